//! What could be done about what a check found: changes of the condition, each for a button.

use object::{Condition, ConditionFile, DVec3, JointKind};
use serde_json::{Map, Value, json};
use studio::Remedy;

/// A range that ends here, as a share of where two parts were found to overlap, ends before that: a guess.
const BEFORE: f64 = 0.95;
/// The lighter of two links gets this much more than the least that the rule allows: a guess.
const SPARE: f64 = 1.05;
/// Checks whose findings depend on how far joints go.
const OF_RANGES: [&str; 4] = ["C2", "C3", "C4", "S3"];

/// A joint of what was built and of what was asked for.
struct Place {
    /// The part of the condition that it moves.
    part: usize,
    /// Which of the part's joints.
    index: usize,
}

/// What could be done about what was found: `scene` is the page's of what was built of `condition`, which
/// was read from `file`.
pub(super) fn of(scene: &Value, condition: &Condition, file: &ConditionFile) -> Vec<Remedy> {
    let mut remedies = Vec::new();
    let mut add = |remedy: Remedy| {
        let same = |r: &Remedy| {
            (r.part.as_ref(), r.index, &r.set, &r.check)
                == (remedy.part.as_ref(), remedy.index, &remedy.set, &remedy.check)
        };
        if !remedies.iter().any(same) {
            remedies.push(remedy);
        }
    };
    for check in scene["checks"].as_array().into_iter().flatten() {
        if check["status"] == "pass" {
            continue;
        }
        let id = check["id"].as_str().unwrap_or_default();
        for (evidence, found) in check["evidence"].as_array().into_iter().flatten().enumerate() {
            let finding = Finding { scene, condition, file, id, evidence, found };
            finding.shorter().into_iter().for_each(&mut add);
            finding.other_way().into_iter().for_each(&mut add);
            finding.heavier().into_iter().for_each(&mut add);
            finding.taken_back().into_iter().for_each(&mut add);
        }
    }
    remedies
}

/// One thing that was found.
struct Finding<'a> {
    scene: &'a Value,
    condition: &'a Condition,
    file: &'a ConditionFile,
    id: &'a str,
    evidence: usize,
    found: &'a Value,
}

impl Finding<'_> {
    /// Ends ranges before parts overlap.
    fn shorter(&self) -> Vec<Remedy> {
        if !OF_RANGES.contains(&self.id) {
            return vec![];
        }
        let one = |(joint, value): (usize, f64)| {
            let place = self.place(joint)?;
            let kinds = &self.condition.tree.parts()[place.part].joints;
            if kinds.get(place.index) == Some(&JointKind::Continuous) {
                return None;
            }
            let range = &self.scene["joints"][joint]["range"];
            let (lower, upper) = (range[0].as_f64()?, range[1].as_f64()?);
            let end = round(BEFORE * value);
            let range = if value > 0.0 { [lower, end] } else { [end, upper] };
            let is_shorter = range[1] - range[0] > 1e-3 && range[1] - range[0] < upper - lower;
            // A person counts from where it is shut, and the pose that is shown lies at `rest`.
            let rest = self.rest(&place);
            let which = if value > 0.0 { "end" } else { "start" };
            let at = self.amount(&place, end + rest);
            let words = format!("{which} {} at {at}", self.joint_name(&place));
            let range = range.map(|end| round(end + rest));
            is_shorter.then(|| self.remedy(&place, words, json!({ "range": range })))
        };
        self.pose().into_iter().filter(|(_, v)| v.abs() > 1e-6).filter_map(one).collect()
    }

    /// Turns an axis round that opens into something.
    fn other_way(&self) -> Option<Remedy> {
        let (joint, _) = *self.pose().first().filter(|_| self.id == "C5")?;
        let place = self.place(joint)?;
        // Links have the object's orientation, so an axis is the same in both.
        let axis = self.scene["joints"][joint]["axis"].as_array()?;
        let axis: Vec<f64> = axis.iter().filter_map(Value::as_f64).collect();
        let [x, y, z] = axis[..] else { return None };
        let axis = self.condition.frame.point_to_file(-DVec3::new(x, y, z)).to_array();
        let axis = axis.map(|v| if v == 0.0 { 0.0 } else { v });
        let words = format!("open {} the other way", self.joint_name(&place));
        Some(self.remedy(&place, words, json!({ "axis": axis, "range": null, "rest": null })))
    }

    /// Gives the lighter of two links enough mass.
    fn heavier(&self) -> Option<Remedy> {
        if self.id != "M6" {
            return None;
        }
        let text = self.found["text"].as_str()?;
        let (above, _) = text.split_once(" kg above")?;
        let above: f64 = above.rsplit(' ').next()?.parse().ok()?;
        let joint = text.split('`').nth(1)?;
        let joint = self.joints().position(|j| j["name"] == joint)?;
        let place = self.place(joint)?;
        let part = &self.condition.tree.parts()[place.part].name;
        let mass = round(SPARE * above / sim_check::profile::bounds::RATIO);
        let set = json!({ "mass": mass });
        Some(Remedy { index: None, ..self.remedy(&place, format!("give `{part}` {mass} kg"), set) })
    }

    /// Takes back what a person gave of the joints and the masses that it is about.
    fn taken_back(&self) -> Vec<Remedy> {
        let mut remedies = Vec::new();
        for (joint, _) in self.pose() {
            let Some(place) = self.place(joint) else { continue };
            let given = self.condition.prompts[place.part].given(place.index);
            if given.range.is_some() || given.open_by.is_some() {
                let words = format!("take back the range given of {}", self.joint_name(&place));
                remedies.push(self.remedy(&place, words, json!({ "range": null, "rest": null })));
            }
        }
        if self.id.starts_with('M') {
            for link in self.found["links"].as_array().into_iter().flatten() {
                let name =
                    link.as_u64().and_then(|l| self.scene["links"][l as usize]["name"].as_str());
                let Some(part) = name.and_then(|name| self.part(name)) else { continue };
                if self.condition.prompts[part].mass.is_some() {
                    let place = Place { part, index: 0 };
                    let name = &self.condition.tree.parts()[part].name;
                    let words = format!("take back the mass given of `{name}`");
                    let remedy = self.remedy(&place, words, json!({ "mass": null }));
                    remedies.push(Remedy { index: None, ..remedy });
                }
            }
        }
        remedies
    }

    /// Where the file says that a joint is shown in its range, radians or metres.
    fn rest(&self, place: &Place) -> f64 {
        let part = &self.file.parts[place.part];
        let said = match part.joints.get(place.index) {
            Some(joint) => joint.rest.as_ref(),
            None => part.rest.as_ref(),
        };
        let kinds = &self.condition.tree.parts()[place.part].joints;
        let turns = kinds.get(place.index).is_some_and(|kind| kind.turns());
        said.and_then(|rest| rest.value(turns).ok()).unwrap_or(0.0)
    }

    fn remedy(&self, place: &Place, label: String, set: Value) -> Remedy {
        let part = &self.condition.tree.parts()[place.part];
        Remedy {
            check: self.id.to_owned(),
            evidence: self.evidence,
            label,
            part: Some(part.name.clone()),
            index: (part.joints.len() > 1).then_some(place.index),
            set: match set {
                Value::Object(set) => set,
                _ => Map::new(),
            },
        }
    }

    fn joints(&self) -> impl Iterator<Item = &Value> {
        self.scene["joints"].as_array().into_iter().flatten()
    }

    /// Joints and their values in the pose in which it was found.
    fn pose(&self) -> Vec<(usize, f64)> {
        let one = |p: &Value| Some((p[0].as_u64()? as usize, p[1].as_f64()?));
        self.found["pose"].as_array().into_iter().flatten().filter_map(one).collect()
    }

    fn part(&self, name: &str) -> Option<usize> {
        self.condition.tree.parts().iter().position(|p| p.name == name)
    }

    /// The part that a joint moves: its child, or where that stands between two joints, the child's child.
    fn place(&self, joint: usize) -> Option<Place> {
        let child = self.scene["joints"][joint]["child"].as_u64()?;
        let name = |link: u64| self.scene["links"][link as usize]["name"].as_str();
        if let Some(part) = self.part(name(child)?) {
            let last = self.condition.tree.parts()[part].joints.len().checked_sub(1)?;
            return Some(Place { part, index: last });
        }
        let next = self.joints().find(|j| j["parent"].as_u64() == Some(child))?;
        let part = self.part(name(next["child"].as_u64()?)?)?;
        Some(Place { part, index: 0 })
    }

    fn joint_name(&self, place: &Place) -> String {
        let part = &self.condition.tree.parts()[place.part];
        match part.joints.len() {
            0 | 1 => format!("`{}`", part.name),
            _ => format!("joint {} of `{}`", place.index + 1, part.name),
        }
    }

    fn amount(&self, place: &Place, value: f64) -> String {
        let kinds = &self.condition.tree.parts()[place.part].joints;
        match kinds.get(place.index) {
            Some(kind) if !kind.turns() => format!("{:.0} mm", value * 1000.0),
            _ => format!("{:.0}°", value.to_degrees()),
        }
    }
}

/// Four digits that count.
fn round(value: f64) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return value;
    }
    let digits = 10f64.powf(3.0 - value.abs().log10().floor());
    (value * digits).round() / digits
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on stops")]
mod tests {
    use super::*;

    fn found(scene: &Value, condition: &Condition) -> Vec<Remedy> {
        of(scene, condition, &ConditionFile::from(condition))
    }

    fn condition(door: &str) -> Condition {
        let text = format!(
            r#"{{ "schema": "kinfold-condition/2", "parts": [
                {{ "name": "body" }},
                {{ "name": "door", "parent": "body", "joint": "revolute" {door} }},
                {{ "name": "knob", "parent": "body", "joint": ["prismatic", "revolute"] }} ] }}"#
        );
        Condition::from_json(&text).unwrap()
    }

    fn scene(check: &str, text: &str, pose: Value) -> Value {
        let link = |name: &str| json!({ "name": name });
        let joint = |name: &str, parent: usize, child: usize| json!({ "name": name, "parent": parent, "child": child, "axis": [0, 0, 1], "range": [0.0, 1.5] });
        json!({
            "links": [link("body"), link("door"), link("knob_between"), link("knob")],
            "joints": [joint("door_turn", 0, 1), joint("knob_slide", 0, 2), joint("knob_turn", 2, 3)],
            "checks": [
                { "id": "F1", "status": "pass", "evidence": [] },
                { "id": check, "status": "fail", "evidence": [{ "text": text, "pose": pose, "links": [1] }] },
            ],
        })
    }

    #[test]
    fn an_overlap_on_the_way_is_answered_by_an_earlier_end() {
        let scene = scene("C2", "overlap", json!([[0, 1.2]]));
        let remedies = found(&scene, &condition(""));
        assert_eq!(remedies.len(), 1);
        assert_eq!(remedies[0].label, "end `door` at 65°");
        assert_eq!(json!(remedies[0].set), json!({ "range": [0.0, 1.14] }));
        assert_eq!((remedies[0].part.as_deref(), remedies[0].index), (Some("door"), None));
    }

    #[test]
    fn an_end_is_told_as_the_file_counts() {
        let text = r#"{ "schema": "kinfold-condition/2", "parts": [ { "name": "body" },
            { "name": "door", "parent": "body", "joint": "revolute", "range": [0, 1.5], "rest": 1.5 } ] }"#;
        let file: ConditionFile = serde_json::from_str(text).unwrap();
        let mut scene = scene("C2", "overlap", json!([[0, -1.4]]));
        scene["joints"][0]["range"] = json!([-1.5, 0.0]);
        let remedies = of(&scene, &file.resolve().unwrap(), &file);
        assert_eq!(remedies[0].label, "start `door` at 10°");
        assert_eq!(remedies[0].set["range"], json!([0.17, 1.5]));
        assert!(!remedies[0].set.contains_key("rest"), "it is shown where it was");
    }

    #[test]
    fn a_joint_between_two_is_the_first_of_its_part() {
        let scene = scene("C3", "overlap", json!([[1, 1.0], [2, 0.5]]));
        let remedies = found(&scene, &condition(""));
        let of_joint: Vec<_> = remedies.iter().map(|r| (r.part.as_deref(), r.index)).collect();
        assert_eq!(of_joint, [(Some("knob"), Some(0)), (Some("knob"), Some(1))]);
        assert_eq!(remedies[0].label, "end joint 1 of `knob` at 950 mm");
    }

    #[test]
    fn what_opens_into_something_opens_the_other_way() {
        let scene = scene("C5", "collides", json!([[0, 0.3]]));
        let remedies = found(&scene, &condition(""));
        // The file has y up: the object's -z is the file's -y.
        assert_eq!(remedies[0].set["axis"], json!([0.0, -1.0, 0.0]));
    }

    #[test]
    fn what_a_person_gave_can_be_taken_back() {
        let overlap = scene("C2", "overlap", json!([[0, 1.2]]));
        let remedies = found(&overlap, &condition(", \"range\": [0, 1.5]"));
        assert_eq!(remedies[1].label, "take back the range given of `door`");
        let text = "line 9: joint `door_turn`: 3015 kg above, 1.584 kg below";
        let remedies = found(&scene("M6", text, json!([])), &condition(", \"mass\": 1.584"));
        assert_eq!(remedies[0].label, "give `door` 3.166 kg");
        assert_eq!(remedies[1].set["mass"], Value::Null);
    }
}
