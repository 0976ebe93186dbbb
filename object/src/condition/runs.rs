//! Faces by number, as runs: how painted faces are written.

use std::borrow::Cow;
use std::fmt;
use std::ops::Range;
use std::str::FromStr;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};

/// Faces of a mesh by number, ascending, without gaps inside a run: written `0-119 340 400-410`.
///
/// ```
/// use object::condition::Runs;
///
/// let runs: Runs = "0-2 5".parse()?;
/// assert_eq!(runs.iter().collect::<Vec<_>>(), [0, 1, 2, 5]);
/// assert_eq!([5, 1, 0, 2].into_iter().collect::<Runs>(), runs);
/// # Ok::<(), object::condition::RunsError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Runs(Vec<Range<u32>>);

/// Text that is no list of faces.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("faces are numbers and runs of them, ascending, such as `0-119 340 400-410`; found `{0}`")]
pub struct RunsError(String);

impl Runs {
    /// Whether no face is among them.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The runs, each from its first face to the one after its last.
    pub fn ranges(&self) -> &[Range<u32>] {
        &self.0
    }

    /// The faces, ascending.
    pub fn iter(&self) -> impl Iterator<Item = u32> + '_ {
        self.0.iter().cloned().flatten()
    }

    /// The largest number among them.
    pub fn last(&self) -> Option<u32> {
        self.0.last().map(|run| run.end - 1)
    }
}

impl FromIterator<u32> for Runs {
    fn from_iter<I: IntoIterator<Item = u32>>(faces: I) -> Self {
        let mut faces: Vec<u32> = faces.into_iter().filter(|f| *f < u32::MAX).collect();
        faces.sort_unstable();
        faces.dedup();
        let mut runs: Vec<Range<u32>> = Vec::new();
        for face in faces {
            match runs.last_mut() {
                Some(run) if run.end == face => run.end += 1,
                _ => runs.push(face..face + 1),
            }
        }
        Self(runs)
    }
}

impl FromStr for Runs {
    type Err = RunsError;

    fn from_str(text: &str) -> Result<Self, RunsError> {
        let number = |digits: &str| digits.parse::<u32>().ok().filter(|n| *n < u32::MAX);
        let mut runs: Vec<Range<u32>> = Vec::new();
        for word in text.split([' ', ',']).filter(|word| !word.is_empty()) {
            let (first, last) = word.split_once('-').unwrap_or((word, word));
            let run = match (number(first), number(last)) {
                (Some(first), Some(last)) if first <= last => first..last + 1,
                _ => return Err(RunsError(word.into())),
            };
            match runs.last_mut() {
                Some(before) if run.start < before.end => return Err(RunsError(word.into())),
                Some(before) if run.start == before.end => before.end = run.end,
                _ => runs.push(run),
            }
        }
        Ok(Self(runs))
    }
}

impl fmt::Display for Runs {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, run) in self.0.iter().enumerate() {
            let space = if i == 0 { "" } else { " " };
            match run.end - run.start {
                1 => write!(f, "{space}{}", run.start)?,
                _ => write!(f, "{space}{}-{}", run.start, run.end - 1)?,
            }
        }
        Ok(())
    }
}

impl TryFrom<String> for Runs {
    type Error = RunsError;
    fn try_from(text: String) -> Result<Self, RunsError> {
        text.parse()
    }
}

impl From<Runs> for String {
    fn from(runs: Runs) -> Self {
        runs.to_string()
    }
}

impl JsonSchema for Runs {
    fn schema_name() -> Cow<'static, str> {
        "Runs".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({"type": "string", "pattern": "^([0-9]+(-[0-9]+)?([ ,]+|$))*$"})
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_again() {
        let runs: Runs = "0-119, 120 340 400-410".parse().unwrap();
        assert_eq!(runs.to_string(), "0-120 340 400-410");
        assert_eq!(runs.to_string().parse::<Runs>(), Ok(runs.clone()));
        assert_eq!((runs.iter().count(), runs.last()), (133, Some(410)));
    }

    #[test]
    fn what_is_no_list_of_faces_is_refused_by_its_word() {
        for (text, word) in [
            ("1 x", "x"),
            ("5-3", "5-3"),
            ("4 2", "2"),
            ("0-4294967295", "0-4294967295"),
            ("-1", "-1"),
        ] {
            assert_eq!(text.parse::<Runs>(), Err(RunsError(word.into())), "{text}");
        }
    }
}
