//! Which way a joint opens and how far it moves, from free motion and from what is usual for the
//! part's role.

use std::f64::consts::PI;

use object::{DVec3, Range};

use crate::classic::joints::context::JointContext;
use crate::classic::joints::sweep::{Axis, Sweep};
use crate::classic::lexicon::words::Role;

/// Step of the sweep that sets a range, share of the diagonal.
const STEP: f64 = 0.004;
/// Shares of probes that may be stopped: firmly nearly none, softly a tenth.
const SHARES: [f64; 2] = [0.02, 0.1];
/// Shares of probes that may be stopped in a full turn.
const SPUN: [f64; 3] = [0.03, 0.12, 0.33];
/// Free motion below this, in radians or in lengths of the part, is none.
const LITTLE: f64 = 0.08;
/// One side shows more than the other by this share of it.
const CLEARLY: f64 = 0.3;
/// A part that touches its parent this far from the hinge, in its own reach, is shut.
const SHUT: f64 = 0.6;
/// What goes at least this share of its whole way to either side has no side that opens.
const BOTH: f64 = 0.15;

/// How far parts of a role go: opening and closing, radians; or lengths of the part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// The positive way.
    pub open: f64,
    /// The negative way.
    pub close: f64,
}

/// The usual reach of a role, for turns (radians) and slides (lengths of the part along the axis).
///
/// Medians to upper quartiles of 1,040 Articraft objects, rounded; furniture by custom: a door
/// opens to 115°, an oven's to level, a lid to 90°.
pub fn usual(role: Role, turns: bool) -> Reach {
    let (open, close) = match (role, turns) {
        (Role::Door, true) => (2.0, 2.0),
        (Role::FallDoor | Role::Lid, true) => (1.57, 1.57),
        (Role::Flap, true) => (1.4, 1.4),
        (Role::Knob | Role::Wheel | Role::Pointer | Role::Lift, true) => (2.4, 2.4),
        (Role::Lever | Role::Stand | Role::Head, true) => (0.8, 0.6),
        (_, true) => (1.3, 0.9),
        (Role::Button, false) => (0.4, 0.0),
        (Role::Lift, false) => (0.45, 0.1),
        (Role::Drawer, false) => (0.75, 0.75),
        (_, false) => (0.6, 0.6),
    };
    Reach { open, close }
}

/// Whether a joint is that of something pressed, as a button is.
pub(crate) fn is_pressed(axis: &Axis, role: Role) -> bool {
    role == Role::Button && !axis.turns
}

/// Free motion both ways.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Freedom {
    /// Along the axis: firm and soft.
    pub ahead: [f64; 2],
    /// Against it.
    pub back: [f64; 2],
}

/// The chosen axis, right way round, with its range in radians or scene lengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Travel {
    /// Positive is opening; where neither way is, see [`Travel::facing`].
    pub axis: Axis,
    /// The range; never empty.
    pub range: Range,
    /// Whether nothing was found free, so that the range is a guess.
    pub stuck: bool,
    /// Whether the free motion was found only by ignoring a tenth of the surface.
    pub rough: bool,
    /// How likely the trees find it; nothing of an endless joint.
    pub said: Option<Likely>,
}

/// How likely the trees find the ways and the amount of a motion, each 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Likely {
    /// The way it is taken to go: ahead, back, or both.
    pub way: f64,
    /// The likeliest of the others.
    pub next: f64,
    /// That it goes both ways.
    pub both: f64,
    /// The likeliest amount, of those that move.
    pub amount: f64,
}

impl Travel {
    /// The same motion, its axis along the positive side of its largest component where the part goes
    /// both ways, or without end: as one writes down a yaw, a pitch or a roll.
    #[must_use]
    pub fn facing(self) -> Self {
        let goes_both_ways = match self.range {
            Range::Limits { lower, upper } => upper.min(-lower) >= BOTH * (upper - lower),
            Range::Continuous => true,
        };
        let d = self.axis.direction;
        if !goes_both_ways || d[d.abs().max_position()] >= 0.0 {
            return self;
        }
        self.reversed()
    }

    /// The same motion along the axis turned round.
    #[must_use]
    pub(crate) fn reversed(self) -> Self {
        Self { axis: self.axis.reversed(), range: self.range.reversed(), ..self }
    }
}

impl JointContext<'_> {
    /// Length that ranges of a slide are measured in: the part's own along the axis, scene units.
    pub fn length(&self, axis: &Axis) -> f64 {
        let (low, high) = self.body.extent(axis.direction);
        if axis.turns { 1.0 } else { (high - low).max(1e-3) }
    }

    /// How far the part moves freely both ways, at most as far as any part of its role goes.
    pub fn freedom_of(&self, axis: &Axis, role: Role) -> Freedom {
        let reach = usual(role, axis.turns);
        let limit = reach.open.max(reach.close) * self.length(axis);
        let sweep =
            Sweep { scene: self.scene, probes: &self.probes, still: &self.still, step: STEP };
        let ahead = sweep.free(axis, limit, SHARES);
        let back = sweep.free(&axis.reversed(), limit, SHARES);
        Freedom { ahead, back }
    }

    /// How far the part moves firmly free along the axis, at most so far: radians or scene units.
    pub(crate) fn firmly_free(&self, axis: &Axis, limit: f64) -> f64 {
        let sweep = Sweep { scene: self.scene, probes: &self.few, still: &self.still, step: STEP };
        sweep.free(axis, limit, [SHARES[0]])[0]
    }

    /// How far the part moves freely along the axis and against it, at most half a turn or one diagonal,
    /// whatever its role: radians or scene units.
    pub fn clearance(&self, axis: &Axis) -> [f64; 2] {
        let limit = if axis.turns { PI } else { 1.0 };
        let sweep =
            Sweep { scene: self.scene, probes: &self.probes, still: &self.still, step: STEP };
        let [ahead, back] = [*axis, axis.reversed()].map(|a| sweep.free(&a, limit, SHARES));
        let little = LITTLE * self.length(axis);
        let pick = usize::from(ahead[0] < little && back[0] < little);
        [ahead[pick], back[pick]]
    }

    /// Share of a full turn that the part makes before a few and before many of its probes are
    /// stopped, 0 to 1.
    pub fn spin(&self, axis: &Axis) -> f64 {
        let sweep = Sweep { scene: self.scene, probes: &self.few, still: &self.still, step: STEP };
        let [ahead, back] =
            [*axis, axis.reversed()].map(|a| sweep.free(&a, PI, SPUN).iter().sum::<f64>());
        (ahead + back) / (2.0 * PI * SPUN.len() as f64)
    }

    /// The axis turned the opening way.
    pub fn opening(&self, axis: &Axis, role: Role) -> Axis {
        let opens = self.opens_ahead(axis, role, &self.freedom_of(axis, role));
        if opens { *axis } else { axis.reversed() }
    }

    /// Turns the axis the opening way and gives it the range that the trees find likeliest.
    pub fn travel(&self, axis: &Axis, role: Role) -> Travel {
        let free = self.freedom_of(axis, role);
        let (axis, open, close) = if self.opens_ahead(axis, role, &free) {
            (*axis, free.ahead, free.back)
        } else {
            (axis.reversed(), free.back, free.ahead)
        };
        let length = self.length(&axis);
        let little = LITTLE * length;
        let rough = open[0] < little && close[0] < little;
        let pick = usize::from(rough);
        let stuck = open[pick] < little && close[pick] < little;
        let most = if stuck && !is_pressed(&axis, role) { little } else { f64::INFINITY };
        let (reaches, said) = self.reaches(&axis, role);
        let [upper, lower] = reaches.map(|reach| reach.min(most));
        let range = Range::Limits { lower: -lower, upper };
        let travel = Travel { axis, range, stuck, rough, said: Some(said) };
        // Positive is opening.
        if upper > 0.0 { travel } else { travel.reversed() }
    }

    /// Whether the positive way is the opening one: what is pushed in leaves the eye, what closes an
    /// opening comes towards it; everything else goes where it is clearly freer, or else away from its
    /// parent.
    fn opens_ahead(&self, axis: &Axis, role: Role, free: &Freedom) -> bool {
        let away = self.body.centroid - self.parent.bounds.centre();
        let leaves = axis.velocity(self.body.centroid).dot(away);
        let is_pressed = is_pressed(axis, role);
        let is_shutter =
            matches!(role, Role::Door | Role::FallDoor | Role::Lid | Role::Flap | Role::Drawer);
        if (is_pressed || is_shutter)
            && let Some(is_to_the_eye) = self.comes_to_the_eye(axis)
        {
            return is_to_the_eye != is_pressed;
        }
        if is_pressed {
            return leaves < 0.0;
        }
        let [ahead, back] = [free.ahead, free.back].map(|f| f[0] + f[1]);
        if (ahead - back).abs() > 0.25 * ahead.max(back) { ahead > back } else { leaves >= 0.0 }
    }

    /// Whether the part, setting off the positive way, goes where one sees more of it from; `None` if
    /// one sees about as much from either side, or if it hardly sets off.
    pub(crate) fn comes_to_the_eye(&self, axis: &Axis) -> Option<bool> {
        let way = axis.velocity(self.body.centroid).try_normalize()?;
        let [ahead, back] = [way, -way].map(|d| self.shows(d));
        ((ahead - back).abs() > CLEARLY * ahead.max(back)).then_some(ahead > back)
    }

    /// Whether the part touches its parent far from the hinge: then it is shut and cannot close.
    pub(crate) fn is_shut(&self, axis: &Axis) -> bool {
        if !axis.turns {
            return false;
        }
        let reach = self.body.probes.iter().map(|&p| axis.radius(p)).fold(1e-6, f64::max);
        let touch = self.contact.child.iter().filter(|t| t.weight > 0.3);
        touch.map(|t| axis.radius(t.position)).fold(0.0, f64::max) > SHUT * reach
    }

    /// The point of the axis nearest to the part and to its parent; for a slide, of their contact.
    pub fn pivot(&self, axis: &Axis) -> DVec3 {
        if !axis.turns {
            let touch = self.contact.child.iter().max_by(|a, b| a.weight.total_cmp(&b.weight));
            return touch.map_or(axis.pivot, |t| t.position);
        }
        let d = axis.direction;
        let (low, high) = self.body.extent(d);
        let base = axis.pivot - d * d.dot(axis.pivot);
        let reach = |body: &crate::classic::joints::scene::Body, x| {
            body.nearest(x, 1.0).map_or(1.0, |n| n.distance)
        };
        let at = |i: i32| base + d * (low + (high - low) * f64::from(i) / 40.0);
        let worst = |x: DVec3| reach(self.body, x).max(reach(self.parent, x));
        // the middle first, so that it wins among equals
        let order = (0..=20).flat_map(|k| [20 + k, 20 - k]).map(at);
        let best = order
            .map(|x| (worst(x), x))
            .fold((f64::INFINITY, axis.pivot), |b, c| if c.0 < b.0 - 1e-3 { c } else { b });
        best.1
    }
}
