//! Whether collision pieces cover what is seen, no more and no less (G3).

use std::collections::BTreeSet;

use glamx::DVec3;
use object::sample::sample_positions;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::finding::{Finding, judged, mm, unread};
use super::part::{Hull, Part, Parts, Skin};
use crate::profile::bounds::{COVER, FILLED};
use crate::profile::words::percent;
use crate::robot::{Link, Robot};
use crate::verdict::{Check, Status};

/// Where no surface is near, the winding of the six points around one has the mean of that one (it
/// is harmonic): below this, none of the six reaches a half.
const NEGLIGIBLE: f64 = 1.0 / 15.0;
/// Samples on the whole asset, per question.
const SAMPLES: usize = 3000;
/// Least samples on a link, per question.
const LEAST: usize = 96;

/// G3.
pub(super) fn cover(parts: &Parts, seed: u64) -> Check {
    if parts.parts.iter().all(|p| p.pieces.is_empty()) {
        let reason = "no link has collision geometry, so nothing that is seen can be touched";
        let (seen, unread) = (parts.parts.iter().any(|p| p.skin.is_some()), unread(parts));
        return match seen && unread.is_empty() {
            true => Check::fail("G3").evidence(reason),
            false => Check::unknown("G3", reason),
        };
    }
    if parts.parts.iter().all(|p| p.skin.is_none()) {
        return Check::unknown("G3", "no link has visual geometry to cover");
    }
    let gap = COVER.of(parts.diagonal);
    let mut findings = Vec::new();
    for (part, samples) in parts.parts.iter().zip(shares(parts)) {
        let question = Question { part, gap, samples, seed };
        findings.extend(question.findings());
    }
    let bound =
        format!("gap <= {}, filled cavity <= {} of the collision volume", mm(gap), percent(FILLED));
    let check = judged("G3", findings, unread(parts)).threshold(bound);
    let unseen = unseen(parts.robot);
    match check.status == Status::Pass && !unseen.is_empty() {
        true => Check { status: Status::Warn, ..check }.evidences(unseen),
        false => check,
    }
}

/// Rigid bodies that can be touched and show nothing, where others are seen: what was meant to be seen
/// of them is likely lost.
fn unseen(robot: &Robot) -> Vec<String> {
    let body_of = robot.body_of_link();
    let bodies_with = |has: fn(&Link) -> bool| -> BTreeSet<usize> {
        let links = robot.links.iter().zip(&body_of).filter(|(link, _)| has(link));
        links.map(|(_, body)| *body).collect()
    };
    let seen = bodies_with(|l| !l.visuals.is_empty());
    let touched = bodies_with(|l| !l.collisions.is_empty());
    if seen.is_empty() {
        return Vec::new();
    }
    let lost = touched.difference(&seen);
    lost.map(|b| format!("link `{}` can be touched and is not seen", robot.links[*b].name))
        .collect()
}

/// How many samples each link gets: by its visual area, but never less than [`LEAST`].
fn shares(parts: &Parts) -> Vec<usize> {
    let area = |p: &Part| {
        let mesh = p.skin.as_ref().map(|s| &s.mesh);
        mesh.map_or(0.0, |m| (0..m.faces().len()).map(|f| m.area(f)).sum())
    };
    let areas: Vec<f64> = parts.parts.iter().map(area).collect();
    let total = areas.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    areas.iter().map(|a| LEAST.max((SAMPLES as f64 * a / total) as usize)).collect()
}

struct Question<'a> {
    part: &'a Part<'a>,
    gap: f64,
    samples: usize,
    seed: u64,
}

impl Question<'_> {
    fn findings(&self) -> Vec<Finding> {
        let name = &self.part.link.name;
        let hulls: Vec<&Hull> = self.part.hulls().collect();
        match &self.part.skin {
            Some(_) if hulls.is_empty() => vec![Finding {
                severity: f64::INFINITY,
                value: f64::INFINITY,
                unit: "m",
                words: format!("link `{name}` is seen but has no collision geometry"),
            }],
            Some(skin) if self.part.unread().is_none() => {
                vec![self.uncovered(skin), self.overhang(skin, &hulls), self.filled(skin, &hulls)]
            }
            _ => vec![],
        }
    }

    fn gap_finding(&self, (gap, place): (f64, DVec3), what: &str) -> Finding {
        let (name, gap_mm) = (&self.part.link.name, mm(gap));
        let words = format!("link `{name}`: {what} {gap_mm}, near {place:.3} (link frame)");
        Finding { severity: gap / self.gap, value: gap, unit: "m", words }
    }

    /// Largest distance from what is seen to the pieces.
    fn uncovered(&self, skin: &Skin) -> Finding {
        let seen = sample_positions(&skin.mesh, self.samples, self.seed);
        let further = |worst: (f64, DVec3), p: DVec3| {
            let gap = self.part.hull_distance_beyond(p, worst.0, f64::INFINITY);
            if gap > worst.0 { (gap, p) } else { worst }
        };
        let worst = seen.into_iter().fold((0.0, DVec3::ZERO), further);
        self.gap_finding(worst, "the surface leaves its collision pieces by")
    }

    /// Largest distance from the pieces' outside to the seen solid.
    fn overhang(&self, skin: &Skin, hulls: &[&Hull]) -> Finding {
        let total: f64 = hulls.iter().map(|h| h.volume.cbrt()).sum();
        let mut points = Vec::new();
        for (i, hull) in hulls.iter().enumerate() {
            let count = 12 + (self.samples as f64 * hull.volume.cbrt() / total) as usize;
            let on_it = sample_positions(&hull.mesh, count, self.seed.wrapping_add(i as u64 + 1));
            points.extend(on_it.into_iter().map(|p| (i, p)));
        }
        let margin = 1e-6 * skin.mesh.bounds().diagonal();
        let is_outer = |i: usize, p: DVec3| {
            hulls.iter().enumerate().all(|(k, h)| k == i || !h.contains(p, margin))
        };
        let outer = points.into_iter().filter(|&(i, p)| is_outer(i, p));
        let further = |worst: (f64, DVec3), (_, p): (usize, DVec3)| {
            let gap = self.empty_distance(skin, p, worst.0);
            if gap > worst.0 { (gap, p) } else { worst }
        };
        let worst = outer.fold((0.0, DVec3::ZERO), further);
        self.gap_finding(worst, "a collision piece leaves the surface by")
    }

    /// Distance to the surface; beyond the gap that to the solid, which counts as 0 within the gap.
    /// Where it is no more than `enough`, any figure up to that.
    fn empty_distance(&self, skin: &Skin, p: DVec3, enough: f64) -> f64 {
        let limit = if enough < self.gap { self.gap } else { f64::INFINITY };
        let within = skin.distance_beyond(p, enough, limit);
        if within < self.gap || within <= enough {
            within
        } else if self.is_near_solid(skin, p) {
            0.0
        } else {
            skin.distance_beyond(p, enough, f64::INFINITY)
        }
    }

    /// Whether a point lies farther than the gap from the surface and what it encloses.
    fn is_empty(&self, skin: &Skin, p: DVec3) -> bool {
        !skin.is_near(p, self.gap) && !self.is_near_solid(skin, p)
    }

    /// Whether a point lies in the solid or within the gap of it. An open surface has its solid's
    /// face where the winding is a half.
    fn is_near_solid(&self, skin: &Skin, p: DVec3) -> bool {
        let winding = |at: DVec3| skin.winding.at(at);
        let here = winding(p);
        let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|a| a * self.gap);
        let beside = || axes.iter().any(|&a| winding(p + a) > 0.5 || winding(p - a) > 0.5);
        here > 0.5 || (here > NEGLIGIBLE && beside())
    }

    /// Share of the pieces' common volume that lies in empty space, beyond the gap.
    fn filled(&self, skin: &Skin, hulls: &[&Hull]) -> Finding {
        let total: f64 = hulls.iter().map(|h| h.volume).sum();
        let (mut filled, mut whole) = (0.0, 0.0);
        for (i, hull) in hulls.iter().enumerate() {
            let count = 12 + (self.samples as f64 * hull.volume / total) as usize;
            let points = points_inside(hull, count, self.seed.wrapping_add(i as u64));
            let weight = hull.volume / (points.len() as f64).max(1.0);
            for p in points {
                let holders = hulls.iter().filter(|h| h.contains(p, 0.0)).count().max(1);
                let share = weight / holders as f64;
                whole += share;
                filled += if self.is_empty(skin, p) { share } else { 0.0 };
            }
        }
        let value = filled / f64::max(whole, f64::MIN_POSITIVE);
        let name = &self.part.link.name;
        let words = format!(
            "link `{name}`: {:.1} % of its collision volume fills empty space",
            100.0 * value
        );
        Finding { severity: value / FILLED, value, unit: "of the volume", words }
    }
}

/// Points spread evenly inside a hull: at most `count`, found in its box by trial.
fn points_inside(hull: &Hull, count: usize, seed: u64) -> Vec<DVec3> {
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let (min, size) = (hull.bounds.min, hull.bounds.size());
    let mut draw = || min + size * DVec3::new(rng.random(), rng.random(), rng.random());
    let tries = (0..20 * count).map(|_| draw());
    tries.filter(|p| hull.contains(*p, 0.0)).take(count).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::tessellate::tessellated;
    use crate::robot::Geometry;

    #[test]
    fn points_inside_a_hull_are_inside_and_repeat() {
        let ball = tessellated(&Geometry::Sphere { radius: 1.0 }).unwrap();
        let hull = Hull::of(ball.vertices().to_vec()).unwrap();
        let points = points_inside(&hull, 101, 3);
        assert_eq!(points.len(), 101);
        assert!(points.iter().all(|p| p.length() <= 1.0));
        assert_eq!(points, points_inside(&hull, 101, 3));
    }
}
