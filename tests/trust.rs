//! Nobody's configuration acts before it is approved, and no key stands in one.
#![cfg(unix)]

use std::path::Path;
use std::process::Command;

use serde_json::{Value, json};

use crate::cabinet::Cabinet;
use crate::kinfold::{Said, program, say};
use crate::server::{Answer, Server};

const SECRET: &str = "wJalrXUtnFEMI-of-somebody-0001";

/// A folder that a stranger sent, with a photo and a configuration, and a home beside it.
struct Folder {
    root: tempfile::TempDir,
    server: Server,
}

impl Folder {
    fn with(config: impl Fn(u16) -> String) -> Self {
        let root = tempfile::tempdir().unwrap();
        let work = root.path().join("work");
        std::fs::create_dir(&work).unwrap();
        Cabinet::write(&work);
        std::fs::write(work.join("items.jsonl"), "{\"id\":\"a\",\"photo\":\"photo.png\"}\n")
            .unwrap();
        std::fs::create_dir_all(work.join("cases/home__cabinet")).unwrap();
        let server = Server::start(|_| Answer::json(200, &json!({ "data": [] })));
        std::fs::write(work.join("kinfold.toml"), config(server.port)).unwrap();
        Self { root, server }
    }

    fn work(&self) -> std::path::PathBuf {
        self.root.path().join("work")
    }

    fn kinfold(&self, args: &[&str]) -> Command {
        let mut command = program();
        command.current_dir(self.work()).env("AWS_SECRET_ACCESS_KEY", SECRET).args(args);
        command.env("KINFOLD_STATE", self.root.path().join("state"));
        command.env("HOME", self.root.path().join("home"));
        command
    }

    fn say(&self, args: &[&str]) -> Said {
        self.kinfold(args).output().unwrap().into()
    }
}

/// Sends a variable that is none of its business to an address of its own.
fn thief(port: u16) -> String {
    format!(
        "[vlm]\nprovider = \"openai\"\nmodel = \"m\"\nbase = \"http://127.0.0.1:{port}/v1\"\n\
         key_env = \"AWS_SECRET_ACCESS_KEY\"\n"
    )
}

/// Starts a program of its own.
fn starter(_: u16) -> String {
    "[image_to_3d]\nprovider = \"command\"\nprogram = \"touch\"\narguments = [\"started\"]\n".into()
}

const ACTING: [&[&str]; 8] = [
    &["doctor"],
    &["doctor", "--free"],
    &["doctor", "--json"],
    &["make", "photo.png"],
    &["make", "photo.png", "--dry-run"],
    &["make", "photo.png", "--graph"],
    &["batch", "items.jsonl", "--out", "out"],
    &["batch", "items.jsonl", "--out", "out", "--dry-run"],
];

/// Fault: standing in somebody's folder was enough to obey its configuration.
#[test]
fn a_configuration_found_in_the_working_folder_sends_and_starts_nothing() {
    for (config, told) in [
        (thief as fn(u16) -> String, "[vlm] sends what AWS_SECRET_ACCESS_KEY holds to 127.0.0.1:"),
        (starter, "[image_to_3d] starts the program `touch started`"),
    ] {
        let folder = Folder::with(config);
        for args in ACTING {
            let said = folder.say(args);
            assert_eq!(said.code, Some(2), "{args:?}: {said:?}");
            assert!(said.err.contains(told), "{args:?}: {}", said.err);
            assert!(said.err.contains("hint: read the file, then `kinfold trust`"), "{}", said.err);
            assert!(!said.err.contains(SECRET) && !said.out.contains(SECRET), "{said:?}");
        }
        assert!(folder.server.asked().is_empty(), "nothing is sent");
        for name in ["started", "out", "photo.kinfold", "../state"] {
            assert!(!folder.work().join(name).exists(), "{name}");
        }
        let said = folder.say(&["providers"]);
        assert_eq!(said.code, Some(0), "{said:?}");
        assert!(said.err.starts_with("warning: kinfold.toml: ") && said.err.contains(told));
    }
}

#[test]
fn what_asks_for_a_case_is_not_obeyed_either() {
    let folder = Folder::with(thief);
    std::fs::write(folder.work().join("cases/home__cabinet/truth.json"), "{}").unwrap();
    let said = folder.say(&["eval", "cases", "--mode", "mesh"]);
    assert_eq!(said.code, Some(2), "{said:?}");
    assert!(said.err.contains("AWS_SECRET_ACCESS_KEY"), "{}", said.err);
    assert!(folder.server.asked().is_empty());
}

#[test]
fn an_approval_holds_until_the_file_changes_or_it_is_taken_back() {
    let folder = Folder::with(thief);
    let said = folder.say(&["trust"]);
    assert_eq!(said.code, Some(0), "{said:?}");
    assert!(said.out.contains("kinfold.toml: trusted until it changes\n  [vlm] sends"), "{said:?}");
    assert_eq!(folder.say(&["doctor", "--free"]).code, Some(0));
    assert_eq!(folder.server.count("GET", "/v1/models"), 1);
    let list = folder.say(&["trust", "--list", "--json"]);
    let list: Value = serde_json::from_str(&list.out).unwrap();
    assert!(list[0]["path"].as_str().unwrap().ends_with("work/kinfold.toml"), "{list}");

    let config = folder.work().join("kinfold.toml");
    let text = std::fs::read_to_string(&config).unwrap();
    std::fs::write(&config, format!("{text}critic = true\n")).unwrap();
    assert_eq!(folder.say(&["doctor", "--free"]).code, Some(2), "a changed file is another");
    std::fs::write(&config, &text).unwrap();
    assert_eq!(folder.say(&["doctor", "--free"]).code, Some(0));
    std::fs::create_dir(folder.work().join("copy")).unwrap();
    std::fs::write(folder.work().join("copy/kinfold.toml"), &text).unwrap();
    let mut elsewhere = folder.kinfold(&["doctor", "--free"]);
    let said: Said = elsewhere.current_dir(folder.work().join("copy")).output().unwrap().into();
    assert_eq!(said.code, Some(2), "the same bytes elsewhere are another");

    assert_eq!(folder.say(&["trust", "--remove"]).code, Some(0));
    assert_eq!(folder.say(&["doctor", "--free"]).code, Some(2));
    assert_eq!(folder.say(&["trust", "--list"]).out, "");
}

#[test]
fn one_run_can_be_let_without_an_approval_and_a_named_file_needs_none() {
    let folder = Folder::with(thief);
    assert_eq!(folder.say(&["doctor", "--free", "--trust-config"]).code, Some(0));
    assert_eq!(folder.say(&["doctor", "--free"]).code, Some(2), "it was for that once");
    assert_eq!(folder.say(&["doctor", "--free", "--config", "kinfold.toml"]).code, Some(0));
    let mut named = folder.kinfold(&["doctor", "--free"]);
    let said: Said = named.env("KINFOLD_CONFIG", "kinfold.toml").output().unwrap().into();
    assert_eq!(said.code, Some(0), "{said:?}");
    let mut homeless = folder.kinfold(&["trust"]);
    let said: Said = homeless.env_remove("HOME").output().unwrap().into();
    assert_eq!(said.code, Some(1), "{said:?}");
    assert!(said.err.contains("neither XDG_CONFIG_HOME nor HOME is set"), "{}", said.err);
    let mut homeless = folder.kinfold(&["doctor", "--free"]);
    let said: Said = homeless.env_remove("HOME").output().unwrap().into();
    assert_eq!(said.code, Some(2), "{said:?}");
}

#[test]
fn a_configuration_that_only_names_whom_everybody_knows_needs_no_approval() {
    let folder = Folder::with(|_| {
        "[vlm]\nprovider = \"openai\"\nmodel = \"m\"\n[budget]\ncalls = 0\n".into()
    });
    let said = folder.say(&["make", "photo.png", "--mesh", "cabinet.glb", "--dry-run"]);
    assert!(said.err.contains("no key: the variable OPENAI_API_KEY is not set"), "{said:?}");
}

#[test]
fn a_file_whose_work_is_given_needs_no_approval() {
    let folder = Folder::with(starter);
    let args =
        ["make", "photo.png", "--mesh", "cabinet.glb", "--condition", "cabinet.json", "--dry-run"];
    let said = folder.say(&args);
    assert_eq!(said.code, Some(0), "{said:?}");
}

#[test]
fn a_key_written_into_the_file_is_refused_by_line_and_field_and_never_quoted() {
    let vlm = "[vlm]\nprovider = \"openai\"\nmodel = \"m\"\n";
    let cases = [
        (format!("{vlm}key = \"{SECRET}\"\n"), "line 4, field `key`"),
        (format!("{vlm}api_key = \"{SECRET}\"\n"), "line 4, field `api_key`"),
        (format!("{vlm}key_env = \"sk-{SECRET}\"\n"), "line 4, field `key_env`"),
        (format!("{vlm}base = \"https://h.example/?k=sk-{SECRET}\"\n"), "line 4, field `base`"),
        (format!("{vlm}key = \"{SECRET}\n"), "line 4"),
        (format!("{vlm}points = \"{SECRET} {SECRET}\"\n"), "line 4"),
        (format!("{vlm}{SECRET}\n"), "line 4"),
    ];
    for (text, told) in cases {
        let folder = Folder::with(|_| text.clone());
        let named = ["--config", "kinfold.toml"];
        for args in [&["doctor"][..], &["make", "photo.png"], &["providers"], &["trust"]] {
            let with_it = [args, if args == ["trust"] { &[] } else { &named }].concat();
            let said = folder.say(&with_it);
            assert_eq!(said.code, Some(1), "{args:?}: {said:?}");
            assert!(said.err.contains(told), "{args:?}: {}", said.err);
            assert!(!format!("{said:?}").contains("wJalrXUtnFEMI"), "{args:?}: {said:?}");
        }
    }
}

#[test]
fn a_key_does_not_leave_over_plain_http() {
    let config = |_| {
        "[vlm]\nprovider = \"openai\"\nmodel = \"m\"\nbase = \"http://192.0.2.7/v1\"\n\
         key_env = \"AWS_SECRET_ACCESS_KEY\"\n"
            .into()
    };
    let folder = Folder::with(config);
    for verb in [&["doctor"][..], &["make", "photo.png", "--mesh", "cabinet.glb"]] {
        let said = folder.say(&[verb, &["--trust-config"]].concat());
        assert_eq!(said.code, Some(1), "{said:?}");
        let told = "192.0.2.7: the key in AWS_SECRET_ACCESS_KEY would leave over plain http";
        assert!(said.err.contains(told) && said.err.contains("hint: keys leave over https"));
    }
}

#[test]
fn what_a_configuration_would_do_is_told_inertly() {
    let config = |_| {
        "[image_to_3d]\nprovider = \"command\"\nprogram = \"a\\u001b[2J\\nerror: b\\u202e\"\narguments = []\n"
            .into()
    };
    let folder = Folder::with(config);
    for args in [&["make", "photo.png"][..], &["providers"], &["trust"]] {
        let said = folder.say(args);
        let all = format!("{}{}", said.out, said.err);
        assert!(all.contains("a\\u{1b}[2J\\u{a}error: b\\u{202e}"), "{said:?}");
        assert!(!all.contains(['\u{1b}', '\u{202e}']) && !all.contains("\nerror: b"), "{said:?}");
    }
}

#[test]
fn trust_says_what_is_wrong_with_a_file() {
    let said = say(&["trust", "/nowhere/kinfold.toml"]);
    assert_eq!(said.code, Some(1), "{said:?}");
    assert!(Path::new("/nowhere").exists() || said.err.starts_with("error: "), "{said:?}");
}
