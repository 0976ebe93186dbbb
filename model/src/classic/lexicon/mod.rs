//! What words say of a part: its role, its usual size, where it is.

pub mod places;
pub mod sizes;
pub mod words;
