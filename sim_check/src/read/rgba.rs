//! Colours as both formats write them. No check is about them: what is no colour is none.

/// An sRGB colour with opacity from three or four numbers of 0 to 1, those outside held to the nearest
/// end; `None` for any other text.
pub(super) fn rgba(text: &str) -> Option<[u8; 4]> {
    let mut numbers = [1.0; 4];
    let mut count = 0;
    for word in text.split_whitespace() {
        let number: f64 = word.parse().ok()?;
        *numbers.get_mut(count).filter(|_| number.is_finite())? = number;
        count += 1;
    }
    (count >= 3).then(|| numbers.map(|n| (n.clamp(0.0, 1.0) * 255.0).round() as u8))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_or_four_numbers_are_a_colour_and_nothing_else_is() {
        assert_eq!(rgba("1 0.5 0"), Some([255, 128, 0, 255]));
        assert_eq!(rgba(" 2 -1 .2\n0 "), Some([255, 0, 51, 0]));
        for text in ["", "1 0", "1 0 0 1 1", "red", "1 0 nan", "1,0,0"] {
            assert_eq!(rgba(text), None, "{text}");
        }
    }
}
