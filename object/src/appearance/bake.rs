//! Colours of vertices under materials: what is seen of a texture where only vertices have colours.

use std::collections::BTreeMap;

use super::{AlphaMode, Appearance, Pixels, Texture, Wrap};
use crate::glb::{linear_of_srgb, srgb_of_linear};
use crate::mesh::Mesh;

impl Appearance {
    /// One sRGB colour and opacity per vertex: base colour times texture, in linear light, the mean over the
    /// corners that meet there. Vertices without a material keep their colour, white if they have none.
    /// Pictures that do not decode count as white.
    pub fn colours_of(&self, mesh: &Mesh) -> Vec<[u8; 4]> {
        let pixels = self.decoded();
        let to_linear: [f64; 256] = std::array::from_fn(|i| linear_of_srgb(i as f64 / 255.0));
        let mut sums = vec![([0.0; 4], 0u32); mesh.vertices().len()];
        for (face, corners) in mesh.faces().iter().enumerate() {
            let Some((material, places)) = self.of_face(face) else { continue };
            let picture = material.base_texture.and_then(|t| Some((t, pixels.get(&t.picture)?)));
            for (vertex, at) in corners.iter().zip(places) {
                let texel = picture.map_or([1.0; 4], |(t, p)| sample(p, at, t, &to_linear));
                let alpha = if material.alpha == AlphaMode::Opaque {
                    1.0
                } else {
                    texel[3] * material.base_colour[3]
                };
                if let Some((sum, count)) = sums.get_mut(*vertex as usize) {
                    let of =
                        |k: usize| if k == 3 { alpha } else { texel[k] * material.base_colour[k] };
                    (0..4).for_each(|k| sum[k] += of(k));
                    *count += 1;
                }
            }
        }
        let own = |v: usize| mesh.colours().and_then(|c| c.get(v).copied()).unwrap_or([255; 4]);
        let byte = |c: f64| (c.clamp(0.0, 1.0) * 255.0).round() as u8;
        let colour = |(v, (sum, count)): (usize, ([f64; 4], u32))| {
            if count == 0 {
                return own(v);
            }
            let [r, g, b, a] = sum.map(|c| c / f64::from(count));
            let [r, g, b] = [r, g, b].map(|c| byte(srgb_of_linear(c)));
            [r, g, b, byte(a)]
        };
        sums.into_iter().enumerate().map(colour).collect()
    }

    /// The pictures of base colours that decode.
    fn decoded(&self) -> BTreeMap<usize, Pixels> {
        let used = self.materials().iter().filter_map(|m| m.base_texture).map(|t| t.picture);
        let used: std::collections::BTreeSet<usize> = used.collect();
        let decode = |index: usize| Some((index, self.pictures().get(index)?.pixels().ok()?));
        used.into_iter().filter_map(decode).collect()
    }
}

/// Linear light and opacity at a place, between the four texels around it.
fn sample(pixels: &Pixels, at: [f32; 2], texture: Texture, to_linear: &[f64; 256]) -> [f64; 4] {
    let size = [pixels.width(), pixels.height()];
    let place = [0, 1].map(|k| f64::from(at[k]) * f64::from(size[k]) - 0.5);
    let part = place.map(|c| c - c.floor());
    let mut sum = [0.0; 4];
    for step in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]] {
        let share = |k: usize| if step[k] > 0.0 { part[k] } else { 1.0 - part[k] };
        let [x, y] = [0, 1].map(|k| wrapped(place[k].floor() + step[k], size[k], texture.wrap[k]));
        let [r, g, b, a] = pixels.at(x, y);
        let linear = [r, g, b].map(|c| to_linear[usize::from(c)]);
        let texel = [linear[0], linear[1], linear[2], f64::from(a) / 255.0];
        (0..4).for_each(|k| sum[k] += share(0) * share(1) * texel[k]);
    }
    sum
}

fn wrapped(at: f64, size: u32, wrap: Wrap) -> u32 {
    let n = f64::from(size);
    let inside = match wrap {
        Wrap::Clamp => at,
        Wrap::Mirror => {
            let m = at.rem_euclid(2.0 * n);
            if m < n { m } else { 2.0 * n - 1.0 - m }
        }
        Wrap::Repeat => at.rem_euclid(n),
    };
    inside.clamp(0.0, (n - 1.0).max(0.0)) as u32
}
