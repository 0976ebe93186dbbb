//! Fine dark lines where one thing ends and another begins: outlines, steps, creases and borders
//! between parts, so that a surface without colours can be read.

use rayon::prelude::*;

use crate::raster::{NO_FACE, Shaded};
use crate::visibility::Samples;

const OUTLINE: f32 = 0.85;
const STEP: f32 = 0.75;
const CREASE: f32 = 0.42;
const BORDER: f32 = 0.65;
/// Cosine below which two neighbouring normals make a crease (about 32°).
const BEND: f32 = 0.85;
/// Width of a picture in which lines have full strength; in smaller ones they would smother.
const FULL_SIZE: f32 = 900.0;

/// What lines are found from.
pub(crate) struct Line<'a> {
    pub size: [u32; 2],
    pub samples: &'a [Samples],
    pub shaded: &'a [Shaded],
    /// Depth difference that counts as a step, metres.
    pub step: f64,
    /// The part of a face, where parts are known.
    pub part: &'a (dyn Fn(u32) -> Option<u16> + Sync),
}

/// How dark the line through each pixel is, 0 to 1.
pub(crate) fn line_strength(line: &Line<'_>) -> Vec<f32> {
    let [width, height] = line.size.map(|n| n as usize);
    let scale = (width.min(height) as f32 / FULL_SIZE).min(1.0);
    let pixel = |i: usize| scale * line.at(i % width, i / width);
    let raw: Vec<f32> =
        (0..line.samples.len()).into_par_iter().with_min_len(4096).map(pixel).collect();
    soften(&raw, width, height)
}

impl Line<'_> {
    fn at(&self, x: usize, y: usize) -> f32 {
        let [width, height] = self.size.map(|n| n as usize);
        let i = y * width + x;
        if self.samples[i].face[0] == NO_FACE {
            return 0.0;
        }
        let along = |from: Option<usize>, to: Option<usize>| match (from, to) {
            (Some(from), Some(to)) => self.between(i, from, to),
            _ => 0.0,
        };
        let left = x.checked_sub(1).map(|_| i - 1);
        let right = (x + 1 < width).then_some(i + 1);
        let above = y.checked_sub(1).map(|_| i - width);
        let below = (y + 1 < height).then_some(i + width);
        along(left, right).max(along(above, below))
    }

    /// The strongest line at pixel `i` between its neighbours `a` and `b` on opposite sides.
    fn between(&self, i: usize, a: usize, b: usize) -> f32 {
        let [here, one, two] = [i, a, b].map(|k| &self.samples[k]);
        if one.face[0] == NO_FACE || two.face[0] == NO_FACE {
            return OUTLINE;
        }
        if here.face[0] == one.face[0] && here.face[0] == two.face[0] {
            return 0.0;
        }
        // One over the depth is linear on a plane: its bend tells a step from a slope.
        let bend = 2.0 * here.nearness[0] - one.nearness[0] - two.nearness[0];
        let depth = 1.0 / here.nearness[0];
        let step = bend * depth * depth / self.step as f32;
        let mut strength = STEP * ((step - 0.3) / 0.7).clamp(0.0, 1.0);
        if (self.part)(here.face[0]) != (self.part)(two.face[0]) {
            strength = strength.max(BORDER);
        }
        let bent = dot(self.shaded[i].normal, self.shaded[b].normal);
        if bent < BEND {
            strength = strength.max(CREASE * ((BEND - bent) / 0.3).clamp(0.0, 1.0));
        }
        strength
    }
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// A little blur (1 2 1 both ways) takes the stairs out of slanted lines.
fn soften(raw: &[f32], width: usize, height: usize) -> Vec<f32> {
    let across = blur(raw, 1, |i| (i % width, width));
    blur(&across, width, |i| (i / width, height))
}

/// Blurs along `step`; `place` tells where a pixel is on its run and how long the run is.
fn blur(from: &[f32], step: usize, place: impl Fn(usize) -> (usize, usize) + Sync) -> Vec<f32> {
    let pixel = |i: usize| match place(i) {
        (at, length) if at == 0 || at + 1 == length => from[i],
        _ => (from[i - step] + 2.0 * from[i] + from[i + step]) / 4.0,
    };
    (0..from.len()).into_par_iter().with_min_len(4096).map(pixel).collect()
}
