//! Places parts without a point by their words, the tree and the shape.
//!
//! What could be a part (`Candidates`) is weighed by a table of what parts of that role look like;
//! like-worded parts get copies, children lie beside their parents (`Puzzle`); words such as left
//! and upper tell like-worded parts apart ([`crate::classic::lexicon::places`]).

use object::{Condition, DVec3, JointKind};

use crate::articulate::Note;
use crate::classic::lexicon::places::Place;
use crate::classic::lexicon::sizes::{SizePrior, family};
use crate::classic::lexicon::words::{ROLES, meaning};
use crate::classic::segment::oversegment::units::Units;
use crate::classic::segment::prompts::assign::{Choice, Puzzle};
use crate::classic::segment::prompts::candidates::Candidates;
use crate::classic::segment::prompts::roles::PartTraits;
use crate::classic::segment::prompts::seeds::Seed;
use crate::classic::segment::prompts::shape::{Shape, shape};

/// How much it counts that a part is where its words say in the object's box.
const PLACE: f64 = 2.5;
/// A part that moves has no more of the surface than this.
pub(crate) const MOST: f64 = 0.9;

/// Adds seeds on everything that is taken for a part without one, and for each such part a note in
/// place of the one that says it is unknown.
///
/// A base without a point is placed along with them, as what the others are not. Nothing is said of
/// a part without words, so it stays unknown.
/// `placeable` gives the units of the surface and what is made of them.
pub(crate) fn add<'a>(
    placeable: impl FnOnce() -> &'a (Units, Candidates),
    condition: &Condition,
    (seeds, notes): (&mut Vec<Seed>, &mut Vec<Note>),
) {
    let open = open(condition, seeds);
    if open.is_empty() {
        return;
    }
    let (units, candidates) = placeable();
    let choice = choose(condition, (units, candidates), (&open, seeds));
    let root = condition.tree.root();
    for part in open {
        let Some(candidate) = choice[part] else { continue };
        let on = candidates.units(candidate).iter().map(|&u| units.list[u as usize].face);
        seeds.extend(on.map(|face| Seed { face, part: part as u16 }));
        if part == root {
            continue;
        }
        let note = note(condition, part);
        notes.retain(|n| n.part != note.part);
        notes.push(note);
    }
}

/// Parts with words but without a point or a seed, and the base if it has neither; nothing if only
/// the base is left.
pub(crate) fn open(condition: &Condition, seeds: &[Seed]) -> Vec<usize> {
    let root = condition.tree.root();
    let is_open = |&p: &usize| {
        (p == root || !condition.text(p).trim().is_empty())
            && condition.prompts.get(p).is_none_or(|prompt| prompt.point.is_none())
            && seeds.iter().all(|s| usize::from(s.part) != p)
    };
    let open: Vec<usize> = (0..condition.tree.len()).filter(is_open).collect();
    if open == [root] { vec![] } else { open }
}

/// The candidate of each part.
pub(crate) fn choose(
    condition: &Condition,
    (units, candidates): (&Units, &Candidates),
    (open, seeds): (&[usize], &[Seed]),
) -> Choice {
    let mut known: Choice = vec![None; condition.tree.len()];
    for s in seeds {
        known[usize::from(s.part)] = Some(units.of_face[s.face as usize] as usize);
    }
    puzzle(condition, (units, candidates), (open, seeds)).solve(&known)
}

/// The parts to place and what is known of them.
pub(crate) fn puzzle<'a>(
    condition: &Condition,
    (units, candidates): (&Units, &'a Candidates),
    (open, seeds): (&[usize], &[Seed]),
) -> Puzzle<'a> {
    let barred: Vec<u32> = seeds.iter().map(|s| units.of_face[s.face as usize]).collect();
    Puzzle {
        fits: fits(condition, candidates, units, (open, &barred)),
        parents: (0..condition.tree.len()).map(|p| condition.tree.parent(p)).collect(),
        families: families(condition, open),
        places: (0..condition.tree.len()).map(|p| Place::of(condition.text(p))).collect(),
        around: around(units, candidates),
        candidates,
    }
}

fn note(condition: &Condition, part: usize) -> Note {
    let words = condition.text(part);
    let message = format!("has no point and was placed by its words \"{words}\" and the shape");
    Note { part: condition.tree.parts()[part].name.clone(), message, loss: false }
}

/// For each part, how well it fits each candidate; nothing fits parts that are not open.
fn fits(
    condition: &Condition,
    candidates: &Candidates,
    units: &Units,
    (open, barred): (&[usize], &[u32]),
) -> Vec<Vec<f64>> {
    let shape = shape(candidates, units);
    let total: f64 = units.list.iter().map(|u| u.mass.area).sum();
    let shut = |c: usize| candidates.units(c).iter().any(|u| barred.contains(u));
    let shut: Vec<bool> = (0..candidates.list.len()).map(shut).collect();
    let (centre, half) = (units.bounds.centre(), units.bounds.size() / 2.0);
    let mut fits = vec![vec![]; condition.tree.len()];
    for &part in open {
        let traits = traits(condition, part);
        let towards = Place::of(condition.text(part)).towards;
        let is_base = part == condition.tree.root();
        let prior = SizePrior::of(condition.text(part), is_base);
        let fit = |(c, shape): (usize, &Shape)| {
            let mass = &candidates.list[c].mass;
            let share = mass.area / total.max(f64::MIN_POSITIVE);
            if shut[c] || !prior.allows(share) || (share > MOST && !is_base) {
                return f64::NEG_INFINITY;
            }
            let off = (mass.bounds.centre() - centre) / half.max(DVec3::splat(f64::MIN_POSITIVE));
            traits.fit(shape) + PLACE * towards.dot(off)
        };
        fits[part] = shape.iter().enumerate().map(fit).collect();
    }
    fits
}

/// What is known of a part beside its place.
pub(crate) fn traits(condition: &Condition, part: usize) -> PartTraits {
    let tree = &condition.tree;
    let role = meaning(condition.text(part), &condition.category).role;
    let joints = &tree.parts()[part].joints;
    PartTraits {
        role: ROLES.iter().position(|r| *r == role).unwrap_or(0),
        joint: if joints.contains(&JointKind::Continuous) {
            2
        } else if joints.contains(&JointKind::Prismatic) {
            1
        } else if joints.is_empty() {
            3
        } else {
            0
        },
        like: like(condition, part).len().max(1),
        carries: (0..tree.len()).any(|q| tree.parent(q) == Some(part)),
        hangs_on_base: tree.parent(part) == Some(tree.root()),
        is_base: part == tree.root(),
    }
}

/// The parts with the same words and the same parent as a part; the base is none of them.
pub(crate) fn like(condition: &Condition, part: usize) -> Vec<usize> {
    let tree = &condition.tree;
    let words = family(condition.text(part));
    let is_like = |&q: &usize| {
        q != tree.root()
            && tree.parent(q) == tree.parent(part)
            && family(condition.text(q)) == words
    };
    (0..tree.len()).filter(is_like).collect()
}

/// Like-worded parts together, in order of the first.
fn families(condition: &Condition, open: &[usize]) -> Vec<Vec<usize>> {
    let mut families: Vec<(String, Vec<usize>)> = Vec::new();
    for &part in open {
        let words = family(condition.text(part));
        match families.iter_mut().find(|(w, _)| *w == words) {
            Some((_, parts)) => parts.push(part),
            None => families.push((words, vec![part])),
        }
    }
    families.into_iter().map(|(_, parts)| parts).collect()
}

/// For each unit in the order of the candidates, where the units stand that it touches.
fn around(units: &Units, candidates: &Candidates) -> Vec<Vec<u32>> {
    let mut at = vec![0; units.list.len()];
    for (unit, place) in at.iter_mut().enumerate() {
        *place = candidates.list[unit].span().start as u32;
    }
    let mut around = vec![vec![]; units.list.len()];
    for &(a, b) in units.touching.keys() {
        let [a, b] = [at[a as usize], at[b as usize]];
        around[a as usize].push(b);
        around[b as usize].push(a);
    }
    around
}

#[cfg(test)]
mod tests {
    use object::Mesh;
    use object::weld::Weld;

    use super::*;
    use crate::classic::segment::{Way, label_faces};

    fn boxes(list: &[([f64; 3], [f64; 3])]) -> Mesh {
        let quads =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let (mut vertices, mut faces) = (Vec::new(), Vec::<[u32; 3]>::new());
        for (min, max) in list {
            let base = vertices.len() as u32;
            let pick =
                |i: usize, axis: usize| if i >> axis & 1 == 1 { max[axis] } else { min[axis] };
            vertices.extend((0..8).map(|i| DVec3::new(pick(i, 0), pick(i, 1), pick(i, 2))));
            faces.extend(quads.iter().flat_map(|&[a, b, c, d]| {
                [[a, b, c], [a, c, d]].map(|f| f.map(|i: u32| i + base))
            }));
        }
        Mesh::new(vertices, faces).unwrap()
    }

    /// A table's board, four legs, and two boxes that hang under it.
    fn desk() -> Mesh {
        let leg = |x: f64, y: f64| ([x, y, 0.0], [x + 0.05, y + 0.05, 0.7]);
        let drawer = |x: f64| ([x, -0.34, 0.55], [x + 0.35, 0.25, 0.697]);
        boxes(&[
            ([-0.7, -0.35, 0.7], [0.7, 0.35, 0.73]),
            leg(-0.69, -0.34),
            leg(0.64, -0.34),
            leg(-0.69, 0.29),
            leg(0.64, 0.29),
            drawer(0.24),
            drawer(-0.59),
        ])
    }

    fn asked(parts: &str) -> Condition {
        let text = format!(r#"{{"schema": "kinfold-condition/1", "up": "z", "parts": [{parts}]}}"#);
        Condition::from_json(&text).unwrap()
    }

    fn labelled(mesh: &Mesh, condition: &Condition) -> (Vec<u16>, Vec<Note>) {
        let labels = label_faces(mesh, condition, &Weld::new(mesh), Way::Merging);
        (labels.part_of_face.chunks(12).map(|b| b[0]).collect(), labels.notes)
    }

    #[test]
    fn drawers_without_points_go_where_their_words_say_and_say_so() {
        let drawers = |first: &str, second: &str| {
            asked(&format!(
                r#"{{"name": "desk"}},
                {{"name": "a", "text": "{first} drawer", "parent": "desk", "joint": "prismatic"}},
                {{"name": "b", "text": "{second} drawer", "parent": "desk", "joint": "prismatic"}}"#
            ))
        };
        let (labels, notes) = labelled(&desk(), &drawers("left", "right"));
        assert_eq!(labels, [0, 0, 0, 0, 0, 2, 1]);
        let parts: Vec<_> = notes.iter().map(|n| n.part.as_str()).collect();
        assert_eq!(parts, ["a", "b"]);
        assert!(notes.iter().all(|n| n.message.contains("by its words") && !n.loss));
        assert_eq!(labelled(&desk(), &drawers("right", "left")).0, [0, 0, 0, 0, 0, 1, 2]);
    }

    #[test]
    fn a_point_on_one_drawer_leaves_the_other_to_its_twin() {
        let c = asked(
            r#"{"name": "desk"},
            {"name": "a", "text": "drawer", "parent": "desk", "joint": "prismatic"},
            {"name": "b", "text": "big drawer", "parent": "desk", "joint": "prismatic",
             "point": [-0.4, -0.34, 0.6]}"#,
        );
        assert_eq!(labelled(&desk(), &c).0, [0, 0, 0, 0, 0, 1, 2]);
    }

    #[test]
    fn a_part_without_words_and_one_that_fits_nothing_stay_unknown() {
        let mesh = boxes(&[([0.0; 3], [1.0; 3]), ([0.2, 0.2, 1.0], [0.8, 0.8, 1.4])]);
        let c = asked(
            r#"{"name": "body"},
            {"name": "lid", "parent": "body", "joint": "revolute", "point": [0.5, 0.5, 1.4]},
            {"name": "wheel", "parent": "body", "joint": "continuous"}"#,
        );
        let (labels, notes) = labelled(&mesh, &c);
        assert_eq!(labels, [0, 1]);
        assert!(notes[0].part == "wheel" && notes[0].message.contains("no shape says where"));
        let mut c = c;
        c.prompts[1].point = None;
        let part = |p: &object::Part| object::Part { text: String::new(), ..p.clone() };
        c.tree = object::KinematicTree::new(c.tree.parts().iter().map(part).collect()).unwrap();
        assert_eq!(labelled(&mesh, &c).0, [0, 0]);
    }
}
