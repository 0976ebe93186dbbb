//! Questions in SQL: what may be asked, for how long, and how much may come out.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use runner::ours::looking;
use rusqlite::hooks::{AuthAction, AuthContext, Authorization};
use rusqlite::limits::Limit;
use rusqlite::types::Value;
use rusqlite::{Connection, Error, ErrorCode};

use super::database::{FILE, Ledger, LedgerError, schema};

/// Most bytes of an answer (64 MiB), and of one value in it.
const MOST: usize = 64 << 20;
/// Longest value and row, bytes: one step of a question is not interrupted, and compares texts with each
/// other in a second at most; a guess, some eight times the longest row of ours.
const LONGEST_VALUE: i32 = 1 << 18;
/// Longest pattern of LIKE and GLOB, bytes; a guess.
const LONGEST_PATTERN: i32 = 1000;
/// Longest question, bytes.
const LONGEST: i32 = 100_000;
/// Most memory that SQLite takes for a question, bytes (1 GiB).
const MEMORY: i64 = 1 << 30;
/// What a question may look into besides the ledger's own tables: functions that give rows.
const ROWS: [&str; 2] = ["json_each", "json_tree"];

/// Why a question has no answer.
#[derive(Debug, thiserror::Error)]
pub enum AskError {
    /// SQLite does not understand it, or the ledger cannot be read.
    #[error(transparent)]
    Ledger(#[from] LedgerError),
    /// It would do something else than ask the ledger.
    #[error("only the ledger's own tables can be asked, and nothing changed: {found}")]
    NotAllowed {
        /// What it would do.
        found: String,
    },
    /// It takes too long.
    #[error("it was not answered within {} s and was stopped", longest.as_secs_f64())]
    TooLong {
        /// The longest time.
        longest: Duration,
    },
    /// Its answer is too long.
    #[error("its answer has more than {most} bytes, the most that is given")]
    TooMuch {
        /// Most bytes.
        most: usize,
    },
    /// A value or a row on the way to it is too long.
    #[error(
        "a value or a row has more than {most} bytes on the way to its answer, the most that is made"
    )]
    TooWide {
        /// Most bytes.
        most: i32,
    },
    /// It takes too much memory.
    #[error("it takes more than {most} bytes of memory to answer, the most that is given")]
    TooLarge {
        /// Most bytes.
        most: i64,
    },
}

impl Ledger {
    /// Answers a question in SQL: the columns' names and the rows, at most `most`. It can read the
    /// ledger's tables and call functions, and nothing else; `longest` is the longest time.
    ///
    /// # Errors
    /// [`AskError`].
    pub fn ask(
        &self,
        sql: &str,
        most: usize,
        longest: Duration,
    ) -> Result<(Vec<String>, Vec<Vec<Value>>), AskError> {
        let asked = Arc::new(AtomicBool::new(false));
        let mut too_much = false;
        let answered = self.with("ask", |db| {
            restrict(db, Arc::clone(&asked), longest)?;
            let answer = answer(db, sql, &asked, most);
            db.authorizer(None::<fn(AuthContext<'_>) -> Authorization>)?;
            db.progress_handler(0, None::<fn() -> bool>)?;
            let (names, rows) = answer?;
            too_much = rows.is_none();
            Ok((names, rows.unwrap_or_default()))
        });
        let answered = answered.map_err(|error| named(error, longest))?;
        if !asked.load(Ordering::Relaxed) {
            return Err(AskError::NotAllowed { found: "it is no SELECT".into() });
        }
        if too_much {
            return Err(AskError::TooMuch { most: MOST });
        }
        Ok(answered)
    }
}

/// The ledger's tables and views with their columns, the view of items first.
///
/// # Errors
/// [`AskError::Ledger`] where SQLite fails.
pub fn columns() -> Result<Vec<(String, Vec<String>)>, AskError> {
    let listed = || {
        let own = Connection::open_in_memory()?;
        own.execute_batch(&schema())?;
        let sql = "SELECT m.name, c.name FROM sqlite_schema m, pragma_table_info(m.name) c \
                   WHERE m.type IN ('table', 'view') ORDER BY m.type DESC, m.name, c.cid";
        let mut query = own.prepare(sql)?;
        let pairs = query.query_map([], |row| Ok((row.get(0)?, row.get(1)?)))?;
        let mut tables: Vec<(String, Vec<String>)> = Vec::new();
        for pair in pairs {
            let (table, column): (String, String) = pair?;
            match tables.last_mut() {
                Some((last, columns)) if *last == table => columns.push(column),
                _ => tables.push((table, vec![column])),
            }
        }
        Ok(tables)
    };
    listed().map_err(|source| LedgerError { doing: "read", path: FILE.into(), source }.into())
}

/// Forbids everything but to read; notes whether anything was asked for at all.
fn restrict(db: &mut Connection, asked: Arc<AtomicBool>, longest: Duration) -> Result<(), Error> {
    let tables = tables()?;
    let others = others(db, &tables)?;
    db.set_limit(Limit::SQLITE_LIMIT_LENGTH, LONGEST_VALUE)?;
    db.set_limit(Limit::SQLITE_LIMIT_LIKE_PATTERN_LENGTH, LONGEST_PATTERN)?;
    db.set_limit(Limit::SQLITE_LIMIT_SQL_LENGTH, LONGEST)?;
    db.set_limit(Limit::SQLITE_LIMIT_ATTACHED, 0)?;
    db.pragma_update(None, "hard_heap_limit", MEMORY)?;
    db.authorizer(Some(move |context: AuthContext<'_>| {
        let allowed = match context.action {
            AuthAction::Select => {
                asked.store(true, Ordering::Relaxed);
                true
            }
            // Of a name that the question itself gives to rows no column is ever read.
            AuthAction::Read { table_name, column_name: "" } => {
                !others.contains(&table_name.to_ascii_lowercase())
            }
            AuthAction::Read { table_name, .. } => {
                tables.contains(table_name) || ROWS.contains(&table_name)
            }
            AuthAction::Function { function_name } => {
                !function_name.eq_ignore_ascii_case("load_extension")
            }
            AuthAction::Recursive => true,
            _ => false,
        };
        if allowed { Authorization::Allow } else { Authorization::Deny }
    }))?;
    looking::end_by(db, longest)
}

/// The names of the ledger's own tables and views.
fn tables() -> Result<BTreeSet<String>, Error> {
    let own = Connection::open_in_memory()?;
    own.execute_batch(&schema())?;
    let mut query =
        own.prepare("SELECT name FROM sqlite_schema WHERE type IN ('table', 'view')")?;
    query.query_map([], |row| row.get(0))?.collect()
}

/// Everything else that rows could come out of, in lower case.
fn others(db: &Connection, own: &BTreeSet<String>) -> Result<BTreeSet<String>, Error> {
    let sql =
        "SELECT lower(name) FROM sqlite_schema UNION SELECT lower(name) FROM pragma_module_list";
    let mut query = db.prepare(sql)?;
    let names = query.query_map([], |row| row.get(0))?;
    let mut others = names.collect::<Result<BTreeSet<String>, _>>()?;
    let schemas = ["sqlite_schema", "sqlite_master", "sqlite_temp_schema", "sqlite_temp_master"];
    others.extend(schemas.map(String::from));
    others.retain(|name| !own.contains(name) && !ROWS.contains(&name.as_str()));
    Ok(others)
}

/// The columns' names and the rows; no rows where they are too many bytes.
type Rows = (Vec<String>, Option<Vec<Vec<Value>>>);

fn answer(db: &Connection, sql: &str, asked: &AtomicBool, most: usize) -> Result<Rows, Error> {
    let mut query = db.prepare(sql)?;
    let names: Vec<_> = query.column_names().map(String::from).collect();
    // VACUUM is not shown to an authorizer.
    if !asked.load(Ordering::Relaxed) || !query.readonly() {
        return Ok((names, Some(Vec::new())));
    }
    let mut rows = query.query([])?;
    let (mut found, mut bytes) = (Vec::new(), 0);
    while let Some(row) = rows.next()? {
        if found.len() == most {
            break;
        }
        let cells: Vec<Value> = (0..names.len()).map(|i| row.get(i)).collect::<Result<_, _>>()?;
        bytes += cells.iter().map(size).sum::<usize>();
        if bytes > MOST {
            return Ok((names, None));
        }
        found.push(cells);
    }
    Ok((names, Some(found)))
}

/// About the bytes a cell takes.
fn size(cell: &Value) -> usize {
    match cell {
        Value::Text(text) => 32 + text.len(),
        Value::Blob(bytes) => 32 + bytes.len(),
        _ => 32,
    }
}

/// The cap that was exceeded, where one was.
fn named(error: LedgerError, longest: Duration) -> AskError {
    match error.source.sqlite_error_code() {
        Some(ErrorCode::OperationInterrupted) => AskError::TooLong { longest },
        Some(ErrorCode::OutOfMemory) => AskError::TooLarge { most: MEMORY },
        Some(ErrorCode::TooBig) => AskError::TooWide { most: LONGEST_VALUE },
        Some(ErrorCode::AuthorizationForStatementDenied) => not_allowed(&error),
        // So SQLite says of a function.
        _ if error.source.to_string().starts_with("not authorized") => not_allowed(&error),
        _ => error.into(),
    }
}

fn not_allowed(error: &LedgerError) -> AskError {
    AskError::NotAllowed { found: error.source.to_string() }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on stops")]
mod tests {
    use super::*;

    const SECOND: Duration = Duration::from_secs(1);

    fn ledger() -> (tempfile::TempDir, Ledger) {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join(FILE);
        drop(Ledger::open(&path).unwrap());
        let ledger = Ledger::open_to_read(&path).unwrap().unwrap();
        (dir, ledger)
    }

    fn told(ledger: &Ledger, sql: &str) -> String {
        let answer = ledger.ask(sql, 10, SECOND);
        answer.map_or_else(|e| e.to_string(), |rows| panic!("{sql} was answered: {rows:?}"))
    }

    #[test]
    fn what_does_anything_else_than_ask_the_ledger_is_refused() {
        let (dir, ledger) = ledger();
        let other = dir.path().join("other.db");
        let other = other.display();
        for sql in [
            &format!("VACUUM INTO '{other}'"),
            "VACUUM",
            &format!("ATTACH '{other}' AS x"),
            "CREATE TABLE t (x)",
            "CREATE TEMP TABLE t AS SELECT * FROM items",
            "CREATE TEMP VIEW v AS SELECT 1",
            "DELETE FROM outcomes",
            "INSERT INTO runs VALUES (1, '', '', '', 1) RETURNING run",
            "PRAGMA journal_mode = DELETE",
            "PRAGMA user_version",
            "SELECT * FROM pragma_table_info('items')",
            "SELECT * FROM dbstat",
            "SELECT sql FROM sqlite_schema",
            "SELECT count(*) FROM SQLITE_MASTER",
            "SELECT count(*) FROM pragma_database_list",
            "WITH t AS (SELECT sql FROM sqlite_schema) SELECT * FROM t",
            "BEGIN",
            "ANALYZE",
            "REINDEX",
            "SELECT load_extension('x')",
        ] {
            let found = told(&ledger, sql);
            assert!(
                found.starts_with("only the ledger's own tables can be asked"),
                "{sql}: {found}"
            );
        }
        let names: Vec<_> = std::fs::read_dir(dir.path()).unwrap().flatten().collect();
        assert_eq!(names.len(), 1, "{names:?}");
    }

    #[test]
    fn what_never_ends_grows_or_floods_is_stopped_by_a_cap_that_is_named() {
        let (_dir, ledger) = ledger();
        let endless = "WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM c)";
        let longest = Duration::from_millis(200);
        let error =
            ledger.ask(&format!("{endless} SELECT count(*) FROM c"), 1, longest).unwrap_err();
        assert_eq!(error.to_string(), "it was not answered within 0.2 s and was stopped");
        let flood = format!("{endless} SELECT hex(zeroblob(100000)) FROM c");
        let error = ledger.ask(&flood, usize::MAX, 60 * SECOND).unwrap_err().to_string();
        assert!(error.contains("more than 67108864 bytes"), "{error}");
        let error = told(&ledger, "SELECT length(zeroblob(100000000))");
        assert!(error.contains("a value or a row has more than 262144 bytes"), "{error}");
    }

    #[test]
    fn reading_counting_and_functions_are_answered() {
        let (_dir, ledger) = ledger();
        for sql in [
            "SELECT count(*) FROM items",
            "SELECT id, max(n) FROM outcomes GROUP BY id",
            "SELECT a.value FROM outcomes, json_each(facts, '$.artefacts') a",
            "WITH t AS (SELECT id FROM items) SELECT upper(id) FROM t ORDER BY 1",
            "SELECT (SELECT count(*) FROM calls) + 1",
            "EXPLAIN QUERY PLAN SELECT * FROM items",
        ] {
            ledger.ask(sql, 10, SECOND).unwrap_or_else(|e| panic!("{sql}: {e}"));
        }
        let (_, rows) = ledger.ask("SELECT 1 UNION ALL SELECT 2", 1, SECOND).unwrap();
        assert_eq!(rows, [[Value::Integer(1)]]);
        ledger.each_item(|_| Ok::<(), LedgerError>(())).unwrap();
    }
}
