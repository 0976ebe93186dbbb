//! What a part weighs and how its mass is spread: exact over closed surfaces, as a wall where a body
//! must be hollow, as a sheet where the surface is open.
//!
//! Densities are those of solid material while most bodies are hollow. Therefore a closed body
//! counts with the smaller of its volume and its area times the usual wall of its material.
//!
//! ```
//! use asset::mass::materials::substance;
//! use asset::mass::weigh::weigh;
//! use asset::surface::repair::repair;
//! use object::{Condition, DVec3, Mesh};
//! let corners = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
//! let faces = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
//! let mesh = Mesh::new(corners, faces)?;
//! let condition = Condition::from_json(
//!     r#"{"schema": "kinfold-condition/1", "category": "block", "parts": [{"name": "block", "mass": 2}]}"#,
//! )?;
//! let stuff = substance(&condition, condition.prompts.first(), "block", 1.7);
//! let body = weigh(&repair(&mesh, None)?, &[], &stuff);
//! assert_eq!(body.mass.value, 2.0);
//! assert!((body.volume.value - 1.0 / 6.0).abs() < 1e-15);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::collections::BTreeMap;

use glamx::{DMat3, DVec3};
use object::mesh::Bounds;
use object::{Origin, Sourced};

use crate::collision::piece::{ConvexPiece, held};
use crate::mass::columns::overlap;
use crate::mass::materials::Substance;
use crate::mass::moments::{Moments, floored};
use crate::surface::repaired::Surface;

/// No link is lighter, kg, unless it would have to be denser than [`DENSITY`] allows.
pub const LIGHTEST: f64 = 1e-4;
/// A part whose surface is closed to this share of its area has a volume of its own.
const MOSTLY_CLOSED: f64 = 0.9;
/// Emptiest and densest a part may become, kg per m³ of the space it fills, unless stated: a little
/// within 100 to 8000, outside of which a density is suspect.
pub const DENSITY: [f64; 2] = [102.0, 7900.0];
/// Smallest covariance as a share of its trace: the margin of the triangle inequality.
const ROUNDNESS: f64 = 1e-6;

/// A part's mass, before any adjustment between parts.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Mass, kg.
    pub mass: Sourced<f64>,
    /// Centre of mass, in the frame of the surface, metres.
    pub centre: DVec3,
    /// Covariance of the mass about its centre, m²; inertia follows by [`crate::mass::moments::inertia_of`].
    pub covariance: DMat3,
    /// Space the part fills, m³: its closed bodies' union, or its collision pieces.
    pub volume: Sourced<f64>,
    /// Mass below which the part would be emptier than [`DENSITY`] allows, kg.
    pub least: f64,
}

/// One closed body: an outer patch and the cavities in it.
struct Closed {
    volume: Moments,
    sheet: Moments,
    bounds: Bounds,
}

/// Weighs a part. Its collision `pieces` bound what an open surface may enclose.
pub fn weigh(surface: &Surface, pieces: &[ConvexPiece], substance: &Substance) -> Body {
    let about = surface.mesh.bounds().centre();
    let bodies = closed_bodies(surface, about);
    let open = open_sheet(surface, about);
    let twice = counted_twice(surface, &bodies, about);
    let space = filled(&bodies, &open, twice.measure, pieces);
    let wall = substance.wall.value;
    let (closed, shape) = closed_material(&bodies, &twice, wall);
    let open = open_material(&open, closed.measure, space.value, wall);
    let material = usable(closed + open, surface, about);
    let sheets = bodies.iter().any(|b| is_hollow(b, wall)) || open.measure > 0.0;
    let least = substance.density.value.min(DENSITY[0]) * space.value.max(held(pieces));
    let mass = mass_of(material.measure, least, substance, &shape);
    let covariance = material.covariance();
    let trace = covariance.x_axis.x + covariance.y_axis.y + covariance.z_axis.z;
    let thickness = if sheets { wall * wall / 12.0 } else { 0.0 };
    Body {
        mass,
        centre: material.centre() + about,
        covariance: floored(covariance, thickness.max(ROUNDNESS * trace)),
        volume: space,
        least,
    }
}

fn closed_bodies(surface: &Surface, about: DVec3) -> Vec<Closed> {
    let mut body_of = vec![usize::MAX; surface.patches.len()];
    let mut bodies: Vec<Closed> = Vec::new();
    for (p, patch) in surface.patches.iter().enumerate() {
        if patch.volume.is_some() && patch.hollows.is_none() {
            body_of[p] = bodies.len();
            bodies.push(measured(surface, &patch.faces, about));
        }
    }
    for patch in &surface.patches {
        let host = patch.hollows.and_then(|h| body_of.get(h)).and_then(|&b| bodies.get_mut(b));
        if let Some(body) = host {
            let cavity = measured(surface, &patch.faces, about);
            body.volume = body.volume + cavity.volume;
            body.sheet = body.sheet + cavity.sheet;
        }
    }
    bodies
}

fn measured(surface: &Surface, faces: &[u32], about: DVec3) -> Closed {
    let corners = || faces.iter().map(|&f| surface.mesh.corners(f as usize).map(|p| p - about));
    Closed {
        volume: corners().map(Moments::cone).sum(),
        sheet: corners().map(Moments::sheet).sum(),
        bounds: Bounds::of(corners().flatten()),
    }
}

/// Area of the open patches; a face and its reverse are one sheet.
fn open_sheet(surface: &Surface, about: DVec3) -> Moments {
    let open = surface.patches.iter().filter(|p| p.volume.is_none());
    let faces: Vec<[DVec3; 3]> =
        open.flat_map(|p| &p.faces).map(|&f| surface.mesh.corners(f as usize)).collect();
    let key = |corners: &[DVec3; 3]| {
        let mut bits = corners.map(|c| c.to_array().map(f64::to_bits));
        bits.sort_unstable();
        bits
    };
    let mut sides = BTreeMap::new();
    faces.iter().for_each(|f| *sides.entry(key(f)).or_insert(0_u32) += 1);
    let share = |f: &[DVec3; 3]| 1.0 / f64::from(sides.get(&key(f)).copied().unwrap_or(1));
    faces.iter().map(|f| Moments::sheet(f.map(|p| p - about)) * share(f)).sum()
}

/// What the bodies' sum counts more than once; nothing unless their boxes meet.
fn counted_twice(surface: &Surface, bodies: &[Closed], about: DVec3) -> Moments {
    let meets =
        |(i, b): (usize, &Closed)| bodies[..i].iter().any(|a| a.bounds.intersects(&b.bounds));
    if !bodies.iter().enumerate().any(meets) {
        return Moments::ZERO;
    }
    let closed = surface.patches.iter().filter(|p| p.volume.is_some());
    let faces = closed.flat_map(|p| &p.faces);
    let corners = |&f: &u32| surface.mesh.corners(f as usize).map(|p| p - about);
    overlap(&faces.map(corners).collect::<Vec<_>>())
}

fn is_hollow(body: &Closed, wall: f64) -> bool {
    body.volume.measure > body.sheet.measure * wall
}

/// Material of the closed bodies, m³, and how it was found.
fn closed_material(bodies: &[Closed], twice: &Moments, wall: f64) -> (Moments, String) {
    let part = |b: &Closed| if is_hollow(b, wall) { b.sheet * wall } else { b.volume };
    let sum: Moments = bodies.iter().map(part).sum();
    let hollow = bodies.iter().filter(|b| is_hollow(b, wall)).count();
    let solid = bodies.len() - hollow;
    let shape = format!("{solid} solid and {hollow} hollow bodies");
    let total: f64 = bodies.iter().map(|b| b.volume.measure).sum();
    let kept = if total > 0.0 { (1.0 - twice.measure / total).clamp(0.02, 1.0) } else { 1.0 };
    let corrected = sum - *twice;
    if hollow == 0 && corrected.measure > 0.1 * sum.measure {
        return (corrected, shape);
    }
    (sum * kept, shape)
}

/// Material of the open patches, m³: sheets of the usual wall, but no more than the part has room
/// for beside its closed bodies.
fn open_material(open: &Moments, closed: f64, space: f64, wall: f64) -> Moments {
    let sheet = *open * wall;
    let room = (space - closed).max(0.05 * sheet.measure);
    if space > 0.0 && sheet.measure > room { sheet * (room / sheet.measure) } else { sheet }
}

/// The material, or the bare surface if nothing else has a measure.
fn usable(material: Moments, surface: &Surface, about: DVec3) -> Moments {
    let sound = material.measure > 0.0 && material.covariance().is_finite();
    if sound && material.covariance().determinant() >= 0.0 {
        return material;
    }
    let faces = 0..surface.mesh.faces().len();
    faces.map(|f| Moments::sheet(surface.mesh.corners(f).map(|p| p - about))).sum::<Moments>()
        * 1e-3
}

/// The space, m³, that the closed bodies of a surface fill; none unless it is mostly closed.
pub(crate) fn enclosed(surface: &Surface) -> Option<f64> {
    let about = surface.mesh.bounds().centre();
    let bodies = closed_bodies(surface, about);
    let open = open_sheet(surface, about);
    let twice = counted_twice(surface, &bodies, about).measure;
    let (sum, share) = closed_share(&bodies, &open);
    (share >= MOSTLY_CLOSED && sum > twice).then_some(sum - twice)
}

/// What closed bodies fill one by one, m³, and their share of the area.
fn closed_share(bodies: &[Closed], open: &Moments) -> (f64, f64) {
    let sum: f64 = bodies.iter().map(|b| b.volume.measure).sum();
    let closed: f64 = bodies.iter().map(|b| b.sheet.measure).sum();
    (sum, (closed / (closed + open.measure)).abs())
}

/// The space a part fills.
fn filled(bodies: &[Closed], open: &Moments, twice: f64, pieces: &[ConvexPiece]) -> Sourced<f64> {
    let (sum, share) = closed_share(bodies, open);
    let held = held(pieces);
    if share >= MOSTLY_CLOSED || held <= 0.0 {
        let how = format!("union of {} closed bodies", bodies.len());
        return Sourced::new((sum - twice).max(0.0), Origin::Measured, how);
    }
    let how = format!("collision pieces; the surface is closed to {:.0} %", share * 100.0);
    Sourced::new(held.max(sum - twice), Origin::Measured, how)
}

/// Stated mass, or density times material within the bounds of [`DENSITY`].
fn mass_of(material: f64, least: f64, of: &Substance, shape: &str) -> Sourced<f64> {
    if let Some(stated) = &of.mass {
        return stated.clone();
    }
    let density = of.density.value;
    let raw = density * material;
    // A sliver is not made denser than any likely material to come up to a weight.
    let lightest = if material > 0.0 { LIGHTEST.min(DENSITY[1] * material) } else { LIGHTEST };
    let mass = raw.max(least).max(lightest);
    let mut how = format!(
        "{} kg/m3 ({}) x {:.3e} m3 of material: {shape}, wall {:.1} mm",
        density,
        of.material.value,
        material,
        of.wall.value * 1e3
    );
    if mass > raw {
        let bound = match mass {
            m if m == least => "102 kg per m3 of space",
            m if m == LIGHTEST => "0.0001 kg",
            _ => "7900 kg per m3 of material",
        };
        how.push_str(&format!("; raised from {raw:.3e} kg to {bound}"));
    }
    Sourced::new(mass, of.density.origin, how)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mass::moments::inertia_of;
    use crate::surface::repair::repair;
    use crate::tests::{block, joined};
    use object::Mesh;

    fn of(density: f64, wall: f64) -> Substance {
        let number = |v| Sourced::new(v, Origin::User, "test");
        Substance {
            material: Sourced::new("stuff".into(), Origin::User, "test"),
            density: number(density),
            wall: number(wall),
            friction: number(0.5),
            mass: None,
        }
    }

    fn body(mesh: &Mesh, pieces: &[ConvexPiece], substance: &Substance) -> Body {
        weigh(&repair(mesh, None).unwrap(), pieces, substance)
    }

    #[test]
    fn a_solid_cube_weighs_its_volume() {
        let cube = block(DVec3::ONE, DVec3::new(3.0, -2.0, 0.5));
        let b = body(&cube, &[], &of(700.0, 0.5));
        assert!((b.mass.value - 700.0).abs() < 1e-9);
        assert!((b.centre - DVec3::new(3.0, -2.0, 0.5)).length() < 1e-12);
        let inertia = inertia_of(b.covariance, b.mass.value);
        assert!((inertia.x_axis.x - 700.0 / 6.0).abs() < 1e-9);
    }

    #[test]
    fn a_hollow_cube_weighs_its_walls_but_no_less_than_an_empty_appliance() {
        let cube = block(DVec3::ONE, DVec3::ZERO);
        let b = body(&cube, &[], &of(7850.0, 3e-3));
        assert!((b.mass.value - 7850.0 * 6.0 * 3e-3).abs() < 1e-9);
        assert!((b.covariance.x_axis.x - 5.0 / 36.0).abs() < 1e-12, "a shell's covariance");
        let thin = body(&cube, &[], &of(7850.0, 1e-3));
        assert!((thin.mass.value - 102.0).abs() < 1e-9);
        assert!(thin.mass.how.contains("raised"));
    }

    #[test]
    fn bodies_that_overlap_are_not_counted_twice() {
        let (a, b) = (block(DVec3::ONE, DVec3::ZERO), block(DVec3::ONE, DVec3::X * 0.5));
        let b = body(&joined(&[a, b]), &[], &of(100.0, 1.0));
        assert!((b.mass.value / 150.0 - 1.0).abs() < 0.01, "{}", b.mass.value);
        assert!((b.centre.x - 0.25).abs() < 0.01);
    }

    #[test]
    fn an_open_sheet_weighs_its_wall_once_even_if_it_has_two_sides() {
        let corners = vec![DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
        let one = vec![[0, 1, 2], [0, 2, 3]];
        let two = [one.clone(), vec![[2, 1, 0], [3, 2, 0]]].concat();
        for faces in [one, two] {
            let sheet = Mesh::new(corners.clone(), faces).unwrap();
            let b = body(&sheet, &[], &of(1000.0, 2e-3));
            assert!((b.mass.value - 2.0).abs() < 1e-12, "{}", b.mass.value);
            let i = inertia_of(b.covariance, b.mass.value);
            assert!(i.x_axis.x + i.y_axis.y > i.z_axis.z);
        }
    }

    #[test]
    fn a_sliver_is_raised_no_further_than_a_dense_material_weighs() {
        let sliver = body(&block(DVec3::splat(1e-3), DVec3::ZERO), &[], &of(1000.0, 0.5));
        assert!((sliver.mass.value - 7.9e-6).abs() < 1e-12, "{}", sliver.mass.value);
        assert!(sliver.mass.how.ends_with("to 7900 kg per m3 of material"));
        let small = body(&block(DVec3::splat(4e-3), DVec3::ZERO), &[], &of(1000.0, 0.5));
        assert_eq!(small.mass.value, LIGHTEST);
    }

    #[test]
    fn a_stated_mass_wins() {
        let mut substance = of(1000.0, 1e-3);
        substance.mass = Some(Sourced::new(12.5, Origin::User, "condition"));
        let b = body(&block(DVec3::ONE, DVec3::ZERO), &[], &substance);
        assert_eq!(b.mass.value, 12.5);
    }

    #[test]
    fn an_open_surface_weighs_no_more_than_its_pieces_hold() {
        let block = block(DVec3::splat(0.02), DVec3::ZERO);
        let piece =
            ConvexPiece { vertices: block.vertices().to_vec(), faces: block.faces().to_vec() };
        let open = block.submesh(2..12).unwrap();
        let b = body(&open, &[piece], &of(1000.0, 0.01));
        assert!((b.mass.value - 1000.0 * 8e-6).abs() < 1e-12, "{}", b.mass.value);
        assert!(b.volume.how.contains("collision pieces"));
    }
}
