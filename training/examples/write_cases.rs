//! Writes objects as case folders for `kinfold eval`: from shards, or from our own families.
//!
//! `write_cases OUT SHARDS|families:EACH [SKIN [apart]] [opened] [cut] [doubled] [anywhere]`
//!
//! - `SHARDS` is a folder of shards. `families:EACH` makes so many objects of each family, from a
//!   seed that nothing is fitted with.
//! - `SKIN` makes each object one fused mesh, by a recipe as [`Recipe`] writes it; with `apart`,
//!   the base is a fused mesh of its own.
//! - `opened` puts every part at rest or anywhere in its range.
//! - `cut` cuts half of the bodies into several pieces ([`cut_up`]).
//! - `doubled` draws every face twice, once each way round, as many files do.
//! - `anywhere` puts a part's point on any of its faces, larger ones more often. Without it, the
//!   point is in the middle of the face nearest the middle of the part's surface.

#![allow(clippy::print_stdout, clippy::print_stderr)]

use std::path::Path;

use blake3::hash;
use object::{ArticulatedObject, DVec3, Mesh, Part};
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use serde_json::json;
use training::dataset::cut::cut_up;
use training::dataset::evalcase::specimen;
use training::dataset::pose::opened;
use training::dataset::shards::{read_shard, shards};
use training::dataset::{Specimen, any_face, middle_face};
use training::fuse::{Recipe, fused};
use training::procedural::{self, worded};
use training::truth::TruthFile;

const USAGE: &str = "OUT SHARDS|families:EACH [SKIN [apart]] [opened] [cut] [doubled] [anywhere]";
/// The seed of families, which nothing else is made with.
const FAMILY_SEED: u64 = 55;

type Anyhow = Box<dyn std::error::Error + Send + Sync>;

/// How objects are written.
#[derive(Default)]
struct Wanted {
    skin: Option<Recipe>,
    is_apart: bool,
    is_opened: bool,
    is_cut: bool,
    is_doubled: bool,
    is_anywhere: bool,
}

fn main() -> Result<(), Anyhow> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [out, from, rest @ ..] = &args[..] else { return Err(USAGE.into()) };
    let mut wanted = Wanted::default();
    for word in rest {
        match word.as_str() {
            "apart" => wanted.is_apart = true,
            "opened" => wanted.is_opened = true,
            "cut" => wanted.is_cut = true,
            "doubled" => wanted.is_doubled = true,
            "anywhere" => wanted.is_anywhere = true,
            written if wanted.skin.is_none() => wanted.skin = Some(written.parse()?),
            _ => return Err(format!("a second skin, `{word}`: {USAGE}").into()),
        }
    }
    if wanted.is_apart && wanted.skin.is_none() {
        return Err(format!("apart, but no skin: {USAGE}").into());
    }
    if let Some(each) = from.strip_prefix("families:") {
        let all: Vec<procedural::Id> = procedural::each(each.parse()?).collect();
        return all.into_par_iter().try_for_each(|id| {
            let made = worded(id, FAMILY_SEED)?;
            write(Path::new(out), made, &wanted)
        });
    }
    for shard in shards(Path::new(from))? {
        let bundles = read_shard(&shard)?;
        bundles.par_iter().for_each(|bundle| {
            let told = |e: Anyhow| eprintln!("{}: {e}", bundle.id);
            let written = specimen(bundle).map_err(Into::into);
            written.and_then(|s| write(Path::new(out), s, &wanted)).unwrap_or_else(told);
        });
        eprintln!("{}", shard.display());
    }
    Ok(())
}

fn write(out: &Path, mut specimen: Specimen, wanted: &Wanted) -> Result<(), Anyhow> {
    let id = specimen.id.clone();
    let mut dice = Pcg64Mcg::from_seed(hash(id.as_bytes()).as_bytes()[..16].try_into()?);
    if wanted.is_opened {
        specimen.object = opened(&specimen.object, &mut dice)?;
    }
    if wanted.is_cut {
        specimen.object = cut_up(&specimen.object, &mut dice)?;
    }
    if let Some(recipe) = &wanted.skin {
        specimen =
            if wanted.is_apart { apart(&specimen, recipe)? } else { fused(&specimen, recipe)? };
    }
    let object = &specimen.object;
    let end = if wanted.skin.is_some() { "-fused" } else { "" };
    let folder = out.join(format!("{id}{end}"));
    std::fs::create_dir_all(&folder)?;
    let sides = if wanted.is_doubled { 2 } else { 1 };
    std::fs::write(folder.join("mesh.glb"), object::glb::write(&drawn(object.mesh(), sides)?))?;
    let labels = object.part_of_face().iter().flat_map(|&label| std::iter::repeat_n(label, sides));
    let labels: Vec<u8> = labels.flat_map(u16::to_le_bytes).collect();
    std::fs::write(folder.join("face_labels.u16le"), labels)?;
    let mut truth = TruthFile::of(object);
    for (part, said) in truth.parts.iter_mut().zip(object.tree().parts()) {
        part.name.clone_from(&said.text);
    }
    std::fs::write(folder.join("truth.json"), serde_json::to_vec(&truth)?)?;
    let clicks = wanted.is_anywhere.then_some(&mut dice);
    let condition = condition(object, clicks);
    std::fs::write(folder.join("condition.json"), serde_json::to_vec_pretty(&condition)?)?;
    Ok(())
}

/// The specimen as skins, of which the base is one of its own: drawn beside the rest and put back.
fn apart(specimen: &Specimen, recipe: &Recipe) -> Result<Specimen, Anyhow> {
    let size = specimen.object.mesh().bounds().size();
    let shortest = DVec3::AXES.into_iter().min_by(|a, b| size.dot(*a).total_cmp(&size.dot(*b)));
    let aside = 2.0 * size.dot(shortest.unwrap_or(DVec3::Z)) * shortest.unwrap_or(DVec3::Z);
    let mut drawn = specimen.clone();
    drawn.object = moved(&drawn.object, aside)?;
    let mut skins = fused(&drawn, recipe)?;
    skins.object = moved(&skins.object, -aside)?;
    Ok(skins)
}

/// The object with its base elsewhere.
fn moved(object: &ArticulatedObject, way: DVec3) -> Result<ArticulatedObject, Anyhow> {
    let (mesh, root) = (object.mesh(), object.tree().root() as u16);
    let faces = object.part_of_face().iter().enumerate();
    let put = |(face, &part): (usize, &u16)| {
        mesh.corners(face).map(|c| if part == root { c + way } else { c })
    };
    let put = Mesh::of_triangles(&faces.map(put).collect::<Vec<_>>())?.with_frame(mesh.frame());
    Ok(object.with_surface(put, object.part_of_face().to_vec())?)
}

/// The mesh as it is, or with every face followed by itself as seen from behind.
fn drawn(mesh: &Mesh, sides: usize) -> Result<Mesh, Anyhow> {
    let faces =
        mesh.faces().iter().flat_map(|&[a, b, c]| [[a, b, c], [b, a, c]].into_iter().take(sides));
    let drawn = Mesh::new(mesh.vertices().to_vec(), faces.collect())?;
    Ok(drawn.with_colours(mesh.colours().map(<[_]>::to_vec))?.with_frame(mesh.frame()))
}

/// The object's words, tree and kinds of joints, with a point on every part (`condition/1`), in its middle
/// unless dice say where.
fn condition(object: &ArticulatedObject, mut dice: Option<&mut Pcg64Mcg>) -> serde_json::Value {
    let frame = object.mesh().frame();
    let part = |(id, part): (usize, &Part)| {
        let faces: Vec<usize> = object.faces_of(id).collect();
        let face = match &mut dice {
            Some(dice) => any_face(object.mesh(), &faces, dice),
            None => middle_face(object.mesh(), &faces),
        };
        let point = face.map(|f| frame.point_to_file(object.mesh().centroid(f)).to_array());
        let kinds: Vec<_> = part.joints.iter().map(|k| json!(k)).collect();
        json!({"id": id, "text": part.text, "parent": part.parent, "joints": kinds, "point": point})
    };
    let parts: Vec<_> = object.tree().parts().iter().enumerate().map(part).collect();
    json!({"schema": "condition/1", "category": "object", "parts": parts})
}
