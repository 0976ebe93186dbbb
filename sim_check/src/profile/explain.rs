//! What a rule is for, how it is measured and what mends it, for people who were told that it fails.
//!
//! ```
//! use sim_check::profile::explain::explain;
//! let convex = explain("G2").unwrap();
//! assert!(convex.why.contains("convex") && convex.how.contains("64"));
//! assert_eq!(convex.remedy(&["link `a`: a.stl is not convex: 4 mm below its hull".into()]), convex.mend[0].1);
//! ```

mod in_motion;
mod right;
mod still;
mod text;

use crate::profile;
use crate::profile::Rule;

/// What is to be known of one rule.
#[derive(Clone, Debug)]
pub struct Explanation {
    /// The rule.
    pub rule: &'static Rule,
    /// What goes wrong where it does not hold.
    pub why: &'static str,
    /// How it is measured, with the bounds of the profile.
    pub how: String,
    /// What mends it, the usual remedy last; each with a word of the findings it is for, empty for
    /// any.
    pub mend: &'static [(&'static str, &'static str)],
}

impl Explanation {
    /// What mends these findings, in a line.
    pub fn remedy(&self, findings: &[String]) -> &'static str {
        let fits = |word: &str| findings.iter().any(|finding| finding.contains(word));
        let fitting = self.mend.iter().find(|(word, _)| word.is_empty() || fits(word));
        fitting.or(self.mend.last()).map_or("", |(_, remedy)| remedy)
    }
}

/// What is to be known of the rule of that id; none for an id that the profile does not have.
pub fn explain(id: &str) -> Option<Explanation> {
    let text = still::TEXTS
        .iter()
        .chain(&in_motion::TEXTS)
        .chain(&right::TEXTS)
        .find(|text| text.id == id)?;
    Some(Explanation { rule: profile::rule(id), why: text.why, how: (text.how)(), mend: text.mend })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::RULES;

    #[test]
    fn every_rule_has_a_text_and_every_text_a_rule() {
        for rule in RULES {
            let told = explain(rule.id).unwrap_or_else(|| panic!("{} has no text", rule.id));
            assert_eq!(told.rule.id, rule.id);
            assert!(!told.why.is_empty() && !told.how.is_empty(), "{}", rule.id);
            let (word, remedy) = told.mend.last().unwrap();
            assert!(word.is_empty() && !remedy.is_empty(), "{}: a remedy for anything", rule.id);
        }
        let texts = still::TEXTS.len() + in_motion::TEXTS.len() + right::TEXTS.len();
        assert_eq!(texts, RULES.len());
        assert!(explain("Z9").is_none());
    }

    #[test]
    fn sentences_are_short() {
        for rule in RULES {
            let told = explain(rule.id).unwrap();
            let remedies = told.mend.iter().map(|(_, remedy)| *remedy);
            for text in [told.why, told.how.as_str()].into_iter().chain(remedies) {
                for sentence in text.split(". ") {
                    let words = sentence.split_whitespace().filter(|w| w.len() > 1).count();
                    assert!(words <= 30, "{}: {words} words: {sentence}", rule.id);
                }
            }
        }
    }

    #[test]
    fn a_remedy_is_for_what_was_found() {
        let j4 = explain("J4").unwrap();
        assert!(j4.remedy(&["joint `a`: has no effort".into()]).contains("<limit"));
        assert!(j4.remedy(&["joint `a`: damping -1 is negative".into()]).contains("0 or more"));
        assert_eq!(j4.remedy(&[]), j4.mend.last().unwrap().1);
    }
}
