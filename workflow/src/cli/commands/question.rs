//! The one question whose answer would help most, as `make --ask` prints it.

use model::Articulation;
use object::Condition;
use runner::Outcome;
use serde_json::{Value, json};
use studio::question::{Asked, Choice, asked};

/// The question about what a run made; none where nothing is in doubt, or nobody says how sure he is.
pub(super) fn of_outcome(outcome: &Outcome) -> Option<Asked> {
    let made: Articulation = outcome.artefact("articulate").ok()?;
    let condition: Condition = outcome.artefact("propose-condition").ok()?;
    asked(&made, &condition)
}

/// The question and its answers, line by line: each with what it adds to the condition.
pub(super) fn lines(asked: &Asked) -> Vec<String> {
    let answer = |choice: &Choice| {
        let Choice { words, part, index, .. } = choice;
        let of = match index {
            Some(index) if *index > 0 => format!("joint {} of `{part}`", index + 1),
            _ => format!("`{part}`"),
        };
        format!("  {words}: add {} to {of} in the condition", fields(choice))
    };
    let first = format!("question: {}", asked.words);
    std::iter::once(first).chain(asked.answers.iter().map(answer)).collect()
}

/// What an answer adds, as fields of a condition file.
fn fields(choice: &Choice) -> Value {
    match (&choice.set, choice.point) {
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
        let choice = |words: &str, index, point, set| Choice {
            words: words.into(),
            part: "lid".into(),
            index,
            point,
            set,
        };
        let set = Set { axis: [0.0, 1.0, 0.0], pivot: [0.0; 3], range: Some([0.0, 1.5]) };
        let asked = Asked {
            words: "Which way does `lid` open?".into(),
            part: "lid".into(),
            at: None,
            gain: 0.5,
            answers: vec![
                choice("Along its axis", Some(1), None, Some(set)),
                choice("body", None, Some([1.0, 2.0, 3.0]), None),
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
    }
}
