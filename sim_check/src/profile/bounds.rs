//! The bounds of the profile, each once: what is checked and what is said of it come from here.
//!
//! Metres, radians, kilograms, seconds; shares from 0 to 1.
//!
//! ```
//! use sim_check::profile::bounds::{OPENED, OVERLAP};
//! assert_eq!([OVERLAP.of(0.3), OVERLAP.of(2.0)], [0.001, 0.004]);
//! assert_eq!(OPENED.of(false), 0.005);
//! ```

use std::f64::consts::{PI, TAU};
use std::ops::RangeInclusive;

/// A length that grows with what it is about: a few metres at least, or a share of its size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grown {
    /// Least length, metres.
    pub least: f64,
    /// Share of the size, mostly the diagonal of the whole object at rest.
    pub share: f64,
}

impl Grown {
    /// The bound for a thing of this size, metres.
    pub fn of(self, size: f64) -> f64 {
        self.least.max(self.share * size)
    }
}

/// A length that shrinks with what it is about: a few metres at most, or a share of its size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shrunk {
    /// Most, metres.
    pub most: f64,
    /// Share of the size.
    pub share: f64,
}

impl Shrunk {
    /// The bound for a thing of this size, metres.
    pub fn of(self, size: f64) -> f64 {
        self.most.min(self.share * size)
    }
}

/// A bound on a joint's value: an angle where it turns, a length where it slides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moved {
    /// Degrees.
    pub degrees: f64,
    /// Metres.
    pub metres: f64,
}

impl Moved {
    /// The bound for a joint that turns, radians, or slides, metres.
    pub fn of(self, turns: bool) -> f64 {
        if turns { radians(self.degrees) } else { self.metres }
    }
}

/// Degrees in radians.
pub const fn radians(degrees: f64) -> f64 {
    degrees * PI / 180.0
}

/// U1: largest deviation of a mesh scale from 1.
pub const SCALE: f64 = 1e-9;
/// U2: believable diagonals, metres.
pub const SIZES: RangeInclusive<f64> = 0.005..=10.0;
/// U3: how far the lowest point may be from z = 0 (`least` alone), and the base's centre from the z
/// axis, by the base's width.
pub const PLACED: Grown = Grown { least: 0.002, share: 0.05 };
/// G1: largest share of degenerate faces.
pub const DEGENERATE: f64 = 0.001;
/// G1: largest share of paired edges that both faces traverse the same way.
pub const CLASHING: f64 = 0.001;
/// G1: most faces of all visuals together.
pub const FACES: usize = 50_000;
/// G2: how far a piece may dent below its hull, as a share of its own diagonal.
pub const DENT: f64 = 1e-3;
/// G2: thinnest piece.
pub const THIN: Shrunk = Shrunk { most: 1e-3, share: 2e-3 };
/// G2: most vertices of a piece after welding.
pub const VERTICES: usize = 64;
/// G2: most pieces of a link.
pub const PIECES: usize = 32;
/// G3: largest gap between surface and pieces, either way.
pub const COVER: Grown = Grown { least: 5e-3, share: 0.02 };
/// G3: largest share of a link's collision volume that fills empty space.
pub const FILLED: f64 = 0.05;
/// G4: how near a piece of surface must be to the rest.
pub const BESIDE: Grown = Grown { least: 5e-3, share: 0.02 };
/// G4: largest share of the total area or closed volume that may hang loose.
pub const LOOSE: f64 = 0.01;
/// M2: possible densities, kg/m³.
pub const DENSITY: (f64, f64) = (20.0, 20_000.0);
/// M2: likely densities, kg/m³; outside a person should look.
pub const LIKELY: (f64, f64) = (100.0, 8_000.0);
/// M3: relative tolerance of the triangle inequality.
pub const TRIANGLE: f64 = 1e-6;
/// M4: how many times principal moments may leave those of the shape.
pub const MOMENTS: f64 = 10.0;
/// M5: how far outside its part's hull a centre of mass may lie.
pub const OUTSIDE: Grown = Grown { least: 1e-3, share: 2e-3 };
/// M6: most times a parent may outweigh its child.
pub const RATIO: f64 = 1000.0;
/// J1: tolerance of an axis' length.
pub const AXIS: f64 = 1e-6;
/// J3: largest turn between limits, radians.
pub const TURN: f64 = TAU;
/// J3: largest slide, as a share of the part's extent along it.
pub const SLIDE: f64 = 1.2;
/// J5: farthest pivot, as a share of the diagonal.
pub const PIVOT: f64 = 0.05;
/// J6: largest angle between an axis and a direction of its part, degrees.
pub const PARALLEL: f64 = 5.0;
/// J7: how far a joint may fall open; also how far one may be dragged along (S3).
pub const OPENED: Moved = Moved { degrees: 2.0, metres: 0.005 };
/// J7: how long gravity may try, seconds.
pub const HELD_FOR: f64 = 5.0;
/// C1, C2, C3: deepest overlap.
pub const OVERLAP: Grown = Grown { least: 0.001, share: 0.002 };
/// C4: how much a hinge's gap may grow.
pub const HINGE_GAP: Grown = Grown { least: 0.003, share: 0.003 };
/// C4: share of its own extent a slide must keep inside its guide.
pub const SLIDE_KEEPS: f64 = 0.05;
/// C5: a range whose declared side collides before this share of it is opened the wrong way, if the other
/// side is free.
pub const SOON: f64 = 0.5;
/// C5: the other side counts as free if it gets at least this many times as far.
pub const FARTHER: f64 = 2.0;
/// S1: energy that may be gained, as a share of what the motion turns over: what the engine's finite
/// steps make of a free swing.
pub const GAIN: f64 = 0.02;
/// S2: time to settle, seconds.
pub const SETTLE: f64 = 5.0;
/// S2: most sideways motion.
pub const DRIFT: Grown = Grown { least: 0.002, share: 0.002 };
/// S2: a root that leans further than this has tipped over, degrees.
pub const TIPPED: f64 = 10.0;
/// S3: share of its range a joint must cover.
pub const REACHED: f64 = 0.95;
/// S3: how far beyond an end a joint may go, as a share of its range.
pub const OVERSHOOT: f64 = 0.05;
/// S4: how far a joint may be pushed beyond its limit, as a share of its range ...
pub const PUSHED: f64 = 0.05;
/// S4: ... or this, where that is more.
pub const PUSHED_LEAST: Moved = Moved { degrees: 0.5, metres: 0.002 };
/// S5: relative difference to the closed form.
pub const CLOSED_FORM: f64 = 0.05;
/// R1 to R3: what is less likely right than this is doubtful; a guess.
pub const SURE: f64 = 0.5;
/// R4: class probability from which a piece of a link may well be another link's; a guess.
pub const STRAY: f64 = 0.35;
/// R4: share of its link from which a piece matters; a guess.
pub const PIECE: f64 = 0.05;
/// R4: a link that is likelier right than this keeps its pieces. Tuned on validation: with 0.8, seven of eight
/// links that R4 alone flagged were right.
pub const UNSURE: f64 = 0.6;
/// R5: how far from the nearer end of its range a joint is that is shown neither shut nor in the middle, as
/// shares of the range. Measured: of 223 true joints of Articraft's validation split 4 are shown so, 10 where
/// the second is 0.35.
pub const AJAR: (f64, f64) = (0.05, 0.2);
/// R6: smallest piece that matters, as a share of its link and of all that is seen. Tuned on Articraft's validation
/// split: of three smaller ones that lie along another link all were right.
pub const LOOSE_PIECE: f64 = 0.05;
/// R6: pieces of a link that come this near each other touch, as a share of the diagonal; a guess.
pub const TOUCH: f64 = 3e-4;
/// R6: what is nearer than this lies along each other, as a share of the diagonal; a guess.
pub const ALONG: f64 = 5e-3;
/// R6: a piece is doubtful if this many times as much of it lies along another link as along its own; a guess.
pub const TWICE: f64 = 2.0;
/// R6: surfaces part if one moves off along the other's normal, as a cosine: within 60°; a guess.
pub const PARTS: f64 = 0.5;
/// R7: how far beyond its range a joint is looked at, times the range; a guess.
pub const FARTHEST: f64 = 1.5;
/// R7: what is free this share of its range beyond it may have been shown open; a guess.
pub const BACK: f64 = 0.5;
/// R7: what is nearer than this lies against it, as a share of the diagonal; a guess.
pub const LIES: f64 = 0.01;
/// R7: how much more of a turning part must lie against the rest to be shut, as a share of its surface.
/// Tuned on Articraft's validation split: no turn of an object that is right has so much. Slides are not asked so,
/// for five telescopes there that are right go farther in than their range.
pub const CLOSER: f64 = 0.05;
/// R7: a slide of which this share lies against the rest is inside it; a guess.
pub const INSIDE: f64 = 0.5;
/// R7: shorter slides are buttons, which go in, as a share of the diagonal. Measured: of Articraft's validation
/// split the longest such button goes 0.009.
pub const STROKE: f64 = 0.03;
/// R7: how much of a slide must come free the other way, as a share of its surface; a guess.
pub const OUT: f64 = 0.2;
