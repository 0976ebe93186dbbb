//! Runs the real program in a folder of its own and looks at what it leaves behind.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::OnceLock;

use crate::cabinet::Cabinet;

/// The clock of runs that must repeat.
pub const CLOCK: &str = "2026-01-31T12:00:00Z";

/// A folder with a cabinet, a state directory and room for results.
pub struct Bench {
    folder: tempfile::TempDir,
    /// The cabinet's files.
    pub cabinet: Cabinet,
}

/// What the program said and how it ended.
#[derive(Debug)]
pub struct Said {
    /// Exit code; `None` if it was killed.
    pub code: Option<i32>,
    /// The result.
    pub out: String,
    /// The conversation.
    pub err: String,
}

impl From<Output> for Said {
    fn from(output: Output) -> Self {
        let text = |bytes| String::from_utf8(bytes).unwrap();
        Self { code: output.status.code(), out: text(output.stdout), err: text(output.stderr) }
    }
}

/// The program with nothing of the caller's environment but the search path.
pub fn program() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_kinfold"));
    command.env_clear().envs(std::env::var_os("PATH").map(|p| ("PATH", p)));
    command.stdin(Stdio::null());
    command
}

/// The program in a folder whose `kinfold.toml`, where there is one, is named: one that is only found
/// there would have to be approved first.
pub fn program_in(folder: &Path) -> Command {
    let mut command = program();
    command.current_dir(folder);
    if folder.join("kinfold.toml").is_file() {
        command.env("KINFOLD_CONFIG", "kinfold.toml");
    }
    command
}

/// Runs the program with some arguments.
pub fn say(args: &[&str]) -> Said {
    program().args(args).output().unwrap().into()
}

impl Bench {
    /// A fresh one.
    pub fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let cabinet = Cabinet::write(folder.path());
        Self { folder, cabinet }
    }

    /// A copy of one that was made already: the same for all tests, made once.
    pub fn done() -> Self {
        static DONE: OnceLock<Said> = OnceLock::new();
        let shared = Path::new(env!("CARGO_TARGET_TMPDIR")).join("kinfold-done");
        let made = DONE.get_or_init(|| {
            let bench = Self::new();
            let said = bench.made(&[]);
            let _ = std::fs::remove_dir_all(&shared);
            copy(bench.folder.path(), &shared);
            said
        });
        assert_eq!(made.code, Some(0), "{made:?}");
        let bench = Self::new();
        copy(&shared, bench.folder.path());
        bench
    }

    /// A path in the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// `kinfold make` of the cabinet, with its own state directory and output folder.
    pub fn make(&self, more: &[&str]) -> Command {
        let mut command = program();
        command.current_dir(self.folder.path()).env("KINFOLD_STATE", self.path("state"));
        command.args(["make", "photo.png", "--mesh", "cabinet.glb", "--condition", "cabinet.json"]);
        command.args(["--out", "out", "--clock", CLOCK]).args(more);
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    /// Runs [`Bench::make`].
    pub fn made(&self, more: &[&str]) -> Said {
        self.make(more).output().unwrap().into()
    }

    /// Everything in the output folder.
    pub fn out(&self) -> BTreeMap<String, Vec<u8>> {
        files(&self.path("out"))
    }

    /// What the trace in the output folder says.
    pub fn trace(&self) -> trace::Reading {
        trace::read(&self.path("out/trace.mcap")).unwrap()
    }

    /// What the trace of a failed run says, by the number of its folder.
    pub fn failed(&self, number: u64) -> trace::Reading {
        trace::read(&self.path(&format!("out.failed/{number}/trace.mcap"))).unwrap()
    }

    /// How often each stage did what, such as `("articulate", "finished") -> 1`.
    pub fn counts(&self) -> BTreeMap<(String, String), u64> {
        let journal = runner::journal::Journal::open_to_read(&self.path("state/run.sqlite"));
        let counts = journal.unwrap().counts().unwrap();
        counts.into_iter().map(|(stage, did, times)| ((stage, did), times)).collect()
    }

    /// How often a stage was committed.
    pub fn finished(&self, stage: &str) -> u64 {
        self.counts().get(&(stage.into(), "finished".into())).copied().unwrap_or_default()
    }
}

/// All files under a folder by relative path.
pub fn files(root: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![root.to_path_buf()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).into_iter().flatten() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(root).unwrap().to_string_lossy().into_owned();
                found.insert(name, std::fs::read(path).unwrap());
            }
        }
    }
    found
}

fn copy(from: &Path, to: &Path) {
    for (name, bytes) in files(from) {
        let path = to.join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
}

/// The names in a map of files.
pub fn names(files: &BTreeMap<String, Vec<u8>>) -> Vec<&str> {
    files.keys().map(String::as_str).collect()
}
