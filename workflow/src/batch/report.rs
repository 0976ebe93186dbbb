//! One page about a batch, in one file: yield, failures, cost, times, and what the assets look like.
//! Every figure comes from `index.parquet`, the pictures from the assets' own folders.

mod charts;
mod figures;
mod gallery;
mod html;
mod markup;

use std::path::{Path, PathBuf};

use runner::ours::write_synced;

use super::folder::io_failed;
use super::index::{self, IndexError};

pub use figures::Figures;

/// Name of the page in its folder.
pub const FILE: &str = "report.html";

/// Writes index and page of a batch's folder; returns the page's path and what it says.
///
/// # Errors
/// [`IndexError`] when a ledger cannot be read or the disk refuses.
pub fn write(root: &Path) -> Result<(PathBuf, Figures), IndexError> {
    let (index, _) = index::write(root)?;
    let figures = figures::of(&index)?;
    let pictures = gallery::pictures(root, &figures);
    let name = root.file_name().unwrap_or(root.as_os_str()).to_string_lossy();
    let page = html::page(&name, &figures, &pictures);
    let path = root.join(FILE);
    write_synced(&path, page.as_bytes()).map_err(io_failed("write", &path))?;
    Ok((path, figures))
}
