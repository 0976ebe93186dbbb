//! Which part each face belongs to, from the prompts and the shape alone.

pub mod contact;
pub mod flood;
pub mod lexicon;
pub mod merge;

use std::collections::BTreeMap;

use object::weld::{Weld, nearest_face};
use object::{Condition, Mesh};

use crate::articulate::Note;
use contact::{Body, Touch};
use merge::Link;

/// A part for each face, and what was noticed on the way.
#[derive(Clone, Debug, PartialEq)]
pub struct Labels {
    /// For each face, the index of its part in the condition's tree.
    pub part_of_face: Vec<u16>,
    /// Losses and doubts, in order of part.
    pub notes: Vec<Note>,
}

/// Labels every face with a part of the condition's tree.
pub fn label_faces(mesh: &Mesh, condition: &Condition, weld: &Weld) -> Labels {
    let diagonal = mesh.bounds().diagonal();
    let seeds = seed_faces(mesh, condition);
    let (component, bodies) = contact::bodies(mesh, weld);
    let (piece_of_face, seed_of_piece) = pieces(mesh, weld, &component, &bodies, &seeds);
    let touches = contact::touches(&bodies, &piece_of_face, diagonal);
    let mut area = vec![0.0; seed_of_piece.len()];
    for (f, &p) in piece_of_face.iter().enumerate() {
        area[p as usize] += mesh.area(f);
    }
    let mut boxes = vec![object::mesh::Bounds::of([]); area.len()];
    for (f, &p) in piece_of_face.iter().enumerate() {
        let b = object::mesh::Bounds::of(mesh.corners(f));
        let x = &mut boxes[p as usize];
        *x = object::mesh::Bounds { min: x.min.min(b.min), max: x.max.max(b.max) };
    }
    let extent: Vec<f64> = boxes.iter().map(|b| b.size().max_element()).collect();
    let total: f64 = area.iter().sum();
    let links = links(&touches, &area, &extent, total, diagonal);
    let root = condition.tree.root() as u16;
    let priors: Vec<_> = (0..condition.tree.len()).map(|p| lexicon::size_prior(condition.text(p), p == condition.tree.root())).collect();
    let share: Vec<f64> = area.iter().map(|a| a / total).collect();
    let part = merge::merge(&seed_of_piece, &share, &links, &priors);
    let part_of_face: Vec<u16> = piece_of_face.iter().map(|&p| part[p as usize].unwrap_or(root)).collect();
    Labels { part_of_face, notes: vec![] }
}

fn seed_faces(mesh: &Mesh, condition: &Condition) -> Vec<(u32, u16)> {
    let face = |(part, p): (usize, &object::condition::Prompt)| {
        p.point.map(|x| (nearest_face(mesh, x).0 as u32, part as u16))
    };
    condition.prompts.iter().enumerate().filter_map(face).collect()
}

fn pieces(mesh: &Mesh, weld: &Weld, component: &[u32], bodies: &[Body], seeds: &[(u32, u16)]) -> (Vec<u32>, Vec<Option<u16>>) {
    let mut of_body: BTreeMap<u32, Vec<(u32, u16)>> = BTreeMap::new();
    for &(f, p) in seeds {
        of_body.entry(component[f as usize]).or_default().push((f, p));
    }
    let mut piece_of_face = component.to_vec();
    let mut seed: Vec<Option<u16>> = (0..bodies.len() as u32).map(|b| of_body.get(&b).map(|s| s[0].1)).collect();
    let diagonal = mesh.bounds().diagonal();
    let graph = flood::FaceGraph::new(component.len(), weld.neighbours());
    let cost: Vec<f64> = graph.edges.iter().map(|e| flood::turn_cost(mesh, e, diagonal)).collect();
    let flooded = flood::flood(&graph, &cost, seeds);
    for (&b, s) in of_body.iter().filter(|(_, s)| s.len() > 1) {
        let mut number: BTreeMap<u16, u32> = BTreeMap::new();
        for (i, &(_, part)) in s.iter().enumerate() {
            number.insert(part, if i == 0 { b } else { seed.push(Some(part)); seed.len() as u32 - 1 });
        }
        for &f in &bodies[b as usize].faces {
            if let Some(n) = flooded[f as usize].and_then(|p| number.get(&p)) { piece_of_face[f as usize] = *n; }
        }
    }
    (piece_of_face, seed)
}

pub fn links(touches: &BTreeMap<(u32, u32), Touch>, area: &[f64], extent: &[f64], total: f64, diagonal: f64) -> Vec<Link> {
    let mut links = Vec::new();
    let none = Touch { touching: 0.0, inside: 0.0, reaching: 0.0, gap: f64::INFINITY };
    for (&(a, b), ab) in touches {
        if a > b && touches.contains_key(&(b, a)) { continue; }
        let ba = touches.get(&(b, a)).unwrap_or(&none);
        let (a, b, ab, ba) = if area[a as usize] <= area[b as usize] { (a, b, ab, ba) } else { (b, a, ba, ab) };
        let (small, large) = (area[a as usize], area[b as usize]);
        let inside = ab.inside / small;
        let any = if ab.inside + ba.inside > 0.0 { 1.0 } else { 0.0 };
        let twin = if (large - small).abs() < 0.01 * large { 1.0 } else { 0.0 };
        let gap = (ab.gap.min(ba.gap) / diagonal / contact::REACH).min(1.0);
        let evidence = 1.269 * any - 0.671 * (small / total + 1e-6).log10() - 1.716 * ba.reaching / large
            + 0.664 * (ab.touching / small).sqrt() + 1.159 * twin + 0.449 * (extent[a as usize] / diagonal + 1e-4).log10()
            - 0.461 * gap + 2.406 * inside.sqrt() - 2.138 * inside - 0.887;
        links.push(Link { a, b, evidence, weight: 1.0 });
    }
    links
}
