//! What a part's words say about it: its role (door, knob, drawer), its usual size, and where it
//! is (left, upper, second).

pub mod places;
pub mod sizes;
pub mod words;
