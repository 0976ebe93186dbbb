//! The changes one after the other, each kept only if the checks approve of it.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Instant;

use serde::{Deserialize, Serialize};
use sim_check::profile::explain::explain;
use sim_check::read::load::{self, Edition};
use sim_check::read::source::Source;
use sim_check::{Severity, Status, Verdict, check_edition};

pub use super::offer::{Job, NewFile, Split};

use super::judge::{Outcome, compare};
use super::offer::{Change, Offer, State};
use super::remedies::{REMEDIES, Way, is_mendable};
use super::{collisions, joints, pivots, weights, winding};

/// How often all ways are gone through: what one mends may let another be judged. Measured: no model
/// of ours or of forty others asked for a third time.
const ROUNDS: usize = 3;
/// How often one way is asked again in a row: a check tells twenty findings at a time.
const AGAIN: usize = 8;

/// What was changed, and why.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Mended {
    /// The rules that asked for it.
    pub rules: Vec<String>,
    /// What it is about, such as "joint `hinge`".
    pub subject: String,
    /// Its line in the file as it was at that moment.
    pub line: u32,
    /// What was changed, in words.
    pub change: String,
}

/// What a check still finds, and why nothing is done about it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Left {
    /// The rule.
    pub rule: String,
    /// What was found.
    pub finding: String,
    /// Why it stays, or what a person can do.
    pub why: String,
    /// Whether it lowers the tier.
    pub counts: bool,
}

/// A model before and after.
#[derive(Clone, Debug)]
pub struct Fixed {
    /// The verdict on the file as it is.
    pub before: Verdict,
    /// The verdict on the text that would stand there.
    pub after: Verdict,
    /// The file as it is.
    pub old: String,
    /// The text that would stand there.
    pub new: String,
    /// Files that it needs.
    pub files: Vec<NewFile>,
    /// What was changed.
    pub mended: Vec<Mended>,
    /// What stays.
    pub left: Vec<Left>,
    /// Whether time ran out before every way was tried.
    pub ran_out: bool,
    /// Whether it could be read as one model.
    pub is_model: bool,
}

/// A file that cannot be mended at all.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoFix {
    /// It cannot be read, or is no model.
    #[error("{0}")]
    Unreadable(String),
    /// It is of a format that is read and not mended.
    #[error("{0} is checked, and not mended: only URDF and MJCF are")]
    Format(&'static str),
}

/// Mends a model in memory; nothing is written. `until`: no further change is tried after that moment.
///
/// # Errors
/// [`NoFix`] where the file is no XML that is read here, or of a format that is not mended.
pub fn fix(job: &Job, until: Instant) -> Result<Fixed, NoFix> {
    let bytes = load::read_bytes(job.file, job.options.outside).map_err(NoFix::Unreadable)?;
    if load::is_usd(job.file, &bytes) {
        return Err(NoFix::Format("USD"));
    }
    let old = String::from_utf8(bytes);
    let old = old.map_err(|e| NoFix::Unreadable(format!("the file is not UTF-8: {e}")))?;
    let edition = Edition { text: old.clone(), ..Edition::default() };
    let (before, robot) = check_edition(job.file, &edition, job.options);
    let source = Source::of(&old);
    if source.as_ref().is_some_and(|source| source.tag(source.root()) == "sdf") {
        return Err(NoFix::Format("SDFormat"));
    }
    let (Some(robot), Some(source)) = (robot, source) else {
        let left = left(job, &before, &[]);
        let (new, after) = (old.clone(), before.clone());
        let (files, mended) = (vec![], vec![]);
        let (ran_out, is_model) = (false, false);
        return Ok(Fixed { before, after, old, new, files, mended, left, ran_out, is_model });
    };
    let state = State { edition, source, robot, verdict: before.clone(), files: vec![] };
    let mut run = Run {
        job,
        until,
        state,
        mended: vec![],
        tried: BTreeSet::new(),
        refused: vec![],
        ran_out: false,
    };
    for _ in 0..ROUNDS {
        let known = run.mended.len();
        REMEDIES.iter().for_each(|remedy| run.go(remedy.way));
        if run.mended.len() == known || run.ran_out {
            break;
        }
    }
    let Run { state, mended, refused, ran_out, .. } = run;
    let named = |file: &NewFile| state.edition.text.contains(last_part(&file.name));
    let files = state.files.iter().filter(|f| named(f)).cloned().collect();
    let left = left(job, &state.verdict, &refused);
    let (new, after) = (state.edition.text, state.verdict);
    Ok(Fixed { before, after, old, new, files, mended, left, ran_out, is_model: true })
}

fn last_part(name: &str) -> &str {
    name.rsplit('/').next().unwrap_or(name)
}

/// Why a way did nothing about a subject.
struct Refused {
    way: Way,
    subject: String,
    why: String,
}

struct Run<'a> {
    job: &'a Job<'a>,
    until: Instant,
    state: State,
    mended: Vec<Mended>,
    /// Ways and subjects that were tried and gave nothing.
    tried: BTreeSet<(Way, String)>,
    refused: Vec<Refused>,
    ran_out: bool,
}

/// A change of one offer.
#[derive(Clone)]
struct Pick<'o> {
    offer: &'o Offer,
    change: &'o Change,
}

impl Run<'_> {
    /// One way, as long as it mends something.
    fn go(&mut self, way: Way) {
        for _ in 0..AGAIN {
            let known = self.mended.len();
            if self.is_late() {
                return;
            }
            let findings = self.job.wanted.findings(&self.state.verdict, way);
            if findings.is_empty() {
                return;
            }
            let offers = self.offers(way, &findings);
            let mut open = Vec::new();
            for offer in &offers {
                let key = (way, offer.subject.clone());
                match &offer.changes {
                    _ if self.tried.contains(&key) => {}
                    Ok(changes) if !changes.is_empty() => open.push(offer),
                    Ok(_) => {}
                    Err(why) => {
                        self.tried.insert(key);
                        self.refuse(offer, why.clone());
                    }
                }
            }
            self.several(&open);
            if self.mended.len() == known {
                return;
            }
        }
    }

    fn offers(&self, way: Way, findings: &[(&str, &str)]) -> Vec<Offer> {
        let state = &self.state;
        let made = || match way {
            Way::Unit | Way::Swap | Way::Degrees | Way::Flip | Way::Clamp => {
                joints::offers(state, way, findings)
            }
            Way::Centre | Way::Inertia | Way::Weight => weights::offers(state, way, findings),
            Way::Turn => winding::offers((state, self.job), findings),
            Way::Touch | Way::Split | Way::Cover => {
                collisions::offers((state, self.job), way, findings)
            }
            Way::Pivot => pivots::offers(state, findings),
        };
        // What a geometry library breaks down on is not mended.
        std::panic::catch_unwind(std::panic::AssertUnwindSafe(made)).unwrap_or_default()
    }

    fn is_late(&mut self) -> bool {
        self.ran_out |= Instant::now() >= self.until;
        self.ran_out
    }

    /// All offers at once, by their best changes; where that is not approved of, halves of them, and
    /// in the end each alone with all its changes.
    fn several(&mut self, offers: &[&Offer]) {
        if offers.is_empty() || self.is_late() {
            return;
        }
        let picks: Vec<Pick> = offers
            .iter()
            .filter_map(|&offer| {
                let change = offer.changes.as_ref().ok()?.first()?;
                Some(Pick { offer, change })
            })
            .collect();
        let tried = self.try_on(&picks);
        match (tried, offers) {
            (Ok(()), _) => {}
            (Err(outcome), [one]) => self.alternatives(one, &outcome),
            (Err(_), _) => {
                let way = offers[0].way;
                let (first, second) = offers.split_at(offers.len() / 2);
                self.several(first);
                // The text has moved: the second half is told anew.
                self.again(way, second);
            }
        }
    }

    /// The same offers, made of the text as it is now.
    fn again(&mut self, way: Way, offers: &[&Offer]) {
        let subjects: Vec<&String> = offers.iter().map(|o| &o.subject).collect();
        let findings = self.job.wanted.findings(&self.state.verdict, way);
        let fresh = self.offers(way, &findings);
        let same = fresh.iter().filter(|o| subjects.contains(&&o.subject) && o.changes.is_ok());
        let same: Vec<&Offer> = same.collect();
        self.several(&same);
    }

    fn alternatives(&mut self, offer: &Offer, first: &Outcome) {
        // The best change is the one to speak of.
        let why = told(first);
        for change in offer.changes.iter().flatten().skip(1) {
            if self.is_late() {
                return;
            }
            if self.try_on(&[Pick { offer, change }]).is_ok() {
                return;
            }
        }
        self.tried.insert((offer.way, offer.subject.clone()));
        self.refuse(offer, why);
    }

    fn refuse(&mut self, offer: &Offer, why: String) {
        let (way, subject) = (offer.way, offer.subject.clone());
        self.refused.retain(|r| (r.way, &r.subject) != (way, &subject));
        self.refused.push(Refused { way, subject, why });
    }

    /// Keeps these changes if the checks approve of them.
    fn try_on(&mut self, picks: &[Pick]) -> Result<(), Outcome> {
        let failed = |why: &str| Err(Outcome { worse: vec![why.to_owned()], is_better: false });
        let edits: Vec<_> = picks.iter().flat_map(|p| p.change.edits.iter().cloned()).collect();
        let files: Vec<_> = picks.iter().flat_map(|p| p.change.files.iter().cloned()).collect();
        if edits.iter().any(|edit| self.state.source.takes_macro(edit)) {
            return failed("a macro or a substitution tells what would be changed: mend it there");
        }
        let names: BTreeSet<&str> = files.iter().map(|f| f.name.as_str()).collect();
        if names.len() < files.len() {
            return failed("two of its files have one name");
        }
        let Some(text) = self.state.source.with(&edits) else {
            return failed("it touches another change");
        };
        let mut edition = Edition { text, ..self.state.edition.clone() };
        for file in &files {
            edition.added.insert(file.name.clone(), Arc::from(file.bytes.as_slice()));
        }
        let (verdict, robot) = check_edition(self.job.file, &edition, self.job.options);
        let way = picks.first().map(|p| p.offer.way);
        let adds = matches!(way, Some(Way::Touch | Way::Cover));
        let outcome = compare(&self.state.verdict, &verdict, adds);
        let source = Source::of(&edition.text);
        let (Some(robot), Some(source), true, []) =
            (robot, source, outcome.is_better, &outcome.worse[..])
        else {
            return Err(outcome);
        };
        let asked: Vec<Vec<String>> = picks.iter().map(|p| self.asked(p.offer)).collect();
        let files = self.state.files.iter().cloned().chain(files).collect();
        self.state = State { edition, source, robot, verdict, files };
        self.mended.extend(picks.iter().zip(asked).map(|(p, rules)| Mended {
            rules,
            subject: p.offer.subject.clone(),
            line: p.offer.line,
            change: p.change.words.clone(),
        }));
        Ok(())
    }
}

impl Run<'_> {
    /// The rules that found something about what an offer is for.
    fn asked(&self, offer: &Offer) -> Vec<String> {
        let findings = self.job.wanted.findings(&self.state.verdict, offer.way);
        let named = |f: &&(&str, &str)| is_about(f.1, &offer.subject);
        let mut rules: Vec<String> =
            findings.iter().filter(named).map(|f| f.0.to_owned()).collect();
        if rules.is_empty() {
            rules = findings.iter().map(|f| f.0.to_owned()).collect();
        }
        rules.sort();
        rules.dedup();
        rules
    }
}

fn told(outcome: &Outcome) -> String {
    match outcome.worse.first() {
        Some(why) if why.starts_with("a macro") => why.clone(),
        Some(worse) => format!("tried and undone, for {worse}"),
        None => "tried and undone, for no check finds less".into(),
    }
}

/// What is still found of what is wanted, and why it stays.
fn left(job: &Job, verdict: &Verdict, refused: &[Refused]) -> Vec<Left> {
    let mut all = Vec::new();
    let asked = |id: &str| job.wanted.only.is_empty() || job.wanted.only.iter().any(|o| o == id);
    for check in verdict.checks.iter().filter(|c| c.status == Status::Fail && asked(&c.id)) {
        let remedy = explain(&check.id).map_or("", |e| e.remedy(&check.evidence));
        for finding in check.evidence.iter().filter(|f| is_finding(f)) {
            let mine = refused.iter().rev().find(|r| {
                r.way.remedy().is_for(&check.id, finding) && is_about(finding, &r.subject)
            });
            let wanted = job.wanted.wants(check);
            let why = match mine {
                Some(refused) => refused.why.clone(),
                None if is_mendable(&check.id, finding) && !wanted => {
                    format!("a warning: --flags, or --only {}, mends those, too", check.id)
                }
                None => format!("by hand: {remedy}"),
            };
            let counts = check.counts_against() && check.severity == Severity::Error;
            all.push(Left { rule: check.id.clone(), finding: finding.clone(), why, counts });
        }
    }
    all
}

/// Whether a piece of evidence is a finding, and not how it was looked for.
fn is_finding(evidence: &str) -> bool {
    !["looked at", "judged at", "and "].iter().any(|start| evidence.starts_with(start))
}

/// Whether a finding names all that a subject does.
fn is_about(finding: &str, subject: &str) -> bool {
    subject.split('`').skip(1).step_by(2).all(|name| finding.contains(&format!("`{name}`")))
}
