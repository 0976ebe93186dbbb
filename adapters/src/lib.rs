//! The world outside: who makes a mesh from a photo, who says what its parts are.
//!
//! Narrow traits with a written promise, [`ImageTo3d`], [`Vlm`] and the optional [`Critic`]; every
//! implementation is tested against [`contract`]. Whatever talks to a network does so through [`Transport`] alone.

pub mod asking;
pub mod book;
mod bounded;
pub mod budget;
pub mod chat;
pub mod config;
pub mod contract;
pub mod critic;
#[cfg(test)]
mod damage;
pub mod error;
pub mod files;
mod formats;
pub mod generators;
pub mod image_to_3d;
pub mod keeper;
pub mod kept;
pub mod net;
pub mod overheard;
pub mod photo;
pub mod probe;
pub mod recorded;
pub mod replay;
pub mod scripted;
pub mod sent;
pub mod terms;
pub mod transport;
pub mod usage;
#[cfg(test)]
mod vendor;
pub mod vlm;
pub mod world;

pub use config::Config;
pub use critic::{Critic, Critique, CritiqueQuestion};
pub use error::AdapterError;
pub use files::{ConditionFile, MeshFile};
pub use image_to_3d::{GeneratedMesh, ImageTo3d};
pub use photo::Photo;
pub use scripted::Scripted;
pub use transport::{Request, Response, Transport, TransportError};
pub use vlm::{KinematicQuestion, RenderedView, Vlm};
pub use world::World;
