//! Colours of a glTF surface: vertex colour × base colour × texture, baked to one sRGB per vertex.

use std::collections::BTreeMap;

use image::RgbaImage;

use super::accessor::Accessors;
use super::buffers::data_uri;
use super::decoding::guarded;
use super::document::Document;
use super::error::GlbError;
use super::materials::{CLAMP, MIRROR, Material, REPEAT, TextureInfo};
use super::primitive::Source;
use crate::appearance::{MAX_IMAGE_SIDE, MAX_PIXELS, decoded, header};

/// Decodes textures when a surface first needs them, and bakes colours.
#[derive(Debug)]
pub(super) struct Painter<'a> {
    accessors: Accessors<'a>,
    pictures: BTreeMap<usize, Option<RgbaImage>>,
    to_linear: [f64; 256],
    /// What was left out, in plain words.
    pub notes: Vec<String>,
}

impl<'a> Painter<'a> {
    /// Checks the dimensions of every image from its header alone; decodes none.
    pub(super) fn new(accessors: Accessors<'a>) -> Result<Self, GlbError> {
        let to_linear = std::array::from_fn(|i| linear_of_srgb(i as f64 / 255.0));
        let painter = Self { accessors, pictures: BTreeMap::new(), to_linear, notes: Vec::new() };
        painter.check_images()?;
        Ok(painter)
    }

    fn check_images(&self) -> Result<(), GlbError> {
        let mut pixels = 0u64;
        for index in 0..self.accessors.document.images.len() {
            let place = format!("image {index}");
            let Some(bytes) = self.image_bytes(index, &place)? else { continue };
            let Some((_, [width, height])) = header(&bytes) else { continue };
            if width.max(height) > MAX_IMAGE_SIDE {
                let found = format!("{width} × {height}");
                return Err(GlbError::rule(place, "an image has at most 8192 a side", found));
            }
            pixels += u64::from(width) * u64::from(height);
            if pixels > MAX_PIXELS {
                let rule = "all images together have at most 256 million pixels";
                return Err(GlbError::rule(place, rule, format!("{pixels}")));
            }
        }
        Ok(())
    }

    pub(super) fn image_bytes(
        &self,
        index: usize,
        place: &str,
    ) -> Result<Option<std::borrow::Cow<'a, [u8]>>, GlbError> {
        let Some(image) = self.accessors.document.images.get(index) else { return Ok(None) };
        Ok(match (&image.uri, image.buffer_view) {
            (Some(uri), _) => Some(data_uri(place, uri)?.into()),
            (None, Some(view)) => Some(self.accessors.buffers.view(view, place)?.into()),
            (None, None) => None,
        })
    }

    /// The picture of an image, decoded once; none, with a note, if it cannot be decoded.
    fn picture(&mut self, index: usize) -> Result<Option<&RgbaImage>, GlbError> {
        if !self.pictures.contains_key(&index) {
            let place = format!("image {index}");
            let bytes = self.image_bytes(index, &place)?;
            let decoded = bytes.map(|bytes| guarded(&place, "image", || decoded(&bytes)));
            let picture = match decoded {
                Some(Ok(picture)) => Some(picture),
                Some(Err(error)) => {
                    self.notes.push(format!("colours go without a texture: {error}"));
                    None
                }
                None => None,
            };
            self.pictures.insert(index, picture);
        }
        Ok(self.pictures.get(&index).and_then(Option::as_ref))
    }

    /// One sRGB colour per vertex; none if the file says nothing about colour.
    pub(super) fn colours(
        &mut self,
        source: &Source<'_>,
        vertices: usize,
    ) -> Result<Option<Vec<[u8; 4]>>, GlbError> {
        let material = self.material(source)?;
        let pbr = material.map(|m| &m.pbr_metallic_roughness);
        let factor = pbr.and_then(|p| p.base_color_factor).unwrap_or([1.0; 4]);
        let own = source.colours(vertices)?;
        let texture = match pbr.and_then(|p| p.base_color_texture.as_ref()) {
            Some(info) => self.texels(source, info, vertices)?,
            None => None,
        };
        if own.is_none() && texture.is_none() && factor == [1.0; 4] {
            return Ok(None);
        }
        let opaque = material.and_then(|m| m.alpha_mode.as_deref()).is_none_or(|m| m == "OPAQUE");
        let at = |layer: &Option<Vec<[f64; 4]>>, v: usize| {
            layer.as_ref().and_then(|l| l.get(v).copied()).unwrap_or([1.0; 4])
        };
        let colour = |v: usize| {
            let (own, texel) = (at(&own, v), at(&texture, v));
            let [r, g, b, a] = std::array::from_fn(|c| own[c] * factor[c] * texel[c]);
            let alpha = if opaque { 255 } else { byte(a) };
            [byte(srgb_of_linear(r)), byte(srgb_of_linear(g)), byte(srgb_of_linear(b)), alpha]
        };
        Ok(Some((0..vertices).map(colour).collect()))
    }

    fn material(&self, source: &Source<'_>) -> Result<Option<&'a Material>, GlbError> {
        let Some(index) = source.primitive.material else { return Ok(None) };
        let all = &self.accessors.document.materials;
        let missing = || GlbError::reference(&source.place, "material", index, all.len());
        all.get(index).map(Some).ok_or_else(missing)
    }

    /// Linear texture colour at each vertex; none if there is no usable picture or coordinate.
    fn texels(
        &mut self,
        source: &Source<'_>,
        info: &TextureInfo,
        vertices: usize,
    ) -> Result<Option<Vec<[f64; 4]>>, GlbError> {
        let (set, transform) = info.coordinates();
        let name = format!("TEXCOORD_{set}");
        let Some(rows) = source.rows::<2>(&name)? else { return Ok(None) };
        let coordinates = source.checked(&name, rows, vertices)?;
        let (image, wrap) = texture_source(self.accessors.document, &source.place, info)?;
        let (Some(image), to_linear) = (image, self.to_linear) else { return Ok(None) };
        let Some(picture) = self.picture(image)? else { return Ok(None) };
        let place = |[u, v]: [f64; 2]| match transform {
            Some(t) => t.moved([u, v]),
            None => [u, v],
        };
        let texel = |uv: &[f64; 2]| sample(picture, place(*uv), wrap, &to_linear);
        Ok(Some(coordinates.iter().map(texel).collect()))
    }
}

/// The image of a texture and how it repeats along u and v.
pub(super) fn texture_source(
    document: &Document,
    place: &str,
    info: &TextureInfo,
) -> Result<(Option<usize>, [u32; 2]), GlbError> {
    let missing = |what, index, count| GlbError::reference(place, what, index, count);
    let count = document.textures.len();
    let texture = document.textures.get(info.index);
    let texture = texture.ok_or_else(|| missing("texture", info.index, count))?;
    let image = texture.extensions.webp.as_ref().map(|w| w.source).or(texture.source);
    let count = document.images.len();
    if let Some(index) = image.filter(|&i| i >= count) {
        return Err(missing("image", index, count));
    }
    let sampler = texture.sampler.and_then(|s| document.samplers.get(s));
    let wrap = sampler.map(|s| [s.wrap_s, s.wrap_t]).unwrap_or_default();
    Ok((image, wrap.map(|w| w.unwrap_or(REPEAT))))
}

/// Bilinear sample in linear light at texture coordinates, v pointing down.
fn sample(
    picture: &RgbaImage,
    [u, v]: [f64; 2],
    wrap: [u32; 2],
    to_linear: &[f64; 256],
) -> [f64; 4] {
    let (width, height) = picture.dimensions();
    let (x, y) = (u * f64::from(width) - 0.5, v * f64::from(height) - 0.5);
    let (fx, fy) = (x - x.floor(), y - y.floor());
    let mut sum = [0.0; 4];
    for (dx, dy, weight) in [
        (0.0, 0.0, (1.0 - fx) * (1.0 - fy)),
        (1.0, 0.0, fx * (1.0 - fy)),
        (0.0, 1.0, (1.0 - fx) * fy),
        (1.0, 1.0, fx * fy),
    ] {
        let px = wrapped(x.floor() + dx, width, wrap[0]);
        let py = wrapped(y.floor() + dy, height, wrap[1]);
        let [r, g, b, a] = picture.get_pixel_checked(px, py).map_or([255; 4], |p| p.0);
        let linear = [r, g, b].map(|c| to_linear[usize::from(c)]);
        let texel = [linear[0], linear[1], linear[2], f64::from(a) / 255.0];
        sum = std::array::from_fn(|c| sum[c] + weight * texel[c]);
    }
    sum
}

fn wrapped(at: f64, size: u32, mode: u32) -> u32 {
    let n = f64::from(size);
    let inside = match mode {
        CLAMP => at,
        MIRROR => {
            let m = at.rem_euclid(2.0 * n);
            if m < n { m } else { 2.0 * n - 1.0 - m }
        }
        _ => at.rem_euclid(n),
    };
    inside.clamp(0.0, n - 1.0) as u32
}

fn byte(value: f64) -> u8 {
    (value.clamp(0.0, 1.0) * 255.0).round() as u8
}

/// Linear light (0–1) of an sRGB value (0–1), IEC 61966-2-1.
pub fn linear_of_srgb(c: f64) -> f64 {
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

/// The sRGB value (0–1) of linear light (0–1).
pub fn srgb_of_linear(c: f64) -> f64 {
    if c <= 0.003_130_8 { c * 12.92 } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_survives_the_way_to_linear_light_and_back() {
        let back = |b: u8| byte(srgb_of_linear(linear_of_srgb(f64::from(b) / 255.0)));
        assert!((0..=255).all(|b| back(b) == b));
    }

    #[test]
    fn textures_repeat_mirror_and_clamp() {
        let [repeat, mirror, clamp] =
            [REPEAT, MIRROR, CLAMP].map(|mode| [-1.0, 0.0, 3.0, 4.0].map(|x| wrapped(x, 4, mode)));
        assert_eq!(repeat, [3, 0, 3, 0]);
        assert_eq!(mirror, [0, 0, 3, 3]);
        assert_eq!(clamp, [0, 0, 3, 3]);
        assert!(wrapped(f64::NAN, 4, REPEAT) < 4);
    }

    #[test]
    fn a_sample_in_a_texel_centre_is_that_texel() {
        let picture = RgbaImage::from_fn(2, 1, |x, _| image::Rgba([255 * x as u8, 0, 0, 255]));
        let table = std::array::from_fn(|i| linear_of_srgb(i as f64 / 255.0));
        let at = |u| sample(&picture, [u, 0.5], [CLAMP; 2], &table)[0];
        assert_eq!((at(0.25), at(0.75)), (0.0, 1.0));
        assert!((at(0.5) - 0.5).abs() < 1e-12);
    }
}
