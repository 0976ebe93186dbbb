//! Databases that are looked at, whoever sent them: nothing is written beside them, nothing in them
//! acts.
//!
//! ```
//! use runner::journal::Journal;
//! use runner::ours::looking;
//!
//! let dir = tempfile::tempdir()?;
//! let path = dir.path().join("run.sqlite");
//! drop(Journal::open(&path)?);
//! let looked = looking::open(&path)?;
//! let runs: i64 = looked.db.query_row("SELECT count(*) FROM runs", [], |row| row.get(0))?;
//! assert_eq!(runs, 0);
//! assert!(looked.db.execute("DELETE FROM runs", []).is_err());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::io::Read as _;
use std::path::Path;
use std::time::{Duration, Instant};

use guard::files::Refused;
use guard::folder::{Caps, Folder};
use rusqlite::config::DbConfig;
use rusqlite::{Connection, Error, OpenFlags};
use tempfile::TempDir;

use super::scratch;

/// Most bytes of a database (64 GiB), and of its write-ahead log (1 GiB), which has to be copied:
/// a million items take 3 GiB, a log that is merged as usual 4 MiB.
const MOST: u64 = 64 << 30;
const MOST_LOG: u64 = 1 << 30;
/// How often a database is copied anew that was written to meanwhile.
const TRIES: u32 = 20;
/// Length of a log's head, which changes whenever the log begins anew, bytes (SQLite's file format).
const HEAD: usize = 32;

/// An open database, and the copy that it is, if it is one.
#[derive(Debug)]
pub struct Looked {
    /// The database.
    pub db: Connection,
    /// Goes with it.
    pub copy: Option<TempDir>,
}

/// Opens a database for looking only. Beside it nothing changes, no log and no index of one
/// appears; what a writer has not merged yet is seen, in a copy. Views and triggers of its own are
/// switched off.
///
/// # Errors
/// What SQLite says, or that the file is none that is read.
pub fn open(path: &Path) -> Result<Looked, Error> {
    let name = path.file_name().map(Path::new).ok_or_else(|| wrapped(Refused::NotRegular))?;
    let parent = path.parent().unwrap_or(Path::new(""));
    let caps = Caps { file: MOST, all: MOST, ..Caps::default() };
    let folder = Folder::open(parent, caps).map_err(wrapped)?;
    let real = folder.real(name).map_err(wrapped)?;
    let mut log = name.as_os_str().to_owned();
    log.push("-wal");
    let log = Path::new(&log);
    for _ in 0..TRIES {
        let looked = match folder.file(log) {
            Err(refused) if refused.is_absence() => Some(unchanging(&real)?),
            Err(refused) => return Err(log_refused(log, &refused)),
            Ok(file) if file.length() == 0 => Some(unchanging(&real)?),
            Ok(_) => copied(&folder, name, log)?,
        };
        if let Some(looked) = looked {
            harmless(&looked.db)?;
            return Ok(looked);
        }
    }
    let found = "it is being written to all the time; look again later";
    Err(Error::ToSqlConversionFailure(found.into()))
}

/// Opens a file that nobody writes to: SQLite takes no lock and leaves no file.
fn unchanging(path: &Path) -> Result<Looked, Error> {
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"/._-".contains(&byte);
    let mut uri = String::from("file:");
    for &byte in path.as_os_str().as_encoded_bytes() {
        match byte {
            b'\\' if cfg!(windows) => uri.push('/'),
            byte if plain(byte) => uri.push(char::from(byte)),
            byte => uri.push_str(&format!("%{byte:02x}")),
        }
    }
    let flags = flags | OpenFlags::SQLITE_OPEN_URI;
    let db = Connection::open_with_flags(uri + "?immutable=1", flags)?;
    Ok(Looked { db, copy: None })
}

/// A copy of a database with its log; none if that was no moment to copy. A log that ends or begins
/// anew meanwhile may have taken pages along that the copy lacks.
fn copied(folder: &Folder, name: &Path, log: &Path) -> Result<Option<Looked>, Error> {
    let io = |e: std::io::Error| wrapped(Refused::of(e));
    let Some(before) = head(folder, log)? else { return Ok(None) };
    let copy = scratch::folder().map_err(io)?;
    let to = copy.path().join("copy.sqlite");
    for (from, to) in [(name, to.clone()), (log, copy.path().join("copy.sqlite-wal"))] {
        let mut opened = match folder.file(from) {
            Err(refused) if refused.is_absence() => return Ok(None),
            opened => opened.map_err(wrapped)?,
        };
        let mut file = std::fs::File::create(to).map_err(io)?;
        std::io::copy(&mut opened, &mut file).map_err(io)?;
    }
    if head(folder, log)?.as_ref() != Some(&before) {
        return Ok(None);
    }
    Ok(Some(Looked { db: Connection::open(&to)?, copy: Some(copy) }))
}

/// The head of a log; none if there is none any more.
fn head(folder: &Folder, log: &Path) -> Result<Option<Vec<u8>>, Error> {
    let opened = match folder.file(log) {
        Err(refused) if refused.is_absence() => return Ok(None),
        opened => opened.map_err(|why| log_refused(log, &why))?,
    };
    if opened.length() > MOST_LOG {
        return Err(log_refused(log, &Refused::TooLarge { most: MOST_LOG }));
    }
    let mut head = Vec::new();
    let read = opened.take(HEAD as u64).read_to_end(&mut head);
    read.map_err(|e| wrapped(Refused::of(e)))?;
    Ok(Some(head))
}

fn log_refused(log: &Path, why: &Refused) -> Error {
    let long = Refused::TooLarge { most: MOST_LOG };
    let why = if matches!(why, Refused::TooLarge { .. }) { &long } else { why };
    Error::ToSqlConversionFailure(format!("its log {} {why}", log.display()).into())
}

fn wrapped(refused: Refused) -> Error {
    Error::ToSqlConversionFailure(Box::new(refused))
}

/// Switches off whatever a database can bring along that acts (SQLite, "Defense Against The Dark
/// Arts"), and keeps everything in memory that it would put into temporary files.
fn harmless(db: &Connection) -> Result<(), Error> {
    db.set_db_config(DbConfig::SQLITE_DBCONFIG_DEFENSIVE, true)?;
    for off in [
        DbConfig::SQLITE_DBCONFIG_TRUSTED_SCHEMA,
        DbConfig::SQLITE_DBCONFIG_ENABLE_TRIGGER,
        DbConfig::SQLITE_DBCONFIG_ENABLE_VIEW,
        DbConfig::SQLITE_DBCONFIG_ENABLE_FTS3_TOKENIZER,
        DbConfig::SQLITE_DBCONFIG_ENABLE_ATTACH_CREATE,
        DbConfig::SQLITE_DBCONFIG_ENABLE_ATTACH_WRITE,
        DbConfig::SQLITE_DBCONFIG_WRITABLE_SCHEMA,
    ] {
        db.set_db_config(off, false)?;
    }
    db.execute_batch(
        "PRAGMA temp_store = MEMORY; PRAGMA cell_size_check = ON; PRAGMA mmap_size = 0;",
    )
}

/// Lets everything asked of a database end by then.
///
/// # Errors
/// What SQLite says.
pub fn end_by(db: &mut Connection, longest: Duration) -> Result<(), Error> {
    /// Steps of SQLite's machine between two looks at the clock: some tenths of a millisecond.
    const STEPS: i32 = 10_000;
    let begun = Instant::now();
    db.progress_handler(STEPS, Some(move || begun.elapsed() > longest))
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on stops")]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let name = |e: std::io::Result<std::fs::DirEntry>| e.unwrap().file_name().into_string();
        let mut names: Vec<_> =
            std::fs::read_dir(folder).unwrap().map(|e| name(e).unwrap()).collect();
        names.sort();
        names
    }

    fn count(db: &Connection) -> i64 {
        db.query_row("SELECT count(*) FROM t", [], |r| r.get(0)).unwrap()
    }

    #[test]
    fn what_is_only_in_the_log_is_seen_and_nothing_appears_beside() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a b?#%.sqlite");
        let writer = Connection::open(&path).unwrap();
        writer
            .execute_batch(
                "PRAGMA journal_mode = WAL; CREATE TABLE t (x); INSERT INTO t VALUES (1);",
            )
            .unwrap();
        let before = names(dir.path());
        let looked = open(&path).unwrap();
        assert_eq!((count(&looked.db), looked.copy.is_some()), (1, true));
        assert_eq!(names(dir.path()), before);
        writer.execute_batch("INSERT INTO t VALUES (2)").unwrap();
        assert_eq!(count(&looked.db), 1, "it is a copy");
        drop(writer);
        let before = names(dir.path());
        assert_eq!(before.len(), 1, "{before:?}");
        let looked = open(&path).unwrap();
        assert_eq!((count(&looked.db), looked.copy.is_some()), (2, false));
        assert!(looked.db.execute("INSERT INTO t VALUES (3)", []).is_err());
        drop(looked);
        assert_eq!(names(dir.path()), before);
    }

    #[cfg(unix)]
    #[test]
    fn a_database_or_a_log_that_is_no_file_of_the_folder_is_refused() {
        let dir = tempfile::tempdir().unwrap();
        let (inside, outside) = (dir.path().join("in"), dir.path().join("out.sqlite"));
        std::fs::create_dir(&inside).unwrap();
        Connection::open(&outside).unwrap().execute_batch("CREATE TABLE t (x)").unwrap();
        let told = |name: &str| open(&inside.join(name)).unwrap_err().to_string();
        std::os::unix::fs::symlink(&outside, inside.join("link")).unwrap();
        assert!(told("link").contains("leads out of the folder"), "{}", told("link"));
        std::fs::copy(&outside, inside.join("own")).unwrap();
        std::os::unix::fs::symlink(&outside, inside.join("own-wal")).unwrap();
        assert!(told("own").contains("own-wal leads out of the folder"), "{}", told("own"));
        assert!(
            std::process::Command::new("mkfifo").arg(inside.join("p")).status().unwrap().success()
        );
        assert!(told("p").contains("is no regular file"));
        std::fs::remove_file(inside.join("own-wal")).unwrap();
        let log = std::fs::File::create(inside.join("own-wal")).unwrap();
        log.set_len(1 << 40).unwrap();
        assert!(told("own").contains("more than 1073741824 bytes"), "{}", told("own"));
    }

    #[test]
    fn views_and_triggers_of_a_strangers_database_do_nothing() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("forged");
        let forged = "CREATE TABLE t (x); CREATE VIEW v AS SELECT * FROM t;
            CREATE TRIGGER g AFTER INSERT ON t BEGIN DELETE FROM t; END;";
        Connection::open(&path).unwrap().execute_batch(forged).unwrap();
        let looked = open(&path).unwrap();
        assert!(looked.db.prepare("SELECT * FROM v").is_err());
        let own = "CREATE TEMP VIEW v AS SELECT 7 AS seven";
        looked.db.execute_batch(own).unwrap();
        let seven: i64 = looked.db.query_row("SELECT seven FROM v", [], |r| r.get(0)).unwrap();
        assert_eq!(seven, 7);
    }

    fn written(path: &Path) -> Connection {
        let db = Connection::open(path).unwrap();
        let told = "PRAGMA journal_mode = WAL; CREATE TABLE a (n); INSERT INTO a VALUES (7);";
        db.execute_batch(told).unwrap();
        db
    }

    fn seen(path: &Path) -> i64 {
        open(path).unwrap().db.query_row("SELECT n FROM a", [], |r| r.get(0)).unwrap()
    }

    #[test]
    fn looking_creates_nothing_whoever_was_there_before() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a b?%41.sqlite");
        let db = written(&path);
        assert_eq!(seen(&path), 7, "while somebody is at work");
        // As a kill leaves it, and as it arrives when somebody sends it on.
        let (killed, sent) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        for name in names(dir.path()) {
            std::fs::copy(dir.path().join(&name), killed.path().join(&name)).unwrap();
            if !name.ends_with("-shm") {
                std::fs::copy(dir.path().join(&name), sent.path().join(&name)).unwrap();
            }
        }
        drop(db);
        for (folder, count) in [(dir.path(), 1), (killed.path(), 3), (sent.path(), 2)] {
            let before = names(folder);
            assert_eq!(before.len(), count, "{before:?}");
            assert_eq!(seen(&folder.join("a b?%41.sqlite")), 7);
            assert_eq!(names(folder), before);
        }
        assert!(open(&dir.path().join("none")).is_err());
        assert_eq!(names(dir.path()).len(), 1);
    }
}
