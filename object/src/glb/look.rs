//! Materials, pictures and texture coordinates of a glTF surface, kept as the file has them.

use super::accessor::Accessors;
use super::error::GlbError;
use super::materials::{CLAMP, MIRROR, Material as FileMaterial, TextureInfo, TextureTransform};
use super::paint::{Painter, texture_source};
use super::primitive::Source;
use super::tint::{Tinted, tinted};
use crate::appearance::{
    AlphaMode, Appearance, MAX_PIXELS, Material, Picture, Surfacing, Texture, Wrap,
};

/// What of a file's looks is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Looks {
    /// Colours of vertices alone.
    Colours,
    /// Materials and textures, too.
    Materials,
}

/// What a glTF file may leave unsaid: fully metallic and rough.
const METALLIC_ROUGH: f64 = 1.0;
/// What a mask leaves out where the file does not say (glTF 2.0).
const CUTOFF: f64 = 0.5;
/// Most pixels of pictures with colours of vertices laid over them: a quarter of all that may be.
const MOST_BAKED: u64 = MAX_PIXELS / 4;
/// Extensions of materials that are followed, or that say no more than how light is reckoned.
const FOLLOWED: [&str; 2] = ["KHR_materials_emissive_strength", "KHR_materials_ior"];

/// Which set of coordinates textures take, and how they are moved first.
type Coordinates<'a> = (u32, Option<&'a TextureTransform>);

/// Materials of a file, and what the faces laid so far have of them.
#[derive(Debug)]
pub(super) struct Look<'a> {
    pictures: Vec<Picture>,
    /// For each material of the file, what it became and which coordinates its textures take.
    materials: Vec<(Material, Option<Coordinates<'a>>)>,
    faces: Option<Vec<Surfacing>>,
    notes: Vec<String>,
    /// Pixels of pictures that were made here.
    baked: u64,
}

impl<'a> Look<'a> {
    /// Reads materials and the headers of pictures; with [`Looks::Colours`] nothing.
    pub(super) fn new(
        accessors: Accessors<'a>,
        painter: &Painter<'a>,
        looks: Looks,
    ) -> Result<Self, GlbError> {
        let faces = (looks == Looks::Materials).then(Vec::new);
        let mut look = Self { pictures: vec![], materials: vec![], faces, notes: vec![], baked: 0 };
        if looks == Looks::Colours {
            return Ok(look);
        }
        let document = accessors.document;
        let mut place_of = vec![None; document.images.len()];
        for (index, place) in place_of.iter_mut().enumerate() {
            let Some(bytes) = painter.image_bytes(index, &format!("image {index}"))? else {
                continue;
            };
            match Picture::new(bytes.into_owned()) {
                Ok(picture) => {
                    *place = Some(look.pictures.len());
                    look.pictures.push(picture);
                }
                Err(why) => look.notes.push(format!("image {index} is left out: {why}")),
            }
        }
        for (index, material) in document.materials.iter().enumerate() {
            let reader =
                Reader { accessors, place_of: &place_of, place: format!("material {index}") };
            let read = reader.material(material, &mut look.notes)?;
            look.materials.push(read);
        }
        Ok(look)
    }

    /// A primitive's material, and the texture coordinates of its vertices.
    pub(super) fn of(
        &mut self,
        source: &Source<'_>,
        (vertices, faces): (usize, &[[u32; 3]]),
    ) -> Result<(Option<u32>, Vec<[f32; 2]>), GlbError> {
        let none = (None, Vec::new());
        if self.faces.is_none() {
            return Ok(none);
        }
        let Some(index) = source.primitive.material else { return Ok(none) };
        let Some((material, coordinates)) = self.materials.get(index) else { return Ok(none) };
        let is_tinted = source.is_tinted(vertices)?;
        let Some((set, transform)) = coordinates else {
            // Vertices that have colours of their own keep them.
            return Ok((u32::try_from(index).ok().filter(|_| !is_tinted), Vec::new()));
        };
        let name = format!("TEXCOORD_{set}");
        let Some(rows) = source.rows::<2>(&name)? else {
            let (place, of) = (&source.place, &material.name);
            self.notes.push(format!("{place}: `{of}` has textures and the surface no {name}"));
            return Ok(none);
        };
        let moved = |row: &[f64; 2]| {
            let at = transform.map_or(*row, |t| t.moved(*row)).map(|c| c as f32);
            if at.iter().all(|c| c.is_finite()) { at } else { [0.0; 2] }
        };
        let rows: Vec<_> = source.checked(&name, rows, vertices)?.iter().map(moved).collect();
        let index = match source.colours(vertices)?.filter(|_| is_tinted) {
            Some(tints) => self.tinted(source, index, (faces, &rows, &tints)),
            None => index,
        };
        Ok((u32::try_from(index).ok(), rows))
    }

    /// A material whose base colour is multiplied by the colours of vertices, as glTF has it: by its factor
    /// where they have one colour, else by a picture of its own.
    fn tinted(&mut self, source: &Source<'_>, index: usize, over: Tinted<'_>) -> usize {
        let Some((material, _)) = self.materials.get(index) else { return index };
        let mut material = material.clone();
        let tints = over.2;
        if let Some(one) = tints.first().filter(|one| tints.iter().all(|t| t == *one)) {
            (0..4).for_each(|k| material.base_colour[k] *= one[k].clamp(0.0, 1.0));
            return self.added(material);
        }
        let base = material.base_texture.and_then(|t| Some((t, self.pictures.get(t.picture)?)));
        let baked = self.baked;
        let made = base.filter(|(_, p)| baked + p.pixel_count() <= MOST_BAKED);
        let made = made.and_then(|(texture, picture)| {
            let pixels = tinted(&picture.pixels().ok()?, over)?;
            Some((texture, Picture::new(pixels.png().ok()?).ok()?))
        });
        let Some((texture, picture)) = made else {
            let place = &source.place;
            self.notes.push(format!(
                "{place}: colours of vertices over a texture that repeats or has none are left out"
            ));
            return index;
        };
        self.baked += picture.pixel_count();
        self.pictures.push(picture);
        material.base_texture = Some(Texture { picture: self.pictures.len() - 1, ..texture });
        self.added(material)
    }

    /// The index of a material, a new one where there is none like it.
    fn added(&mut self, material: Material) -> usize {
        let known = self.materials.iter().position(|(m, _)| *m == material);
        known.unwrap_or_else(|| {
            self.materials.push((material, None));
            self.materials.len() - 1
        })
    }

    /// Adds the faces of a primitive, by their vertices in it.
    pub(super) fn append(
        &mut self,
        (material, rows): &(Option<u32>, Vec<[f32; 2]>),
        faces: impl Iterator<Item = [u32; 3]>,
    ) {
        let Some(all) = &mut self.faces else { return };
        let corner = |v: u32| rows.get(v as usize).copied().unwrap_or_default();
        all.extend(faces.map(|f| Surfacing { material: *material, corners: f.map(corner) }));
    }

    /// How all faces look, unless no face has a material; and what was left out.
    pub(super) fn finish(self) -> (Option<Appearance>, Vec<String>) {
        let Self { pictures, materials, faces, mut notes, .. } = self;
        let faces = faces.unwrap_or_default();
        let materials = materials.into_iter().map(|(material, _)| material).collect();
        (Appearance::or_noted((pictures, materials, faces), &mut notes), notes)
    }
}

/// Reads one material.
struct Reader<'a, 'p> {
    accessors: Accessors<'a>,
    /// For each image of the file, its place among those that can be read.
    place_of: &'p [Option<usize>],
    place: String,
}

impl<'a> Reader<'a, '_> {
    fn material(
        &self,
        of: &'a FileMaterial,
        notes: &mut Vec<String>,
    ) -> Result<(Material, Option<Coordinates<'a>>), GlbError> {
        let pbr = &of.pbr_metallic_roughness;
        let infos = [
            ("base colour", &pbr.base_color_texture),
            ("metallic-roughness", &pbr.metallic_roughness_texture),
            ("normal", &of.normal_texture),
            ("emissive", &of.emissive_texture),
        ];
        let mut coordinates = None;
        let mut textures = [None; 4];
        for ((what, info), texture) in infos.into_iter().zip(&mut textures) {
            let Some(info) = info else { continue };
            let own = info.coordinates();
            if *coordinates.get_or_insert(own) != own {
                let place = &self.place;
                notes.push(format!(
                    "{place}: its {what} texture has coordinates of its own and is left out"
                ));
                continue;
            }
            *texture = self.texture(info, what, notes)?;
        }
        self.note_losses(of, notes);
        let share = |x: Option<f64>, otherwise: f64| match x {
            Some(x) if x.is_finite() => x.clamp(0.0, 1.0),
            _ => otherwise,
        };
        let colour = pbr.base_color_factor.unwrap_or([1.0; 4]).map(|c| share(Some(c), 1.0));
        let strength = of.extensions.get("KHR_materials_emissive_strength");
        let strength = strength.and_then(|e| e.get("emissiveStrength")?.as_f64()).unwrap_or(1.0);
        let emissive = of.emissive_factor.unwrap_or_default().map(|e| share(Some(e), 0.0));
        let [base_texture, metallic_roughness_texture, normal_texture, emissive_texture] = textures;
        let material = Material {
            name: of.name.clone().unwrap_or_default().chars().take(200).collect(),
            base_colour: colour,
            metallic: share(pbr.metallic_factor, METALLIC_ROUGH),
            roughness: share(pbr.roughness_factor, METALLIC_ROUGH),
            emissive: emissive.map(|e| e * strength.clamp(0.0, 1e6)),
            normal_scale: of.normal_texture.as_ref().and_then(|t| t.scale).unwrap_or(1.0),
            alpha: match of.alpha_mode.as_deref() {
                Some("MASK") => AlphaMode::Mask(share(of.alpha_cutoff, CUTOFF)),
                Some("BLEND") => AlphaMode::Blend,
                _ => AlphaMode::Opaque,
            },
            double_sided: of.double_sided,
            base_texture,
            metallic_roughness_texture,
            normal_texture,
            emissive_texture,
        };
        Ok((material, coordinates.filter(|_| textures.iter().any(Option::is_some))))
    }

    fn note_losses(&self, of: &FileMaterial, notes: &mut Vec<String>) {
        let place = &self.place;
        if of.occlusion_texture.is_some() {
            notes.push(format!("{place}: its occlusion texture is left out"));
        }
        for name in of.extensions.keys().filter(|e| !FOLLOWED.contains(&e.as_str())) {
            let name: String = name.chars().take(80).collect();
            notes.push(format!("{place}: `{name}` is left out"));
        }
    }

    fn texture(
        &self,
        info: &TextureInfo,
        what: &str,
        notes: &mut Vec<String>,
    ) -> Result<Option<Texture>, GlbError> {
        let document = self.accessors.document;
        let (image, wrap) = texture_source(document, &self.place, info)?;
        let picture = image.and_then(|i| self.place_of.get(i).copied().flatten());
        let Some(picture) = picture else {
            let extensions = document.textures.get(info.index).map(|t| &t.extensions);
            let kind = match extensions {
                Some(e) if e.basis.is_some() => "a Basis texture, which kinfold does not decode",
                Some(e) if e.avif.is_some() => "an AVIF picture, which kinfold does not decode",
                _ => "no picture that can be read",
            };
            notes.push(format!("{}: its {what} texture is {kind}", self.place));
            return Ok(None);
        };
        let wrap = wrap.map(|code| match code {
            CLAMP => Wrap::Clamp,
            MIRROR => Wrap::Mirror,
            _ => Wrap::Repeat,
        });
        Ok(Some(Texture { picture, wrap }))
    }
}
