//! What a person corrects is followed: by labels and by joints, by every articulator of this room.

use object::{Condition, DVec3, JointMotion, Mesh, Range};

use crate::articulate::{Articulate, Articulation};
use crate::classic::prepared::Prepared;
use crate::classic::{Geometric, Hybrid};

fn boxes(list: &[([f64; 3], [f64; 3])]) -> Mesh {
    let quads =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let (mut vertices, mut faces) = (Vec::new(), Vec::<[u32; 3]>::new());
    for (min, max) in list {
        let base = vertices.len() as u32;
        let pick = |i: usize, axis: usize| if i >> axis & 1 == 1 { max[axis] } else { min[axis] };
        vertices.extend((0..8).map(|i| DVec3::new(pick(i, 0), pick(i, 1), pick(i, 2))));
        let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
        faces.extend(triangles.map(|f| f.map(|i: u32| i + base)));
    }
    Mesh::new(vertices, faces).unwrap()
}

/// A case, a door in front of it, and a bar on the door that a little gap keeps from it.
fn cupboard() -> Mesh {
    boxes(&[
        ([0.0, 0.0, 0.0], [1.0, 0.6, 1.2]),
        ([0.0, -0.05, 0.0], [1.0, -0.01, 1.2]),
        ([0.8, -0.12, 0.5], [0.85, -0.051, 0.8]),
    ])
}

fn asked(door: &str, more: &str) -> Condition {
    let text = format!(
        r#"{{"schema": "kinfold-condition/2", "up": "z", "mesh": "{}", "parts": [
            {{"name": "body", "point": [0.5, 0.6, 0.6]}},
            {{"name": "door", "parent": "body", "joint": "revolute", "point": [0.5, -0.05, 0.6]{door}}}
            {more}]}}"#,
        cupboard().digest()
    );
    Condition::from_json(&text).unwrap()
}

fn both(condition: &Condition) -> [Articulation; 2] {
    let by =
        |articulator: &dyn Articulate| articulator.articulate(&cupboard(), condition, 1).unwrap();
    [by(&Geometric), by(&Hybrid)]
}

/// The part of each box.
fn parts(made: &Articulation) -> Vec<u16> {
    made.object.part_of_face().chunks(12).map(|b| b[0]).collect()
}

const BAR: &str = r#", {"name": "bar", "parent": "door", "point": [0.82, -0.12, 0.6]}"#;

#[test]
fn a_further_point_brings_a_part_what_it_lacked_and_a_point_that_is_not_of_it_takes_it_away() {
    for made in both(&asked("", "")) {
        assert_eq!(parts(&made), [0, 1, 1], "the bar goes with the door");
    }
    for made in both(&asked(r#", "not": [[0.82, -0.12, 0.6]]"#, "")) {
        assert_eq!(parts(&made), [0, 1, 0], "nobody else is there but the body");
    }
    let mut body = asked("", "");
    body.prompts[0].also = vec![DVec3::new(0.82, -0.12, 0.6)];
    for made in both(&body) {
        assert_eq!(parts(&made), [0, 1, 0]);
    }
}

#[test]
fn painted_faces_are_of_the_part_they_were_painted_as_and_need_no_point() {
    let condition = asked("", r#", {"name": "patch", "parent": "body", "faces": "4-5 24-30"}"#);
    for made in both(&condition) {
        let labels = made.object.part_of_face();
        let painted: Vec<usize> = (0..36).filter(|f| labels[*f] == 2).collect();
        assert!(
            [4, 5, 24, 25, 26, 27, 28, 29, 30].iter().all(|f| painted.contains(f)),
            "{painted:?}"
        );
        assert!(made.notes.iter().all(|n| n.part != "patch"), "{:?}", made.notes);
    }
}

#[test]
fn painted_faces_of_a_mesh_drawn_on_both_sides_are_those_of_the_file() {
    let once = cupboard();
    let faces = once.faces().iter().flat_map(|&[a, b, c]| [[a, b, c], [b, a, c]]).collect();
    let twice = Mesh::new(once.vertices().to_vec(), faces).unwrap();
    let mut condition = asked("", r#", {"name": "patch", "parent": "body", "faces": "48-49"}"#);
    condition.painted_on = Some(twice.digest());
    for articulator in [&Geometric as &dyn Articulate, &Hybrid] {
        let made = articulator.articulate(&twice, &condition, 1).unwrap();
        assert_eq!(&made.object.part_of_face()[48..50], &[2, 2]);
    }
}

fn door(made: &Articulation) -> JointMotion {
    made.object.joints(1)[0]
}

#[test]
fn axis_and_pivot_and_range_are_found_as_they_were_given() {
    let given = r#", "axis": [0.1, 0, -2], "pivot": [1.01, -0.03, 0.2], "range": ["-10°", 1.5], "rest": "5°""#;
    for made in both(&asked(given, BAR)) {
        let JointMotion { axis, pivot, range, .. } = door(&made);
        assert_eq!(axis, DVec3::new(0.1, 0.0, -2.0).normalize());
        assert_eq!(pivot, DVec3::new(1.01, -0.03, 0.2));
        let (lower, upper) = range.ends();
        let shown = 5f64.to_radians();
        assert!((lower + 3.0 * shown).abs() < 1e-12 && (upper - 1.5 + shown).abs() < 1e-12);
    }
}

#[test]
fn a_direction_alone_is_kept_and_its_place_is_found() {
    for sign in [1.0, -1.0] {
        for made in both(&asked(&format!(r#", "axis": [0, 0, {sign}]"#), BAR)) {
            let JointMotion { axis, pivot, range, .. } = door(&made);
            assert_eq!(axis, DVec3::Z * sign);
            assert!(pivot.x.abs() < 0.05 || (pivot.x - 1.0).abs() < 0.05, "at an edge: {pivot}");
            let (lower, upper) = range.ends();
            let opens_forward = if pivot.x < 0.5 { -1.0 } else { 1.0 };
            let ahead = if sign == opens_forward { upper } else { -lower };
            assert!(ahead > 1.0, "it opens to the front: {range:?} about {axis} at {pivot}");
        }
    }
}

#[test]
fn a_pivot_alone_is_kept_and_the_direction_goes_through_it() {
    for made in both(&asked(r#", "pivot": [0.5, -0.03, 0.0]"#, BAR)) {
        let JointMotion { axis, pivot, .. } = door(&made);
        assert_eq!(pivot, DVec3::new(0.5, -0.03, 0.0));
        assert!(axis.x.abs() > 0.99, "the line through the lower edge: {axis}");
    }
}

#[test]
fn what_is_shown_shut_starts_there_and_what_is_shown_open_goes_back_by_so_much() {
    for made in both(&asked(r#", "rest": 0"#, BAR)) {
        let (lower, upper) = door(&made).range.ends();
        assert!(lower == 0.0 && upper > 1.0, "{lower} to {upper}");
    }
    for made in both(&asked(r#", "rest": "80°""#, BAR)) {
        let (lower, upper) = door(&made).range.ends();
        assert!((lower + 80f64.to_radians()).abs() < 1e-12 && upper >= 0.0, "{lower} to {upper}");
    }
}

#[test]
fn lengths_of_a_slide_are_those_of_the_finished_object() {
    let text = r#"{"schema": "kinfold-condition/2", "up": "z", "size": {"height": 0.6}, "parts": [
        {"name": "body", "point": [0.5, 0.6, 0.6]},
        {"name": "front", "parent": "body", "joint": "prismatic", "point": [0.5, -0.05, 0.6],
         "range": [0, "20 cm"]}]}"#;
    for made in both(&Condition::from_json(text).unwrap()) {
        let Range::Limits { lower, upper } = door(&made).range else { panic!("a slide") };
        assert!(
            lower == 0.0 && (upper - 0.4).abs() < 1e-12,
            "half the size, so twice as far: {upper}"
        );
    }
}

#[test]
fn two_hinges_of_one_part_turn_about_the_axes_they_were_given() {
    let text = r#"{"schema": "kinfold-condition/2", "up": "z", "parts": [
        {"name": "body", "point": [0.5, 0.6, 0.6]},
        {"name": "head", "parent": "body", "point": [0.5, -0.05, 0.6], "joints": [
            {"type": "revolute", "axis": [0, 0, 1], "pivot": [0, 0, 0]},
            {"type": "revolute", "axis": [1, 0, 0], "range": [0, 1]}]}]}"#;
    for made in both(&Condition::from_json(text).unwrap()) {
        let [first, second] = made.object.joints(1) else { panic!("two joints") };
        assert_eq!((first.axis, second.axis), (DVec3::Z, DVec3::X));
        assert_eq!(
            (first.pivot, second.range),
            (DVec3::ZERO, Range::Limits { lower: 0.0, upper: 1.0 })
        );
    }
}

#[test]
fn a_base_whose_faces_were_all_painted_as_another_part_is_named() {
    let mut condition = asked(", \"faces\": \"0-11\"", "");
    condition.prompts[0].point = None;
    let error = Geometric.articulate(&cupboard(), &condition, 1).unwrap_err().to_string();
    assert!(error.contains("no face of the mesh is left for the base `body`"), "{error}");
}

#[test]
fn a_range_that_was_given_opens_as_found_and_is_not_turned_round_for_looks() {
    // A tray that goes both ways: without ends its axis would be written along +y.
    let front = |more: &str| {
        let text = format!(
            r#"{{"schema": "kinfold-condition/2", "up": "z", "parts": [
            {{"name": "body", "text": "cabinet body", "point": [0.5, 0.6, 0.6]}},
            {{"name": "drawer", "parent": "body", "joint": "prismatic", "point": [0.5, -0.05, 0.6]{more}}}]}}"#
        );
        both(&Condition::from_json(&text).unwrap()).map(|made| door(&made))
    };
    for (ends, alone) in
        front(r#", "range": [0, 0.2], "rest": 0.12"#).iter().zip(front(r#", "rest": 0"#))
    {
        assert_eq!(ends.axis, alone.axis, "opening is opening, wherever it is shown");
        let (lower, upper) = ends.range.ends();
        assert!((lower + 0.12).abs() < 1e-12 && (upper - 0.08).abs() < 1e-12, "{lower} to {upper}");
    }
}

#[test]
fn a_door_is_free_to_come_out_and_not_to_go_in() {
    let ready = Prepared::new(&cupboard()).unwrap();
    let free = |of: (usize, usize), axis: DVec3| {
        ready.free_range(&asked("", BAR), of, (axis, DVec3::new(0.0, -0.03, 0.0)), 1)
    };
    let (lower, upper) = free((1, 0), DVec3::Z * 2.0).unwrap().ends();
    assert!(lower < -1.5 && upper < 0.2, "{lower} to {upper}");
    let (into, out) = free((1, 0), -DVec3::Z).unwrap().ends();
    assert!((into + upper).abs() < 1e-9 && (out + lower).abs() < 1e-9, "{into} to {out}");
    for (of, axis) in
        [((0, 0), DVec3::Z), ((1, 1), DVec3::Z), ((9, 0), DVec3::Z), ((1, 0), DVec3::ZERO)]
    {
        assert!(free(of, axis).unwrap_err().to_string().contains("has no joint"));
    }
}
