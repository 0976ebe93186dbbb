//! The roof: order, persistence, people. [`mod@image_to_urdf`] is the flow; read it first.
//!
//! [`dag`] runs any flow, [`stages`] are this one's steps, [`recording`] writes its trace,
//! [`output`] what a person gets, [`cli`] and [`commands`] talk with that person.

pub mod batch;
pub mod cli;
pub mod commands;
pub mod dag;
pub mod image_to_urdf;
pub mod isolated;
pub mod moment;
pub mod ours;
pub mod output;
pub mod progress;
pub mod recording;
pub mod speech;
pub mod stages;
pub mod trust;
pub mod watch;

pub use image_to_urdf::image_to_urdf;
pub use stages::Tools;
