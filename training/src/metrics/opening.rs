//! Which way a joint opens: whether a part that can go one way alone is said to go that way.

use serde::Serialize;

use super::body::Motion;
use object::JointKind;

/// A true joint goes one way if at least this share of its range lies to one side of the pose shown.
/// A guess: a lid that also gives a little the other way still opens one way.
pub const ONE_WAY: f64 = 0.9;
/// A prediction opens a way if at least this share of its range lies on that side. A guess: a
/// quarter as far the other way is where a person would no longer say that it opens one way.
pub const OPENS: f64 = 0.8;

/// How a joint that truly goes one way was said to go.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Opening {
    /// The true way.
    Right,
    /// Both ways, or round and round.
    Both,
    /// The other way.
    Wrong,
}

impl Opening {
    /// What becomes of a joint that truly goes one way; `ends` are the prediction's, turned to the
    /// true axis's side. None of a joint that goes both ways or nowhere.
    pub fn of(wanted: &Motion, found: &Motion, ends: [f64; 2]) -> Option<Self> {
        let upwards = upward_share([wanted.lower, wanted.upper])?;
        if wanted.kind == JointKind::Continuous || upwards.max(1.0 - upwards) < ONE_WAY {
            return None;
        }
        let Some(found_upwards) = upward_share(ends) else { return Some(Self::Both) };
        let share = if upwards > 0.5 { found_upwards } else { 1.0 - found_upwards };
        Some(match share {
            _ if found.kind == JointKind::Continuous => Self::Both,
            s if s >= OPENS => Self::Right,
            s if s <= 1.0 - OPENS => Self::Wrong,
            _ => Self::Both,
        })
    }
}

/// Shares of joints that truly go one way and whose axis is found.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct OpeningShares {
    /// How many there are.
    pub joints: usize,
    /// Share that opens the true way; none where there are none.
    pub right: Option<f64>,
    /// Share that goes both ways.
    pub both: Option<f64>,
    /// Share that opens the other way.
    pub wrong: Option<f64>,
}

impl OpeningShares {
    /// Sums up joints, each by its weight.
    pub fn of(openings: impl IntoIterator<Item = (f64, Opening)>) -> Self {
        let all: Vec<_> = openings.into_iter().collect();
        let weight: f64 = all.iter().map(|(weight, _)| weight).sum();
        let share = |which: Opening| {
            let own: f64 = all.iter().filter(|(_, o)| *o == which).map(|(weight, _)| weight).sum();
            (weight > 0.0).then(|| own / weight)
        };
        Self {
            joints: all.len(),
            right: share(Opening::Right),
            both: share(Opening::Both),
            wrong: share(Opening::Wrong),
        }
    }
}

/// The share of a range that lies above the pose shown; none of a range without length.
fn upward_share([lower, upper]: [f64; 2]) -> Option<f64> {
    let (down, up) = ((-lower).max(0.0), upper.max(0.0));
    (down + up > 0.0).then(|| up / (down + up))
}
