//! What any program finds: by its exit code, or by lines that it has not for the original.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use adapters::keeper::Keeper;

use super::answers::{Asker, Found, Seen};
use crate::cli::args::{BenchArgs, FoundBy};
use crate::cli::program;
use crate::mutate::manifest::Mutant;

/// Pause between two looks at whether it has ended.
const PAUSE: Duration = Duration::from_millis(20);
/// The word of its arguments that the model's file stands for.
const FILE: &str = "{}";
/// Most characters of a line that is quoted.
const LONGEST: usize = 200;

/// A program, and what it says of the original.
pub(super) struct Program<'a> {
    args: &'a BenchArgs,
    locks: tempfile::TempDir,
    original: Option<Original>,
}

struct Original {
    exit: Option<i32>,
    lines: BTreeSet<String>,
    /// Lines that differ between two runs, their numbers left out.
    vague: BTreeSet<String>,
}

/// One run of it.
struct Run {
    /// Its exit code; none where a signal ended it or it took too long.
    exit: Option<i32>,
    lines: BTreeSet<String>,
    seconds: f64,
    /// Why there is no answer.
    trouble: Option<String>,
}

impl<'a> Program<'a> {
    pub(super) fn new(args: &'a BenchArgs) -> std::io::Result<Self> {
        Ok(Self { args, locks: tempfile::tempdir()?, original: None })
    }

    fn run(&self, file: &Path) -> Run {
        let began = Instant::now();
        let broken = |why: String| Run {
            exit: None,
            lines: BTreeSet::new(),
            seconds: began.elapsed().as_secs_f64(),
            trouble: Some(why),
        };
        let Some((name, words)) = self.args.program.split_first() else {
            return broken("no program is named".into());
        };
        let told = file.display().to_string();
        let mut words: Vec<String> = words.iter().map(|w| w.replace(FILE, &told)).collect();
        if !self.args.program.iter().any(|w| w.contains(FILE)) {
            words.push(told);
        }
        let keeper =
            Keeper { program: program::apart().ok(), lock: self.locks.path().join("lock") };
        let mut kept = match keeper.start(name, &words, None) {
            Ok(kept) => kept,
            Err(e) => return broken(format!("it cannot be started: {e}")),
        };
        let status = loop {
            match kept.ended() {
                Ok(Some(status)) => break status,
                Err(e) => return broken(format!("nobody can say how it ended: {e}")),
                Ok(None) if began.elapsed() >= self.args.deadline => {
                    kept.end();
                    let seconds = self.args.deadline.as_secs_f64();
                    return broken(format!("no answer in {seconds} s"));
                }
                Ok(None) => std::thread::sleep(PAUSE),
            }
        };
        let seconds = began.elapsed().as_secs_f64();
        let said = String::from_utf8_lossy(&kept.last_words()).into_owned();
        let trouble = match status.code() {
            None => Some(format!("it broke down: {status}")),
            // What a shell and the keeper end with where there is no such program.
            Some(127) => Some(format!("it cannot be started: {}", said.trim())),
            Some(_) => None,
        };
        Run { exit: status.code(), lines: self.findings(&said, file), seconds, trouble }
    }

    /// Lines that are findings, without colours and without the path of the folder.
    fn findings(&self, said: &str, file: &Path) -> BTreeSet<String> {
        let folder = file.parent().unwrap_or(Path::new("")).display().to_string();
        let marks: Vec<String> = self.args.marks.iter().map(|m| m.trim().to_lowercase()).collect();
        let plain = |line: &str| {
            let line = uncoloured(line).replace(&folder, "");
            line.split_whitespace().collect::<Vec<_>>().join(" ")
        };
        let is_one = |line: &String| {
            let lower = line.to_lowercase();
            marks.iter().any(|m| !m.is_empty() && lower.contains(m.as_str()))
        };
        said.lines().map(plain).filter(is_one).collect()
    }
}

/// A line without the sequences that terminals colour by.
fn uncoloured(line: &str) -> String {
    let (mut out, mut rest) = (String::with_capacity(line.len()), line);
    while let Some(at) = rest.find("\u{1b}[") {
        out.push_str(&rest[..at]);
        let tail = &rest[at + 2..];
        let end = tail.find(|c: char| c.is_ascii_alphabetic()).map_or(tail.len(), |i| i + 1);
        rest = &tail[end..];
    }
    out + rest
}

/// A line without its numbers.
pub(super) fn numberless(line: &str) -> String {
    line.chars().filter(|c| !c.is_ascii_digit()).collect()
}

impl Asker for Program<'_> {
    fn original(&mut self, file: &Path) -> Seen {
        let [one, two] = [self.run(file), self.run(file)];
        let differ = one.lines.symmetric_difference(&two.lines);
        let vague = differ.map(|l| numberless(l)).collect();
        let by_exit = one.exit != Some(0) && self.args.found_by != FoundBy::Output;
        let alarm = one.trouble.clone().or_else(|| {
            by_exit.then(|| format!("exit {}", one.exit.map_or("none".into(), |c| c.to_string())))
        });
        let seconds = one.seconds.min(two.seconds);
        let lines = one.lines.union(&two.lines).cloned().collect();
        self.original = Some(Original { exit: one.exit, lines, vague });
        Seen { alarm, seconds }
    }

    fn mutant(&mut self, file: &Path, _: &Mutant) -> Found {
        let run = self.run(file);
        let Some(original) = &self.original else {
            let by = "the original was not asked".to_owned();
            return Found { is_found: false, by, seconds: run.seconds };
        };
        if let Some(why) = run.trouble {
            return Found { is_found: false, by: why, seconds: run.seconds };
        }
        let exit = run.exit.filter(|code| *code != 0 && original.exit == Some(0));
        let known =
            |l: &&String| !original.lines.contains(*l) && !original.vague.contains(&numberless(l));
        let line = run.lines.iter().find(known);
        let how = self.args.found_by;
        let by_exit = exit.filter(|_| how != FoundBy::Output).map(|code| format!("exit {code}"));
        let by_line = line
            .filter(|_| how != FoundBy::Exit)
            .map(|l| guard::text::brief(l, LONGEST).into_owned());
        let found: Vec<String> = by_exit.into_iter().chain(by_line).collect();
        let by = if found.is_empty() { "nothing".into() } else { found.join(": ") };
        Found { is_found: !found.is_empty(), by, seconds: run.seconds }
    }
}

/// Whether a program of that name can be found at all; checked before anything is run.
pub(super) fn stands(name: &str) -> bool {
    let path = PathBuf::from(name);
    if path.components().count() > 1 {
        return path.is_file();
    }
    let all = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&all).any(|folder| folder.join(name).is_file())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_and_numbers_make_no_new_finding() {
        assert_eq!(uncoloured("\u{1b}[31mERROR\u{1b}[0m no"), "ERROR no");
        assert_eq!(numberless("2 errors in 0.31 s"), " errors in . s");
    }
}
