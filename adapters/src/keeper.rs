//! Programs that end with us, however we end: this program, started once more, looks after each.
//!
//! The keeper holds a pipe from us and leads a process group. When the pipe closes, because we let
//! go of it or are no more, it ends the program, whatever that started, and itself. So nothing has
//! to be remembered and nothing has to be tidied up by the next run.

use std::ffi::OsString;
use std::fs::File;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitCode, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use crate::overheard::{Onlooker, Overheard};

/// The word after which this program is a keeper: `kinfold keep-program LOCK PROGRAM ARGUMENTS...`.
pub const VERB: &str = "keep-program";
/// What the keeper ends with where the program cannot be started, as a shell does.
const NOT_STARTED: u8 = 127;
/// How much of a program's last words is kept, bytes.
const LAST_WORDS: usize = 64 << 10;
/// How long the end of what a program says is waited for once it is gone: a guess, for whoever it
/// started may hold its output open.
const LAST_WAIT: Duration = Duration::from_secs(2);
/// How long whoever looks on may take to see the last lines.
const LAST_LOOK: Duration = Duration::from_millis(300);
/// How long a keeper may take to end its program: far more than it needs.
const ENDING: Duration = Duration::from_secs(10);
/// Pause between two looks at what is still there.
const PAUSE: Duration = Duration::from_millis(10);

/// Looks after a program if the arguments say so: then it returns what to end with.
pub fn asked(mut arguments: impl Iterator<Item = OsString>) -> Option<ExitCode> {
    arguments.nth(1).filter(|verb| verb == VERB)?;
    let (lock, program) = (arguments.next()?, arguments.next()?);
    Some(keep(Path::new(&lock), &program, arguments))
}

fn keep(lock: &Path, program: &OsString, arguments: impl Iterator<Item = OsString>) -> ExitCode {
    called_otherwise();
    adopt();
    std::thread::spawn(|| {
        // Nothing is ever said through it: what comes is its end.
        let _ = std::io::copy(&mut std::io::stdin(), &mut std::io::sink());
        end_all();
    });
    let alone = match alone(lock) {
        Ok(alone) => alone,
        Err(e) => return failed(&format!("{}: {e}", lock.display())),
    };
    let mut command = Command::new(program);
    command.args(arguments).stdin(Stdio::null());
    let ended = command.spawn().and_then(|mut child| child.wait());
    let code = match ended {
        Ok(status) => {
            end_descendants();
            ended_like(status)
        }
        Err(e) => failed(&format!("it cannot be started: {e}")),
    };
    // Who waits for the lock looks for the file anew.
    let _ = std::fs::remove_file(lock);
    drop(alone);
    code
}

fn failed(why: &str) -> ExitCode {
    // Its words go where the program's would.
    let _ = std::io::Write::write_all(&mut std::io::stderr(), format!("{why}\n").as_bytes());
    ExitCode::from(NOT_STARTED)
}

/// Waits until nobody else looks after the same work, such as a keeper that is about to end it.
fn alone(lock: &Path) -> std::io::Result<File> {
    loop {
        let file = File::options().create(true).truncate(false).write(true).open(lock)?;
        file.lock()?;
        if is_still_there(&file, lock)? {
            return Ok(file);
        }
    }
}

/// Whether a file that is open still has its name.
fn is_still_there(file: &File, path: &Path) -> std::io::Result<bool> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt as _;
        match std::fs::metadata(path) {
            Ok(named) => Ok(named.ino() == file.metadata()?.ino()),
            Err(e) if e.kind() == ErrorKind::NotFound => Ok(false),
            Err(e) => Err(e),
        }
    }
    #[cfg(not(unix))]
    Ok(path.exists() && file.metadata().is_ok())
}

/// Another name than the program's, so that whoever ends all processes of that name leaves the one that
/// tidies up.
fn called_otherwise() {
    #[cfg(target_os = "linux")]
    // Under its old name it does its work as well.
    let _ = std::fs::write("/proc/self/comm", "keeper");
}

/// Whoever the program leaves behind becomes a child of the keeper, not of the system.
fn adopt() {
    #[cfg(target_os = "linux")]
    {
        use rustix::process::{getpid, set_child_subreaper};
        // Without it, those who left the group are not found; the group still is.
        let _ = set_child_subreaper(Some(getpid()));
    }
}

/// Ends the program, whatever it started, and this keeper.
fn end_all() {
    end_descendants();
    #[cfg(unix)]
    // It is in the group itself.
    let _ = rustix::process::kill_current_process_group(rustix::process::Signal::KILL);
    std::process::exit(i32::from(NOT_STARTED));
}

/// Ends everybody who descends from this process, and waits until they are gone.
fn end_descendants() {
    let began = Instant::now();
    while began.elapsed() < ENDING {
        let left = descendants(std::process::id());
        if left.is_empty() {
            return;
        }
        left.into_iter().for_each(end);
        std::thread::sleep(PAUSE);
    }
}

fn end(pid: u32) {
    #[cfg(unix)]
    {
        let pid = i32::try_from(pid).ok().and_then(rustix::process::Pid::from_raw);
        // It may be gone by now.
        let _ = pid.map(|pid| rustix::process::kill_process(pid, rustix::process::Signal::KILL));
    }
    #[cfg(not(unix))]
    let _ = pid;
}

/// Everybody alive who descends from a process, as `/proc` tells; nobody where there is none.
fn descendants(root: u32) -> Vec<u32> {
    let number = |name: OsString| name.to_str()?.parse::<u32>().ok();
    let all = std::fs::read_dir("/proc").into_iter().flatten().flatten();
    let living: Vec<(u32, u32)> = all
        .filter_map(|entry| number(entry.file_name()))
        .filter_map(|pid| Some((pid, parent(pid)?)))
        .collect();
    let mut found = vec![root];
    let mut next = 0;
    while let Some(parent) = found.get(next).copied() {
        found.extend(living.iter().filter(|(_, p)| *p == parent).map(|(pid, _)| *pid));
        next += 1;
    }
    found.remove(0);
    found
}

/// The parent of a living process.
fn parent(pid: u32) -> Option<u32> {
    let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    // The name stands in parentheses and may hold anything.
    let mut words = stat.rsplit_once(')')?.1.split_whitespace();
    let is_alive = words.next().is_some_and(|state| !matches!(state, "Z" | "X"));
    words.next()?.parse().ok().filter(|_| is_alive)
}

/// The end of the program as the keeper's own.
fn ended_like(status: std::process::ExitStatus) -> ExitCode {
    #[cfg(unix)]
    if let Some(signal) = std::os::unix::process::ExitStatusExt::signal(&status) {
        use rustix::process::{Signal, getpid, kill_process};
        let signal = Signal::from_named_raw(signal).unwrap_or(Signal::KILL);
        // One that this process does not die of is told like a shell tells it.
        let _ = kill_process(getpid(), signal);
        return ExitCode::from(128_u8.saturating_add(signal.as_raw().unsigned_abs() as u8));
    }
    ExitCode::from(status.code().and_then(|c| u8::try_from(c).ok()).unwrap_or(1))
}

/// Who looks after programs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Keeper {
    /// This program; none to start programs without anybody who ends them when we are no more, for
    /// tests of one room alone.
    pub program: Option<PathBuf>,
    /// A file that whoever does the same work locks.
    pub lock: PathBuf,
}

/// A program at work. It ends at the latest when this is let go.
pub struct Kept {
    child: Child,
    is_kept: bool,
    /// Whether the keeper ended by itself, and with it everybody it looked after.
    is_over: bool,
    words: Receiver<Vec<u8>>,
    /// Says when whoever looks on has seen everything.
    seen: Option<Receiver<()>>,
}

impl Keeper {
    /// Starts a program whose words are kept, the last of them; somebody may look on.
    ///
    /// # Errors
    /// That of the system, where it cannot be started.
    pub fn start(
        &self,
        program: &str,
        arguments: &[String],
        onlooker: Option<Onlooker>,
    ) -> std::io::Result<Kept> {
        let (reader, writer) = std::io::pipe()?;
        let mut command = match &self.program {
            Some(keeper) => {
                if let Some(folder) = self.lock.parent() {
                    std::fs::create_dir_all(folder)?;
                }
                let mut command = Command::new(keeper);
                command.arg(VERB).arg(&self.lock).arg(program).stdin(Stdio::piped());
                command
            }
            None => {
                let mut command = Command::new(program);
                command.stdin(Stdio::null());
                command
            }
        };
        command.args(arguments).stdout(writer.try_clone()?).stderr(writer);
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let child = command.spawn()?;
        drop(command);
        let (sender, words) = channel();
        let name = Path::new(program).file_name().unwrap_or_default().to_string_lossy();
        let heard = onlooker.map(|onlooker| Overheard::by(onlooker, &name));
        let (heard, seen) = heard.map_or((None, None), |(heard, seen)| (Some(heard), Some(seen)));
        std::thread::spawn(move || sender.send(last_of(reader, heard)));
        Ok(Kept { child, is_kept: self.program.is_some(), is_over: false, words, seen })
    }
}

/// The last of what is said until the end; all of it is overheard.
fn last_of(mut said: impl std::io::Read, mut heard: Option<Overheard>) -> Vec<u8> {
    let (mut words, mut piece) = (Vec::new(), vec![0; 8 << 10]);
    loop {
        match said.read(&mut piece) {
            Err(e) if e.kind() == ErrorKind::Interrupted => {}
            Ok(0) | Err(_) => break,
            Ok(n) => {
                if let Some(heard) = &mut heard {
                    heard.hear(&piece[..n]);
                }
                words.extend_from_slice(&piece[..n]);
                if words.len() > 2 * LAST_WORDS {
                    words.drain(..words.len() - LAST_WORDS);
                }
            }
        }
    }
    if let Some(heard) = heard {
        heard.end();
    }
    words.drain(..words.len().saturating_sub(LAST_WORDS));
    words
}

impl Kept {
    /// How it ended, if it did.
    ///
    /// # Errors
    /// That of the system, where it cannot be told.
    pub fn ended(&mut self) -> std::io::Result<Option<std::process::ExitStatus>> {
        let ended = self.child.try_wait()?;
        self.is_over |= self.is_kept && ended.is_some_and(|status| status.code().is_some());
        Ok(ended)
    }

    /// The last it said; it must have ended.
    pub fn last_words(&self) -> Vec<u8> {
        self.words.recv_timeout(LAST_WAIT).unwrap_or_default()
    }

    /// Gives whoever looks on a moment to see the last lines; it must have ended.
    pub fn be_seen(&self) {
        if let Some(seen) = &self.seen {
            // Who is slower than that misses nothing that is kept.
            let _ = seen.recv_timeout(LAST_LOOK);
        }
    }

    /// Ends it and whatever it started, and waits for that.
    pub fn end(&mut self) {
        if self.is_over {
            return;
        }
        // The keeper sees the end of its pipe, and ends everything.
        drop(self.child.stdin.take());
        let began = Instant::now();
        while self.is_kept && began.elapsed() < ENDING {
            if !matches!(self.child.try_wait(), Ok(None)) {
                break;
            }
            std::thread::sleep(PAUSE);
        }
        self.end_group();
    }

    /// Ends whoever is left of its group.
    fn end_group(&mut self) {
        #[cfg(unix)]
        {
            use rustix::process::{Pid, Signal, kill_process_group};
            let group = i32::try_from(self.child.id()).ok().and_then(Pid::from_raw);
            // Nobody may be left.
            let _ = group.map(|group| kill_process_group(group, Signal::KILL));
        }
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Drop for Kept {
    fn drop(&mut self) {
        self.end();
    }
}
