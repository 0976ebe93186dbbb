//! Shapes as they are stored: what follows from the rest is left out and put back.

use glamx::DVec3;
use object::articulated::ObjectError;
use object::mesh::MeshError;
use object::{ArticulatedObject, Confidence, JointMotion, KinematicTree, Mesh};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::build::shapes::Shapes;
use crate::change::Change;
use crate::collision::piece::ConvexPiece;
use crate::surface::repaired::Surface;
use crate::surface::simplify::joined;

/// What stands of shapes in a file. The object's surface is those of its parts, one after the other.
#[derive(Serialize, Deserialize)]
struct StoredShapes {
    scale: f64,
    offset: DVec3,
    part_of_condition: Vec<Option<usize>>,
    tree: KinematicTree,
    parts: Vec<StoredPart>,
    changes: Vec<Change>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    confidence: Option<Confidence>,
}

/// What stands of one part.
#[derive(Serialize, Deserialize)]
struct StoredPart {
    diagonal: f64,
    joints: Vec<JointMotion>,
    wanted: Vec<JointMotion>,
    surface: Surface,
    /// None where all of the surface is seen.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    seen: Option<Mesh>,
    pieces: Vec<ConvexPiece>,
}

/// Why what is stored makes no shapes.
#[derive(Debug, thiserror::Error)]
enum StoredError {
    #[error("expected the shapes of {expected} parts, found {found}")]
    Parts { expected: usize, found: usize },
    #[error("part `{part}`: expected {expected}")]
    Part { part: String, expected: &'static str },
    #[error(transparent)]
    Mesh(#[from] MeshError),
    #[error(transparent)]
    Object(#[from] ObjectError),
}

impl Serialize for Shapes {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        StoredShapes::of(self).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Shapes {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        StoredShapes::deserialize(deserializer)?.proved().map_err(D::Error::custom)
    }
}

impl StoredShapes {
    fn of(shapes: &Shapes) -> Self {
        let part = |part: usize| {
            let (surface, seen) = (shapes.surfaces[part].clone(), &shapes.seen[part]);
            StoredPart {
                diagonal: shapes.diagonals[part],
                joints: shapes.object.joints(part).to_vec(),
                wanted: shapes.wanted[part].clone(),
                seen: (*seen != surface.mesh).then(|| seen.clone()),
                surface,
                pieces: shapes.pieces[part].clone(),
            }
        };
        let tree = shapes.object.tree().clone();
        Self {
            scale: shapes.scale,
            offset: shapes.offset,
            part_of_condition: shapes.part_of_condition.clone(),
            parts: (0..tree.len()).map(part).collect(),
            tree,
            changes: shapes.changes.clone(),
            confidence: shapes.confidence.clone(),
        }
    }

    fn proved(self) -> Result<Shapes, StoredError> {
        let (expected, found) = (self.tree.len(), self.parts.len());
        if expected != found {
            return Err(StoredError::Parts { expected, found });
        }
        for (part, stored) in self.tree.parts().iter().zip(&self.parts) {
            let name = || part.name.clone();
            stored.check().map_err(|expected| StoredError::Part { part: name(), expected })?;
        }
        let meshes: Vec<&Mesh> = self.parts.iter().map(|p| &p.surface.mesh).collect();
        let (mesh, labels) = joined(&meshes)?;
        let joints = self.parts.iter().map(|p| p.joints.clone()).collect();
        let object = ArticulatedObject::new(mesh, self.tree, labels, joints)?;
        let mut shapes = Shapes {
            scale: self.scale,
            offset: self.offset,
            part_of_condition: self.part_of_condition,
            diagonals: self.parts.iter().map(|p| p.diagonal).collect(),
            object,
            wanted: Vec::new(),
            surfaces: Vec::new(),
            seen: Vec::new(),
            pieces: Vec::new(),
            changes: self.changes,
            confidence: self.confidence,
        };
        for part in self.parts {
            shapes.wanted.push(part.wanted);
            shapes.seen.push(part.seen.unwrap_or_else(|| part.surface.mesh.clone()));
            shapes.surfaces.push(part.surface);
            shapes.pieces.push(part.pieces);
        }
        Ok(shapes)
    }
}

impl StoredPart {
    /// Says what was expected where something leads out of its list.
    fn check(&self) -> Result<(), &'static str> {
        let faces = self.surface.mesh.faces().len();
        let patches = &self.surface.patches;
        let is_there = |p: &ConvexPiece| {
            let corners = p.vertices.len();
            !p.faces.is_empty() && p.faces.iter().flatten().all(|&v| (v as usize) < corners)
        };
        let rules = [
            (self.wanted.len() == self.joints.len(), "a wanted motion for each joint"),
            (
                patches.iter().flat_map(|p| &p.faces).all(|&f| (f as usize) < faces),
                "patches of faces that are there",
            ),
            (
                !self.pieces.is_empty() && self.pieces.iter().all(is_there),
                "collision pieces whose corners are there",
            ),
        ];
        rules.into_iter().find(|(holds, _)| !holds).map_or(Ok(()), |(_, rule)| Err(rule))
    }
}
