//! MTL text → materials in our terms.
//!
//! `Kd` and `Ke` are taken as sRGB, as viewers show them, and multiply their maps. Readers differ about the
//! rest; we follow Blender's importer: roughness is `Pr`, else 1 − √(`Ns` / 1000), opacity `d` or 1 − `Tr`.

use crate::appearance::{AlphaMode, Material, Texture, Wrap};
use crate::glb::linear_of_srgb;

/// Shininess at which a surface is perfectly smooth, as Blender's importer and exporter have it.
const SMOOTH: f64 = 1000.0;

/// How a material's texture coordinates are moved before use: scaled, then shifted; v upward.
pub(super) type Moved = [[f64; 2]; 2];
/// As they are.
const AS_THEY_ARE: Moved = [[1.0; 2], [0.0; 2]];

/// A material, the names of its pictures in the order of [`Material::textures`], and how coordinates go.
#[derive(Clone, Debug)]
pub(super) struct Named {
    pub(super) name: String,
    pub(super) material: Material,
    pub(super) pictures: [Option<String>; 4],
    wraps: [[Wrap; 2]; 4],
    pub(super) moved: Moved,
}

impl Named {
    /// Lays the picture with an index on the material, as its `which`th texture.
    pub(super) fn lay(&mut self, which: usize, picture: usize) {
        let wrap = self.wraps.get(which).copied().unwrap_or_default();
        let texture = Some(Texture { picture, wrap });
        match which {
            0 => self.material.base_texture = texture,
            2 => self.material.normal_texture = texture,
            3 => self.material.emissive_texture = texture,
            _ => {}
        }
    }
}

/// A line that lays a picture on a material: the word, its options, and the picture's name.
struct Map<'a> {
    word: &'a str,
    options: Vec<&'a str>,
    name: String,
}

impl<'a> Map<'a> {
    fn of(line: &'a str) -> Option<Self> {
        let mut words = line.split_whitespace().peekable();
        let word = words.next().filter(|w| {
            let w = w.to_ascii_lowercase();
            w.starts_with("map_")
                || matches!(w.as_str(), "norm" | "bump" | "disp" | "decal" | "refl")
        })?;
        let mut options = Vec::new();
        while let Some(option) = words.next_if(|w| w.starts_with('-')) {
            options.push(option);
            let most = match option {
                "-s" | "-o" | "-t" => 3,
                "-mm" => 2,
                _ => 1,
            };
            // Where fewer numbers are written than may be, the next word is the name.
            for n in 0..most {
                let is_argument = |w: &&str| most == 1 && n == 0 || w.parse::<f64>().is_ok();
                match words.next_if(is_argument) {
                    Some(argument) => options.push(argument),
                    None => break,
                }
            }
        }
        let name = words.collect::<Vec<_>>().join(" ");
        (!name.is_empty()).then_some(Self { word, options, name })
    }

    /// Two numbers behind an option.
    fn numbers(&self, option: &str, otherwise: f64) -> [f64; 2] {
        let at = self.options.iter().position(|o| *o == option);
        let number = |n: usize| {
            let word = at.and_then(|at| self.options.get(at + n));
            word.and_then(|w| w.parse().ok()).filter(|x: &f64| x.is_finite())
        };
        [number(1).unwrap_or(otherwise), number(2).unwrap_or(otherwise)]
    }

    fn wrap(&self) -> [Wrap; 2] {
        let is_clamped = self.options.windows(2).any(|o| o == ["-clamp", "on"]);
        [if is_clamped { Wrap::Clamp } else { Wrap::Repeat }; 2]
    }
}

/// The picture that a line lays on a material in a way that is followed here.
pub(super) fn picture(line: &str) -> Option<String> {
    let map = Map::of(line)?;
    texture(map.word).map(|_| map.name)
}

/// Which texture of a material a word lays: base colour, normal, emissive.
fn texture(word: &str) -> Option<usize> {
    match word.to_ascii_lowercase().as_str() {
        "map_kd" => Some(0),
        "norm" | "map_kn" => Some(2),
        "map_ke" => Some(3),
        _ => None,
    }
}

/// Materials of an MTL text, and what of them is not followed, in plain words.
pub(super) fn parse(text: &str, most: usize, notes: &mut Vec<String>) -> Vec<Named> {
    let mut all: Vec<Named> = Vec::new();
    let mut shine: Option<f64> = None;
    for line in text.lines() {
        let line = line.trim();
        let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        if word == "newmtl" {
            if all.len() >= most {
                notes.push(format!("materials beyond the first {most} are left out"));
                break;
            }
            shine = None;
            let material =
                Material { name: rest.trim().chars().take(200).collect(), ..Material::default() };
            let (pictures, wraps) = ([const { None }; 4], [[Wrap::Repeat; 2]; 4]);
            all.push(Named {
                name: rest.trim().into(),
                material,
                pictures,
                wraps,
                moved: AS_THEY_ARE,
            });
            continue;
        }
        let Some(last) = all.last_mut() else { continue };
        match Map::of(line) {
            Some(map) => lay(last, &map, notes),
            None => factor(last, (word, rest), &mut shine),
        }
    }
    all.iter_mut().for_each(finish);
    all
}

fn lay(of: &mut Named, map: &Map<'_>, notes: &mut Vec<String>) {
    let Some(which) = texture(map.word) else {
        // Opacity beside the colour is no loss: it stands in the same picture.
        let is_alpha = map.word.eq_ignore_ascii_case("map_d");
        if !(is_alpha && of.pictures[0].as_ref() == Some(&map.name)) {
            let name: String = of.name.chars().take(80).collect();
            notes.push(format!("material `{name}`: its {} is left out", map.word));
        } else {
            of.material.alpha = AlphaMode::Blend;
        }
        return;
    };
    if which == 0 {
        of.moved = [map.numbers("-s", 1.0), map.numbers("-o", 0.0)];
    }
    of.wraps[which] = map.wrap();
    of.pictures[which] = Some(map.name.clone());
}

fn factor(of: &mut Named, (word, rest): (&str, &str), shine: &mut Option<f64>) {
    let numbers: Vec<f64> = rest
        .split_whitespace()
        .map_while(|w| w.parse().ok())
        .filter(|x: &f64| x.is_finite())
        .collect();
    let Some(&first) = numbers.first() else { return };
    // One number is a grey.
    let colour = [first, *numbers.get(1).unwrap_or(&first), *numbers.get(2).unwrap_or(&first)];
    let colour = colour.map(|c| linear_of_srgb(c.clamp(0.0, 1.0)));
    let share = first.clamp(0.0, 1.0);
    let material = &mut of.material;
    match word {
        "Kd" => material.base_colour[..3].copy_from_slice(&colour),
        "Ke" => material.emissive = colour,
        "d" => material.base_colour[3] = share,
        "Tr" => material.base_colour[3] = 1.0 - share,
        "Pm" => material.metallic = share,
        "Pr" => (material.roughness, *shine) = (share, Some(0.0)),
        "Ns" if shine.is_none() => {
            *shine = Some(first);
            material.roughness = 1.0 - (first / SMOOTH).clamp(0.0, 1.0).sqrt();
        }
        _ => {}
    }
}

/// What follows from factors and maps together.
fn finish(of: &mut Named) {
    let material = &mut of.material;
    if material.base_colour[3] < 1.0 {
        material.alpha = AlphaMode::Blend;
    }
    // A map under a black factor would not be seen: exporters leave the factor unsaid so.
    if of.pictures[0].is_some() && material.base_colour[..3] == [0.0; 3] {
        material.base_colour[..3].copy_from_slice(&[1.0; 3]);
    }
    if of.pictures[3].is_some() && material.emissive == [0.0; 3] {
        material.emissive = [1.0; 3];
    }
}
