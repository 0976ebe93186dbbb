//! Which vertices stand in one place, which faces hang together, which face is nearest.

use std::collections::BTreeMap;

use glamx::DVec3;
use rustc_hash::{FxBuildHasher, FxHashMap};

use crate::mesh::Mesh;

/// Vertices closer than this share of the mesh's diagonal are one place.
pub const WELD_TOLERANCE: f64 = 1e-6;
/// Cells along a mesh, at most.
const CELLS: f64 = 1.0 / WELD_TOLERANCE;

/// A mesh's connectivity by position: files repeat vertices along seams, so indices tell nothing.
#[derive(Clone, Debug)]
pub struct Weld {
    /// For each vertex, the index of the place it stands in.
    pub place_of_vertex: Vec<u32>,
    /// Position of each place, object frame, metres.
    pub places: Vec<DVec3>,
    /// For each face, its three places; two may coincide on a sliver.
    pub faces: Vec<[u32; 3]>,
}

/// Two faces that share an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Neighbour {
    /// The two places of the edge, smaller first.
    pub edge: [u32; 2],
    /// The lower face index.
    pub first: u32,
    /// The higher face index.
    pub second: u32,
}

impl Weld {
    /// Merges vertices that stand within [`WELD_TOLERANCE`] of the diagonal of each other, by
    /// snapping to a grid of that size and looking into the neighbouring cells.
    pub fn new(mesh: &Mesh) -> Self {
        let bounds = mesh.bounds();
        let cell = bounds.diagonal() * WELD_TOLERANCE;
        let start = bounds.min;
        let mut grid = Grid::for_places(mesh.vertices().len());
        let mut places: Vec<DVec3> = Vec::new();
        let mut place_of_vertex = Vec::with_capacity(mesh.vertices().len());
        for &v in mesh.vertices() {
            // A vertex that no face uses may stand anywhere; where no number counts, it is just outside.
            let key = ((v - start) / cell).to_array().map(|c| c.clamp(-1.0, CELLS).floor() as i64);
            let near = |p: u32| places[p as usize].distance_squared(v) <= cell * cell;
            let place = grid.find(key, near).unwrap_or_else(|| {
                places.push(v);
                grid.add(key)
            });
            place_of_vertex.push(place);
        }
        let place = |v: u32| place_of_vertex[v as usize];
        let faces = mesh.faces().iter().map(|f| f.map(place)).collect();
        Self { place_of_vertex, places, faces }
    }

    /// Pairs of faces that share an edge, sorted; an edge of n faces gives its n−1 successive pairs.
    pub fn neighbours(&self) -> Vec<Neighbour> {
        let mut edges: Vec<([u32; 2], u32)> = Vec::with_capacity(self.faces.len() * 3);
        for (face, &[a, b, c]) in self.faces.iter().enumerate() {
            for [p, q] in [[a, b], [b, c], [c, a]] {
                if p != q {
                    edges.push(([p.min(q), p.max(q)], face as u32));
                }
            }
        }
        edges.sort_unstable();
        let pair = |w: &[([u32; 2], u32)]| {
            let ((edge, first), (other, second)) = (w[0], w[1]);
            (edge == other && first != second).then_some(Neighbour { edge, first, second })
        };
        edges.windows(2).filter_map(pair).collect()
    }

    /// For each face, the component it belongs to, numbered in order of first face; and how many
    /// there are. Faces that share an edge are of one component: what touches in single places is
    /// apart. A face whose places all coincide has no edge and is of the first face that has one there.
    pub fn components(&self) -> (Vec<u32>, usize) {
        let mut sets = DisjointSets::new(self.faces.len());
        for pair in self.neighbours() {
            sets.join(pair.first, pair.second);
        }
        self.join_points(&mut sets);
        let mut number = BTreeMap::new();
        let component = (0..self.faces.len() as u32).map(|face| {
            let next = number.len() as u32;
            *number.entry(sets.root(face)).or_insert(next)
        });
        let component = component.collect();
        (component, number.len())
    }

    /// Joins faces that are a point to the first face there that is more than that, or else to each
    /// other.
    fn join_points(&self, sets: &mut DisjointSets) {
        let is_point = |&(_, &[a, b, c]): &(u32, &[u32; 3])| a == b && b == c;
        let points: Vec<_> = (0u32..).zip(&self.faces).filter(is_point).collect();
        if points.is_empty() {
            return;
        }
        let mut first_at = FxHashMap::default();
        for (face, &[a, b, c]) in (0u32..).zip(&self.faces) {
            if a != b || b != c {
                for place in [a, b, c] {
                    first_at.entry(place).or_insert(face);
                }
            }
        }
        for (face, [place, ..]) in points {
            sets.join(face, *first_at.entry(*place).or_insert(face));
        }
    }
}

/// Cells along a block of cells: more, and a crowd in one block takes long to look through; fewer,
/// and a cell has its neighbours in more blocks.
const BLOCK: u64 = 4;

/// Places by the cells they lie in, in blocks of cells.
struct Grid {
    /// The last place of each block.
    last: FxHashMap<u64, u32>,
    /// Each place's cell, and the place before it in its block.
    places: Vec<([i64; 3], Option<u32>)>,
}

impl Grid {
    fn for_places(count: usize) -> Self {
        let last = FxHashMap::with_capacity_and_hasher(count, FxBuildHasher);
        Self { last, places: Vec::with_capacity(count) }
    }

    /// Of the places in a cell or beside it that will do, the first by cell (x fastest), then by
    /// number.
    fn find(&self, cell: [i64; 3], will_do: impl Fn(u32) -> bool) -> Option<u32> {
        let [[x0, x1], [y0, y1], [z0, z1]] = cell.map(|c| [-1, 1].map(|d| block(c + d)));
        let mut first: Option<(i64, u32)> = None;
        for z in z0..=z1 {
            for y in y0..=y1 {
                for x in x0..=x1 {
                    let mut walk = self.last.get(&key([x, y, z])).copied();
                    while let Some(place) = walk {
                        let (there, before) = self.places[place as usize];
                        let away: [i64; 3] = std::array::from_fn(|k| there[k] - cell[k]);
                        let order = away[0] + 3 * away[1] + 9 * away[2];
                        let is_beside = away.iter().all(|d| d.abs() <= 1);
                        if is_beside && first.is_none_or(|f| (order, place) < f) && will_do(place) {
                            first = Some((order, place));
                        }
                        walk = before;
                    }
                }
            }
        }
        first.map(|f| f.1)
    }

    /// Puts the next place into a cell; its number.
    fn add(&mut self, cell: [i64; 3]) -> u32 {
        let number = self.places.len() as u32;
        let before = self.last.insert(key(cell.map(block)), number);
        self.places.push((cell, before));
        number
    }
}

/// The block of a cell along one side; cells are counted from −1, with one more on either side.
fn block(cell: i64) -> u64 {
    (cell + 2).max(0) as u64 / BLOCK
}

/// A block as one number: a million cells are fewer than 2^20 blocks.
fn key([x, y, z]: [u64; 3]) -> u64 {
    x << 40 | y << 20 | z
}

/// Union–find over indices.
#[derive(Clone, Debug)]
pub struct DisjointSets(Vec<u32>);

impl DisjointSets {
    /// `n` sets of one.
    pub fn new(n: usize) -> Self {
        Self((0..n as u32).collect())
    }

    /// The representative of the set `i` is in: its smallest member.
    pub fn root(&mut self, mut i: u32) -> u32 {
        while self.0[i as usize] != i {
            let grandparent = self.0[self.0[i as usize] as usize];
            self.0[i as usize] = grandparent;
            i = grandparent;
        }
        i
    }

    /// Makes the sets of `a` and `b` one.
    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}

/// The face nearest a point, and its distance; by looking at every face, closely where its box is near.
pub fn nearest_face(mesh: &Mesh, p: DVec3) -> (usize, f64) {
    let mut best = (0, f64::INFINITY);
    for face in 0..mesh.faces().len() {
        let corners = mesh.corners(face);
        if !is_beyond(p, corners, best.1) {
            let distance = nearest_on_triangle(p, corners).distance(p);
            best = if distance < best.1 { (face, distance) } else { best };
        }
    }
    best
}

/// Whether the box of a triangle is farther from a point than `reach`, by more than rounding could lead
/// astray along the triangle.
fn is_beyond(p: DVec3, [a, b, c]: [DVec3; 3], reach: f64) -> bool {
    /// A share of the box's sides together, and of the coordinates.
    const ASTRAY: [f64; 2] = [1e-4, 8.0 * f64::EPSILON];
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    let off = (low - p).max(p - high).max(DVec3::ZERO);
    let [along, about] = [high - low, low.abs().max(high.abs())].map(DVec3::element_sum);
    off.length_squared() > (reach + ASTRAY[0] * along + ASTRAY[1] * about).powi(2)
}

/// The point of a mesh nearest to another, and their distance in the mesh's unit.
pub fn nearest_point(mesh: &Mesh, p: DVec3) -> (DVec3, f64) {
    let nearest = nearest_on_triangle(p, mesh.corners(nearest_face(mesh, p).0));
    (nearest, nearest.distance(p))
}

/// The faces nearest a point: all that are farther than the nearest by no more than `slack`, in
/// the mesh's unit, ascending.
pub fn nearest_faces(mesh: &Mesh, p: DVec3, slack: f64) -> Vec<usize> {
    let reach = nearest_face(mesh, p).1 + slack;
    let is_near = |&face: &usize| {
        let corners = mesh.corners(face);
        !is_beyond(p, corners, reach) && nearest_on_triangle(p, corners).distance(p) <= reach
    };
    (0..mesh.faces().len()).filter(is_near).collect()
}

/// A triangle is as good as its edges where the squared sine of an angle is below this: rounding
/// would then lead farther astray along it than it is wide.
const THIN: f64 = 5e-11;

/// The point of a triangle's edges nearest to `p`.
fn nearest_on_edges(p: DVec3, [a, b, c]: [DVec3; 3]) -> DVec3 {
    let on = |from: DVec3, to: DVec3| {
        let along = to - from;
        let share = (p - from).dot(along) / along.length_squared().max(f64::MIN_POSITIVE);
        from + along * share.clamp(0.0, 1.0)
    };
    let edges = [on(b, c), on(c, a)];
    edges
        .into_iter()
        .fold(on(a, b), |x, y| if p.distance_squared(y) < p.distance_squared(x) { y } else { x })
}

/// The point of a triangle nearest to `p`; by the region of the plane that `p` stands over (Ericson
/// 2005, section 5.1.5).
pub fn nearest_on_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> DVec3 {
    let (ab, ac) = (b - a, c - a);
    let along = |from: DVec3| (ab.dot(p - from), ac.dot(p - from));
    let (a1, a2) = along(a);
    if a1 <= 0.0 && a2 <= 0.0 {
        return a;
    }
    let (b1, b2) = along(b);
    if b1 >= 0.0 && b2 <= b1 {
        return b;
    }
    let beside_ab = a1 * b2 - b1 * a2;
    if beside_ab <= 0.0 && a1 >= 0.0 && b1 <= 0.0 {
        return a + ab * (a1 / (a1 - b1).max(f64::MIN_POSITIVE));
    }
    let (c1, c2) = along(c);
    if c2 >= 0.0 && c1 <= c2 {
        return c;
    }
    let beside_ac = c1 * a2 - a1 * c2;
    if beside_ac <= 0.0 && a2 >= 0.0 && c2 <= 0.0 {
        return a + ac * (a2 / (a2 - c2).max(f64::MIN_POSITIVE));
    }
    let beside_bc = b1 * c2 - c1 * b2;
    let (from_b, from_c) = (b2 - b1, c1 - c2);
    if beside_bc <= 0.0 && from_b >= 0.0 && from_c >= 0.0 {
        return b + (c - b) * (from_b / (from_b + from_c).max(f64::MIN_POSITIVE));
    }
    let all = beside_ab + beside_ac + beside_bc;
    if all <= THIN * ab.length_squared() * ac.length_squared() {
        return nearest_on_edges(p, [a, b, c]);
    }
    a + ab * (beside_ac / all) + ac * (beside_ab / all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    /// Two unit squares side by side, written without shared vertices, and one far away.
    fn seams() -> Mesh {
        let square = |x: f64| {
            let p = |dx: f64, y: f64| DVec3::new(x + dx, y, 0.0);
            [p(0.0, 0.0), p(1.0, 0.0), p(1.0, 1.0), p(0.0, 0.0), p(1.0, 1.0), p(0.0, 1.0)]
        };
        let vertices: Vec<_> = [0.0, 1.0, 5.0].into_iter().flat_map(square).collect();
        let faces = (0..6).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
        Mesh::new(vertices, faces).unwrap()
    }

    /// Found by fuzzing: a node far from the origin, whose cells no number could count.
    #[test]
    fn what_is_far_from_the_origin_is_welded_like_what_is_near() {
        let far = seams().map_vertices(|v| v * 0.01 + DVec3::splat(1e12)).unwrap();
        let weld = Weld::new(&far);
        assert_eq!(weld.places.len(), 6 + 4);
        assert_eq!(weld.components(), (vec![0, 0, 0, 0, 1, 1], 2));
    }

    /// Found by fuzzing: a vertex that no face uses stands wherever it likes.
    #[test]
    fn a_vertex_without_a_face_may_be_anywhere() {
        let (vertices, faces) = (seams().vertices().to_vec(), seams().faces().to_vec());
        let far = [DVec3::splat(-1e300), DVec3::splat(1e300)];
        let mesh = Mesh::new(vertices.into_iter().chain(far).collect(), faces).unwrap();
        let weld = Weld::new(&mesh);
        assert_eq!((weld.places.len(), weld.components().1), (6 + 4 + 2, 2));
    }

    /// Places as the rule has them: the first by cell, then by number, of those near enough.
    fn places_by_rule(mesh: &Mesh) -> Vec<u32> {
        let bounds = mesh.bounds();
        let cell = bounds.diagonal() * WELD_TOLERANCE;
        let key = |v: DVec3| ((v - bounds.min) / cell).to_array().map(|c| c.floor() as i64);
        let mut places: Vec<DVec3> = Vec::new();
        let place = |&v: &DVec3| {
            let order = |p: &DVec3| {
                let away: [i64; 3] = std::array::from_fn(|k| key(*p)[k] - key(v)[k]);
                away.iter().all(|d| d.abs() <= 1).then(|| away[0] + 3 * away[1] + 9 * away[2])
            };
            let near = |p: &DVec3| p.distance_squared(v) <= cell * cell;
            let known = (0u32..).zip(&places).filter(|(_, p)| near(p));
            let first = known.filter_map(|(i, p)| Some((order(p)?, i))).min();
            first.map_or_else(
                || {
                    places.push(v);
                    places.len() as u32 - 1
                },
                |f| f.1,
            )
        };
        mesh.vertices().iter().map(place).collect()
    }

    #[test]
    fn crowds_of_vertices_are_welded_by_the_rule() {
        let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(5);
        for spread in [1e-6, 4e-6, 3e-5] {
            let mut near = || DVec3::from_array([(); 3].map(|_| rng.random_range(0.0..spread)));
            let crowd: Vec<_> = (0..400).map(|k| near() + DVec3::splat(f64::from(k % 2))).collect();
            let faces = (0..398).map(|f| [f, f + 1, f + 2]).collect();
            let mesh = Mesh::new(crowd, faces).unwrap();
            assert_eq!(Weld::new(&mesh).place_of_vertex, places_by_rule(&mesh), "{spread}");
        }
    }

    #[test]
    fn repeated_vertices_are_one_place() {
        let weld = Weld::new(&seams());
        assert_eq!(weld.places.len(), 6 + 4);
        assert_eq!(weld.components(), (vec![0, 0, 0, 0, 1, 1], 2));
        let pairs: Vec<_> = weld.neighbours().iter().map(|n| (n.first, n.second)).collect();
        assert_eq!(pairs.len(), 4);
        assert!(pairs.contains(&(0, 3)), "the squares share the edge x = 1: {pairs:?}");
    }

    #[test]
    fn what_touches_in_one_place_is_apart() {
        let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
        let corners = [DVec3::ZERO, x, y, -x, x + z, y + z, z];
        let of = |faces: &[[u32; 3]]| {
            Weld::new(&Mesh::new(corners.to_vec(), faces.to_vec()).unwrap()).components()
        };
        assert_eq!(of(&[[0, 1, 2], [0, 4, 5], [0, 2, 3]]), (vec![0, 1, 0], 2));
        assert_eq!(
            of(&[[0, 1, 2], [4, 5, 6], [0, 6, 6]]),
            (vec![0, 1, 2], 3),
            "a sliver joins none"
        );
        let points = [[3, 3, 3], [0, 1, 2], [0, 2, 3], [0, 0, 1], [6, 6, 6], [6, 6, 6], [0, 0, 0]];
        assert_eq!(of(&points), (vec![0, 0, 0, 0, 1, 1, 0], 2));
    }

    #[test]
    fn the_nearest_point_of_a_triangle_is_inside_on_an_edge_or_a_corner() {
        let t = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let near = |x, y, z| nearest_on_triangle(DVec3::new(x, y, z), t);
        assert!((near(0.25, 0.25, 2.0) - DVec3::new(0.25, 0.25, 0.0)).length() < 1e-15);
        assert!((near(0.5, -1.0, 0.0) - DVec3::new(0.5, 0.0, 0.0)).length() < 1e-15);
        assert_eq!(near(3.0, -1.0, 1.0), DVec3::X);
        let flat =
            nearest_on_triangle(DVec3::new(1.5, 1.0, 0.0), [DVec3::ZERO, DVec3::X, DVec3::X * 2.0]);
        assert!((flat - DVec3::X * 1.5).length() < 1e-15, "a triangle without area: {flat}");
        assert_eq!(nearest_face(&seams(), DVec3::new(5.5, 2.0, 0.0)), (5, 1.0));
        assert_eq!(nearest_faces(&seams(), DVec3::new(5.5, 2.0, 0.0), 0.0), [5]);
    }

    /// As [`nearest_face`] and [`nearest_faces`] promise, without looking at boxes first.
    #[test]
    fn looking_at_boxes_first_finds_the_same_face() {
        let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(7);
        let mut place = || DVec3::from_array([(); 3].map(|()| rng.random_range(-1.0..1.0)));
        let mut corners: Vec<DVec3> = Vec::new();
        for round in 0..300 {
            let [a, b, c] = [(); 3].map(|()| place());
            let c = if round % 3 == 0 { a.lerp(b, 0.3) + (c - a) * 1e-9 } else { c };
            corners.extend([a, b, c].map(|x| if round % 2 == 0 { x * 0.1 } else { x }));
        }
        let faces = (0..300).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
        let mesh = Mesh::new(corners, faces).unwrap();
        let mut from: Vec<DVec3> = (0..200).map(|_| place()).collect();
        from.extend((0..300).map(|face| mesh.centroid(face)));
        from.extend(mesh.vertices());
        for p in from {
            let distance = |f: usize| nearest_on_triangle(p, mesh.corners(f)).distance(p);
            let all: Vec<f64> = (0..300).map(distance).collect();
            let least = all.iter().copied().fold(f64::INFINITY, f64::min);
            let first = all.iter().position(|d| *d == least).unwrap();
            assert_eq!(nearest_face(&mesh, p), (first, least));
            let near: Vec<usize> = (0..300).filter(|f| all[*f] <= least + 0.01).collect();
            assert_eq!(nearest_faces(&mesh, p, 0.01), near);
        }
    }

    #[test]
    fn no_place_on_a_triangle_is_nearer_than_the_nearest_however_thin_it_is() {
        let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(5);
        for round in 0..3000 {
            let mut place = || DVec3::from_array([(); 3].map(|()| rng.random_range(-1.0..1.0)));
            let [a, b, mut c, p] = [(); 4].map(|()| place());
            match round % 3 {
                0 => c = a.lerp(b, 0.3) + (c - a) * 1e-9,
                1 => c = a.lerp(b, 1.7),
                _ => {}
            }
            let found = nearest_on_triangle(p, [a, b, c]).distance(p);
            for (i, j) in (0..=12).flat_map(|i| (0..=12 - i).map(move |j| (i, j))) {
                let (u, v) = (f64::from(i) / 12.0, f64::from(j) / 12.0);
                let there = (a + (b - a) * u + (c - a) * v).distance(p);
                assert!(found <= there + 1e-7, "{a} {b} {c} from {p}: {found} > {there}");
            }
        }
    }
}
