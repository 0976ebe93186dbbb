//! How a surface looks beside its shape: materials, pictures and texture coordinates.
//!
//! An [`Appearance`] belongs to one [`crate::Mesh`], face by face, and never alters it. Colours of
//! vertices stay with the mesh. Terms and meanings are those of glTF 2.0's metallic-roughness
//! materials; texture coordinates have v downward, 0 to 1 over a picture, and repeat outside of it as
//! the texture says.
//!
//! ```
//! use object::appearance::{Appearance, Material, Surfacing};
//! let brass = Material { base_colour: [0.8, 0.6, 0.2, 1.0], ..Material::default() };
//! let faces = vec![Surfacing { material: Some(0), corners: [[0.0; 2]; 3] }];
//! let appearance = Appearance::new(vec![], vec![brass], faces)?;
//! assert_eq!(appearance.of_face(0).and_then(|(m, _)| m.base_texture), None);
//! # Ok::<(), object::appearance::AppearanceError>(())
//! ```

mod bake;
mod picture;

pub use picture::{MAX_IMAGE_SIDE, MAX_PIXELS, Picture, PictureFormat, Pixels};
pub(crate) use picture::{decoded, header, media_type};

use serde::{Deserialize, Serialize};

/// Most materials of one appearance; the reader's own bound of lists in a file.
pub const MAX_MATERIALS: usize = 65_536;

/// How a texture goes on outside of 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Wrap {
    /// Again and again.
    #[default]
    Repeat,
    /// Again and again, every second time mirrored.
    Mirror,
    /// As at its edge.
    Clamp,
}

/// A picture laid on a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Texture {
    /// Index of the picture.
    pub picture: usize,
    /// How it goes on along u and v.
    pub wrap: [Wrap; 2],
}

/// What opacity means.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum AlphaMode {
    /// Nothing: all is opaque.
    #[default]
    Opaque,
    /// What is below the given opacity (0 to 1) is not there; all else is opaque.
    Mask(f64),
    /// What lies behind shines through.
    Blend,
}

/// A metallic-roughness material. Factors are linear light, 0 to 1, and multiply their texture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Material {
    /// Its name in the file; may be empty, need not be unique.
    pub name: String,
    /// Base colour and opacity.
    pub base_colour: [f64; 4],
    /// How metallic it is.
    pub metallic: f64,
    /// How rough it is.
    pub roughness: f64,
    /// Light it gives of itself; with a strength, above 1.
    pub emissive: [f64; 3],
    /// How far its normal map bends normals, 1 as it stands there.
    pub normal_scale: f64,
    /// What opacity means.
    pub alpha: AlphaMode,
    /// Whether its back is seen.
    pub double_sided: bool,
    /// sRGB base colour and opacity.
    pub base_texture: Option<Texture>,
    /// Roughness in green, metallic in blue.
    pub metallic_roughness_texture: Option<Texture>,
    /// Normals in tangent space.
    pub normal_texture: Option<Texture>,
    /// sRGB emitted light.
    pub emissive_texture: Option<Texture>,
}

impl Default for Material {
    /// White and matt, as a file without materials means it for us.
    fn default() -> Self {
        Self {
            name: String::new(),
            base_colour: [1.0; 4],
            metallic: 0.0,
            roughness: 0.8,
            emissive: [0.0; 3],
            normal_scale: 1.0,
            alpha: AlphaMode::Opaque,
            double_sided: true,
            base_texture: None,
            metallic_roughness_texture: None,
            normal_texture: None,
            emissive_texture: None,
        }
    }
}

impl Material {
    /// Its textures in the order base colour, metallic-roughness, normal, emissive.
    pub fn textures(&self) -> [Option<Texture>; 4] {
        [
            self.base_texture,
            self.metallic_roughness_texture,
            self.normal_texture,
            self.emissive_texture,
        ]
    }

    /// Whether any picture lies on it.
    pub fn is_textured(&self) -> bool {
        self.textures().iter().any(Option::is_some)
    }
}

/// What one face is made of, and where its corners lie on the textures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Surfacing {
    /// Index of the material; none where the file names none, or colours vertices itself.
    pub material: Option<u32>,
    /// Texture coordinates u, v of the three corners, v downward; zeros without a texture.
    pub corners: [[f32; 2]; 3],
}

/// Why materials, pictures and coordinates make no appearance.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AppearanceError {
    /// Above [`MAX_MATERIALS`].
    #[error("an appearance may have at most {MAX_MATERIALS} materials, found {0}")]
    TooManyMaterials(usize),
    /// Above [`MAX_PIXELS`].
    #[error("the pictures together may have at most {MAX_PIXELS} pixels, found {0}")]
    TooManyPixels(u64),
    /// A material with a number out of its range.
    #[error("material {material}: {what} must be a finite number in its range")]
    Range {
        /// Index of the material.
        material: usize,
        /// Which number.
        what: &'static str,
    },
    /// A texture names a picture that is not there.
    #[error("material {material} uses picture {picture}, but there are {pictures}")]
    UnknownPicture {
        /// Index of the material.
        material: usize,
        /// The picture it uses.
        picture: usize,
        /// How many there are.
        pictures: usize,
    },
    /// A face names a material that is not there, or has a coordinate that is not finite.
    #[error("face {face}: its material must be one of {materials} and its coordinates finite")]
    Face {
        /// Index of the face.
        face: usize,
        /// How many materials there are.
        materials: usize,
    },
}

/// Materials, pictures, and what each face of a mesh has of them.
///
/// Built only through [`Appearance::new`]: every index leads somewhere, every number is finite and in
/// its range.
#[derive(Clone, Debug, PartialEq)]
pub struct Appearance {
    pictures: Vec<Picture>,
    materials: Vec<Material>,
    faces: Vec<Surfacing>,
}

impl Appearance {
    /// How the faces that a file describes look: nothing if none has a material, or with a note if a rule is
    /// broken.
    pub(crate) fn or_noted(
        (pictures, materials, faces): (Vec<Picture>, Vec<Material>, Vec<Surfacing>),
        notes: &mut Vec<String>,
    ) -> Option<Self> {
        if faces.iter().all(|face| face.material.is_none()) {
            return None;
        }
        let made = Self::new(pictures, materials, faces);
        made.map_err(|why| notes.push(format!("materials are left out: {why}"))).ok()
    }

    /// Proves the invariants of [`Appearance`]; `faces` are in the order of the mesh's.
    ///
    /// # Errors
    /// [`AppearanceError`], the first broken rule.
    pub fn new(
        pictures: Vec<Picture>,
        materials: Vec<Material>,
        faces: Vec<Surfacing>,
    ) -> Result<Self, AppearanceError> {
        if materials.len() > MAX_MATERIALS {
            return Err(AppearanceError::TooManyMaterials(materials.len()));
        }
        let pixels = pictures.iter().map(Picture::pixel_count).sum();
        if pixels > MAX_PIXELS {
            return Err(AppearanceError::TooManyPixels(pixels));
        }
        for (material, of) in materials.iter().enumerate() {
            check(material, of)?;
            let used = of.textures().into_iter().flatten().map(|t| t.picture);
            if let Some(picture) = used.into_iter().find(|&p| p >= pictures.len()) {
                let pictures = pictures.len();
                return Err(AppearanceError::UnknownPicture { material, picture, pictures });
            }
        }
        let sound = |f: &Surfacing| {
            f.material.is_none_or(|m| (m as usize) < materials.len())
                && f.corners.iter().flatten().all(|c| c.is_finite())
        };
        match faces.iter().position(|f| !sound(f)) {
            Some(face) => Err(AppearanceError::Face { face, materials: materials.len() }),
            None => Ok(Self { pictures, materials, faces }),
        }
    }

    /// The pictures, as they are encoded in the file.
    pub fn pictures(&self) -> &[Picture] {
        &self.pictures
    }

    /// The materials.
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// What each face has, in the order of the mesh's faces.
    pub fn faces(&self) -> &[Surfacing] {
        &self.faces
    }

    /// The material of a face, and where its corners lie; none without a material.
    pub fn of_face(&self, face: usize) -> Option<(&Material, [[f32; 2]; 3])> {
        let of = self.faces.get(face)?;
        Some((self.materials.get(of.material? as usize)?, of.corners))
    }
}

fn check(material: usize, of: &Material) -> Result<(), AppearanceError> {
    let share = |x: &f64| (0.0..=1.0).contains(x);
    let cutoff = match of.alpha {
        AlphaMode::Mask(cutoff) => cutoff,
        AlphaMode::Opaque | AlphaMode::Blend => 0.0,
    };
    let rules = [
        (of.base_colour.iter().all(share), "base colour"),
        (share(&of.metallic), "metallic"),
        (share(&of.roughness), "roughness"),
        (of.emissive.iter().all(|e| e.is_finite() && *e >= 0.0), "emissive"),
        (of.normal_scale.is_finite(), "normal scale"),
        (cutoff.is_finite() && cutoff >= 0.0, "alpha cutoff"),
    ];
    match rules.into_iter().find(|(holds, _)| !holds) {
        Some((_, what)) => Err(AppearanceError::Range { material, what }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_leads_nowhere_is_no_appearance() {
        let of = |material| vec![Surfacing { material, corners: [[0.0; 2]; 3] }];
        let plain = || vec![Material::default()];
        assert!(Appearance::new(vec![], plain(), of(Some(0))).is_ok());
        assert!(Appearance::new(vec![], plain(), of(None)).is_ok());
        let beyond = Appearance::new(vec![], plain(), of(Some(1))).unwrap_err();
        assert_eq!(beyond, AppearanceError::Face { face: 0, materials: 1 });
        let mut bad = of(Some(0));
        bad[0].corners[1][0] = f32::NAN;
        assert!(Appearance::new(vec![], plain(), bad).is_err());
        let texture = Some(Texture { picture: 0, wrap: [Wrap::Repeat; 2] });
        let textured = Material { base_texture: texture, ..Material::default() };
        let told = Appearance::new(vec![], vec![textured], of(Some(0))).unwrap_err().to_string();
        assert_eq!(told, "material 0 uses picture 0, but there are 0");
        let loud = Material { roughness: f64::NAN, ..Material::default() };
        assert!(Appearance::new(vec![], vec![loud], vec![]).is_err());
    }
}
