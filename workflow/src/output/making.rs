//! A folder in the making: it stands beside the place that it is meant for, until it is whole.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use runner::ours::marker::Saved;
use runner::ours::swap::{self, Heir, Names};
use runner::ours::{Kind, Marker};
use runner::ours::{sync_folder, write_synced};

use super::error::{OutError, io_failed};
use super::names::{ENVELOPE, SIGNATURE, STATEMENT, TRACE};
use super::standing;
use crate::stages::bundle::Files;

/// Signatures, and the file beside them that each is of.
const SIGNATURES: [(&str, &str); 2] = [(SIGNATURE, TRACE), (ENVELOPE, STATEMENT)];
/// Most bytes of a file that was signed: a trace's.
const MOST: u64 = trace::reader::MAX_BYTES;

/// A folder in which a run's files come together. Its marker lists each of them before it is
/// written, so that whoever tidies up knows ours from others'.
#[derive(Debug)]
pub struct Making {
    root: PathBuf,
}

impl Making {
    /// Creates the folder, with a marker and nothing else in it.
    ///
    /// # Errors
    /// [`OutError`] when something stands there, or the disk refuses.
    pub fn begin(root: &Path) -> Result<Self, OutError> {
        fs::create_dir(root).map_err(io_failed("create the folder", root))?;
        let this = Self { root: root.to_path_buf() };
        this.mark(Kind::Unfinished, [TRACE.to_owned()], Saved::Later)?;
        Ok(this)
    }

    /// Where it stands.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// Where a file of it stands.
    pub fn path(&self, name: &str) -> PathBuf {
        self.root.join(name)
    }

    /// Where the trace is written while the run goes on.
    pub fn trace(&self) -> PathBuf {
        self.path(TRACE)
    }

    /// Writes the files of a finished run beside the trace; then every one of them is on the disk, and
    /// the folder is that of an asset.
    ///
    /// # Errors
    /// [`OutError`] when the disk refuses; the trace is left alone then.
    pub fn fill(&self, files: &Files) -> Result<(), OutError> {
        let filled = self.filled(files);
        if filled.is_err() {
            self.leave_only_trace();
        }
        filled
    }

    fn filled(&self, files: &Files) -> Result<(), OutError> {
        let mut names: BTreeSet<String> = files.keys().cloned().collect();
        if self.trace().exists() {
            names.insert(TRACE.into());
        }
        self.mark(Kind::Unfinished, names.clone(), Saved::Later)?;
        let mut folders = BTreeSet::from([self.root.clone()]);
        for (name, bytes) in files {
            let path = self.root.join(name);
            let folder = path.parent().unwrap_or(&self.root);
            if folders.insert(folder.to_path_buf()) {
                fs::create_dir_all(folder).map_err(io_failed("create the folder", folder))?;
            }
            write_synced(&path, bytes).map_err(io_failed("write", &path))?;
        }
        self.mark(Kind::Asset, names, Saved::Now)?;
        folders.iter().try_for_each(|f| sync_folder(f).map_err(io_failed("sync", f)))
    }

    /// Takes everything away but the trace, as far as the disk lets us.
    pub fn leave_only_trace(&self) {
        let Some(marker) = Marker::read(&self.root) else { return };
        for name in marker.files.iter().filter(|name| *name != TRACE) {
            let path = self.root.join(name);
            // What the disk refuses to remove, the next run removes.
            let _ = fs::remove_file(&path);
            if let Some(folder) = path.parent().filter(|folder| *folder != self.root) {
                let _ = fs::remove_dir(folder);
            }
        }
        let _ = self.mark(Kind::Unfinished, [TRACE.to_owned()], Saved::Later);
    }

    fn mark(
        &self,
        kind: Kind,
        files: impl IntoIterator<Item = String>,
        saved: Saved,
    ) -> Result<(), OutError> {
        let marker = Marker::of(kind).with(files);
        marker.write(&self.root, saved).map_err(io_failed("mark", &self.root))
    }

    /// The same elsewhere on its disk.
    ///
    /// # Errors
    /// [`OutError`] when the disk refuses.
    pub fn moved(self, to: &Path) -> Result<Self, OutError> {
        fs::rename(&self.root, to).map_err(io_failed("move into place", to))?;
        Ok(Self { root: to.to_path_buf() })
    }

    /// Puts the folder in its place by one step; at any moment the old folder stands there whole, or
    /// the new one does. Files in the old one that are not among ours stand in the new one, too, and
    /// so do signatures of what is the same in both; those of anything else are returned, and go.
    ///
    /// `before` is where the old one is put in between, where the system cannot exchange them.
    ///
    /// # Errors
    /// [`OutError`] when a file of somebody else's cannot be carried over, or the disk refuses; the
    /// old folder stands in its place as it was then.
    pub fn publish(
        &self,
        place: &Path,
        before: &Path,
        was: &Names,
    ) -> Result<Vec<&'static str>, OutError> {
        let stood = fs::symlink_metadata(place).ok();
        let mut gone = Vec::new();
        if stood.is_some() {
            swap::carry(place, &self.root, was)?;
            gone = self.keep_signatures(place, was)?;
        }
        let is = standing::ours(&self.root);
        let put = swap::put(&self.root, place, before);
        let Some(old) = put.map_err(io_failed("move into place", place))? else { return Ok(gone) };
        // The asset is published: what is left of the old one is swept by the next run, and whoever
        // may look at it is no reason to fail.
        let stood = stood.filter(fs::Metadata::is_dir);
        let _ = stood.map(|about| fs::set_permissions(place, about.permissions()));
        let _ = swap::clear(&old, was, Some(Heir { place, ours: &is }));
        Ok(gone)
    }

    /// Takes over from the old folder the signatures of files that are the same here; returns those of
    /// files that are not.
    fn keep_signatures(&self, place: &Path, was: &Names) -> Result<Vec<&'static str>, OutError> {
        let mut gone = Vec::new();
        for (signature, signed) in SIGNATURES {
            let stands = fs::symlink_metadata(place.join(signature)).is_ok_and(|f| f.is_file());
            if !stands || !was.has(Path::new(signature)) {
                continue;
            }
            let read = |root: &Path| guard::files::read(&root.join(signed), MOST).ok();
            let (old, new) = (read(place), read(&self.root));
            let own = guard::files::read(&place.join(signature), MOST).ok();
            let Some(own) = own.filter(|_| new.is_some() && old == new) else {
                gone.push(signature);
                continue;
            };
            let path = self.root.join(signature);
            if let Some(mut marker) = Marker::read(&self.root) {
                marker.files.insert(signature.into());
                marker.write(&self.root, Saved::Now).map_err(io_failed("mark", &self.root))?;
            }
            write_synced(&path, &own).map_err(io_failed("write", &path))?;
        }
        Ok(gone)
    }
}

/// Removes a folder of ours that was left behind; files of others in it go to the heir, or stay.
///
/// # Errors
/// [`OutError`] when the disk refuses.
pub fn clear(folder: &Path, ours: &Names, heir: Option<&Path>) -> Result<(), OutError> {
    // A link of that name is none of ours, and what it leads to even less.
    if !fs::symlink_metadata(folder).is_ok_and(|about| about.is_dir()) {
        return Ok(());
    }
    let heir = heir.filter(|place| fs::symlink_metadata(place).is_ok_and(|about| about.is_dir()));
    let names = heir.map(standing::ours);
    let heir = heir.zip(names.as_ref()).map(|(place, ours)| Heir { place, ours });
    swap::clear(folder, ours, heir).map(drop).map_err(io_failed("remove", folder))
}
