//! One page about a batch, in one file: yield, failures, cost, times, and what the assets look like.
//! Every figure comes from `index.parquet`, bad lines from the ledgers, pictures from the assets' own
//! folders.

mod charts;
mod figures;
mod gallery;
mod html;
mod markup;
mod refusals;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use runner::ours::write_synced;

use super::folder::io_failed;
use super::index::{self, IndexError};
use super::run::TOLD;

pub use figures::Figures;

/// Name of the page in its folder.
pub const FILE: &str = "report.html";

/// Writes index and page of a batch's folder; returns the page's path and what it says.
///
/// # Errors
/// [`IndexError`] when a ledger cannot be read or the disk refuses.
pub fn write(root: &Path) -> Result<(PathBuf, Figures), IndexError> {
    let (index, _) = index::write(root)?;
    let mut figures = figures::of(&index)?;
    figures.bad_lines = bad_lines(root)?;
    let looks = gallery::looks(root, &figures);
    let name = root.file_name().unwrap_or(root.as_os_str()).to_string_lossy();
    let page = html::page(&name, &figures, &looks);
    let path = root.join(FILE);
    write_synced(&path, page.as_bytes()).map_err(io_failed("write", &path))?;
    Ok((path, figures))
}

/// The first lines of the manifest that are no items, and how many there are; of several shards, which
/// have the same, each once.
fn bad_lines(root: &Path) -> Result<(Vec<(u64, String)>, u64), IndexError> {
    let (mut lines, mut most) = (BTreeSet::new(), 0);
    for (_, ledger) in index::ledgers(root)? {
        let (own, all) = ledger.latest_bad_lines(TOLD)?;
        lines.extend(own);
        most = most.max(all);
    }
    let lines: Vec<_> = lines.into_iter().take(TOLD as usize).collect();
    let all = most.max(lines.len() as u64);
    Ok((lines, all))
}
