//! The folder of a batch: one folder per accepted asset, the rest in quarantine, a ledger beside.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use runner::ours::lock::After;
use runner::ours::marker::{self, Saved, Whose};
use runner::ours::swap::Names;
use runner::ours::sync_folder;
use runner::ours::{Kind, Lock, Marker, Turns};

use super::error::BatchError;
use super::ledger::{self, Ledger};
use crate::output::{self, Making, standing};

/// Accepted assets, by id.
pub const ASSETS: &str = "assets";
/// What was made and not accepted, and the traces of what failed, by id.
pub const QUARANTINE: &str = "quarantine";
/// What is being made.
const UNFINISHED: &str = "unfinished";
/// How the name begins of an old folder on its way out; no id begins with a dot.
const BEFORE: &str = ".before-";

/// The folder of a batch.
///
/// Open for writing it holds the lock, which the operating system frees when the process ends,
/// however it ends.
#[derive(Debug)]
pub struct BatchFolder {
    root: PathBuf,
    _lock: Lock,
}

impl BatchFolder {
    /// Refuses a folder that is somebody else's. Changes nothing.
    ///
    /// # Errors
    /// [`BatchError`] when it holds something else.
    pub fn look(root: &Path) -> Result<(), BatchError> {
        let not_ours = |found: String| BatchError::NotOurs { path: root.to_path_buf(), found };
        match marker::whose(root).map_err(io_failed("look into", root))? {
            Whose::Nobodys | Whose::Ours(Marker { kind: Kind::Batch, .. }) => {}
            Whose::Ours(Marker { kind, .. }) => {
                return Err(not_ours(format!("a marker that says {kind:?}")));
            }
            Whose::Strange(found) if !is_of_old(root) => return Err(not_ours(found)),
            Whose::Strange(_) => {}
        }
        for name in [ASSETS, QUARANTINE, UNFINISHED] {
            let about = fs::symlink_metadata(root.join(name));
            if about.is_ok_and(|about| !about.is_dir()) {
                return Err(not_ours(name.to_owned()));
            }
        }
        Ok(())
    }

    /// Makes a folder that of a batch; one of 0.1.0 gets its marker. A folder of shards has no more
    /// than this.
    ///
    /// # Errors
    /// [`BatchError`] when it holds something else, or the disk refuses.
    pub fn claim(root: &Path) -> Result<(), BatchError> {
        Self::look(root)?;
        fs::create_dir_all(root).map_err(io_failed("create", root))?;
        if Marker::read(root).is_some() {
            return Ok(());
        }
        let marker = Marker::of(Kind::Batch);
        marker.write(root, Saved::Now).map_err(io_failed("mark", root))
    }

    /// Opens or creates the folder, alone, and its ledger, when it is our turn.
    ///
    /// # Errors
    /// [`BatchError`] when another batch has it and nobody is to wait, when it holds something else,
    /// or the disk refuses.
    pub fn open(root: &Path, turns: Turns) -> Result<(Self, Ledger), BatchError> {
        Self::claim(root)?;
        let what = format!("batch {}", runner::ours::name(root));
        let lock = Lock::take(&root.join("lock"), After::Stays, turns, &what);
        let lock = lock.map_err(|source| BatchError::Lock { path: root.to_path_buf(), source })?;
        for folder in [ASSETS, QUARANTINE, UNFINISHED] {
            let folder = root.join(folder);
            fs::create_dir_all(&folder).map_err(io_failed("create", &folder))?;
        }
        let ledger = Ledger::open(&root.join(ledger::FILE))?;
        Ok((Self { root: root.to_path_buf(), _lock: lock }, ledger))
    }

    /// Its path.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// An empty folder to make an item's asset in. What a killed run left there is removed; what is
    /// not ours in it goes where the asset stands.
    ///
    /// # Errors
    /// [`BatchError`] when the disk refuses.
    pub fn begin(&self, id: &str) -> Result<Making, BatchError> {
        let before = self.before(id);
        for place in [ASSETS, QUARANTINE, UNFINISHED] {
            check_place(&self.root.join(place).join(id))?;
        }
        for place in [ASSETS, QUARANTINE].map(|place| self.root.join(place).join(id)) {
            // A kill between two folders, where the system cannot exchange them.
            if before.join(place_word(&place)).exists() && !place.exists() {
                let back = fs::rename(before.join(place_word(&place)), &place);
                back.map_err(io_failed("move back into place", &place))?;
            }
        }
        let places = [ASSETS, QUARANTINE].map(|place| self.root.join(place).join(id));
        let heir = places.iter().find(|place| place.is_dir()).map(PathBuf::as_path);
        for left in [before.join(ASSETS), before.join(QUARANTINE), self.unfinished(id)] {
            output::clear(&left, &standing::ours_of_item(&left), heir)?;
        }
        let _ = fs::remove_dir(&before);
        let unfinished = self.unfinished(id);
        if unfinished.exists() {
            // Files of others are in it, and there is no asset that they could go to.
            let found = "it holds files that no run of ours wrote".into();
            return Err(BatchError::Folder { path: unfinished, found });
        }
        Ok(Making::begin(&unfinished)?)
    }

    fn unfinished(&self, id: &str) -> PathBuf {
        self.root.join(UNFINISHED).join(id)
    }

    /// Where an old folder of an item is in between, where the system cannot exchange two folders.
    fn before(&self, id: &str) -> PathBuf {
        self.root.join(UNFINISHED).join(format!("{BEFORE}{id}"))
    }

    /// Puts what was made in its place by one step, instead of whatever an earlier try left there.
    /// An asset that was accepted goes only when another one is accepted. Returns where it stands, and the
    /// signatures that stood there, were of something else, and went.
    ///
    /// # Errors
    /// [`BatchError`] when the disk refuses; what stood there stands there as it was then.
    pub fn place(
        &self,
        id: &str,
        made: &Making,
        accepted: bool,
    ) -> Result<(PathBuf, Vec<&'static str>), BatchError> {
        let here = if accepted { ASSETS } else { QUARANTINE };
        let to = self.root.join(here).join(id);
        let before = self.before(id);
        fs::create_dir_all(&before).map_err(io_failed("create", &before))?;
        let gone = made.publish(&to, &before.join(here), &standing::ours_of_item(&to))?;
        let _ = fs::remove_dir(&before);
        if accepted {
            let there = self.root.join(QUARANTINE).join(id);
            output::clear(&there, &standing::ours_of_item(&there), Some(&to))?;
        }
        let parent = self.root.join(here);
        sync_folder(&parent).map_err(io_failed("sync", &parent))?;
        Ok((to, gone))
    }

    /// Removes what was being made of an item.
    ///
    /// # Errors
    /// [`BatchError`] when the disk refuses.
    pub fn put_down(&self, id: &str) -> Result<(), BatchError> {
        let left = self.unfinished(id);
        Ok(output::clear(&left, &standing::ours_of_item(&left), None)?)
    }
}

/// Refuses a place of an item where something stands that is no folder, or one of somebody else's: with
/// files in it, and none that a run of ours wrote.
fn check_place(place: &Path) -> Result<(), BatchError> {
    let refused =
        |found: &str| BatchError::Folder { path: place.to_path_buf(), found: found.into() };
    let Ok(about) = fs::symlink_metadata(place) else { return Ok(()) };
    if !about.is_dir() {
        return Err(refused("is no folder, and stands where an item's files go"));
    }
    if Marker::read(place).is_some() {
        return Ok(());
    }
    let mut entries = fs::read_dir(place).map_err(io_failed("look into", place))?;
    let Names(ours) = standing::ours_of_item(place);
    match entries.next().is_some() && ours.is_empty() {
        true => {
            Err(refused("it holds files, no marker of ours and nothing that a run of ours wrote"))
        }
        false => Ok(()),
    }
}

/// The name of the folder that a place is in.
fn place_word(place: &Path) -> &'static str {
    let of = place.parent().and_then(Path::file_name);
    if of.is_some_and(|name| name == ASSETS) { ASSETS } else { QUARANTINE }
}

/// Whether 0.1.0 made this folder: a ledger in it that is one, or shards of which one has such a
/// ledger. Or nothing but empty folders and files of ours, as a kill left them at the very beginning.
fn is_of_old(root: &Path) -> bool {
    let regular = |path: &Path| fs::symlink_metadata(path).is_ok_and(|about| about.is_file());
    let has_ledger = |folder: &Path| {
        let ledger = folder.join(ledger::FILE);
        regular(&ledger) && Ledger::is_one(&ledger)
    };
    if has_ledger(root) {
        return true;
    }
    let entries: Vec<_> = fs::read_dir(root).into_iter().flatten().flatten().collect();
    let of_shard = |e: &fs::DirEntry| e.file_name().to_string_lossy().starts_with("shard-");
    if entries.iter().any(|e| of_shard(e) && has_ledger(&e.path())) {
        return true;
    }
    let is_empty = |e: &fs::DirEntry| match e.file_type() {
        Ok(kind) if kind.is_dir() => {
            [ASSETS, QUARANTINE, UNFINISHED].iter().any(|name| e.file_name() == *name)
                && fs::read_dir(e.path()).is_ok_and(|mut inner| inner.next().is_none())
        }
        Ok(kind) if kind.is_file() => {
            ["lock", ledger::FILE].iter().any(|name| e.file_name() == *name)
                && e.metadata().is_ok_and(|about| about.len() == 0)
        }
        _ => false,
    };
    entries.iter().all(is_empty)
}

/// An error of the disk about a file of the batch.
pub(super) fn io_failed(
    doing: &'static str,
    path: &Path,
) -> impl FnOnce(io::Error) -> BatchError + use<> {
    let path = path.to_path_buf();
    move |source| BatchError::Io { doing, path, source }
}

/// What was found of a folder or a file of the batch that is not read.
pub(super) fn refused(path: &Path) -> impl FnOnce(guard::files::Refused) -> BatchError + use<> {
    let path = path.to_path_buf();
    move |refused| BatchError::Folder { path, found: refused.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let names = entries.map(|e| e.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<_> = names.filter(|name| !marker::is_marker(name)).collect();
        names.sort();
        names
    }

    #[test]
    fn an_accepted_asset_stays_until_another_one_is_accepted() {
        let dir = tempfile::tempdir().unwrap();
        let (folder, _ledger) = BatchFolder::open(dir.path(), Turns::AT_ONCE).unwrap();
        let mut standing = None;
        for (n, accepted) in [false, true, true, false, true].into_iter().enumerate() {
            let made = folder.begin("lid").unwrap();
            let files = [("asset.urdf".to_owned(), n.to_string().into_bytes())];
            made.fill(&files.into()).unwrap();
            folder.place("lid", &made, accepted).unwrap();
            standing = if accepted { Some(n) } else { standing };
            let read = |place: &str| {
                fs::read_to_string(dir.path().join(place).join("lid/asset.urdf")).ok()
            };
            assert_eq!(read(ASSETS), standing.map(|n| n.to_string()));
            assert_eq!(read(QUARANTINE), (!accepted).then(|| n.to_string()));
            assert_eq!(names(&dir.path().join(UNFINISHED)), [""; 0]);
        }
    }

    #[test]
    fn notes_beside_an_asset_survive_its_being_made_again() {
        let dir = tempfile::tempdir().unwrap();
        let (folder, _ledger) = BatchFolder::open(dir.path(), Turns::AT_ONCE).unwrap();
        let place = dir.path().join(ASSETS).join("lid");
        fs::create_dir(&place).unwrap();
        for name in ["asset.urdf", "trace.mcap", "notes.txt"] {
            fs::write(place.join(name), name).unwrap();
        }
        // Without a marker it is somebody else's, whatever its files are called.
        let error = folder.begin("lid").unwrap_err().to_string();
        assert!(error.contains("no marker of ours"), "{error}");
        let ours = ["asset.urdf", "trace.mcap"].map(String::from);
        Marker::of(Kind::Asset).with(ours).write(&place, Saved::Later).unwrap();
        let made = folder.begin("lid").unwrap();
        made.fill(&[("asset.urdf".to_owned(), b"2".to_vec())].into()).unwrap();
        folder.place("lid", &made, true).unwrap();
        assert_eq!(names(&place), ["asset.urdf", "notes.txt"]);
        assert_eq!(fs::read_to_string(place.join("notes.txt")).unwrap(), "notes.txt");
    }

    #[test]
    fn a_second_batch_in_one_folder_is_refused_until_the_first_is_gone() {
        let dir = tempfile::tempdir().unwrap();
        let first = BatchFolder::open(dir.path(), Turns::AT_ONCE).unwrap();
        let error = BatchFolder::open(dir.path(), Turns::AT_ONCE).unwrap_err().to_string();
        assert!(error.contains("is in use by process"), "{error}");
        drop(first);
        BatchFolder::open(dir.path(), Turns::AT_ONCE).unwrap();
    }

    #[test]
    fn somebody_elses_folder_is_left_alone() {
        for name in ["thesis.tex", ledger::FILE, "assets/mine/asset.urdf", "shard-0-of-2/thesis"] {
            let dir = tempfile::tempdir().unwrap();
            let path = dir.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(&path, "mine").unwrap();
            let error = BatchFolder::open(dir.path(), Turns::AT_ONCE).unwrap_err().to_string();
            assert!(error.contains("no marker of ours"), "{error}");
            assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
            assert_eq!(fs::read_to_string(&path).unwrap(), "mine");
        }
    }

    #[test]
    fn a_batch_of_0_1_0_is_ours_and_gets_its_marker() {
        let dir = tempfile::tempdir().unwrap();
        drop(BatchFolder::open(dir.path(), Turns::AT_ONCE).unwrap());
        fs::remove_file(dir.path().join(marker::FILE)).unwrap();
        drop(BatchFolder::open(dir.path(), Turns::AT_ONCE).unwrap());
        assert!(Marker::read(dir.path()).is_some());
    }

    #[cfg(unix)]
    #[test]
    fn a_place_that_is_a_link_is_refused() {
        let dir = tempfile::tempdir().unwrap();
        let (root, far) = (dir.path().join("out"), dir.path().join("far"));
        drop(BatchFolder::open(&root, Turns::AT_ONCE).unwrap());
        fs::create_dir_all(far.join("lid")).unwrap();
        fs::write(far.join("lid/asset.urdf"), "mine").unwrap();
        fs::remove_dir(root.join(ASSETS)).unwrap();
        std::os::unix::fs::symlink(&far, root.join(ASSETS)).unwrap();
        let error = BatchFolder::open(&root, Turns::AT_ONCE).unwrap_err().to_string();
        assert!(error.contains("holds `assets`"), "{error}");
        assert_eq!(fs::read_to_string(far.join("lid/asset.urdf")).unwrap(), "mine");
    }
}
