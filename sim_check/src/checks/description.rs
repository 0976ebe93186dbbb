//! The sidecar `asset.json` as it lies beside a model.

use std::collections::BTreeMap;
use std::path::Path;

use guard::folder::Folder;
use serde_json::Value;

use crate::read::meshes::in_words;

/// Schema name of the sidecar.
pub(super) const SCHEMA: &str = "kinfold-asset/1";
/// Name of the sidecar, beside the URDF.
pub(super) const FILE_NAME: &str = "asset.json";
/// Most bytes a sidecar may have (64 MiB).
const MAX_BYTES: u64 = 64 << 20;

/// Reads it, or says what is wrong.
pub(super) fn read(folder: &Folder) -> Result<Value, String> {
    let bytes = match folder.file(Path::new(FILE_NAME)) {
        Ok(file) if file.length() > MAX_BYTES => {
            return Err(format!("{FILE_NAME} is no file of at most {MAX_BYTES} bytes"));
        }
        Ok(_) => folder.read(Path::new(FILE_NAME)),
        Err(refused) if refused.is_absence() => return Err(format!("there is no {FILE_NAME}")),
        Err(refused) => Err(refused),
    };
    let bytes = bytes.map_err(|refused| format!("{FILE_NAME} {}", in_words(&refused)))?;
    let value: Value =
        serde_json::from_slice(&bytes).map_err(|e| format!("{FILE_NAME} is not JSON: {e}"))?;
    match value.get("schema").and_then(Value::as_str) {
        Some(SCHEMA) => Ok(value),
        found => Err(format!("{FILE_NAME}: expected schema `{SCHEMA}`, found {found:?}")),
    }
}

/// The entries of a list (or map) in the sidecar, by name.
pub(super) fn entries<'a>(sidecar: &'a Value, list: &str) -> BTreeMap<&'a str, &'a Value> {
    match sidecar.get(list) {
        Some(Value::Array(items)) => {
            items.iter().filter_map(|i| Some((i.get("name").and_then(Value::as_str)?, i))).collect()
        }
        Some(Value::Object(map)) => map.iter().map(|(k, v)| (k.as_str(), v)).collect(),
        _ => BTreeMap::new(),
    }
}
