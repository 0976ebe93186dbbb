//! What a person has corrected: points that are not of a part, and faces that were painted.
//!
//! A point that is not of a part becomes a seed of the likeliest other part, and labels spread anew. What the
//! part had around that point, nearer to it than to the part's own points, is then as it is found with that
//! seed; everything else stays. Painted faces are as they were painted, whatever else is found.

use object::weld::{Neighbour, nearest_face};
use object::{Condition, Mesh};

use crate::classic::segment::classify::{self, Asked, Probabilities};
use crate::classic::segment::oversegment::flood::flood;
use crate::classic::segment::prompts::seeds::Seed;
use crate::classic::segment::skin::Skin;
use crate::classic::segment::start::Start;

/// The faces that were said not to be of a part, each with that part.
pub(super) fn barred(mesh: &Mesh, condition: &Condition) -> Vec<Seed> {
    let of = |(part, prompt): (usize, &object::condition::Prompt)| {
        let face = |&point| nearest_face(mesh, point).0 as u32;
        let faces: Vec<u32> = prompt.not.iter().map(face).collect();
        faces.into_iter().map(move |face| Seed { face, part: part as u16 })
    };
    condition.prompts.iter().enumerate().flat_map(of).collect()
}

/// A seed for every face that is barred: the likeliest part that it is not barred from. How likely each part
/// is of each segment of the usual cut may be known already.
pub(super) fn instead(
    start: &Start,
    condition: &Condition,
    barred: &[Seed],
    (known, by_merging): (Option<&Probabilities>, bool),
) -> Vec<Seed> {
    let likely = known.cloned().map_or_else(|| Likely::of(start, condition, by_merging), Likely);
    let mut faces: Vec<u32> = barred.iter().map(|b| b.face).collect();
    faces.sort_unstable();
    faces.dedup();
    faces.retain(|face| start.seeds.iter().all(|s| s.face != *face));
    let one = |face: u32| {
        let may = |part: usize| !barred.contains(&Seed { face, part: part as u16 });
        let part = likely.part(start, face, may)?;
        Some(Seed { face, part: part as u16 })
    };
    faces.into_iter().filter_map(one).collect()
}

/// How likely each part is of each segment of the usual cut.
struct Likely(Probabilities);

impl Likely {
    fn of(start: &Start, condition: &Condition, by_merging: bool) -> Self {
        if by_merging {
            let certain = |label: Option<u16>| {
                let mut row = vec![0.0; condition.tree.len()];
                if let Some(label) = label {
                    row[usize::from(label)] = 1.0;
                }
                row
            };
            let groups = start.groups(&start.view, condition);
            return Self(groups.iter().map(|group| certain(group.label)).collect());
        }
        let is_fused = start.is_fused(condition.tree.root() as u16);
        let mut layout = start.usual_layout(condition);
        Self(classify::estimated(&mut layout, is_fused, Asked::Ensemble(0)))
    }

    /// The likeliest part that may be; where none is likely, that of the nearest seed.
    fn part(&self, start: &Start, face: u32, may: impl Fn(usize) -> bool) -> Option<usize> {
        /// Below this a part is no more likely than any other.
        const SOME: f32 = 1e-3;
        let segment = start.view.cut.of_face[face as usize] as usize;
        let row = self.0.get(segment)?;
        let ranked = row.iter().enumerate().filter(|(part, p)| may(*part) && **p > SOME);
        if let Some((part, _)) = ranked.max_by(|a, b| a.1.total_cmp(b.1)) {
            return Some(part);
        }
        let mesh = &start.skin.mesh;
        let here = mesh.centroid(face as usize);
        let off = |s: &&Seed| mesh.centroid(s.face as usize).distance_squared(here);
        let others = start.seeds.iter().filter(|s| may(usize::from(s.part)));
        let nearest = others.min_by(|a, b| off(a).total_cmp(&off(b)));
        nearest.map(|s| usize::from(s.part))
    }
}

/// Labels after what was said not to be of a part was taken from it, and nothing else: of the faces that a
/// part had `before`, those that are nearer over its surface to a barred face than to a point of its own
/// are what they are `after`.
pub(super) fn taken(
    skin: &Skin,
    (seeds, barred): (&[Seed], &[Seed]),
    (before, after): (&[u16], &[u16]),
) -> Vec<u16> {
    let mut labels = before.to_vec();
    let mut parts: Vec<u16> = barred.iter().map(|b| b.part).collect();
    parts.sort_unstable();
    parts.dedup();
    for part in parts {
        let is_part = |face: u32| before[face as usize] == part;
        let inside = skin.edges.iter().filter(|e| is_part(e.first) && is_part(e.second));
        let way = |e: &Neighbour| {
            let [a, b] = [e.first, e.second].map(|face| skin.mesh.centroid(face as usize));
            (e.first, e.second, a.distance(b))
        };
        let ways: Vec<(u32, u32, f64)> = inside.map(way).collect();
        let of = |all: &[Seed]| -> Vec<u32> {
            all.iter().filter(|s| s.part == part && is_part(s.face)).map(|s| s.face).collect()
        };
        let (own, mut starts) = (of(seeds).len(), of(seeds));
        starts.extend(of(barred));
        for (face, start) in flood(labels.len(), &ways, &starts).into_iter().enumerate() {
            if start.is_some_and(|start| start >= own) {
                labels[face] = after[face];
            }
        }
    }
    labels
}

/// Makes sure that no barred face is left to its part.
pub(super) fn enforce(
    part_of_face: &mut [u16],
    (segment_of_face, seeds): (&[u32], &[Seed]),
    barred: &[Seed],
) {
    for wrong in barred {
        let face = wrong.face as usize;
        let right = seeds.iter().find(|s| s.face == wrong.face && s.part != wrong.part);
        let Some(right) = right.filter(|_| part_of_face[face] == wrong.part) else { continue };
        let segment = segment_of_face[face];
        for (label, _) in part_of_face
            .iter_mut()
            .zip(segment_of_face)
            .filter(|(label, s)| **s == segment && **label == wrong.part)
        {
            *label = right.part;
        }
    }
}

#[cfg(test)]
mod tests {
    use object::DVec3;
    use object::weld::Weld;

    use super::*;

    /// A strip of ten squares along x, each two faces.
    fn strip() -> Mesh {
        let at = |i: u32| DVec3::new(f64::from(i / 2), f64::from(i % 2), 0.0);
        let square = |i: u32| [[2 * i, 2 * i + 2, 2 * i + 1], [2 * i + 1, 2 * i + 2, 2 * i + 3]];
        Mesh::new((0..22).map(at).collect(), (0..10).flat_map(square).collect()).unwrap()
    }

    fn taken_of(barred: Seed, after: &[u16]) -> Vec<u16> {
        let mesh = strip();
        let before: Vec<u16> = (0..20).map(|face| u16::from(face < 16)).collect();
        let own = [Seed { face: 0, part: 1 }];
        taken(&Skin::of(&mesh, &Weld::new(&mesh)), (&own, &[barred]), (&before, after))
    }

    #[test]
    fn a_point_that_is_not_of_a_part_does_not_take_the_whole_part_away() {
        let labels = taken_of(Seed { face: 15, part: 1 }, &[0; 20]);
        assert_eq!(labels[..7], [1; 7], "nearer to the part's own point");
        assert_eq!(labels[9..], [0; 11], "nearer to the other");
    }

    #[test]
    fn a_point_that_is_not_of_a_part_moves_nothing_that_was_not_of_it() {
        let labels = taken_of(Seed { face: 15, part: 1 }, &[2; 20]);
        assert_eq!(labels[16..], [0; 4], "these were another's before");
        let labels = taken_of(Seed { face: 18, part: 1 }, &[2; 20]);
        assert_eq!(labels[..16], [1; 16], "the part has nothing there");
    }
}
