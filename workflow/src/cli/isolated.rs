//! Checks in processes of their own, so that no file can hang, crash or starve the rest.

use std::ffi::OsString;
use std::io::{BufRead as _, BufReader, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::Duration;

use sim_check::{Asked, CheckOptions, Outside, Verdict, undecided};

/// Files a process checks before another takes over: what one file left behind must not last.
const FILES: usize = 64;
/// Most address space of a process that checks, bytes (8 GiB): one that wants more is ended by that.
/// Meshes as large as they may be (5 million vertices) need less than half; a guess with room.
const MEMORY: u64 = 8 << 30;

/// How checks are run apart.
pub struct Isolation {
    /// This program.
    pub program: PathBuf,
    /// How long one check may take.
    pub deadline: Duration,
    /// Threads each process may use.
    pub threads: usize,
}

/// One process after the other that checks files.
pub struct Checker<'a> {
    isolation: &'a Isolation,
    options: &'a CheckOptions,
    process: Option<Process>,
}

/// A process that waits for names of files and answers each with a verdict, a line each.
struct Process {
    child: Child,
    answers: Receiver<String>,
    files: usize,
}

/// Why there is no verdict.
enum Trouble {
    /// It took too long.
    Slow,
    /// The process is gone.
    Gone(String),
}

fn too_slow(deadline: Duration) -> String {
    format!("the check took longer than {} s and was stopped", deadline.as_secs_f64())
}

impl<'a> Checker<'a> {
    /// No process yet.
    pub fn new(isolation: &'a Isolation, options: &'a CheckOptions) -> Self {
        Self { isolation, options, process: None }
    }

    /// The verdict on a URDF. A process that is too slow is stopped, one that dies is said to have
    /// died; everything is unknown then. What dies after it checked other files is asked once more
    /// on its own.
    pub fn check(&mut self, urdf: &Path) -> Verdict {
        let is_fresh = self.process.is_none();
        let answer = match self.ask(urdf) {
            Err(Trouble::Gone(_)) if !is_fresh => self.ask(urdf),
            answer => answer,
        };
        answer.unwrap_or_else(|trouble| {
            let reason = match trouble {
                Trouble::Slow => too_slow(self.isolation.deadline),
                Trouble::Gone(reason) => reason,
            };
            undecided(&reason, self.options)
        })
    }

    fn ask(&mut self, urdf: &Path) -> Result<Verdict, Trouble> {
        let mut process = match self.process.take() {
            Some(process) => process,
            None => self.isolation.start(self.options).map_err(Trouble::Gone)?,
        };
        let verdict = process.ask(urdf, self.isolation.deadline)?;
        process.files += 1;
        self.process = Some(process).filter(|p| p.files < FILES);
        Ok(verdict)
    }
}

impl Isolation {
    fn start(&self, options: &CheckOptions) -> Result<Process, String> {
        let words = ["check".to_owned()].into_iter().chain(arguments(options));
        self.begin(words.chain(["--".into(), NAMES.into()]).map(OsString::from))
    }

    /// The line that this program answers when it is asked once, apart, with these words: in its time,
    /// within its memory.
    ///
    /// # Errors
    /// Why there is no answer, in words.
    pub fn line(&self, words: impl IntoIterator<Item = OsString>) -> Result<String, String> {
        let mut process = self.begin(words)?;
        match process.answers.recv_timeout(self.deadline) {
            Ok(line) => Ok(line),
            Err(RecvTimeoutError::Timeout) => Err(too_slow(self.deadline)),
            Err(RecvTimeoutError::Disconnected) => match process.broken(self.deadline) {
                Trouble::Gone(reason) => Err(reason),
                Trouble::Slow => Err(too_slow(self.deadline)),
            },
        }
    }

    fn begin(&self, words: impl IntoIterator<Item = OsString>) -> Result<Process, String> {
        let mut command = Command::new(&self.program);
        command.args(words);
        command.env("RAYON_NUM_THREADS", self.threads.max(1).to_string());
        command.env(ASKER, std::process::id().to_string());
        // Most files need less than it takes to clear a few huge pages.
        command.env("MIMALLOC_ALLOW_THP", "0");
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        let failed = |e| format!("no process could be started to check it: {e}");
        let mut child = command.spawn().map_err(failed)?;
        let (sender, answers) = channel();
        let stdout = child.stdout.take();
        std::thread::spawn(move || {
            let lines = stdout.into_iter().flat_map(|out| BufReader::new(out).lines());
            // What cannot be read is no verdict; nobody may be waiting for it any more.
            lines.map_while(Result::ok).try_for_each(|line| sender.send(line))
        });
        Ok(Process { child, answers, files: 0 })
    }
}

impl Process {
    fn ask(&mut self, urdf: &Path, deadline: Duration) -> Result<Verdict, Trouble> {
        let name =
            serde_json::to_string(urdf.as_os_str()).map_err(|e| self.gone(&e.to_string()))?;
        if let Some(stdin) = &mut self.child.stdin {
            // One that does not listen does not answer either.
            let _ = writeln!(stdin, "{name}").and_then(|()| stdin.flush());
        }
        match self.answers.recv_timeout(deadline) {
            Ok(line) => serde_json::from_str(&line).map_err(|_| self.broken(deadline)),
            Err(RecvTimeoutError::Timeout) => Err(Trouble::Slow),
            Err(RecvTimeoutError::Disconnected) => Err(self.broken(deadline)),
        }
    }

    /// How it ended that gives no answer, or none that can be read.
    fn broken(&mut self, deadline: Duration) -> Trouble {
        drop(self.child.stdin.take());
        if self.answers.recv_timeout(deadline) != Err(RecvTimeoutError::Disconnected) {
            let _ = self.child.kill();
        }
        match self.child.wait() {
            Ok(status) => self.gone(&status.to_string()),
            Err(e) => self.gone(&e.to_string()),
        }
    }

    fn gone(&self, how: &str) -> Trouble {
        let most = MEMORY >> 30;
        Trouble::Gone(format!(
            "the process that checked it broke down ({how}); it may take {most} GiB of memory"
        ))
    }
}

impl Drop for Process {
    /// It has answered, or has had its time.
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The place of a file where the names of files come in, a line each.
pub const NAMES: &str = "-";

/// The variable that holds the number of the process that asks for checks.
const ASKER: &str = "KINFOLD_ASKED_BY";
/// Pause between two looks at who asks, once no more names can come.
const PAUSE: Duration = Duration::from_millis(20);

/// Checks the files named on standard input, a line of JSON each; answers with a line each. Ends in
/// the middle of a check if whoever asked is no more, and takes no more memory than it may.
///
/// # Errors
/// What reading or writing fails of.
pub fn serve(options: &CheckOptions) -> std::io::Result<()> {
    bound_memory()?;
    let (sender, names) = channel();
    std::thread::spawn(move || {
        let lines = std::io::stdin().lock().lines();
        // Nobody takes names any more when a check could not be answered.
        let _ = lines.map(|line| sender.send(line)).take_while(Result::is_ok).count();
        drop(sender);
        outlive_nobody();
    });
    for line in names {
        let name: std::ffi::OsString = serde_json::from_str(&line?)?;
        let mut answer = serde_json::to_vec(&sim_check::check(Path::new(&name), options))?;
        answer.push(b'\n');
        let mut out = std::io::stdout().lock();
        out.write_all(&answer)?;
        out.flush()?;
    }
    Ok(())
}

/// Bounds this process, which answers one question: its memory, and its life by that of whoever asked.
///
/// # Errors
/// What the system refuses.
pub fn answer_once() -> std::io::Result<()> {
    bound_memory()?;
    std::thread::spawn(|| {
        // It ends when whoever asked is no more; nothing is said there.
        let _ = std::io::copy(&mut std::io::stdin().lock(), &mut std::io::sink());
        outlive_nobody();
    });
    Ok(())
}

/// Ends this process as soon as its parent is not the one that asked.
fn outlive_nobody() {
    let asker = std::env::var(ASKER).ok().and_then(|pid| pid.parse::<u32>().ok());
    let Some(asker) = asker else { return };
    #[cfg(unix)]
    while std::os::unix::process::parent_id() == asker {
        std::thread::sleep(PAUSE);
    }
    #[cfg(not(unix))]
    let _ = (asker, PAUSE);
    std::process::exit(0);
}

/// A lower bound that somebody else has set stays.
#[cfg(unix)]
pub(super) fn bound_memory() -> std::io::Result<()> {
    use rlimit::Resource;
    let (soft, hard) = Resource::AS.get()?;
    Resource::AS.set(soft.min(MEMORY), hard.min(MEMORY))
}

/// Other systems have no such bound: the deadline is all there is.
#[cfg(not(unix))]
pub(super) fn bound_memory() -> std::io::Result<()> {
    Ok(())
}

/// The options as this program's arguments.
fn arguments(options: &CheckOptions) -> Vec<String> {
    let mut all: Vec<String> = ["--here", "--json", "--tier"].map(String::from).into();
    all.extend([options.up_to.name().into(), "--seed".into(), options.seed.to_string()]);
    if options.outside == Outside::Allowed {
        all.push("--allow-outside".into());
    }
    match options.subject {
        Asked::As(subject) => all.extend(["--as".into(), subject.name().into()]),
        Asked::Asset | Asked::Found => {}
    }
    if let Some(base) = options.base {
        all.extend(["--base".into(), base.name().into()]);
    }
    let places = &options.places;
    for (name, folder) in &places.packages {
        all.extend(["--package".into(), format!("{name}={}", folder.display())]);
    }
    if !places.shelves.is_empty() {
        all.push("--ros".into());
    }
    for (name, value) in &places.env {
        all.extend(["--env".into(), format!("{name}={value}")]);
    }
    for (name, value) in &places.args {
        all.extend(["--arg".into(), format!("{name}={value}")]);
    }
    if let Some(path) = &places.srdf {
        all.extend(["--srdf".into(), path.display().to_string()]);
    }
    for (id, reason) in &options.waivers {
        all.extend(["--waive".into(), format!("{id}={reason}")]);
    }
    all
}

#[cfg(all(test, unix))]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on stops")]
mod tests {
    use super::*;
    use sim_check::{Status, Tier};

    /// The verdicts on some files where the program is a shell script instead.
    fn verdicts_of(script: &str, milliseconds: u64, files: &[&str]) -> Vec<Verdict> {
        use std::os::unix::fs::PermissionsExt as _;
        let folder = tempfile::tempdir().unwrap();
        let program = folder.path().join("program");
        std::fs::write(&program, format!("#!/bin/sh\n{script}\n")).unwrap();
        std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755)).unwrap();
        let deadline = Duration::from_millis(milliseconds);
        let isolation = Isolation { program, deadline, threads: 1 };
        let options = CheckOptions::default();
        let mut checker = Checker::new(&isolation, &options);
        files.iter().map(|file| checker.check(Path::new(file))).collect()
    }

    fn verdict_of(script: &str, milliseconds: u64) -> Verdict {
        verdicts_of(script, milliseconds, &["x.urdf"]).remove(0)
    }

    /// A script that answers every name, but ends on some of them.
    fn answering(ends: &str) -> String {
        let said = serde_json::to_string(&undecided("asked", &CheckOptions::default())).unwrap();
        let cases = format!("case \"$name\" in {ends} esac");
        format!("while read -r name; do {cases}; cat <<'END'\n{said}\nEND\ndone")
    }

    fn reason(verdict: &Verdict) -> &str {
        assert_eq!(verdict.tier, Tier::None);
        assert!(verdict.checks.iter().all(|c| c.status == Status::Unknown));
        &verdict.checks[0].evidence[0]
    }

    #[test]
    fn a_process_that_hangs_is_stopped_and_everything_is_unknown() {
        let verdict = verdict_of("exec sleep 60", 100);
        assert_eq!(reason(&verdict), "the check took longer than 0.1 s and was stopped");
    }

    #[test]
    fn a_process_that_dies_is_no_verdict() {
        let verdict = verdict_of("echo '{\"tier\": \"dynamic\"'; kill -ABRT $$", 10_000);
        assert!(reason(&verdict).contains("broke down (signal: 6"), "{}", reason(&verdict));
    }

    #[test]
    fn files_are_checked_one_after_the_other_and_one_that_kills_its_process_costs_no_other() {
        let files = ["a", "bad", "b", "c"];
        let verdicts = verdicts_of(&answering("*98,97,100*) kill -ABRT $$;;"), 10_000, &files);
        let reasons: Vec<_> = verdicts.iter().map(reason).collect();
        assert!(reasons[1].contains("broke down (signal: 6"), "{reasons:?}");
        assert_eq!([reasons[0], reasons[2], reasons[3]], ["asked"; 3]);
    }

    #[test]
    fn one_that_is_too_slow_costs_no_other() {
        let verdicts = verdicts_of(&answering("*97*) exec sleep 60;;"), 300, &["b", "a", "b"]);
        let reasons: Vec<_> = verdicts.iter().map(reason).collect();
        assert_eq!(reasons, ["asked", "the check took longer than 0.3 s and was stopped", "asked"]);
    }

    /// The third file of a process kills it, whatever it is: fresh ones check it.
    #[test]
    fn what_dies_after_other_files_is_asked_once_more() {
        let script = answering("*) n=$((n+1)); [ $n -gt 2 ] && kill -ABRT $$;;");
        let verdicts = verdicts_of(&script, 10_000, &["a", "b", "c", "d", "e"]);
        assert_eq!(verdicts.iter().map(reason).collect::<Vec<_>>(), ["asked"; 5]);
    }

    #[test]
    fn options_survive_the_way_to_the_other_process() {
        let waivers = [("C1".to_string(), "a = b".to_string())].into();
        let options = CheckOptions { waivers, seed: 7, ..CheckOptions::default() };
        let all = arguments(&options);
        assert_eq!(all[2..], ["--tier", "audited", "--seed", "7", "--waive", "C1=a = b"]);
    }
}
