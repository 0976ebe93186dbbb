//! What is wrong with a condition: everything at once, each with its place.

use std::error::Error;
use std::fmt;

/// So many faults are told of one file; the others are counted.
const MOST: usize = 20;

/// Why a condition cannot be used: what is wrong with it, in the order of the file, twenty things at most.
///
/// Told as one sentence where one thing is wrong; otherwise by how many there are, with each as a cause.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ConditionError {
    first: Box<Fault>,
    count: usize,
}

/// One thing that is wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// The line of the file, from 1; `None` where no file was read.
    pub line: Option<usize>,
    /// The rule and what was found, with the part where it is one's.
    pub message: String,
    next: Option<Box<Fault>>,
}

impl Fault {
    pub(super) fn new(line: Option<usize>, message: impl Into<String>) -> Self {
        Self { line, message: message.into(), next: None }
    }
}

impl ConditionError {
    /// One thing that is wrong, in no line.
    pub(super) fn one(message: impl Into<String>) -> Self {
        Self::single(Fault::new(None, message))
    }

    /// One fault.
    pub(super) fn single(fault: Fault) -> Self {
        Self { first: Box::new(fault), count: 1 }
    }

    /// Something that is wrong beyond what the file says by itself.
    pub fn told(message: impl Into<String>) -> Self {
        Self::one(message)
    }

    /// All faults as an error; nothing where there is none.
    pub(super) fn of(mut faults: Vec<Fault>) -> Result<(), Self> {
        faults.sort_by_key(|fault| fault.line.unwrap_or(usize::MAX));
        let count = faults.len();
        if count > MOST {
            faults.truncate(MOST);
            faults.push(Fault::new(None, format!("and {} more", count - MOST)));
        }
        let chained =
            |next: Option<Box<Fault>>, fault: Fault| Some(Box::new(Fault { next, ..fault }));
        faults
            .into_iter()
            .rev()
            .fold(None, chained)
            .map_or(Ok(()), |first| Err(Self { first, count }))
    }

    /// Everything that is wrong, in the order of the file.
    pub fn faults(&self) -> impl Iterator<Item = &Fault> {
        std::iter::successors(Some(&*self.first), |fault| fault.next.as_deref())
    }
}

impl fmt::Display for ConditionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.count {
            1 => self.first.fmt(f),
            count => write!(f, "{count} things are wrong in it"),
        }
    }
}

impl Error for ConditionError {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        (self.count > 1).then_some(&*self.first)
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(line) = self.line {
            write!(f, "line {line}: ")?;
        }
        f.write_str(&self.message)
    }
}

impl Error for Fault {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        self.next.as_deref().map(|next| next as &(dyn Error + 'static))
    }
}

/// A word of a file as a message has it: its beginning, where it is long.
pub(super) fn short(word: &str) -> String {
    match word.char_indices().nth(40) {
        Some((at, _)) => format!("{}…", &word[..at]),
        None => word.to_owned(),
    }
}

/// Of some words the one that was likely meant, as a question after a comma; nothing where none is near.
pub(super) fn meant<'w>(found: &str, words: impl IntoIterator<Item = &'w str>) -> String {
    /// No word of ours, and hardly a name of anybody's, is longer.
    const LONG: usize = 64;
    if found.len() > LONG {
        return String::new();
    }
    let lower = found.to_lowercase();
    let near = |word: &'w str| {
        let most = 1 + word.chars().count() / 4;
        let off = strsim::osa_distance(&lower, &word.to_lowercase());
        (off <= most).then_some((off, word))
    };
    match words.into_iter().filter_map(near).min_by_key(|(off, _)| *off) {
        Some((_, word)) => format!(": did you mean `{word}`?"),
        None => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_fault_is_a_sentence_and_several_are_counted_and_told_one_by_one() {
        let fault = |line, message: &str| Fault::new(Some(line), message);
        let one = ConditionError::of(vec![fault(4, "no joint")]).unwrap_err();
        assert_eq!((one.to_string(), one.source().is_none()), ("line 4: no joint".into(), true));
        let both = ConditionError::of(vec![fault(7, "b"), fault(4, "a")]).unwrap_err();
        assert_eq!(both.to_string(), "2 things are wrong in it");
        let first = both.source().unwrap();
        let second = first.source().unwrap();
        assert_eq!(
            (first.to_string(), second.to_string()),
            ("line 4: a".into(), "line 7: b".into())
        );
        assert!(second.source().is_none() && both.faults().count() == 2);
        assert!(ConditionError::of(vec![]).is_ok());
    }

    #[test]
    fn of_very_many_faults_the_first_are_told_and_the_others_counted() {
        let many = (1..=100_000).map(|line| Fault::new(Some(line), "wrong")).collect();
        let error = ConditionError::of(many).unwrap_err();
        assert_eq!(error.to_string(), "100000 things are wrong in it");
        let told: Vec<String> = error.faults().map(ToString::to_string).collect();
        assert_eq!((told.len(), &*told[19], &*told[20]), (21, "line 20: wrong", "and 99980 more"));
    }

    #[test]
    fn the_nearest_word_is_offered_and_a_far_one_is_not() {
        let kinds = ["revolute", "continuous", "prismatic"];
        assert_eq!(meant("Revolut", kinds), ": did you mean `revolute`?");
        assert_eq!(meant("ball", kinds), "");
    }
}
