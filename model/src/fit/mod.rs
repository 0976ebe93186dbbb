//! From what single points say to one axis, one range and one part for each face.

pub mod axis;
pub mod faces;
pub mod range;
pub mod survive;

pub use axis::{Axis, fit_axis};
pub use faces::{FaceVotes, Mode, label_faces};
pub use range::{Bounds, Displacement, slide_bounds, turn_bounds};
