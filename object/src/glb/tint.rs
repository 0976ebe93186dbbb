//! A picture multiplied by colours of vertices, texel by texel, as far as each texel is seen in one place.

use super::paint::{linear_of_srgb, srgb_of_linear};
use crate::appearance::Pixels;

/// Faces by their vertices, and for each vertex its place on the picture and its colour, linear light.
pub(super) type Tinted<'a> = (&'a [[u32; 3]], &'a [[f32; 2]], &'a [[f64; 4]]);

/// How much two faces that share a texel may differ about its colour: what is not seen of 255 steps.
const ALIKE: f64 = 2.0 / 255.0;
/// Texels beyond a face's edge that are coloured with it: what filters take.
const MARGIN: f64 = 1.5;
/// Most texels that are looked at, for faces may lie over one another: a guess with room for the largest picture.
const MAX_WORK: u64 = 1 << 30;

/// The picture with the colours of vertices laid over it; none where faces lie outside of it or over one
/// another with different colours, for then one texel is seen in several.
pub(super) fn tinted(picture: &Pixels, over: Tinted<'_>) -> Option<Pixels> {
    let (faces, places, tints) = over;
    let size = [picture.width(), picture.height()].map(f64::from);
    let count = picture.width() as usize * picture.height() as usize;
    // For each texel its colour, and how far inside the face is that gave it.
    let mut laid: Vec<Option<([f64; 4], f64)>> = vec![None; count];
    let mut work = 0u64;
    for face in faces {
        let corners = face.map(|v| (places.get(v as usize), tints.get(v as usize)));
        let [(Some(a), Some(p)), (Some(b), Some(q)), (Some(c), Some(r))] = corners else {
            return None;
        };
        let at = [a, b, c].map(|uv| [0, 1].map(|k| f64::from(uv[k]) * size[k] - 0.5));
        if [a, b, c].iter().any(|uv| uv.iter().any(|c| !(0.0..=1.0).contains(c))) {
            return None;
        }
        let bound =
            |k: usize, pick: fn(f64, f64) -> f64| at.iter().map(|p| p[k]).fold(at[0][k], pick);
        let low = [0, 1].map(|k| (bound(k, f64::min) - MARGIN).ceil().max(0.0) as u32);
        let high =
            [0, 1].map(|k| (bound(k, f64::max) + MARGIN).floor().clamp(0.0, size[k] - 1.0) as u32);
        work += u64::from(high[0] + 1 - low[0].min(high[0]))
            * u64::from(high[1] + 1 - low[1].min(high[1]));
        if work > MAX_WORK {
            return None;
        }
        for (x, y) in (low[1]..=high[1]).flat_map(|y| (low[0]..=high[0]).map(move |x| (x, y))) {
            let (shares, inside) = barycentric(at, [f64::from(x), f64::from(y)]);
            if inside < -MARGIN {
                continue;
            }
            let tint: [f64; 4] = std::array::from_fn(|k| {
                let mixed = shares[0] * p[k] + shares[1] * q[k] + shares[2] * r[k];
                mixed.clamp(p[k].min(q[k]).min(r[k]), p[k].max(q[k]).max(r[k])).clamp(0.0, 1.0)
            });
            let slot = laid.get_mut(y as usize * picture.width() as usize + x as usize)?;
            match slot {
                Some((other, depth)) => {
                    let differs = |k: usize| (other[k] - tint[k]).abs() > ALIKE;
                    if inside > 0.0 && *depth > 0.0 && (0..4).any(differs) {
                        return None;
                    }
                    if inside > *depth {
                        *slot = Some((tint, inside));
                    }
                }
                None => *slot = Some((tint, inside)),
            }
        }
    }
    let mut whole = picture.clone();
    for (index, tint) in laid.iter().enumerate() {
        let Some((tint, _)) = tint else { continue };
        let (x, y) = (index as u32 % picture.width(), index as u32 / picture.width());
        let was = picture.at(x, y).map(|c| f64::from(c) / 255.0);
        let byte = |c: f64| (c.clamp(0.0, 1.0) * 255.0).round() as u8;
        let light = |k: usize| byte(srgb_of_linear(linear_of_srgb(was[k]) * tint[k]));
        whole.set(x, y, [light(0), light(1), light(2), byte(was[3] * tint[3])]);
    }
    Some(whole)
}

/// Shares of the corners at a place, and how far inside of the nearest edge it lies, in texels.
fn barycentric(at: [[f64; 2]; 3], p: [f64; 2]) -> ([f64; 3], f64) {
    let cross = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| {
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    let whole = cross(at[0], at[1], at[2]);
    if whole.abs() < 1e-12 {
        // A face of no area on the picture: its first corner's colour, on the spot alone.
        let off = (p[0] - at[0][0]).hypot(p[1] - at[0][1]);
        return ([1.0, 0.0, 0.0], -off);
    }
    let (mut shares, mut inside) = ([0.0; 3], f64::INFINITY);
    for k in 0..3 {
        let (a, b) = (at[(k + 1) % 3], at[(k + 2) % 3]);
        shares[k] = cross(a, b, p) / whole;
        let length = (b[0] - a[0]).hypot(b[1] - a[1]).max(1e-12);
        inside = inside.min(shares[k] * whole.abs() / length);
    }
    (shares, inside)
}

#[cfg(test)]
mod tests {
    use super::*;

    const RED: [f64; 4] = [1.0, 0.0, 0.0, 1.0];
    const WHITE: [f64; 4] = [1.0; 4];

    #[test]
    fn a_picture_under_colours_is_multiplied_where_faces_lie() {
        let picture = Pixels::filled(8, 8, [100, 200, 50, 255]);
        let places = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
        let faces = [[0, 1, 2], [1, 3, 2]];
        let made = tinted(&picture, (&faces, &places, &[RED, WHITE, RED, WHITE])).unwrap();
        assert_eq!(made.at(0, 4), {
            let share = 0.5 / 8.0;
            let byte = |c: f64| (c * 255.0).round() as u8;
            let of = |c: u8| byte(srgb_of_linear(linear_of_srgb(f64::from(c) / 255.0) * share));
            [100, of(200), of(50), 255]
        });
        assert!(made.at(7, 4)[1] > 180 && made.at(3, 3)[1] > 120);
    }

    #[test]
    fn what_repeats_or_lies_over_itself_in_two_colours_is_not_multiplied() {
        let picture = Pixels::filled(8, 8, [100, 200, 50, 255]);
        let beyond = [[0.0, 0.0], [2.0, 0.0], [0.0, 1.0]];
        assert_eq!(tinted(&picture, (&[[0, 1, 2]], &beyond, &[RED, RED, WHITE])), None);
        let twice = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        let tints = [RED, RED, RED, WHITE, WHITE, WHITE];
        assert_eq!(tinted(&picture, (&[[0, 1, 2], [3, 4, 5]], &twice, &tints)), None);
        assert!(tinted(&picture, (&[[0, 1, 2], [3, 4, 5]], &twice, &[RED; 6])).is_some());
    }
}
