//! Looking is safe: whatever a stranger sent, nothing runs, nothing is written but the named output,
//! nothing outside is read, and it ends.
#![cfg(unix)]

use std::collections::BTreeMap;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use trace::Digest;

use crate::batch::Batch;
use crate::forged;
use crate::kinfold::{Bench, CLOCK, Said, program, say};
use crate::replays::Made;

/// After so long a program hangs; it ends a test and measures nothing.
const HANGS: Duration = Duration::from_secs(120);

/// Runs the program with some arguments; one that hangs is ended, and so is the test.
fn looked(at: &Path, args: &[&str]) -> Said {
    let mut command = program();
    command.current_dir(at).args(args).env("HOME", at.join("home"));
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let begun = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if begun.elapsed() > HANGS {
            child.kill().unwrap();
            panic!("{args:?} hangs");
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    child.wait_with_output().unwrap().into()
}

/// It ends with exit 1 and these words.
fn refused(at: &Path, args: &[&str], words: &[&str]) {
    let said = looked(at, args);
    assert_eq!(said.code, Some(1), "{args:?}: {said:?}");
    for word in words {
        assert!(said.err.contains(word), "{args:?}: no {word:?} in {}", said.err);
    }
}

fn pipe(path: &Path) {
    assert!(std::process::Command::new("mkfifo").arg(path).status().unwrap().success());
}

fn sparse(path: &Path) {
    std::fs::File::create(path).unwrap().set_len(1 << 40).unwrap();
}

/// Everything in a folder: what it is, how long, what it holds or where it leads.
fn tree(root: &Path) -> BTreeMap<PathBuf, String> {
    let (mut found, mut folders) = (BTreeMap::new(), vec![root.to_path_buf()]);
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            let about = std::fs::symlink_metadata(&path).unwrap();
            let told = if about.is_dir() {
                folders.push(path.clone());
                "folder".into()
            } else if about.is_file() && about.len() < 1 << 30 {
                Digest::of(&std::fs::read(&path).unwrap()).to_string()
            } else {
                format!("{:?} {:?} {}", about.file_type(), path.read_link().ok(), about.len())
            };
            found.insert(path.strip_prefix(root).unwrap().to_path_buf(), told);
        }
    }
    found
}

/// An asset whose mesh was made by a program, which leaves a file `ran` where it runs.
fn of_a_program() -> (Bench, trace::Reading) {
    let bench = Bench::new();
    let config = "[image_to_3d]\nprovider = 'command'\nprogram = 'sh'\n\
        arguments = ['-c', 'touch ran; cp cabinet.glb \"$1\"', 'sh', '{mesh}']\n";
    std::fs::write(bench.path("config.toml"), config).unwrap();
    let mut command = program();
    command.current_dir(bench.path("")).env("KINFOLD_STATE", bench.path("state"));
    command.args(["make", "photo.png", "--condition", "cabinet.json", "--out", "out"]);
    command.args(["--config", "config.toml", "--clock", CLOCK]);
    let said: Said = command.output().unwrap().into();
    assert!(matches!(said.code, Some(0 | 3)), "{said:?}");
    assert!(bench.path("ran").exists(), "the program ran once");
    std::fs::remove_file(bench.path("ran")).unwrap();
    let reading = bench.trace();
    (bench, reading)
}

/// Looks at a trace in every way there is; nothing may have been started.
fn runs_nothing(bench: &Bench, reading: &trace::Reading, replay: (i32, &str)) {
    let at = bench.path("");
    forged::write(&bench.path("forged.mcap"), reading);
    let said = looked(&at, &["trace", "replay", "forged.mcap"]);
    assert_eq!(said.code, Some(replay.0), "{said:?}");
    assert!(said.err.contains(replay.1), "{said:?}");
    looked(&at, &["trace", "extract", "forged.mcap", "asset.urdf", "--out", "taken", "--force"]);
    looked(&at, &["trace", "verify", "forged.mcap", "--files", "out"]);
    looked(&at, &["trace", "show", "forged.mcap"]);
    assert!(!bench.path("ran").exists(), "the program was started");
}

#[test]
fn a_replay_never_starts_the_program_that_a_trace_names() {
    let (bench, mut reading) = of_a_program();
    runs_nothing(&bench, &reading, (0, ""));
    // As it was attacked: one call is enough to have the adapter asked.
    forged::add_call(&mut reading, "generate-mesh");
    runs_nothing(&bench, &reading, (0, ""));
}

#[test]
fn a_replay_without_the_mesh_of_a_program_fails_and_says_what_is_missing() {
    let (bench, mut reading) = of_a_program();
    forged::drop_file(&mut reading, "mesh.glb");
    runs_nothing(&bench, &reading, (1, "it lacks what generate-mesh made"));
    forged::add_call(&mut reading, "generate-mesh");
    runs_nothing(&bench, &reading, (1, "it lacks what generate-mesh made"));
}

#[test]
fn an_artefact_that_is_not_whole_in_a_trace_is_made_again_without_the_program() {
    let (bench, mut reading) = of_a_program();
    forged::add_call(&mut reading, "generate-mesh");
    let urdf = bench.out()["asset.urdf"].clone();
    forged::drop_file(&mut reading, "asset.urdf");
    forged::write(&bench.path("forged.mcap"), &reading);
    let at = bench.path("");
    let said = looked(&at, &["trace", "extract", "forged.mcap", "asset.urdf"]);
    assert_eq!(said.code, Some(0), "{said:?}");
    assert_eq!(std::fs::read(bench.path("asset.urdf")).unwrap(), urdf);
    assert!(!bench.path("ran").exists(), "the program was started");
}

#[test]
fn a_replay_asks_no_server_whatever_its_trace_lacks() {
    let made = Made::cabinet();
    let asked = made.server.asked().len();
    let mut reading = trace::read(&made.path("out/trace.mcap")).unwrap();
    reading.calls.clear();
    reading.events.iter_mut().for_each(|(_, event)| event.calls.clear());
    forged::write(&made.path("forged.mcap"), &reading);
    let at = made.path("");
    refused(&at, &["trace", "replay", "forged.mcap"], &["not in the record"]);
    assert_eq!(made.server.asked().len(), asked, "a server was asked");
}

#[test]
fn a_trace_that_names_a_file_outside_has_none_of_it_read() {
    let bench = Bench::done();
    let secret = b"of nobody's business";
    std::fs::write(bench.path("secret"), secret).unwrap();
    let mut reading = bench.trace();
    let urdf = forged::finished(&mut reading, "write-urdf");
    let mut stolen = urdf.outputs[0].clone();
    stolen.name = "../secret".into();
    urdf.outputs.push(stolen);
    forged::write(&bench.path("out/trace.mcap"), &reading);
    let said = looked(&bench.path(""), &["trace", "verify", "out/trace.mcap"]);
    assert_eq!(said.code, Some(1), "{said:?}");
    assert!(said.err.contains("leads out of the folder"), "{said:?}");
    assert!(!said.err.contains(Digest::of(secret).short()), "{said:?}");
}

#[test]
fn a_question_to_the_ledger_writes_nothing_attaches_nothing_and_ends() {
    let batch = Batch::of(1);
    batch.ran(&[]);
    let before = tree(&batch.path("out"));
    let at = batch.path("");
    for sql in [
        "VACUUM INTO 'anywhere.db'",
        "ATTACH 'other.sqlite' AS x",
        "CREATE TEMP TABLE t (x)",
        "PRAGMA journal_mode = DELETE",
        "SELECT * FROM pragma_database_list",
        "SELECT load_extension('x')",
    ] {
        refused(&at, &["audit", "query", "out", sql], &["only the ledger's own tables"]);
    }
    let endless =
        "WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL SELECT x+1 FROM c) SELECT count(*) FROM c";
    let words = ["was not answered within 0.5 s and was stopped", "--deadline"];
    refused(&at, &["audit", "query", "out", endless, "--deadline", "0.5"], &words);
    let large = "WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL SELECT x+1 FROM c)
        SELECT x, zeroblob(200000) AS b FROM c ORDER BY b, x";
    let said = looked(&at, &["audit", "query", "out", large, "--deadline", "60"]);
    let capped = said.err.contains("bytes of memory") || said.err.contains("was stopped");
    assert!(said.code == Some(1) && capped, "{said:?}");
    // One step of these went on for half a minute, whatever the deadline.
    let began = std::time::Instant::now();
    let long = "SELECT instr(printf('%.*c', 20000000, 'a'), printf('%.*c', 10000000, 'a') || 'b')";
    let pattern = format!("SELECT 'a' LIKE '{}'", "%a".repeat(2000));
    for (sql, found) in
        [(long, "a value or a row has more than 262144 bytes"), (pattern.as_str(), "too complex")]
    {
        refused(&at, &["audit", "query", "out", sql, "--deadline", "4"], &[found]);
    }
    assert!(began.elapsed() < std::time::Duration::from_secs(60), "far beyond their deadline");
    assert_eq!(batch.ask("SELECT count(*) FROM items"), "1");
    assert_eq!(tree(&batch.path("out")), before);
    assert!(!batch.path("anywhere.db").exists() && !batch.path("other.sqlite").exists());
}

#[test]
fn a_forged_ledger_does_nothing_and_hides_nothing() {
    let batch = Batch::of(1);
    batch.ran(&[]);
    let path = batch.path("out/ledger.sqlite");
    let db = rusqlite::Connection::open(&path).unwrap();
    let forged = "PRAGMA journal_mode = DELETE; DROP VIEW items;
        CREATE VIEW items AS SELECT * FROM outcomes WHERE 0;";
    db.execute_batch(forged).unwrap();
    drop(db);
    std::fs::write(batch.path("out/assets/k000/asset.urdf"), "other").unwrap();
    std::fs::write(batch.path("out/ledger.sqlite-journal"), "a journal that is none").unwrap();
    let before = tree(&batch.path("out"));
    let said = looked(&batch.path(""), &["audit", "out"]);
    assert_eq!(said.code, Some(1), "{said:?}");
    assert!(said.err.contains("asset.urdf was changed"), "{said:?}");
    assert_eq!(batch.ask("SELECT count(*) FROM items"), "1");
    assert_eq!(tree(&batch.path("out")), before);
}

#[test]
fn a_ledger_that_is_a_link_or_has_a_link_for_a_log_is_refused() {
    let (batch, other) = (Batch::of(1), Batch::of(1));
    batch.ran(&[]);
    other.ran(&[]);
    let at = batch.path("");
    let log = batch.path("out/ledger.sqlite-wal");
    symlink(other.path("items.jsonl"), &log).unwrap();
    refused(&at, &["audit", "out"], &["ledger.sqlite-wal", "leads out of the folder"]);
    std::fs::remove_file(&log).unwrap();
    pipe(&log);
    refused(&at, &["audit", "out"], &["ledger.sqlite-wal", "is no regular file"]);
    std::fs::remove_file(&log).unwrap();
    let ledger = batch.path("out/ledger.sqlite");
    std::fs::remove_file(&ledger).unwrap();
    symlink(other.path("out/ledger.sqlite"), &ledger).unwrap();
    refused(&at, &["audit", "query", "out", "SELECT 1"], &["leads out of the folder"]);
    std::fs::remove_file(&ledger).unwrap();
    pipe(&ledger);
    refused(&at, &["audit", "out"], &["ledger.sqlite", "is no regular file"]);
}

#[test]
fn a_pipe_in_a_folder_hangs_no_verify_no_audit_and_no_check() {
    let bench = Bench::done();
    let at = bench.path("");
    std::fs::remove_file(bench.path("out/asset.json")).unwrap();
    pipe(&bench.path("out/asset.json"));
    refused(&at, &["trace", "verify", "out/trace.mcap"], &["asset.json is no regular file"]);
    pipe(&bench.path("x.urdf"));
    let said = looked(&at, &["check", "x.urdf"]);
    assert_eq!(said.code, Some(1), "{said:?}");
    assert!(said.out.contains("`x.urdf` is not a file"), "{said:?}");
    let said = looked(&at, &["check", "out/asset.urdf", "--json"]);
    assert!(said.out.contains("asset.json is not a file"), "{said:?}");
    let batch = Batch::of(1);
    batch.ran(&[]);
    pipe(&batch.path("out/assets/k000/pipe"));
    refused(&batch.path(""), &["audit", "out"], &["k000: pipe is no regular file"]);
}

#[test]
fn links_in_circles_end_and_are_no_files_of_the_run() {
    let bench = Bench::done();
    for name in ["x", "y"] {
        symlink(".", bench.path("out/meshes").join(name)).unwrap();
    }
    let words = ["meshes/x is a link, which is not followed"];
    refused(&bench.path(""), &["trace", "verify", "out/trace.mcap"], &words);
    let batch = Batch::of(1);
    batch.ran(&[]);
    for name in ["x", "y"] {
        symlink(".", batch.path("out/assets/k000/meshes").join(name)).unwrap();
        symlink(".", batch.path("out").join(name)).unwrap();
    }
    let at = batch.path("");
    refused(&at, &["audit", "out"], &["meshes/x is a link", "meshes/y is a link"]);
    let said = looked(&at, &["store", "gc", "out", "--dry-run", "--keep", "out"]);
    assert_eq!(said.code, Some(0), "{said:?}");
}

#[test]
fn a_terabyte_of_nothing_is_refused_by_its_length_everywhere() {
    let bench = Bench::done();
    let at = bench.path("");
    let urdf = std::fs::read_to_string(bench.path("out/asset.urdf")).unwrap();
    let mesh = urdf.split('"').find(|w| w.starts_with("meshes/")).unwrap();
    std::fs::remove_file(bench.path("out").join(mesh)).unwrap();
    sparse(&bench.path("out").join(mesh));
    let words = [mesh, "has more than 1073741824 bytes"];
    refused(&at, &["trace", "verify", "out/trace.mcap"], &words);
    let said = looked(&at, &["check", "out/asset.urdf", "--json"]);
    assert!(said.out.contains("exceeds the 1 GiB"), "{said:?}");
    sparse(&bench.path("long.mcap"));
    for verb in ["show", "verify", "replay", "extract"] {
        refused(&at, &["trace", verb, "long.mcap"], &["long.mcap", "more than 1073741824 bytes"]);
    }
    refused(&at, &["trace", "diff", "long.mcap", "long.mcap"], &["more than 1073741824 bytes"]);
    sparse(&bench.path("long.urdf"));
    let said = looked(&at, &["check", "long.urdf"]);
    assert!(said.out.contains("at most 16777216 bytes"), "{said:?}");
}

#[test]
fn pipes_devices_and_folders_are_no_traces_to_any_verb() {
    let bench = Bench::new();
    pipe(&bench.path("pipe"));
    symlink("/dev/zero", bench.path("zero")).unwrap();
    std::fs::create_dir(bench.path("folder")).unwrap();
    let at = bench.path("");
    for name in ["pipe", "zero", "folder", "/dev/random"] {
        for verb in ["show", "verify", "replay", "extract"] {
            refused(&at, &["trace", verb, name], &[name, "is no regular file"]);
        }
        refused(&at, &["trace", "diff", name, name], &[name, "is no regular file"]);
        if name != "folder" {
            let args = ["batch", name, "--dry-run", "--out", "never"];
            refused(&at, &args, &[name, "is no regular file"]);
        }
    }
    assert!(!bench.path("never").exists());
}

#[test]
fn a_folder_of_models_is_looked_through_without_its_links_and_pipes() {
    let bench = Bench::new();
    let models = bench.path("models");
    std::fs::create_dir_all(models.join("a")).unwrap();
    std::fs::write(models.join("a/own.urdf"), "<robot name=\"r\"><link name=\"a\"/></robot>")
        .unwrap();
    std::fs::write(bench.path("secret.urdf"), "<robot name=\"secret\"/>").unwrap();
    symlink("../..", models.join("a/up")).unwrap();
    symlink("../../secret.urdf", models.join("a/out.urdf")).unwrap();
    symlink("own.urdf", models.join("a/in.urdf")).unwrap();
    pipe(&models.join("a/pipe.urdf"));
    let said = looked(&bench.path(""), &["check", "models"]);
    assert!(said.out.contains("models/a/own.urdf") && said.out.contains("a/in.urdf"), "{said:?}");
    assert!(said.out.contains("a/pipe.urdf") && !said.out.contains("out.urdf"), "{said:?}");
    assert!(said.out.ends_with("of 3 reach kinematic\n"), "{said:?}");
}

/// A URDF whose `asset.json` lists that file; what the check says at the tier `audited`.
fn audited(at: &Path, listed: &str) -> Value {
    let body = "<visual><geometry><box size='1 1 1'/></geometry></visual>";
    let urdf = format!("<robot name='r'><link name='a'>{body}</link></robot>");
    std::fs::write(at.join("x.urdf"), urdf).unwrap();
    let sidecar = json!({ "schema": "kinfold-asset/1", "files": { listed: "blake3:00" } });
    std::fs::write(at.join("asset.json"), sidecar.to_string()).unwrap();
    let said = looked(at, &["check", "x.urdf", "--tier", "audited", "--json"]);
    let verdict: Value = serde_json::from_str(&said.out).unwrap();
    let checks = verdict["checks"].as_array().unwrap();
    checks.iter().find(|c| c["id"] == "F4").unwrap().clone()
}

#[test]
fn a_hash_follows_no_link_out_of_the_package() {
    let bench = Bench::new();
    let at = bench.path("package");
    std::fs::create_dir(&at).unwrap();
    std::fs::write(bench.path("secret"), "of nobody's business").unwrap();
    symlink("../secret", at.join("h.bin")).unwrap();
    let f4 = audited(&at, "h.bin");
    let evidence = f4["evidence"].to_string();
    assert!(evidence.contains("leads out of the package through a link"), "{f4}");
    let digest = Digest::of(b"of nobody's business").to_string();
    assert!(!evidence.contains(&digest), "{f4}");
    for (name, to, rule) in [
        ("folder", bench.path(""), "leads out of the package"),
        ("zero", "/dev/zero".into(), "leads out of the package"),
        ("circle", "circle".into(), "cannot be opened"),
        ("gone", "nowhere".into(), "no such file"),
    ] {
        symlink(to, at.join(name)).unwrap();
        let name = if name == "folder" { "folder/secret" } else { name };
        let f4 = audited(&at, name);
        assert!(f4["evidence"].to_string().contains(rule), "{name}: {f4}");
    }
    sparse(&at.join("long"));
    assert!(audited(&at, "long")["evidence"].to_string().contains("exceeds the 1 GiB"));
    pipe(&at.join("pipe"));
    assert!(audited(&at, "pipe")["evidence"].to_string().contains("is not a file"));
    // Neither is the file itself one that lies elsewhere.
    std::fs::write(bench.path("other.urdf"), "<robot name='other'/>").unwrap();
    std::fs::remove_file(at.join("x.urdf")).unwrap();
    symlink("../other.urdf", at.join("x.urdf")).unwrap();
    let said = looked(&at, &["check", "x.urdf"]);
    assert!(said.out.contains("`x.urdf` leads out of its folder through a link"), "{said:?}");
    let said = looked(&at, &["check", "x.urdf", "--allow-outside"]);
    assert!(!said.out.contains("leads out of its folder"), "{said:?}");
    std::fs::remove_file(at.join("x.urdf")).unwrap();
    // A link within the package leads to a file of the package.
    std::fs::write(at.join("own"), "own").unwrap();
    symlink("own", at.join("inside")).unwrap();
    let f4 = audited(&at, "inside")["evidence"].to_string();
    assert!(f4.contains(Digest::of(b"own").as_str()), "{f4}");
}

#[test]
fn an_extracted_file_is_written_over_nothing_unless_that_is_meant() {
    let bench = Bench::done();
    let at = bench.path("work");
    std::fs::create_dir(&at).unwrap();
    std::fs::write(at.join("condition.json"), "mine").unwrap();
    let take = |more: &[&str]| {
        let args = [&["trace", "extract", "../out/trace.mcap", "condition.json"], more].concat();
        looked(&at, &args)
    };
    let said = take(&[]);
    assert_eq!(said.code, Some(1), "{said:?}");
    assert!(said.err.contains("condition.json is there already") && said.err.contains("--force"));
    assert_eq!(std::fs::read(at.join("condition.json")).unwrap(), b"mine");
    // A link, even one that leads nowhere, is not written through.
    symlink(at.join("condition.json"), at.join("link")).unwrap();
    symlink(bench.path("elsewhere"), at.join("dangling")).unwrap();
    assert_eq!(take(&["--out", "link"]).code, Some(1));
    assert_eq!(take(&["--out", "dangling"]).code, Some(1));
    assert_eq!(take(&["--out", "link", "--force"]).code, Some(0));
    assert_eq!(std::fs::read(at.join("condition.json")).unwrap(), b"mine", "the link was replaced");
    assert!(!bench.path("elsewhere").exists());
    assert_eq!(take(&["--force"]).code, Some(0));
    assert_eq!(
        std::fs::read(at.join("condition.json")).unwrap(),
        std::fs::read(at.join("link")).unwrap()
    );
}

#[test]
fn an_artefacts_name_leads_nowhere() {
    let bench = Bench::done();
    let at = bench.path("work");
    std::fs::create_dir(&at).unwrap();
    let before = tree(&bench.path(""));
    for name in ["..", "a/..", "/", "x\u{1b}[2J", ".profile", "a\nb", "C:\\x", "-rf"] {
        let mut reading = bench.trace();
        let event = forged::finished(&mut reading, "propose-condition");
        let mut odd = event.outputs[0].clone();
        odd.name = name.into();
        event.outputs.push(odd);
        forged::write(&bench.path("forged.mcap"), &reading);
        let said = looked(&at, &["trace", "extract", "../forged.mcap", "--", name]);
        assert_eq!(said.code, Some(1), "{name:?}: {said:?}");
        assert!(said.err.contains("no plain name of a file"), "{name:?}: {said:?}");
    }
    std::fs::remove_file(bench.path("forged.mcap")).unwrap();
    assert_eq!(tree(&bench.path("")), before);
}

#[test]
fn looking_leaves_every_folder_as_it_was() {
    let batch = Batch::of(2);
    batch.ran(&[]);
    // A writer that was killed leaves its log.
    let open = rusqlite::Connection::open(batch.path("out/state/run.sqlite")).unwrap();
    open.execute_batch("INSERT INTO runs (flow, version, started_ns) VALUES ('x', 'y', 1)")
        .unwrap();
    assert!(batch.path("out/state/run.sqlite-wal").exists());
    let before = tree(&batch.path(""));
    for args in [
        &["audit", "out"][..],
        &["audit", "query", "out", "SELECT * FROM items"],
        &["store", "verify", "out"],
        &["store", "gc", "out", "--dry-run", "--older-than", "0", "--keep", "out/assets"],
        &["batch", "items.jsonl", "--out", "out", "--dry-run"],
        &["batch", "items.jsonl", "--out", "new", "--dry-run"],
        &["batch", ".", "--out", "new", "--dry-run", "--state", "elsewhere"],
        &[
            "make",
            "photo.png",
            "--mesh",
            "cabinet.glb",
            "--condition",
            "cabinet.json",
            "--dry-run",
            "--state",
            "out/state",
        ],
        &["trace", "verify", "out/assets/k000/trace.mcap"],
        &["trace", "replay", "out/assets/k000/trace.mcap"],
        &["trace", "show", "out/assets/k000/trace.mcap"],
        &["trace", "diff", "out/assets/k000/trace.mcap", "out/assets/k001/trace.mcap"],
        &["trace", "extract", "out/assets/k000/trace.mcap"],
        &["check", "out/assets"],
        &["doctor", "--offline"],
    ] {
        let said = looked(&batch.path(""), args);
        assert!(matches!(said.code, Some(0 | 1 | 3)), "{args:?}: {said:?}");
        assert_eq!(tree(&batch.path("")), before, "{args:?} changed something");
    }
    drop(open);
}

#[test]
fn the_store_of_a_stranger_is_looked_through_and_nothing_else() {
    let batch = Batch::of(1);
    batch.ran(&[]);
    let cas = batch.path("out/state/cas");
    let blob = |name: &str| {
        let folder = cas.join(&name[..2]);
        std::fs::create_dir_all(&folder).unwrap();
        folder.join(&name[2..])
    };
    let secret = Digest::of(b"secret").to_string();
    std::fs::write(batch.path("secret"), "secret").unwrap();
    symlink(batch.path("secret"), blob(&secret)).unwrap();
    pipe(&blob(&"ab".repeat(32)));
    sparse(&blob(&"cd".repeat(32)));
    symlink("/", cas.join("ef")).unwrap();
    let before = tree(&batch.path(""));
    let said = looked(&batch.path(""), &["store", "verify", "out"]);
    assert_eq!(said.code, Some(3), "{said:?}");
    for damaged in [secret, "ab".repeat(32), "cd".repeat(32)] {
        assert!(said.err.contains(&format!("damaged: {damaged}")), "{said:?}");
    }
    let said = looked(&batch.path(""), &["store", "gc", "out", "--dry-run"]);
    assert_eq!(said.code, Some(0), "{said:?}");
    symlink(batch.path(""), batch.path("out/assets/up")).unwrap();
    let args = ["store", "gc", "out", "--dry-run", "--keep", "out/assets"];
    refused(&batch.path(""), &args, &["leads out of the folder"]);
    std::fs::remove_file(batch.path("out/assets/up")).unwrap();
    assert_eq!(tree(&batch.path("")), before);
}

#[test]
fn an_offline_doctor_asks_nobody_and_says_so() {
    let made = Made::cabinet();
    let asked = made.server.asked().len();
    let mut command = program();
    command.current_dir(made.path("")).args(["doctor", "--offline", "--json"]);
    command.args(["--config", "kinfold.toml", "--state"]).arg(made.path("nowhere"));
    let said: Said = command.output().unwrap().into();
    assert_eq!(said.code, Some(0), "{said:?}");
    assert!(said.err.contains("nobody was asked, no program was started, no key was sent"));
    let answer: Value = serde_json::from_str(&said.out).unwrap();
    assert_eq!(answer["offline"], true, "{answer}");
    assert_eq!(made.server.asked().len(), asked, "a server was asked");
    assert!(!made.path("nowhere").exists());
}

#[test]
fn a_deadline_and_a_cap_of_memory_end_every_look_and_are_named() {
    let bench = Bench::done();
    let trace = bench.path("out/trace.mcap").display().to_string();
    let said = say(&["trace", "replay", &trace, "--deadline", "0.001"]);
    assert_eq!(said.code, Some(1), "{said:?}");
    let words =
        "error: replaying the trace took longer than 0.001 s and was stopped\nhint: --deadline";
    assert!(said.err.contains(words), "{said:?}");
    assert_eq!(said.out, "");
}
