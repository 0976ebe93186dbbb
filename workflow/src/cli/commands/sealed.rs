//! Traces that are believed: every bit as it was sealed, everything in them belonging together.

use std::path::{Path, PathBuf};

use trace::{Reading, verify};

use crate::cli::speech::Complaint;

/// The trace that is meant: of a folder that has one, the one in it.
pub(in crate::cli) fn meant(path: &Path) -> PathBuf {
    let inside = path.join("trace.mcap");
    if path.is_dir() && inside.symlink_metadata().is_ok() { inside } else { path.to_path_buf() }
}

/// A trace of which every bit is as it was sealed, and in which everything belongs together.
pub(super) fn sealed(file: &Path) -> Result<Reading, Complaint> {
    sealed_bytes(file).map(|(_, reading)| reading)
}

/// The same with the bytes of the file.
pub(super) fn sealed_bytes(file: &Path) -> Result<(Vec<u8>, Reading), Complaint> {
    let bytes = read(file)?;
    let reading = sealed_in(&bytes)?;
    Ok((bytes, reading))
}

/// The bytes of a file that may be a trace.
pub(super) fn read(file: &Path) -> Result<Vec<u8>, Complaint> {
    let bytes = guard::files::read(file, trace::reader::MAX_BYTES);
    bytes.map_err(|refused| Complaint::failed(refused.to_string()))
}

/// The trace in some bytes.
pub(super) fn sealed_in(bytes: &[u8]) -> Result<Reading, Complaint> {
    trace::seal::check(bytes).map_err(Complaint::failed)?;
    let reading = trace::read_bytes(bytes, "the file").map_err(|e| Complaint::from_error(&e))?;
    verify::holds_together(&reading).map_err(Complaint::failed)?;
    Ok(reading)
}
