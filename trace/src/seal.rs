//! The seal at a trace's end: one digest over every byte before it, so that no bit can change unseen.
//!
//! The seal is a private MCAP record, which readers pass over. What stands behind it, the index of
//! the file, is covered by the checksums MCAP prescribes. A seal gives damage away; who means to
//! deceive can write a new one, and is found out by running the trace again.
//!
//! ```
//! # use trace::{Manifest, Recorder};
//! # let dir = tempfile::tempdir()?;
//! # let path = dir.path().join("trace.mcap");
//! # let (inputs, parameters) = Default::default();
//! # let (run_id, flow, version) = ("r".into(), "toy".into(), "1".into());
//! # let manifest = Manifest { run_id, flow, version, seed: 7, inputs, parameters };
//! # Recorder::create(&path, &manifest, 1)?.finish()?;
//! let mut bytes = std::fs::read(&path)?;
//! assert_eq!(trace::seal::check(&bytes), Ok(()));
//!
//! bytes[100] ^= 1;
//! assert!(trace::seal::check(&bytes).is_err());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use crate::digest::Digest;

/// Opcode of the record; MCAP leaves 0x80 and above to applications.
pub(crate) const OPCODE: u8 = 0x90;
/// How the record begins; the digest's 64 digits follow.
const WORD: &[u8] = b"kinfold-seal/1 ";
/// Opcode and length before a record's content, bytes.
const HEAD: usize = 9;
/// Length of the record, bytes.
const SEAL: usize = HEAD + WORD.len() + 64;
/// Length of the record that ends the data, bytes.
const DATA_END: usize = HEAD + 4;
/// Length of the record that ends the file, bytes.
const FOOTER: usize = HEAD + 20;

/// The content of the seal over some bytes.
pub(crate) fn content(bytes: &[u8]) -> Vec<u8> {
    [WORD, Digest::of(bytes).as_str().as_bytes()].concat()
}

/// Whether a trace is whole and every bit of it as it was when it was sealed.
///
/// # Errors
/// What is wrong, in words.
pub fn check(trace: &[u8]) -> Result<(), String> {
    let torn = || "it ends before its seal: the run that wrote it did not end".to_owned();
    let magic = trace.len().checked_sub(mcap::MAGIC.len()).ok_or_else(torn)?;
    if trace.get(magic..) != Some(mcap::MAGIC) {
        return Err(torn());
    }
    let footer = magic.checked_sub(FOOTER).ok_or_else(torn)?;
    let index = index_start(trace.get(footer..magic).ok_or_else(torn)?)?;
    let sum = u32_at(trace, magic.saturating_sub(4)).ok_or_else(torn)?;
    let indexed = trace.get(index..magic.saturating_sub(4));
    if indexed.is_none_or(|bytes| crc32fast::hash(bytes) != sum) {
        return Err("its index is damaged: the checksum is another".to_owned());
    }
    data_end_holds(trace, index)?;
    seal_holds(trace, index.saturating_sub(DATA_END))
}

/// Where the footer says that the index begins.
fn index_start(footer: &[u8]) -> Result<usize, String> {
    let broken = || "its footer is damaged".to_owned();
    let head = footer.get(..HEAD).ok_or_else(broken)?;
    let start = footer.get(HEAD..HEAD + 8).and_then(|b| <[u8; 8]>::try_from(b).ok());
    if head != record_head(0x02, 20) {
        return Err(broken());
    }
    start.and_then(|b| usize::try_from(u64::from_le_bytes(b)).ok()).ok_or_else(broken)
}

fn data_end_holds(trace: &[u8], index: usize) -> Result<(), String> {
    let broken = || "the record between its data and its index is damaged".to_owned();
    let at = index.checked_sub(DATA_END).ok_or_else(broken)?;
    let (data, end) = (trace.get(..at), trace.get(at..index));
    let (data, end) = data.zip(end).ok_or_else(broken)?;
    let sum = crc32fast::hash(data).to_le_bytes();
    let whole = [&record_head(0x0f, 4)[..], &sum[..]].concat();
    if end == whole { Ok(()) } else { Err(broken()) }
}

fn seal_holds(trace: &[u8], end: usize) -> Result<(), String> {
    let none = || "it has no seal: the run that wrote it did not end".to_owned();
    let start = end.checked_sub(SEAL).ok_or_else(none)?;
    let (sealed, seal) = trace.get(..start).zip(trace.get(start..end)).ok_or_else(none)?;
    let head = record_head(OPCODE, (SEAL - HEAD) as u64);
    let content_found = seal.strip_prefix(&head[..]).ok_or_else(none)?;
    if content_found == content(sealed) {
        return Ok(());
    }
    Err("its bytes are not the ones that were sealed".to_owned())
}

fn record_head(opcode: u8, length: u64) -> [u8; HEAD] {
    let mut head = [opcode; HEAD];
    head[1..].copy_from_slice(&length.to_le_bytes());
    head
}

fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    let four = bytes.get(at..at.checked_add(4)?)?;
    Some(u32::from_le_bytes(four.try_into().ok()?))
}
