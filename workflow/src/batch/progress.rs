//! What a person sees of a batch: one line that stays readable at a hundred thousand items.

use std::collections::BTreeMap;
use std::io::{self, IsTerminal, Write};
use std::sync::{Mutex, MutexGuard};
use std::time::{Duration, Instant};

use indicatif::{HumanCount, HumanDuration, ProgressBar, ProgressStyle};

use super::gate::Places;
use super::purse::Spent;
use super::record::{Ended, Record};

/// Pause between two lines where there is no terminal.
pub const PAUSE: Duration = Duration::from_secs(10);
/// Items at work that are named in a line.
const NAMED: usize = 3;
/// Failures that are told one by one; the others are only counted.
const TOLD: u64 = 20;

/// What the batch is at, in numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    /// Items of this run that came to an outcome.
    pub done: u64,
    /// Accepted in this run.
    pub accepted: u64,
    /// Rejected in this run.
    pub rejected: u64,
    /// Failed in this run.
    pub failed: u64,
    /// Of those not accepted, how many of which class.
    pub classes: BTreeMap<String, u64>,
    /// Stages that ran.
    pub stages_run: u64,
    /// Stages whose result was there.
    pub stages_recalled: u64,
}

impl Tally {
    fn note(&mut self, record: &Record) {
        self.done += 1;
        match record.outcome {
            Ended::Accepted => self.accepted += 1,
            Ended::Rejected => self.rejected += 1,
            Ended::Failed | Ended::Reopened => self.failed += 1,
        }
        if let Some(class) = &record.class {
            *self.classes.entry(class.clone()).or_default() += 1;
        }
        self.stages_run += record.stages_run;
        self.stages_recalled += record.stages_recalled;
    }
}

/// Where progress is shown.
pub struct Board {
    desk: Mutex<Desk>,
    bar: Option<ProgressBar>,
    quiet: bool,
}

struct Desk {
    tally: Tally,
    before: u64,
    planned: u64,
    told: u64,
    began: Instant,
    last: Instant,
}

impl Board {
    /// A board for `planned` items, of which `before` have an outcome already; silent if `quiet`.
    pub fn new(planned: u64, before: u64, quiet: bool) -> Self {
        let bar = (!quiet && io::stderr().is_terminal()).then(|| {
            let bar = ProgressBar::new(planned);
            let style = ProgressStyle::with_template("{bar:24} {msg}");
            bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
            bar.set_position(before);
            bar
        });
        let now = Instant::now();
        let (tally, told) = (Tally::default(), 0);
        let desk = Desk { tally, before, planned, told, began: now, last: now };
        Self { desk: Mutex::new(desk), bar, quiet }
    }

    fn desk(&self) -> MutexGuard<'_, Desk> {
        self.desk.lock().unwrap_or_else(|e| e.into_inner())
    }

    /// Takes note of an outcome.
    pub fn note(&self, record: &Record, at_work: [usize; 3], spent: Spent) {
        let mut desk = self.desk();
        desk.tally.note(record);
        if record.outcome != Ended::Accepted {
            self.tell_failure(&mut desk, record);
        }
        if let Some(bar) = &self.bar {
            bar.set_position(
                desk.before + desk.tally.accepted + desk.tally.rejected + desk.tally.failed,
            );
            bar.set_message(desk.line(at_work, spent));
        }
    }

    /// Says how far the batch is and what it works at, where there is no terminal and nothing was said for
    /// [`PAUSE`].
    pub fn tick(&self, places: &Places, spent: Spent) {
        let mut desk = self.desk();
        if self.bar.is_some() || desk.last.elapsed() < PAUSE {
            return;
        }
        desk.last = Instant::now();
        let mut line = desk.line(places.taken(), spent);
        line.push_str(&named(&places.at_work()));
        self.say(&line);
    }

    fn tell_failure(&self, desk: &mut Desk, record: &Record) {
        desk.told += 1;
        if desk.told <= TOLD {
            let class = record.class.as_deref().unwrap_or_default();
            let reason = record.reason.as_deref().unwrap_or_default();
            self.say(&format!("{} {}: {class}: {reason}", record.outcome.name(), record.id));
        } else if desk.told == TOLD + 1 {
            self.say("more of those are only counted; the ledger has them all");
        }
    }

    /// Takes the line off the screen and returns the numbers.
    pub fn finish(&self) -> Tally {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
        self.desk().tally.clone()
    }

    /// Says a line of the conversation; what it quotes is inert.
    pub fn say(&self, line: &str) {
        let line = &*guard::text::shown(line);
        match &self.bar {
            Some(bar) => bar.println(line),
            None if self.quiet => {}
            // Nobody may be listening; that is no reason to stop.
            None => drop(writeln!(io::stderr(), "{line}")),
        }
    }
}

/// The first items at work, each with its stage.
fn named(at_work: &[(String, &'static str)]) -> String {
    let first = at_work.iter().take(NAMED).map(|(id, stage)| format!("{id} {stage}"));
    let first: Vec<String> = first.collect();
    let more = at_work.len().saturating_sub(NAMED);
    match (first.is_empty(), more) {
        (true, _) => String::new(),
        (false, 0) => format!(": {}", first.join(", ")),
        (false, more) => format!(": {} and {more} more", first.join(", ")),
    }
}

impl Desk {
    fn line(&self, [cpu, mesh, condition]: [usize; 3], spent: Spent) -> String {
        let Tally { done, accepted, rejected, failed, .. } = &self.tally;
        let at = HumanCount(self.before + done);
        let mut line = format!(
            "{at}/{}  accepted {}  rejected {}  failed {}",
            HumanCount(self.planned),
            HumanCount(*accepted),
            HumanCount(*rejected),
            HumanCount(*failed),
        );
        let seconds = self.began.elapsed().as_secs_f64();
        let left = self.planned.saturating_sub(self.before + done);
        if *done > 0 && seconds > 0.0 {
            let rate = *done as f64 / seconds;
            let eta = Duration::try_from_secs_f64(left as f64 / rate).unwrap_or(Duration::MAX);
            line.push_str(&format!("  {rate:.2}/s  {} left", HumanDuration(eta)));
        }
        line.push_str(&format!("  at work {cpu}+{mesh}+{condition}"));
        if spent.calls > 0 {
            line.push_str(&format!("  calls {}", HumanCount(spent.calls)));
        }
        line
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_is_one_line_at_a_hundred_thousand_items() {
        let board = Board::new(100_000, 45_000, true);
        for n in 0..100 {
            let mut record = Record::new(format!("k{n}"), Ended::Accepted);
            if n % 10 == 0 {
                (record.outcome, record.class) = (Ended::Rejected, Some("verdict".into()));
            }
            board.note(&record, [2, 4, 8], Spent { calls: 12_345, cost: 1.0 });
        }
        let line = board.desk().line([2, 4, 8], Spent { calls: 12_345, cost: 1.0 });
        assert!(line.starts_with("45,100/100,000  accepted 90  rejected 10  failed 0"), "{line}");
        assert!(line.len() < 140 && !line.contains('\n'), "{line}");
        let tally = board.finish();
        assert_eq!((tally.done, tally.classes["verdict"]), (100, 10));
    }

    #[test]
    fn the_first_items_at_work_are_named_with_their_stages() {
        let work = |count: usize| -> Vec<(String, &'static str)> {
            (0..count).map(|n| (format!("kettle-{n}"), "articulate")).collect()
        };
        assert_eq!(named(&work(0)), "");
        assert_eq!(named(&work(1)), ": kettle-0 articulate");
        let all = ": kettle-0 articulate, kettle-1 articulate, kettle-2 articulate and 2 more";
        assert_eq!(named(&work(5)), all);
    }
}
