//! Labels of a surface that was cut in several ways: class probabilities are averaged where the
//! cuts overlap.

use std::collections::{BTreeSet, HashMap};

use crate::classic::segment::classify::facts::Probabilities;
use crate::classic::segment::confidence::Confidence;
use crate::classic::segment::refine::connectivity::Ground;
use crate::classic::segment::refine::siblings;
use crate::classic::segment::refine::surface::Surface;

/// One way to cut the surface, and what is believed of its segments.
pub(crate) struct Told<'a> {
    /// The segment of each face.
    pub of_face: &'a [u32],
    /// For each segment, how likely each part is.
    pub probabilities: &'a Probabilities,
}

/// The part of each face, as all cuts together have it; what lies apart from its part is gathered in,
/// and parts far larger or smaller than others of their kind are settled (see [`siblings`]).
/// Beside it what was believed of the faces before that.
pub(crate) fn labels(surface: &Surface, told: &[Told]) -> (Vec<u16>, Confidence) {
    let Surface { skin, seeds, .. } = *surface;
    let (region, mut probabilities) = regions(skin.component.len(), told);
    let region_of_face = region.iter().map(|&a| a as u32).collect();
    let confidence = Confidence { region_of_face, rows: probabilities.clone() };
    let count = probabilities.len();
    let mut ground = Ground {
        beside: vec![Vec::new(); count],
        share: vec![0.0; count],
        seed: vec![None; count],
    };
    region.iter().zip(&skin.masses).for_each(|(&a, mass)| ground.share[a] += mass.area);
    let all = ground.share.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    ground.share.iter_mut().for_each(|share| *share /= all);
    for seed in seeds {
        ground.seed[region[seed.face as usize]] = Some(usize::from(seed.part));
    }
    let mut meet = BTreeSet::new();
    for e in &skin.edges {
        let (a, b) = (region[e.first as usize], region[e.second as usize]);
        if a != b {
            meet.extend([(a, b), (b, a)]);
        }
    }
    meet.into_iter().for_each(|(a, b)| ground.beside[a].push(b));
    let mut part_of_region = ground.gathered(&probabilities);
    let settled = siblings::settle(surface, &region, &part_of_region, &mut probabilities);
    if settled.changed {
        part_of_region = ground.gathered(&probabilities);
    }
    let mut labels = region.iter().map(|&a| part_of_region[a]).collect::<Vec<u16>>();
    siblings::keep_to_places(surface, &settled.twins, &mut labels);
    (labels, confidence)
}

/// Faces that no cut parts are one atom: the atom of each face, numbered in order of first face, and the
/// mean of what is believed of the segments that each atom is of.
fn regions(faces: usize, told: &[Told]) -> (Vec<usize>, Probabilities) {
    let mut region = vec![0_usize; faces];
    let mut first = Vec::new();
    for Told { of_face, .. } in told {
        let mut number = HashMap::new();
        first.clear();
        for (face, (region, segment)) in region.iter_mut().zip(*of_face).enumerate() {
            let next = first.len();
            *region = *number.entry((*region, *segment)).or_insert(next);
            if *region == next {
                first.push(face);
            }
        }
    }
    let row = |&face: &usize| {
        let rows = told.iter().map(|t| &t.probabilities[t.of_face[face] as usize]);
        mean(&rows.collect::<Vec<_>>())
    };
    let probabilities = first.iter().map(row).collect();
    (region, probabilities)
}

fn mean(rows: &[&Vec<f32>]) -> Vec<f32> {
    let parts = rows.first().map_or(0, |row| row.len());
    let of = |part: usize| rows.iter().map(|row| row[part]).sum::<f32>() / rows.len() as f32;
    (0..parts).map(of).collect()
}

#[cfg(test)]
mod tests {
    use object::weld::Weld;
    use object::{Condition, DVec3, Mesh};

    use super::*;
    use crate::classic::segment::prompts::seeds::Seed;
    use crate::classic::segment::skin::Skin;

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
        let skin = Skin::of(&mesh, &Weld::new(&mesh));
        labels(&Surface { skin: &skin, condition: &condition, seeds: &seeds }, told).0
    }

    fn seed(face: u32, part: u16) -> Seed {
        Seed { face, part }
    }

    #[test]
    fn where_cuts_overlap_the_mean_decides() {
        let (first, second) = ([0, 0, 0, 0, 0, 0, 1, 1, 1, 1], [0, 0, 0, 0, 1, 1, 1, 1, 1, 1]);
        let told = [
            Told { of_face: &first, probabilities: &vec![vec![0.6, 0.4], vec![0.1, 0.9]] },
            Told { of_face: &second, probabilities: &vec![vec![0.9, 0.1], vec![0.2, 0.8]] },
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
        let probabilities = [0.0, 0.55, 0.2, 0.9, 1.0].map(row).to_vec();
        let told = [Told { of_face: &of_face, probabilities: &probabilities }];
        assert_eq!(labelled(&told), [0, 0, 0, 0, 0, 0, 1, 1, 1, 1]);
    }
}
