//! Files of meshes: `mesh-…`.

use std::collections::{BTreeMap, BTreeSet};

use object::Mesh;
use object::mesh::UpAxis;
use object::weld::Weld;

use super::language::Language;
use super::model::Model;
use super::needed::Needed;
use super::planted::{Made, Planted, first, made};
use crate::fix::winding::{turned_obj, turned_stl};

/// Bytes of a binary STL before its first face, and of each face.
const STL: (usize, usize) = (84, 50);
const NO_MESH: &str = "it names no mesh file";

/// The mesh files of a model, as drawn.
fn meshes<'m>(model: &'m Model, word: &str) -> Vec<&'m Needed> {
    let all = model.needed.iter().filter(|n| n.is_mesh && !n.named.is_empty());
    model.drawn(word, all.collect())
}

/// The first element that names a mesh gets another name to name.
fn renamed(model: &Model, word: &str, of: impl Fn(&str) -> Result<String, String>) -> Made {
    first(meshes(model, word), NO_MESH, |mesh| {
        let (at, attribute) = *mesh.named.first().ok_or(NO_MESH)?;
        let (source, told) = (&model.source, of(&mesh.told)?);
        let mut edits = vec![match attribute {
            "" => source.replace(at, format!("<uri>{}</uri>", guard::text::markup(&told))),
            attribute => source.set(at, attribute, &told),
        }];
        // What shapes call a mesh of MJCF would change with its file.
        if model.language == Language::Mjcf && source.get(at, "name").is_none() {
            let name = mesh.told.rsplit('/').next().unwrap_or(&mesh.told);
            let stem = name.rsplit_once('.').map_or(name, |(stem, _)| stem);
            edits.push(source.set(at, "name", stem));
        }
        made(format!("mesh `{}`", mesh.told), source.line(at), format!("named `{told}`"), edits)
    })
}

fn in_folder(told: &str, of: impl Fn(&str) -> String) -> String {
    match told.rsplit_once('/') {
        Some((folder, name)) => format!("{folder}/{}", of(name)),
        None => of(told),
    }
}

pub(super) fn missing(model: &Model, word: &str) -> Made {
    renamed(model, word, |told| Ok(in_folder(told, |name| format!("not_there_{name}"))))
}

pub(super) fn elsewhere(model: &Model, word: &str) -> Made {
    renamed(model, word, |told| {
        let name = told.rsplit('/').next().unwrap_or(told);
        Ok(format!("/home/user/catkin_ws/src/robot/meshes/{name}"))
    })
}

pub(super) fn other_case(model: &Model, word: &str) -> Made {
    let swapped = |name: &str| -> String {
        let turn = |c: char| {
            if c.is_ascii_lowercase() { c.to_ascii_uppercase() } else { c.to_ascii_lowercase() }
        };
        name.chars().map(turn).collect()
    };
    renamed(model, word, |told| {
        let new = in_folder(told, swapped);
        let is_free = new != told && model.needed.iter().all(|n| n.told != new);
        if is_free { Ok(new) } else { Err("its name has one case only".into()) }
    })
}

/// A mesh file with other bytes.
fn rewritten(
    model: &Model,
    word: &str,
    touched: bool,
    of: impl Fn(&Needed) -> Result<(Vec<u8>, String), String>,
) -> Made {
    let pieces = model.robot.links.iter().flat_map(|l| &l.collisions);
    let in_use: BTreeSet<&str> = pieces.map(|s| s.source.as_str()).collect();
    let is_touched = |n: &&Needed| in_use.contains(n.read.as_str());
    let all = meshes(model, word).into_iter().filter(|n| !touched || is_touched(n));
    let all: Vec<&Needed> = all.collect();
    first(all, NO_MESH, |mesh| {
        let (bytes, words) = of(mesh)?;
        let line = mesh.named.first().map_or(0, |(at, _)| model.source.line(*at));
        let files = BTreeMap::from([(mesh.to.clone(), bytes)]);
        let subject = format!("mesh `{}`", mesh.told);
        Ok(Planted { subject, line, words, files, ..Planted::default() })
    })
}

pub(super) fn empty(model: &Model, word: &str) -> Made {
    rewritten(model, word, false, |_| Ok((vec![], "its file is empty".into())))
}

pub(super) fn cut_off(model: &Model, word: &str) -> Made {
    rewritten(model, word, false, |mesh| {
        let half = mesh.bytes.len() / 2;
        Ok((mesh.bytes[..half].to_vec(), format!("its file ends after {half} bytes")))
    })
}

/// What a mesh file is, by its name.
enum Written<'m> {
    Obj(&'m str),
    /// A binary STL and how many faces it has.
    Stl(usize),
}

fn written(mesh: &Needed) -> Result<Written<'_>, String> {
    let ending = mesh.to.rsplit_once('.').map_or("", |(_, e)| e).to_ascii_lowercase();
    match ending.as_str() {
        "obj" => {
            let text = std::str::from_utf8(&mesh.bytes);
            Ok(Written::Obj(text.map_err(|_| "an OBJ file of it is not UTF-8")?))
        }
        "stl" => {
            let count = mesh.bytes.get(80..84).and_then(|b| <[u8; 4]>::try_from(b).ok());
            let count = count.map_or(0, u32::from_le_bytes) as usize;
            match mesh.bytes.len() == STL.0 + STL.1 * count && count > 0 {
                true => Ok(Written::Stl(count)),
                false => Err("only binary STL and OBJ files are edited".into()),
            }
        }
        _ => Err("only binary STL and OBJ files are edited".into()),
    }
}

pub(super) fn not_a_number(model: &Model, word: &str) -> Made {
    rewritten(model, word, false, |mesh| {
        let words = "a coordinate of its first vertex is nan".to_owned();
        match written(mesh)? {
            Written::Obj(text) => {
                let is_vertex = |l: &&str| l.trim_start().starts_with("v ");
                let line = text.lines().find(is_vertex).ok_or("it has no vertex")?;
                let rest: Vec<&str> = line.split_whitespace().skip(2).collect();
                let told = format!("v nan {}", rest.join(" "));
                Ok((text.replacen(line, &told, 1).into_bytes(), words))
            }
            Written::Stl(_) => {
                let mut bytes = mesh.bytes.to_vec();
                let first = STL.0 + 12;
                bytes[first..first + 4].copy_from_slice(&f32::NAN.to_le_bytes());
                Ok((bytes, words))
            }
        }
    })
}

/// The mesh of a file, if it is closed and encloses a volume.
fn closed(mesh: &Needed, written: &Written) -> Result<Mesh, String> {
    let read = match written {
        Written::Obj(text) => object::obj::read(text, UpAxis::Z).map_err(|e| e.to_string())?,
        Written::Stl(_) => object::stl::read(&mesh.bytes).map_err(|e| e.to_string())?,
    };
    let mut uses: BTreeMap<[u32; 2], [usize; 2]> = BTreeMap::new();
    for [a, b, c] in Weld::new(&read).faces {
        for [p, q] in [[a, b], [b, c], [c, a]] {
            uses.entry([p.min(q), p.max(q)]).or_default()[usize::from(p < q)] += 1;
        }
    }
    match uses.values().all(|u| *u == [1, 1]) && read.signed_volume() > 0.0 {
        true => Ok(read),
        false => Err("no mesh of it is closed".into()),
    }
}

pub(super) fn inside_out(model: &Model, word: &str) -> Made {
    rewritten(model, word, false, |mesh| {
        let kind = written(mesh)?;
        let turn = vec![true; closed(mesh, &kind)?.faces().len()];
        let bytes = match kind {
            Written::Obj(_) => turned_obj(&mesh.bytes, &turn)?,
            Written::Stl(_) => turned_stl(&mesh.bytes, &turn)?,
        };
        Ok((bytes, format!("its {} faces turned round", turn.len())))
    })
}

pub(super) fn open(model: &Model, word: &str) -> Made {
    /// Share of the faces that is left out; a guess.
    const LEFT_OUT: usize = 10;
    rewritten(model, word, true, |mesh| {
        let kind = written(mesh)?;
        closed(mesh, &kind)?;
        match kind {
            Written::Stl(count) => {
                let gone = count.div_ceil(LEFT_OUT);
                let kept = count - gone;
                let mut bytes = mesh.bytes[..STL.0 + STL.1 * kept].to_vec();
                bytes[80..84].copy_from_slice(&(kept as u32).to_le_bytes());
                Ok((bytes, format!("{gone} of its {count} faces left out")))
            }
            Written::Obj(text) => {
                let is_face = |l: &&str| l.trim_start().starts_with("f ");
                let count = text.lines().filter(is_face).count();
                let gone = count.div_ceil(LEFT_OUT);
                let (mut seen, mut out) = (0, String::with_capacity(text.len()));
                for line in text.split_inclusive('\n') {
                    let is_one = line.trim_start().starts_with("f ");
                    seen += usize::from(is_one);
                    if !is_one || seen + gone <= count {
                        out.push_str(line);
                    }
                }
                Ok((out.into_bytes(), format!("{gone} of its {count} faces left out")))
            }
        }
    })
}
