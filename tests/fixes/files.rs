//! What `fix --write` leaves on disk, and what it refuses.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

use super::models::{cup, cupboard, write_meshes};
use super::{fixed, run};
use crate::kinfold::{Bench, files, names, program, say};
use crate::transcripts::is_word_for_word;

fn swapped() -> String {
    cupboard("lower=\"0\" upper=\"1.50\"", "lower=\"1.50\" upper=\"0\"")
}

#[test]
fn a_diff_is_applied_by_patch_and_gives_what_write_gives() {
    for text in [swapped(), swapped().replace('\n', "\r\n"), swapped().trim_end().to_owned()] {
        let bench = Bench::new();
        std::fs::write(bench.path("model.urdf"), &text).unwrap();
        let said = run(&bench.path(""), "model.urdf", &[]);
        assert_eq!(said.code, Some(0), "{said:?}");
        assert_eq!(std::fs::read_to_string(bench.path("model.urdf")).unwrap(), text);
        std::fs::write(bench.path("mended.diff"), &said.out).unwrap();
        let written = run(&bench.path(""), "model.urdf", &["--write"]);
        assert_eq!((written.code, written.out.as_str()), (Some(0), ""), "{written:?}");
        let due = std::fs::read(bench.path("model.urdf")).unwrap();
        std::fs::write(bench.path("model.urdf"), &text).unwrap();
        let patch = Command::new("patch")
            .current_dir(bench.path(""))
            .args(["--binary", "-s", "-p1", "-i", "mended.diff"])
            .status();
        let Ok(patch) = patch else {
            eprintln!("SKIPPED: no patch");
            return;
        };
        assert!(patch.success(), "{}", said.out);
        assert_eq!(std::fs::read(bench.path("model.urdf")).unwrap(), due);
        let again = run(&bench.path(""), "model.urdf", &["--write"]);
        assert_eq!((again.code, again.out.as_str()), (Some(0), ""), "{again:?}");
        assert!(!again.err.contains("was written"), "{}", again.err);
    }
}

#[cfg(unix)]
#[test]
fn permissions_and_links_stay_and_nothing_half_written_is_left() {
    use std::os::unix::fs::PermissionsExt as _;
    let bench = Bench::new();
    std::fs::write(bench.path("real.urdf"), swapped()).unwrap();
    let mode = std::fs::Permissions::from_mode(0o640);
    std::fs::set_permissions(bench.path("real.urdf"), mode).unwrap();
    std::os::unix::fs::symlink("real.urdf", bench.path("model.urdf")).unwrap();
    let known: Vec<String> = files(&bench.path("")).into_keys().collect();
    let said = run(&bench.path(""), "model.urdf", &["--write"]);
    assert_eq!(said.code, Some(0), "{said:?}");
    assert!(bench.path("model.urdf").symlink_metadata().unwrap().is_symlink());
    let about = std::fs::metadata(bench.path("real.urdf")).unwrap();
    assert_eq!(about.permissions().mode() & 0o777, 0o640);
    assert_eq!(names(&files(&bench.path(""))), known);
}

#[test]
fn new_meshes_stand_beside_the_old_ones_and_replace_none() {
    let bench = Bench::new();
    write_meshes(&bench.path(""));
    std::fs::write(bench.path("hollow_convex.obj"), "mine").unwrap();
    std::fs::write(bench.path("model.urdf"), cup("hollow.obj")).unwrap();
    let hollow = std::fs::read(bench.path("hollow.obj")).unwrap();
    let answer: Value = fixed(&bench.path(""), "model.urdf", &["--write"]);
    assert_eq!(answer["written"], true);
    let new = answer["new_files"].as_array().unwrap();
    assert!(
        new.len() > 1 && new.iter().all(|f| bench.path(f.as_str().unwrap()).is_file()),
        "{new:?}"
    );
    assert_eq!(std::fs::read(bench.path("hollow.obj")).unwrap(), hollow);
    assert_eq!(std::fs::read(bench.path("hollow_convex.obj")).unwrap(), b"mine");
    let text = std::fs::read_to_string(bench.path("model.urdf")).unwrap();
    assert!(
        text.contains("<collision name=\"skin\">") && text.contains("<collision name=\"skin_2\">")
    );
    let checked: Value = {
        let said = program()
            .current_dir(bench.path(""))
            .args(["check", "model.urdf", "--json", "--tier", "dynamic"])
            .output()
            .unwrap();
        serde_json::from_slice(&said.stdout).unwrap()
    };
    assert_eq!(checked["checks"], answer["verdicts"]["after"]["checks"]);
}

#[test]
fn odd_files_and_words_are_refused_with_what_to_do() {
    let bench = Bench::new();
    std::fs::write(bench.path("text.urdf"), "no xml").unwrap();
    std::fs::write(bench.path("latin.urdf"), b"<robot name='\xe4'/>").unwrap();
    std::fs::write(
        bench.path("two.urdf"),
        "<robot name='r'><link name='a'/><link name='b'/></robot>",
    )
    .unwrap();
    let of = |name: &str, more: &[&str]| run(&bench.path(""), name, more);
    for (name, code, words) in [
        ("text.urdf", 1, "stays F1"),
        ("latin.urdf", 1, "not UTF-8"),
        ("nothing.urdf", 1, "nothing.urdf"),
        ("two.urdf", 1, "stays T1"),
        (".", 2, "is a folder"),
    ] {
        let said = of(name, &["--write"]);
        assert_eq!((said.code, said.out.as_str()), (Some(code), ""), "{name}: {said:?}");
        assert!(said.err.contains(words), "{name}: {}", said.err);
    }
    let said = of("two.urdf", &["--only", "F1"]);
    assert_eq!(said.code, Some(2));
    assert!(
        said.err.contains("nothing mends what F1 finds")
            && said.err.contains("hint: --only takes C1"),
        "{}",
        said.err
    );
    for args in [&["fix"][..], &["fix", "a", "--only", "Q1"], &["fix", "a", "--diff", "--write"]] {
        assert_eq!(say(args).code, Some(2), "{args:?}");
    }
}

#[cfg(unix)]
#[test]
fn a_read_only_file_is_left_and_said() {
    use std::os::unix::fs::PermissionsExt as _;
    let bench = Bench::new();
    std::fs::write(bench.path("model.urdf"), swapped()).unwrap();
    let mode = std::fs::Permissions::from_mode(0o444);
    std::fs::set_permissions(bench.path("model.urdf"), mode).unwrap();
    let said = run(&bench.path(""), "model.urdf", &["--write"]);
    assert_eq!(said.code, Some(1), "{said:?}");
    assert!(said.err.contains("is read-only") && said.err.contains("hint:"), "{}", said.err);
    assert_eq!(std::fs::read_to_string(bench.path("model.urdf")).unwrap(), swapped());
}

#[test]
fn a_mesh_that_is_missing_leaves_the_rest_to_be_mended() {
    let bench = Bench::new();
    let model =
        swapped().replacen("<box size=\"0.5 0.4 0.6\"/>", "<mesh filename=\"nope.stl\"/>", 1);
    std::fs::write(bench.path("model.urdf"), model).unwrap();
    let answer = fixed(&bench.path(""), "model.urdf", &[]);
    assert!(answer["changes"].to_string().contains("swapped"), "{answer:#}");
    assert!(answer["left"].to_string().contains("F2"));
}

#[test]
fn what_can_be_mended_is_listed_and_the_page_says_the_same() {
    let said = say(&["fix", "--list"]);
    assert_eq!(said.code, Some(0));
    is_word_for_word("fix_list", &said.out);
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/fixes.md");
    let page = std::fs::read_to_string(page).unwrap().replace('`', "");
    let all: Value = serde_json::from_str(&say(&["fix", "--list", "--json"]).out).unwrap();
    for remedy in all.as_array().unwrap() {
        let text = |key: &str| remedy[key].as_str().unwrap().to_owned();
        let rules: Vec<&str> =
            remedy["rules"].as_array().unwrap().iter().map(|r| r.as_str().unwrap()).collect();
        let row = format!("| {} | {} | {} |", rules.join(", "), text("found"), text("change"));
        assert!(page.contains(&row), "{row}");
    }
}

#[test]
fn help_says_what_is_written_and_what_the_exit_codes_mean() {
    let said = say(&["fix", "--help"]);
    assert_eq!(said.code, Some(0));
    is_word_for_word("help_fix", &said.out);
}

#[test]
fn a_person_is_told_what_changed_and_what_stays() {
    let bench = Bench::new();
    std::fs::write(bench.path("cupboard.urdf"), swapped().replace("velocity=\"1\"", "")).unwrap();
    let said = run(&bench.path(""), "cupboard.urdf", &[]);
    assert_eq!(said.code, Some(3), "{said:?}");
    is_word_for_word("fix_cupboard", &format!("{}\n{}", said.out, said.err));
}
