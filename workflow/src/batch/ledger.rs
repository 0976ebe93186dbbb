//! The ledger of a batch: what was planned, what was asked, and what became of each item. SQLite; rows
//! are only ever added, and each names the digest of the one before it in its table.

mod ask;
mod calls;
mod chain;
mod outcomes;
mod plan;

use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard};
use std::time::Duration;

use rusqlite::Connection;
use rusqlite::types::Value;
use trace::{Digest, Time};

use super::record::{COLUMNS, Kind, signed};
use crate::ours::looking::{self, Looked};
pub use ask::AskError;
pub use calls::{Call, Sent};
pub use plan::{Planned, Settled, Standing};

/// Name of the ledger in its folder.
pub const FILE: &str = "ledger.sqlite";
/// Version of the tables; in version 1, of kinfold 0.1.0, outcomes alone were chained.
const VERSION: i64 = 2;

/// The latest outcome of each item.
const ITEMS: &str = "SELECT o.* FROM outcomes o
            WHERE o.n = (SELECT max(n) FROM outcomes l WHERE l.id = o.id)
            AND o.outcome <> 'reopened'";

/// The ledger of a batch, shared by everybody who works on it.
#[derive(Debug)]
pub struct Ledger {
    db: Mutex<Connection>,
    /// Where it is looked at and had to be copied for that.
    _copy: Option<tempfile::TempDir>,
}

/// Why the ledger could not do its work.
#[derive(Debug, thiserror::Error)]
#[error("{}: cannot {doing} the ledger: {source}", path.display())]
pub struct LedgerError {
    /// What was tried.
    pub doing: &'static str,
    /// The file.
    pub path: PathBuf,
    /// What SQLite said.
    pub source: rusqlite::Error,
}

fn schema() -> String {
    let columns: Vec<_> =
        COLUMNS.iter().map(|(name, kind)| format!("{name} {}", kind.sql())).collect();
    let columns = columns.join(", ");
    let guard = |table: &str, verb: &str| {
        format!(
            "CREATE TRIGGER IF NOT EXISTS {table}_keep_{verb} BEFORE {verb} ON {table}
             BEGIN SELECT RAISE(ABORT, 'the ledger is only added to'); END;"
        )
    };
    let guards: String = ["outcomes", "calls", "runs", "planned", "bad_lines"]
        .iter()
        .flat_map(|table| ["UPDATE", "DELETE"].map(|verb| guard(table, verb)))
        .chain([guard("plans", "DELETE"), guard("heads", "DELETE")])
        .collect();
    let chained = "previous TEXT NOT NULL, digest TEXT NOT NULL";
    format!(
        "CREATE TABLE IF NOT EXISTS heads (
            name TEXT PRIMARY KEY, rows INTEGER NOT NULL, digest TEXT NOT NULL,
            unchained INTEGER NOT NULL);
         CREATE TABLE IF NOT EXISTS runs (
            run INTEGER PRIMARY KEY, version TEXT NOT NULL, settings TEXT NOT NULL,
            words TEXT NOT NULL, at_ns INTEGER NOT NULL, {chained});
         CREATE TABLE IF NOT EXISTS plans (
            plan INTEGER PRIMARY KEY, manifest TEXT NOT NULL, whole INTEGER NOT NULL DEFAULT 0,
            {chained});
         CREATE TABLE IF NOT EXISTS planned (
            n INTEGER PRIMARY KEY, id TEXT NOT NULL, line INTEGER NOT NULL, spec TEXT NOT NULL,
            question TEXT NOT NULL, plan INTEGER NOT NULL, {chained}, UNIQUE (plan, id));
         CREATE TABLE IF NOT EXISTS bad_lines (
            n INTEGER PRIMARY KEY, plan INTEGER NOT NULL, line INTEGER NOT NULL, why TEXT NOT NULL,
            {chained});
         CREATE TABLE IF NOT EXISTS outcomes (
            n INTEGER PRIMARY KEY, run INTEGER NOT NULL, question TEXT NOT NULL,
            settings TEXT NOT NULL, final INTEGER NOT NULL, {columns},
            facts TEXT NOT NULL, previous TEXT NOT NULL, digest TEXT NOT NULL);
         CREATE INDEX IF NOT EXISTS outcomes_by_id ON outcomes (id, n);
         CREATE TABLE IF NOT EXISTS calls (
            n INTEGER PRIMARY KEY, run INTEGER NOT NULL, id TEXT NOT NULL, stage TEXT NOT NULL,
            step TEXT, question TEXT, settles INTEGER, fate TEXT NOT NULL, cost REAL,
            input INTEGER, output INTEGER, credits REAL, at_ns INTEGER NOT NULL, {chained});
         CREATE INDEX IF NOT EXISTS calls_by_id ON calls (id, stage);
         CREATE INDEX IF NOT EXISTS calls_by_settled ON calls (settles);
         {guards}
         CREATE VIEW IF NOT EXISTS items AS {ITEMS};
         PRAGMA user_version = {VERSION};"
    )
}

impl Kind {
    fn sql(self) -> &'static str {
        match self {
            Self::Text => "TEXT",
            Self::Integer => "INTEGER",
            Self::Real => "REAL",
        }
    }
}

/// An error of this ledger.
fn failed<'a>(
    path: &'a Path,
    doing: &'static str,
) -> impl FnOnce(rusqlite::Error) -> LedgerError + 'a {
    move |source| LedgerError { doing, path: path.to_path_buf(), source }
}

impl Ledger {
    /// Opens or creates a ledger: write-ahead log, every outcome synced.
    ///
    /// # Errors
    /// [`LedgerError`] when the disk refuses, or the file is of another kind or version.
    pub fn open(path: &Path) -> Result<Self, LedgerError> {
        let db = Connection::open(path).map_err(failed(path, "open"))?;
        db.busy_timeout(Duration::from_secs(5)).map_err(failed(path, "set up"))?;
        let version = check_version(&db, path)?;
        let set_up = "PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL;";
        db.execute_batch(set_up).map_err(failed(path, "set up"))?;
        let mut db = db;
        make_tables(&mut db, version).map_err(failed(path, "create tables in"))?;
        Ok(Self { db: Mutex::new(db), _copy: None })
    }

    /// A ledger that is gone when it is let go, for plans that are only looked at.
    ///
    /// # Errors
    /// [`LedgerError`] when the disk refuses.
    pub fn passing() -> Result<Self, LedgerError> {
        Self::open(Path::new(""))
    }

    /// Opens a ledger for looking only; `None` if there is none. Beside it nothing appears and
    /// nothing changes; what it calls `items` is what this program calls so, whoever made it.
    ///
    /// # Errors
    /// [`LedgerError`] when it cannot be read.
    pub fn open_to_read(path: &Path) -> Result<Option<Self>, LedgerError> {
        if std::fs::symlink_metadata(path).is_err_and(|e| e.kind() == ErrorKind::NotFound) {
            return Ok(None);
        }
        let Looked { db, copy } = looking::open(path).map_err(failed(path, "open"))?;
        check_version(&db, path)?;
        let items = format!("CREATE TEMP VIEW items AS {ITEMS}");
        db.execute_batch(&items).map_err(failed(path, "set up"))?;
        Ok(Some(Self { db: Mutex::new(db), _copy: copy }))
    }

    /// Whether a file is a ledger of a batch. Nothing is created or changed.
    pub fn is_one(path: &Path) -> bool {
        let sql = "SELECT count(*) FROM sqlite_master WHERE type = 'table'
            AND name IN ('runs', 'plans', 'planned', 'outcomes', 'calls')";
        let tables = |db: &Connection| db.query_row(sql, [], |r| r.get::<_, i64>(0));
        let looked = looking::open(path);
        looked.and_then(|looked| tables(&looked.db)).is_ok_and(|tables| tables == 5)
    }

    /// The connection; one that panicked while it held it has rolled its transaction back.
    fn db(&self) -> MutexGuard<'_, Connection> {
        self.db.lock().unwrap_or_else(|e| e.into_inner())
    }

    fn with<A>(
        &self,
        doing: &'static str,
        f: impl FnOnce(&mut Connection) -> rusqlite::Result<A>,
    ) -> Result<A, LedgerError> {
        let mut db = self.db();
        let done = f(&mut db);
        done.map_err(|source| {
            let path = PathBuf::from(db.path().unwrap_or(FILE));
            LedgerError { doing, path, source }
        })
    }

    /// Notes that a run begins: who, under which settings. Returns its number.
    ///
    /// # Errors
    /// [`LedgerError`] when it cannot be written.
    pub fn begin(&self, version: &str, settings: &str, at: Time) -> Result<i64, LedgerError> {
        let values = vec![
            Value::Text(version.into()),
            Value::Text(Digest::of(settings.as_bytes()).to_string()),
            Value::Text(settings.into()),
            Value::Integer(signed(at)),
        ];
        self.with("write to", |db| {
            let all = db.transaction()?;
            let run = chain::add_row(&all, "runs", values)?;
            all.commit()?;
            Ok(run)
        })
    }
}

/// Makes what is missing, and takes the rows of kinfold 0.1.0 into the chain; all or nothing.
fn make_tables(db: &mut Connection, version: i64) -> rusqlite::Result<()> {
    let all = db.transaction()?;
    if version == 1 {
        chain::set_aside(&all)?;
    }
    all.execute_batch(&schema())?;
    if version < VERSION {
        chain::begin(&all)?;
    }
    if version == 1 {
        chain::take_in(&all)?;
    }
    all.commit()
}

fn check_version(db: &Connection, path: &Path) -> Result<i64, LedgerError> {
    let version = db.query_row("PRAGMA user_version", [], |r| r.get::<_, i64>(0));
    let version = version.map_err(failed(path, "read"))?;
    if version <= VERSION {
        return Ok(version);
    }
    let found = format!("it has version {version}, this program knows version {VERSION}");
    Err(failed(path, "open")(rusqlite::Error::ToSqlConversionFailure(found.into())))
}

fn foreign(column: usize, found: String) -> rusqlite::Error {
    rusqlite::Error::FromSqlConversionFailure(column, rusqlite::types::Type::Text, found.into())
}

fn digest(row: &rusqlite::Row<'_>, column: usize) -> rusqlite::Result<Digest> {
    let text: String = row.get(column)?;
    Digest::parse(&text).ok_or_else(|| foreign(column, format!("`{text}` is no digest")))
}

#[cfg(test)]
mod tests;
