//! Points onto the three planes xy, yz, xz, and planes back to points.
//!
//! Letters: N points · C channels · R resolution.

use rayon::prelude::*;

use super::sizes::PartFieldSizes;

/// The two coordinates of each plane: columns run with the first, rows with the second.
const AXES: [[usize; 2]; 3] = [[0, 1], [1, 2], [0, 2]];

/// Means of the points' values [C, N] in each pixel [3, C, R, R]; 0 where there are none.
pub(super) fn scatter(points: &[[f32; 3]], values: &[f32], r: usize) -> Vec<f32> {
    let n = points.len();
    let c = values.len() / n.max(1);
    let pixel = |p: f32| {
        let u = (p / 2.0 / (1.0 + 1e-5) + 0.5).clamp(0.0, 1.0 - 1e-5);
        ((u * r as f32) as usize).min(r - 1)
    };
    let mut out = vec![0.0f32; 3 * c * r * r];
    for (plane, axes) in out.chunks_exact_mut(c * r * r).zip(AXES) {
        let index: Vec<usize> =
            points.iter().map(|p| pixel(p[axes[1]]) * r + pixel(p[axes[0]])).collect();
        let mut count = vec![0.0f32; r * r];
        index.iter().for_each(|&i| count[i] += 1.0);
        for (channel, values) in plane.chunks_exact_mut(r * r).zip(values.chunks_exact(n)) {
            index.iter().zip(values).for_each(|(&i, v)| channel[i] += v);
            channel.iter_mut().zip(&count).for_each(|(s, n)| *s /= n.max(1.0));
        }
    }
    out
}

/// The sum of what the planes [3, T, R, R] hold at each point, without the distance channels
/// [N, T − distance]; between pixels in proportion, corners on ±1.
pub(super) fn sample(planes: &[f32], points: &[[f32; 3]], sizes: &PartFieldSizes) -> Vec<f32> {
    let (r, width) = (sizes.resolution, sizes.features());
    let mut out = vec![0.0; points.len() * width];
    out.par_chunks_mut(width).zip(points).for_each(|(out, p)| {
        for (plane, axes) in planes.chunks_exact(sizes.out * r * r).zip(AXES) {
            let corners = corners([p[axes[0]], p[axes[1]]], r);
            let channels = plane.chunks_exact(r * r).skip(sizes.distance);
            for (o, channel) in out.iter_mut().zip(channels) {
                *o += corners.iter().map(|&(i, w)| channel[i] * w).sum::<f32>();
            }
        }
    });
    out
}

fn corners(p: [f32; 2], r: usize) -> [(usize, f32); 4] {
    let split = |c: f32| {
        let at = ((c + 1.0) / 2.0 * (r - 1) as f32).clamp(0.0, (r - 1) as f32);
        let low = at.floor();
        (low as usize, (low as usize + 1).min(r - 1), at - low)
    };
    let ((x0, x1, u), (y0, y1, v)) = (split(p[0]), split(p[1]));
    [
        (y0 * r + x0, (1.0 - u) * (1.0 - v)),
        (y0 * r + x1, u * (1.0 - v)),
        (y1 * r + x0, (1.0 - u) * v),
        (y1 * r + x1, u * v),
    ]
}
