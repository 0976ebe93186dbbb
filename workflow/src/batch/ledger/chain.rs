//! The chain: every row of every table names the digest of the one before it, and the end of each
//! chain stands apart, so that rows that were changed, moved or taken away are found.

use rusqlite::types::Value;
use rusqlite::{Connection, OptionalExtension as _, params, params_from_iter};
use trace::Digest;

use super::super::record::COLUMNS;
use super::database::{Ledger, LedgerError, VERSION};

/// A table whose rows are chained: its name, its key, and the columns its digests are over.
pub(super) struct Table {
    pub(super) name: &'static str,
    pub(super) key: &'static str,
    pub(super) columns: &'static [&'static str],
}

/// Where runs, plans, items, bad lines and requests stand; outcomes have columns of their own.
pub(super) const TABLES: [Table; 5] = [
    Table { name: "runs", key: "run", columns: &["run", "version", "settings", "words", "at_ns"] },
    Table { name: "plans", key: "plan", columns: &["plan", "manifest"] },
    Table { name: "planned", key: "n", columns: &["n", "id", "line", "spec", "question", "plan"] },
    Table { name: "bad_lines", key: "n", columns: &["n", "plan", "line", "why"] },
    Table {
        name: "calls",
        key: "n",
        columns: &[
            "n", "run", "id", "stage", "step", "question", "settles", "fate", "cost", "input",
            "output", "credits", "at_ns",
        ],
    },
];
/// The table of what became of each item.
pub(super) const OUTCOMES: &str = "outcomes";

/// What the first row names as the one before it.
pub(super) fn genesis() -> String {
    Digest::of(b"").to_string()
}

/// The digest of a row: of the one before it and all its values.
pub(super) fn link(previous: &str, values: &[Value]) -> String {
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

/// The columns an outcome's digest is over, as SQL.
pub(super) fn hashed_outcome() -> String {
    let names: Vec<_> = COLUMNS.iter().map(|(name, _)| *name).collect();
    format!("run, question, settings, final, {}, facts", names.join(", "))
}

/// How many columns those are.
fn outcome_width() -> usize {
    COLUMNS.len() + 5
}

/// The digest of a table's last row.
pub(super) fn last_digest(db: &Connection, table: &str) -> rusqlite::Result<String> {
    let sql = "SELECT digest FROM heads WHERE name = ?1";
    db.prepare_cached(sql)?.query_row([table], |r| r.get(0))
}

/// Moves the end of a table's chain to a row that was added.
pub(super) fn moved_on(db: &Connection, table: &str, digest: &str) -> rusqlite::Result<()> {
    let sql = "UPDATE heads SET rows = rows + 1, digest = ?2 WHERE name = ?1";
    db.prepare_cached(sql)?.execute([table, digest]).map(drop)
}

/// Adds a row, all of whose columns but the key are given, to a table; its key.
pub(super) fn add_row(
    db: &Connection,
    table: &'static str,
    values: Vec<Value>,
) -> rusqlite::Result<i64> {
    let unknown = || rusqlite::Error::InvalidParameterName(table.into());
    let Table { key, columns, .. } = TABLES.iter().find(|t| t.name == table).ok_or_else(unknown)?;
    let sql = format!("SELECT coalesce(max({key}), 0) + 1 FROM {table}");
    let number: i64 = db.prepare_cached(&sql)?.query_row([], |r| r.get(0))?;
    add_numbered(db, (table, columns), number, values)?;
    Ok(number)
}

fn add_numbered(
    db: &Connection,
    (table, columns): (&str, &[&str]),
    number: i64,
    values: Vec<Value>,
) -> rusqlite::Result<()> {
    let mut all = vec![Value::Integer(number)];
    all.extend(values);
    let previous = last_digest(db, table)?;
    let digest = link(&previous, &all);
    all.extend([Value::Text(previous), Value::Text(digest.clone())]);
    let marks = vec!["?"; all.len()].join(", ");
    let names = columns.join(", ");
    let sql = format!("INSERT INTO {table} ({names}, previous, digest) VALUES ({marks})");
    db.prepare_cached(&sql)?.execute(params_from_iter(all))?;
    moved_on(db, table, &digest)
}

/// Makes the ends of the chains of a ledger that has none yet.
pub(super) fn begin(db: &Connection) -> rusqlite::Result<()> {
    let tables = TABLES.iter().map(|t| t.name).chain([OUTCOMES]);
    for table in tables {
        let sql = "INSERT INTO heads (name, rows, digest, unchained) VALUES (?1, 0, ?2, 0)";
        db.execute(sql, params![table, genesis()])?;
    }
    Ok(())
}

/// Columns of kinfold 0.1.0, as they stand in the tables of today; what it did not know is none.
const OLD: [(&str, &str); 5] = [
    ("runs", "run, version, settings, words, at_ns"),
    ("plans", "plan, manifest"),
    ("planned", "n, id, line, spec, question, plan"),
    ("bad_lines", "rowid, plan, line, why"),
    ("calls", "n, run, id, stage, NULL, NULL, NULL, 'asked', NULL, NULL, NULL, NULL, at_ns"),
];

/// Sets the tables of kinfold 0.1.0 aside, which chained outcomes alone, so that new ones can be made.
pub(super) fn set_aside(db: &Connection) -> rusqlite::Result<()> {
    for (table, _) in OLD {
        for verb in ["UPDATE", "DELETE"] {
            db.execute_batch(&format!("DROP TRIGGER IF EXISTS {table}_keep_{verb};"))?;
        }
        db.execute_batch(&format!("ALTER TABLE {table} RENAME TO old_{table};"))?;
    }
    db.execute_batch("DROP INDEX IF EXISTS calls_by_id;")
}

/// Takes the rows that were set aside into the chain, which vouches for them from now on; that nothing
/// vouched for them before is written down.
pub(super) fn take_in(db: &Connection) -> rusqlite::Result<()> {
    for (Table { name, key, columns }, (_, old)) in TABLES.iter().zip(OLD) {
        let order = if *name == "bad_lines" { "rowid" } else { key };
        let mut query = db.prepare(&format!("SELECT {old} FROM old_{name} ORDER BY {order}"))?;
        let mut rows = query.query([])?;
        while let Some(row) = rows.next()? {
            let values: Vec<Value> =
                (1..columns.len()).map(|i| row.get(i)).collect::<Result<_, _>>()?;
            add_numbered(db, (name, columns), row.get(0)?, values)?;
        }
        db.execute("UPDATE heads SET unchained = rows WHERE name = ?1", [name])?;
    }
    db.execute_batch(
        "UPDATE plans SET whole = (SELECT whole FROM old_plans o WHERE o.plan = plans.plan);",
    )?;
    for (table, _) in OLD {
        db.execute_batch(&format!("DROP TABLE old_{table};"))?;
    }
    let (rows, last) = outcomes_end(db)?;
    db.execute(
        "UPDATE heads SET rows = ?1, digest = ?2 WHERE name = ?3",
        params![rows, last, OUTCOMES],
    )?;
    Ok(())
}

fn outcomes_end(db: &Connection) -> rusqlite::Result<(i64, String)> {
    let rows = db.query_row("SELECT count(*) FROM outcomes", [], |r| r.get(0))?;
    let last = "SELECT digest FROM outcomes ORDER BY n DESC LIMIT 1";
    let last = db.query_row(last, [], |r| r.get(0)).optional()?;
    Ok((rows, last.unwrap_or_else(genesis)))
}

/// A chain as it is looked at.
struct Look<'a> {
    table: &'a str,
    columns: String,
    width: usize,
    key: &'a str,
    /// What a row is called besides its number.
    name: &'a str,
}

impl Ledger {
    /// Every chain that does not hold: what was edited, moved or taken away first in each table.
    ///
    /// # Errors
    /// [`LedgerError`] when it cannot be read.
    pub fn broken_links(&self) -> Result<Vec<String>, LedgerError> {
        let outcomes = Look {
            table: OUTCOMES,
            columns: hashed_outcome(),
            width: outcome_width(),
            key: "n",
            name: "id",
        };
        let mut looks = vec![outcomes];
        if self.is_chained_whole()? {
            looks.extend(TABLES.iter().map(|Table { name, key, columns }| Look {
                table: name,
                columns: columns.join(", "),
                width: columns.len(),
                key,
                name: if columns.contains(&"id") { "id" } else { "''" },
            }));
        }
        let found = looks.iter().map(|look| self.broken(look)).collect::<Result<Vec<_>, _>>()?;
        let mut found: Vec<_> = found.into_iter().flatten().collect();
        found.extend(self.calls_that_are_gone()?);
        Ok(found)
    }

    /// What is wrong with the chain of requests alone, which budgets rest on.
    ///
    /// # Errors
    /// [`LedgerError`] when it cannot be read.
    pub fn broken_calls(&self) -> Result<Option<String>, LedgerError> {
        let calls = TABLES.iter().find(|t| t.name == "calls");
        let Some(Table { name, key, columns }) = calls else { return Ok(None) };
        let (columns, width) = (columns.join(", "), columns.len());
        self.broken(&Look { table: name, columns, width, key, name: "id" })
    }

    /// Tables with rows that nothing vouches for, because kinfold 0.1.0 did not chain them, and how
    /// many those are.
    ///
    /// # Errors
    /// [`LedgerError`] when it cannot be read.
    pub fn unchained(&self) -> Result<Vec<(String, u64)>, LedgerError> {
        let is_whole = self.is_chained_whole()?;
        let mut found = Vec::new();
        for Table { name, .. } in &TABLES {
            let sql = if is_whole {
                format!("SELECT unchained FROM heads WHERE name = '{name}'")
            } else {
                format!("SELECT count(*) FROM {name}")
            };
            let rows =
                self.with("read", |db| db.query_row(&sql, [], |r| r.get::<_, i64>(0)).optional())?;
            let rows = rows.unwrap_or_default().unsigned_abs();
            if rows > 0 {
                found.push(((*name).to_owned(), rows));
            }
        }
        Ok(found)
    }

    /// Whether it is a ledger whose tables are all chained, and no older one that is only read.
    fn is_chained_whole(&self) -> Result<bool, LedgerError> {
        let version = self.with("read", |db| db.query_row("PRAGMA user_version", [], |r| r.get(0)));
        version.map(|version: i64| version >= VERSION)
    }

    fn broken(&self, look: &Look<'_>) -> Result<Option<String>, LedgerError> {
        let Look { table, columns, width, key, name } = look;
        let said = |what: String| match *table {
            OUTCOMES => what,
            table => format!("{table}: {what}"),
        };
        let sql = format!("SELECT {columns}, previous, digest, {name} FROM {table} ORDER BY {key}");
        let walked = self.with("read", |db| {
            let mut query = db.prepare(&sql)?;
            let mut rows = query.query([])?;
            let (mut last, mut number) = (genesis(), 0_i64);
            while let Some(row) = rows.next()? {
                number += 1;
                let values: Vec<Value> =
                    (0..*width).map(|i| row.get(i)).collect::<Result<_, _>>()?;
                let [previous, digest, id] = [0, 1, 2].map(|i| row.get::<_, String>(width + i));
                let (previous, digest, id) = (previous?, digest?, id?);
                let id = if id.is_empty() { id } else { format!(" (`{id}`)") };
                if previous != last {
                    return Ok(Err(format!("row {number}{id} does not follow the row before it")));
                }
                if link(&previous, &values) != digest {
                    return Ok(Err(format!("row {number}{id} was edited")));
                }
                last = digest;
            }
            Ok(Ok((number, last)))
        })?;
        match walked {
            Err(found) => Ok(Some(said(found))),
            Ok(end) => Ok(self.end_differs(table, &end)?.map(said)),
        }
    }

    /// Whether a chain ends where it was said to end.
    fn end_differs(
        &self,
        table: &str,
        (rows, last): &(i64, String),
    ) -> Result<Option<String>, LedgerError> {
        if !self.is_chained_whole()? {
            return Ok(None);
        }
        let sql = "SELECT rows, digest FROM heads WHERE name = ?1";
        let head = self.with("read", |db| {
            let row = |r: &rusqlite::Row<'_>| Ok((r.get::<_, i64>(0)?, r.get::<_, String>(1)?));
            db.query_row(sql, [table], row).optional()
        })?;
        Ok(match head {
            None => Some("nothing says where its chain ends".into()),
            Some((should, _)) if should > *rows => {
                Some(format!("{} rows are missing at its end", should - rows))
            }
            Some((should, digest)) if should != *rows || digest != *last => {
                Some("its chain does not end where it should".into())
            }
            Some(_) => None,
        })
    }

    /// Items whose outcome names more requests than the ledger holds.
    fn calls_that_are_gone(&self) -> Result<Vec<String>, LedgerError> {
        let settled = if self.is_chained_whole()? { "c.settles IS NULL AND " } else { "" };
        let sql = format!(
            "SELECT o.id, o.calls, (SELECT count(*) FROM calls c WHERE {settled} c.id = o.id) AS held
             FROM outcomes o WHERE o.calls > 0
             AND o.n = (SELECT max(n) FROM outcomes l WHERE l.id = o.id) AND o.calls > held"
        );
        self.with("read", |db| {
            let mut query = db.prepare(&sql)?;
            let found = query.query_map([], |r| {
                let (id, named, held) =
                    (r.get::<_, String>(0)?, r.get::<_, i64>(1)?, r.get::<_, i64>(2)?);
                Ok(format!("calls: the outcome of `{id}` names {named}, {held} are there"))
            })?;
            found.collect()
        })
    }
}
