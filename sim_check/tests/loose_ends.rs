//! Things that a model names and that are not there, and parts that lack what others have: each was
//! passed over in silence once.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on stops")]

use sim_check::read::load::from_text;
use sim_check::{Asked, CheckOptions, Status, Tier, check};

/// The statuses and the evidence of some checks of a text.
fn judged(text: &str, name: &str, ids: &[&str]) -> Vec<(Status, String)> {
    let folder = std::env::temp_dir().join(format!("kinfold-loose-{name}-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join(format!("{name}.model"));
    std::fs::write(&file, text).unwrap();
    let options =
        CheckOptions { up_to: Tier::Static, subject: Asked::Found, ..CheckOptions::default() };
    let verdict = check(&file, &options);
    let _ = std::fs::remove_dir_all(&folder);
    let one = |id: &&str| {
        let check = verdict.check(id).unwrap();
        (check.status, check.evidence.join("; "))
    };
    ids.iter().map(one).collect()
}

const BOX: &str = "<geometry><box size='.2 .2 .2'/></geometry>";

/// A body and a lid on a hinge, in URDF.
fn urdf(visual: &str, joint: &str, more: &str) -> String {
    let link = |name: &str, visual: &str| {
        format!(
            "<link name='{name}'><inertial><mass value='2'/><inertia ixx='.0133' iyy='.0133' izz='.0133' \
             ixy='0' ixz='0' iyz='0'/></inertial>{visual}<collision>{BOX}</collision></link>\n"
        )
    };
    let seen = format!("<visual>{BOX}</visual>");
    format!(
        "<robot name='crate'>\n{}{}<joint name='hinge' {joint}><parent link='body'/><child link='lid'/>\
         <origin xyz='0 0 .21'/><axis xyz='0 0 1'/><limit lower='0' upper='1' effort='1' velocity='1'/>\
         <dynamics damping='1' friction='1'/></joint>\n{more}</robot>\n",
        link("body", &seen),
        link("lid", visual)
    )
}

const SEEN: &str = "<visual><geometry><box size='.2 .2 .2'/></geometry></visual>";

#[test]
fn a_material_that_is_defined_nowhere_is_told() {
    let with = |inside: &str| SEEN.replace("</visual>", &format!("{inside}</visual>"));
    let text = urdf(&with("<material name='oak'/>"), "type='revolute'", "");
    let (status, words) = &judged(&text, "oak", &["T1"])[0];
    assert_eq!(*status, Status::Warn);
    assert!(words.contains("material `oak` is defined nowhere"), "{words}");
    for (visual, more) in [
        ("<material name='oak'/>", "<material name='oak'><color rgba='1 1 1 1'/></material>"),
        ("<material name='oak'><color rgba='1 1 1 1'/></material>", ""),
        ("<material name=''/>", ""),
    ] {
        let found = judged(&urdf(&with(visual), "type='revolute'", more), "oak_known", &["T1"]);
        assert_eq!(found[0].0, Status::Pass, "{visual}: {found:?}");
    }
}

#[test]
fn a_transmission_of_no_joint_is_told() {
    let with =
        |name: &str| format!("<transmission name='drive'><joint name='{name}'/></transmission>");
    let found = judged(&urdf(SEEN, "type='revolute'", &with("hing")), "drive", &["T1"]);
    assert!(found[0].0 == Status::Warn && found[0].1.contains("joint `hing` is not there"));
    let found = judged(&urdf(SEEN, "type='revolute'", &with("hinge")), "drive_known", &["T1"]);
    assert_eq!(found[0].0, Status::Pass, "{found:?}");
}

#[test]
fn a_joint_with_a_range_that_cannot_move_or_never_ends_is_told() {
    for (kind, words) in [("fixed", "is fixed and has a range"), ("continuous", "never ends")] {
        let joint = format!("type='{kind}'");
        let found = judged(&urdf(SEEN, &joint, ""), kind, &["J2"]);
        assert!(found[0].0 == Status::Warn && found[0].1.contains(words), "{kind}: {found:?}");
        // What exporters write into every joint is no range.
        let text = urdf(SEEN, &joint, "").replace("upper='1'", "upper='0'");
        assert_eq!(judged(&text, kind, &["J2"])[0].0, Status::Pass);
    }
    let text = urdf(SEEN, "type='continuous'", "")
        .replace("lower='0' upper='1'", "lower='-3.15' upper='3.15'");
    assert_eq!(judged(&text, "round", &["J2"])[0].0, Status::Pass, "a whole turn ends nowhere");
}

#[test]
fn a_joint_that_names_no_axis_is_told() {
    let whole = urdf(SEEN, "type='revolute'", "");
    assert_eq!(judged(&whole, "axis", &["J1"])[0].0, Status::Pass);
    let found = judged(&whole.replace("<axis xyz='0 0 1'/>", ""), "no_axis", &["J1"]);
    assert!(found[0].0 == Status::Warn && found[0].1.contains("names no axis"), "{found:?}");
}

#[test]
fn a_part_that_is_touched_and_not_seen_is_told() {
    let found = judged(&urdf("", "type='revolute'", ""), "unseen", &["G3"]);
    assert!(found[0].0 == Status::Warn, "{found:?}");
    assert!(found[0].1.contains("link `lid` can be touched and is not seen"), "{found:?}");
    // What is tied to a part that is seen is a piece of it.
    let found = judged(&urdf("", "type='fixed'", ""), "tied", &["G3"]);
    assert!(!found[0].1.contains("is not seen"), "{found:?}");
}

#[test]
fn a_model_that_touches_nothing_fails_and_is_not_unknown() {
    let text = urdf(SEEN, "type='revolute'", "");
    let bare = text.replace(&format!("<collision>{BOX}</collision>"), "");
    let found = judged(&bare, "bare", &["G3"]);
    assert!(found[0].0 == Status::Fail && found[0].1.contains("can be touched"), "{found:?}");
}

/// The same crate in MJCF.
fn mjcf(joint: &str, lid: &str, more: &str) -> String {
    format!(
        "<mujoco model='crate'><asset><material name='oak'/></asset><worldbody><body name='body'>\
         <geom type='box' size='.1 .1 .1' mass='2' contype='0' conaffinity='0' material='oak'/>\
         <geom type='box' size='.1 .1 .1' mass='0' group='3'/><body name='lid' pos='0 0 .21'>\
         <joint name='hinge' axis='0 0 1' range='0 60' {joint}/>{lid}\
         <geom type='box' size='.1 .1 .1' mass='2' group='3'/></body></body></worldbody>{more}</mujoco>"
    )
}

const SHOWN: &str =
    "<geom type='box' size='.1 .1 .1' mass='0' contype='0' conaffinity='0' material='oak'/>";

#[test]
fn what_mujoco_refuses_for_a_name_fails_and_the_rest_is_judged_all_the_same() {
    for (name, lid, more, words) in [
        ("material", &*SHOWN.replace("oak", "elm"), "", "there is no material `elm`"),
        ("drive", SHOWN, "<actuator><motor joint='hing'/></actuator>", "there is no joint `hing`"),
    ] {
        let found = judged(&mjcf("", lid, more), name, &["T1", "J1", "M1"]);
        assert!(found[0].0 == Status::Fail && found[0].1.contains(words), "{name}: {found:?}");
        assert!(found[1..].iter().all(|f| f.0 == Status::Pass), "{name}: {found:?}");
    }
    let more = "<actuator><motor joint='hinge'/></actuator>";
    let found = judged(&mjcf("", SHOWN, more), "sound", &["T1", "T2", "G3"]);
    assert!(found.iter().all(|f| f.0 == Status::Pass), "{found:?}");
}

#[test]
fn a_joint_type_of_another_format_is_no_joint_type_of_mjcf() {
    let found = judged(&mjcf("type='revolute'", SHOWN, ""), "revolute", &["T2"]);
    assert!(
        found[0].0 == Status::Fail && found[0].1.contains("`revolute` is unknown"),
        "{found:?}"
    );
}

#[test]
fn a_body_whose_geoms_are_all_in_hidden_groups_is_told() {
    let found = judged(&mjcf("", "", ""), "hidden", &["G3"]);
    assert!(found[0].1.contains("link `lid` can be touched and is not seen"), "{found:?}");
}

#[test]
fn names_that_copies_make_are_not_missed() {
    let text = mjcf("", SHOWN, "<actuator><motor joint='hinge0'/></actuator>");
    let text = text.replace("<body name='lid'", "<replicate count='2'><body name='lid'");
    let text = text.replace("</body></body></worldbody>", "</body></replicate></body></worldbody>");
    let loaded = from_text(&text, ".".as_ref(), &CheckOptions::default());
    let references = loaded.checks.iter().find(|c| c.id == "T1").unwrap();
    assert!(!references.evidence.join("; ").contains("there is no joint"), "{references:?}");
}
