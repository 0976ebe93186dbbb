//! What parts are made of: densities, usual wall thicknesses and friction by the words people use.
//!
//! The figures are everyday engineering values, not measurements of the object at hand; whatever
//! comes from here is marked as a default.
//!
//! ```
//! use asset::mass::materials::named;
//! let wood = named("solid oak").map(|m| m.name);
//! assert_eq!((wood, named("unobtainium")), (Some("wood"), None));
//! ```

use object::condition::{Condition, Prompt};
use object::{Origin, Sourced};
use serde::{Deserialize, Serialize};

/// Usual wall of a hollow body: its share of the body's diagonal, then least and most, metres.
pub type Wall = [f64; 3];

/// A material of the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Its name in the table.
    pub name: &'static str,
    /// Density of the solid material, kg/m³.
    pub density: f64,
    /// Usual wall of a hollow body.
    pub wall: Wall,
    /// Coefficient of sliding friction against everyday surfaces.
    pub friction: f64,
    words: &'static [&'static str],
}

const fn material(
    name: &'static str,
    density: f64,
    wall: Wall,
    friction: f64,
    words: &'static [&'static str],
) -> Material {
    Material { name, density, wall, friction, words }
}

/// The table; the first row with a word that occurs in a material's description is meant.
pub const MATERIALS: &[Material] = &[
    material(
        "rubber",
        1150.0,
        [0.015, 2e-3, 6e-3],
        0.9,
        &["rubber", "tyre", "tire", "silicone", "latex"],
    ),
    material("foam", 40.0, [0.5, 5e-3, 0.5], 0.6, &["foam", "sponge", "cushion", "padding"]),
    material("leather", 900.0, [0.01, 1e-3, 4e-3], 0.6, &["leather"]),
    material("fabric", 300.0, [0.02, 1e-3, 1e-2], 0.6, &["fabric", "cloth", "textile", "canvas"]),
    material("cardboard", 300.0, [5e-3, 1e-3, 5e-3], 0.5, &["cardboard", "paper"]),
    material(
        "plastic",
        1050.0,
        [5e-3, 1.8e-3, 4e-3],
        0.4,
        &["plastic", "abs", "nylon", "poly", "hdpe", "pvc", "acrylic", "resin", "bakelite"],
    ),
    material(
        "engineered wood",
        700.0,
        [0.02, 6e-3, 18e-3],
        0.45,
        &["plywood", "mdf", "chipboard", "particle", "engineered", "laminate", "veneer"],
    ),
    material(
        "wood",
        650.0,
        [0.012, 6e-3, 18e-3],
        0.45,
        &["wood", "oak", "pine", "beech", "walnut", "bamboo", "timber", "teak", "maple"],
    ),
    material("aluminium", 2700.0, [2e-3, 1e-3, 3e-3], 0.4, &["alumin", "alloy"]),
    material("brass", 8500.0, [4e-3, 1.5e-3, 4e-3], 0.4, &["brass", "bronze", "copper"]),
    material(
        "steel",
        7850.0,
        [1.2e-3, 0.8e-3, 1.5e-3],
        0.45,
        &["steel", "iron", "metal", "chrome", "tin", "zinc"],
    ),
    material("glass", 2500.0, [6e-3, 2.5e-3, 6e-3], 0.4, &["glass", "mirror"]),
    material("ceramic", 2300.0, [0.015, 3e-3, 1e-2], 0.45, &["ceramic", "porcelain", "clay"]),
    material(
        "stone",
        2600.0,
        [0.03, 1e-2, 4e-2],
        0.6,
        &["stone", "marble", "granite", "concrete", "brick"],
    ),
];

/// Words of a part or an object that say what it is usually made of, where nobody told.
const USUALLY: &[(&str, &[&str])] = &[
    ("rubber", &["wheel", "tyre", "tire", "caster", "castor"]),
    ("glass", &["glass", "window", "lens", "mirror", "bulb"]),
    ("plastic", &["knob", "button", "key", "switch", "dial"]),
    ("foam", &["cushion", "pillow", "mattress"]),
    ("fabric", &["seat", "sofa", "curtain"]),
    (
        "engineered wood",
        &["drawer", "cabinet", "cupboard", "wardrobe", "shelf", "desk", "dresser", "nightstand"],
    ),
    ("wood", &["table", "chair", "easel", "chest", "crate", "stool"]),
    ("ceramic", &["mug", "cup", "toilet", "basin", "vase"]),
    ("aluminium", &["ladder", "tripod", "laptop", "scooter"]),
    (
        "steel",
        &[
            "oven",
            "fridge",
            "refrigerator",
            "freezer",
            "dishwasher",
            "washing",
            "washer",
            "dryer",
            "microwave",
            "safe",
            "faucet",
            "tap",
            "hinge",
            "gate",
            "vise",
            "toolbox",
            "locker",
            "rack",
            "bracket",
            "handle",
            "lamp",
            "bicycle",
            "stapler",
            "scissors",
            "mailbox",
        ],
    ),
];

/// What nobody named anything else is made of.
const FALLBACK: &str = "plastic";

/// What a part is made of, each figure with its origin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Substance {
    /// The material in words.
    pub material: Sourced<String>,
    /// Density of the solid material, kg/m³.
    pub density: Sourced<f64>,
    /// Wall a hollow body of it has, metres.
    pub wall: Sourced<f64>,
    /// Coefficient of sliding friction.
    pub friction: Sourced<f64>,
    /// Mass of the whole part, kg, where somebody said.
    pub mass: Option<Sourced<f64>>,
}

/// The row whose word occurs in `text`, letters only compared in lower case.
pub fn named(text: &str) -> Option<&'static Material> {
    let text = text.to_lowercase();
    MATERIALS.iter().find(|m| m.words.iter().any(|w| text.contains(w)))
}

/// The row of parts called something like `text`.
pub fn usual(text: &str) -> Option<&'static Material> {
    let text = text.to_lowercase();
    let is_meant = |w: &&str| text.split(|c: char| !c.is_alphanumeric()).any(|t| is_word(t, w));
    let row = USUALLY.iter().find(|(_, words)| words.iter().any(is_meant))?;
    MATERIALS.iter().find(|m| m.name == row.0)
}

/// `drawer` and `drawers` alike.
fn is_word(token: &str, word: &str) -> bool {
    token.strip_prefix(word).is_some_and(|rest| matches!(rest, "" | "s" | "es"))
}

/// The row of an object of this category whose parts nobody called anything else.
pub(crate) fn otherwise(category: &str) -> &'static Material {
    let fallback = || MATERIALS.iter().find(|m| m.name == FALLBACK).unwrap_or(&MATERIALS[0]);
    usual(category).unwrap_or_else(fallback)
}

/// How thick that wall is in a body of this diagonal, metres both.
pub(crate) fn thickness([share, least, most]: Wall, diagonal: f64) -> f64 {
    (share * diagonal).clamp(least, most)
}

/// What a part of the object is made of. `prompt` is what the condition says, if anything; `text`
/// names the part, `diagonal` is the part's, metres.
pub fn substance(
    condition: &Condition,
    prompt: Option<&Prompt>,
    text: &str,
    diagonal: f64,
) -> Substance {
    let said = prompt.and_then(|p| p.material.as_deref());
    let by_name = || usual(text);
    let row = said.and_then(named).or_else(by_name);
    let row = row.unwrap_or_else(|| otherwise(&condition.category));
    let material = match said {
        Some(words) => Sourced::new(words.into(), condition.origin, "condition"),
        None => Sourced::new(row.name.into(), Origin::Default, format!("usual for `{text}`")),
    };
    let table = format!("table: {}", row.name);
    let stated = |value: Option<f64>, default: f64| match value {
        Some(v) => Sourced::new(v, condition.origin, "condition"),
        None => Sourced::new(default, Origin::Default, table.clone()),
    };
    let how = format!("table: {} walls, {} of the part's diagonal", row.name, row.wall[0]);
    Substance {
        material,
        density: stated(prompt.and_then(|p| p.density), row.density),
        wall: Sourced::new(thickness(row.wall, diagonal), Origin::Default, how),
        friction: stated(prompt.and_then(|p| p.friction), row.friction),
        mass: prompt.and_then(|p| p.mass).map(|m| Sourced::new(m, condition.origin, "condition")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn name(found: Option<&Material>) -> &str {
        found.map_or("-", |m| m.name)
    }

    #[test]
    fn descriptions_find_their_row() {
        let cases = [
            ("ABS plastic", "plastic"),
            ("polyurethane rubber", "rubber"),
            ("tyre rubber and steel wheel", "rubber"),
            ("chromed plastic", "plastic"),
            ("stainless steel", "steel"),
            ("oak veneer", "engineered wood"),
            ("unobtainium", "-"),
        ];
        for (words, expected) in cases {
            assert_eq!(name(named(words)), expected, "{words}");
        }
    }

    #[test]
    fn parts_without_a_material_get_the_usual_one() {
        assert_eq!(name(usual("left drawers")), "engineered wood");
        assert_eq!(name(usual("keyboard")), "-");
        assert_eq!(name(usual("front wheel")), "rubber");
    }

    #[test]
    fn what_the_condition_says_wins_and_keeps_its_origin() {
        let file = r#"{"schema": "kinfold-condition/1", "category": "oven", "parts": [
            {"name": "body", "density": 7900}, {"name": "door", "parent": "body"}]}"#;
        let c = Condition::from_json(file).unwrap();
        let body = substance(&c, Some(&c.prompts[0]), "body", 1.0);
        assert_eq!((body.density.value, body.density.origin), (7900.0, Origin::User));
        assert_eq!((body.wall.value, body.wall.origin), (1.2e-3, Origin::Default));
        assert_eq!(body.material.value, "steel");
        let door = substance(&c, None, "door", 1.0);
        assert_eq!((door.density.value, door.density.origin), (7850.0, Origin::Default));
    }
}
