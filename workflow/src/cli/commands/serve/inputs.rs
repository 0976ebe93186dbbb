//! Files that were sent to a service: each in a folder of its own, named by its digest, below whose it is.

use std::collections::BTreeMap;
use std::fs;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use runner::ours::sync_folder;
use studio::{Failure, Incoming, Kept};
use tempfile::NamedTempFile;
use trace::Digest;

/// The folder of all of them, in the service's.
pub(super) const INPUTS: &str = "inputs";
/// What a file is called in its folder.
const FILE: &str = "file";
/// What a condition is called in its folder.
pub(super) const CONDITION: &str = "condition.json";
/// How the name of one begins that is coming in; nobody's name begins so.
const COMING: &str = ".coming-";

/// How many bytes each has sent that are kept.
type Counts = Arc<Mutex<BTreeMap<String, u64>>>;

/// The files of all who ask.
pub(super) struct Inputs {
    root: PathBuf,
    /// Most bytes of each.
    most: u64,
    kept: Counts,
}

impl Inputs {
    /// Those in a service's folder; what a kill left half is removed.
    pub(super) fn open(folder: &Path, most: u64) -> io::Result<Self> {
        let root = folder.join(INPUTS);
        fs::create_dir_all(&root)?;
        let mut kept = BTreeMap::new();
        for entry in fs::read_dir(&root)?.flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            if name.starts_with(COMING) {
                fs::remove_file(entry.path())?;
            } else if entry.file_type()?.is_dir() {
                kept.insert(name, bytes_of(&entry.path())?);
            }
        }
        Ok(Self { root, most, kept: Arc::new(Mutex::new(kept)) })
    }

    /// A file that begins to come in.
    pub(super) fn receive(&self, who: &str) -> Result<Box<dyn Incoming>, Failure> {
        let kept = locked(&self.kept).get(who).copied().unwrap_or_default();
        if kept >= self.most {
            let most = self.most;
            let found = format!("this token's files have {kept} bytes, and {most} are its most");
            let hint = "ask whoever runs the service: --max-stored gives more";
            return Err(Failure::new(found).with_hint(hint));
        }
        let file = tempfile::Builder::new().prefix(COMING).tempfile_in(&self.root);
        let file = file.map_err(unkept)?;
        let (who, kept) = (who.to_owned(), Arc::clone(&self.kept));
        Ok(Box::new(Coming { file, bytes: 0, place: self.root.join(&who), who, kept }))
    }

    /// Keeps some bytes under a name of their own; the path from the service's folder.
    pub(super) fn keep(&self, who: &str, bytes: &[u8], name: &str) -> io::Result<PathBuf> {
        let digest = Digest::of(bytes);
        let path = self.root.join(who).join(digest.as_str()).join(name);
        if !path.is_file() {
            let mut file = tempfile::Builder::new().prefix(COMING).tempfile_in(&self.root)?;
            file.write_all(bytes)?;
            settled(file, &path)?;
            *locked(&self.kept).entry(who.to_owned()).or_default() += bytes.len() as u64;
        }
        Ok(from_folder(who, &digest).join(name))
    }

    /// A file that came in, as the ending `obj` where the reader goes by it; the path from the service's
    /// folder, or none where this one sent none of that digest.
    pub(super) fn find(
        &self,
        who: &str,
        digest: &str,
        is_obj: bool,
    ) -> io::Result<Option<PathBuf>> {
        let Some(digest) = Digest::parse(digest) else { return Ok(None) };
        let folder = self.root.join(who).join(digest.as_str());
        let file = folder.join(FILE);
        if !file.is_file() {
            return Ok(None);
        }
        if !is_obj {
            return Ok(Some(from_folder(who, &digest).join(FILE)));
        }
        let name = format!("{FILE}.obj");
        let named = folder.join(&name);
        if !named.is_file() {
            match fs::hard_link(&file, &named) {
                // Another request of the same file was quicker.
                Err(e) if e.kind() == io::ErrorKind::AlreadyExists => {}
                linked => linked?,
            }
            sync_folder(&folder)?;
        }
        Ok(Some(from_folder(who, &digest).join(name)))
    }
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn unkept(error: io::Error) -> Failure {
    Failure::new(format!("the file cannot be kept: {error}"))
}

/// The bytes of the files in a token's folder; another name of a file takes no room.
fn bytes_of(folder: &Path) -> io::Result<u64> {
    let mut bytes = 0;
    for entry in fs::read_dir(folder)?.flatten() {
        for file in [FILE, CONDITION] {
            bytes += fs::metadata(entry.path().join(file)).map_or(0, |about| about.len());
        }
    }
    Ok(bytes)
}

fn from_folder(who: &str, digest: &Digest) -> PathBuf {
    Path::new(INPUTS).join(who).join(digest.as_str())
}

/// Puts a file where it stays, and is not done before it would survive a cut of the power.
fn settled(file: NamedTempFile, path: &Path) -> io::Result<()> {
    file.as_file().sync_all()?;
    let folder = path.parent().unwrap_or(Path::new("."));
    fs::create_dir_all(folder)?;
    file.persist(path).map_err(|e| e.error)?;
    for folder in folder.ancestors().take(3) {
        sync_folder(folder)?;
    }
    Ok(())
}

/// A file that comes in.
struct Coming {
    file: NamedTempFile,
    bytes: u64,
    /// Whose it is, and his folder.
    who: String,
    place: PathBuf,
    kept: Counts,
}

impl Incoming for Coming {
    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.bytes += bytes.len() as u64;
        self.file.write_all(bytes)
    }

    fn keep(self: Box<Self>) -> Result<Kept, Failure> {
        let Self { file, bytes, who, place, kept } = *self;
        let again = file.reopen().map_err(unkept)?;
        let digest = Digest::of_reader(again).map_err(unkept)?;
        let path = place.join(digest.as_str()).join(FILE);
        if !path.is_file() {
            settled(file, &path).map_err(unkept)?;
            *locked(&kept).entry(who).or_default() += bytes;
        }
        Ok(Kept { digest: digest.to_string(), bytes })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_was_sent_is_its_senders_and_one_that_broke_off_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let inputs = Inputs::open(folder.path(), 14).unwrap();
        let send = |who, bytes: &[u8]| {
            let mut file = inputs.receive(who).unwrap();
            file.write(bytes).unwrap();
            file
        };
        let kept = send("ann", b"a photo").keep().unwrap();
        assert_eq!(kept, send("ann", b"a photo").keep().unwrap());
        drop(send("ann", b"half"));
        send("ann", b"another").keep().unwrap();
        let full = inputs.receive("ann").err().unwrap();
        assert_eq!(full.message, "this token's files have 14 bytes, and 14 are its most");
        assert!(inputs.receive("bob").is_ok(), "another's room is another's");
        std::fs::write(folder.path().join("inputs/.coming-x"), "of one that was killed").unwrap();
        let again = Inputs::open(folder.path(), 14).unwrap();
        assert_eq!(again.receive("ann").err().unwrap(), full, "the same after a start");
        let find = |who, digest: &str, obj| inputs.find(who, digest, obj).unwrap();
        let found = find("ann", &kept.digest, false).unwrap();
        assert_eq!(std::fs::read(folder.path().join(&found)).unwrap(), b"a photo");
        let obj = find("ann", &kept.digest, true).unwrap();
        assert!(obj.ends_with("file.obj") && folder.path().join(&obj).is_file());
        for (who, digest) in [("bob", &*kept.digest), ("ann", "../../x"), ("ann", &"0".repeat(64))]
        {
            assert_eq!(find(who, digest, false), None);
        }
        let all = std::fs::read_dir(folder.path().join("inputs")).unwrap();
        assert_eq!(all.count(), 1, "ann's folder alone");
    }
}
