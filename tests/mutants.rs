//! `kinfold mutate` and `kinfold bench-check`: defects planted in a sound model, and who finds them.

use std::path::Path;

use serde_json::Value;

use crate::fixes::models::{cup, cupboard, mjcf, write_meshes};
use crate::kinfold::{Bench, Said, files, program, say};
use crate::transcripts::is_word_for_word;

fn run(bench: &Bench, args: &[&str]) -> Said {
    program().current_dir(bench.path("")).args(args).output().unwrap().into()
}

/// A bench with a cupboard and its mutants.
fn planted(more: &[&str]) -> (Bench, Value) {
    let bench = Bench::new();
    std::fs::write(bench.path("model.urdf"), cupboard("", "")).unwrap();
    let said =
        run(&bench, &[&["mutate", "model.urdf", "--out", "mutants", "--json"], more].concat());
    assert_eq!(said.code, Some(0), "{said:?}");
    let manifest = serde_json::from_str(&said.out).unwrap();
    (bench, manifest)
}

fn kinds(manifest: &Value) -> Vec<&str> {
    let all = manifest["mutants"].as_array().unwrap().iter();
    all.map(|m| m["kind"].as_str().unwrap()).collect()
}

#[test]
fn the_kinds_are_listed_and_the_page_says_the_same() {
    let all: Value = serde_json::from_str(&say(&["mutate", "--list", "--json"]).out).unwrap();
    let all = all.as_array().unwrap();
    assert!(all.len() >= 40, "{}", all.len());
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/mutants.md");
    let page = std::fs::read_to_string(page).unwrap();
    for kind in all {
        let text = |key: &str| kind[key].as_str().unwrap().to_owned();
        let list = |key: &str, between: &str| {
            let words = kind[key].as_array().unwrap().iter().map(|v| v.as_str().unwrap());
            words.collect::<Vec<_>>().join(between)
        };
        let rules = list("rules", " or ");
        let rules = if rules.is_empty() { "any".into() } else { rules };
        let row = format!(
            "| `{}` | {} | {} | {} | {rules} |",
            text("kind"),
            text("change"),
            text("wrong"),
            list("formats", ", ")
        );
        assert!(page.contains(&row), "{row}");
    }
    let said = say(&["mutate", "--list"]);
    assert!(said.out.contains("\nlimits-swapped  (URDF, MJCF, SDF)\n"), "{}", said.out);
}

#[test]
fn help_says_what_is_written_and_how_a_mutant_counts_as_found() {
    is_word_for_word("help_mutate", &say(&["mutate", "--help"]).out);
    is_word_for_word("help_bench_check", &say(&["bench-check", "--help"]).out);
}

#[test]
fn every_defect_of_a_cupboard_is_found_and_the_cupboard_itself_raises_no_alarm() {
    let (bench, manifest) = planted(&[]);
    assert!(kinds(&manifest).len() >= 40, "{:?}", kinds(&manifest));
    let said = run(&bench, &["bench-check", "--mutants", "mutants", "--json"]);
    let answer: Value = serde_json::from_str(&said.out).unwrap();
    let missed: Vec<&Value> =
        answer["mutants"].as_array().unwrap().iter().filter(|m| m["found"] != true).collect();
    assert!(missed.is_empty(), "{missed:#?}");
    assert_eq!(answer["originals"][0]["alarm"], Value::Null);
    assert_eq!(said.code, Some(0), "{}", said.err);
}

#[test]
fn every_defect_of_an_mjcf_cupboard_is_found() {
    let bench = Bench::new();
    std::fs::write(bench.path("model.xml"), mjcf("range", "range")).unwrap();
    let said =
        run(&bench, &["mutate", "model.xml", "--as", "object", "--out", "mutants", "--json"]);
    let manifest: Value = serde_json::from_str(&said.out).unwrap();
    assert!(kinds(&manifest).len() >= 30, "{:?}", kinds(&manifest));
    let said = run(&bench, &["bench-check", "--mutants", "mutants"]);
    let missed: Vec<&str> = said.out.lines().filter(|l| l.contains("  missed ")).skip(1).collect();
    assert!(missed.is_empty(), "{missed:#?}");
}

#[test]
fn a_mutant_is_a_whole_folder_with_one_change() {
    let (bench, manifest) = planted(&[]);
    let original = std::fs::read_to_string(bench.path("mutants/original/model.urdf")).unwrap();
    assert_eq!(original, cupboard("", ""), "what needs no other names stays as it is");
    assert_eq!(original, std::fs::read_to_string(bench.path("model.urdf")).unwrap());
    let swapped = manifest["mutants"].as_array().unwrap().iter();
    let swapped = swapped.clone().find(|m| m["kind"] == "limits-swapped").unwrap();
    let diff = swapped["diff"].as_str().unwrap();
    assert!(diff.contains("+    <limit lower=\"1.5\" upper=\"0\" effort=\"10\""), "{diff}");
    let changed = |mark: char| diff.lines().filter(|l| l.starts_with(mark)).count();
    assert_eq!([changed('+'), changed('-')], [2, 2], "one line, and the head: {diff}");
    let listed: Value =
        serde_json::from_slice(&std::fs::read(bench.path("mutants/mutants.json")).unwrap())
            .unwrap();
    assert_eq!(listed, manifest);
}

#[test]
fn meshes_of_packages_and_of_other_folders_come_along_and_get_names_that_lead_there() {
    let bench = Bench::new();
    std::fs::create_dir_all(bench.path("cup_description/urdf")).unwrap();
    std::fs::create_dir_all(bench.path("cup_description/meshes")).unwrap();
    write_meshes(&bench.path("cup_description/meshes"));
    std::fs::write(
        bench.path("cup_description/package.xml"),
        "<package><name>cup_description</name></package>",
    )
    .unwrap();
    let text = cup("package://cup_description/meshes/hollow.obj");
    std::fs::write(bench.path("cup_description/urdf/cup.urdf"), text).unwrap();
    let said = run(&bench, &["mutate", "cup_description/urdf/cup.urdf", "--out", "mutants"]);
    assert!(matches!(said.code, Some(0 | 3)), "{said:?}");
    let all = files(&bench.path("mutants"));
    let text = String::from_utf8(all["original/cup.urdf"].clone()).unwrap();
    assert!(text.contains("filename=\"files/hollow.obj\""), "{text}");
    assert!(all.contains_key("original/files/hollow.obj"));
    assert!(all["mesh-empty/files/hollow.obj"].is_empty());
    assert!(!all["mesh-missing/files/hollow.obj"].is_empty(), "only its name is wrong");
}

#[test]
fn the_same_seed_gives_the_same_bytes() {
    let made = || files(&planted(&["--seed", "5"]).0.path("mutants"));
    let (one, two) = (made(), made());
    assert_eq!(one.keys().collect::<Vec<_>>(), two.keys().collect::<Vec<_>>());
    assert_eq!(one, two);
}

#[test]
fn a_folder_of_somebody_else_is_refused_and_one_of_ours_keeps_what_others_put_there() {
    let (bench, _) = planted(&["--kind", "axis-zero", "--kind", "mass-zero"]);
    std::fs::write(bench.path("mutants/notes.txt"), "mine").unwrap();
    let said = run(&bench, &["mutate", "model.urdf", "--out", "mutants", "--kind", "axis-zero"]);
    assert_eq!(said.code, Some(0), "{said:?}");
    assert!(bench.path("mutants/axis-zero/model.urdf").is_file());
    assert!(!bench.path("mutants/mass-zero").exists(), "what is ours and not due goes");
    assert_eq!(std::fs::read_to_string(bench.path("mutants/notes.txt")).unwrap(), "mine");
    std::fs::create_dir(bench.path("theirs")).unwrap();
    std::fs::write(bench.path("theirs/thesis.tex"), "mine").unwrap();
    let said = run(&bench, &["mutate", "model.urdf", "--out", "theirs"]);
    assert_eq!(said.code, Some(2), "{said:?}");
    assert!(said.err.contains("holds `thesis.tex`") && said.err.contains("hint:"), "{}", said.err);
    assert_eq!(files(&bench.path("theirs")).len(), 1);
}

#[test]
fn a_model_with_findings_of_its_own_is_said_to_have_them() {
    let bench = Bench::new();
    std::fs::write(
        bench.path("model.urdf"),
        cupboard("<mass value=\"2\"/>", "<mass value=\"0\"/>"),
    )
    .unwrap();
    let said = run(&bench, &["mutate", "model.urdf", "--out", "mutants"]);
    assert_eq!(said.code, Some(3), "{said:?}");
    assert!(
        said.err.contains("has findings of its own") && said.err.contains("M1"),
        "{}",
        said.err
    );
}

#[test]
fn what_cannot_be_read_is_refused_and_nothing_is_written() {
    let bench = Bench::new();
    write_meshes(&bench.path(""));
    for (name, text, words) in [
        ("not.urdf", "<robot".to_owned(), "no XML"),
        ("html.urdf", "<html/>".to_owned(), "expected <robot>, <mujoco> or <sdf>"),
        ("mesh.urdf", cup("nope.obj"), "nope.obj"),
        ("two.urdf", "<robot name='r'><link name='a'/><link name='b'/></robot>".to_owned(), "root"),
    ] {
        std::fs::write(bench.path(name), text).unwrap();
        let said = run(&bench, &["mutate", name, "--out", "mutants"]);
        assert_eq!(said.code, Some(1), "{name}: {said:?}");
        assert!(said.err.contains(words) && said.err.contains("hint:"), "{name}: {}", said.err);
        assert!(!bench.path("mutants").exists(), "{name}");
    }
    let said = run(&bench, &["mutate", "mesh.urdf", "--out", "m", "--kind", "axis"]);
    assert_eq!(said.code, Some(2));
    assert!(said.err.contains("`kinfold mutate --list` names them"), "{}", said.err);
    for args in [&["mutate"][..], &["mutate", "a.urdf"], &["bench-check"]] {
        assert_eq!(run(&bench, args).code, Some(2), "{args:?}");
    }
}

/// What a shell script finds, with these arguments before it.
#[cfg(unix)]
fn by_script(script: &str, more: &[&str]) -> (Value, Said) {
    let (bench, _) =
        planted(&["--kind", "axis-zero", "--kind", "mass-zero", "--kind", "xml-broken"]);
    std::fs::write(bench.path("checker.sh"), script).unwrap();
    let args =
        [&["bench-check", "--mutants", "mutants", "--json"], more, &["--", "sh", "checker.sh"]];
    let said = run(&bench, &args.concat());
    (serde_json::from_str(&said.out).unwrap_or_else(|e| panic!("{e}: {said:?}")), said)
}

#[cfg(unix)]
fn found(answer: &Value) -> Vec<&str> {
    let all = answer["mutants"].as_array().unwrap().iter();
    all.filter(|m| m["found"] == true).map(|m| m["kind"].as_str().unwrap()).collect()
}

#[cfg(unix)]
#[test]
fn a_program_is_scored_by_its_exit_code_and_by_its_lines() {
    // Exits 1 for the axis, speaks of the mass, and says the time in every run.
    let script = "echo \"no errors before $(date +%N)\"\n\
        if grep -q 'xyz=\"0 0 0\"' \"$1\"; then echo axis; exit 1; fi\n\
        if grep -q '<mass value=\"0\"' \"$1\"; then echo \"WARNING: no mass in $1\"; fi\n";
    let (answer, said) = by_script(script, &[]);
    assert_eq!(found(&answer), ["axis-zero", "mass-zero"]);
    assert_eq!((said.code, &answer["originals"][0]["alarm"]), (Some(3), &Value::Null), "{said:?}");
    assert_eq!(found(&by_script(script, &["--found-by", "exit"]).0), ["axis-zero"]);
    assert_eq!(found(&by_script(script, &["--found-by", "output"]).0), ["mass-zero"]);
}

#[cfg(unix)]
#[test]
fn a_program_that_refuses_everything_finds_nothing_and_raises_a_false_alarm() {
    let (answer, _) = by_script("echo error; exit 2\n", &[]);
    assert_eq!(found(&answer), [""; 0]);
    assert_eq!(answer["originals"][0]["alarm"], "exit 2");
}

#[cfg(unix)]
#[test]
fn a_program_without_an_answer_finds_nothing() {
    let script = "grep -q 'xyz=\"0 0 0\"' \"$1\" && sleep 600\nexit 0\n";
    let (answer, _) = by_script(script, &["--deadline", "1"]);
    assert_eq!(found(&answer), [""; 0]);
    assert!(answer["mutants"].to_string().contains("no answer in 1 s"), "{answer:#}");
}

#[test]
fn a_program_or_a_folder_that_is_not_there_is_said_before_anything_runs() {
    let (bench, _) = planted(&["--kind", "axis-zero"]);
    let said = run(&bench, &["bench-check", "--mutants", "mutants", "--", "no-such-checker"]);
    assert_eq!(said.code, Some(2), "{said:?}");
    assert!(said.err.contains("there is no program `no-such-checker`"), "{}", said.err);
    let said = run(&bench, &["bench-check", "--mutants", "nowhere"]);
    assert_eq!(said.code, Some(1), "{said:?}");
    assert!(said.err.contains("`kinfold mutate MODEL --out DIR` writes such a folder"));
    std::fs::write(bench.path("mutants/mutants.json"), "{\"schema\": \"x\"}").unwrap();
    assert_eq!(run(&bench, &["bench-check", "--mutants", "mutants"]).code, Some(1));
}
