//! A program killed while a paid job runs asks for that job once, however often it starts again.
#![cfg(unix)]

use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use rand::{RngExt as _, SeedableRng as _};
use serde_json::json;

use crate::cabinet::Cabinet;
use crate::kinfold::{CLOCK, Said, program_in};
use crate::server::{Answer, Asked, Server};

/// A paid service whose one job runs until it is told to be done.
fn service(mesh: Vec<u8>, done: Arc<AtomicBool>) -> Server {
    Server::start(move |asked: &Asked| match (asked.method.as_str(), asked.path.as_str()) {
        ("POST", "/openapi/v1/image-to-3d") => Answer::json(202, &json!({ "result": "job-1" })),
        ("GET", "/openapi/v1/image-to-3d/job-1") if done.load(Ordering::SeqCst) => {
            let host = asked
                .headers
                .iter()
                .find_map(|h| h.to_ascii_lowercase().strip_prefix("host: ").map(String::from));
            let address = format!("http://{}/file.glb?Signature=canary", host.unwrap());
            Answer::json(200, &json!({ "status": "SUCCEEDED", "model_urls": { "glb": address } }))
        }
        ("GET", "/openapi/v1/image-to-3d/job-1") => {
            Answer::json(200, &json!({ "status": "IN_PROGRESS" }))
        }
        ("GET", _) => Answer { status: 200, headers: vec![], body: mesh.clone() },
        _ => Answer::json(404, &json!({})),
    })
}

fn make(folder: &Path) -> Command {
    let mut command = program_in(folder);
    command.env("KINFOLD_STATE", folder.join("state"));
    command.env("MESHY_API_KEY", "some-key-of-ours");
    command.args(["make", "photo.png", "--condition", "cabinet.json", "--out", "out"]);
    command.args(["--clock", CLOCK]).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// Starts a run and kills it some time after its submit arrived; then lets it end.
fn killed_between_submit_and_result(after: Duration) -> (Server, Said) {
    let folder = tempfile::tempdir().unwrap();
    let cabinet = Cabinet::write(folder.path());
    let done = Arc::new(AtomicBool::new(false));
    let server = service(std::fs::read(&cabinet.mesh).unwrap(), Arc::clone(&done));
    let config = format!(
        "[image_to_3d]\nprovider = \"meshy\"\nmodel = \"meshy-6\"\nbase = \"http://127.0.0.1:{}\"\n",
        server.port
    );
    std::fs::write(folder.path().join("kinfold.toml"), config).unwrap();
    let mut child = make(folder.path()).spawn().unwrap();
    let begun = Instant::now();
    while server.count("POST", "/") == 0 && begun.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_micros(200));
    }
    std::thread::sleep(after);
    child.kill().unwrap();
    child.wait().unwrap();
    done.store(true, Ordering::SeqCst);
    (server, make(folder.path()).output().unwrap().into())
}

/// `KINFOLD_KILLS` says how many; 50 takes minutes.
#[test]
fn a_killed_run_asks_for_its_paid_job_once() {
    let kills = std::env::var("KINFOLD_KILLS").ok().and_then(|n| n.parse().ok()).unwrap_or(4);
    let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(4);
    let (mut resumed, mut unknown) = (0, 0);
    for _ in 0..kills {
        // Many at once after the submit, some while the run sleeps between two looks.
        let most = if rng.random() { 4_000 } else { 400_000 };
        let after = Duration::from_micros(rng.random_range(0..most));
        let (server, said) = killed_between_submit_and_result(after);
        assert_eq!(server.count("POST", "/"), 1, "killed after {after:?}: {said:?}");
        match said.code {
            Some(0) => resumed += 1,
            // Killed before the answer was on disk: it says so rather than pay twice.
            _ if said.err.contains("it may have been charged") => unknown += 1,
            _ => panic!("killed after {after:?}: {said:?}"),
        }
    }
    eprintln!("{kills} kills: {resumed} went on, {unknown} said that nobody can know");
}
