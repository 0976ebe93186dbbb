//! The one question whose answer would help most, as `make --ask` prints it.

use model::Articulation;
use object::Condition;
use runner::Outcome;
use serde_json::{Value, json};
use studio::question::{Asked, Choice, Edit, asked};

/// The question about what a run made; none where nothing is in doubt, or nobody says how sure he is.
pub(super) fn of_outcome(outcome: &Outcome) -> Option<Asked> {
    let made: Articulation = outcome.artefact("articulate").ok()?;
    let condition: Condition = outcome.artefact("propose-condition").ok()?;
    asked(&made, &condition)
}

/// The question and its answers, line by line: each with what it adds to the condition.
pub(super) fn lines(asked: &Asked) -> Vec<String> {
    let answer = |choice: &Choice| {
        let own = format!("  {}: add {} in the condition", choice.words, adds(&choice.change));
        let also = choice
            .also
            .iter()
            .map(|edit| format!("    and {}, if it holds for that as well", adds(edit)));
        std::iter::once(own).chain(also).collect::<Vec<_>>()
    };
    let first = format!("question: {}", asked.words);
    std::iter::once(first).chain(asked.answers.iter().flat_map(answer)).collect()
}

/// What an answer adds to a part, and where.
fn adds(edit: &Edit) -> String {
    let Edit { part, index, .. } = edit;
    let of = match index {
        Some(index) if *index > 0 => format!("joint {} of `{part}`", index + 1),
        _ => format!("`{part}`"),
    };
    format!("{} to {of}", fields(edit))
}

/// What an answer adds, as fields of a condition file.
fn fields(edit: &Edit) -> Value {
    match (&edit.set, edit.point) {
        (Some(set), _) => json!(set),
        (None, Some(point)) => json!({ "points": [point] }),
        (None, None) => json!({}),
    }
}

#[cfg(test)]
mod tests {
    use studio::question::Set;

    use super::*;

    #[test]
    fn every_answer_is_a_line_with_what_it_adds_to_the_condition() {
        let edit = |part: &str, index, point, set| Edit { part: part.into(), index, point, set };
        let choice = |words: &str, change, also| Choice { words: words.into(), change, also };
        let set = Set { axis: [0.0, 1.0, 0.0], pivot: [0.0; 3], range: Some([0.0, 1.5]) };
        let asked = Asked {
            words: "Which way does `lid` open?".into(),
            part: "lid".into(),
            siblings: vec!["cap".into()],
            at: None,
            gain: 0.5,
            answers: vec![
                choice("Along its axis", edit("lid", Some(1), None, Some(set)), vec![]),
                choice(
                    "body",
                    edit("lid", None, Some([1.0, 2.0, 3.0]), None),
                    vec![edit("cap", None, Some([0.5; 3]), None)],
                ),
            ],
        };
        let told = lines(&asked);
        assert_eq!(told[0], "question: Which way does `lid` open?");
        assert_eq!(
            told[1],
            "  Along its axis: add {\"axis\":[0.0,1.0,0.0],\"pivot\":[0.0,0.0,0.0],\"range\":[0.0,1.5]} \
             to joint 2 of `lid` in the condition"
        );
        assert_eq!(told[2], "  body: add {\"points\":[[1.0,2.0,3.0]]} to `lid` in the condition");
        assert_eq!(
            told[3],
            "    and {\"points\":[[0.5,0.5,0.5]]} to `cap`, if it holds for that as well"
        );
    }
}
