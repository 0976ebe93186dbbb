//! A surface before anything is said of it: what its components, faces and edges are like, and how it may
//! fall into patches. It is found once; whatever a condition says, labels start from here.

use std::sync::OnceLock;

use object::weld::{Neighbour, Weld};
use object::{DVec3, Mesh};

use crate::classic::segment::oversegment::contact::{self, Body, Near};
use crate::classic::segment::oversegment::patches::{Cutting, Turn, patches, turn};
use crate::classic::segment::oversegment::units::{Mass, Units};
use crate::classic::segment::prompts::candidates::Candidates;

/// A surface, ready to be labelled.
#[derive(Debug)]
pub(crate) struct Skin {
    /// The surface, each triangle once.
    pub mesh: Mesh,
    /// What stands in one place.
    pub weld: Weld,
    /// The component of each face, numbered in order of first face.
    pub component: Vec<u32>,
    /// The components.
    pub bodies: Vec<Body>,
    /// Length of the diagonal of the surface's box, the mesh's unit.
    pub diagonal: f64,
    /// For each face how its area is spread.
    pub masses: Vec<Mass>,
    /// For each face its normal as long as its area is large.
    pub normals: Vec<DVec3>,
    /// Faces that share an edge, sorted by edge.
    pub edges: Vec<Neighbour>,
    /// How the surface turns over each of them.
    pub turns: Vec<Turn>,
    /// For each component, its edges by their places among all.
    edges_of: Vec<Vec<u32>>,
    /// What points of each component come near on others.
    near: OnceLock<Vec<Near>>,
    /// For the first of the ways to cut that are alike, and each component, the patch of each of its faces in
    /// all these ways.
    patches: [Vec<OnceLock<Vec<Vec<u32>>>>; 1 + Cutting::OTHERS.len()],
    /// What parts without a point may be.
    placeable: OnceLock<(Units, Candidates)>,
}

impl Skin {
    /// What is known of a surface.
    pub(crate) fn of(mesh: &Mesh, weld: &Weld) -> Self {
        let edges = weld.neighbours();
        let diagonal = mesh.bounds().diagonal();
        let (component, bodies) = contact::bodies(mesh, weld);
        let faces = 0..mesh.faces().len();
        let turns: Vec<Turn> = edges.iter().map(|e| turn(mesh, weld, e, diagonal)).collect();
        let mut edges_of = vec![Vec::new(); bodies.len()];
        for (i, edge) in edges.iter().enumerate() {
            edges_of[component[edge.first as usize] as usize].push(i as u32);
        }
        let uncut = || bodies.iter().map(|_| OnceLock::new()).collect();
        Self {
            masses: faces.clone().map(|face| Mass::of_face(mesh, face)).collect(),
            normals: faces.map(|face| mesh.normal(face) * mesh.area(face)).collect(),
            patches: std::array::from_fn(|_| uncut()),
            near: OnceLock::new(),
            placeable: OnceLock::new(),
            mesh: mesh.clone(),
            weld: weld.clone(),
            component,
            bodies,
            diagonal,
            edges,
            turns,
            edges_of,
        }
    }

    /// The component of a face.
    pub(crate) fn body_of(&self, face: usize) -> &Body {
        &self.bodies[self.component[face] as usize]
    }

    /// The edges of a component, by their places among all.
    pub(crate) fn edges_of(&self, component: usize) -> &[u32] {
        &self.edges_of[component]
    }

    /// Two faces that share an edge, by its place among all, and how the surface turns over it.
    pub(crate) fn edge(&self, place: u32) -> (&Neighbour, &Turn) {
        (&self.edges[place as usize], &self.turns[place as usize])
    }

    /// The patch of each face of a component that is cut in some way: the first face of that patch.
    pub(crate) fn patches(&self, component: usize, cutting: Cutting) -> &[u32] {
        let alike = cutting.alike();
        let others = Cutting::OTHERS.iter().position(|other| alike.first() == Some(other));
        let cut = || self.cut(component, &alike);
        let all = self.patches[others.map_or(0, |i| i + 1)][component].get_or_init(cut);
        &all[alike.iter().position(|other| *other == cutting).unwrap_or(0)]
    }

    /// For each of some ways to cut that are alike, the patch of each face.
    fn cut(&self, component: usize, alike: &[Cutting]) -> Vec<Vec<u32>> {
        let faces = &self.bodies[component].faces;
        let local = |face: u32| faces.partition_point(|f| *f < face) as u32;
        let edge = |&i: &u32| {
            let e = &self.edges[i as usize];
            Neighbour { first: local(e.first), second: local(e.second), ..*e }
        };
        let edges: Vec<Neighbour> = self.edges_of[component].iter().map(edge).collect();
        let turns: Vec<Turn> =
            self.edges_of[component].iter().map(|&i| self.turns[i as usize]).collect();
        let by_first = |(patch, count): (Vec<u32>, usize)| {
            let mut first = vec![u32::MAX; count];
            for (face, patch) in faces.iter().zip(&patch) {
                first[*patch as usize] = first[*patch as usize].min(*face);
            }
            patch.into_iter().map(|patch| first[patch as usize]).collect()
        };
        patches(&turns, &edges, faces.len(), alike).into_iter().map(by_first).collect()
    }

    /// What points of each component come near on others, component by component.
    pub(crate) fn near(&self) -> &[Near] {
        self.near.get_or_init(|| contact::near(&self.bodies, self.diagonal))
    }

    /// What parts without a point may be.
    pub(crate) fn placeable(&self) -> &(Units, Candidates) {
        self.placeable.get_or_init(|| {
            let units = Units::of(&self.mesh, &self.weld, &self.component, &self.bodies);
            let candidates = Candidates::of(&units);
            (units, candidates)
        })
    }
}

/// Numbers in the order in which each first comes up, for keys below `most`.
pub(crate) struct Numbering {
    number: Vec<u32>,
    next: u32,
}

impl Numbering {
    /// No number is given yet.
    pub(crate) fn below(most: usize) -> Self {
        Self { number: vec![u32::MAX; most], next: 0 }
    }

    /// The number of a key.
    pub(crate) fn of(&mut self, key: usize) -> u32 {
        let number = &mut self.number[key];
        if *number == u32::MAX {
            *number = self.next;
            self.next += 1;
        }
        *number
    }

    /// How many numbers were given.
    pub(crate) fn count(&self) -> usize {
        self.next as usize
    }
}
