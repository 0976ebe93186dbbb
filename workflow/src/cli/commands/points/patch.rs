//! Faces that hang together, as `faces` of a condition takes them.

use object::Mesh;
use object::condition::Runs;
use object::weld::{DisjointSets, Weld};

/// The faces around one that follow on from it and from each other over edges that bend by at most so
/// much, radians. At half a turn that is all that hangs together.
pub(super) fn patch(mesh: &Mesh, face: u32, bend: f64) -> Runs {
    let mut sets = DisjointSets::new(mesh.faces().len());
    let least = bend.cos();
    for pair in Weld::new(mesh).neighbours() {
        let [a, b] = [pair.first, pair.second].map(|f| mesh.normal(f as usize));
        // A face without area has no direction, and is no edge.
        let flat = a.length_squared() == 0.0 || b.length_squared() == 0.0;
        if flat || a.dot(b) >= least - 1e-12 {
            sets.join(pair.first, pair.second);
        }
    }
    let own = sets.root(face);
    (0..mesh.faces().len() as u32).filter(|&f| sets.root(f) == own).collect()
}

/// All that hangs together, in the order of the first faces, and which of it each face is of.
pub(super) fn pieces(mesh: &Mesh) -> (Vec<Runs>, Vec<u32>) {
    let (piece_of_face, count) = Weld::new(mesh).components();
    let mut faces: Vec<Vec<u32>> = vec![vec![]; count];
    for (face, &piece) in (0u32..).zip(&piece_of_face) {
        if let Some(all) = faces.get_mut(piece as usize) {
            all.push(face);
        }
    }
    (faces.into_iter().map(|all| all.into_iter().collect()).collect(), piece_of_face)
}

#[cfg(test)]
mod tests {
    use object::DVec3;

    use super::*;

    /// Two cubes of two triangles a side, the second beside the first.
    fn cubes() -> Mesh {
        let corner = |i: u32| DVec3::new((i & 1).into(), (i >> 1 & 1).into(), (i >> 2).into());
        let quads =
            [[0, 1, 5, 4], [0, 2, 3, 1], [4, 5, 7, 6], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let one = |from: u32| {
            let quads = quads.map(|q: [u32; 4]| q.map(|v| v + from));
            quads.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]])
        };
        let vertices = (0..8).map(corner).chain((0..8).map(|i| corner(i) + DVec3::X * 3.0));
        Mesh::new(vertices.collect(), one(0).chain(one(8)).collect()).unwrap()
    }

    #[test]
    fn a_patch_ends_where_the_surface_bends_more() {
        let runs = |bend: f64| patch(&cubes(), 14, bend.to_radians()).to_string();
        assert_eq!(runs(30.0), "14-15");
        assert_eq!((runs(90.0), runs(180.0)), ("12-23".into(), "12-23".into()));
    }

    #[test]
    fn what_hangs_together_is_told_whole() {
        let (pieces, piece_of_face) = pieces(&cubes());
        let told: Vec<_> = pieces.iter().map(ToString::to_string).collect();
        assert_eq!(told, ["0-11", "12-23"]);
        assert_eq!((piece_of_face[0], piece_of_face[23]), (0, 1));
    }
}
