//! The folder a person gets: whole files of one run, or none.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use adapters::Critique;

use crate::dag::store::{sync_folder, write_synced};
use crate::dag::{Artefact as _, Outcome, Stage as _, StageError};
use crate::stages::bundle::Files;
use crate::stages::{Checked, Criticise, Export, UrdfPackage, Views};

/// Everything a run may put into its folder, the trace last.
const OURS: [&str; 10] = [
    "asset.urdf",
    "asset.json",
    "meshes",
    "asset.xml",
    "asset.usda",
    "asset.glb",
    "views",
    "verdict.json",
    "critic.json",
    TRACE,
];
/// The trace.
const TRACE: &str = "trace.mcap";
/// Suffix of what is not finished.
const PARTIAL: &str = ".partial";

/// The files of a finished run, by path in the output folder.
///
/// # Errors
/// [`StageError`] when a stage's result is missing or cannot be read.
pub fn files(outcome: &Outcome, exports: &[Export]) -> Result<Files, StageError> {
    let mut files: Files = outcome.artefact::<UrdfPackage>("write-urdf")?.0;
    for (stage, file) in exports.iter().filter_map(|e| e.stage_and_file()) {
        files.insert(file.into(), outcome.bytes(stage)?.to_vec());
    }
    let views = outcome.artefact::<Views>("render-views")?;
    files.extend(views.0.into_iter().map(|(name, png)| (format!("views/{name}"), png)));
    let checked = outcome.artefact::<Checked>("check-in-sim")?;
    files.insert("verdict.json".into(), checked.verdict.to_json().into_bytes());
    // Only there where it was asked for.
    if let Ok(critique) = outcome.bytes(Criticise::NAME) {
        files.insert(Critique::FILE_NAME.into(), critique.to_vec());
    }
    Ok(files)
}

/// The folder of a run.
///
/// What lies in it belongs to the run whose trace lies in it: a run that fails takes the files of
/// an earlier one away and leaves its trace alone. It never touches a folder that holds such
/// names without a trace, because somebody else put them there.
#[derive(Debug)]
pub struct OutFolder {
    root: PathBuf,
}

/// Why a folder cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum OutError {
    /// It holds files of our names that no run of ours made.
    #[error("{} holds `{found}` but no trace.mcap, so no earlier run put it there", root.display())]
    NotOurs {
        /// The folder.
        root: PathBuf,
        /// What was found.
        found: &'static str,
    },
    /// The disk.
    #[error("{}: cannot {doing}: {source}", path.display())]
    Io {
        /// What was tried.
        doing: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
}

impl OutFolder {
    /// Makes the folder ready: creates it, and removes what a killed run left unfinished.
    ///
    /// # Errors
    /// [`OutError`] when it is somebody else's or the disk refuses.
    pub fn prepare(root: &Path) -> Result<Self, OutError> {
        let this = Self { root: root.to_path_buf() };
        let traced = this.path(TRACE).exists() || this.trace_in_progress().exists();
        let stranger = OURS.into_iter().find(|name| this.path(name).exists());
        if let (false, Some(found)) = (traced, stranger) {
            return Err(OutError::NotOurs { root: this.root, found });
        }
        fs::create_dir_all(root).map_err(io_failed("create the folder", root))?;
        for name in OURS.into_iter().filter(|&name| name != TRACE) {
            remove(&this.partial(name))?;
        }
        Ok(this)
    }

    /// Where a file of the folder stands.
    pub fn path(&self, name: &str) -> PathBuf {
        self.root.join(name)
    }

    /// Where the trace is written while the run goes on.
    pub fn trace_in_progress(&self) -> PathBuf {
        self.partial(TRACE)
    }

    fn partial(&self, name: &str) -> PathBuf {
        self.root.join(format!("{name}{PARTIAL}"))
    }

    /// Puts the files of a finished run into the folder: all are written and synced beside their
    /// place first, then renamed into it, the trace last.
    ///
    /// # Errors
    /// [`OutError`] when the disk refuses; nothing unfinished is left then.
    pub fn publish(&self, files: &Files) -> Result<(), OutError> {
        let written = self.write_beside(files);
        if written.is_err() {
            self.remove_unfinished();
        }
        written?;
        for name in OURS {
            let (from, to) = (self.partial(name), self.path(name));
            if to.is_dir() || !from.exists() {
                remove(&to)?;
            }
            if from.exists() {
                fs::rename(&from, &to).map_err(io_failed("move into place", &to))?;
            }
        }
        sync_folder(&self.root).map_err(io_failed("sync", &self.root))
    }

    fn write_beside(&self, files: &Files) -> Result<(), OutError> {
        for (name, bytes) in files {
            let path = match name.split_once('/') {
                Some((folder, rest)) => self.partial(folder).join(rest),
                None => self.partial(name),
            };
            let folder = path.parent().unwrap_or(&self.root);
            fs::create_dir_all(folder).map_err(io_failed("create the folder", folder))?;
            write_synced(&path, bytes).map_err(io_failed("write", &path))?;
        }
        Ok(())
    }

    fn remove_unfinished(&self) {
        for name in OURS.into_iter().filter(|&name| name != TRACE) {
            // The disk refused already; what it refuses to remove, the next run removes.
            let _ = remove(&self.partial(name));
        }
    }

    /// Leaves nothing but the trace of a run that failed.
    ///
    /// # Errors
    /// [`OutError`] when the disk refuses.
    pub fn leave_only_trace(&self) -> Result<(), OutError> {
        self.publish(&Files::new())
    }
}

fn remove(path: &Path) -> Result<(), OutError> {
    let removed = if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
    match removed {
        Err(e) if e.kind() != io::ErrorKind::NotFound => Err(io_failed("remove", path)(e)),
        _ => Ok(()),
    }
}

fn io_failed(doing: &'static str, path: &Path) -> impl FnOnce(io::Error) -> OutError {
    let path = path.to_path_buf();
    move |source| OutError::Io { doing, path, source }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(root: &Path) -> Vec<String> {
        let name = |e: io::Result<fs::DirEntry>| e.unwrap().file_name().into_string().unwrap();
        let mut names: Vec<_> = fs::read_dir(root).unwrap().map(name).collect();
        names.sort();
        names
    }

    fn run(root: &Path, files: &[(&str, &str)]) -> OutFolder {
        let folder = OutFolder::prepare(root).unwrap();
        fs::write(folder.trace_in_progress(), "trace").unwrap();
        let files = files.iter().map(|(n, b)| ((*n).into(), b.as_bytes().to_vec())).collect();
        folder.publish(&files).unwrap();
        folder
    }

    #[test]
    fn a_finished_run_leaves_its_files_and_those_of_the_earlier_run_are_gone() {
        let dir = tempfile::tempdir().unwrap();
        let root = dir.path().join("out");
        run(&root, &[("asset.urdf", "1"), ("meshes/a.obj", "a"), ("verdict.json", "v")]);
        assert_eq!(names(&root), ["asset.urdf", "meshes", "trace.mcap", "verdict.json"]);
        run(&root, &[("asset.urdf", "2"), ("meshes/b.obj", "b")]);
        assert_eq!(names(&root), ["asset.urdf", "meshes", "trace.mcap"]);
        assert_eq!(names(&root.join("meshes")), ["b.obj"]);
        assert_eq!(fs::read(root.join("asset.urdf")).unwrap(), b"2");
    }

    #[test]
    fn a_failed_run_leaves_its_trace_alone() {
        let dir = tempfile::tempdir().unwrap();
        run(dir.path(), &[("asset.urdf", "1"), ("meshes/a.obj", "a")]);
        let folder = OutFolder::prepare(dir.path()).unwrap();
        fs::write(folder.trace_in_progress(), "failed").unwrap();
        folder.leave_only_trace().unwrap();
        assert_eq!(names(dir.path()), ["trace.mcap"]);
        assert_eq!(fs::read(folder.path("trace.mcap")).unwrap(), b"failed");
    }

    #[test]
    fn somebody_elses_files_are_not_touched() {
        let dir = tempfile::tempdir().unwrap();
        fs::create_dir(dir.path().join("meshes")).unwrap();
        fs::write(dir.path().join("meshes/mine.obj"), "mine").unwrap();
        let error = OutFolder::prepare(dir.path()).unwrap_err();
        assert!(error.to_string().contains("holds `meshes` but no trace.mcap"), "{error}");
        assert!(dir.path().join("meshes/mine.obj").exists());
    }

    #[test]
    fn unfinished_files_of_a_killed_run_are_removed_and_other_files_stay() {
        let dir = tempfile::tempdir().unwrap();
        for name in ["trace.mcap.partial", "asset.urdf.partial", "notes.txt"] {
            fs::write(dir.path().join(name), "x").unwrap();
        }
        OutFolder::prepare(dir.path()).unwrap();
        assert_eq!(names(dir.path()), ["notes.txt", "trace.mcap.partial"]);
    }
}
