//! USDZ: a ZIP archive whose first layer is the scene, and pictures beside it.

use std::collections::BTreeMap;
use std::io::{Cursor, Read as _};

use zip::ZipArchive;

use super::error::UsdError;
use crate::beside::Found;

/// Most bytes that all entries together may come to.
const MAX_BYTES: u64 = 512 << 20;
/// Most entries.
const MAX_ENTRIES: usize = 4096;

/// The other files of an archive, by name; none of a plain layer.
pub(super) struct Packed(BTreeMap<String, Vec<u8>>);

impl Packed {
    /// The layers among them.
    pub(super) fn layers(self) -> BTreeMap<String, Vec<u8>> {
        let is_layer = |name: &String| {
            let name = name.to_ascii_lowercase();
            [".usdc", ".usda", ".usd"].iter().any(|end| name.ends_with(end))
        };
        self.0.into_iter().filter(|(name, _)| is_layer(name)).collect()
    }

    /// A file of the archive, however the path to it is written.
    pub(super) fn take(&mut self, name: &str) -> Option<Found> {
        let name = name.trim_start_matches("./").replace('\\', "/");
        let bytes = self.0.get(&name).or_else(|| {
            let ends = |n: &&String| n.ends_with(&format!("/{name}"));
            self.0.keys().find(ends).and_then(|n| self.0.get(n))
        })?;
        Some(Found { name, bytes: bytes.clone() })
    }
}

/// The layer to read, and what is packed beside it.
pub(super) fn opened(bytes: Vec<u8>) -> Result<(Vec<u8>, Packed), UsdError> {
    if !bytes.starts_with(b"PK\x03\x04") {
        return Ok((bytes, Packed(BTreeMap::new())));
    }
    let broken = |e: String| UsdError::Unreadable(format!("the USDZ archive: {e}"));
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|e| broken(e.to_string()))?;
    if archive.len() > MAX_ENTRIES {
        return Err(broken(format!(
            "it may have at most {MAX_ENTRIES} files, found {}",
            archive.len()
        )));
    }
    let (mut layer, mut files, mut left) = (None, BTreeMap::new(), MAX_BYTES);
    for index in 0..archive.len() {
        let file = archive.by_index(index).map_err(|e| broken(e.to_string()))?;
        if !file.is_file() {
            continue;
        }
        let name = file.name().replace('\\', "/");
        let mut bytes = Vec::new();
        file.take(left + 1).read_to_end(&mut bytes).map_err(|e| broken(e.to_string()))?;
        left = left.checked_sub(bytes.len() as u64).ok_or_else(|| {
            broken(format!("its files may have at most {MAX_BYTES} bytes in all, found more"))
        })?;
        let is_layer =
            [".usdc", ".usda", ".usd"].iter().any(|end| name.to_ascii_lowercase().ends_with(end));
        if is_layer && layer.is_none() {
            layer = Some(bytes);
        } else {
            files.insert(name, bytes);
        }
    }
    let layer = layer.ok_or_else(|| broken("it has no layer (.usdc, .usda, .usd)".into()))?;
    Ok((layer, Packed(files)))
}
