//! A path → its text → the model in it.

use std::path::Path;

use guard::files;

use crate::read::error::{ReadError, Reason};
use crate::read::mjcf::Mjcf;
use crate::read::shelf::{Outside, Shelf};
use crate::read::tree::Tree;
use crate::read::urdf::Urdf;
use crate::read::usda::Stage;

/// Most bytes of a model file; a guess with room: the largest of the models that ship with simulators
/// have fewer than 5 MB without their meshes.
pub const MAX_BYTES: u64 = 64 << 20;

/// A file that the rules look at.
#[derive(Debug)]
pub enum Model {
    /// A URDF, with what is known of its meshes.
    Urdf(Urdf),
    /// An MJCF model.
    Mjcf(Mjcf),
    /// A USD stage.
    Usd(Stage),
}

/// Reads a file: USD text by its first words, URDF and MJCF by their root.
///
/// # Errors
/// [`ReadError`], which names the file and says what to do.
pub fn read(path: &Path, outside: Outside) -> Result<Model, ReadError> {
    read_inside(path, outside).map_err(|reason| ReadError { path: path.to_path_buf(), reason })
}

fn read_inside(path: &Path, outside: Outside) -> Result<Model, Reason> {
    let bytes = files::read(path, MAX_BYTES)?;
    // A crate file of USD, and USDZ, which is a ZIP archive.
    if bytes.starts_with(b"PXR-USDC") || bytes.starts_with(b"PK\x03\x04") {
        return Err(Reason::Binary);
    }
    let text = String::from_utf8(bytes).map_err(|_| Reason::Text)?;
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    if text.starts_with("#usda") {
        return Stage::read(text).map(Model::Usd);
    }
    let tree = Tree::read(text)?;
    let root = tree.root().map(|r| r.tag.clone()).unwrap_or_default();
    match root.as_str() {
        "robot" => {
            let mut shelf = Shelf::beside(path, outside)?;
            Urdf::read(&tree, &mut shelf).map(Model::Urdf)
        }
        "mujoco" => Ok(Model::Mjcf(Mjcf::new(tree))),
        _ => Err(Reason::Root { found: root.chars().take(60).collect() }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(bytes: &[u8]) -> String {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m");
        std::fs::write(&path, bytes).unwrap();
        let said = read(&path, Outside::Refused).unwrap_err().to_string();
        said.split_once(": ").unwrap().1.to_string()
    }

    #[test]
    fn every_kind_of_wrong_file_is_told_with_a_way_out() {
        assert!(said(b"PXR-USDC").contains("usdcat"));
        assert!(said(b"\xff\xfe").contains("UTF-8"));
        assert!(said(b"<sdf/>").contains("SDF is not read yet"));
        assert!(said(b"<robot").contains("is no XML"));
        assert!(said(b"").contains("is no XML"));
        assert!(said(b"<!DOCTYPE robot><robot/>").contains("DOCTYPE"));
        let number =
            b"<robot>\n<link name='a'><inertial><mass value='1,5'/></inertial></link></robot>";
        assert_eq!(said(number), "line 2: value=\"1,5\": expected 1 finite numbers");
        let folder = tempfile::tempdir().unwrap();
        let e = read(folder.path(), Outside::Refused).unwrap_err().to_string();
        assert!(e.ends_with("is no regular file"), "{e}");
    }
}
