//! The surface cut into segments small enough to belong to one part each.

use std::collections::{BTreeMap, BTreeSet};

use object::mesh::Bounds;
use object::weld::{Neighbour, Weld};
use object::{DVec3, Mesh};

use crate::classic::segment::oversegment::flood::flood;
use crate::classic::segment::oversegment::patches::{Cutting, Seam, Turn, patches, seams, turn};
pub(crate) use crate::classic::segment::oversegment::segment::Segment;
use crate::classic::segment::prompts::seeds::Seed;

/// A surface in segments.
pub(crate) struct Cut {
    /// The segment of each face; segments are numbered in order of first face.
    pub of_face: Vec<u32>,
    /// The segments.
    pub segments: Vec<Segment>,
    /// What the borders between segments of one component look like.
    pub seams: BTreeMap<(u32, u32), Seam>,
}

/// Cuts the surface so that no segment holds two seeds. Components with at most one seed stay whole;
/// if the `root` has no seed, a component of more than half the surface is cut nevertheless, and
/// the largest segment without a seed is the root's.
pub(crate) fn cut(
    (mesh, weld): (&Mesh, &Weld),
    component: &[u32],
    (seeds, root): (&[Seed], u16),
    cutting: Cutting,
) -> Cut {
    let mixed = mixed_components(mesh, component, seeds, root);
    let inside = |e: &Neighbour| mixed[component[e.first as usize] as usize];
    let edges: Vec<Neighbour> = weld.neighbours().into_iter().filter(inside).collect();
    let diagonal = mesh.bounds().diagonal();
    let turns: Vec<Turn> = edges.iter().map(|e| turn(mesh, weld, e, diagonal)).collect();
    let (mut patch, count) = patches(&turns, &edges, component.len(), cutting);
    part_crowded(&mut patch, count, &turns, &edges, seeds);
    let key = |f: usize| {
        let c = component[f];
        if mixed[c as usize] { (true, patch[f]) } else { (false, c) }
    };
    let mut number = BTreeMap::new();
    let of_face = (0..component.len()).map(|f| {
        let next = number.len() as u32;
        *number.entry(key(f)).or_insert(next)
    });
    let of_face: Vec<u32> = of_face.collect();
    let mut segments = measure(mesh, &of_face, number.len());
    for s in seeds {
        segments[of_face[s.face as usize] as usize].seed = Some(s.part);
    }
    seed_root(&mut segments, root);
    let seams = seams(&turns, &edges, &of_face);
    Cut { of_face, segments, seams }
}

fn mixed_components(mesh: &Mesh, component: &[u32], seeds: &[Seed], root: u16) -> Vec<bool> {
    let count = component.iter().max().map_or(0, |m| *m as usize + 1);
    let (mut seeded, mut area) = (vec![0usize; count], vec![0.0; count]);
    for s in seeds {
        seeded[component[s.face as usize] as usize] += 1;
    }
    for (f, &c) in component.iter().enumerate() {
        area[c as usize] += mesh.area(f);
    }
    let half = area.iter().sum::<f64>() / 2.0;
    let lacks_root = seeds.iter().all(|s| s.part != root);
    (0..count).map(|c| seeded[c] > 1 || (lacks_root && seeded[c] == 1 && area[c] > half)).collect()
}

/// How much of the surface that tells of other parts than the base lies in components that are [`cut`], 0
/// to 1: components on which only the base has a prompt tell of none.
pub(crate) fn fused(mesh: &Mesh, component: &[u32], (seeds, root): (&[Seed], u16)) -> f64 {
    let mixed = mixed_components(mesh, component, seeds, root);
    let held = |of_base: bool| -> BTreeSet<u32> {
        let seeds = seeds.iter().filter(|s| (s.part == root) == of_base);
        seeds.map(|s| component[s.face as usize]).collect()
    };
    let alone: BTreeSet<u32> = held(true).difference(&held(false)).copied().collect();
    let (mut cut, mut all) = (0.0, 0.0);
    for (face, &c) in component.iter().enumerate().filter(|(_, c)| !alone.contains(c)) {
        let area = mesh.area(face);
        all += area;
        cut += if mixed[c as usize] { area } else { 0.0 };
    }
    cut / all.max(f64::MIN_POSITIVE)
}

/// Splits every patch that holds several seeds between them, by geodesic watershed.
fn part_crowded(
    patch: &mut [u32],
    count: usize,
    turns: &[Turn],
    edges: &[Neighbour],
    seeds: &[Seed],
) {
    let mut held: BTreeMap<u32, Vec<Seed>> = BTreeMap::new();
    for s in seeds {
        held.entry(patch[s.face as usize]).or_default().push(*s);
    }
    let crowded: Vec<Seed> = held.into_values().filter(|s| s.len() > 1).flatten().collect();
    let within = |e: &Neighbour| patch[e.first as usize] == patch[e.second as usize];
    let ways: Vec<(u32, u32, f64)> = edges
        .iter()
        .zip(turns)
        .filter(|(e, _)| within(e))
        .map(|(e, t)| (e.first, e.second, t.effort))
        .collect();
    let starts: Vec<u32> = crowded.iter().map(|s| s.face).collect();
    for (face, start) in flood(patch.len(), &ways, &starts).into_iter().enumerate() {
        if let Some(start) = start {
            patch[face] = (count + start) as u32;
        }
    }
}

fn measure(mesh: &Mesh, of_face: &[u32], count: usize) -> Vec<Segment> {
    let (bounds, zero) = (Bounds::of([]), DVec3::ZERO);
    let empty = Segment { seed: None, share: 0.0, area: 0.0, centre: zero, bounds, normal: zero };
    let mut segments = vec![empty; count];
    for (face, &p) in of_face.iter().enumerate() {
        let (segment, area) = (&mut segments[p as usize], mesh.area(face));
        segment.area += area;
        segment.centre += mesh.centroid(face) * area;
        segment.normal += mesh.normal(face) * area;
        let b = Bounds::of(mesh.corners(face));
        segment.bounds =
            Bounds { min: segment.bounds.min.min(b.min), max: segment.bounds.max.max(b.max) };
    }
    let total: f64 = segments.iter().map(|p| p.area).sum();
    for p in &mut segments {
        p.share = p.area / total.max(f64::MIN_POSITIVE);
        p.normal /= p.area.max(f64::MIN_POSITIVE);
        p.centre = if p.area > 0.0 { p.centre / p.area } else { p.bounds.centre() };
    }
    segments
}

fn seed_root(segments: &mut [Segment], root: u16) {
    if segments.iter().any(|p| p.seed == Some(root)) {
        return;
    }
    let free = segments.iter_mut().filter(|p| p.seed.is_none());
    let larger = |a: &Segment, b: &Segment| a.area >= b.area;
    let largest = free.reduce(|a, b| if larger(a, b) { a } else { b });
    if let Some(segment) = largest {
        segment.seed = Some(root);
    }
}
