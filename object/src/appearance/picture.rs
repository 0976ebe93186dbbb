//! Pictures as they stand in files, and their pixels.

use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder as _, ImageFormat, ImageReader, Limits, RgbaImage};
use serde::{Deserialize, Serialize};

/// Longest side of a picture, in pixels.
pub const MAX_IMAGE_SIDE: u32 = 8192;
/// Most pixels of all pictures together (256 million).
pub const MAX_PIXELS: u64 = 256_000_000;
/// Memory a decoder may take, in bytes.
const MAX_IMAGE_MEMORY: u64 = 1 << 30;

/// How a picture is encoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PictureFormat {
    /// PNG.
    Png,
    /// JPEG.
    Jpeg,
    /// WebP.
    WebP,
}

/// An encoded picture whose header was read: at most [`MAX_IMAGE_SIDE`] pixels a side.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    bytes: Vec<u8>,
    format: PictureFormat,
    size: [u32; 2],
}

impl Picture {
    /// Reads the header alone.
    ///
    /// # Errors
    /// What is wrong, in words: no PNG, JPEG or WebP, without pixels, or too many of them.
    pub fn new(bytes: Vec<u8>) -> Result<Self, String> {
        let found = header(&bytes).ok_or("expected a PNG, JPEG or WebP picture")?;
        let (format, [width, height]) = found;
        if width == 0 || height == 0 || width.max(height) > MAX_IMAGE_SIDE {
            let rule = format!("a picture has 1 to {MAX_IMAGE_SIDE} pixels a side");
            return Err(format!("{rule}, found {width} × {height}"));
        }
        Ok(Self { bytes, format, size: [width, height] })
    }

    /// The file's bytes.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// How it is encoded.
    pub fn format(&self) -> PictureFormat {
        self.format
    }

    /// Width and height in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// How many pixels it has.
    pub fn pixel_count(&self) -> u64 {
        u64::from(self.size[0]) * u64::from(self.size[1])
    }

    /// Its pixels.
    ///
    /// # Errors
    /// What the decoder says.
    pub fn pixels(&self) -> Result<Pixels, String> {
        let image = decoded(&self.bytes)?;
        let [width, height] = [image.width(), image.height()];
        Ok(Pixels { width, height, rgba: image.into_raw() })
    }
}

/// Decoded pixels: rows from the top, four bytes each, red, green, blue and opacity.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pixels {
    width: u32,
    height: u32,
    rgba: Vec<u8>,
}

impl Pixels {
    /// Pixels all of one colour.
    pub fn filled(width: u32, height: u32, colour: [u8; 4]) -> Self {
        let count = width as usize * height as usize;
        Self { width, height, rgba: colour.repeat(count) }
    }

    /// Width in pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height in pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The pixel at a column and a row, as at the edge outside of them.
    pub fn at(&self, x: u32, y: u32) -> [u8; 4] {
        let (x, y) = (x.min(self.width.saturating_sub(1)), y.min(self.height.saturating_sub(1)));
        let start = 4 * (y as usize * self.width as usize + x as usize);
        self.rgba.get(start..start + 4).and_then(|p| p.try_into().ok()).unwrap_or([255; 4])
    }

    /// Sets the pixel at a column and a row; outside of them nothing is done.
    pub fn set(&mut self, x: u32, y: u32, colour: [u8; 4]) {
        if x >= self.width || y >= self.height {
            return;
        }
        let start = 4 * (y as usize * self.width as usize + x as usize);
        if let Some(pixel) = self.rgba.get_mut(start..start + 4) {
            pixel.copy_from_slice(&colour);
        }
    }

    /// The pixels in rows from the top.
    pub fn iter(&self) -> impl Iterator<Item = [u8; 4]> + '_ {
        self.rgba.chunks_exact(4).map(|p| [p[0], p[1], p[2], p[3]])
    }

    /// The same at another size: each pixel is the mean, byte for byte, over what it covers.
    #[must_use]
    pub fn resized(&self, width: u32, height: u32) -> Self {
        let image = RgbaImage::from_raw(self.width, self.height, self.rgba.clone());
        let Some(image) = image else { return Self::filled(width, height, [255; 4]) };
        let filter = image::imageops::FilterType::Triangle;
        let resized = image::imageops::resize(&image, width, height, filter);
        Self { width, height, rgba: resized.into_raw() }
    }

    /// As a PNG file, without opacity where all is opaque; the same pixels give the same bytes.
    ///
    /// # Errors
    /// What the encoder says.
    pub fn png(&self) -> Result<Vec<u8>, String> {
        let mut bytes = Vec::new();
        let encoder = PngEncoder::new_with_quality(
            &mut bytes,
            CompressionType::Default,
            FilterType::Adaptive,
        );
        let opaque = self.iter().all(|p| p[3] == 255);
        let written = if opaque {
            let rgb: Vec<u8> = self.iter().flat_map(|p| [p[0], p[1], p[2]]).collect();
            encoder.write_image(&rgb, self.width, self.height, ExtendedColorType::Rgb8)
        } else {
            encoder.write_image(&self.rgba, self.width, self.height, ExtendedColorType::Rgba8)
        };
        written.map_err(|e| e.to_string())?;
        Ok(bytes)
    }
}

/// Media type of an encoded picture, by how it begins.
pub(crate) fn media_type(bytes: &[u8]) -> &'static str {
    match bytes {
        [0xff, 0xd8, ..] => "image/jpeg",
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => "image/webp",
        _ => "image/png",
    }
}

/// Format and size of a picture by its header; none of what is no picture of ours.
pub(crate) fn header(bytes: &[u8]) -> Option<(PictureFormat, [u32; 2])> {
    let reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format().ok()?;
    let format = match reader.format()? {
        ImageFormat::Png => PictureFormat::Png,
        ImageFormat::Jpeg => PictureFormat::Jpeg,
        ImageFormat::WebP => PictureFormat::WebP,
        _ => return None,
    };
    let (width, height) = guarded(|| reader.into_dimensions()).ok()?;
    Some((format, [width, height]))
}

/// The pixels of an encoded picture.
pub(crate) fn decoded(bytes: &[u8]) -> Result<RgbaImage, String> {
    guarded(|| {
        let mut reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format()?;
        let mut limits = Limits::default();
        limits.max_image_width = Some(MAX_IMAGE_SIDE);
        limits.max_image_height = Some(MAX_IMAGE_SIDE);
        limits.max_alloc = Some(MAX_IMAGE_MEMORY);
        reader.limits(limits);
        Ok::<_, image::ImageError>(reader.decode()?.into_rgba8())
    })
}

/// Runs a decoder we did not write; one that panics gives an error.
fn guarded<T, E: std::fmt::Display>(decode: impl FnOnce() -> Result<T, E>) -> Result<T, String> {
    match catch_unwind(AssertUnwindSafe(decode)) {
        Ok(done) => done.map_err(|e| e.to_string()),
        Err(_) => Err("the decoder gave up".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_written_comes_back_pixel_for_pixel() {
        for alpha in [255, 128] {
            let mut pixels = Pixels::filled(5, 3, [10, 20, 30, 255]);
            pixels.set(4, 2, [200, 100, 50, alpha]);
            let picture = Picture::new(pixels.png().unwrap()).unwrap();
            assert_eq!((picture.size(), picture.format()), ([5, 3], PictureFormat::Png));
            assert_eq!(picture.pixels().unwrap(), pixels);
        }
    }

    #[test]
    fn what_is_no_picture_is_refused_in_words() {
        assert!(Picture::new(b"no picture".to_vec()).unwrap_err().contains("PNG, JPEG or WebP"));
        let whole = Pixels::filled(64, 64, [1, 2, 3, 255]).png().unwrap();
        let torn = Picture::new(whole[..whole.len() / 2].to_vec());
        assert!(torn.is_err_and(|e| !e.is_empty()) || torn_pixels_fail(&whole));
    }

    fn torn_pixels_fail(whole: &[u8]) -> bool {
        Picture::new(whole[..whole.len() / 2].to_vec()).is_ok_and(|p| p.pixels().is_err())
    }
}
