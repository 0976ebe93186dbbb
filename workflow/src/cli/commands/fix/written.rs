//! A model that was mended, on disk: new meshes first, then the file itself in one step.

use std::fs::{File, OpenOptions};
use std::io::Write as _;
use std::path::{Path, PathBuf};

use super::told::Made;
use crate::cli::speech::Complaint;

/// Writes what was made. Whatever fails, the file is as it was, and nothing new stands beside it.
///
/// # Errors
/// [`Complaint`] when the file was changed meanwhile, may not be written, or something stands where a
/// new mesh is to go.
pub(super) fn write(file: &Path, made: &Made) -> Result<(), Complaint> {
    let failed = |e: std::io::Error| Complaint::failed(format!("{}: {e}", file.display()));
    // A link stays a link: what it leads to is changed.
    let real = std::fs::canonicalize(file).map_err(failed)?;
    let about = std::fs::metadata(&real).map_err(failed)?;
    if about.permissions().readonly() {
        let message = format!("{} is read-only", file.display());
        return Err(
            Complaint::failed(message).hint("make it writable, or apply the diff elsewhere")
        );
    }
    let now = std::fs::read(&real).map_err(failed)?;
    if now != made.old.as_bytes() {
        let message = format!("{} was changed while it was looked at", file.display());
        return Err(Complaint::failed(message).hint("run it again"));
    }
    let mut fresh = Fresh(Vec::new());
    for mesh in &made.files {
        let bytes = mesh.bytes().ok_or_else(|| Complaint::failed("a new mesh is not whole"))?;
        fresh.write(&mesh.path, &bytes)?;
    }
    let folder = real.parent().unwrap_or(Path::new("."));
    let mut draft =
        tempfile::Builder::new().prefix(".kinfold-fix-").tempfile_in(folder).map_err(failed)?;
    draft.write_all(made.new.as_bytes()).map_err(failed)?;
    draft.as_file().set_permissions(about.permissions()).map_err(failed)?;
    draft.as_file().sync_all().map_err(failed)?;
    draft.persist(&real).map_err(|e| failed(e.error))?;
    fresh.keep();
    Ok(())
}

/// Files that go again unless they are kept.
struct Fresh(Vec<PathBuf>);

impl Fresh {
    /// Writes a file where nothing stands.
    fn write(&mut self, path: &Path, bytes: &[u8]) -> Result<(), Complaint> {
        let failed = |e: std::io::Error| Complaint::failed(format!("{}: {e}", path.display()));
        let mut file: File =
            OpenOptions::new().write(true).create_new(true).open(path).map_err(failed)?;
        self.0.push(path.to_path_buf());
        file.write_all(bytes).and_then(|()| file.sync_all()).map_err(failed)
    }

    fn keep(mut self) {
        self.0.clear();
    }
}

impl Drop for Fresh {
    fn drop(&mut self) {
        for path in &self.0 {
            // What cannot be taken away is no worse than what the error says already.
            let _ = std::fs::remove_file(path);
        }
    }
}
