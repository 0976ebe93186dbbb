//! The one question whose answer is expected to help most, and what each answer changes in the condition.
//!
//! An object is right where each of its parts and joints is. So the question is about what is least sure, as far
//! as one answer settles it: whose a doubtful piece is, which of two axes is right, which way a joint opens.
//! What is said of a part holds for its siblings, parts of one kind on one parent, as far as they agree with it:
//! all drawers of a chest come out of its front.

mod answers;
mod questions;
mod siblings;
mod types;

pub use answers::in_file;
pub use questions::{question, questions};
pub use siblings::heading;
pub use types::{About, Answer, Change, Question, Told};

#[cfg(test)]
mod tests;
