//! A stage's surfaces and materials in the object frame and our terms.

use std::collections::BTreeMap;

use glamx::DVec3;
use rustc_hash::FxHashMap;

use super::error::UsdError;
use super::scene::{Input, Laid, Look, Scene, Surface};
use crate::appearance::{AlphaMode, Appearance, Material, Picture, Surfacing, Texture};
use crate::beside::Beside;
use crate::glb::srgb_of_linear;
use crate::mesh::{FileFrame, MAX_FACES, MAX_VERTICES, Mesh, UpAxis, limit};
use crate::reading::{Reading, shortened};

/// What `UsdPreviewSurface` says where a material does not.
const GREY: f64 = 0.18;
const ROUGH: f64 = 0.5;

/// How a material's coordinates go: the set, and scale, turn and shift.
type Coordinates = Option<(String, [f64; 5])>;

/// The mesh of a scene with how it looks.
pub(super) fn reading(scene: Scene, up: UpAxis, files: Beside<'_>) -> Result<Reading, UsdError> {
    let up = match scene.up.as_deref() {
        Some("Z") => UpAxis::Z,
        Some("Y") => UpAxis::Y,
        _ => up,
    };
    if !(scene.unit.is_finite() && scene.unit > 0.0) {
        let (rule, found) = ("metersPerUnit is a number above 0", scene.unit.to_string());
        return Err(UsdError::Rule { prim: "/".into(), rule: rule.into(), found });
    }
    let mut dresser =
        Dresser { notes: scene.notes, pictures: vec![], places: BTreeMap::new(), files };
    let materials: Vec<_> = scene.looks.iter().map(|look| dresser.material(look)).collect();
    let mut surface = Joined { frame: FileFrame { up }, unit: scene.unit, ..Joined::default() };
    for part in &scene.surfaces {
        surface.add(part, &materials)?;
    }
    let Joined { vertices, colours, coloured, faces, dress, frame, .. } = surface;
    let mesh = Mesh::new(vertices, faces)?.with_frame(frame);
    let mesh = mesh.with_colours(coloured.then_some(colours))?;
    let Dresser { mut notes, pictures, .. } = dresser;
    let materials = materials.into_iter().map(|(material, _)| material).collect();
    let appearance = Appearance::or_noted((pictures, materials, dress), &mut notes);
    Ok(Reading { mesh, appearance, notes: shortened(notes) })
}

/// All surfaces in one.
#[derive(Default)]
struct Joined {
    frame: FileFrame,
    unit: f64,
    vertices: Vec<DVec3>,
    colours: Vec<[u8; 4]>,
    coloured: bool,
    faces: Vec<[u32; 3]>,
    dress: Vec<Surfacing>,
}

impl Joined {
    fn add(&mut self, of: &Surface, materials: &[(Material, Coordinates)]) -> Result<(), UsdError> {
        // Points that have several colours are several vertices.
        let mut known: FxHashMap<(u32, [u8; 4]), u32> = FxHashMap::default();
        for (number, polygon) in of.polygons.iter().enumerate() {
            let index = of.bound.of(number);
            let material = index.and_then(|i| materials.get(i));
            let set = material.and_then(|(_, c)| c.as_ref());
            let set = set
                .and_then(|(name, moved)| Some((of.places.iter().find(|p| p.0 == *name)?, moved)));
            let mut corners = polygon.chunks_exact(2).map(|pair| {
                let (point, corner) = (pair[0], pair[1] as usize);
                let colour = match (material, &of.colours) {
                    (None, Some(all)) => all.at(number, point, corner).map_or([255; 4], shown),
                    _ => [255; 4],
                };
                let place = set.and_then(|((_, all), moved)| {
                    Some(moved_place(all.at(number, point, corner)?, moved))
                });
                let vertex = *known.entry((point, colour)).or_insert_with(|| {
                    let p = of.points.get(point as usize).copied().unwrap_or_default();
                    self.vertices.push(self.frame.point_to_object(p * self.unit));
                    self.colours.push(colour);
                    self.vertices.len() as u32 - 1
                });
                (vertex, place.unwrap_or_default())
            });
            let (Some(hub), Some(mut last)) = (corners.next(), corners.next()) else { continue };
            for next in corners {
                self.faces.push([hub.0, last.0, next.0]);
                let material = index.map(|i| i as u32);
                self.dress.push(Surfacing { material, corners: [hub.1, last.1, next.1] });
                last = next;
            }
            limit("vertices", MAX_VERTICES, self.vertices.len())?;
            limit("triangles", MAX_FACES, self.faces.len())?;
        }
        self.coloured |= of.colours.is_some();
        Ok(())
    }
}

/// A linear colour as sRGB bytes.
fn shown(colour: [f64; 4]) -> [u8; 4] {
    let [r, g, b, a] = colour.map(|c| if c.is_finite() { c.clamp(0.0, 1.0) } else { 1.0 });
    let byte = |c: f64| (c * 255.0).round() as u8;
    [byte(srgb_of_linear(r)), byte(srgb_of_linear(g)), byte(srgb_of_linear(b)), byte(a)]
}

/// Coordinates scaled, turned and shifted; v downward.
fn moved_place([u, v]: [f64; 2], moved: &[f64; 5]) -> [f32; 2] {
    let (u, v) = (u * moved[0], v * moved[1]);
    let (sin, cos) = moved[2].to_radians().sin_cos();
    let (u, v) = (cos * u - sin * v + moved[3], sin * u + cos * v + moved[4]);
    [u as f32, (1.0 - v) as f32].map(|c| if c.is_finite() { c } else { 0.0 })
}

/// Makes materials and fetches their pictures, each once.
struct Dresser<'b> {
    notes: Vec<String>,
    pictures: Vec<Picture>,
    places: BTreeMap<String, Option<usize>>,
    files: Beside<'b>,
}

impl Dresser<'_> {
    fn material(&mut self, look: &Look) -> (Material, Coordinates) {
        let share = |x: f64| x.clamp(0.0, 1.0);
        let number = |input: &Input, otherwise: f64| match &input.picture {
            Some(_) => 1.0,
            None => input.value.as_ref().and_then(|v| v.first().copied()).map_or(otherwise, share),
        };
        let colour = |input: &Input, otherwise: f64| match input.value.as_deref() {
            Some([r, g, b, ..]) => [*r, *g, *b].map(share),
            _ => [if input.picture.is_some() { 1.0 } else { otherwise }; 3],
        };
        let mut coordinates = None;
        let base_texture = self.lay(look, &look.base.picture, "base colour", &mut coordinates);
        let emissive_texture = self.lay(look, &look.emissive.picture, "emissive", &mut coordinates);
        let normal_texture = self.lay(look, &look.normal.picture, "normal", &mut coordinates);
        let packed = self.packed(look);
        let metallic_roughness_texture =
            self.lay(look, &packed, "metallic-roughness", &mut coordinates);
        let is_packed = metallic_roughness_texture.is_some();
        let of = |input: &Input, otherwise| match (&input.picture, is_packed) {
            (Some(_), false) => otherwise,
            _ => number(input, otherwise),
        };
        let [r, g, b] = colour(&look.base, GREY);
        let cutoff = look.threshold.value.as_ref().and_then(|v| v.first().copied()).unwrap_or(0.0);
        let opacity = self.opacity(look, base_texture.is_some());
        let alpha = match opacity {
            None => AlphaMode::Opaque,
            Some(_) if cutoff > 0.0 => AlphaMode::Mask(share(cutoff)),
            Some(_) => AlphaMode::Blend,
        };
        let emissive = look.emissive.picture.is_some() && emissive_texture.is_none();
        let material = Material {
            name: look.name.chars().take(200).collect(),
            base_colour: [r, g, b, opacity.unwrap_or(1.0)],
            metallic: of(&look.metallic, 0.0),
            roughness: of(&look.roughness, ROUGH),
            emissive: if emissive { [0.0; 3] } else { colour(&look.emissive, 0.0) },
            alpha,
            base_texture,
            metallic_roughness_texture,
            normal_texture,
            emissive_texture,
            ..Material::default()
        };
        (material, coordinates)
    }

    /// Opacity's factor where something may be seen through: a number below 1, or the base picture's own.
    fn opacity(&mut self, look: &Look, has_base: bool) -> Option<f64> {
        match (&look.opacity.picture, &look.base.picture) {
            (None, _) => {
                let value = look.opacity.value.as_ref()?.first().copied()?;
                (value < 1.0).then_some(value.max(0.0))
            }
            (Some(own), Some(base)) if own.file == base.file && own.channel == "a" && has_base => {
                Some(1.0)
            }
            _ => {
                self.notes.push(format!("{}: its opacity texture is left out", look.path));
                None
            }
        }
    }

    /// The picture with roughness in green and metallic in blue, where these are in one, as glTF has them.
    fn packed(&mut self, look: &Look) -> Option<Laid> {
        let (rough, metal) = (look.roughness.picture.as_ref(), look.metallic.picture.as_ref());
        let fits = |laid: Option<&Laid>, channel: &str| laid.is_none_or(|l| l.channel == channel);
        let laid = rough.or(metal)?;
        let is_one = fits(rough, "g")
            && fits(metal, "b")
            && rough.is_none_or(|r| metal.is_none_or(|m| r.file == m.file));
        if is_one {
            return Some(laid.clone());
        }
        self.notes.push(format!("{}: its metallic and roughness textures are left out", look.path));
        None
    }

    fn lay(
        &mut self,
        look: &Look,
        laid: &Option<Laid>,
        what: &str,
        coordinates: &mut Coordinates,
    ) -> Option<Texture> {
        let laid = laid.as_ref()?;
        let own = (laid.set.clone(), laid.moved);
        if *coordinates.get_or_insert_with(|| own.clone()) != own {
            let path = &look.path;
            self.notes.push(format!(
                "{path}: its {what} texture has coordinates of its own and is left out"
            ));
            return None;
        }
        let known = self.places.get(&laid.file).copied();
        let place = known.unwrap_or_else(|| {
            let read = (self.files)(&laid.file).map_err(|why| format!("it {why}"));
            let place = match read.and_then(|found| Picture::new(found.bytes)) {
                Ok(picture) => {
                    self.pictures.push(picture);
                    Some(self.pictures.len() - 1)
                }
                Err(why) => {
                    let name: String = laid.file.chars().take(200).collect();
                    self.notes.push(format!("picture `{name}` is left out: {why}"));
                    None
                }
            };
            self.places.insert(laid.file.clone(), place);
            place
        });
        place.map(|picture| Texture { picture, wrap: laid.wrap })
    }
}
