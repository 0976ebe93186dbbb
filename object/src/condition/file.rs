//! A condition as it stands in a file a person can write, `kinfold-condition/2`.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::runs::Runs;
use super::types::{Condition, Extent};
use crate::kinematics::JointKind;
use crate::mesh::UpAxis;

/// The schema name a condition file of ours carries.
pub const SCHEMA: &str = "kinfold-condition/2";
/// The schema before it: the same without corrections.
pub const SCHEMA_1: &str = "kinfold-condition/1";

/// A condition as it stands in a file (`kinfold-condition/2`; files of `kinfold-condition/1` have the
/// same fields but those of corrections).
///
/// ```
/// let file: object::ConditionFile = serde_json::from_str(r#"{
///   "schema": "kinfold-condition/2",
///   "category": "kettle",
///   "size": { "height": 0.24 },
///   "parts": [
///     { "name": "body", "material": "steel" },
///     { "name": "lid", "text": "round lid", "parent": "body", "joint": "revolute",
///       "point": [-0.10, 0.47, 0.0], "axis": [1, 0, 0], "range": [0, "80°"] }
///   ]
/// }"#).unwrap();
/// let condition = file.resolve().unwrap();
/// assert_eq!(condition.tree.parent(1), Some(0));
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "kinfold condition", description = "Parts, joints and prompts of one object")]
pub struct ConditionFile {
    /// Address of this JSON Schema, for editors; not read.
    #[serde(rename = "$schema", default, skip_serializing_if = "Option::is_none")]
    pub json_schema: Option<String>,
    /// `kinfold-condition/2`.
    pub schema: String,
    /// What the object is, in a word or two.
    #[serde(default)]
    pub category: String,
    /// Up axis of the mesh file, and so of the points below: `y` unless said otherwise, or `z`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub up: Option<UpAxis>,
    /// True size in metres, one of `largest`, `height`, `width`, `depth`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<BTreeMap<Extent, f64>>")]
    pub size: Option<FileSize>,
    /// Digest of the mesh that the painted `faces` of parts count in.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mesh: Option<String>,
    /// Free text, kept but not used.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub notes: String,
    /// The parts; the one without a parent is the base.
    pub parts: Vec<FilePart>,
}

/// A true size as written in a file: `{ "height": 0.24 }`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FileSize {
    /// The longest side, metres.
    Largest(f64),
    /// Along the up axis, metres.
    Height(f64),
    /// Along x, metres.
    Width(f64),
    /// Front to back, metres.
    Depth(f64),
}

/// One part of a condition file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FilePart {
    /// Identifier, unique, `[A-Za-z_][A-Za-z0-9_]*`: the URDF link's name.
    pub name: String,
    /// What the part is, in words; the name with spaces if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub text: Option<String>,
    /// Name of the part it hangs on; none for the base.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parent: Option<String>,
    /// How it moves: one kind, a list of two, or nothing (fixed).
    #[serde(default, skip_serializing_if = "FileJoints::is_fixed")]
    pub joint: FileJoints,
    /// The same with what is known of each, the first nearest the parent; in place of `joint`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub joints: Vec<FileJoint>,
    /// A point on its surface, in the mesh file's own coordinates and unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub point: Option<[f64; 3]>,
    /// Further points on its surface.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub points: Vec<[f64; 3]>,
    /// Points on the surface that are not of this part.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub not: Vec<[f64; 3]>,
    /// Faces of the mesh that are of this part whatever else is found, by number from 0: `120-339 350`.
    #[serde(default, skip_serializing_if = "Runs::is_empty")]
    pub faces: Runs,
    /// Direction of its joint's axis, in the mesh file's coordinates; any length but none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axis: Option<[f64; 3]>,
    /// A point on its joint's axis, in the mesh file's coordinates and unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pivot: Option<[f64; 3]>,
    /// Both ends of its joint's range: radians, or metres of the finished object.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<[Quantity; 2]>,
    /// Where in the range the mesh shows it; how far it is open where no range is given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rest: Option<Quantity>,
    /// Largest torque or force of its joint's drive, N·m or N.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub effort: Option<f64>,
    /// Viscous damping of its joint, N·m·s/rad or N·s/m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub damping: Option<f64>,
    /// Material in words, like `oak` or `stainless steel`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// Density of the solid material, kg/m³, 1 to 25,000.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub density: Option<f64>,
    /// Mass, kg; wins over density.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass: Option<f64>,
    /// Coefficient of surface friction, 0 to 2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<f64>,
}

/// One joint of a part and what is known of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FileJoint {
    /// How it moves.
    #[serde(rename = "type")]
    pub kind: JointKind,
    /// Direction of its axis, in the mesh file's coordinates; any length but none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axis: Option<[f64; 3]>,
    /// A point on its axis, in the mesh file's coordinates and unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pivot: Option<[f64; 3]>,
    /// Both ends of its range: radians, or metres of the finished object.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<[Quantity; 2]>,
    /// Where in the range the mesh shows it; how far it is open where no range is given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rest: Option<Quantity>,
    /// Largest torque or force of its drive, N·m or N.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub effort: Option<f64>,
    /// Viscous damping, N·m·s/rad or N·s/m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub damping: Option<f64>,
}

/// Joints of a part as written: `"revolute"`, `["prismatic", "continuous"]`, or left out.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum FileJoints {
    /// One degree of freedom.
    One(JointKind),
    /// None or two, the first nearest the parent.
    #[serde(skip)]
    #[default]
    Fixed,
    /// A list; empty means fixed.
    Many(Vec<JointKind>),
}

/// An angle or a length as written: a number of radians or metres, or a text with its unit (`"80°"`,
/// `"1.2 rad"`, `"12 cm"`, `"5 mm"`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Quantity {
    /// Radians or metres.
    Number(f64),
    /// A number and its unit.
    Text(String),
}

/// Units of angles, each with radians.
const ANGLES: [(&str, f64); 6] = [
    ("rad", 1.0),
    ("°", std::f64::consts::PI / 180.0),
    ("deg", std::f64::consts::PI / 180.0),
    ("degree", std::f64::consts::PI / 180.0),
    ("degrees", std::f64::consts::PI / 180.0),
    ("turn", std::f64::consts::TAU),
];
/// Units of lengths, each with metres.
const LENGTHS: [(&str, f64); 4] = [("m", 1.0), ("cm", 0.01), ("mm", 0.001), ("in", 0.0254)];

impl Condition {
    /// The JSON Schema of a condition file, for editors.
    pub fn json_schema() -> serde_json::Value {
        schemars::schema_for!(ConditionFile).to_value()
    }
}

impl Quantity {
    /// Radians where the joint `turns`, metres where it slides.
    ///
    /// # Errors
    /// What is wrong with it, in a sentence's part.
    pub fn value(&self, turns: bool) -> Result<f64, String> {
        let (what, units): (_, &[(&str, f64)]) =
            if turns { ("an angle", &ANGLES) } else { ("a length", &LENGTHS) };
        let wrong = |found: &str| {
            let known: Vec<&str> = units.iter().map(|(unit, _)| *unit).collect();
            let bare = if turns { "radians" } else { "metres" };
            Err(format!(
                "{what} is a number of {bare}, or a text of a number and one of {}; found {found}",
                known.join(", ")
            ))
        };
        let value = match self {
            Self::Number(value) => *value,
            Self::Text(text) => {
                let text = text.trim();
                let ends = |c: char| !(c.is_ascii_digit() || "+-.eE".contains(c));
                // The `e` of `1e-2` is of the number, that of `deg` never comes first.
                let at = text.find(ends).unwrap_or(text.len());
                let (number, unit) = text.split_at(at);
                let unit = unit.trim();
                let factor = match units.iter().find(|(known, _)| *known == unit) {
                    Some((_, factor)) => *factor,
                    None => return wrong(&format!("`{text}`")),
                };
                match number.trim().parse::<f64>() {
                    Ok(number) => number * factor,
                    Err(_) => return wrong(&format!("`{text}`")),
                }
            }
        };
        if value.is_finite() { Ok(value) } else { wrong(&value.to_string()) }
    }
}

impl FileJoints {
    /// The shortest way to write some joints.
    pub fn from_kinds(kinds: Vec<JointKind>) -> Self {
        match kinds[..] {
            [] => Self::Fixed,
            [one] => Self::One(one),
            _ => Self::Many(kinds),
        }
    }

    fn is_fixed(&self) -> bool {
        self.kinds().is_empty()
    }

    /// The kinds, the first nearest the parent.
    pub fn kinds(&self) -> Vec<JointKind> {
        match self {
            Self::Fixed => vec![],
            Self::One(kind) => vec![*kind],
            Self::Many(kinds) => kinds.clone(),
        }
    }
}

impl FilePart {
    /// The kinds of its joints, the first nearest the parent.
    pub fn kinds(&self) -> Vec<JointKind> {
        match self.joints.is_empty() {
            true => self.joint.kinds(),
            false => self.joints.iter().map(|j| j.kind).collect(),
        }
    }

    /// Whether something is said of its one joint beside its kind.
    pub(super) fn corrects_its_joint(&self) -> bool {
        self.axis.is_some()
            || self.pivot.is_some()
            || self.range.is_some()
            || self.rest.is_some()
            || self.effort.is_some()
            || self.damping.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_and_lengths_are_read_with_their_units() {
        let text = |t: &str| Quantity::Text(t.into());
        let angle = |t: &str| text(t).value(true).unwrap();
        assert_eq!(angle("180°"), std::f64::consts::PI);
        assert_eq!((angle("1.5 rad"), angle("-0.25turn")), (1.5, -std::f64::consts::FRAC_PI_2));
        assert_eq!(angle("90 deg"), angle("90 degrees"));
        let length = |t: &str| text(t).value(false).unwrap();
        assert_eq!((length("12 cm"), length("5mm"), length("1e-2 m")), (0.12, 0.005, 0.01));
        assert_eq!(Quantity::Number(0.7).value(true), Ok(0.7));
    }

    #[test]
    fn a_unit_of_the_wrong_kind_is_named_with_those_there_are() {
        let told = Quantity::Text("12 cm".into()).value(true).unwrap_err();
        assert!(
            told.contains("radians") && told.contains("deg") && told.contains("`12 cm`"),
            "{told}"
        );
        for wrong in ["", "cm", "1,5 cm", "80 %", "1e400 m", "nan m"] {
            assert!(Quantity::Text(wrong.into()).value(false).is_err(), "{wrong}");
        }
        assert!(Quantity::Number(f64::NAN).value(true).is_err());
    }
}
