//! `kinfold check` in somebody's CI: settings, waivers, baselines, changes and reports.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::kinfold::{Bench, Said, program_in, say};

fn say_in(folder: &Path, args: &[&str]) -> Said {
    program_in(folder).args(args).output().unwrap().into()
}

/// Two boxes on a slide, `door` and `wall` 10 mm in each other; lines count from 1.
fn model(overlap: f64) -> String {
    let link = |name: &str, x: f64| {
        let shape =
            format!("<origin xyz=\"{x} 0 0.1\"/><geometry><box size=\"0.2 0.2 0.2\"/></geometry>");
        format!(
            "  <link name=\"{name}\">\n    <visual>{shape}</visual>\n    <collision>{shape}</collision>\n    \
             <inertial><origin xyz=\"{x} 0 0.1\"/><mass value=\"1\"/><inertia ixx=\"0.007\" iyy=\"0.007\" \
             izz=\"0.007\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>\n  </link>\n"
        )
    };
    format!(
        "<robot name=\"r\">\n{}{}  <joint name=\"slide\" type=\"prismatic\">\n    <parent link=\"wall\"/>\
         <child link=\"door\"/>\n    <axis xyz=\"0 1 0\"/>\n    <limit lower=\"0\" upper=\"0.1\" effort=\"20\" \
         velocity=\"1\"/>\n  </joint>\n</robot>\n",
        link("wall", 0.0),
        link("door", 0.2 - overlap)
    )
}

fn place(files: &[(&str, &str)]) -> Bench {
    let bench = Bench::new();
    for (name, text) in files {
        let path = bench.path(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
    bench
}

fn c1(said: &str) -> Value {
    let verdict: Value = serde_json::from_str(said).unwrap();
    let checks = verdict["checks"].as_array().unwrap();
    checks.iter().find(|c| c["id"] == "C1").unwrap().clone()
}

#[test]
fn a_tier_that_is_asked_for_runs_no_check_above_it() {
    let bench = place(&[("m.urdf", &model(0.0))]);
    let said = say_in(&bench.path("."), &["check", "m.urdf", "--tier", "static", "--json"]);
    let verdict: Value = serde_json::from_str(&said.out).unwrap();
    assert_eq!(verdict["asked"], "static");
    let ids: Vec<_> = verdict["checks"].as_array().unwrap().iter().map(|c| &c["id"]).collect();
    assert!(!ids.iter().any(|id| *id == "C1" || *id == "S1"), "{ids:?}");
}

#[test]
fn settings_of_the_repository_are_found_above_and_said() {
    let settings = "tier = \"static\"\nexclude = [\"old\"]\n[[override]]\nfiles = \"b/*.urdf\"\ntier = \"parse\"\n";
    let text = model(0.0);
    let bench =
        place(&[("kinfold-check.toml", settings), ("a/m.urdf", &text), ("b/m.urdf", &text)]);
    let said = say_in(&bench.path("a"), &["check", "m.urdf", "--json"]);
    assert_eq!(serde_json::from_str::<Value>(&said.out).unwrap()["asked"], "static");
    assert!(
        said.err.contains("settings from") && said.err.contains("kinfold-check.toml"),
        "{}",
        said.err
    );
    let said = say_in(&bench.path("a"), &["check", "../b/m.urdf", "--json"]);
    assert_eq!(serde_json::from_str::<Value>(&said.out).unwrap()["asked"], "parse");
    let said = say_in(&bench.path("a"), &["check", "m.urdf", "--json", "--no-config"]);
    assert_eq!(serde_json::from_str::<Value>(&said.out).unwrap()["asked"], "dynamic");
    std::fs::write(bench.path("kinfold-check.toml"), "teir = \"static\"\n").unwrap();
    let said = say_in(&bench.path("a"), &["check", "m.urdf"]);
    assert_eq!(said.code, Some(2), "{said:?}");
    assert!(
        said.err.contains("unknown field `teir`") && said.err.contains("hint:"),
        "{}",
        said.err
    );
}

#[test]
fn a_comment_in_the_model_waives_a_finding_until_its_day() {
    let text = model(0.01);
    let allowed = |words: &str| {
        text.replace(
            "  <link name=\"door\">",
            &format!("  <!-- kinfold: {words} -->\n  <link name=\"door\">"),
        )
    };
    let bench = place(&[("m.urdf", &text)]);
    let asked = |text: &str| {
        std::fs::write(bench.path("m.urdf"), text).unwrap();
        say_in(&bench.path("."), &["check", "m.urdf", "--json"])
    };
    assert_eq!(c1(&asked(&text).out)["status"], "fail");
    assert!(c1(&asked(&text).out)["waived"].is_null());
    let said = asked(&allowed("allow C1 until 2999-01-01: a pin in its hole"));
    assert_eq!(c1(&said.out)["waived"], "a pin in its hole");
    let said = asked(&allowed("allow C1 until 2001-01-01: a pin in its hole"));
    assert!(c1(&said.out)["waived"].is_null());
    assert!(said.err.contains("C1 was allowed until 2001-01-01"), "{}", said.err);
    let said = asked(&allowed("allow C1"));
    assert!(c1(&said.out)["waived"].is_null());
    assert!(said.err.contains("found no reason"), "{}", said.err);
}

#[test]
fn settings_waive_by_file_and_element_and_say_what_nothing_needed() {
    let waive = |at: &str, more: &str| {
        format!("[[waive]]\ncheck = \"C1\"\nat = \"{at}\"\nreason = \"a rim\"\n{more}")
    };
    let text = model(0.01);
    let bench = place(&[("m.urdf", &text)]);
    let asked = |settings: &str| {
        std::fs::write(bench.path("kinfold-check.toml"), settings).unwrap();
        say_in(&bench.path("."), &["check", "m.urdf", "--json"])
    };
    assert_eq!(c1(&asked(&waive("door", "")).out)["waived"], "a rim");
    let said = asked(&waive("lid", ""));
    assert!(c1(&said.out)["waived"].is_null());
    assert!(said.err.contains("nothing failed that it is for"), "{}", said.err);
    assert!(c1(&asked(&waive("door", "files = \"x/**\"\n")).out)["waived"].is_null());
    let said = asked(&waive("door", "until = 2001-01-01\n"));
    assert!(said.err.contains("it held until 2001-01-01"), "{}", said.err);
}

#[test]
fn a_baseline_lets_known_findings_pass_and_no_new_one() {
    let bench = place(&[("m.urdf", &model(0.01))]);
    let here = bench.path(".");
    let said = say_in(&here, &["check", "m.urdf", "--write-baseline", "known.json"]);
    assert_eq!(said.code, Some(3), "{said:?}");
    let known = ["check", "m.urdf", "--baseline", "known.json", "--json"];
    let said = say_in(&here, &known);
    assert_eq!(said.code, Some(0), "{said:?}");
    assert!(c1(&said.out)["waived"].as_str().unwrap().contains("known before"));
    // Deeper, it is the same finding; of another link it is a new one.
    std::fs::write(bench.path("m.urdf"), model(0.02)).unwrap();
    assert_eq!(say_in(&here, &known).code, Some(0));
    std::fs::write(bench.path("m.urdf"), model(0.01).replace("\"door\"", "\"gate\"")).unwrap();
    assert_eq!(say_in(&here, &known).code, Some(3));
    std::fs::write(bench.path("known.json"), "{}").unwrap();
    let said = say_in(&here, &known);
    assert_eq!(said.code, Some(2), "{said:?}");
    assert!(said.err.contains("not a baseline"), "{}", said.err);
}

fn git(folder: &Path, words: &[&str]) {
    let mut git = Command::new("git");
    git.args(["-c", "user.name=t", "-c", "user.email=t@example.com", "-c", "commit.gpgsign=false"]);
    let done = git.arg("-C").arg(folder).args(words).output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
}

#[test]
fn only_what_a_change_touches_is_checked_meshes_and_includes_with_it() {
    if Command::new("git").arg("--version").output().is_err() {
        eprintln!("SKIPPED: no git");
        return;
    }
    let meshed =
        model(0.0).replace("<box size=\"0.2 0.2 0.2\"/>", "<mesh filename=\"parts/box.obj\"/>");
    let macros = "<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\"><xacro:include filename=\"b.xacro\"/></robot>";
    let bench = place(&[
        ("plain.urdf", &model(0.0)),
        ("meshed.urdf", &meshed),
        ("top.urdf", &format!("<!-- made from a.xacro -->\n{}", model(0.0))),
        ("a.xacro", macros),
        ("b.xacro", "<robot/>"),
        ("parts/box.obj", "v 0 0 0\n"),
    ]);
    let here = bench.path(".");
    git(&here, &["init", "-q"]);
    git(&here, &["add", "-A"]);
    git(&here, &["commit", "-qm", "a"]);
    let touched = || -> Vec<String> {
        let said =
            say_in(&here, &["check", ".", "--changed-since", "HEAD", "--json", "--tier", "parse"]);
        let name = |line: &str| {
            let line: Value = serde_json::from_str(line).unwrap();
            line["file"].as_str().unwrap().rsplit('/').next().unwrap().to_owned()
        };
        said.out.lines().map(name).collect()
    };
    assert!(touched().is_empty());
    std::fs::write(bench.path("parts/box.obj"), "v 1 0 0\n").unwrap();
    assert_eq!(touched(), ["meshed.urdf"]);
    std::fs::write(bench.path("b.xacro"), "<robot name=\"b\"/>").unwrap();
    assert_eq!(touched(), ["meshed.urdf", "top.urdf"]);
    std::fs::write(bench.path("new.urdf"), model(0.0)).unwrap();
    assert_eq!(touched(), ["meshed.urdf", "new.urdf", "top.urdf"]);
    let said = say_in(&here, &["check", ".", "--changed-since", "nowhere"]);
    assert_eq!(said.code, Some(1), "{said:?}");
    assert!(said.err.contains("--changed-since nowhere: git:"), "{}", said.err);
    let said = say_in(&here, &["check", ".", "--changed-since=--output=owned"]);
    assert_eq!(said.code, Some(1), "{said:?}");
    assert!(!bench.path("owned").exists());
}

#[test]
fn reports_stand_beside_each_other_and_a_scan_sums_up() {
    let bench = place(&[("a/good.urdf", &model(0.0)), ("a/bad.urdf", &model(0.01))]);
    let here = bench.path(".");
    let said = say_in(
        &here,
        &[
            "scan",
            "a",
            "--sarif",
            "r.sarif",
            "--markdown",
            "r.md",
            "--html",
            "r.html",
            "--junit",
            "r.xml",
        ],
    );
    assert_eq!(said.code, Some(3), "{said:?}");
    assert!(said.out.contains("1 of 2 reach the tier that is asked of them"), "{}", said.out);
    assert!(said.out.contains("C1 "), "{}", said.out);
    let sarif: Value =
        serde_json::from_slice(&std::fs::read(bench.path("r.sarif")).unwrap()).unwrap();
    let results = sarif["runs"][0]["results"].as_array().unwrap();
    let overlap = results.iter().find(|r| r["ruleId"] == "C1" && r["level"] == "error").unwrap();
    let place = &overlap["locations"][0]["physicalLocation"];
    assert_eq!(place["artifactLocation"]["uri"], "a/bad.urdf");
    let line = place["region"]["startLine"].as_u64().unwrap();
    let text = model(0.01);
    let named = text.lines().nth(line as usize - 1).unwrap();
    assert!(named.contains("<link name="), "line {line}: {named}");
    let page = std::fs::read_to_string(bench.path("r.html")).unwrap();
    assert!(page.contains("a/good.urdf") && page.contains("a/bad.urdf"));
    assert!(std::fs::read_to_string(bench.path("r.md")).unwrap().contains("1 of 2 models"));
    let said = say_in(&here, &["scan", "a", "--json"]);
    let all: Value = serde_json::from_str(&said.out).unwrap();
    assert_eq!(all["models"], 2);
    assert_eq!(all["files"].as_array().unwrap().len(), 2);
}

#[test]
fn the_action_and_the_hooks_name_options_that_there_are() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let help = say(&["check", "--help"]).out;
    for file in ["action.yml", ".pre-commit-hooks.yaml", "docs/check-in-ci.md"] {
        let text = std::fs::read_to_string(root.join(file)).unwrap();
        let words = text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '-'));
        let ours = words.filter(|w| w.starts_with("--") && w.len() > 2);
        let foreign = ["--locked", "--quiet", "--path"];
        let is_option = |o: &&str| o.contains(|c: char| c != '-') && !foreign.contains(o);
        for option in ours.filter(is_option) {
            assert!(help.contains(option), "{file}: {option}");
        }
    }
}

#[test]
fn a_model_that_one_client_takes_otherwise_is_not_portable_and_exits_3() {
    let rough = model(0.0).replace("<axis", "<dynamics friction=\"2\" damping=\"0.1\"/><axis");
    let bench = place(&[("m.urdf", &rough)]);
    let here = bench.path(".");
    let asked = ["check", "m.urdf", "--portable", "--for", "mujoco,pybullet"];
    let said = say_in(&here, &asked);
    assert_eq!(said.code, Some(3), "{said:?}");
    assert!(said.err.contains("m.urdf: not portable: PyBullet"), "{}", said.err);
    assert_eq!(say_in(&here, &asked[..2]).code, Some(0));
}
