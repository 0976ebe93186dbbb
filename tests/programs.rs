//! Programs that we start end with us, however we end, and so does whatever they started.
#![cfg(unix)]

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::batch::Batch;
use crate::cabinet::Cabinet;
use crate::kinfold::{CLOCK, Said, files, program};

/// A folder whose generator is a shell script of that body: `$1` is the mesh to write, `MARK` a folder
/// for the numbers of processes.
struct Shop(tempfile::TempDir);

impl Shop {
    fn open(body: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        Cabinet::write(folder.path());
        std::fs::create_dir(folder.path().join("mark")).unwrap();
        let mark = folder.path().join("mark").display().to_string();
        let mesh = folder.path().join("cabinet.glb").display().to_string();
        let body = body.replace("MARK", &mark).replace("MESH", &mesh);
        let config = format!(
            "[image_to_3d]\nprovider = \"command\"\nprogram = \"sh\"\narguments = [\"-c\", {body:?}, \"sh\", \"{{mesh}}\"]\n"
        );
        std::fs::write(folder.path().join("kinfold.toml"), config).unwrap();
        Self(folder)
    }

    fn make(&self) -> Command {
        let mut command = program();
        command.current_dir(self.0.path()).env("KINFOLD_STATE", self.0.path().join("state"));
        command.args(["make", "photo.png", "--condition", "cabinet.json", "--out", "out"]);
        command.args(["--config", "kinfold.toml", "--clock", CLOCK]);
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    /// Numbers of the processes that told theirs, once so many have.
    fn pids(&self, count: usize) -> Vec<u32> {
        let began = Instant::now();
        loop {
            let told = files(&self.0.path().join("mark"));
            let all: Option<Vec<u32>> =
                told.values().map(|b| String::from_utf8_lossy(b).trim().parse().ok()).collect();
            match all {
                Some(all) if all.len() >= count => return all,
                _ => assert!(began.elapsed() < Duration::from_secs(60), "they never began"),
            }
            std::thread::sleep(Duration::from_millis(10));
        }
    }
}

/// Whether a process is there and no zombie.
pub fn is_alive(pid: u32) -> bool {
    let stat = std::fs::read_to_string(Path::new("/proc").join(pid.to_string()).join("stat"));
    stat.is_ok_and(|s| s.rsplit_once(')').is_some_and(|(_, rest)| !rest.starts_with(" Z")))
}

/// Waits until all of them are gone; a minute is a hang.
pub fn all_gone(pids: &[u32]) {
    let began = Instant::now();
    while pids.iter().any(|pid| is_alive(*pid)) {
        assert!(began.elapsed() < Duration::from_secs(60), "{pids:?} live on");
        std::thread::sleep(Duration::from_millis(10));
    }
}

pub fn signal(name: &str, pid: u32) {
    Command::new("kill").args([&format!("-{name}"), &pid.to_string()]).status().unwrap();
}

/// A program with a child, a grandchild, and one that left the group and the session if it can.
const FAMILY: &str = "echo $$ > MARK/a; sleep 600 & echo $! > MARK/b; \
    sh -c 'sleep 600 & echo $! > MARK/c; wait' & \
    if command -v setsid >/dev/null; then setsid sh -c 'echo $$ > MARK/d; sleep 600' & \
    else echo $$ > MARK/d; fi; wait";

/// The fault as it was reported: the program goes on after a kill.
#[test]
fn a_generator_program_ends_when_kinfold_is_killed() {
    let shop = Shop::open(FAMILY);
    let mut child = shop.make().spawn().unwrap();
    let pids = shop.pids(4);
    assert!(pids.iter().all(|pid| is_alive(*pid)));
    child.kill().unwrap();
    child.wait().unwrap();
    all_gone(&pids);
}

/// Whoever kills every process called kinfold kills the keeper, too, if that is its name.
#[cfg(target_os = "linux")]
#[test]
fn a_keeper_is_not_called_as_the_program_is() {
    let shop = Shop::open(FAMILY);
    let mut child = shop.make().spawn().unwrap();
    let pids = shop.pids(4);
    let stat = |pid: u32| std::fs::read_to_string(format!("/proc/{pid}/stat")).unwrap();
    let keeper: u32 = {
        let own = stat(pids[0]);
        own.rsplit_once(')').unwrap().1.split_whitespace().nth(1).unwrap().parse().unwrap()
    };
    assert_ne!(keeper, child.id());
    let name = |pid: u32| std::fs::read_to_string(format!("/proc/{pid}/comm")).unwrap();
    assert_eq!((name(child.id()).trim(), name(keeper).trim()), ("kinfold", "keeper"));
    child.kill().unwrap();
    child.wait().unwrap();
    all_gone(&pids);
}

/// The fault as it was reported: two Ctrl-C end kinfold and leave the program running.
#[test]
fn a_second_term_or_ctrl_c_ends_the_program_too() {
    for name in ["TERM", "INT"] {
        let shop = Shop::open(FAMILY);
        let child = shop.make().spawn().unwrap();
        let pids = shop.pids(4);
        signal(name, child.id());
        std::thread::sleep(Duration::from_millis(100));
        assert!(pids.iter().all(|pid| is_alive(*pid)), "the first lets what runs finish");
        signal(name, child.id());
        let said: Said = child.wait_with_output().unwrap().into();
        assert_eq!(said.code, Some(130), "{said:?}");
        all_gone(&pids);
    }
}

/// The fault as it was reported: a second start puts a second program beside the first.
#[test]
fn a_start_after_a_kill_never_runs_two_programs_at_once() {
    let body = "n=0; while ! mkdir MARK/alone 2>/dev/null; do echo two > MARK/two; exit 9; done; \
        trap '' TERM; echo $$ > MARK/pid; sleep 0.3; cp MESH \"$1\"; rmdir MARK/alone";
    let shop = Shop::open(body);
    for _ in 0..3 {
        let mut child = shop.make().spawn().unwrap();
        shop.pids(1);
        child.kill().unwrap();
        child.wait().unwrap();
        let pids = shop.pids(1);
        all_gone(&pids);
        std::fs::remove_file(shop.0.path().join("mark/pid")).unwrap();
        let _ = std::fs::remove_dir(shop.0.path().join("mark/alone"));
    }
    let said: Said = shop.make().output().unwrap().into();
    assert_eq!(said.code, Some(0), "{said:?}");
    assert!(!shop.0.path().join("mark/two").exists());
    let left = files(&shop.0.path().join("state/jobs"));
    assert!(left.is_empty(), "the job is done and nothing of it is left: {:?}", left.keys());
}

/// A keeper that still ends its program is waited for by the next one: two at the same work never are.
#[test]
fn two_keepers_of_one_job_take_turns() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("log");
    let lock = folder.path().join("job.lock");
    let body = format!("echo + >> '{0}'; sleep 0.2; echo - >> '{0}'", log.display());
    let keep = || {
        let mut command = program();
        command.arg("keep-program").arg(&lock).args(["sh", "-c", &body]).stdin(Stdio::piped());
        command.spawn().unwrap()
    };
    let mut keepers: Vec<_> = (0..3).map(|_| keep()).collect();
    for keeper in &mut keepers {
        let stdin = keeper.stdin.take();
        assert!(keeper.wait().unwrap().success());
        drop(stdin);
    }
    assert_eq!(std::fs::read_to_string(log).unwrap(), "+\n-\n".repeat(3));
}

#[test]
fn a_program_that_fails_or_is_not_there_is_told_through_its_keeper() {
    for (body, told) in [
        ("echo first; echo out of memory >&2; exit 3", "exit status: 3: out of memory"),
        ("kill -KILL $$", "signal: 9"),
        (
            "yes a flood of words | head -c 3000000; echo; echo the end; exit 4",
            "exit status: 4: the end",
        ),
    ] {
        let shop = Shop::open(body);
        let said: Said = shop.make().output().unwrap().into();
        assert_eq!(said.code, Some(1), "{said:?}");
        assert!(said.err.contains(told), "{told} is not in {}", said.err);
        let state: usize = files(&shop.0.path().join("state")).values().map(Vec::len).sum();
        assert!(state < 1_000_000, "what it said is not kept on disk: {state} bytes");
    }
}

#[test]
fn whatever_a_program_leaves_behind_ends_with_it() {
    let shop = Shop::open("sleep 600 & echo $! > MARK/left; cp MESH \"$1\"");
    let said: Said = shop.make().output().unwrap().into();
    assert_eq!(said.code, Some(0), "{said:?}");
    all_gone(&shop.pids(1));
}

#[test]
fn a_killed_batch_leaves_no_program_behind() {
    let batch = Batch::of(0);
    let mark = batch.path("mark");
    std::fs::create_dir(&mark).unwrap();
    let line = |n: usize| {
        let mut line = Batch::given(&format!("k{n:03}"), n);
        line.as_object_mut().unwrap().remove("mesh");
        format!("{line}\n")
    };
    batch.write("items.jsonl", (0..3).map(line).collect::<String>());
    batch.with_generator(&format!("echo $$ > '{}'/$2; sleep 600", mark.display()));
    let mut child = batch.batch(&["--quiet", "--config", "kinfold.toml"]).spawn().unwrap();
    let began = Instant::now();
    while files(&mark).values().filter(|b| !b.is_empty()).count() < 3 {
        assert!(began.elapsed() < Duration::from_secs(60), "they never began");
        std::thread::sleep(Duration::from_millis(10));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let pids: Vec<u32> =
        files(&mark).values().map(|b| String::from_utf8_lossy(b).trim().parse().unwrap()).collect();
    all_gone(&pids);
}

/// A worker whose asker is not its parent any more ends in the middle of its names.
#[test]
fn a_check_worker_ends_when_whoever_asked_is_no_more() {
    use std::io::Write as _;
    let bench = crate::kinfold::Bench::done();
    let name = serde_json::to_string(bench.path("out/asset.urdf").as_os_str()).unwrap();
    let ask = |asker: u32| {
        let mut command = program();
        command
            .args(["check", "--here", "--json", "--", "-"])
            .env("KINFOLD_ASKED_BY", asker.to_string());
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
        let mut stdin = child.stdin.take().unwrap();
        // It may be gone before it has taken all of them.
        let _ = stdin.write_all(format!("{name}\n").repeat(40).as_bytes());
        drop(stdin);
        let said: Said = child.wait_with_output().unwrap().into();
        said.out.lines().count()
    };
    assert_eq!(ask(std::process::id()), 40, "its parent asked: every name is answered");
    assert!(ask(1_999_999_999) < 40, "somebody else's names are left alone");
}
