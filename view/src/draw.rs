//! Drawn on top of a picture: captions, numbered marks, joint axes; all edges smooth.

use glamx::DVec3;

use crate::camera::Camera;
use crate::font;
use crate::raster::Picture;

const INK: [u8; 3] = [27, 32, 42];
const WHITE: [u8; 3] = [255; 3];
const MARK: [u8; 3] = [226, 26, 94];
/// An axis counts as hidden where the surface is nearer by more than this share of the depth.
const HIDDEN: f64 = 0.004;

/// What a stroke is drawn with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ink {
    /// sRGB.
    pub colour: [u8; 3],
    /// 0 (invisible) to 1 (covers).
    pub opacity: f64,
}

impl Ink {
    /// Ink that covers.
    pub fn solid(colour: [u8; 3]) -> Self {
        Self { colour, opacity: 1.0 }
    }
}

/// Writes a line of text on a dark label in the top left corner.
pub fn caption(picture: &mut Picture, text: &str) {
    let dot = text_dot(picture);
    let (pad, corner) = (4.2 * dot, 4.0 * dot);
    let room = f64::from(picture.size[0]) - 2.0 * corner;
    let high = font::CAPITAL as f64 * dot + 2.0 * pad - dot;
    let wide = (font::layout(text).1 * dot + 2.0 * pad).min(room);
    let label = [[corner, corner], [corner + wide, corner + high]];
    rounded_box(picture, label, 2.6 * dot, Ink { colour: INK, opacity: 0.86 });
    write(picture, [corner + pad, corner + pad], dot, Ink::solid(WHITE), text);
}

/// Puts a dot with a label (a number, best one or two characters) at a pixel position.
pub fn mark(picture: &mut Picture, at: [f64; 2], label: &str) {
    let dot = 0.72 * text_dot(picture);
    let wide = font::layout(label).1 * dot;
    let radius = (7.0 * dot).max(wide / 2.0 + 3.5 * dot);
    stroke(picture, [at, at], radius + 1.6 * dot, Ink::solid(WHITE));
    stroke(picture, [at, at], radius, Ink::solid(MARK));
    let corner = [at[0] - wide / 2.0, at[1] - (font::CAPITAL - 1) as f64 / 2.0 * dot];
    write(picture, corner, dot, Ink::solid(WHITE), label);
}

/// Draws a joint's axis as an arrow between two points of the object frame; where the surface hides
/// it, it is dashed and faint.
pub fn draw_axis(picture: &mut Picture, camera: &Camera, from: DVec3, to: DVec3, colour: [u8; 3]) {
    let radius = 0.9 * text_dot(picture);
    let pieces = pieces(picture, camera, from, to);
    for casing in [true, false] {
        for piece in &pieces {
            let ink = match (casing, piece.hidden) {
                (true, false) => Ink { colour: WHITE, opacity: 0.9 },
                (false, false) => Ink::solid(colour),
                (false, true) if piece.dash => Ink { colour, opacity: 0.75 },
                _ => continue,
            };
            let wide = match (casing, piece.hidden) {
                (true, _) => radius * 1.9,
                (_, hidden) => radius * if hidden { 0.6 } else { 1.0 },
            };
            stroke(picture, piece.ends, wide, ink);
        }
    }
    if let Some(last) = pieces.iter().rev().find(|p| p.ends[0] != p.ends[1]) {
        arrow_head(picture, last.ends, radius, colour);
    }
}

/// A short straight piece of an axis in the picture.
struct Piece {
    ends: [[f64; 2]; 2],
    hidden: bool,
    dash: bool,
}

fn pieces(picture: &Picture, camera: &Camera, from: DVec3, to: DVec3) -> Vec<Piece> {
    let steps = (picture.size[0].max(picture.size[1]) / 8).clamp(16, 256);
    let at = |i: u32| camera.project(from.lerp(to, f64::from(i) / f64::from(steps)));
    let piece = |i: u32| {
        let (a, b) = (at(i)?, at(i + 1)?);
        let middle = [0, 1].map(|c| (a.pixel[c] + b.pixel[c]) / 2.0);
        let hidden = depth_at(picture, middle) < (a.depth + b.depth) / 2.0 * (1.0 - HIDDEN);
        Some(Piece { ends: [a.pixel, b.pixel], hidden, dash: (i / 2).is_multiple_of(2) })
    };
    (0..steps).filter_map(piece).collect()
}

fn depth_at(picture: &Picture, [x, y]: [f64; 2]) -> f64 {
    let inside = x >= 0.0 && y >= 0.0;
    let index = inside.then(|| picture.index([x as u32, y as u32])).flatten();
    index.and_then(|i| picture.depth.get(i)).map_or(f64::INFINITY, |&d| f64::from(d))
}

fn arrow_head(picture: &mut Picture, [a, tip]: [[f64; 2]; 2], radius: f64, colour: [u8; 3]) {
    let length = (tip[0] - a[0]).hypot(tip[1] - a[1]);
    if length == 0.0 {
        return;
    }
    let along = [(tip[0] - a[0]) / length, (tip[1] - a[1]) / length];
    let back = |share: f64| {
        let side = share * 3.4 * radius;
        [0, 1].map(|c| tip[c] - along[c] * 8.0 * radius + side * [-along[1], along[0]][c])
    };
    for (wide, ink) in [(1.8, Ink { colour: WHITE, opacity: 0.9 }), (0.9, Ink::solid(colour))] {
        for i in -6..=6 {
            stroke(picture, [tip, back(f64::from(i) / 6.0)], wide * radius, ink);
        }
    }
}

/// Writes text whose first letter's top left dot is at `at`; `dot` is the distance of two dots in
/// pixels.
pub fn write(picture: &mut Picture, at: [f64; 2], dot: f64, ink: Ink, text: &str) {
    for (character, offset) in text.chars().zip(font::layout(text).0) {
        let left = at[0] + offset * dot;
        let place = |[x, y]: [f64; 2]| [left + x * dot, at[1] + y * dot];
        for ends in font::strokes(character) {
            stroke(picture, ends.map(place), 0.52 * dot, ink);
        }
    }
}

/// A straight stroke with round ends, `radius` pixels to either side; a disc if its ends coincide.
pub fn stroke(picture: &mut Picture, [a, b]: [[f64; 2]; 2], radius: f64, ink: Ink) {
    let corners =
        [[0, 1].map(|c| a[c].min(b[c]) - radius), [0, 1].map(|c| a[c].max(b[c]) + radius)];
    let along = [b[0] - a[0], b[1] - a[1]];
    let squared = along[0] * along[0] + along[1] * along[1];
    fill(picture, corners, ink, |[x, y]| {
        let off = [x - a[0], y - a[1]];
        let dot = off[0] * along[0] + off[1] * along[1];
        let t = if squared > 0.0 { (dot / squared).clamp(0.0, 1.0) } else { 0.0 };
        (off[0] - t * along[0]).hypot(off[1] - t * along[1]) - radius
    });
}

/// A filled box with round corners.
pub fn rounded_box(picture: &mut Picture, corners: [[f64; 2]; 2], radius: f64, ink: Ink) {
    let [low, high] = corners;
    fill(picture, corners, ink, |p| {
        let over = [0, 1].map(|c| {
            let half = (high[c] - low[c]) / 2.0;
            ((p[c] - (low[c] + high[c]) / 2.0).abs() - half + radius).max(0.0)
        });
        over[0].hypot(over[1]) - radius
    });
}

/// Colours every pixel near a shape given by its signed distance (negative inside), in pixels.
fn fill(
    picture: &mut Picture,
    [low, high]: [[f64; 2]; 2],
    ink: Ink,
    distance: impl Fn([f64; 2]) -> f64,
) {
    let [width, height] = picture.size.map(f64::from);
    let range = |low: f64, high: f64, n: f64| {
        let ends = [(low - 1.0).floor().clamp(0.0, n), (high + 1.0).ceil().clamp(0.0, n)];
        ends[0] as u32..ends[1] as u32
    };
    for y in range(low[1], high[1], height) {
        for x in range(low[0], high[0], width) {
            let cover = 0.5 - distance([f64::from(x) + 0.5, f64::from(y) + 0.5]);
            let Some(index) = picture.index([x, y]) else { continue };
            if let Some(pixel) = picture.colour.get_mut(index) {
                blend(pixel, ink, cover.clamp(0.0, 1.0));
            }
        }
    }
}

fn blend(pixel: &mut [u8; 4], ink: Ink, cover: f64) {
    let share = ink.opacity * cover;
    let mix = |from: u8, to: u8| {
        (f64::from(from) + (f64::from(to) - f64::from(from)) * share).round() as u8
    };
    let [r, g, b, a] = *pixel;
    let [to_r, to_g, to_b] = ink.colour;
    *pixel = [mix(r, to_r), mix(g, to_g), mix(b, to_b), mix(a, 255)];
}

/// Distance of two dots of the typeface, pixels, so that text fits the picture's size.
fn text_dot(picture: &Picture) -> f64 {
    (f64::from(picture.size[0].min(picture.size[1])) / 320.0).max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dark(picture: &Picture) -> usize {
        picture.colour.iter().filter(|c| c[0] < 128).count()
    }

    #[test]
    fn a_disc_covers_its_area() {
        let mut picture = Picture::blank([101, 101], [255; 4]);
        stroke(&mut picture, [[50.5; 2]; 2], 30.0, Ink::solid([0; 3]));
        let missing: f64 = picture.colour.iter().map(|c| 1.0 - f64::from(c[0]) / 255.0).sum();
        assert!((missing - std::f64::consts::PI * 900.0).abs() < 5.0, "{missing}");
    }

    #[test]
    fn a_caption_stays_in_the_top_left_corner() {
        let mut picture = Picture::blank([640, 480], [255; 4]);
        caption(&mut picture, "front  1/8");
        assert!(dark(&picture) > 1000);
        let places = (0..480).flat_map(|y| (0..640).map(move |x| [x, y]));
        let changed = |p: &[u32; 2]| picture.colour[picture.index(*p).unwrap()] != [255; 4];
        assert!(places.filter(changed).all(|[x, y]| x < 320 && y < 60));
    }

    #[test]
    fn a_mark_is_centred_on_its_pixel() {
        let mut picture = Picture::blank([400, 400], [255; 4]);
        mark(&mut picture, [200.0, 100.0], "12");
        let (mut sum, mut count) = ([0.0; 2], 0.0);
        for (i, c) in picture.colour.iter().enumerate() {
            if c[1] < 128 {
                sum = [sum[0] + (i % 400) as f64 + 0.5, sum[1] + (i / 400) as f64 + 0.5];
                count += 1.0;
            }
        }
        let centre = sum.map(|s| s / count);
        assert!((centre[0] - 200.0).abs() < 1.5 && (centre[1] - 100.0).abs() < 1.5, "{centre:?}");
    }

    #[test]
    fn an_axis_behind_the_surface_is_fainter_than_one_before_it() {
        let (eye, target) = (DVec3::new(0.0, -5.0, 0.0), DVec3::ZERO);
        let camera = Camera { eye, target, up: DVec3::Z, fov_y: 0.6, size: [200, 200] };
        let drawn = |depth: f32| {
            let mut picture = Picture::blank([200, 200], [255; 4]);
            picture.depth.fill(depth);
            draw_axis(&mut picture, &camera, DVec3::NEG_Z * 0.5, DVec3::Z, [200, 0, 0]);
            picture.colour.iter().filter(|c| c[1] < 100).count()
        };
        let (before, behind) = (drawn(9.0), drawn(2.0));
        assert!(before > 2 * behind, "{before} against {behind}");
        assert!(behind > 0);
    }

    #[test]
    fn drawing_outside_the_picture_is_harmless() {
        let mut picture = Picture::blank([50, 50], [255; 4]);
        stroke(&mut picture, [[-1e12, 5.0], [1e12, 7.0]], 2.0, Ink::solid([0; 3]));
        mark(&mut picture, [-500.0, 1e300], "1");
        caption(&mut Picture::blank([0, 0], [0; 4]), "nothing");
    }
}
