//! What a person reads: verdicts, explanations, traces, and who is asked, in words and in one place.

use serde_json::Value;

use crate::batch::Batch;
use crate::kinfold::{Bench, Said, program, say};
use crate::transcripts::is_word_for_word;

/// Two boxes of a metre, one in the other, on a hinge.
fn boxes_in_each_other() -> String {
    let link = |name: &str| {
        let shape = "<geometry><box size='1 1 1'/></geometry>";
        format!(
            "<link name='{name}'><inertial><mass value='500'/><inertia ixx='83' iyy='83' izz='83' \
             ixy='0' ixz='0' iyz='0'/></inertial><visual>{shape}</visual>\
             <collision>{shape}</collision></link>"
        )
    };
    format!(
        "<robot name='boxes'>\n{}\n{}\n<joint name='hinge' type='revolute'><parent link='body'/>\
         <child link='door'/><axis xyz='0 0 1'/><limit lower='0' upper='1' effort='1' velocity='1'/>\
         </joint>\n</robot>\n",
        link("body"),
        link("door")
    )
}

fn checked(bench: &Bench, name: &str, bytes: impl AsRef<[u8]>, more: &[&str]) -> Said {
    std::fs::write(bench.path(name), bytes).unwrap();
    program().current_dir(bench.path("")).arg("check").arg(name).args(more).output().unwrap().into()
}

#[test]
fn a_verdict_says_what_fails_first_what_follows_and_what_mends_it() {
    let bench = Bench::new();
    let said = checked(&bench, "boxes.urdf", boxes_in_each_other(), &["--tier", "dynamic"]);
    assert_eq!(said.code, Some(3), "{said:?}");
    is_word_for_word("check_boxes", &said.out);
    let all = checked(&bench, "boxes.urdf", boxes_in_each_other(), &["--tier", "dynamic", "-v"]);
    assert_eq!(all.code, said.code);
    let json = checked(&bench, "boxes.urdf", boxes_in_each_other(), &["--json"]);
    let verdict: Value = serde_json::from_str(&json.out).unwrap();
    for check in verdict["checks"].as_array().unwrap() {
        assert!(all.out.contains(check["rule"].as_str().unwrap()) || check["status"] == "unknown");
    }
}

#[test]
fn a_forecast_stands_beside_the_verdict_and_changes_no_exit_code() {
    let bench = Bench::new();
    let plain = checked(&bench, "boxes.urdf", boxes_in_each_other(), &[]);
    let said = checked(&bench, "boxes.urdf", boxes_in_each_other(), &["--for", "rerun,mujoco"]);
    assert_eq!(said.code, plain.code);
    let (verdict, forecast) = said.out.split_at(plain.out.len());
    assert_eq!(verdict, plain.out);
    assert!(forecast.starts_with("\nMuJoCo: "), "{forecast}");
    assert!(forecast.contains("\nlooks    MuJoCo drops the visuals of a URDF"), "{forecast}");
    assert!(forecast.contains("mujoco.visuals-dropped, measured with mujoco"), "{forecast}");
    assert!(forecast.contains("\nRerun: none of "), "{forecast}");
    let json = ["--for", "mujoco", "--json"];
    let json: Value =
        serde_json::from_str(&checked(&bench, "boxes.urdf", boxes_in_each_other(), &json).out)
            .unwrap();
    assert_eq!(json["forecast"][0]["client"], "mujoco");
    assert!(json["checks"].as_array().is_some_and(|c| !c.is_empty()));
    let wrong = checked(&bench, "boxes.urdf", boxes_in_each_other(), &["--for", "mujocco"]);
    assert_eq!(wrong.code, Some(2));
    assert!(wrong.err.contains("did you mean `mujoco`?"), "{wrong:?}");
}

#[test]
fn usd_without_bodies_is_no_model_and_is_forecast_all_the_same() {
    let bench = Bench::new();
    let joint =
        "#usda 1.0\ndef PhysicsRevoluteJoint \"j\"\n{\n    float physics:lowerLimit = -30\n}\n";
    let said = checked(&bench, "asset.usda", joint, &["--for", "isaac"]);
    assert_eq!(said.code, Some(1));
    assert!(said.out.contains("isaac.usd-one-sided-limit"), "{said:?}");
}

#[test]
fn a_file_that_is_no_model_is_one_line_and_machines_are_told_the_same_as_ever() {
    let bench = Bench::new();
    for (name, bytes, kind) in [
        ("asset.glb", &b"glTF\x02\0\0\0"[..], "GLB"),
        ("parts.zip", b"PK\x03\x04\0", "an archive (ZIP, USDZ, 3MF)"),
        ("notes.txt", b"a door and a body", "a text that is not XML"),
        ("empty.urdf", b"", "an empty file"),
    ] {
        let said = checked(&bench, name, bytes, &[]);
        assert_eq!((said.code, said.out.as_str()), (Some(1), ""), "{said:?}");
        let line =
            format!("error: {name}: {kind} is not read: expected URDF, MJCF, SDFormat or USD\n");
        assert_eq!(said.err, line);
        let json = checked(&bench, name, bytes, &["--json"]);
        let verdict: Value = serde_json::from_str(&json.out).unwrap();
        assert_eq!((json.code, &verdict["tier"]), (Some(1), &"none".into()));
        assert!(verdict["counts"]["unknown"].as_u64().unwrap() > 30, "{verdict}");
    }
    let said = checked(&bench, "cut.urdf", "<robot name='r'><link", &[]);
    assert!(said.out.contains("FAIL   F1") && said.out.contains("F1 is why"), "{}", said.out);
    assert!(said.out.lines().count() < 12, "{}", said.out);
}

#[test]
fn colour_is_for_terminals_and_for_whoever_asks() {
    let bench = Bench::new();
    let plain = checked(&bench, "boxes.urdf", boxes_in_each_other(), &[]);
    assert!(!plain.out.contains('\u{1b}'), "{}", plain.out);
    let bright = checked(&bench, "boxes.urdf", boxes_in_each_other(), &["--color", "always"]);
    assert!(bright.out.contains("\u{1b}[31mFAIL"), "{:?}", bright.out);
    let json =
        checked(&bench, "boxes.urdf", boxes_in_each_other(), &["--color", "always", "--json"]);
    assert!(!json.out.contains('\u{1b}'), "{}", json.out);
}

#[test]
fn a_rule_is_explained() {
    is_word_for_word("explain_g2", &say(&["explain", "g2"]).out);
    is_word_for_word("explain", &say(&["explain"]).out);
    let unknown = say(&["explain", "Z9"]);
    assert_eq!((unknown.code, unknown.out.as_str()), (Some(2), ""));
    assert!(unknown.err.contains("found `Z9`"), "{}", unknown.err);
    let all: Value = serde_json::from_str(&say(&["explain", "--json"]).out).unwrap();
    assert_eq!(all.as_array().unwrap().len(), sim_check::profile::RULES.len());
}

#[test]
fn nobody_is_not_well() {
    let bench = Bench::new();
    let mut doctor = program();
    doctor.current_dir(bench.path("")).env("KINFOLD_STATE", bench.path("state")).arg("doctor");
    let said: Said = doctor.output().unwrap().into();
    assert_eq!(said.code, Some(0), "{said:?}");
    let expected = "none image_to_3d          nobody is configured; give --mesh FILE\n\
                    none vlm                  nobody is configured; give --condition FILE\n";
    assert_eq!(said.out, expected);
}

#[test]
fn a_trace_is_verified_in_a_line_and_by_its_folder() {
    let bench = Bench::done();
    let folder = bench.path("out").display().to_string();
    let said = say(&["trace", "verify", &folder]);
    assert_eq!((said.code, said.err.as_str()), (Some(0), ""), "{said:?}");
    assert_eq!(said.out.lines().count(), 1, "{}", said.out);
    assert!(
        said.out.starts_with("holds: ") && said.out.contains(" stages, seal ok"),
        "{}",
        said.out
    );
    let listed = say(&["trace", "verify", &folder, "--verbose"]);
    let files = listed.out.lines().count() - 1;
    assert!(said.out.starts_with(&format!("holds: {files} files, ")), "{}", said.out);
    assert!(listed.out.ends_with(&said.out) && listed.out.contains(" asset.urdf\n"));
    let shown = say(&["trace", "show", &folder]);
    assert!(shown.out.contains("by mesh-file/1 ") && shown.out.contains("by condition-file/1 "));
}

#[test]
fn the_ledger_says_which_tables_and_columns_it_has() {
    let batch = Batch::of(1);
    batch.ran(&[]);
    let said = batch.say(&["audit", "query", "out", ".schema"]);
    assert_eq!(said.code, Some(0), "{said:?}");
    assert!(said.out.starts_with("items\n    ") && said.out.contains("\noutcomes\n    "));
    let json = batch.say(&["audit", "query", "out", ".schema", "--json"]);
    let first: Value = serde_json::from_str(json.out.lines().next().unwrap()).unwrap();
    assert_eq!(first["table"], "items");
    let columns: Vec<_> =
        first["columns"].as_array().unwrap().iter().map(|c| c.as_str().unwrap()).collect();
    let asked = format!("SELECT {} FROM items", columns.join(", "));
    assert_eq!(batch.say(&["audit", "query", "out", &asked]).code, Some(0));
    let wrong = batch.say(&["audit", "query", "out", "SELECT teir FROM items"]);
    assert_eq!((wrong.code, wrong.out.as_str()), (Some(1), ""), "{wrong:?}");
    assert!(columns.iter().all(|column| wrong.err.contains(column)), "{}", wrong.err);
}

#[cfg(unix)]
mod asked {
    use super::*;
    use object::Condition;

    use crate::services::Object;

    const KEY: &str = "sk-somebodys-0123456789abcdef";

    /// A run whose condition a server says that no file names.
    fn made(key: Option<&str>, more: &[&str]) -> (Bench, crate::server::Server, Said) {
        let bench = Bench::new();
        let text = std::fs::read_to_string(&bench.cabinet.condition).unwrap();
        let condition = Condition::from_json(&text).unwrap();
        let server = Object::of(&bench.cabinet.mesh, &condition).serve();
        let address = format!("http://127.0.0.1:{}/v1", server.port);
        let mut command = program();
        command.current_dir(bench.path("")).env("KINFOLD_STATE", bench.path("state"));
        command.envs(key.map(|key| ("OPENAI_API_KEY", key)));
        command.args(["make", "photo.png", "--mesh", "cabinet.glb", "--out", "out"]);
        command.args(["--vlm", &address, "--model", "some-vlm"]).args(more);
        let said = command.output().unwrap().into();
        (bench, server, said)
    }

    #[test]
    fn a_server_that_the_command_line_names_is_asked_without_a_file() {
        let (bench, server, said) = made(None, &[]);
        assert_eq!(said.code, Some(0), "{said:?}");
        assert_eq!(server.count("POST", "/v1/chat/completions"), 3);
        let sends_key = |asked: &crate::server::Asked| {
            asked.headers.iter().any(|h| h.to_ascii_lowercase().starts_with("authorization"))
        };
        assert!(!server.asked().iter().any(sends_key), "there was none");
        assert!(!said.err.contains("sends what"), "{}", said.err);
        let shown = say(&["trace", "show", bench.path("out").to_str().unwrap()]);
        assert!(shown.out.contains("by openai-chat/1 some-vlm at 127.0.0.1:"), "{}", shown.out);
        assert!(shown.out.contains("3 calls: vlm.kinematics/0, vlm."), "{}", shown.out);
        let replayed = say(&["trace", "replay", bench.path("out").to_str().unwrap()]);
        assert_eq!(replayed.code, Some(0), "{replayed:?}");
        let (bench, server, said) = made(Some(KEY), &[]);
        assert_eq!(said.code, Some(0), "{said:?}");
        assert!(server.asked().iter().all(sends_key), "this machine may know it");
        let told = format!("--vlm: sends what OPENAI_API_KEY holds to 127.0.0.1:{}\n", server.port);
        assert!(said.err.starts_with(&told), "before anything else is said: {}", said.err);
        assert!(!said.err.contains(KEY) && !said.out.contains(KEY), "{said:?}");
        let (_, _, quiet) = made(Some(KEY), &["--quiet"]);
        assert_eq!((quiet.code, quiet.err.as_str()), (Some(0), ""));
        let trace = std::fs::read(bench.path("out/trace.mcap")).unwrap();
        assert!(!trace.windows(KEY.len()).any(|w| w == KEY.as_bytes()));
    }

    #[test]
    fn a_server_that_is_named_by_halves_or_beside_a_condition_is_misuse() {
        for args in [
            &["--vlm", "http://127.0.0.1:1/v1"][..],
            &["--model", "m"],
            &["--vlm", "127.0.0.1:1", "--model", "m"],
            &["--vlm", "http://127.0.0.1:1", "--model", "m", "--condition", "c.json"],
        ] {
            let said = say(&[&["make", "p.png", "--mesh", "m.glb"], args].concat());
            assert_eq!((said.code, said.out.as_str()), (Some(2), ""), "{args:?}: {said:?}");
        }
    }

    #[test]
    fn what_a_generator_says_is_seen_while_it_runs_unless_quiet() {
        let made = |more: &[&str]| -> Said {
            let bench = Bench::new();
            let script =
                "echo 'loading\u{1b}[2J weights'; echo 'step 1' >&2; cp cabinet.glb \"$1\"";
            let config = format!(
                "[image_to_3d]\nprovider = \"command\"\nprogram = \"sh\"\n\
                 arguments = [\"-c\", {script:?}, \"sh\", \"{{mesh}}\"]\n"
            );
            std::fs::write(bench.path("kinfold.toml"), config.replace("\\u{1b}", "\\u001b"))
                .unwrap();
            let mut command = program();
            command.current_dir(bench.path("")).env("KINFOLD_STATE", bench.path("state"));
            command.args(["make", "photo.png", "--condition", "cabinet.json", "--out", "out"]);
            command.args(["--config", "kinfold.toml"]).args(more);
            command.output().unwrap().into()
        };
        let said = made(&[]);
        assert_eq!(said.code, Some(0), "{said:?}");
        let lines: Vec<_> = said.err.lines().collect();
        let at = |line: &str| lines.iter().position(|l| l.starts_with(line));
        let done = at("generate-mesh").unwrap();
        assert!(at("sh: loading weights").unwrap() < done, "{}", said.err);
        assert!(at("sh: step 1").unwrap() < done && !said.err.contains('\u{1b}'), "{}", said.err);
        let quiet = made(&["--quiet"]);
        assert_eq!((quiet.code, quiet.err.as_str(), quiet.out), (Some(0), "", said.out));
    }
}
