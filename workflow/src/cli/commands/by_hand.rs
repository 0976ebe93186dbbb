//! What a person gave of each part, read from the condition that a trace holds.

use object::Condition;
use object::condition::{GivenJoint, Prompt};
use runner::Artefact;
use serde_json::{Value, json};
use trace::Reading;

/// A part and what was given of it by hand, each in a few words.
pub(super) struct ByHand {
    pub part: String,
    pub given: Vec<String>,
}

/// The parts of which more was given than a point and a material; none where the trace has no condition
/// that can be read.
pub(super) fn by_hand(reading: &Reading) -> Vec<ByHand> {
    let is_condition =
        |kept: &&trace::reader::Kept| kept.name == <Condition as Artefact<crate::Tools>>::FILE_NAME;
    let kept = reading.attachments.iter().find(is_condition);
    let decoded = kept.map(|kept| <Condition as Artefact<crate::Tools>>::decode(&kept.bytes));
    let Some(Ok(condition)) = decoded else { return Vec::new() };
    let parts = condition.tree.parts().iter().zip(&condition.prompts);
    let one = |(part, prompt): (&object::Part, &Prompt)| {
        let given = of_part(prompt);
        (!given.is_empty()).then(|| ByHand { part: part.name.clone(), given })
    };
    parts.filter_map(one).collect()
}

/// For machines.
pub(super) fn as_json(all: &[ByHand]) -> Value {
    all.iter().map(|by| json!({ "part": by.part, "given": by.given })).collect()
}

fn of_part(prompt: &Prompt) -> Vec<String> {
    let several = prompt.joints.len() > 1;
    let joints = prompt.joints.iter().enumerate().flat_map(|(index, given)| {
        let place = if several { format!("joint {}: ", index + 1) } else { String::new() };
        of_joint(given).into_iter().map(move |what| format!("{place}{what}"))
    });
    let counted = |count: usize, one: &str, more: &str| match count {
        0 => None,
        1 => Some(format!("1 {one}")),
        count => Some(format!("{count} {more}")),
    };
    let points = [
        counted(prompt.also.len(), "further point", "further points"),
        counted(prompt.not.len(), "point that is not on it", "points that are not on it"),
        counted(prompt.faces.iter().count(), "painted face", "painted faces"),
    ];
    joints.chain(points.into_iter().flatten()).collect()
}

fn of_joint(given: &GivenJoint) -> Vec<&'static str> {
    let all = [
        ("axis", given.axis.is_some()),
        ("pivot", given.pivot.is_some()),
        ("range", given.range.is_some()),
        ("where it is shut", given.open_by.is_some()),
        ("effort", given.effort.is_some()),
        ("damping", given.damping.is_some()),
    ];
    all.into_iter().filter(|(_, is)| *is).map(|(what, _)| what).collect()
}
