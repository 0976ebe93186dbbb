//! Requests that may cost: each stands in the ledger before it is sent, and then what became of it.

use adapters::budget::{Entry, Fate};
use rusqlite::types::Value;
use rusqlite::{OptionalExtension as _, params_from_iter};
use trace::Time;

use super::super::record::signed;
use super::chain::add_row;
use super::database::{Ledger, LedgerError};

/// A request about to be sent.
#[derive(Clone, Copy, Debug)]
pub struct Call<'a> {
    /// The run.
    pub run: i64,
    /// The item.
    pub id: &'a str,
    /// The stage it is for.
    pub stage: &'a str,
    /// What it costs by the batch's prices.
    pub cost: f64,
    /// When.
    pub at: Time,
}

/// How many requests a stage sent, and what they cost; those of 0.1.0 have no cost of their own.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sent {
    /// The stage.
    pub stage: String,
    /// Requests that were sent, or may have been.
    pub requests: u64,
    /// What they cost, without those of 0.1.0.
    pub cost: f64,
    /// How many of them are of 0.1.0, where one stood for all of a stage's.
    pub old: u64,
}

fn word(fate: Fate) -> &'static str {
    match fate {
        Fate::Asked => "asked",
        Fate::Answered => "answered",
        Fate::Lost => "lost",
        Fate::Refused => "refused",
        Fate::Unsent => "unsent",
    }
}

impl Ledger {
    /// Writes down a request before it is sent; its number.
    ///
    /// # Errors
    /// [`LedgerError`] when it cannot be written.
    pub fn call(&self, call: &Call<'_>, entry: &Entry) -> Result<i64, LedgerError> {
        self.write_call(call, entry, None)
    }

    /// Writes down what became of a request, and what it costs after all.
    ///
    /// # Errors
    /// [`LedgerError`] when it cannot be written.
    pub fn settle(&self, number: i64, call: &Call<'_>, entry: &Entry) -> Result<(), LedgerError> {
        self.write_call(call, entry, Some(number)).map(drop)
    }

    fn write_call(
        &self,
        call: &Call<'_>,
        entry: &Entry,
        settles: Option<i64>,
    ) -> Result<i64, LedgerError> {
        let count = |n: Option<u64>| n.map_or(Value::Null, |n| Value::Integer(signed(n)));
        let values = vec![
            Value::Integer(call.run),
            Value::Text(call.id.into()),
            Value::Text(call.stage.into()),
            Value::Text(entry.step.clone()),
            Value::Text(entry.question.to_string()),
            settles.map_or(Value::Null, Value::Integer),
            Value::Text(word(entry.fate).into()),
            Value::Real(call.cost + 0.0),
            count(entry.usage.input),
            count(entry.usage.output),
            entry.usage.credits.map_or(Value::Null, |c| Value::Real(c + 0.0)),
            Value::Integer(signed(call.at)),
        ];
        self.with("write to", |db| {
            let all = db.transaction()?;
            let number = add_row(&all, "calls", values)?;
            all.commit()?;
            Ok(number)
        })
    }

    /// The latest request of that question and step which was asked and never settled: its number and
    /// item.
    ///
    /// # Errors
    /// [`LedgerError`] when it cannot be read.
    pub fn unsettled(&self, entry: &Entry) -> Result<Option<(i64, String)>, LedgerError> {
        let sql = "SELECT c.n, c.id FROM calls c
            WHERE c.question = ?1 AND c.step = ?2 AND c.settles IS NULL AND c.fate = 'asked'
            AND NOT EXISTS (SELECT 1 FROM calls s WHERE s.settles = c.n) ORDER BY c.n DESC LIMIT 1";
        let values = [entry.question.as_str(), entry.step.as_str()];
        self.with("read", |db| {
            let row = |r: &rusqlite::Row<'_>| Ok((r.get(0)?, r.get(1)?));
            db.prepare_cached(sql)?.query_row(values, row).optional()
        })
    }

    /// How many requests each stage sent and what they cost: for an item, or for all. What was asked
    /// and never settled counts as sent.
    ///
    /// # Errors
    /// [`LedgerError`] when it cannot be read.
    pub fn calls(&self, id: Option<&str>) -> Result<Vec<Sent>, LedgerError> {
        match id {
            Some(id) => self.sent_where("c.id = ?1", &[Value::Text(id.into())]),
            None => self.sent_where("1", &[]),
        }
    }

    /// The same of the calls `c` of which this holds.
    pub(super) fn sent_where(
        &self,
        whose: &str,
        values: &[Value],
    ) -> Result<Vec<Sent>, LedgerError> {
        let sql = format!(
            "SELECT c.stage, count(*), sum(coalesce(s.cost, c.cost, 0)), sum(c.step IS NULL)
             FROM calls c LEFT JOIN calls s ON s.settles = c.n
             WHERE {whose} AND c.settles IS NULL AND coalesce(s.fate, c.fate) <> 'unsent'
             GROUP BY c.stage"
        );
        self.with("read", |db| {
            let mut query = db.prepare_cached(&sql)?;
            let rows = query.query_map(params_from_iter(values), |r| {
                let count = |i| r.get::<_, i64>(i).map(i64::unsigned_abs);
                Ok(Sent { stage: r.get(0)?, requests: count(1)?, cost: r.get(2)?, old: count(3)? })
            })?;
            rows.collect()
        })
    }
}
