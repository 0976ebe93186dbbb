//! The files that a model needs, and where they stand in a copy of it.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path};
use std::sync::Arc;

use sim_check::CheckOptions;
use sim_check::read::load;
use sim_check::read::source::{At, Edit, Source};

use super::language::Language;

/// Most bytes of all files of one model: every mutant has a copy of them. A guess.
const MOST: usize = 64 << 20;

/// A file that a model names.
#[derive(Clone, Debug)]
pub struct Needed {
    /// Where it stands in a copy, relative, with `/` between.
    pub to: String,
    /// What stands in it.
    pub bytes: Arc<[u8]>,
    /// The elements that name it, and by which attribute; none where no element does. The attribute of
    /// an SDF's element is empty: its text names the file.
    pub named: Vec<(At, &'static str)>,
    /// What it is called where it is named.
    pub told: String,
    /// What the model as it stands calls it, as it is read.
    pub read: String,
    /// Whether it is a mesh.
    pub is_mesh: bool,
}

/// Files of a model, and the text in which all of them have names that lead to their copies.
pub struct Complete {
    /// The files, their elements those of the new text.
    pub files: Vec<Needed>,
    /// The text.
    pub text: String,
    /// How many names had to be written anew.
    pub renamed: usize,
}

/// An element that names a file.
struct Naming {
    at: At,
    attribute: &'static str,
    told: String,
    /// As it is read: with the folder that the compiler of MJCF names.
    read: String,
    is_mesh: bool,
}

/// Finds all files of a model.
///
/// # Errors
/// Which of them cannot be had, and why.
pub fn complete(
    file: &Path,
    source: &Source,
    language: Language,
    options: &CheckOptions,
) -> Result<Complete, String> {
    let names = names(source, language)?;
    let escapes = names.iter().any(|n| !stays(&n.read));
    let mut files: BTreeMap<String, Needed> = BTreeMap::new();
    let mut by_read: BTreeMap<String, (String, String)> = BTreeMap::new();
    let mut taken = BTreeSet::new();
    let (mut edits, mut all) = (Vec::new(), 0);
    for naming in &names {
        let (to, told) = match by_read.get(&naming.read) {
            Some(known) => known.clone(),
            None => {
                let (path, bytes) = load::mesh_file(file, &naming.read, options)
                    .map_err(|why| format!("`{}`: {why}", naming.told))?;
                all += bytes.len();
                if all > MOST {
                    return Err(format!("its files have more than {} MiB", MOST >> 20));
                }
                // Of MJCF one folder holds all or none: its compiler has one word for it.
                let is_kept = stays(&naming.read) && !(language == Language::Mjcf && escapes);
                let to = match is_kept {
                    true => slashed(&naming.read),
                    false => free(&path, &mut taken),
                };
                let told = if is_kept { naming.told.clone() } else { to.clone() };
                taken.insert(to.clone());
                for (beside, bytes) in attached(&path, &bytes) {
                    let to = Path::new(&to).with_file_name(&beside);
                    let to = slashed(&to.to_string_lossy());
                    let needed = Needed {
                        to: to.clone(),
                        bytes,
                        named: vec![],
                        told: beside.clone(),
                        read: beside,
                        is_mesh: false,
                    };
                    files.entry(to).or_insert(needed);
                }
                let needed = Needed {
                    to: to.clone(),
                    bytes: bytes.into(),
                    named: vec![],
                    told: told.clone(),
                    read: naming.read.clone(),
                    is_mesh: naming.is_mesh,
                };
                files.insert(to.clone(), needed);
                by_read.insert(naming.read.clone(), (to.clone(), told.clone()));
                (to, told)
            }
        };
        if told != naming.told {
            edits.push(match naming.attribute {
                "" => {
                    source.replace(naming.at, format!("<uri>{}</uri>", guard::text::markup(&told)))
                }
                attribute => source.set(naming.at, attribute, &told),
            });
        }
        if let Some(needed) = files.get_mut(&to) {
            needed.named.push((naming.at, naming.attribute));
        }
    }
    if language == Language::Mjcf && escapes {
        edits.extend(folders(source));
    }
    let renamed = edits.len();
    let text = source.with(&edits).ok_or("its names of files stand in each other")?;
    Ok(Complete { files: files.into_values().collect(), text, renamed })
}

/// Whether a relative path stays in its folder, and is no address.
fn stays(name: &str) -> bool {
    let plain = |c: Component| matches!(c, Component::Normal(_) | Component::CurDir);
    !name.contains("://") && !name.contains("$(") && Path::new(name).components().all(plain)
}

fn slashed(name: &str) -> String {
    let parts = Path::new(name).components().filter_map(|c| match c {
        Component::Normal(part) => part.to_str(),
        _ => None,
    });
    parts.collect::<Vec<_>>().join("/")
}

/// A name in `files/` that no other file has.
fn free(path: &Path, taken: &mut BTreeSet<String>) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let mut number = 1;
    loop {
        let to = match number {
            1 => format!("files/{name}"),
            n => format!("files/{n}/{name}"),
        };
        if !taken.contains(&to) {
            return to;
        }
        number += 1;
    }
}

/// The material files that an OBJ names and that lie beside it.
fn attached(path: &Path, bytes: &[u8]) -> Vec<(String, Arc<[u8]>)> {
    let is_obj = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("obj"));
    let Some(folder) = path.parent().filter(|_| is_obj) else { return Vec::new() };
    let text = String::from_utf8_lossy(bytes);
    let named = text.lines().filter_map(|l| l.trim().strip_prefix("mtllib "));
    let plain = |n: &&str| !n.is_empty() && !n.contains(['/', '\\']) && *n != "..";
    let read = |name: &str| {
        // Colours are of no use to a checker: what cannot be had is left out.
        let bytes = guard::files::read(&folder.join(name), 1 << 20).ok()?;
        Some((name.to_owned(), Arc::from(bytes)))
    };
    named.map(str::trim).filter(plain).take(8).filter_map(read).collect()
}

/// Edits that take the folders out of an MJCF's compiler.
fn folders(source: &Source) -> Vec<Edit> {
    let compilers = source.children(source.root(), "compiler");
    let told = ["meshdir", "texturedir", "assetdir"];
    let all = compilers.iter().flat_map(|c| told.iter().map(move |t| (*c, *t)));
    all.filter_map(|(at, name)| source.unset(at, name)).collect()
}

/// Every element in one, itself included.
pub(super) fn every(source: &Source) -> Vec<At> {
    let mut all = vec![source.root()];
    let mut done = 0;
    while done < all.len() {
        all.extend(source.all_children(all[done]));
        done += 1;
    }
    all
}

/// What an MJCF's compiler takes for a folder of meshes or textures.
fn folder_of(source: &Source, own: &str) -> String {
    let compilers = source.children(source.root(), "compiler");
    let told = compilers
        .iter()
        .rev()
        .find_map(|c| source.get(*c, own).or_else(|| source.get(*c, "assetdir")));
    let told = told.unwrap_or_default().trim().trim_end_matches('/');
    if told.is_empty() { String::new() } else { format!("{told}/") }
}

/// The elements that name files.
fn names(source: &Source, language: Language) -> Result<Vec<Naming>, String> {
    let mut all = Vec::new();
    for at in every(source) {
        let tag = source.tag(at);
        let mut add = |attribute: &'static str, folder: &str, is_mesh: bool| {
            if let Some(told) = source.get(at, attribute).filter(|t| !t.trim().is_empty()) {
                let (told, read) = (told.to_owned(), format!("{folder}{}", told.trim()));
                all.push(Naming { at, attribute, told, read, is_mesh });
            }
        };
        match (language, tag) {
            (Language::Urdf, "mesh") => add("filename", "", true),
            (Language::Urdf, "texture") => add("filename", "", false),
            (Language::Mjcf, "mesh") => add("file", &folder_of(source, "meshdir"), true),
            (Language::Mjcf, "hfield" | "skin" | "flexcomp") => {
                add("file", &folder_of(source, "meshdir"), false);
            }
            (Language::Mjcf, "texture") => {
                let folder = folder_of(source, "texturedir");
                let sides = [
                    "file",
                    "fileright",
                    "fileleft",
                    "fileup",
                    "filedown",
                    "filefront",
                    "fileback",
                ];
                sides.into_iter().for_each(|side| add(side, &folder, false));
            }
            (Language::Mjcf, "include" | "attach" | "model") => {
                return Err(format!("<{tag}> of line {} brings in another file", source.line(at)));
            }
            (Language::Sdf, "uri") => {
                let parent = source.parent(at).map(|p| source.tag(p).to_owned());
                if parent.as_deref() == Some("include") {
                    return Err(format!("<include> of line {} brings in a model", source.line(at)));
                }
                let written = source.written(at);
                let told = written.split(['<', '>']).nth(2).unwrap_or_default().trim().to_owned();
                let is_mesh = parent.as_deref() == Some("mesh");
                all.push(Naming { at, attribute: "", read: told.clone(), told, is_mesh });
            }
            _ => {}
        }
    }
    Ok(all)
}
