//! The folder a person gets: whole files of one run, or none.
//!
//! A run works in a folder of its own, `NAME.failed/N` beside the output folder `NAME`, where its
//! trace stands from its first moment. When it is done, that folder takes the place of `NAME` by one
//! step; when it fails, or is killed, it stays where it is.

mod error;
mod making;
pub(crate) mod names;
mod shipped;
pub mod standing;
pub mod sureness;

use std::fs;
use std::path::{Path, PathBuf};

use adapters::Critique;
use runner::ours::lock::After;
use runner::ours::marker::{self, Saved, Whose};
use runner::ours::swap::Names;
use runner::ours::sync_folder;
use runner::ours::{Kind, Lock, Marker, Turns};
use runner::{Artefact as _, Outcome, Stage as _, StageError};
use trace::Digest;

use self::error::io_failed;
use self::names::{TRACE, VERDICT};
use crate::stages::bundle::{self, Files};
use crate::stages::{Checked, Criticise, Export, Pictures, UrdfPackage, Views, WritePictures};

pub use error::OutError;
pub use making::{Making, clear};
pub use shipped::shipped;
pub use standing::Standing;

/// Failed runs that are kept; a guess: enough to compare, too few to fill a disk.
const KEPT: usize = 5;
/// A finished folder on its way, and the old one behind it.
const NEXT: &str = "next";
/// The old folder on its way, where the system cannot exchange two folders.
const BEFORE: &str = "before";

/// The files of a finished run, by path in the output folder.
///
/// # Errors
/// [`StageError`] when a stage's result is missing or cannot be read.
pub fn files(outcome: &Outcome, exports: &[Export]) -> Result<Files, StageError> {
    let mut files: Files = outcome.artefact::<_, UrdfPackage>("write-urdf")?.0;
    for (stage, file) in exports.iter().filter_map(|e| e.stage_and_file()) {
        files.insert(file.into(), outcome.bytes(stage)?.to_vec());
    }
    for package in exports.iter().filter_map(|e| e.package()) {
        let inside = bundle::unpack(outcome.bytes(package.stage)?);
        let inside = inside.map_err(|why| StageError::new(format!("{}: {why}", package.bundle)))?;
        files.extend(inside.into_iter().map(|(path, b)| (format!("{}{path}", package.folder), b)));
    }
    if exports.contains(&Export::Pictures) {
        files.extend(outcome.artefact::<_, Pictures>(WritePictures::NAME)?.0);
    }
    let views = outcome.artefact::<_, Views>("render-views")?;
    files.extend(views.0.into_iter().map(|(name, png)| (format!("views/{name}"), png)));
    let checked = outcome.artefact::<_, Checked>("check-in-sim")?;
    files.insert(VERDICT.into(), checked.verdict.to_json().into_bytes());
    // Only there where it was asked for.
    if let Ok(critique) = outcome.bytes(Criticise::NAME) {
        files.insert(Critique::FILE_NAME.into(), critique.to_vec());
    }
    Ok(files)
}

/// The output folder of a run.
///
/// Open it holds a lock beside the folder, which the operating system frees when the process ends,
/// however it ends. What stands in the folder changes by one step, in [`Attempt::publish`], and at no
/// other moment.
#[derive(Debug)]
pub struct OutFolder {
    /// Where it stands, with no link on the way.
    place: PathBuf,
    /// As the person named it.
    shown: PathBuf,
    /// Where runs are that are under way or failed.
    shelf: PathBuf,
    shown_shelf: PathBuf,
    _lock: Lock,
}

/// A run's own folder.
#[derive(Debug)]
pub struct Attempt<'a> {
    out: &'a OutFolder,
    making: Making,
    number: u64,
}

impl OutFolder {
    /// Refuses a folder that cannot be used. Changes nothing.
    ///
    /// # Errors
    /// [`OutError`] when it is somebody else's, or no folder can take its place.
    pub fn look(root: &Path) -> Result<(), OutError> {
        let place = resolved(root)?;
        standing::check(&place, root)?;
        check_shelf(&beside(&place, ".failed")?)
    }

    /// Makes the folder ready, alone: nothing in it changes. What a killed run left is set right.
    ///
    /// # Errors
    /// [`OutError`] when it is somebody else's, somebody is at work in it, or the disk refuses.
    pub fn open(root: &Path, turns: Turns) -> Result<Self, OutError> {
        Self::look(root)?;
        if let Some(parent) = root.parent().filter(|p| !p.as_os_str().is_empty()) {
            fs::create_dir_all(parent).map_err(io_failed("create the folder", parent))?;
        }
        let place = resolved(root)?;
        let lock = Lock::take(&hidden(&place)?, After::Goes, turns, &runner::ours::name(root));
        let lock = lock.map_err(|source| OutError::Lock { root: root.to_path_buf(), source })?;
        let shelf = beside(&place, ".failed")?;
        let is_link = fs::symlink_metadata(root).is_ok_and(|about| about.is_symlink());
        let shown_shelf = if is_link { shelf.clone() } else { beside(root, ".failed")? };
        let shown = root.to_path_buf();
        let this = Self { place, shown, shelf, shown_shelf, _lock: lock };
        // It may be another one by now.
        standing::check(&this.place, root)?;
        check_shelf(&this.shelf)?;
        this.set_right()?;
        Ok(this)
    }

    /// Ends what a killed run had begun: an old folder that was moved aside goes back where nothing
    /// took its place.
    fn set_right(&self) -> Result<(), OutError> {
        let (next, before) = (self.shelf.join(NEXT), self.shelf.join(BEFORE));
        let is_there = |path: &Path| fs::symlink_metadata(path).is_ok();
        if is_there(&before) && !is_there(&self.place) {
            let back = fs::rename(&before, &self.place);
            back.map_err(io_failed("move back into place", &self.place))?;
        }
        for left in [&before, &next] {
            clear(left, &standing::ours(left), Some(self.place.as_path()))?;
        }
        self.tidy();
        Ok(())
    }

    /// The folder as the person named it.
    pub fn shown(&self) -> &Path {
        &self.shown
    }

    /// How good what stands there is.
    pub fn standing(&self) -> Standing {
        standing::of(&self.place)
    }

    /// The photo of the asset that stands there, as its trace has it; `None` where there is none, or
    /// nobody can say.
    pub fn photo(&self) -> Option<Digest> {
        standing::photo(&self.place)
    }

    /// A folder of its own for a run; of those that failed the oldest make room for it.
    ///
    /// # Errors
    /// [`OutError`] when the disk refuses.
    pub fn begin(&self) -> Result<Attempt<'_>, OutError> {
        fs::create_dir_all(&self.shelf).map_err(io_failed("create the folder", &self.shelf))?;
        let marker = Marker::of(Kind::Failed);
        marker.write(&self.shelf, Saved::Later).map_err(io_failed("mark", &self.shelf))?;
        let numbers = self.numbers();
        for old in numbers.iter().rev().skip(KEPT - 1) {
            let old = self.shelf.join(old.to_string());
            clear(&old, &standing::ours(&old), None)?;
        }
        let number = match numbers.last() {
            None => 1,
            Some(last) if *last < u64::from(u32::MAX) => last + 1,
            // Nothing is larger: one of the many below it is free.
            Some(_) => (1..).find(|n| numbers.binary_search(n).is_err()).unwrap_or(1),
        };
        let making = Making::begin(&self.shelf.join(number.to_string()))?;
        Ok(Attempt { out: self, making, number })
    }

    /// The numbers of runs that failed, smallest first.
    fn numbers(&self) -> Vec<u64> {
        let entries = fs::read_dir(&self.shelf).into_iter().flatten().flatten();
        let number =
            |e: fs::DirEntry| Some(u64::from(e.file_name().to_str()?.parse::<u32>().ok()?));
        let mut numbers: Vec<_> = entries.filter_map(number).collect();
        numbers.sort_unstable();
        numbers
    }

    /// Takes the shelf away where nothing lies on it but its marker.
    fn tidy(&self) {
        let mut names = fs::read_dir(&self.shelf).into_iter().flatten().flatten();
        if names.all(|e| e.file_name().to_str().is_some_and(marker::is_marker)) {
            // Whatever the disk refuses to remove does no harm.
            let _ = clear(&self.shelf, &Names::default(), None);
        }
    }
}

impl Attempt<'_> {
    /// Where the trace is written while the run goes on.
    pub fn trace(&self) -> PathBuf {
        self.making.trace()
    }

    /// Writes the files beside the trace and puts them where the asset stands, by one step. Returns the
    /// signatures that stood there, were of something else, and went.
    ///
    /// # Errors
    /// [`OutError`] when something stands in the way or the disk refuses: what stood there stands
    /// there as it was, and the trace where it was.
    pub fn publish(self, files: &Files) -> Result<Vec<&'static str>, OutError> {
        let Self { out, making, .. } = self;
        making.fill(files)?;
        let (from, next) = (making.root().to_path_buf(), out.shelf.join(NEXT));
        let making = making.moved(&next)?;
        // Whoever put files of his own there meanwhile keeps them.
        let published = standing::check(&out.place, &out.shown).and_then(|()| {
            let was = standing::ours(&out.place);
            making.publish(&out.place, &out.shelf.join(BEFORE), &was)
        });
        if published.is_err() {
            // What was made is kept with the failed runs.
            let _ = fs::rename(&next, &from);
        }
        let gone = published?;
        let parent = out.place.parent().unwrap_or(Path::new("."));
        sync_folder(parent).map_err(io_failed("sync", parent))?;
        out.tidy();
        Ok(gone)
    }

    /// Writes the files beside the trace and leaves them there; returns the folder.
    ///
    /// # Errors
    /// [`OutError`] when the disk refuses.
    pub fn keep_apart(self, files: &Files) -> Result<PathBuf, OutError> {
        self.making.fill(files)?;
        Ok(self.folder())
    }

    /// Leaves the trace alone; returns where it stands.
    pub fn fail(self) -> PathBuf {
        self.making.leave_only_trace();
        self.folder().join(TRACE)
    }

    /// Its folder, where it stays unless it is published.
    pub fn folder(&self) -> PathBuf {
        self.out.shown_shelf.join(self.number.to_string())
    }
}

/// Where a folder is, with no link on the way; it need not be there yet.
fn resolved(root: &Path) -> Result<PathBuf, OutError> {
    let refused = |why| OutError::Place { root: root.to_path_buf(), why };
    let whole = std::path::absolute(root).map_err(io_failed("find", root))?;
    let place = match fs::symlink_metadata(root) {
        Ok(about) if about.is_symlink() && !root.exists() => {
            return Err(refused("is a link that leads nowhere"));
        }
        Ok(_) if !root.is_dir() => return Err(refused("is no folder")),
        Ok(_) => fs::canonicalize(root).map_err(io_failed("find", root))?,
        Err(_) => match (whole.parent().map(fs::canonicalize), whole.file_name()) {
            (Some(Ok(parent)), Some(name)) => parent.join(name),
            // Its parent comes into being, too.
            _ => whole,
        },
    };
    let here = std::env::current_dir().and_then(fs::canonicalize).unwrap_or_default();
    match place.parent() {
        None => Err(refused("has no folder around it, so that nothing can take its place")),
        Some(_) if here.starts_with(&place) => {
            Err(refused("is the folder you work in, so that nothing can take its place"))
        }
        Some(parent) if place.exists() && is_mounted(&place, parent) => {
            Err(refused("is a disk of its own, so that nothing can take its place"))
        }
        Some(_) => Ok(place),
    }
}

#[cfg(unix)]
fn is_mounted(place: &Path, parent: &Path) -> bool {
    use std::os::unix::fs::MetadataExt as _;

    let disk = |path: &Path| fs::metadata(path).map(|about| about.dev());
    matches!((disk(place), disk(parent)), (Ok(one), Ok(other)) if one != other)
}

#[cfg(not(unix))]
fn is_mounted(_: &Path, _: &Path) -> bool {
    false
}

/// The place's name with something behind it.
fn beside(place: &Path, suffix: &str) -> Result<PathBuf, OutError> {
    let none = || OutError::Place { root: place.to_path_buf(), why: "has no name" };
    let mut name = place.file_name().ok_or_else(none)?.to_owned();
    name.push(suffix);
    Ok(place.with_file_name(name))
}

/// The file of a folder's lock: beside it, for the folder itself is exchanged.
fn hidden(place: &Path) -> Result<PathBuf, OutError> {
    let path = beside(place, ".lock")?;
    let mut name = std::ffi::OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    Ok(path.with_file_name(name))
}

/// Refuses a place for failed runs that is somebody else's.
fn check_shelf(shelf: &Path) -> Result<(), OutError> {
    let root = shelf.to_path_buf();
    if fs::symlink_metadata(shelf).is_ok_and(|about| !about.is_dir()) {
        let why = "is meant for the traces of runs that fail, and is no folder";
        return Err(OutError::Place { root, why });
    }
    match marker::whose(shelf).map_err(io_failed("look into", shelf))? {
        Whose::Nobodys | Whose::Ours(Marker { kind: Kind::Failed, .. }) => Ok(()),
        Whose::Ours(Marker { kind, .. }) => Err(OutError::Kind { root, kind }),
        Whose::Strange(found) => Err(OutError::NotOurs { root, found }),
    }
}

#[cfg(test)]
mod tests;
