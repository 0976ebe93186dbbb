//! A surface looked at closely: degenerate faces, winding, components, closedness, volume.

use glamx::{DPose3, DVec3};
use object::Mesh;
use object::weld::Weld;

/// Two faces look the same way if their normals agree this well: within 8 degrees.
const LEVEL: f64 = 0.99;
/// A closed surface of less volume than this times its area to the power of 1.5 is a sheet: a ball
/// has 0.09, a square pane 1/1000 as thick as wide 0.0004.
const SHEET: f64 = 1e-5;
/// Faces of a component that are asked what lies around it.
const ASKED: usize = 7;

/// How the faces of a mesh hang together.
#[derive(Clone, Debug)]
pub(crate) struct Topology {
    /// Distinct vertex positions that faces use.
    pub places: Vec<DVec3>,
    /// Faces without area, or with two corners in one place.
    pub degenerate: usize,
    /// Edges of exactly two faces.
    pub paired_edges: usize,
    /// Of those, the ones both faces traverse in the same direction.
    pub clashing_edges: usize,
    /// Edges of an odd number of faces: the surface is open there.
    pub open_edges: usize,
    /// For each face, its component.
    pub component_of_face: Vec<u32>,
    /// The components, in order of first face.
    pub components: Vec<Component>,
    /// For each component, a few of its faces, spread over it.
    asked: Vec<Vec<u32>>,
}

/// Faces that hang together.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Component {
    /// m².
    pub area: f64,
    /// Signed volume, m³; means something only where closed.
    pub volume: f64,
    /// Whether every edge is traversed as often one way as the other.
    pub is_closed: bool,
    /// A vertex of it.
    pub anchor: DVec3,
}

impl Component {
    /// Whether it is closed but encloses next to nothing, like a sheet with two sides.
    pub(crate) fn is_sheet(&self) -> bool {
        self.is_closed && self.volume.abs() <= SHEET * self.area.powf(1.5)
    }
}

/// A face's use of an edge, as one number: the edge's places, lesser first, then whether the face
/// goes that way, then the face. To sort them is one comparison each, not four.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct EdgeUse(u128);

impl EdgeUse {
    fn new([from, to]: [u32; 2], face: u32) -> Self {
        let numbers = [from.min(to), from.max(to), u32::from(from < to), face];
        Self(numbers.into_iter().fold(0, |all, n| all << 32 | u128::from(n)))
    }

    fn edge(self) -> u64 {
        (self.0 >> 64) as u64
    }

    fn is_forward(self) -> bool {
        self.0 >> 32 & 1 == 1
    }

    fn face(self) -> u32 {
        self.0 as u32
    }
}

impl Topology {
    /// Welds the mesh and counts.
    pub(crate) fn of(mesh: &Mesh) -> Self {
        let weld = Weld::new(mesh);
        let (component_of_face, count) = weld.components();
        let mut topology = Self {
            places: used_places(&weld),
            degenerate: degenerate_faces(mesh, &weld),
            paired_edges: 0,
            clashing_edges: 0,
            open_edges: 0,
            asked: spread_faces(&component_of_face, count),
            component_of_face,
            components: vec![Component { is_closed: true, ..Component::default() }; count],
        };
        topology.measure(mesh);
        topology.count_edges(mesh, &weld);
        topology
    }

    fn measure(&mut self, mesh: &Mesh) {
        let mut is_new = vec![true; self.components.len()];
        for face in 0..mesh.faces().len() {
            let c = self.component_of_face[face] as usize;
            let corners = mesh.corners(face);
            let component = &mut self.components[c];
            if std::mem::take(&mut is_new[c]) {
                component.anchor = corners[0];
            }
            let [p, q, r] = corners.map(|v| v - component.anchor);
            component.area += mesh.area(face);
            component.volume += p.dot(q.cross(r)) / 6.0;
        }
    }

    /// Counts edges by how many faces use them. Two faces that use one the same way clash, unless
    /// they look the same way: then one lies on the other, and each has an open edge there.
    fn count_edges(&mut self, mesh: &Mesh, weld: &Weld) {
        let mut edges: Vec<EdgeUse> = Vec::with_capacity(3 * weld.faces.len());
        for (face, &[a, b, c]) in weld.faces.iter().enumerate() {
            if a == b || b == c || c == a {
                continue;
            }
            for [p, q] in [[a, b], [b, c], [c, a]] {
                edges.push(EdgeUse::new([p, q], face as u32));
            }
        }
        edges.sort_unstable();
        for fan in edges.chunk_by(|x, y| x.edge() == y.edge()) {
            let forward = fan.iter().filter(|e| e.is_forward()).count();
            let balanced = 2 * forward == fan.len();
            let look = |face: u32| mesh.normal(face as usize);
            let sheets =
                fan.len() == 2 && !balanced && look(fan[0].face()).dot(look(fan[1].face())) > LEVEL;
            self.paired_edges += usize::from(fan.len() == 2 && !sheets);
            self.clashing_edges += usize::from(fan.len() == 2 && !balanced && !sheets);
            self.open_edges += if sheets { 2 } else { fan.len() % 2 };
            let component = self.component_of_face[fan[0].face() as usize];
            self.components[component as usize].is_closed &= balanced;
        }
    }

    /// A few points just outside a component, whichever way its faces look: where its volume is
    /// negative, that is behind them.
    pub(crate) fn outside(&self, mesh: &Mesh, component: usize) -> impl Iterator<Item = DVec3> {
        let asked = self.asked.get(component).cloned().unwrap_or_default();
        let sign = if self.components[component].volume < 0.0 { -1.0 } else { 1.0 };
        let step = sign * 1e-5 * mesh.bounds().diagonal();
        asked.into_iter().map(move |f| mesh.centroid(f as usize) + mesh.normal(f as usize) * step)
    }

    /// Whether every component is closed and consistently wound.
    pub(crate) fn is_closed(&self) -> bool {
        self.components.iter().all(|c| c.is_closed)
    }

    /// Sum of the components' signed volumes, m³: cavities count negative.
    pub(crate) fn volume(&self) -> f64 {
        self.components.iter().map(|c| c.volume).sum()
    }
}

/// Up to [`ASKED`] faces of each component, evenly spread over its list.
fn spread_faces(component_of_face: &[u32], count: usize) -> Vec<Vec<u32>> {
    let mut faces = vec![Vec::new(); count];
    for (face, &component) in component_of_face.iter().enumerate() {
        faces[component as usize].push(face as u32);
    }
    let spread = |all: Vec<u32>| {
        let every = all.len().div_ceil(ASKED).max(1);
        all.into_iter().step_by(every).collect()
    };
    faces.into_iter().map(spread).collect()
}

fn used_places(weld: &Weld) -> Vec<DVec3> {
    let mut used = vec![false; weld.places.len()];
    weld.faces.iter().flatten().for_each(|&p| used[p as usize] = true);
    weld.places.iter().zip(used).filter_map(|(p, used)| used.then_some(*p)).collect()
}

fn degenerate_faces(mesh: &Mesh, weld: &Weld) -> usize {
    let tiny = 1e-14 * mesh.bounds().diagonal().powi(2);
    let is_degenerate = |(face, &[a, b, c]): (usize, &[u32; 3])| {
        a == b || b == c || c == a || mesh.area(face) <= tiny
    };
    weld.faces.iter().enumerate().filter(|f| is_degenerate(*f)).count()
}

/// Several surfaces as one, each moved to its pose, without vertices no face uses; `None` if there
/// is none.
pub(crate) fn merged<'m>(parts: impl Iterator<Item = (&'m Mesh, DPose3)>) -> Option<Mesh> {
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for (mesh, pose) in parts {
        let first = vertices.len() as u32;
        vertices.extend(mesh.vertices().iter().map(|&v| pose.transform_point(v)));
        faces.extend(mesh.faces().iter().map(|f| f.map(|v| v + first)));
    }
    let all = Mesh::new(vertices, faces).ok()?;
    all.submesh(0..all.faces().len()).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::tessellate::tessellated;
    use crate::robot::Geometry;

    fn cube() -> Mesh {
        tessellated(&Geometry::Box { size: DVec3::new(1.0, 2.0, 3.0) }).unwrap()
    }

    #[test]
    fn a_face_taken_out_opens_three_edges_and_one_turned_round_clashes_on_three() {
        let whole = cube();
        let mut faces = whole.faces().to_vec();
        faces.pop();
        let open = Topology::of(&Mesh::new(whole.vertices().to_vec(), faces.clone()).unwrap());
        assert_eq!((open.open_edges, open.is_closed()), (3, false));
        let [a, b, c] = whole.faces()[11];
        faces.push([b, a, c]);
        let turned = Topology::of(&Mesh::new(whole.vertices().to_vec(), faces).unwrap());
        assert_eq!((turned.open_edges, turned.clashing_edges, turned.paired_edges), (0, 3, 18));
        assert!(!turned.is_closed());
    }

    #[test]
    fn a_pane_is_a_solid_and_a_sheet_with_two_sides_is_none() {
        let pane = |t| {
            let size = DVec3::new(1.0, 1.0, t);
            Topology::of(&tessellated(&Geometry::Box { size }).unwrap()).components[0]
        };
        assert!(!pane(1e-3).is_sheet() && pane(1e-6 * 5.0).is_sheet());
    }

    #[test]
    fn two_boxes_are_two_components_with_their_own_volumes() {
        let far = DPose3::translation(10.0, 0.0, 0.0);
        let cube = cube();
        let both = merged([(&cube, DPose3::identity()), (&cube, far)].into_iter()).unwrap();
        let topology = Topology::of(&both);
        assert_eq!(topology.components.len(), 2);
        assert!(topology.components.iter().all(|c| (c.volume - 6.0).abs() < 1e-12));
    }

    #[test]
    fn a_sheet_lying_on_another_is_open_and_not_wound_against_it() {
        let at = |x: f64, y: f64| glamx::DVec3::new(x, y, 0.0);
        let corners = vec![at(0.0, 0.0), at(1.0, 0.0), at(0.2, 1.0), at(0.4, 0.7)];
        let mesh = Mesh::new(corners, vec![[0, 1, 2], [0, 1, 3]]).unwrap();
        let sheets = Topology::of(&mesh);
        assert_eq!((sheets.clashing_edges, sheets.open_edges), (0, 6));
    }
}
