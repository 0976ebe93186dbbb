//! The pictures of an asset: for each link what it shows of a texture, packed, or the whole of it where
//! that is less.
//!
//! Charts are cut out with [`PADDING`] texels of what lies beside them, texel for texel, so that no
//! filter brings in what was not there before.

use std::collections::BTreeMap;

use object::appearance::{Appearance, Material, Picture, PictureFormat, Pixels, Texture, Wrap};
use object::weld::DisjointSets;

use crate::write::appearance::look::TextureFile;
use crate::write::appearance::pack::packed;

/// Texels round each chart: two more than the two smaller pictures that bilinear filters take most need.
/// A guess.
const PADDING: i64 = 4;
/// Longest side of a packed picture, what every graphics card takes.
const MOST_SIDE: u32 = 4096;
/// What maps are called in file names, in the order of [`Material::textures`].
const SUFFIXES: [&str; 4] = ["", "_roughness", "_normal", "_emissive"];

/// What one link shows of one material.
#[derive(Debug)]
pub(crate) struct Use {
    /// Name of the group: file names begin with it.
    pub(crate) name: String,
    /// Where the corners of its faces lie on the textures; laid anew on what is packed.
    pub(crate) corners: Vec<[[f32; 2]; 3]>,
}

/// Pictures in the making.
pub(crate) struct Textures<'a> {
    of: &'a Appearance,
    pixels: BTreeMap<usize, Option<Pixels>>,
    whole: BTreeMap<usize, Option<usize>>,
    pub(crate) files: Vec<TextureFile>,
    pub(crate) notes: Vec<String>,
}

/// A rectangle of texels on a texture that goes on for ever.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cut {
    low: [i64; 2],
    high: [i64; 2],
}

impl Cut {
    const NONE: Self = Self { low: [i64::MAX; 2], high: [i64::MIN; 2] };

    fn with(self, other: Self) -> Self {
        let pick =
            |f: fn(i64, i64) -> i64, a: [i64; 2], b: [i64; 2]| [f(a[0], b[0]), f(a[1], b[1])];
        Self {
            low: pick(i64::min, self.low, other.low),
            high: pick(i64::max, self.high, other.high),
        }
    }

    /// What a face takes of a texture of this size, padded.
    fn of(corners: [[f32; 2]; 3], size: [u32; 2]) -> Self {
        let mut cut = Self::NONE;
        for uv in corners {
            let at = [0, 1].map(|k| f64::from(uv[k]) * f64::from(size[k]) - 0.5);
            let low = at.map(|c| c.floor() as i64 - PADDING);
            let high = at.map(|c| c.floor() as i64 + 2 + PADDING);
            cut = cut.with(Self { low, high });
        }
        cut
    }

    fn size(self) -> [u64; 2] {
        [0, 1].map(|k| self.high[k].saturating_sub(self.low[k]).max(0).unsigned_abs())
    }

    fn area(self) -> u64 {
        let [w, h] = self.size();
        w.saturating_mul(h)
    }
}

/// Cuts of a link, the cut of each face, where they lie on their sheet, and its size.
struct Sheet {
    cuts: Vec<Cut>,
    cut_of_face: Vec<usize>,
    places: Vec<[u32; 2]>,
    size: [u32; 2],
}

impl Sheet {
    /// None where it would be larger than any sheet may be.
    fn of(corners: &[[[f32; 2]; 3]], size: [u32; 2]) -> Option<Self> {
        let mut sets = DisjointSets::new(corners.len());
        let mut first = BTreeMap::new();
        for (face, of) in (0u32..).zip(corners) {
            for uv in of {
                sets.join(face, *first.entry(uv.map(f32::to_bits)).or_insert(face));
            }
        }
        let (mut number, mut cuts, mut cut_of_face) = (BTreeMap::new(), Vec::new(), Vec::new());
        for (face, of) in (0u32..).zip(corners) {
            let cut = *number.entry(sets.root(face)).or_insert(cuts.len());
            if cut == cuts.len() {
                cuts.push(Cut::NONE);
            }
            cuts[cut] = cuts[cut].with(Cut::of(*of, size));
            cut_of_face.push(cut);
        }
        let all = cuts.iter().fold(Cut::NONE, |a, b| a.with(*b));
        let apart = cuts.iter().fold(0u64, |sum, c| sum.saturating_add(c.area()));
        if all.area() <= apart {
            (cuts, cut_of_face) = (vec![all], vec![0; corners.len()]);
        }
        let is_small = |c: &Cut| c.size().iter().all(|s| *s <= u64::from(MOST_SIDE));
        if !cuts.iter().all(is_small) || apart.min(all.area()) > u64::from(MOST_SIDE).pow(2) {
            return None;
        }
        let sizes: Vec<_> = cuts.iter().map(|c| c.size().map(|s| s as u32)).collect();
        let (places, size) = packed(&sizes);
        let fits = size.iter().all(|s| *s <= MOST_SIDE);
        fits.then_some(Self { cuts, cut_of_face, places, size })
    }

    fn area(&self) -> u64 {
        u64::from(self.size[0]) * u64::from(self.size[1])
    }

    /// The cuts of a picture, laid on the sheet; nothing is between them but the colour of the first.
    fn pixels(&self, of: &Pixels, wrap: [Wrap; 2]) -> Pixels {
        let [width, height] = self.size;
        let at = |x: i64, y: i64| {
            of.at(wrapped(x, of.width(), wrap[0]), wrapped(y, of.height(), wrap[1]))
        };
        let ground = self.cuts.first().map_or([255; 4], |c| at(c.low[0], c.low[1]));
        let mut sheet = Pixels::filled(width, height, ground);
        for (cut, place) in self.cuts.iter().zip(&self.places) {
            let [w, h] = cut.size().map(|s| s as u32);
            for y in 0..h {
                for x in 0..w {
                    let from = [cut.low[0] + i64::from(x), cut.low[1] + i64::from(y)];
                    sheet.set(place[0] + x, place[1] + y, at(from[0], from[1]));
                }
            }
        }
        sheet
    }

    /// Coordinates on the sheet of what lay on a picture of a size.
    fn moved(&self, face: usize, corners: [[f32; 2]; 3], size: [u32; 2]) -> [[f32; 2]; 3] {
        let cut = self.cut_of_face[face];
        let (low, place) = (self.cuts[cut].low, self.places[cut]);
        corners.map(|uv| {
            [0, 1].map(|k| {
                let texel = f64::from(uv[k]) * f64::from(size[k]) - low[k] as f64;
                ((texel + f64::from(place[k])) / f64::from(self.size[k])) as f32
            })
        })
    }
}

/// The texel of a picture of `size` that stands for one outside of it.
fn wrapped(at: i64, size: u32, wrap: Wrap) -> u32 {
    let n = i64::from(size).max(1);
    let inside = match wrap {
        Wrap::Clamp => at.clamp(0, n - 1),
        Wrap::Repeat => at.rem_euclid(n),
        Wrap::Mirror => {
            let m = at.rem_euclid(2 * n);
            if m < n { m } else { 2 * n - 1 - m }
        }
    };
    inside as u32
}

impl<'a> Textures<'a> {
    pub(crate) fn new(of: &'a Appearance) -> Self {
        let (pixels, whole) = (BTreeMap::new(), BTreeMap::new());
        Self { of, pixels, whole, files: vec![], notes: vec![] }
    }

    /// The pixels of a picture, decoded once; none, with a note, of what cannot be decoded.
    pub(crate) fn pixels(&mut self, picture: usize) -> Option<&Pixels> {
        let (of, notes) = (self.of, &mut self.notes);
        let decode = || match of.pictures().get(picture)?.pixels() {
            Ok(pixels) => Some(pixels),
            Err(why) => {
                notes.push(format!("picture {picture} is left out: {why}"));
                None
            }
        };
        self.pixels.entry(picture).or_insert_with(decode).as_ref()
    }

    /// Writes what the uses of one material show; for each use the material as it is to be written, with
    /// textures that are among the files.
    pub(crate) fn lay(&mut self, material: &Material, uses: &mut [Use]) -> Vec<Material> {
        let mut material = material.clone();
        let readable = material.textures().map(|t| t.filter(|t| self.pixels(t.picture).is_some()));
        set_textures(&mut material, readable);
        let size =
            readable.iter().flatten().find_map(|t| Some(self.of.pictures().get(t.picture)?.size()));
        let Some(size) = size else { return vec![material; uses.len()] };
        let sheets: Vec<_> = uses.iter().map(|u| Sheet::of(&u.corners, size)).collect();
        let apart = sheets.iter().try_fold(0u64, |sum, s| Some(sum + s.as_ref()?.area()));
        let all = u64::from(size[0]) * u64::from(size[1]);
        if apart.is_none_or(|apart| apart >= all) {
            self.note_wraps(&material, uses);
            let whole = readable.map(|t| t.and_then(|t| self.whole(t)));
            set_textures(&mut material, whole);
            return vec![material; uses.len()];
        }
        let sheets = sheets.into_iter().flatten();
        let laid = sheets.zip(uses).map(|(sheet, of)| {
            let mut material = material.clone();
            let maps = readable.into_iter().zip(SUFFIXES);
            let maps = maps.map(|(texture, suffix)| {
                let name = format!("{}{suffix}", of.name);
                self.sheet(&sheet, (texture?, size), &name)
            });
            let mut textures = [None; 4];
            maps.zip(&mut textures).for_each(|(map, texture)| *texture = map);
            set_textures(&mut material, textures);
            for (face, corners) in of.corners.iter_mut().enumerate() {
                *corners = sheet.moved(face, *corners, size);
            }
            material
        });
        laid.collect()
    }

    /// One map of a sheet as a file.
    fn sheet(
        &mut self,
        sheet: &Sheet,
        (of, size): (Texture, [u32; 2]),
        name: &str,
    ) -> Option<Texture> {
        let pixels = self.pixels(of.picture)?;
        let laid = if [pixels.width(), pixels.height()] == size {
            sheet.pixels(pixels, of.wrap)
        } else {
            sheet.pixels(&pixels.resized(size[0], size[1]), of.wrap)
        };
        let picture = self.add(format!("meshes/{name}.png"), laid.png(), None)?;
        Some(Texture { picture, wrap: [Wrap::Repeat; 2] })
    }

    /// A whole picture as a file, the same for all that show it.
    fn whole(&mut self, of: Texture) -> Option<Texture> {
        if let Some(known) = self.whole.get(&of.picture) {
            return known.map(|picture| Texture { picture, ..of });
        }
        let source = self.of.pictures().get(of.picture)?;
        let png = match source.format() {
            PictureFormat::Png => Ok(source.bytes().to_vec()),
            PictureFormat::Jpeg | PictureFormat::WebP => self.pixels(of.picture)?.png(),
        };
        let original = (source.format() == PictureFormat::Jpeg).then(|| source.clone());
        let file = self.add(format!("meshes/texture_{}.png", of.picture), png, original);
        self.whole.insert(of.picture, file);
        file.map(|picture| Texture { picture, ..of })
    }

    fn add(
        &mut self,
        path: String,
        png: Result<Vec<u8>, String>,
        original: Option<Picture>,
    ) -> Option<usize> {
        match png.and_then(Picture::new) {
            Ok(picture) => {
                self.files.push(TextureFile { path, picture, original });
                Some(self.files.len() - 1)
            }
            Err(why) => {
                self.notes.push(format!("{path} is left out: {why}"));
                None
            }
        }
    }

    /// Formats other than GLB and USD repeat every texture.
    fn note_wraps(&mut self, material: &Material, uses: &[Use]) {
        let is_odd = |t: &Texture| t.wrap != [Wrap::Repeat; 2];
        let is_beyond = |uv: &[f32; 2]| uv.iter().any(|c| !(0.0..=1.0).contains(c));
        let beyond = uses.iter().flat_map(|u| u.corners.iter().flatten()).any(is_beyond);
        if beyond && material.textures().iter().flatten().any(is_odd) {
            let name = &material.name;
            self.notes.push(format!(
                "material `{name}` repeats in URDF and MJCF, where it was clamped or mirrored"
            ));
        }
    }
}

fn set_textures(material: &mut Material, [base, rough, normal, emissive]: [Option<Texture>; 4]) {
    material.base_texture = base;
    material.metallic_roughness_texture = rough;
    material.normal_texture = normal;
    material.emissive_texture = emissive;
}

#[cfg(test)]
mod tests {
    use super::*;
    use object::appearance::Surfacing;

    /// A picture of 64 × 64 texels of which each has a colour of its own, on one material.
    fn look() -> Appearance {
        let mut pixels = Pixels::filled(64, 64, [0, 0, 0, 255]);
        for (x, y) in (0..64).flat_map(|x| (0..64).map(move |y| (x, y))) {
            pixels.set(x, y, [x as u8 * 4, y as u8 * 4, (x ^ y) as u8, 255]);
        }
        let picture = Picture::new(pixels.png().unwrap()).unwrap();
        let base_texture = Some(Texture { picture: 0, wrap: [Wrap::Repeat; 2] });
        let material = Material { base_texture, ..Material::default() };
        let face = Surfacing { material: Some(0), corners: [[0.0; 2]; 3] };
        Appearance::new(vec![picture], vec![material], vec![face]).unwrap()
    }

    fn triangle(u: f32, v: f32, size: f32) -> [[f32; 2]; 3] {
        [[u, v], [u + size, v], [u, v + size]]
    }

    fn sample(pixels: &Pixels, uv: [f32; 2]) -> [u8; 4] {
        let texel = |c: f32, n: u32| wrapped((c * n as f32).floor() as i64, n, Wrap::Repeat);
        pixels.at(texel(uv[0], pixels.width()), texel(uv[1], pixels.height()))
    }

    #[test]
    fn what_is_packed_shows_what_it_showed_and_carries_no_more() {
        let look = look();
        let was =
            [triangle(0.125, 0.125, 0.1), triangle(0.75, 0.5, 0.1), triangle(0.95, 0.95, 0.1)];
        let mut uses = [Use { name: "door".into(), corners: was.to_vec() }];
        let mut textures = Textures::new(&look);
        let laid = textures.lay(&look.materials()[0], &mut uses);
        assert_eq!(laid[0].base_texture.unwrap().picture, 0);
        assert_eq!(textures.files[0].path, "meshes/door.png");
        let now = textures.files[0].picture.pixels().unwrap();
        assert!(now.width() * now.height() < 64 * 64 / 2, "{} × {}", now.width(), now.height());
        let whole = look.pictures()[0].pixels().unwrap();
        for (was, now_at) in was.iter().flatten().zip(uses[0].corners.iter().flatten()) {
            assert_eq!(sample(&whole, *was), sample(&now, *now_at), "{was:?}");
        }
    }

    #[test]
    fn two_links_that_show_all_of_a_texture_share_it_as_it_is() {
        let look = look();
        let all = || vec![triangle(0.0, 0.0, 1.0)];
        let mut uses = ["a", "b"].map(|name| Use { name: name.into(), corners: all() });
        let mut textures = Textures::new(&look);
        textures.lay(&look.materials()[0], &mut uses);
        assert_eq!(textures.files.len(), 1);
        assert_eq!(textures.files[0].picture.bytes(), look.pictures()[0].bytes());
        assert_eq!(uses[1].corners, all());
    }

    #[test]
    fn a_texture_that_is_tiled_many_times_stays_whole() {
        let look = look();
        let mut uses = [Use { name: "floor".into(), corners: vec![triangle(0.0, 0.0, 1e9)] }];
        let mut textures = Textures::new(&look);
        textures.lay(&look.materials()[0], &mut uses);
        assert_eq!(uses[0].corners, [triangle(0.0, 0.0, 1e9)]);
    }
}
