//! Zip archives as PyTorch writes them: entries stored as they are, found through the directory.

use std::collections::BTreeMap;
use std::io::{Read, Seek, SeekFrom};

use super::checkpoint::ConvertError;

/// Most entries, and most bytes of directory, that are read.
const MAX_ENTRIES: usize = 100_000;
const MAX_DIRECTORY: u64 = 64 << 20;
/// The end record is this long, and a comment of at most 65,535 bytes may follow it.
const END_RECORD: u64 = 22;

/// Where an entry's bytes lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Entry {
    header: u64,
    size: u64,
}

/// An archive whose directory was read.
#[derive(Debug)]
pub(crate) struct Archive<R> {
    reader: R,
    length: u64,
    entries: BTreeMap<String, Entry>,
}

impl<R: Read + Seek> Archive<R> {
    pub(crate) fn open(mut reader: R) -> Result<Self, ConvertError> {
        let length = reader.seek(SeekFrom::End(0))?;
        let tail_at = length.saturating_sub(END_RECORD + u64::from(u16::MAX));
        let mut tail = Vec::new();
        reader.seek(SeekFrom::Start(tail_at))?;
        reader.by_ref().take(END_RECORD + u64::from(u16::MAX)).read_to_end(&mut tail)?;
        let end = tail.windows(4).rposition(|w| w == b"PK\x05\x06");
        let end = end.ok_or_else(|| zip("no end-of-directory record: not a zip file"))?;
        let record = Fields(tail.get(end..).unwrap_or(&[]));
        let (size, from) = (u64::from(record.u32(12)?), u64::from(record.u32(16)?));
        if from == u64::from(u32::MAX) || size > MAX_DIRECTORY || from + size > length {
            let rule = "its directory must lie inside the file and have no zip64 extension";
            return Err(zip(format!("{rule}, found {size} bytes at {from} of {length}")));
        }
        let mut directory = vec![0; size as usize];
        reader.seek(SeekFrom::Start(from))?;
        reader.read_exact(&mut directory)?;
        let entries = entries(&directory, usize::from(record.u16(10)?))?;
        Ok(Self { reader, length, entries })
    }

    /// Names of all entries, sorted.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.entries.keys().map(String::as_str)
    }

    /// Length of an entry.
    pub(crate) fn size(&self, name: &str) -> Option<u64> {
        self.entries.get(name).map(|e| e.size)
    }

    /// All bytes of an entry; at most `limit` of them.
    pub(crate) fn read(&mut self, name: &str, limit: u64) -> Result<Vec<u8>, ConvertError> {
        let entry = *self.entries.get(name).ok_or_else(|| zip(format!("no entry `{name}`")))?;
        if entry.size > limit {
            return Err(zip(format!(
                "entry `{name}` has {} bytes, at most {limit} are read",
                entry.size
            )));
        }
        let mut header = [0; 30];
        self.reader.seek(SeekFrom::Start(entry.header))?;
        self.reader.read_exact(&mut header)?;
        let fields = Fields(&header);
        if fields.u32(0)? != 0x0403_4b50 {
            return Err(zip(format!("entry `{name}` has no header")));
        }
        let from = entry.header + 30 + u64::from(fields.u16(26)?) + u64::from(fields.u16(28)?);
        if from.checked_add(entry.size).is_none_or(|end| end > self.length) {
            return Err(zip(format!("entry `{name}` reaches beyond the end of the file")));
        }
        let mut bytes = vec![0; entry.size as usize];
        self.reader.seek(SeekFrom::Start(from))?;
        self.reader.read_exact(&mut bytes)?;
        Ok(bytes)
    }
}

fn entries(directory: &[u8], count: usize) -> Result<BTreeMap<String, Entry>, ConvertError> {
    if count > MAX_ENTRIES {
        return Err(zip(format!("at most {MAX_ENTRIES} entries are read, found {count}")));
    }
    let mut entries = BTreeMap::new();
    let mut at = 0;
    for _ in 0..count {
        let fields = Fields(directory.get(at..).unwrap_or(&[]));
        let [name, extra, comment] = [28, 30, 32].map(|i| fields.u16(i).map(usize::from));
        let name = fields.0.get(46..46 + name?).ok_or_else(|| zip("its directory is cut short"))?;
        let text = std::str::from_utf8(name).map_err(|_| zip("an entry's name is not UTF-8"))?;
        let (method, packed, size) = (fields.u16(10)?, fields.u32(20)?, fields.u32(24)?);
        if method != 0 || packed != size || size == u32::MAX {
            return Err(zip(format!(
                "entry `{text}` must be stored as it is, found method {method}"
            )));
        }
        let entry = Entry { header: fields.u32(42)?.into(), size: size.into() };
        if entries.insert(text.to_owned(), entry).is_some() {
            return Err(zip(format!("two entries are called `{text}`")));
        }
        at += 46 + name.len() + extra? + comment?;
    }
    Ok(entries)
}

/// Little-endian fields of a record.
struct Fields<'a>(&'a [u8]);

impl Fields<'_> {
    fn u16(&self, at: usize) -> Result<u16, ConvertError> {
        let bytes = self.0.get(at..at + 2).and_then(|b| b.try_into().ok());
        bytes.map(u16::from_le_bytes).ok_or_else(|| zip("a record is cut short"))
    }

    fn u32(&self, at: usize) -> Result<u32, ConvertError> {
        let bytes = self.0.get(at..at + 4).and_then(|b| b.try_into().ok());
        bytes.map(u32::from_le_bytes).ok_or_else(|| zip("a record is cut short"))
    }
}

fn zip(what: impl Into<String>) -> ConvertError {
    ConvertError::Archive(what.into())
}
