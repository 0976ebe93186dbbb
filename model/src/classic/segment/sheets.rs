//! What is known of an object before labels spread, as tables: `contacts.pack` and `roles.pack`
//! are fitted to these.

use object::weld::Weld;
use object::{Condition, Mesh};

use crate::classic::lexicon::sizes::SizePrior;
use crate::classic::segment::grow::evidence;
use crate::classic::segment::grow::evidence::Features;
use crate::classic::segment::oversegment::contact;
use crate::classic::segment::oversegment::patches::Cutting;
use crate::classic::segment::oversegment::segments;
use crate::classic::segment::oversegment::units::Units;
use crate::classic::segment::prompts::candidates::Candidates;
use crate::classic::segment::prompts::placed::{MOST, like, traits};
use crate::classic::segment::prompts::roles::WEIGHTS;
use crate::classic::segment::prompts::shape::shape;
use crate::classic::segment::skin::Skin;

/// The components of a surface and how they meet.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactSheet {
    /// The component of each face.
    pub component_of_face: Vec<u32>,
    /// Components that touch or nearly touch, each two once.
    pub contacts: Vec<Contact>,
}

/// Two components that touch or nearly touch.
#[derive(Clone, Debug, PartialEq)]
pub struct Contact {
    /// Which two.
    pub components: [u32; 2],
    /// The features of their contact, in the order of [`evidence::NAMES`].
    pub features: Features,
}

/// The contacts of an object.
pub fn contact_sheet(mesh: &Mesh, weld: &Weld) -> ContactSheet {
    let skin = Skin::of(mesh, weld);
    // Without prompts every component is one segment.
    let cut = segments::cut(&skin, (&[], 0), Cutting::USUAL);
    let diagonal = skin.diagonal;
    let touches = contact::touches((&skin.bodies, skin.near()), &cut.of_face, diagonal);
    let all = evidence::contacts(&touches, &cut.segments, diagonal).into_iter();
    let contacts = all.map(|(components, features)| Contact { components, features }).collect();
    ContactSheet { component_of_face: cut.of_face, contacts }
}

/// What parts without a point are chosen from.
#[derive(Clone, Debug, PartialEq)]
pub struct RoleSheet {
    /// The unit of each face: a component, or a patch of a fused mesh.
    pub unit_of_face: Vec<u32>,
    /// The units of each candidate.
    pub candidates: Vec<Vec<u32>>,
    /// For each part, what is known of it and the candidates.
    pub parts: Vec<RolePart>,
}

/// A part that is to be chosen.
#[derive(Clone, Debug, PartialEq)]
pub struct RolePart {
    /// The rows of weights that count for it, as places in [`crate::classic::segment::prompts::roles::rows`].
    pub rows: Vec<usize>,
    /// The parts with the same words and the same parent, itself among them; of the base itself alone.
    pub like: Vec<usize>,
    /// For each candidate its features, in the order of [`crate::classic::segment::prompts::roles::names`]; nothing of one that by
    /// the part's words is too large for it.
    pub features: Vec<Option<[f64; WEIGHTS]>>,
}

/// The candidates for the parts of an object, whose prompts do not count; nothing where there are more
/// candidates than `most`.
pub fn role_sheet(
    mesh: &Mesh,
    weld: &Weld,
    condition: &Condition,
    most: usize,
) -> Option<RoleSheet> {
    let (component, bodies) = contact::bodies(mesh, weld);
    let units = Units::of(mesh, weld, &component, &bodies);
    if units.list.len() > most {
        return None;
    }
    let candidates = Candidates::of(&units);
    let count = candidates.list.len();
    if count > most {
        return None;
    }
    let shape = shape(&candidates, &units);
    let total: f64 = units.list.iter().map(|u| u.mass.area).sum();
    let share = |c: usize| candidates.list[c].mass.area / total.max(f64::MIN_POSITIVE);
    let part = |part: usize| {
        let (traits, is_base) = (traits(condition, part), part == condition.tree.root());
        let prior = SizePrior::of(condition.text(part), is_base);
        let may = |c: usize| prior.allows(share(c)) && (share(c) <= MOST || is_base);
        let like = if is_base { vec![part] } else { like(condition, part) };
        let features = (0..count).map(|c| may(c).then(|| traits.features(&shape[c]))).collect();
        RolePart { rows: traits.rows(), like, features }
    };
    let parts = (0..condition.tree.len()).map(part).collect();
    let candidates = (0..count).map(|c| candidates.units(c).to_vec()).collect();
    Some(RoleSheet { unit_of_face: units.of_face, candidates, parts })
}

#[cfg(test)]
mod tests {
    use object::DVec3;

    use super::*;
    use crate::classic::segment::grow::evidence::NAMES;

    /// Two boxes on a larger one, and a third that hangs free.
    fn desk() -> Mesh {
        let mut corners = Vec::new();
        let mut put = |min: [f64; 3], max: [f64; 3]| {
            let c = |i: usize| {
                let pick = |a: usize| if i >> a & 1 == 1 { max[a] } else { min[a] };
                DVec3::new(pick(0), pick(1), pick(2))
            };
            let quads = [
                [0, 2, 3, 1],
                [4, 5, 7, 6],
                [0, 1, 5, 4],
                [2, 6, 7, 3],
                [0, 4, 6, 2],
                [1, 3, 7, 5],
            ];
            for [a, b, d, e] in quads {
                corners.extend([[c(a), c(b), c(d)], [c(a), c(d), c(e)]]);
            }
        };
        put([0.0; 3], [1.0, 1.0, 0.5]);
        put([0.1, 0.1, 0.5], [0.3, 0.3, 0.7]);
        put([0.6, 0.6, 0.4], [0.8, 0.8, 0.6]);
        put([3.0; 3], [3.6; 3]);
        Mesh::of_triangles(&corners).unwrap()
    }

    #[test]
    fn what_touches_and_what_reaches_in_is_on_the_sheet_and_what_hangs_free_is_not() {
        let mesh = desk();
        let sheet = contact_sheet(&mesh, &Weld::new(&mesh));
        assert_eq!(
            sheet.component_of_face.chunks(12).map(|b| b[0]).collect::<Vec<_>>(),
            [0, 1, 2, 3]
        );
        let of = |pair: [u32; 2]| sheet.contacts.iter().find(|c| c.components == pair);
        let (on, into) = (of([0, 1]).unwrap(), of([0, 2]).unwrap());
        assert_eq!(sheet.contacts.len(), 2, "{:?}", sheet.contacts);
        let at = |name: &str| NAMES.iter().position(|n| *n == name).unwrap();
        assert_eq!((on.features[at("constant")], into.features[at("constant")]), (1.0, 1.0));
        assert_eq!(into.features[at("meets")], 1.0);
        assert!((into.features[at("swallowed")] - 0.5).abs() < 0.1, "{:?}", into.features);
        assert!(on.features[at("gap")] < 0.05, "{:?}", on.features);
    }

    #[test]
    fn every_part_has_its_rows_its_like_and_the_candidates_that_its_words_allow() {
        let text = r#"{"schema": "kinfold-condition/1", "up": "z", "parts": [{"name": "body"},
            {"name": "a", "text": "left button", "parent": "body", "joint": "prismatic"},
            {"name": "b", "text": "right button", "parent": "body", "joint": "prismatic"}]}"#;
        let (mesh, condition) = (desk(), Condition::from_json(text).unwrap());
        let weld = Weld::new(&mesh);
        let sheet = role_sheet(&mesh, &weld, &condition, 100).unwrap();
        assert_eq!(
            sheet.parts.iter().map(|p| &p.like[..]).collect::<Vec<_>>(),
            [&[0][..], &[1, 2], &[1, 2]]
        );
        let rows = crate::classic::segment::prompts::roles::rows();
        let names: Vec<&str> = sheet.parts[1].rows.iter().map(|&r| rows[r]).collect();
        assert_eq!(names, ["any", "role_button", "joint_slide", "several_alike"]);
        let single = |unit: u32| sheet.candidates.iter().position(|c| c[..] == [unit]).unwrap();
        assert!(sheet.parts[1].features[single(0)].is_none(), "no button is most of the object");
        assert!(sheet.parts[1].features[single(1)].is_some());
        assert!(sheet.parts[0].features.iter().all(Option::is_some));
        assert!(role_sheet(&mesh, &weld, &condition, 3).is_none(), "too many candidates");
    }
}
