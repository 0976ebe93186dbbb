//! `kinfold trace diff`: which input, which stage, which request, which number changed.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use serde_json::{Value, json};
use trace::verify::CALL_BODY;
use trace::{Digest, Happening, Reading, StageEvent};

use crate::cli::speech::{Answer, Complaint, Exit};

/// Most values shown of one file.
const MOST: usize = 20;

/// Compares two traces. Exit 1 if they differ in anything but their times.
///
/// # Errors
/// [`Complaint`] when one cannot be read or is no trace.
pub fn diff(a: &Path, b: &Path, as_json: bool) -> Result<Answer, Complaint> {
    let read = |file: &Path| trace::read(file).map_err(|e| Complaint::from_error(&e));
    let (a, b) = (&Indexed::of(read(a)?), &Indexed::of(read(b)?));
    let mut found = manifests(&a.reading, &b.reading);
    found.extend(stages(a, b));
    let exit = if found.is_empty() { Exit::Done } else { Exit::Failed };
    let result = if as_json {
        let all: Vec<_> =
            found.iter().map(|d| json!({ "where": d.place, "a": d.a, "b": d.b })).collect();
        format!("{:#}\n", json!({ "same": found.is_empty(), "differences": all }))
    } else if found.is_empty() {
        "no difference\n".to_owned()
    } else {
        found.iter().fold(String::new(), |mut out, d| {
            let line = format!("{}: {} -> {}", d.place, d.a, d.b);
            let _ = writeln!(out, "{}", guard::text::shown(&line));
            out
        })
    };
    Ok(Answer { result, remarks: Vec::new(), exit })
}

/// A trace, and where its files stand in it.
struct Indexed {
    reading: Reading,
    by_name: BTreeMap<String, usize>,
    by_digest: BTreeMap<Digest, usize>,
}

impl Indexed {
    fn of(reading: Reading) -> Self {
        let files = || reading.attachments.iter().enumerate().rev();
        let by_name = files().map(|(n, file)| (file.name.clone(), n)).collect();
        let by_digest = files().map(|(n, file)| (Digest::of(&file.bytes), n)).collect();
        Self { reading, by_name, by_digest }
    }

    fn json(&self, place: Option<&usize>) -> Option<Value> {
        serde_json::from_slice(&self.reading.attachments.get(*place?)?.bytes).ok()
    }
}

/// A place where two traces differ, and what stands there.
struct Difference {
    place: String,
    a: String,
    b: String,
}

fn difference(place: impl Into<String>, a: impl ToString, b: impl ToString) -> Difference {
    Difference { place: place.into(), a: a.to_string(), b: b.to_string() }
}

fn manifests(a: &Reading, b: &Reading) -> Vec<Difference> {
    let value = |r: &Reading| {
        let mut value = json!(r.manifest);
        // The digest over the rest: it differs whenever anything does.
        value.as_object_mut().map(|m| m.remove("run_id"));
        value
    };
    values("manifest", &value(a), &value(b))
}

/// Stage by stage, in the order of the first trace.
fn stages(a: &Indexed, b: &Indexed) -> Vec<Difference> {
    let ended = |r: &Indexed| -> Vec<StageEvent> {
        let ends =
            r.reading.events.iter().map(|(_, e)| e).filter(|e| e.event != Happening::Started);
        ends.cloned().collect()
    };
    let (first, second) = (ended(a), ended(b));
    let mut found = vec![];
    for one in &first {
        match second.iter().find(|e| e.stage == one.stage) {
            Some(other) => found.extend(stage((a, one), (b, other))),
            None => found.push(difference(&one.stage, word(one.event), "nothing")),
        }
    }
    let new = second.iter().filter(|e| !first.iter().any(|f| f.stage == e.stage));
    found.extend(new.map(|e| difference(&e.stage, "nothing", word(e.event))));
    found
}

fn stage(
    (a, one): (&Indexed, &StageEvent),
    (b, other): (&Indexed, &StageEvent),
) -> Vec<Difference> {
    let name = &one.stage;
    let mut found = vec![];
    if one.event != other.event {
        found.push(difference(name, word(one.event), word(other.event)));
    }
    let who = |e: &StageEvent| e.identity.clone().unwrap_or_else(|| "nobody".into());
    if one.identity != other.identity {
        found.push(difference(format!("{name}: who answered"), who(one), who(other)));
    }
    found.extend(calls((a, one), (b, other)));
    found.extend(outputs((a, one), (b, other)));
    if one.notes != other.notes {
        found.push(difference(format!("{name}: notes"), json!(one.notes), json!(other.notes)));
    }
    found
}

/// Request by request, in order.
fn calls(
    (a, one): (&Indexed, &StageEvent),
    (b, other): (&Indexed, &StageEvent),
) -> Vec<Difference> {
    let (first, second) = (spoken(a, one), spoken(b, other));
    let mut found = vec![];
    for (n, (x, y)) in first.iter().zip(&second).enumerate() {
        let step = x.get("step").and_then(Value::as_str).unwrap_or("call");
        found.extend(values(&format!("{}: call {} ({step})", one.stage, n + 1), x, y));
    }
    if first.len() != second.len() {
        found.push(difference(format!("{}: calls", one.stage), first.len(), second.len()));
    }
    found
}

/// A stage's calls with what was said in place of its digest.
fn spoken(trace: &Indexed, event: &StageEvent) -> Vec<Value> {
    let said = |call: &mut Value, pointer: &str| {
        let Some(place) = call.pointer_mut(pointer) else { return };
        let name = place.as_str().map(|digest| format!("{CALL_BODY}{digest}"));
        let body = name.and_then(|name| trace.json(trace.by_name.get(&name)));
        if let Some(body) = body {
            *place = body;
        }
    };
    let all: std::collections::BTreeSet<_> = event.calls.iter().collect();
    let named = |bytes: &&Vec<u8>| all.contains(&Digest::of(bytes));
    let calls = trace.reading.calls.iter().filter(named);
    let calls = calls.filter_map(|bytes| serde_json::from_slice::<Value>(bytes).ok());
    calls
        .map(|mut call| {
            call.as_object_mut().map(|c| c.remove("key"));
            ["/body", "/outcome/answered/body"].iter().for_each(|p| said(&mut call, p));
            call
        })
        .collect()
}

/// Artefact by artefact; of JSON that stands in both traces value by value.
fn outputs(
    (a, one): (&Indexed, &StageEvent),
    (b, other): (&Indexed, &StageEvent),
) -> Vec<Difference> {
    let by_name = |e: &StageEvent| -> BTreeMap<String, Digest> {
        e.outputs.iter().map(|o| (o.name.clone(), o.digest.clone())).collect()
    };
    let (first, second) = (by_name(one), by_name(other));
    let names: std::collections::BTreeSet<_> = first.keys().chain(second.keys()).collect();
    let mut found = vec![];
    for name in names {
        let (x, y) = (first.get(name), second.get(name));
        if x == y {
            continue;
        }
        let place = format!("{}: {name}", one.stage);
        let whole = |trace: &Indexed, d: Option<&Digest>| trace.json(trace.by_digest.get(d?));
        let both = whole(a, x).zip(whole(b, y));
        let inside = both.map(|(x, y)| values(&place, &x, &y)).unwrap_or_default();
        if inside.is_empty() {
            let digest = |d: Option<&Digest>| d.map_or("nothing".to_owned(), |d| d.short().into());
            found.push(difference(place, digest(x), digest(y)));
        }
        found.extend(inside);
    }
    found
}

/// The places where two values differ, by JSON pointer.
fn values(place: &str, a: &Value, b: &Value) -> Vec<Difference> {
    let mut found = vec![];
    unequal(place, "", (a, b), &mut found);
    let more = found.len().saturating_sub(MOST);
    found.truncate(MOST);
    if more > 0 {
        found.push(difference(place, format!("and {more} more"), "other values"));
    }
    found
}

fn unequal(place: &str, pointer: &str, (a, b): (&Value, &Value), found: &mut Vec<Difference>) {
    match (a, b) {
        _ if a == b => {}
        (Value::Object(x), Value::Object(y)) => {
            let keys: std::collections::BTreeSet<_> = x.keys().chain(y.keys()).collect();
            for key in keys {
                let pair = (x.get(key).unwrap_or(&Value::Null), y.get(key).unwrap_or(&Value::Null));
                unequal(place, &format!("{pointer}/{key}"), pair, found);
            }
        }
        (Value::Array(x), Value::Array(y)) if x.len() == y.len() => {
            for (n, pair) in x.iter().zip(y).enumerate() {
                unequal(place, &format!("{pointer}/{n}"), pair, found);
            }
        }
        _ => found.push(difference(format!("{place} {pointer}"), brief(a), brief(b))),
    }
}

/// A value in a few words.
fn brief(value: &Value) -> String {
    let text = value.to_string();
    match text.char_indices().nth(80) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}

fn word(event: Happening) -> &'static str {
    match event {
        Happening::Started => "started",
        Happening::Finished => "finished",
        Happening::Failed => "failed",
    }
}
