//! A paid provider on this machine: a chat server and a job service behind a counter, which looks into
//! the account book whenever it is asked for work.
#![cfg(unix)]

use std::collections::{BTreeMap, VecDeque};
use std::io::Write as _;
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use adapters::budget::{Book as _, Entry, FileBook};
use serde_json::{Value, json};
use trace::Digest;

use crate::cabinet::{Cabinet, png};
use crate::kinfold::{CLOCK, Said, files, program};
use crate::providers::{parts, physical, points};
use crate::server::{Asked, read};

/// What becomes of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mood {
    /// It is answered.
    Answers,
    /// It is taken, and the line is dropped.
    HangsUp,
    /// It is answered with this status and nothing else.
    Says(u16),
    /// It is answered, and the answer stops half way.
    Tears,
    /// It is answered with something that breaks the rules.
    Errs,
}

/// A request for work.
#[derive(Clone, Debug)]
pub struct Work {
    /// Such as `points` or `submit`.
    pub what: String,
    /// Digest of what was asked.
    pub asked: Digest,
    /// The account book of whoever asked.
    pub book: PathBuf,
    /// Requests that stood in it when this one came.
    pub booked: usize,
}

/// The provider.
#[derive(Clone)]
pub struct Paid {
    /// Where it listens.
    pub port: u16,
    desk: Arc<Desk>,
}

struct Desk {
    port: u16,
    work: Mutex<Vec<Work>>,
    moods: Mutex<BTreeMap<String, VecDeque<Mood>>>,
    pause: Duration,
    book: Mutex<PathBuf>,
    points: Value,
    mesh: Vec<u8>,
}

impl Paid {
    /// One that takes its time for every answer.
    pub fn open(pause: Duration) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let cabinet = Cabinet::write(folder.path());
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port();
        let desk = Arc::new(Desk {
            port,
            work: Mutex::default(),
            moods: Mutex::default(),
            pause,
            book: Mutex::default(),
            points: points(&cabinet.mesh),
            mesh: std::fs::read(&cabinet.mesh).unwrap(),
        });
        let kept = Arc::clone(&desk);
        std::thread::spawn(move || {
            for stream in listener.incoming().flatten() {
                let desk = Arc::clone(&kept);
                // A client that was killed in mid-sentence is no failure of the server.
                std::thread::spawn(move || desk.talk(&stream));
            }
        });
        Self { port, desk }
    }

    /// What becomes of the next requests of a sort; all later ones are answered.
    pub fn will(&self, what: &str, moods: &[Mood]) {
        let moods = moods.iter().copied().collect();
        self.desk.moods.lock().unwrap().insert(what.to_owned(), moods);
    }

    /// All work it was asked for.
    pub fn work(&self) -> Vec<Work> {
        self.desk.work.lock().unwrap().clone()
    }

    /// How often it was asked for work of a sort.
    pub fn count(&self, what: &str) -> usize {
        self.work().iter().filter(|w| w.what == what).count()
    }

    /// How often it was asked for each part of a condition.
    pub fn counts(&self) -> [usize; 3] {
        ["kinematics", "points", "physical"].map(|what| self.count(what))
    }

    /// Requests that came before they stood in the book it looks into.
    pub fn unbooked(&self) -> usize {
        let (book, work) = (self.desk.book.lock().unwrap().clone(), self.work());
        let ours = work.iter().filter(|work| work.book == book);
        ours.enumerate().filter(|(n, work)| work.booked <= *n).count()
    }

    /// A configuration that asks it for conditions, and for meshes too if `all`.
    pub fn config(&self, all: bool) -> String {
        let base = format!("http://127.0.0.1:{}", self.port);
        let vlm =
            format!("[vlm]\nprovider = \"openai\"\nbase = \"{base}/v1\"\nmodel = \"some-vlm\"\n");
        let mesh = format!(
            "[image_to_3d]\nprovider = \"meshy\"\nmodel = \"meshy-6\"\nbase = \"{base}\"\nkey_env = \"PAID_KEY\"\n"
        );
        if all { mesh + &vlm } else { vlm }
    }
}

/// Requests that stand in a book.
pub fn booked(book: &Path) -> usize {
    let text = std::fs::read_to_string(book).unwrap_or_default();
    text.lines().filter(|l| !l.contains("\"settles\":") && l.contains("\"work\":true")).count()
}

impl Desk {
    fn talk(&self, stream: &TcpStream) -> Option<()> {
        let asked = read(stream)?;
        let body: Value = serde_json::from_slice(&asked.body).unwrap_or_default();
        let schema = body.pointer("/response_format/json_schema/name").and_then(Value::as_str);
        let what = match (asked.method.as_str(), schema) {
            ("POST", Some(schema)) => schema,
            ("POST", None) => "submit",
            _ => return self.looked_at(stream, &asked),
        };
        let book = self.book.lock().unwrap().clone();
        let (what_for, booked) = (what.to_owned(), booked(&book));
        let work = Work { what: what_for, asked: Digest::of(&asked.body), book, booked };
        self.work.lock().unwrap().push(work);
        let mood = self.moods.lock().unwrap().get_mut(what).and_then(VecDeque::pop_front);
        std::thread::sleep(self.pause);
        match mood.unwrap_or(Mood::Answers) {
            Mood::HangsUp => None,
            Mood::Says(status) => said(stream, status, b"{}", 2),
            Mood::Tears => said(stream, 200, b"{\"choices\": [", 4000),
            Mood::Errs => chat(stream, &json!({ "no": "rule is kept" })),
            Mood::Answers => match what {
                "kinematics" => chat(stream, &parts()),
                "points" => chat(stream, &self.points),
                "physical" => chat(stream, &physical()),
                _ => whole(stream, &json!({ "result": "job-1" })),
            },
        }
    }

    /// Looks and downloads cost nothing.
    fn looked_at(&self, stream: &TcpStream, asked: &Asked) -> Option<()> {
        if asked.path == "/mesh.glb" {
            return said(stream, 200, &self.mesh, self.mesh.len());
        }
        let url = format!("http://127.0.0.1:{}/mesh.glb", self.port);
        whole(stream, &json!({ "status": "SUCCEEDED", "model_urls": { "glb": url } }))
    }
}

fn chat(stream: &TcpStream, content: &Value) -> Option<()> {
    let message = json!({ "role": "assistant", "content": content.to_string() });
    let choice = json!({ "finish_reason": "stop", "message": message });
    let usage = json!({ "prompt_tokens": 3000, "completion_tokens": 200 });
    whole(stream, &json!({ "choices": [choice], "usage": usage }))
}

fn whole(stream: &TcpStream, value: &Value) -> Option<()> {
    let body = value.to_string();
    said(stream, 200, body.as_bytes(), body.len())
}

fn said(mut stream: &TcpStream, status: u16, body: &[u8], length: usize) -> Option<()> {
    let head = "content-type: application/json\r\nconnection: close\r\n";
    let head = format!("HTTP/1.1 {status} Something\r\n{head}content-length: {length}\r\n\r\n");
    stream.write_all(head.as_bytes()).ok()?;
    stream.write_all(body).ok()
}

/// A folder in which an asset is made with a paid provider's help.
pub struct Shop {
    folder: tempfile::TempDir,
    /// The provider.
    pub paid: Paid,
}

impl Shop {
    /// One with these further lines in its configuration; the mesh is given unless `all` is asked for.
    pub fn open(paid: Paid, all: bool, more: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        Cabinet::write(folder.path());
        let config = format!("{}{more}", paid.config(all));
        std::fs::write(folder.path().join("kinfold.toml"), config).unwrap();
        let this = Self { folder, paid };
        this.looks_into("state/spent.jsonl");
        this
    }

    /// The provider looks into that book from now on.
    pub fn looks_into(&self, book: &str) {
        *self.paid.desk.book.lock().unwrap() = self.path(book);
    }

    /// A path in the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// `kinfold` in the folder.
    pub fn kinfold(&self, args: &[&str]) -> Command {
        let mut command = program();
        command.current_dir(self.folder.path()).env("KINFOLD_STATE", self.path("state"));
        command.env("PAID_KEY", "canary-key-of-a-stand-in").args(args);
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    /// `kinfold make` of the photo.
    pub fn make(&self, more: &[&str]) -> Command {
        self.make_of("photo.png", more)
    }

    /// `kinfold make` of a photo in the folder.
    pub fn make_of(&self, photo: &str, more: &[&str]) -> Command {
        let mut command = self.kinfold(&["make", photo, "--config", "kinfold.toml"]);
        command.args(["--out", "out", "--clock", CLOCK]).args(more);
        if !std::fs::read_to_string(self.path("kinfold.toml")).unwrap().contains("image_to_3d") {
            command.args(["--mesh", "cabinet.glb"]);
        }
        command
    }

    /// Runs [`Shop::make`].
    pub fn made(&self) -> Said {
        self.make(&[]).output().unwrap().into()
    }

    /// Starts [`Shop::make`] and kills it when the provider was asked for something so often.
    pub fn killed_at(&self, what: &str, times: usize) {
        kill_at(self.make(&["--quiet"]), &self.paid, what, times);
    }

    /// Everything that stands in the account book.
    pub fn book(&self) -> Vec<Entry> {
        FileBook::new(self.path("state/spent.jsonl")).entries().unwrap()
    }

    /// Everything in the output folder.
    pub fn out(&self) -> BTreeMap<String, Vec<u8>> {
        files(&self.path("out"))
    }

    /// A photo like no other, and so another question.
    pub fn photo(&self, n: usize) -> String {
        let name = format!("{n}.png");
        std::fs::write(self.path(&name), png(40 + n as u32, 40)).unwrap();
        name
    }

    /// A manifest of items whose photos differ, and so their questions.
    pub fn with_items(&self, items: usize) {
        let line = |n: usize| {
            let photo = self.photo(n);
            let line = json!({ "id": format!("k{n:03}"), "photo": photo, "mesh": "cabinet.glb" });
            format!("{line}\n")
        };
        let lines: String = (0..items).map(line).collect();
        std::fs::write(self.path("items.jsonl"), lines).unwrap();
        self.looks_into("assets/state/spent.jsonl");
    }

    /// `kinfold batch` of the manifest.
    pub fn batch(&self, more: &[&str]) -> Command {
        let args = ["batch", "items.jsonl", "--config", "kinfold.toml", "--out", "assets"];
        let mut command = self.kinfold(&args);
        command.args(["--clock", CLOCK, "--json"]).args(more);
        command
    }

    /// Runs the batch; its answer.
    pub fn ran(&self, more: &[&str]) -> (Said, Value) {
        let said: Said = self.batch(more).output().unwrap().into();
        let answer = serde_json::from_str(&said.out).unwrap_or_else(|e| panic!("{e}: {said:?}"));
        (said, answer)
    }
}

/// Starts a program and kills it when the provider was asked for something so often, or when it ends.
pub fn kill_at(mut command: Command, paid: &Paid, what: &str, times: usize) {
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    while paid.count(what) < times && child.try_wait().unwrap().is_none() {
        std::thread::sleep(Duration::from_millis(5));
    }
    // It may have ended by itself.
    let _ = child.kill();
    child.wait().unwrap();
}
