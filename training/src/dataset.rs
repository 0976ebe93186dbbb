//! What is trained on: objects with exact labels and joints, measured once and kept on disk.
//!
//! A [`Specimen`] is an object as its source gives it; a [`Sample`] is one pose of it, seen through
//! points in the unit cube, with everything the network is shown and asked. [`prepare`] turns the
//! first into the second and keeps the result in a folder, so that features are computed once.

pub mod cache;
pub mod cut;
pub mod evalcase;
pub mod library;
pub mod pose;
pub mod prepare;
pub mod sample;
pub mod shards;

pub use library::{Library, Plan, SourceConfig};
pub use sample::{Sample, SampleJoint, SamplePart};

use std::path::{Path, PathBuf};

use object::{ArticulatedObject, DVec3, Mesh};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

/// An object with its truth, and what its parts may be called.
#[derive(Clone, Debug)]
pub struct Specimen {
    /// Unique in its source.
    pub id: String,
    /// Mesh, labels, tree and joints; object frame.
    pub object: ArticulatedObject,
    /// For each part, one or more ways to say what it is.
    pub wordings: Vec<Vec<String>>,
}

/// The face nearest the middle of the surface that some faces make: where one points who knows the
/// part.
pub fn middle_face(mesh: &Mesh, faces: &[usize]) -> Option<usize> {
    let all: f64 = faces.iter().map(|&f| mesh.area(f)).sum();
    let middle = faces.iter().map(|&f| mesh.centroid(f) * mesh.area(f)).sum::<DVec3>() / all;
    let off = |f: usize| mesh.centroid(f).distance_squared(middle);
    faces.iter().copied().min_by(|&a, &b| off(a).total_cmp(&off(b)))
}

/// Any of some faces, the larger ones oftener by as much: where one may well click.
pub fn any_face(mesh: &Mesh, faces: &[usize], dice: &mut Pcg64Mcg) -> Option<usize> {
    let all: f64 = faces.iter().map(|&f| mesh.area(f)).sum();
    let mut left = all * dice.random::<f64>();
    let found = faces.iter().copied().find(|&f| {
        left -= mesh.area(f);
        left <= 0.0
    });
    found.or(faces.last().copied())
}

/// Why data cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum DataError {
    /// The disk.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// A file that is not what it should be.
    #[error("{}: {what}", path.display())]
    Broken {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        what: String,
    },
    /// An object kept back for evaluation.
    #[error("{}: object `{id}` must not be trained on: {why}", path.display())]
    HeldOut {
        /// The file it stands in.
        path: PathBuf,
        /// The object.
        id: String,
        /// What says so.
        why: String,
    },
    /// A source that gives nothing.
    #[error("source `{0}` has no usable object")]
    Empty(String),
}

impl DataError {
    pub(crate) fn io(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_path_buf();
        move |source| Self::Io { path, source }
    }

    pub(crate) fn broken(path: &Path, what: impl std::fmt::Display) -> Self {
        Self::Broken { path: path.to_path_buf(), what: what.to_string() }
    }
}
