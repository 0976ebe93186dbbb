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

/// Texels that a face's edge may be long before it is split: a guess, a third of what is seen as a stripe.
const TEXELS: f64 = 6.0;
/// Edges of a surface's diagonal that may be seen apart: a picture of it is rarely wider on a screen.
const EDGES: f64 = 160.0;
/// Most pieces of an edge.
const MOST_PIECES: usize = 48;

impl Appearance {
    /// The surface for whoever draws colours of vertices alone: faces under a texture are split until
    /// vertices are as dense as its texels or as a screen shows, and as far as `most` faces go. What lies
    /// where is not changed. None where nothing is textured, or not even the faces there are fit.
    pub fn refined(&self, mesh: &Mesh, most: usize) -> Option<Mesh> {
        let pixels = self.decoded();
        if pixels.is_empty()
            || mesh.faces().len() > most
            || self.faces().len() != mesh.faces().len()
        {
            return None;
        }
        let diagonal = mesh.bounds().diagonal();
        let pieces = |face: usize, coarse: f64| -> usize {
            let Some((material, places)) = self.of_face(face) else { return 1 };
            let Some(picture) = material.base_texture.and_then(|t| pixels.get(&t.picture)) else {
                return 1;
            };
            let size = [picture.width(), picture.height()].map(f64::from);
            let (corners, mut longest, mut wide) = (mesh.corners(face), 0.0_f64, 0.0_f64);
            for (a, b) in [(0, 1), (1, 2), (2, 0)] {
                let way = |k: usize| f64::from(places[b][k] - places[a][k]) * size[k];
                longest = longest.max(way(0).hypot(way(1)));
                wide = wide.max((corners[b] - corners[a]).length());
            }
            let most = (longest / TEXELS).min(wide / diagonal * EDGES) / coarse;
            (most.ceil() as usize).clamp(1, MOST_PIECES)
        };
        // The coarser, the fewer: at some point each face is one piece.
        let mut coarse = 1.0;
        while (0..mesh.faces().len()).map(|f| pieces(f, coarse).pow(2)).sum::<usize>() > most {
            coarse *= 1.5;
        }
        let to_linear: [f64; 256] = std::array::from_fn(|i| linear_of_srgb(i as f64 / 255.0));
        let (mut vertices, mut colours, mut faces) = (Vec::new(), Vec::new(), Vec::new());
        for face in 0..mesh.faces().len() {
            let (n, corners) = (pieces(face, coarse), mesh.corners(face));
            let first = vertices.len() as u32;
            for (i, j) in (0..=n).flat_map(|i| (0..=n - i).map(move |j| (i, j))) {
                let [b, c] = [i, j].map(|k| k as f64 / n as f64);
                vertices.push(corners[0] * (1.0 - b - c) + corners[1] * b + corners[2] * c);
                colours.push(self.colour_at(
                    (mesh, face),
                    [1.0 - b - c, b, c],
                    (&pixels, &to_linear),
                ));
            }
            let at =
                |i: usize, j: usize| first + (i * (n + 1) + j - i * i.saturating_sub(1) / 2) as u32;
            for (i, j) in (0..n).flat_map(|i| (0..n - i).map(move |j| (i, j))) {
                faces.push([at(i, j), at(i + 1, j), at(i, j + 1)]);
                if i + j + 1 < n {
                    faces.push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
                }
            }
        }
        let refined = Mesh::new(vertices, faces).ok()?.with_frame(mesh.frame());
        refined.with_colours(Some(colours)).ok()
    }

    /// The colour of a face at a place, by shares of its corners.
    fn colour_at(
        &self,
        (mesh, face): (&Mesh, usize),
        shares: [f64; 3],
        (pixels, to_linear): (&BTreeMap<usize, Pixels>, &[f64; 256]),
    ) -> [u8; 4] {
        let byte = |c: f64| (c.clamp(0.0, 1.0) * 255.0).round() as u8;
        let Some((material, places)) = self.of_face(face) else {
            let own = mesh.faces().get(face).map(|f| f[0] as usize);
            return own
                .zip(mesh.colours())
                .and_then(|(v, c)| c.get(v).copied())
                .unwrap_or([255; 4]);
        };
        let at =
            [0, 1].map(|k| (0..3).map(|c| shares[c] * f64::from(places[c][k])).sum::<f64>() as f32);
        let picture = material.base_texture.and_then(|t| Some((t, pixels.get(&t.picture)?)));
        let texel = picture.map_or([1.0; 4], |(t, p)| sample(p, at, t, to_linear));
        let [r, g, b, a]: [f64; 4] = std::array::from_fn(|k| texel[k] * material.base_colour[k]);
        let alpha = if material.alpha == AlphaMode::Opaque { 1.0 } else { a };
        [byte(srgb_of_linear(r)), byte(srgb_of_linear(g)), byte(srgb_of_linear(b)), byte(alpha)]
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Material, Picture, Surfacing};
    use super::*;
    use glamx::DVec3;

    #[test]
    fn a_stripe_inside_a_face_is_seen_by_vertices_of_the_refined_surface() {
        let mut pixels = Pixels::filled(64, 64, [0, 0, 255, 255]);
        (24..40).for_each(|x| (0..64).for_each(|y| pixels.set(x, y, [255, 0, 0, 255])));
        let picture = Picture::new(pixels.png().unwrap()).unwrap();
        let base_texture = Some(Texture { picture: 0, wrap: [Wrap::Clamp; 2] });
        let material = Material { base_texture, ..Material::default() };
        let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        let face = Surfacing { material: Some(0), corners };
        let look = Appearance::new(vec![picture], vec![material], vec![face]).unwrap();
        let mesh = Mesh::of_triangles(&[[DVec3::ZERO, DVec3::X, DVec3::Y]]).unwrap();
        let fine = look.refined(&mesh, 10_000).unwrap();
        let area: f64 = (0..fine.faces().len()).map(|f| fine.area(f)).sum();
        assert!((area - 0.5).abs() < 1e-9 && (100..10_000).contains(&fine.faces().len()));
        assert!((0..fine.faces().len()).all(|f| fine.normal(f).dot(DVec3::Z) > 0.99));
        for (at, colour) in
            [(0.5, [255, 0, 0, 255]), (0.1, [0, 0, 255, 255]), (0.8, [0, 0, 255, 255])]
        {
            let near = |v: &DVec3| (v.x - at).abs() + v.y.abs() * 1e-3;
            let vertices = fine.vertices().iter().enumerate();
            let (vertex, _) = vertices.min_by(|a, b| near(a.1).total_cmp(&near(b.1))).unwrap();
            assert_eq!(fine.colours().unwrap()[vertex], colour, "{at}");
        }
        let coarse = look.refined(&mesh, 20).unwrap();
        assert!(coarse.faces().len() <= 20);
        assert!(look.refined(&mesh, 0).is_none());
        assert_eq!(look.colours_of(&mesh), [[0, 0, 255, 255]; 3]);
    }
}
