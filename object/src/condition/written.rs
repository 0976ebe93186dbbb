//! From a condition in memory back to a file that a person can write.

use super::file::{ConditionFile, FileJoint, FileJoints, FilePart, FileSize, Quantity, SCHEMA};
use super::types::{Condition, Extent, GivenJoint, TrueSize};
use crate::articulated::Range;
use crate::kinematics::Part;
use crate::mesh::{FileFrame, UpAxis};
use glamx::DVec3;

impl From<&Condition> for ConditionFile {
    /// The file that this condition could have been read from, in its own frame.
    fn from(condition: &Condition) -> Self {
        let frame = condition.frame;
        Self {
            json_schema: None,
            schema: SCHEMA.into(),
            category: condition.category.clone(),
            up: (frame.up != UpAxis::default()).then_some(frame.up),
            size: condition.size.map(size),
            mesh: condition.painted_on.clone(),
            notes: String::new(),
            parts: (0..condition.tree.len()).map(|part| written(condition, part)).collect(),
        }
    }
}

fn size(size: TrueSize) -> FileSize {
    match size.of {
        Extent::Largest => FileSize::Largest(size.metres),
        Extent::Height => FileSize::Height(size.metres),
        Extent::Width => FileSize::Width(size.metres),
        Extent::Depth => FileSize::Depth(size.metres),
    }
}

fn written(condition: &Condition, part: usize) -> FilePart {
    let parts = condition.tree.parts();
    let Part { name, text, parent, joints } = &parts[part];
    let prompt = &condition.prompts[part];
    let point = |p: &DVec3| condition.frame.point_to_file(*p).to_array();
    let mut file = FilePart {
        name: name.clone(),
        text: (*text != name.replace('_', " ")).then(|| text.clone()),
        parent: parent.map(|p| parts[p].name.clone()),
        joint: FileJoints::from_kinds(joints.clone()),
        point: prompt.point.as_ref().map(point),
        points: prompt.also.iter().map(point).collect(),
        not: prompt.not.iter().map(point).collect(),
        faces: prompt.faces.clone(),
        material: prompt.material.clone(),
        density: prompt.density,
        mass: prompt.mass,
        friction: prompt.friction,
        ..FilePart::default()
    };
    let said =
        (0..joints.len()).map(|index| joint(joints[index], prompt.given(index), condition.frame));
    let said: Vec<FileJoint> = said.collect();
    match &said[..] {
        _ if prompt.joints.is_empty() => {}
        [one] => {
            (file.axis, file.pivot) = (one.axis, one.pivot);
            (file.range, file.rest) = (one.range.clone(), one.rest.clone());
            (file.effort, file.damping) = (one.effort, one.damping);
        }
        _ => (file.joint, file.joints) = (FileJoints::Fixed, said),
    }
    file
}

fn joint(kind: crate::JointKind, given: GivenJoint, frame: FileFrame) -> FileJoint {
    let point = |p: DVec3| frame.point_to_file(p).to_array();
    let range = given.range.and_then(|range| match range {
        Range::Limits { lower, upper } => Some([lower, upper].map(Quantity::Number)),
        Range::Continuous => None,
    });
    FileJoint {
        kind,
        axis: given.axis.map(point),
        pivot: given.pivot.map(point),
        range,
        rest: given.open_by.map(Quantity::Number),
        effort: given.effort,
        damping: given.damping,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_reads_as_the_same_condition() {
        let text = r#"{
            "schema": "kinfold-condition/2", "category": "oven", "up": "z", "size": { "width": 0.6 },
            "mesh": "0123",
            "parts": [
                { "name": "body", "material": "steel", "mass": 30 },
                { "name": "door", "text": "glass door", "parent": "body", "joint": "revolute",
                  "point": [0.1, 0.2, 0.3], "points": [[0, 0, 1]], "not": [[1, 0, 0]], "faces": "0-4 9",
                  "axis": [1, 0, 0], "pivot": [0, 0, 0.1], "range": [-0.5, "90°"], "effort": 3 },
                { "name": "rack", "parent": "body", "joint": "prismatic", "rest": "12 cm" },
                { "name": "knob", "parent": "door",
                  "joints": [{ "type": "prismatic" }, { "type": "continuous", "axis": [0, 2, 0], "damping": 0.1 }] }
            ] }"#;
        let condition = Condition::from_json(text).unwrap();
        let file = ConditionFile::from(&condition);
        let again = serde_json::to_string_pretty(&file).unwrap();
        assert_eq!(Condition::from_json(&again).unwrap(), condition, "{again}");
        assert_eq!(ConditionFile::from(&Condition::from_json(&again).unwrap()), file);
    }
}
