//! Five small objects, each with what the others lack: components, a fused mesh, cut up bodies, no points,
//! no texts. All coordinates are sums, products and square roots, so they are the same everywhere.

use object::weld::{nearest_face, nearest_on_triangle};
use object::{Condition, DVec3, KinematicTree, Mesh, Part};

/// A surface in the making.
#[derive(Default)]
struct Shape {
    vertices: Vec<DVec3>,
    faces: Vec<[u32; 3]>,
}

/// The faces of a box: which four corners each side has.
const SIDES: [[usize; 4]; 6] =
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

impl Shape {
    fn add(&mut self, points: &[DVec3], faces: &[[u32; 3]]) {
        let base = self.vertices.len() as u32;
        self.vertices.extend(points);
        self.faces.extend(faces.iter().map(|f| f.map(|v| v + base)));
    }

    /// A box.
    fn block(self, min: [f64; 3], max: [f64; 3]) -> Self {
        self.shell(min, max, &[])
    }

    /// A box without some of its sides: −z, +z, −y, +y, −x, +x.
    fn shell(mut self, min: [f64; 3], max: [f64; 3], without: &[usize]) -> Self {
        let at = |i: u32| {
            DVec3::from_array([0, 1, 2].map(|k| if i >> k & 1 == 0 { min[k] } else { max[k] }))
        };
        let sides = (0..6).filter(|side| !without.contains(side)).map(|side| SIDES[side]);
        let faces: Vec<[u32; 3]> = sides
            .flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]])
            .map(|f| f.map(|v| v as u32))
            .collect();
        self.add(&(0..8).map(at).collect::<Vec<_>>(), &faces);
        self
    }

    /// A round bar of radius `r` along an axis, 0 to 2, from `a` to a coordinate.
    fn bar(mut self, a: [f64; 3], (axis, to): (usize, f64), r: f64) -> Self {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let ring = |along: f64| {
            circle().map(move |[s, t]| {
                let mut p = a;
                (p[axis], p[u], p[v]) = (along, a[u] + r * s, a[v] + r * t);
                DVec3::from_array(p)
            })
        };
        let (low, high) = (a[axis].min(to), a[axis].max(to));
        let mut ends = [DVec3::from_array(a); 2];
        (ends[0][axis], ends[1][axis]) = (low, high);
        let points: Vec<DVec3> = ring(low).into_iter().chain(ring(high)).chain(ends).collect();
        let n = ROUND as u32;
        let side = |i: u32| {
            let j = (i + 1) % n;
            [[i, j, n + j], [i, n + j, n + i], [2 * n, j, i], [2 * n + 1, n + i, n + j]]
        };
        self.add(&points, &(0..n).flat_map(side).collect::<Vec<_>>());
        self
    }

    /// A slab in one mesh whose front, towards −y, stands out as `height` says at x and z; `cells` along
    /// x and z.
    fn relief(
        mut self,
        (min, max): ([f64; 3], [f64; 3]),
        [nx, nz]: [u32; 2],
        height: impl Fn(f64, f64) -> f64,
    ) -> Self {
        let along =
            |k: usize, i: u32, n: u32| min[k] + (max[k] - min[k]) * f64::from(i) / f64::from(n);
        let place = |i: u32, j: u32| (along(0, i, nx), along(2, j, nz));
        let front = |(i, j): (u32, u32)| {
            let (x, z) = place(i, j);
            DVec3::new(x, min[1] - height(x, z), z)
        };
        let number = |i: u32, j: u32| i * (nz + 1) + j;
        let grid = (0..=nx).flat_map(|i| (0..=nz).map(move |j| (i, j)));
        let mut points: Vec<DVec3> = grid.map(front).collect();
        let mut faces = Vec::new();
        for (i, j) in (0..nx).flat_map(|i| (0..nz).map(move |j| (i, j))) {
            let [a, b, c, d] =
                [number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)];
            faces.extend([[a, b, c], [a, c, d]]);
        }
        let rim: Vec<(u32, u32)> = (0..nx)
            .map(|i| (i, 0))
            .chain((0..nz).map(|j| (nx, j)))
            .chain((1..=nx).rev().map(|i| (i, nz)))
            .chain((1..=nz).rev().map(|j| (0, j)))
            .collect();
        let (first, count) = (points.len() as u32, rim.len() as u32);
        for &(i, j) in &rim {
            let (x, z) = place(i, j);
            points.push(DVec3::new(x, max[1], z));
        }
        let middle = [(min[0] + max[0]) / 2.0, max[1], (min[2] + max[2]) / 2.0];
        points.push(DVec3::from_array(middle));
        for k in 0..count {
            let l = (k + 1) % count;
            let [a, b] = [k, l].map(|k| number(rim[k as usize].0, rim[k as usize].1));
            let (c, d) = (first + l, first + k);
            faces.extend([[b, a, d], [b, d, c], [first + count, c, d]]);
        }
        self.add(&points, &faces);
        self
    }

    fn mesh(&self) -> Mesh {
        Mesh::new(self.vertices.clone(), self.faces.clone()).unwrap()
    }
}

/// Corners of a round thing.
const ROUND: usize = 16;

/// Sixteen points of the unit circle, in order.
fn circle() -> [[f64; 2]; ROUND] {
    let half = |c: f64| ((1.0 + c) / 2.0).sqrt();
    let eighth = half(0.5_f64.sqrt());
    let steps = [1.0, eighth, 0.5_f64.sqrt(), (1.0 - eighth * eighth).sqrt()];
    std::array::from_fn(|i| {
        let (quarter, step) = (i / 4, i % 4);
        let (c, s) = (steps[step], if step == 0 { 0.0 } else { steps[4 - step] });
        [[c, s], [-s, c], [-c, -s], [s, -c]][quarter]
    })
}

/// 1 inside a box of x and z, falling to 0 over `rim` around it.
fn plate([x, z]: [f64; 2], (min, max): ([f64; 2], [f64; 2]), rim: f64) -> f64 {
    let off = [x, z].into_iter().enumerate().map(|(k, p)| (min[k] - p).max(p - max[k]).max(0.0));
    (1.0 - off.fold(0.0, f64::max) / rim).max(0.0)
}

/// 1 in the middle of a disc, falling to 0 at its rim as a dome does.
fn dome([x, z]: [f64; 2], middle: [f64; 2], radius: f64) -> f64 {
    let square = (x - middle[0]).powi(2) + (z - middle[1]).powi(2);
    (1.0 - square / radius.powi(2)).max(0.0).sqrt()
}

/// A condition for a mesh; its points are moved onto the surface where they are a little off.
fn condition(mesh: &Mesh, category: &str, parts: &str) -> Condition {
    let head = r#""schema": "kinfold-condition/1", "up": "z""#;
    let text = format!(r#"{{{head}, "category": "{category}", "parts": [{parts}]}}"#);
    let mut condition = Condition::from_json(&text).unwrap();
    condition.check_points(mesh).unwrap();
    for point in condition.prompts.iter_mut().filter_map(|prompt| prompt.point.as_mut()) {
        *point = nearest_on_triangle(*point, mesh.corners(nearest_face(mesh, *point).0));
    }
    condition
}

/// The object that consists of components: what is pointed at is whole, and one wheel is found by its
/// likeness to the other.
pub(in crate::classic) fn components() -> (Mesh, Condition) {
    let panel = |s: Shape, min: [f64; 3], max: [f64; 3]| s.block(min, max);
    let body = panel(Shape::default(), [-0.30, 0.0, 0.0], [-0.28, 0.5, 0.6]);
    let body = panel(body, [0.28, 0.0, 0.0], [0.30, 0.5, 0.6]);
    let body = panel(body, [-0.28, 0.0, 0.0], [0.28, 0.5, 0.02]);
    let body = panel(body, [-0.28, 0.0, 0.38], [0.28, 0.5, 0.40]);
    let body = panel(body, [-0.28, 0.48, 0.02], [0.28, 0.5, 0.38]);
    let door = body
        .block([-0.29, -0.025, 0.01], [0.29, -0.004, 0.39])
        .block([0.22, -0.06, 0.15], [0.24, -0.024, 0.25])
        .bar([-0.30, -0.015, 0.04], (2, 0.12), 0.012)
        .bar([-0.30, -0.015, 0.28], (2, 0.36), 0.012)
        .bar([-0.30, -0.015, 0.02], (2, 0.38), 0.005)
        .block([-0.315, -0.01, 0.015], [-0.29, 0.03, 0.022]);
    let knob = door
        .bar([0.05, -0.05, 0.31], (1, -0.0245), 0.022)
        .block([0.045, -0.056, 0.30], [0.055, -0.0495, 0.33]);
    let drawers = knob
        .block([-0.27, -0.02, 0.41], [-0.01, 0.0, 0.59])
        .block([-0.27, 0.0, 0.42], [-0.01, 0.4, 0.43])
        .block([-0.16, -0.04, 0.49], [-0.12, -0.019, 0.51])
        .block([0.01, -0.02, 0.41], [0.27, 0.0, 0.59])
        .block([0.01, 0.0, 0.42], [0.27, 0.4, 0.43])
        .block([0.12, -0.04, 0.49], [0.16, -0.019, 0.51])
        .block([0.20, 0.01, 0.44], [0.26, 0.2, 0.52]);
    let lid = drawers
        .block([-0.30, -0.01, 0.60], [0.30, 0.5, 0.62])
        .block([-0.04, -0.03, 0.605], [0.04, -0.0095, 0.615]);
    let wheel = |s: Shape, x: f64, y: f64| {
        s.bar([x, y, -0.05], (0, x + 0.03), 0.045).bar([x - 0.012, y, -0.05], (0, x + 0.042), 0.01)
    };
    let mesh = wheel(wheel(lid, -0.26, 0.1), 0.20, 0.1).mesh();
    let condition = condition(
        &mesh,
        "kitchen cabinet",
        r#"{"name": "body", "text": "cabinet body", "point": [0.30, 0.25, 0.3]},
           {"name": "door", "text": "front door with handle", "parent": "body", "joint": "revolute", "point": [0.1, -0.025, 0.12]},
           {"name": "knob", "text": "small knob", "parent": "door", "joint": "continuous", "point": [0.06, -0.05, 0.305]},
           {"name": "drawer_1", "text": "left drawer", "parent": "body", "joint": "prismatic", "point": [-0.2, -0.02, 0.45]},
           {"name": "drawer_2", "text": "right drawer", "parent": "body", "joint": "prismatic", "point": [0.2, -0.02, 0.45]},
           {"name": "lid", "text": "top lid", "parent": "body", "joint": "revolute", "point": [0.1, 0.2, 0.62]},
           {"name": "wheel_1", "text": "left wheel", "parent": "body", "joint": "continuous", "point": [-0.23, 0.11, -0.03]},
           {"name": "wheel_2", "text": "right wheel", "parent": "body", "joint": "continuous"}"#,
    );
    (mesh, condition)
}

/// The object that is one fused mesh: a door with a rim, three keys of which the third is drawn out, a
/// knob, over a panel that is folded a little here and there.
pub(in crate::classic) fn fused() -> (Mesh, Condition) {
    let height = |x: f64, z: f64| {
        let p = [x, z];
        let fold = 0.09 * (z - 0.28).abs().min(0.06) + 0.12 * (x - 0.44).abs().min(0.05);
        let door = 0.02 * plate(p, ([0.06, 0.06], [0.28, 0.34]), 0.02)
            + 0.012 * plate(p, ([0.24, 0.14], [0.26, 0.24]), 0.02);
        let key = |at: f64| 0.012 * plate(p, ([at - 0.012, 0.30], [at + 0.012, 0.33]), 0.016);
        let long = 0.010 * plate(p, ([0.49, 0.20], [0.53, 0.33]), 0.03);
        let knob = 0.035 * dome(p, [0.42, 0.12], 0.065);
        fold + door.max(knob).max(key(0.36)).max(key(0.43)).max(key(0.50).max(long))
    };
    let mesh =
        Shape::default().relief(([0.0, 0.0, 0.0], [0.56, 0.16, 0.40]), [28, 20], height).mesh();
    let condition = condition(
        &mesh,
        "control panel",
        r#"{"name": "panel", "point": [0.3, 0.16, 0.2]},
           {"name": "door", "text": "cover door", "parent": "panel", "joint": "revolute", "point": [0.15, -0.03, 0.2]},
           {"name": "key_1", "text": "first key", "parent": "panel", "joint": "prismatic", "point": [0.36, -0.022, 0.315]},
           {"name": "key_2", "text": "second key", "parent": "panel", "joint": "prismatic", "point": [0.43, -0.017, 0.315]},
           {"name": "key_3", "text": "third key", "parent": "panel", "joint": "prismatic", "point": [0.50, -0.02, 0.315]},
           {"name": "knob", "text": "control knob", "parent": "panel", "joint": "continuous", "point": [0.42, -0.045, 0.12]}"#,
    );
    (mesh, condition)
}

/// The object whose bodies are cut up: a front in one mesh with a hatch, which is more than half of the
/// surface and less than nearly all, a lid in three pieces, a drawer in shells that are open at their cuts.
pub(in crate::classic) fn cut_up() -> (Mesh, Condition) {
    let height = |x: f64, z: f64| {
        let p = [x, z];
        0.018 * plate(p, ([0.08, 0.08], [0.32, 0.28]), 0.02) + 0.03 * dome(p, [0.46, 0.2], 0.08)
            - 0.1 * (x - 0.2).abs().min(0.05)
    };
    let front = Shape::default().relief(([0.0, 0.0, 0.0], [0.56, 0.30, 0.40]), [20, 14], height);
    let lid = front
        .block([0.0, 0.0, 0.405], [0.19, 0.30, 0.425])
        .shell([0.1901, 0.0, 0.405], [0.38, 0.30, 0.425], &[4, 5])
        .shell([0.3801, 0.0, 0.405], [0.56, 0.30, 0.425], &[4])
        .bar([0.05, 0.30, 0.415], (0, 0.15), 0.012)
        .bar([0.41, 0.30, 0.415], (0, 0.51), 0.012);
    let drawer = lid
        .block([0.0, 0.02, -0.09], [0.02, 0.30, -0.002])
        .block([0.54, 0.02, -0.09], [0.56, 0.30, -0.002])
        .shell([0.03, 0.0, -0.085], [0.28, 0.02, -0.01], &[5])
        .shell([0.2801, 0.0, -0.085], [0.53, 0.02, -0.01], &[4])
        .shell([0.03, 0.0201, -0.085], [0.53, 0.15, -0.075], &[3])
        .shell([0.03, 0.1501, -0.085], [0.53, 0.28, -0.075], &[2])
        .block([0.25, -0.02, -0.05], [0.31, 0.001, -0.04]);
    let mesh = drawer.mesh();
    let condition = condition(
        &mesh,
        "washing machine",
        r#"{"name": "body", "point": [0.3, 0.30, 0.35]},
           {"name": "hatch", "text": "round hatch", "parent": "body", "joint": "revolute", "point": [0.2, -0.018, 0.18]},
           {"name": "dial", "text": "dial on the front", "parent": "body", "joint": "continuous", "point": [0.46, -0.03, 0.2]},
           {"name": "lid", "text": "lid", "parent": "body", "joint": "revolute", "point": [0.28, 0.15, 0.425]},
           {"name": "drawer", "text": "lower drawer", "parent": "body", "joint": "prismatic", "point": [0.1, 0.0, -0.05]}"#,
    );
    (mesh, condition)
}

/// The object nobody points at: a desk with drawers, casters and a lamp's arm.
pub(in crate::classic) fn no_points() -> (Mesh, Condition) {
    let leg = |s: Shape, x: f64, y: f64| s.block([x, y, 0.05], [x + 0.05, y + 0.05, 0.7]);
    let drawer = |s: Shape, x: f64, z: f64| s.block([x, -0.34, z], [x + 0.35, 0.25, z + 0.12]);
    let desk = Shape::default().block([-0.7, -0.35, 0.7], [0.7, 0.35, 0.73]);
    let desk = leg(leg(leg(leg(desk, -0.69, -0.34), 0.64, -0.34), -0.69, 0.29), 0.64, 0.29);
    let desk = drawer(drawer(drawer(desk, 0.24, 0.57), 0.24, 0.44), -0.59, 0.57);
    let caster = |s: Shape, x: f64, y: f64| s.bar([x, y, 0.026], (0, x + 0.02), 0.024);
    let desk = caster(caster(desk, -0.675, -0.315), 0.655, -0.315);
    let mesh = desk
        .bar([0.5, 0.2, 0.73], (2, 0.74), 0.06)
        .block([0.49, 0.19, 0.741], [0.51, 0.21, 1.05])
        .block([0.38, 0.17, 1.051], [0.52, 0.23, 1.08])
        .mesh();
    let condition = condition(
        &mesh,
        "writing desk",
        r#"{"name": "desk"},
           {"name": "a", "text": "upper right drawer", "parent": "desk", "joint": "prismatic"},
           {"name": "b", "text": "lower right drawer", "parent": "desk", "joint": "prismatic"},
           {"name": "c", "text": "left drawer", "parent": "desk", "joint": "prismatic"},
           {"name": "d", "text": "left caster wheel", "parent": "desk", "joint": "continuous"},
           {"name": "e", "text": "right caster wheel", "parent": "desk", "joint": "continuous"},
           {"name": "f", "text": "lamp arm", "parent": "desk", "joint": "revolute"},
           {"name": "g", "text": "tilting lamp head", "parent": "f", "joint": "revolute"}"#,
    );
    (mesh, condition)
}

/// The object nobody says anything of: points and joints alone, on a mesh of which four fifths are fused.
pub(in crate::classic) fn no_texts() -> (Mesh, Condition) {
    let height = |x: f64, z: f64| {
        let p = [x, z];
        let plates = 0.016 * plate(p, ([0.04, 0.04], [0.16, 0.16]), 0.02)
            + 0.016 * plate(p, ([0.24, 0.04], [0.36, 0.16]), 0.02);
        plates
            + 0.02 * plate(p, ([0.06, 0.22], [0.30, 0.24]), 0.014)
            + 0.08 * (x - 0.2).abs().min(0.1)
    };
    let slab = Shape::default().relief(([0.0, 0.0, 0.0], [0.40, 0.12, 0.28]), [20, 14], height);
    let mesh = slab
        .block([0.42, 0.0, 0.0], [0.45, 0.12, 0.26])
        .bar([0.40, 0.06, 0.26], (0, 0.45), 0.012)
        .bar([0.10, 0.06, 0.29], (2, 0.2801), 0.02)
        .block([0.07, 0.055, 0.29], [0.13, 0.065, 0.30])
        .mesh();
    let mut condition = condition(
        &mesh,
        "",
        r#"{"name": "a", "point": [0.2, 0.12, 0.14]},
           {"name": "b", "parent": "a", "joint": "prismatic", "point": [0.1, -0.024, 0.1]},
           {"name": "c", "parent": "a", "joint": "revolute", "point": [0.3, -0.024, 0.1]},
           {"name": "d", "parent": "a", "joint": "prismatic", "point": [0.2, -0.02, 0.23]},
           {"name": "e", "parent": "a", "joint": "revolute", "point": [0.45, 0.06, 0.1]},
           {"name": "f", "parent": "a", "joint": ["prismatic", "continuous"], "point": [0.11, 0.065, 0.295]}"#,
    );
    let wordless = |p: &Part| Part { text: String::new(), ..p.clone() };
    condition.tree =
        KinematicTree::new(condition.tree.parts().iter().map(wordless).collect()).unwrap();
    (mesh, condition)
}
