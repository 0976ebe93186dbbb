//! What a stage shows, in plain numbers: surfaces in its own frame, and what they are made of.

use glamx::DVec3;
use serde::{Deserialize, Serialize};

use crate::appearance::Wrap;

/// A mesh prim.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Surface {
    pub(super) points: Vec<DVec3>,
    /// Corners of each polygon, and for each the index of the corner among all.
    pub(super) polygons: Vec<Vec<u32>>,
    pub(super) colours: Option<Spread<[f64; 4]>>,
    /// Texture coordinates, v upward, by the name of the set.
    pub(super) places: Vec<(String, Spread<[f64; 2]>)>,
    /// Material of each polygon.
    pub(super) bound: Bound,
}

/// Values of a primvar: one for each of what it is spread over.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Spread<T> {
    pub(super) over: Over,
    pub(super) values: Vec<T>,
}

/// What the values of a primvar are of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Over {
    All,
    Faces,
    Points,
    Corners,
}

impl<T: Copy> Spread<T> {
    /// The value at a corner.
    pub(super) fn at(&self, face: usize, point: u32, corner: usize) -> Option<T> {
        let index = match self.over {
            Over::All => 0,
            Over::Faces => face,
            Over::Points => point as usize,
            Over::Corners => corner,
        };
        self.values.get(index).copied()
    }
}

/// All of it.
#[derive(Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Scene {
    /// `Y` or `Z`, where the file says.
    pub(super) up: Option<String>,
    /// Metres a unit.
    pub(super) unit: f64,
    pub(super) surfaces: Vec<Surface>,
    pub(super) looks: Vec<Look>,
    pub(super) notes: Vec<String>,
}

/// A picture on a material.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Laid {
    pub(super) file: String,
    pub(super) wrap: [Wrap; 2],
    /// Name of the set of coordinates; `st` where nothing is said.
    pub(super) set: String,
    /// Scale, turn in degrees, and shift of coordinates, in this order.
    pub(super) moved: [f64; 5],
    /// Which channel is taken: `rgb`, `r`, `g`, `b`, `a`.
    pub(super) channel: String,
}

/// A value, or a picture that has it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Input {
    pub(super) value: Option<Vec<f64>>,
    pub(super) picture: Option<Laid>,
}

/// A material as far as it is a `UsdPreviewSurface`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Look {
    pub(super) path: String,
    pub(super) name: String,
    pub(super) base: Input,
    pub(super) emissive: Input,
    pub(super) metallic: Input,
    pub(super) roughness: Input,
    pub(super) opacity: Input,
    pub(super) threshold: Input,
    pub(super) normal: Input,
}

/// Index of the material of each polygon.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Bound {
    pub(super) whole: Option<usize>,
    /// Where subsets say another.
    pub(super) of_face: Vec<Option<usize>>,
}

impl Bound {
    pub(super) fn of(&self, face: usize) -> Option<usize> {
        self.of_face.get(face).copied().flatten().or(self.whole)
    }
}
