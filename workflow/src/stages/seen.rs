//! How a robot stands with its joints at given values, and what is seen of it.

use object::Mesh;
use sim_check::geometry::tessellate::tessellated;
use sim_check::robot::{Robot, Shape};

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
