//! How a robot stands with its joints at given values, and what is seen of it.

use std::sync::Arc;

use object::Mesh;
use object::beside::Found;
use object::mesh::UpAxis;
use object::reading::Reading;
use sim_check::geometry::tessellate::tessellated;
use sim_check::robot::{Geometry, Robot, Shape};

use super::bundle::Files;

/// The surface of a shape, in the frame of its link, metres; in the colour the file gives it, where its
/// mesh has none of its own.
///
/// # Errors
/// Why there is none, in words.
pub(super) fn surface(shape: &Shape) -> Result<Mesh, String> {
    let mesh = tessellated(&shape.geometry)?;
    let mesh = mesh.map_vertices(|v| shape.origin * v).map_err(|e| e.to_string())?;
    match (mesh.colours(), shape.colour) {
        (None, Some(colour)) => {
            let colours = vec![colour; mesh.vertices().len()];
            mesh.with_colours(Some(colours)).map_err(|e| e.to_string())
        }
        _ => Ok(mesh),
    }
}

/// One value per joint, radians or metres: those given by joint, 0 for the others, and what follows from
/// them.
pub(super) fn values(robot: &Robot, given: &[(usize, f64)]) -> Vec<f64> {
    let mut values = vec![0.0; robot.joints.len()];
    given.iter().for_each(|&(joint, value)| values[joint] = value);
    // A chain of mimics is no longer than all joints.
    for _ in 0..robot.joints.len().min(8) {
        for (j, joint) in robot.joints.iter().enumerate() {
            if let Some(m) = joint.mimic {
                values[j] = m.multiplier * values[m.joint] + m.offset;
            }
        }
    }
    values
}

/// Most faces that are drawn of all textured visuals together: what a page shows with ease. A guess.
const FINE: usize = 120_000;

/// Lets visuals show what lies on them: colours of vertices come from the pictures of the package, where it
/// has any, as finely as pages and pictures can show it. For whoever draws; what is judged is the file's own.
pub(super) fn dress(robot: &mut Robot, files: &Files) {
    let visuals = robot.links.iter_mut().flat_map(|link| link.visuals.iter_mut());
    let mut textured: Vec<_> =
        visuals.filter_map(|shape| Some((reading(shape, files)?, shape))).collect();
    let share = FINE / textured.len().max(1);
    for (Reading { mesh, appearance, .. }, shape) in &mut textured {
        let fine = appearance.as_ref().and_then(|a| a.refined(mesh, share));
        let scale = shape.scale;
        let placed = fine.and_then(|mesh| mesh.map_vertices(|v| v * scale).ok());
        if let Some(mesh) = placed {
            shape.geometry = Geometry::Mesh(Arc::new(mesh));
        }
    }
}

/// The mesh of a visual with its materials and pictures; none of what has none.
fn reading(shape: &Shape, files: &Files) -> Option<Reading> {
    let text = std::str::from_utf8(files.get(&shape.source)?).ok()?;
    if !(shape.source.ends_with(".obj") && text.contains("mtllib")) {
        return None;
    }
    let folder = shape.source.rsplit_once('/').map_or("", |(folder, _)| folder);
    let mut beside = |name: &str| {
        let name = format!("{folder}/{name}");
        let bytes = files.get(name.trim_start_matches('/')).cloned();
        bytes.map(|bytes| Found { name, bytes }).ok_or_else(|| "is not there".to_owned())
    };
    let whole = object::obj::contained(text, &mut beside);
    object::obj::read_noted(&whole, UpAxis::Z).ok().filter(|r| r.appearance.is_some())
}
