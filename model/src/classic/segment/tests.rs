//! Closed-form cases for the labeller: boxes whose parts are known.

use object::{Condition, DVec3, Mesh};

use crate::classic::segment::*;

/// An axis-aligned box from its corners, twelve outward faces.
fn boxed(min: [f64; 3], max: [f64; 3]) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let corner = |i: usize| {
        let pick = |axis: usize| if i >> axis & 1 == 1 { max[axis] } else { min[axis] };
        DVec3::new(pick(0), pick(1), pick(2))
    };
    let quads =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    ((0..8).map(corner).collect(), faces.collect())
}

fn boxes(list: &[([f64; 3], [f64; 3])]) -> Mesh {
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for &(min, max) in list {
        let (v, f) = boxed(min, max);
        let base = vertices.len() as u32;
        vertices.extend(v);
        faces.extend(f.iter().map(|t| t.map(|i| i + base)));
    }
    Mesh::new(vertices, faces).unwrap()
}

fn condition(parts: &str) -> Condition {
    let text = format!(r#"{{"schema": "kinfold-condition/1", "up": "z", "parts": [{parts}]}}"#);
    Condition::from_json(&text).unwrap()
}

/// The part of each box; merging, the fitted models and each of their folds agree.
fn per_box(mesh: &Mesh, condition: &Condition) -> Vec<u16> {
    let merged = by(Way::Merging, mesh, condition);
    for way in std::iter::once(Way::Fitted).chain((0..3).map(Way::OutOfFold)) {
        assert_eq!(merged, by(way, mesh, condition), "{way:?}");
    }
    merged
}

fn by(way: Way, mesh: &Mesh, condition: &Condition) -> Vec<u16> {
    let labels = label_faces(mesh, condition, &Weld::new(mesh), way).part_of_face;
    assert!(labels.chunks(12).all(|b| b.iter().all(|l| *l == b[0])), "a box is one part");
    labels.chunks(12).map(|b| b[0]).collect()
}

#[test]
fn a_bar_that_reaches_into_the_door_goes_with_the_door() {
    let mesh = boxes(&[
        ([0.0, 0.0, 0.0], [1.0, 0.6, 1.2]),
        ([0.0, -0.05, 0.0], [1.0, -0.01, 1.2]),
        ([0.8, -0.12, 0.5], [0.85, -0.03, 0.8]),
    ]);
    let c = condition(
        r#"{"name": "body", "point": [0.5, 0.6, 0.6]},
           {"name": "door", "parent": "body", "joint": "revolute", "point": [0.5, -0.05, 0.6]}"#,
    );
    assert_eq!(per_box(&mesh, &c), [0, 1, 1]);
}

#[test]
fn what_nobody_points_at_is_not_the_buttons() {
    let mesh = boxes(&[
        ([0.0, 0.0, 0.0], [1.0, 0.5, 1.0]),
        ([0.0, 0.0, 1.0001], [1.0, 0.5, 1.3]),
        ([0.4, 0.2, 1.29], [0.44, 0.24, 1.32]),
    ]);
    let c = condition(
        r#"{"name": "body", "point": [0.5, 0.0, 0.5]},
           {"name": "button", "parent": "body", "joint": "prismatic", "point": [0.42, 0.22, 1.32]}"#,
    );
    assert_eq!(per_box(&mesh, &c), [0, 0, 1]);
}

#[test]
fn a_wheel_without_a_point_is_found_by_its_likeness_and_noted() {
    let wheel = |x: f64| ([x, -0.02, 0.0], [x + 0.2, 0.02, 0.2]);
    let mesh = boxes(&[([0.0, 0.05, 0.1], [2.0, 0.5, 0.6]), wheel(0.1), wheel(1.7)]);
    let c = condition(
        r#"{"name": "body", "point": [1.0, 0.05, 0.3]},
           {"name": "wheel_1", "text": "left wheel", "parent": "body", "joint": "continuous", "point": [0.2, -0.02, 0.1]},
           {"name": "wheel_2", "text": "right wheel", "parent": "body", "joint": "continuous"},
           {"name": "lid", "parent": "body", "joint": "revolute"}"#,
    );
    assert_eq!(per_box(&mesh, &c), [0, 1, 2]);
    let notes = label_faces(&mesh, &c, &Weld::new(&mesh), Way::Merging).notes;
    let parts: Vec<_> = notes.iter().map(|n| n.part.as_str()).collect();
    assert_eq!(parts, ["wheel_2", "lid"]);
    assert!(notes[1].message.contains("no shape says where"));
}

/// A strip of quads along x with the given heights: one fused mesh, 3 wide in y.
fn strip(heights: &[f64]) -> Mesh {
    let row = |(i, &z): (usize, &f64)| (0..4).map(move |j| DVec3::new(i as f64, f64::from(j), z));
    let vertices: Vec<DVec3> = heights.iter().enumerate().flat_map(row).collect();
    let mut faces = Vec::new();
    for i in 0..heights.len() as u32 - 1 {
        for j in 0..3 {
            let [a, b, c, d] = [4 * i + j, 4 * i + 4 + j, 4 * i + 5 + j, 4 * i + 1 + j];
            faces.extend([[a, b, c], [a, c, d]]);
        }
    }
    Mesh::new(vertices, faces).unwrap()
}

#[test]
fn one_skin_parts_in_the_groove_not_on_the_ridge() {
    let mesh = strip(&[0.0, 0.0, 0.0, 1.5, 0.0, 0.0, 0.0]);
    let c = condition(
        r#"{"name": "left", "point": [0.5, 1.5, 0.0]},
           {"name": "right", "parent": "left", "joint": "revolute", "point": [5.5, 1.5, 0.0]}"#,
    );
    let labels = label_faces(&mesh, &c, &Weld::new(&mesh), Way::Merging).part_of_face;
    let column = |i: usize| labels[6 * i..6 * i + 6].to_vec();
    assert_eq!((column(0), column(1)), (vec![0; 6], vec![0; 6]));
    assert_eq!((column(4), column(5)), (vec![1; 6], vec![1; 6]));
    assert_eq!(column(2), column(3), "the ridge is one part's");
}

#[test]
fn on_a_skin_a_part_is_nearest_where_its_prompt_is() {
    let mesh = strip(&[0.0, 0.0, 0.0, 1.5, 0.0, 0.0, 0.0]);
    let c = condition(
        r#"{"name": "left", "point": [0.5, 1.5, 0.0]},
           {"name": "right", "parent": "left", "joint": "revolute", "point": [5.5, 1.5, 0.0]}"#,
    );
    let sheet = sheet(&mesh, &c, &Weld::new(&mesh)).unwrap();
    assert!((sheet.share.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    for (part, x) in [0.5, 5.5].into_iter().enumerate() {
        let face = object::weld::nearest_face(&mesh, DVec3::new(x, 1.5, 0.0)).0;
        let row = &sheet.features[sheet.segment_of_face[face] as usize];
        let [here, there] = [row[part].unwrap(), row[1 - part].unwrap()];
        assert_eq!((here[0], here[3]), (0.0, 0.0), "no detour, no groove");
        assert!(there[0] > 0.0 && there[3] > 0.5 && there[1] > here[1] && there[2] > here[2]);
    }
    let single = condition(r#"{"name": "left", "point": [0.5, 1.5, 0.0]}"#);
    assert!(crate::classic::segment::sheet(&mesh, &single, &Weld::new(&mesh)).is_none());
}

#[test]
fn what_is_the_bases_alone_makes_no_less_of_a_skin_and_what_is_another_parts_does() {
    let (fused_surface, beside) =
        (strip(&[0.0, 1.5, 0.0]), boxes(&[([0.0, 8.0, 0.0], [6.0, 12.0, 3.0])]));
    let count = fused_surface.vertices().len() as u32;
    let vertices = [fused_surface.vertices(), beside.vertices()].concat();
    let moved = beside.faces().iter().map(|f| f.map(|i| i + count));
    let mesh =
        Mesh::new(vertices, fused_surface.faces().iter().copied().chain(moved).collect()).unwrap();
    let is_fused = |base: &str, lid: &str| {
        let c = condition(&format!(
            r#"{{"name": "base", "point": {base}}},
               {{"name": "lid", "parent": "base", "joint": "revolute", "point": {lid}}},
               {{"name": "door", "parent": "base", "joint": "revolute", "point": [1.5, 1.5, 0.75]}}"#
        ));
        Start::of(&Skin::of(&mesh, &Weld::new(&mesh)), &c).is_fused(0)
    };
    let (on_fused, on_box) = ("[0.5, 1.5, 0.75]", "[3.0, 10.0, 3.0]");
    assert!(is_fused(on_box, on_fused));
    assert!(!is_fused(on_fused, on_box));
    assert!(!is_fused(on_fused, "[0.5, 0.5, 0.75]"), "nobody speaks of the box");
}

#[test]
fn every_prompted_face_keeps_its_prompt_even_on_a_flat_sheet() {
    let mesh = strip(&[0.0; 6]);
    let c = condition(
        r#"{"name": "a", "point": [0.3, 0.1, 0.0]},
           {"name": "b", "parent": "a", "joint": "revolute", "point": [4.7, 2.9, 0.0]},
           {"name": "c", "parent": "a", "joint": "revolute", "point": [4.7, 2.8, 0.0]}"#,
    );
    let Labels { part_of_face, notes } = label_faces(&mesh, &c, &Weld::new(&mesh), Way::Merging);
    let at = |x, y| object::weld::nearest_face(&mesh, DVec3::new(x, y, 0.0)).0;
    assert_eq!(part_of_face[at(0.3, 0.1)], 0);
    assert_eq!(part_of_face[at(4.7, 2.9)], 1);
    assert_eq!(notes.len(), 1, "two points on one face: {notes:?}");
    assert!(notes[0].part == "c" && notes[0].message.contains("same face as that of `b`"));
}

#[test]
fn a_point_where_a_knob_lies_on_a_ensemble_speaks_of_the_knob() {
    let mesh = boxes(&[
        ([0.0, 0.0, 0.0], [1.0, 0.1, 1.0]),
        ([0.2, 0.1, 0.2], [0.3, 0.15, 0.3]),
        ([0.6, 0.1, 0.2], [0.7, 0.15, 0.3]),
    ]);
    let c = condition(
        r#"{"name": "ensemble", "point": [0.26, 0.1, 0.24]},
           {"name": "one", "parent": "ensemble", "joint": "revolute", "point": [0.25, 0.1, 0.24]},
           {"name": "two", "parent": "ensemble", "joint": "revolute", "point": [0.65, 0.1, 0.24]}"#,
    );
    assert_eq!(per_box(&mesh, &c), [0, 1, 2]);
}

#[test]
fn merging_gives_an_island_to_the_nearest_part() {
    let mesh = boxes(&[
        ([0.0, 0.0, 0.0], [1.0, 1.0, 1.0]),
        ([3.0, 0.0, 0.0], [4.0, 1.0, 1.0]),
        ([2.5, 0.4, 0.4], [2.6, 0.6, 0.6]),
    ]);
    let c = condition(
        r#"{"name": "a", "point": [0.5, 0.5, 1.0]},
           {"name": "b", "parent": "a", "joint": "prismatic", "point": [3.5, 0.5, 1.0]}"#,
    );
    assert_eq!(by(Way::Merging, &mesh, &c), [0, 1, 1]);
}

#[test]
fn a_base_without_a_point_gets_what_is_left() {
    let mesh = boxes(&[([0.0, 0.0, 0.0], [1.0, 1.0, 1.0]), ([0.0, 0.0, 1.01], [1.0, 1.0, 1.1])]);
    let c = condition(
        r#"{"name": "body"},
           {"name": "lid", "parent": "body", "joint": "revolute", "point": [0.5, 0.5, 1.1]}"#,
    );
    assert_eq!(per_box(&mesh, &c), [0, 1]);
}

#[test]
fn without_any_point_everything_is_the_base() {
    let mesh = boxes(&[([0.0, 0.0, 0.0], [1.0, 1.0, 1.0]), ([2.0, 0.0, 0.0], [3.0, 1.0, 1.0])]);
    let c =
        condition(r#"{"name": "body"}, {"name": "lid", "parent": "body", "joint": "revolute"}"#);
    assert_eq!(per_box(&mesh, &c), [0, 0]);
}

#[test]
fn labels_do_not_depend_on_the_number_of_threads() {
    let mesh = boxes(&[
        ([0.0, 0.0, 0.0], [1.0, 0.6, 1.2]),
        ([0.0, -0.05, 0.0], [1.0, -0.01, 1.2]),
        ([0.8, -0.12, 0.5], [0.85, -0.03, 0.8]),
        ([0.1, 0.1, 1.19], [0.3, 0.3, 1.5]),
    ]);
    let c = condition(
        r#"{"name": "body", "point": [0.5, 0.6, 0.6]},
           {"name": "door", "parent": "body", "joint": "revolute", "point": [0.5, -0.05, 0.6]}"#,
    );
    for way in [Way::Merging, Way::Fitted] {
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| label_faces(&mesh, &c, &Weld::new(&mesh), way))
        };
        assert_eq!(on(1), on(3));
    }
}

#[test]
fn a_tie_says_how_the_smaller_segment_touches_the_larger_one_and_kin_follow_it() {
    let mesh = boxes(&[
        ([0.0, 0.0, 0.0], [1.0, 0.6, 1.2]),
        ([0.4, -0.02, 0.4], [0.6, 0.0, 0.6]),
        ([3.0, 0.0, 0.0], [3.5, 0.5, 0.5]),
    ]);
    let c = condition(
        r#"{"name": "body", "point": [0.5, 0.6, 0.6]},
           {"name": "far", "parent": "body", "joint": "revolute", "point": [3.5, 0.2, 0.2]}"#,
    );
    let (_, mut layout) = layout(&mesh, &c, &Weld::new(&mesh));
    let [segment_pair] = layout.segment_pairs() else { panic!("{:?}", layout.segment_pairs()) };
    assert_eq!((segment_pair.small, segment_pair.large), (1, 0));
    assert!(segment_pair.features.iter().all(|n| n.is_finite()));
    let of = |layout: &Layout| layout.features(1, &layout.clusters(&layout.first()));
    let untold = of(&layout);
    layout.told_of_pairs(&[0.25]);
    assert_eq!(layout.pair_chances(), [0.25]);
    let told = of(&layout);
    let changed = |part: usize| {
        let (a, b) = (untold[part].unwrap(), told[part].unwrap());
        a.iter().zip(b).filter(|(a, b)| **a != *b).map(|(_, b)| b).collect::<Vec<_>>()
    };
    let negative_log_likelihood = 4f32.ln();
    assert_eq!(
        changed(0).iter().filter(|&&x| (x - negative_log_likelihood).abs() < 1e-6).count(),
        2,
        "both ways"
    );
    assert!(changed(1).contains(&30.0), "the far box cannot be reached");
}
