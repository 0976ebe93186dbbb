//! What a part's words say about its size, and which parts are of one kind.

use crate::classic::learned::pack::{Pack, PackError, place};
use crate::classic::learned::shipped::Shipped;
use crate::classic::lexicon::words::ANY_PART;

/// How much of an object's surface a part usually covers, as log₁₀ of the share: learned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SizePrior {
    mean: f64,
    spread: f64,
}

/// A part may not take in more where its score would fall below this: a switch is no tenth of an
/// object.
const ABSURD: f64 = -4.5;

static SHIPPED: Shipped<Sizes> =
    Shipped::new("sizes", include_bytes!("../../../weights/sizes.pack"), Sizes::read);

/// What packs of sizes are called inside.
pub const KIND: &str = "sizes";
/// Their table of features: [`NAMES`].
pub const TABLE: &str = "log10_share";
/// What is known of each class.
pub const NAMES: [&str; 2] = ["mean", "spread"];
/// The classes, each a section of the pack: pressed, turned or flipped with a finger; held in a hand,
/// and what rolls; of which no word says anything; the base.
pub const CLASSES: [&str; 4] = ["tiny", "small", "ordinary", "base"];

/// The usual size of each class.
#[derive(Debug)]
struct Sizes {
    tiny: SizePrior,
    small: SizePrior,
    ordinary: SizePrior,
    base: SizePrior,
}

impl Default for Sizes {
    fn default() -> Self {
        let any = SizePrior { mean: 0.0, spread: 1.0 };
        Self { tiny: any, small: any, ordinary: any, base: any }
    }
}

impl Sizes {
    fn read(pack: &Pack<'_>) -> Result<Self, PackError> {
        pack.is(KIND)?;
        pack.asks(TABLE, &NAMES)?;
        let one = |class: usize| {
            let numbers = pack.numbers(CLASSES[class], NAMES.len())?;
            Ok(SizePrior { mean: numbers[0], spread: numbers[1] })
        };
        Ok(Self { tiny: one(0)?, small: one(1)?, ordinary: one(2)?, base: one(3)? })
    }
}

/// Refuses a pack that this program cannot read.
pub(crate) fn check() -> Result<(), PackError> {
    SHIPPED.check()
}

/// The name and the digest of the pack.
pub(crate) fn digest_of_pack() -> (&'static str, String) {
    SHIPPED.digest()
}

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
/// Words that tell parts of one kind apart.
const SIDES: [&str; 22] = [
    "left", "right", "front", "rear", "back", "upper", "lower", "top", "bottom", "middle",
    "center", "centre", "inner", "outer", "first", "second", "third", "fourth", "fifth", "near",
    "far", "mid",
];

impl SizePrior {
    /// The usual size of a part that a text describes; `base` for the root of the tree.
    pub(crate) fn of(text: &str, base: bool) -> Self {
        let Sizes { tiny, small, ordinary, base: whole } = SHIPPED.get();
        *[tiny, small, ordinary, whole][size_class(text, base)]
    }

    /// Whether a part may have as much of the surface as this share; it may always have less than is
    /// usual.
    pub(crate) fn allows(self, share: f64) -> bool {
        share.max(1e-12).log10() <= self.mean || self.score(share) > ABSURD
    }

    /// Log-likelihood of a share of the surface, up to a constant: half a squared deviation above
    /// the mean, a fifth of that below it.
    pub(crate) fn score(self, share: f64) -> f64 {
        let off = (share.max(1e-12).log10() - self.mean) / self.spread;
        -0.5 * off * off * if off > 0.0 { 1.0 } else { 0.2 }
    }
}

/// How large a part usually is that a text describes, as a place in [`CLASSES`]; `base` for the root of
/// the tree.
///
/// The last word of the list before an aside decides: "control knob from the left" is a knob. A word
/// counts if it ends in one of the list, so a handwheel is a wheel, or holds a long one, so a
/// lightswitchroot is a switch.
pub fn size_class(text: &str, base: bool) -> usize {
    const TINY: usize = place(&CLASSES, "tiny");
    const SMALL: usize = place(&CLASSES, "small");
    if base {
        return const { place(&CLASSES, "base") };
    }
    let of_word = |word: &String| {
        let stem = word.strip_suffix('s').unwrap_or(word);
        let holds = |k: &&str| stem.ends_with(k) || k.len() > 5 && stem.contains(k);
        let small = || SMALL_WORDS.iter().any(&holds).then_some(SMALL);
        if TINY_WORDS.iter().any(holds) { Some(TINY) } else { small() }
    };
    let words = words(text);
    let head = words.iter().take_while(|w| !ASIDES.contains(&w.as_str()));
    head.filter_map(of_word).last().unwrap_or(const { place(&CLASSES, "ordinary") })
}

/// A text without numbers and sides: parts of one family are copies of each other by name.
pub(crate) fn family(text: &str) -> String {
    let kept = words(text).into_iter().filter(|w| !SIDES.contains(&w.as_str()));
    kept.collect::<Vec<_>>().join(" ")
}

/// The word that names a part: the last before an aside, but for those that tell parts of one kind apart
/// and for what robots' formats call every part.
pub(crate) fn noun(text: &str) -> String {
    named(text).pop().unwrap_or_default()
}

/// What a part is called before an aside, but for the words that [`noun`] passes over.
pub(crate) fn named(text: &str) -> Vec<String> {
    let head = words(text).into_iter().take_while(|w| !ASIDES.contains(&w.as_str()));
    head.filter(|w| w != ANY_PART && !SIDES.contains(&w.as_str())).collect()
}

fn words(text: &str) -> Vec<String> {
    let lower = text.to_lowercase();
    let words = lower.split(|c: char| !c.is_alphabetic()).filter(|w| !w.is_empty());
    words.map(String::from).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_noun_of_a_part_is_its_kind() {
        let nouns = ["middle control knob", "first knob from left", "number key 7", "right", ""];
        assert_eq!(nouns.map(noun), ["knob", "knob", "key", "", ""]);
        assert_eq!(["knob_link", "link 2"].map(noun), ["knob", ""], "every part is a link");
    }

    #[test]
    fn the_last_telling_word_before_an_aside_decides() {
        let Sizes { tiny, small, ordinary, base } = *SHIPPED.get();
        assert_eq!(SizePrior::of("second control knob from left", false), tiny);
        assert_eq!(SizePrior::of("lid release button", false), tiny);
        assert_eq!(SizePrior::of("handwheels", false), small);
        assert_eq!(SizePrior::of("lightswitchroot", false), tiny);
        assert_eq!(SizePrior::of("door with handle", false), ordinary);
        assert_eq!(SizePrior::of("button box", true), base);
    }

    #[test]
    fn a_button_as_large_as_a_cabinet_is_far_less_likely_than_a_door() {
        let button = SizePrior::of("button", false);
        let door = SizePrior::of("door", false);
        assert!(button.score(0.6) < door.score(0.6) - 5.0);
        assert!(button.score(0.003) > button.score(0.01));
        assert!(button.allows(0.09) && !button.allows(0.11) && door.allows(1.0));
        assert!(SizePrior::of("body", true).allows(1e-9), "little is never too much");
    }

    #[test]
    fn numbers_and_sides_do_not_make_a_family() {
        assert_eq!(family("front left wheel 0"), family("Rear right wheel 3"));
        assert_ne!(family("left wheel"), family("left door"));
    }
}
