//! Three dots: whether a model can point, and in which of the known ways it writes a point.

use std::io::Cursor;

use image::{Rgb, RgbImage};
use serde_json::{Value, json};

use super::pointing::Convention;
use super::repair::first_json;
use super::{Asking, SYSTEM, schema};
use crate::AdapterError;
use crate::chat::{Codec, Piece, Question, Turn};

const DOTS: &str = include_str!("../prompts/dots.md");
/// Pixels a side: neither 1000, so that pixels are not mistaken for thousandths, nor far from what
/// is asked in earnest.
const SIZE: u32 = 1280;
/// Pixels.
const RADIUS: f64 = 40.0;
/// A dot counts as hit within this share of the picture's side.
const NEAR: f64 = 0.03;
/// Colour, and the middle as shares of width and height; no two exchanged or mirrored.
const PLACES: [(&str, [u8; 3], [f64; 2]); 3] = [
    ("red", [220, 30, 30], [0.14, 0.62]),
    ("green", [20, 150, 40], [0.71, 0.23]),
    ("blue", [30, 60, 220], [0.55, 0.86]),
];

/// What came of the test.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Pointing {
    /// It points as it is asked to.
    Right,
    /// It points, but writes points in another way than it is asked to.
    Otherwise(Convention),
    /// No known way explains its answer.
    Cannot(String),
}

/// The picture with the dots, PNG.
pub fn picture() -> Result<Vec<u8>, AdapterError> {
    let side = f64::from(SIZE);
    let dot = |x: u32, y: u32| {
        let inside = |place: [f64; 2]| {
            let [dx, dy] = [f64::from(x) - place[0] * side, f64::from(y) - place[1] * side];
            dx.hypot(dy) <= RADIUS
        };
        let hit = PLACES.iter().find(|(_, _, place)| inside(*place));
        Rgb(hit.map_or([255; 3], |(_, colour, _)| *colour))
    };
    let mut png = Cursor::new(vec![]);
    let written = RgbImage::from_fn(SIZE, SIZE, dot).write_to(&mut png, image::ImageFormat::Png);
    written.map_err(|e| AdapterError::Photo {
        path: "the picture with three dots".into(),
        rule: "a picture must be encoded".into(),
        found: e.to_string(),
    })?;
    Ok(png.into_inner())
}

impl<C: Codec> Asking<C> {
    /// Asks the model for three dots, once.
    ///
    /// # Errors
    /// [`AdapterError`] when it gives no answer; a wrong one is a result.
    pub fn points_at_dots(&self) -> Result<Pointing, AdapterError> {
        let words = DOTS.replace("{convention}", self.convention.words());
        let pieces = vec![Piece::text(words), Piece::picture("image/png", &picture()?)];
        let key = self.convention.key();
        let question = Question {
            step: "vlm.dots/0".into(),
            system: SYSTEM,
            turns: vec![Turn::Ours(pieces)],
            schema_name: "dots",
            schema: schema::dots(key),
            max_tokens: self.max_tokens,
        };
        let response = self.transport.send(&self.codec.request(&question))?;
        let reply = self.codec.reply(&question.step, &response)?;
        let answer = first_json(&reply.text).unwrap_or_else(|_| json!({}));
        Ok(judged(&answer, self.convention))
    }
}

/// Which way of writing explains an answer: the one asked for first.
fn judged(answer: &Value, asked: Convention) -> Pointing {
    let all = [Convention::Yx1000, Convention::Xy1000, Convention::XyPixels];
    let Some(written) = written(answer) else {
        return Pointing::Cannot("its answer has no point for each of the three colours".into());
    };
    if explains(asked, &written) {
        return Pointing::Right;
    }
    let mut others = all.into_iter().filter(|c| explains(*c, &written));
    match (others.next(), others.next()) {
        (Some(convention), None) => Pointing::Otherwise(convention),
        _ => Pointing::Cannot(format!("it points at {written:?}, which no known way explains")),
    }
}

/// The three points as they are written, red, green and blue.
fn written(answer: &Value) -> Option<[[i64; 2]; 3]> {
    let points = answer.get("points")?.as_array()?;
    let one = |colour: &str| {
        let mut same = points.iter().filter(|p| {
            p.get("label")
                .and_then(Value::as_str)
                .is_some_and(|l| l.to_lowercase().contains(colour))
        });
        let point = same.next()?;
        let pair = point.get("point").or(point.get("point_2d"))?.as_array()?;
        let number = |n: usize| pair.get(n)?.as_f64().map(|v| v.round() as i64);
        same.next().is_none().then_some([number(0)?, number(1)?])
    };
    let [red, green, blue] = PLACES.map(|(colour, ..)| one(colour));
    Some([red?, green?, blue?])
}

fn explains(convention: Convention, written: &[[i64; 2]; 3]) -> bool {
    let side = f64::from(SIZE);
    let hit = |written: [i64; 2], [u, v]: [f64; 2]| {
        let pixel = convention.pixel(written, [SIZE; 2]);
        pixel.is_some_and(|[x, y]| (x / side - u).abs() <= NEAR && (y / side - v).abs() <= NEAR)
    };
    written.iter().zip(&PLACES).all(|(found, (_, _, place))| hit(*found, *place))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answer(convention: Convention) -> Value {
        let point = |(colour, _, [x, y]): (&str, [u8; 3], [f64; 2])| {
            let (x, y) = match convention {
                Convention::Yx1000 => (y * 1000.0, x * 1000.0),
                Convention::Xy1000 => (x * 1000.0, y * 1000.0),
                Convention::XyPixels => (x * f64::from(SIZE), y * f64::from(SIZE)),
            };
            json!({ "label": colour, convention.key(): [x.round() as i64, y.round() as i64] })
        };
        json!({ "points": PLACES.map(point) })
    }

    #[test]
    fn each_way_of_writing_is_told_from_the_others() {
        let all = [Convention::Yx1000, Convention::Xy1000, Convention::XyPixels];
        for asked in all {
            for written in all {
                let expected =
                    if asked == written { Pointing::Right } else { Pointing::Otherwise(written) };
                assert_eq!(judged(&answer(written), asked), expected, "{asked:?} {written:?}");
            }
        }
    }

    #[test]
    fn a_model_that_guesses_does_not_pass() {
        let middle = |colour: &str| json!({ "label": colour, "point": [500, 500] });
        let points = ["red", "green", "blue"].map(middle);
        let middle = json!({ "points": points });
        assert!(matches!(judged(&middle, Convention::Yx1000), Pointing::Cannot(_)));
        let mut two = answer(Convention::Yx1000);
        two["points"].as_array_mut().unwrap().pop();
        assert!(matches!(judged(&two, Convention::Yx1000), Pointing::Cannot(_)));
        assert!(matches!(judged(&json!(7), Convention::Yx1000), Pointing::Cannot(_)));
    }

    #[test]
    fn the_picture_shows_each_dot_where_it_is_said_to_be() {
        let picture = image::load_from_memory(&picture().unwrap()).unwrap().to_rgb8();
        for (_, colour, [x, y]) in PLACES {
            let place = [x, y].map(|share| (share * f64::from(SIZE)) as u32);
            assert_eq!(picture.get_pixel(place[0], place[1]).0, colour);
        }
    }
}
