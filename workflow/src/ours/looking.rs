//! SQLite files that are only looked at: nothing is created beside them.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use rusqlite::{Connection, OpenFlags};

/// How long another process is waited for that is writing.
const PATIENCE: Duration = Duration::from_secs(5);

/// A database that is only read, with what it takes to read it.
#[derive(Debug)]
pub struct Looked {
    /// The connection.
    pub db: Connection,
    /// A copy of it, where one was needed; gone when this is let go.
    pub copy: Option<tempfile::TempDir>,
}

/// Opens a database to read. What it says stands in its file, or also in the log beside it, which
/// whoever was killed or is at work leaves there. SQLite would create an index of the log: where
/// there is none, log and file are read from a copy.
///
/// # Errors
/// What SQLite or the disk says.
pub fn open(path: &Path) -> rusqlite::Result<Looked> {
    let beside = |suffix: &str| {
        let mut name = path.as_os_str().to_owned();
        name.push(suffix);
        PathBuf::from(name)
    };
    let (log, index) = (beside("-wal"), beside("-shm"));
    let has_log = fs::symlink_metadata(&log).is_ok_and(|about| about.len() > 0);
    if !has_log {
        return Ok(Looked { db: read(path, "?immutable=1")?, copy: None });
    }
    if fs::symlink_metadata(&index).is_ok() {
        return Ok(Looked { db: read(path, "?mode=ro")?, copy: None });
    }
    let copy = tempfile::tempdir().map_err(failed)?;
    let place = copy.path().join("copy.sqlite");
    fs::copy(path, &place).map_err(failed)?;
    fs::copy(&log, copy.path().join("copy.sqlite-wal")).map_err(failed)?;
    Ok(Looked { db: read(&place, "?mode=ro")?, copy: Some(copy) })
}

fn read(path: &Path, how: &str) -> rusqlite::Result<Connection> {
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY
        | OpenFlags::SQLITE_OPEN_NO_MUTEX
        | OpenFlags::SQLITE_OPEN_URI;
    let address = format!("{}{how}", address(path)?);
    let db = Connection::open_with_flags(address, flags)?;
    db.busy_timeout(PATIENCE)?;
    Ok(db)
}

/// The path as an address in which no letter means anything.
fn address(path: &Path) -> rusqlite::Result<String> {
    let whole = std::path::absolute(path).map_err(failed)?;
    let text = whole.to_str().ok_or_else(|| rusqlite::Error::InvalidPath(whole.clone()))?;
    let plain = |b: u8| b.is_ascii_alphanumeric() || b"/-._~".contains(&b);
    let escaped = |b: u8| if plain(b) { char::from(b).to_string() } else { format!("%{b:02X}") };
    Ok(format!("file://{}", text.bytes().map(escaped).collect::<String>()))
}

fn failed(error: std::io::Error) -> rusqlite::Error {
    rusqlite::Error::ToSqlConversionFailure(error.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<_> =
            entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
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
            fs::copy(dir.path().join(&name), killed.path().join(&name)).unwrap();
            if !name.ends_with("-shm") {
                fs::copy(dir.path().join(&name), sent.path().join(&name)).unwrap();
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
