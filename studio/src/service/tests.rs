//! The service as a program asks it, without a socket and with one.

use std::collections::BTreeMap;
use std::io::{Read as _, Write as _};
use std::net::TcpStream;
use std::sync::Mutex as Lock;
use std::time::Instant;

use axum::body::{Body, to_bytes};
use axum::http::Request;
use serde_json::{Value, json};
use tower::ServiceExt as _;

use super::*;
use crate::house::Failure;
use crate::http::Token;
use crate::http::room::locked;
use crate::works::{About, Incoming, Job, JobOrder, JobState, Kept, Refused, Submitted, Works};

const TOKEN: &str = "a-token-of-some-length";

/// Works that make nothing and keep what they were asked.
#[derive(Default)]
struct Bench(Lock<BTreeMap<(String, String), Job>>);

struct Sink(Vec<u8>);

impl Incoming for Sink {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<()> {
        self.0.extend_from_slice(bytes);
        Ok(())
    }

    fn keep(self: Box<Self>) -> Result<Kept, Failure> {
        Ok(Kept { digest: blake3::hash(&self.0).to_hex().to_string(), bytes: self.0.len() as u64 })
    }
}

fn job(id: &str, state: JobState) -> Job {
    Job {
        id: id.into(),
        state,
        stage: None,
        done: 0,
        of: 3,
        tier: None,
        class: None,
        reason: None,
        trouble: None,
        confidence: None,
        failed_checks: vec![],
        calls: 0,
        cost: 0.0,
        files: BTreeMap::new(),
    }
}

impl Works for Bench {
    fn about(&self, who: &str) -> Result<About, Failure> {
        Err(Failure::new(format!("{who} asks too much")).with_hint("ask less"))
    }

    fn receive(&self, _: &str) -> Result<Box<dyn Incoming>, Failure> {
        Ok(Box::new(Sink(vec![])))
    }

    fn submit(&self, who: &str, order: JobOrder) -> Result<Submitted, Refused> {
        let id = order.category.unwrap_or_default();
        if id == "too many" {
            return Err(Refused::Full(Failure::new("too many wait")));
        }
        let new = job(&id, JobState::Queued);
        let is_new = locked(&self.0).insert((who.into(), id), new.clone()).is_none();
        Ok(Submitted { job: new, is_new })
    }

    fn job(&self, who: &str, id: &str) -> Result<Option<Job>, Failure> {
        Ok(locked(&self.0).get(&(who.to_owned(), id.to_owned())).cloned())
    }

    fn jobs(&self, who: &str, _: Option<&str>, most: usize) -> Result<Vec<Job>, Failure> {
        let all = locked(&self.0);
        Ok(all.iter().filter(|((of, _), _)| of == who).take(most).map(|(_, j)| j.clone()).collect())
    }

    fn artefact(&self, _: &str, _: &str, digest: &str) -> Result<Option<Vec<u8>>, Failure> {
        Ok((digest == "abc").then(|| b"bytes".to_vec()))
    }
}

fn service(works: Arc<Bench>) -> Service {
    let limits = Limits {
        most_bytes: 1 << 20,
        most_requests: 1e6,
        connections: 3,
        patience: Duration::from_millis(150),
    };
    let tokens = [("ann", TOKEN), ("bob", "another-token-of-some-length")];
    let tokens = tokens.map(|(name, token)| (name.to_owned(), Token::of(token))).to_vec();
    Service { tokens, limits, works, bell: Bell::default() }
}

fn ask(desk: &Desk, method: &str, path: &str, token: &str, body: Vec<u8>) -> (u16, Vec<u8>) {
    let request = Request::builder().method(method).uri(path);
    let request = request.header("authorization", format!("Bearer {token}"));
    let request = request.body(Body::from(body)).unwrap();
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async {
        let response = router(Arc::clone(desk)).oneshot(request).await.unwrap();
        let status = response.status().as_u16();
        (status, to_bytes(response.into_body(), usize::MAX).await.unwrap().to_vec())
    })
}

fn told((status, body): (u16, Vec<u8>)) -> (u16, Value) {
    (status, serde_json::from_slice(&body).unwrap())
}

#[test]
fn whoever_has_no_token_learns_nothing_and_whoever_has_one_sees_his_own_jobs() {
    let desk = desk(service(Arc::default()));
    for (path, _) in routes() {
        for token in ["", "wrong", &TOKEN[1..], &format!("{TOKEN}x")] {
            let (status, told) = told(ask(&desk, "GET", path, token, vec![]));
            assert_eq!(status, 401, "{path}");
            assert_eq!(told["error"]["message"], "the token is missing or wrong");
        }
    }
    let order = json!({ "category": "kettle" }).to_string().into_bytes();
    let submit = || told(ask(&desk, "POST", "/v1/jobs", TOKEN, order.clone()));
    assert_eq!([submit().0, submit().0], [202, 200]);
    let see = |token| told(ask(&desk, "GET", "/v1/jobs/kettle", token, vec![])).0;
    assert_eq!([see(TOKEN), see("another-token-of-some-length")], [200, 404]);
    let (_, list) = told(ask(&desk, "GET", "/v1/jobs?most=9", TOKEN, vec![]));
    assert_eq!(list["jobs"][0]["id"], "kettle");
}

#[test]
fn a_question_that_is_none_is_told_why_and_what_to_do() {
    let desk = desk(service(Arc::default()));
    let long = vec![b'x'; (1 << 20) + 1];
    let cases: [(&str, &str, &[u8], u16, &str); 9] = [
        ("POST", "/v1/jobs", b"{", 400, "EOF while parsing"),
        ("POST", "/v1/jobs", br#"{"path": "/etc/passwd"}"#, 400, "unknown field `path`"),
        ("POST", "/v1/jobs", br#"{"category": "too many"}"#, 429, "too many wait"),
        ("POST", "/v1/files", &long, 413, "at most 1048576 bytes"),
        ("GET", "/v1/jobs?path=x", b"", 400, "found `path=x`"),
        ("GET", "/v1/jobs/x/artefacts/def", b"", 404, "no file of that digest"),
        ("GET", "/v1/about", b"", 422, "ann asks too much"),
        ("GET", "/v1/nothing", b"", 404, "nothing is asked for like that"),
        ("DELETE", "/v1/jobs", b"", 405, "not asked for in this way"),
    ];
    for (method, path, body, wanted, words) in cases {
        let (status, told) = told(ask(&desk, method, path, TOKEN, body.to_vec()));
        let message = told["error"]["message"].as_str().unwrap();
        assert!(status == wanted && message.contains(words), "{method} {path}: {status} {told}");
        if wanted != 429 {
            assert!(told["error"]["hint"].is_string(), "{method} {path}: {told}");
        }
    }
}

#[test]
fn a_file_is_kept_by_its_digest_and_one_goes_out_by_it() {
    let desk = desk(service(Arc::default()));
    let photo = vec![7u8; 1 << 20];
    let (status, kept) = told(ask(&desk, "POST", "/v1/files", TOKEN, photo.clone()));
    assert_eq!((status, &kept["bytes"]), (201, &json!(1 << 20)));
    assert_eq!(kept["digest"], blake3::hash(&photo).to_hex().as_str());
    let out = ask(&desk, "GET", "/v1/jobs/x/artefacts/abc", TOKEN, vec![]);
    assert_eq!(out, (200, b"bytes".to_vec()));
}

#[test]
fn the_document_names_every_path_and_every_reference_leads_somewhere() {
    let document = openapi();
    for (path, _) in routes() {
        assert!(document["paths"][path].is_object(), "{path}");
    }
    assert_eq!(document["paths"].as_object().unwrap().len(), routes().len());
    let text = document.to_string();
    for (at, _) in text.match_indices("\"$ref\":\"#") {
        let path = text[at + 9..].split('"').next().unwrap();
        assert!(document.pointer(path).is_some(), "{path}");
    }
}

/// A service that listens, until the test ends.
fn listening(works: &Arc<Bench>) -> (std::net::SocketAddr, Bell, Stop) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let (service, stop) = (service(Arc::clone(works)), Stop::default());
    let (bell, ended) = (service.bell.clone(), stop.clone());
    std::thread::spawn(move || serve(listener, service, &ended).unwrap());
    (address, bell, stop)
}

fn said(stream: &mut TcpStream) -> String {
    stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
    let mut said = String::new();
    let _ = stream.read_to_string(&mut said);
    said
}

#[test]
fn whoever_sends_too_slowly_is_let_go_and_keeps_nobody_out() {
    let (address, _, stop) = listening(&Arc::default());
    let began = Instant::now();
    // As many as may come at a time: one says nothing, one stops in its head, one in its body.
    let head = format!("POST /v1/files HTTP/1.1\r\nhost: x\r\nauthorization: Bearer {TOKEN}\r\n");
    let body = format!("{head}content-length: 100\r\n\r\nabc");
    let mut slow: Vec<_> = ["", &head, &body]
        .into_iter()
        .map(|words| {
            let mut stream = TcpStream::connect(address).unwrap();
            stream.write_all(words.as_bytes()).unwrap();
            stream
        })
        .collect();
    let mut next = TcpStream::connect(address).unwrap();
    let question = format!(
        "GET /v1/openapi.json HTTP/1.1\r\nhost: x\r\nauthorization: Bearer {TOKEN}\r\nconnection: close\r\n\r\n"
    );
    next.write_all(question.as_bytes()).unwrap();
    assert!(said(&mut next).starts_with("HTTP/1.1 200 OK"));
    let last = said(&mut slow.pop().unwrap());
    assert!(last.starts_with("HTTP/1.1 408") && last.contains("came too slowly"), "{last}");
    assert!(slow.iter_mut().all(|stream| said(stream).is_empty()));
    assert!(began.elapsed() < Duration::from_secs(15), "{:?}", began.elapsed());
    stop.stop();
}

#[test]
fn a_job_is_followed_until_it_is_over() {
    let works: Arc<Bench> = Arc::default();
    let (address, bell, stop) = listening(&works);
    let put = |state| {
        locked(&works.0).insert(("ann".into(), "kettle".into()), job("kettle", state));
        bell.ring("ann", "kettle");
    };
    put(JobState::Queued);
    let mut stream = TcpStream::connect(address).unwrap();
    let question = format!(
        "GET /v1/jobs/kettle/events HTTP/1.1\r\nhost: x\r\nauthorization: Bearer {TOKEN}\r\nconnection: close\r\n\r\n"
    );
    stream.write_all(question.as_bytes()).unwrap();
    std::thread::sleep(Duration::from_millis(700));
    bell.ring("bob", "kettle");
    put(JobState::Running);
    std::thread::sleep(Duration::from_millis(100));
    put(JobState::Accepted);
    let said = said(&mut stream);
    let states =
        ["queued", "running", "accepted"].map(|s| said.find(&format!("\"state\":\"{s}\"")));
    assert!(states.iter().all(Option::is_some) && states.is_sorted(), "{said}");
    assert_eq!(said.matches("event: job").count(), 3, "{said}");
    stop.stop();
}
