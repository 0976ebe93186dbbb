//! What became of each item: outcomes that are only ever added, each naming the digest of the one
//! before it.

use std::collections::BTreeSet;

use rusqlite::OptionalExtension as _;
use rusqlite::types::Value;
use rusqlite::{Connection, params_from_iter};
use trace::Digest;

use super::super::record::{COLUMNS, Record};
use super::chain::{OUTCOMES, hashed_outcome, last_digest, link, moved_on};
use super::database::{Ledger, LedgerError, digest, foreign};

impl Ledger {
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

    /// Mean time to compute of the items that ran whole, seconds; none if there are none.
    ///
    /// # Errors
    /// [`LedgerError`] when it cannot be read.
    pub fn mean_seconds(&self) -> Result<Option<f64>, LedgerError> {
        let sql = "SELECT avg(seconds_render_views + seconds_articulate + seconds_build_asset
            + seconds_write + seconds_check_in_sim) FROM items";
        self.with("read", |db| db.query_row(sql, [], |r| r.get(0)))
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
            let Some((end, _)) = page.last() else { return Ok(()) };
            last.clone_from(end);
            page.into_iter().try_for_each(|(_, record)| each(record))?;
        }
    }

    /// Items in the order of their ids as the table has them: an id that is another in the facts
    /// would lead around in circles, and is no ledger of ours.
    fn page(&self, after: &str) -> Result<Vec<(String, Record)>, LedgerError> {
        let sql = "SELECT id, facts FROM items WHERE id > ?1 ORDER BY id LIMIT 1000";
        self.with("read", |db| {
            let mut query = db.prepare_cached(sql)?;
            let rows = query.query_map([after], |r| Ok((r.get(0)?, r.get(1)?)))?;
            let parse = |row: rusqlite::Result<(String, String)>| {
                let (id, facts) = row?;
                let record: Record =
                    serde_json::from_str(&facts).map_err(|e| foreign(1, e.to_string()))?;
                if record.id == id {
                    return Ok((id, record));
                }
                Err(foreign(1, format!("the row of `{id}` tells of `{}`", record.id)))
            };
            rows.map(parse).collect()
        })
    }

    /// The last outcome of an item with which an asset was accepted, if there is one.
    ///
    /// # Errors
    /// [`LedgerError`] when it cannot be read.
    pub fn last_accepted(&self, id: &str) -> Result<Option<Record>, LedgerError> {
        let sql = "SELECT facts FROM outcomes WHERE id = ?1 AND outcome = 'accepted'
            ORDER BY n DESC LIMIT 1";
        self.with("read", |db| {
            let row = db.prepare_cached(sql)?.query_row([id], |r| r.get::<_, String>(0));
            let text = row.optional()?;
            let parse = |text: String| serde_json::from_str(&text);
            text.map(parse).transpose().map_err(|e| foreign(0, e.to_string()))
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
                named.insert(digest(row, 0)?);
            }
            Ok(named)
        })
    }
}

fn add_one(
    db: &Connection,
    (run, settings, question): (i64, &Digest, &Digest),
    record: &Record,
) -> rusqlite::Result<()> {
    let previous = last_digest(db, OUTCOMES)?;
    let facts = serde_json::to_string(record);
    let facts = facts.map_err(|e| rusqlite::Error::ToSqlConversionFailure(e.into()))?;
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
    values.extend([Value::Text(previous), Value::Text(digest.clone())]);
    let marks = vec!["?"; values.len()].join(", ");
    let columns = hashed_outcome();
    let sql = format!("INSERT INTO outcomes ({columns}, previous, digest) VALUES ({marks})");
    db.prepare_cached(&sql)?.execute(params_from_iter(values))?;
    moved_on(db, OUTCOMES, &digest)
}
