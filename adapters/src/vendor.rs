//! Vendors' own schemas of what they may be sent, for tests; they lie outside of the repository.

use std::path::PathBuf;

use serde_json::{Value, json};

/// A vendor's schema, with its `oneOf`s loosened: they are not exclusive in truth. None, said aloud,
/// where the shared folder is missing.
pub(crate) fn vendor(file: &str, root: &str) -> Option<jsonschema::Validator> {
    let shared = std::env::var("KINFOLD_SHARED").map(PathBuf::from);
    let beside = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared");
    let path = shared.unwrap_or(beside).join("specs").join(file);
    let Ok(text) = std::fs::read_to_string(&path) else {
        eprintln!("SKIPPED: no vendor schema at {}", path.display());
        return None;
    };
    let mut spec: Value = serde_json::from_str(&text).unwrap();
    loosen(&mut spec);
    let components = spec["components"].take();
    let schema =
        json!({ "$ref": format!("#/components/schemas/{root}"), "components": components });
    Some(jsonschema::draft202012::new(&schema).unwrap())
}

/// `oneOf` becomes `anyOf` where it is a keyword: there it holds a list.
fn loosen(value: &mut Value) {
    match value {
        Value::Array(items) => items.iter_mut().for_each(loosen),
        Value::Object(map) => {
            if map.get("oneOf").is_some_and(Value::is_array)
                && let Some(options) = map.remove("oneOf")
            {
                map.insert("anyOf".into(), options);
            }
            map.values_mut().for_each(loosen);
        }
        _ => {}
    }
}

#[test]
fn a_property_that_is_called_like_a_keyword_stays() {
    let mut schema = json!({ "properties": { "oneOf": { "type": "string" } },
        "items": { "oneOf": [{ "oneOf": [] }] } });
    loosen(&mut schema);
    let expected = json!({ "properties": { "oneOf": { "type": "string" } },
        "items": { "anyOf": [{ "anyOf": [] }] } });
    assert_eq!(schema, expected);
}
