//! The folder of mutants: new or ours, and exchanged by one step.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use runner::ours::lock::After;
use runner::ours::marker::{Saved, whose};
use runner::ours::swap::{self, Heir, Names};
use runner::ours::{Kind, Lock, Marker, Turns, Whose};

use crate::cli::speech::Complaint;

/// A file of the folder.
pub(super) enum Content<'a> {
    /// These bytes.
    Bytes(&'a [u8]),
    /// Those of another file of it, by its path.
    Same(String),
}

/// Refuses a folder that is not ours, not empty and there.
pub(super) fn look(out: &Path) -> Result<(), Complaint> {
    if fs::symlink_metadata(out).is_err() {
        return Ok(());
    }
    let hint = "name a new folder with --out DIR";
    let complaint =
        |why: String| Complaint::misused(format!("{}: {why}", out.display())).hint(hint);
    match whose(out).map_err(|e| complaint(e.to_string()))? {
        Whose::Nobodys | Whose::Ours(Marker { kind: Kind::Mutants, .. }) => Ok(()),
        Whose::Ours(_) => Err(complaint("is a folder of another command of kinfold".into())),
        Whose::Strange(found) => {
            let found = guard::text::shown(&found).into_owned();
            Err(complaint(format!("holds `{found}`, and no `kinfold mutate` made this folder")))
        }
    }
}

/// A folder that is written beside the place that it is meant for.
pub(super) struct Making {
    place: PathBuf,
    folder: tempfile::TempDir,
    _lock: Lock,
}

impl Making {
    /// Begins one.
    pub(super) fn begin(out: &Path) -> Result<Self, Complaint> {
        look(out)?;
        let failed = |e: io::Error| Complaint::failed(format!("{}: {e}", out.display()));
        let place = match fs::canonicalize(out) {
            Ok(place) => place,
            Err(_) => std::path::absolute(out).map_err(failed)?,
        };
        let (Some(parent), Some(name)) = (place.parent(), place.file_name()) else {
            let why = format!("{} has no folder around it", out.display());
            return Err(Complaint::misused(why).hint("name a new folder with --out DIR"));
        };
        fs::create_dir_all(parent).map_err(failed)?;
        let name = name.to_string_lossy();
        let lock = parent.join(format!(".{name}.lock"));
        let lock = Lock::take(&lock, After::Goes, Turns::AT_ONCE, &name)
            .map_err(|e| Complaint::failed(format!("{} {e}", out.display())))?;
        let mut builder = tempfile::Builder::new();
        builder.prefix(".kinfold-mutants-");
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o755));
        let folder = builder.tempdir_in(parent).map_err(failed)?;
        Ok(Self { place, folder, _lock: lock })
    }

    /// Where its files are meanwhile.
    pub(super) fn root(&self) -> &Path {
        self.folder.path()
    }

    /// Writes files into it. What stands in another one already is linked, where the disk can.
    pub(super) fn fill(&self, files: &BTreeMap<String, Content>) -> Result<(), Complaint> {
        let root = self.root();
        for (name, content) in files {
            let path = root.join(name);
            let failed = |e: io::Error| Complaint::failed(format!("{}: {e}", path.display()));
            if let Some(folder) = path.parent() {
                fs::create_dir_all(folder).map_err(failed)?;
            }
            match content {
                Content::Bytes(bytes) => fs::write(&path, bytes).map_err(failed)?,
                Content::Same(other) => {
                    let other = root.join(other);
                    if fs::hard_link(&other, &path).is_err() {
                        fs::copy(&other, &path).map(drop).map_err(failed)?;
                    }
                }
            }
        }
        Ok(())
    }

    /// Puts it in its place; files of others that stood there stay there.
    pub(super) fn publish(self, names: BTreeSet<String>) -> Result<(), Complaint> {
        let failed = |e: io::Error| Complaint::failed(format!("{}: {e}", self.place.display()));
        let marker = Marker::of(Kind::Mutants).with(names);
        marker.write(self.root(), Saved::Later).map_err(failed)?;
        let was = Marker::read(&self.place).map(|m| Names::from(m.files));
        let stood = fs::symlink_metadata(&self.place).is_ok();
        if let Some(was) = &was {
            let carried = swap::carry(&self.place, self.root(), was);
            carried.map_err(|e| Complaint::failed(e.to_string()))?;
        }
        let before = self.place.with_file_name(format!(
            ".{}.before",
            self.place.file_name().unwrap_or_default().to_string_lossy()
        ));
        // What stood there comes into it by the exchange: from here on nothing tidies it up by itself.
        let root = self.folder.keep();
        let put = swap::put(&root, &self.place, &before);
        if put.is_err() {
            // Of others there are links alone in it.
            let _ = fs::remove_dir_all(&root);
        }
        let old = put.map_err(failed)?;
        let own = was.unwrap_or_default();
        if let Some(old) = old.filter(|_| stood) {
            let names = Marker::read(&self.place).map(|m| Names::from(m.files)).unwrap_or_default();
            let heir = Heir { place: &self.place, ours: &names };
            swap::clear(&old, &own, Some(heir)).map_err(failed)?;
        }
        Ok(())
    }
}
