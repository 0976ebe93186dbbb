//! Collision pieces: convex, closed, outward, thick enough, simple (G2).

use glamx::DVec3;

use super::finding::{Finding, judged, mm};
use super::part::{Hull, Part, Parts, Piece};
use super::surface::Topology;
use crate::profile::bounds::{DENT, PIECES, THIN, VERTICES};
use crate::robot::Geometry;
use crate::verdict::Check;

/// A dent this deep is none, metres, or a tenth of the thinnest piece where that is less.
const FLAT: f64 = 1e-4;

/// G2.
pub(super) fn sound_pieces(parts: &Parts) -> Check {
    if parts.parts.iter().all(|p| p.pieces.is_empty()) {
        return Check::unknown("G2", "no link has collision geometry");
    }
    let least = THIN.of(parts.diagonal);
    let (mut findings, mut unread) = (Vec::new(), Vec::new());
    for part in &parts.parts {
        let count = part.pieces.len();
        findings.push(Finding {
            severity: count as f64 / PIECES as f64,
            value: count as f64,
            unit: "pieces",
            words: format!("link `{}` has {count} pieces", part.link.name),
        });
        for piece in &part.pieces {
            match &piece.surface.body {
                Err(reason) if matches!(piece.surface.shape.geometry, Geometry::Unread { .. }) => {
                    unread.push(format!("link `{}`: {reason}", part.link.name));
                }
                Err(reason) => {
                    let (link, label) = (&part.link.name, piece.surface.label());
                    let words = format!("link `{link}`: {label}: {reason}");
                    findings.push(Finding { severity: 2.0, value: 0.0, unit: "m", words });
                }
                Ok(body) => findings.extend(look_at(part, piece, &body.1, least)),
            }
        }
    }
    judged("G2", findings, unread)
}

/// Collision shapes that are no shape at all, whatever the rest: a size that is not positive.
pub(super) fn broken(parts: &Parts) -> Vec<String> {
    let pieces = parts.parts.iter().flat_map(|p| p.pieces.iter().map(move |piece| (p, piece)));
    let told = |(part, piece): (&Part, &Piece)| {
        let is_unread = matches!(piece.surface.shape.geometry, Geometry::Unread { .. });
        let reason = piece.surface.body.as_ref().err().filter(|_| !is_unread)?;
        Some(format!("link `{}`: {}: {reason}", part.link.name, piece.surface.label()))
    };
    pieces.filter_map(told).collect()
}

fn look_at(part: &Part, piece: &Piece, topology: &Topology, least: f64) -> Vec<Finding> {
    let mut faults = Vec::new();
    if matches!(piece.surface.shape.geometry, Geometry::Mesh(_)) {
        let count = topology.places.len();
        let severity = count as f64 / VERTICES as f64;
        faults.push((severity, count as f64, "vertices", format!("has {count} vertices")));
        faults.extend(leak(topology));
    }
    match &piece.hull {
        Err(reason) => faults.push((2.0, 0.0, "m³", format!("is no solid: {reason}"))),
        Ok(hull) => {
            let thickness = hull.thickness();
            let severity = least * (1.0 - 1e-6) / thickness;
            faults.push((severity, thickness, "m", format!("is {} thin", mm(thickness))));
            let dent = deepest_dent(piece, hull);
            let bound = (DENT * hull.bounds.diagonal()).max(FLAT.min(least / 10.0));
            let words = format!("is not convex: {} below its hull", mm(dent));
            faults.push((dent / bound, dent, "m", words));
        }
    }
    let finding = |(severity, value, unit, words)| {
        let words = format!("link `{}`: {} {words}", part.link.name, piece.surface.label());
        Finding { severity, value, unit, words }
    };
    faults.into_iter().map(finding).collect()
}

type Fault = (f64, f64, &'static str, String);

/// Why the piece encloses no volume, if so.
fn leak(topology: &Topology) -> Option<Fault> {
    let volume = topology.volume();
    let (open, clashing) = (topology.open_edges, topology.clashing_edges);
    if open > 0 {
        Some((2.0, open as f64, "open edges", format!("is open along {open} edges")))
    } else if !topology.is_closed() {
        let words = format!("is not closed: {clashing} edges clash");
        Some((2.0, clashing as f64, "clashing edges", words))
    } else if volume <= 0.0 {
        Some((2.0, volume, "m³", format!("faces inward: volume {volume:.3e} m³")))
    } else {
        None
    }
}

/// How far the deepest vertex or face centre lies below the hull, metres.
fn deepest_dent(piece: &Piece, hull: &Hull) -> f64 {
    let Some(mesh) = piece.surface.mesh() else { return f64::INFINITY };
    let pose = piece.surface.shape.origin;
    let centres = (0..mesh.faces().len()).map(|f| mesh.centroid(f));
    let corners = mesh.faces().iter().flatten().map(|&v| mesh.vertices()[v as usize]);
    let points: Vec<DVec3> = centres.chain(corners).collect();
    let every = points.len().div_ceil(20_000);
    let looked_at = points.into_iter().step_by(every);
    looked_at.map(|p| hull.depth(pose.transform_point(p))).fold(0.0, f64::max)
}
