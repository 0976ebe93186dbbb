//! `kinfold audit`: whether a batch still is what it was, and what stands in its ledger.

use std::path::Path;
use std::time::Duration;

use rusqlite::types::Value as Cell;
use serde_json::{Map, Value, json};

use crate::batch::audit::audit as look;
use crate::batch::index::ledgers;
use crate::batch::ledger::{AskError, columns};
use crate::cli::args::{AuditArgs, AuditCommand};
use crate::cli::speech::{Answer, Complaint, Exit};

/// What can be asked.
const TABLES: &str = "the table is `items`, its columns those of index.parquet, such as: SELECT id, verdict, provider, license FROM items WHERE outcome = 'accepted'";
/// Asks for the tables and their columns, as SQLite's own shell is asked.
const SCHEMA: &str = ".schema";
/// Findings that are told one by one.
const TOLD: usize = 50;

/// Audits a batch, or answers a question about it. Exit 1 if something does not hold.
///
/// # Errors
/// [`Complaint`] when there is no batch, its ledger cannot be read, or the question not be answered.
pub fn audit(args: &AuditArgs) -> Result<Answer, Complaint> {
    if let Some(AuditCommand::Query { folder, sql, limit, deadline, json }) = &args.command {
        return query(folder, sql, (*limit, *deadline), *json);
    }
    if let Some(AuditCommand::Sign { folder, key, json }) = &args.command {
        return super::signing::sign_batch(folder, key, *json);
    }
    let key = args.key.as_deref().map(super::signing::public_key).transpose()?;
    // The command line demands it where nothing else is asked for.
    let folder = args.folder.clone().unwrap_or_default();
    let audit = look(&folder, args.sample, key.as_ref()).map_err(|e| Complaint::from_error(&e))?;
    let holds = audit.findings.is_empty();
    let lines = audit.findings.iter().take(TOLD).map(|f| match f.id.as_str() {
        "" => f.found.clone(),
        id => format!("{id}: {}", f.found),
    });
    let mut remarks: Vec<_> = lines.collect();
    let more = audit.findings.len().saturating_sub(TOLD);
    if more > 0 {
        remarks.push(format!("and {more} more findings"));
    }
    remarks.extend(audit.unknown.iter().map(|found| format!("not known: {found}")));
    let word = match (holds, audit.unknown.is_empty()) {
        (true, true) => "holds",
        (true, false) => "holds as far as it is chained",
        (false, _) => "does not hold",
    };
    let result = if args.json {
        let finding = |f: &crate::batch::audit::Finding| json!({ "id": f.id, "found": f.found });
        let value = json!({
            "holds": holds && audit.unknown.is_empty(),
            "signed_with": key.as_ref().filter(|_| holds).map(|key| key.id().to_string()),
            "items": audit.items,
            "looked_at": audit.looked_at,
            "findings": audit.findings.iter().map(finding).collect::<Vec<_>>(),
            "not_known": audit.unknown,
        });
        format!("{value:#}\n")
    } else {
        let by = key.as_ref().filter(|_| holds);
        let by = by.map(|key| format!(", signed with key {}", key.id())).unwrap_or_default();
        format!(
            "{word}: {} of {} items looked at, {} findings{by}\n",
            audit.looked_at,
            audit.items,
            audit.findings.len()
        )
    };
    let exit = match (holds, audit.unknown.is_empty()) {
        (true, true) => Exit::Done,
        // Unknown is never a pass.
        (true, false) => Exit::Losses,
        (false, _) => Exit::Failed,
    };
    Ok(Answer { result, remarks, exit })
}

fn query(
    folder: &Path,
    sql: &str,
    (limit, longest): (usize, Duration),
    as_json: bool,
) -> Result<Answer, Complaint> {
    let mut found = ledgers(folder).map_err(|e| Complaint::from_error(&e))?;
    let Some((_, ledger)) = found.pop().filter(|_| found.is_empty()) else {
        let complaint =
            Complaint::failed(format!("{} holds several ledgers, one per shard", folder.display()));
        return Err(
            complaint.hint("ask one shard's folder, or read index.parquet, which has them all")
        );
    };
    if sql.trim().trim_end_matches(';') == SCHEMA {
        return tables(as_json);
    }
    let answered = ledger.ask(sql, limit.saturating_add(1), longest);
    let (names, mut rows) = answered.map_err(|e| unanswered(&e))?;
    let cut = rows.len() > limit;
    rows.truncate(limit);
    let result = if as_json { in_json(&names, &rows) } else { in_columns(&names, &rows) };
    let remarks = if cut {
        vec![format!("only the first {limit} rows are shown: --limit N")]
    } else {
        Vec::new()
    };
    Ok(Answer { result, remarks, exit: Exit::Done })
}

/// Why a question is not answered, and what to ask instead.
fn unanswered(error: &AskError) -> Complaint {
    let complaint = Complaint::from_error(error);
    let is_of_a_name = {
        let line = complaint.line();
        line.contains("no such column") || line.contains("no such table")
    };
    complaint.hint(match error {
        AskError::TooLong { .. } => "--deadline SECONDS gives it more".into(),
        AskError::TooMuch { .. } => "ask for fewer columns, or fewer rows with --limit N".into(),
        AskError::TooWide { .. } => {
            "ask for shorter texts: the ledger itself holds none so long".into()
        }
        _ if is_of_a_name => named_instead(),
        _ => TABLES.to_owned(),
    })
}

/// The columns of the items, and how the others are found.
fn named_instead() -> String {
    let all = columns().unwrap_or_default();
    let items = all.iter().find(|(table, _)| table == "items").map(|(_, of)| of.join(", "));
    match items {
        Some(items) => format!("`items` has {items}; `{SCHEMA}` lists the other tables, too"),
        None => TABLES.to_owned(),
    }
}

/// Every table with its columns.
fn tables(as_json: bool) -> Result<Answer, Complaint> {
    let all = columns().map_err(|e| Complaint::from_error(&e))?;
    let line = |(table, columns): &(String, Vec<String>)| match as_json {
        true => format!("{}\n", json!({ "table": table, "columns": columns })),
        false => format!("{table}\n    {}\n", columns.join(", ")),
    };
    Ok(Answer::done(all.iter().map(line).collect::<String>()))
}

/// One object per line.
fn in_json(names: &[String], rows: &[Vec<Cell>]) -> String {
    let value = |cell: &Cell| match cell {
        Cell::Null | Cell::Blob(_) => Value::Null,
        Cell::Integer(i) => json!(i),
        Cell::Real(r) => json!(r),
        Cell::Text(t) => json!(t),
    };
    let row = |cells: &Vec<Cell>| {
        let object: Map<_, _> = names.iter().cloned().zip(cells.iter().map(value)).collect();
        format!("{}\n", Value::Object(object))
    };
    rows.iter().map(row).collect()
}

/// Tab-separated, the names first.
fn in_columns(names: &[String], rows: &[Vec<Cell>]) -> String {
    let word = |cell: &Cell| match cell {
        Cell::Null | Cell::Blob(_) => String::new(),
        Cell::Integer(i) => i.to_string(),
        Cell::Real(r) => r.to_string(),
        Cell::Text(t) => guard::text::shown(&t.replace(['\t', '\n'], " ")).into_owned(),
    };
    let line = |cells: &Vec<Cell>| cells.iter().map(word).collect::<Vec<_>>().join("\t") + "\n";
    let body: String = rows.iter().map(line).collect();
    let names: Vec<_> = names.iter().map(|name| guard::text::shown(name)).collect();
    format!("{}\n{body}", names.join("\t"))
}
