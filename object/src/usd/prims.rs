//! A USD stage prim by prim, for whoever looks for more in it than surfaces: what each is, where it stands,
//! what it says of physics.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

/// All prims of a stage that are defined and active, each after the one above it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Stage {
    /// `Y` or `Z`, where the file says.
    pub up: Option<String>,
    /// Metres a unit; a centimetre where nothing is said.
    pub metres: f64,
    /// Kilograms a unit.
    pub kilograms: f64,
    /// The prim that stands for the file.
    pub default_prim: Option<String>,
    /// Its prims.
    pub prims: Vec<Prim>,
    /// What of it could not be put together.
    pub missing: Vec<String>,
}

/// A prim.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Prim {
    /// Its path; one in an instance is called as if it stood there itself.
    pub path: String,
    /// Its type, such as `Xform`.
    pub kind: String,
    /// Schemas applied to it, each with its instance's name behind a colon.
    pub schemas: Vec<String>,
    /// Index of the prim above it.
    pub above: Option<usize>,
    /// Columns of where it stands in the stage's frame: three directions and a place.
    pub place: [[f64; 3]; 4],
    /// Whether it is hidden, itself or by one above.
    pub is_hidden: bool,
    /// `default`, `render`, `proxy` or `guide`, its own or that of one above.
    pub purpose: String,
    /// Numbers it says, by attribute.
    pub numbers: BTreeMap<String, Vec<f64>>,
    /// Words it says, by attribute.
    pub words: BTreeMap<String, String>,
    /// What it points at, by relationship.
    pub targets: BTreeMap<String, Vec<String>>,
    /// Points and polygons of a mesh.
    pub surface: Option<Polygons>,
}

/// Points in the prim's own frame and the corners of each face; a face whose corners turn left is seen.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Polygons {
    /// Places of its points.
    pub points: Vec<[f64; 3]>,
    /// Points of each face.
    pub faces: Vec<Vec<u32>>,
}

/// The files of a stage for the process that reads it, the first of them its root.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Bundle {
    pub root: Vec<u8>,
    pub files: BTreeMap<String, Vec<u8>>,
    /// Files that are not to be had.
    pub absent: BTreeSet<String>,
}

/// What came of a bundle.
#[derive(Debug, Serialize, Deserialize)]
pub(super) enum Told {
    Stage(Stage),
    /// Files that it names and that are not in the bundle.
    Lacks(Vec<String>),
}
