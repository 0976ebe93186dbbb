//! The key of a result: the digest of everything it depends on.
//!
//! ```
//! use runner::key::Material;
//!
//! let material = Material {
//!     stage: "upper".into(),
//!     code: "1".into(),
//!     params: serde_json::json!({ "b": 2, "a": 1 }),
//!     seed: None,
//!     identity: None,
//!     inputs: vec![],
//! };
//! assert!(material.canonical().contains(r#""params":{"a":1,"b":2}"#));
//! let other = Material { seed: Some(7), ..material.clone() };
//! assert_ne!(other.key(), material.key());
//! ```

use serde::{Deserialize, Serialize};
use serde_json::Value;
use trace::Digest;

use super::stage::Profile;

/// Everything a stage's result depends on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Material {
    /// Name of the stage.
    pub stage: String,
    /// Version of its code.
    pub code: String,
    /// Its parameters.
    pub params: Value,
    /// The seed, where it matters.
    pub seed: Option<u64>,
    /// Who does the work.
    pub identity: Option<String>,
    /// Its inputs in order.
    pub inputs: Vec<InputDigest>,
}

/// An input by name and content.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct InputDigest {
    /// Name of the artefact.
    pub name: String,
    /// Digest of its bytes.
    pub digest: Digest,
}

impl Material {
    /// The material of a stage with these inputs.
    pub fn of(stage: &str, profile: Profile, inputs: Vec<InputDigest>) -> Self {
        let Profile { code, params, seed, identity } = profile;
        Self { stage: stage.into(), code, params, seed, identity, inputs }
    }

    /// The material as canonical JSON: keys sorted, no spaces.
    pub fn canonical(&self) -> String {
        let value = serde_json::to_value(self).unwrap_or(Value::Null);
        let mut text = String::new();
        write_canonical(&value, &mut text);
        text
    }

    /// BLAKE3 of the canonical JSON.
    pub fn key(&self) -> Digest {
        Digest::of(self.canonical().as_bytes())
    }
}

/// JSON with object keys sorted at every depth, whatever order the map keeps.
fn write_canonical(value: &Value, out: &mut String) {
    match value {
        Value::Object(map) => {
            let mut entries: Vec<_> = map.iter().collect();
            entries.sort_by_key(|&(key, _)| key);
            out.push('{');
            for (i, (key, value)) in entries.into_iter().enumerate() {
                out.push_str(if i > 0 { "," } else { "" });
                out.push_str(&Value::String(key.clone()).to_string());
                out.push(':');
                write_canonical(value, out);
            }
            out.push('}');
        }
        Value::Array(items) => {
            out.push('[');
            for (i, item) in items.iter().enumerate() {
                out.push_str(if i > 0 { "," } else { "" });
                write_canonical(item, out);
            }
            out.push(']');
        }
        plain => out.push_str(&plain.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn material() -> Material {
        Material {
            stage: "upper".into(),
            code: "1".into(),
            params: serde_json::json!({ "b": [1, 2.5], "a": { "z": null, "y": "\"" } }),
            seed: Some(7),
            identity: None,
            inputs: vec![InputDigest { name: "text".into(), digest: Digest::of(b"abc") }],
        }
    }

    #[test]
    fn the_canonical_form_sorts_keys_at_every_depth() {
        let text = material().canonical();
        assert!(text.starts_with(r#"{"code":"1","identity":null,"inputs":[{"digest":"#), "{text}");
        assert!(
            text.contains(r#""params":{"a":{"y":"\"","z":null},"b":[1,2.5]},"seed":7"#),
            "{text}"
        );
    }

    #[test]
    fn every_field_changes_the_key() {
        let base = material();
        let changed = [
            Material { stage: "lower".into(), ..base.clone() },
            Material { code: "2".into(), ..base.clone() },
            Material { params: Value::Null, ..base.clone() },
            Material { seed: None, ..base.clone() },
            Material { identity: Some("x".into()), ..base.clone() },
            Material { inputs: vec![], ..base.clone() },
        ];
        let mut keys: Vec<_> = changed.iter().map(Material::key).collect();
        keys.push(base.key());
        keys.sort();
        keys.dedup();
        assert_eq!(keys.len(), 7);
        assert_eq!(base.key(), material().key());
    }
}
