//! What a file is that is no model at all.

use std::io::Read as _;
use std::path::Path;

use guard::folder::{Caps, Folder};
use sim_check::{Status, Verdict};

/// How a file begins that is not XML, and what it is called.
const KINDS: [(&[u8], &str); 14] = [
    (b"#usda", "USD"),
    (b"PXR-USDC", "USD"),
    (b"PK\x03\x04", "an archive (ZIP, USDZ, 3MF)"),
    (b"glTF", "GLB"),
    (b"{", "JSON (glTF?)"),
    (b"solid ", "STL"),
    (b"ply", "PLY"),
    (b"OFF", "OFF"),
    (b"Kaydara FBX", "FBX"),
    (b"BLENDER", "a Blender file"),
    (b"v ", "OBJ"),
    (b"mtllib", "OBJ"),
    (b"\x89PNG", "a picture"),
    (b"\xff\xd8", "a picture"),
];
/// As much of a file as is looked at, bytes.
const BEGINNING: u64 = 64;

/// What a file is that could not be read as XML, where it does not look like XML at all.
pub(super) fn not_xml(file: &Path, verdict: &Verdict) -> Option<&'static str> {
    let f1 = verdict.check("F1").filter(|c| c.status == Status::Fail)?;
    let reason = f1.evidence.first()?;
    if !reason.starts_with("not XML") && !reason.contains("not UTF-8") {
        return None;
    }
    // Nothing else is opened than what was checked: no pipe, and nothing that leads out of the folder.
    let folder = Folder::open(file.parent().unwrap_or(Path::new("")), Caps::default()).ok()?;
    let opened = folder.file(Path::new(file.file_name()?)).ok()?;
    let mut bytes = Vec::new();
    opened.take(BEGINNING).read_to_end(&mut bytes).ok()?;
    of(&bytes)
}

fn of(bytes: &[u8]) -> Option<&'static str> {
    if bytes.is_empty() {
        return Some("an empty file");
    }
    if let Some((_, name)) = KINDS.iter().find(|(head, _)| bytes.starts_with(head)) {
        return Some(name);
    }
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    // UTF-16 begins with zeros between, or with a mark.
    let is_wide = bytes.contains(&0) && bytes.contains(&b'<');
    match text.starts_with(b"<") || is_wide {
        true => None,
        false if std::str::from_utf8(text.get(..16).unwrap_or(text)).is_ok() => {
            Some("a text that is not XML")
        }
        false => Some("a file that is not XML"),
    }
}

/// Most bytes of an `.xml` file that is looked at for what it holds; larger ones are taken for models.
const LOOKED_AT: u64 = 1 << 20;

/// Whether an XML file holds a model rather than a part of one or anything else: its root is `robot`,
/// `mujoco` with a world in it, or `sdf` with a model.
pub(super) fn is_model(folder: &Folder, path: &Path) -> bool {
    let Ok(opened) = folder.file(path) else { return false };
    let mut bytes = Vec::new();
    if opened.take(LOOKED_AT).read_to_end(&mut bytes).is_err() {
        return false;
    }
    let text = String::from_utf8_lossy(&bytes);
    match root(&text) {
        Some("robot") => true,
        Some("sdf") => {
            text.contains("<model") || text.contains("<include") || bytes.len() as u64 == LOOKED_AT
        }
        Some("mujoco") => text.contains("<worldbody") || bytes.len() as u64 == LOOKED_AT,
        _ => false,
    }
}

/// The name of the first element of a text.
fn root(text: &str) -> Option<&str> {
    let mut rest = text;
    loop {
        let at = rest.find('<')?;
        rest = &rest[at + 1..];
        rest = match rest {
            _ if rest.starts_with("!--") => &rest[rest.find("-->")? + 3..],
            _ if rest.starts_with(['?', '!']) => &rest[rest.find('>')? + 1..],
            _ => {
                let end = rest.find(|c: char| c.is_whitespace() || "/>".contains(c))?;
                return Some(&rest[..end]);
            }
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_root_of_a_text_is_found_past_remarks_and_declarations() {
        assert_eq!(root("<?xml version='1.0'?>\n<!-- <a> -->\n<mujoco model='m'>"), Some("mujoco"));
        assert_eq!(root("\u{feff} <robot>"), Some("robot"));
        assert_eq!(root("<robot/>"), Some("robot"));
        for none in ["", "text", "<!-- <robot>", "<?xml"] {
            assert_eq!(root(none), None, "{none}");
        }
    }

    #[test]
    fn what_is_not_xml_is_called_by_its_name() {
        for (bytes, name) in [
            (&b"#usda 1.0\n"[..], Some("USD")),
            (b"PXR-USDC\0", Some("USD")),
            (b"glTF\x02\0", Some("GLB")),
            (b"hello", Some("a text that is not XML")),
            (b"\x01\xff\xfe\xfd", Some("a file that is not XML")),
            (b"", Some("an empty file")),
            (b"\xef\xbb\xbf <robot", None),
            (b"<robot name=", None),
            (b"\xff\xfe<\0r\0", None),
        ] {
            assert_eq!(of(bytes), name, "{bytes:?}");
        }
    }
}
