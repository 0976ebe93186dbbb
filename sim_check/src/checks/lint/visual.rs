//! Visual surfaces: degenerate faces, winding, closed volumes, face budget (G1).

use super::finding::{Finding, judged};
use super::part::{Part, Parts, Skin, Surface};
use super::surface::{Component, Topology};
use crate::profile::bounds::{CLASHING, DEGENERATE, FACES};
use crate::verdict::Check;

/// Components below this share of a surface's volume are not looked at for inversion.
const SMALL: f64 = 1e-3;
/// Most components of a surface looked at for inversion, the largest first.
const LOOKED_AT: usize = 64;

/// G1.
pub(super) fn sound_surfaces(parts: &Parts) -> Check {
    let surfaces = parts.parts.iter().flat_map(|p| p.visuals.iter().map(move |v| (p, v)));
    let mut findings = Vec::new();
    let (mut faces, mut unread) = (0, Vec::new());
    for (part, surface) in surfaces {
        match &surface.body {
            Ok(body) => {
                faces += body.0.faces().len();
                findings.extend(look_at(part, surface, &body.1, body.0.faces().len()));
            }
            Err(reason) => unread.push(format!("link `{}`: {reason}", part.link.name)),
        }
    }
    if faces == 0 && unread.is_empty() {
        return Check::unknown("G1", "no link has visual geometry");
    }
    findings.push(Finding {
        severity: faces as f64 / FACES as f64,
        value: faces as f64,
        unit: "faces",
        words: format!("all visuals together have {faces} faces"),
    });
    judged("G1", findings, unread)
}

fn look_at(part: &Part, surface: &Surface, topology: &Topology, faces: usize) -> Vec<Finding> {
    let place = format!("link `{}`, {}", part.link.name, surface.label());
    let share = |count: usize, of: usize, (bound, unit): (f64, &'static str), what: &str| {
        let value = count as f64 / (of as f64).max(1.0);
        let words = format!("{place}: {count} of {of} {what} ({:.2} %)", 100.0 * value);
        Finding { severity: value / bound, value, unit, words }
    };
    let degenerate =
        share(topology.degenerate, faces, (DEGENERATE, "of the faces"), "faces are degenerate");
    let clashing = share(
        topology.clashing_edges,
        topology.paired_edges,
        (CLASHING, "of the edges"),
        "edges are wound against each other",
    );
    let inverted = inverted_components(part, surface, topology).into_iter().map(|c| Finding {
        severity: 2.0,
        value: c.volume,
        unit: "m³",
        words: format!(
            "{place}: a closed surface near {} faces inward (volume {:.3e} m³)",
            c.anchor, c.volume
        ),
    });
    [degenerate, clashing].into_iter().chain(inverted).collect()
}

/// Closed components of negative volume that are no cavity of something around them.
fn inverted_components(part: &Part, surface: &Surface, topology: &Topology) -> Vec<Component> {
    let Some(skin) = &part.skin else { return vec![] };
    let volumes = topology.components.iter().map(|c| c.volume.abs());
    let small = SMALL * volumes.fold(0.0, f64::max);
    let mut suspects: Vec<usize> = (0..topology.components.len())
        .filter(|&i| {
            let c = topology.components[i];
            c.is_closed && !c.is_sheet() && -c.volume > small
        })
        .collect();
    suspects
        .sort_by(|a, b| topology.components[*a].volume.total_cmp(&topology.components[*b].volume));
    suspects.truncate(LOOKED_AT);
    suspects.retain(|&i| !is_cavity(i, surface, topology, skin));
    suspects.into_iter().map(|i| topology.components[i]).collect()
}

/// Whether there is matter around the component, as round a cavity.
fn is_cavity(component: usize, surface: &Surface, topology: &Topology, skin: &Skin) -> bool {
    let Some(mesh) = surface.mesh() else { return false };
    let place = |p| surface.shape.origin.transform_point(p);
    let around: Vec<f64> =
        topology.outside(mesh, component).map(|p| skin.winding.at(place(p))).collect();
    2 * around.iter().filter(|w| **w > 0.5).count() > around.len()
}
