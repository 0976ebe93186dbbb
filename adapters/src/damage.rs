//! Answers as no service should give them, for tests: fields dropped, retyped and nested wrongly,
//! numbers out of range, bytes torn.

use rand::RngExt as _;
use rand_pcg::Pcg64Mcg;
use serde_json::{Value, json};

/// An answer that is still JSON, with one to three damages; what is no JSON stays as it is.
pub(crate) fn misshapen(body: &[u8], rng: &mut Pcg64Mcg) -> Vec<u8> {
    let Ok(mut value) = serde_json::from_slice::<Value>(body) else { return body.to_vec() };
    for _ in 0..rng.random_range(1..4) {
        let mut at = rng.random_range(0..nodes(&value));
        let other = nth(&mut value.clone(), &mut rng.random_range(0..nodes(&value))).cloned();
        if let Some(node) = nth(&mut value, &mut at) {
            damage(node, other.unwrap_or_default(), rng);
        }
    }
    value.to_string().into_bytes()
}

/// The lines of a stream of events, with the data of some misshapen and some lines lost.
pub(crate) fn misshapen_events(body: &[u8], rng: &mut Pcg64Mcg) -> Vec<u8> {
    let mut told = vec![];
    for line in body.split_inclusive(|b| *b == b'\n') {
        match (rng.random_range(0..4), line.strip_prefix(b"data:")) {
            (0, _) => {}
            (1, Some(data)) => {
                told.extend_from_slice(b"data:");
                told.extend(misshapen(data.trim_ascii(), rng));
                told.push(b'\n');
            }
            _ => told.extend_from_slice(line),
        }
    }
    told
}

/// Bytes changed, lost and added, or nothing of the answer at all.
pub(crate) fn torn(body: &[u8], rng: &mut Pcg64Mcg) -> Vec<u8> {
    let mut bytes = match rng.random_range(0..8) {
        0 => (0..rng.random_range(0..64)).map(|_| rng.random()).collect(),
        1 => b"[".repeat(rng.random_range(1..5000)),
        2 => b"{\"a\":1e999}".to_vec(),
        _ => body.to_vec(),
    };
    for _ in 0..rng.random_range(1..4) {
        let at = rng.random_range(0..=bytes.len());
        match rng.random_range(0..3) {
            0 => bytes.truncate(at),
            1 => bytes.insert(at, rng.random()),
            _ => drop(bytes.drain(..at.min(3))),
        }
    }
    bytes
}

fn nodes(value: &Value) -> usize {
    match value {
        Value::Array(items) => 1 + items.iter().map(nodes).sum::<usize>(),
        Value::Object(map) => 1 + map.values().map(nodes).sum::<usize>(),
        _ => 1,
    }
}

/// The node that so many come before.
fn nth<'v>(value: &'v mut Value, before: &mut usize) -> Option<&'v mut Value> {
    if *before == 0 {
        return Some(value);
    }
    *before -= 1;
    match value {
        Value::Array(items) => items.iter_mut().find_map(|item| nth(item, before)),
        Value::Object(map) => map.values_mut().find_map(|value| nth(value, before)),
        _ => None,
    }
}

fn damage(node: &mut Value, other: Value, rng: &mut Pcg64Mcg) {
    let whole = node.take();
    *node = match (rng.random_range(0..6), whole) {
        (0, Value::Object(mut map)) => {
            let at = rng.random_range(0..=map.len());
            let lost = map.keys().nth(at).cloned();
            if let Some(key) = lost {
                map.remove(&key);
            }
            Value::Object(map)
        }
        (0, Value::Array(mut items)) => {
            items.truncate(rng.random_range(0..=items.len()));
            Value::Array(items)
        }
        (1, whole) => json!([whole]),
        (2, whole) => json!({ "url": whole, "path": other }),
        (3, whole) => json!([other, whole]),
        (4, _) => other,
        _ => strange(rng),
    };
}

/// A value that nobody would send.
fn strange(rng: &mut Pcg64Mcg) -> Value {
    let deep = |n| (0..n).fold(json!({}), |inner, _| json!([inner]));
    let values = [
        Value::Null,
        json!(true),
        json!(-1),
        json!(u64::MAX),
        json!(i64::MIN),
        json!(1e308),
        json!(-5e-324),
        json!(""),
        json!("\u{0}\u{202e}\u{1b}[2J ё.glb"),
        json!("x".repeat(5000)),
        json!("https://"),
        json!("{\"token\":\"a\"}"),
        json!([]),
        json!({}),
        deep(60),
    ];
    values[rng.random_range(0..values.len())].clone()
}
