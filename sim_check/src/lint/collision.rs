//! Collision pieces: convex, closed, outward, thick enough, simple (G2).

use glamx::DVec3;

use super::part::{Hull, Part, Parts, Piece};
use super::surface::Topology;
use super::{Finding, judged, mm};
use crate::robot::Geometry;
use crate::verdict::Check;

/// How far a piece may dent below its hull: share of its own diagonal, and least in metres.
const DENT: (f64, f64) = (1e-3, 1e-4);
/// Thinnest extent: the smaller of metres and share of the asset's diagonal.
const THIN: (f64, f64) = (1e-3, 2e-3);
/// Most vertices of a piece after welding.
const VERTICES: usize = 64;
/// Most pieces of a link.
const PIECES: usize = 32;

/// G2.
pub(super) fn sound_pieces(parts: &Parts) -> Check {
    if parts.parts.iter().all(|p| p.pieces.is_empty()) {
        return Check::unknown("G2", "no link has collision geometry");
    }
    let least = THIN.0.min(THIN.1 * parts.diagonal);
    let (mut findings, mut unread) = (Vec::new(), Vec::new());
    for part in &parts.parts {
        let count = part.pieces.len();
        findings.push(finding(part, count as f64, PIECES as f64, format!("{count} pieces")));
        for piece in &part.pieces {
            match &piece.surface.body {
                Err(reason) if matches!(piece.surface.shape.geometry, Geometry::Unread { .. }) => {
                    unread.push(format!("link `{}`: {reason}", part.link.name));
                }
                Err(reason) => {
                    let words = format!("{}: {reason}", piece.surface.label());
                    findings.push(finding(part, 2.0, 1.0, words));
                }
                Ok(body) => findings.extend(look_at(part, piece, &body.1, least)),
            }
        }
    }
    judged("G2", findings, unread)
}

fn finding(part: &Part, value: f64, bound: f64, words: String) -> Finding {
    let words = format!("link `{}`: {words}", part.link.name);
    Finding { severity: value / bound, value, words }
}

fn look_at(part: &Part, piece: &Piece, topology: &Topology, least: f64) -> Vec<Finding> {
    let name = piece.surface.label();
    let mut findings = Vec::new();
    let mut fault = |value: f64, words: String| {
        findings.push(finding(part, value, 1.0, format!("{name} {words}")))
    };
    if matches!(piece.surface.shape.geometry, Geometry::Mesh(_)) {
        let count = topology.places.len();
        fault(count as f64 / VERTICES as f64, format!("has {count} vertices"));
        let volume = topology.volume();
        if topology.open_edges > 0 {
            fault(2.0, format!("is open along {} edges", topology.open_edges));
        } else if !topology.is_closed() {
            fault(2.0, format!("is not closed: {} edges clash", topology.clashing_edges));
        } else if volume <= 0.0 {
            fault(2.0, format!("faces inward: volume {volume:.3e} m³"));
        }
    }
    match &piece.hull {
        Err(reason) => fault(2.0, format!("is no solid: {reason}")),
        Ok(hull) => {
            let thickness = hull.thickness();
            fault(least * (1.0 - 1e-6) / thickness, format!("is {} thin", mm(thickness)));
            let (dent, bound) = (deepest_dent(piece, hull), DENT.0 * hull.bounds.diagonal());
            let words = format!("is not convex: {} below its hull", mm(dent));
            fault(dent / bound.max(DENT.1.min(least / 10.0)), words);
        }
    }
    findings
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
