//! Small assemblies whose clearances are known, judged by parry's contact query.

use glamx::{DPose3, DVec3};
use object::pose::joint_pose;
use object::{ArticulatedObject, JointKind, JointMotion, KinematicTree, Mesh, Part, Range};
use parry3d_f64::query::contact;
use parry3d_f64::shape::ConvexPolyhedron;

use super::{ClearanceOptions, Cleared, clear};
use crate::collision::hulls::decompose;
use crate::collision::hulls::tests::{add_box, volume};

type Box3 = ([f64; 3], [f64; 3]);

/// Vertices and faces.
type Soup = (Vec<DVec3>, Vec<[u32; 3]>);

fn joint(kind: JointKind, axis: DVec3, pivot: DVec3, lower: f64, upper: f64) -> JointMotion {
    let range = match kind {
        JointKind::Continuous => Range::Continuous,
        _ => Range::Limits { lower, upper },
    };
    JointMotion { kind, axis, pivot, range }
}

/// Parts made of boxes: the first is the base, the others hang on it by one joint each.
fn assembly(parts: &[(&[Box3], Option<JointMotion>)]) -> ArticulatedObject {
    let (mut soup, mut labels, mut tree, mut joints) = Default::default();
    let (soup, labels): (&mut Soup, &mut Vec<u16>) = (&mut soup, &mut labels);
    for (i, (boxes, joint)) in parts.iter().enumerate() {
        boxes.iter().for_each(|&(min, max)| add_box(soup, min, max));
        labels.resize(soup.1.len(), i as u16);
        let parent = (i > 0).then_some(0);
        let kinds = joint.iter().map(|j| j.kind).collect();
        let part = Part { name: format!("p{i}"), text: String::new(), parent, joints: kinds };
        Vec::push(&mut tree, part);
        Vec::push(&mut joints, Vec::from_iter(*joint));
    }
    let mesh = Mesh::new(soup.0.clone(), soup.1.clone()).unwrap();
    ArticulatedObject::new(mesh, KinematicTree::new(tree).unwrap(), labels.clone(), joints).unwrap()
}

fn cleared(object: &ArticulatedObject) -> Cleared {
    let options = ClearanceOptions::for_diagonal(object.mesh().bounds().diagonal());
    let link = |p: usize| object.mesh().submesh(object.faces_of(p)).unwrap();
    let pieces = (0..object.tree().len()).map(|p| decompose(&link(p), options.tolerance).unwrap());
    let cleared = clear(object, pieces.collect(), &options);
    assert!(cleared.pieces.iter().all(|p| !p.is_empty()), "no part loses its last piece");
    cleared
}

/// Deepest overlap of parts 1 and 2, or 1 and 0 where there are two, at 101 values of the range.
fn deepest(cleared: &Cleared, moved: usize, other: usize) -> f64 {
    let motion = cleared.joints[moved][0];
    let (low, high) = motion.range.ends();
    let shape = |p: &crate::collision::piece::ConvexPiece| {
        ConvexPolyhedron::from_convex_hull(&p.vertices).unwrap()
    };
    let of = |part: usize| cleared.pieces[part].iter().map(shape).collect::<Vec<_>>();
    let (a, b) = (of(moved), of(other));
    let mut worst = 0.0f64;
    for i in 0..=100 {
        let pose = joint_pose(&motion, low + (high - low) * f64::from(i) / 100.0);
        for (x, y) in a.iter().flat_map(|x| b.iter().map(move |y| (x, y))) {
            let found = contact(&pose, x, &DPose3::identity(), y, 0.0).unwrap();
            worst = worst.max(-found.map_or(0.0, |c| c.dist));
        }
    }
    worst
}

const CABINET: [Box3; 5] = [
    ([0.0, 0.0, 0.0], [0.5, 0.4, 0.02]),
    ([0.0, 0.0, 0.28], [0.5, 0.4, 0.3]),
    ([0.0, 0.0, 0.02], [0.02, 0.4, 0.28]),
    ([0.48, 0.0, 0.02], [0.5, 0.4, 0.28]),
    ([0.02, 0.38, 0.02], [0.48, 0.4, 0.28]),
];

#[test]
fn a_drawer_that_fits_exactly_slides_its_whole_range() {
    let drawer: [Box3; 1] = [([0.02, 0.0, 0.02], [0.48, 0.38, 0.28])];
    let slide = joint(JointKind::Prismatic, -DVec3::Y, DVec3::ZERO, 0.0, 0.3);
    let result = cleared(&assembly(&[(&CABINET, None), (&drawer, Some(slide))]));
    assert_eq!(result.joints[1][0].range, Range::Limits { lower: 0.0, upper: 0.3 });
    assert_eq!(deepest(&result, 1, 0), 0.0);
    assert!(result.changes.is_empty(), "{:?}", result.changes);
}

#[test]
fn a_shaft_sunk_into_a_block_turns_freely_and_keeps_its_length() {
    let block: [Box3; 1] = [([0.0; 3], [0.3, 0.3, 0.2])];
    let shaft: [Box3; 2] =
        [([0.14, 0.14, 0.02], [0.16, 0.16, 0.3]), ([0.1, 0.1, 0.3], [0.2, 0.2, 0.32])];
    let spin = joint(JointKind::Continuous, DVec3::Z, DVec3::new(0.15, 0.15, 0.0), 0.0, 0.0);
    let result = cleared(&assembly(&[(&block, None), (&shaft, Some(spin))]));
    assert_eq!(deepest(&result, 1, 0), 0.0);
    let low = result.pieces[1].iter().flat_map(|p| &p.vertices).map(|v| v.z).fold(9.0, f64::min);
    assert!(low < 0.05, "the shaft still reaches into the block, to z = {low}");
    let left: f64 = result.pieces[0].iter().map(volume).sum();
    assert!(left > 0.9 * 0.3 * 0.3 * 0.2, "the block loses a hole only: {left}");
}

#[test]
fn a_door_stops_where_a_wall_stands() {
    let wall: [Box3; 2] =
        [([-0.2, 0.5, 0.0], [1.0, 0.6, 1.0]), ([-0.1, 0.0, 0.0], [-0.01, 0.02, 1.0])];
    let door: [Box3; 1] = [([0.0, 0.0, 0.0], [1.0, 0.02, 1.0])];
    let hinge = joint(JointKind::Revolute, DVec3::Z, DVec3::ZERO, 0.0, 2.0);
    let result = cleared(&assembly(&[(&wall, None), (&door, Some(hinge))]));
    let (_, upper) = result.joints[1][0].range.ends();
    // The far edge's outer corner, at angle atan(0.02) on the door, comes to y = 0.5.
    let meets = (0.5 / 1.0f64.hypot(0.02)).asin() - 0.02f64.atan();
    assert!(upper < meets + 0.05 && upper > meets - 0.07, "stops at {upper}, meets at {meets}");
    assert_eq!(deepest(&result, 1, 0), 0.0);
    assert!(result.changes.iter().any(|c| c.part == "p1" && c.what == "range"));
}

#[test]
fn two_doors_that_cross_are_kept_apart() {
    let base: [Box3; 1] = [([-1.0, -0.3, -0.1], [1.0, 0.3, -0.02])];
    let left: [Box3; 1] = [([-0.6, 0.0, 0.0], [-0.01, 0.02, 0.5])];
    let right: [Box3; 1] = [([0.01, 0.0, 0.0], [0.6, 0.02, 0.5])];
    let at = |x: f64| DVec3::new(x, 0.0, 0.0);
    // Hinged at the middle of each other's way: together at a right angle they would cross.
    let a = joint(JointKind::Revolute, -DVec3::Z, at(-0.3), 0.0, 1.5);
    let b = joint(JointKind::Revolute, DVec3::Z, at(0.25), 0.0, 1.5);
    let object = assembly(&[(&base, None), (&left, Some(a)), (&right, Some(b))]);
    let result = cleared(&object);
    let moved = object.with_joints(result.joints.clone()).unwrap();
    let shape = |p: &crate::collision::piece::ConvexPiece| {
        ConvexPolyhedron::from_convex_hull(&p.vertices).unwrap()
    };
    for i in 0..=30 {
        for j in 0..=30 {
            let at =
                |part: usize, k: i32| moved.joints(part)[0].range.ends().1 * f64::from(k) / 30.0;
            let pose = |part: usize, k| joint_pose(&moved.joints(part)[0], at(part, k));
            for (x, y) in
                result.pieces[1].iter().flat_map(|x| result.pieces[2].iter().map(move |y| (x, y)))
            {
                let found = contact(&pose(1, i), &shape(x), &pose(2, j), &shape(y), 0.0).unwrap();
                assert!(found.is_none_or(|c| c.dist > -1e-3), "at {i}, {j}");
            }
        }
    }
}

#[test]
fn a_slide_is_no_longer_than_its_part_and_stays_in_its_guide() {
    let rail: [Box3; 1] = [([0.0, 0.0, 0.0], [1.0, 0.1, 0.05])];
    let slider: [Box3; 1] = [([0.0, 0.0, 0.06], [0.4, 0.1, 0.1])];
    let slide = joint(JointKind::Prismatic, DVec3::X, DVec3::ZERO, -0.5, 0.9);
    let result = cleared(&assembly(&[(&rail, None), (&slider, Some(slide))]));
    let (lower, upper) = result.joints[1][0].range.ends();
    assert!(
        upper - lower <= 1.15 * 0.4 + 1e-9 && lower >= -0.4 * 0.93 && upper <= 1.0 - 0.4 * 0.07
    );
}

#[test]
fn the_same_object_gives_the_same_bytes() {
    let block: [Box3; 1] = [([0.0; 3], [0.3, 0.3, 0.2])];
    let knob: [Box3; 1] = [([0.1, 0.1, 0.1], [0.2, 0.2, 0.3])];
    let spin = joint(JointKind::Continuous, DVec3::Z, DVec3::new(0.15, 0.15, 0.0), 0.0, 0.0);
    let object = assembly(&[(&block, None), (&knob, Some(spin))]);
    let (first, second) = (cleared(&object), cleared(&object));
    assert_eq!((first.pieces, first.joints), (second.pieces, second.joints));
}
