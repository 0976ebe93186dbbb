//! From text to a condition: everything that is wrong is told at once, each with its line.

use std::collections::BTreeSet;

use jsonc_parser::ast::{Object, ObjectProp, Value};
use jsonc_parser::common::Ranged;

use super::fault::{ConditionError, Fault, meant, short};
use super::file::{
    ConditionFile, FileJoint, FileJoints, FilePart, FileSize, Quantity, SCHEMA, SCHEMA_1,
};
use super::foreign;
use super::lines::Lines;
use super::plain::parsed;
use super::runs::Runs;
use super::types::Condition;
use crate::kinematics::JointKind;
use crate::mesh::UpAxis;

/// The fields of a file, of a part and of a joint.
const TOP: [&str; 8] = ["$schema", "schema", "category", "up", "size", "mesh", "notes", "parts"];
const PART: [&str; 19] = [
    "name", "text", "parent", "joint", "joints", "point", "points", "not", "faces", "axis",
    "pivot", "range", "rest", "effort", "damping", "material", "density", "mass", "friction",
];
const JOINT: [&str; 7] = ["type", "axis", "pivot", "range", "rest", "effort", "damping"];
/// What came with the second schema.
const SECOND: [&str; 11] = [
    "mesh", "joints", "points", "not", "faces", "axis", "pivot", "range", "rest", "effort",
    "damping",
];
const EXTENTS: [&str; 4] = ["largest", "height", "width", "depth"];
const KINDS: [(&str, JointKind); 3] = [
    ("revolute", JointKind::Revolute),
    ("continuous", JointKind::Continuous),
    ("prismatic", JointKind::Prismatic),
];
/// Other words for how a part moves, each with ours.
const OTHER_WORDS: [(&str, &str); 18] = [
    ("hinge", "revolute"),
    ("hinged", "revolute"),
    ("rotate", "revolute"),
    ("rotation", "revolute"),
    ("rotary", "revolute"),
    ("rotational", "revolute"),
    ("swing", "revolute"),
    ("wheel", "continuous"),
    ("spin", "continuous"),
    ("endless", "continuous"),
    ("knob", "continuous"),
    ("slide", "prismatic"),
    ("slider", "prismatic"),
    ("sliding", "prismatic"),
    ("linear", "prismatic"),
    ("translation", "prismatic"),
    ("drawer", "prismatic"),
    ("button", "prismatic"),
];
/// Words for not moving, which is said by leaving `joint` out.
const STILL: [&str; 4] = ["fixed", "static", "rigid", "none"];

impl Condition {
    /// Reads a condition file of any of the three schemas. A byte-order mark, comments, commas after the
    /// last of a list, single quotes and names without quotes are read, too.
    ///
    /// # Errors
    /// [`ConditionError`]: everything that is wrong, with lines, what was found and what is allowed.
    pub fn from_json(text: &str) -> Result<Self, ConditionError> {
        condition(text, UpAxis::Y)
    }

    /// The same of a mesh whose up axis somebody else said, where the file does not say it.
    ///
    /// # Errors
    /// As [`Condition::from_json`].
    pub fn from_json_with(text: &str, up: UpAxis) -> Result<Self, ConditionError> {
        condition(text, up)
    }
}

/// Reads a condition of any schema; `up` is the up axis of one that does not say.
fn condition(text: &str, up: UpAxis) -> Result<Condition, ConditionError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut reading = Reading::of(text);
    let (value, _) = parsed(text)?;
    let schema = match &value {
        Value::Object(object) => object.get_string("schema").map(|s| s.value.to_string()),
        _ => None,
    };
    if schema.as_deref() == Some("condition/1") {
        let file: foreign::File = serde_json::from_str(text)
            .map_err(|e| ConditionError::one(format!("not a `condition/1`: {e}")))?;
        return file.translate().resolve();
    }
    let mut file = reading.file(&value);
    file.up.get_or_insert(up);
    file.resolved(reading.faults, &reading.lines)
}

/// A text that is read, and what was found wrong with it.
struct Reading {
    /// Where lines begin, in bytes.
    starts: Vec<usize>,
    /// Whether the file calls itself one of the first schema.
    is_first: bool,
    faults: Vec<Fault>,
    lines: Lines,
}

impl Reading {
    fn of(text: &str) -> Self {
        let after = text.match_indices('\n').map(|(at, _)| at + 1);
        let starts = std::iter::once(0).chain(after).collect();
        Self { starts, is_first: false, faults: Vec::new(), lines: Lines::default() }
    }

    fn line(&self, at: &impl Ranged) -> usize {
        self.starts.partition_point(|start| *start <= at.start())
    }

    fn fault(&mut self, at: &impl Ranged, message: impl Into<String>) {
        let line = self.line(at);
        self.faults.push(Fault::new(Some(line), message));
    }

    /// The properties of an object whose names are among `known`; the others and repeated ones are told.
    fn fields<'o, 't>(
        &mut self,
        object: &'o Object<'t>,
        whose: &str,
        known: &[&'static str],
    ) -> Vec<(&'static str, &'o ObjectProp<'t>)> {
        let mut seen = BTreeSet::new();
        let mut fields = Vec::new();
        for property in &object.properties {
            let name = property.name.as_str();
            let Some(field) = known.iter().copied().find(|known| *known == name) else {
                let near = meant(name, known.iter().copied());
                let all = known.join(", ");
                self.fault(
                    property,
                    format!("{whose}unknown field `{}`{near}; known are {all}", short(name)),
                );
                continue;
            };
            if !seen.insert(field) {
                self.fault(property, format!("{whose}`{name}` stands twice"));
                continue;
            }
            if self.is_first && SECOND.contains(&field) {
                let why =
                    format!("{whose}`{name}` is of `{SCHEMA}`, but `schema` says `{SCHEMA_1}`");
                self.fault(property, why);
                continue;
            }
            if !matches!(property.value, Value::NullKeyword(_)) {
                fields.push((field, property));
            }
        }
        fields
    }

    fn file(&mut self, value: &Value<'_>) -> ConditionFile {
        let mut file = ConditionFile { schema: SCHEMA.into(), ..ConditionFile::default() };
        let Value::Object(object) = value else {
            self.fault(
                value,
                format!("a condition is an object of {}; found {}", TOP.join(", "), told(value)),
            );
            return file;
        };
        self.is_first = object.get_string("schema").is_some_and(|s| s.value == SCHEMA_1);
        for (field, property) in self.fields(object, "", &TOP) {
            let value = &property.value;
            self.lines.put((None, field), self.line(property));
            match field {
                "schema" => file.schema = self.text(value, "`schema`").unwrap_or_default(),
                "category" => file.category = self.text(value, "`category`").unwrap_or_default(),
                "notes" => file.notes = self.text(value, "`notes`").unwrap_or_default(),
                "mesh" => file.mesh = self.text(value, "`mesh`"),
                "up" => file.up = self.up(value),
                "size" => file.size = self.size(value),
                "parts" => file.parts = self.parts(value),
                _ => {}
            }
        }
        if object.get("parts").is_none() {
            self.fault(
                object,
                "`parts` is missing: a list of the object's parts, the base first or not",
            );
        }
        file
    }

    fn up(&mut self, value: &Value<'_>) -> Option<UpAxis> {
        match self.text(value, "`up`")?.as_str() {
            "y" | "Y" => Some(UpAxis::Y),
            "z" | "Z" => Some(UpAxis::Z),
            other => {
                self.fault(value, format!("`up` is `y` or `z`, found `{}`", short(other)));
                None
            }
        }
    }

    fn size(&mut self, value: &Value<'_>) -> Option<FileSize> {
        let rule = "`size` is an object with one of largest, height, width, depth, in metres, such as \
                    {\"height\": 0.24}";
        let Value::Object(object) = value else {
            self.fault(value, format!("{rule}; found {}", told(value)));
            return None;
        };
        let fields = self.fields(object, "`size`: ", &EXTENTS);
        let [(field, property)] = fields[..] else {
            if object.properties.len() != 1 {
                let names: Vec<&str> = object.properties.iter().map(|p| p.name.as_str()).collect();
                self.fault(value, format!("{rule}; found {}: {}", names.len(), names.join(", ")));
            }
            return None;
        };
        let metres = self.quantity(&property.value, &format!("`size`: `{field}`"))?;
        let metres = match metres.value(false) {
            Ok(metres) => metres,
            Err(why) => {
                self.fault(&property.value, format!("`size`: `{field}`: {why}"));
                return None;
            }
        };
        Some(match field {
            "largest" => FileSize::Largest(metres),
            "height" => FileSize::Height(metres),
            "width" => FileSize::Width(metres),
            _ => FileSize::Depth(metres),
        })
    }

    fn parts(&mut self, value: &Value<'_>) -> Vec<FilePart> {
        let Value::Array(list) = value else {
            self.fault(value, format!("`parts` is a list, found {}", told(value)));
            return vec![];
        };
        list.elements.iter().enumerate().map(|(i, value)| self.part(i, value)).collect()
    }

    fn part(&mut self, index: usize, value: &Value<'_>) -> FilePart {
        let mut part = FilePart::default();
        self.lines.put((Some(index), ""), self.line(value));
        let Value::Object(object) = value else {
            self.fault(value, format!("part {index}: a part is an object, found {}", told(value)));
            return part;
        };
        let name = object.get_string("name").map(|name| name.value.to_string());
        let whose = match &name {
            Some(name) => format!("part `{}`: ", short(name)),
            None => format!("part {index}: "),
        };
        if object.get("name").is_none() {
            self.fault(object, format!("{whose}`name` is missing"));
        }
        for (field, property) in self.fields(object, &whose, &PART) {
            self.lines.put((Some(index), field), self.line(property));
            let (value, what) = (&property.value, format!("{whose}`{field}`"));
            match field {
                "name" => part.name = self.text(value, &what).unwrap_or_default(),
                "text" => part.text = self.text(value, &what),
                "parent" => part.parent = self.text(value, &what),
                "material" => part.material = self.text(value, &what),
                "joint" => part.joint = self.kinds(value, &what).unwrap_or_default(),
                "joints" => part.joints = self.joints(value, &whose),
                "point" => part.point = self.point(value, &what),
                "points" => part.points = self.points(value, &what),
                "not" => part.not = self.points(value, &what),
                "faces" => part.faces = self.faces(value, &what).unwrap_or_default(),
                "axis" => part.axis = self.point(value, &what),
                "pivot" => part.pivot = self.point(value, &what),
                "range" => part.range = self.range(value, &what),
                "rest" => part.rest = self.quantity(value, &what),
                "effort" => part.effort = self.number(value, &what),
                "damping" => part.damping = self.number(value, &what),
                "density" => part.density = self.number(value, &what),
                "mass" => part.mass = self.number(value, &what),
                _ => part.friction = self.number(value, &what),
            }
        }
        part
    }

    fn joints(&mut self, value: &Value<'_>, whose: &str) -> Vec<FileJoint> {
        let Value::Array(list) = value else {
            let rule = "`joints` is a list of objects such as {\"type\": \"revolute\", \"axis\": [1, 0, 0]}";
            self.fault(value, format!("{whose}{rule}; found {}", told(value)));
            return vec![];
        };
        list.elements.iter().filter_map(|value| self.joint(value, whose)).collect()
    }

    fn joint(&mut self, value: &Value<'_>, whose: &str) -> Option<FileJoint> {
        let Value::Object(object) = value else {
            self.fault(
                value,
                format!("{whose}`joints`: a joint is an object, found {}", told(value)),
            );
            return None;
        };
        let mut joint = FileJoint {
            kind: JointKind::Revolute,
            axis: None,
            pivot: None,
            range: None,
            rest: None,
            effort: None,
            damping: None,
        };
        let mut kind = None;
        for (field, property) in self.fields(object, &format!("{whose}`joints`: "), &JOINT) {
            let (value, what) = (&property.value, format!("{whose}`joints`: `{field}`"));
            match field {
                "type" => kind = Some(self.kind(value, &what)),
                "axis" => joint.axis = self.point(value, &what),
                "pivot" => joint.pivot = self.point(value, &what),
                "range" => joint.range = self.range(value, &what),
                "rest" => joint.rest = self.quantity(value, &what),
                "effort" => joint.effort = self.number(value, &what),
                _ => joint.damping = self.number(value, &what),
            }
        }
        if kind.is_none() {
            self.fault(
                value,
                format!("{whose}`joints`: `type` is missing: revolute, continuous or prismatic"),
            );
        }
        joint.kind = kind??;
        Some(joint)
    }

    fn kinds(&mut self, value: &Value<'_>, what: &str) -> Option<FileJoints> {
        match value {
            Value::StringLit(_) => self.kind(value, what).map(FileJoints::One),
            Value::Array(list) => {
                let kinds: Vec<_> = list.elements.iter().map(|v| self.kind(v, what)).collect();
                kinds.into_iter().collect::<Option<Vec<_>>>().map(FileJoints::from_kinds)
            }
            _ => {
                let rule = "is revolute, continuous or prismatic, or a list of two of them";
                self.fault(value, format!("{what} {rule}; found {}", told(value)));
                None
            }
        }
    }

    fn kind(&mut self, value: &Value<'_>, what: &str) -> Option<JointKind> {
        let word = self.text(value, what)?;
        if let Some((_, kind)) = KINDS.iter().find(|(known, _)| *known == word) {
            return Some(*kind);
        }
        let lower = word.to_lowercase();
        let advice = match OTHER_WORDS.iter().find(|(other, _)| *other == lower) {
            _ if STILL.contains(&lower.as_str()) => {
                ": leave it out where a part does not move".into()
            }
            Some((_, ours)) => format!(": did you mean `{ours}`?"),
            None => meant(&word, KINDS.iter().map(|(known, _)| *known)),
        };
        let known = "there are revolute, continuous, prismatic";
        self.fault(value, format!("{what}: `{}` is no joint; {known}{advice}", short(&word)));
        None
    }

    fn text(&mut self, value: &Value<'_>, what: &str) -> Option<String> {
        match value {
            Value::StringLit(text) => Some(text.value.to_string()),
            _ => {
                self.fault(value, format!("{what} is a text in quotes, found {}", told(value)));
                None
            }
        }
    }

    fn number(&mut self, value: &Value<'_>, what: &str) -> Option<f64> {
        if let Value::NumberLit(number) = value
            && let Some(number) = number.value.parse::<f64>().ok().filter(|n| n.is_finite())
        {
            return Some(number);
        }
        let rule = match value {
            Value::NumberLit(_) => "is a finite number",
            _ => "is a number",
        };
        self.fault(value, format!("{what} {rule}, found {}", told(value)));
        None
    }

    fn point(&mut self, value: &Value<'_>, what: &str) -> Option<[f64; 3]> {
        let Value::Array(list) = value else {
            self.fault(value, format!("{what} is a list of three numbers, found {}", told(value)));
            return None;
        };
        if list.elements.len() != 3 {
            let found = list.elements.len();
            self.fault(value, format!("{what} is a list of three numbers, found {found}"));
            return None;
        }
        let mut point = [0.0; 3];
        for (place, value) in point.iter_mut().zip(&list.elements) {
            *place = self.number(value, what)?;
        }
        Some(point)
    }

    fn points(&mut self, value: &Value<'_>, what: &str) -> Vec<[f64; 3]> {
        let Value::Array(list) = value else {
            self.fault(value, format!("{what} is a list of points, found {}", told(value)));
            return vec![];
        };
        // One point where a list of them is asked for means itself.
        if list.elements.first().is_some_and(|first| matches!(first, Value::NumberLit(_))) {
            return self.point(value, what).into_iter().collect();
        }
        list.elements.iter().filter_map(|value| self.point(value, what)).collect()
    }

    fn faces(&mut self, value: &Value<'_>, what: &str) -> Option<Runs> {
        let text = self.text(value, what)?;
        match text.parse() {
            Ok(runs) => Some(runs),
            Err(why) => {
                self.fault(value, format!("{what}: {why}"));
                None
            }
        }
    }

    fn quantity(&mut self, value: &Value<'_>, what: &str) -> Option<Quantity> {
        match value {
            Value::StringLit(text) => Some(Quantity::Text(text.value.to_string())),
            Value::NumberLit(_) => self.number(value, what).map(Quantity::Number),
            _ => {
                let rule = "is a number, or a text with its unit such as \"80°\" or \"12 cm\"";
                self.fault(value, format!("{what} {rule}; found {}", told(value)));
                None
            }
        }
    }

    fn range(&mut self, value: &Value<'_>, what: &str) -> Option<[Quantity; 2]> {
        if let Value::Array(list) = value
            && let [lower, upper] = &list.elements[..]
        {
            return Some([self.quantity(lower, what)?, self.quantity(upper, what)?]);
        }
        let rule = "is a list of its lower and its upper end, such as [0, \"80°\"]";
        self.fault(value, format!("{what} {rule}; found {}", told(value)));
        None
    }
}

/// What a value is, in words.
fn told(value: &Value<'_>) -> String {
    match value {
        Value::StringLit(text) => format!("the text \"{}\"", short(&text.value)),
        Value::NumberLit(number) => format!("the number {}", short(number.value)),
        Value::BooleanLit(truth) => format!("`{}`", truth.value),
        Value::Object(_) => "an object".into(),
        Value::Array(list) => format!("a list of {}", list.elements.len()),
        Value::NullKeyword(_) => "`null`".into(),
    }
}
