//! What a path leads to: a file, the one model of a folder, or the asset of a trace.

use std::path::{Component, Path, PathBuf};

use guard::folder::{Caps, Folder, Kind};
use runner::ours::scratch;
use serde_json::Value;
use tempfile::TempDir;
use trace::{Digest, Happening, Reading};

use crate::cli::commands::sealed::sealed;
use crate::cli::speech::Complaint;
use crate::stages::bundle::{self, Files};

/// The asset of a folder of ours.
const URDF: &str = "asset.urdf";
/// What says where an asset's numbers come from.
const SIDECAR: &str = "asset.json";
/// Most bytes of that.
const MOST: u64 = 16 << 20;
/// Names that are listed where there are several.
const NAMED: usize = 5;

/// A file to look at.
pub(super) struct Model {
    /// The file.
    pub file: PathBuf,
    /// What to call it where it has no name of its own.
    pub name: String,
    /// What to say about where it comes from.
    pub notes: Vec<String>,
    /// A folder that is gone with this.
    _unpacked: Option<TempDir>,
}

impl Model {
    fn of(file: PathBuf, notes: Vec<String>) -> Self {
        let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Self { file, name, notes, _unpacked: None }
    }

    /// The `asset.json` beside it, if there is one.
    pub(super) fn sidecar(&self) -> Option<Value> {
        let caps = Caps { file: MOST, all: MOST, ..Caps::default() };
        let folder = Folder::open(self.file.parent()?, caps).ok()?;
        serde_json::from_slice(&folder.read(Path::new(SIDECAR)).ok()?).ok()
    }
}

/// What a path leads to.
///
/// # Errors
/// [`Complaint`] when it leads to no model, or to several.
pub(super) fn found(path: &Path) -> Result<Model, Complaint> {
    if path.is_dir() {
        return of_folder(path);
    }
    let is_trace = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("mcap"));
    if is_trace { of_trace(path) } else { Ok(Model::of(path.to_path_buf(), vec![])) }
}

fn of_folder(folder: &Path) -> Result<Model, Complaint> {
    let asset = folder.join(URDF);
    if asset.is_file() {
        return Ok(Model::of(asset, vec![]));
    }
    let failed = |e| Complaint::failed(format!("{} {e}", folder.display()));
    let opened = Folder::open(folder, Caps::default()).map_err(failed)?;
    let all = opened.walk(Path::new(".")).map_err(failed)?;
    let is_urdf = |p: &Path| p.extension().is_some_and(|e| e.eq_ignore_ascii_case("urdf"));
    let mut urdfs: Vec<PathBuf> = all
        .into_iter()
        .filter(|e| e.kind == Kind::File && is_urdf(&e.path))
        .map(|e| folder.join(e.path))
        .collect();
    urdfs.sort();
    match &urdfs[..] {
        [one] => Ok(Model::of(one.clone(), vec![])),
        [] => Err(Complaint::failed(format!("{}: no URDF in it", folder.display()))
            .hint("name a file: a URDF, an MJCF model or a trace")),
        several => {
            let names: Vec<_> =
                several.iter().take(NAMED).map(|p| p.display().to_string()).collect();
            let message = format!("{}: {} URDFs in it", folder.display(), several.len());
            Err(Complaint::failed(message).hint(format!("name one of them: {}", names.join(", "))))
        }
    }
}

/// The asset that a trace holds, unpacked into a folder that goes with it; or the one beside it, where
/// the trace only names it.
fn of_trace(path: &Path) -> Result<Model, Complaint> {
    let named =
        |c: Complaint| Complaint { message: format!("{}: {}", path.display(), c.message), ..c };
    let reading = sealed(path).map_err(named)?;
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    if let Some(bytes) = package(&reading) {
        let files = bundle::unpack(bytes).map_err(|e| named(Complaint::failed(e)))?;
        let folder = unpacked(&files).map_err(named)?;
        let file = folder.path().join(URDF);
        return Ok(Model { file, name, notes: vec![], _unpacked: Some(folder) });
    }
    let beside = path.with_file_name(URDF);
    let digest = reading.events.iter().flat_map(|(_, e)| &e.outputs).find(|o| o.name == URDF);
    let bytes = guard::files::read(&beside, sim_check::read::load::MAX_URDF_BYTES).ok();
    match (digest, bytes) {
        (Some(o), Some(bytes)) if Digest::of(&bytes) == o.digest => {
            let note = "The trace names this asset by its digest; shown is the one beside it.";
            Ok(Model::of(beside, vec![note.into()]))
        }
        (Some(_), _) => Err(named(Complaint::failed(
            "its asset is too large to stand in the trace",
        ))
        .hint("`kinfold trace replay FILE --out DIR` makes it again; then `kinfold view DIR`")),
        (None, _) => Err(named(Complaint::failed("the run came to no asset"))
            .hint("`kinfold trace show` says how far it went")),
    }
}

/// The URDF package in a trace.
fn package(reading: &Reading) -> Option<&[u8]> {
    let mut finished = reading.events.iter().map(|(_, e)| e);
    let event = finished.rfind(|e| e.stage == "write-urdf" && e.event == Happening::Finished)?;
    let digest = &event.outputs.first()?.digest;
    let kept = reading.attachments.iter().find(|a| Digest::of(&a.bytes) == *digest)?;
    Some(&kept.bytes)
}

/// Writes files into a new folder, and none elsewhere.
fn unpacked(files: &Files) -> Result<TempDir, Complaint> {
    let folder = scratch::folder();
    let folder = folder.map_err(|e| Complaint::failed(format!("no folder to work in: {e}")))?;
    for (name, bytes) in files {
        let inside = Path::new(name).components().all(|c| matches!(c, Component::Normal(_)));
        if !inside || name.contains('\\') {
            return Err(Complaint::failed(format!(
                "its file `{name}` leads out of the asset's folder"
            )));
        }
        let path = folder.path().join(name);
        let parent = path.parent().unwrap_or(folder.path());
        let written = std::fs::create_dir_all(parent).and_then(|()| std::fs::write(&path, bytes));
        written.map_err(|e| Complaint::failed(format!("{name}: {e}")))?;
    }
    Ok(folder)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on stops")]
mod tests {
    use super::*;

    #[test]
    fn what_leads_out_of_the_folder_is_not_written() {
        for name in ["../a", "/tmp/a", "a/../../b", "a\\..\\..\\b"] {
            let files = Files::from([(name.to_owned(), vec![])]);
            assert!(unpacked(&files).err().unwrap().message.contains("leads out"), "{name}");
        }
    }

    #[test]
    fn a_folder_with_several_models_is_asked_about() {
        let folder = tempfile::tempdir().unwrap();
        assert!(found(folder.path()).err().unwrap().message.ends_with("no URDF in it"));
        std::fs::create_dir(folder.path().join("b")).unwrap();
        std::fs::write(folder.path().join("b/one.urdf"), "").unwrap();
        assert!(found(folder.path()).unwrap().file.ends_with("b/one.urdf"));
        std::fs::write(folder.path().join("two.urdf"), "").unwrap();
        assert!(found(folder.path()).err().unwrap().message.ends_with("2 URDFs in it"));
        std::fs::write(folder.path().join(URDF), "").unwrap();
        assert!(found(folder.path()).unwrap().file.ends_with(URDF));
    }
}
