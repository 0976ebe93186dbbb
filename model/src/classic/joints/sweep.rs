//! How far a part moves along a joint before it bumps into what stays behind.
//!
//! Each probe point of the moving part walks along its own path; from a place that is `d` away from
//! everything it may jump by `d` unseen. A probe is stopped when it goes behind a face it stood in
//! front of, deeper than contact at rest explains. Lengths are shares of the object's diagonal.

use object::pose::turn_about;
use object::{DPose3, DVec3};

use crate::classic::joints::scene::{Nearest, Scene};

/// Deeper than this behind a face, beyond what it was at rest, is a collision.
pub const TOLERANCE: f64 = 0.005;
/// Behind a face this far, and the face says nothing about inside and outside any more.
const SHEET: f64 = 0.03;
/// Far more than the rounding of any distance.
const SLACK: f64 = 1e-9;
/// No probe looks farther than this for obstacles at once.
const SIGHT: f64 = 0.25;

/// A candidate axis: where it is, where it points and whether the part turns or slides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    /// Unit direction.
    pub direction: DVec3,
    /// A point on it.
    pub pivot: DVec3,
    /// Turns about it, rather than slides along it.
    pub turns: bool,
}

impl Axis {
    /// The motion by `q` radians or diagonals.
    pub fn pose(&self, q: f64) -> DPose3 {
        if self.turns {
            turn_about(self.direction, self.pivot, q)
        } else {
            DPose3::from_translation(self.direction * q)
        }
    }

    /// The velocity of a point per unit of q.
    pub fn velocity(&self, x: DVec3) -> DVec3 {
        if self.turns { self.direction.cross(x - self.pivot) } else { self.direction }
    }

    /// The same axis the other way round.
    #[must_use]
    pub fn reversed(&self) -> Self {
        Self { direction: -self.direction, ..*self }
    }

    /// Distance of a point from the axis line.
    pub fn radius(&self, x: DVec3) -> f64 {
        (x - self.pivot).reject_from_normalized(self.direction).length()
    }
}

/// A point of the moving part and what it is nearest to at rest.
#[derive(Clone, Copy, Debug)]
pub struct Probe {
    /// Where it starts.
    pub start: DVec3,
    /// The nearest point of what stays, if in sight.
    pub near: Option<Nearest>,
}

impl Probe {
    /// Looks around once, for all the sweeps to come.
    pub fn new(scene: &Scene, still: &[usize], start: DVec3) -> Self {
        Self { start, near: scene.nearest(still, start, SIGHT) }
    }
}

/// Who moves and who stays, and how finely to look.
pub struct Sweep<'a> {
    /// The bodies.
    pub scene: &'a Scene,
    /// Points of everything that moves.
    pub probes: &'a [Probe],
    /// The bodies that stay.
    pub still: &'a [usize],
    /// Shortest step of a probe.
    pub step: f64,
}

impl Sweep<'_> {
    /// How far the probes move along `axis`, at most `limit`, before more than each of the given
    /// shares of them is stopped. The shares rise; a few stopped probes may be rough surface.
    pub fn free<const N: usize>(&self, axis: &Axis, limit: f64, shares: [f64; N]) -> [f64; N] {
        let rank = |share: f64| (share * self.probes.len() as f64) as usize;
        let most = shares.last().map_or(0, |&s| rank(s));
        let mut stopped: Vec<f64> = Vec::new();
        for p in self.probes {
            let bar = stopped.get(most).copied().unwrap_or(limit);
            let reached = self.walk(axis, p, bar);
            if reached < bar {
                let at = stopped.partition_point(|&s| s <= reached);
                stopped.insert(at, reached);
                stopped.truncate(most + 1);
            }
        }
        shares.map(|s| stopped.get(rank(s)).copied().unwrap_or(limit))
    }

    /// How far one probe gets.
    fn walk(&self, axis: &Axis, probe: &Probe, limit: f64) -> f64 {
        let speed = axis.velocity(probe.start).length();
        if speed * limit <= TOLERANCE {
            return limit;
        }
        let mut walker = Walker::default();
        let (mut travelled, mut q) = (0.0, 0.0);
        let (mut x, mut near) = (probe.start, probe.near);
        while !walker.is_stopped(x, near, self.step) {
            if q >= limit {
                return limit;
            }
            travelled += near.map_or(SIGHT, |n| n.distance).max(self.step);
            q = (travelled / speed).min(limit);
            x = axis.pose(q) * probe.start;
            // What was nearest is still there: nothing farther than that counts.
            let most = near.map_or(SIGHT, |n| (n.point.distance(x) + SLACK).min(SIGHT));
            near = self.scene.nearest(self.still, x, most);
        }
        (q - self.step / speed).max(0.0)
    }
}

/// What a probe remembers of its way.
#[derive(Default)]
struct Walker {
    /// How deep it may be; `None` before the first look, at rest.
    allowed: Option<f64>,
    /// Whether it came from the free side.
    outside: bool,
    /// The last face it stood in front of, closely.
    faced: Option<Nearest>,
}

impl Walker {
    fn is_stopped(&mut self, x: DVec3, near: Option<Nearest>, step: f64) -> bool {
        let behind = near.is_some_and(|n| n.is_behind(x));
        let close = near.filter(|n| n.distance < SHEET);
        let depth = close.filter(|_| behind).map_or(0.0, |n| n.distance);
        let deep = self.outside && self.allowed.is_some_and(|a| depth > a);
        let through =
            self.faced.zip(close).is_some_and(|(before, now)| passed(&before, &now, x, step));
        self.allowed = Some(self.allowed.unwrap_or(f64::INFINITY).min(depth + TOLERANCE));
        if close.is_none() || !behind {
            self.outside = !behind;
            self.faced = close;
        }
        deep || through
    }
}

/// Whether a probe that stood in front of one face of a thin wall now stands in front of the other.
fn passed(before: &Nearest, now: &Nearest, x: DVec3, step: f64) -> bool {
    let behind = (x - before.point).dot(before.normal) < -step / 4.0;
    behind && now.normal.dot(before.normal) < -0.5 && x.distance(before.point) < 3.0 * step
}
