use glamx::DVec3;

use super::*;
use crate::articulated::Range;
use crate::kinematics::JointKind;
use crate::mesh::Mesh;

fn read(parts: &str) -> Result<Condition, ConditionError> {
    Condition::from_json(&format!(r#"{{"schema": "kinfold-condition/1", "parts": [{parts}]}}"#))
}

#[test]
fn names_stand_in_for_texts_and_joints_may_be_one_or_two() {
    let c = read(
        r#"{"name": "bottle_neck"},
           {"name": "cap", "parent": "bottle_neck", "joint": ["prismatic", "continuous"]}"#,
    )
    .unwrap();
    assert_eq!(c.text(0), "bottle neck");
    assert_eq!(c.tree.parts()[1].joints, [JointKind::Prismatic, JointKind::Continuous]);
}

#[test]
fn every_broken_rule_is_named_with_its_part() {
    let rule = |parts: &str| read(parts).unwrap_err().to_string();
    assert!(rule(r#"{"name": "a"}, {"name": "b", "parent": "x"}"#).contains("parent `x`"));
    let two = r#"{"name": "a"}, {"name": "b"}, {"name": "c", "parent": "a"}, {"name": "c", "parent": "b"}"#;
    assert_eq!(rule(two), "line 1: part `c` has two parents, `a` and `b`");
    let cycle = r#"{"name": "a"}, {"name": "b", "parent": "c"}, {"name": "c", "parent": "b"}"#;
    assert!(rule(cycle).contains("cycle"));
    let twins = r#"{"name": "a"}, {"name": "b", "text": "door", "parent": "a"},
        {"name": "c", "text": "Door", "parent": "a", "point": [0, 0, 0]}"#;
    assert!(rule(twins).contains("`b` has no point"));
    assert!(rule(r#"{"name": "a", "density": -1}"#).contains("density must be in 1 to 25,000"));
    assert!(rule(r#"{"name": "a", "colour": 1}"#).contains("unknown field `colour`"));
}

#[test]
fn the_foreign_schema_is_read_with_points_turned_upright() {
    let c = Condition::from_json(
        r#"{"schema": "condition/1", "id": "x", "category": "bin", "source": "hand",
            "real_size_m": {"largest_extent": 0.65, "evidence": "measured"},
            "parts": [
              {"id": 0, "text": "bin body", "parent": null, "joints": [], "point": [0, 1, 0]},
              {"id": 1, "text": "2nd lid!", "parent": 0, "joints": ["revolute"], "point": [1, 2, 3]}]}"#,
    )
    .unwrap();
    assert_eq!(c.tree.parts()[1].name, "part_2nd_lid");
    assert_eq!(c.prompts[1].point, Some(DVec3::new(1.0, -3.0, 2.0)));
    assert_eq!(c.size, Some(TrueSize { of: Extent::Largest, metres: 0.65 }));
}

#[test]
fn a_point_off_the_mesh_is_refused_with_its_distance() {
    let v = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
    let mesh = Mesh::new(v, vec![[0, 1, 2]]).unwrap();
    let at = |y: f64| read(&format!(r#"{{"name": "a", "point": [0.2, {y}, -0.2]}}"#)).unwrap();
    assert!(at(0.001).check_points(&mesh).is_ok());
    let e = at(0.5).check_points(&mesh).unwrap_err().to_string();
    assert!(e.contains("(0.2, 0.5, -0.2) lies 0.5000 off the mesh"), "{e}");
}

fn second(parts: &str) -> Result<Condition, ConditionError> {
    Condition::from_json(&format!(
        "{{\"schema\": \"kinfold-condition/2\", \"parts\": [\n{parts}]}}"
    ))
}

fn faults(parts: &str) -> Vec<String> {
    second(parts).unwrap_err().faults().map(ToString::to_string).collect()
}

const BODY: &str = r#"{"name": "body"}, "#;

/// A square of side 1 in z = 0, object frame.
fn square() -> Mesh {
    let v = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::X + DVec3::Y];
    Mesh::new(v, vec![[0, 1, 2], [1, 3, 2]]).unwrap()
}

#[test]
fn everything_that_is_wrong_is_told_at_once_with_its_line() {
    let told = faults(
        "{\"name\": \"body\", \"mass\": -1},
         {\"name\": \"door\", \"parent\": \"bodi\", \"joint\": \"hinge\"},
         {\"name\": \"knob\", \"parent\": \"body\", \"jont\": \"continuous\", \"friction\": \"low\"}",
    );
    let expected = [
        "line 2: part `body`: mass must be in 1e-6 to 1e5 kg, found -1",
        "line 3: part `door`: `joint`: `hinge` is no joint; there are revolute, continuous, prismatic: did you mean `revolute`?",
        "line 3: part `door` names the parent `bodi`, which no part is called: did you mean `body`?",
    ];
    assert_eq!(told[..3], expected);
    assert!(
        told[3].starts_with("line 4: part `knob`: unknown field `jont`: did you mean `joint`?")
    );
    assert_eq!(told[4], "line 4: part `knob`: `friction` is a number, found the text \"low\"");
    assert_eq!(told.len(), 5);
}

#[test]
fn a_byte_order_mark_comments_and_json5_are_read() {
    let text =
        "\u{feff}// an oven\n{schema: 'kinfold-condition/2', /* one */ parts: [{name: 'a',},],}";
    assert_eq!(Condition::from_json(text).unwrap().tree.len(), 1);
    let c = Condition::from_json("{\"parts\": [{\"name\": \"a\"}]}").unwrap();
    assert_eq!(c.text(0), "a", "the schema may be left out");
}

#[test]
fn what_is_no_json_says_where() {
    let told = |text: &str| Condition::from_json(text).unwrap_err().to_string();
    assert!(
        told("{\n  \"parts\": [\n}").starts_with("line 3: not a condition: not JSON: "),
        "{}",
        told("{\n  \"parts\": [\n}")
    );
    assert!(told("").contains("the file is empty"));
    assert!(told("[]").contains("a condition is an object"));
    assert!(told("{}").contains("`parts` is missing"));
    assert!(told(&"[".repeat(100_000)).contains("not JSON"));
    assert!(
        told(r#"{"schema": "kinfold-condition/3", "parts": [{"name": "a"}]}"#).contains("unknown")
    );
}

#[test]
fn a_joint_by_another_name_is_offered_ours() {
    let told = |joint: &str| {
        faults(&format!("{BODY}{{\"name\": \"b\", \"parent\": \"body\", \"joint\": {joint}}}"))
    };
    assert!(told("\"Revolute\"")[0].ends_with("did you mean `revolute`?"));
    assert!(told("\"slider\"")[0].ends_with("did you mean `prismatic`?"));
    assert!(told("\"fixed\"")[0].ends_with("leave it out where a part does not move"));
    assert!(told("\"ball\"")[0].ends_with("there are revolute, continuous, prismatic"));
    assert!(told("3")[0].contains("found the number 3"));
    assert!(told("[\"revolute\", \"revolute\", \"prismatic\"]")[0].contains("at most two joints"));
}

#[test]
fn a_size_is_an_object_with_one_extent_and_says_so() {
    let told = |size: &str| {
        let text = format!("{{\"size\": {size}, \"parts\": [{{\"name\": \"a\"}}]}}");
        Condition::from_json(&text).map(|c| c.size.unwrap().metres).map_err(|e| e.to_string())
    };
    assert_eq!(told("{\"height\": 0.9}"), Ok(0.9));
    assert_eq!(told("{\"height\": \"90 cm\"}"), Ok(0.9));
    assert!(
        told("0.9")
            .unwrap_err()
            .contains("`size` is an object with one of largest, height, width, depth")
    );
    assert!(told("{\"height\": 1, \"width\": 2}").unwrap_err().contains("found 2: height, width"));
    assert!(told("{\"height\": \"tall\"}").unwrap_err().contains("a length is a number of metres"));
    assert!(told("{\"heigth\": 1}").unwrap_err().contains("did you mean `height`?"));
    assert!(
        told("{\"height\": 900}").unwrap_err().contains("size must be in 0.005 to 20 m, found 900")
    );
}

#[test]
fn several_points_and_what_is_not_of_a_part_are_kept() {
    let c = second(&format!(
        "{BODY}{{\"name\": \"lid\", \"parent\": \"body\", \"joint\": \"revolute\",
          \"points\": [[1, 0, 0], [0, 1, 0]], \"not\": [0, 0, 1]}}"
    ))
    .unwrap();
    let lid = &c.prompts[1];
    assert_eq!(lid.points().collect::<Vec<_>>(), [DVec3::X, DVec3::Z]);
    assert_eq!(
        (lid.point, &lid.not[..]),
        (Some(DVec3::X), &[DVec3::NEG_Y][..]),
        "y is up in the file"
    );
}

#[test]
fn what_a_person_says_of_a_joint_is_kept_about_the_pose_that_is_shown() {
    let c = second(&format!(
        "{BODY}{{\"name\": \"door\", \"parent\": \"body\", \"joint\": \"revolute\", \"axis\": [0, 2, 0],
          \"pivot\": [1, 2, 3], \"range\": [0, \"90°\"], \"rest\": 0.5, \"effort\": 4, \"damping\": 0.1}}"
    ))
    .unwrap();
    let given = c.prompts[1].given(0);
    assert_eq!((given.axis, given.pivot), (Some(DVec3::Z), Some(DVec3::new(1.0, -3.0, 2.0))));
    let upper = std::f64::consts::FRAC_PI_2 - 0.5;
    assert_eq!(given.range, Some(Range::Limits { lower: -0.5, upper }));
    assert_eq!((given.open_by, given.effort, given.damping), (None, Some(4.0), Some(0.1)));
    let c = second(&format!(
        "{BODY}{{\"name\": \"tray\", \"parent\": \"body\", \"joint\": \"prismatic\", \"rest\": \"12 cm\"}}"
    ))
    .unwrap();
    assert_eq!(c.prompts[1].given(0), GivenJoint { open_by: Some(0.12), ..GivenJoint::default() });
}

#[test]
fn two_hinges_of_one_part_are_given_an_axis_each() {
    let two = |axes: [&str; 2]| {
        let joint = |axis: &str| format!("{{\"type\": \"revolute\"{axis}}}");
        let [first, second_] = axes.map(joint);
        second(&format!(
            "{BODY}{{\"name\": \"lamp\", \"parent\": \"body\", \"joints\": [{first}, {second_}]}}"
        ))
    };
    let c = two([", \"axis\": [1, 0, 0]", ", \"axis\": [0, 1, 0]"]).unwrap();
    assert_eq!(c.tree.parts()[1].joints, [JointKind::Revolute; 2]);
    assert_eq!(c.prompts[1].given(1).axis, Some(DVec3::Z));
    let told = two(["", ", \"axis\": [0, 1, 0]"]).unwrap_err().to_string();
    assert!(told.contains("two joints of one kind need an `axis` each"), "{told}");
}

#[test]
fn corrections_that_make_no_sense_are_refused() {
    let told = |rest: &str| {
        let parts = format!("{BODY}{{\"name\": \"b\", \"parent\": \"body\", {rest}}}");
        let told = faults(&parts);
        assert_eq!(told.len(), 1, "{told:?}");
        told[0].clone()
    };
    let hinge = "\"joint\": \"revolute\"";
    assert!(told("\"axis\": [1, 0, 0]").contains("it has no joint"));
    assert!(told(&format!("{hinge}, \"axis\": [0, 0, 0]")).contains("that are not all 0"));
    assert!(
        told(&format!("{hinge}, \"axis\": [0, 1]")).contains("a list of three numbers, found 2")
    );
    assert!(
        told(&format!("{hinge}, \"range\": [1, 0]")).contains("from its lower to its upper end")
    );
    assert!(told(&format!("{hinge}, \"range\": [0, 7]")).contains("over 0.0001 to 6.2832 rad"));
    assert!(told(&format!("{hinge}, \"range\": [0, 1e-300]")).contains("found 0 to 0.000"));
    assert!(told(&format!("{hinge}, \"rest\": 1e6")).contains("from 0 to 6.2832 rad"));
    assert!(
        told(&format!("{hinge}, \"range\": [0, 1], \"rest\": 2")).contains("lies within `range`")
    );
    assert!(told(&format!("{hinge}, \"rest\": -1")).contains("how far it is open"));
    assert!(
        told(&format!("{hinge}, \"range\": [0, \"12 cm\"]"))
            .contains("an angle is a number of radians")
    );
    assert!(told("\"joint\": \"continuous\", \"range\": [0, 1]").contains("turns without end"));
    assert!(
        told("\"joint\": [\"revolute\", \"prismatic\"], \"axis\": [1, 0, 0]")
            .contains("in `joints`")
    );
    assert!(told(&format!("{hinge}, \"faces\": \"0-3\"")).contains("say in which"));
}

#[test]
fn a_file_of_the_first_schema_says_nothing_of_the_second() {
    let told = read(
        r#"{"name": "a"}, {"name": "b", "parent": "a", "joint": "revolute", "axis": [1, 0, 0]}"#,
    );
    let told = told.unwrap_err().to_string();
    assert!(told.contains("`axis` is of `kinfold-condition/2`"), "{told}");
}

#[test]
fn a_condition_without_corrections_is_kept_as_before() {
    let c = read(r#"{"name": "a", "point": [1, 2, 3]}"#).unwrap();
    let kept = serde_json::to_string(&c).unwrap();
    for new in ["also", "not", "faces", "joints\":[{", "painted_on"] {
        assert!(!kept.contains(new), "{kept}");
    }
    assert_eq!(serde_json::from_str::<Condition>(&kept).unwrap(), c);
}

#[test]
fn points_off_the_mesh_are_all_told_with_the_nearest_and_what_they_look_like() {
    // In the file y is up: the square lies in y = 0.
    let off = |points: [&str; 2]| {
        let [a, b] = points;
        let c = second(&format!(
            "{{\"name\": \"a\", \"point\": {a}}}, {{\"name\": \"b\", \"parent\": \"a\", \"not\": [{b}]}}"
        ));
        let told = c.unwrap().check_points(&square()).unwrap_err();
        told.faults().map(ToString::to_string).collect::<Vec<_>>()
    };
    let told = off(["[0.5, 0.5, 0]", "[0.25, 0.5, 0]"]);
    assert!(told[0].contains("(0.5, 0.5, 0) lies 0.5000 off the mesh"), "{told:?}");
    assert!(told[0].ends_with("nearest on it is (0.5, 0, 0)"), "{told:?}");
    assert!(told[1].starts_with("part `b`: `not` point (0.25, 0.5, 0)"), "{told:?}");
    assert!(told[1].contains("z-up coordinates, as Blender has them"), "{told:?}");
    let told = off(["[500, 0, -500]", "[250, 0, -500]"]);
    assert!(told[1].contains("1000 times too large"), "{told:?}");
    let told = off(["[5, 0, -500]", "[250, 7, -500]"]);
    assert!(told.iter().all(|t| !t.contains("look")), "{told:?}");
}

#[test]
fn points_off_the_mesh_are_moved_onto_it_where_that_is_asked_for() {
    let c = second(r#"{"name": "a", "points": [[0.5, 0.5, -0.5], [0.5, 0.001, -0.5]]}"#).unwrap();
    let (snapped, count) = c.snapped(&square());
    assert_eq!((count, snapped.prompts[0].point), (1, Some(DVec3::new(0.5, 0.5, 0.0))));
    assert_eq!(snapped.prompts[0].also, c.prompts[0].also, "what is near enough stays");
    assert!(snapped.check_points(&square()).is_ok());
}

#[test]
fn painted_faces_are_those_of_the_mesh_they_were_painted_on() {
    let painted = |mesh: &str, faces: &str| {
        Condition::from_json(&format!(
            r#"{{"mesh": "{mesh}", "parts": [{{"name": "a", "faces": "{faces}"}}]}}"#
        ))
        .unwrap()
        .check_points(&square())
        .map_err(|e| e.to_string())
    };
    let digest = square().digest();
    assert_eq!(painted(&digest, "0-1"), Ok(()));
    assert!(painted(&digest, "0-2").unwrap_err().contains("face 2 is painted, but the mesh has 2"));
    assert!(painted("abc", "0").unwrap_err().contains("painted on the mesh abc"));
    let both = Condition::from_json(
        r#"{"mesh": "x", "parts": [{"name": "a", "faces": "0-5"}, {"name": "b", "parent": "a", "faces": "3"}]}"#,
    );
    assert!(both.unwrap_err().to_string().contains("face 3 is painted as `a`'s, too"));
}

#[test]
fn what_only_a_finished_asset_has_is_no_question_of_shape() {
    let condition = |more: &str, slide: &str| {
        let parts = format!(
            "{{\"name\": \"body\"{more}}}, {{\"name\": \"tray\", \"parent\": \"body\", \"joint\": \"prismatic\"{slide}}}"
        );
        let text = format!("{{\"size\": {{\"height\": 0.5}}, \"parts\": [{parts}]}}");
        Condition::from_json(&text).unwrap()
    };
    let plain = condition("", "").of_shape();
    assert_eq!(
        (plain.size, plain.clone()),
        (None, condition(", \"mass\": 3, \"material\": \"oak\"", "").of_shape())
    );
    assert_eq!(plain, condition("", ", \"effort\": 4").of_shape(), "a drive alone");
    let long = condition("", ", \"range\": [0, 0.2]").of_shape();
    assert!(long.size.is_some(), "how long that is on the mesh depends on its size");
    assert_ne!(plain, condition(", \"not\": [1, 2, 3]", "").of_shape());
}

#[test]
fn an_axis_far_off_the_mesh_and_a_slide_far_longer_than_it_are_refused() {
    let told = |joint: &str, more: &str| {
        let parts = format!(
            "{BODY}{{\"name\": \"b\", \"parent\": \"body\", \"joint\": \"{joint}\", {more}}}"
        );
        second(&parts).unwrap().check_points(&square()).map_err(|e| e.to_string())
    };
    assert_eq!(told("revolute", "\"pivot\": [3, 0, 0]"), Ok(()), "two diagonals off are allowed");
    let far = told("revolute", "\"pivot\": [1e6, 0, 0]").unwrap_err();
    assert!(far.contains("pivot lies 999999.0000 off the mesh, at most 2.8284"), "{far}");
    let long = told("prismatic", "\"range\": [0, 15]").unwrap_err();
    assert!(
        long.contains("a slide goes at most 2.8284 m") && long.contains("found 15.0000 m"),
        "{long}"
    );
    assert!(told("prismatic", "\"rest\": \"15 m\"").unwrap_err().contains("found 15.0000 m"));
}

#[test]
fn an_axis_of_any_length_is_a_direction() {
    for length in ["1e308", "1e-200", "3"] {
        let parts = format!(
            "{BODY}{{\"name\": \"b\", \"parent\": \"body\", \"joint\": \"revolute\", \"axis\": [0, {length}, 0]}}"
        );
        assert_eq!(second(&parts).unwrap().prompts[1].given(0).axis, Some(DVec3::Z), "{length}");
    }
}

#[test]
fn what_a_person_says_of_one_place_does_not_contradict_itself() {
    let told = |part: &str| {
        let text = format!(
            "{{\"mesh\": \"{}\", \"parts\": [{{\"name\": \"a\", \"point\": [0.2, 0, -0.2]}}, {{\"name\": \"b\", \"parent\": \"a\", {part}}}]}}",
            square().digest()
        );
        Condition::from_json(&text).unwrap().check_points(&square()).unwrap_err().to_string()
    };
    let painted = told("\"faces\": \"0\"");
    assert!(
        painted.contains("part `a`: a point of it lies on face 0, which is painted as `b`"),
        "{painted}"
    );
    let same = told("\"points\": [[0.9, 0, -0.9]], \"not\": [[0.8, 0, -0.9]]");
    assert!(
        same.contains("part `b`: a point of it and a `not` point lie on one face, 1"),
        "{same}"
    );
}

#[test]
fn a_part_called_parent_hides_no_fault_of_the_tree() {
    let told = faults(
        "{\"name\": \"grandparent\", \"mass\": -1}, {\"name\": \"a\", \"parent\": \"b\"}, {\"name\": \"b\", \"parent\": \"a\"}",
    );
    assert_eq!(told.len(), 2, "{told:?}");
    assert!(told.iter().any(|t| t.contains("form a cycle")), "{told:?}");
}
