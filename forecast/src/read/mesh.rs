//! What the rules need to know of a mesh.

use std::path::PathBuf;

/// How a mesh is named in a model file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Uri {
    /// A path.
    Plain,
    /// `package://NAME/…`, with the name.
    Package(String),
    /// `file://…`.
    File,
}

/// Whether it was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Here {
    /// It was.
    Yes,
    /// It was not.
    No,
    /// It was not looked at: it stands outside, or is too large.
    Unknown,
}

/// A mesh that a model file names.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// The name in the file.
    pub filename: String,
    /// How it is named.
    pub uri: Uri,
    /// Its extension in small letters, without the dot; empty if it has none.
    pub extension: String,
    /// Whether it was found.
    pub here: Here,
    /// Whether all its corners lie in one plane.
    pub flat: bool,
    /// Whether it is known to have a dent deeper than [`DENT`] of its size.
    pub concave: bool,
    /// Triangles; 0 where they were not counted.
    pub faces: usize,
    /// Whether it is an STL written as text.
    pub is_text: bool,
    /// Materials that its faces name; 0 where they were not counted.
    pub materials: usize,
    /// Its lowest and highest corner, in the mesh's unit; `None` where it was not measured.
    pub bounds: Option<Bounds>,
    pub(crate) path: PathBuf,
    pub(crate) pairs: usize,
}

/// Depth of the dents that count, of a mesh's longest extent: shallower ones are rounding of scans
/// and exporters; a guess.
pub const DENT: f64 = 0.01;
/// How far corners of a sheet may lie off its plane, of its longest extent; the rounding of numbers
/// with seven digits.
const SHEET: f64 = 1e-7;
/// Most pairs of a face and a corner that are looked at in each of a file's first meshes, a tenth of a
/// second of work; larger meshes are asked about some of their faces.
const MOST_PAIRS: usize = 50_000_000;
/// How many meshes these are; later ones get a hundredth. Both keep a file of thousands of meshes
/// within seconds; guesses.
const FIRST: usize = 100;

pub(crate) type Point = [f64; 3];

/// The lowest and the highest corner of a box.
pub type Bounds = [[f64; 3]; 2];

impl Mesh {
    /// A mesh of which only the name is known.
    pub(crate) fn named(filename: &str) -> Self {
        let (uri, path) = if let Some(rest) = filename.strip_prefix("package://") {
            let name = rest.split('/').next().unwrap_or_default().to_string();
            (Uri::Package(name), PathBuf::from(rest))
        } else if let Some(rest) = filename.strip_prefix("file://") {
            (Uri::File, PathBuf::from(rest))
        } else {
            (Uri::Plain, PathBuf::from(filename))
        };
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        Self {
            filename: filename.chars().take(200).collect(),
            uri,
            extension: extension.unwrap_or_default(),
            here: Here::Unknown,
            flat: false,
            concave: false,
            faces: 0,
            is_text: false,
            materials: 0,
            bounds: None,
            path,
            pairs: MOST_PAIRS,
        }
    }

    /// The same, when so many meshes of its file were looked at before it.
    pub(crate) fn after(mut self, meshes: usize) -> Self {
        if meshes >= FIRST {
            self.pairs = MOST_PAIRS / 100;
        }
        self
    }

    /// Measures corners and triangles; indices are into `corners`, and those beyond are passed over.
    pub(crate) fn measure(&mut self, corners: &[Point], faces: &[[usize; 3]]) {
        let Some(first) = corners.first() else { return };
        let (mut low, mut high) = (*first, *first);
        for corner in corners {
            for i in 0..3 {
                low[i] = low[i].min(corner[i]);
                high[i] = high[i].max(corner[i]);
            }
        }
        let extents = sub(high, low);
        let size = extents.into_iter().fold(0.0, f64::max);
        self.bounds = Some([low, high]);
        self.faces = faces.len();
        self.flat = size > 0.0 && thickness(corners) <= SHEET * size;
        self.concave = !self.flat && is_dented(corners, faces, DENT * size, self.pairs);
    }
}

fn sub(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// A vector of length 1; `None` of a vanishing one.
fn unit(a: Point) -> Option<Point> {
    let length = dot(a, a).sqrt();
    (length > 0.0 && length.is_finite()).then(|| a.map(|x| x / length))
}

/// How far corners lie off the plane through three of them that are far apart.
fn thickness(corners: &[Point]) -> f64 {
    let Some(a) = corners.first().copied() else { return 0.0 };
    let farthest = |of: &dyn Fn(Point) -> f64| {
        corners.iter().copied().max_by(|p, q| of(*p).total_cmp(&of(*q))).unwrap_or(a)
    };
    let b = farthest(&|p| dot(sub(p, a), sub(p, a)));
    let Some(along) = unit(sub(b, a)) else { return 0.0 };
    let off = |p: Point| cross(along, sub(p, a));
    let c = farthest(&|p| dot(off(p), off(p)));
    let Some(normal) = unit(off(c)) else { return 0.0 };
    corners.iter().map(|p| dot(normal, sub(*p, a)).abs()).fold(0.0, f64::max)
}

/// Whether corners lie further than `depth` on both sides of a face: then it is no face of the hull.
fn is_dented(corners: &[Point], faces: &[[usize; 3]], depth: f64, pairs: usize) -> bool {
    let asked = (pairs / corners.len().max(1)).max(1);
    let step = faces.len().div_ceil(asked).max(1);
    faces.iter().step_by(step).any(|face| {
        let [Some(a), Some(b), Some(c)] = face.map(|i| corners.get(i).copied()) else {
            return false;
        };
        let Some(normal) = unit(cross(sub(b, a), sub(c, a))) else { return false };
        let (mut below, mut above) = (false, false);
        for corner in corners {
            let off = dot(normal, sub(*corner, a));
            below |= off < -depth;
            above |= off > depth;
            if below && above {
                return true;
            }
        }
        false
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measured(corners: &[Point], faces: &[[usize; 3]]) -> Mesh {
        let mut mesh = Mesh::named("a.obj");
        mesh.measure(corners, faces);
        mesh
    }

    const TETRA: [Point; 4] = [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 1.0]];
    const FACES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

    #[test]
    fn a_tetrahedron_is_neither_flat_nor_dented() {
        let mesh = measured(&TETRA, &FACES);
        assert!(!mesh.flat && !mesh.concave);
        assert_eq!(mesh.bounds, Some([[0.0; 3], [3.0, 2.0, 1.0]]));
    }

    #[test]
    fn a_sheet_is_flat_in_any_direction() {
        let slanted = TETRA.map(|[x, y, _]| [x, y, 0.3 * x - 0.7 * y]);
        assert!(measured(&slanted, &FACES).flat);
    }

    #[test]
    fn a_roof_turned_inside_is_a_dent_whichever_way_faces_turn() {
        let mut corners = TETRA.to_vec();
        corners.push([0.2, 0.2, 0.2]);
        let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 4], [2, 3, 4], [4, 3, 1]];
        assert!(measured(&corners, &faces).concave);
        assert!(measured(&corners, &faces.map(|[a, b, c]| [a, c, b])).concave);
    }

    #[test]
    fn broken_indices_and_points_are_passed_over() {
        assert!(!measured(&TETRA, &[[0, 1, 9]]).concave);
        assert!(!measured(&[], &[]).flat);
        assert!(!measured(&[[0.0; 3]; 5], &[[0, 1, 2]]).flat);
    }
}
