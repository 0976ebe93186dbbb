//! How the program speaks: results, complaints and exit codes.

use std::error::Error;
use std::fmt;

use guard::text::{brief, shown};
use runner::StageError;

/// Most characters of a message, a cause or a hint: what they quote may be of any length.
const LONGEST: usize = 4000;

/// How the program ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// Everything asked for is there.
    Done = 0,
    /// It could not be done.
    Failed = 1,
    /// The command was not understood.
    Misused = 2,
    /// Done, but something asked for is missing.
    Losses = 3,
    /// Stopped by Ctrl-C; the same command goes on.
    Interrupted = 130,
}

/// What a command has to say at its end.
#[derive(Clone, Debug)]
pub struct Answer {
    /// For stdout: the result and nothing else.
    pub result: String,
    /// For stderr: what a person should know besides, a line each.
    pub remarks: Vec<String>,
    /// How the program ends.
    pub exit: Exit,
}

impl Answer {
    /// A result without remarks.
    pub fn done(result: impl Into<String>) -> Self {
        Self { result: result.into(), remarks: Vec::new(), exit: Exit::Done }
    }
}

/// Why a command has no result: what is wrong, why, and what to do about it.
#[derive(Clone, Debug)]
pub struct Complaint {
    /// The rule and what was found; lower case, no full stop.
    pub message: String,
    /// What lies behind it, outermost first.
    pub causes: Vec<String>,
    /// What a person can do about it.
    pub hints: Vec<String>,
    /// How the program ends.
    pub exit: Exit,
    /// What goes to stdout nevertheless, for machines.
    pub result: String,
}

impl Complaint {
    /// Something that cannot be done.
    pub fn failed(message: impl Into<String>) -> Self {
        let (causes, hints) = (Vec::new(), Vec::new());
        Self { message: message.into(), causes, hints, exit: Exit::Failed, result: String::new() }
    }

    /// A command that makes no sense.
    pub fn misused(message: impl Into<String>) -> Self {
        Self { exit: Exit::Misused, ..Self::failed(message) }
    }

    /// The same with advice.
    #[must_use]
    pub fn hint(mut self, hint: impl Into<String>) -> Self {
        self.hints.push(hint.into());
        self
    }

    /// An error of any room, with its chain of causes.
    pub fn from_error(error: &dyn Error) -> Self {
        Self::from_stage(StageError::from_error(error))
    }

    /// A stage's error.
    pub fn from_stage(error: StageError) -> Self {
        let hints = error.hint.into_iter().collect();
        Self { causes: error.causes, hints, ..Self::failed(error.message) }
    }

    /// The lines it is told in.
    pub fn lines(&self) -> Vec<String> {
        self.to_string().lines().map(String::from).collect()
    }

    /// Message and causes in one line.
    pub fn line(&self) -> String {
        let all = std::iter::once(&self.message).chain(&self.causes);
        all.map(|said| brief(said, LONGEST)).collect::<Vec<_>>().join(": ")
    }
}

impl fmt::Display for Complaint {
    /// A line for the message, for each cause and for each hint, whatever they quote.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let told = |said: &str| shown(&brief(said, LONGEST)).into_owned();
        write!(f, "error: {}", told(&self.message))?;
        self.causes.iter().try_for_each(|cause| write!(f, "\n  caused by: {}", told(cause)))?;
        self.hints.iter().try_for_each(|hint| write!(f, "\nhint: {}", told(hint)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_complaint_quotes_forges_no_line() {
        let mut complaint = Complaint::failed("a\nerror: b").hint("c\u{1b}[2J\u{202e}");
        complaint.causes.push("d\r\nhint: e".into());
        let expected = [
            "error: a\\u{a}error: b",
            "  caused by: d\\u{d}\\u{a}hint: e",
            "hint: c\\u{1b}[2J\\u{202e}",
        ];
        assert_eq!(complaint.lines(), expected);
    }

    #[test]
    fn what_a_complaint_quotes_fills_no_screen() {
        let mut complaint = Complaint::failed("m".repeat(100_000)).hint("h".repeat(100_000));
        complaint.causes.push("c".repeat(100_000));
        let lines = complaint.lines();
        assert!(lines.len() == 3 && lines.iter().all(|l| l.ends_with('…') && l.len() < 4100));
        assert!(complaint.line().len() < 8100);
    }

    #[test]
    fn a_complaint_says_what_why_and_what_to_do() {
        let mut complaint = Complaint::failed("mesh.glb: no triangles").hint("export it again");
        complaint.causes.push("the file is empty".into());
        let text = complaint.to_string();
        assert_eq!(
            text,
            "error: mesh.glb: no triangles\n  caused by: the file is empty\nhint: export it again"
        );
        assert_eq!(complaint.line(), "mesh.glb: no triangles: the file is empty");
    }
}
