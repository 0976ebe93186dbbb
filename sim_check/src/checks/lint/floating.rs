//! Loose pieces: what is seen must hang together at rest (G4).

use std::collections::BTreeMap;

use glamx::DVec3;
use object::weld::DisjointSets;

use super::finding::{Finding, judged, mm, unread};
use super::part::Parts;
use crate::geometry::near::islands::{Islands, join_near};
use crate::profile::bounds::{BESIDE, LOOSE};
use crate::profile::words::percent;
use crate::verdict::Check;

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
    let near = BESIDE.of(parts.diagonal);
    let (islands, mut surfaces) = islands(parts);
    if islands.is_empty() {
        return Check::unknown("G4", "no link has visual geometry");
    }
    let mut clusters = Clusters(DisjointSets::new(islands.len()));
    if islands.len() > 1 {
        clusters.join_near(parts, &mut surfaces, near);
    }
    let findings = clusters.findings(parts, &islands);
    let bound = format!("pieces above {} lie within {} of the rest", percent(LOOSE), mm(near));
    let unread = unread(parts);
    // A piece that touches nothing else may touch what was not read.
    let findings = if unread.is_empty() { findings } else { Vec::new() };
    judged("G4", findings, unread).threshold(bound)
}

/// All islands, and for each link with a surface what belongs to which.
fn islands(parts: &Parts) -> (Vec<Island>, Vec<(usize, Islands)>) {
    let (mut islands, mut surfaces) = (Vec::new(), Vec::new());
    for (link, part) in parts.parts.iter().enumerate() {
        let mut of_face = Vec::new();
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
            of_face.extend(topology.component_of_face.iter().map(|c| first + c));
        }
        let surface = part.skin.as_ref().map(|skin| (link, Islands::new(skin.near(), &of_face)));
        surfaces.extend(surface);
    }
    (islands, surfaces)
}

struct Clusters(DisjointSets);

impl Clusters {
    /// Joins islands that come within `near` of each other.
    fn join_near(&mut self, parts: &Parts, surfaces: &mut [(usize, Islands)], near: f64) {
        surfaces.iter_mut().for_each(|(_, surface)| surface.join_own(near, &mut self.0));
        let around = |(link, surface): &(usize, Islands)| surface.bounds(&parts.poses[*link]);
        let mut placed: Vec<_> = surfaces.iter().map(|s| (around(s), s)).collect();
        placed.sort_by(|(a, one), (b, two)| a.min.x.total_cmp(&b.min.x).then(one.0.cmp(&two.0)));
        for (k, (bounds, (a, one))) in placed.iter().enumerate() {
            let reach = bounds.grown(near);
            let beside = placed[k + 1..].iter().take_while(|(b, _)| b.min.x <= reach.max.x);
            for (_, (b, two)) in beside.filter(|(b, _)| reach.intersects(b)) {
                let pose = parts.poses[*a].inv_mul(&parts.poses[*b]);
                join_near(one, two, &pose, near, &mut self.0);
            }
        }
    }

    fn findings(&mut self, parts: &Parts, islands: &[Island]) -> Vec<Finding> {
        let mut clusters: BTreeMap<u32, Vec<&Island>> = BTreeMap::new();
        for (i, island) in islands.iter().enumerate() {
            clusters.entry(self.0.root(i as u32)).or_default().push(island);
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
