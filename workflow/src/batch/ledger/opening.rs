//! Opens ledgers: to write, to look, or to be gone again.

use std::io::ErrorKind;
use std::path::Path;
use std::sync::Mutex;
use std::time::Duration;

use runner::ours::looking::{self, Looked};
use rusqlite::Connection;
use rusqlite::types::Value;
use trace::{Digest, Time};

use super::super::record::signed;
use super::chain;
use super::database::{ITEMS, Ledger, LedgerError, VERSION, failed, schema};

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
