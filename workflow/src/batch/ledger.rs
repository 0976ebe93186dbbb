//! The ledger of a batch: what was planned and what became of each item. SQLite; outcomes and calls
//! are only ever added, and each outcome names the digest of the one before it.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard};
use std::time::Duration;

use rusqlite::types::Value;
use rusqlite::{Connection, OpenFlags, OptionalExtension as _, params, params_from_iter};
use trace::{Digest, Time};

use super::class::Class;
use super::manifest::Item;
use super::record::{COLUMNS, Kind, Record, signed};

/// Name of the ledger in its folder.
pub const FILE: &str = "ledger.sqlite";
/// Version of the tables.
const VERSION: i64 = 1;

/// The ledger of a batch, shared by everybody who works on it.
#[derive(Debug)]
pub struct Ledger {
    db: Mutex<Connection>,
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

/// An item as it stands in the plan.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Planned {
    /// Its place in the plan.
    pub n: i64,
    /// Its line in the manifest.
    pub line: u64,
    /// The item, with paths from the program's folder.
    pub item: Item,
    /// Digest of the item: another seed or photo is another question.
    pub question: Digest,
}

/// What a plan holds, and what of it is settled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Standing {
    /// Items planned.
    pub planned: u64,
    /// Lines that are no items.
    pub bad: u64,
    /// Accepted, by the latest outcome.
    pub accepted: u64,
    /// Rejected.
    pub rejected: u64,
    /// Failed for good.
    pub failed: u64,
}

/// Whose outcomes count: those under these settings, and not of classes to be tried again.
#[derive(Clone, Debug)]
pub struct Settled<'a> {
    /// The plan.
    pub plan: i64,
    /// Digest of everything that shapes every asset of the batch.
    pub settings: &'a Digest,
    /// Classes whose outcomes of earlier runs do not count.
    pub again: &'a [&'a str],
    /// This run: what it settled stays settled.
    pub run: i64,
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
    let guards: String = ["outcomes", "calls"]
        .iter()
        .flat_map(|table| ["UPDATE", "DELETE"].map(|verb| guard(table, verb)))
        .collect();
    format!(
        "CREATE TABLE IF NOT EXISTS runs (
            run INTEGER PRIMARY KEY, version TEXT NOT NULL, settings TEXT NOT NULL,
            words TEXT NOT NULL, at_ns INTEGER NOT NULL);
         CREATE TABLE IF NOT EXISTS plans (
            plan INTEGER PRIMARY KEY, manifest TEXT NOT NULL, whole INTEGER NOT NULL DEFAULT 0);
         CREATE TABLE IF NOT EXISTS planned (
            n INTEGER PRIMARY KEY, id TEXT NOT NULL UNIQUE, line INTEGER NOT NULL,
            spec TEXT NOT NULL, question TEXT NOT NULL, plan INTEGER NOT NULL);
         CREATE TABLE IF NOT EXISTS bad_lines (
            plan INTEGER NOT NULL, line INTEGER NOT NULL, why TEXT NOT NULL);
         CREATE TABLE IF NOT EXISTS outcomes (
            n INTEGER PRIMARY KEY, run INTEGER NOT NULL, question TEXT NOT NULL,
            settings TEXT NOT NULL, final INTEGER NOT NULL, {columns},
            facts TEXT NOT NULL, previous TEXT NOT NULL, digest TEXT NOT NULL);
         CREATE INDEX IF NOT EXISTS outcomes_by_id ON outcomes (id, n);
         CREATE TABLE IF NOT EXISTS calls (
            n INTEGER PRIMARY KEY, run INTEGER NOT NULL, id TEXT NOT NULL, stage TEXT NOT NULL,
            at_ns INTEGER NOT NULL);
         CREATE INDEX IF NOT EXISTS calls_by_id ON calls (id, stage);
         {guards}
         CREATE VIEW IF NOT EXISTS items AS SELECT o.* FROM outcomes o
            WHERE o.n = (SELECT max(n) FROM outcomes l WHERE l.id = o.id)
            AND o.outcome <> 'reopened';
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
        check_version(&db, path)?;
        let set_up = "PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL;";
        db.execute_batch(set_up).map_err(failed(path, "set up"))?;
        db.execute_batch(&schema()).map_err(failed(path, "create tables in"))?;
        Ok(Self { db: Mutex::new(db) })
    }

    /// A ledger that is gone when it is let go, for plans that are only looked at.
    ///
    /// # Errors
    /// [`LedgerError`] when the disk refuses.
    pub fn passing() -> Result<Self, LedgerError> {
        Self::open(Path::new(""))
    }

    /// Opens a ledger for looking only; `None` if there is none.
    ///
    /// # Errors
    /// [`LedgerError`] when it cannot be read.
    pub fn open_to_read(path: &Path) -> Result<Option<Self>, LedgerError> {
        if !path.exists() {
            return Ok(None);
        }
        let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
        let db = Connection::open_with_flags(path, flags).map_err(failed(path, "open"))?;
        db.busy_timeout(Duration::from_secs(5)).map_err(failed(path, "set up"))?;
        check_version(&db, path)?;
        Ok(Some(Self { db: Mutex::new(db) }))
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
        let sql = "INSERT INTO runs (version, settings, words, at_ns) VALUES (?1, ?2, ?3, ?4)";
        let digest = Digest::of(settings.as_bytes());
        self.with("write to", |db| {
            db.execute(sql, params![version, digest.as_str(), settings, signed(at)])?;
            Ok(db.last_insert_rowid())
        })
    }

    /// The plan of a manifest that was taken in whole; none if there is none.
    ///
    /// # Errors
    /// [`LedgerError`] when it cannot be read.
    pub fn plan_of(&self, manifest: &Digest) -> Result<Option<i64>, LedgerError> {
        let sql = "SELECT plan FROM plans WHERE manifest = ?1 AND whole
                   AND plan = (SELECT max(plan) FROM plans WHERE whole)";
        self.with("read", |db| db.query_row(sql, [manifest.as_str()], |r| r.get(0)).optional())
    }

    /// Begins a plan of a manifest.
    ///
    /// # Errors
    /// [`LedgerError`] when it cannot be written.
    pub fn begin_plan(&self, manifest: &Digest) -> Result<i64, LedgerError> {
        let sql = "INSERT INTO plans (manifest) VALUES (?1)";
        self.with("write to", |db| {
            db.execute(sql, [manifest.as_str()])?;
            Ok(db.last_insert_rowid())
        })
    }

    /// Takes some lines into a plan, all or none: items, and bad lines with their reasons.
    ///
    /// # Errors
    /// [`LedgerError`] when they cannot be written.
    pub fn take(
        &self,
        plan: i64,
        lines: &[(u64, Result<Item, String>)],
    ) -> Result<(), LedgerError> {
        self.with("write to", |db| {
            let all = db.transaction()?;
            for (number, item) in lines {
                let why = match item {
                    Ok(item) => take_item(&all, plan, *number, item)?,
                    Err(why) => Some(why.clone()),
                };
                if let Some(why) = why {
                    let sql = "INSERT INTO bad_lines VALUES (?1, ?2, ?3)";
                    all.prepare_cached(sql)?.execute(params![plan, signed(*number), why])?;
                }
            }
            all.commit()
        })
    }

    /// How many items of a plan were given no mesh, and how many no condition.
    ///
    /// # Errors
    /// [`LedgerError`] when it cannot be read.
    pub fn to_ask_for(&self, plan: i64) -> Result<(u64, u64), LedgerError> {
        let sql = "SELECT count(*) - count(spec ->> 'mesh'), count(*) - count(spec ->> 'condition')
            FROM planned WHERE plan = ?1";
        self.with("read", |db| {
            db.query_row(sql, [plan], |r| {
                Ok((r.get::<_, i64>(0)?.unsigned_abs(), r.get::<_, i64>(1)?.unsigned_abs()))
            })
        })
    }

    /// Notes that a plan is whole.
    ///
    /// # Errors
    /// [`LedgerError`] when it cannot be written.
    pub fn end_plan(&self, plan: i64) -> Result<(), LedgerError> {
        self.with("write to", |db| {
            db.execute("UPDATE plans SET whole = 1 WHERE plan = ?1", [plan]).map(drop)
        })
    }

    /// The first bad lines of a plan.
    ///
    /// # Errors
    /// [`LedgerError`] when they cannot be read.
    pub fn bad_lines(&self, plan: i64, most: u32) -> Result<Vec<(u64, String)>, LedgerError> {
        let sql = "SELECT line, why FROM bad_lines WHERE plan = ?1 ORDER BY rowid LIMIT ?2";
        self.with("read", |db| {
            let mut query = db.prepare(sql)?;
            let rows = query.query_map(params![plan, most], |r| {
                Ok((r.get::<_, i64>(0)?.unsigned_abs(), r.get(1)?))
            })?;
            rows.collect()
        })
    }

    /// The next items after place `after` that have no outcome yet, in the order of the plan.
    ///
    /// # Errors
    /// [`LedgerError`] when they cannot be read.
    pub fn pending(
        &self,
        settled: &Settled<'_>,
        after: i64,
        most: u32,
    ) -> Result<Vec<Planned>, LedgerError> {
        let sql = "SELECT p.n, p.line, p.spec, p.question FROM planned p
            WHERE p.plan = ?1 AND p.n > ?2 AND NOT EXISTS (
                SELECT 1 FROM outcomes o WHERE o.id = p.id
                AND o.n = (SELECT max(n) FROM outcomes l WHERE l.id = p.id)
                AND o.question = p.question AND o.settings = ?3 AND o.final
                AND (o.run = ?4 OR instr(?5, ',' || coalesce(o.class, '-') || ',') = 0))
            ORDER BY p.n LIMIT ?6";
        let again = format!(",{},", settled.again.join(","));
        let Settled { plan, settings, run, .. } = settled;
        self.with("read", |db| {
            let mut query = db.prepare_cached(sql)?;
            let values = params![plan, after, settings.as_str(), run, again, most];
            let rows = query.query_map(values, planned)?;
            rows.filter_map(Result::transpose).collect()
        })
    }

    /// Whether an item of another plan has an outcome here that stands.
    ///
    /// # Errors
    /// [`LedgerError`] when it cannot be read.
    pub fn is_settled(
        &self,
        planned: &Planned,
        settings: &Digest,
        again: &[Class],
    ) -> Result<bool, LedgerError> {
        let sql =
            "SELECT class FROM outcomes WHERE id = ?1 AND question = ?2 AND settings = ?3 AND final
            AND n = (SELECT max(n) FROM outcomes WHERE id = ?1)";
        let values = params![planned.item.id, planned.question.as_str(), settings.as_str()];
        let class = self.with("read", |db| {
            db.prepare_cached(sql)?.query_row(values, |r| r.get::<_, Option<String>>(0)).optional()
        })?;
        Ok(class.is_some_and(|c| !again.iter().any(|a| Some(a.name()) == c.as_deref())))
    }

    /// Mean time to compute of the items that ran whole, seconds; none if there are none.
    ///
    /// # Errors
    /// [`LedgerError`] when it cannot be read.
    pub fn mean_seconds(&self) -> Result<Option<f64>, LedgerError> {
        let sql = "SELECT avg(seconds_render_views + seconds_articulate + seconds_build_asset
            + seconds_write + seconds_check_in_sim) FROM items";
        self.with("read", |db| db.query_row(sql, [], |r| r.get(0)))
    }

    /// An item of the plan by its place.
    ///
    /// # Errors
    /// [`LedgerError`] when it cannot be read.
    pub fn planned(&self, n: i64) -> Result<Option<Planned>, LedgerError> {
        let sql = "SELECT n, line, spec, question FROM planned WHERE n = ?1";
        self.with("read", |db| Ok(db.query_row(sql, [n], planned).optional()?.flatten()))
    }

    /// Adds outcomes to the ledger, all or none, each chained to the one before it.
    ///
    /// # Errors
    /// [`LedgerError`] when they cannot be written.
    pub fn add(
        &self,
        run: i64,
        settings: &Digest,
        outcomes: &[(Digest, Record)],
    ) -> Result<(), LedgerError> {
        self.with("write to", |db| {
            let all = db.transaction()?;
            for (question, record) in outcomes {
                add_one(&all, (run, settings, question), record)?;
            }
            all.commit()
        })
    }

    /// Notes that a provider is about to be called, before it is.
    ///
    /// # Errors
    /// [`LedgerError`] when it cannot be written.
    pub fn call(&self, run: i64, id: &str, stage: &str, at: Time) -> Result<(), LedgerError> {
        let sql = "INSERT INTO calls (run, id, stage, at_ns) VALUES (?1, ?2, ?3, ?4)";
        self.with("write to", |db| {
            db.prepare_cached(sql)?.execute(params![run, id, stage, signed(at)]).map(drop)
        })
    }

    /// How often each stage's provider was called: for an item, or for all.
    ///
    /// # Errors
    /// [`LedgerError`] when it cannot be read.
    pub fn calls(&self, id: Option<&str>) -> Result<Vec<(String, u64)>, LedgerError> {
        let sql = "SELECT stage, count(*) FROM calls WHERE ?1 IS NULL OR id = ?1 GROUP BY stage";
        let of_one = "SELECT stage, count(*) FROM calls WHERE id = ?1 GROUP BY stage";
        self.with("read", |db| {
            let mut query = db.prepare_cached(if id.is_some() { of_one } else { sql })?;
            let rows =
                query.query_map([id], |r| Ok((r.get(0)?, r.get::<_, i64>(1)?.unsigned_abs())))?;
            rows.collect()
        })
    }

    /// How a plan stands.
    ///
    /// # Errors
    /// [`LedgerError`] when it cannot be read.
    pub fn standing(&self, plan: i64, settings: &Digest) -> Result<Standing, LedgerError> {
        let counts = "SELECT o.outcome, count(*) FROM planned p JOIN items o ON o.id = p.id
            WHERE p.plan = ?1 AND o.question = p.question AND o.settings = ?2 AND o.final
            GROUP BY o.outcome";
        self.with("read", |db| {
            let count = |sql: &str| {
                db.query_row(sql, [plan], |r| r.get::<_, i64>(0)).map(i64::unsigned_abs)
            };
            let mut standing = Standing {
                planned: count("SELECT count(*) FROM planned WHERE plan = ?1")?,
                bad: count("SELECT count(*) FROM bad_lines WHERE plan = ?1")?,
                ..Standing::default()
            };
            let mut query = db.prepare(counts)?;
            let mut rows = query.query(params![plan, settings.as_str()])?;
            while let Some(row) = rows.next()? {
                let times = row.get::<_, i64>(1)?.unsigned_abs();
                match row.get::<_, String>(0)?.as_str() {
                    "accepted" => standing.accepted = times,
                    "rejected" => standing.rejected = times,
                    _ => standing.failed = times,
                }
            }
            Ok(standing)
        })
    }

    /// Every latest outcome in the order of the ids, one at a time.
    ///
    /// # Errors
    /// [`LedgerError`] when it cannot be read, or whatever `each` says.
    pub fn each_item<E: From<LedgerError>>(
        &self,
        mut each: impl FnMut(Record) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut last = String::new();
        loop {
            let page = self.page(&last)?;
            let Some(end) = page.last() else { return Ok(()) };
            last.clone_from(&end.id);
            page.into_iter().try_for_each(&mut each)?;
        }
    }

    fn page(&self, after: &str) -> Result<Vec<Record>, LedgerError> {
        let sql = "SELECT facts FROM items WHERE id > ?1 ORDER BY id LIMIT 1000";
        self.with("read", |db| {
            let mut query = db.prepare_cached(sql)?;
            let rows = query.query_map([after], |r| r.get::<_, String>(0))?;
            let parse = |text: rusqlite::Result<String>| {
                serde_json::from_str(&text?).map_err(|e| foreign(0, e.to_string()))
            };
            rows.map(parse).collect()
        })
    }

    /// Whether an item ever had an outcome.
    ///
    /// # Errors
    /// [`LedgerError`] when it cannot be read.
    pub fn knows(&self, id: &str) -> Result<bool, LedgerError> {
        let sql = "SELECT EXISTS (SELECT 1 FROM outcomes WHERE id = ?1)";
        self.with("read", |db| db.prepare_cached(sql)?.query_row([id], |r| r.get(0)))
    }

    /// Digests of everything any outcome rests on, latest or not.
    ///
    /// # Errors
    /// [`LedgerError`] when it cannot be read.
    pub fn named(&self) -> Result<BTreeSet<Digest>, LedgerError> {
        let sql = "SELECT DISTINCT a.value FROM outcomes, json_each(facts, '$.artefacts') a";
        self.with("read", |db| {
            let mut query = db.prepare(sql)?;
            let mut rows = query.query([])?;
            let mut named = BTreeSet::new();
            while let Some(row) = rows.next()? {
                named.extend(Digest::parse(&row.get::<_, String>(0)?));
            }
            Ok(named)
        })
    }

    /// The first outcome whose digest or predecessor is not what it should be, if there is one.
    ///
    /// # Errors
    /// [`LedgerError`] when it cannot be read.
    pub fn broken_link(&self) -> Result<Option<String>, LedgerError> {
        self.with("read", |db| {
            let mut query = db.prepare(&format!(
                "SELECT {}, previous, digest, id FROM outcomes ORDER BY n",
                hashed()
            ))?;
            let width = hashed_width();
            let mut rows = query.query([])?;
            let (mut last, mut number) = (genesis(), 0_i64);
            while let Some(row) = rows.next()? {
                number += 1;
                let values: Vec<Value> =
                    (0..width).map(|i| row.get(i)).collect::<Result<_, _>>()?;
                let previous: String = row.get(width)?;
                let digest: String = row.get(width + 1)?;
                let id: String = row.get(width + 2)?;
                if previous != last {
                    return Ok(Some(format!(
                        "row {number} (`{id}`) does not follow the row before it"
                    )));
                }
                if link(&previous, &values) != digest {
                    return Ok(Some(format!("row {number} (`{id}`) was edited")));
                }
                last = digest;
            }
            Ok(None)
        })
    }

    /// Answers a question in SQL: the columns' names and the rows as text, at most `most`.
    ///
    /// # Errors
    /// [`LedgerError`] for what SQLite does not understand, or would change something.
    pub fn ask(
        &self,
        sql: &str,
        most: usize,
    ) -> Result<(Vec<String>, Vec<Vec<Value>>), LedgerError> {
        self.with("ask", |db| {
            let mut query = db.prepare(sql)?;
            let names: Vec<_> = query.column_names().map(String::from).collect();
            let mut rows = query.query([])?;
            let mut found = Vec::new();
            while let Some(row) = rows.next()? {
                if found.len() == most {
                    break;
                }
                found.push((0..names.len()).map(|i| row.get(i)).collect::<Result<_, _>>()?);
            }
            Ok((names, found))
        })
    }
}

fn check_version(db: &Connection, path: &Path) -> Result<(), LedgerError> {
    let version = db.query_row("PRAGMA user_version", [], |r| r.get::<_, i64>(0));
    let version = version.map_err(failed(path, "read"))?;
    if version <= VERSION {
        return Ok(());
    }
    let found = format!("it has version {version}, this program knows version {VERSION}");
    Err(failed(path, "open")(rusqlite::Error::ToSqlConversionFailure(found.into())))
}

fn foreign(column: usize, found: String) -> rusqlite::Error {
    rusqlite::Error::FromSqlConversionFailure(column, rusqlite::types::Type::Text, found.into())
}

/// Takes an item into the plan; the reason if its id stands there already.
fn take_item(
    db: &Connection,
    plan: i64,
    line: u64,
    item: &Item,
) -> rusqlite::Result<Option<String>> {
    let spec = serde_json::to_string(item).unwrap_or_default();
    let question = Digest::of(spec.as_bytes());
    let sql = "INSERT INTO planned (id, line, spec, question, plan) VALUES (?1, ?2, ?3, ?4, ?5)
        ON CONFLICT (id) DO UPDATE SET
            line = excluded.line, spec = excluded.spec, question = excluded.question, plan = excluded.plan
        WHERE plan <> excluded.plan";
    let values = params![item.id, signed(line), spec, question.as_str(), plan];
    if db.prepare_cached(sql)?.execute(values)? > 0 {
        return Ok(None);
    }
    let sql = "SELECT line FROM planned WHERE id = ?1";
    let first: i64 = db.query_row(sql, [&item.id], |r| r.get(0))?;
    Ok(Some(format!("the id `{}` stands in line {first} already", item.id)))
}

fn planned(row: &rusqlite::Row<'_>) -> rusqlite::Result<Option<Planned>> {
    let spec: String = row.get(2)?;
    let item = serde_json::from_str(&spec).map_err(|e| foreign(2, e.to_string()))?;
    let Some(question) = Digest::parse(&row.get::<_, String>(3)?) else { return Ok(None) };
    let line = row.get::<_, i64>(1)?.unsigned_abs();
    Ok(Some(Planned { n: row.get(0)?, line, item, question }))
}

/// The columns a row's digest is over, as SQL.
fn hashed() -> String {
    let names: Vec<_> = COLUMNS.iter().map(|(name, _)| *name).collect();
    format!("run, question, settings, final, {}, facts", names.join(", "))
}

fn hashed_width() -> usize {
    COLUMNS.len() + 5
}

/// What the first row names as the one before it.
fn genesis() -> String {
    Digest::of(b"").to_string()
}

/// The digest of a row: of the one before it and all its values.
fn link(previous: &str, values: &[Value]) -> String {
    let mut text = previous.to_owned();
    for value in values {
        let word = match value {
            Value::Null => "n".to_owned(),
            Value::Integer(i) => format!("i{i}"),
            Value::Real(r) => format!("r{:016x}", r.to_bits()),
            Value::Text(t) => format!("t{}:{t}", t.len()),
            Value::Blob(b) => format!("b{}", Digest::of(b)),
        };
        text.push('\n');
        text.push_str(&word);
    }
    Digest::of(text.as_bytes()).to_string()
}

fn add_one(
    db: &Connection,
    (run, settings, question): (i64, &Digest, &Digest),
    record: &Record,
) -> rusqlite::Result<()> {
    let last = "SELECT digest FROM outcomes ORDER BY n DESC LIMIT 1";
    let previous = db.prepare_cached(last)?.query_row([], |r| r.get::<_, String>(0)).optional()?;
    let previous = previous.unwrap_or_else(genesis);
    let facts = serde_json::to_string(record).unwrap_or_default();
    let head = [
        Value::Integer(run),
        Value::Text(question.to_string()),
        Value::Text(settings.to_string()),
        Value::Integer(record.is_final().into()),
    ];
    let mut values: Vec<Value> = head.into();
    values.extend(COLUMNS.iter().map(|(name, _)| record.value(name)));
    values.push(Value::Text(facts));
    let digest = link(&previous, &values);
    values.extend([Value::Text(previous), Value::Text(digest)]);
    let marks = vec!["?"; values.len()].join(", ");
    let sql = format!("INSERT INTO outcomes ({}, previous, digest) VALUES ({marks})", hashed());
    db.prepare_cached(&sql)?.execute(params_from_iter(values)).map(drop)
}

#[cfg(test)]
#[path = "ledger_tests.rs"]
mod tests;
