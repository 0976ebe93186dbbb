//! A key that a service says back, in every form and at every place, stands in nothing that is
//! written or said. What is looked through is decoded by decoders of this file's own.
#![cfg(unix)]

use std::path::Path;

use aho_corasick::AhoCorasick;
use base64::Engine as _;
use base64::engine::general_purpose::{STANDARD, URL_SAFE};
use object::Condition;
use parquet::file::reader::{FileReader as _, SerializedFileReader};
use serde_json::{Value, json};

use crate::cabinet::{Cabinet, png};
use crate::kinfold::{CLOCK, Said, files, program_in};
use crate::server::{Answer, Asked, Server};
use crate::services::{Object, Said as Flags};

const KEY: &str = "sk-CANARY/Zq7+Wm3xKd9=Jt5vRb2hLp8n";
/// So many characters of it in a row give it away.
const PIECE: usize = 12;
/// What stands in answers where the key is to be.
const PLACE: &str = "qPLACEq";

/// A name and how a key is written in that form.
type Form = (&'static str, fn(&str) -> String);

const FORMS: [Form; 23] = [
    ("plain", |key| key.into()),
    ("JSON slash", |key| key.replace('/', "\\/")),
    ("JSON unicode", |key| each(key, |b| format!("\\u{b:04x}"))),
    ("percent", |key| each(key, |b| format!("%{b:02x}"))),
    ("HTML named", |key| key.replace('/', "&sol;").replace('+', "&plus;").replace('=', "&equals;")),
    ("HTML decimal", |key| each(key, |b| format!("&#{b};"))),
    ("HTML hexadecimal", |key| each(key, |b| format!("&#X{b:X};"))),
    ("hex", |key| each(key, |b| format!("{b:02x}"))),
    ("hex upper", |key| each(key, |b| format!("{b:02X}"))),
    ("base32", |key| base32(key.as_bytes())),
    ("base64 in lines", |key| {
        in_lines(&STANDARD.encode(format!("Authorization: Bearer {key} for 3 of us")))
    }),
    ("base32hex", |key| by_fives(key.as_bytes(), b"0123456789ABCDEFGHIJKLMNOPQRSTUV")),
    ("quoted-printable", |key| each(key, |b| format!("={b:02X}"))),
    ("hex of base64", |key| each(&STANDARD.encode(key), |b| format!("{b:02x}"))),
    ("base32 of hex", |key| base32(each(key, |b| format!("{b:02x}")).as_bytes())),
    ("hex reversed", |key| each(key, |b| format!("{b:02x}")).chars().rev().collect()),
    ("base64 reversed", |key| STANDARD.encode(key).chars().rev().collect()),
    ("base64 for addresses", |key| URL_SAFE.encode(key)),
    ("base64 twice", |key| STANDARD.encode(STANDARD.encode(key))),
    ("reversed", |key| key.chars().rev().collect()),
    ("upper", |key| key.to_ascii_uppercase()),
    ("lower", |key| key.to_ascii_lowercase()),
    ("all but the last", |key| key[..key.len() - 1].into()),
];

fn each(key: &str, write: impl Fn(u8) -> String) -> String {
    key.bytes().map(write).collect()
}

fn in_lines(text: &str) -> String {
    let lines = text.as_bytes().chunks(64).map(|l| String::from_utf8_lossy(l).into_owned());
    lines.collect::<Vec<_>>().join("\n")
}

fn base32(bytes: &[u8]) -> String {
    by_fives(bytes, b"ABCDEFGHIJKLMNOPQRSTUVWXYZ234567")
}

fn by_fives(bytes: &[u8], letters: &[u8; 32]) -> String {
    let bits: Vec<u8> = bytes.iter().flat_map(|b| (0..8).rev().map(move |i| b >> i & 1)).collect();
    let letter = |bits: &[u8]| {
        let value = (0..5).fold(0, |v, i| v << 1 | bits.get(i).copied().unwrap_or(0));
        char::from(letters[usize::from(value)])
    };
    bits.chunks(5).map(letter).collect()
}

// ---- looking through what was kept ----------------------------------------------------------

/// Looks for the key in any form.
struct Search(AhoCorasick);

impl Search {
    fn new() -> Self {
        let forward = KEY.to_ascii_lowercase().into_bytes();
        let backward: Vec<u8> = forward.iter().rev().copied().collect();
        // A form that was turned around as a whole is told apart from one that was not.
        let mut pieces: Vec<Vec<u8>> = [forward, backward]
            .iter()
            .flat_map(|key| key.windows(PIECE).map(<[u8]>::to_vec))
            .collect();
        for form in [each(KEY, |b| format!("{b:02x}")), STANDARD.encode(KEY)] {
            let turned: Vec<u8> = form.bytes().rev().collect();
            pieces.extend(turned.windows(2 * PIECE).map(<[u8]>::to_vec));
        }
        Self(AhoCorasick::builder().ascii_case_insensitive(true).build(pieces).unwrap())
    }

    fn says(&self, text: &[u8]) -> bool {
        self.0.is_match(text)
    }

    /// How a text says the key once it is decoded, up to so many times.
    fn found(&self, text: &[u8], depth: usize) -> Option<String> {
        if self.says(text) {
            return Some(String::from_utf8_lossy(&text[..text.len().min(400)]).into_owned());
        }
        if depth == 0 || text.len() > 4 << 20 {
            return None;
        }
        decoded(text).iter().find_map(|text| self.found(text, depth - 1))
    }

    /// Nothing of it stands here.
    fn none_in(&self, place: &str, bytes: &[u8]) {
        // Pictures and meshes are no text; whoever wrote a key into one did not encode it.
        let depth = if std::str::from_utf8(bytes).is_ok() { 3 } else { 1 };
        if let Some(found) = self.found(bytes, depth) {
            panic!("{place} says the key: {found}");
        }
    }

    /// Nor in any file of a folder, as bytes and as what it holds.
    fn none_below(&self, what: &str, folder: &Path) {
        for (name, bytes) in files(folder) {
            let place = format!("{what}: {name}");
            self.none_in(&place, &bytes);
            self.none_in(&place, name.as_bytes());
            if name.ends_with(".mcap") || name.ends_with(".mcap.partial") {
                self.none_in_trace(&place, &bytes);
            } else if bytes.starts_with(b"SQLite format 3") {
                self.none_in_tables(&place, &folder.join(&name));
            } else if bytes.starts_with(b"PAR1") {
                self.none_in_columns(&place, &bytes);
            } else if bytes.starts_with(b"glTF") {
                let end = 20 + u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
                self.none_in(&place, &bytes[20..end]);
            }
        }
    }

    fn none_in_trace(&self, place: &str, bytes: &[u8]) {
        let reading = trace::read_bytes(bytes, place).unwrap();
        self.none_in(place, json!(reading.manifest).to_string().as_bytes());
        reading.calls.iter().for_each(|c| self.none_in(&format!("{place}: a call"), c));
        for kept in &reading.attachments {
            self.none_in(&format!("{place}: {}", kept.name), &kept.bytes);
        }
        self.none_in(place, format!("{:?}", reading.events).as_bytes());
        // Every message of every topic, the log among them, out of its compressed pieces.
        for message in mcap::MessageStream::new(bytes).unwrap() {
            let message = message.unwrap();
            self.none_in(&format!("{place}: {}", message.channel.topic), &message.data);
        }
    }

    fn none_in_tables(&self, place: &str, path: &Path) {
        let base = rusqlite::Connection::open(path).unwrap();
        let mut tables =
            base.prepare("SELECT name FROM sqlite_master WHERE type = 'table'").unwrap();
        let names: Vec<String> =
            tables.query_map([], |row| row.get(0)).unwrap().map(Result::unwrap).collect();
        assert!(!names.is_empty(), "{place}: no tables");
        for name in names {
            let mut rows = base.prepare(&format!("SELECT * FROM \"{name}\"")).unwrap();
            let columns = rows.column_count();
            let mut rows = rows.query([]).unwrap();
            while let Some(row) = rows.next().unwrap() {
                for column in 0..columns {
                    if let Ok(cell) = row.get_ref(column).unwrap().as_bytes() {
                        self.none_in(&format!("{place}: {name}"), cell);
                    }
                }
            }
        }
    }

    fn none_in_columns(&self, place: &str, bytes: &[u8]) {
        let file = tempfile::tempfile().unwrap();
        std::io::Write::write_all(&mut &file, bytes).unwrap();
        let reader = SerializedFileReader::new(file).unwrap();
        let mut rows = 0;
        for row in reader.get_row_iter(None).unwrap() {
            self.none_in(place, row.unwrap().to_string().as_bytes());
            rows += 1;
        }
        assert!(rows > 0, "{place}: no rows");
    }

    fn none_said(&self, what: &str, said: &Said) {
        self.none_in(&format!("{what}: stdout"), said.out.as_bytes());
        self.none_in(&format!("{what}: stderr"), said.err.as_bytes());
    }
}

/// What a text may be decoded to.
fn decoded(text: &[u8]) -> Vec<Vec<u8>> {
    let mut all = vec![];
    if text.iter().any(|b| b"\\%&=".contains(b)) {
        all.push(unescaped(text));
    }
    if text.iter().any(u8::is_ascii_whitespace) {
        all.push(text.iter().filter(|b| !b.is_ascii_whitespace()).copied().collect());
    }
    let of64 = |b: u8| match b {
        b'A'..=b'Z' => Some(b - b'A'),
        b'a'..=b'z' => Some(b - b'a' + 26),
        b'0'..=b'9' => Some(b - b'0' + 52),
        b'+' | b'-' => Some(62),
        b'/' | b'_' => Some(63),
        _ => None,
    };
    let of32 = |b: u8| match b.to_ascii_uppercase() {
        b @ b'A'..=b'Z' => Some(b - b'A'),
        b @ b'2'..=b'7' => Some(b - b'2' + 26),
        _ => None,
    };
    let of16 = |b: u8| char::from(b).to_digit(16).map(|d| d as u8);
    all.extend(by_bits(text, 6, 16, of64));
    all.extend(by_bits(text, 5, 20, of32));
    all.extend(by_bits(text, 5, 20, |b| char::from(b).to_digit(32).map(|d| d as u8)));
    all.extend(by_bits(text, 4, 24, of16));
    all
}

/// Every run of at least so many letters of so many bits, read from each place it may begin at.
fn by_bits(
    text: &[u8],
    width: u32,
    least: usize,
    value: impl Fn(u8) -> Option<u8>,
) -> Vec<Vec<u8>> {
    // What is longer is a picture of ours.
    let runs = text.split(|b| value(*b).is_none()).filter(|r| (least..1 << 16).contains(&r.len()));
    let runs: Vec<&[u8]> = runs.collect();
    if runs.is_empty() {
        return vec![];
    }
    let phases = [(4, 2), (5, 8), (6, 4)].iter().find(|(w, _)| *w == width).unwrap().1;
    let read = |phase: usize| {
        let mut bytes = vec![];
        for run in &runs {
            let (mut held, mut bits) = (0_u64, 0);
            for letter in run.iter().skip(phase) {
                held = held << width | u64::from(value(*letter).unwrap());
                bits += width;
                if bits >= 8 {
                    bits -= 8;
                    bytes.push((held >> bits) as u8);
                }
            }
            bytes.push(0);
        }
        bytes
    };
    (0..phases).map(read).collect()
}

/// Backslashes, percent signs and entities decoded once.
fn unescaped(text: &[u8]) -> Vec<u8> {
    let text = String::from_utf8_lossy(text);
    let (mut rest, mut out) = (&*text, String::new());
    let number = |digits: &str, radix| char::from_u32(u32::from_str_radix(digits, radix).ok()?);
    while let Some(at) = rest.find(['\\', '%', '&', '=']) {
        out.push_str(&rest[..at]);
        rest = &rest[at..];
        let found = if let Some(more) = rest.strip_prefix("\\u") {
            more.get(..4).and_then(|d| number(d, 16)).map(|c| (c, 6))
        } else if let Some(more) = rest.strip_prefix('\\') {
            let next = more.chars().next();
            next.map(|c| (if c == 'n' { '\n' } else { c }, 1 + c.len_utf8()))
        } else if let Some(more) = rest.strip_prefix(['%', '=']) {
            more.get(..2).and_then(|d| number(d, 16)).map(|c| (c, 3))
        } else {
            let name = rest[1..].split(';').next().unwrap();
            let lower = name.to_ascii_lowercase();
            let c = match (lower.strip_prefix("#x"), lower.strip_prefix('#'), name) {
                (Some(digits), ..) => number(digits, 16),
                (_, Some(digits), _) => number(digits, 10),
                (.., "sol") => Some('/'),
                (.., "plus") => Some('+'),
                (.., "equals") => Some('='),
                _ => None,
            };
            c.map(|c| (c, name.len() + 2))
        };
        let (c, length) = found.unwrap_or((rest.chars().next().unwrap(), 1));
        out.push(c);
        rest = &rest[length..];
    }
    out.push_str(rest);
    out.into_bytes()
}

#[test]
fn the_search_finds_every_form() {
    let search = Search::new();
    for (name, form) in FORMS {
        assert!(search.found(format!("so: {}!", form(KEY)).as_bytes(), 3).is_some(), "{name}");
        let quoted = json!({ "a": json!({ "b": form(KEY) }).to_string() }).to_string();
        assert!(search.found(quoted.as_bytes(), 3).is_some(), "{name}, quoted");
    }
    search.none_in("nothing", b"{\"a\": \"sk-CAN\", \"b\": \"an innocent text of some length\"}");
}

// ---- services that say it back ----------------------------------------------------------------

/// Where a service says the key, besides everything that fits beside it.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Says {
    /// In answers that are well: fields, quoted JSON, headers, the model's words, the mesh.
    InGoodAnswers,
    /// In why a job failed.
    InTheJobsStatus,
    /// In an error in JSON.
    InAnError,
    /// On a page of HTML, and in plain text.
    OnAPage,
    /// In the address it sends on to.
    InARedirect,
}

/// Both services, and the key as they write it.
struct Echo {
    object: Object,
    says: Says,
    form: String,
}

impl Echo {
    /// Answers, with the form wherever [`PLACE`] stands in JSON as it is written there.
    fn answer(&self, asked: &Asked) -> Answer {
        let mut answer = self.of(asked);
        if let Ok(text) = String::from_utf8(answer.body.clone()) {
            answer.body = text.replace(PLACE, &self.form.replace('\n', "\\n")).into_bytes();
        }
        let header = self.form.replace('\n', " ");
        answer.headers.push(("x-request-id".into(), header.clone()));
        answer.headers.push(("x-ratelimit-limit-requests".into(), header));
        answer
    }

    fn of(&self, asked: &Asked) -> Answer {
        let chat = asked.path.starts_with("/v1/");
        let told = format!("no such key as {PLACE}");
        match (self.says, asked.method.as_str()) {
            (Says::InAnError, _) => Answer::json(401, &json!({ "error": { "message": told } })),
            (Says::OnAPage, _) => {
                let media = if chat { "text/plain" } else { "text/html" };
                let headers = vec![("content-type".into(), media.into())];
                let body = format!("<p>\n{}\n</p>", self.form).into_bytes();
                Answer { status: 403, headers, body }
            }
            (Says::InARedirect, _) => {
                let form = self.form.replace('\n', "%0A");
                let headers = vec![("location".into(), format!("https://{PLACE}.example/{form}"))];
                Answer { headers, ..Answer::json(302, &json!({ "moved": told })) }
            }
            _ if chat => with_fields(self.object.answer(asked)),
            (_, "POST") => Answer::json(200, &json!({ "result": "job-1", "for": told })),
            _ if asked.path.starts_with("/file.glb") => self.mesh(),
            (Says::InTheJobsStatus, _) => {
                let error = json!({ "message": told });
                Answer::json(200, &json!({ "status": "FAILED", "task_error": error }))
            }
            _ => {
                let host = asked
                    .headers
                    .iter()
                    .find_map(|h| h.to_ascii_lowercase().strip_prefix("host: ").map(String::from));
                let address = format!("http://{}/file.glb?Signature=abc", host.unwrap());
                let urls = json!({ "glb": address });
                with_fields(Answer::json(
                    200,
                    &json!({ "status": "SUCCEEDED", "model_urls": urls }),
                ))
            }
        }
    }

    /// The mesh with the form in its JSON and, as bytes, behind its triangles.
    fn mesh(&self) -> Answer {
        let glb = &self.object.mesh;
        let word = |at: usize| u32::from_le_bytes(glb[at..at + 4].try_into().unwrap()) as usize;
        let end = 20 + word(12);
        let mut value: Value = serde_json::from_slice(&glb[20..end]).unwrap();
        value["asset"]["generator"] = PLACE.into();
        value["asset"]["extras"] = json!({ "told": self.form });
        let mut json = value.to_string().replace(PLACE, &self.form.replace('\n', "\\n"));
        json.push_str(&"   "[..json.len().wrapping_neg() % 4]);
        let length = |n: usize| (n as u32).to_le_bytes();
        let all = 20 + json.len() + glb.len() - end;
        let body = [b"glTF\x02\0\0\0", &length(all)[..], &length(json.len()), b"JSON"];
        let body = [&body.concat(), json.as_bytes(), &glb[end..]].concat();
        Answer { status: 200, headers: vec![], body }
    }
}

/// More fields beside those that are read: a text, and JSON in a text.
fn with_fields(answer: Answer) -> Answer {
    let mut value: Value = serde_json::from_slice(&answer.body).unwrap();
    value["echo"] = PLACE.into();
    value["quoted"] = json!({ "authorization": format!("Bearer {PLACE}") }).to_string().into();
    value[PLACE] = json!([1, PLACE]);
    Answer { body: value.to_string().into_bytes(), ..answer }
}

/// A cabinet whose model says the key in everything that it may say freely.
fn talkative(cabinet: &Cabinet) -> Object {
    let text = std::fs::read_to_string(&cabinet.condition).unwrap();
    let mut object = Object::of(&cabinet.mesh, &Condition::from_json(&text).unwrap());
    object.parts["category"] = format!("cabinet {PLACE}").into();
    object.parts["description"] = format!("a cabinet {PLACE}").into();
    object.parts["parts"][0]["text"] = format!("body {PLACE}").into();
    object.parts["parts"][1]["text"] = format!("door {PLACE}").into();
    object.parts["parts"][1]["name"] = format!("door_{PLACE}").into();
    object.physical["scale"]["basis"] = PLACE.into();
    let flag = json!({ "part_id": "p1", "fault": "axis", "reason": format!("see {PLACE}") });
    object.flags = Flags::Answer(json!({ "flags": [flag] }));
    object
}

fn config(port: u16) -> String {
    format!(
        "[image_to_3d]\nprovider = \"meshy\"\nmodel = \"meshy-6\"\nbase = \"http://127.0.0.1:{port}\"\n\
         [vlm]\nprovider = \"openai\"\nmodel = \"some-vlm\"\ncritic = true\nkey_env = \"VLM_KEY\"\n\
         base = \"http://127.0.0.1:{port}/v1\"\n"
    )
}

/// A folder with a photo and a server that says a form of the key there.
fn bench(says: Says, form: &Form) -> (tempfile::TempDir, Server) {
    let folder = tempfile::tempdir().unwrap();
    let cabinet = Cabinet::write(folder.path());
    let echo = Echo { object: talkative(&cabinet), says, form: form.1(KEY) };
    let server = Server::start(move |asked| echo.answer(asked));
    std::fs::write(folder.path().join("kinfold.toml"), config(server.port)).unwrap();
    (folder, server)
}

fn run(folder: &Path, args: &[&str]) -> Said {
    let mut command = program_in(folder);
    command.env("KINFOLD_STATE", "state").env("VLM_KEY", KEY).env("MESHY_API_KEY", KEY);
    command.args(args).output().unwrap().into()
}

fn make(folder: &Path) -> Said {
    run(folder, &["make", "photo.png", "--out", "out", "--clock", CLOCK, "--json"])
}

/// Fault: the key stood in plain in the error, in `--json`, in the database and in the trace.
#[test]
fn a_key_that_comes_back_in_json_escapes_stands_in_no_error() {
    let search = Search::new();
    for form in &FORMS[1..3] {
        let (folder, server) = bench(Says::InAnError, form);
        let said = make(folder.path());
        assert_eq!(said.code, Some(1), "{said:?}");
        assert!(said.err.contains("no such key as hidden"), "{said:?}");
        assert!(server.asked().iter().any(|a| a.headers.iter().any(|h| h.contains(KEY))));
        search.none_said(form.0, &said);
        search.none_below(form.0, folder.path());
    }
}

/// One asset: every form at every place, and everything that is left behind.
#[test]
fn no_form_of_a_key_at_any_place_stands_in_anything_that_is_kept_or_said() {
    let search = Search::new();
    let places = [
        Says::InGoodAnswers,
        Says::InTheJobsStatus,
        Says::InAnError,
        Says::OnAPage,
        Says::InARedirect,
    ];
    for (says, form) in places.iter().flat_map(|says| FORMS.iter().map(move |form| (*says, form))) {
        let what = format!("{says:?}, {}", form.0);
        let (folder, server) = bench(says, form);
        let said = make(folder.path());
        let expected = if says == Says::InGoodAnswers { 0 } else { 1 };
        assert_eq!(said.code, Some(expected), "{what}: {said:?}");
        assert!(server.asked().iter().any(|a| a.headers.iter().any(|h| h.contains(KEY))));
        search.none_said(&what, &said);
        search.none_below(&what, folder.path());
        if says == Says::InAnError {
            search.none_said(&what, &run(folder.path(), &["doctor", "--json"]));
        }
    }
}

/// A batch: ledger, index, reasons, report.
#[test]
fn no_form_of_a_key_stands_in_anything_that_a_batch_leaves() {
    let search = Search::new();
    let folder = tempfile::tempdir().unwrap();
    let cabinet = Cabinet::write(folder.path());
    let object = talkative(&cabinet);
    let next = std::sync::atomic::AtomicUsize::new(0);
    // Each request meets another form; every third job fails, and every fifth question.
    let server = Server::start(move |asked| {
        let n = next.fetch_add(1, std::sync::atomic::Ordering::SeqCst);
        let says = match (asked.path.starts_with("/v1/"), n % 3, n % 5) {
            (false, 0, _) if asked.method == "GET" => Says::InTheJobsStatus,
            (true, _, 0) => Says::InAnError,
            _ => Says::InGoodAnswers,
        };
        Echo { object: object.clone(), says, form: FORMS[n % FORMS.len()].1(KEY) }.answer(asked)
    });
    std::fs::write(folder.path().join("kinfold.toml"), config(server.port)).unwrap();
    let items = FORMS.iter().enumerate().map(|(n, _)| {
        std::fs::write(folder.path().join(format!("{n}.png")), png(40 + n as u32, 40)).unwrap();
        format!("{}\n", json!({ "id": format!("k{n:02}"), "photo": format!("{n}.png") }))
    });
    std::fs::write(folder.path().join("items.jsonl"), items.collect::<String>()).unwrap();
    let said = run(folder.path(), &["batch", "items.jsonl", "--out", "out", "--json"]);
    assert_eq!(said.code, Some(3), "{said:?}");
    let answer: Value = serde_json::from_str(&said.out).unwrap();
    assert!(
        answer["accepted"].as_u64() > Some(0) && answer["failed"].as_u64() > Some(0),
        "{answer}"
    );
    search.none_said("batch", &said);
    search.none_said("report", &run(folder.path(), &["batch", "report", "out"]));
    let sql = "SELECT * FROM items";
    search.none_said("query", &run(folder.path(), &["audit", "query", "out", sql]));
    search.none_below("batch", folder.path());
}
