//! Bounds in words, as the profile prints them.

use super::bounds::{Grown, Moved, Shrunk};

/// A figure without the noise of its last bits.
fn plain(x: f64) -> f64 {
    (x * 1e6).round() / 1e6
}

/// A share as a percentage: `0.2 %`.
pub(crate) fn percent(share: f64) -> String {
    format!("{} %", plain(100.0 * share))
}

/// A length in millimetres: `5 mm`.
pub(crate) fn mm(metres: f64) -> String {
    format!("{} mm", plain(1000.0 * metres))
}

/// A whole number with its thousands apart: `50,000`.
pub(crate) fn thousands(whole: f64) -> String {
    let digits = format!("{whole:.0}");
    let first = digits.len() % 3;
    let (head, tail) = digits.split_at(first);
    let groups = tail.as_bytes().chunks(3).map(|g| String::from_utf8_lossy(g).into_owned());
    let head = (!head.is_empty()).then(|| head.to_owned());
    head.into_iter().chain(groups).collect::<Vec<_>>().join(",")
}

/// `max(1 mm, 0.2 % of the diagonal)`, with what its share is of.
pub(crate) fn grown(bound: Grown, of: &str) -> String {
    format!("max({}, {} of {of})", mm(bound.least), percent(bound.share))
}

/// `min(1 mm, 0.2 % of the diagonal)`.
pub(crate) fn shrunk(bound: Shrunk) -> String {
    format!("min({}, {} of the diagonal)", mm(bound.most), percent(bound.share))
}

/// `2 deg or 5 mm`.
pub(crate) fn moved(bound: Moved) -> String {
    format!("{} deg or {}", plain(bound.degrees), mm(bound.metres))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_said_as_people_say_them() {
        assert_eq!([percent(0.001), percent(0.05), percent(0.95)], ["0.1 %", "5 %", "95 %"]);
        assert_eq!([mm(0.005), mm(0.0005), mm(3e-3)], ["5 mm", "0.5 mm", "3 mm"]);
        let said = [7.0, 100.0, 1000.0, 50_000.0, 1_234_567.0].map(thousands);
        assert_eq!(said, ["7", "100", "1,000", "50,000", "1,234,567"]);
        assert_eq!(moved(Moved { degrees: 0.5, metres: 0.002 }), "0.5 deg or 2 mm");
    }
}
