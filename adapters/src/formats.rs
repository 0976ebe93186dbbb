//! Files that are not read here, told by how they begin: an error names what somebody has.

/// The format of a mesh file that is neither GLB nor OBJ, where it is a known one.
pub(crate) fn of_mesh(bytes: &[u8]) -> Option<&'static str> {
    let begins = |with: &[u8]| bytes.starts_with(with);
    let text = bytes.trim_ascii_start();
    let known: [(bool, &str); 13] = [
        (begins(b"glTF"), ""),
        (begins(b"ply\n") || begins(b"ply\r"), "PLY"),
        (begins(b"OFF\n") || begins(b"OFF\r") || begins(b"COFF"), "OFF"),
        (begins(b"Kaydara FBX"), "FBX"),
        (begins(b"BLENDER") || begins(&[0x28, 0xb5, 0x2f, 0xfd]), "a Blender file (.blend)"),
        (begins(b"PXR-USDC") || begins(b"#usda"), "USD"),
        (begins(b"PK\x03\x04"), "a ZIP archive, as USDZ and 3MF are"),
        (begins(b"solid "), "STL"),
        (is_binary_stl(bytes), "STL"),
        (text.starts_with(b"{"), "JSON, as a .gltf in several files is: export one GLB"),
        (text.starts_with(b"<"), "XML, as COLLADA (.dae) and X3D are"),
        (text.starts_with(b"v ") || text.starts_with(b"# "), "a text, as OBJ is: name it .obj"),
        (bytes.is_empty(), "an empty file"),
    ];
    known.into_iter().find(|(is, _)| *is).map(|(_, name)| name).filter(|name| !name.is_empty())
}

/// Eighty bytes of anything, a count, and fifty bytes a triangle.
fn is_binary_stl(bytes: &[u8]) -> bool {
    let count = bytes.get(80..84).and_then(|word| word.try_into().ok()).map(u32::from_le_bytes);
    count.is_some_and(|count| bytes.len() as u64 == 84 + 50 * u64::from(count))
}

/// The format of a picture that is neither PNG, JPEG nor WebP, where it is a known one.
pub(crate) fn of_picture(bytes: &[u8]) -> Option<&'static str> {
    let brand = bytes.get(8..12).filter(|_| bytes.get(4..8) == Some(b"ftyp"));
    match brand {
        Some(b"heic" | b"heix" | b"hevc" | b"heim" | b"heis" | b"mif1" | b"msf1") => {
            return Some(
                "HEIC, as iPhones take it: share or export it as JPEG (heif-convert IN.heic OUT.jpg)",
            );
        }
        Some(b"avif" | b"avis") => return Some("AVIF: export it as PNG (avifdec IN.avif OUT.png)"),
        Some(_) => return Some("a film or another file of the ISO base media format"),
        None => {}
    }
    let known: [(&[u8], &str); 7] = [
        (b"GIF8", "GIF"),
        (b"BM", "BMP"),
        (b"II*\0", "TIFF"),
        (b"MM\0*", "TIFF"),
        (b"%PDF", "PDF"),
        (b"<svg", "SVG"),
        (b"8BPS", "a Photoshop file"),
    ];
    known.into_iter().find(|(head, _)| bytes.starts_with(head)).map(|(_, name)| name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meshes_of_other_formats_are_called_by_their_name() {
        let mut stl = vec![0; 84 + 50];
        stl[80] = 1;
        for (bytes, name) in [
            (&b"ply\nformat ascii 1.0\n"[..], "PLY"),
            (b"OFF\n3 1 0\n", "OFF"),
            (b"Kaydara FBX Binary  \0", "FBX"),
            (b"solid cube\n", "STL"),
            (&stl, "STL"),
            (b"#usda 1.0\n", "USD"),
        ] {
            assert_eq!(of_mesh(bytes), Some(name));
        }
        assert!(of_mesh(b"PK\x03\x04").unwrap().contains("USDZ"));
        assert!(of_mesh(b" {\"asset\": {}}").unwrap().contains(".gltf"));
        assert!(of_mesh(b"BLENDER-v300").unwrap().contains(".blend"));
        assert!(of_mesh(b"v 0 0 0\n").unwrap().contains("name it .obj"));
        assert_eq!((of_mesh(b"glTF\x02"), of_mesh(b"\x01\x02")), (None, None));
    }

    #[test]
    fn pictures_of_other_formats_are_called_by_their_name() {
        assert!(of_picture(b"\0\0\0\x18ftypheic\0\0").unwrap().starts_with("HEIC"));
        assert!(of_picture(b"\0\0\0\x18ftypavif\0\0").unwrap().starts_with("AVIF"));
        assert_eq!((of_picture(b"GIF89a"), of_picture(b"BM12")), (Some("GIF"), Some("BMP")));
        assert_eq!(of_picture(b"text"), None);
    }
}
