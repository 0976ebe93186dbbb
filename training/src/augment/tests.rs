//! What a lesson promises.

use rand::SeedableRng;

use super::*;
use crate::dataset::sample::Counts;
use crate::dataset::{SampleJoint, SamplePart};
use crate::procedural::{Id, generate};

const SIZE: LessonSize = LessonSize { points: 60, queries: 50, balanced: 20, parts: 16 };

fn rng(seed: u64) -> Pcg64Mcg {
    Pcg64Mcg::seed_from_u64(seed)
}

/// The first family: a cabinet with a drawer and a door.
fn cabinet() -> Sample {
    let specimen = generate(Id::new("cabinet", 0).unwrap(), 0).unwrap();
    Sample::of(&specimen, Counts { even: 400, least: 30 }, 1).unwrap()
}

/// Three parts in a chain, one point each.
fn chain() -> Sample {
    let part = |p: usize| SamplePart {
        parent: p.checked_sub(1),
        wordings: vec![["base", "arm", "hand"][p].into()],
        joints: if p == 0 {
            vec![]
        } else {
            vec![SampleJoint {
                turns: true,
                axis: [1.0, 0.0, 0.0],
                pivot: [0.0, 0.1 * p as f64, 0.0],
                lower: 0.0,
                upper: 1.0,
            }]
        },
    };
    let width = model::features::geometric::WIDTH;
    Sample {
        positions: vec![[0.1, 0.0, 0.0], [0.2, 0.1, 0.0], [0.3, 0.2, 0.1]],
        normals: vec![[0.0, 1.0, 0.0]; 3],
        features: (0..3 * width).map(|i| i as f32).collect(),
        labels: vec![0, 1, 2],
        even: 3,
        parts: (0..3).map(part).collect(),
    }
}

#[test]
fn a_lesson_repeats_with_its_generator_and_has_the_size_asked_for() {
    let sample = cabinet();
    let draw = |seed| lesson(&sample, &Augment::default(), SIZE, &mut rng(seed)).unwrap();
    assert_eq!(draw(1), draw(1));
    assert_ne!(draw(1), draw(2));
    for seed in 0..20 {
        let l = draw(seed);
        assert_eq!((l.example.shape.positions.len(), l.labels.len()), (60, 50));
        let rows: usize = l.example.joints.iter().map(|j| j.queries.len()).sum();
        assert_eq!(l.targets.len(), rows);
        for part in &l.example.parts {
            assert!(part.text.is_some() || part.point.is_some(), "never both are dropped");
        }
    }
}

#[test]
fn without_augmentation_points_lie_where_they_are() {
    let sample = chain();
    let l = lesson(&sample, &Augment::none(), SIZE, &mut rng(1)).unwrap();
    for p in &l.example.queries.positions {
        assert!(sample.positions.contains(p));
    }
    assert!(l.example.parts.iter().all(|p| p.text.is_some() && p.point.is_some()));
}

#[test]
fn a_part_merged_into_its_parent_hands_over_points_and_children() {
    let always = Augment { merge: 1.0, ..Augment::none() };
    let l = lesson(&chain(), &always, SIZE, &mut rng(1)).unwrap();
    assert_eq!((l.example.parts.len(), l.targets.len()), (1, 0));
    let sometimes = Augment { merge: 0.5, ..Augment::none() };
    let only_arm = (0..64).find_map(|seed| {
        let view = View::draw(&chain(), &sometimes, &mut rng(seed));
        let names: Vec<&str> = view.parts.iter().map(|p| p.wordings[0].as_str()).collect();
        (names == ["base", "hand"]).then_some(view)
    });
    let view = only_arm.unwrap();
    assert_eq!([0, 1, 2].map(|p| view.label(&chain(), p)), [0, 0, 1]);
    assert_eq!(view.parts[1].parent, Some(0));
    assert_eq!(view.parts[1].joints[0].pivot, [0.0, 0.2, 0.0]);
}

#[test]
fn turned_points_turn_with_their_joints() {
    let sample = chain();
    let turning = Augment { turn: true, ..Augment::none() };
    let mut seen = std::collections::BTreeSet::new();
    for seed in 0..32 {
        let l = lesson(&sample, &turning, SIZE, &mut rng(seed)).unwrap();
        let joint = &l.example.joints[1];
        let row = l.example.joints[0].queries.len();
        let target = l.targets[row];
        let [q, axis, closest] = [
            l.example.queries.positions[joint.queries[0] as usize],
            [target[0], target[1], target[2]],
            [target[3], target[4], target[5]],
        ];
        let apart: Vec<f32> = (0..3).map(|i| q[i] - closest[i]).collect();
        let along: f32 = apart.iter().zip(axis).map(|(a, b)| a * b).sum();
        let length = apart.iter().map(|a| a * a).sum::<f32>().sqrt();
        assert!(along.abs() < 1e-6 && (length - 0.1).abs() < 1e-6, "the hand is 0.1 off its axis");
        seen.insert(axis.map(|x| x.round() as i32));
    }
    assert!(seen.len() == 4, "{seen:?}");
}

#[test]
fn an_object_whose_texts_name_sides_is_not_turned() {
    let mut sample = chain();
    sample.parts[1].wordings = vec!["left arm".into()];
    let turning = Augment { turn: true, ..Augment::none() };
    for seed in 0..16 {
        let l = lesson(&sample, &turning, SIZE, &mut rng(seed)).unwrap();
        assert!(l.example.queries.positions.iter().all(|p| sample.positions.contains(p)));
    }
}

#[test]
fn a_part_whose_text_another_shares_keeps_its_point() {
    let mut sample = chain();
    sample.parts[1].wordings = vec!["arm 1".into()];
    sample.parts[2].wordings = vec!["arm 2".into()];
    let eager = Augment { no_point: 1.0, no_text: 0.5, ..Augment::none() };
    for seed in 0..16 {
        let l = lesson(&sample, &eager, SIZE, &mut rng(seed)).unwrap();
        assert!(l.example.parts[0].point.is_none());
        assert!(l.example.parts[1].point.is_some() && l.example.parts[2].point.is_some());
    }
}
