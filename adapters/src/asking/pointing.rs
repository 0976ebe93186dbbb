//! How a model writes a point in a picture: a property of the model, not of its service.

/// Order and unit of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Convention {
    /// `"point": [y, x]`, each 0 to 1000: Gemini.
    Yx1000,
    /// `"point_2d": [x, y]`, each 0 to 1000: Qwen 3 and Qwen 2 VL.
    Xy1000,
    /// `"point_2d": [x, y]` in pixels of the picture: Qwen 2.5 VL, and models without a habit.
    XyPixels,
}

impl Convention {
    /// The habit of a model by its name; pixels for one that is not known to have any.
    pub fn of_model(model: &str) -> Self {
        let model = model.to_ascii_lowercase();
        let is = |name: &str| model.contains(name);
        if is("gemini") {
            Self::Yx1000
        } else if is("qwen3") || is("qwen2-vl") {
            Self::Xy1000
        } else {
            Self::XyPixels
        }
    }

    /// The key a point stands under.
    pub fn key(self) -> &'static str {
        match self {
            Self::Yx1000 => "point",
            Self::Xy1000 | Self::XyPixels => "point_2d",
        }
    }

    /// What the model is told.
    pub(super) fn words(self) -> &'static str {
        match self {
            Self::Yx1000 => {
                "A `point` is [y, x], integers from 0 to 1000: y 0 is the top edge of the view and 1000 the bottom, x 0 the left edge and 1000 the right."
            }
            Self::Xy1000 => {
                "A `point_2d` is [x, y], integers from 0 to 1000: x 0 is the left edge of the view and 1000 the right, y 0 the top edge and 1000 the bottom."
            }
            Self::XyPixels => {
                "A `point_2d` is [x, y] in whole pixels of the view as it was sent, from its top left corner."
            }
        }
    }

    /// The pixel a written point means in a picture of `size`; none outside of it.
    pub fn pixel(self, written: [i64; 2], size: [u32; 2]) -> Option<[f64; 2]> {
        let [first, second] = written;
        let (x, y) = if self == Self::Yx1000 { (second, first) } else { (first, second) };
        let place = |v: i64, pixels: u32| {
            let most = if self == Self::XyPixels { i64::from(pixels) } else { 1000 };
            let inside = (0..=most).contains(&v);
            // The far edge means the last pixel.
            let share = v as f64 / most as f64;
            inside.then(|| (share * f64::from(pixels)).min(f64::from(pixels) - 0.5))
        };
        Some([place(x, size[0])?, place(y, size[1])?])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_place_is_written_in_three_ways() {
        let size = [400, 200];
        assert_eq!(Convention::Yx1000.pixel([500, 250], size), Some([100.0, 100.0]));
        assert_eq!(Convention::Xy1000.pixel([250, 500], size), Some([100.0, 100.0]));
        assert_eq!(Convention::XyPixels.pixel([100, 100], size), Some([100.0, 100.0]));
        assert_eq!(Convention::Xy1000.pixel([1000, 0], size), Some([399.5, 0.0]));
    }

    #[test]
    fn a_point_outside_the_picture_is_none_and_not_clamped() {
        assert_eq!(Convention::Yx1000.pixel([1001, 3], [400, 200]), None);
        assert_eq!(Convention::XyPixels.pixel([100, 201], [400, 200]), None);
        assert_eq!(Convention::Xy1000.pixel([-1, 3], [400, 200]), None);
    }

    #[test]
    fn models_are_known_by_name() {
        assert_eq!(Convention::of_model("gemini-3-pro"), Convention::Yx1000);
        assert_eq!(Convention::of_model("Qwen/Qwen3-VL-8B"), Convention::Xy1000);
        assert_eq!(Convention::of_model("gpt-5.4"), Convention::XyPixels);
    }
}
