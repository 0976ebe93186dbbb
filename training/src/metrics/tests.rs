//! The measures against closed forms, and the public code's defects as they are known.

use std::f64::consts::PI;

use object::mesh::Bounds;
use object::{DPose3, DVec3, JointKind};

use super::Rules;
use super::assign::assign;
use super::body::{Body, BodyError, Drive, Link, Motion};
use super::boxes::{MovedBox, around, giou, iou, sampled_giou, thickened, volume};
use super::cloud::{Cloud, chamfer};
use super::compare::Comparer;
use super::joints::compare_joints;
use super::moved::moved_points_giou;
use super::opening::Opening;
use super::scores::{PointIous, Scores, point_ious};

fn unit() -> Bounds {
    Bounds { min: DVec3::ZERO, max: DVec3::ONE }
}

fn motion(kind: JointKind, axis: DVec3, pivot: DVec3, (lower, upper): (f64, f64)) -> Motion {
    Motion { kind, axis, pivot, lower, upper }
}

fn hinge(axis: DVec3, pivot: DVec3) -> Motion {
    motion(JointKind::Revolute, axis, pivot, (0.0, 1.0))
}

/// A box filled with a 5 × 5 × 5 grid of points.
fn grid(low: DVec3, size: DVec3) -> Vec<DVec3> {
    let at = |i: i32| DVec3::new(f64::from(i % 5), f64::from(i / 5 % 5), f64::from(i / 25)) / 4.0;
    (0..125).map(|i| low + size * at(i)).collect()
}

fn body(parts: &[Vec<DVec3>], links: Vec<Link>) -> Body {
    let labels = (0..).zip(parts).flat_map(|(i, p)| std::iter::repeat_n(i, p.len()));
    Body::new(parts.concat(), labels.collect(), links).unwrap()
}

/// A base and a drawer beside it that slides by one along x.
fn drawer(drawer_at: DVec3) -> Body {
    let parts = [grid(DVec3::ZERO, DVec3::ONE), grid(drawer_at, DVec3::ONE)];
    let slide = motion(JointKind::Prismatic, DVec3::X, DVec3::ZERO, (0.0, 1.0));
    body(&parts, vec![Link::default(), Link { parent: Some(0), motions: vec![slide] }])
}

#[test]
fn like_boxes_agree_and_boxes_apart_disagree() {
    let apart = |x: f64| Bounds { min: unit().min + DVec3::X * x, max: unit().max + DVec3::X * x };
    assert_eq!((iou(&unit(), &unit()), giou(&unit(), &unit())), (1.0, 1.0));
    assert!((iou(&unit(), &apart(0.5)) - 1.0 / 3.0).abs() < 1e-15);
    assert!((giou(&unit(), &apart(5.0)) + 4.0 / 6.0).abs() < 1e-15);
}

#[test]
fn a_sheet_agrees_with_itself_once_it_is_thick() {
    let sheet = Bounds { min: DVec3::ZERO, max: DVec3::new(1.0, 1.0, 0.0) };
    assert!(giou(&sheet, &sheet).is_nan());
    assert!((giou(&thickened(&sheet), &thickened(&sheet)) - 1.0).abs() < 1e-9);
    assert_eq!(thickened(&unit()), unit());
}

/// Like boxes, one moved along x: the sampled gIoU by both readings of the box around them.
fn moved_apart(x: f64) -> [f64; 2] {
    let a = MovedBox { rest: unit(), pose: DPose3::identity() };
    let b = MovedBox { rest: unit(), pose: DPose3::from_translation(DVec3::X * x) };
    let after = volume(&around(&a.bounds(), &b.bounds()));
    let at_rest = volume(&around(&a.rest, &b.rest));
    [after, at_rest].map(|whole| sampled_giou(&a, &b, whole, 7))
}

#[test]
fn boxes_moved_apart_score_below_zero_by_the_paper_and_one_by_the_public_code() {
    let [paper, public] = moved_apart(5.0);
    assert!((paper + 4.0 / 6.0).abs() < 1e-12, "{paper}");
    assert!((public - 1.0).abs() < 1e-12, "{public}");
    let [paper, public] = moved_apart(0.5);
    assert!((paper - 1.0 / 3.0).abs() < 0.03, "{paper}");
    assert!((public - 5.0 / 6.0).abs() < 0.03, "{public}");
}

#[test]
fn the_assignment_is_the_cheapest_of_all() {
    let mut state = 7_u64;
    let mut random = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f64
    };
    for (rows, columns) in [(1, 1), (3, 5), (5, 3), (5, 5), (0, 0)] {
        let cost: Vec<Vec<f64>> =
            (0..rows).map(|_| (0..columns).map(|_| random()).collect()).collect();
        let pairs = assign(&cost);
        assert_eq!(pairs.len(), rows.min(columns));
        let total: f64 = pairs.iter().map(|&(r, c)| cost[r][c]).sum();
        assert_eq!(total, cheapest(&cost, 0, &mut vec![false; columns], rows.min(columns)));
    }
}

/// Every way to pair `left` rows from `row` on with free columns, by trying.
fn cheapest(cost: &[Vec<f64>], row: usize, taken: &mut Vec<bool>, left: usize) -> f64 {
    if left == 0 {
        return 0.0;
    }
    if row == cost.len() {
        return f64::INFINITY;
    }
    let mut best = cheapest(cost, row + 1, taken, left);
    for c in 0..taken.len() {
        if !taken[c] {
            taken[c] = true;
            best = best.min(cost[row][c] + cheapest(cost, row + 1, taken, left - 1));
            taken[c] = false;
        }
    }
    best
}

#[test]
fn chamfer_adds_the_squares_of_both_directions() {
    let still = DPose3::identity();
    let a = Cloud::new(0, vec![DVec3::ZERO, DVec3::X]);
    let b = Cloud::new(0, vec![DVec3::X * 3.0]);
    assert_eq!(chamfer((&a, still), (&b, still)), (9.0 + 4.0) / 2.0 + 4.0);
    let there = DPose3::from_translation(DVec3::X * -3.0);
    assert!((chamfer((&a, still), (&b, there)) - (0.0 + 1.0) / 2.0).abs() < 1e-15);
}

/// Both parts' points, all found.
fn all_found() -> PointIous {
    PointIous { mean: Some(1.0), of_true: [(0, 1.0), (1, 1.0)].into() }
}

#[test]
fn a_perfect_prediction_gets_full_marks() {
    let object = drawer(DVec3::new(2.0, 0.0, 0.0));
    let mut comparer = Comparer::new(object.clone(), object.clone(), Rules::Paper, 3);
    let pairing = comparer.by_centroid();
    assert_eq!(pairing, comparer.by_number());
    let comparison = comparer.compare(&pairing);
    let joints = compare_joints(&object, &object, [(0, Some(0)), (1, Some(1))]);
    let scores = Scores::of(&comparison, Some(&all_found()), 1.0, &joints);
    assert_eq!((scores.precision, scores.recall, scores.giou), (1.0, 1.0, 1.0));
    assert_eq!((scores.chamfer, scores.box_iou, scores.moved_overall), (0.0, 1.0, 0.0));
    assert!(scores.moved_chamfer < 1e-24 && (scores.moved_giou - 1.0).abs() < 1e-9);
    assert_eq!((scores.joints.angle, scores.joints.near), (Some(0.0), Some(1.0)));
    assert_eq!((scores.joints.opening.right, scores.fully_right), (Some(1.0), Some(true)));
    let ragged = PointIous { of_true: [(0, 1.0), (1, 0.74)].into(), ..all_found() };
    let scores = Scores::of(&comparison, Some(&ragged), 1.0, &joints);
    assert_eq!(scores.fully_right, Some(false), "three quarters of a part's points are too few");
}

fn opening(wanted: (f64, f64), found: (f64, f64), is_reversed: bool) -> Option<Opening> {
    let joint = |axis, (lower, upper)| motion(JointKind::Revolute, axis, DVec3::X, (lower, upper));
    let axis = if is_reversed { -DVec3::Z } else { DVec3::Z };
    one_joint(joint(DVec3::Z, wanted), joint(axis, found)).opening
}

#[test]
fn a_door_that_opens_into_its_cabinet_opens_the_wrong_way_whatever_its_axis_says() {
    let door = (0.0, 1.5);
    assert_eq!(opening(door, (0.0, 0.4), false), Some(Opening::Right));
    assert_eq!(opening(door, (-0.4, 0.0), false), Some(Opening::Wrong));
    assert_eq!(opening(door, (-0.4, 0.0), true), Some(Opening::Right));
    assert_eq!(opening(door, (0.0, 1.5), true), Some(Opening::Wrong));
    assert_eq!(opening(door, (-1.5, 1.5), true), Some(Opening::Both));
    assert_eq!(opening(door, (-0.375, 1.5), false), Some(Opening::Right), "a little slack");
    assert_eq!(opening(door, (0.0, 0.0), false), Some(Opening::Both), "it does not open at all");
    assert_eq!(opening((-1.5, 0.1), (0.0, 1.0), false), Some(Opening::Wrong), "shown open");
    assert_eq!(opening((-1.0, 1.0), (0.0, 1.0), false), None, "a lever goes both ways");
    assert_eq!(opening((0.0, 0.0), (0.0, 1.0), false), None);
}

#[test]
fn a_joint_that_turns_round_and_round_does_not_open_one_way() {
    let door = motion(JointKind::Revolute, DVec3::Z, DVec3::X, (0.0, 1.5));
    let wheel = motion(JointKind::Continuous, DVec3::Z, DVec3::X, (-PI, PI));
    assert_eq!(one_joint(door, wheel).opening, Some(Opening::Both));
    assert_eq!(one_joint(wheel, door).opening, None);
}

#[test]
fn of_two_turns_of_one_part_the_second_is_compared_with_the_second() {
    let (first, second) = (hinge(DVec3::Z, DVec3::ZERO), hinge(DVec3::X, DVec3::ZERO));
    let links = |motions| vec![Link { parent: None, motions }];
    let object = body(&[vec![DVec3::ZERO]], links(vec![first, second]));
    let found = compare_joints(&object, &object, [(0, Some(0))]);
    assert_eq!(found.iter().map(|j| j.angle).collect::<Vec<_>>(), [Some(0.0); 2]);
    let other = body(&[vec![DVec3::ZERO]], links(vec![first]));
    let found = compare_joints(&other, &object, [(0, Some(0))]);
    assert_eq!(found.iter().map(|j| j.angle).collect::<Vec<_>>(), [Some(0.0), None]);
}

/// A drawer as above whose slide is another.
fn drawer_that(axis: DVec3, range: (f64, f64)) -> Body {
    let parts = [grid(DVec3::ZERO, DVec3::ONE), grid(DVec3::X * 2.0, DVec3::ONE)];
    let slide = motion(JointKind::Prismatic, axis, DVec3::ZERO, range);
    body(&parts, vec![Link::default(), Link { parent: Some(0), motions: vec![slide] }])
}

#[test]
fn boxes_of_moved_points_tell_how_far_and_which_way_and_nothing_of_the_axis_s_sign() {
    let together = [(0, 0), (1, 1)];
    let truth = drawer_that(DVec3::X, (0.0, 1.0));
    let of = |axis, range| moved_points_giou(&drawer_that(axis, range), &truth, &together);
    assert_eq!(of(DVec3::X, (0.0, 1.0)), 1.0);
    assert_eq!(of(-DVec3::X, (-1.0, 0.0)), 1.0, "the same motion, said the other way round");
    // Half as far: two unit boxes that overlap by half. The base is right in all.
    let half = of(DVec3::X, (0.0, 0.5));
    assert!((half - (1.0 + 1.0 / 3.0) / 2.0).abs() < 1e-12, "{half}");
    // Not at all, and the other way: two boxes side by side.
    for range in [(0.0, 0.0), (-1.0, 0.0)] {
        assert!((of(DVec3::X, range) - 0.5).abs() < 1e-12, "{range:?}");
    }
    assert_eq!(moved_points_giou(&truth, &truth, &[(0, 0)]), 0.0, "a part without a counterpart");
    let open = drawer_that(DVec3::X, (-1.0, 0.1));
    assert_eq!(moved_points_giou(&open, &open, &together), 1.0, "shown open, it shuts");
}

#[test]
fn a_wheel_is_turned_as_far_as_the_truth_goes() {
    let parts = || [grid(DVec3::ZERO, DVec3::ONE), grid(DVec3::X, DVec3::ONE)];
    let wheel = |kind, axis, range| {
        let spin = motion(kind, axis, DVec3::X, range);
        body(&parts(), vec![Link::default(), Link { parent: Some(0), motions: vec![spin] }])
    };
    let truth = wheel(JointKind::Revolute, DVec3::Z, (-0.2, 1.0));
    for axis in [DVec3::Z, -DVec3::Z] {
        let found = wheel(JointKind::Continuous, axis, (-PI, PI));
        let giou = moved_points_giou(&found, &truth, &[(0, 0), (1, 1)]);
        assert!((giou - 1.0).abs() < 1e-12, "{giou}");
    }
}

#[test]
fn a_missing_part_costs_its_worst_on_the_side_it_is_missing() {
    let truth = drawer(DVec3::new(2.0, 0.0, 0.0));
    let predicted = body(&[grid(DVec3::ZERO, DVec3::ONE)], vec![Link::default(), Link::default()]);
    let half_diagonal = 3.0_f64.sqrt() / 2.0;
    let mut comparer = Comparer::new(predicted, truth, Rules::Paper, 3);
    let comparison = comparer.compare(&comparer.by_number());
    let scores = Scores::of(&comparison, None, 1.0, &[]);
    assert_eq!((scores.precision, scores.recall), (1.0, 0.5));
    assert_eq!((scores.giou, scores.box_iou), ((1.0 + 0.0) / 2.0, (1.0 + 0.5) / 2.0));
    assert!((scores.chamfer - half_diagonal / 2.0 / 2.0).abs() < 1e-15);
}

#[test]
fn the_root_stands_still_by_the_paper_and_moves_by_the_public_code() {
    let slide = motion(JointKind::Prismatic, DVec3::X, DVec3::ZERO, (0.0, 1.0));
    let links = vec![Link { parent: None, motions: vec![slide] }];
    let (still, moving) = (
        body(&[grid(DVec3::ZERO, DVec3::ONE)], vec![Link::default()]),
        body(&[grid(DVec3::ZERO, DVec3::ONE)], links),
    );
    let overall = |rules| {
        let mut comparer = Comparer::new(moving.clone(), still.clone(), rules, 1);
        comparer.compare(&[(0, 0)]).overall_moved.last().copied().unwrap()
    };
    assert_eq!(overall(Rules::Paper), 0.0);
    assert!(overall(Rules::RefCompat) > 0.2);
}

#[test]
fn a_child_is_carried_by_its_parent_and_its_axis_with_it() {
    let point = vec![DVec3::new(2.0, 0.0, 0.0)];
    let quarter = |x: f64| {
        let range = (0.0, std::f64::consts::FRAC_PI_2);
        vec![motion(JointKind::Revolute, DVec3::Z, DVec3::X * x, range)]
    };
    let links = vec![
        Link { parent: Some(1), motions: quarter(1.0) },
        Link { parent: None, motions: quarter(0.0) },
    ];
    let arm = Body::new(point, vec![0], links).unwrap();
    let tip = arm.moved(Drive::Share(1.0))[0];
    assert!((tip - DVec3::new(-1.0, 1.0, 0.0)).length() < 1e-14, "{tip}");
    assert!(arm.moves(0) && !arm.clone().with_still_root().moves(1));
}

#[test]
fn what_is_not_a_body_is_refused() {
    let one = || vec![DVec3::ZERO];
    let link = |parent| Link { parent, motions: vec![] };
    assert_eq!(Body::new(vec![], vec![], vec![]), Err(BodyError::NoPoints));
    assert_eq!(
        Body::new(one(), vec![1], vec![link(None)]),
        Err(BodyError::UnknownPart { part: 1, parts: 1 })
    );
    let circle = vec![link(None), link(Some(2)), link(Some(1))];
    assert_eq!(Body::new(one(), vec![0], circle), Err(BodyError::Rootless(1)));
    assert_eq!(Body::new(one(), vec![0], vec![link(Some(9))]), Err(BodyError::Rootless(0)));
    assert_eq!(
        Body::new(vec![DVec3::NAN], vec![0], vec![link(None)]),
        Err(BodyError::NotFinite(0))
    );
}

fn one_joint(wanted: Motion, found: Motion) -> super::JointComparison {
    let of = |m: Motion| body(&[vec![DVec3::ZERO]], vec![Link { parent: None, motions: vec![m] }]);
    compare_joints(&of(found), &of(wanted), [(0, Some(0))])[0].clone()
}

#[test]
fn an_axis_counts_whichever_way_it_points_and_its_range_is_turned_with_it() {
    let wanted = motion(JointKind::Revolute, DVec3::Z, DVec3::ZERO, (0.0, 1.0));
    let found = motion(JointKind::Revolute, DVec3::NEG_Z, DVec3::X * 0.02, (-0.5, 0.0));
    let joint = one_joint(wanted, found);
    assert_eq!((joint.angle, joint.range), (Some(0.0), Some(0.5)));
    assert!((joint.line.unwrap() - 0.02).abs() < 1e-15 && joint.is_found());
}

#[test]
fn lines_that_cross_at_right_angles_are_no_distance_apart() {
    let joint = one_joint(hinge(DVec3::Z, DVec3::ZERO), hinge(DVec3::X, DVec3::Z * 3.0));
    assert!((joint.angle.unwrap() - 90.0).abs() < 1e-9);
    assert!(joint.line.unwrap() < 1e-12 && !joint.is_near());
}

#[test]
fn a_joint_of_another_type_or_of_an_unmatched_part_is_counted_but_not_compared() {
    let slide = motion(JointKind::Prismatic, DVec3::Z, DVec3::ZERO, (0.0, 1.0));
    let wanted = hinge(DVec3::Z, DVec3::ZERO);
    assert_eq!(one_joint(wanted, slide).angle, None);
    let links = vec![Link { parent: None, motions: vec![wanted] }];
    let object = body(&[vec![DVec3::ZERO]], links);
    let scores = super::JointScores::of(&compare_joints(&object, &object, [(0, None)]));
    assert_eq!((scores.joints, scores.compared, scores.near), (1, 0, Some(0.0)));
    assert_eq!(scores.angle, None);
}

#[test]
fn points_of_a_part_that_is_missing_count_as_nothing() {
    let truth = [0, 0, 0, 1, 1, 2];
    assert_eq!(point_ious(&truth, &truth, &[(0, 0), (1, 1), (2, 2)]).mean, Some(1.0));
    let predicted = [0, 0, 0, 1, 0, 0];
    let ious = point_ious(&predicted, &truth, &[(0, 0), (1, 1)]);
    let found = ious.mean.unwrap();
    assert!((found - (3.0 / 5.0 + 1.0 / 2.0 + 0.0) / 3.0).abs() < 1e-15);
}
