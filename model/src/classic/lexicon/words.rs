//! What the words of a part say about how it moves: a small lexicon of roles.

/// The kinds of moving part that people name; [`Role::Other`] when no word is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Role {
    /// No known word.
    Other,
    /// Turns about its own axis of revolution, driven or rolling: wheel, rotor, drum.
    Wheel,
    /// Turned by fingers about its own axis: knob, dial, cap, screw.
    Knob,
    /// Turns over a face like a clock's hand.
    Pointer,
    /// Pressed inwards: button, key.
    Button,
    /// Pulled out of a body: drawer, tray, rack.
    Drawer,
    /// Slides along a guide: carriage, slider, bolt.
    Slider,
    /// One tube or column out of another.
    Lift,
    /// Closes an opening from above: lid, hatch, hood.
    Lid,
    /// A small leaf that swings about a horizontal edge.
    Flap,
    /// Closes an opening from the side: door, gate, window.
    Door,
    /// A door of an appliance that falls open about its lower edge.
    FallDoor,
    /// Moved by hand or foot about one end: lever, handle, pedal, switch.
    Lever,
    /// One bar of a linkage.
    Arm,
    /// What something stands on: leg, stand, frame.
    Stand,
    /// What a mount carries: head, screen, shade.
    Head,
}

/// Every role, in the order of the score table.
pub const ROLES: [Role; 16] = [
    Role::Other,
    Role::Wheel,
    Role::Knob,
    Role::Pointer,
    Role::Button,
    Role::Drawer,
    Role::Slider,
    Role::Lift,
    Role::Lid,
    Role::Flap,
    Role::Door,
    Role::FallDoor,
    Role::Lever,
    Role::Arm,
    Role::Stand,
    Role::Head,
];

/// What the roles are called as features, in the order of [`ROLES`].
pub const ROLE_NAMES: [&str; ROLES.len()] = [
    "role_other",
    "role_wheel",
    "role_knob",
    "role_pointer",
    "role_button",
    "role_drawer",
    "role_slider",
    "role_lift",
    "role_lid",
    "role_flap",
    "role_door",
    "role_fall_door",
    "role_lever",
    "role_arm",
    "role_stand",
    "role_head",
];

/// What a part's text says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Meaning {
    /// The role of its head noun.
    pub role: Role,
    /// A word for turning about the vertical: pan, swivel, caster.
    pub upright: bool,
    /// A word for turning about a level axis: tilt, pitch, fold.
    pub level: bool,
}

/// Head nouns of each role. Words of four letters and more are also found inside a longer word.
const NOUNS: [(Role, &[&str]); 15] = [
    (
        Role::Wheel,
        &[
            "wheel",
            "wheels",
            "roller",
            "rotor",
            "propeller",
            "prop",
            "fan",
            "drum",
            "gear",
            "pulley",
            "hub",
            "turntable",
            "platter",
            "globe",
            "spool",
            "reel",
            "turbine",
            "agitator",
            "beater",
            "impeller",
            "disc",
            "disk",
            "crank",
            "spinner",
            "carousel",
            "tub",
            "planet",
            "tire",
            "tyre",
            "sprocket",
            "chainring",
            "spindle",
            "shaft",
            "axle",
            "auger",
            "capsule",
            "brush",
            "basket",
            "handwheel",
            "flywheel",
            "cylinder",
            "mandrel",
        ],
    ),
    (
        Role::Knob,
        &[
            "knob",
            "dial",
            "cap",
            "screw",
            "ring",
            "encoder",
            "winder",
            "valve",
            "bulb",
            "nut",
            "bezel",
            "thumbscrew",
            "lens",
            "selector",
            "adjuster",
            "collar",
            "bottle",
            "stopper",
            "plug",
            "chuck",
            "crown",
        ],
    ),
    (Role::Pointer, &["hand", "pointer", "needle", "indicator", "tonearm", "wiper", "pendulum"]),
    (Role::Button, &["button", "key", "plunger", "pushbutton", "keycap"]),
    (Role::Drawer, &["drawer", "tray", "rack", "shelf", "crisper", "bin", "cartridge"]),
    (
        Role::Slider,
        &[
            "slider", "slide", "carriage", "bolt", "weight", "saddle", "jaw", "rod", "carrier",
            "truck", "trolley", "shuttle", "ram", "runner", "gantry", "clamp", "stop", "fence",
            "piston",
        ],
    ),
    (
        Role::Lift,
        &[
            "column",
            "mast",
            "post",
            "pole",
            "tube",
            "sleeve",
            "stage",
            "section",
            "lift",
            "barrel",
            "elevator",
            "platform",
            "extension",
            "fly",
            "riser",
            "stem",
            "telescopic handle",
            "pull handle",
        ],
    ),
    (
        Role::Lid,
        &[
            "lid", "hatch", "top", "hood", "bonnet", "trunk", "roof", "tabletop", "canopy", "seat",
            "cover", "backrest", "plate",
        ],
    ),
    (
        Role::Flap,
        &[
            "flap", "visor", "tailgate", "tab", "petal", "lip", "rudder", "aileron", "louver",
            "slat", "vane", "fin", "ramp", "damper",
        ],
    ),
    (
        Role::Door,
        &[
            "door",
            "gate",
            "leaf",
            "window",
            "panel",
            "wing",
            "shutter",
            "sash",
            "glass",
            "portal",
            "turnstile",
        ],
    ),
    (
        Role::FallDoor,
        &["oven door", "dishwasher door", "dish washer door", "drop door", "glove box"],
    ),
    (
        Role::Lever,
        &[
            "lever", "handle", "pedal", "switch", "latch", "hook", "trigger", "clasp", "tap",
            "faucet", "spout", "toggle", "rocker", "stick", "catch", "lock", "bail", "paddle",
            "clip", "grip", "bell", "pawl", "buckle", "hasp",
        ],
    ),
    (
        Role::Arm,
        &[
            "arm", "link", "boom", "forearm", "brace", "stay", "yoke", "antenna", "branch",
            "strut", "finger", "wrist", "bar", "jib", "bucket", "bridge", "upperarm", "fork",
            "blade", "cabin", "beam", "shoulder", "elbow", "knuckle", "rail", "temple",
        ],
    ),
    (
        Role::Stand,
        &["leg", "stand", "foot", "frame", "kickstand", "support", "bracket", "easel", "base"],
    ),
    (
        Role::Head,
        &[
            "head",
            "body",
            "screen",
            "cradle",
            "shade",
            "lamp",
            "monitor",
            "turret",
            "camera",
            "spotlight",
            "display",
            "pod",
            "gimbal",
            "mirror",
            "bowl",
            "tool",
            "can",
        ],
    ),
];

/// What robots' formats call every part.
pub(crate) const ANY_PART: &str = "link";
const UPRIGHT: [&str; 9] =
    ["pan", "swivel", "yaw", "caster", "castor", "slew", "turntable", "azimuth", "steering"];
const LEVEL: [&str; 7] = ["tilt", "pitch", "fold", "folding", "elevation", "flip", "recline"];
/// Appliances whose door falls open.
const FALLING: [&str; 7] =
    ["oven", "dishwasher", "mailbox", "glove", "stove", "toaster oven", "dish washer"];
/// What follows these words describes the part, it does not name it.
const TAILS: [&str; 9] =
    [" with ", " of ", " for ", " on ", " in ", " from ", " behind ", " and ", " at "];

/// A text without its digits: `drawer 1` and `drawer 2` are of one kind.
pub(crate) fn stem(text: &str) -> String {
    text.chars().filter(|c| !c.is_ascii_digit()).collect()
}

/// Whether two texts name parts of one kind: one role, or one text but for digits where the role is unknown.
pub(crate) fn are_alike(a: &str, b: &str) -> bool {
    let role = |text| meaning(text, "").role;
    role(a) == role(b) && (role(a) != Role::Other || stem(a) == stem(b))
}

/// Reads a part's text, in the light of what the whole object is.
pub fn meaning(text: &str, category: &str) -> Meaning {
    let text = plain(text);
    let named = TAILS.iter().filter_map(|t| text.find(t)).min().map_or(&text[..], |i| &text[..i]);
    let says = |words: &[&str]| words.iter().any(|w| find(&text, w).is_some());
    let role = match head_noun(named) {
        Role::Other => head_noun(&text),
        role => role,
    };
    let category = plain(category);
    let falls = FALLING.iter().any(|w| find(&category, w).is_some() || find(&text, w).is_some());
    let role = if role == Role::Door && falls { Role::FallDoor } else { role };
    let rolls = ["wheel", "wheels"].iter().any(|w| named.ends_with(w));
    Meaning { role, upright: says(&UPRIGHT) && !rolls, level: says(&LEVEL) }
}

/// Lower case, anything but letters a space.
fn plain(text: &str) -> String {
    let letter = |c: char| if c.is_alphabetic() { c.to_ascii_lowercase() } else { ' ' };
    text.chars().map(letter).collect::<String>().trim().to_string()
}

/// The role of the known noun that ends last; of two that end together, the longer. What formats call
/// every part, as in `door_link`, names one only where nothing else does.
fn head_noun(text: &str) -> Role {
    let all = NOUNS.iter().flat_map(|(role, words)| words.iter().map(move |w| (*role, *w)));
    let found =
        all.filter_map(|(role, w)| find(text, w).map(|end| (w != ANY_PART, end, w.len(), role)));
    found.max().map_or(Role::Other, |(.., role)| role)
}

/// Where the last mention of `word` ends: as a word of its own, or inside one if it is long enough
/// to mean the same there.
fn find(text: &str, word: &str) -> Option<usize> {
    let own = |at: usize| {
        let before = text[..at].chars().next_back().is_none_or(|c| c == ' ');
        let rest = &text[at + word.len()..];
        before
            && (rest.is_empty() || rest.starts_with(' ') || rest == "s" || rest.starts_with("s "))
    };
    let hits = text.match_indices(word).map(|(at, _)| at);
    hits.filter(|&at| word.len() >= 4 || own(at)).last().map(|at| at + word.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_noun_names_the_part() {
        let role = |t: &str| meaning(t, "").role;
        assert_eq!(role("door handle"), Role::Lever);
        assert_eq!(role("left_upper drawer 3"), Role::Drawer);
        assert_eq!(role("microdoorroot"), Role::Door);
        assert_eq!(role("spout with knob"), Role::Lever);
        assert_eq!(role("keyboard thing"), Role::Other);
        assert_eq!(role("wheels"), Role::Wheel);
        assert_eq!(role("door_link"), Role::Door);
        assert_eq!(role("forelink 2"), Role::Arm);
    }

    #[test]
    fn an_oven_door_falls_open_and_a_cabinet_door_swings() {
        assert_eq!(meaning("front door", "oven").role, Role::FallDoor);
        assert_eq!(meaning("front door", "cabinet").role, Role::Door);
        assert!(meaning("caster", "").upright && !meaning("caster wheel", "").upright);
        assert!(meaning("pan head", "").upright && meaning("tilt head", "").level);
    }
}
