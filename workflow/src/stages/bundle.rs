//! Several files as one run of bytes: a line of JSON that names them, then their bytes.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// Files by relative path, sorted.
pub type Files = BTreeMap<String, Vec<u8>>;

#[derive(Serialize, Deserialize)]
struct Index {
    files: Vec<(String, usize)>,
}

/// The files as one run of bytes; the same files give the same bytes.
pub fn pack(files: &Files) -> Vec<u8> {
    let index = Index { files: files.iter().map(|(n, b)| (n.clone(), b.len())).collect() };
    let mut bytes = serde_json::to_vec(&index).unwrap_or_default();
    bytes.push(b'\n');
    files.values().for_each(|b| bytes.extend_from_slice(b));
    bytes
}

/// The files behind such bytes.
///
/// # Errors
/// What is wrong with them, in words.
pub fn unpack(bytes: &[u8]) -> Result<Files, String> {
    let end = bytes.iter().position(|&b| b == b'\n').ok_or("expected an index line, found none")?;
    let (index, rest) = bytes.split_at(end);
    let index: Index = serde_json::from_slice(index).map_err(|e| e.to_string())?;
    let mut rest = rest.get(1..).unwrap_or_default();
    let mut files = Files::new();
    for (name, length) in index.files {
        let (file, tail) = rest
            .split_at_checked(length)
            .ok_or_else(|| format!("expected {length} bytes of {name}, found {}", rest.len()))?;
        files.insert(name, file.to_vec());
        rest = tail;
    }
    if rest.is_empty() { Ok(files) } else { Err(format!("{} bytes belong to no file", rest.len())) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_come_back_as_they_were() {
        let files = Files::from([
            ("meshes/a.obj".into(), b"v 0 0 0\n".to_vec()),
            ("asset.urdf".into(), vec![0, 10, 255]),
            ("empty".into(), vec![]),
        ]);
        assert_eq!(unpack(&pack(&files)).unwrap(), files);
    }

    #[test]
    fn torn_bytes_are_refused() {
        let bytes = pack(&Files::from([("a".into(), b"abc".to_vec())]));
        for cut in 0..bytes.len() {
            assert!(unpack(&bytes[..cut]).is_err());
        }
        assert!(unpack(&[&bytes[..], b"x"].concat()).unwrap_err().contains("belong to no file"));
    }
}
