//! A cone, which the model has no word for, as a surface.

use std::f64::consts::TAU;
use std::sync::Arc;

use glamx::DVec3;
use object::Mesh;

use crate::robot::Geometry;

/// Sides of a cone: its volume is less than that of a round one by 0.2 % (computed).
const SIDES: u32 = 64;

/// A cone along z whose tip is up, centred halfway between tip and foot.
pub(crate) fn cone(radius: f64, length: f64, line: u32) -> Geometry {
    let rim = (0..SIDES).map(|k| {
        let (sin, cos) = (TAU * f64::from(k) / f64::from(SIDES)).sin_cos();
        DVec3::new(radius * cos, radius * sin, -length / 2.0)
    });
    let (tip, foot) = (DVec3::Z * (length / 2.0), DVec3::Z * (-length / 2.0));
    let vertices = [tip, foot].into_iter().chain(rim).collect();
    let faces = (0..SIDES).flat_map(|k| {
        let (a, b) = (2 + k, 2 + (k + 1) % SIDES);
        [[0, a, b], [1, b, a]]
    });
    match Mesh::new(vertices, faces.collect()) {
        Ok(mesh) => Geometry::Mesh(Arc::new(mesh)),
        Err(e) => Geometry::Unread { reason: format!("line {line}: a cone: {e}") },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cone_is_closed_and_stands_on_its_foot() {
        let Geometry::Mesh(mesh) = cone(1.0, 3.0, 1) else { panic!("a mesh") };
        assert!((mesh.signed_volume() / std::f64::consts::PI - 1.0).abs() < 2e-3);
        assert_eq!((mesh.bounds().min.z, mesh.bounds().max.z), (-1.5, 1.5));
    }
}
