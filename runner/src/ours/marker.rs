//! The marker of a folder of ours: a small file that only we write, which says what the folder is
//! and which files in it we wrote. No other file makes a folder ours, whatever its name.
//!
//! ```
//! use runner::ours::marker::{Saved, whose};
//! use runner::ours::{Kind, Marker, Whose};
//!
//! let dir = tempfile::tempdir()?;
//! assert_eq!(whose(dir.path())?, Whose::Nobodys);
//! let marker = Marker::of(Kind::Asset).with(["asset.urdf".to_owned()]);
//! marker.write(dir.path(), Saved::Later)?;
//! assert_eq!(whose(dir.path())?, Whose::Ours(marker));
//! # Ok::<(), std::io::Error>(())
//! ```

use std::collections::BTreeSet;
use std::fs;
use std::io::{self, Write as _};
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::files;

/// Name of the marker in its folder.
pub const FILE: &str = ".kinfold";
/// How the name begins of a marker that is being written; the number of the process follows, since
/// two may claim a folder at once.
const PARTIAL: &str = ".kinfold.partial";
/// What a marker says that it is.
const SCHEMA: &str = "kinfold-folder/1";
/// Most bytes of a marker that are read; a guess: it has a name of a file per line, and an asset has
/// some hundreds of them.
const MOST: u64 = 16 << 20;

/// What a folder of ours is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// A state directory.
    State,
    /// A store that several machines share.
    Store,
    /// The folder of a batch.
    Batch,
    /// A finished asset.
    Asset,
    /// An asset that is being made, or was when its run ended.
    Unfinished,
    /// Where the folders of runs lie that did not publish an asset.
    Failed,
    /// Copies of a model with planted defects.
    Mutants,
}

/// What a marker says.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Marker {
    schema: String,
    /// What the folder is.
    pub kind: Kind,
    /// The files in it that we wrote, by path in it with `/` between; folders are not listed.
    #[serde(default, skip_serializing_if = "BTreeSet::is_empty")]
    pub files: BTreeSet<String>,
}

/// Whether the disk must have a marker before anything else happens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Saved {
    /// It survives a power cut.
    Now,
    /// It survives the end of the program.
    Later,
}

/// Whose a folder is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Whose {
    /// There is none, or it is empty.
    Nobodys,
    /// It has our marker.
    Ours(Marker),
    /// It has files and no marker of ours: the name of one of them.
    Strange(String),
}

impl Marker {
    /// A marker without files.
    pub fn of(kind: Kind) -> Self {
        Self { schema: SCHEMA.into(), kind, files: BTreeSet::new() }
    }

    /// The same with the files that we write.
    #[must_use]
    pub fn with(self, files: impl IntoIterator<Item = String>) -> Self {
        Self { files: files.into_iter().collect(), ..self }
    }

    /// The marker of a folder; none where there is no file of that name that we wrote.
    pub fn read(folder: &Path) -> Option<Self> {
        let path = folder.join(FILE);
        if !fs::symlink_metadata(&path).ok()?.is_file() {
            return None;
        }
        let bytes = guard::files::read(&path, MOST).ok()?;
        let marker: Self = serde_json::from_slice(&bytes).ok()?;
        (marker.schema == SCHEMA).then_some(marker)
    }

    /// Writes the marker of a folder, whole or not at all.
    ///
    /// # Errors
    /// What the operating system says.
    pub fn write(&self, folder: &Path, saved: Saved) -> io::Result<()> {
        let partial = folder.join(format!("{PARTIAL}-{}", std::process::id()));
        let written = self.write_to(&partial, saved);
        let moved = written.and_then(|()| fs::rename(&partial, folder.join(FILE)));
        if moved.is_err() {
            // A full disk is full of other things.
            let _ = fs::remove_file(&partial);
        }
        moved?;
        if saved == Saved::Now {
            fs::File::open(folder)?.sync_all()?;
        }
        Ok(())
    }

    fn write_to(&self, path: &Path, saved: Saved) -> io::Result<()> {
        let mut text = serde_json::to_vec_pretty(self)?;
        text.push(b'\n');
        let mut file = files::create(path)?;
        file.write_all(&text)?;
        if saved == Saved::Now { file.sync_all() } else { Ok(()) }
    }
}

/// Whose a folder is. A link is followed, since a person named it.
///
/// # Errors
/// What the operating system says; that it is no folder, too.
pub fn whose(folder: &Path) -> io::Result<Whose> {
    if let Some(marker) = Marker::read(folder) {
        return Ok(Whose::Ours(marker));
    }
    let entries = match fs::read_dir(folder) {
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(Whose::Nobodys),
        entries => entries?,
    };
    for entry in entries {
        let name = entry?.file_name();
        // Ours was killed before anything else was there.
        if name.to_str().is_some_and(|name| name.starts_with(PARTIAL)) {
            continue;
        }
        // Whoever claims it at the same time writes the marker first.
        let strange = || Whose::Strange(files::name(Path::new(&name)));
        return Ok(Marker::read(folder).map_or_else(strange, Whose::Ours));
    }
    Ok(Whose::Nobodys)
}

/// Whether a name in a folder is the marker's, finished or not.
pub fn is_marker(name: &str) -> bool {
    name == FILE || name.starts_with(PARTIAL)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_is_ours_by_what_the_marker_says_and_not_by_its_name() {
        let dir = tempfile::tempdir().unwrap();
        assert_eq!(whose(&dir.path().join("none")).unwrap(), Whose::Nobodys);
        assert_eq!(whose(dir.path()).unwrap(), Whose::Nobodys);
        for strange in ["", "{}", "{\"schema\":\"other/1\",\"kind\":\"asset\"}", "\u{0}\u{1}"] {
            fs::write(dir.path().join(FILE), strange).unwrap();
            assert_eq!(whose(dir.path()).unwrap(), Whose::Strange(FILE.into()), "{strange}");
        }
        let marker = Marker::of(Kind::Asset).with(["asset.urdf".to_owned()]);
        marker.write(dir.path(), Saved::Now).unwrap();
        assert_eq!(whose(dir.path()).unwrap(), Whose::Ours(marker));
    }

    #[test]
    fn a_run_that_was_killed_over_its_marker_is_no_stranger() {
        let dir = tempfile::tempdir().unwrap();
        fs::write(dir.path().join(PARTIAL), "{\"sch").unwrap();
        assert_eq!(whose(dir.path()).unwrap(), Whose::Nobodys);
        fs::write(dir.path().join("thesis.txt"), "mine").unwrap();
        assert_eq!(whose(dir.path()).unwrap(), Whose::Strange("thesis.txt".into()));
    }

    #[cfg(unix)]
    #[test]
    fn a_marker_behind_a_link_is_none() {
        let dir = tempfile::tempdir().unwrap();
        let (ours, theirs) = (dir.path().join("ours"), dir.path().join("theirs"));
        for folder in [&ours, &theirs] {
            fs::create_dir(folder).unwrap();
        }
        Marker::of(Kind::State).write(&ours, Saved::Later).unwrap();
        std::os::unix::fs::symlink(ours.join(FILE), theirs.join(FILE)).unwrap();
        assert_eq!(whose(&theirs).unwrap(), Whose::Strange(FILE.into()));
    }
}
