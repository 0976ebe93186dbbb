//! A photo, checked before anybody pays for looking at it.

use std::io::Cursor;
use std::path::Path;

use image::{ImageFormat, ImageReader};
use serde::{Deserialize, Serialize};

use crate::AdapterError;
use crate::bounded::read_limited;
use crate::formats;

/// Largest photo file, bytes.
pub const MAX_BYTES: u64 = 64 << 20;
/// Longest side, pixels.
pub const MAX_SIDE: u32 = 16_384;
/// Most pixels.
pub const MAX_PIXELS: u64 = 64_000_000;
/// Shortest side, pixels.
pub const MIN_SIDE: u32 = 16;

/// A picture file whose header and pixels could be read.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Photo {
    /// The file's bytes, as they are.
    pub bytes: Vec<u8>,
    /// `image/png`, `image/jpeg` or `image/webp`.
    pub media_type: String,
    /// Width and height, pixels.
    pub size: [u32; 2],
}

impl Photo {
    /// Reads a photo from disk.
    ///
    /// # Errors
    /// [`AdapterError::Io`] or [`AdapterError::Photo`], naming the file.
    pub fn open(path: &Path) -> Result<Self, AdapterError> {
        let name = path.display().to_string();
        let bytes = read_limited(path, MAX_BYTES)?;
        Self::read(bytes, &name)
    }

    /// Proves that some bytes are a PNG, JPEG or WebP picture of reasonable size; `name` stands in
    /// errors. The header is judged before any pixel is decoded.
    ///
    /// # Errors
    /// [`AdapterError::Photo`] with the rule and what was found.
    pub fn read(bytes: Vec<u8>, name: &str) -> Result<Self, AdapterError> {
        let refuse = |rule: &str, found: String| AdapterError::Photo {
            path: name.into(),
            rule: rule.into(),
            found,
        };
        let known = "a photo must be a PNG, JPEG or WebP picture";
        let reader = ImageReader::new(Cursor::new(&bytes)).with_guessed_format();
        let format = reader.ok().and_then(|r| r.format());
        let media_type = match format {
            Some(ImageFormat::Png) => "image/png",
            Some(ImageFormat::Jpeg) => "image/jpeg",
            Some(ImageFormat::WebP) => "image/webp",
            _ => return Err(refuse(known, describe(&bytes))),
        };
        let header =
            ImageReader::with_format(Cursor::new(&bytes), format.unwrap_or(ImageFormat::Png));
        let size = header.into_dimensions().map_err(|e| refuse(known, e.to_string()))?;
        check_size(size).map_err(|(rule, found)| refuse(&rule, found))?;
        decode(&bytes, format).map_err(|e| refuse("a photo must decode to its last pixel", e))?;
        Ok(Self { bytes, media_type: media_type.into(), size: [size.0, size.1] })
    }
}

fn check_size((width, height): (u32, u32)) -> Result<(), (String, String)> {
    let found = format!("{width} x {height}");
    if width.min(height) < MIN_SIDE {
        return Err((format!("a photo has at least {MIN_SIDE} pixels a side"), found));
    }
    if width.max(height) > MAX_SIDE || u64::from(width) * u64::from(height) > MAX_PIXELS {
        let rule = format!("a photo has at most {MAX_SIDE} pixels a side and {MAX_PIXELS} in all");
        return Err((rule, found));
    }
    Ok(())
}

fn decode(bytes: &[u8], format: Option<ImageFormat>) -> Result<(), String> {
    let mut reader = ImageReader::new(Cursor::new(bytes));
    if let Some(format) = format {
        reader.set_format(format);
    }
    let mut limits = image::Limits::default();
    limits.max_alloc = Some(MAX_PIXELS * 8);
    reader.limits(limits);
    reader.decode().map(drop).map_err(|e| e.to_string())
}

fn describe(bytes: &[u8]) -> String {
    let head: Vec<String> = bytes.iter().take(8).map(|b| format!("{b:02x}")).collect();
    if bytes.is_empty() {
        "an empty file".into()
    } else if let Some(known) = formats::of_picture(bytes) {
        known.into()
    } else {
        format!("a file that begins {}", head.join(" "))
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) fn png(width: u32, height: u32) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        let picture =
            image::RgbImage::from_fn(width, height, |x, y| image::Rgb([x as u8, y as u8, 7]));
        picture.write_to(&mut bytes, ImageFormat::Png).unwrap();
        bytes.into_inner()
    }

    #[test]
    fn a_picture_is_taken_as_it_is() {
        let photo = Photo::read(png(31, 17), "p.png").unwrap();
        assert_eq!((photo.media_type.as_str(), photo.size), ("image/png", [31, 17]));
        assert_eq!(photo.bytes, png(31, 17));
    }

    #[test]
    fn what_is_no_picture_is_refused_with_its_first_bytes() {
        let error = |bytes: Vec<u8>| Photo::read(bytes, "p.png").unwrap_err().to_string();
        let rule = "p.png: a photo must be a PNG, JPEG or WebP picture, found ";
        assert_eq!(error(vec![]), format!("{rule}an empty file"));
        assert!(error(b"hello world".to_vec()).ends_with("68 65 6c 6c 6f 20 77 6f"));
        assert!(error(png(9, 300)).contains("at least 16 pixels a side, found 9 x 300"));
        let mut torn = png(200, 200);
        torn.truncate(torn.len() / 2);
        assert!(error(torn).contains("decode to its last pixel"));
    }
}
