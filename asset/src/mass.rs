//! What a part weighs and how its mass is spread: exact over closed surfaces, as a wall where a body
//! must be hollow, as a sheet where the surface is open.
//!
//! Densities are those of solid material while most bodies are hollow. Therefore a closed body
//! counts with the smaller of its volume and its area times the usual wall of its material.

use glamx::{DMat3, DVec3};
use object::mesh::Bounds;
use object::{Origin, Sourced};

use crate::columns::overlap;
use crate::hulls::ConvexPiece;
use crate::materials::Substance;
use crate::moments::{Moments, floored};
use crate::repair::Surface;

/// No link is lighter, kg.
pub const LIGHTEST: f64 = 1e-4;
/// A part whose surface is closed to this share of its area has a volume of its own.
const MOSTLY_CLOSED: f64 = 0.9;
/// Emptiest and densest a part may be, kg per m³ of the space it fills, unless stated.
pub const DENSITY: [f64; 2] = [100.0, 8000.0];
/// Smallest covariance as a share of its trace: the margin of the triangle inequality.
const ROUNDNESS: f64 = 1e-6;

/// A part's mass, before any adjustment between parts.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Mass, kg.
    pub mass: Sourced<f64>,
    /// Centre of mass, in the frame of the surface, metres.
    pub centre: DVec3,
    /// Covariance of the mass about its centre, m²; inertia follows by [`crate::moments::inertia_of`].
    pub covariance: DMat3,
    /// Space the part fills, m³: its closed bodies' union, or its collision pieces.
    pub volume: Sourced<f64>,
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
    let open = open_material(&open, &bodies, pieces, wall);
    let material = usable(closed + open, surface, about);
    let sheets = bodies.iter().any(|b| is_hollow(b, wall)) || open.measure > 0.0;
    let mass = mass_of(material.measure, &space, substance, &shape);
    let covariance = material.covariance();
    let trace = covariance.x_axis.x + covariance.y_axis.y + covariance.z_axis.z;
    let thickness = if sheets { wall * wall / 12.0 } else { 0.0 };
    Body {
        mass,
        centre: material.centre() + about,
        covariance: floored(covariance, thickness.max(ROUNDNESS * trace)),
        volume: space,
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

fn open_sheet(surface: &Surface, about: DVec3) -> Moments {
    let open = surface.patches.iter().filter(|p| p.volume.is_none());
    open.map(|p| measured(surface, &p.faces, about).sheet).sum()
}

/// What the bodies' sum counts more than once; nothing unless their boxes meet.
fn counted_twice(surface: &Surface, bodies: &[Closed], about: DVec3) -> Moments {
    let meets = |(i, b): (usize, &Closed)| bodies[..i].iter().any(|a| a.bounds.intersects(&b.bounds));
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

/// Material of the open patches, m³: sheets of the usual wall, but no more than their pieces hold.
fn open_material(open: &Moments, bodies: &[Closed], pieces: &[ConvexPiece], wall: f64) -> Moments {
    let closed: f64 = bodies.iter().map(|b| b.sheet.measure).sum();
    let sheet = *open * wall;
    let held = held(pieces);
    if open.measure > closed && held > 0.0 && sheet.measure > held {
        return sheet * (held / sheet.measure);
    }
    sheet
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

/// The space a part fills.
fn filled(bodies: &[Closed], open: &Moments, twice: f64, pieces: &[ConvexPiece]) -> Sourced<f64> {
    let sum: f64 = bodies.iter().map(|b| b.volume.measure).sum();
    let closed: f64 = bodies.iter().map(|b| b.sheet.measure).sum();
    let share = (closed / (closed + open.measure)).abs();
    let held = held(pieces);
    if share >= MOSTLY_CLOSED || held <= 0.0 {
        let how = format!("union of {} closed bodies", bodies.len());
        return Sourced::new((sum - twice).max(0.0), Origin::Measured, how);
    }
    let how = format!("collision pieces; the surface is closed to {:.0} %", share * 100.0);
    Sourced::new(held.max(sum - twice), Origin::Measured, how)
}

/// Volume of convex pieces, m³.
fn held(pieces: &[ConvexPiece]) -> f64 {
    let volume = |p: &ConvexPiece| -> f64 {
        let corner = |v: u32| p.vertices.get(v as usize).copied().unwrap_or(DVec3::ZERO);
        p.faces.iter().map(|f| Moments::cone(f.map(corner)).measure).sum()
    };
    pieces.iter().map(volume).sum()
}

/// Stated mass, or density times material within the bounds of [`DENSITY`].
fn mass_of(material: f64, space: &Sourced<f64>, of: &Substance, shape: &str) -> Sourced<f64> {
    if let Some(stated) = &of.mass {
        return stated.clone();
    }
    let density = of.density.value;
    let raw = density * material;
    let least = DENSITY[0].min(density) * space.value;
    let mass = raw.max(least).max(LIGHTEST);
    let mut how = format!(
        "{} kg/m3 ({}) x {:.3e} m3 of material: {shape}, wall {:.1} mm",
        density,
        of.material.value,
        material,
        of.wall.value * 1e3
    );
    if mass > raw {
        let bound = if least > LIGHTEST { "100 kg per m3 of space" } else { "0.0001 kg" };
        how.push_str(&format!("; raised from {raw:.3e} kg to {bound}"));
    }
    Sourced::new(mass, of.density.origin, how)
}
