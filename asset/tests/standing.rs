//! What is shown standing stands: other masses, or a small turn.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on stops")]

use asset::{Asset, BuildOptions, build};
use object::{
    ArticulatedObject, Condition, DQuat, DVec3, JointKind, JointMotion, KinematicTree, Mesh, Part,
    Range,
};

/// A base and an arm that turns on it about x, each made of blocks (centre, size).
fn asset(base: &[(DVec3, DVec3)], arm: &[(DVec3, DVec3)], said: &str) -> Asset {
    let range = Range::Limits { lower: 0.0, upper: 0.2 };
    let (axis, pivot) = (DVec3::X, arm[0].0);
    let hinge = JointMotion { kind: JointKind::Revolute, axis, pivot, range };
    let part = |name: &str, parent, joints: &[JointKind]| Part {
        name: name.into(),
        text: name.into(),
        parent,
        joints: joints.to_vec(),
    };
    let parts = vec![part("base", None, &[]), part("arm", Some(0), &[JointKind::Revolute])];
    let tree = KinematicTree::new(parts).unwrap();
    let (mut vertices, mut faces, mut labels) = (vec![], vec![], vec![]);
    for (part, of) in [base, arm].into_iter().enumerate() {
        for (centre, size) in of {
            let first = vertices.len() as u32;
            let pick = |i: u32, k: usize| ((i >> k) & 1) as f64 - 0.5;
            let corner = |i| *centre + *size * DVec3::new(pick(i, 0), pick(i, 1), pick(i, 2));
            vertices.extend((0..8).map(corner));
            let quads = [
                [0, 2, 3, 1],
                [4, 5, 7, 6],
                [0, 1, 5, 4],
                [2, 6, 7, 3],
                [0, 4, 6, 2],
                [1, 3, 7, 5],
            ];
            let halves = |q: [u32; 4]| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]];
            faces.extend(quads.into_iter().flat_map(halves).map(|f| f.map(|v| v + first)));
            labels.extend([part as u16; 12]);
        }
    }
    let mesh = Mesh::new(vertices, faces).unwrap();
    let object = ArticulatedObject::new(mesh, tree, labels, vec![vec![], vec![hinge]]).unwrap();
    let condition = format!(
        r#"{{"schema": "kinfold-condition/1", "category": "thing", "parts": [{{"name": "base" {said}}},
            {{"name": "arm", "parent": "base", "joint": "revolute" {said}}}]}}"#
    );
    let condition = Condition::from_json(&condition).unwrap();
    build(&object, &condition, &[Some(0), Some(1)], &BuildOptions::default()).unwrap()
}

fn centre(asset: &Asset) -> DVec3 {
    let of = |l: &asset::Link| (l.frame + l.inertial.centre.value) * l.inertial.mass.value;
    asset.links.iter().map(of).sum::<DVec3>() / asset.mass()
}

fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

/// A lamp whose arm reaches out farther than its foot.
fn lamp(said: &str) -> Asset {
    let base = [(v(0.0, 0.0, 0.015), v(0.24, 0.24, 0.03)), (v(0.0, 0.0, 0.4), v(0.03, 0.03, 0.74))];
    asset(&base, &[(v(0.0, 0.34, 0.82), v(0.08, 0.7, 0.08))], said)
}

#[test]
fn a_lamp_that_would_tip_over_gets_a_heavy_foot() {
    let lamp = lamp("");
    assert!(centre(&lamp).y < 0.115, "{}", centre(&lamp));
    let masses: Vec<_> = lamp.changes.iter().filter(|c| c.what == "mass").collect();
    assert!(!masses.is_empty() && masses.iter().all(|c| c.why.contains("S2")), "{masses:?}");
    assert_eq!(lamp.turn, DQuat::IDENTITY);
}

/// A ladder that leans over its narrow feet: no masses bring it as far inside them as other things.
#[test]
fn what_is_too_narrow_to_stand_firmly_is_brought_as_far_as_it_can_be() {
    let base = [(v(0.0, 0.0, 1.0), v(0.5, 0.08, 2.0))];
    let ladder = asset(&base, &[(v(0.0, 0.075, 2.0), v(0.5, 0.05, 3.8))], "");
    let inside = 0.04 - centre(&ladder).y;
    assert!(inside > 0.012, "{inside} m inside its edge");
    assert!(ladder.changes.iter().any(|c| c.what == "mass"), "{:?}", ladder.changes);
}

#[test]
fn a_stated_mass_stays() {
    let lamp = lamp(r#", "mass": 1.0"#);
    assert!(lamp.changes.iter().all(|c| c.what != "mass"), "{:?}", lamp.changes);
    assert!(lamp.links.iter().all(|l| l.inertial.mass.value == 1.0));
}

/// A chest with a bar under its front alone.
#[test]
fn a_chest_that_would_lean_is_set_down_as_it_leans() {
    let base = [(v(0.0, 0.0, 0.25), v(0.5, 0.6, 0.4)), (v(0.0, 0.28, 0.03), v(0.5, 0.02, 0.05))];
    let chest = asset(&base, &[(v(0.0, 0.0, 0.48), v(0.5, 0.6, 0.04))], "");
    let angle = (0.045f64 / 0.57).atan();
    let (axis, turned) = chest.turn.to_axis_angle();
    assert!((turned - angle).abs() < 0.01 && axis.x.abs() > 0.999, "{axis} {turned}");
    let said: Vec<_> = chest.changes.iter().filter(|c| c.what == "stance").collect();
    assert_eq!(said.len(), 1, "{:?}", chest.changes);
    let hinge = chest.joints[0].motion.as_ref().unwrap().axis.value;
    assert!((hinge - chest.turn * DVec3::X).length() < 1e-9, "{hinge}");
    let lowest = chest.links.iter().filter_map(|l| {
        let body = l.body.as_ref()?;
        body.visual.vertices().iter().map(|p| (p + l.frame).z).min_by(f64::total_cmp)
    });
    assert!(lowest.fold(f64::INFINITY, f64::min).abs() < 1e-9);
    let middle = v(0.0, 0.28, 0.005);
    let stands = chest.turn * (middle * chest.scale.value) + chest.offset;
    assert!(stands.z.abs() < 1e-3, "the bar is on the ground: {stands}");
}

/// A table on four thin legs of which two are a little short.
#[test]
fn a_table_that_would_rock_gets_level_feet() {
    let short = 0.001;
    let leg = |x: f64, y: f64| {
        let up = if x * y > 0.0 { short } else { 0.0 };
        (v(x, y, 0.2 + up / 2.0), v(0.012, 0.012, 0.4 - up))
    };
    let base = [leg(0.4, 0.3), leg(-0.4, 0.3), leg(0.4, -0.3), leg(-0.4, -0.3)];
    let table = asset(&base, &[(v(0.0, 0.0, 0.42), v(0.9, 0.7, 0.04))], "");
    let body = table.links[0].body.as_ref().unwrap();
    let lowest = |p: &asset::collision::piece::ConvexPiece| {
        p.vertices.iter().map(|v| (v + table.links[0].frame).z).fold(f64::INFINITY, f64::min)
    };
    let feet: Vec<f64> = body.collision.iter().map(lowest).collect();
    assert!(feet.len() == 4 && feet.iter().all(|z| z.abs() < 1e-9), "{feet:?}");
    let said = |a: &Asset| a.changes.iter().filter(|c| c.after == "level feet").count();
    assert_eq!((said(&table), table.turn), (1, DQuat::IDENTITY), "{:?}", table.changes);
    assert_eq!(said(&lamp("")), 0, "a level foot stays");
}

#[test]
fn joints_held_more_firmly_can_still_be_driven_and_say_so() {
    let loose = lamp("");
    let firm = loose.firmer(2.0, ["kinematic, not S2", "dynamic"], "S2");
    let [was, now] = [&loose, &firm].map(|a| a.joints[0].motion.clone().unwrap());
    assert_eq!(now.friction.value, 2.0 * was.friction.value);
    assert!(now.effort.value >= was.effort.value + 3.0 * was.friction.value - 1e-12);
    assert!(now.friction.how.contains("2 times that: S2"), "{}", now.friction.how);
    let change = firm.changes.last().unwrap();
    assert_eq!((change.what.as_str(), firm.changes.len()), ("friction", loose.changes.len() + 1));
    assert!(change.before.contains("not S2") && change.after.contains("dynamic"), "{change:?}");
}
