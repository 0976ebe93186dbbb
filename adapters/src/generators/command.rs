//! Any program on this machine that makes a GLB of a picture: the generator with no protocol.

use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use std::sync::Arc;
use std::time::Duration;

use object::glb;

use super::answer::shortened;
use crate::files::{MAX_MESH_BYTES, read_limited};
use crate::net::pace::Pace;
use crate::sent::sent;
use crate::{AdapterError, GeneratedMesh, ImageTo3d, Photo};

/// Pause between two looks at a running program.
const PAUSE: Duration = Duration::from_millis(50);
/// How much of a program's last words is passed on, bytes.
const LAST_WORDS: usize = 2000;

/// A program that is given a picture and leaves a GLB.
///
/// Of its arguments `{image}` is the path of a PNG, `{mesh}` the path where the GLB must be when it
/// ends, `{seed}` the seed. No shell stands between. It must end with status 0.
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
}

impl ImageTo3d for Command {
    fn identity(&self) -> Result<String, AdapterError> {
        Ok(format!("command/1 {} {}", self.program, self.arguments.join(" ")))
    }

    fn generate(&self, photo: &Photo, seed: u64) -> Result<GeneratedMesh, AdapterError> {
        let io = |source| AdapterError::Io { path: self.scratch.display().to_string(), source };
        std::fs::create_dir_all(&self.scratch).map_err(io)?;
        let folder = tempfile::tempdir_in(&self.scratch).map_err(io)?;
        let image = folder.path().join("image.png");
        let mesh = folder.path().join("mesh.glb");
        std::fs::write(&image, sent(photo)?.bytes).map_err(io)?;
        self.run(&image, &mesh, seed)?;
        if !mesh.is_file() {
            return Err(self.failed("it ended well, but left no file where {mesh} said"));
        }
        let file = read_limited(&mesh, MAX_MESH_BYTES)?;
        let path = format!("the mesh made by {}", self.program);
        let mesh = glb::read(&file).map_err(|source| AdapterError::Glb { path, source })?;
        Ok(GeneratedMesh { mesh, file, media_type: "model/gltf-binary".into() })
    }
}

impl Command {
    fn run(&self, image: &Path, mesh: &Path, seed: u64) -> Result<(), AdapterError> {
        let filled = |argument: &String| {
            let argument = argument.replace("{image}", &image.to_string_lossy());
            argument.replace("{mesh}", &mesh.to_string_lossy()).replace("{seed}", &seed.to_string())
        };
        let mut command = std::process::Command::new(&self.program);
        command.args(self.arguments.iter().map(filled));
        // What it says goes to a file: a full pipe would stop it, and stdout is ours.
        let words = mesh.with_extension("log");
        let log = std::fs::File::create(&words).map_err(|e| self.failed(&e.to_string()))?;
        let twin = log.try_clone().map_err(|e| self.failed(&e.to_string()))?;
        command.stdin(Stdio::null()).stdout(log).stderr(twin);
        let child = command.spawn();
        let mut child = child.map_err(|e| self.failed(&format!("cannot be started: {e}")))?;
        self.ended(&mut child, &words)
    }

    fn ended(&self, child: &mut Child, words: &Path) -> Result<(), AdapterError> {
        let start = self.pace.elapsed();
        loop {
            match child.try_wait() {
                Ok(Some(status)) if status.success() => return Ok(()),
                Ok(Some(status)) => {
                    return Err(self.failed(&format!("{status}: {}", last_words(words))));
                }
                Ok(None) => {}
                Err(e) => return Err(self.failed(&e.to_string())),
            }
            if self.pace.elapsed().saturating_sub(start) > self.deadline {
                // It may have ended by itself in between.
                let _ = child.kill();
                let _ = child.wait();
                return Err(self.failed(&format!("not done after {:?}, ended", self.deadline)));
            }
            self.pace.wait(PAUSE);
        }
    }

    fn failed(&self, found: &str) -> AdapterError {
        AdapterError::Program { program: self.program.clone(), found: found.into() }
    }
}

/// The end of what a program said.
fn last_words(path: &Path) -> String {
    let mut bytes = vec![];
    let read = std::fs::File::open(path).map(|f| f.take(1 << 20).read_to_end(&mut bytes));
    if read.is_err() || bytes.is_empty() {
        return "it said nothing".into();
    }
    let tail = &bytes[bytes.len().saturating_sub(LAST_WORDS)..];
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
        assert!(told("echo hello > \"$2\"").contains("GLB: "));
        let mut missing = shell(dir.path(), "");
        missing.program = "no-such-program-anywhere".into();
        let error = missing.generate(&photo, 1).unwrap_err().to_string();
        assert!(error.contains("cannot be started"), "{error}");
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
}
