//! Mesh and condition to segmentation and joints: the chapter at the heart of the flow.

pub mod articulate;
pub mod ask;
pub mod choice;
pub mod classic;
pub mod features;
pub mod fit;
pub mod net;
pub mod neural;
pub mod predecessor;
pub mod weights;

pub use articulate::{Articulate, ArticulateError, Articulation, Note};
pub use choice::{Choice, articulator};
pub use classic::joints::choices::{Choices, LikelyAxis};
pub use classic::prepared::{PartLabels, Prepared};
pub use classic::{Geometric, Hybrid};
pub use neural::{Neural, NeuralError};
pub use predecessor::{Predecessor, PredecessorError, Proposal};
