//! The meshes that stand beside a model file, each looked at once.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use guard::files::{self, Refused};
use guard::folder::{Caps, Folder};

use crate::read::error::Reason;
use crate::read::mesh::{Here, Mesh, Uri};
use crate::read::{obj, stl};

/// Whether files outside the model's folder are looked at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Outside {
    /// They are not, and no rule says anything about them.
    #[default]
    Refused,
    /// They are.
    Allowed,
}

/// Most bytes of a mesh that are read; a guess with room.
const MAX_MESH: u64 = 256 << 20;
/// Most bytes of all meshes together; a guess.
const MAX_ALL: u64 = 1 << 30;
/// Most meshes of a file that are looked at; a guess with room.
const MAX_MESHES: usize = 4096;

/// What was seen of a folder's meshes.
#[derive(Debug)]
pub(crate) struct Shelf {
    folder: Folder,
    at: PathBuf,
    outside: Outside,
    seen: BTreeMap<String, Mesh>,
}

impl Shelf {
    /// The meshes beside a file.
    ///
    /// # Errors
    /// [`Reason::File`] when its folder cannot be opened.
    pub(crate) fn beside(path: &Path, outside: Outside) -> Result<Self, Reason> {
        let parent = path.parent().filter(|p| !p.as_os_str().is_empty());
        let at = parent.unwrap_or(Path::new(".")).to_path_buf();
        let caps = Caps { file: MAX_MESH, all: MAX_ALL, ..Caps::default() };
        let folder = Folder::open(&at, caps)?;
        Ok(Self { folder, at, outside, seen: BTreeMap::new() })
    }

    /// What is known of the mesh of that name.
    pub(crate) fn mesh(&mut self, filename: &str) -> Mesh {
        if let Some(mesh) = self.seen.get(filename) {
            return mesh.clone();
        }
        let mut mesh = Mesh::named(filename).after(self.seen.len());
        if self.seen.len() < MAX_MESHES {
            self.look(&mut mesh);
            self.seen.insert(filename.to_string(), mesh.clone());
        }
        mesh
    }

    fn look(&self, mesh: &mut Mesh) {
        let read = match self.folder.read(&mesh.path) {
            Err(Refused::Outside) if self.outside == Outside::Allowed => {
                files::read(&self.at.join(&mesh.path), MAX_MESH)
            }
            other => other,
        };
        let bytes = match read {
            Ok(bytes) => bytes,
            // A package may stand anywhere above.
            Err(e) if e.is_absence() && !matches!(mesh.uri, Uri::Package(_)) => {
                mesh.here = Here::No;
                return;
            }
            Err(_) => return,
        };
        mesh.here = Here::Yes;
        match mesh.extension.as_str() {
            "obj" => obj::look(&bytes, mesh),
            "stl" => stl::look(&bytes, mesh),
            _ => {}
        }
    }
}
