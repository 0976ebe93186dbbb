//! The step by which a finished folder takes its place, and what is done with the folder that stood
//! there: files of ours go, files of others stay where they were.
//!
//! ```
//! use runner::ours::swap;
//!
//! let dir = tempfile::tempdir()?;
//! let [new, place, before] = ["new", "place", "before"].map(|name| dir.path().join(name));
//! std::fs::create_dir(&new)?;
//! assert_eq!(swap::put(&new, &place, &before)?, None);
//! assert!(place.is_dir() && !new.exists());
//! # Ok::<(), std::io::Error>(())
//! ```

use std::collections::BTreeSet;
use std::fs::{self, Metadata};
use std::io;
use std::path::{Path, PathBuf};

use super::files::{self, sync_folder};
use super::marker::is_marker;

/// Most files of others that are carried over; a guess: more of them are a project, not notes.
const MOST: usize = 100_000;

/// The files of ours in a folder, by path in it with `/` between.
#[derive(Clone, Debug, Default)]
pub struct Names(pub BTreeSet<String>);

impl Names {
    /// Whether a path in the folder is one of them.
    pub fn has(&self, path: &Path) -> bool {
        slashed(path).is_some_and(|name| self.0.contains(&name))
    }
}

impl From<BTreeSet<String>> for Names {
    fn from(names: BTreeSet<String>) -> Self {
        Self(names)
    }
}

/// Something of somebody else's that cannot be carried over.
#[derive(Debug, thiserror::Error)]
#[error("{} {why}", files::name(path))]
pub struct Stuck {
    /// Where it stands.
    pub path: PathBuf,
    /// Why not.
    pub why: String,
}

/// Links everything in `old` that is not ours into `new`, so that it stands in both. Nothing in
/// `old` changes, and no link is followed.
///
/// # Errors
/// [`Stuck`]: what cannot stand in the new folder, too.
pub fn carry(old: &Path, new: &Path, ours: &Names) -> Result<(), Stuck> {
    let stuck = |path: &Path, why: String| Stuck { path: old.join(path), why };
    let failed = |path: &Path, e: io::Error| stuck(path, format!("cannot be carried over: {e}"));
    let disk = disk(&fs::symlink_metadata(old).map_err(|e| failed(Path::new(""), e))?);
    let (mut folders, mut count) = (vec![PathBuf::new()], 0);
    while let Some(folder) = folders.pop() {
        for (path, about) in entries(old, &folder).map_err(|e| failed(&folder, e))? {
            let target = new.join(&path);
            if about.is_dir() {
                if self::disk(&about) != disk {
                    let why = "lies on another disk and cannot be carried over".into();
                    return Err(stuck(&path, why));
                }
                if !holds_ours(&path, ours) {
                    make_folder(&target, &about).map_err(|e| failed(&path, e))?;
                }
                folders.push(path);
            } else if !ours.has(&path) {
                count += 1;
                if count > MOST {
                    let why = format!("is one of more than {MOST} files that we did not write");
                    return Err(stuck(&path, why));
                }
                if fs::symlink_metadata(&target).is_ok() {
                    let why = "stands where the asset has a file, and we did not write it".into();
                    return Err(stuck(&path, why));
                }
                let linked =
                    make_parents(new, &path).and_then(|()| fs::hard_link(old.join(&path), &target));
                linked.map_err(|e| failed(&path, e))?;
            }
        }
    }
    Ok(())
}

/// Puts folder `new` in its place by one step. What stood there lies at the path that is returned;
/// none if nothing did.
///
/// Where the system cannot exchange two folders in one step, the old one moves to `before` and the
/// new one into its place: whoever comes next finds `before` and sets it right.
///
/// # Errors
/// What the operating system says; the old folder stands in its place then.
pub fn put(new: &Path, place: &Path, before: &Path) -> io::Result<Option<PathBuf>> {
    let old = match fs::symlink_metadata(place) {
        Err(e) if e.kind() == io::ErrorKind::NotFound => {
            fs::rename(new, place)?;
            None
        }
        Err(e) => return Err(e),
        Ok(_) => Some(match exchange(new, place) {
            Some(exchanged) => exchanged.map(|()| new.to_path_buf())?,
            None => in_two_steps(new, place, before)?,
        }),
    };
    for path in [place, new] {
        sync_folder(path.parent().unwrap_or(Path::new(".")))?;
    }
    Ok(old)
}

/// The old folder moves aside, the new one into its place.
fn in_two_steps(new: &Path, place: &Path, before: &Path) -> io::Result<PathBuf> {
    fs::rename(place, before)?;
    match fs::rename(new, place) {
        Err(e) => fs::rename(before, place).and(Err(e)),
        Ok(()) => Ok(before.to_path_buf()),
    }
}

/// Exchanges two folders in one step; none where the system does not know how.
#[cfg(any(target_os = "linux", target_os = "macos"))]
fn exchange(one: &Path, other: &Path) -> Option<io::Result<()>> {
    use rustix::fs::{CWD, RenameFlags, renameat_with};
    use rustix::io::Errno;

    match renameat_with(CWD, one, CWD, other, RenameFlags::EXCHANGE) {
        Err(Errno::INVAL | Errno::NOSYS | Errno::OPNOTSUPP) => None,
        done => Some(done.map_err(io::Error::from)),
    }
}

#[cfg(not(any(target_os = "linux", target_os = "macos")))]
fn exchange(_: &Path, _: &Path) -> Option<io::Result<()>> {
    None
}

/// The folder that took another one's place, and what in it is ours.
#[derive(Clone, Copy, Debug)]
pub struct Heir<'a> {
    /// Where it stands.
    pub place: &'a Path,
    /// What in it is ours.
    pub ours: &'a Names,
}

/// Removes our files from a folder, and the folder once it is empty; true if it is gone.
///
/// Files of others stand in the heir already; what came since is moved there. Without an heir they
/// stay where they are, and so does the folder.
///
/// # Errors
/// What the operating system says.
pub fn clear(folder: &Path, ours: &Names, heir: Option<Heir<'_>>) -> io::Result<bool> {
    let (mut folders, mut seen) = (vec![PathBuf::new()], Vec::new());
    while let Some(inner) = folders.pop() {
        for (path, about) in entries(folder, &inner)? {
            if about.is_dir() {
                folders.push(path.clone());
                seen.push(path);
            } else if ours.has(&path) {
                fs::remove_file(folder.join(&path))?;
            } else if let Some(heir) = heir {
                hand_over(folder, (&path, &about), heir)?;
            }
        }
    }
    for inner in seen.iter().rev() {
        // One that is not empty has files of others in it.
        let _ = fs::remove_dir(folder.join(inner));
    }
    let left = fs::read_dir(folder)?.filter_map(Result::ok);
    let mut left = left.filter(|e| !e.file_name().to_str().is_some_and(is_marker));
    if left.next().is_some() {
        return Ok(false);
    }
    // The marker last: whoever is killed before leaves a folder that is known as ours.
    for entry in fs::read_dir(folder)? {
        fs::remove_file(entry?.path())?;
    }
    fs::remove_dir(folder)?;
    Ok(true)
}

/// Lets go of a file of somebody else's that stands in the heir already, or moves it there.
fn hand_over(folder: &Path, (path, about): (&Path, &Metadata), heir: Heir<'_>) -> io::Result<()> {
    let (from, to) = (folder.join(path), heir.place.join(path));
    match fs::symlink_metadata(&to) {
        Ok(there) if same(about, &there) => fs::remove_file(from),
        // What was saved last is the file in the old folder.
        Ok(there) if !there.is_dir() && !heir.ours.has(path) => fs::rename(from, to),
        Ok(_) => Ok(()),
        Err(_) => make_parents(heir.place, path).and_then(|()| fs::rename(from, to)),
    }
}

/// What stands in a folder below `root`, by path from there; markers are left out.
fn entries(root: &Path, folder: &Path) -> io::Result<Vec<(PathBuf, Metadata)>> {
    let mut found = Vec::new();
    for entry in fs::read_dir(root.join(folder))? {
        let entry = entry?;
        let name = entry.file_name();
        if folder.as_os_str().is_empty() && name.to_str().is_some_and(is_marker) {
            continue;
        }
        found.push((folder.join(&name), fs::symlink_metadata(entry.path())?));
    }
    found.sort_by(|(a, _), (b, _)| a.cmp(b));
    Ok(found)
}

/// Whether a file of ours may lie below that folder.
fn holds_ours(path: &Path, ours: &Names) -> bool {
    let Some(name) = slashed(path) else { return false };
    let head = format!("{name}/");
    let next = ours.0.range(head.clone()..).next();
    next.is_some_and(|file| file.starts_with(&head)) || ours.has(path)
}

fn make_parents(root: &Path, path: &Path) -> io::Result<()> {
    let mut folder = root.to_path_buf();
    for part in path.parent().into_iter().flat_map(Path::components) {
        folder.push(part);
        match fs::create_dir(&folder) {
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {
                if !fs::symlink_metadata(&folder)?.is_dir() {
                    return Err(io::Error::other("the asset has a file of its folder's name"));
                }
            }
            made => made?,
        }
    }
    Ok(())
}

fn make_folder(target: &Path, like: &Metadata) -> io::Result<()> {
    match fs::create_dir(target) {
        Err(e) if e.kind() == io::ErrorKind::AlreadyExists && target.is_dir() => return Ok(()),
        made => made?,
    }
    fs::set_permissions(target, like.permissions())
}

fn slashed(path: &Path) -> Option<String> {
    let parts: Option<Vec<_>> = path.iter().map(|part| part.to_str()).collect();
    Some(parts?.join("/"))
}

#[cfg(unix)]
fn disk(about: &Metadata) -> u64 {
    std::os::unix::fs::MetadataExt::dev(about)
}

#[cfg(unix)]
fn same(one: &Metadata, other: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    (one.dev(), one.ino()) == (other.dev(), other.ino())
}

#[cfg(not(unix))]
fn disk(_: &Metadata) -> u64 {
    0
}

/// Without numbers of files a copy is known by its length and its time.
#[cfg(not(unix))]
fn same(one: &Metadata, other: &Metadata) -> bool {
    one.len() == other.len() && one.modified().ok() == other.modified().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write(root: &Path, files: &[(&str, &str)]) {
        for (name, text) in files {
            let path = root.join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
    }

    fn all(root: &Path) -> Vec<(String, String)> {
        let (mut folders, mut found) = (vec![PathBuf::new()], vec![]);
        while let Some(folder) = folders.pop() {
            for (path, about) in entries(root, &folder).unwrap() {
                if about.is_dir() {
                    folders.push(path);
                } else {
                    let text = fs::read_to_string(root.join(&path)).unwrap();
                    found.push((slashed(&path).unwrap(), text));
                }
            }
        }
        found.sort();
        found
    }

    fn ours(names: &[&str]) -> Names {
        names.iter().map(ToString::to_string).collect::<BTreeSet<_>>().into()
    }

    #[test]
    fn files_of_others_stand_in_the_new_folder_and_ours_are_gone() {
        let dir = tempfile::tempdir().unwrap();
        let [old, new, before] = ["old", "new", "before"].map(|n| dir.path().join(n));
        write(&old, &[("asset.urdf", "1"), ("meshes/a.stl", "a"), ("meshes/mine.stl", "mine")]);
        write(&old, &[("notes/b/c.txt", "c"), ("readme", "r")]);
        fs::create_dir(old.join("empty")).unwrap();
        write(&new, &[("asset.urdf", "2"), ("meshes/b.stl", "b")]);
        let (was, is) =
            (ours(&["asset.urdf", "meshes/a.stl"]), ours(&["asset.urdf", "meshes/b.stl"]));
        carry(&old, &new, &was).unwrap();
        assert_eq!(all(&old).len(), 5, "nothing in the old one changes");
        let aside = put(&new, &old, &before).unwrap().unwrap();
        // Somebody saves a file and adds another while we are at it.
        fs::remove_file(aside.join("readme")).unwrap();
        write(&aside, &[("readme", "newer"), ("late/d.txt", "d")]);
        assert!(clear(&aside, &was, Some(Heir { place: &old, ours: &is })).unwrap());
        let expected = [
            ("asset.urdf", "2"),
            ("late/d.txt", "d"),
            ("meshes/b.stl", "b"),
            ("meshes/mine.stl", "mine"),
            ("notes/b/c.txt", "c"),
            ("readme", "newer"),
        ];
        assert_eq!(all(&old), expected.map(|(n, t)| (n.to_owned(), t.to_owned())));
        assert!(old.join("empty").is_dir() && !new.exists() && !before.exists());
    }

    #[test]
    fn what_stands_where_the_asset_has_a_file_is_not_overwritten() {
        for theirs in ["asset.glb", "asset.glb/inner.txt", "meshes"] {
            let dir = tempfile::tempdir().unwrap();
            let [old, new] = ["old", "new"].map(|n| dir.path().join(n));
            write(&old, &[("asset.urdf", "1"), (theirs, "mine")]);
            write(&new, &[("asset.urdf", "2"), ("asset.glb", "g"), ("meshes/a.stl", "a")]);
            let stuck = carry(&old, &new, &ours(&["asset.urdf"])).unwrap_err();
            assert!(stuck.path.starts_with(old.join(theirs.split('/').next().unwrap())), "{stuck}");
            assert_eq!(fs::read_to_string(old.join(theirs)).unwrap(), "mine");
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_link_is_carried_as_a_link_and_never_followed() {
        let dir = tempfile::tempdir().unwrap();
        let [old, new, far] = ["old", "new", "far"].map(|n| dir.path().join(n));
        write(&far, &[("precious", "mine")]);
        write(&old, &[("asset.urdf", "1")]);
        write(&new, &[("asset.urdf", "2")]);
        std::os::unix::fs::symlink(&far, old.join("meshes")).unwrap();
        carry(&old, &new, &ours(&["asset.urdf", "meshes/precious"])).unwrap();
        let aside = put(&new, &old, &dir.path().join("before")).unwrap().unwrap();
        let is = ours(&["asset.urdf"]);
        let was = ours(&["asset.urdf", "meshes/precious"]);
        assert!(clear(&aside, &was, Some(Heir { place: &old, ours: &is })).unwrap());
        assert_eq!(fs::read_link(old.join("meshes")).unwrap(), far);
        assert_eq!(fs::read_to_string(far.join("precious")).unwrap(), "mine");
    }

    #[test]
    fn in_two_steps_the_old_folder_is_back_if_the_new_one_does_not_come() {
        let dir = tempfile::tempdir().unwrap();
        let [old, new, before] = ["old", "new", "before"].map(|n| dir.path().join(n));
        write(&old, &[("asset.urdf", "1")]);
        assert!(in_two_steps(&new, &old, &before).is_err());
        assert_eq!(all(&old), [("asset.urdf".to_owned(), "1".to_owned())]);
        write(&new, &[("asset.urdf", "2")]);
        assert_eq!(in_two_steps(&new, &old, &before).unwrap(), before);
        assert_eq!(all(&old), [("asset.urdf".to_owned(), "2".to_owned())]);
        assert_eq!(all(&before), [("asset.urdf".to_owned(), "1".to_owned())]);
    }

    #[test]
    fn without_an_heir_files_of_others_stay_where_they_are() {
        let dir = tempfile::tempdir().unwrap();
        let folder = dir.path().join("3");
        write(&folder, &[("trace.mcap", "t"), ("mine.txt", "mine")]);
        assert!(!clear(&folder, &ours(&["trace.mcap"]), None).unwrap());
        assert_eq!(all(&folder), [("mine.txt".to_owned(), "mine".to_owned())]);
    }
}
