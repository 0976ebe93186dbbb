//! Reads shards: `tar.zst` archives with a folder of three files for each object.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use super::DataError;

/// Largest file inside a shard, bytes.
const LARGEST: u64 = 256 << 20;

/// The files of one object, not yet understood.
#[derive(Clone, Debug, Default)]
pub struct Bundle {
    /// Its folder in the shard.
    pub id: String,
    /// `mesh.glb`.
    pub mesh: Vec<u8>,
    /// `face_labels.u16le`.
    pub labels: Vec<u8>,
    /// `truth.json`.
    pub truth: Vec<u8>,
}

/// The shards of a folder, in the order of their names.
///
/// # Errors
/// [`DataError`] when the folder cannot be read or holds none.
pub fn shards(folder: &Path) -> Result<Vec<PathBuf>, DataError> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(DataError::io(folder))? {
        let path = entry.map_err(DataError::io(folder))?.path();
        if path.to_string_lossy().ends_with(".tar.zst") {
            found.push(path);
        }
    }
    found.sort();
    if found.is_empty() {
        return Err(DataError::broken(folder, "expected shards called *.tar.zst, found none"));
    }
    Ok(found)
}

/// The objects of a shard, in its order.
///
/// # Errors
/// [`DataError`] when it cannot be read; objects before the fault are lost, too.
pub fn read_shard(path: &Path) -> Result<Vec<Bundle>, DataError> {
    let file = File::open(path).map_err(DataError::io(path))?;
    let plain = zstd::Decoder::new(file).map_err(DataError::io(path))?;
    let mut archive = tar::Archive::new(plain);
    let mut bundles: Vec<Bundle> = Vec::new();
    for entry in archive.entries().map_err(DataError::io(path))? {
        let mut entry = entry.map_err(DataError::io(path))?;
        if !entry.header().entry_type().is_file() {
            continue;
        }
        let name = String::from_utf8_lossy(&entry.path_bytes()).into_owned();
        let Some((id, member)) = name.split_once('/') else { continue };
        let mut bytes = Vec::new();
        entry.by_ref().take(LARGEST).read_to_end(&mut bytes).map_err(DataError::io(path))?;
        keep(&mut bundles, id, member, bytes);
    }
    Ok(bundles)
}

fn keep(bundles: &mut Vec<Bundle>, id: &str, member: &str, bytes: Vec<u8>) {
    if bundles.last().is_none_or(|b| b.id != id) {
        bundles.push(Bundle { id: id.into(), ..Bundle::default() });
    }
    let Some(bundle) = bundles.last_mut() else { return };
    match member {
        "mesh.glb" => bundle.mesh = bytes,
        "face_labels.u16le" => bundle.labels = bytes,
        "truth.json" => bundle.truth = bytes,
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shard(folder: &Path, members: &[(&str, &[u8])]) -> PathBuf {
        let path = folder.join("shard-000.tar.zst");
        let mut archive = tar::Builder::new(Vec::new());
        for (name, bytes) in members {
            let mut header = tar::Header::new_gnu();
            header.set_size(bytes.len() as u64);
            header.set_mode(0o644);
            archive.append_data(&mut header, name, *bytes).unwrap();
        }
        let plain = archive.into_inner().unwrap();
        std::fs::write(&path, zstd::encode_all(&plain[..], 1).unwrap()).unwrap();
        path
    }

    #[test]
    fn a_shard_gives_the_files_of_each_object_together() {
        let folder = tempfile::tempdir().unwrap();
        let members: [(&str, &[u8]); 5] = [
            ("a/mesh.glb", b"m"),
            ("a/face_labels.u16le", b"l"),
            ("a/truth.json", b"t"),
            ("b/truth.json", b"u"),
            ("b/notes.txt", b"?"),
        ];
        shard(folder.path(), &members);
        let found = shards(folder.path()).unwrap();
        let bundles = read_shard(&found[0]).unwrap();
        assert_eq!(bundles.len(), 2);
        assert_eq!((&bundles[0].mesh[..], &bundles[0].labels[..]), (&b"m"[..], &b"l"[..]));
        assert_eq!((bundles[1].id.as_str(), &bundles[1].truth[..]), ("b", &b"u"[..]));
    }

    #[test]
    fn a_shard_cut_short_is_an_error_that_names_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = shard(folder.path(), &[("a/mesh.glb", &[7; 100_000])]);
        let bytes = std::fs::read(&path).unwrap();
        std::fs::write(&path, &bytes[..bytes.len() - 9]).unwrap();
        let told = read_shard(&path).unwrap_err().to_string();
        assert!(told.contains("shard-000.tar.zst"), "{told}");
        assert!(shards(&folder.path().join("none")).is_err());
    }
}
