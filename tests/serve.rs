//! `kinfold serve` as programs use it: the real server, real connections, and kills in between.
#![cfg(unix)]

use std::collections::BTreeSet;
use std::io::{self, BufRead as _, BufReader, Read as _, Write as _};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use rusqlite::Connection;
use serde_json::{Value, json};
use trace::Digest;

use crate::cabinet::{self, Cabinet};
use crate::kinfold::{Said, program};
use crate::server::{Answer, Asked, Server};

/// A service that runs.
struct Service {
    child: Child,
    port: u16,
    token: String,
}

impl Service {
    /// Starts one in a folder, on this port; 0 is any.
    fn start(folder: &Path, port: u16, words: &[&str], set: &[(&str, &str)]) -> Self {
        let mut command = program();
        command.current_dir(folder).args(["serve", "jobs", "--json", "--quiet"]).args(words);
        command.args(["--port", &port.to_string()]).envs(set.iter().copied());
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.as_mut().unwrap()).read_line(&mut line).unwrap();
        let told: Value = serde_json::from_str(&line).unwrap_or_else(|e| {
            let said = Said::from(child.wait_with_output_of_killed());
            panic!("{e}: {line} {said:?}")
        });
        let port = told["url"].as_str().unwrap().rsplit(':').next().unwrap().parse().unwrap();
        let token = told["token"].as_str().unwrap_or_default().to_owned();
        Self { child, port, token }
    }

    /// As an angry person ends it.
    fn kill(mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }

    fn line(&self) -> Line {
        Line { port: self.port, token: self.token.clone(), stream: None }
    }
}

impl Drop for Service {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

trait Killed {
    fn wait_with_output_of_killed(&mut self) -> std::process::Output;
}

impl Killed for Child {
    fn wait_with_output_of_killed(&mut self) -> std::process::Output {
        let _ = self.kill();
        let mut output =
            std::process::Output { status: self.wait().unwrap(), stdout: vec![], stderr: vec![] };
        let _ = self.stderr.as_mut().unwrap().read_to_end(&mut output.stderr);
        output
    }
}

/// A connection that is kept, and made anew where it was cut.
struct Line {
    port: u16,
    token: String,
    stream: Option<BufReader<TcpStream>>,
}

impl Line {
    /// Asks until somebody answers.
    fn ask(&mut self, method: &str, path: &str, body: &[u8]) -> (u16, Vec<u8>) {
        let begun = Instant::now();
        loop {
            match self.once(method, path, body) {
                Ok(answer) => return answer,
                Err(error) => {
                    self.stream = None;
                    assert!(begun.elapsed() < Duration::from_secs(120), "{method} {path}: {error}");
                    std::thread::sleep(Duration::from_millis(20));
                }
            }
        }
    }

    fn told(&mut self, method: &str, path: &str, body: &[u8]) -> (u16, Value) {
        let (status, body) = self.ask(method, path, body);
        let told = serde_json::from_slice(&body);
        (status, told.unwrap_or_else(|e| panic!("{e}: {}", String::from_utf8_lossy(&body))))
    }

    fn once(&mut self, method: &str, path: &str, body: &[u8]) -> io::Result<(u16, Vec<u8>)> {
        let Self { port, token, stream } = self;
        if stream.is_none() {
            let new = TcpStream::connect(("127.0.0.1", *port))?;
            new.set_read_timeout(Some(Duration::from_secs(60)))?;
            *stream = Some(BufReader::new(new));
        }
        let Some(stream) = stream else { return Err(io::ErrorKind::NotConnected.into()) };
        let head = format!(
            "{method} {path} HTTP/1.1\r\nHost: 127.0.0.1\r\nAuthorization: Bearer {token}\r\n\
             Content-Length: {}\r\n\r\n",
            body.len()
        );
        stream.get_mut().write_all(head.as_bytes())?;
        stream.get_mut().write_all(body)?;
        let (mut status, mut length) = (None, 0);
        loop {
            let mut line = String::new();
            if stream.read_line(&mut line)? == 0 {
                return Err(io::ErrorKind::UnexpectedEof.into());
            }
            let line = line.trim_end();
            if line.is_empty() {
                break;
            }
            status = status.or_else(|| line.split(' ').nth(1).and_then(|s| s.parse().ok()));
            let lower = line.to_ascii_lowercase();
            if let Some(said) = lower.strip_prefix("content-length: ") {
                length = said.parse().unwrap();
            }
        }
        let mut answer = vec![0; length];
        stream.read_exact(&mut answer)?;
        Ok((status.unwrap(), answer))
    }

    fn send(&mut self, bytes: &[u8]) -> String {
        let (status, kept) = self.told("POST", "/v1/files", bytes);
        assert_eq!(status, 201, "{kept}");
        kept["digest"].as_str().unwrap().to_owned()
    }

    /// Waits until a job is over, or something else holds of it.
    fn waited(&mut self, id: &str, enough: impl Fn(&Value) -> bool) -> Value {
        let begun = Instant::now();
        loop {
            let (status, job) = self.told("GET", &format!("/v1/jobs/{id}"), b"");
            assert_eq!(status, 200, "{job}");
            if enough(&job) {
                return job;
            }
            assert!(begun.elapsed() < Duration::from_secs(300), "{job}");
            std::thread::sleep(Duration::from_millis(50));
        }
    }
}

fn is_over(job: &Value) -> bool {
    ["accepted", "rejected", "failed"].iter().any(|state| job["state"] == *state)
}

/// Four jobs: the cabinet, with four seeds.
const JOBS: u64 = 4;
/// Requests, and connections.
const REQUESTS: usize = 200;
const LINES: usize = 8;

#[test]
fn two_hundred_requests_over_eight_connections_and_kills_lose_nothing_and_repeat_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let files = Cabinet::write(folder.path());
    let words = ["--max-rate", "100000"];
    let first = Service::start(folder.path(), 0, &words, &[]);
    let (port, token) = (first.port, first.token.clone());
    let [photo, mesh] = [&files.photo, &files.mesh].map(|path| std::fs::read(path).unwrap());
    let answered = AtomicUsize::new(0);
    let ids = std::thread::scope(|scope| {
        let lines: Vec<_> = (0..LINES)
            .map(|_| {
                let mut line = first.line();
                let (photo, mesh, answered) = (&photo, &mesh, &answered);
                scope.spawn(move || requests(&mut line, (photo, mesh), answered))
            })
            .collect();
        let mut service = Some(first);
        for after in [REQUESTS / 5, REQUESTS / 2, REQUESTS * 3 / 4] {
            while answered.load(Ordering::SeqCst) < after {
                std::thread::sleep(Duration::from_millis(1));
            }
            service.take().unwrap().kill();
            service = Some(Service::start(folder.path(), port, &words, &[]));
            assert_eq!(service.as_ref().unwrap().token, token, "the token outlives the server");
        }
        let ids: BTreeSet<_> = lines.into_iter().flat_map(|l| l.join().unwrap()).collect();
        let service = service.unwrap();
        is_made_once(&service, &ids);
        ids
    });
    assert!(answered.load(Ordering::SeqCst) >= REQUESTS);
    assert_eq!(ids.len() as u64, JOBS, "the same question is the same job");

    // Whoever counts in the ledger finds each once.
    let jobs = folder.path().join("jobs");
    let ledger = Connection::open(jobs.join("ledger.sqlite")).unwrap();
    let count = |sql: &str| ledger.query_row(sql, [], |r| r.get::<_, i64>(0)).unwrap();
    assert_eq!(count("SELECT count(*) FROM planned"), JOBS as i64);
    assert_eq!(count("SELECT count(*) FROM outcomes"), JOBS as i64);
    assert_eq!(count("SELECT count(DISTINCT id) FROM outcomes WHERE final"), JOBS as i64);
    assert!(count("SELECT count(*) FROM runs") >= 4, "it was started again and again");
    drop(ledger);
    let said: Said = program().arg("audit").arg(&jobs).output().unwrap().into();
    assert_eq!(said.code, Some(0), "{said:?}");
    let left = std::fs::read_dir(jobs.join("unfinished")).unwrap().count();
    assert_eq!(left, 0, "nothing half made is left");
}

/// Its share of the requests over one connection; the ids of the jobs that it asked for.
fn requests(line: &mut Line, (photo, mesh): (&[u8], &[u8]), answered: &AtomicUsize) -> Vec<String> {
    let count = || answered.fetch_add(1, Ordering::SeqCst);
    let digests = [photo, mesh].map(|bytes| line.send(bytes));
    answered.fetch_add(digests.len(), Ordering::SeqCst);
    let [photo, mesh] = digests;
    let mut ids = Vec::new();
    for seed in 0..JOBS {
        let order = json!({
            "photo": photo, "mesh": { "digest": mesh }, "condition": cabinet::condition(),
            "seed": seed,
        });
        let (status, job) = line.told("POST", "/v1/jobs", order.to_string().as_bytes());
        assert!([200, 202].contains(&status), "{job}");
        ids.push(job["id"].as_str().unwrap().to_owned());
        count();
    }
    for n in 0..REQUESTS / LINES - 2 - JOBS as usize {
        let (status, job) = line.told("GET", &format!("/v1/jobs/{}", ids[n % ids.len()]), b"");
        assert_eq!((status, &job["id"]), (200, &json!(ids[n % ids.len()])), "{job}");
        count();
        std::thread::sleep(Duration::from_millis(20));
    }
    ids
}

/// Every job is accepted, and its files are those that it names.
fn is_made_once(service: &Service, ids: &BTreeSet<String>) {
    let mut line = service.line();
    for id in ids {
        let job = line.waited(id, is_over);
        assert_eq!(job["state"], "accepted", "{job}");
        let files = job["files"].as_object().unwrap();
        assert!(files.contains_key("asset.urdf") && files.contains_key("trace.mcap"), "{job}");
        for (name, digest) in files {
            let digest = digest.as_str().unwrap();
            let (status, bytes) =
                line.ask("GET", &format!("/v1/jobs/{id}/artefacts/{digest}"), b"");
            assert_eq!((status, Digest::of(&bytes).as_str()), (200, digest), "{name}");
        }
    }
    let (_, list) = line.told("GET", "/v1/jobs", b"");
    assert_eq!(list["jobs"].as_array().unwrap().len(), ids.len());
    let (_, about) = line.told("GET", "/v1/about", b"");
    assert_eq!(about["waiting"], 0, "{about}");
}

#[test]
fn a_wrong_token_too_much_and_too_slow_are_refused_and_no_path_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let words = ["--max-upload", "1", "--patience", "1"];
    let service = Service::start(folder.path(), 0, &words, &[]);
    let mut line = service.line();
    let mut stranger = Line { token: "x".repeat(32), ..service.line() };
    let (status, told) = stranger.told("GET", "/v1/about", b"");
    assert_eq!((status, &told["error"]["message"]), (401, &json!("the token is missing or wrong")));
    let mut long = TcpStream::connect(("127.0.0.1", service.port)).unwrap();
    let head = format!(
        "POST /v1/files HTTP/1.1\r\nHost: x\r\nAuthorization: Bearer {}\r\n",
        service.token
    );
    write!(long, "{head}Content-Length: 1048577\r\n\r\n").unwrap();
    let said = answer(&mut long);
    assert!(said.starts_with("HTTP/1.1 413") && said.contains("at most 1048576 bytes"), "{said}");
    let mut slow = TcpStream::connect(("127.0.0.1", service.port)).unwrap();
    write!(slow, "{head}Content-Length: 1000\r\n\r\nabc").unwrap();
    let said = answer(&mut slow);
    assert!(said.starts_with("HTTP/1.1 408") && said.contains("too slowly"), "{said}");

    // What is no photo fails, and says so without a folder of the service.
    let digest = line.send(b"no photo");
    let mesh = line.send(b"no mesh");
    let order =
        json!({ "photo": digest, "mesh": { "digest": mesh }, "condition": cabinet::condition() });
    let (_, job) = line.told("POST", "/v1/jobs", order.to_string().as_bytes());
    let job = line.waited(job["id"].as_str().unwrap(), is_over);
    let reason = job["reason"].as_str().unwrap();
    assert!(job["state"] == "failed" && job["class"] == "input", "{job}");
    assert!(reason.starts_with("file: ") && !reason.contains("inputs"), "{reason}");
    let wrong = [
        (json!({ "photo": "a".repeat(64) }), "nobody makes a mesh here"),
        (
            json!({ "photo": "/etc/passwd", "mesh": { "digest": mesh }, "condition": {} }),
            "/etc/passwd",
        ),
        (
            json!({ "photo": digest, "mesh": { "digest": mesh }, "condition": {} }),
            "`parts` is missing",
        ),
        (json!({ "mesh": { "digest": mesh } }), "a photo, or a mesh and a condition"),
    ];
    for (order, words) in wrong {
        let (status, told) = line.told("POST", "/v1/jobs", order.to_string().as_bytes());
        let said = told.to_string();
        assert!(status == 422 && said.contains(words), "{order}: {status} {said}");
    }
    // Another one in the same folder would be a second hand in one ledger.
    let mut second = program();
    second.current_dir(folder.path()).args(["serve", "jobs", "--port", "0", "--no-wait"]);
    let said: Said = second.output().unwrap().into();
    assert_eq!(said.code, Some(1), "{said:?}");
    assert!(said.err.contains("in use by process"), "{said:?}");
}

/// What is said on a connection, as far as it comes.
fn answer(stream: &mut TcpStream) -> String {
    stream.set_read_timeout(Some(Duration::from_secs(30))).unwrap();
    let (mut said, mut some) = (Vec::new(), [0; 4096]);
    while !String::from_utf8_lossy(&said).contains("hint") {
        match stream.read(&mut some) {
            Ok(0) | Err(_) => break,
            Ok(n) => said.extend_from_slice(&some[..n]),
        }
    }
    String::from_utf8_lossy(&said).into_owned()
}

#[test]
fn a_token_that_spent_its_budget_waits_and_leaves_another_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let files = Cabinet::write(folder.path());
    let mesh = std::fs::read(&files.mesh).unwrap();
    let provider =
        Server::start(move |asked: &Asked| match (asked.method.as_str(), asked.path.as_str()) {
            ("POST", "/openapi/v1/image-to-3d") => Answer::json(202, &json!({ "result": "job-1" })),
            ("GET", path) if path.starts_with("/openapi/v1/image-to-3d/") => {
                let host = asked
                    .headers
                    .iter()
                    .find_map(|h| h.to_ascii_lowercase().strip_prefix("host: ").map(String::from));
                let glb = format!("http://{}/file.glb", host.unwrap());
                Answer::json(200, &json!({ "status": "SUCCEEDED", "model_urls": { "glb": glb } }))
            }
            ("GET", _) => Answer { status: 200, headers: vec![], body: mesh.clone() },
            _ => Answer::json(404, &json!({})),
        });
    let config = format!(
        "[image_to_3d]\nprovider = \"meshy\"\nmodel = \"meshy-6\"\nbase = \"http://127.0.0.1:{}\"\n",
        provider.port
    );
    std::fs::write(folder.path().join("kinfold.toml"), config).unwrap();
    let tokens = "[tokens.ann]\nenv = \"ANN\"\nmax_calls = 1\n\n[tokens.bob]\nenv = \"BOB\"\n";
    std::fs::write(folder.path().join("tokens.toml"), tokens).unwrap();
    let words = ["--tokens", "tokens.toml", "--config", "kinfold.toml"];
    let (ann, bob) = ("ann-says-this-and-no-more", "bob-says-something-else");
    let set = [("ANN", ann), ("BOB", bob), ("MESHY_API_KEY", "some-key-of-ours")];
    let service = Service::start(folder.path(), 0, &words, &set);
    assert_eq!(service.token, "", "what somebody chose is not printed");
    let photo = std::fs::read(&files.photo).unwrap();
    let submit = |token: &str, seed: u64| {
        let mut line = Line { token: token.into(), ..service.line() };
        let photo = line.send(&photo);
        let order = json!({ "photo": photo, "condition": cabinet::condition(), "seed": seed });
        let (status, job) = line.told("POST", "/v1/jobs", order.to_string().as_bytes());
        assert_eq!(status, 202, "{job}");
        (line, job["id"].as_str().unwrap().to_owned())
    };
    let (mut line, id) = submit(ann, 1);
    let job = line.waited(&id, is_over);
    assert_eq!((&job["state"], &job["calls"]), (&json!("accepted"), &json!(1)), "{job}");
    let (_, id) = submit(ann, 2);
    // It is tried a few times.
    let job = line.waited(&id, |job| job["trouble"].is_string() && job["state"] == "queued");
    assert_eq!((&job["state"], &job["class"]), (&json!("queued"), &json!("budget")), "{job}");
    assert!(job["trouble"].as_str().unwrap().contains("the token's budget of 1 requests"), "{job}");
    let (mut other, id) = submit(bob, 3);
    let job = other.waited(&id, is_over);
    assert_eq!(job["state"], "accepted", "{job}");
    let (_, about) = line.told("GET", "/v1/about", b"");
    assert_eq!(about["budget"]["calls"], 1, "{about}");
    assert_eq!(provider.count("POST", "/"), 2, "nothing was sent for the job that waits");
    let (status, _) = other.told("GET", &format!("/v1/jobs/{id}"), b"");
    let (others, _) = line.told("GET", &format!("/v1/jobs/{id}"), b"");
    assert_eq!((status, others), (200, 404), "a job is its token's");
}
