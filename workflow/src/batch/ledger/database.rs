//! The file of a ledger: its tables, and how they are reached.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard};

use rusqlite::Connection;
use trace::Digest;

use super::super::record::{COLUMNS, Kind};

/// Name of the ledger in its folder.
pub const FILE: &str = "ledger.sqlite";
/// Version of the tables; in version 1, of kinfold 0.1.0, outcomes alone were chained.
pub(super) const VERSION: i64 = 2;

/// The latest outcome of each item, with what of its facts is asked for by name.
pub(super) const ITEMS: &str = "SELECT o.*, json_extract(o.facts, '$.confidence') AS confidence
            FROM outcomes o
            WHERE o.n = (SELECT max(n) FROM outcomes l WHERE l.id = o.id)
            AND o.outcome <> 'reopened'";

/// The ledger of a batch, shared by everybody who works on it.
#[derive(Debug)]
pub struct Ledger {
    pub(super) db: Mutex<Connection>,
    /// Where it is looked at and had to be copied for that.
    pub(super) _copy: Option<tempfile::TempDir>,
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

pub(super) fn schema() -> String {
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
         DROP VIEW IF EXISTS items;
         CREATE VIEW items AS {ITEMS};
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
pub(super) fn failed<'a>(
    path: &'a Path,
    doing: &'static str,
) -> impl FnOnce(rusqlite::Error) -> LedgerError + 'a {
    move |source| LedgerError { doing, path: path.to_path_buf(), source }
}

impl Ledger {
    /// The connection; one that panicked while it held it has rolled its transaction back.
    pub(super) fn db(&self) -> MutexGuard<'_, Connection> {
        self.db.lock().unwrap_or_else(|e| e.into_inner())
    }

    pub(super) fn with<A>(
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
}

pub(super) fn foreign(column: usize, found: String) -> rusqlite::Error {
    rusqlite::Error::FromSqlConversionFailure(column, rusqlite::types::Type::Text, found.into())
}

pub(super) fn digest(row: &rusqlite::Row<'_>, column: usize) -> rusqlite::Result<Digest> {
    let text: String = row.get(column)?;
    Digest::parse(&text).ok_or_else(|| foreign(column, format!("`{text}` is no digest")))
}
