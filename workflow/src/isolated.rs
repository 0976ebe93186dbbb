//! One check in a process of its own, so that no file can hang, crash or starve the rest.

use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc;
use std::time::Duration;

use sim_check::{CheckOptions, Outside, Verdict, undecided};

/// How checks are run apart.
pub struct Isolation {
    /// This program.
    pub program: PathBuf,
    /// How long one check may take.
    pub deadline: Duration,
    /// Threads each process may use.
    pub threads: usize,
}

impl Isolation {
    /// The verdict on a URDF. A process that is too slow is stopped, one that dies is said to have
    /// died; everything is unknown then.
    pub fn check(&self, urdf: &Path, options: &CheckOptions) -> Verdict {
        let mut command = Command::new(&self.program);
        command.arg("check").args(arguments(options)).arg("--").arg(urdf);
        command.env("RAYON_NUM_THREADS", self.threads.max(1).to_string());
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null());
        let answer = match command.spawn() {
            Ok(child) => self.answer(child),
            Err(e) => Err(format!("no process could be started to check it: {e}")),
        };
        answer.unwrap_or_else(|reason| undecided(&reason, options))
    }

    fn answer(&self, mut child: Child) -> Result<Verdict, String> {
        let (sender, receiver) = mpsc::channel();
        let stdout = child.stdout.take();
        std::thread::spawn(move || {
            let mut said = Vec::new();
            // What cannot be read is no verdict; nobody may be waiting for it any more.
            let _ = stdout.map(|mut out| out.read_to_end(&mut said));
            let _ = sender.send(said);
        });
        let Ok(said) = receiver.recv_timeout(self.deadline) else {
            // It may have ended this very moment.
            let _ = child.kill();
            let _ = child.wait();
            let seconds = self.deadline.as_secs_f64();
            return Err(format!("the check took longer than {seconds} s and was stopped"));
        };
        let status = child.wait().map_err(|e| e.to_string())?;
        serde_json::from_slice(&said)
            .map_err(|_| format!("the process that checked it broke down ({status})"))
    }
}

/// The options as this program's arguments.
fn arguments(options: &CheckOptions) -> Vec<String> {
    let mut all: Vec<String> = ["--here", "--json", "--tier"].map(String::from).into();
    all.extend([options.up_to.name().into(), "--seed".into(), options.seed.to_string()]);
    if options.outside == Outside::Allowed {
        all.push("--allow-outside".into());
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

    /// The verdict where the program is a shell script instead.
    fn verdict_of(script: &str, milliseconds: u64) -> Verdict {
        use std::os::unix::fs::PermissionsExt as _;
        let folder = tempfile::tempdir().unwrap();
        let program = folder.path().join("program");
        std::fs::write(&program, format!("#!/bin/sh\n{script}\n")).unwrap();
        std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755)).unwrap();
        let deadline = Duration::from_millis(milliseconds);
        let isolation = Isolation { program, deadline, threads: 1 };
        isolation.check(Path::new("x.urdf"), &CheckOptions::default())
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
    fn options_survive_the_way_to_the_other_process() {
        let waivers = [("C1".to_string(), "a = b".to_string())].into();
        let options = CheckOptions { waivers, seed: 7, ..CheckOptions::default() };
        let all = arguments(&options);
        assert_eq!(all[2..], ["--tier", "audited", "--seed", "7", "--waive", "C1=a = b"]);
    }
}
