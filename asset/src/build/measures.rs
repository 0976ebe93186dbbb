//! What of a condition the shapes of an asset's parts follow from, and nothing else of it.

use object::condition::{GivenJoint, TrueSize};
use object::{Condition, KinematicTree};
use serde::{Deserialize, Serialize};

use crate::error::AssetError;
use crate::mass::materials::{Wall, named, otherwise, usual};
use crate::surface::caps::moving;

/// What of a condition the shapes of an asset's parts follow from: its size, what is given of axes,
/// pivots and ranges, and how thick the walls of its materials are. Two conditions of the same
/// measures give an articulated object the same [`crate::Shapes`].
///
/// ```
/// use asset::Measures;
/// use object::Condition;
/// let of = |body: &str| -> Result<_, Box<dyn std::error::Error>> {
///     let parts = format!(r#"[{{"name": "body", {body}}}]"#);
///     Ok(Measures::of(&Condition::from_json(&format!(r#"{{"parts": {parts}}}"#))?))
/// };
/// assert_eq!(of(r#""mass": 3"#)?, of(r#""mass": 4"#)?);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measures {
    /// True size, where known.
    pub(crate) size: Option<TrueSize>,
    /// The wall of parts of which nothing tells another.
    otherwise: Wall,
    /// For each part of the condition.
    parts: Vec<PartMeasures>,
}

/// What of a condition the shape of one part follows from.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct PartMeasures {
    /// The wall of what it is said to be made of; none where its own name tells it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    wall: Option<Wall>,
    /// What is given of its joints but their drives.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) joints: Vec<GivenJoint>,
}

impl Measures {
    /// Those of a condition, for an object whose parts bear the condition's names, as those that were
    /// articulated by it do. Walls of parts that do not move are left out, for nothing is closed there.
    pub fn of(condition: &Condition) -> Self {
        let mut measures = Self::in_full(condition);
        let moves = moving(&condition.tree);
        for (p, part) in condition.tree.parts().iter().enumerate() {
            let by_name = measures.wall_by_name(&part.text);
            let needed = |wall: &Wall| moves[p] && *wall != by_name;
            measures.parts[p].wall = measures.parts[p].wall.filter(needed);
        }
        measures
    }

    /// Those of a condition, for an object whatever its parts are called.
    pub(crate) fn in_full(condition: &Condition) -> Self {
        let told = condition.of_shape().prompts.into_iter().zip(&condition.prompts);
        let parts = told.map(|(shape, prompt)| PartMeasures {
            wall: prompt.material.as_deref().and_then(named).map(|row| row.wall),
            joints: shape.joints,
        });
        let otherwise = otherwise(&condition.category).wall;
        Self { size: condition.size, otherwise, parts: parts.collect() }
    }

    /// For each part of an object its measures; none of a part that no part of the condition became.
    ///
    /// # Errors
    /// [`AssetError::PartMap`] and [`AssetError::UnknownPart`] where the map does not fit.
    pub(crate) fn of_parts(
        &self,
        part_of_condition: &[Option<usize>],
        tree: &KinematicTree,
    ) -> Result<Vec<PartMeasures>, AssetError> {
        let (parts, found) = (self.parts.len(), part_of_condition.len());
        if parts != found {
            return Err(AssetError::PartMap { parts, found });
        }
        let mut all = vec![PartMeasures::default(); tree.len()];
        for (number, (measures, index)) in self.parts.iter().zip(part_of_condition).enumerate() {
            let Some(index) = *index else { continue };
            let (part, parts) = (format!("number {number}"), all.len());
            let unknown = || AssetError::UnknownPart { part, index, parts };
            all.get_mut(index).ok_or_else(unknown)?.clone_from(measures);
        }
        Ok(all)
    }

    /// The wall of a part of the object called `text`.
    pub(crate) fn wall(&self, part: &PartMeasures, text: &str) -> Wall {
        part.wall.unwrap_or_else(|| self.wall_by_name(text))
    }

    fn wall_by_name(&self, text: &str) -> Wall {
        usual(text).map_or(self.otherwise, |row| row.wall)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Measures of a cupboard whose body and door are described so.
    fn measures(size: &str, body: &str, door: &str) -> Measures {
        let text = format!(
            r#"{{"category": "cupboard"{size}, "parts": [{{"name": "body"{body}}},
                {{"name": "door", "parent": "body", "joint": "revolute"{door}}}]}}"#
        );
        Measures::of(&Condition::from_json(&text).unwrap())
    }

    #[test]
    fn masses_frictions_and_drives_are_no_measures() {
        let plain = measures("", "", "");
        for said in [r#", "mass": 3"#, r#", "density": 900"#, r#", "friction": 0.3"#] {
            assert_eq!(measures("", said, said), plain, "{said}");
        }
        assert_eq!(measures("", "", r#", "effort": 3, "damping": 0.1"#), plain);
    }

    #[test]
    fn a_material_counts_where_a_part_moves_and_its_wall_is_another() {
        let plain = measures("", "", "");
        assert_eq!(measures("", r#", "material": "steel""#, ""), plain, "the body stands still");
        assert_eq!(measures("", "", r#", "material": "plywood""#), plain, "as cupboards are");
        let steel = measures("", "", r#", "material": "steel""#);
        assert_ne!(steel, plain);
        assert_eq!(measures("", "", r#", "material": "cast iron""#), steel, "walls alike");
    }

    #[test]
    fn a_size_and_what_is_given_of_a_joint_are() {
        let plain = measures("", "", "");
        assert_ne!(measures(r#", "size": {"height": 1}"#, "", ""), plain);
        assert_ne!(measures("", "", r#", "range": [0, 1]"#), plain);
        assert_ne!(measures("", "", r#", "rest": "80°""#), plain);
        assert_ne!(measures("", "", r#", "pivot": [0, 0, 1]"#), plain);
    }

    #[test]
    fn measures_read_back_as_they_were() {
        let all = measures(
            r#", "size": {"height": 0.1}"#,
            "",
            r#", "axis": [0.1, 0.2, 1], "material": "oak""#,
        );
        let text = serde_json::to_string(&all).unwrap();
        assert_eq!(serde_json::from_str::<Measures>(&text).unwrap(), all, "{text}");
    }
}
