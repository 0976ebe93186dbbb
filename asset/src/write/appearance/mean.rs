//! The mean colour of what a material shows.

use object::Mesh;
use object::appearance::{Material, Pixels, Texture};
use object::glb::{linear_of_srgb, srgb_of_linear};

/// Places on a face at which its texture is looked up, in barycentric coordinates.
const PLACES: [[f64; 3]; 7] = {
    const A: f64 = 1.0 / 3.0;
    const B: f64 = 2.0 / 3.0;
    const C: f64 = 1.0 / 6.0;
    const D: f64 = 5.0 / 12.0;
    [[A, A, A], [B, C, C], [C, B, C], [C, C, B], [D, D, C], [D, C, D], [C, D, D]]
};

/// Mean colour over faces with coordinates, by their area: the texture's light times the factor, as sRGB
/// and opacity, each 0 to 1. Without a texture, or a face, it is the factor's.
pub(crate) fn mean(
    material: &Material,
    base: Option<(Texture, &Pixels)>,
    mesh: Option<&Mesh>,
    (faces, corners): (&[u32], &[[[f32; 2]; 3]]),
) -> [f64; 4] {
    let (mut sum, mut total) = ([0.0; 4], 0.0);
    if let (Some((_, pixels)), Some(mesh)) = (base, mesh) {
        for (&face, of) in faces.iter().zip(corners) {
            let area = mesh.area(face as usize);
            total += area * PLACES.len() as f64;
            for place in PLACES {
                let at =
                    [0, 1].map(|k| (0..3).map(|c| place[c] * f64::from(of[c][k])).sum::<f64>());
                let texel = |c: f64, n: u32| ((c.rem_euclid(1.0) * f64::from(n)) as u32).min(n - 1);
                let [r, g, b, a] = pixels
                    .at(texel(at[0], pixels.width()), texel(at[1], pixels.height()))
                    .map(|c| f64::from(c) / 255.0);
                let light = [linear_of_srgb(r), linear_of_srgb(g), linear_of_srgb(b), a];
                sum.iter_mut().zip(light).for_each(|(s, l)| *s += area * l);
            }
        }
    }
    let texture = if total > 0.0 { sum.map(|s| s / total) } else { [1.0; 4] };
    let [r, g, b, alpha] = std::array::from_fn(|k| texture[k] * material.base_colour[k]);
    let alpha = if material.alpha == object::appearance::AlphaMode::Blend { alpha } else { 1.0 };
    [srgb_of_linear(r), srgb_of_linear(g), srgb_of_linear(b), alpha]
        .map(|c| (c.clamp(0.0, 1.0) * 1e4).round() / 1e4)
}
