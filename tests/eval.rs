//! `kinfold eval` on cases of our own.

use std::path::Path;

use serde_json::Value;
use training::evaluate::case;
use training::procedural::FAMILIES;

use crate::kinfold::{Said, program};

/// Two objects as case folders.
fn cases(root: &Path) {
    for (name, family) in [("articraft__cabinet", 0), ("home__cart", 2)] {
        let made = FAMILIES[family].make().unwrap();
        case::write(&root.join("cases").join(name), &made.object, &made.condition).unwrap();
    }
}

fn eval(root: &Path, more: &[&str]) -> Said {
    let mut command = program();
    command.current_dir(root).args(["eval", "cases", "--points", "3000"]).args(more);
    command.output().unwrap().into()
}

#[test]
fn the_table_is_the_answer_and_the_files_hold_everything() {
    let dir = tempfile::tempdir().unwrap();
    cases(dir.path());
    let files = ["--json", "a.json", "--csv", "a.csv", "--sheet", "a.png", "--worst", "1"];
    let said = eval(dir.path(), &files);
    assert_eq!(said.code, Some(0), "{said:?}");
    for word in ["identity", "hungarian", "by joint", "cad", "simulation", "all"] {
        assert!(said.out.contains(word), "no {word} in\n{}", said.out);
    }
    assert_eq!(said.err.lines().count(), 2, "{}", said.err);
    let text = std::fs::read_to_string(dir.path().join("a.json")).unwrap();
    let report: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(
        (&report["schema"], &report["how"]["rules"]),
        (&"kinfold-eval/1".into(), &"paper".into())
    );
    assert_eq!(report["cases"].as_array().unwrap().len(), 2);
    assert_eq!(std::fs::read_to_string(dir.path().join("a.csv")).unwrap().lines().count(), 3);
    assert!(std::fs::read(dir.path().join("a.png")).unwrap().starts_with(b"\x89PNG"));
    let again = eval(dir.path(), &["--json", "b.json", "--jobs", "2", "--quiet"]);
    assert_eq!((again.out, again.err.as_str()), (said.out, ""));
    assert_eq!(text, std::fs::read_to_string(dir.path().join("b.json")).unwrap());
}

#[test]
fn a_case_without_an_answer_is_named_and_exits_3() {
    let dir = tempfile::tempdir().unwrap();
    cases(dir.path());
    std::fs::write(dir.path().join("cases/home__cart/truth.json"), "{}").unwrap();
    let said = eval(dir.path(), &["--quiet"]);
    assert_eq!(said.code, Some(3), "{said:?}");
    assert!(said.err.starts_with("home__cart: "), "{}", said.err);
    assert!(said.err.contains("truth.json: not a truth file: missing field `schema`"));
}

#[test]
fn what_cannot_be_asked_says_what_can() {
    let dir = tempfile::tempdir().unwrap();
    cases(dir.path());
    let asked = [
        (&["--mode", "image"][..], "needs a provider"),
        (&["--articulator", "net"], "--weights FILE.safetensors"),
        (&["--articulator", "net", "--weights", "w", "--labels", "truth"], "goes with"),
        (&["--weights", "w"], "--articulator net"),
        (&["--text-features", "clip"], "--articulator net, or leave --text-features out"),
        (&["--precision", "full"], "--articulator net, or leave --precision out"),
        (&["--filter", "piano"], "none of 2 cases"),
        (&["--jobs", "0"], "1..=256"),
        (&["--json", "nowhere/a.json"], "nowhere: no such folder"),
    ];
    for (args, hint) in asked {
        let said = eval(dir.path(), args);
        assert_eq!((said.code, said.out.as_str()), (Some(2), ""), "{args:?}");
        assert!(said.err.contains(hint), "{}", said.err);
    }
    let said = eval(dir.path(), &["--articulator", "net", "--weights", "nowhere"]);
    assert_eq!(said.code, Some(1));
    assert!(said.err.contains("nowhere: "), "{}", said.err);
}
