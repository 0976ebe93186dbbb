//! Pictures that follow each other as one animated WebP file, the same bytes for the same pictures.
//!
//! Each picture is kept whole, without loss but for [`ALIKE`]; of those behind the first only what
//! changed is written. The pictures themselves are encoded by `image`; the container around them, which
//! no crate in Rust alone writes, is that of RFC 9649.

use image::codecs::webp::WebPEncoder;
use image::{ExtendedColorType, ImageEncoder};

use crate::ViewError;
use crate::raster::Picture;

/// A pixel that differs by at most this in every channel from what is shown stays as it is.
pub const ALIKE: u8 = 1;
/// Most pixels across or down: what the container can name.
const LONGEST: u32 = 1 << 14;
/// Longest time a picture can stand, milliseconds.
const LASTING: u32 = (1 << 24) - 1;
/// What the container says of a frame that is not laid over the one before.
const WHOLE: u8 = 0x02;
/// What the container says of an animation with transparent pixels.
const ANIMATED: u8 = 0x02 | 0x10;

/// An animation in the making. It plays again and again.
#[derive(Clone, Debug)]
pub struct Film {
    size: [u32; 2],
    shown: Vec<[u8; 4]>,
    frames: Vec<Frame>,
}

/// What changes from one picture to the next, and how long it stands.
#[derive(Clone, Debug)]
struct Frame {
    corner: [u32; 2],
    size: [u32; 2],
    milliseconds: u32,
    /// Whether some of it stays as it is.
    has_holes: bool,
    chunk: Vec<u8>,
}

impl Film {
    /// An animation of pictures of a size, pixels across and down.
    ///
    /// # Errors
    /// [`ViewError::Size`] for a size without pixels, or above 16,384 on a side.
    pub fn new(size: [u32; 2]) -> Result<Self, ViewError> {
        let [width, height] = size;
        if size.iter().any(|n| !(1..=LONGEST).contains(n)) {
            return Err(ViewError::Size { width, height, colours: 0 });
        }
        Ok(Self { size, shown: vec![], frames: vec![] })
    }

    /// Shows a picture for so many milliseconds. What is there longer than the container can say is
    /// shown as long as it can.
    ///
    /// # Errors
    /// [`ViewError`] for a picture of another size, or when the encoder refuses.
    pub fn push(&mut self, picture: &Picture, milliseconds: u32) -> Result<(), ViewError> {
        let [width, height] = picture.size;
        let colours = picture.colour.len();
        let all = self.size[0] as usize * self.size[1] as usize;
        if picture.size != self.size || colours != all {
            return Err(ViewError::Size { width, height, colours });
        }
        let (corner, size) = match (self.changed(&picture.colour), self.frames.last_mut()) {
            (None, Some(last)) => {
                last.milliseconds = last.milliseconds.saturating_add(milliseconds).min(LASTING);
                return Ok(());
            }
            (Some(place), Some(_)) => place,
            (_, None) => ([0; 2], self.size),
        };
        let (chunk, has_holes) = self.draw(&picture.colour, corner, size)?;
        let milliseconds = milliseconds.min(LASTING);
        self.frames.push(Frame { corner, size, milliseconds, has_holes, chunk });
        Ok(())
    }

    /// The box around all that changes: its corner, both numbers even, and its size.
    fn changed(&self, colour: &[[u8; 4]]) -> Option<([u32; 2], [u32; 2])> {
        let width = self.size[0] as usize;
        let (mut low, mut high) = ([u32::MAX; 2], [0; 2]);
        for (i, (new, shown)) in colour.iter().zip(&self.shown).enumerate() {
            if !alike(new, shown) {
                for (axis, v) in [(i % width) as u32, (i / width) as u32].into_iter().enumerate() {
                    low[axis] = v.min(low[axis]);
                    high[axis] = v.max(high[axis]);
                }
            }
        }
        let corner = low.map(|v| v & !1);
        (low[0] != u32::MAX).then(|| (corner, [0, 1].map(|a| high[a] - corner[a] + 1)))
    }

    /// Draws what changed in a box; what did not is transparent. Returns the chunk that holds it, and
    /// whether some of it is transparent.
    fn draw(
        &mut self,
        colour: &[[u8; 4]],
        [left, top]: [u32; 2],
        [width, height]: [u32; 2],
    ) -> Result<(Vec<u8>, bool), ViewError> {
        let first = self.shown.is_empty();
        if first {
            self.shown = colour.to_vec();
        }
        let mut pixels = Vec::with_capacity(width as usize * height as usize);
        for y in top..top + height {
            let start = y as usize * self.size[0] as usize + left as usize;
            let run = start..start + width as usize;
            for (shown, &[r, g, b, _]) in self.shown[run.clone()].iter_mut().zip(&colour[run]) {
                let new = [r, g, b, 255];
                let same = !first && alike(&new, shown);
                pixels.push(if same { [0; 4] } else { new });
                if !same {
                    *shown = new;
                }
            }
        }
        let has_holes = pixels.iter().any(|p| p[3] == 0);
        let mut file = Vec::new();
        let encoder = WebPEncoder::new_lossless(&mut file);
        let written =
            encoder.write_image(pixels.as_flattened(), width, height, ExtendedColorType::Rgba8);
        written.map_err(|e| ViewError::Encode(e.to_string()))?;
        // Behind the head of the file stands the chunk with the picture, padded to even length.
        Ok((file.split_off(file.len().min(12)), has_holes))
    }

    /// The file.
    ///
    /// # Errors
    /// [`ViewError::EmptySheet`] without pictures; [`ViewError::Encode`] above 4 GB.
    pub fn finish(self) -> Result<Vec<u8>, ViewError> {
        if self.frames.is_empty() {
            return Err(ViewError::EmptySheet);
        }
        let mut body = b"WEBP".to_vec();
        let head = [vec![ANIMATED, 0, 0, 0], less_one(self.size[0]), less_one(self.size[1])];
        chunk(&mut body, *b"VP8X", &head.concat())?;
        // Background white, without end.
        chunk(&mut body, *b"ANIM", &[255, 255, 255, 255, 0, 0])?;
        for frame in &self.frames {
            let [x, y] = frame.corner.map(|v| short(v / 2));
            let [width, height] = frame.size.map(less_one);
            // What is whole replaces what was there: no reader then has to mix colours.
            let mixing = if frame.has_holes { 0 } else { WHOLE };
            let head = [x, y, width, height, short(frame.milliseconds), vec![mixing]];
            chunk(&mut body, *b"ANMF", &[head.concat(), frame.chunk.clone()].concat())?;
        }
        let mut file = Vec::with_capacity(body.len() + 8);
        chunk(&mut file, *b"RIFF", &body)?;
        Ok(file)
    }
}

fn alike(a: &[u8; 4], b: &[u8; 4]) -> bool {
    (0..3).all(|c| a[c].abs_diff(b[c]) <= ALIKE)
}

/// A number of 24 bits, the least first.
fn short(value: u32) -> Vec<u8> {
    value.to_le_bytes()[..3].to_vec()
}

fn less_one(value: u32) -> Vec<u8> {
    short(value.saturating_sub(1))
}

fn chunk(file: &mut Vec<u8>, name: [u8; 4], bytes: &[u8]) -> Result<(), ViewError> {
    let length = u32::try_from(bytes.len());
    let length = length.map_err(|_| ViewError::Encode("more than 4 GB".into()))?;
    file.extend(name);
    file.extend(length.to_le_bytes());
    file.extend_from_slice(bytes);
    if bytes.len() % 2 == 1 {
        file.push(0);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use image::AnimationDecoder as _;
    use image::codecs::webp::WebPDecoder;

    use super::*;

    const SIZE: [u32; 2] = [31, 17];

    /// Noise that is the same each time, with a bright box whose left edge is at `x`.
    fn picture(x: u32) -> Picture {
        let mut picture = Picture::blank(SIZE, [0, 0, 0, 255]);
        for (i, pixel) in picture.colour.iter_mut().enumerate() {
            let (column, row) = (i as u32 % SIZE[0], i as u32 / SIZE[0]);
            let inside = (x..x + 5).contains(&column) && (3..9).contains(&row);
            let noise = (i as u32).wrapping_mul(2_654_435_761).to_be_bytes();
            *pixel = if inside { [250, 200, 30, 255] } else { [noise[0], noise[1], noise[2], 255] };
        }
        picture
    }

    fn back(file: &[u8]) -> Vec<(u32, Vec<u8>)> {
        let decoder = WebPDecoder::new(std::io::Cursor::new(file)).unwrap();
        let frames = decoder.into_frames().collect_frames().unwrap();
        let one = |f: &image::Frame| (f.delay().numer_denom_ms().0, f.buffer().as_raw().clone());
        frames.iter().map(one).collect()
    }

    #[test]
    fn an_animation_reads_back_picture_for_picture() {
        let places = [4, 5, 11, 20, 4];
        let film = || {
            let mut film = Film::new(SIZE).unwrap();
            places.iter().for_each(|&x| film.push(&picture(x), 40 + x).unwrap());
            film.finish().unwrap()
        };
        let read = back(&film());
        assert_eq!(read.len(), places.len());
        for ((delay, colours), x) in read.iter().zip(places) {
            assert_eq!(*delay, 40 + x);
            let near = |(a, b): (&u8, &u8)| a.abs_diff(*b) <= ALIKE;
            assert!(colours.iter().zip(picture(x).colour.as_flattened()).all(near), "{x}");
        }
        assert_eq!(film(), film());
    }

    #[test]
    fn what_does_not_change_takes_no_room_and_stands_longer() {
        let mut film = Film::new(SIZE).unwrap();
        film.push(&picture(4), 100).unwrap();
        let one = film.clone().finish().unwrap().len();
        film.push(&picture(4), 50).unwrap();
        let read = back(&film.clone().finish().unwrap());
        assert_eq!((read.len(), read[0].0), (1, 150));
        film.push(&picture(5), 50).unwrap();
        let two = film.finish().unwrap().len();
        // Of noise the changed sixteenth costs a table of its own, and less than half of the whole.
        assert!(two - one < one / 2, "{one} and {two}");
    }

    #[test]
    fn what_drifts_slowly_is_never_far_from_what_is_shown() {
        let grey = |v: u8| Picture::blank(SIZE, [v, v, v, 255]);
        let mut film = Film::new(SIZE).unwrap();
        (100..130).for_each(|v| film.push(&grey(v), 10).unwrap());
        let read = back(&film.finish().unwrap());
        assert_eq!(read.len(), 15);
        assert!(read.last().unwrap().1[0] >= 130 - 1 - ALIKE);
    }

    #[test]
    fn what_is_no_film_is_refused() {
        assert!(Film::new([0, 5]).is_err() && Film::new([5, 1 << 20]).is_err());
        let film = Film::new(SIZE).unwrap();
        assert_eq!(film.clone().finish(), Err(ViewError::EmptySheet));
        let other = Picture::blank([3, 3], [0; 4]);
        assert!(matches!(film.clone().push(&other, 1), Err(ViewError::Size { .. })));
    }
}
