//! Providers that are busy, slow or paid for, and disks that are full: what a batch makes of them.
#![cfg(unix)]

use std::io::Write as _;
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use serde_json::{Value, json};

use crate::batch::Batch;
use crate::providers::{body, parts, physical, points};

/// A chat server for many items that counts.
pub struct Chat {
    /// Where it listens.
    pub port: u16,
    /// Questions that were answered, in order.
    pub answered: Arc<Mutex<Vec<String>>>,
    /// Most questions at once.
    pub most: Arc<AtomicUsize>,
}

impl Chat {
    /// One that says "busy" to the first questions and takes its time for the others.
    pub fn open(mesh: &Path, busy: usize, pause: Duration) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port();
        let (answered, most) =
            (Arc::<Mutex<Vec<String>>>::default(), Arc::<AtomicUsize>::default());
        let (now, asked) = (Arc::<AtomicUsize>::default(), Arc::<AtomicUsize>::default());
        let (words, peak, points) = (Arc::clone(&answered), Arc::clone(&most), points(mesh));
        std::thread::spawn(move || {
            for stream in listener.incoming() {
                let (words, peak, points) = (Arc::clone(&words), Arc::clone(&peak), points.clone());
                let (now, asked) = (Arc::clone(&now), Arc::clone(&asked));
                std::thread::spawn(move || {
                    peak.fetch_max(now.fetch_add(1, Ordering::SeqCst) + 1, Ordering::SeqCst);
                    let number = asked.fetch_add(1, Ordering::SeqCst);
                    answer(stream.unwrap(), number < busy, pause, (&points, &words));
                    now.fetch_sub(1, Ordering::SeqCst);
                });
            }
        });
        Self { port, answered, most }
    }
}

fn answer(
    mut stream: TcpStream,
    busy: bool,
    pause: Duration,
    (points, words): (&Value, &Mutex<Vec<String>>),
) {
    let asked = body(&stream);
    let question = asked["response_format"]["json_schema"]["name"].as_str().unwrap_or_default();
    std::thread::sleep(pause);
    let head = "content-type: application/json\r\nconnection: close\r\n";
    if busy {
        // The client may have been killed in between.
        let _ = write!(
            stream,
            "HTTP/1.1 503 Busy\r\nretry-after: 1\r\n{head}content-length: 2\r\n\r\n{{}}"
        );
        return;
    }
    let content = match question {
        "points" => points.to_string(),
        "physical" => physical().to_string(),
        _ => parts().to_string(),
    };
    let answer = json!({ "choices": [{ "finish_reason": "stop",
        "message": { "role": "assistant", "content": content } }] })
    .to_string();
    words.lock().unwrap().push(question.to_owned());
    let _ =
        write!(stream, "HTTP/1.1 200 OK\r\n{head}content-length: {}\r\n\r\n{answer}", answer.len());
}

/// Items whose conditions come from a chat server.
pub fn with_chat(items: usize, chat: &Chat) -> Batch {
    let batch = Batch::of(0);
    let line = |n: usize| {
        let mut line = Batch::given(&format!("k{n:03}"), n);
        line.as_object_mut().unwrap().remove("condition");
        // Another photo is another question.
        line["photo"] = format!("{n}.png").into();
        batch.write(&format!("{n}.png"), crate::cabinet::png(40 + n as u32, 40));
        format!("{line}\n")
    };
    batch.write("items.jsonl", (0..items).map(line).collect::<String>());
    let base = format!("http://127.0.0.1:{}/v1", chat.port);
    let config = format!("[vlm]\nprovider = \"openai\"\nbase = \"{base}\"\nmodel = \"some-vlm\"\n");
    batch.write("kinfold.toml", config);
    batch
}

/// The cabinet's mesh in a folder of its own.
pub fn cabinet_mesh() -> (tempfile::TempDir, std::path::PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let mesh = crate::cabinet::Cabinet::write(folder.path()).mesh;
    (folder, mesh)
}

#[test]
fn a_busy_model_is_asked_again_with_a_pause_and_no_item_is_lost() {
    let (_folder, mesh) = cabinet_mesh();
    let chat = Chat::open(&mesh, 1, Duration::from_millis(20));
    let batch = with_chat(3, &chat);
    let (said, answer) = batch.ran(&["--condition-calls", "2"]);
    assert_eq!(said.code, Some(0), "{said:?}");
    assert_eq!(answer["accepted"], 3);
    assert_eq!(answer["calls"], 10, "three requests an item, and the busy one again");
    assert!(chat.most.load(Ordering::SeqCst) <= 2, "more at once than may");
}

#[test]
fn an_answer_that_was_paid_for_is_never_asked_for_again() {
    let (_folder, mesh) = cabinet_mesh();
    let chat = Chat::open(&mesh, 0, Duration::ZERO);
    let batch = with_chat(2, &chat);
    assert_eq!(batch.ran(&[]).0.code, Some(0));
    let asked = chat.answered.lock().unwrap().len();
    // The outcomes are gone, the store is not: everything is looked at anew and nobody asked.
    std::fs::remove_file(batch.path("out/ledger.sqlite")).unwrap();
    for beside in ["ledger.sqlite-wal", "ledger.sqlite-shm"] {
        let _ = std::fs::remove_file(batch.path("out").join(beside));
    }
    std::fs::rename(batch.path("out/state"), batch.path("state")).unwrap();
    std::fs::remove_dir_all(batch.path("out")).unwrap();
    let (said, answer) = batch.ran(&["--state", "state"]);
    assert_eq!((said.code, &answer["this_run"]["stages_run"]), (Some(0), &json!(0)), "{said:?}");
    assert_eq!(chat.answered.lock().unwrap().len(), asked);
}

#[test]
fn one_changed_condition_repeats_only_what_depends_on_it() {
    let batch = Batch::of(2);
    batch.ran(&[]);
    let mut edited = crate::cabinet::condition();
    edited["parts"][1]["material"] = "steel".into();
    batch.write("steel.json", edited.to_string());
    let mut steel = Batch::given("k001", 1);
    steel["condition"] = "steel.json".into();
    batch.write("items.jsonl", format!("{}\n{steel}\n", Batch::given("k000", 0)));
    let (said, answer) = batch.ran(&[]);
    assert_eq!(said.code, Some(0), "{said:?}");
    assert_eq!(answer["this_run"]["items"], 1);
    assert_eq!(answer["this_run"]["stages_recalled"], 3, "mesh, views and parts: {answer}");
    assert_eq!(answer["this_run"]["stages_run"], 8);
}

/// A small disk of its own; none where we may not mount.
pub struct Disk(tempfile::TempDir);

impl Disk {
    pub fn of(size: &str) -> Option<Self> {
        let folder = tempfile::tempdir().unwrap();
        let option = format!("size={size}");
        let mounted = Command::new("mount")
            .args(["-t", "tmpfs", "-o", &option, "tmpfs"])
            .arg(folder.path())
            .output()
            .is_ok_and(|o| o.status.success());
        if !mounted {
            eprintln!("SKIPPED: a small disk cannot be mounted here, so no disk is full");
        }
        mounted.then(|| Self(folder))
    }

    pub fn grow(&self, size: &str) {
        let option = format!("remount,size={size}");
        let grown =
            Command::new("mount").args(["-o", &option]).arg(self.0.path()).status().unwrap();
        assert!(grown.success());
    }

    pub fn path(&self) -> &Path {
        self.0.path()
    }
}

impl Drop for Disk {
    fn drop(&mut self) {
        // What is left mounted is told by the next line of `df`; there is nobody else to tell.
        let _ = Command::new("umount").arg("-l").arg(self.0.path()).status();
    }
}

#[test]
fn a_full_disk_stops_the_batch_with_an_error_and_a_larger_one_goes_on() {
    let Some(disk) = Disk::of("3m") else { return };
    let undisturbed = Batch::of(3);
    undisturbed.ran(&[]);
    let batch = Batch::of(3);
    let out = disk.path().join("out");
    let run = || -> crate::kinfold::Said {
        let mut command =
            batch.kinfold(&["batch", "items.jsonl", "--clock", crate::kinfold::CLOCK, "--out"]);
        command.arg(&out).output().unwrap().into()
    };
    let said = run();
    assert_eq!(said.code, Some(1), "{said:?}");
    assert!(said.err.contains("error: ") && said.err.contains("hint: "), "{}", said.err);
    disk.grow("200m");
    let said = run();
    assert_eq!(said.code, Some(0), "{said:?}");
    assert!(crate::kinfold::files(&out.join("assets")) == undisturbed.assets());
}

#[test]
fn a_store_that_may_not_be_written_is_an_error_before_any_work() {
    let Some(disk) = Disk::of("50m") else { return };
    let batch = Batch::of(1);
    let out = disk.path().join("out");
    std::fs::create_dir(&out).unwrap();
    let read_only = Command::new("mount").args(["-o", "remount,ro"]).arg(disk.path()).status();
    assert!(read_only.unwrap().success());
    let mut command = batch.kinfold(&["batch", "items.jsonl", "--out"]);
    let said: crate::kinfold::Said = command.arg(&out).output().unwrap().into();
    assert_eq!(said.code, Some(1), "{said:?}");
    assert!(said.err.to_lowercase().contains("read-only file system"), "{}", said.err);
}
