//! Geodesic watershed on the face graph: every face goes to the prompt it is cheapest to reach.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use object::Mesh;
use object::weld::Neighbour;

/// Faces as nodes, shared edges as links: for each face its neighbours and the cost to get there.
pub struct FaceGraph {
    /// For each face, (neighbour, index into `edges`).
    pub around: Vec<Vec<(u32, u32)>>,
    /// Links in the order of [`object::weld::Weld::neighbours`].
    pub edges: Vec<Neighbour>,
}

impl FaceGraph {
    /// The face graph of a welded mesh.
    pub fn new(faces: usize, edges: Vec<Neighbour>) -> Self {
        let mut around = vec![Vec::new(); faces];
        for (i, e) in edges.iter().enumerate() {
            around[e.first as usize].push((e.second, i as u32));
            around[e.second as usize].push((e.first, i as u32));
        }
        Self { around, edges }
    }
}

/// Cost to pass an edge: length between the centroids plus a share of the diagonal for the turn.
pub fn turn_cost(mesh: &Mesh, e: &Neighbour, diagonal: f64) -> f64 {
    let (f, g) = (e.first as usize, e.second as usize);
    let (cf, cg) = (mesh.centroid(f), mesh.centroid(g));
    let (nf, ng) = (mesh.normal(f), mesh.normal(g));
    let turn = 1.0 - nf.dot(ng);
    let concave = (cg - cf).dot(nf) > (cg - cf).dot(ng);
    (cg - cf).length() / diagonal + 100.0 * turn * if concave { 1.0 } else { 0.1 }
}

/// Labels spread from the seeds over the edges at the given costs; faces no seed reaches stay `None`.
pub fn flood(graph: &FaceGraph, cost: &[f64], seeds: &[(u32, u16)]) -> Vec<Option<u16>> {
    let mut best = vec![f64::INFINITY; graph.around.len()];
    let mut label = vec![None; graph.around.len()];
    let mut heap = BinaryHeap::new();
    for &(face, part) in seeds {
        best[face as usize] = 0.0;
        heap.push(Reverse((Key(0.0), face, part)));
    }
    while let Some(Reverse((Key(d), face, part))) = heap.pop() {
        if label[face as usize].is_some() {
            continue;
        }
        label[face as usize] = Some(part);
        for &(next, edge) in &graph.around[face as usize] {
            let there = d + cost[edge as usize];
            if there < best[next as usize] {
                best[next as usize] = there;
                heap.push(Reverse((Key(there), next, part)));
            }
        }
    }
    label
}

/// A finite cost in order.
#[derive(Clone, Copy, PartialEq)]
pub struct Key(pub f64);
impl Eq for Key {}
impl PartialOrd for Key {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Key {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}
