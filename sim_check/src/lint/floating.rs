//! Loose pieces: what is seen must hang together at rest (G4).

use std::collections::BTreeMap;

use glamx::DVec3;
use object::mesh::Bounds;
use object::weld::DisjointSets;
use rustc_hash::{FxHashMap, FxHashSet};

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
    /// A few points just outside it, root frame.
    outside: Vec<DVec3>,
}

impl Island {
    /// Whether there is matter around it: the wall of a cavity, or a piece sunk into a solid, is
    /// held without coming near another surface.
    fn is_held(&self, parts: &Parts) -> bool {
        let in_solid = |p: &&DVec3| {
            parts.parts.iter().zip(&parts.poses).any(|(part, pose)| {
                let local = pose.inverse_transform_point(**p);
                part.skin.as_ref().is_some_and(|s| s.winding.at(local) > 0.5)
            })
        };
        2 * self.outside.iter().filter(in_solid).count() > self.outside.len()
    }
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
    if islands.len() > 1 {
        clusters.join_near(points);
    }
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
            islands.extend(topology.components.iter().enumerate().map(|(i, c)| Island {
                link,
                area: c.area,
                volume: if c.is_closed { c.volume.abs() } else { 0.0 },
                anchor: pose.transform_point(c.anchor),
                outside: topology.outside(mesh, i).map(|p| pose.transform_point(p)).collect(),
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

/// Points of a triangle, at most `spacing` apart along its edges and across it.
fn spread([a, b, c]: [DVec3; 3], spacing: f64, put: &mut impl FnMut(DVec3)) {
    let (ab, bc, ca) = (a.distance(b), b.distance(c), c.distance(a));
    if ab.max(bc).max(ca) <= spacing {
        return put((a + b + c) / 3.0);
    }
    // Rows run parallel to the shortest side, so a needle gets few points.
    let [tip, left, right] = match (bc <= ab && bc <= ca, ca <= ab) {
        (true, _) => [a, b, c],
        (false, true) => [b, c, a],
        (false, false) => [c, a, b],
    };
    let steps = |length: f64| (length / spacing).ceil().clamp(1.0, 500.0) as u32;
    let rows = steps(tip.distance(left).max(tip.distance(right)));
    for row in 0..=rows {
        let t = f64::from(row) / f64::from(rows);
        let (from, to) = (tip.lerp(left, t), tip.lerp(right, t));
        let columns = steps(from.distance(to));
        (0..=columns).for_each(|i| put(from.lerp(to, f64::from(i) / f64::from(columns))));
    }
}

/// Points that lie in one cell, and the islands they are of, each once.
#[derive(Default)]
struct Cell {
    points: Vec<(DVec3, u32)>,
    islands: Vec<u32>,
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
    /// and fine cell, so the answer is good to a quarter of `near` or so.
    fn join_near(&mut self, points: Vec<(DVec3, u32)>) {
        let fine = self.near / 4.0;
        let min = Bounds::of(points.iter().map(|p| p.0)).min;
        let place = |p: DVec3, size: f64| ((p - min) / size).to_array().map(|c| c as i32);
        let mut known = FxHashSet::default();
        let mut last = None;
        let mut number_of: FxHashMap<[i32; 3], usize> = FxHashMap::default();
        let mut cells: Vec<([i32; 3], Cell)> = Vec::new();
        for (p, island) in points {
            // Neighbours on a surface come one after the other.
            let spot = Some((place(p, fine), island));
            if spot == last || !known.insert(spot) {
                continue;
            }
            last = spot;
            let at = place(p, self.near);
            let number = *number_of.entry(at).or_insert_with(|| {
                cells.push((at, Cell::default()));
                cells.len() - 1
            });
            let cell = &mut cells[number].1;
            cell.points.push((p, island));
            if !cell.islands.contains(&island) {
                cell.islands.push(island);
            }
        }
        for ([x, y, z], here) in &cells {
            for i in 13..27 {
                let there = [x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1];
                if let Some(&there) = number_of.get(&there) {
                    self.join_cells(here, &cells[there].1);
                }
            }
        }
    }

    fn join_cells(&mut self, here: &Cell, there: &Cell) {
        for &(p, a) in &here.points {
            if self.are_one(here, there) {
                return;
            }
            for &(q, b) in &there.points {
                if a != b && p.distance_squared(q) <= self.near * self.near {
                    self.sets.join(a, b);
                }
            }
        }
    }

    /// Whether all islands of two cells are of one cluster already.
    fn are_one(&mut self, here: &Cell, there: &Cell) -> bool {
        let mut roots = here.islands.iter().chain(&there.islands).map(|i| self.sets.root(*i));
        let first = roots.next();
        roots.all(|r| Some(r) == first)
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
        let loose = |(share, island): &&(f64, &Island)| *share > LOOSE && !island.is_held(parts);
        let told = |&(value, island): &(f64, &Island)| Finding {
            severity: value / LOOSE,
            value,
            unit: "of all",
            words: format!(
                "link `{}`: a piece of {:.1} % near {:.3} (root frame) touches nothing else",
                parts.robot.links[island.link].name,
                100.0 * value,
                island.anchor
            ),
        };
        let loose: Vec<_> = shares.iter().skip(1).filter(loose).map(told).collect();
        let tiny = shares.get(1).filter(|s| s.0 <= LOOSE).map(told);
        if loose.is_empty() { tiny.into_iter().collect() } else { loose }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_on_a_triangle_are_no_farther_apart_than_asked() {
        for corners in [[DVec3::ZERO, DVec3::X, DVec3::Y], [DVec3::X, DVec3::ZERO, DVec3::Y * 0.01]]
        {
            let mut points = Vec::new();
            spread(corners, 0.3, &mut |p| points.push(p));
            assert!(points.len() < 25 && corners.iter().all(|c| points.contains(c)));
            let alone = |p: &DVec3| points.iter().filter(|q| p.distance(**q) <= 0.3).count() < 3;
            assert!(!points.iter().any(alone), "{points:?}");
        }
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
