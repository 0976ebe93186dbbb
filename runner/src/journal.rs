//! The run record: which key gave which result, and what every run did. SQLite, one row per fact.
//!
//! ```
//! use runner::journal::Journal;
//! use trace::Digest;
//!
//! let dir = tempfile::tempdir()?;
//! let path = dir.path().join("run.sqlite");
//! let journal = Journal::open(&path)?;
//! assert_eq!(journal.begin("shout", "1", 7)?, 1);
//! assert_eq!(journal.recall(&Digest::of(b"a key"))?, None);
//! assert!(Journal::is_one(&path));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::{Mutex, MutexGuard};
use std::time::Duration;

use rusqlite::{Connection, OptionalExtension, params};
use trace::{Digest, Time};

use super::artefact::Note;
use super::key::Material;
use super::ours::looking::{self, Looked};

/// How many earlier results of a stage a plan compares with.
const COMPARED: u32 = 1000;

/// The journal of a state directory, shared by every run of a process.
///
/// What a result rests on is synced when it is committed; what is told besides (an attempt began, a
/// result was recalled) is written at once and synced with the next result: a kill loses none of
/// it, a power cut at most the last words.
#[derive(Debug)]
pub struct Journal {
    db: Mutex<Connection>,
    /// Where it is looked at and had to be copied for that.
    _copy: Option<tempfile::TempDir>,
}

/// Why the journal could not do its work.
#[derive(Debug, thiserror::Error)]
#[error("run record: cannot {doing}: {source}")]
pub struct JournalError {
    /// What was tried.
    pub doing: &'static str,
    /// What SQLite said.
    pub source: rusqlite::Error,
}

/// A result that was committed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Committed {
    /// Digest of the artefact.
    pub output: Digest,
    /// Its losses and doubts.
    pub notes: Vec<Note>,
}

/// What a run did with a stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Did {
    /// An attempt began.
    Started,
    /// The result was committed.
    Finished,
    /// The result was there already.
    Recalled,
    /// An attempt failed and another follows.
    Retried,
    /// The stage gave up.
    Failed,
    /// The blob of a committed result was missing or damaged.
    Lost,
}

impl Did {
    fn word(self) -> &'static str {
        match self {
            Self::Started => "started",
            Self::Finished => "finished",
            Self::Recalled => "recalled",
            Self::Retried => "retried",
            Self::Failed => "failed",
            Self::Lost => "lost",
        }
    }
}

/// A line of the record.
#[derive(Clone, Debug)]
pub struct Line<'a> {
    /// The run.
    pub run: i64,
    /// The stage.
    pub stage: &'a str,
    /// The key of its result.
    pub key: &'a Digest,
    /// What happened.
    pub did: Did,
    /// A word about it: the error, or nothing.
    pub word: &'a str,
    /// When.
    pub at: Time,
}

const SCHEMA: &str = "
    CREATE TABLE IF NOT EXISTS runs (
        id INTEGER PRIMARY KEY, flow TEXT NOT NULL, version TEXT NOT NULL,
        started_ns INTEGER NOT NULL, ended_ns INTEGER, outcome TEXT);
    CREATE TABLE IF NOT EXISTS results (
        key TEXT PRIMARY KEY, stage TEXT NOT NULL, material TEXT NOT NULL, output TEXT NOT NULL,
        bytes INTEGER NOT NULL, notes TEXT NOT NULL, run INTEGER NOT NULL, at_ns INTEGER NOT NULL);
    CREATE INDEX IF NOT EXISTS results_by_stage ON results (stage, at_ns);
    CREATE TABLE IF NOT EXISTS events (
        id INTEGER PRIMARY KEY, run INTEGER NOT NULL, stage TEXT NOT NULL, key TEXT NOT NULL,
        did TEXT NOT NULL, word TEXT NOT NULL, at_ns INTEGER NOT NULL);
    CREATE INDEX IF NOT EXISTS events_by_key ON events (key, at_ns);
    CREATE VIEW IF NOT EXISTS repeated AS
        SELECT stage, key, count(*) AS times FROM events WHERE did = 'finished'
        GROUP BY key HAVING count(*) > 1;
    PRAGMA user_version = 1;";

fn failed(doing: &'static str) -> impl FnOnce(rusqlite::Error) -> JournalError {
    move |source| JournalError { doing, source }
}

/// SQLite has no unsigned integers; times after the year 2262 are cut.
fn signed(at: Time) -> i64 {
    i64::try_from(at).unwrap_or(i64::MAX)
}

impl Journal {
    /// Opens or creates the record: write-ahead log, every commit synced.
    ///
    /// # Errors
    /// [`JournalError`] when the disk refuses or the file is of another kind or version.
    pub fn open(path: &Path) -> Result<Self, JournalError> {
        let db = Connection::open(path).map_err(failed("open"))?;
        db.busy_timeout(Duration::from_secs(5)).map_err(failed("set up"))?;
        check_version(&db)?;
        let set_up = "PRAGMA journal_mode = WAL; PRAGMA synchronous = NORMAL;";
        db.execute_batch(set_up).map_err(failed("set up"))?;
        db.execute_batch(SCHEMA).map_err(failed("create tables in"))?;
        Ok(Self { db: Mutex::new(db), _copy: None })
    }

    /// Opens the record for looking only. Beside it nothing appears and nothing changes.
    ///
    /// # Errors
    /// [`JournalError`] when there is none.
    pub fn open_to_read(path: &Path) -> Result<Self, JournalError> {
        let Looked { db, copy } = looking::open(path).map_err(failed("open"))?;
        check_version(&db)?;
        Ok(Self { db: Mutex::new(db), _copy: copy })
    }

    /// Whether a file is a run record of ours. Nothing is created or changed.
    pub fn is_one(path: &Path) -> bool {
        let sql = "SELECT count(*) FROM sqlite_master WHERE type = 'table'
            AND name IN ('runs', 'results', 'events')";
        let tables = |db: &Connection| db.query_row(sql, [], |r| r.get::<_, i64>(0));
        let looked = looking::open(path);
        looked.and_then(|looked| tables(&looked.db)).is_ok_and(|tables| tables == 3)
    }

    /// The connection; one that panicked while it held it has rolled its transaction back.
    fn db(&self) -> MutexGuard<'_, Connection> {
        self.db.lock().unwrap_or_else(|e| e.into_inner())
    }

    /// Notes that a run begins; returns its number.
    ///
    /// # Errors
    /// [`JournalError`] when it cannot be written.
    pub fn begin(&self, flow: &str, version: &str, at: Time) -> Result<i64, JournalError> {
        let sql = "INSERT INTO runs (flow, version, started_ns) VALUES (?1, ?2, ?3)";
        let db = self.db();
        db.execute(sql, params![flow, version, signed(at)]).map_err(failed("write"))?;
        Ok(db.last_insert_rowid())
    }

    /// Notes how a run ended.
    ///
    /// # Errors
    /// [`JournalError`] when it cannot be written.
    pub fn end(&self, run: i64, outcome: &str, at: Time) -> Result<(), JournalError> {
        let sql = "UPDATE runs SET ended_ns = ?2, outcome = ?3 WHERE id = ?1";
        self.db().execute(sql, params![run, signed(at), outcome]).map_err(failed("write"))?;
        Ok(())
    }

    /// Notes what happened.
    ///
    /// # Errors
    /// [`JournalError`] when it cannot be written.
    pub fn write(&self, line: &Line<'_>) -> Result<(), JournalError> {
        write_line(&self.db(), line).map_err(failed("write"))
    }

    /// Commits a result whose bytes are in the store already: the row and its event, or neither.
    ///
    /// # Errors
    /// [`JournalError`] when it cannot be written.
    pub fn commit(
        &self,
        line: &Line<'_>,
        material: &Material,
        result: &Committed,
        bytes: usize,
    ) -> Result<(), JournalError> {
        let notes = serde_json::to_string(&result.notes).unwrap_or_default();
        let sql = "INSERT OR REPLACE INTO results VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)";
        let (key, output) = (line.key.as_str(), result.output.as_str());
        let bytes = i64::try_from(bytes).unwrap_or(i64::MAX);
        let mut db = self.db();
        let mut all = || {
            db.execute_batch("PRAGMA synchronous = FULL")?;
            let both = db.transaction()?;
            let text = material.canonical();
            let at = signed(line.at);
            both.execute(sql, params![key, line.stage, text, output, bytes, notes, line.run, at])?;
            write_line(&both, line)?;
            both.commit()
        };
        let committed = all().map_err(failed("commit to"));
        db.execute_batch("PRAGMA synchronous = NORMAL").map_err(failed("set up"))?;
        committed
    }

    /// The result committed under a key.
    ///
    /// # Errors
    /// [`JournalError`] when it cannot be read.
    pub fn recall(&self, key: &Digest) -> Result<Option<Committed>, JournalError> {
        let sql = "SELECT output, notes FROM results WHERE key = ?1";
        let row = |r: &rusqlite::Row<'_>| Ok((r.get::<_, String>(0)?, r.get::<_, String>(1)?));
        let found = self.db().query_row(sql, [key.as_str()], row).optional();
        let found = found.map_err(failed("read"))?;
        Ok(found.and_then(|(output, notes)| {
            let notes = serde_json::from_str(&notes).ok()?;
            Some(Committed { output: Digest::parse(&output)?, notes })
        }))
    }

    /// What earlier results of a stage were made of, newest first.
    ///
    /// # Errors
    /// [`JournalError`] when it cannot be read.
    pub fn materials(&self, stage: &str) -> Result<Vec<Material>, JournalError> {
        let sql = "SELECT material FROM results WHERE stage = ?1 ORDER BY at_ns DESC, rowid DESC LIMIT ?2";
        let db = self.db();
        let mut query = db.prepare(sql).map_err(failed("read"))?;
        let rows = query.query_map(params![stage, COMPARED], |r| r.get::<_, String>(0));
        let texts: Result<Vec<_>, _> = rows.map_err(failed("read"))?.collect();
        let texts = texts.map_err(failed("read"))?;
        Ok(texts.iter().filter_map(|t| serde_json::from_str(t).ok()).collect())
    }

    /// Keys of results that were made before a moment, not used since, and whose bytes are not
    /// `named`.
    ///
    /// # Errors
    /// [`JournalError`] when it cannot be read.
    pub fn stale(
        &self,
        before: Time,
        named: &BTreeSet<Digest>,
    ) -> Result<BTreeSet<String>, JournalError> {
        let sql = "SELECT key, output FROM results r WHERE at_ns < ?1 AND NOT EXISTS (
            SELECT 1 FROM events e WHERE e.key = r.key AND e.at_ns >= ?1)";
        let db = self.db();
        let mut query = db.prepare(sql).map_err(failed("read"))?;
        let row = |r: &rusqlite::Row<'_>| Ok((r.get::<_, String>(0)?, r.get::<_, String>(1)?));
        let rows = query.query_map([signed(before)], row).map_err(failed("read"))?;
        let rows: Vec<_> = rows.collect::<Result<_, _>>().map_err(failed("read"))?;
        let is_named = |output: &str| Digest::parse(output).is_some_and(|d| named.contains(&d));
        Ok(rows.into_iter().filter(|(_, o)| !is_named(o)).map(|(key, _)| key).collect())
    }

    /// Digests that results name, as output or as input, except those under some keys.
    ///
    /// # Errors
    /// [`JournalError`] when it cannot be read.
    pub fn named_except(&self, keys: &BTreeSet<String>) -> Result<BTreeSet<Digest>, JournalError> {
        let db = self.db();
        let sql = "SELECT key, output, material FROM results";
        let mut query = db.prepare(sql).map_err(failed("read"))?;
        let mut rows = query.query([]).map_err(failed("read"))?;
        let mut named = BTreeSet::new();
        while let Some(row) = rows.next().map_err(failed("read"))? {
            let text = |n: usize| row.get::<_, String>(n).map_err(failed("read"));
            if keys.contains(&text(0)?) {
                continue;
            }
            named.extend(Digest::parse(&text(1)?));
            let material = serde_json::from_str::<Material>(&text(2)?);
            named.extend(material.into_iter().flat_map(|m| m.inputs).map(|i| i.digest));
        }
        Ok(named)
    }

    /// Digests of all committed artefacts.
    ///
    /// # Errors
    /// [`JournalError`] when it cannot be read.
    pub fn outputs(&self) -> Result<BTreeSet<Digest>, JournalError> {
        let db = self.db();
        let mut query = db.prepare("SELECT output FROM results").map_err(failed("read"))?;
        let rows = query.query_map([], |r| r.get::<_, String>(0)).map_err(failed("read"))?;
        let texts: Vec<_> = rows.collect::<Result<_, _>>().map_err(failed("read"))?;
        Ok(texts.iter().filter_map(|t| Digest::parse(t)).collect())
    }

    /// Forgets the results under some keys, all or none.
    ///
    /// # Errors
    /// [`JournalError`] when it cannot be written.
    pub fn forget(&self, keys: &BTreeSet<String>) -> Result<(), JournalError> {
        let mut db = self.db();
        let mut all = || {
            let all = db.transaction()?;
            for key in keys {
                all.execute("DELETE FROM results WHERE key = ?1", [key])?;
            }
            all.commit()
        };
        all().map_err(failed("write"))
    }

    /// How often each (stage, word) stands in the record, such as `("articulate", "finished")`.
    ///
    /// # Errors
    /// [`JournalError`] when it cannot be read.
    pub fn counts(&self) -> Result<Vec<(String, String, u64)>, JournalError> {
        let sql = "SELECT stage, did, count(*) FROM events GROUP BY stage, did ORDER BY stage, did";
        let db = self.db();
        let mut query = db.prepare(sql).map_err(failed("read"))?;
        let row = |r: &rusqlite::Row<'_>| Ok((r.get(0)?, r.get(1)?, r.get::<_, i64>(2)? as u64));
        let rows = query.query_map([], row).map_err(failed("read"))?;
        rows.collect::<Result<_, _>>().map_err(failed("read"))
    }
}

fn check_version(db: &Connection) -> Result<(), JournalError> {
    let version = db.query_row("PRAGMA user_version", [], |r| r.get::<_, i64>(0));
    let version = version.map_err(failed("read"))?;
    if version <= 1 {
        return Ok(());
    }
    let found = format!("it has version {version}, this program knows version 1");
    let source = rusqlite::Error::ToSqlConversionFailure(found.into());
    Err(JournalError { doing: "open", source })
}

fn write_line(db: &Connection, line: &Line<'_>) -> rusqlite::Result<()> {
    let sql =
        "INSERT INTO events (run, stage, key, did, word, at_ns) VALUES (?1, ?2, ?3, ?4, ?5, ?6)";
    let key = line.key.as_str();
    let at = signed(line.at);
    db.execute(sql, params![line.run, line.stage, key, line.did.word(), line.word, at]).map(drop)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::Value;

    fn material(code: &str) -> Material {
        let (stage, code) = ("upper".into(), code.into());
        Material { stage, code, params: Value::Null, seed: None, identity: None, inputs: vec![] }
    }

    fn commit(journal: &Journal, code: &str, at: Time) -> Digest {
        let material = material(code);
        let key = material.key();
        let notes = vec![Note { message: "part `lid` got no face".into(), loss: true }];
        let result = Committed { output: Digest::of(code.as_bytes()), notes };
        let line = Line { run: 1, stage: "upper", key: &key, did: Did::Finished, word: "", at };
        journal.commit(&line, &material, &result, 3).unwrap();
        key
    }

    #[test]
    fn a_committed_result_is_recalled_with_its_notes_after_reopening() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("run.sqlite");
        let journal = Journal::open(&path).unwrap();
        let key = commit(&journal, "1", 5);
        drop(journal);
        let journal = Journal::open_to_read(&path).unwrap();
        let found = journal.recall(&key).unwrap().unwrap();
        assert_eq!(found.output, Digest::of(b"1"));
        assert!(found.notes[0].loss);
        assert_eq!(journal.recall(&Digest::of(b"no key")).unwrap(), None);
        assert_eq!(journal.counts().unwrap(), [("upper".into(), "finished".into(), 1)]);
    }

    #[test]
    fn materials_come_newest_first() {
        let dir = tempfile::tempdir().unwrap();
        let journal = Journal::open(&dir.path().join("run.sqlite")).unwrap();
        for (code, at) in [("old", 1), ("new", 9), ("middle", 5)] {
            commit(&journal, code, at);
        }
        let codes: Vec<_> =
            journal.materials("upper").unwrap().into_iter().map(|m| m.code).collect();
        assert_eq!(codes, ["new", "middle", "old"]);
    }

    #[test]
    fn a_file_that_is_no_record_is_refused() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("run.sqlite");
        std::fs::write(&path, "not a database at all, but long enough to be looked at").unwrap();
        assert!(Journal::open(&path).unwrap_err().to_string().starts_with("run record: cannot"));
    }
}
