//! Why a stage gave up: what it is a failure of, and whether another try may help.
//!
//! ```
//! use runner::{Again, Blame, StageError};
//!
//! let error = StageError::new("the service is busy").later(None).about("a mesh");
//! assert_eq!(error.line(), "a mesh: the service is busy");
//! assert_eq!((error.again, error.blame), (Again::Later(None), Blame::Work));
//! ```

use std::any::Any;
use std::time::Duration;

use guard::text::brief;

/// Most characters of an error's message that are kept: what it quotes may be of any length.
const LONGEST: usize = 4000;

/// Whether another attempt may help.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Again {
    /// The same inputs will fail the same way.
    Never,
    /// The cause may pass; wait at least so long where the other side said so.
    Later(Option<Duration>),
}

/// What a failure is a failure of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Blame {
    /// The stage's own work, on these inputs.
    #[default]
    Work,
    /// What may be spent is spent; the work was not begun.
    Budget,
    /// The house: its disk or its record. Any other work would fail the same way.
    House,
}

/// Why a stage gave up.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{message}")]
pub struct StageError {
    /// The rule and what was found.
    pub message: String,
    /// What lies behind it, outermost first.
    pub causes: Vec<String>,
    /// What a person can do about it.
    pub hint: Option<String>,
    /// Whether to try again.
    pub again: Again,
    /// What it is a failure of.
    pub blame: Blame,
}

impl StageError {
    /// An error that the same inputs will meet again.
    pub fn new(message: impl Into<String>) -> Self {
        let (causes, hint, again) = (Vec::new(), None, Again::Never);
        Self { message: message.into(), causes, hint, again, blame: Blame::Work }
    }

    /// The same for an error of another room, with its chain of causes; of what is longer than
    /// 4,000 characters the beginning, for it is kept and shown.
    pub fn from_error(error: &dyn std::error::Error) -> Self {
        let told = |error: &dyn std::error::Error| brief(&error.to_string(), LONGEST).into_owned();
        let mut causes: Vec<String> = Vec::new();
        let mut source = error.source();
        while let Some(cause) = source {
            causes.push(told(cause));
            source = cause.source();
        }
        let message = told(error);
        Self { causes: without_repeats(&message, causes), ..Self::new(message) }
    }

    /// An attempt that panicked.
    pub(super) fn of_panic(panic: &(dyn Any + Send)) -> Self {
        let text = panic.downcast_ref::<&str>().copied();
        let text = text.or_else(|| panic.downcast_ref::<String>().map(String::as_str));
        Self::new(format!("stopped on an internal error: {}", text.unwrap_or("no message")))
    }

    /// The same error with a word before it, such as the file it is about.
    #[must_use]
    pub fn about(mut self, subject: impl std::fmt::Display) -> Self {
        self.message = format!("{subject}: {}", self.message);
        self
    }

    /// The same error with advice.
    #[must_use]
    pub fn hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }

    /// The same error, worth another attempt.
    #[must_use]
    pub fn later(mut self, after: Option<Duration>) -> Self {
        self.again = Again::Later(after);
        self
    }

    /// The same error, of something other than the work.
    #[must_use]
    pub fn blamed_on(mut self, blame: Blame) -> Self {
        self.blame = blame;
        self
    }

    /// An error of the disk: the house's if it is full or may not be written, whoever meets it.
    pub fn from_io(error: &std::io::Error) -> Self {
        let blame = if is_of_the_house(error) { Blame::House } else { Blame::Work };
        Self::from_error(error).blamed_on(blame)
    }

    /// Message and causes in one line.
    pub fn line(&self) -> String {
        let mut parts = vec![self.message.clone()];
        parts.extend(self.causes.iter().cloned());
        parts.join(": ")
    }
}

/// Whether an error of the disk would meet any other file, too.
pub fn is_of_the_house(error: &std::io::Error) -> bool {
    use std::io::ErrorKind::{QuotaExceeded, ReadOnlyFilesystem, StorageFull};
    matches!(error.kind(), StorageFull | ReadOnlyFilesystem | QuotaExceeded)
}

/// Drops causes whose words stand in the message already, as `#[error("...: {source}")]` leads to.
fn without_repeats(message: &str, causes: Vec<String>) -> Vec<String> {
    let mut said = message.to_string();
    let mut kept = Vec::new();
    for cause in causes {
        if !said.contains(&cause) {
            said.push_str(&cause);
            kept.push(cause);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, thiserror::Error)]
    #[error("lid.glb: {source}")]
    struct Outer {
        source: std::io::Error,
    }

    #[test]
    fn of_an_error_that_quotes_a_long_text_the_beginning_is_kept() {
        let error = StageError::from_error(&std::io::Error::other("x".repeat(1_000_000)));
        assert!(error.message.ends_with("x…") && error.message.chars().count() == LONGEST + 1);
    }

    #[test]
    fn a_cause_that_the_message_tells_already_is_not_told_twice() {
        let source = std::io::Error::other("the disk is full");
        let error = StageError::from_error(&Outer { source });
        assert_eq!(error.line(), "lid.glb: the disk is full");
        assert_eq!(error.about("mesh").line(), "mesh: lid.glb: the disk is full");
    }
}
