//! What strangers wrote is shown and never acts: no terminal obeys it, no line is forged.
#![cfg(unix)]

use std::path::Path;

use serde_json::{Value, json};

use crate::batch::Batch;
use crate::kinfold::{Bench, Said, program, program_in, say};

/// Clears a terminal, forges a line, sets a title by one byte, and turns the direction of writing.
const EVIL: &str = "x\u{1b}[2J\nkinematic  good.urdf\r\u{9b}31m\u{202e}\u{2066}\u{2028}y";
/// The same as it may be shown.
const SHOWN: &str =
    "x\\u{1b}[2J\\u{a}kinematic  good.urdf\\u{d}\\u{9b}31m\\u{202e}\\u{2066}\\u{2028}y";
/// The same in JSON.
const QUOTED: &str = "x\\u001b[2J\\nkinematic  good.urdf\\r\\u009b31m\\u202e\\u2066\\u2028y";

/// Whether nothing in a text acts but the line feeds and tabs of its own.
fn inert(text: &str) -> bool {
    let turns = |c| matches!(c, '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    !text.contains(|c: char| (c.is_control() && !matches!(c, '\n' | '\t')) || turns(c))
        && !text.lines().any(|line| line.starts_with("kinematic  good.urdf"))
}

fn checked(said: &Said) {
    assert!(inert(&said.out), "stdout: {:?}", said.out);
    assert!(inert(&said.err), "stderr: {:?}", said.err);
}

fn urdf(link: &str) -> String {
    let link = link.replace('\n', "&#10;").replace('\r', "&#13;").replace('\u{1b}', "");
    format!("<robot name=\"{link}\"><link name=\"{link}\"/><link name=\"{link}\"/></robot>")
}

/// Fault: a file's name forged lines of the overview, and its escapes were obeyed.
#[test]
fn the_name_of_a_urdf_forges_no_line_of_the_overview() {
    let folder = tempfile::tempdir().unwrap();
    let name = format!("{EVIL}.urdf");
    std::fs::write(folder.path().join(&name), urdf("a")).unwrap();
    std::fs::write(folder.path().join("b.urdf"), urdf("b")).unwrap();
    let path = folder.path().to_str().unwrap();
    let report = folder.path().join("report.xml");
    let said = say(&["check", path, "--junit", report.to_str().unwrap()]);
    checked(&said);
    assert!(said.out.contains(SHOWN), "{}", said.out);
    assert_eq!(said.out.lines().count(), 3, "{}", said.out);
    let report = std::fs::read_to_string(report).unwrap();
    assert!(inert(&report) && report.contains(SHOWN), "{report}");
    let said = say(&["check", path, "--json"]);
    checked(&said);
    assert!(said.out.contains(QUOTED), "{}", said.out);
    for line in said.out.lines() {
        let value: Value = serde_json::from_str(line).unwrap();
        assert!(value["file"].as_str().unwrap().ends_with(".urdf"));
    }
    checked(&say(&["check", folder.path().join(&name).to_str().unwrap()]));
    checked(&say(&["check", folder.path().join(format!("no {EVIL}")).to_str().unwrap()]));
}

/// Fault: names of links went raw into evidence.
#[test]
fn the_name_of_a_link_forges_no_line_of_evidence() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.urdf");
    std::fs::write(&file, urdf(EVIL)).unwrap();
    let file = file.to_str().unwrap();
    let said = say(&["check", file]);
    checked(&said);
    assert!(
        said.out.contains("\\u{a}kinematic  good.urdf\\u{d}\\u{9b}31m\\u{202e}"),
        "{}",
        said.out
    );
    let said = say(&["check", file, "--json"]);
    checked(&said);
    let verdict: Value = serde_json::from_str(&said.out).unwrap();
    let evidence =
        verdict["checks"].as_array().unwrap().iter().flat_map(|c| c["evidence"].as_array());
    let mut evidence = evidence.flatten().map(|e| e.as_str().unwrap());
    assert!(evidence.all(inert), "{verdict}");
}

#[test]
fn what_a_waiver_says_and_what_is_no_argument_are_inert() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.urdf");
    std::fs::write(&file, urdf("a")).unwrap();
    checked(&say(&["check", file.to_str().unwrap(), "--waive", &format!("C1={EVIL}")]));
    let said = say(&["check", &format!("--{EVIL}")]);
    assert_eq!(said.code, Some(2));
    checked(&said);
    checked(&say(&[EVIL]));
    checked(&say(&["trace", "show", EVIL]));
    let folder = tempfile::tempdir().unwrap();
    let mut make = program_in(folder.path());
    make.args(["make", EVIL, "--mesh", EVIL, "--condition", EVIL, "--state", "state"]);
    checked(&make.output().unwrap().into());
}

/// Fault: an id in a bad line, and categories and licences of a query, were printed raw.
#[test]
fn ids_categories_and_licences_of_a_batch_are_inert() {
    let batch = Batch::of(0);
    let mut good = Batch::given("good", 0);
    good["license"] = EVIL.into();
    good["category"] = EVIL.into();
    let mut bad = Batch::given("bad", 1);
    bad["id"] = EVIL.into();
    let mut gone = Batch::given("gone", 2);
    gone["photo"] = format!("{EVIL}.png").into();
    let lines = format!("{good}\n{bad}\n{gone}\n{{\"id\": \"{}\", \"z\": 1}}\n", "\u{202e}\u{9b}");
    batch.write("items.jsonl", lines);
    for args in [
        &["batch", "items.jsonl", "--out", "out"][..],
        &["batch", "items.jsonl", "--out", "out", "--json"],
        &["batch", "report", "out"],
        &["audit", "out"],
        &["audit", "query", "out", "SELECT * FROM items"],
        &["audit", "query", "out", "SELECT id AS \"a\n\u{1b}[2Jkinematic  good.urdf\" FROM items"],
        &["audit", "query", "out", "SELECT char(27, 10, 155, 8238) FROM items"],
        &["audit", "query", "out", "SELECT * FROM items", "--json"],
        &["audit", "query", "out", &format!("SELECT {EVIL}")],
    ] {
        checked(&batch.say(args));
    }
    let page = std::fs::read_to_string(batch.path("out/report.html")).unwrap();
    assert!(inert(&page));
}

/// What a trace of somebody else's says.
#[test]
fn a_trace_of_somebody_elses_shows_itself_inertly() {
    let bench = Bench::new();
    let photo = bench.path(&format!("{EVIL}.png"));
    std::fs::copy(&bench.cabinet.photo, &photo).unwrap();
    let mut condition = crate::cabinet::condition();
    condition["category"] = EVIL.into();
    bench.cabinet.write_condition(&condition);
    let said: Said = {
        let mut command = program();
        command.current_dir(bench.path("")).env("KINFOLD_STATE", bench.path("state"));
        command.arg("make").arg(&photo).args([
            "--mesh",
            "cabinet.glb",
            "--condition",
            "cabinet.json",
        ]);
        command.args(["--out", EVIL]).output().unwrap().into()
    };
    checked(&said);
    let trace = bench.path(EVIL).join("trace.mcap");
    if trace.exists() {
        for verb in ["show", "verify", "extract", "replay"] {
            checked(&say(&["trace", verb, trace.to_str().unwrap()]));
            if verb != "extract" {
                checked(&say(&["trace", verb, trace.to_str().unwrap(), "--json"]));
            }
        }
        let log = logs(&trace);
        assert!(log.iter().all(|line| inert(line)), "{log:?}");
    }
    let failed = bench.made(&["--seed", "1"]);
    checked(&failed);
}

/// The lines of a trace's log.
fn logs(trace: &Path) -> Vec<String> {
    let bytes = std::fs::read(trace).unwrap();
    let messages = mcap::MessageStream::new(&bytes).unwrap().map(Result::unwrap);
    let logs = messages.filter(|m| m.channel.topic == "/log");
    logs.map(|m| String::from_utf8_lossy(&m.data).into_owned())
        .map(|s| s.replace(|c: char| c.is_control(), ""))
        .collect()
}

/// What a service says of why it failed.
#[test]
fn what_a_service_says_is_inert() {
    let server = crate::server::Server::start(|_| {
        crate::server::Answer::json(500, &json!({ "error": { "message": EVIL } }))
    });
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("photo.png"), crate::cabinet::png(48, 40)).unwrap();
    let config = crate::services::config(server.port);
    std::fs::write(folder.path().join("kinfold.toml"), config).unwrap();
    for args in [&["doctor"][..], &["make", "photo.png"], &["make", "photo.png", "--json"]] {
        let mut command = crate::kinfold::program_in(folder.path());
        command.env("KINFOLD_STATE", "state").args(args);
        checked(&command.output().unwrap().into());
    }
    assert!(!server.asked().is_empty());
}
