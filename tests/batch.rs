//! `kinfold batch`: nothing lost, nothing repeated, everything said.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::{Value, json};

use crate::cabinet::Cabinet;
use crate::kinfold::{CLOCK, Said, files, names, program_in};

/// A folder with a cabinet's files, a manifest, and room for a batch.
pub struct Batch {
    folder: tempfile::TempDir,
}

impl Batch {
    /// Items that differ by their seed, each with mesh and condition given.
    pub fn of(items: usize) -> Self {
        let this = Self { folder: tempfile::tempdir().unwrap() };
        Cabinet::write(this.folder.path());
        let line = |n| format!("{}\n", Self::given(&format!("k{n:03}"), n));
        this.write("items.jsonl", (0..items).map(line).collect::<String>());
        this
    }

    /// A line whose answers are files.
    pub fn given(id: &str, seed: usize) -> Value {
        json!({ "id": id, "photo": "photo.png", "mesh": "cabinet.glb", "condition": "cabinet.json",
            "seed": seed, "category": "cabinet", "license": "CC0-1.0" })
    }

    /// A path in the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Writes a file.
    pub fn write(&self, name: &str, text: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), text).unwrap();
    }

    /// A configuration whose generator is a shell script of that body: `$1` is the mesh to write, `$2`
    /// the seed.
    pub fn with_generator(&self, body: &str) {
        let config = format!(
            "[image_to_3d]\nprovider = \"command\"\nprogram = \"sh\"\narguments = [\"-c\", {body:?}, \"sh\", \"{{mesh}}\", \"{{seed}}\"]\n"
        );
        self.write("kinfold.toml", config);
    }

    /// `kinfold` in the folder.
    pub fn kinfold(&self, args: &[&str]) -> Command {
        let mut command = program_in(self.folder.path());
        command.args(args);
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    /// Runs `kinfold` in the folder.
    pub fn say(&self, args: &[&str]) -> Said {
        self.kinfold(args).output().unwrap().into()
    }

    /// `kinfold batch` of the manifest into `out`.
    pub fn batch(&self, more: &[&str]) -> Command {
        let mut command = self.kinfold(&["batch", "items.jsonl", "--out", "out", "--clock", CLOCK]);
        command.args(more);
        command
    }

    /// Runs the batch; its answer as JSON.
    pub fn ran(&self, more: &[&str]) -> (Said, Value) {
        let said: Said = self.batch(more).arg("--json").output().unwrap().into();
        let answer = serde_json::from_str(&said.out).unwrap_or_else(|e| panic!("{e}: {said:?}"));
        (said, answer)
    }

    /// All accepted assets' files.
    pub fn assets(&self) -> BTreeMap<String, Vec<u8>> {
        files(&self.path("out/assets"))
    }

    /// One value out of the ledger.
    pub fn ask(&self, sql: &str) -> String {
        let said = self.say(&["audit", "query", "out", sql]);
        assert_eq!(said.code, Some(0), "{said:?}");
        said.out.lines().nth(1).unwrap_or_default().to_owned()
    }

    /// Results that were committed more than once.
    pub fn repeated(&self) -> i64 {
        let db = rusqlite::Connection::open(self.path("out/state/run.sqlite")).unwrap();
        db.query_row("SELECT count(*) FROM repeated", [], |r| r.get(0)).unwrap()
    }
}

/// A number of an answer.
pub fn number(answer: &Value, name: &str) -> u64 {
    answer[name].as_u64().unwrap_or_else(|| panic!("no {name} in {answer}"))
}

/// The same files, byte for byte.
pub fn same(one: &BTreeMap<String, Vec<u8>>, other: &BTreeMap<String, Vec<u8>>) {
    assert_eq!(names(one), names(other));
    let differ: Vec<_> = one.iter().filter(|(n, b)| other[*n] != **b).map(|(n, _)| n).collect();
    assert!(differ.is_empty(), "{differ:?} differ");
}

#[test]
fn a_batch_leaves_one_folder_per_asset_as_make_writes_it() {
    let batch = Batch::of(2);
    let (said, answer) = batch.ran(&["--pages"]);
    assert_eq!(said.code, Some(0), "{said:?}");
    assert_eq!([number(&answer, "accepted"), number(&answer, "planned")], [2, 2]);
    let args = ["make", "photo.png", "--mesh", "cabinet.glb", "--condition", "cabinet.json"];
    let made = batch.say(
        &[&args[..], &["--seed", "1", "--clock", CLOCK, "--state", "s", "--out", "made"]].concat(),
    );
    assert_eq!(made.code, Some(0), "{made:?}");
    let mut ours = files(&batch.path("out/assets/k001"));
    let statement: Value =
        serde_json::from_slice(&ours.remove("attestation.json").unwrap()).unwrap();
    let mut theirs = files(&batch.path("made"));
    // The marker lists what we wrote, and so the statement, too.
    for files in [&mut ours, &mut theirs] {
        assert!(files.remove(".kinfold").is_some());
    }
    same(&ours, &theirs);
    assert_eq!(statement["predicate"]["license"], "CC0-1.0");
    assert!(statement["predicate"]["origins"]["user"].as_u64().unwrap() > 0);
    assert_eq!(statement["subject"].as_array().unwrap().len(), ours.len());
}

#[test]
fn the_same_batch_again_does_nothing() {
    let batch = Batch::of(2);
    batch.ran(&[]);
    let before = files(&batch.path("out/assets"));
    let (said, answer) = batch.ran(&[]);
    assert_eq!((said.code, &answer["this_run"]["items"]), (Some(0), &json!(0)));
    assert_eq!(answer["this_run"]["resumed"], true);
    same(&before, &batch.assets());
}

/// Its items were others, were made again, and what was signed was signed no more.
#[test]
fn a_manifest_named_otherwise_is_the_same_manifest() {
    let batch = Batch::of(2);
    batch.ran(&[]);
    let before = files(&batch.path("out/assets"));
    let (whole, elsewhere) = (batch.path("items.jsonl"), batch.path("elsewhere"));
    std::fs::create_dir(&elsewhere).unwrap();
    for (folder, manifest, out) in [
        (batch.path(""), "./items.jsonl", "out"),
        (batch.path(""), whole.to_str().unwrap(), "out"),
        (elsewhere, "../items.jsonl", "../out"),
    ] {
        let mut again =
            batch.kinfold(&["batch", manifest, "--out", out, "--clock", CLOCK, "--json"]);
        let said: Said = again.current_dir(folder).output().unwrap().into();
        let answer: Value = serde_json::from_str(&said.out).unwrap();
        assert_eq!(answer["this_run"]["items"], 0, "{manifest}: {said:?}");
    }
    same(&files(&batch.path("out/assets")), &before);
    assert_eq!(batch.ask("SELECT count(*) FROM outcomes"), "2");
}

#[test]
fn a_dry_run_tells_which_lines_are_no_items() {
    let batch = Batch::of(1);
    let mut lines = std::fs::read_to_string(batch.path("items.jsonl")).unwrap();
    lines.push_str("{\"id\": \"gone\", \"photo\": \"gone.png\"}\n");
    batch.write("items.jsonl", lines);
    let said: Said = batch.batch(&["--dry-run"]).output().unwrap().into();
    assert_eq!(said.code, Some(3), "{said:?}");
    assert!(said.err.contains("line 2: photo ") && said.err.contains("is not there"), "{said:?}");
}

#[test]
fn a_bad_line_is_told_with_its_number_and_the_rest_goes_on() {
    let batch = Batch::of(0);
    let mut gone = Batch::given("gone", 1);
    gone["photo"] = "nowhere.png".into();
    let good = Batch::given("good", 1);
    batch.write("items.jsonl", format!("{good}\nnot an item\n{gone}\n{good}\n"));
    let (said, answer) = batch.ran(&[]);
    assert_eq!(said.code, Some(3), "{said:?}");
    assert_eq!([number(&answer, "accepted"), number(&answer, "bad_lines")], [1, 3]);
    assert!(said.err.contains("line 2: expected an item as JSON"), "{}", said.err);
    assert!(said.err.contains("line 3: photo nowhere.png is not there"), "{}", said.err);
    assert!(said.err.contains("line 4: the id `good` stands in line 1 already"), "{}", said.err);
    let again = batch.say(&["batch", "items.jsonl", "--out", "out", "--clock", CLOCK]);
    assert_eq!(again.code, Some(3), "bad lines are told each time: {again:?}");
    assert_eq!(again.out, "accepted   1\nbad lines  3\n");
}

#[test]
fn what_is_not_accepted_lies_in_quarantine_with_its_reason() {
    let batch = Batch::of(1);
    batch.write("no.png", "no picture");
    batch.write("broken.json", "{\"schema\": \"kinfold-condition/1\", \"parts\": []}");
    let mut broken = Batch::given("broken", 1);
    broken["condition"] = "broken.json".into();
    let mut blind = Batch::given("blind", 1);
    blind["photo"] = "no.png".into();
    let mut text = std::fs::read_to_string(batch.path("items.jsonl")).unwrap();
    text.push_str(&format!("{broken}\n{blind}\n"));
    batch.write("items.jsonl", text);
    let (said, answer) = batch.ran(&[]);
    assert_eq!(said.code, Some(3));
    assert_eq!(answer["this_run"]["classes"], json!({ "input": 2 }));
    let reason = |id: &str| -> Value {
        let path = batch.path("out/quarantine").join(id).join("reason.json");
        serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
    };
    assert_eq!(reason("broken")["stage"], "propose-condition");
    assert!(reason("blind")["reason"].as_str().unwrap().contains("must be a PNG, JPEG or WebP"));
    assert!(batch.path("out/quarantine/broken/trace.mcap").exists());
    assert_eq!(names(&batch.assets()).iter().filter(|n| n.ends_with("asset.urdf")).count(), 1);
    // What a failed item left is as much of the record as an asset is.
    for file in ["broken/trace.mcap", "broken/reason.json", "blind/reason.json"] {
        let path = batch.path("out/quarantine").join(file);
        let whole = std::fs::read(&path).unwrap();
        assert_eq!(batch.say(&["audit", "out"]).code, Some(0));
        std::fs::write(&path, b"another").unwrap();
        let changed = batch.say(&["audit", "out"]);
        let told = format!("quarantine/{file} is not the one the ledger names");
        assert!(changed.code == Some(1) && changed.err.contains(&told), "{changed:?}");
        std::fs::remove_file(&path).unwrap();
        assert_eq!(batch.say(&["audit", "out"]).code, Some(1), "{file} is gone");
        std::fs::write(&path, whole).unwrap();
    }
    let (_, again) = batch.ran(&[]);
    assert_eq!(again["this_run"]["items"], 0, "what fails for good is not tried again by itself");
    let whole = std::fs::read(batch.path("cabinet.json")).unwrap();
    batch.write("broken.json", whole);
    let (_, again) = batch.ran(&["--retry", "input"]);
    assert_eq!(again["this_run"]["items"], 2);
    assert_eq!(number(&again, "accepted"), 2);
    assert!(!batch.path("out/quarantine/broken").exists());
}

/// A configuration whose generator is a shell script of that body, and items without meshes.
fn with_program(items: usize, body: &str) -> Batch {
    let batch = Batch::of(0);
    let line = |n: usize| {
        let mut line = Batch::given(&format!("k{n:03}"), n);
        line.as_object_mut().unwrap().remove("mesh");
        format!("{line}\n")
    };
    batch.write("items.jsonl", (0..items).map(line).collect::<String>());
    let body = body.replace("MESH", &batch.path("cabinet.glb").display().to_string());
    let body = body.replace("LOG", &batch.path("calls.log").display().to_string());
    batch.with_generator(&body);
    batch
}

fn log(batch: &Batch) -> Vec<String> {
    let text = std::fs::read_to_string(batch.path("calls.log")).unwrap_or_default();
    text.lines().map(String::from).collect()
}

#[cfg(unix)]
#[test]
fn no_more_calls_run_at_once_than_may_and_each_is_made_once() {
    let batch = with_program(6, "echo + >> LOG; sleep 0.2; cp MESH \"$1\"; echo - >> LOG");
    let (said, answer) = batch.ran(&["--mesh-calls", "2"]);
    assert_eq!(said.code, Some(0), "{said:?}");
    assert_eq!([number(&answer, "accepted"), number(&answer, "calls")], [6, 6]);
    let (mut now, mut most) = (0, 0);
    for line in log(&batch) {
        now += if line == "+" { 1 } else { -1 };
        most = most.max(now);
    }
    assert_eq!((now, most), (0, 2));
    assert_eq!(batch.repeated(), 0);
}

#[cfg(unix)]
#[test]
fn a_spent_budget_stops_the_batch_and_a_larger_one_goes_on() {
    let batch = with_program(4, "echo $2 >> LOG; cp MESH \"$1\"");
    let prices = ["--mesh-price", "0.5", "--mesh-calls", "1", "--max-cost"];
    let (said, answer) = batch.ran(&[&prices[..], &["1"]].concat());
    assert_eq!(said.code, Some(3), "{said:?}");
    assert_eq!(number(&answer, "calls"), 2);
    assert_eq!([number(&answer, "accepted"), number(&answer, "left")], [2, 2]);
    assert!(said.err.contains("hint: the same command with a larger --max-calls"), "{}", said.err);
    let (said, answer) = batch.ran(&[&prices[..], &["9"]].concat());
    assert_eq!(said.code, Some(0), "{said:?}");
    assert_eq!((number(&answer, "accepted"), answer["cost"].as_f64()), (4, Some(2.0)));
    let mut calls = log(&batch);
    calls.sort();
    assert_eq!(calls, ["0", "1", "2", "3"], "no call was made twice");
}

#[cfg(unix)]
#[test]
fn a_provider_that_fails_for_good_is_asked_once_and_the_others_finish() {
    let batch = with_program(3, "echo $2 >> LOG; [ \"$2\" != 1 ] && cp MESH \"$1\"");
    let (said, answer) = batch.ran(&[]);
    assert_eq!(said.code, Some(3), "{said:?}");
    assert_eq!([number(&answer, "accepted"), number(&answer, "failed")], [2, 1]);
    assert_eq!(answer["this_run"]["classes"], json!({ "provider": 1 }));
    assert_eq!(log(&batch).len(), 3);
}

#[test]
fn items_that_nobody_can_make_are_a_misuse_before_any_work() {
    let batch = Batch::of(0);
    batch.write("items.jsonl", "{\"photo\": \"photo.png\"}\n");
    let said = batch.say(&["batch", "items.jsonl", "--out", "out"]);
    assert_eq!(said.code, Some(2), "{said:?}");
    assert!(said.err.contains("nobody to ask for a mesh, which 1 items need"), "{}", said.err);
    assert!(said.err.contains("hint: name who is to be asked in kinfold.toml"), "{}", said.err);
}

#[test]
fn a_dry_run_says_what_would_be_asked_for_and_changes_nothing() {
    let batch = with_program(3, "cp MESH \"$1\"");
    let (said, answer) = batch.ran(&["--dry-run", "--mesh-price", "0.2"]);
    assert_eq!(said.code, Some(0), "{said:?}");
    assert_eq!([number(&answer, "items"), number(&answer, "todo")], [3, 3]);
    assert_eq!(answer["calls"], json!({ "mesh": 3, "condition": 0 }));
    assert!((answer["cost"].as_f64().unwrap() - 0.6).abs() < 1e-9);
    assert!(!batch.path("out").exists());
    batch.ran(&[]);
    let (_, answer) = batch.ran(&["--dry-run"]);
    assert_eq!([number(&answer, "settled"), number(&answer, "todo")], [3, 0]);
}

#[cfg(unix)]
#[test]
fn a_batch_killed_at_any_moment_gives_the_bytes_of_an_undisturbed_one() {
    let undisturbed = Batch::of(4);
    let began = std::time::Instant::now();
    undisturbed.ran(&[]);
    killed(&Batch::of(4), began.elapsed(), 4, &undisturbed.assets());
}

/// Kills a batch some times at moments that look like chance, then lets it finish.
pub fn killed(
    batch: &Batch,
    whole: std::time::Duration,
    times: u32,
    expected: &BTreeMap<String, Vec<u8>>,
) {
    for n in 1..=times {
        let mut child = batch.batch(&["--quiet"]).spawn().unwrap();
        let share = (f64::from(n) * 0.618_033_988_749_894_9).fract();
        std::thread::sleep(whole.mul_f64(share * 0.6));
        // It may have ended by itself.
        let _ = child.kill();
        child.wait().unwrap();
    }
    let (said, _) = batch.ran(&[]);
    assert_eq!(said.code, Some(0), "{said:?}");
    same(expected, &batch.assets());
    assert_eq!(batch.repeated(), 0, "a committed result was made again");
    let audit = batch.say(&["audit", "out"]);
    assert_eq!(audit.code, Some(0), "{audit:?}");
}

#[cfg(unix)]
#[test]
fn ctrl_c_lets_running_stages_finish_and_the_same_command_goes_on() {
    let batch = Batch::of(4);
    let child = batch.batch(&[]).spawn().unwrap();
    std::thread::sleep(std::time::Duration::from_millis(400));
    interrupt(child.id());
    let said: Said = child.wait_with_output().unwrap().into();
    if said.code == Some(130) {
        assert!(said.err.contains("interrupted; the same command goes on from there"), "{said:?}");
    }
    assert_eq!(batch.ran(&[]).0.code, Some(0));
    assert_eq!(batch.repeated(), 0);
}

#[cfg(unix)]
#[test]
fn a_second_ctrl_c_ends_the_batch_at_once_and_loses_nothing() {
    let batch = Batch::of(4);
    let child = batch.batch(&[]).spawn().unwrap();
    std::thread::sleep(std::time::Duration::from_millis(400));
    interrupt(child.id());
    std::thread::sleep(std::time::Duration::from_millis(10));
    interrupt(child.id());
    let said: Said = child.wait_with_output().unwrap().into();
    assert!(matches!(said.code, Some(130 | 0) | None), "{said:?}");
    assert_eq!(batch.ran(&[]).0.code, Some(0));
    assert_eq!(batch.repeated(), 0);
}

#[cfg(unix)]
pub fn interrupt(pid: u32) {
    Command::new("kill").args(["-INT", &pid.to_string()]).status().unwrap();
}

#[test]
fn a_second_batch_in_one_folder_or_one_state_directory_that_may_not_wait_is_refused() {
    let batch = Batch::of(1);
    batch.ran(&[]);
    let held = runner::StateDir::open(&batch.path("out/state")).unwrap();
    let said = batch.say(&["batch", "items.jsonl", "--out", "out", "--no-wait"]);
    assert_eq!(said.code, Some(1));
    assert!(said.err.contains("state directory out/state is in use by process"), "{}", said.err);
    drop(held);
    let turns = runner::ours::Turns::AT_ONCE;
    let held = workflow::batch::folder::BatchFolder::open(&batch.path("out"), turns).unwrap();
    let args = ["batch", "items.jsonl", "--out", "out", "--state", "other", "--no-wait"];
    let said = batch.say(&args);
    assert!(said.err.contains("batch out is in use by process"), "{}", said.err);
    drop(held);
    assert_eq!(batch.ran(&[]).0.code, Some(0));
}

#[test]
fn shards_share_the_work_and_the_report_has_them_all() {
    let batch = Batch::of(5);
    let mut ids = Vec::new();
    for shard in ["0/2", "1/2"] {
        let (said, answer) = batch.ran(&["--shard", shard]);
        assert_eq!(said.code, Some(0), "{said:?}");
        ids.push(number(&answer, "accepted"));
    }
    assert_eq!(ids.iter().sum::<u64>(), 5);
    let said = batch.say(&["batch", "report", "out", "--json"]);
    let report: Value = serde_json::from_str(&said.out).unwrap();
    assert_eq!(number(&report, "accepted"), 5);
    let audit = batch.say(&["audit", "out", "--json"]);
    assert_eq!(audit.code, Some(0), "{audit:?}");
}

#[test]
fn machines_that_share_a_store_make_each_stage_once() {
    let (one, other) = (Batch::of(2), Batch::of(2));
    let store = one.path("shared");
    let shared = ["--store", store.to_str().unwrap()];
    let (said, first) = one.ran(&shared);
    assert_eq!(said.code, Some(0), "{said:?}");
    assert!(number(&first["this_run"], "stages_run") > 0);
    let (said, second) = other.ran(&shared);
    assert_eq!(said.code, Some(0), "{said:?}");
    assert_eq!(number(&second["this_run"], "stages_run"), 0, "{second}");
    same(&one.assets(), &other.assets());
}

#[test]
fn a_blob_that_rotted_is_found_and_only_its_stage_is_made_again() {
    let batch = Batch::of(2);
    batch.ran(&[]);
    let before = batch.assets();
    let blobs = batch.path("out/state/cas");
    let all = files(&blobs);
    let (largest, _) = all.iter().max_by_key(|(_, bytes)| bytes.len()).unwrap();
    std::fs::write(blobs.join(largest), "rotten").unwrap();
    let said = batch.say(&["store", "verify", "out"]);
    assert_eq!(said.code, Some(3), "{said:?}");
    assert!(said.err.contains("hint: --repair takes it out"), "{}", said.err);
    assert_eq!(std::fs::read(blobs.join(largest)).unwrap(), b"rotten", "looking changes nothing");
    let said = batch.say(&["store", "verify", "out", "--repair"]);
    assert_eq!(said.code, Some(3), "{said:?}");
    assert!(said.err.contains("will be made again by the same `kinfold batch`"), "{}", said.err);
    let (said, answer) = batch.ran(&[]);
    assert_eq!(said.code, Some(0), "{said:?}");
    assert_eq!(answer["this_run"]["stages_run"], 1, "{answer}");
    same(&before, &batch.assets());
    assert_eq!(batch.say(&["store", "verify", "out"]).code, Some(0));
}

#[test]
fn what_a_ledger_names_is_kept_and_the_rest_is_tidied_up() {
    let batch = Batch::of(2);
    batch.ran(&[]);
    let kept = files(&batch.path("out/state/cas"));
    let orphan = "ab/".to_string() + &"cd".repeat(31);
    let path = batch.path("out/state/cas").join(&orphan);
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    std::fs::write(&path, "nobody names this").unwrap();
    let gc =
        |more: &[&str]| batch.say(&[&["store", "gc", "out", "--older-than", "0"], more].concat());
    let said = gc(&["--dry-run"]);
    assert_eq!(said.out, format!("would remove 1 blobs, 17 B; kept {}\n", kept.len()), "{said:?}");
    assert!(path.exists());
    assert_eq!(gc(&[]).code, Some(0));
    same(&kept, &files(&batch.path("out/state/cas")));
    let (_, answer) = batch.ran(&["--seed", "3"]);
    assert_eq!(answer["this_run"]["stages_run"], 0, "everything is still there: {answer}");
}

#[test]
fn an_audit_finds_whatever_was_touched() {
    let batch = Batch::of(3);
    batch.ran(&[]);
    let audit = |found: &str| {
        let said = batch.say(&["audit", "out"]);
        assert_eq!(said.code, Some(if found.is_empty() { 0 } else { 1 }), "{said:?}");
        assert!(said.err.contains(found), "expected {found} in {}", said.err);
    };
    audit("");
    let asset = |id: &str, name: &str| batch.path("out/assets").join(id).join(name);
    let touched = |path: &Path, found: &str, change: &dyn Fn(Vec<u8>) -> Vec<u8>| {
        let bytes = std::fs::read(path).unwrap();
        std::fs::write(path, change(bytes.clone())).unwrap();
        audit(found);
        std::fs::write(path, bytes).unwrap();
        audit("");
    };
    let meshes = files(&asset("k001", "meshes"));
    let mesh = names(&meshes)[0];
    touched(&asset("k001", "meshes").join(mesh), "does not follow from the trace", &|mut bytes| {
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
        bytes
    });
    let verdict = |bytes: Vec<u8>| {
        String::from_utf8(bytes)
            .unwrap()
            .replacen("\"tier\": \"", "\"tier\": \"super", 1)
            .into_bytes()
    };
    touched(
        &asset("k002", "verdict.json"),
        "k002: verdict.json does not follow from the trace",
        &verdict,
    );
    let other = std::fs::read(asset("k000", "trace.mcap")).unwrap();
    touched(
        &asset("k001", "trace.mcap"),
        "k001: trace.mcap is not the one the ledger names",
        &|_| other.clone(),
    );
    let db = rusqlite::Connection::open(batch.path("out/ledger.sqlite")).unwrap();
    let force = "DROP TRIGGER outcomes_keep_DELETE; DELETE FROM outcomes WHERE id = 'k001'";
    db.execute_batch(force).unwrap();
    audit("k001: assets/k001 stands in no row of the ledger");
}

#[test]
fn the_ledger_answers_in_sql() {
    let batch = Batch::of(2);
    batch.ran(&[]);
    let sql = "SELECT count(*) FROM items WHERE provider = 'mesh-file/1' AND license = 'CC0-1.0'";
    assert_eq!(batch.ask(sql), "2");
    let said = batch.say(&["audit", "query", "out", "DELETE FROM outcomes"]);
    assert_eq!(said.code, Some(1));
    let said = batch.say(&[
        "audit",
        "query",
        "out",
        "SELECT id FROM items ORDER BY id",
        "--limit",
        "1",
        "--json",
    ]);
    assert_eq!(
        (said.out.as_str(), said.err.as_str()),
        ("{\"id\":\"k000\"}\n", "only the first 1 rows are shown: --limit N\n")
    );
}

#[test]
fn the_report_says_what_the_index_says() {
    let batch = Batch::of(3);
    batch.write("no.png", "no picture");
    let mut text = std::fs::read_to_string(batch.path("items.jsonl")).unwrap();
    let mut blind = Batch::given("blind", 1);
    blind["photo"] = "no.png".into();
    text.push_str(&format!("{blind}\n"));
    batch.write("items.jsonl", text);
    batch.ran(&[]);
    let said = batch.say(&["batch", "report", "out"]);
    assert_eq!(said.out, "out/report.html\nout/index.parquet\n", "{said:?}");
    let (mut accepted, mut twins, mut failed) = (0, 0, 0);
    workflow::batch::index::read(&batch.path("out/index.parquet"), |row| {
        accepted += u64::from(row.text("outcome") == Some("accepted"));
        failed += u64::from(row.text("outcome") == Some("failed"));
        twins += u64::from(row.text("duplicate_of").is_some());
    })
    .unwrap();
    assert_eq!((accepted, failed, twins), (3, 1, 2));
    let page = std::fs::read_to_string(batch.path("out/report.html")).unwrap();
    for (name, value) in
        [("accepted", accepted), ("failed", failed), ("near-duplicates", twins), ("items", 4)]
    {
        assert!(page.contains(&format!("<b id=\"{name}\">{value}</b>")), "{name} is not {value}");
    }
    assert_eq!(page.matches("data:image/jpeg;base64,").count(), 3);
    assert!(!page.contains("<script") && !page.contains("src=\"http"));
}
