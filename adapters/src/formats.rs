//! Files that are not read here, told by how they begin: an error names what somebody has.

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
    fn pictures_of_other_formats_are_called_by_their_name() {
        assert!(of_picture(b"\0\0\0\x18ftypheic\0\0").unwrap().starts_with("HEIC"));
        assert!(of_picture(b"\0\0\0\x18ftypavif\0\0").unwrap().starts_with("AVIF"));
        assert_eq!((of_picture(b"GIF89a"), of_picture(b"BM12")), (Some("GIF"), Some("BMP")));
        assert_eq!(of_picture(b"text"), None);
    }
}
