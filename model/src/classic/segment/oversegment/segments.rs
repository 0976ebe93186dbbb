//! The surface cut into segments small enough to belong to one part each.

use std::collections::{BTreeMap, BTreeSet};

use object::DVec3;
use object::mesh::Bounds;
use object::weld::Neighbour;

use crate::classic::segment::oversegment::contact::Body;
use crate::classic::segment::oversegment::flood::flood;
use crate::classic::segment::oversegment::patches::{Cutting, Seam, seams};
pub(crate) use crate::classic::segment::oversegment::segment::Segment;
use crate::classic::segment::prompts::seeds::Seed;
use crate::classic::segment::skin::{Numbering, Skin};

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
pub(crate) fn cut(skin: &Skin, (seeds, root): (&[Seed], u16), cutting: Cutting) -> Cut {
    let (component, faces) = (&skin.component, skin.component.len());
    let mixed = mixed_components(skin, seeds, root);
    let mut patch: Vec<u32> = (0..faces as u32).collect();
    for (c, body) in skin.bodies.iter().enumerate().filter(|(c, _)| mixed[*c]) {
        let patches = body.faces.iter().zip(skin.patches(c, cutting));
        patches.for_each(|(face, first)| patch[*face as usize] = *first);
    }
    part_crowded(skin, &mut patch, seeds);
    // What was parted has numbers from that of the faces on, at most one for each seed.
    let beyond = faces + seeds.len();
    let key = |f: usize| {
        let c = component[f] as usize;
        if mixed[c] { patch[f] as usize } else { beyond + c }
    };
    let mut number = Numbering::below(beyond + skin.bodies.len());
    let of_face: Vec<u32> = (0..faces).map(|f| number.of(key(f))).collect();
    let mut segments = measure(skin, &of_face, number.count());
    for s in seeds {
        segments[of_face[s.face as usize] as usize].seed = Some(s.part);
    }
    seed_root(&mut segments, root);
    let edges = (0..skin.bodies.len()).filter(|c| mixed[*c]).map(|c| skin.edges_of(c));
    let borders = |e: &Neighbour| of_face[e.first as usize] != of_face[e.second as usize];
    let mut edges: Vec<u32> =
        edges.flatten().copied().filter(|i| borders(&skin.edges[*i as usize])).collect();
    edges.sort_unstable();
    let seams = seams(edges.iter().map(|&i| skin.edge(i)), &of_face);
    Cut { of_face, segments, seams }
}

fn mixed_components(skin: &Skin, seeds: &[Seed], root: u16) -> Vec<bool> {
    let mut seeded = vec![0_usize; skin.bodies.len()];
    for s in seeds {
        seeded[skin.component[s.face as usize] as usize] += 1;
    }
    let half = skin.bodies.iter().map(|body| body.area).sum::<f64>() / 2.0;
    let lacks_root = seeds.iter().all(|s| s.part != root);
    let is_mixed = |(body, &seeded): (&Body, &usize)| {
        seeded > 1 || (lacks_root && seeded == 1 && body.area > half)
    };
    skin.bodies.iter().zip(&seeded).map(is_mixed).collect()
}

/// How much of the surface that tells of other parts than the base lies in components that are [`cut`], 0
/// to 1: components on which only the base has a prompt tell of none.
pub(crate) fn fused(skin: &Skin, (seeds, root): (&[Seed], u16)) -> f64 {
    let mixed = mixed_components(skin, seeds, root);
    let held = |of_base: bool| -> BTreeSet<u32> {
        let seeds = seeds.iter().filter(|s| (s.part == root) == of_base);
        seeds.map(|s| skin.component[s.face as usize]).collect()
    };
    let mut alone = vec![false; skin.bodies.len()];
    held(true).difference(&held(false)).for_each(|&c| alone[c as usize] = true);
    let (mut cut, mut all) = (0.0, 0.0);
    for (mass, &c) in skin.masses.iter().zip(&skin.component).filter(|(_, c)| !alone[**c as usize])
    {
        all += mass.area;
        cut += if mixed[c as usize] { mass.area } else { 0.0 };
    }
    cut / all.max(f64::MIN_POSITIVE)
}

/// Splits every patch that holds several seeds between them, by geodesic watershed.
fn part_crowded(skin: &Skin, patch: &mut [u32], seeds: &[Seed]) {
    let mut held: BTreeMap<u32, Vec<Seed>> = BTreeMap::new();
    for s in seeds {
        held.entry(patch[s.face as usize]).or_default().push(*s);
    }
    held.retain(|_, seeds| seeds.len() > 1);
    let count = patch.len();
    let mut before = 0;
    for (crowded, seeds) in held {
        let component = skin.component[seeds[0].face as usize] as usize;
        let faces = skin.bodies[component].faces.iter().copied();
        let faces: Vec<u32> = faces.filter(|face| patch[*face as usize] == crowded).collect();
        let local = |face: u32| faces.partition_point(|f| *f < face) as u32;
        let all = skin.edges_of(component).iter().map(|&i| skin.edge(i));
        let within = all.filter(|(e, _)| {
            patch[e.first as usize] == crowded && patch[e.second as usize] == crowded
        });
        let ways: Vec<(u32, u32, f64)> =
            within.map(|(e, t)| (local(e.first), local(e.second), t.effort)).collect();
        let starts: Vec<u32> = seeds.iter().map(|s| local(s.face)).collect();
        for (face, start) in faces.iter().zip(flood(faces.len(), &ways, &starts)) {
            if let Some(start) = start {
                patch[*face as usize] = (count + before + start) as u32;
            }
        }
        before += seeds.len();
    }
}

fn measure(skin: &Skin, of_face: &[u32], count: usize) -> Vec<Segment> {
    let (bounds, zero) = (Bounds::of([]), DVec3::ZERO);
    let empty = Segment { seed: None, share: 0.0, area: 0.0, centre: zero, bounds, normal: zero };
    let mut segments = vec![empty; count];
    for ((mass, normal), &p) in skin.masses.iter().zip(&skin.normals).zip(of_face) {
        let segment = &mut segments[p as usize];
        segment.area += mass.area;
        segment.centre += mass.first;
        segment.normal += *normal;
        let b = &mass.bounds;
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
