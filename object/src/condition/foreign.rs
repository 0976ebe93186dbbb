//! The schema `condition/1`: parts by number, points in glTF coordinates.

use serde::Deserialize;

use super::file::{ConditionFile, FileJoints, FilePart, FileSize, SCHEMA};
use super::names::name_from_text;
use crate::kinematics::JointKind;

#[derive(Deserialize)]
pub(super) struct File {
    #[serde(default)]
    category: String,
    real_size_m: Option<Size>,
    #[serde(default)]
    notes: String,
    parts: Vec<Part>,
}

#[derive(Deserialize)]
struct Size {
    largest_extent: f64,
}

#[derive(Deserialize)]
struct Part {
    id: u64,
    text: String,
    parent: Option<u64>,
    #[serde(default)]
    joints: Vec<JointKind>,
    point: Option<[f64; 3]>,
    material: Option<String>,
    density_kg_m3: Option<f64>,
    friction: Option<f64>,
}

impl File {
    pub(super) fn translate(self) -> ConditionFile {
        let mut names: Vec<String> = Vec::new();
        for part in &self.parts {
            names.push(name_from_text(&part.text, &names));
        }
        let name_of = |id| self.parts.iter().position(|p| p.id == id).map(|i| names[i].clone());
        let part = |(i, p): (usize, &Part)| FilePart {
            name: names[i].clone(),
            text: Some(p.text.clone()),
            parent: p.parent.map(|id| name_of(id).unwrap_or_else(|| format!("id {id}"))),
            joint: FileJoints::Many(p.joints.clone()),
            point: p.point,
            material: p.material.clone(),
            density: p.density_kg_m3,
            friction: p.friction,
            ..FilePart::default()
        };
        let parts = self.parts.iter().enumerate().map(part).collect();
        ConditionFile {
            schema: SCHEMA.into(),
            category: self.category,
            size: self.real_size_m.map(|s| FileSize::Largest(s.largest_extent)),
            notes: self.notes,
            parts,
            ..ConditionFile::default()
        }
    }
}
