//! A statement about one asset: what it is made of, by whom, under which licence, and where every
//! number comes from. In the form of an in-toto statement, so that other people's tools read it.

use std::collections::BTreeMap;

use runner::Outcome;
use serde_json::{Value, json};
use trace::Digest;

use super::manifest::Item;
use crate::recording::VERSION;
use crate::stages::Tools;
use crate::stages::bundle::Files;

/// What sort of statement it is.
const PREDICATE: &str = "urn:kinfold:attestation:1";

/// The statement about an asset whose files have these digests. The same asset gives the same bytes.
pub fn statement(
    item: &Item,
    tools: &Tools,
    outcome: &Outcome,
    files: &Files,
    digests: &BTreeMap<String, Digest>,
) -> Vec<u8> {
    let subject: Vec<_> = digests
        .iter()
        .map(|(name, digest)| json!({ "name": name, "digest": { "blake3": digest } }))
        .collect();
    let mut statement = json!({
        "_type": "https://in-toto.io/Statement/v1",
        "subject": subject,
        "predicateType": PREDICATE,
        "predicate": {
            "id": item.id,
            "category": item.category,
            "license": item.license,
            "flow": "image-to-urdf",
            "version": VERSION,
            "seed": tools.seed,
            "providers": {
                "mesh": tools.image_to_3d.identity().ok(),
                "condition": tools.vlm.identity().ok(),
                "articulation": tools.articulate.identity(),
            },
            "stages": stages(outcome),
            "verdict": verdict(files),
            "origins": origins(files),
        },
    });
    // Somebody who was not asked is not listed.
    if let Some(critic) = &tools.critic {
        statement["predicate"]["providers"]["critic"] = json!(critic.identity().ok());
    }
    serde_json::to_vec_pretty(&statement)
        .map(|mut text| {
            text.push(b'\n');
            text
        })
        .unwrap_or_default()
}

fn stages(outcome: &Outcome) -> Vec<Value> {
    let one = |node: &runner::outcome::NodeOutcome| {
        json!({
            "stage": node.stage,
            "key": node.key,
            "output": node.output.as_ref().map(|(digest, _)| digest),
            "notes": node.notes.iter().map(|n| &n.message).collect::<Vec<_>>(),
        })
    };
    outcome.nodes.iter().map(one).collect()
}

fn verdict(files: &Files) -> Value {
    let verdict = files.get("verdict.json").and_then(|b| serde_json::from_slice::<Value>(b).ok());
    verdict.map_or(Value::Null, |v| json!({ "profile": v["profile"], "tier": v["tier"] }))
}

/// How many numbers of the asset have which origin.
fn origins(files: &Files) -> BTreeMap<String, u64> {
    let asset = files.get("asset.json").and_then(|b| serde_json::from_slice::<Value>(b).ok());
    let mut counts = BTreeMap::new();
    count_origins(&asset.unwrap_or_default(), &mut counts);
    counts
}

fn count_origins(value: &Value, counts: &mut BTreeMap<String, u64>) {
    match value {
        Value::Object(map) => {
            if let Some(Value::String(origin)) = map.get("origin") {
                *counts.entry(origin.clone()).or_default() += 1;
            }
            map.values().for_each(|v| count_origins(v, counts));
        }
        Value::Array(all) => all.iter().for_each(|v| count_origins(v, counts)),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn origins_are_counted_at_every_depth() {
        let asset = json!({ "links": [{ "mass": { "value": 1, "origin": "user" } },
            { "mass": { "value": 2, "origin": "default", "axis": { "origin": "model" } } }],
            "scale": { "origin": "user" } });
        let files = Files::from([("asset.json".into(), asset.to_string().into_bytes())]);
        let expected = [("default", 1), ("model", 1), ("user", 2)];
        assert_eq!(origins(&files), expected.map(|(k, n)| (k.to_string(), n)).into());
        assert!(origins(&Files::new()).is_empty());
    }
}
