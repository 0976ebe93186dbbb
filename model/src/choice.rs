//! Who articulates: the one place that turns a choice into an articulator.

use std::fmt;
use std::str::FromStr;

use crate::articulate::Articulate;
use crate::classic::{Geometric, Hybrid};

/// The articulators that need nothing but what ships.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Choice {
    /// Geometry, with labels by the trees that ship: what every command uses unless told otherwise.
    #[default]
    Default,
    /// Geometry alone.
    Geometric,
}

/// A word that chooses no articulator.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected an articulator, default or geometric, found `{0}`")]
pub struct ChoiceError(String);

/// The articulator that is chosen.
///
/// ```
/// use model::{Choice, articulator};
///
/// let choice: Choice = "geometric".parse()?;
/// assert_ne!(articulator(choice).identity(), articulator(Choice::default()).identity());
/// # Ok::<(), model::choice::ChoiceError>(())
/// ```
pub fn articulator(choice: Choice) -> Box<dyn Articulate + Send + Sync> {
    match choice {
        Choice::Default => Box::new(Hybrid),
        Choice::Geometric => Box::new(Geometric),
    }
}

impl fmt::Display for Choice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Default => "default",
            Self::Geometric => "geometric",
        })
    }
}

impl FromStr for Choice {
    type Err = ChoiceError;

    fn from_str(text: &str) -> Result<Self, ChoiceError> {
        let all = [Self::Default, Self::Geometric];
        all.into_iter().find(|c| c.to_string() == text).ok_or_else(|| ChoiceError(text.into()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_choice_is_read_as_it_is_written_and_has_an_articulator_of_its_own() {
        for choice in [Choice::Default, Choice::Geometric] {
            assert_eq!(choice.to_string().parse(), Ok(choice));
        }
        let error = "network".parse::<Choice>().unwrap_err();
        assert_eq!(
            error.to_string(),
            "expected an articulator, default or geometric, found `network`"
        );
        assert_eq!(articulator(Choice::Default).identity(), Hybrid.identity());
        assert_eq!(articulator(Choice::Geometric).identity(), Geometric.identity());
    }
}
