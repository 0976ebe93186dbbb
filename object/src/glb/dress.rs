//! Materials and textures as GLB has them, and a mesh written with how it looks.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use super::document::LEFT_OUT;
use super::write::{BinaryChunk, Faces};
use crate::appearance::{AlphaMode, Appearance, Material, PictureFormat, Texture, Wrap};
use crate::mesh::Mesh;
use crate::normals::{CREASE_ANGLE, corner_normals};

/// Most surfaces that a mesh is written as: what is beyond loses its materials, and the file says so. Each has
/// four lists, of which a file may have 65,536.
const MAX_SURFACES: usize = 16_000;

/// Textures and samplers in the making: one texture for each picture and way to repeat.
#[derive(Debug, Default)]
pub struct Textures(Vec<Texture>);

impl Textures {
    fn index(&mut self, of: Texture) -> Value {
        let known = self.0.iter().position(|t| *t == of);
        let index = known.unwrap_or_else(|| {
            self.0.push(of);
            self.0.len() - 1
        });
        json!({"index": index})
    }

    /// A material by a name, with its textures by index.
    pub fn material(&mut self, name: &str, of: &Material) -> Value {
        let mut pbr = json!({"baseColorFactor": of.base_colour, "metallicFactor": of.metallic,
            "roughnessFactor": of.roughness});
        let mut material = json!({"name": name, "doubleSided": true, "alphaMode": match of.alpha {
            AlphaMode::Opaque => "OPAQUE",
            AlphaMode::Mask(_) => "MASK",
            AlphaMode::Blend => "BLEND",
        }});
        if let AlphaMode::Mask(cutoff) = of.alpha {
            material["alphaCutoff"] = cutoff.into();
        }
        if let Some(texture) = of.base_texture {
            pbr["baseColorTexture"] = self.index(texture);
        }
        if let Some(texture) = of.metallic_roughness_texture {
            pbr["metallicRoughnessTexture"] = self.index(texture);
        }
        if let Some(texture) = of.normal_texture {
            material["normalTexture"] = self.index(texture);
            material["normalTexture"]["scale"] = of.normal_scale.into();
        }
        if let Some(texture) = of.emissive_texture {
            material["emissiveTexture"] = self.index(texture);
        }
        let strength = of.emissive.iter().copied().fold(1.0, f64::max);
        if of.emissive.iter().any(|e| *e > 0.0) {
            material["emissiveFactor"] = json!(of.emissive.map(|e| e / strength));
        }
        if strength > 1.0 {
            let extension = json!({"emissiveStrength": strength});
            material["extensions"] = json!({"KHR_materials_emissive_strength": extension});
        }
        material["pbrMetallicRoughness"] = pbr;
        material
    }

    /// Puts pictures, samplers and textures into a document that has its materials; `picture` gives the bytes
    /// of an index and their media type.
    pub fn finish(
        self,
        document: &mut Value,
        chunk: &mut BinaryChunk,
        picture: impl Fn(usize) -> Option<(Vec<u8>, &'static str)>,
    ) {
        let is_bright = |m: &Value| m["extensions"].is_object();
        if document["materials"].as_array().is_some_and(|all| all.iter().any(is_bright)) {
            document["extensionsUsed"] = json!(["KHR_materials_emissive_strength"]);
        }
        if self.0.is_empty() {
            return;
        }
        let mut images = BTreeMap::new();
        for texture in &self.0 {
            if images.contains_key(&texture.picture) {
                continue;
            }
            if let Some((bytes, media_type)) = picture(texture.picture) {
                images.insert(texture.picture, chunk.image(bytes, media_type));
            }
        }
        let wrap = |wrap: Wrap| match wrap {
            Wrap::Repeat => 10497,
            Wrap::Mirror => 33648,
            Wrap::Clamp => 33071,
        };
        let sampler = |t: &Texture| json!({"wrapS": wrap(t.wrap[0]), "wrapT": wrap(t.wrap[1])});
        let texture =
            |(n, t): (usize, &Texture)| json!({"source": images.get(&t.picture), "sampler": n});
        document["samplers"] = self.0.iter().map(sampler).collect();
        document["textures"] = self.0.iter().enumerate().map(texture).collect();
    }
}

/// Writes a mesh with how it looks as a GLB file, y up, single precision: what [`super::read_noted`] reads. Faces
/// keep their order; `left_out` is what did not come along, and is said again by who reads the file. The same
/// inputs give the same bytes.
pub fn write_dressed(mesh: &Mesh, appearance: &Appearance, left_out: &[String]) -> Vec<u8> {
    let mut notes = left_out.to_vec();
    let own = |face: usize| appearance.faces().get(face).and_then(|f| f.material);
    let mut runs = runs(mesh.faces().len(), own);
    if runs.len() > MAX_SURFACES {
        notes.push(format!(
            "materials change {} times over the surface and are left out",
            runs.len()
        ));
        runs = vec![(None, (0..mesh.faces().len() as u32).collect())];
    }
    let (mut chunk, mut textures) = (BinaryChunk::default(), Textures::default());
    let normals = corner_normals(mesh, CREASE_ANGLE);
    let mut materials: Vec<Value> =
        appearance.materials().iter().map(|m| textures.material(&m.name, m)).collect();
    materials.push(json!({"pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": 0.8},
        "doubleSided": true, "alphaMode": "OPAQUE"}));
    let plain = materials.len() - 1;
    let primitive = |(material, faces): &(Option<u32>, Vec<u32>)| {
        let of = material.and_then(|m| appearance.materials().get(m as usize));
        let place =
            |f: &u32| appearance.faces().get(*f as usize).map(|s| s.corners).unwrap_or_default();
        let corners: Vec<_> = match of.is_some_and(Material::is_textured) {
            true => faces.iter().map(place).collect(),
            false => Vec::new(),
        };
        let part =
            Faces { normals: &normals, faces, corners: &corners, painted: material.is_none() };
        let mut primitive = chunk.faces(mesh, part);
        primitive["material"] = material.map_or(plain, |m| m as usize).into();
        primitive
    };
    let primitives: Vec<Value> = runs.iter().map(primitive).collect();
    let mut document = json!({
        "asset": {"version": "2.0", "generator": "kinfold"},
        "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": primitives}], "materials": materials,
    });
    if !notes.is_empty() {
        document["asset"]["extras"] = json!({LEFT_OUT: notes});
    }
    textures.finish(&mut document, &mut chunk, |index| {
        let picture = appearance.pictures().get(index)?;
        let media_type = match picture.format() {
            PictureFormat::Png => "image/png",
            PictureFormat::Jpeg => "image/jpeg",
            PictureFormat::WebP => "image/webp",
        };
        Some((picture.bytes().to_vec(), media_type))
    });
    chunk.into_glb(document)
}

/// Faces by runs of the same material.
fn runs(count: usize, of: impl Fn(usize) -> Option<u32>) -> Vec<(Option<u32>, Vec<u32>)> {
    let mut runs: Vec<(Option<u32>, Vec<u32>)> = Vec::new();
    for face in 0..count {
        let own = of(face);
        match runs.last_mut() {
            Some((material, faces)) if *material == own => faces.push(face as u32),
            _ => runs.push((own, vec![face as u32])),
        }
    }
    runs
}
