//! The mesh as a page draws it: all of its faces, or fewer that stand for them.

use object::simplify::{Triangles, simpler};
use object::{DVec3, Mesh};
use parry3d_f64::query::PointQueryWithLocation as _;
use parry3d_f64::shape::TriMesh;
use rayon::prelude::*;

/// Most faces that a page draws; a guess at what a laptop turns smoothly while it is painted on.
pub const MOST_FACES: usize = 400_000;

/// What is drawn, and which faces of the mesh it stands for.
pub(crate) struct Screen {
    /// The bytes a page reads; see [`Screen::of`].
    pub bytes: Vec<u8>,
    /// How many faces are drawn.
    pub shown: usize,
    /// For each drawn face the face of the mesh it is; none where all are drawn, in their order.
    of_shown: Option<Vec<u32>>,
}

impl Screen {
    /// Little endian: the numbers of vertices, of drawn faces and of the mesh's faces and a zero, u32;
    /// positions, three f32 each, object frame; colours, RGBA bytes; corners, three u32 a face; and where
    /// not all faces are drawn, for each of the mesh's the drawn one that stands for it, u32.
    pub(crate) fn of(mesh: &Mesh) -> Self {
        Self::at_most(mesh, MOST_FACES)
    }

    fn at_most(mesh: &Mesh, most: usize) -> Self {
        let fewer = (mesh.faces().len() > most)
            .then(|| simpler(mesh, most, Triangles::Any).ok())
            .flatten()
            .filter(|fewer| fewer.faces().len() < mesh.faces().len());
        let Some(fewer) = fewer else {
            let (bytes, shown) = (packed(mesh, mesh.faces().len()), mesh.faces().len());
            return Self { bytes, shown, of_shown: None };
        };
        let mut bytes = packed(&fewer, mesh.faces().len());
        for face in nearest(&fewer, mesh) {
            bytes.extend(face.to_le_bytes());
        }
        let of_shown = Some(nearest(mesh, &fewer));
        Self { bytes, shown: fewer.faces().len(), of_shown }
    }

    /// What is known of each face of the mesh, as known of each drawn one.
    pub(crate) fn shown<T: Copy>(&self, of_face: &[T]) -> Vec<T> {
        match &self.of_shown {
            None => of_face.to_vec(),
            Some(faces) => faces.iter().filter_map(|&f| of_face.get(f as usize).copied()).collect(),
        }
    }
}

fn packed(mesh: &Mesh, all: usize) -> Vec<u8> {
    let (vertices, faces) = (mesh.vertices(), mesh.faces());
    let mut bytes = Vec::with_capacity(16 + 16 * vertices.len() + 12 * faces.len());
    for number in [vertices.len(), faces.len(), all, 0] {
        bytes.extend((number as u32).to_le_bytes());
    }
    let narrow = |v: &DVec3| v.to_array().map(|x| x as f32);
    bytes.extend(vertices.iter().flat_map(narrow).flat_map(f32::to_le_bytes));
    let plain = [200, 200, 200, 255];
    let colour = |i: usize| mesh.colours().and_then(|c| c.get(i).copied()).unwrap_or(plain);
    bytes.extend((0..vertices.len()).flat_map(colour));
    bytes.extend(faces.iter().flatten().flat_map(|i| i.to_le_bytes()));
    bytes
}

/// For each face of `of`, the face of `among` nearest to its middle.
fn nearest(among: &Mesh, of: &Mesh) -> Vec<u32> {
    let surface = TriMesh::new(among.vertices().to_vec(), among.faces().to_vec());
    let Ok(surface) = surface else { return vec![0; of.faces().len()] };
    let one = |f: usize| surface.project_local_point_and_get_location(of.centroid(f), false).1.0;
    (0..of.faces().len()).into_par_iter().map(one).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on stops")]
mod tests {
    use super::*;

    /// A flat sheet of n × n squares.
    fn sheet(n: u32) -> Mesh {
        let at = |i: u32| DVec3::new(f64::from(i % (n + 1)), f64::from(i / (n + 1)), 0.0);
        let vertices = (0..(n + 1) * (n + 1)).map(at).collect();
        let square = |i: u32| {
            let a = i / n * (n + 1) + i % n;
            [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]
        };
        Mesh::new(vertices, (0..n * n).flat_map(square).collect()).unwrap()
    }

    fn numbers(bytes: &[u8]) -> Vec<u32> {
        bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
    }

    #[test]
    fn all_faces_are_drawn_in_their_order_where_they_are_not_too_many() {
        let mesh = sheet(2);
        let screen = Screen::of(&mesh);
        let all = numbers(&screen.bytes);
        assert_eq!((&all[..4], screen.shown), (&[9, 8, 8, 0][..], 8));
        assert_eq!(all.len(), 4 + 3 * 9 + 9 + 3 * 8);
        assert_eq!(all[4 + 4 * 9..], mesh.faces().concat());
        assert_eq!(screen.shown(&[1, 2, 3]), [1, 2, 3]);
    }

    #[test]
    fn of_too_many_faces_each_has_one_that_stands_for_it() {
        let mesh = sheet(40);
        let screen = Screen::at_most(&mesh, 400);
        let all = numbers(&screen.bytes);
        let (vertices, shown, faces) = (all[0] as usize, all[1] as usize, all[2] as usize);
        assert!(shown < 3200 && shown == screen.shown && faces == 3200);
        assert_eq!(all.len(), 4 + 4 * vertices + 3 * shown + faces);
        // The half at x < 20 is of one part, the other of another; drawn faces are of the part they lie on.
        let parts: Vec<u16> = (0..faces).map(|f| u16::from(mesh.centroid(f).x > 20.0)).collect();
        let drawn = screen.shown(&parts);
        assert_eq!(drawn.len(), shown);
        assert!(drawn.contains(&0) && drawn.contains(&1));
        let stands = &all[4 + 4 * vertices + 3 * shown..];
        assert!(stands.iter().all(|&f| (f as usize) < shown));
    }
}
