//! One writer at a time: a lock that the operating system frees when its holder ends, however it
//! ends, and a word about the holder for whoever waits.
//!
//! Who takes two locks takes that of the folder it makes first, then that of its state directory,
//! and never two of a kind: nobody waits in a circle.
//!
//! ```
//! use runner::ours::lock::After;
//! use runner::ours::{Lock, LockError, Turns};
//!
//! let dir = tempfile::tempdir().unwrap();
//! let path = dir.path().join("lock");
//! let take = || Lock::take(&path, After::Stays, Turns::AT_ONCE, "a folder");
//! let held = take()?;
//! assert!(matches!(take(), Err(LockError::InUse(_))));
//! drop(held);
//! assert!(take().is_ok());
//! # Ok::<(), LockError>(())
//! ```

use std::fs::{self, File, TryLockError};
use std::io::{self, Read as _, Seek as _, Write as _};
use std::path::{Path, PathBuf};
use std::time::Duration;

use serde::{Deserialize, Serialize};
use trace::{Clock as _, SystemClock, moment};

use super::files;

/// What a holder's word says that it is.
const SCHEMA: &str = "kinfold-lock/1";
/// How the file of a lock begins that one of ours holds or held.
const HEAD: &[u8] = b"{\"schema\":\"kinfold-lock/1\"";
/// Most bytes of a holder's word.
const MOST: u64 = 4096;
/// How often who waits looks whether it is its turn.
const GLANCE: Duration = Duration::from_millis(50);

/// What is done while another process is at work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Turns {
    /// Wait until it is done; otherwise be refused at once.
    pub wait: bool,
    /// Say on stderr for whom.
    pub tell: bool,
}

impl Turns {
    /// Now or not at all.
    pub const AT_ONCE: Self = Self { wait: false, tell: false };
}

/// Who holds a lock.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Holder {
    schema: String,
    /// Its number on its machine.
    pub pid: u32,
    /// Its machine.
    pub host: String,
    /// When it got the lock, RFC 3339.
    pub since: String,
}

impl std::fmt::Display for Holder {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (host, since) = (guard::text::shown(&self.host), guard::text::shown(&self.since));
        write!(f, "process {} on {host}, at work since {since}", self.pid)
    }
}

/// Why a lock was not got.
#[derive(Debug, thiserror::Error)]
pub enum LockError {
    /// Another process has it, and nobody was to wait.
    #[error("is in use by {}", .0.as_ref().map_or("another run".to_owned(), Holder::to_string))]
    InUse(Option<Holder>),
    /// A file of its name stands there that we did not write.
    #[error("cannot be locked: {} is no lock of ours", files::name(.0))]
    Strange(PathBuf),
    /// The disk.
    #[error("cannot be locked: {}: {source}", files::name(path))]
    Io {
        /// The file of the lock.
        path: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
}

/// What becomes of a lock's file when the lock is let go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum After {
    /// It stays, empty of meaning.
    Stays,
    /// It goes.
    Goes,
}

/// A lock that is held until it is let go.
#[derive(Debug)]
pub struct Lock {
    file: File,
    path: PathBuf,
    after: After,
}

impl Lock {
    /// Takes the lock of that file; `what` names what it is for to whoever waits.
    ///
    /// # Errors
    /// [`LockError`].
    pub fn take(path: &Path, after: After, turns: Turns, what: &str) -> Result<Self, LockError> {
        let mut told: Option<Option<Holder>> = None;
        loop {
            let file = open(path)?;
            match file.try_lock() {
                Ok(()) if !stands(&file, path) => continue, // its last holder took it away
                Ok(()) => return Self::held(file, path, after),
                Err(TryLockError::WouldBlock) => {}
                Err(TryLockError::Error(e)) => return Err(failed(path)(e)),
            }
            let holder = holder(file);
            if !turns.wait {
                return Err(LockError::InUse(holder));
            }
            // A holder that has just begun has not said yet who it is.
            let news = told.as_ref().is_none_or(|before| *before != holder && holder.is_some());
            if turns.tell && news {
                tell(what, holder.as_ref());
            }
            told = Some(holder);
            std::thread::sleep(GLANCE);
        }
    }

    fn held(mut file: File, path: &Path, after: After) -> Result<Self, LockError> {
        let mut begins = Vec::new();
        let read = (&mut file).take(HEAD.len() as u64).read_to_end(&mut begins);
        read.map_err(failed(path))?;
        if !HEAD.starts_with(&begins) {
            return Err(LockError::Strange(path.to_path_buf()));
        }
        // Only a word for whoever waits; on a full disk there is none.
        let _ = introduce(&mut file);
        Ok(Self { file, path: path.to_path_buf(), after })
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        if self.after == After::Goes && cfg!(unix) && stands(&self.file, &self.path) {
            // While it is held: who waits finds another file or none, and looks again.
            let _ = fs::remove_file(&self.path);
        } else {
            let _ = self.file.set_len(0);
        }
        // Said aloud: a program that another thread has just started holds the open file, too, for a
        // moment, and with it a lock that is only closed.
        let _ = self.file.unlock();
    }
}

fn introduce(file: &mut File) -> io::Result<()> {
    let word = Holder {
        schema: SCHEMA.into(),
        pid: std::process::id(),
        host: host(),
        since: moment::written(SystemClock::default().now()),
    };
    let text = serde_json::to_vec(&word)?;
    file.rewind()?;
    file.set_len(0)?;
    file.write_all(&text)
}

fn host() -> String {
    let told = fs::read_to_string("/proc/sys/kernel/hostname").ok();
    let told = told.or_else(|| std::env::var("HOSTNAME").ok());
    let told = told.or_else(|| std::env::var("COMPUTERNAME").ok());
    told.map(|t| t.trim().to_owned()).filter(|t| !t.is_empty()).unwrap_or("this machine".into())
}

fn holder(file: File) -> Option<Holder> {
    let mut bytes = Vec::new();
    file.take(MOST).read_to_end(&mut bytes).ok()?;
    serde_json::from_slice(&bytes).ok().filter(|h: &Holder| h.schema == SCHEMA)
}

fn tell(what: &str, holder: Option<&Holder>) {
    let who = holder.map_or("another run".to_owned(), Holder::to_string);
    let line = format!("{what} is in use: waiting for {who} (--no-wait would not)\n");
    // Nobody may be listening.
    let _ = io::stderr().write_all(line.as_bytes());
}

/// Opens or creates the file; a link, a pipe or a device is none of ours.
fn open(path: &Path) -> Result<File, LockError> {
    let mut options = File::options();
    options.read(true).write(true).create(true).truncate(false);
    #[cfg(unix)]
    {
        use std::os::unix::fs::OpenOptionsExt as _;

        let flags = rustix::fs::OFlags::NOFOLLOW | rustix::fs::OFlags::NONBLOCK;
        options.custom_flags(flags.bits().cast_signed());
    }
    let is_link = || fs::symlink_metadata(path).is_ok_and(|about| about.is_symlink());
    let file = match options.open(path) {
        Err(_) if is_link() => return Err(LockError::Strange(path.to_path_buf())),
        opened => opened.map_err(failed(path))?,
    };
    let about = file.metadata().map_err(failed(path))?;
    if about.is_file() { Ok(file) } else { Err(LockError::Strange(path.to_path_buf())) }
}

/// Whether an open file is still the one of that name.
#[cfg(unix)]
fn stands(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt as _;

    let id = |about: fs::Metadata| (about.dev(), about.ino());
    let (own, there) = (file.metadata().map(id), fs::symlink_metadata(path).map(id));
    matches!((own, there), (Ok(own), Ok(there)) if own == there)
}

#[cfg(not(unix))]
fn stands(_: &File, _: &Path) -> bool {
    true
}

fn failed(path: &Path) -> impl FnOnce(io::Error) -> LockError + use<> {
    let path = path.to_path_buf();
    move |source| LockError::Io { path, source }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU32, Ordering};

    use super::*;

    const WAIT: Turns = Turns { wait: true, tell: false };

    #[test]
    fn one_at_a_time_holds_it_and_the_last_takes_the_file_away() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join(".out.lock");
        let (inside, most) = (AtomicU32::new(0), AtomicU32::new(0));
        std::thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| {
                    let _lock = Lock::take(&path, After::Goes, WAIT, "out").unwrap();
                    most.fetch_max(inside.fetch_add(1, Ordering::SeqCst) + 1, Ordering::SeqCst);
                    std::thread::sleep(Duration::from_millis(2));
                    inside.fetch_sub(1, Ordering::SeqCst);
                });
            }
        });
        assert_eq!(most.into_inner(), 1);
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 0);
    }

    #[test]
    fn who_is_not_to_wait_is_told_who_has_it() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("lock");
        let first = Lock::take(&path, After::Stays, Turns::AT_ONCE, "state").unwrap();
        let refused = Lock::take(&path, After::Stays, Turns::AT_ONCE, "state").unwrap_err();
        let expected = format!("is in use by process {} on ", std::process::id());
        assert!(refused.to_string().starts_with(&expected), "{refused}");
        drop(first);
        Lock::take(&path, After::Stays, Turns::AT_ONCE, "state").unwrap();
    }

    #[test]
    fn a_file_that_we_did_not_write_is_left_as_it_is() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join(".out.lock");
        fs::write(&path, "mine").unwrap();
        let refused = Lock::take(&path, After::Goes, WAIT, "out").unwrap_err();
        assert!(matches!(refused, LockError::Strange(_)), "{refused}");
        assert_eq!(fs::read_to_string(&path).unwrap(), "mine");
        #[cfg(unix)]
        {
            let link = dir.path().join("link.lock");
            std::os::unix::fs::symlink(&path, &link).unwrap();
            let refused = Lock::take(&link, After::Goes, WAIT, "out").unwrap_err();
            assert!(matches!(refused, LockError::Strange(_)), "{refused}");
        }
    }
}
