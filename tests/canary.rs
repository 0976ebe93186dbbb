//! Secrets stay at home: servers that say everything back find no place that keeps it.
#![cfg(unix)]

use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::{STANDARD, URL_SAFE};
use object::Condition;
use serde_json::{Value, json};

use crate::cabinet::Cabinet;
use crate::kinfold::{CLOCK, Said, files, program_in};
use crate::server::{Answer, Asked, Server};
use crate::services::Object;

const KEY: &str = "sk-canary+key/0001 of ours";
const PASSWORD: &str = "canary-password-0002";
const TOKEN: &str = "canary-token-0003";
const SIGNATURE: &str = "canary-signature-0004";
const DOOR: &str = "canary-door-0005";
const PLACE: &str = "canary-gps-0006";

const ALL: [&str; 6] = [KEY, PASSWORD, TOKEN, SIGNATURE, DOOR, PLACE];

/// A secret in every form in which it could be read back.
fn disguises(secret: &str) -> Vec<Vec<u8>> {
    let percent = |upper: bool| -> String {
        let plain = |b: u8| b.is_ascii_alphanumeric() || b"-._~".contains(&b);
        let hex = |b: u8| if upper { format!("%{b:02X}") } else { format!("%{b:02x}") };
        secret.bytes().map(|b| if plain(b) { char::from(b).to_string() } else { hex(b) }).collect()
    };
    let mut forms = vec![secret.to_owned(), percent(true), percent(false)];
    for (offset, first) in [(0, 0), (1, 2), (2, 3)] {
        // Inside the base64 of something longer, at each of its three places.
        let bytes = [&[0; 2][..offset], secret.as_bytes()].concat();
        let end = bytes.len() * 8 / 6;
        forms.push(STANDARD.encode(&bytes)[first..end].to_owned());
        forms.push(URL_SAFE.encode(&bytes)[first..end].to_owned());
    }
    forms.into_iter().map(String::into_bytes).collect()
}

fn search(place: &str, bytes: &[u8]) {
    // A trace keeps the photo as it was given, comment and all.
    let own = place.ends_with(".mcap");
    for secret in ALL.into_iter().filter(|s| !own || *s != PLACE) {
        for form in disguises(secret) {
            let found = bytes.windows(form.len()).any(|w| w == form);
            assert!(!found, "{place} holds {secret} as {}", String::from_utf8_lossy(&form));
        }
    }
}

/// Everything that was asked, said back three times.
fn echo(asked: &Asked) -> Value {
    let told = format!("{} {} {:?}", asked.method, asked.path, asked.headers);
    json!({ "plain": told, "base64": STANDARD.encode(&told), "key": STANDARD.encode(key(asked)),
        "percent": told.replace(' ', "%20"), "access_token": DOOR,
        "file": format!("https://cdn.example/m.glb?Signature={SIGNATURE}") })
}

/// The key it was told, if it was told one.
fn key(asked: &Asked) -> String {
    let told = asked.headers.iter().find_map(|h| Some(h.split_once(": Bearer ")?.1.to_owned()));
    told.unwrap_or_default()
}

fn with_echo(asked: &Asked, answer: Answer) -> Answer {
    let mut value: Value = serde_json::from_slice(&answer.body).unwrap();
    value["echo"] = echo(asked);
    let mut answer = Answer { body: value.to_string().into_bytes(), ..answer };
    answer.headers.extend([
        ("x-request-id".into(), format!("for {}", key(asked))),
        ("set-cookie".into(), format!("session={DOOR}")),
    ]);
    answer
}

/// A JPEG that says where it was taken.
fn photo(path: &Path) {
    let mut jpeg = std::io::Cursor::new(vec![]);
    let picture = image::RgbImage::from_fn(48, 40, |x, _| image::Rgb([(x * 5) as u8, 9, 9]));
    picture.write_to(&mut jpeg, image::ImageFormat::Jpeg).unwrap();
    let comment = format!("taken at {PLACE}");
    let length = (comment.len() + 2) as u16;
    let head = [&[0xff, 0xd8, 0xff, 0xfe][..], &length.to_be_bytes(), comment.as_bytes()].concat();
    std::fs::write(path, [&head[..], &jpeg.into_inner()[2..]].concat()).unwrap();
}

struct Run {
    folder: tempfile::TempDir,
    said: Said,
}

impl Run {
    /// One run against a server, with a secret in every place where people put one.
    fn against(server: &Server) -> Self {
        let folder = tempfile::tempdir().unwrap();
        photo(&folder.path().join("photo.jpg"));
        let port = server.port;
        let config = format!(
            "[image_to_3d]\nprovider = \"hunyuan\"\nqueue = true\n\
             base = \"http://somebody:{PASSWORD}@127.0.0.1:{port}\"\n\
             [vlm]\nprovider = \"openai\"\nmodel = \"some-vlm\"\nkey_env = \"VLM_KEY\"\n\
             base = \"http://somebody:{PASSWORD}@127.0.0.1:{port}/v1\"\n"
        );
        std::fs::write(folder.path().join("kinfold.toml"), config).unwrap();
        let mut command = program_in(folder.path());
        command.env("KINFOLD_STATE", folder.path().join("state"));
        command.env("VLM_KEY", KEY).env("OTHER_SECRET", TOKEN);
        command.args(["make", "photo.jpg", "--out", "out", "--clock", CLOCK, "--json"]);
        let said = command.output().unwrap().into();
        Self { folder, said }
    }

    /// Nothing that stays behind holds a secret, save the photo of one's own.
    fn holds_no_secret(&self) {
        search("stdout", self.said.out.as_bytes());
        search("stderr", self.said.err.as_bytes());
        for (name, bytes) in files(&self.folder.path().join("out")) {
            search_file(&name, &bytes);
        }
        for (name, bytes) in files(&self.folder.path().join("state/calls")) {
            search(&name, &bytes);
        }
        for (name, bytes) in files(&self.folder.path().join("state/jobs")) {
            search(&name, &bytes);
        }
    }
}

/// A trace is searched inside its compressed pieces, too.
fn search_file(name: &str, bytes: &[u8]) {
    search(name, bytes);
    if !name.ends_with(".mcap") {
        return;
    }
    let reading = trace::read_bytes(bytes, name).unwrap();
    search("manifest", serde_json::to_string(&reading.manifest).unwrap().as_bytes());
    reading.calls.iter().for_each(|c| search("a call", c));
    reading.attachments.iter().for_each(|a| search(&a.name, &a.bytes));
    for (_, event) in &reading.events {
        search("an event", serde_json::to_string(event).unwrap().as_bytes());
    }
}

#[test]
fn servers_that_say_everything_back_leave_no_secret_behind() {
    let folder = tempfile::tempdir().unwrap();
    let cabinet = Cabinet::write(folder.path());
    let text = std::fs::read_to_string(&cabinet.condition).unwrap();
    let object = Object::of(&cabinet.mesh, &Condition::from_json(&text).unwrap());
    let server = Server::start(move |asked| with_echo(asked, object.answer(asked)));
    let run = Run::against(&server);
    assert_eq!(run.said.code, Some(0), "{:?}", run.said);
    let heard = server.asked().iter().any(|a| a.headers.iter().any(|h| h.contains(KEY)));
    assert!(heard, "the server itself must be given the key");
    let kept = server.asked().iter().any(|a| {
        let body = String::from_utf8_lossy(&a.body).into_owned();
        body.contains(PLACE) || body.contains(&STANDARD.encode(PLACE)[4..16])
    });
    assert!(!kept, "no place is sent along with a photo");
    run.holds_no_secret();
}

#[test]
fn errors_that_quote_everything_leave_no_secret_behind() {
    for status in [200, 400, 401, 404] {
        let server = Server::start(move |asked: &Asked| {
            let told = echo(asked);
            let answer = json!({ "status": told, "uid": told, "message": told.to_string(),
                "error": { "message": told.to_string() }, "detail": told.to_string() });
            with_echo(asked, Answer::json(status, &answer))
        });
        let run = Run::against(&server);
        assert_eq!(run.said.code, Some(1), "{status}: {:?}", run.said);
        run.holds_no_secret();
    }
}
