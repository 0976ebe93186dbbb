//! `index.parquet`: one row per item, the ledger's columns, what each asset nearly repeats and how sure it is.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use guard::folder::{Caps, Entry, Folder, Kind as What};
use parquet::basic::{Compression, Repetition};
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader as _, SerializedFileReader};
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::record::Field;
use parquet::schema::parser::parse_message_type;
use runner::ours::sync_folder;
use rusqlite::types::Value;

use super::error::BatchError;
use super::folder::{io_failed, refused};
use super::ledger::{self, Ledger, LedgerError};
use super::look::near_duplicates;
use super::record::{COLUMNS, CONFIDENCE, Ended, Kind, Record};

/// Name of the index in its folder.
pub const FILE: &str = "index.parquet";
/// The column that the ledger does not have: the first earlier asset that looks the same.
pub const DUPLICATE_OF: &str = "duplicate_of";
/// Rows of a row group.
const GROUP: usize = 5000;

/// Why an index cannot be written or read.
#[derive(Debug, thiserror::Error)]
pub enum IndexError {
    /// The ledger.
    #[error(transparent)]
    Ledger(#[from] LedgerError),
    /// The folder.
    #[error(transparent)]
    Folder(#[from] BatchError),
    /// The format.
    #[error("{}: {source}", path.display())]
    Parquet {
        /// The file.
        path: PathBuf,
        /// What the library said.
        source: ParquetError,
    },
}

/// The ledgers of a batch's folder, with the folder each belongs to: its own and its shards'.
///
/// # Errors
/// [`BatchError`] when one cannot be read, or there is none.
pub fn ledgers(root: &Path) -> Result<Vec<(PathBuf, Ledger)>, BatchError> {
    let mut folders = vec![root.to_path_buf()];
    let looked = Folder::open(root, Caps::default()).and_then(|f| f.list(Path::new(".")));
    for Entry { path, kind } in looked.map_err(refused(root))? {
        if !path.to_string_lossy().starts_with("shard-") {
            continue;
        }
        let path = root.join(path);
        match kind {
            What::Folder => folders.push(path),
            What::Link => {
                let found = "a shard that is a link, which is not followed".into();
                return Err(BatchError::Folder { path, found });
            }
            What::File | What::Other => {}
        }
    }
    folders.sort();
    let mut found = Vec::new();
    for folder in folders {
        if let Some(ledger) = Ledger::open_to_read(&folder.join(ledger::FILE))? {
            found.push((folder, ledger));
        }
    }
    if found.is_empty() {
        let found = format!("it holds no {}, so no batch was made in it", ledger::FILE);
        return Err(BatchError::Folder { path: root.to_path_buf(), found });
    }
    Ok(found)
}

/// Writes the index of a batch's folder anew; returns its path and the number of its rows.
///
/// # Errors
/// [`IndexError`] when a ledger cannot be read or the disk refuses.
pub fn write(root: &Path) -> Result<(PathBuf, u64), IndexError> {
    let ledgers = ledgers(root)?;
    let path = root.join(FILE);
    // A report may be asked for while the batch is at work.
    let partial = root.join(format!("{FILE}.{}.partial", std::process::id()));
    let written = write_all(&partial, &ledgers).and_then(|rows| {
        std::fs::rename(&partial, &path).map_err(io_failed("move into place", &path))?;
        Ok(rows)
    });
    if written.is_err() {
        // Half an index is of use to nobody; that it cannot go is less than why it is half.
        let _ = std::fs::remove_file(&partial);
    }
    let rows = written?;
    sync_folder(root).map_err(io_failed("sync", root))?;
    Ok((path, rows))
}

fn write_all(path: &Path, ledgers: &[(PathBuf, Ledger)]) -> Result<u64, IndexError> {
    let file = runner::ours::create(path).map_err(io_failed("create", path))?;
    let twin = file.try_clone().map_err(io_failed("open", path))?;
    let broken = |source| IndexError::Parquet { path: path.to_path_buf(), source };
    let schema = Arc::new(parse_message_type(&schema()).map_err(broken)?);
    let properties = WriterProperties::builder().set_compression(Compression::UNCOMPRESSED);
    let properties = properties.set_created_by("kinfold".into()).build();
    let mut writer =
        SerializedFileWriter::new(file, schema, Arc::new(properties)).map_err(broken)?;
    let twins = twins(ledgers)?;
    let mut rows: Vec<Vec<Value>> = Vec::new();
    let mut number = 0;
    for (_, ledger) in ledgers {
        ledger.each_item(|record| {
            rows.push(row(&record, twins.get(number).cloned().flatten()));
            number += 1;
            if rows.len() == GROUP {
                group(&mut writer, &std::mem::take(&mut rows)).map_err(broken)?;
            }
            Ok::<(), IndexError>(())
        })?;
    }
    if !rows.is_empty() {
        group(&mut writer, &rows).map_err(broken)?;
    }
    writer.close().map_err(broken)?;
    twin.sync_all().map_err(io_failed("sync", path))?;
    Ok(number as u64)
}

/// For each item, in the order of the index, the id of the asset it nearly repeats.
fn twins(ledgers: &[(PathBuf, Ledger)]) -> Result<Vec<Option<String>>, LedgerError> {
    let (mut ids, mut looks) = (Vec::new(), Vec::new());
    for (_, ledger) in ledgers {
        ledger.each_item(|record| {
            let accepted = record.outcome == Ended::Accepted;
            looks.push(record.look.filter(|_| accepted));
            ids.push(record.id);
            Ok::<(), LedgerError>(())
        })?;
    }
    let name = |n: Option<usize>| n.and_then(|n| ids.get(n).cloned());
    Ok(near_duplicates(&looks).into_iter().map(name).collect())
}

fn row(record: &Record, twin: Option<String>) -> Vec<Value> {
    let mut row: Vec<_> = COLUMNS.iter().map(|(name, _)| record.value(name)).collect();
    row.push(twin.map_or(Value::Null, Value::Text));
    row.push(record.value(CONFIDENCE));
    row
}

fn columns() -> impl Iterator<Item = (&'static str, Kind)> {
    COLUMNS.into_iter().chain([(DUPLICATE_OF, Kind::Text), (CONFIDENCE, Kind::Real)])
}

fn schema() -> String {
    let column = |(name, kind)| {
        let kind = match kind {
            Kind::Text => format!("BYTE_ARRAY {name} (UTF8)"),
            Kind::Integer => format!("INT64 {name}"),
            Kind::Real => format!("DOUBLE {name}"),
        };
        format!("{} {kind};", Repetition::OPTIONAL)
    };
    format!("message item {{ {} }}", columns().map(column).collect::<String>())
}

type Writer = SerializedFileWriter<File>;

fn group(writer: &mut Writer, rows: &[Vec<Value>]) -> Result<(), ParquetError> {
    let mut group = writer.next_row_group()?;
    for (n, (_, kind)) in columns().enumerate() {
        let Some(mut column) = group.next_column()? else { break };
        let values = rows.iter().map(|row| row.get(n).unwrap_or(&Value::Null));
        match kind {
            Kind::Text => fill::<ByteArrayType>(&mut column, values, text)?,
            Kind::Integer => fill::<Int64Type>(&mut column, values, integer)?,
            Kind::Real => fill::<DoubleType>(&mut column, values, real)?,
        }
        column.close()?;
    }
    group.close().map(drop)
}

fn text(value: &Value) -> Option<ByteArray> {
    if let Value::Text(t) = value { Some(t.as_str().into()) } else { None }
}

fn integer(value: &Value) -> Option<i64> {
    if let Value::Integer(i) = value { Some(*i) } else { None }
}

fn real(value: &Value) -> Option<f64> {
    if let Value::Real(r) = value { Some(*r) } else { None }
}

fn fill<'a, T: DataType>(
    column: &mut SerializedColumnWriter<'_>,
    values: impl Iterator<Item = &'a Value>,
    of: impl Fn(&Value) -> Option<T::T>,
) -> Result<(), ParquetError> {
    let (mut there, mut levels) = (Vec::new(), Vec::new());
    for value in values {
        let value = of(value);
        levels.push(i16::from(value.is_some()));
        there.extend(value);
    }
    column.typed::<T>().write_batch(&there, Some(&levels), None).map(drop)
}

/// A row of an index: values by the name of their column.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row(std::collections::BTreeMap<String, Cell>);

/// A value of an index.
#[derive(Clone, Debug, PartialEq)]
enum Cell {
    Text(String),
    Number(f64),
}

impl Row {
    /// The text in a column.
    pub fn text(&self, column: &str) -> Option<&str> {
        if let Some(Cell::Text(t)) = self.0.get(column) { Some(t) } else { None }
    }

    /// The number in a column.
    pub fn number(&self, column: &str) -> Option<f64> {
        if let Some(Cell::Number(n)) = self.0.get(column) { Some(*n) } else { None }
    }
}

/// Reads an index row by row.
///
/// # Errors
/// [`IndexError`] when it cannot be read.
pub fn read(path: &Path, mut each: impl FnMut(Row)) -> Result<(), IndexError> {
    let broken = |source| IndexError::Parquet { path: path.to_path_buf(), source };
    let file = File::open(path).map_err(io_failed("open", path))?;
    let reader = SerializedFileReader::new(file).map_err(broken)?;
    for row in reader.get_row_iter(None).map_err(broken)? {
        let row = row.map_err(broken)?;
        let cell = |(name, field): (&String, &Field)| Some((name.clone(), cell(field)?));
        each(Row(row.get_column_iter().filter_map(cell).collect()));
    }
    Ok(())
}

fn cell(field: &Field) -> Option<Cell> {
    match field {
        Field::Str(text) => Some(Cell::Text(text.clone())),
        Field::Long(n) => Some(Cell::Number(*n as f64)),
        Field::Double(n) => Some(Cell::Number(*n)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use trace::Digest;

    use super::*;

    #[test]
    fn an_index_holds_what_the_ledger_holds() {
        let dir = tempfile::tempdir().unwrap();
        let ledger = Ledger::open(&dir.path().join(ledger::FILE)).unwrap();
        let digest = Digest::of(b"q");
        for n in 0..3 {
            let mut record = Record::new(format!("k{n}"), Ended::Accepted);
            record.cost = f64::from(n) / 4.0;
            record.look = Some(format!("{:032x}", if n == 1 { u128::MAX } else { 7 }));
            record.seconds.insert("articulate".into(), 0.5);
            ledger.add(1, &digest, &[(digest.clone(), record)]).unwrap();
        }
        drop(ledger);
        let (path, rows) = write(dir.path()).unwrap();
        assert_eq!(rows, 3);
        let mut found = Vec::new();
        read(&path, |row| found.push(row)).unwrap();
        assert_eq!(
            found.iter().map(|r| r.text("id").unwrap()).collect::<Vec<_>>(),
            ["k0", "k1", "k2"]
        );
        assert_eq!(found[2].number("cost"), Some(0.5));
        assert_eq!(found[1].number("seconds_articulate"), Some(0.5));
        assert_eq!(found[1].number("seconds_write"), None);
        assert_eq!(
            found.iter().map(|r| r.text(DUPLICATE_OF)).collect::<Vec<_>>(),
            [None, None, Some("k0")]
        );
        let again = std::fs::read(&path).unwrap();
        write(dir.path()).unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), again, "the same ledger gives the same bytes");
    }

    #[test]
    fn a_folder_without_a_ledger_is_no_batch() {
        let dir = tempfile::tempdir().unwrap();
        let error = write(dir.path()).unwrap_err().to_string();
        assert!(error.contains("it holds no ledger.sqlite"), "{error}");
    }
}
