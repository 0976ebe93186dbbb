//! Moments in time as people write them: RFC 3339, or nanoseconds since 1970.
//!
//! ```
//! use trace::moment;
//!
//! let noon = moment::parse("2026-01-31T12:00:00Z")?;
//! assert_eq!(noon, 1_769_860_800_000_000_000);
//! assert_eq!(moment::parse("2026-01-31T13:00:00+01:00")?, noon);
//! assert_eq!(moment::written(noon), "2026-01-31T12:00:00Z");
//! # Ok::<(), moment::MomentError>(())
//! ```

use super::clock::Time;

/// Days before each month in a common year.
const DAYS_BEFORE: [u64; 12] = [0, 31, 59, 90, 120, 151, 181, 212, 243, 273, 304, 334];

/// Why a text is no moment.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected a moment like 2026-01-31T12:00:00Z or nanoseconds since 1970, found `{0}`")]
pub struct MomentError(String);

/// Reads RFC 3339 (years 1970 to 2553) or a whole number of nanoseconds since 1970.
///
/// # Errors
/// [`MomentError`] for anything else.
pub fn parse(text: &str) -> Result<Time, MomentError> {
    let number = !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    let time = if number { text.parse().ok() } else { rfc3339(text) };
    time.ok_or_else(|| MomentError(text.into()))
}

fn rfc3339(text: &str) -> Option<Time> {
    let (date, time) = text.split_once(['T', 't', ' '])?;
    let (clock, offset) = match time.find(['Z', 'z', '+', '-']) {
        Some(at) => time.split_at_checked(at)?,
        None => return None,
    };
    let [year, month, day] = numbers(date, '-', [4, 2, 2])?;
    let (clock, fraction) = clock.split_once('.').unwrap_or((clock, "0"));
    let [hour, minute, second] = numbers(clock, ':', [2, 2, 2])?;
    let in_range = (1970..=2553).contains(&year)
        && (1..=12).contains(&month)
        && (1..=days_in(year, month)).contains(&day)
        && hour < 24
        && minute < 60
        && second < 61;
    let seconds = in_range.then(|| {
        let days = days_before(year, month) + day - 1;
        ((days * 24 + hour) * 60 + minute) * 60 + second
    })?;
    let seconds = i64::try_from(seconds).ok()?.checked_sub(offset_seconds(offset)?)?;
    u64::try_from(seconds).ok()?.checked_mul(1_000_000_000)?.checked_add(nanoseconds(fraction)?)
}

fn numbers<const N: usize>(text: &str, mark: char, widths: [usize; N]) -> Option<[u64; N]> {
    let mut found = [0; N];
    let mut parts = text.split(mark);
    for (slot, width) in found.iter_mut().zip(widths) {
        let part = parts.next().filter(|p| p.len() == width)?;
        *slot = part.bytes().all(|b| b.is_ascii_digit()).then(|| part.parse().ok())??;
    }
    parts.next().is_none().then_some(found)
}

fn nanoseconds(fraction: &str) -> Option<u64> {
    let valid = (1..=9).contains(&fraction.len()) && fraction.bytes().all(|b| b.is_ascii_digit());
    valid.then(|| format!("{fraction:0<9}").parse().ok())?
}

fn offset_seconds(offset: &str) -> Option<i64> {
    if offset.eq_ignore_ascii_case("z") {
        return Some(0);
    }
    let sign = if offset.starts_with('-') { -1 } else { 1 };
    let [hours, minutes] = numbers(offset.get(1..)?, ':', [2, 2])?;
    let seconds = i64::try_from((hours * 60 + minutes) * 60).ok()?;
    (hours < 24 && minutes < 60).then_some(sign * seconds)
}

/// The moment as RFC 3339 in UTC, whole seconds.
pub fn written(time: Time) -> String {
    let seconds = time / 1_000_000_000;
    let (mut days, clock) = (seconds / 86_400, seconds % 86_400);
    let mut year = 1970;
    while days >= 365 + u64::from(is_leap(year)) {
        days -= 365 + u64::from(is_leap(year));
        year += 1;
    }
    let mut month = 1;
    while days >= days_in(year, month) {
        days -= days_in(year, month);
        month += 1;
    }
    let (hour, minute, second) = (clock / 3600, clock / 60 % 60, clock % 60);
    format!("{year:04}-{month:02}-{:02}T{hour:02}:{minute:02}:{second:02}Z", days + 1)
}

fn is_leap(year: u64) -> bool {
    year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400))
}

fn days_in(year: u64, month: u64) -> u64 {
    match month {
        2 if is_leap(year) => 29,
        2 => 28,
        4 | 6 | 9 | 11 => 30,
        _ => 31,
    }
}

/// Days from 1970-01-01 to the first of a month.
fn days_before(year: u64, month: u64) -> u64 {
    let leaps = |y: u64| y / 4 - y / 100 + y / 400;
    let before = DAYS_BEFORE.get(month as usize - 1).copied().unwrap_or_default();
    let leap_day = u64::from(month > 2 && is_leap(year));
    (year - 1970) * 365 + leaps(year - 1) - leaps(1969) + before + leap_day
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_moments_read_as_their_nanoseconds() {
        assert_eq!(parse("1970-01-01T00:00:00Z"), Ok(0));
        assert_eq!(parse("2000-03-01T00:00:00Z"), Ok(951_868_800_000_000_000));
        assert_eq!(parse("2026-01-31T12:34:56.5Z"), Ok(1_769_862_896_500_000_000));
        assert_eq!(parse("2026-01-31T13:34:56.5+01:00"), parse("2026-01-31T12:34:56.5Z"));
        assert_eq!(parse("1700000000000000000"), Ok(1_700_000_000_000_000_000));
    }

    #[test]
    fn a_moment_reads_as_it_was_written() {
        for text in ["1970-01-01T00:00:00Z", "2000-02-29T23:59:59Z", "2026-12-31T12:34:56Z"] {
            assert_eq!(written(parse(text).unwrap()), text);
        }
    }

    #[test]
    fn what_is_no_moment_is_refused_with_what_was_found() {
        let wrong = ["", "now", "2026-02-29T00:00:00Z", "2026-01-01", "2026-01-01T25:00:00Z", "-5"];
        for text in wrong.into_iter().chain(["2026-01-01T00:00:00", "1969-12-31T23:59:59Z", "é"]) {
            assert_eq!(parse(text), Err(MomentError(text.into())), "{text}");
        }
    }
}
