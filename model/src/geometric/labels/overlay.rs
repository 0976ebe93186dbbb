//! Labels of a surface that was cut in several ways: where cuts overlap, what is believed of each is
//! averaged.

use std::collections::{BTreeMap, BTreeSet};

use object::weld::Weld;
use object::{Condition, Mesh};

use super::belonging::Beliefs;
use super::belonging::strays::Ground;
use super::fellows;
use super::seeds::Seed;

/// A surface and what is said of it.
pub(super) struct Surface<'a> {
    pub mesh: &'a Mesh,
    pub condition: &'a Condition,
    pub seeds: &'a [Seed],
}

/// One way to cut the surface, and what is believed of its pieces.
pub(super) struct Told<'a> {
    /// The piece of each face.
    pub of_face: &'a [u32],
    /// For each piece, how likely each part is.
    pub beliefs: &'a Beliefs,
}

/// The part of each face, as all cuts together have it; what lies apart from its part is gathered in,
/// and parts far larger or smaller than others of their kind are settled (see [`fellows`]).
pub(super) fn labels(surface: &Surface, weld: &Weld, told: &[Told]) -> Vec<u16> {
    let Surface { mesh, seeds, .. } = *surface;
    let (atom, mut beliefs) = atoms(mesh.faces().len(), told);
    let count = beliefs.len();
    let mut ground = Ground {
        beside: vec![Vec::new(); count],
        share: vec![0.0; count],
        seed: vec![None; count],
    };
    atom.iter().enumerate().for_each(|(face, &a)| ground.share[a] += mesh.area(face));
    let all = ground.share.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    ground.share.iter_mut().for_each(|share| *share /= all);
    for seed in seeds {
        ground.seed[atom[seed.face as usize]] = Some(usize::from(seed.part));
    }
    let mut meet = BTreeSet::new();
    for e in weld.neighbours() {
        let (a, b) = (atom[e.first as usize], atom[e.second as usize]);
        if a != b {
            meet.extend([(a, b), (b, a)]);
        }
    }
    meet.into_iter().for_each(|(a, b)| ground.beside[a].push(b));
    let mut part_of_atom = ground.gathered(&beliefs);
    let settled = fellows::settle(surface, &atom, &part_of_atom, &mut beliefs);
    if settled.changed {
        part_of_atom = ground.gathered(&beliefs);
    }
    let mut labels = atom.iter().map(|&a| part_of_atom[a]).collect::<Vec<u16>>();
    fellows::keep_to_places(surface, &settled.twins, &mut labels);
    labels
}

/// Faces that no cut parts are one atom: the atom of each face, numbered in order of first face, and the
/// mean of what is believed of the pieces that each atom is of.
fn atoms(faces: usize, told: &[Told]) -> (Vec<usize>, Beliefs) {
    let (mut number, mut beliefs) = (BTreeMap::new(), Beliefs::new());
    let atom = (0..faces).map(|face| {
        let pieces: Vec<u32> = told.iter().map(|t| t.of_face[face]).collect();
        let next = beliefs.len();
        *number.entry(pieces).or_insert_with_key(|pieces| {
            let rows = pieces.iter().zip(told).map(|(&piece, t)| &t.beliefs[piece as usize]);
            beliefs.push(mean(&rows.collect::<Vec<_>>()));
            next
        })
    });
    (atom.collect(), beliefs)
}

fn mean(rows: &[&Vec<f32>]) -> Vec<f32> {
    let parts = rows.first().map_or(0, |row| row.len());
    let of = |part: usize| rows.iter().map(|row| row[part]).sum::<f32>() / rows.len() as f32;
    (0..parts).map(of).collect()
}

#[cfg(test)]
mod tests {
    use object::DVec3;

    use super::*;

    /// A strip of five squares, each two faces.
    fn strip() -> Mesh {
        let at = |i: u32| DVec3::new(f64::from(i / 2), f64::from(i % 2), 0.0);
        let square = |i: u32| [[2 * i, 2 * i + 2, 2 * i + 1], [2 * i + 1, 2 * i + 2, 2 * i + 3]];
        Mesh::new((0..12).map(at).collect(), (0..5).flat_map(square).collect()).unwrap()
    }

    /// Two parts, whose prompts lie at both ends.
    fn condition() -> Condition {
        let parts = r#"{"name": "body"}, {"name": "lid", "parent": "body", "joint": "revolute"}"#;
        let text = format!(r#"{{"schema": "kinfold-condition/1", "up": "z", "parts": [{parts}]}}"#);
        Condition::from_json(&text).unwrap()
    }

    fn labelled(told: &[Told]) -> Vec<u16> {
        let (mesh, condition) = (strip(), condition());
        let seeds = [seed(0, 0), seed(9, 1)];
        let surface = Surface { mesh: &mesh, condition: &condition, seeds: &seeds };
        labels(&surface, &Weld::new(&mesh), told)
    }

    fn seed(face: u32, part: u16) -> Seed {
        Seed { face, part }
    }

    #[test]
    fn where_cuts_overlap_the_mean_decides() {
        let (first, second) = ([0, 0, 0, 0, 0, 0, 1, 1, 1, 1], [0, 0, 0, 0, 1, 1, 1, 1, 1, 1]);
        let told = [
            Told { of_face: &first, beliefs: &vec![vec![0.6, 0.4], vec![0.1, 0.9]] },
            Told { of_face: &second, beliefs: &vec![vec![0.9, 0.1], vec![0.2, 0.8]] },
        ];
        assert_eq!(
            labelled(&told),
            [0, 0, 0, 0, 1, 1, 1, 1, 1, 1],
            "0.4 and 0.8 are more than 0.6 and 0.2"
        );
    }

    #[test]
    fn what_lies_apart_is_gathered_in() {
        let of_face = [0, 0, 1, 1, 2, 2, 3, 3, 4, 4];
        let row = |p: f32| vec![1.0 - p, p];
        let beliefs = [0.0, 0.55, 0.2, 0.9, 1.0].map(row).to_vec();
        let told = [Told { of_face: &of_face, beliefs: &beliefs }];
        assert_eq!(labelled(&told), [0, 0, 0, 0, 0, 0, 1, 1, 1, 1]);
    }
}
