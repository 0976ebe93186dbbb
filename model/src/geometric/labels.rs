//! Which part each face belongs to, from the prompts and the shape alone.

pub mod contact;
pub mod flood;
pub mod lexicon;
pub mod merge;
pub mod patches;

use std::collections::BTreeMap;

use object::weld::{Neighbour, Weld, nearest_face};
use object::{Condition, Mesh};

use crate::articulate::Note;
use contact::Touch;
use lexicon::knob;
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
    let edges = weld.neighbours();
    let cut = Cut::new(mesh, weld, &edges, &component, bodies.len(), &seeds);
    let (piece_of_face, seed_of_piece) = (cut.piece_of_face, cut.seed_of_piece);
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
    let mut links = links(&touches, &area, &extent, total, diagonal);
    links.extend(cut.seams);
    let root = condition.tree.root() as u16;
    let priors: Vec<_> = (0..condition.tree.len())
        .map(|p| lexicon::size_prior(condition.text(p), p == condition.tree.root()))
        .collect();
    let share: Vec<f64> = area.iter().map(|a| a / total).collect();
    let part = merge::label(&seed_of_piece, &share, &priors, &links);
    let part_of_face: Vec<u16> =
        piece_of_face.iter().map(|&p| part[p as usize].unwrap_or(root)).collect();
    Labels { part_of_face, notes: vec![] }
}

pub fn seed_faces(mesh: &Mesh, condition: &Condition) -> Vec<(u32, u16)> {
    let face = |(part, p): (usize, &object::condition::Prompt)| {
        p.point.map(|x| (nearest_face(mesh, x).0 as u32, part as u16))
    };
    condition.prompts.iter().enumerate().filter_map(face).collect()
}

pub struct Cut {
    pub piece_of_face: Vec<u32>,
    pub seed_of_piece: Vec<Option<u16>>,
    pub seams: Vec<Link>,
}

impl Cut {
    pub fn new(mesh: &Mesh, weld: &Weld, edges: &[Neighbour], component: &[u32], count: usize, seeds: &[(u32, u16)]) -> Self {
        let mut seeds_in = vec![0; count];
        for &(f, _) in seeds { seeds_in[component[f as usize] as usize] += 1; }
        let diagonal = mesh.bounds().diagonal();
        let mixed = |f: u32| seeds_in[component[f as usize] as usize] > 1;
        let edges: Vec<Neighbour> = edges.iter().filter(|e| mixed(e.first)).copied().collect();
        let normals = patches::smooth_normals(mesh, &edges, 0);
        let turns: Vec<_> = edges.iter().map(|e| patches::turn(mesh, weld, &normals, e)).collect();
        let wide = patches::widened(mesh, &edges, &turns, knob("psteps", 0.0) as usize);
        let (mut patch, mut pieces) = patches::patches(&wide, &edges, component.len());
        let mut seeds_on: BTreeMap<u32, Vec<(u32, u16)>> = BTreeMap::new();
        for &(f, p) in seeds { if mixed(f) { seeds_on.entry(patch[f as usize]).or_default().push((f, p)); } }
        // patches with several seeds
        let graph = flood::FaceGraph::new(component.len(), edges.clone());
        let cost: Vec<f64> = edges.iter().map(|e| if patch[e.first as usize] == patch[e.second as usize] { flood::turn_cost(mesh, e, diagonal) } else { f64::INFINITY }).collect();
        let crowded: Vec<(u32, u16)> = seeds_on.values().filter(|s| s.len() > 1).flatten().copied().collect();
        let flooded = flood::flood(&graph, &cost, &crowded);
        let mut number: BTreeMap<u16, u32> = BTreeMap::new();
        for &(_, p) in &crowded { number.insert(p, pieces as u32); pieces += 1; }
        for (f, l) in flooded.iter().enumerate() { if let Some(l) = l { patch[f] = number[l]; } }
        // renumber
        let mut seen = BTreeMap::new();
        let piece_of_face: Vec<u32> = (0..component.len()).map(|f| {
            let key = if mixed(f as u32) { (1, patch[f]) } else { (0, component[f]) };
            let next = seen.len() as u32;
            *seen.entry(key).or_insert(next)
        }).collect();
        let mut seed_of_piece = vec![None; seen.len()];
        for &(f, p) in seeds { seed_of_piece[piece_of_face[f as usize] as usize] = Some(p); }
        let wide = patches::widened(mesh, &edges, &turns, knob("steps", 2.0) as usize);
        let seams = patches::seams(&wide, &edges, &piece_of_face);
        let seams = seams.iter().map(|(&(a, b), s)| Link { a, b, evidence: knob("s0", 4.0) - knob("s1", 8.0) * s.concave.min(1.0) - knob("s2", 0.0) * s.convex.min(1.0), weight: s.length / diagonal }).collect();
        Self { piece_of_face, seed_of_piece, seams }
    }
}

pub fn links(
    touches: &BTreeMap<(u32, u32), Touch>,
    area: &[f64],
    extent: &[f64],
    total: f64,
    diagonal: f64,
) -> Vec<Link> {
    let mut links = Vec::new();
    let none = Touch { touching: 0.0, inside: 0.0, reaching: 0.0, gap: f64::INFINITY };
    for (&(a, b), ab) in touches {
        if a > b && touches.contains_key(&(b, a)) {
            continue;
        }
        let ba = touches.get(&(b, a)).unwrap_or(&none);
        let (a, b, ab, ba) =
            if area[a as usize] <= area[b as usize] { (a, b, ab, ba) } else { (b, a, ba, ab) };
        let (small, large) = (area[a as usize], area[b as usize]);
        let inside = ab.inside / small;
        let any = if ab.inside + ba.inside > 0.0 { 1.0 } else { 0.0 };
        let twin = if (large - small).abs() < 0.01 * large { 1.0 } else { 0.0 };
        let gap = (ab.gap.min(ba.gap) / diagonal / contact::REACH).min(1.0);
        let evidence =
            1.269 * any - 0.671 * (small / total + 1e-6).log10() - 1.716 * ba.reaching / large
                + 0.664 * (ab.touching / small).sqrt()
                + 1.159 * twin
                + 0.449 * (extent[a as usize] / diagonal + 1e-4).log10()
                - 0.461 * gap
                + 2.406 * inside.sqrt()
                - 2.138 * inside
                - 0.887;
        links.push(Link { a, b, evidence, weight: 0.05 });
    }
    links
}
