//! Balls and capsules as they are: a segment and a radius.

/// All points within a radius of a segment along z about the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Round {
    /// Half the segment's length, metres; 0 for a ball.
    pub half: f64,
    /// Metres.
    pub radius: f64,
}
