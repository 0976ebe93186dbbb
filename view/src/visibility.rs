//! Which face each sample of each pixel sees: exact edge tests, nearest face wins, band by band.

use glamx::DVec3;
use object::Mesh;
use rayon::prelude::*;

use crate::camera::Camera;

/// The face of a pixel that sees none.
pub const NO_FACE: u32 = u32::MAX;
/// Sample positions in a pixel: its centre, whose finding is the pixel's own, and four around it on
/// a turned square, so that edges of every direction come out smooth.
pub(crate) const SAMPLES: [[f64; 2]; 5] =
    [[0.5, 0.5], [0.375, 0.125], [0.875, 0.375], [0.625, 0.875], [0.125, 0.625]];
/// Screen positions are rounded to this share of a pixel, which makes edge tests exact.
const SUBPIXEL: f64 = 256.0;
/// Rows drawn by one task.
pub(crate) const BAND: usize = 16;
/// A face must be nearer than what is there by this share to replace it: of two faces in one place
/// the first wins everywhere instead of speckling.
const TIE: f32 = 2e-6;
/// A triangle of fewer columns is drawn without asking where each row begins and ends.
const NARROW: usize = 6;
/// Nothing nearer than this share of the distance to the target is drawn.
const NEAR: f64 = 1e-3;

/// What a pixel's samples see.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Samples {
    /// One over the depth, per metre; zero for background.
    pub nearness: [f32; 5],
    /// The face, or [`NO_FACE`].
    pub face: [u32; 5],
}

const EMPTY: Samples = Samples { nearness: [0.0; 5], face: [NO_FACE; 5] };

/// What is kept of a pixel's samples once they are lit.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Seen {
    /// The face the centre sees, or [`NO_FACE`].
    pub face: u32,
    /// One over the depth of what the centre sees, per metre; zero for background.
    pub nearness: f32,
    /// The same for the nearest of the samples.
    pub nearest: f32,
}

impl Seen {
    /// Of a pixel.
    pub(crate) fn of(samples: &Samples) -> Self {
        let nearest = samples.nearness.iter().copied().fold(0.0, f32::max);
        Self { face: samples.face[0], nearness: samples.nearness[0], nearest }
    }
}

/// A mesh as it falls on a picture, its triangles sorted into bands of [`BAND`] rows.
pub(crate) struct Screen {
    width: usize,
    triangles: Vec<Triangle>,
    bands: Vec<Vec<u32>>,
}

impl Screen {
    /// Projects every face.
    pub(crate) fn new(mesh: &Mesh, camera: &Camera) -> Self {
        let [width, height] = camera.size.map(|n| n as usize);
        let triangles = screen_triangles(mesh, camera);
        let mut bands: Vec<Vec<u32>> = vec![Vec::new(); height.div_ceil(BAND)];
        for (t, triangle) in triangles.iter().enumerate() {
            let [top, bottom] = triangle.rows.map(|row| row / BAND);
            bands[top..=bottom].iter_mut().for_each(|band| band.push(t as u32));
        }
        Self { width, triangles, bands }
    }

    /// What the pixels of a band see, row by row; what was in `pixels` is forgotten.
    pub(crate) fn look(&self, band: usize, length: usize, pixels: &mut Vec<Samples>) {
        pixels.clear();
        pixels.resize(length, EMPTY);
        for &t in self.bands.get(band).into_iter().flatten() {
            self.triangles[t as usize].draw(pixels, self.width, band * BAND);
        }
    }
}

/// A corner on the screen: pixels, and one over the depth.
#[derive(Clone, Copy, Debug)]
struct Corner {
    x: f64,
    y: f64,
    nearness: f64,
}

/// A triangle ready to draw: inside where all three edge functions `a x + b y + c` are at
/// least zero.
#[derive(Clone, Debug)]
struct Triangle {
    face: u32,
    edges: [[f64; 3]; 3],
    nearness: [f64; 3],
    range: [f64; 2],
    rows: [usize; 2],
    columns: [usize; 2],
}

fn screen_triangles(mesh: &Mesh, camera: &Camera) -> Vec<Triangle> {
    let axes = camera.axes();
    let near = NEAR * camera.eye.distance(camera.target);
    let local = |p: &DVec3| axes.local(*p - camera.eye);
    let vertices: Vec<[f64; 3]> = mesh.vertices().par_iter().map(local).collect();
    let centre = camera.centre();
    let snap = |v: f64| (v * SUBPIXEL).round() / SUBPIXEL;
    let corner = |[x, y, depth]: [f64; 3]| {
        let scale = axes.focal / depth;
        let (x, y) = (snap(centre[0] + x * scale), snap(centre[1] - y * scale));
        Corner { x, y, nearness: 1.0 / depth }
    };
    let of_face = |(face, indices): (usize, &[u32; 3])| {
        let inside = clip(indices.map(|v| vertices[v as usize]), near);
        let corners: Vec<Corner> = inside.into_iter().map(corner).collect();
        let fan = corners.windows(2).skip(1).map(|w| [corners[0], w[0], w[1]]);
        let drawn = fan.filter_map(|c| Triangle::new(face as u32, c, camera.size));
        drawn.collect::<Vec<_>>()
    };
    mesh.faces().par_iter().enumerate().flat_map_iter(of_face).collect()
}

/// The part of a triangle in front of the near plane, a polygon of up to four corners.
fn clip(corners: [[f64; 3]; 3], near: f64) -> Vec<[f64; 3]> {
    if corners.iter().all(|c| c[2] >= near) {
        return corners.to_vec();
    }
    let mut inside = Vec::new();
    for (i, &a) in corners.iter().enumerate() {
        let b = corners[(i + 1) % 3];
        if a[2] >= near {
            inside.push(a);
        }
        if (a[2] >= near) != (b[2] >= near) {
            let t = (near - a[2]) / (b[2] - a[2]);
            inside.push([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), near]);
        }
    }
    inside
}

impl Triangle {
    /// None for a triangle that covers no sample: seen edge on, or outside the picture.
    fn new(face: u32, [a, b, c]: [Corner; 3], size: [u32; 2]) -> Option<Self> {
        let area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
        if area == 0.0 || !area.is_finite() {
            return None;
        }
        let [a, b, c] = if area > 0.0 { [a, b, c] } else { [a, c, b] };
        let span = |pick: fn(&Corner) -> f64, n: u32| {
            let values = [a, b, c].map(|corner| pick(&corner));
            let low = values.into_iter().fold(f64::INFINITY, f64::min).floor().max(0.0);
            let high = values.into_iter().fold(f64::NEG_INFINITY, f64::max).ceil();
            let high = high.min(f64::from(n)) - 1.0;
            (low <= high).then_some([low as usize, high as usize])
        };
        let (columns, rows) = (span(|p| p.x, size[0])?, span(|p| p.y, size[1])?);
        let edges = [edge(b, c), edge(c, a), edge(a, b)];
        let weights = [a, b, c].map(|p| p.nearness / area.abs());
        let nearness = std::array::from_fn(|i| (0..3).map(|k| weights[k] * edges[k][i]).sum());
        let near = [a, b, c].map(|p| p.nearness);
        let range = [near[0].min(near[1]).min(near[2]), near[0].max(near[1]).max(near[2])];
        Some(Self { face, edges, nearness, range, rows, columns })
    }

    /// Draws into a band of rows that starts at row `first`.
    fn draw(&self, pixels: &mut [Samples], width: usize, first: usize) {
        let last = first + pixels.len() / width - 1;
        let steps = Steps::of(self);
        for row in self.rows[0].max(first)..=self.rows[1].min(last) {
            let [left, right] = self.columns_in(row as f64);
            let start = (row - first) * width;
            let Some(run) = pixels.get_mut(start + left..start + right) else { continue };
            for (i, pixel) in run.iter_mut().enumerate() {
                self.cover(&steps, pixel, (left + i) as f64, row as f64);
            }
        }
    }

    /// The first and one past the last column of a row whose pixels the triangle may touch, from
    /// where its edges cross the row; all its columns where that would not save anything.
    fn columns_in(&self, row: f64) -> [usize; 2] {
        let [left, right] = self.columns;
        if right - left < NARROW {
            return [left, right + 1];
        }
        let (mut low, mut high) = (left as f64, right as f64);
        for [a, b, c] in self.edges {
            let most = (b * row).max(b * (row + 1.0)) + c;
            if a > 0.0 {
                low = low.max(-most / a - 1.0);
            } else if a < 0.0 {
                high = high.min(-most / a);
            }
        }
        [(low as usize).max(left), (high as usize).min(right) + 1]
    }

    fn cover(&self, steps: &Steps, pixel: &mut Samples, x: f64, y: f64) {
        let at = |[a, b, c]: [f64; 3]| a * x + b * y + c;
        let [p, q, r] = [at(self.edges[0]), at(self.edges[1]), at(self.edges[2])];
        let [most_p, most_q, most_r] = steps.most;
        if (p + most_p).min(q + most_q).min(r + most_r) < 0.0 {
            return;
        }
        let [low, high] = self.range;
        let [a, b, c, d, e] = pixel.nearness;
        let furthest = a.min(b).min(c.min(d)).min(e);
        if high as f32 <= furthest {
            return;
        }
        let corner = at(self.nearness);
        let Steps { p: dp, q: dq, r: dr, near, .. } = steps;
        for s in 0..SAMPLES.len() {
            let inside = (p + dp[s] >= 0.0) & (q + dq[s] >= 0.0) & (r + dr[s] >= 0.0);
            let nearness = (corner + near[s]).max(low).min(high) as f32;
            let wins = inside & (nearness > pixel.nearness[s] * (1.0 + TIE));
            pixel.nearness[s] = if wins { nearness } else { pixel.nearness[s] };
            pixel.face[s] = if wins { self.face } else { pixel.face[s] };
        }
    }
}

/// From a pixel's corner to each of its samples: the change of the three edge functions and of the
/// nearness; and the most each edge function gains on the way.
struct Steps {
    p: [f64; SAMPLES.len()],
    q: [f64; SAMPLES.len()],
    r: [f64; SAMPLES.len()],
    near: [f64; SAMPLES.len()],
    most: [f64; 3],
}

impl Steps {
    fn of(t: &Triangle) -> Self {
        let none = [0.0; SAMPLES.len()];
        let mut steps =
            Self { p: none, q: none, r: none, near: none, most: [f64::NEG_INFINITY; 3] };
        let step = |[a, b, _]: [f64; 3], [dx, dy]: [f64; 2]| a * dx + b * dy;
        for (s, &to) in SAMPLES.iter().enumerate() {
            let of_edge = [step(t.edges[0], to), step(t.edges[1], to), step(t.edges[2], to)];
            [steps.p[s], steps.q[s], steps.r[s]] = of_edge;
            steps.near[s] = step(t.nearness, to);
            for (most, gain) in steps.most.iter_mut().zip(of_edge) {
                *most = if gain > *most { gain } else { *most };
            }
        }
        steps
    }
}

/// The line from p to q as a function that is positive on its left side on the screen, y down, and
/// at least zero for the samples that belong to that side: a sample on the line itself belongs to
/// one of its two sides only. Positions are multiples of 2⁻⁸, samples of 2⁻³, so that no value is
/// nearer to zero than 2⁻¹⁹ without being zero.
fn edge(p: Corner, q: Corner) -> [f64; 3] {
    const LESS_THAN_ANY: f64 = 1.0 / 1_048_576.0;
    let (a, b) = (p.y - q.y, q.x - p.x);
    let keeps_its_line = a > 0.0 || (a == 0.0 && b > 0.0);
    let bias = if keeps_its_line { 0.0 } else { LESS_THAN_ANY };
    [a, b, -(a * p.x + b * p.y) - bias]
}
