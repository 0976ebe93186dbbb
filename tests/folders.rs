//! Only our own files are deleted or replaced: a folder is ours by a marker that we wrote, never by
//! the names in it.

use std::collections::BTreeMap;
use std::path::Path;

use crate::batch::Batch;
use crate::kinfold::{Bench, CLOCK, Said, program};

/// Everything below a folder, links as where they lead to and never followed. SQLite's index of its
/// log counts by its name alone: whoever reads is noted in it.
pub fn tree(root: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![root.to_path_buf()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).into_iter().flatten() {
            let path = entry.unwrap().path();
            let name = path.strip_prefix(root).unwrap().to_string_lossy().into_owned();
            let about = std::fs::symlink_metadata(&path).unwrap();
            if about.is_symlink() {
                let target = std::fs::read_link(&path).unwrap();
                found.insert(format!("{name} ->"), target.to_string_lossy().into_owned().into());
            } else if about.is_dir() {
                found.insert(format!("{name}/"), vec![]);
                folders.push(path);
            } else if name.ends_with("-shm") {
                found.insert(name, vec![]);
            } else {
                found.insert(name, std::fs::read(&path).unwrap());
            }
        }
    }
    found
}

fn unchanged(root: &Path, before: &BTreeMap<String, Vec<u8>>, after_what: &str) {
    let after = tree(root);
    let names = |of: &BTreeMap<String, Vec<u8>>| of.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(&after), names(before), "after {after_what}");
    assert!(after == *before, "bytes changed after {after_what}");
}

fn put(path: &Path, bytes: impl AsRef<[u8]>) {
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    std::fs::write(path, bytes).unwrap();
}

/// Every command that takes a state directory, over a folder that is none.
fn refused_as_state(bench: &Bench, folder: &str) {
    let root = bench.path(folder);
    let before = tree(&root);
    let commands: [&[&str]; 9] = [
        &["store", "gc", "--dry-run", folder],
        &["store", "gc", folder],
        &["store", "verify", folder],
        &["store", "verify", "--repair", folder],
        &["make", "photo.png", "--mesh", "cabinet.glb", "--condition", "cabinet.json", "--dry-run"],
        &["make", "photo.png", "--mesh", "cabinet.glb", "--condition", "cabinet.json"],
        &["batch", "items.jsonl", "--out", "many", "--state", folder],
        &["batch", "items.jsonl", "--out", folder],
        &["batch", "items.jsonl", "--out", folder, "--dry-run"],
    ];
    for args in commands {
        let mut command = program();
        command.current_dir(bench.path("")).env("KINFOLD_STATE", &root);
        let said: Said = command.args(args).output().unwrap().into();
        let words = format!("{args:?}: {said:?}");
        assert_eq!(said.code, Some(1), "{words}");
        assert!(said.err.contains("no marker of ours") && said.err.contains("hint: "), "{words}");
        unchanged(&root, &before, &words);
    }
    assert!(!bench.path("photo.kinfold").exists(), "nothing was made");
}

fn with_items() -> Bench {
    let bench = Bench::new();
    put(&bench.path("items.jsonl"), Batch::given("k000", 0).to_string());
    bench
}

#[test]
fn any_folder_named_as_a_state_directory_keeps_its_tmp() {
    let bench = with_items();
    put(&bench.path("proj/tmp/thesis.txt"), "precious");
    refused_as_state(&bench, "proj");
}

#[test]
fn a_project_with_names_of_ours_is_no_state_directory() {
    let bench = with_items();
    put(&bench.path("proj/run.sqlite"), "no database");
    put(&bench.path("proj/lock"), "");
    put(&bench.path("proj/tmp/0123456789ab-1.partial"), "precious");
    put(&bench.path("proj/cas/ab").join("cd".repeat(31)), "precious");
    refused_as_state(&bench, "proj");
}

#[test]
fn somebody_elses_database_of_our_name_is_no_state_directory() {
    let bench = with_items();
    std::fs::create_dir(bench.path("proj")).unwrap();
    for name in ["run.sqlite", "ledger.sqlite"] {
        let db = rusqlite::Connection::open(bench.path("proj").join(name)).unwrap();
        db.execute_batch("CREATE TABLE runs (km REAL); INSERT INTO runs VALUES (42.2);").unwrap();
    }
    put(&bench.path("proj/tmp/thesis.txt"), "precious");
    refused_as_state(&bench, "proj");
}

#[test]
fn an_output_folder_is_no_state_directory() {
    let bench = Bench::done();
    put(&bench.path("items.jsonl"), Batch::given("k000", 0).to_string());
    refused_as_state(&bench, "out");
}

#[test]
fn a_store_that_is_somebody_elses_folder_is_refused() {
    let bench = with_items();
    put(&bench.path("proj/cas/photo.png"), "precious");
    let before = tree(&bench.path("proj"));
    let mut command = program();
    command.current_dir(bench.path("")).args(["batch", "items.jsonl", "--out", "many"]);
    let said: Said = command.args(["--store", "proj"]).output().unwrap().into();
    assert_eq!(said.code, Some(1), "{said:?}");
    assert!(said.err.contains("no shared store of kinfold"), "{said:?}");
    unchanged(&bench.path("proj"), &before, "a batch");
}

#[test]
fn looking_creates_nothing_even_where_a_kill_left_its_log() {
    let batch = Batch::of(1);
    let began = std::time::Instant::now();
    batch.ran(&[]);
    let whole = began.elapsed();
    batch.write("more.jsonl", format!("{}\n", Batch::given("k900", 9)));
    let args = ["batch", "more.jsonl", "--out", "out", "--clock", CLOCK, "--quiet"];
    let mut killed = batch.kinfold(&args).spawn().unwrap();
    std::thread::sleep(whole.mul_f64(0.3));
    // It may have ended by itself.
    let _ = killed.kill();
    killed.wait().unwrap();
    let before = tree(&batch.path("out"));
    let commands: [&[&str]; 5] = [
        &["store", "gc", "--dry-run", "out"],
        &["store", "verify", "out"],
        &["batch", "more.jsonl", "--out", "out", "--dry-run"],
        &["audit", "out"],
        &["audit", "query", "out", "SELECT count(*) FROM items"],
    ];
    for args in commands {
        let said = batch.say(args);
        assert!(said.code != Some(2), "{args:?}: {said:?}");
        unchanged(&batch.path("out"), &before, &format!("{args:?}"));
    }
}

/// A make into a folder that is not ours: refused, and everything stays.
fn refused_as_out(bench: &Bench, more: &[&str]) {
    let before = tree(&bench.path("out"));
    for photo in ["photo.png", "cabinet.json"] {
        let mut command = program();
        command.current_dir(bench.path("")).env("KINFOLD_STATE", bench.path("state"));
        command.args(["make", photo, "--mesh", "cabinet.glb", "--condition", "cabinet.json"]);
        let said: Said = command.args(["--out", "out"]).args(more).output().unwrap().into();
        assert_eq!(said.code, Some(1), "{said:?}");
        assert!(
            said.err.contains("hint: choose a new or an empty folder with --out DIR"),
            "{said:?}"
        );
        unchanged(&bench.path("out"), &before, photo);
    }
}

#[test]
fn a_file_called_trace_mcap_does_not_make_a_folder_ours() {
    let bench = Bench::new();
    put(&bench.path("out/trace.mcap"), "bag");
    put(&bench.path("out/meshes/mine.stl"), "mine");
    refused_as_out(&bench, &[]);
    refused_as_out(&bench, &["--dry-run"]);
}

#[test]
fn a_robots_own_recording_does_not_make_a_folder_ours() {
    let bench = Bench::new();
    std::fs::create_dir(bench.path("out")).unwrap();
    let manifest = trace::Manifest {
        run_id: "7".into(),
        flow: "patrol".into(),
        version: "1".into(),
        seed: 0,
        inputs: BTreeMap::new(),
        parameters: BTreeMap::new(),
    };
    let path = bench.path("out/trace.mcap");
    trace::Recorder::create(&path, &manifest, 1).unwrap().finish().unwrap();
    put(&bench.path("out/views/mine.png"), "mine");
    refused_as_out(&bench, &[]);
}

#[test]
fn a_damaged_trace_does_not_make_a_folder_ours() {
    let bench = Bench::done();
    std::fs::remove_file(bench.path("out/.kinfold")).unwrap();
    let mut bytes = std::fs::read(bench.path("out/trace.mcap")).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(bench.path("out/trace.mcap"), bytes).unwrap();
    refused_as_out(&bench, &[]);
}

#[test]
fn a_folder_with_nothing_but_notes_is_refused_too() {
    let bench = Bench::new();
    put(&bench.path("out/notes.txt"), "mine");
    refused_as_out(&bench, &[]);
    // An empty one is nobody's.
    std::fs::remove_file(bench.path("out/notes.txt")).unwrap();
    assert_eq!(bench.made(&[]).code, Some(0));
}

#[cfg(unix)]
#[test]
fn no_link_in_an_output_folder_is_followed() {
    let bench = Bench::done();
    put(&bench.path("far/precious"), "mine");
    let link = |to: &str, name: &str| {
        std::os::unix::fs::symlink(bench.path(to), bench.path(name)).unwrap();
    };
    link("far/precious", "out/trace.mcap.partial");
    link("far/precious", "out/asset.usda");
    link("far", "out/more");
    let said = bench.made(&["--seed", "5"]);
    assert_eq!(said.code, Some(0), "{said:?}");
    // A link in the place of a file or folder of ours is in the way, and nothing is written through it.
    let before = bench.out();
    let said = bench.made(&["--export", "usd"]);
    assert_eq!(said.code, Some(1), "{said:?}");
    assert!(said.err.contains("asset.usda stands where the asset has a file"), "{said:?}");
    assert!(said.err.contains("hint: move it somewhere else, or"), "{said:?}");
    assert!(bench.out() == before);
    std::fs::remove_dir_all(bench.path("out/meshes")).unwrap();
    link("far", "out/meshes");
    let said = bench.made(&[]);
    assert_eq!(said.code, Some(1), "{said:?}");
    let far = tree(&bench.path("far"));
    assert_eq!(far.into_iter().collect::<Vec<_>>(), [("precious".to_owned(), b"mine".to_vec())]);
    let links = ["out/trace.mcap.partial", "out/asset.usda", "out/more", "out/meshes"];
    assert!(links.iter().all(|name| bench.path(name).symlink_metadata().unwrap().is_symlink()));
}

#[test]
fn files_of_others_in_an_output_folder_stay_where_they_are() {
    let bench = Bench::done();
    let theirs = ["notes.txt", "meshes/mine.stl", "paper/fig/1.svg", ".git/HEAD"];
    for name in theirs {
        put(&bench.path("out").join(name), name);
    }
    std::fs::create_dir(bench.path("out/empty")).unwrap();
    let stay = || {
        for name in theirs {
            assert_eq!(std::fs::read_to_string(bench.path("out").join(name)).unwrap(), name);
        }
        assert!(bench.path("out/empty").is_dir() && bench.path("out/asset.urdf").is_file());
    };
    let said = bench.made(&["--seed", "5"]);
    assert_eq!(said.code, Some(0), "{said:?}");
    stay();
    let mesh = std::fs::read(&bench.cabinet.mesh).unwrap();
    std::fs::remove_file(&bench.cabinet.mesh).unwrap();
    assert_eq!(bench.made(&["--seed", "6"]).code, Some(1));
    stay();
    std::fs::write(&bench.cabinet.mesh, mesh).unwrap();
    let trace = bench.path("out/trace.mcap").display().to_string();
    std::fs::remove_file(bench.path("out/meshes/mine.stl")).unwrap();
    let said = crate::kinfold::say(&["trace", "verify", &trace]);
    assert_eq!(said.code, Some(0), "{said:?}");
}

/// Names of ours in a folder without a marker were taken for files of version 0.1.0, and deleted.
#[cfg(unix)]
#[test]
fn a_folder_in_an_items_place_is_ours_by_what_it_holds_and_never_by_its_names() {
    let batch = Batch::of(1);
    batch.ran(&[]);
    put(&batch.path("out/assets/mine/meshes/thesis.obj"), "thesis");
    put(&batch.path("out/assets/mine/asset.urdf"), "mine");
    put(&batch.path("out/quarantine/bad/views/front.png"), "mine");
    put(&batch.path("out/unfinished/left/asset.urdf"), "mine");
    put(&batch.path("far/meshes/thesis.obj"), "thesis");
    put(&batch.path("far/notes.txt"), "notes");
    std::fs::rename(batch.path("out/assets/k000"), batch.path("k000")).unwrap();
    std::os::unix::fs::symlink(batch.path("far"), batch.path("out/assets/k000")).unwrap();
    let assets = || {
        ["out/assets", "out/quarantine", "out/unfinished", "far"].map(|at| tree(&batch.path(at)))
    };
    let before = assets();
    for (id, found) in [
        ("mine", "no marker of ours"),
        ("bad", "no marker of ours"),
        ("left", "no marker of ours"),
        ("k000", "is no folder"),
    ] {
        batch.write("items.jsonl", Batch::given(id, 7).to_string());
        let said: Said = batch.batch(&[]).output().unwrap().into();
        assert!(said.code == Some(1) && said.err.contains(found), "{id}: {said:?}");
        assert!(assets() == before, "{id} changed what is not ours");
    }
}

#[test]
fn items_of_version_0_1_0_are_ours_by_their_trace() {
    let batch = Batch::of(1);
    batch.ran(&[]);
    std::fs::remove_file(batch.path("out/assets/k000/.kinfold")).unwrap();
    put(&batch.path("out/assets/k000/notes.txt"), "notes");
    let (said, _) = batch.ran(&["--seed", "9", "--export", "glb"]);
    assert_eq!(said.code, Some(0), "{said:?}");
    assert!(batch.path("out/assets/k000/asset.glb").exists());
    assert_eq!(std::fs::read_to_string(batch.path("out/assets/k000/notes.txt")).unwrap(), "notes");
}

#[cfg(unix)]
#[test]
fn a_link_for_a_folder_of_the_state_is_not_written_through() {
    let bench = Bench::done();
    put(&bench.path("far/precious"), "mine");
    std::fs::remove_dir_all(bench.path("state/cas")).unwrap();
    std::os::unix::fs::symlink(bench.path("far"), bench.path("state/cas")).unwrap();
    let said = bench.made(&["--seed", "5"]);
    assert!(said.code == Some(1) && said.err.contains("`cas`, a link"), "{said:?}");
    assert_eq!(tree(&bench.path("far")).len(), 1);
}

#[test]
fn the_shelf_of_failed_runs_is_no_state_directory_and_is_never_full() {
    let bench = Bench::done();
    let before = tree(&bench.path("out"));
    let mut command = program();
    command.current_dir(bench.path("")).env("KINFOLD_STATE", bench.path("out.failed"));
    command.args(["make", "photo.png", "--mesh", "cabinet.glb", "--condition", "cabinet.json"]);
    let said: Said = command.args(["--out", "out"]).output().unwrap().into();
    assert!(said.code == Some(2) && said.err.contains("that of its failed runs"), "{said:?}");
    assert!(tree(&bench.path("out")) == before && !bench.path("out.failed").exists());
    // A number that is as large as it gets, left by whomever.
    std::fs::rename(bench.path("cabinet.json"), bench.path("elsewhere.json")).unwrap();
    assert_eq!(bench.made(&[]).code, Some(1));
    std::fs::rename(bench.path("out.failed/1"), bench.path("out.failed/4294967295")).unwrap();
    for number in 1..3 {
        assert_eq!(bench.made(&[]).code, Some(1));
        assert!(bench.path(&format!("out.failed/{number}/trace.mcap")).exists());
    }
    std::fs::rename(bench.path("elsewhere.json"), bench.path("cabinet.json")).unwrap();
    assert_eq!(bench.made(&[]).code, Some(0));
}

#[test]
fn folders_of_version_0_1_0_count_as_ours_and_get_their_marker() {
    let bench = Bench::done();
    let before = bench.out();
    for folder in ["out", "state"] {
        std::fs::remove_file(bench.path(folder).join(".kinfold")).unwrap();
    }
    put(&bench.path("out/meshes/mine.stl"), "mine");
    let said = bench.made(&[]);
    assert_eq!(said.code, Some(0), "{said:?}");
    let mut after = bench.out();
    assert_eq!(after.remove("meshes/mine.stl").as_deref(), Some(&b"mine"[..]));
    assert!(after == before);
    assert!(bench.path("state/.kinfold").exists());
    assert_eq!(bench.finished("articulate"), 1, "and what was done is found again");
}

#[test]
fn a_failed_run_of_version_0_1_0_counts_as_ours() {
    let bench = Bench::new();
    std::fs::remove_file(&bench.cabinet.mesh).unwrap();
    assert_eq!(bench.made(&[]).code, Some(1));
    std::fs::rename(bench.path("out.failed/1"), bench.path("out")).unwrap();
    std::fs::remove_file(bench.path("out/.kinfold")).unwrap();
    put(&bench.path("out/notes.txt"), "mine");
    crate::cabinet::Cabinet::write(&bench.path(""));
    let said = bench.made(&[]);
    assert_eq!(said.code, Some(0), "{said:?}");
    assert_eq!(bench.out()["notes.txt"], b"mine");
}

#[cfg(unix)]
#[test]
fn an_output_folder_that_nothing_can_replace_is_refused_before_any_work() {
    let bench = Bench::done();
    put(&bench.path("file"), "mine");
    std::os::unix::fs::symlink(bench.path("nowhere"), bench.path("dangling")).unwrap();
    std::os::unix::fs::symlink(bench.path("out"), bench.path("link")).unwrap();
    put(&bench.path("other.failed/mine.txt"), "mine");
    let say = |args: &[&str]| -> Said {
        let mut command = program();
        command.current_dir(bench.path("")).args(["make", "photo.png", "--mesh", "cabinet.glb"]);
        command.args(["--condition", "cabinet.json", "--state", "state", "--clock", CLOCK]);
        command.args(args).output().unwrap().into()
    };
    let before = tree(&bench.path(""));
    for (out, words) in [
        (".", "is the folder you work in"),
        ("..", "is the folder you work in"),
        ("/", "nothing can take its place"),
        ("file", "is no folder"),
        ("dangling", "is a link that leads nowhere"),
        ("other", "other.failed holds `mine.txt` and no marker of ours"),
    ] {
        let said = say(&["--out", out]);
        assert_eq!(said.code, Some(1), "{out}: {said:?}");
        assert!(said.err.contains(words) && said.err.contains("hint: "), "{out}: {said:?}");
    }
    let said = say(&["--out", "out", "--state", "out/state"]);
    assert_eq!(said.code, Some(2), "{said:?}");
    unchanged(&bench.path(""), &before, "nine refusals");
    // A link that a person names is the folder that it leads to.
    let said = say(&["--out", "link", "--seed", "5"]);
    assert_eq!(said.code, Some(0), "{said:?}");
    assert!(bench.path("link").symlink_metadata().unwrap().is_symlink());
    assert!(bench.out()["trace.mcap"] != before["out/trace.mcap"]);
}
