//! What a file is, told by how it begins.

/// How much of a text is looked through for the lines of an OBJ.
const BEGINNING: usize = 64 << 10;

/// A format of mesh files.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Format {
    /// Binary glTF.
    Glb,
    /// glTF as JSON.
    Gltf,
    /// Wavefront OBJ.
    Obj,
    /// STL, text or binary.
    Stl,
    /// PLY, text or binary.
    Ply,
    /// USD: text, binary, or packed with its pictures.
    Usd,
    /// What is not read here: its name, and how to convert it.
    Foreign(String),
}

/// The format of some bytes; `is_obj` says that the file's name ends in `.obj`.
pub fn format(bytes: &[u8], is_obj: bool) -> Format {
    let begins = |with: &[u8]| bytes.starts_with(with);
    if begins(b"glTF") {
        return Format::Glb;
    }
    if begins(b"ply\n") || begins(b"ply\r") {
        return Format::Ply;
    }
    if begins(b"PXR-USDC") || begins(b"#usda") || is_usdz(bytes) {
        return Format::Usd;
    }
    if let Some(name) = foreign(bytes) {
        return Format::Foreign(name.into());
    }
    let text = bytes.trim_ascii_start();
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text).trim_ascii_start();
    let is_marked_up = matches!(text, [b'{' | b'<', ..]);
    if is_obj && !is_marked_up || is_obj_text(bytes) {
        return Format::Obj;
    }
    if is_stl(bytes) {
        return Format::Stl;
    }
    match text {
        [b'{', ..] => Format::Gltf,
        [b'<', ..] => Format::Foreign(markup(text).into()),
        _ => Format::Foreign(unknown(bytes)),
    }
}

/// Text that says `solid` and `facet`, or a binary file of the length that its count says.
fn is_stl(bytes: &[u8]) -> bool {
    let count = bytes.get(80..84).and_then(|word| word.try_into().ok()).map(u32::from_le_bytes);
    count.is_some_and(|count| bytes.len() as u64 == 84 + 50 * u64::from(count))
        || bytes.trim_ascii_start().starts_with(b"solid")
}

/// Whether the first lines are those of an OBJ, whatever the file is called: a vertex, or what stands before
/// one.
fn is_obj_text(bytes: &[u8]) -> bool {
    let start = bytes.get(..bytes.len().min(BEGINNING)).unwrap_or_default();
    if start.contains(&0) {
        return false;
    }
    let lines = start.split(|b| *b == b'\n').map(<[u8]>::trim_ascii);
    let mut said = lines.filter(|line| !line.is_empty() && !line.starts_with(b"#"));
    let begins = |line: &[u8], word: &str| {
        let rest = line.strip_prefix(word.as_bytes());
        rest.is_some_and(|rest| rest.first().is_some_and(u8::is_ascii_whitespace))
    };
    said.next().is_some_and(|line| {
        ["v", "vt", "vn", "mtllib", "o", "g", "usemtl", "s"].iter().any(|word| begins(line, word))
    })
}

/// Formats that are known by their first bytes and not read.
fn foreign(bytes: &[u8]) -> Option<&'static str> {
    const PICTURE: &str = "a picture: a mesh is expected here, the photo stands before it";
    const PACKED: &str = "a packed archive: unpack it and name the mesh in it";
    let known: [(&[u8], &str); 27] = [
        (b"Kaydara FBX", "FBX: export a GLB, such as by Blender (File, Export, glTF 2.0)"),
        (b"; FBX", "FBX as text: export a GLB from the program it is of"),
        (b"BLENDER", "a Blender file (.blend): export a GLB (File, Export, glTF 2.0)"),
        (
            &[0x28, 0xb5, 0x2f, 0xfd],
            "a Blender file (.blend): export a GLB (File, Export, glTF 2.0)",
        ),
        (b"DRACO", "a Draco file (.drc): unpack it with `draco_decoder -i IN.drc -o OUT.ply`"),
        (b"version https://git-lfs", "a Git LFS pointer in place of the file: run `git lfs pull`"),
        (b"OFF", "OFF: convert it, such as by MeshLab, to PLY or OBJ"),
        (b"COFF", "OFF: convert it, such as by MeshLab, to PLY or OBJ"),
        (b"ISO-10303-21", "a CAD file (STEP): export an STL or a GLB from it, such as by FreeCAD"),
        (b"#VRML", "VRML: convert it, such as by MeshLab, to PLY or OBJ"),
        (b"#X3D", "X3D: convert it, such as by MeshLab, to PLY or OBJ"),
        (b"xof ", "DirectX (.x): convert it, such as by Assimp, to GLB"),
        (b"Ogawa", "Alembic: export a GLB, such as by Blender"),
        (b"3D Geometry File Format", "Rhino (.3dm): export an OBJ or a GLB from it"),
        (b"\x89PNG", PICTURE),
        (&[0xff, 0xd8, 0xff], PICTURE),
        (b"GIF8", PICTURE),
        (b"%PDF", "a PDF, which is no mesh"),
        (&[0x1f, 0x8b], PACKED),
        (b"7z\xbc\xaf", PACKED),
        (b"Rar!", PACKED),
        (b"BZh", PACKED),
        (&[0xfd, b'7', b'z', b'X', b'Z'], PACKED),
        (b"NGSP", "Gaussian splats (.spz), which have no surface: make a mesh of them first"),
        (b"\x7fELF", "a program, which is no mesh"),
        (b"MZ", "a program, which is no mesh"),
        (b"CREATE TABLE", "a text of a database, which is no mesh"),
    ];
    if bytes.starts_with(b"PK\x03\x04") {
        return Some(archive(bytes));
    }
    let is_webp = bytes.starts_with(b"RIFF") && bytes.get(8..12) == Some(b"WEBP");
    if is_webp || bytes.get(4..8) == Some(b"ftyp") {
        return Some(PICTURE);
    }
    if bytes.trim_ascii().is_empty() {
        return Some("an empty file");
    }
    known.into_iter().find(|(head, _)| bytes.starts_with(head)).map(|(_, name)| name)
}

/// Whether it is a ZIP archive whose first file is a layer of USD.
fn is_usdz(bytes: &[u8]) -> bool {
    let Some(&[low, high]) = bytes.get(26..28).filter(|_| bytes.starts_with(b"PK\x03\x04")) else {
        return false;
    };
    let name = bytes.get(30..30 + usize::from(u16::from_le_bytes([low, high])));
    let name = name.unwrap_or_default().to_ascii_lowercase();
    [&b".usdc"[..], b".usda", b".usd"].iter().any(|ending| name.ends_with(ending))
}

/// What a ZIP archive is, by the names in it.
fn archive(bytes: &[u8]) -> &'static str {
    let names = bytes.get(..bytes.len().min(BEGINNING)).unwrap_or_default();
    let has = |name: &[u8]| names.windows(name.len()).any(|w| w == name);
    if has(b"3D/") || has(b"[Content_Types].xml") {
        return "3MF: export an STL, OBJ or GLB from the slicer, or convert it by Blender";
    }
    "a ZIP archive: unpack it and name the mesh in it"
}

/// What a text is that begins with `<`.
fn markup(text: &[u8]) -> &'static str {
    let start = text.get(..text.len().min(1024)).unwrap_or_default().to_ascii_lowercase();
    let has = |word: &[u8]| start.windows(word.len()).any(|w| w == word);
    if has(b"<!doctype html") || has(b"<html") {
        "a web page, as a link for downloads may give: save the file behind it"
    } else if has(b"<collada") {
        "COLLADA (.dae): export a GLB, such as by Blender up to 4.x, or by Assimp"
    } else if has(b"<x3d") {
        "X3D: convert it, such as by MeshLab, to PLY or OBJ"
    } else if has(b"<svg") {
        "a drawing (SVG), which is no mesh"
    } else if has(b"<robot") || has(b"<mujoco") || has(b"<sdf") {
        "a model of a robot, which `kinfold check` reads: a mesh is expected here"
    } else {
        "XML of a kind that is not read here"
    }
}

fn unknown(bytes: &[u8]) -> String {
    let head: Vec<String> = bytes.iter().take(8).map(|b| format!("{b:02x}")).collect();
    format!("a file that begins {}: export a GLB, such as by Blender", head.join(" "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_what_its_bytes_say_whatever_it_is_called() {
        let mut stl = vec![0; 84 + 50];
        stl[80] = 1;
        for (bytes, is) in [
            (&b"glTF\x02"[..], Format::Glb),
            (b"ply\nformat ascii 1.0\n", Format::Ply),
            (b"ply\r\nformat ascii 1.0\n", Format::Ply),
            (b"solid cube\n", Format::Stl),
            (&stl, Format::Stl),
            (b" {\"asset\": {}}", Format::Gltf),
            (b"\xef\xbb\xbf{\"asset\": {}}", Format::Gltf),
            (b"#usda 1.0\n", Format::Usd),
            (b"PXR-USDC\0", Format::Usd),
            (b"# Blender\n\nmtllib a.mtl\nv 0 0 0\n", Format::Obj),
            (b"v 0 0 0\n", Format::Obj),
        ] {
            assert_eq!(format(bytes, false), is, "{}", String::from_utf8_lossy(bytes));
        }
        assert_eq!(format(b"call it what you like", true), Format::Obj);
        assert_eq!(format(b"glTF\x02", true), Format::Glb);
    }

    #[test]
    fn what_is_not_read_is_called_by_its_name_and_says_what_to_do() {
        let mut three = b"PK\x03\x04".to_vec();
        three.resize(26, 0);
        let zip = |name: &str| {
            let mut bytes = three.clone();
            bytes.extend((name.len() as u16).to_le_bytes());
            bytes.extend([0, 0]);
            bytes.extend(name.as_bytes());
            bytes
        };
        for (bytes, words) in [
            (&b"Kaydara FBX Binary  \0"[..], ["FBX", "GLB"]),
            (b"BLENDER-v300", [".blend", "Export"]),
            (b"DRACO\x02\x02", ["Draco", "draco_decoder"]),
            (
                b"version https://git-lfs.github.com/spec/v1\noid",
                ["Git LFS pointer", "git lfs pull"],
            ),
            (b"<!DOCTYPE html><html>", ["web page", "save the file"]),
            (b"<?xml version=\"1.0\"?><COLLADA>", ["COLLADA", "GLB"]),
            (&zip("3D/3dmodel.model"), ["3MF", "STL"]),
            (&zip("kettle.obj"), ["ZIP archive", "unpack"]),
            (b"\x89PNG\r\n", ["picture", "mesh"]),
            (b"\0\0\0\x18ftypheic", ["picture", "mesh"]),
            (b"OFF\n3 1 0\n", ["OFF", "PLY"]),
            (b"ISO-10303-21;", ["STEP", "FreeCAD"]),
            (b" \n", ["empty", "file"]),
            (b"\x01\x02\x03", ["begins 01 02 03", "GLB"]),
        ] {
            for is_obj in [false, true] {
                let Format::Foreign(said) = format(bytes, is_obj) else {
                    assert!(is_obj, "{words:?}");
                    continue;
                };
                assert!(words.iter().all(|w| said.contains(w)), "{said} for {words:?}");
            }
        }
        assert_eq!(format(&zip("scene.usdc"), false), Format::Usd);
        assert!(matches!(format(b"<html>", true), Format::Foreign(_)));
    }
}
