//! What one process tells the other of a model that was mended, and what a person is told of it.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use sim_check::{Status, Verdict};
use similar::TextDiff;

use crate::cli::args::FixArgs;
use crate::fix::remedies::REMEDIES;
use crate::fix::run::{Fixed, Left, Mended};

/// Most findings that stay and are told a line each.
const TOLD: usize = 12;
/// Most changes that are told a line each: the diff has them all.
const CHANGES: usize = 30;
/// Longest line of a finding that stays, characters.
const LONGEST: usize = 300;
/// What a hunk of a diff shows around a change, lines: as diff and git do.
const AROUND: usize = 3;

/// A model before and after, on its way to the other process.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Made {
    pub(super) before: Verdict,
    pub(super) after: Verdict,
    pub(super) old: String,
    pub(super) new: String,
    pub(super) files: Vec<File>,
    pub(super) mended: Vec<Mended>,
    pub(super) left: Vec<Left>,
    pub(super) ran_out: bool,
    /// Whether it could be read as one model.
    pub(super) is_model: bool,
}

/// A new file.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct File {
    pub(super) path: PathBuf,
    /// In base64.
    bytes: String,
}

/// What the process apart says.
#[derive(Debug, Serialize, Deserialize)]
pub(super) enum Line {
    Made(Box<Made>),
    Complaint { message: String, hints: Vec<String> },
}

impl Made {
    pub(super) fn of(fixed: Fixed) -> Self {
        let file =
            |f: crate::fix::run::NewFile| File { path: f.path, bytes: STANDARD.encode(f.bytes) };
        Self {
            before: fixed.before,
            after: fixed.after,
            old: fixed.old,
            new: fixed.new,
            files: fixed.files.into_iter().map(file).collect(),
            mended: fixed.mended,
            left: fixed.left,
            ran_out: fixed.ran_out,
            is_model: fixed.is_model,
        }
    }
}

impl File {
    /// What stands in it.
    pub(super) fn bytes(&self) -> Option<Vec<u8>> {
        STANDARD.decode(&self.bytes).ok()
    }
}

/// The difference of two texts, as `git apply` and `patch -p1` read it; nothing where there is none.
pub(super) fn diff(file: &Path, old: &str, new: &str) -> String {
    let path = file.display().to_string();
    let path = path.trim_start_matches("./").trim_start_matches('/');
    let path = guard::text::shown(path);
    let (from, to) = (format!("a/{path}"), format!("b/{path}"));
    let diff = TextDiff::from_lines(old, new);
    diff.unified_diff().context_radius(AROUND).header(&from, &to).to_string()
}

/// What stands in the answer for programs.
pub(super) fn json(file: &Path, made: &Made, written: bool) -> String {
    let brief = |v: &Verdict| {
        let failing: Vec<&str> = v.failures().map(|c| c.id.as_str()).collect();
        json!({ "tier": v.tier.name(), "counts": v.counts, "failing": failing })
    };
    let files: Vec<String> = made.files.iter().map(|f| f.path.display().to_string()).collect();
    let value = json!({
        "file": file.display().to_string(),
        "written": written,
        "before": brief(&made.before),
        "after": brief(&made.after),
        "changes": made.mended,
        "left": made.left,
        "new_files": files,
        "out_of_time": made.ran_out,
        "diff": diff(file, &made.old, &made.new),
        "verdicts": { "before": made.before, "after": made.after },
    });
    let text = serde_json::to_string_pretty(&value).unwrap_or_default();
    guard::text::json(&text).into_owned() + "\n"
}

/// What a person is told beside the difference.
pub(super) fn remarks(file: &Path, made: &Made, args: &FixArgs, written: bool) -> Vec<String> {
    if args.json {
        return Vec::new();
    }
    let name = file.display();
    let mut all: Vec<String> = made.mended.iter().take(CHANGES).map(changed).collect();
    if made.mended.len() > CHANGES {
        all.push(format!("{} more changes; --json has them all", made.mended.len() - CHANGES));
    }
    let new = made.files.len();
    if written {
        all.push(format!("{name} was written{}", with_files(new, "are new beside it")));
    } else if !made.mended.is_empty() {
        let needs = with_files(new, "come with it");
        all.push(format!("nothing was written; --write changes {name}{needs}"));
    }
    for file in made.files.iter().take(TOLD) {
        all.push(format!("  new: {}", file.path.display()));
    }
    if new > TOLD {
        all.push(format!("  new: {} more", new - TOLD));
    }
    all.extend(stays(&made.left));
    if made.ran_out {
        all.push("time ran out before everything was tried: --deadline gives more".into());
    }
    let (before, after) = (&made.before, &made.after);
    let is_unknown = |id: &str| before.check(id).is_some_and(|c| c.status == Status::Unknown);
    let told = after.checks.iter().filter(|c| c.status == Status::Fail && is_unknown(&c.id));
    let told: Vec<&str> = told.map(|c| c.id.as_str()).collect();
    if !told.is_empty() {
        all.push(format!("could not be judged before, and fails now: {}", told.join(", ")));
    }
    let open = |v: &Verdict| v.counts.fail + v.counts.unknown;
    all.push(format!(
        "before: tier {}, {} checks fail or are unknown; after: tier {}, {}",
        before.tier.name(),
        open(before),
        after.tier.name(),
        open(after)
    ));
    all
}

fn with_files(count: usize, what: &str) -> String {
    match count {
        0 => String::new(),
        1 => format!(
            ", and 1 mesh file {}",
            what.replacen("are", "is", 1).replacen("come", "comes", 1)
        ),
        n => format!(", and {n} mesh files {what}"),
    }
}

fn changed(mended: &Mended) -> String {
    let Mended { rules, subject, line, change } = mended;
    format!("{}: {subject} (line {line}): {change}", rules.join(", "))
}

/// What stays: those that lower the tier first.
fn stays(left: &[Left]) -> Vec<String> {
    let mut sorted: Vec<&Left> = left.iter().collect();
    sorted.sort_by_key(|l| !l.counts);
    let told = |l: &&Left| {
        let all = format!("stays {}: {}: {}", l.rule, l.finding, l.why);
        guard::text::brief(&all, LONGEST).into_owned()
    };
    let mut all: Vec<String> = sorted.iter().take(TOLD).map(told).collect();
    if sorted.len() > TOLD {
        all.push(format!("stays: {} more; --json has them all", sorted.len() - TOLD));
    }
    all
}

/// What can be mended.
pub(super) fn list(json: bool) -> String {
    if json {
        let all: Vec<Value> = REMEDIES
            .iter()
            .map(|r| json!({ "rules": r.rules, "found": r.found, "change": r.change }))
            .collect();
        return format!("{:#}\n", Value::Array(all));
    }
    let mut out = String::from("What is mended, the smallest change first:\n");
    for remedy in &REMEDIES {
        let _ = writeln!(out, "\n{}", remedy.rules.join(", "));
        let _ = writeln!(out, "  found:  {}\n  change: {}", remedy.found, remedy.change);
    }
    out.push_str("\nEverything else is told and left to a person; `kinfold explain RULE` says what can be done.\n");
    out
}
