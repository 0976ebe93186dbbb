//! How open to the sky each visible point is: corners and gaps come out darker, which lets a
//! person see depth. Found from the depth of neighbouring pixels, at half resolution.

use rayon::prelude::*;

use crate::camera::Camera;
use crate::shade::Shaded;
use crate::visibility::Seen;

/// Points looked at around each pixel.
const LOOKS: usize = 12;
/// How far it looks, as a share of the object's diagonal.
const REACH: f64 = 0.07;
/// How dark a closed corner gets.
const STRENGTH: f32 = 0.85;
/// Golden angle, radians: each look turns by it, so that looks never line up.
const TURN: f32 = 2.399_963;

/// A pixel of the half-resolution picture: position in the camera's frame and normal.
#[derive(Clone, Copy)]
struct Point {
    place: [f32; 3],
    normal: [f32; 3],
}

struct Small {
    size: [usize; 2],
    points: Vec<Point>,
    focal: f32,
    reach: f32,
    looks: [[[f32; 2]; LOOKS]; PATTERNS],
}

/// Looking directions differ between the pixels of each 4 by 4 block, and a blur joins them again.
const PATTERNS: usize = 16;

/// Where each pattern looks: points of a spiral in the unit disc.
fn looks() -> [[[f32; 2]; LOOKS]; PATTERNS] {
    let look = |pattern: usize, k: usize| {
        let start = pattern as f32;
        let share = (k as f32 + 0.5 + start / PATTERNS as f32) / (LOOKS as f32 + 1.0);
        let (sin, cos) = (k as f32 * TURN + start * 0.7).sin_cos();
        [cos * share, sin * share]
    };
    std::array::from_fn(|pattern| std::array::from_fn(|k| look(pattern, k)))
}

/// For every pixel the share of light that gets there.
pub(crate) struct Openness {
    /// None for a picture too small to have halves.
    small: Option<(Small, Vec<f32>)>,
}

impl Openness {
    /// Looks around every second pixel of every second row.
    pub(crate) fn new(camera: &Camera, seen: &[Seen], shaded: &[Shaded], diagonal: f64) -> Self {
        if camera.size[0] < 2 || camera.size[1] < 2 {
            return Self { small: None };
        }
        let small = Small::new(camera, seen, shaded, (REACH * diagonal) as f32);
        let points = (0..small.points.len()).into_par_iter().with_min_len(2048);
        let raw: Vec<f32> = points.map(|i| small.closed(i)).collect();
        let across = small.blurred(&raw, [1, 0]);
        let smooth = small.blurred(&across, [0, 1]);
        Self { small: Some((small, smooth)) }
    }

    /// The share of light that gets to a pixel that sees this, 1 in the open.
    pub(crate) fn at(&self, pixel: [usize; 2], seen: &Seen) -> f32 {
        let Some((small, smooth)) = &self.small else { return 1.0 };
        1.0 - STRENGTH * small.at(smooth, pixel, seen.nearest)
    }
}

impl Small {
    fn new(camera: &Camera, seen: &[Seen], shaded: &[Shaded], reach: f32) -> Self {
        let [width, height] = camera.size.map(|n| n as usize);
        let size = [width / 2, height / 2];
        let axes = camera.axes();
        let (cx, cy, focal) = (width as f32 / 2.0, height as f32 / 2.0, axes.focal as f32);
        let [right, up, forward] =
            [axes.right, axes.up, axes.forward].map(|a| a.to_array().map(|c| c as f32));
        let point = |i: usize| {
            let (x, y) = (i % size[0] * 2, i / size[0] * 2);
            let full = y * width + x;
            let nearness = seen[full].nearness;
            let depth = if nearness > 0.0 { 1.0 / nearness } else { f32::INFINITY };
            let (dx, dy) = (x as f32 + 0.5 - cx, cy - y as f32 - 0.5);
            let place = [dx / focal * depth, dy / focal * depth, depth];
            let n = shaded[full].normal;
            Point { place, normal: [dot(n, right), dot(n, up), dot(n, forward)] }
        };
        let points = (0..size[0] * size[1]).into_par_iter().with_min_len(4096).map(point);
        Self { size, points: points.collect(), focal: focal / 2.0, reach, looks: looks() }
    }

    /// How closed in a point is, 0 to 1.
    fn closed(&self, i: usize) -> f32 {
        let Point { place, normal } = self.points[i];
        if !place[2].is_finite() {
            return 0.0;
        }
        let (x, y) = ((i % self.size[0]) as f32, (i / self.size[0]) as f32);
        let radius = (self.reach * self.focal / place[2]).clamp(3.0, 60.0);
        let pattern = i % self.size[0] % 4 * 4 + i / self.size[0] % 4;
        let mut sum = 0.0;
        for [dx, dy] in self.looks[pattern] {
            let (u, v) = (x + dx * radius, y + dy * radius);
            if u < 0.0 || v < 0.0 || u >= self.size[0] as f32 || v >= self.size[1] as f32 {
                continue;
            }
            let other = self.points[v as usize * self.size[0] + u as usize].place;
            if other[2].is_finite() {
                sum += self.shadow(place, normal, other);
            }
        }
        (2.2 * sum / LOOKS as f32).min(1.0)
    }

    /// How much one neighbour shades a point: much if it stands up steeply and close by.
    fn shadow(&self, place: [f32; 3], normal: [f32; 3], other: [f32; 3]) -> f32 {
        let v: [f32; 3] = std::array::from_fn(|c| other[c] - place[c]);
        let squared = dot(v, v);
        let near = 1.0 - squared / (self.reach * self.reach);
        if near <= 0.0 || squared == 0.0 {
            return 0.0;
        }
        let rise = dot(v, normal) / squared.sqrt();
        (rise - 0.08).max(0.0) * near * near
    }

    /// Mean with neighbours along one direction that lie at about the same depth.
    fn blurred(&self, values: &[f32], step: [i32; 2]) -> Vec<f32> {
        let [width, height] = self.size.map(|n| n as i32);
        let pixel = |i: usize| {
            let (x, y) = (i as i32 % width, i as i32 / width);
            let depth = self.points[i].place[2];
            if !depth.is_finite() {
                return 0.0;
            }
            let (mut sum, mut weight) = (0.0, 0.0);
            for k in -2..=2 {
                let (u, v) = (x + k * step[0], y + k * step[1]);
                if u < 0 || v < 0 || u >= width || v >= height {
                    continue;
                }
                let j = (v * width + u) as usize;
                let apart = (self.points[j].place[2] - depth).abs() / self.reach;
                let w = (1.0 - 4.0 * apart).max(0.0);
                if w > 0.0 {
                    sum += w * values[j];
                    weight += w;
                }
            }
            if weight > 0.0 { sum / weight } else { 0.0 }
        };
        (0..values.len()).into_par_iter().with_min_len(4096).map(pixel).collect()
    }

    /// The value at a full-resolution pixel, mixed from the four around it at its depth.
    fn at(&self, values: &[f32], [x, y]: [usize; 2], nearness: f32) -> f32 {
        if nearness <= 0.0 {
            return 0.0;
        }
        let depth = 1.0 / nearness;
        let (u, v) = (x as f32 / 2.0, y as f32 / 2.0);
        let (mut sum, mut weight) = (0.0, 1e-6);
        for (du, dv) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let i = (u as usize + du).min(self.size[0] - 1);
            let j = (v as usize + dv).min(self.size[1] - 1);
            let k = j * self.size[0] + i;
            let apart = (self.points[k].place[2] - depth).abs() / self.reach;
            let near = if apart.is_finite() { (1.0 - 4.0 * apart).max(0.001) } else { 0.0 };
            let mix = |f: f32, d: usize| if d == 1 { f.fract() } else { 1.0 - f.fract() };
            let w = near * (mix(u, du) * mix(v, dv)).max(0.001);
            sum += w * values[k];
            weight += w;
        }
        sum / weight
    }
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
