//! The roof: order, persistence, people. [`mod@image_to_urdf`] is the flow; read it first.
//!
//! The [`runner`] runs any flow, [`stages`] are this one's steps, [`recording`] writes its trace,
//! [`output`] what a person gets, [`batch`] does many, [`cli`] talks with that person.

pub mod batch;
pub mod cli;
pub mod fix;
pub mod image_to_urdf;
pub mod mutate;
pub mod output;
mod pictured;
pub mod recording;
pub mod stages;

pub use image_to_urdf::image_to_urdf;
pub use stages::Tools;
