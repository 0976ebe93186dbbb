//! The outermost layer of a GLB file: header, chunks, and JSON that is safe to parse.

use super::error::GlbError;

const MAGIC: u32 = 0x4654_6C67;
const JSON: u32 = 0x4E4F_534A;
const BIN: u32 = 0x004E_4942;
const HEADER: usize = 12;
const CHUNK_HEADER: usize = 8;

/// Largest JSON chunk, in bytes (16 MiB).
pub const MAX_JSON: usize = 16 << 20;
/// Deepest nesting of arrays and objects in the JSON chunk.
pub const MAX_JSON_DEPTH: usize = 64;

/// The two chunks we read; others are skipped, as the format demands.
#[derive(Clone, Copy, Debug)]
pub(super) struct Container<'a> {
    pub json: &'a [u8],
    pub bin: Option<&'a [u8]>,
}

impl<'a> Container<'a> {
    /// Checks header, chunk ranges and the JSON's size and nesting.
    pub(super) fn parse(bytes: &'a [u8]) -> Result<Self, GlbError> {
        check_header(bytes)?;
        let (mut json, mut bin) = (None, None);
        let mut offset = HEADER;
        for number in 0.. {
            let Some((kind, data)) = chunk_at(bytes, offset)? else { break };
            match (number, kind) {
                (0, JSON) => json = Some(data),
                (0, _) => {
                    return rule("the first chunk must be JSON", format!("kind {kind:#010x}"));
                }
                (_, JSON) => return rule("there may be only one JSON chunk", "a second one"),
                (1, BIN) => bin = Some(data),
                (_, BIN) => return rule("BIN may only be the second chunk", format!("{number}")),
                _ => {}
            }
            offset += CHUNK_HEADER + data.len();
        }
        let Some(json) = json else { return rule("a JSON chunk is needed", "none") };
        check_json(json)?;
        Ok(Self { json, bin })
    }
}

fn rule<T>(rule: &'static str, found: impl Into<String>) -> Result<T, GlbError> {
    Err(GlbError::Container { rule, found: found.into() })
}

fn u32_at(bytes: &[u8], offset: usize) -> Option<u32> {
    let word = bytes.get(offset..offset.checked_add(4)?)?;
    word.try_into().ok().map(u32::from_le_bytes)
}

fn check_header(bytes: &[u8]) -> Result<(), GlbError> {
    let words = [0, 4, 8].map(|o| u32_at(bytes, o));
    let [Some(magic), Some(version), Some(length)] = words else {
        return rule("the header takes 12 bytes", format!("{} bytes", bytes.len()));
    };
    if magic != MAGIC {
        return rule("the file must start with `glTF`", format!("{magic:#010x}"));
    }
    if version != 2 {
        return rule("the version must be 2", version.to_string());
    }
    if length as usize != bytes.len() {
        let found = format!("{length} declared, {} present", bytes.len());
        return rule("the declared length must be the file's", found);
    }
    Ok(())
}

/// Kind and payload of the chunk that starts at `offset`; none at the end of the file.
fn chunk_at(bytes: &[u8], offset: usize) -> Result<Option<(u32, &[u8])>, GlbError> {
    if offset == bytes.len() {
        return Ok(None);
    }
    let (Some(length), Some(kind)) = (u32_at(bytes, offset), u32_at(bytes, offset + 4)) else {
        let found = format!("{} bytes at offset {offset}", bytes.len() - offset);
        return rule("a chunk header takes 8 bytes", found);
    };
    if length % 4 != 0 {
        return rule("a chunk's length must be a multiple of 4", format!("{length} at {offset}"));
    }
    let start = offset + CHUNK_HEADER;
    let end = start.checked_add(length as usize);
    match end.and_then(|end| bytes.get(start..end)) {
        Some(data) => Ok(Some((kind, data))),
        None => rule("a chunk must end inside the file", format!("{length} bytes at {offset}")),
    }
}

/// Size and nesting, from the bytes alone: a parser never sees text that could exhaust it.
pub(crate) fn check_json(json: &[u8]) -> Result<(), GlbError> {
    if json.len() > MAX_JSON {
        let found = format!("{} bytes", json.len());
        return rule("the JSON chunk may have at most 16 MiB", found);
    }
    let (mut depth, mut in_string, mut escaped) = (0usize, false, false);
    for (at, &byte) in json.iter().enumerate() {
        match byte {
            _ if escaped => escaped = false,
            b'\\' if in_string => escaped = true,
            b'"' => in_string = !in_string,
            b'[' | b'{' if !in_string => depth += 1,
            b']' | b'}' if !in_string => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth > MAX_JSON_DEPTH {
            return rule("JSON may nest at most 64 deep", format!("more at byte {at}"));
        }
    }
    Ok(())
}
