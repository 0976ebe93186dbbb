//! `kinfold fix`: one defect of each kind, mended by the smallest change, and nothing worse for it.

mod files;
pub mod models;

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::Value;

use crate::kinfold::{Bench, Said, files as all_files, program};
use models::{cup, cupboard, mjcf};

/// What `fix` answers for programs.
pub fn fixed(folder: &Path, name: &str, more: &[&str]) -> Value {
    let said = run(folder, name, &[&["--json"], more].concat());
    serde_json::from_str(&said.out).unwrap_or_else(|e| panic!("{e}: {said:?}"))
}

/// Runs `fix` on a file of a folder.
pub fn run(folder: &Path, name: &str, more: &[&str]) -> Said {
    program().current_dir(folder).arg("fix").arg(name).args(more).output().unwrap().into()
}

/// The statuses of a verdict by check.
fn statuses(verdict: &Value) -> BTreeMap<String, String> {
    let checks = verdict["checks"].as_array().unwrap().iter();
    let text = |v: &Value| v.as_str().unwrap().to_owned();
    checks.map(|c| (text(&c["id"]), text(&c["status"]))).collect()
}

/// Checks that hold before and not after.
fn worse(answer: &Value) -> Vec<String> {
    let [before, after] = ["before", "after"].map(|when| statuses(&answer["verdicts"][when]));
    let holds = |s: &str| matches!(s, "pass" | "warn");
    let is_worse = |id: &&String| holds(&before[*id]) && !holds(&after[*id]);
    before.keys().filter(is_worse).cloned().collect()
}

/// One defect: it fails the check, the words stand in the change, the diff has these lines in and out.
struct Case {
    model: String,
    check: &'static str,
    change: &'static str,
    lines: [usize; 2],
}

/// Lines that a diff puts in and takes out.
fn lines(diff: &str) -> [usize; 2] {
    let count = |mark: char, head: &str| {
        diff.lines().filter(|l| l.starts_with(mark) && !l.starts_with(head)).count()
    };
    [count('+', "+++"), count('-', "---")]
}

#[track_caller]
fn mended(case: &Case) -> Value {
    let bench = Bench::new();
    models::write_meshes(&bench.path(""));
    std::fs::write(bench.path("model.urdf"), &case.model).unwrap();
    let answer = fixed(&bench.path(""), "model.urdf", &[]);
    let [before, after] = ["before", "after"].map(|when| statuses(&answer["verdicts"][when]));
    assert!(!matches!(before[case.check].as_str(), "pass" | "warn"), "{} holds", case.check);
    assert!(matches!(after[case.check].as_str(), "pass" | "warn"), "{}: {answer:#}", case.check);
    assert_eq!(worse(&answer), [""; 0], "{answer:#}");
    let changes = answer["changes"].to_string();
    assert!(changes.contains(case.change), "{}: {changes}", case.change);
    assert_eq!(lines(answer["diff"].as_str().unwrap()), case.lines, "{}", answer["diff"]);
    answer
}

#[test]
fn a_cupboard_that_is_sound_is_left_alone() {
    let bench = Bench::new();
    std::fs::write(bench.path("model.urdf"), cupboard("", "")).unwrap();
    let said = run(&bench.path(""), "model.urdf", &[]);
    assert_eq!((said.code, said.out.as_str()), (Some(0), ""), "{said:?}");
}

#[test]
fn limits_that_are_swapped_change_places_and_keep_their_digits() {
    let case = Case {
        model: cupboard("lower=\"0\" upper=\"1.50\"", "lower=\"1.50\" upper=\"0\""),
        check: "J2",
        change: "they were swapped",
        lines: [1, 1],
    };
    let diff = mended(&case)["diff"].to_string();
    assert!(diff.contains("lower=\\\"0\\\" upper=\\\"1.50\\\" effort"), "{diff}");
}

#[test]
fn limits_in_degrees_become_radians_and_several_turns_are_left_to_a_person() {
    let with = |upper: &str| cupboard("upper=\"1.50\"", &format!("upper=\"{upper}\""));
    mended(&Case { model: with("90"), check: "J3", change: "were degrees", lines: [1, 1] });
    let bench = Bench::new();
    std::fs::write(bench.path("model.urdf"), with("12.5")).unwrap();
    let answer = fixed(&bench.path(""), "model.urdf", &["--only", "J3"]);
    assert_eq!(answer["diff"], "");
    assert!(answer["left"].to_string().contains("may be radians"), "{:#}", answer["left"]);
}

#[test]
fn an_axis_gets_length_1_and_one_without_direction_is_said() {
    let with = |axis: &str| cupboard("xyz=\"0 0 -1\"", &format!("xyz=\"{axis}\""));
    mended(&Case { model: with("0 0 -2.5"), check: "J1", change: "of length 1", lines: [1, 1] });
    let bench = Bench::new();
    std::fs::write(bench.path("model.urdf"), with("0 0 0")).unwrap();
    let said = run(&bench.path(""), "model.urdf", &[]);
    assert_eq!((said.code, said.out.as_str()), (Some(3), ""), "{said:?}");
    assert!(said.err.contains("its axis has no direction"), "{}", said.err);
}

#[test]
fn inertia_of_no_body_or_of_another_is_computed_from_the_shape() {
    for (new, check) in [("ixx=\"-0.02\"", "M3"), ("ixx=\"9\"", "M3"), ("ixx=\"0.9\"", "M3")] {
        let model = cupboard("ixx=\"0.0868\"", new);
        mended(&Case { model, check, change: "inertia of its shape with 2 kg", lines: [1, 1] });
    }
    let identity = cupboard(
        "<inertia ixx=\"0.0868\" iyy=\"0.0601\" izz=\"0.0268\"",
        "<inertia ixx=\"1\" iyy=\"1\" izz=\"1\"",
    );
    mended(&Case { model: identity, check: "M4", change: "inertia of its shape", lines: [1, 1] });
}

#[test]
fn a_centre_of_mass_outside_goes_inside_and_inertia_stays() {
    let model =
        cupboard("<origin xyz=\"0.011 0.2 0\"/><!-- weight -->", "<origin xyz=\"0.5 0.2 0\"/>");
    let answer = mended(&Case { model, check: "M5", change: "centre of mass", lines: [1, 1] });
    assert!(answer["diff"].as_str().unwrap().contains("+      <origin xyz=\"0.011 0.2 0\"/>"));
}

#[test]
fn a_link_without_mass_gets_that_of_its_shape_and_the_guess_is_said() {
    let none = cupboard("<mass value=\"2\"/>", "<mass value=\"0\"/>");
    mended(&Case { model: none, check: "M1", change: "that of the other links", lines: [2, 2] });
    let (from, to) =
        ("    <inertial>\n      <origin xyz=\"0.011", "    </inertial>\n    <visual><!-- door");
    let whole = cupboard("", "");
    let [start, end] = [from, to].map(|part| whole.find(part).unwrap());
    let without = format!("{}{}", &whole[..start], &whole[end + "    </inertial>\n".len()..]);
    mended(&Case {
        model: without,
        check: "M1",
        change: "with inertia of its shape",
        lines: [5, 0],
    });
}

#[test]
fn what_is_seen_and_not_touched_gets_the_same_primitive() {
    let whole = cupboard("", "");
    let start = whole.find("    <collision><!-- door").unwrap();
    let end = start + whole[start..].find("</collision>\n").unwrap() + "</collision>\n".len();
    let without = format!("{}{}", &whole[..start], &whole[end..]);
    let answer =
        mended(&Case { model: without, check: "G3", change: "like what is seen", lines: [6, 0] });
    let due = "+    <collision>\n+      <origin xyz=\"0.011 0.2 0\"/>\n+      <geometry>\n+        <box size=\"0.02 0.4 0.6\"/>\n+      </geometry>\n+    </collision>\n";
    assert!(answer["diff"].as_str().unwrap().contains(due), "{}", answer["diff"]);
}

#[test]
fn a_range_that_runs_into_the_body_ends_before_it() {
    let model = cupboard("lower=\"0\"", "lower=\"-1.50\"");
    let answer =
        mended(&Case { model, check: "C2", change: "beyond them parts meet", lines: [1, 1] });
    assert_eq!(answer["after"]["tier"], "dynamic", "{answer:#}");
}

#[test]
fn a_door_that_opens_into_the_body_is_turned_round() {
    let model = cupboard("xyz=\"0 0 -1\"", "xyz=\"0 0 1\"");
    mended(&Case { model, check: "C5", change: "turned round", lines: [1, 1] });
}

#[test]
fn a_pivot_off_its_door_goes_to_the_edge_and_nothing_moves_at_rest() {
    // The same door, its hinge half a metre in front of it.
    let model = cupboard("<origin xyz=\"0.26 -0.2 0\"/>", "<origin xyz=\"0.76 -0.2 0\"/>")
        .replace("xyz=\"0.011 0.2 0\"", "xyz=\"-0.489 0.2 0\"");
    let answer = mended(&Case { model, check: "J5", change: "pivot moved", lines: [4, 4] });
    assert_eq!(answer["after"]["tier"], "dynamic", "{answer:#}");
}

#[test]
fn meshes_that_are_open_inside_out_or_hollow_give_way_to_sound_ones() {
    let case = |mesh: &str, check, change| Case { model: cup(mesh), check, change, lines: [0, 0] };
    for (mesh, check, change) in [
        ("open.obj", "G2", "1 convex piece in place of"),
        ("inward.obj", "G2", "faces turned round"),
        ("inward.obj", "G1", "faces turned round"),
        ("hollow.obj", "G2", "convex pieces in place of"),
    ] {
        let bench = Bench::new();
        models::write_meshes(&bench.path(""));
        std::fs::write(bench.path("model.urdf"), case(mesh, check, change).model).unwrap();
        let answer = fixed(&bench.path(""), "model.urdf", &[]);
        let after = statuses(&answer["verdicts"]["after"]);
        assert_eq!(after[check], "pass", "{mesh}: {answer:#}");
        assert!(answer["changes"].to_string().contains(change), "{mesh}: {:#}", answer["changes"]);
        assert_eq!(worse(&answer), [""; 0]);
    }
}

#[test]
fn only_what_is_asked_for_is_mended() {
    let bench = Bench::new();
    let model = cupboard("lower=\"0\" upper=\"1.50\"", "lower=\"1.50\" upper=\"0\"")
        .replace("ixx=\"0.0868\"", "ixx=\"9\"");
    std::fs::write(bench.path("model.urdf"), model).unwrap();
    let rules = |more: &[&str]| {
        let answer = fixed(&bench.path(""), "model.urdf", more);
        let changes = answer["changes"].as_array().unwrap().clone();
        changes.iter().map(|c| c["rules"][0].as_str().unwrap().to_owned()).collect::<Vec<_>>()
    };
    assert_eq!(rules(&["--only", "j2"]), ["J2"]);
    assert_eq!(rules(&["--only", "M3", "--only", "M4"]), ["M3"]);
    assert_eq!(rules(&[]), ["J2", "M3"]);
}

#[test]
fn an_mjcf_model_is_mended_in_its_own_words() {
    let case = |from: &str, to: &str| {
        let bench = Bench::new();
        std::fs::write(bench.path("model.xml"), mjcf(from, to)).unwrap();
        fixed(&bench.path(""), "model.xml", &["--as", "object"])
    };
    let swapped = case("range=\"0 85\"", "range=\"85 0\"");
    assert!(
        swapped["diff"].as_str().unwrap().contains(
            "+      <joint name=\"hinge\" axis=\"0 0 -1\" pos=\"0 -0.2 0\" range=\"0 85\""
        ),
        "{swapped:#}"
    );
    let clamped = case("range=\"0 85\"", "range=\"-85 85\"");
    assert!(clamped["changes"].to_string().contains("beyond them parts meet"), "{clamped:#}");
    let inertia = case("diaginertia=\"0.0868 0.0601 0.0268\"", "diaginertia=\"2 2 2\"");
    assert!(inertia["changes"].to_string().contains("inertia of its shape"), "{inertia:#}");
    for answer in [swapped, clamped, inertia] {
        assert_eq!(worse(&answer), [""; 0], "{answer:#}");
    }
}

#[test]
fn what_a_macro_makes_is_named_and_left() {
    let bench = Bench::new();
    let text = "<robot name=\"r\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\">\n\
        <xacro:macro name=\"door\" params=\"up\">\n<joint name=\"hinge\" type=\"revolute\">\
        <parent link=\"a\"/><child link=\"b\"/><axis xyz=\"0 0 1\"/>\
        <limit lower=\"2\" upper=\"${up}\" effort=\"1\" velocity=\"1\"/></joint>\n</xacro:macro>\n\
        <link name=\"a\"/>\n<link name=\"b\"/>\n<xacro:door up=\"1\"/>\n</robot>\n";
    std::fs::write(bench.path("model.xacro"), text).unwrap();
    let answer = fixed(&bench.path(""), "model.xacro", &["--only", "J2"]);
    assert_eq!(answer["diff"], "");
    let left = answer["left"].to_string();
    assert!(left.contains("comes from a macro or an included file"), "{left}");
}

#[test]
fn a_xacro_keeps_its_macros_and_what_they_tell_is_left() {
    let bench = Bench::new();
    let head = "<robot name=\"r\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\"><xacro:property name=\"up\" value=\"1.5\"/>";
    let with = |limits: &str| {
        let text = cupboard("<robot name=\"cupboard\">", head)
            .replace("lower=\"0\" upper=\"1.50\"", limits);
        std::fs::write(bench.path("model.xacro"), text).unwrap();
        fixed(&bench.path(""), "model.xacro", &["--only", "J1", "--only", "J2"])
    };
    let mended = with("lower=\"1.5\" upper=\"0\" unit=\"${up}\"");
    assert_eq!(lines(mended["diff"].as_str().unwrap()), [1, 1], "{mended:#}");
    let left = with("lower=\"${up}\" upper=\"0\"");
    assert_eq!(left["diff"], "");
    assert!(left["left"].to_string().contains("a macro or a substitution tells"), "{left:#}");
}

#[test]
fn the_same_model_gives_the_same_bytes() {
    let made = || {
        let bench = Bench::new();
        models::write_meshes(&bench.path(""));
        std::fs::write(bench.path("model.urdf"), cup("hollow.obj")).unwrap();
        let said = run(&bench.path(""), "model.urdf", &["--write"]);
        assert!(matches!(said.code, Some(0 | 3)), "{said:?}");
        all_files(&bench.path(""))
    };
    assert_eq!(made(), made());
}
