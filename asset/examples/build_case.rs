//! Builds the URDF package of a case whose labels and joints are known.
//!
//! `cargo run --release -p kinfold-asset --example build_case -- CASE_FOLDER OUT_FOLDER`, where the
//! case folder holds `mesh.glb`, `face_labels.u16le`, `truth.json` and `condition.json`.

use std::error::Error;
use std::path::Path;

use asset::{BuildOptions, build};
use object::{
    ArticulatedObject, Condition, DVec3, FileFrame, JointKind, JointMotion, KinematicTree, Origin,
    Part, Range, glb,
};
use serde::Deserialize;

#[derive(Deserialize)]
struct Truth {
    parts: Vec<TruthPart>,
}

#[derive(Deserialize)]
struct TruthPart {
    parent: Option<usize>,
    joints: Vec<TruthJoint>,
}

#[derive(Deserialize)]
struct TruthJoint {
    #[serde(rename = "type")]
    kind: JointKind,
    axis: [f64; 3],
    pivot: [f64; 3],
    lower: Option<f64>,
    upper: Option<f64>,
}

impl TruthJoint {
    fn motion(&self) -> JointMotion {
        let turn = |v: [f64; 3]| FileFrame::default().point_to_object(DVec3::from_array(v));
        let range = match (self.lower, self.upper) {
            (Some(lower), Some(upper)) if self.kind != JointKind::Continuous => {
                Range::Limits { lower: lower.min(0.0), upper: upper.max(0.0) }
            }
            _ => Range::Continuous,
        };
        let kind = if range == Range::Continuous { JointKind::Continuous } else { self.kind };
        JointMotion { kind, axis: turn(self.axis).normalize(), pivot: turn(self.pivot), range }
    }
}

fn object_of(case: &Path, condition: &Condition) -> Result<ArticulatedObject, Box<dyn Error>> {
    let truth: Truth = serde_json::from_slice(&std::fs::read(case.join("truth.json"))?)?;
    let mesh = glb::read(&std::fs::read(case.join("mesh.glb"))?)?;
    let labels = std::fs::read(case.join("face_labels.u16le"))?;
    let labels = labels.chunks_exact(2).map(|b| u16::from_le_bytes([b[0], b[1]])).collect();
    let joints: Vec<Vec<_>> =
        truth.parts.iter().map(|p| p.joints.iter().map(TruthJoint::motion).collect()).collect();
    let part = |(i, p): (usize, &TruthPart)| Part {
        name: condition.tree.parts()[i].name.clone(),
        text: condition.tree.parts()[i].text.clone(),
        parent: p.parent,
        joints: joints[i].iter().map(|m: &JointMotion| m.kind).collect(),
    };
    let parts = truth.parts.iter().enumerate().map(part).collect();
    Ok(ArticulatedObject::new(mesh, KinematicTree::new(parts)?, labels, joints)?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, case, out] = &arguments[..] else {
        return Err("expected two arguments: CASE_FOLDER OUT_FOLDER".into());
    };
    let (case, out) = (Path::new(case), Path::new(out));
    let condition = Condition::from_json(&std::fs::read_to_string(case.join("condition.json"))?)?;
    let object = object_of(case, &condition)?;
    let map: Vec<_> = (0..object.tree().len()).map(Some).collect();
    let options = BuildOptions { joints: Origin::User, ..BuildOptions::default() };
    let asset = build(&object, &condition, &map, &options)?;
    for (path, bytes) in &asset.to_urdf().files {
        let path = out.join(path);
        std::fs::create_dir_all(path.parent().unwrap_or(out))?;
        std::fs::write(path, bytes)?;
    }
    Ok(())
}
