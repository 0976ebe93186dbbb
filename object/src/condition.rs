//! The kinematic condition: what the parts are, how they hang together and where to find them.
//!
//! On disk it is a JSON file a person can write ([`ConditionFile`], `kinfold-condition/1`); in
//! memory it is a [`Condition`], the paper's C, whose tree is proved and whose points are in the
//! object frame. Files of the schema `condition/1` are read as well.

use std::collections::BTreeMap;

use glamx::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::kinematics::{JointKind, KinematicTree, Part, TreeError, is_safe_name};
use crate::mesh::{FileFrame, Mesh, UpAxis};
use crate::origin::Origin;

/// The schema name a condition file of ours carries.
pub const SCHEMA: &str = "kinfold-condition/1";
/// A prompt point may lie this far off the surface, as a share of the mesh's diagonal.
pub const POINT_TOLERANCE: f64 = 0.01;
/// Longest part text, in characters.
pub const MAX_TEXT: usize = 120;

/// What the model is told about an object: the paper's C, plus physical properties where known.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Condition {
    /// What the object is, in a word or two; may be empty.
    pub category: String,
    /// Parts and joint types.
    pub tree: KinematicTree,
    /// For each part, where it is and what it is made of.
    pub prompts: Vec<Prompt>,
    /// True size, where known.
    pub size: Option<TrueSize>,
    /// Who wrote the numbers: a person or a vision-language model.
    pub origin: Origin,
}

/// Where a part is and what it is made of; every field may be unknown.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Prompt {
    /// A point on the part's surface, object frame, the mesh's own unit.
    pub point: Option<DVec3>,
    /// Material in words.
    pub material: Option<String>,
    /// Density of the solid material, kg/m³.
    pub density: Option<f64>,
    /// Mass of the part, kg; wins over density.
    pub mass: Option<f64>,
    /// Coefficient of friction of the surface, 0 to 2.
    pub friction: Option<f64>,
}

/// How large the object is in the world.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrueSize {
    /// Which extent is meant.
    pub of: Extent,
    /// Its length, metres, 0.005 to 20.
    pub metres: f64,
}

impl TrueSize {
    /// The factor that brings `mesh` to this size.
    pub fn scale_for(&self, mesh: &Mesh) -> f64 {
        let size = mesh.bounds().size();
        let extent = match self.of {
            Extent::Largest => size.max_element(),
            Extent::Height => size.z,
            Extent::Width => size.x,
            Extent::Depth => size.y,
        };
        self.metres / extent
    }
}

/// An extent of an object, object frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Extent {
    /// The longest side of its box.
    Largest,
    /// Along z.
    Height,
    /// Along x.
    Width,
    /// Along y.
    Depth,
}

/// Why a condition cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ConditionError {
    /// Not JSON, a missing key, a wrong type, an unknown key.
    #[error("not a condition: {0}")]
    Json(#[from] serde_json::Error),
    /// A schema name nobody here knows.
    #[error("schema `{0}` is unknown, expected `{SCHEMA}` or `condition/1`")]
    Schema(String),
    /// The parts are not a tree.
    #[error(transparent)]
    Tree(#[from] TreeError),
    /// A parent name that no part has.
    #[error("part `{part}` names the parent `{parent}`, which no part is called")]
    UnknownParent {
        /// The child.
        part: String,
        /// The name it gives.
        parent: String,
    },
    /// One part listed twice, with different parents.
    #[error("part `{part}` has two parents, `{first}` and `{second}`")]
    TwoParents {
        /// The part.
        part: String,
        /// The first parent named.
        first: String,
        /// The second.
        second: String,
    },
    /// Empty, too long, or nothing but digits.
    #[error(
        "part `{part}`: a text has 1 to {MAX_TEXT} characters and not only digits, found {found:?}"
    )]
    Text {
        /// The part.
        part: String,
        /// Its text.
        found: String,
    },
    /// Nothing tells two parts apart.
    #[error(
        "parts `{first}` and `{second}` are both \"{text}\" and `{pointless}` has no point: give each a point or a text of its own"
    )]
    Ambiguous {
        /// One part.
        first: String,
        /// The other.
        second: String,
        /// Their text.
        text: String,
        /// The one without a point.
        pointless: String,
    },
    /// A number outside its range.
    #[error("part `{part}`: {what} must be in {range}, found {found}")]
    Number {
        /// The part, or `object`.
        part: String,
        /// Which number.
        what: &'static str,
        /// The allowed range.
        range: &'static str,
        /// What was found.
        found: f64,
    },
    /// A point that is nowhere near the surface.
    #[error(
        "part `{part}`: point ({x}, {y}, {z}) lies {distance:.4} off the mesh, allowed is {allowed:.4} (1 % of its diagonal, same unit)"
    )]
    PointOffMesh {
        /// The part.
        part: String,
        /// x, file frame.
        x: f64,
        /// y, file frame.
        y: f64,
        /// z, file frame.
        z: f64,
        /// Distance to the surface.
        distance: f64,
        /// Tolerance.
        allowed: f64,
    },
}

/// A condition as it stands in a file (`kinfold-condition/1`).
///
/// ```
/// let file: object::ConditionFile = serde_json::from_str(r#"{
///   "schema": "kinfold-condition/1",
///   "category": "kettle",
///   "size": { "height": 0.24 },
///   "parts": [
///     { "name": "body", "material": "steel" },
///     { "name": "lid", "text": "round lid", "parent": "body", "joint": "revolute",
///       "point": [-0.10, 0.47, 0.0] }
///   ]
/// }"#).unwrap();
/// let condition = file.resolve().unwrap();
/// assert_eq!(condition.tree.parent(1), Some(0));
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "kinfold condition", description = "Parts, joints and prompts of one object")]
pub struct ConditionFile {
    /// Address of this JSON Schema, for editors; not read.
    #[serde(rename = "$schema", default, skip_serializing_if = "Option::is_none")]
    pub json_schema: Option<String>,
    /// Always `kinfold-condition/1`.
    pub schema: String,
    /// What the object is, in a word or two.
    #[serde(default)]
    pub category: String,
    /// Up axis of the mesh file, and so of the points below: `y` for GLB (default), `z`.
    #[serde(default)]
    pub up: UpAxis,
    /// True size in metres, one of `largest`, `height`, `width`, `depth`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<BTreeMap<Extent, f64>>")]
    pub size: Option<FileSize>,
    /// Free text, kept but not used.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub notes: String,
    /// The parts; the one without a parent is the base.
    pub parts: Vec<FilePart>,
}

/// A true size as written in a file: `{ "height": 0.24 }`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FileSize {
    /// The longest side, metres.
    Largest(f64),
    /// Along the up axis, metres.
    Height(f64),
    /// Along x, metres.
    Width(f64),
    /// Front to back, metres.
    Depth(f64),
}

/// One part of a condition file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FilePart {
    /// Identifier, unique, `[A-Za-z_][A-Za-z0-9_]*`: the URDF link's name.
    pub name: String,
    /// What the part is, in words; the name with spaces if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub text: Option<String>,
    /// Name of the part it hangs on; none for the base.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parent: Option<String>,
    /// How it moves: one kind, a list of two, or nothing (fixed).
    #[serde(default, skip_serializing_if = "FileJoints::is_fixed")]
    pub joint: FileJoints,
    /// A point on its surface, in the mesh file's own coordinates and unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub point: Option<[f64; 3]>,
    /// Material in words, like `oak` or `stainless steel`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// Density of the solid material, kg/m³, 1 to 25,000.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub density: Option<f64>,
    /// Mass, kg; wins over density.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass: Option<f64>,
    /// Coefficient of surface friction, 0 to 2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<f64>,
}

/// Joints of a part as written: `"revolute"`, `["prismatic", "continuous"]`, or left out.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum FileJoints {
    /// One degree of freedom.
    One(JointKind),
    /// None or two, the first nearest the parent.
    #[serde(skip)]
    #[default]
    Fixed,
    /// A list; empty means fixed.
    Many(Vec<JointKind>),
}

impl FileJoints {
    /// The shortest way to write some joints.
    pub fn from_kinds(kinds: Vec<JointKind>) -> Self {
        match kinds[..] {
            [] => Self::Fixed,
            [one] => Self::One(one),
            _ => Self::Many(kinds),
        }
    }

    fn is_fixed(&self) -> bool {
        self.kinds().is_empty()
    }

    fn kinds(&self) -> Vec<JointKind> {
        match self {
            Self::Fixed => vec![],
            Self::One(kind) => vec![*kind],
            Self::Many(kinds) => kinds.clone(),
        }
    }
}

impl Condition {
    /// Reads a condition file of either schema, `kinfold-condition/1` or `condition/1`.
    ///
    /// # Errors
    /// [`ConditionError`], naming the part, the rule and what was found.
    pub fn from_json(text: &str) -> Result<Self, ConditionError> {
        let probe: serde_json::Value = serde_json::from_str(text)?;
        let schema = probe.get("schema").and_then(|s| s.as_str()).unwrap_or(SCHEMA);
        match schema {
            SCHEMA => serde_json::from_str::<ConditionFile>(text)?.resolve(),
            "condition/1" => serde_json::from_str::<foreign::File>(text)?.translate().resolve(),
            other => Err(ConditionError::Schema(other.into())),
        }
    }

    /// The part a text prompt and point describe, as the paper's (t, x).
    pub fn text(&self, part: usize) -> &str {
        &self.tree.parts()[part].text
    }

    /// Checks that every prompt point lies on the mesh, within [`POINT_TOLERANCE`].
    ///
    /// # Errors
    /// [`ConditionError::PointOffMesh`] for the first that does not.
    pub fn check_points(&self, mesh: &Mesh) -> Result<(), ConditionError> {
        let allowed = POINT_TOLERANCE * mesh.bounds().diagonal();
        for (part, prompt) in self.tree.parts().iter().zip(&self.prompts) {
            let Some(p) = prompt.point else { continue };
            let distance = crate::weld::nearest_face(mesh, p).1;
            if distance > allowed {
                let DVec3 { x, y, z } = mesh.frame().point_to_file(p);
                let part = part.name.clone();
                return Err(ConditionError::PointOffMesh { part, x, y, z, distance, allowed });
            }
        }
        Ok(())
    }

    /// The JSON Schema of a condition file, for editors.
    pub fn json_schema() -> serde_json::Value {
        schemars::schema_for!(ConditionFile).to_value()
    }
}

impl ConditionFile {
    /// Proves the tree, turns points into the object frame and checks every number.
    ///
    /// # Errors
    /// [`ConditionError`], naming the part, the rule and what was found.
    pub fn resolve(&self) -> Result<Condition, ConditionError> {
        if self.schema != SCHEMA {
            return Err(ConditionError::Schema(self.schema.clone()));
        }
        self.check_single_parents()?;
        let parts = self.parts.iter().map(|p| self.part(p)).collect::<Result<Vec<_>, _>>()?;
        let frame = FileFrame { up: self.up };
        let prompts = self.parts.iter().map(|p| p.prompt(frame)).collect::<Result<_, _>>()?;
        let condition = Condition {
            category: self.category.clone(),
            tree: KinematicTree::new(parts)?,
            prompts,
            size: self.size.map(FileSize::resolve).transpose()?,
            origin: Origin::User,
        };
        check_distinct(&condition)?;
        Ok(condition)
    }

    fn check_single_parents(&self) -> Result<(), ConditionError> {
        let mut parent_of = BTreeMap::new();
        for p in &self.parts {
            let Some(before) = parent_of.insert(&p.name, &p.parent) else { continue };
            if let (Some(first), Some(second)) = (before, &p.parent)
                && first != second
            {
                let (first, second) = (first.clone(), second.clone());
                return Err(ConditionError::TwoParents { part: p.name.clone(), first, second });
            }
        }
        Ok(())
    }

    fn part(&self, p: &FilePart) -> Result<Part, ConditionError> {
        let index = |parent: &String| {
            let unknown =
                || ConditionError::UnknownParent { part: p.name.clone(), parent: parent.clone() };
            self.parts.iter().position(|q| q.name == *parent).ok_or_else(unknown)
        };
        let text = p.text.clone().unwrap_or_else(|| p.name.replace('_', " "));
        let digits = text.chars().all(|c| c.is_ascii_digit() || c.is_whitespace());
        if digits || text.chars().count() > MAX_TEXT {
            return Err(ConditionError::Text { part: p.name.clone(), found: text });
        }
        let parent = p.parent.as_ref().map(index).transpose()?;
        Ok(Part { name: p.name.clone(), text, parent, joints: p.joint.kinds() })
    }
}

impl FilePart {
    fn prompt(&self, frame: FileFrame) -> Result<Prompt, ConditionError> {
        let within = |what, range: &'static str, (low, high), value: Option<f64>| match value {
            Some(v) if !(v >= low && v <= high) => {
                let part = self.name.clone();
                Err(ConditionError::Number { part, what, range, found: v })
            }
            v => Ok(v),
        };
        if let Some(&bad) = self.point.iter().flatten().find(|c| !c.is_finite()) {
            within("point", "finite numbers", (0.0, 0.0), Some(bad))?;
        }
        Ok(Prompt {
            point: self.point.map(|p| frame.point_to_object(DVec3::from_array(p))),
            material: self.material.clone(),
            density: within("density", "1 to 25,000 kg/m³", (1.0, 25e3), self.density)?,
            mass: within("mass", "1e-6 to 1e5 kg", (1e-6, 1e5), self.mass)?,
            friction: within("friction", "0 to 2", (0.0, 2.0), self.friction)?,
        })
    }
}

impl FileSize {
    fn resolve(self) -> Result<TrueSize, ConditionError> {
        let (of, metres) = match self {
            Self::Largest(m) => (Extent::Largest, m),
            Self::Height(m) => (Extent::Height, m),
            Self::Width(m) => (Extent::Width, m),
            Self::Depth(m) => (Extent::Depth, m),
        };
        if (0.005..=20.0).contains(&metres) {
            return Ok(TrueSize { of, metres });
        }
        let (part, what, range) = ("object".into(), "size", "0.005 to 20 m");
        Err(ConditionError::Number { part, what, range, found: metres })
    }
}

/// Two parts of one text need a point each: otherwise nothing tells them apart.
fn check_distinct(c: &Condition) -> Result<(), ConditionError> {
    let parts = c.tree.parts();
    for (second, b) in parts.iter().enumerate() {
        let same = |a: &Part| a.text.trim().eq_ignore_ascii_case(b.text.trim());
        let Some(first) = parts[..second].iter().position(same) else { continue };
        if let Some(&pointless) = [first, second].iter().find(|&&p| c.prompts[p].point.is_none()) {
            return Err(ConditionError::Ambiguous {
                first: parts[first].name.clone(),
                second: b.name.clone(),
                text: b.text.clone(),
                pointless: parts[pointless].name.clone(),
            });
        }
    }
    Ok(())
}

/// Identifier made of a text: lower case, everything else an underscore, unique by a suffix.
pub fn name_from_text(text: &str, taken: &[String]) -> String {
    let mut name = String::new();
    for c in text.trim().chars().map(|c| c.to_ascii_lowercase()) {
        let plain = if c.is_ascii_alphanumeric() { c } else { '_' };
        if plain != '_' || !name.ends_with('_') {
            name.push(plain);
        }
    }
    let mut name = name.trim_matches('_').to_string();
    if !is_safe_name(&name) {
        name.insert_str(0, "part_");
    }
    let name = name.trim_end_matches('_').to_string();
    let numbered = (2..).map(|n| format!("{name}_{n}"));
    let mut candidates = std::iter::once(name.clone()).chain(numbered);
    candidates.find(|n| !taken.contains(n)).unwrap_or(name)
}

/// The schema `condition/1`: parts by number, points in glTF coordinates.
mod foreign {
    use super::{FileJoints, FilePart, FileSize, JointKind, SCHEMA, UpAxis, name_from_text};
    use serde::Deserialize;

    #[derive(Deserialize)]
    pub(super) struct File {
        #[serde(default)]
        category: String,
        real_size_m: Option<Size>,
        #[serde(default)]
        notes: String,
        parts: Vec<Part>,
    }

    #[derive(Deserialize)]
    struct Size {
        largest_extent: f64,
    }

    #[derive(Deserialize)]
    struct Part {
        id: u64,
        text: String,
        parent: Option<u64>,
        #[serde(default)]
        joints: Vec<JointKind>,
        point: Option<[f64; 3]>,
        material: Option<String>,
        density_kg_m3: Option<f64>,
        friction: Option<f64>,
    }

    impl File {
        pub(super) fn translate(self) -> super::ConditionFile {
            let mut names: Vec<String> = Vec::new();
            for part in &self.parts {
                names.push(name_from_text(&part.text, &names));
            }
            let name_of = |id| self.parts.iter().position(|p| p.id == id).map(|i| names[i].clone());
            let part = |(i, p): (usize, &Part)| FilePart {
                name: names[i].clone(),
                text: Some(p.text.clone()),
                parent: p.parent.map(|id| name_of(id).unwrap_or_else(|| format!("id {id}"))),
                joint: FileJoints::Many(p.joints.clone()),
                point: p.point,
                material: p.material.clone(),
                density: p.density_kg_m3,
                mass: None,
                friction: p.friction,
            };
            let parts = self.parts.iter().enumerate().map(part).collect();
            super::ConditionFile {
                json_schema: None,
                schema: SCHEMA.into(),
                category: self.category,
                up: UpAxis::Y,
                size: self.real_size_m.map(|s| FileSize::Largest(s.largest_extent)),
                notes: self.notes,
                parts,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(parts: &str) -> Result<Condition, ConditionError> {
        Condition::from_json(&format!(r#"{{"schema": "kinfold-condition/1", "parts": [{parts}]}}"#))
    }

    #[test]
    fn names_stand_in_for_texts_and_joints_may_be_one_or_two() {
        let c = read(
            r#"{"name": "bottle_neck"},
               {"name": "cap", "parent": "bottle_neck", "joint": ["prismatic", "continuous"]}"#,
        )
        .unwrap();
        assert_eq!(c.text(0), "bottle neck");
        assert_eq!(c.tree.parts()[1].joints, [JointKind::Prismatic, JointKind::Continuous]);
    }

    #[test]
    fn every_broken_rule_is_named_with_its_part() {
        let rule = |parts: &str| read(parts).unwrap_err().to_string();
        assert!(rule(r#"{"name": "a"}, {"name": "b", "parent": "x"}"#).contains("parent `x`"));
        let two = r#"{"name": "a"}, {"name": "b"}, {"name": "c", "parent": "a"}, {"name": "c", "parent": "b"}"#;
        assert_eq!(rule(two), "part `c` has two parents, `a` and `b`");
        let cycle = r#"{"name": "a"}, {"name": "b", "parent": "c"}, {"name": "c", "parent": "b"}"#;
        assert!(rule(cycle).contains("cycle"));
        let twins = r#"{"name": "a"}, {"name": "b", "text": "door", "parent": "a"},
            {"name": "c", "text": "Door", "parent": "a", "point": [0, 0, 0]}"#;
        assert!(rule(twins).contains("`b` has no point"));
        assert!(rule(r#"{"name": "a", "density": -1}"#).contains("density must be in 1 to 25,000"));
        assert!(rule(r#"{"name": "a", "colour": 1}"#).contains("unknown field `colour`"));
    }

    #[test]
    fn the_foreign_schema_is_read_with_points_turned_upright() {
        let c = Condition::from_json(
            r#"{"schema": "condition/1", "id": "x", "category": "bin", "source": "hand",
                "real_size_m": {"largest_extent": 0.65, "evidence": "measured"},
                "parts": [
                  {"id": 0, "text": "bin body", "parent": null, "joints": [], "point": [0, 1, 0]},
                  {"id": 1, "text": "2nd lid!", "parent": 0, "joints": ["revolute"], "point": [1, 2, 3]}]}"#,
        )
        .unwrap();
        assert_eq!(c.tree.parts()[1].name, "part_2nd_lid");
        assert_eq!(c.prompts[1].point, Some(DVec3::new(1.0, -3.0, 2.0)));
        assert_eq!(c.size, Some(TrueSize { of: Extent::Largest, metres: 0.65 }));
    }

    #[test]
    fn a_point_off_the_mesh_is_refused_with_its_distance() {
        let v = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
        let mesh = Mesh::new(v, vec![[0, 1, 2]]).unwrap();
        let at = |y: f64| read(&format!(r#"{{"name": "a", "point": [0.2, {y}, -0.2]}}"#)).unwrap();
        assert!(at(0.001).check_points(&mesh).is_ok());
        let e = at(0.5).check_points(&mesh).unwrap_err().to_string();
        assert!(e.contains("(0.2, 0.5, -0.2) lies 0.5000 off the mesh"), "{e}");
    }
}
