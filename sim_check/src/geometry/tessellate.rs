//! The surface of a URDF primitive as triangles, for whoever needs to look at it.

use glamx::DVec3;
use object::Mesh;

use crate::robot::Geometry;

/// Sides of the prism that stands for a cylinder, and segments round a sphere.
const SIDES: u32 = 48;

/// The surface of a shape, its own frame, metres.
///
/// # Errors
/// What is wrong with its size, or why it could not be read.
pub fn tessellated(geometry: &Geometry) -> Result<Mesh, String> {
    let sizes = match geometry {
        Geometry::Mesh(mesh) => return Ok(Mesh::clone(mesh)),
        Geometry::Unread { reason } => return Err(reason.clone()),
        Geometry::Box { size } => size.to_array().to_vec(),
        Geometry::Cylinder { radius, length } => vec![*radius, *length],
        Geometry::Sphere { radius } | Geometry::Capsule { radius, .. } => vec![*radius],
        Geometry::Ellipsoid { half } => half.to_array().to_vec(),
    };
    if sizes.iter().any(|s| *s <= 0.0) {
        return Err(format!("sizes must be positive, found {sizes:?}"));
    }
    let (vertices, faces) = match geometry {
        Geometry::Box { size } => lathe(&[(1.0, -0.5), (1.0, 0.5)], 4, &|p| square(p) * *size),
        Geometry::Cylinder { radius: r, length: l } => {
            lathe(&[(*r, -l / 2.0), (*r, l / 2.0)], SIDES, &|p| p)
        }
        Geometry::Ellipsoid { half } => lathe(&meridian(1.0, 0.0), SIDES, &|p| p * *half),
        Geometry::Capsule { radius, length } => {
            lathe(&meridian(*radius, length.max(0.0)), SIDES, &|p| p)
        }
        _ => lathe(&meridian(sizes[0], 0.0), SIDES, &|p| p),
    };
    Mesh::new(vertices, faces).map_err(|e| e.to_string())
}

/// Rings of a ball pulled apart by a length along z: radius and height, from below to above.
fn meridian(radius: f64, length: f64) -> Vec<(f64, f64)> {
    let ring = |i: u32| {
        let (s, c) = (f64::from(i) * std::f64::consts::PI / 24.0).sin_cos();
        let apart = if i < 12 { -length / 2.0 } else { length / 2.0 };
        (radius * s, apart - radius * c)
    };
    (1..24).map(ring).collect()
}

/// The unit square's corner a corner of the unit circle's square stands for.
fn square(p: DVec3) -> DVec3 {
    DVec3::new(p.x.signum() / 2.0, p.y.signum() / 2.0, p.z)
}

/// A closed surface around z: rings of (radius, z) from below to above, capped by fans.
fn lathe(
    rings: &[(f64, f64)],
    sides: u32,
    place: &dyn Fn(DVec3) -> DVec3,
) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for &(radius, z) in rings {
        for side in 0..sides {
            let angle = (f64::from(side) + 0.5) * std::f64::consts::TAU / f64::from(sides);
            vertices.push(place(DVec3::new(radius * angle.cos(), radius * angle.sin(), z)));
        }
    }
    for ring in 1..rings.len() as u32 {
        for side in 0..sides {
            let next = (side + 1) % sides;
            let (low, high) = ((ring - 1) * sides, ring * sides);
            faces.push([low + side, low + next, high + next]);
            faces.push([low + side, high + next, high + side]);
        }
    }
    let top = (rings.len() as u32 - 1) * sides;
    for side in 1..sides - 1 {
        faces.push([0, side + 1, side]);
        faces.push([top, top + side, top + side + 1]);
    }
    (vertices, faces)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::checks::lint::surface::Topology;

    #[test]
    fn primitives_are_closed_and_of_known_volume() {
        let volume = |g: Geometry| {
            let t = Topology::of(&tessellated(&g).unwrap());
            assert!(t.is_closed() && t.degenerate == 0, "{g:?}");
            t.volume()
        };
        assert!((volume(Geometry::Box { size: DVec3::new(1.0, 2.0, 3.0) }) - 6.0).abs() < 1e-12);
        let pi = std::f64::consts::PI;
        let cylinder = volume(Geometry::Cylinder { radius: 2.0, length: 3.0 });
        assert!((cylinder / (12.0 * pi) - 1.0).abs() < 0.01, "{cylinder}");
        let sphere = volume(Geometry::Sphere { radius: 2.0 });
        assert!((sphere / (32.0 / 3.0 * pi) - 1.0).abs() < 0.01, "{sphere}");
        let capsule = volume(Geometry::Capsule { radius: 1.0, length: 2.0 });
        assert!((capsule / (10.0 / 3.0 * pi) - 1.0).abs() < 0.02, "{capsule}");
        let half = DVec3::new(1.0, 2.0, 3.0);
        assert!((volume(Geometry::Ellipsoid { half }) / (8.0 * pi) - 1.0).abs() < 0.01);
        assert!(tessellated(&Geometry::Sphere { radius: 0.0 }).is_err());
    }
}
