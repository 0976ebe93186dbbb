//! The plan of a batch in its ledger: which items a manifest names, and which are still to be made.

use rusqlite::types::Value;
use rusqlite::{Connection, OptionalExtension as _, params};
use trace::Digest;

use super::super::class::Class;
use super::super::manifest::Item;
use super::super::record::signed;
use super::chain::add_row;
use super::database::{Ledger, LedgerError, digest, foreign};

/// An item as it stands in the plan.
#[derive(Clone, Debug, PartialEq)]
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
    /// Digest of everything that shapes every asset of the batch; none where any will do.
    pub settings: Option<&'a Digest>,
    /// Classes whose outcomes of earlier runs do not count.
    pub again: &'a [&'a str],
    /// This run: what it settled stays settled.
    pub run: i64,
}

impl Ledger {
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
        self.with("write to", |db| {
            let all = db.transaction()?;
            let plan = add_row(&all, "plans", vec![Value::Text(manifest.to_string())])?;
            all.commit()?;
            Ok(plan)
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
                    let values = [plan, signed(*number)].map(Value::Integer);
                    let values = values.into_iter().chain([Value::Text(why)]).collect();
                    add_row(&all, "bad_lines", values)?;
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
        let sql = "SELECT line, why FROM bad_lines WHERE plan = ?1 ORDER BY n LIMIT ?2";
        self.with("read", |db| {
            let mut query = db.prepare(sql)?;
            let rows = query.query_map(params![plan, most], |r| {
                Ok((r.get::<_, i64>(0)?.unsigned_abs(), r.get(1)?))
            })?;
            rows.collect()
        })
    }

    /// The first bad lines of the latest plan, and how many it has.
    ///
    /// # Errors
    /// [`LedgerError`] when they cannot be read.
    pub fn latest_bad_lines(&self, most: u32) -> Result<(Vec<(u64, String)>, u64), LedgerError> {
        let latest = "SELECT max(plan) FROM plans";
        let count = "SELECT count(*) FROM bad_lines WHERE plan = ?1";
        let found = self.with("read", |db| {
            let plan: Option<i64> = db.query_row(latest, [], |r| r.get(0))?;
            let Some(plan) = plan else { return Ok(None) };
            let all: i64 = db.query_row(count, [plan], |r| r.get(0))?;
            Ok(Some((plan, all.unsigned_abs())))
        })?;
        let Some((plan, all)) = found else { return Ok((vec![], 0)) };
        Ok((self.bad_lines(plan, most)?, all))
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
                AND o.question = p.question AND (?3 IS NULL OR o.settings = ?3) AND o.final
                AND (o.run = ?4 OR instr(?5, ',' || coalesce(o.class, '-') || ',') = 0))
            ORDER BY p.n LIMIT ?6";
        let again = format!(",{},", settled.again.join(","));
        let Settled { plan, settings, run, .. } = settled;
        self.with("read", |db| {
            let mut query = db.prepare_cached(sql)?;
            let settings = settings.map(Digest::as_str);
            let values = params![plan, after, settings, run, again, most];
            let rows = query.query_map(values, planned)?;
            rows.collect()
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

    /// An item of the plan by its place.
    ///
    /// # Errors
    /// [`LedgerError`] when it cannot be read.
    pub fn planned(&self, n: i64) -> Result<Option<Planned>, LedgerError> {
        let sql = "SELECT n, line, spec, question FROM planned WHERE n = ?1";
        self.with("read", |db| db.query_row(sql, [n], planned).optional())
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
}

/// Takes an item into the plan; the reason if its id stands there already.
pub(super) fn take_item(
    db: &Connection,
    plan: i64,
    line: u64,
    item: &Item,
) -> rusqlite::Result<Option<String>> {
    let spec = match serde_json::to_string(item) {
        Ok(spec) => spec,
        // A path of bytes that are no text.
        Err(e) => return Ok(Some(format!("the item cannot be written down: {e}"))),
    };
    let question = Digest::of(spec.as_bytes());
    let sql = "SELECT line FROM planned WHERE plan = ?1 AND id = ?2";
    let first = db.prepare_cached(sql)?.query_row(params![plan, item.id], |r| r.get::<_, i64>(0));
    if let Some(first) = first.optional()? {
        return Ok(Some(format!("the id `{}` stands in line {first} already", item.id)));
    }
    let values = vec![
        Value::Text(item.id.clone()),
        Value::Integer(signed(line)),
        Value::Text(spec),
        Value::Text(question.to_string()),
        Value::Integer(plan),
    ];
    add_row(db, "planned", values).map(|_| None)
}

pub(super) fn planned(row: &rusqlite::Row<'_>) -> rusqlite::Result<Planned> {
    let spec: String = row.get(2)?;
    let item = serde_json::from_str(&spec).map_err(|e| foreign(2, e.to_string()))?;
    let question = digest(row, 3)?;
    let line = row.get::<_, i64>(1)?.unsigned_abs();
    Ok(Planned { n: row.get(0)?, line, item, question })
}
