//! Loose pieces: what is seen must hang together at rest (G4).

use std::collections::BTreeMap;

use glamx::DVec3;
use object::weld::DisjointSets;

use super::part::Parts;
use super::{Finding, judged, mm, unread};
use crate::verdict::Check;

/// How near a piece must be: least metres, share of the diagonal.
const NEAR: (f64, f64) = (5e-3, 0.02);
/// Largest share of the total area or closed volume that may hang loose.
const LOOSE: f64 = 0.01;
/// Points on the surface are at most this share of the nearness apart.
const SPACING: f64 = 0.5;

/// A connected surface of a link.
struct Island {
    link: usize,
    area: f64,
    volume: f64,
    anchor: DVec3,
}

/// G4: islands of surface that come near each other are one cluster; every cluster but the largest
/// is loose.
pub(super) fn loose_pieces(parts: &Parts) -> Check {
    let near = parts.tolerance(NEAR.0, NEAR.1);
    let (islands, points) = islands(parts, near * SPACING);
    if islands.is_empty() {
        return Check::unknown("G4", "no link has visual geometry");
    }
    let mut clusters = Clusters::new(islands.len(), near);
    clusters.join_near(points);
    let findings = clusters.findings(parts, &islands);
    let bound = format!("pieces above 1 % lie within {} of the rest", mm(near));
    judged("G4", findings, unread(parts)).threshold(bound)
}

/// All islands, and points on them no farther apart than `spacing`, root frame.
fn islands(parts: &Parts, spacing: f64) -> (Vec<Island>, Vec<(DVec3, u32)>) {
    let (mut islands, mut points) = (Vec::new(), Vec::new());
    for (link, part) in parts.parts.iter().enumerate() {
        for surface in &part.visuals {
            let Ok(body) = &surface.body else { continue };
            let (mesh, topology) = (&body.0, &body.1);
            let pose = parts.poses[link] * surface.shape.origin;
            let first = islands.len() as u32;
            islands.extend(topology.components.iter().map(|c| Island {
                link,
                area: c.area,
                volume: if c.is_closed { c.volume.abs() } else { 0.0 },
                anchor: pose.transform_point(c.anchor),
            }));
            for face in 0..mesh.faces().len() {
                let island = first + topology.component_of_face[face];
                let corners = mesh.corners(face).map(|p| pose.transform_point(p));
                spread(corners, spacing, &mut |p| points.push((p, island)));
            }
        }
    }
    (islands, points)
}

/// Points of a triangle on a grid along two of its sides, at most `spacing` apart.
fn spread([a, b, c]: [DVec3; 3], spacing: f64, put: &mut impl FnMut(DVec3)) {
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    let steps = (longest / spacing).ceil().clamp(1.0, 500.0) as u32;
    for i in 0..=steps {
        for j in 0..=steps - i {
            let (u, v) = (f64::from(i) / f64::from(steps), f64::from(j) / f64::from(steps));
            put(a + (b - a) * u + (c - a) * v);
        }
    }
}

struct Clusters {
    sets: DisjointSets,
    near: f64,
}

impl Clusters {
    fn new(islands: usize, near: f64) -> Self {
        Self { sets: DisjointSets::new(islands), near }
    }

    /// Joins islands with points within `near` of each other. Points are thinned to one per island
    /// and eighth of a cell, so the answer is good to a quarter of `near`.
    fn join_near(&mut self, points: Vec<(DVec3, u32)>) {
        let fine = self.near / 4.0;
        let key = |p: DVec3, size: f64| (p / size).floor().to_array().map(|c| c as i64);
        let mut kept: Vec<([i64; 3], u32, DVec3)> =
            points.into_iter().map(|(p, island)| (key(p, fine), island, p)).collect();
        kept.sort_by(|a, b| (a.0, a.1).cmp(&(b.0, b.1)));
        kept.dedup_by(|a, b| (a.0, a.1) == (b.0, b.1));
        let mut cells: BTreeMap<[i64; 3], Vec<(DVec3, u32)>> = BTreeMap::new();
        for (_, island, p) in kept {
            cells.entry(key(p, self.near)).or_default().push((p, island));
        }
        for (&[x, y, z], here) in &cells {
            for i in 13..27 {
                let there = [x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1];
                if let Some(there) = cells.get(&there) {
                    self.join_cells(here, there);
                }
            }
        }
    }

    fn join_cells(&mut self, here: &[(DVec3, u32)], there: &[(DVec3, u32)]) {
        for &(p, a) in here {
            for &(q, b) in there {
                if a != b && p.distance_squared(q) <= self.near * self.near {
                    self.sets.join(a, b);
                }
            }
        }
    }

    fn findings(&mut self, parts: &Parts, islands: &[Island]) -> Vec<Finding> {
        let mut clusters: BTreeMap<u32, Vec<&Island>> = BTreeMap::new();
        for (i, island) in islands.iter().enumerate() {
            clusters.entry(self.sets.root(i as u32)).or_default().push(island);
        }
        let sum = |of: &[&Island], f: fn(&Island) -> f64| of.iter().map(|i| f(i)).sum::<f64>();
        let all: Vec<&Island> = islands.iter().collect();
        let (area, volume) = (sum(&all, |i| i.area), sum(&all, |i| i.volume));
        let share = |of: &[&Island]| {
            let of_volume = sum(of, |i| i.volume) / volume.max(f64::MIN_POSITIVE);
            (sum(of, |i| i.area) / area.max(f64::MIN_POSITIVE)).max(of_volume)
        };
        let mut shares: Vec<(f64, &Island)> =
            clusters.values().map(|of| (share(of), of[0])).collect();
        shares.sort_by(|a, b| b.0.total_cmp(&a.0));
        let told = |&(value, island): &(f64, &Island)| Finding {
            severity: value / LOOSE,
            value,
            words: format!(
                "link `{}`: a piece of {:.1} % near {:.3} (root frame) touches nothing else",
                parts.robot.links[island.link].name,
                100.0 * value,
                island.anchor
            ),
        };
        shares.iter().skip(1).map(told).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_on_a_triangle_are_no_farther_apart_than_asked() {
        let mut points = Vec::new();
        spread([DVec3::ZERO, DVec3::X, DVec3::Y], 0.3, &mut |p| points.push(p));
        assert_eq!(points.len(), 21);
        assert!(points.contains(&DVec3::X) && points.contains(&DVec3::Y));
    }

    #[test]
    fn islands_join_through_a_third_between_them() {
        let at = |x: f64, island: u32| (DVec3::X * x, island);
        let mut clusters = Clusters::new(4, 1.0);
        clusters.join_near(vec![at(0.0, 0), at(1.8, 1), at(0.9, 2), at(4.0, 3)]);
        let roots: Vec<_> = (0..4).map(|i| clusters.sets.root(i)).collect();
        assert_eq!(roots, [0, 0, 0, 3]);
    }
}
