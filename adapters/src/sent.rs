//! A photo as it leaves the house: upright, no larger than anybody looks at, and nothing but pixels.

use std::io::Cursor;

use image::metadata::Orientation;
use image::{DynamicImage, ImageDecoder as _, ImageFormat, ImageReader};

use crate::{AdapterError, Photo};

/// Longest side that is sent, pixels; generators and VLMs scale down further.
pub const MAX_SENT_SIDE: u32 = 2048;

/// The photo as a PNG of its upright pixels: place, time and camera stay at home.
///
/// # Errors
/// [`AdapterError::Photo`] when it cannot be encoded.
pub fn sent(photo: &Photo) -> Result<Photo, AdapterError> {
    let broken = |e: image::ImageError| AdapterError::Photo {
        path: "photo".into(),
        rule: "a photo must decode to its last pixel".into(),
        found: e.to_string(),
    };
    let upright = upright(&photo.bytes).map_err(broken)?;
    let largest = upright.width().max(upright.height());
    let fitted = if largest > MAX_SENT_SIDE {
        upright.resize(MAX_SENT_SIDE, MAX_SENT_SIDE, image::imageops::FilterType::Triangle)
    } else {
        upright
    };
    let mut png = Cursor::new(vec![]);
    let pixels = if fitted.color().has_alpha() {
        DynamicImage::from(fitted.to_rgba8())
    } else {
        DynamicImage::from(fitted.to_rgb8())
    };
    pixels.write_to(&mut png, ImageFormat::Png).map_err(broken)?;
    let size = [pixels.width(), pixels.height()];
    Ok(Photo { bytes: png.into_inner(), media_type: "image/png".into(), size })
}

fn upright(bytes: &[u8]) -> Result<DynamicImage, image::ImageError> {
    let reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format()?;
    let mut decoder = reader.into_decoder()?;
    let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    let mut picture = DynamicImage::from_decoder(decoder)?;
    picture.apply_orientation(orientation);
    Ok(picture)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::photo::tests::png;

    /// A JPEG that says where it was taken and that it lies on its side.
    fn jpeg_with_exif() -> Vec<u8> {
        let picture = image::RgbImage::from_fn(40, 20, |x, _| image::Rgb([(x * 6) as u8, 9, 9]));
        let mut jpeg = Cursor::new(vec![]);
        picture.write_to(&mut jpeg, ImageFormat::Jpeg).unwrap();
        let tiff = b"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0\x06\0\0\0\0\0\0\0GPS 48.2,16.4";
        let mut exif = b"Exif\0\0".to_vec();
        exif.extend_from_slice(tiff);
        let length = (exif.len() + 2) as u16;
        let mut bytes = vec![0xff, 0xd8, 0xff, 0xe1];
        bytes.extend_from_slice(&length.to_be_bytes());
        bytes.extend_from_slice(&exif);
        bytes.extend_from_slice(&jpeg.into_inner()[2..]);
        bytes
    }

    #[test]
    fn what_the_camera_wrote_stays_at_home_and_the_picture_stands_upright() {
        let photo = Photo::read(jpeg_with_exif(), "p.jpg").unwrap();
        let sent = sent(&photo).unwrap();
        assert_eq!((sent.media_type.as_str(), sent.size), ("image/png", [20, 40]));
        assert!(!String::from_utf8_lossy(&sent.bytes).contains("GPS"));
    }

    #[test]
    fn a_large_photo_is_made_smaller_and_comes_out_the_same_each_time() {
        let photo = Photo::read(png(3000, 90), "p.png").unwrap();
        assert_eq!(sent(&photo).unwrap().size, [2048, 61]);
        assert_eq!(sent(&photo).unwrap(), sent(&photo).unwrap());
    }
}
