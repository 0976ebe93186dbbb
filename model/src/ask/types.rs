//! What a question is, what may be answered, and what an answer changes.

use object::{DVec3, Range};

/// A question, and what may be answered.
#[derive(Clone, Debug, PartialEq)]
pub struct Question {
    /// What it is about.
    pub about: About,
    /// The part of the object that it is about.
    pub part: usize,
    /// Further parts that the answer holds for as well, in order.
    pub also: Vec<usize>,
    /// Which share of the objects that are right once it is answered are wrong before, 0 to 1, as far as the
    /// parts and joints it settles are concerned.
    pub gain: f64,
    /// What may be answered; none of it is an answer, too.
    pub answers: Vec<Answer>,
}

/// What a question is about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum About {
    /// Whose the surface at a point is, in the mesh's frame and unit.
    Piece(DVec3),
    /// Where the axis of one of the part's joints is.
    Axis(usize),
    /// Which way one of its joints opens.
    Way(usize),
}

/// An answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Answer {
    /// The piece is of this part of the object.
    Is(usize),
    /// This is the axis, and a point on it, in the mesh's frame and unit.
    Axis(DVec3, DVec3),
    /// The joint opens along this axis, which goes through that point, as far as the range says.
    Opens(DVec3, DVec3, Range),
}

/// What an answer changes of one part in the condition.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Change {
    /// The part of the object.
    pub part: usize,
    /// What is told of it.
    pub told: Told,
}

/// What is told of a part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Told {
    /// A further point on it, in the mesh's frame and unit.
    Point(DVec3),
    /// Of one of its joints.
    Joint {
        /// Which of its joints.
        joint: usize,
        /// Direction of the axis.
        axis: DVec3,
        /// A point on it, in the mesh's frame and unit.
        pivot: DVec3,
        /// Both ends, from the shown pose, if they are told: radians or the mesh's unit.
        range: Option<Range>,
    },
}
