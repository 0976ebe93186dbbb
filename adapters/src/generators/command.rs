//! Any program on this machine that makes a GLB of a picture: the generator with no protocol.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use object::mesh::UpAxis;
use trace::Digest;

use super::Ledger;
use super::answer::shortened;
use crate::files::MeshFile;
use crate::keeper::{Keeper, Kept};
use crate::net::pace::Pace;
use crate::overheard::Onlooker;
use crate::sent::sent;
use crate::{AdapterError, GeneratedMesh, ImageTo3d, Photo};

/// Pause between two looks at a running program.
const PAUSE: Duration = Duration::from_millis(50);
/// How much of a program's last words is passed on, bytes.
const LAST_WORDS: usize = 2000;

/// A program that is given a picture and leaves a GLB.
///
/// Of its arguments `{image}` is the path of a PNG, `{mesh}` the path where the GLB must be when it
/// ends, `{seed}` the seed. No shell stands between. It must end with status 0. It ends with us,
/// however we end, and so does whatever it started.
#[derive(Clone)]
pub struct Command {
    /// The program, found as a shell would.
    pub program: String,
    /// Its arguments.
    pub arguments: Vec<String>,
    /// After this it is ended.
    pub deadline: Duration,
    /// Folder for its files while it runs.
    pub scratch: PathBuf,
    /// Who waits.
    pub pace: Arc<dyn Pace>,
    /// What is known of jobs: what it is asked for stands there while it is at work.
    pub ledger: Arc<dyn Ledger>,
    /// This program, which looks after it; see [`Keeper::program`].
    pub keeper: Option<PathBuf>,
    /// Who sees what it says while it runs; none is nobody.
    pub onlooker: Option<Onlooker>,
}

impl ImageTo3d for Command {
    fn identity(&self) -> Result<String, AdapterError> {
        Ok(format!("command/1 {} {}", self.program, self.arguments.join(" ")))
    }

    fn generate(&self, photo: &Photo, seed: u64) -> Result<GeneratedMesh, AdapterError> {
        let words = serde_json::json!([self.identity()?, Digest::of(&photo.bytes), seed]);
        let job = Digest::of(words.to_string().as_bytes());
        // One that stands there was begun by a run that is no more, and ended with it.
        self.ledger.begin(&job)?;
        let made = self.made(&job, photo, seed);
        self.ledger.forget(&job)?;
        made
    }
}

impl Command {
    fn made(&self, job: &Digest, photo: &Photo, seed: u64) -> Result<GeneratedMesh, AdapterError> {
        let io = |source| AdapterError::Io { path: self.scratch.display().to_string(), source };
        std::fs::create_dir_all(&self.scratch).map_err(io)?;
        let folder = tempfile::Builder::new().prefix("command-").tempdir_in(&self.scratch);
        let folder = folder.map_err(io)?;
        let image = folder.path().join("image.png");
        let mesh = folder.path().join("mesh.glb");
        std::fs::write(&image, sent(photo)?.bytes).map_err(io)?;
        let lock = self.ledger.lock(job).unwrap_or_else(|| folder.path().join("lock"));
        self.run(lock, (&image, &mesh), seed)?;
        if !mesh.is_file() {
            return Err(self.failed("it ended well, but left no file where {mesh} said"));
        }
        // Programs write what they write, whatever the name ends in; the path is of no use to anybody.
        let named = format!("the mesh made by {}", self.program);
        MeshFile { path: mesh, up: UpAxis::Y }.read_as(&named)
    }

    fn run(
        &self,
        lock: PathBuf,
        (image, mesh): (&Path, &Path),
        seed: u64,
    ) -> Result<(), AdapterError> {
        let filled = |argument: &String| {
            let argument = argument.replace("{image}", &image.to_string_lossy());
            argument.replace("{mesh}", &mesh.to_string_lossy()).replace("{seed}", &seed.to_string())
        };
        let arguments: Vec<_> = self.arguments.iter().map(filled).collect();
        let keeper = Keeper { program: self.keeper.clone(), lock };
        let started = keeper.start(&self.program, &arguments, self.onlooker.clone());
        let started = started.map_err(|e| self.failed(&format!("it cannot be started: {e}")))?;
        self.ended(started)
    }

    fn ended(&self, mut program: Kept) -> Result<(), AdapterError> {
        let start = self.pace.elapsed();
        loop {
            match program.ended() {
                Ok(Some(status)) if status.success() => {
                    program.be_seen();
                    return Ok(());
                }
                Ok(Some(status)) => {
                    program.be_seen();
                    let words = last_line(&program.last_words());
                    return Err(self.failed(&format!("{status}: {words}")));
                }
                Ok(None) => {}
                Err(e) => return Err(self.failed(&e.to_string())),
            }
            if self.pace.elapsed().saturating_sub(start) > self.deadline {
                program.end();
                return Err(self.failed(&format!("not done after {:?}, ended", self.deadline)));
            }
            self.pace.wait(PAUSE);
        }
    }

    fn failed(&self, found: &str) -> AdapterError {
        AdapterError::Program { program: self.program.clone(), found: found.into() }
    }
}

/// The last line of what a program said.
fn last_line(words: &[u8]) -> String {
    let tail = &words[words.len().saturating_sub(LAST_WORDS)..];
    let text = String::from_utf8_lossy(tail);
    shortened(text.lines().rev().find(|l| !l.trim().is_empty()).unwrap_or("it said nothing"))
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use crate::contract::check_image_to_3d;
    use crate::net::pace::RealPace;
    use crate::photo::tests::png;

    fn shell(scratch: &Path, script: &str) -> Command {
        let arguments = ["-c", script, "sh", "{image}", "{mesh}"].map(String::from).to_vec();
        Command {
            program: "sh".into(),
            arguments,
            deadline: Duration::from_secs(20),
            scratch: scratch.join("scratch"),
            pace: Arc::new(RealPace::default()),
            ledger: Arc::new(super::super::MemoryLedger::default()),
            keeper: None,
            onlooker: None,
        }
    }

    #[test]
    fn a_program_that_leaves_a_mesh_keeps_the_promise_and_no_file_stays_behind() {
        let dir = tempfile::tempdir().unwrap();
        let ready = dir.path().join("ready.glb");
        std::fs::write(&ready, super::super::fake::glb_file()).unwrap();
        let script = format!("test -s \"$1\" && cp '{}' \"$2\"", ready.display());
        let photo = Photo::read(png(32, 32), "p").unwrap();
        let command = shell(dir.path(), &script);
        check_image_to_3d(&command, &photo).unwrap().unwrap();
        assert_eq!(std::fs::read_dir(&command.scratch).unwrap().count(), 0);
    }

    #[test]
    fn a_program_that_fails_is_quoted() {
        let dir = tempfile::tempdir().unwrap();
        let photo = Photo::read(png(32, 32), "p").unwrap();
        let told =
            |script: &str| shell(dir.path(), script).generate(&photo, 1).unwrap_err().to_string();
        let error = told("echo first; echo out of memory >&2; exit 3");
        assert!(error.starts_with("sh: ") && error.ends_with("3: out of memory"), "{error}");
        assert!(told("exit 0").contains("left no file"));
        assert!(told("echo hello > \"$2\"").contains("expected a mesh as GLB, glTF, OBJ"));
        let mut missing = shell(dir.path(), "");
        missing.program = "no-such-program-anywhere".into();
        let error = missing.generate(&photo, 1).unwrap_err().to_string();
        assert!(error.contains("cannot be started"), "{error}");
    }

    #[test]
    fn what_a_program_says_is_seen_while_it_runs_and_what_is_kept_of_it_stays_the_same() {
        let dir = tempfile::tempdir().unwrap();
        let photo = Photo::read(png(32, 32), "p").unwrap();
        let seen = Arc::new(std::sync::Mutex::new(Vec::new()));
        let mut command = shell(dir.path(), "echo loading; echo warm >&2; exit 3");
        let alone = command.generate(&photo, 1).unwrap_err().to_string();
        let kept = Arc::clone(&seen);
        let look = move |who: &str, line: &str| kept.lock().unwrap().push(format!("{who}: {line}"));
        command.onlooker = Some(Arc::new(look));
        assert_eq!(command.generate(&photo, 1).unwrap_err().to_string(), alone);
        assert_eq!(*seen.lock().unwrap(), ["sh: loading", "sh: warm"]);
    }

    #[test]
    fn a_program_that_never_ends_is_ended() {
        let dir = tempfile::tempdir().unwrap();
        let photo = Photo::read(png(32, 32), "p").unwrap();
        let mut command = shell(dir.path(), "exec sleep 60");
        command.deadline = Duration::from_millis(200);
        let error = command.generate(&photo, 1).unwrap_err().to_string();
        assert!(error.contains("not done after 200ms"), "{error}");
    }

    #[test]
    fn what_a_program_started_ends_with_it_and_a_flood_of_words_is_cut() {
        let dir = tempfile::tempdir().unwrap();
        let photo = Photo::read(png(32, 32), "p").unwrap();
        let mark = dir.path().join("pid");
        let script = format!("sleep 600 & echo $! > '{}'; wait", mark.display());
        let mut command = shell(dir.path(), &script);
        command.deadline = Duration::from_millis(700);
        let error = command.generate(&photo, 1).unwrap_err().to_string();
        assert!(error.contains("not done after"), "{error}");
        let pid = std::fs::read_to_string(mark).unwrap();
        let stat = std::fs::read_to_string(format!("/proc/{}/stat", pid.trim()));
        assert!(stat.is_err() || stat.unwrap().contains(") Z"), "its child is gone");
        let flood = "i=0; while [ $i -lt 40000 ]; do echo a line of words; i=$((i+1)); done; echo end; exit 3";
        let error = shell(dir.path(), flood).generate(&photo, 1).unwrap_err().to_string();
        assert!(error.ends_with("3: end"), "{error}");
    }
}
