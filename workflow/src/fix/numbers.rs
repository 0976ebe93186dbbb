//! Numbers as they are written into a model: short, and near enough for every check.

use glamx::DVec3;

/// Digits of what is computed: a billionth, a thousandth of the strictest bound (J1 and M3: a millionth).
const DIGITS: usize = 9;
/// What is smaller than this share of the largest beside it is rounding, and written as 0.
const NOTHING: f64 = 1e-12;

/// A number with at most nine digits that count.
pub(crate) fn short(value: f64) -> String {
    digits(value, DIGITS)
}

/// A number with at most so many digits that count.
pub(super) fn digits(value: f64, count: usize) -> String {
    let rounded: f64 = format!("{value:.*e}", count.saturating_sub(1)).parse().unwrap_or(value);
    // No sign for nothing.
    let rounded = if rounded == 0.0 { 0.0 } else { rounded };
    let plain = rounded.to_string();
    let power = format!("{rounded:e}");
    if plain.len() <= power.len() + 2 { plain } else { power }
}

/// The same rounded towards 0, with five digits that count: a range is never wider for it.
pub(super) fn inward(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return "0".into();
    }
    let scale = 10f64.powi(4 - value.abs().log10().floor() as i32);
    digits((value * scale).trunc() / scale, 6)
}

/// Three numbers with blanks between them.
pub(crate) fn triple(v: DVec3) -> String {
    let all = cleaned(&v.to_array());
    all.iter().map(|v| short(*v)).collect::<Vec<_>>().join(" ")
}

/// Numbers of one kind with those that are rounding made 0.
pub(super) fn cleaned(all: &[f64]) -> Vec<f64> {
    let most = all.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
    all.iter().map(|v| if v.abs() <= NOTHING * most { 0.0 } else { *v }).collect()
}

/// The same number as it is written, its sign turned.
pub(super) fn negated(word: &str) -> String {
    if word.trim().parse::<f64>() == Ok(0.0) {
        return word.trim_start_matches(['-', '+']).to_owned();
    }
    match word.strip_prefix('-') {
        Some(rest) => rest.to_owned(),
        None => format!("-{}", word.trim_start_matches('+')),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_turn_their_sign_as_they_are_written() {
        let said =
            [std::f64::consts::FRAC_PI_2, 0.1 + 0.2, 90.0, -0.0, 1.234e-9, 0.000123].map(short);
        assert_eq!(said, ["1.57079633", "0.3", "90", "0", "1.234e-9", "0.000123"]);
        assert_eq!(
            ["0", "-0.0", "1.50", "-1", "+2"].map(negated),
            ["0", "0.0", "-1.50", "1", "-2"]
        );
        assert_eq!(triple(DVec3::new(1.0, 1e-17, -0.5)), "1 0 -0.5");
    }

    #[test]
    fn the_end_of_a_range_is_rounded_inward() {
        assert_eq!(
            [0.123456, -0.123456, 1.99999, 0.0, 12.34567].map(inward),
            ["0.12345", "-0.12345", "1.9999", "0", "12.345"]
        );
    }
}
