//! A mesh and a condition to labelled parts and joints, and these in any pose.

use std::collections::BTreeMap;

use model::{Articulation, Prepared};
use object::articulated::{JointMotion, Range};
use object::mesh::FileFrame;
use object::pose::part_poses;
use object::{Condition, Configuration, DPose3, DVec3, Mesh};
use pyo3::prelude::*;
use pyo3::types::{PyByteArray, PyBytes};
use serde_json::{Value, json};

use crate::arrays::{bytes, corners, mesh, points, up_axis};
use crate::errors::Wrong;
use crate::page;
use crate::threads::alone;

/// An articulated object. Points and directions come out in the frame of the mesh that came.
#[pyclass(frozen, module = "kinfold._kinfold")]
pub(crate) struct Articulated {
    made: Articulation,
    /// For each face, how likely it is of the part it is given to.
    chances: Vec<f32>,
    /// Vertices of which each is of one part: the mesh's vertex and the part.
    split: Vec<(u32, u16)>,
    /// The faces, by these vertices.
    faces: Vec<[u32; 3]>,
}

/// Labels the faces of a mesh with the parts of a condition and finds their joints, as `kinfold make` does.
///
/// The surface is vertices and faces, the condition a text. Asked for are the mesh's up axis, which is that
/// of a condition that does not say as well; whether points that lie off the mesh are moved onto it; a seed.
#[pyfunction]
pub(crate) fn articulate(
    py: Python<'_>,
    surface: (Bound<'_, PyAny>, Bound<'_, PyAny>),
    colours: Option<Bound<'_, PyAny>>,
    condition: String,
    asked: (String, bool, u64),
) -> PyResult<Articulated> {
    let ((vertices, faces), (up, snap, seed)) = (surface, asked);
    let up = up_axis(&up).map_err(|wrong| wrong.raised(py))?;
    let mesh = mesh(py, (&vertices, &faces), colours.as_ref(), up)?;
    alone(py, move || {
        let condition = Condition::from_json_with(&condition, up)?;
        if condition.frame.up != up {
            let found = "the condition's `up` is another axis than the mesh's";
            return Err(Wrong::input(found).of_class("ConditionError").hint("leave out `up=`"));
        }
        let condition = if snap { condition.snapped(&mesh).0 } else { condition };
        made(&mesh, &condition, seed)
    })
}

fn made(mesh: &Mesh, condition: &Condition, seed: u64) -> Result<Articulated, Wrong> {
    condition.check_points(mesh)?;
    // What parts and joints follow from, and nothing else, as in the flow.
    let prompts = condition.of_shape();
    let failed = |error: model::ArticulateError| match error {
        model::ArticulateError::Condition(error) => Wrong::from(error),
        error => Wrong::of("ArticulateError", &error).hint(
            "give each part a point on the mesh, and look at what the condition says of the base",
        ),
    };
    let prepared = Prepared::new(mesh).map_err(failed)?;
    let (made, _) = prepared.articulate(&prompts, seed).map_err(failed)?;
    let chances = prepared.labels(&prompts).map_err(failed)?.confidence;
    let (split, faces) = split(mesh, made.object.part_of_face());
    Ok(Articulated { made, chances, split, faces })
}

/// Vertices of one part each, in the order in which faces use them.
fn split(mesh: &Mesh, part_of_face: &[u16]) -> (Vec<(u32, u16)>, Vec<[u32; 3]>) {
    let mut number = BTreeMap::new();
    let mut split = Vec::new();
    let pairs = mesh.faces().iter().zip(part_of_face);
    let faces = pairs.map(|(face, &part)| {
        face.map(|vertex| {
            *number.entry((vertex, part)).or_insert_with(|| {
                split.push((vertex, part));
                split.len() as u32 - 1
            })
        })
    });
    let faces = faces.collect();
    (split, faces)
}

impl Articulated {
    fn frame(&self) -> FileFrame {
        self.made.object.mesh().frame()
    }

    /// Where parts stand at `q`, object frame.
    fn poses(&self, q: Vec<Vec<f64>>) -> Result<Vec<DPose3>, Wrong> {
        let tree = self.made.object.tree();
        let wanted: Vec<_> = tree.parts().iter().map(|p| p.joints.len()).collect();
        let found: Vec<_> = q.iter().map(Vec::len).collect();
        if wanted != found {
            let message = format!("q: expected values for joints {wanted:?}, found {found:?}");
            return Err(Wrong::input(message));
        }
        if let Some(odd) = q.iter().flatten().find(|value| !value.is_finite()) {
            return Err(Wrong::input(format!("q: expected numbers that are finite, found {odd}")));
        }
        Ok(part_poses(&self.made.object, &Configuration(q)))
    }

    fn joint(&self, motion: &JointMotion) -> Value {
        let frame = self.frame();
        let vector = |v: DVec3| frame.point_to_file(v).to_array();
        let range = match motion.range {
            Range::Limits { lower, upper } => json!([lower, upper]),
            Range::Continuous => Value::Null,
        };
        let (axis, pivot) = (vector(motion.axis), vector(motion.pivot));
        json!({ "kind": motion.kind, "axis": axis, "pivot": pivot, "range": range })
    }
}

#[pymethods]
impl Articulated {
    /// The part of every face, u16.
    fn labels<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyByteArray>> {
        bytes(py, self.made.object.part_of_face().iter().map(|part| part.to_ne_bytes()))
    }

    /// How likely every face is of its part, f32.
    fn chances<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyByteArray>> {
        bytes(py, self.chances.iter().map(|chance| chance.to_ne_bytes()))
    }

    /// Vertices of one part each at rest, the mesh's vertex that each is, and the faces: f64, i64, i64.
    fn surface<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyByteArray>, Bound<'py, PyByteArray>, Bound<'py, PyByteArray>)> {
        let all = self.made.object.mesh().vertices();
        let rest = self.split.iter().map(|(vertex, _)| all[*vertex as usize]);
        let came = self.split.iter().map(|(vertex, _)| i64::from(*vertex).to_ne_bytes());
        Ok((points(py, self.frame(), rest)?, bytes(py, came)?, corners(py, &self.faces)?))
    }

    /// The same vertices at `q`: for each part, a value for each joint.
    fn pose<'py>(&self, py: Python<'py>, q: Vec<Vec<f64>>) -> PyResult<Bound<'py, PyByteArray>> {
        let poses = self.poses(q).map_err(|wrong| wrong.raised(py))?;
        let all = self.made.object.mesh().vertices();
        let moved = |(vertex, part): &(u32, u16)| poses[usize::from(*part)] * all[*vertex as usize];
        points(py, self.frame(), self.split.iter().map(moved))
    }

    /// How every part moves from rest at `q`: matrices of four by four, f64, by rows.
    fn transforms<'py>(
        &self,
        py: Python<'py>,
        q: Vec<Vec<f64>>,
    ) -> PyResult<Bound<'py, PyByteArray>> {
        let poses = self.poses(q).map_err(|wrong| wrong.raised(py))?;
        let frame = self.frame();
        let matrix = |pose: &DPose3| {
            // The image of the origin and of each direction, all of them in the file's frame.
            let image = |p: DVec3| frame.point_to_file(*pose * frame.point_to_object(p));
            let origin = image(DVec3::ZERO);
            let columns = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| image(axis) - origin);
            let [x, y, z] = columns.map(|c| c.to_array());
            let o = origin.to_array();
            let row = |r: usize| [x[r], y[r], z[r], o[r]];
            [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]].concat()
        };
        let all: Vec<f64> = poses.iter().flat_map(matrix).collect();
        bytes(py, all.into_iter().map(f64::to_ne_bytes))
    }

    /// Parts, joints, notes and how sure all of it is, as JSON.
    fn described(&self) -> String {
        let object = &self.made.object;
        let part = |(index, part): (usize, &object::Part)| {
            let joints: Vec<_> = object.joints(index).iter().map(|m| self.joint(m)).collect();
            json!({ "name": part.name, "text": part.text, "parent": part.parent, "joints": joints })
        };
        let parts: Vec<_> = object.tree().parts().iter().enumerate().map(part).collect();
        let confidence = self.made.confidence.as_ref().map(|sure| {
            let joint = |j: &object::confidence::JointConfidence| {
                json!({ "axis": j.axis, "line": j.line, "way": j.way, "joint": j.joint })
            };
            let part = |p: &object::confidence::PartConfidence| {
                json!({ "labels": p.labels, "joints": p.joints.iter().map(joint).collect::<Vec<_>>() })
            };
            let parts: Vec<_> = sure.parts.iter().map(part).collect();
            json!({ "object": sure.object, "parts": parts })
        });
        json!({
            "parts": parts,
            "part_of_condition": self.made.part_of_condition,
            "notes": self.made.notes,
            "confidence": confidence,
        })
        .to_string()
    }

    /// The same as the stage `articulate` of a run leaves it.
    fn artefact<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let encoded =
            py.detach(|| <Articulation as runner::Artefact<workflow::Tools>>::encode(&self.made));
        let encoded = encoded.map_err(|e| Wrong::of("InternalError", &e).raised(py))?;
        Ok(PyBytes::new(py, &encoded))
    }

    /// A page that shows it in a browser and moves its joints.
    fn page(&self, py: Python<'_>, title: String) -> String {
        py.detach(|| ::page::write(&page::scene(&self.made.object, title)))
    }
}
