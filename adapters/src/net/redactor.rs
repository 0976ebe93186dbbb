//! Finds secrets in whatever came from outside, in any of their forms, and takes them out.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::sync::Arc;

use aho_corasick::{AhoCorasick, MatchKind};
use base64::Engine as _;
use base64::engine::general_purpose::{STANDARD, URL_SAFE_NO_PAD};
use secrecy::{ExposeSecret as _, SecretString};
use serde_json::Value;
use ureq::http::Uri;

use super::disguise::View;
use super::hidden::{HIDDEN, QUERY_KEYS};

/// Shortest secret that is looked for, characters: a shorter one would be found everywhere.
const SHORTEST: usize = 8;
/// So many characters of a secret in a row give it away; a guess, between the common beginnings of
/// keys (`sk-ant-api03-` says nothing) and the half of a short key.
const PIECE: usize = 12;
/// Fewest different characters of such a piece: zeros in a row are no secret, and stand everywhere.
const DIFFERENT: usize = 4;
/// How often escapes are decoded: JSON in JSON in JSON doubles its backslashes each time.
const ESCAPES: usize = 5;
/// How often base64 is decoded: once more than the twice that services are known to do.
const BASE64: usize = 3;
/// Text up to this is decoded; longer bodies, which are meshes, are searched as they are, bytes.
const LARGEST_TEXT: usize = 16 << 20;
/// The same of a body that is no text by its bytes.
const LARGEST_BINARY: usize = 1 << 20;
/// Longest text, bytes, that may say a part of a secret; pictures are longer.
const LONGEST_SPLIT: usize = 1 << 16;
/// Words before the key in an `authorization` header.
const SCHEMES: [&str; 4] = ["Bearer ", "Basic ", "Key ", "Token "];

/// Takes a set of secrets out of texts, values and files: plain in any case, reversed, in hex,
/// base32 and base64, escaped as JSON, HTML or in a URL, wrapped, and nested in each other; twelve
/// characters of one in a row count.
///
/// Promise: the same text gives the same, and what hides nothing keeps its bytes.
#[derive(Clone, Default)]
pub struct Redactor {
    finder: Option<Arc<AhoCorasick>>,
}

impl std::fmt::Debug for Redactor {
    /// Shows no secret.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let patterns = self.finder.as_ref().map_or(0, |f| f.patterns_len());
        write!(f, "Redactor of {patterns} patterns")
    }
}

impl Redactor {
    /// Whoever takes these secrets out: whole headers, keys, passwords.
    pub fn new<'a>(secrets: impl IntoIterator<Item = &'a SecretString>) -> Self {
        let mut patterns = BTreeSet::new();
        for secret in secrets {
            parts(secret.expose_secret()).for_each(|part| disguises(part, &mut patterns));
        }
        if patterns.is_empty() {
            return Self::default();
        }
        let mut builder = AhoCorasick::builder();
        builder.ascii_case_insensitive(true).match_kind(MatchKind::Standard);
        // Patterns are short and few: no limit of the library is near.
        Self { finder: builder.build(patterns).ok().map(Arc::new) }
    }

    /// Whether there is nothing to look for.
    pub fn is_idle(&self) -> bool {
        self.finder.is_none()
    }

    /// Whether a secret is one of those that are taken out.
    pub(super) fn hides(&self, secret: &str) -> bool {
        parts(secret).all(|part| part.len() < SHORTEST || self.text(part) == HIDDEN)
    }

    /// Whether a text holds a secret in any form.
    pub fn finds(&self, text: &str) -> bool {
        !self.places(text.as_bytes()).is_empty()
    }

    /// A text without secrets.
    pub fn text<'t>(&self, text: &'t str) -> Cow<'t, str> {
        let places = self.places(text.as_bytes());
        if places.is_empty() {
            return Cow::Borrowed(text);
        }
        let mut kept = String::new();
        let mut end = 0;
        for place in places {
            let start = text.floor_char_boundary(place.start).max(end);
            kept.push_str(&text[end..start]);
            kept.push_str(HIDDEN);
            end = text.ceil_char_boundary(place.end).max(start);
        }
        kept.push_str(&text[end..]);
        Cow::Owned(kept)
    }

    /// Takes secrets out of every text of a value, keys included, and out of texts under one key
    /// that say one only together; says whether there were any.
    pub fn value(&self, value: &mut Value) -> bool {
        if self.is_idle() {
            return false;
        }
        self.split(value) | self.each_text(value)
    }

    /// Takes out texts under one key that say a secret only together.
    fn split(&self, value: &mut Value) -> bool {
        let mut joined = BTreeMap::new();
        join("", value, &mut joined);
        joined.retain(|_, (count, text)| *count > 1 && self.finds(text));
        let split: BTreeSet<String> = joined.into_keys().collect();
        if !split.is_empty() {
            hide_all("", value, &split);
        }
        !split.is_empty()
    }

    fn each_text(&self, value: &mut Value) -> bool {
        let hidden = match value {
            Value::String(text) => match self.text(text) {
                Cow::Borrowed(_) => return false,
                Cow::Owned(hidden) => hidden,
            },
            Value::Number(number) => match self.text(&number.to_string()) {
                Cow::Borrowed(_) => return false,
                Cow::Owned(hidden) => hidden,
            },
            Value::Array(items) => {
                return items.iter_mut().fold(false, |any, item| self.each_text(item) | any);
            }
            Value::Object(map) => {
                let told = map.keys().any(|key| self.finds(key));
                if told {
                    let entries = std::mem::take(map).into_iter();
                    map.extend(entries.map(|(key, v)| (self.text(&key).into_owned(), v)));
                }
                return map.values_mut().fold(told, |any, item| self.each_text(item) | any);
            }
            _ => return false,
        };
        *value = Value::String(hidden);
        true
    }

    /// A body without secrets: JSON stays JSON, a GLB stays a GLB, and other bytes keep their number.
    pub fn body(&self, bytes: Vec<u8>) -> Vec<u8> {
        if self.is_idle() {
            return bytes;
        }
        if let Some(glb) = self.glb(&bytes) {
            return glb;
        }
        match std::str::from_utf8(&bytes) {
            Ok(text) if bytes.len() <= LARGEST_TEXT => match self.document(text) {
                Cow::Borrowed(_) => bytes,
                Cow::Owned(hidden) => hidden.into_bytes(),
            },
            _ if bytes.len() <= LARGEST_BINARY => {
                let places = self.places(&bytes);
                filled(bytes, &places)
            }
            _ => {
                let places = merged(self.plain(&View::of(&bytes)));
                filled(bytes, &places)
            }
        }
    }

    /// A text, or JSON, which stays JSON.
    fn document<'t>(&self, text: &'t str) -> Cow<'t, str> {
        let parsed: Option<Value> = serde_json::from_str(text).ok();
        let Some(mut value) = parsed.filter(|v| v.is_object() || v.is_array()) else {
            return self.text(text);
        };
        // What no text holds may still be told by several, and a key that stands twice is two in
        // the text and one in the value.
        let told = self.finds(text);
        let hidden = if told { self.value(&mut value) } else { self.split(&mut value) };
        if !told && !hidden {
            return Cow::Borrowed(text);
        }
        let hidden = value.to_string();
        if self.finds(&hidden) {
            return Cow::Owned(Value::from(HIDDEN).to_string());
        }
        Cow::Owned(hidden)
    }

    /// A GLB whose JSON and bytes are searched each in its own way; none if it is no GLB, or holds
    /// nothing. Source: the glTF 2.0 specification, section 4.4.
    fn glb(&self, bytes: &[u8]) -> Option<Vec<u8>> {
        let word = |at: usize| {
            let word: [u8; 4] = bytes.get(at..at + 4)?.try_into().ok()?;
            usize::try_from(u32::from_le_bytes(word)).ok()
        };
        if !bytes.starts_with(b"glTF") || bytes.get(16..20) != Some(b"JSON") {
            return None;
        }
        let end = word(12)?.checked_add(20)?;
        let json = std::str::from_utf8(bytes.get(20..end)?).ok()?;
        let rest = filled_in(self, &bytes[end..]);
        let hidden = self.document(json);
        let Cow::Owned(mut json) = hidden else {
            return rest.map(|rest| [&bytes[..end], &rest].concat());
        };
        json.push_str(&"   "[..json.len().wrapping_neg() % 4]);
        let rest = rest.unwrap_or_else(|| bytes[end..].to_vec());
        let length = |n: usize| u32::try_from(n).map(u32::to_le_bytes).ok();
        let (all, own) = (length(20 + json.len() + rest.len())?, length(json.len())?);
        Some([&bytes[..8], &all, &own, b"JSON", json.as_bytes(), &rest].concat())
    }

    /// Where a text holds a secret in any form, in order and apart.
    fn places(&self, text: &[u8]) -> Vec<Range<usize>> {
        if self.is_idle() || text.len() < SHORTEST {
            return vec![];
        }
        let mut found = vec![];
        self.look(View::of(text), BASE64, &mut found);
        whole_words(text, merged(found))
    }

    /// Looks at a text as it stands, with its escapes decoded, without white space, and at what its
    /// base64 says.
    fn look(&self, view: View<'_>, depth: usize, found: &mut Vec<Range<usize>>) {
        found.extend(self.plain(&view));
        let mut view = view;
        for _ in 0..ESCAPES {
            let Some(next) = view.unescaped() else { break };
            found.extend(self.plain(&next));
            view = next;
        }
        let compacted = view.compacted();
        found.extend(compacted.iter().flat_map(|view| self.plain(view)));
        if depth > 0 {
            for view in std::iter::once(&view).chain(&compacted) {
                view.decoded().into_iter().for_each(|view| self.look(view, depth - 1, found));
                // One more form within hexadecimal digits or base32: nothing is known to do more.
                for inner in view.hex_decoded().into_iter().chain(view.base32_decoded()) {
                    found.extend(self.plain(&inner));
                }
            }
        }
    }

    /// Where patterns stand in a view, by the places of the original.
    fn plain(&self, view: &View<'_>) -> Vec<Range<usize>> {
        let matches = self.finder.iter().flat_map(|f| f.find_overlapping_iter(&*view.bytes));
        matches.map(|m| view.origin(m.range())).collect()
    }
}

/// What in an address is nobody's business: user, password and the values of its query, save those
/// known to be harmless.
pub fn in_address(url: &str) -> Vec<SecretString> {
    let Ok(uri) = url.parse::<Uri>() else { return vec![] };
    let user = uri.authority().and_then(|a| a.as_str().rsplit_once('@'));
    let user = user.into_iter().flat_map(|(user, _)| user.split(':').map(String::from));
    let pairs = uri.query().into_iter().flat_map(|q| q.split('&'));
    let pairs = pairs.filter_map(|pair| pair.split_once('='));
    let values = pairs.filter(|(key, _)| !QUERY_KEYS.contains(key)).map(|(_, v)| v.to_owned());
    let told = user.chain(values).flat_map(|text| {
        let plain = View::of(text.as_bytes()).unescaped();
        let plain = plain.map(|v| String::from_utf8_lossy(&v.bytes).into_owned());
        [Some(text), plain].into_iter().flatten()
    });
    told.map(SecretString::from).collect()
}

/// What of a secret is looked for: the key behind its scheme; of a signed header, who signed and
/// the signature.
fn parts(secret: &str) -> impl Iterator<Item = &str> {
    let signed = secret.contains("Signature=");
    let bare = SCHEMES.iter().find_map(|scheme| secret.strip_prefix(scheme));
    let whole = (!signed).then(|| bare.unwrap_or(secret));
    let piece = move |name: &'static str| secret.split_once(name)?.1.split(['/', ',', ' ']).next();
    let signed = ["Credential=", "Signature="].into_iter().filter_map(piece);
    whole.into_iter().chain(signed)
}

/// Every form of every piece of a secret that is looked for byte by byte, in any case.
fn disguises(secret: &str, patterns: &mut BTreeSet<Vec<u8>>) {
    let bare: String = secret.split_whitespace().collect();
    for text in [secret, &bare] {
        let bytes = text.as_bytes();
        if bytes.len() < SHORTEST {
            continue;
        }
        for piece in bytes.windows((bytes.len() - 1).clamp(SHORTEST, PIECE)) {
            if piece.iter().collect::<BTreeSet<_>>().len() >= DIFFERENT {
                disguised(piece, patterns);
            }
        }
    }
}

fn disguised(piece: &[u8], patterns: &mut BTreeSet<Vec<u8>>) {
    let backwards: Vec<u8> = piece.iter().rev().copied().collect();
    let swap = |b: &u8| {
        if b.is_ascii_lowercase() { b.to_ascii_uppercase() } else { b.to_ascii_lowercase() }
    };
    let swapped = piece.iter().map(swap).collect();
    for text in [piece.to_vec(), piece.to_ascii_lowercase(), piece.to_ascii_uppercase(), swapped] {
        encoded(&text, patterns);
    }
    encoded(&backwards, patterns);
    for between in [":", "-", ", 0x", ",0x", " 0x"] {
        patterns.insert(hex(piece, between).into_bytes());
    }
    patterns.extend([piece.to_vec(), backwards]);
}

fn encoded(text: &[u8], patterns: &mut BTreeSet<Vec<u8>>) {
    let mut add = |form: Vec<u8>| {
        // Written backwards as a whole, too.
        patterns.insert(form.iter().rev().copied().collect());
        patterns.insert(form);
    };
    add(hex(text, "").into_bytes());
    for offset in 0..3 {
        inside_base64(text, offset).into_iter().for_each(&mut add);
    }
    for offset in 0..5 {
        BASE32.iter().for_each(|letters| add(inside_base32(text, offset, letters)));
    }
}

/// The alphabets of base32 and base32hex: RFC 4648, sections 6 and 7.
const BASE32: [&[u8; 32]; 2] =
    [b"ABCDEFGHIJKLMNOPQRSTUVWXYZ234567", b"0123456789ABCDEFGHIJKLMNOPQRSTUV"];

fn hex(text: &[u8], between: &str) -> String {
    text.iter().map(|b| format!("{b:02x}")).collect::<Vec<_>>().join(between)
}

/// The letters of a text inside the base64 of a longer one, `offset` bytes behind a multiple of
/// three: those that do not depend on its neighbours; in both alphabets.
fn inside_base64(text: &[u8], offset: usize) -> [Vec<u8>; 2] {
    let bytes = [&[0; 3][..offset.min(3)], text].concat();
    let (first, end) = ((offset * 8).div_ceil(6), bytes.len() * 8 / 6);
    let cut = |letters: String| letters.get(first..end).unwrap_or_default().as_bytes().to_vec();
    [cut(STANDARD.encode(&bytes)), cut(URL_SAFE_NO_PAD.encode(&bytes))]
}

/// The same inside base32 of these letters, `offset` bytes behind a multiple of five.
fn inside_base32(text: &[u8], offset: usize, alphabet: &[u8; 32]) -> Vec<u8> {
    let bytes = [&[0; 5][..offset.min(5)], text].concat();
    let bit = |i: usize| bytes[i / 8] >> (7 - i % 8) & 1;
    let letter = |n: usize| (0..5).fold(0, |value, i| value << 1 | bit(n * 5 + i));
    let letters = (offset * 8).div_ceil(5)..bytes.len() * 8 / 5;
    letters.map(|n| alphabet[usize::from(letter(n)) % 32]).collect()
}

/// Ranges in order, those that touch made one.
fn merged(mut found: Vec<Range<usize>>) -> Vec<Range<usize>> {
    found.sort_unstable_by_key(|r| (r.start, r.end));
    let mut apart: Vec<Range<usize>> = vec![];
    for range in found {
        match apart.last_mut() {
            Some(last) if range.start <= last.end => last.end = last.end.max(range.end),
            _ => apart.push(range),
        }
    }
    apart
}

/// The same, as far as the letters and digits around reach: what is left of a key, and the edge of
/// an encoding.
fn whole_words(text: &[u8], found: Vec<Range<usize>>) -> Vec<Range<usize>> {
    let mut grown: Vec<Range<usize>> = vec![];
    for range in found {
        let least = grown.last().map_or(0, |last| last.end);
        if range.end <= least {
            continue;
        }
        let mut start = range.start.max(least);
        while start > least && text[start - 1].is_ascii_alphanumeric() {
            start -= 1;
        }
        let more = text[range.end..].iter().take_while(|b| b.is_ascii_alphanumeric());
        grown.push(start..range.end + more.count());
    }
    merged(grown)
}

/// Bytes with others in these places, as many.
fn filled(mut bytes: Vec<u8>, places: &[Range<usize>]) -> Vec<u8> {
    for place in places {
        bytes[place.clone()].fill(b'*');
    }
    bytes
}

/// The bytes of a GLB behind its JSON without secrets; none if they hold none.
fn filled_in(redactor: &Redactor, bytes: &[u8]) -> Option<Vec<u8>> {
    let places = merged(redactor.plain(&View::of(bytes)));
    (!places.is_empty()).then(|| filled(bytes.to_vec(), &places))
}

/// All texts under each key, one behind the other; those of an array under its own.
fn join(key: &str, value: &Value, joined: &mut BTreeMap<String, (usize, String)>) {
    match value {
        Value::String(text) if text.len() <= LONGEST_SPLIT => {
            let (count, all) = joined.entry(key.to_owned()).or_default();
            *count += 1;
            all.push_str(text);
        }
        Value::Array(items) => items.iter().for_each(|item| join(key, item, joined)),
        Value::Object(map) => map.iter().for_each(|(key, item)| join(key, item, joined)),
        _ => {}
    }
}

fn hide_all(key: &str, value: &mut Value, split: &BTreeSet<String>) {
    match value {
        Value::String(text) if split.contains(key) => HIDDEN.clone_into(text),
        Value::Array(items) => items.iter_mut().for_each(|item| hide_all(key, item, split)),
        Value::Object(map) => map.iter_mut().for_each(|(key, item)| hide_all(key, item, split)),
        _ => {}
    }
}

#[cfg(test)]
#[path = "redactor_tests.rs"]
mod tests;
