//! What a stranger sent is read and shown through here, and nowhere else.
//!
//! [`files`] reads regular files up to a size and never waits for a pipe or a device. [`folder`] does
//! so within a folder, never through a link that leaves it, and looks through it under caps that
//! its errors name. [`text`] makes names and reasons inert before a terminal,
//! a log or a report sees them. Nothing in here knows what a mesh or a trace is.

pub mod files;
pub mod folder;
pub mod text;
