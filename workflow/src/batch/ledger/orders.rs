//! A plan that grows while it is worked on: items that come one by one, each of somebody.
//!
//! Whose an item is stands in its id, before the first dot.

use rusqlite::types::Value;
use rusqlite::{OptionalExtension as _, params};
use trace::Digest;

use super::super::manifest::Item;
use super::super::record::Record;
use super::database::{Ledger, LedgerError, foreign};
use super::plan::{Planned, planned, take_item};

/// The first id behind all of an owner's: the sign behind the dot.
fn ids_of(owner: &str) -> [String; 2] {
    [format!("{owner}."), format!("{owner}/")]
}

impl Ledger {
    /// The plan of this name that items are added to, made where there is none.
    ///
    /// # Errors
    /// [`LedgerError`] when it cannot be read or written.
    pub fn growing_plan(&self, name: &str) -> Result<i64, LedgerError> {
        let digest = Digest::of(name.as_bytes());
        if let Some(plan) = self.plan_of(&digest)? {
            return Ok(plan);
        }
        let plan = self.begin_plan(&digest)?;
        self.end_plan(plan)?;
        Ok(plan)
    }

    /// Adds an item to a plan; false where one of its id is there already.
    ///
    /// # Errors
    /// [`LedgerError`] when it cannot be written.
    pub fn order(&self, plan: i64, item: &Item) -> Result<bool, LedgerError> {
        self.with("write to", |db| {
            let all = db.transaction()?;
            let there = "SELECT EXISTS (SELECT 1 FROM planned WHERE plan = ?1 AND id = ?2)";
            let there: bool =
                all.prepare_cached(there)?.query_row(params![plan, item.id], |r| r.get(0))?;
            if there {
                return Ok(false);
            }
            let line = "SELECT coalesce(max(line), 0) + 1 FROM planned WHERE plan = ?1";
            let line: i64 = all.prepare_cached(line)?.query_row([plan], |r| r.get(0))?;
            if let Some(why) = take_item(&all, plan, line.unsigned_abs(), item)? {
                return Err(rusqlite::Error::ToSqlConversionFailure(why.into()));
            }
            all.commit()?;
            Ok(true)
        })
    }

    /// An item of a plan by its id.
    ///
    /// # Errors
    /// [`LedgerError`] when it cannot be read.
    pub fn ordered(&self, plan: i64, id: &str) -> Result<Option<Planned>, LedgerError> {
        let sql = "SELECT n, line, spec, question FROM planned WHERE plan = ?1 AND id = ?2";
        self.with("read", |db| {
            db.prepare_cached(sql)?.query_row(params![plan, id], planned).optional()
        })
    }

    /// The ids of an owner's items, the newest first: at most so many of those before the item `before`.
    ///
    /// # Errors
    /// [`LedgerError`] when they cannot be read.
    pub fn orders(
        &self,
        plan: i64,
        owner: &str,
        before: Option<&str>,
        most: usize,
    ) -> Result<Vec<String>, LedgerError> {
        let sql = "SELECT id FROM planned WHERE plan = ?1 AND id >= ?2 AND id < ?3 AND (?4 IS NULL
            OR n < (SELECT n FROM planned WHERE plan = ?1 AND id = ?4)) ORDER BY n DESC LIMIT ?5";
        let [first, end] = ids_of(owner);
        let most = i64::try_from(most).unwrap_or(i64::MAX);
        self.with("read", |db| {
            let mut query = db.prepare_cached(sql)?;
            let rows = query.query_map(params![plan, first, end, before, most], |r| r.get(0))?;
            rows.collect()
        })
    }

    /// How many of an owner's items have no outcome that stands.
    ///
    /// # Errors
    /// [`LedgerError`] when they cannot be counted.
    pub fn unsettled_orders(&self, plan: i64, owner: &str) -> Result<u64, LedgerError> {
        let sql = "SELECT count(*) FROM planned p
            WHERE p.plan = ?1 AND p.id >= ?2 AND p.id < ?3 AND NOT EXISTS (
                SELECT 1 FROM outcomes o WHERE o.id = p.id AND o.question = p.question AND o.final
                AND o.n = (SELECT max(n) FROM outcomes l WHERE l.id = p.id))";
        let [first, end] = ids_of(owner);
        self.with("read", |db| {
            let count = |r: &rusqlite::Row<'_>| r.get::<_, i64>(0).map(i64::unsigned_abs);
            db.prepare_cached(sql)?.query_row(params![plan, first, end], count)
        })
    }

    /// The latest outcome of an item.
    ///
    /// # Errors
    /// [`LedgerError`] when it cannot be read.
    pub fn latest(&self, id: &str) -> Result<Option<Record>, LedgerError> {
        let sql = "SELECT facts FROM outcomes WHERE id = ?1 ORDER BY n DESC LIMIT 1";
        let text = self.with("read", |db| {
            db.prepare_cached(sql)?.query_row([id], |r| r.get::<_, String>(0)).optional()
        })?;
        let parse = |text: String| {
            self.with("read", |_| {
                serde_json::from_str(&text).map_err(|e| foreign(0, e.to_string()))
            })
        };
        text.map(parse).transpose()
    }

    /// What an owner's items sent to whom it may have cost, as [`Ledger::calls`].
    ///
    /// # Errors
    /// [`LedgerError`] when it cannot be read.
    pub fn calls_of(&self, owner: &str) -> Result<Vec<super::Sent>, LedgerError> {
        let [first, end] = ids_of(owner).map(Value::Text);
        self.sent_where("c.id >= ?1 AND c.id < ?2", &[first, end])
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::record::Ended;
    use super::super::plan::Settled;
    use super::*;

    fn item(id: &str) -> Item {
        Item { id: id.into(), photo: "p.png".into(), ..Item::default() }
    }

    #[test]
    fn an_item_that_comes_twice_is_planned_once_and_stays_with_its_owner() {
        let ledger = Ledger::passing().unwrap();
        let plan = ledger.growing_plan("requests").unwrap();
        assert_eq!(ledger.growing_plan("requests").unwrap(), plan);
        let came = ["ann.1", "ann.1", "anna.1", "ann.2"].map(|id| ledger.order(plan, &item(id)));
        assert_eq!(came.map(Result::unwrap), [true, false, true, true]);
        let ids = |before| ledger.orders(plan, "ann", before, 10).unwrap();
        assert_eq!(
            (ids(None), ids(Some("ann.2"))),
            (vec!["ann.2".into(), "ann.1".into()], vec!["ann.1".to_owned()])
        );
        assert_eq!(ledger.ordered(plan, "anna.1").unwrap().unwrap().line, 2);
        assert_eq!(ledger.unsettled_orders(plan, "ann").unwrap(), 2);
        let question = ledger.ordered(plan, "ann.1").unwrap().unwrap().question;
        let record = Record::new("ann.1", Ended::Accepted);
        ledger.add(1, &Digest::of(b"some settings"), &[(question, record)]).unwrap();
        assert_eq!(ledger.unsettled_orders(plan, "ann").unwrap(), 1);
        assert_eq!(ledger.latest("ann.1").unwrap().unwrap().outcome, Ended::Accepted);
        // What was made under other settings stays made where nobody asks for some.
        let settled = Settled { plan, settings: None, again: &[], run: 2 };
        let left: Vec<_> =
            ledger.pending(&settled, 0, 9).unwrap().into_iter().map(|p| p.item.id).collect();
        assert_eq!(left, ["anna.1", "ann.2"]);
        assert!(ledger.broken_links().unwrap().is_empty());
    }
}
