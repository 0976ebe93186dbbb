//! Fine dark lines where one thing ends and another begins: outlines, steps, creases and borders
//! between parts, so that a surface without colours can be read.

use rayon::prelude::*;

use crate::shade::Shaded;
use crate::visibility::{NO_FACE, Seen};

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
    pub seen: &'a [Seen],
    pub shaded: &'a [Shaded],
    /// Depth difference that counts as a step, metres.
    pub step: f64,
    /// The part of a face, where parts are known.
    pub part: &'a (dyn Fn(u32) -> Option<u16> + Sync),
}

/// How dark the line through each pixel is, 0 to 1, blurred along the rows; [`softened`] blurs it
/// across them.
pub(crate) fn line_strength(line: &Line<'_>, lines: &mut Vec<f32>) {
    let [width, height] = line.size.map(|n| n as usize);
    let scale = (width.min(height) as f32 / FULL_SIZE).min(1.0);
    lines.resize(width * height, 0.0);
    lines.par_chunks_mut(width.max(1)).enumerate().for_each(|(y, row)| {
        row.iter_mut().enumerate().for_each(|(x, l)| *l = scale * line.at(x, y));
        blur_row(row);
    });
}

/// A little blur (1 2 1 both ways) takes the stairs out of slanted lines: this is the second way,
/// for one pixel.
pub(crate) fn softened(lines: &[f32], width: usize, i: usize) -> f32 {
    let above = i.checked_sub(width).and_then(|a| lines.get(a));
    match (above, lines.get(i + width)) {
        (Some(above), Some(below)) => blur(*above, lines[i], *below),
        _ => lines[i],
    }
}

fn blur(before: f32, here: f32, after: f32) -> f32 {
    (before + 2.0 * here + after) / 4.0
}

/// The first way: along a row, whose ends stay as they are.
fn blur_row(row: &mut [f32]) {
    let Some(&first) = row.first() else { return };
    let mut before = first;
    for x in 1..row.len().saturating_sub(1) {
        let here = row[x];
        row[x] = blur(before, here, row[x + 1]);
        before = here;
    }
}

impl Line<'_> {
    fn at(&self, x: usize, y: usize) -> f32 {
        let [width, height] = self.size.map(|n| n as usize);
        let i = y * width + x;
        if self.seen[i].face == NO_FACE {
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
        let [here, one, two] = [i, a, b].map(|k| &self.seen[k]);
        if one.face == NO_FACE || two.face == NO_FACE {
            return OUTLINE;
        }
        if here.face == one.face && here.face == two.face {
            return 0.0;
        }
        // One over the depth is linear on a plane: its bend tells a step from a slope.
        let bend = 2.0 * here.nearness - one.nearness - two.nearness;
        let depth = 1.0 / here.nearness;
        let step = bend * depth * depth / self.step as f32;
        let mut strength = STEP * ((step - 0.3) / 0.7).clamp(0.0, 1.0);
        if (self.part)(here.face) != (self.part)(two.face) {
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
