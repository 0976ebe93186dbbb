//! What a part's words say about its size: a button is small, a body is large.

/// How much of an object's surface a part usually covers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SizePrior {
    /// Mean of log₁₀ of the part's share of the surface.
    pub mean: f64,
    /// Standard deviation of the same.
    pub spread: f64,
}

/// Parts pressed, turned or flipped with a finger.
const TINY: SizePrior = SizePrior { mean: -2.5, spread: 0.5 };
/// Parts held in a hand, and what rolls.
const SMALL: SizePrior = SizePrior { mean: -1.6, spread: 0.5 };
/// Parts no word says anything about.
const ORDINARY: SizePrior = SizePrior { mean: -0.9, spread: 0.45 };
/// The base.
const BASE: SizePrior = SizePrior { mean: -0.1, spread: 0.2 };

const TINY_WORDS: [&str; 18] = [
    "button", "key", "knob", "dial", "latch", "lock", "screw", "pin", "selector", "switch",
    "caster", "pawl", "bolt", "adjuster", "toggle", "beacon", "trigger", "nut",
];
const SMALL_WORDS: [&str; 24] = [
    "handle",
    "flap",
    "crank",
    "wheel",
    "lever",
    "cap",
    "pedal",
    "roller",
    "hook",
    "propeller",
    "antenna",
    "rod",
    "brace",
    "fork",
    "hatch",
    "hand",
    "fan",
    "swivel",
    "weight",
    "rudder",
    "spout",
    "tab",
    "slider",
    "beater",
];
/// Words after which a text only says where the part is or what hangs on it.
const ASIDES: [&str; 8] = ["with", "from", "of", "on", "in", "at", "and", "for"];

/// The usual size of a part called `text`; `base` for the root of the tree.
///
/// Means and spreads are those of some thousand articulated CAD objects with known parts.
pub fn size_prior(text: &str, base: bool) -> SizePrior {
    if base {
        return BASE;
    }
    let lower = text.to_lowercase();
    let words = lower.split(|c: char| !c.is_alphabetic()).filter(|w| !w.is_empty());
    let head: Vec<&str> = words.take_while(|w| !ASIDES.contains(w)).collect();
    let says = |list: &[&str], w: &str| {
        let stem = w.strip_suffix('s').unwrap_or(w);
        list.iter().any(|k| stem.ends_with(k) || w.ends_with(k))
    };
    for word in head.iter().rev() {
        if says(&TINY_WORDS, word) {
            return TINY;
        }
        if says(&SMALL_WORDS, word) {
            return SMALL;
        }
    }
    ORDINARY
}

impl SizePrior {
    /// Log-likelihood of a share of the surface, up to a constant; being smaller costs nothing.
    pub fn score(&self, share: f64) -> f64 {
        let over = (share.max(1e-12).log10() - self.mean) / self.spread;
        -0.5 * knob("over", 1.0) * over.max(0.0).powi(2)
            - 0.5 * knob("under", 0.2) * over.min(0.0).powi(2)
    }
}

pub fn knob(name: &str, default: f64) -> f64 {
    static K: std::sync::OnceLock<std::collections::BTreeMap<String, f64>> =
        std::sync::OnceLock::new();
    let k = K.get_or_init(|| {
        std::env::var("K")
            .unwrap_or_default()
            .split(',')
            .filter_map(|x| {
                let (a, b) = x.split_once('=')?;
                Some((a.to_string(), b.parse().ok()?))
            })
            .collect()
    });
    k.get(name).copied().unwrap_or(default)
}
