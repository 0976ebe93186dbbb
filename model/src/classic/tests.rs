//! Joints of things anybody can picture: a cabinet, a drawer, a door, a knob.

use object::weld::Weld;
use object::{Condition, DVec3, JointKind, JointMotion, KinematicTree, Mesh, Part, Range};

use crate::articulate::Articulate;
use crate::classic::joints::context::JointContext;
use crate::classic::joints::features::NAMES;
use crate::classic::joints::pins::{pins, rings};
use crate::classic::joints::range::Travel;
use crate::classic::joints::scene::Scene;
use crate::classic::joints::sweep::{Axis, Probe, Sweep};
use crate::classic::joints::{Joints, Labelled, fit_joints};
use crate::classic::{Geometric, Hybrid};

/// A mesh in the making: triangles and the part each belongs to.
#[derive(Clone, Default)]
struct Model {
    vertices: Vec<DVec3>,
    faces: Vec<[u32; 3]>,
    labels: Vec<u16>,
}

impl Model {
    fn add(&mut self, part: u16, points: &[DVec3], faces: &[[u32; 3]]) {
        let base = self.vertices.len() as u32;
        self.vertices.extend(points);
        self.faces.extend(faces.iter().map(|f| f.map(|v| v + base)));
        self.labels.extend(faces.iter().map(|_| part));
    }

    fn block(mut self, part: u16, min: [f64; 3], max: [f64; 3]) -> Self {
        let at = |i: u32| {
            DVec3::from_array([0, 1, 2].map(|k| if i >> k & 1 == 0 { min[k] } else { max[k] }))
        };
        let quads =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let faces: Vec<_> = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        self.add(part, &(0..8).map(at).collect::<Vec<_>>(), &faces);
        self
    }

    /// A round bar of radius `r` from `a` to `b`.
    fn bar(mut self, part: u16, a: DVec3, b: DVec3, r: f64) -> Self {
        let n = 24;
        let axis = (b - a).normalize();
        let u = axis.any_orthonormal_vector();
        let v = axis.cross(u);
        let ring = |c: DVec3| {
            (0..n).map(move |i| {
                let (s, t) = (std::f64::consts::TAU * f64::from(i) / f64::from(n)).sin_cos();
                c + u * (r * t) + v * (r * s)
            })
        };
        let points: Vec<DVec3> = ring(a).chain(ring(b)).chain([a, b]).collect();
        let n = n as u32;
        let side = |i: u32| {
            let j = (i + 1) % n;
            [[i, j, n + j], [i, n + j, n + i], [2 * n, j, i], [2 * n + 1, n + i, n + j]]
        };
        self.add(part, &points, &(0..n).flat_map(side).collect::<Vec<_>>());
        self
    }

    fn mesh(&self) -> Mesh {
        Mesh::new(self.vertices.clone(), self.faces.clone()).unwrap()
    }

    fn joints(&self, parts: &[(&str, JointKind)]) -> Joints {
        let (mesh, tree) = (self.mesh(), tree(parts));
        let weld = Weld::new(&mesh);
        let part_of_face = &self.labels;
        fit_joints(
            &Labelled {
                mesh: &mesh,
                weld: &weld,
                tree: &tree,
                part_of_face,
                category: "",
                given: &[],
            },
            &[],
            3,
        )
    }
}

fn tree(parts: &[(&str, JointKind)]) -> KinematicTree {
    let base = Part { name: "body".into(), text: "body".into(), parent: None, joints: vec![] };
    let part = |&(text, kind): &(&str, JointKind)| Part {
        name: text.replace(' ', "_"),
        text: text.into(),
        parent: Some(0),
        joints: vec![kind],
    };
    KinematicTree::new(std::iter::once(base).chain(parts.iter().map(part)).collect()).unwrap()
}

/// Five ensembles around a hollow that opens towards −y: 0.5 wide, 0.6 deep, 0.4 high.
fn cabinet() -> Model {
    Model::default()
        .block(0, [-0.25, 0.0, 0.0], [-0.23, 0.6, 0.4])
        .block(0, [0.23, 0.0, 0.0], [0.25, 0.6, 0.4])
        .block(0, [-0.25, 0.0, 0.0], [0.25, 0.6, 0.02])
        .block(0, [-0.25, 0.0, 0.38], [0.25, 0.6, 0.4])
        .block(0, [-0.25, 0.58, 0.0], [0.25, 0.6, 0.4])
}

/// An open box in the hollow, a hair off its walls, with a handle.
fn cabinet_with_drawer() -> Model {
    cabinet()
        .block(1, [-0.22, -0.02, 0.03], [0.22, 0.0, 0.37])
        .block(1, [-0.22, 0.0, 0.03], [-0.21, 0.5, 0.3])
        .block(1, [0.21, 0.0, 0.03], [0.22, 0.5, 0.3])
        .block(1, [-0.22, 0.0, 0.03], [0.22, 0.5, 0.04])
        .block(1, [-0.22, 0.49, 0.03], [0.22, 0.5, 0.3])
        .block(1, [-0.05, -0.05, 0.19], [0.05, -0.02, 0.21])
}

/// A slab before the hollow, its knuckles on a pin at the left edge, its handle at the right.
fn cabinet_with_door() -> Model {
    let at = |z| DVec3::new(-0.26, -0.015, z);
    cabinet()
        .block(1, [-0.25, -0.025, 0.0], [0.25, -0.005, 0.4])
        .block(1, [0.19, -0.06, 0.15], [0.21, -0.025, 0.25])
        .bar(1, at(0.05), at(0.12), 0.01)
        .bar(1, at(0.28), at(0.35), 0.01)
        .bar(0, at(0.03), at(0.37), 0.004)
        .block(0, [-0.265, -0.01, 0.02], [-0.25, 0.05, 0.03])
}

fn only(joints: &Joints) -> JointMotion {
    joints.motions[1][0]
}

fn limits(m: &JointMotion) -> (f64, f64) {
    match m.range {
        Range::Limits { lower, upper } => (lower, upper),
        Range::Continuous => panic!("expected limits"),
    }
}

/// How far the second part slides along a direction, in lengths of the model.
fn slide(model: &Model, direction: DVec3, limit: f64) -> f64 {
    let (mesh, tree) = (model.mesh(), tree(&[("thing", JointKind::Prismatic)]));
    let weld = Weld::new(&mesh);
    let part_of_face = &model.labels;
    let from =
        Labelled { mesh: &mesh, weld: &weld, tree: &tree, part_of_face, category: "", given: &[] };
    let scene = Scene::new(&from, 3);
    let probe = |&p: &DVec3| Probe::new(&scene, &[0], p);
    let probes: Vec<Probe> = scene.bodies[1].probes.iter().map(probe).collect();
    let sweep = Sweep { scene: &scene, probes: &probes, still: &[0], step: 0.004 };
    let axis = Axis { direction, pivot: DVec3::ZERO, turns: false };
    sweep.free(&axis, limit / scene.unit, [0.0])[0] * scene.unit
}

#[test]
fn a_part_with_the_same_faces_under_other_labels_is_the_same_body() {
    let model = Model::default()
        .block(0, [0.0, 0.0, 0.0], [2.0, 1.0, 1.0])
        .block(1, [2.0, 0.0, 0.0], [2.1, 1.0, 1.0])
        .bar(2, DVec3::new(1.0, -0.2, 0.5), DVec3::new(1.0, 0.0, 0.5), 0.1);
    let parts = [("door", JointKind::Revolute), ("knob", JointKind::Continuous)];
    let (mesh, tree) = (model.mesh(), tree(&parts));
    let weld = Weld::new(&mesh);
    let labelled = |part_of_face| Labelled {
        mesh: &mesh,
        weld: &weld,
        tree: &tree,
        part_of_face,
        category: "",
        given: &[],
    };
    let mut labels = model.labels.clone();
    labels[0] = 1;
    let own = Scene::new(&labelled(&model.labels), 3);
    let [beside, alone] =
        [&[&own][..], &[]].map(|known| Scene::beside(known, &labelled(&labels), 3));
    let is_shared = [0, 1, 2].map(|p| std::sync::Arc::ptr_eq(&beside.bodies[p], &own.bodies[p]));
    assert_eq!(is_shared, [false, false, true]);
    for (here, there) in beside.bodies.iter().zip(&alone.bodies) {
        assert_eq!(here.probes, there.probes);
        assert_eq!((here.bounds, here.area), (there.bounds, there.area));
        let x = DVec3::new(0.1, -0.4, 0.2);
        assert_eq!(format!("{:?}", here.nearest(x, 1.0)), format!("{:?}", there.nearest(x, 1.0)));
    }
    let look = |scene: &Scene| format!("{:?}", scene.look(DVec3::X, -DVec3::X, 2.0));
    assert_eq!(look(&beside), look(&alone));
}

#[test]
fn a_block_stops_at_the_wall_it_meets() {
    let model = Model::default().block(0, [3.0, -2.0, -2.0], [3.5, 2.0, 2.0]).block(
        1,
        [0.0, 0.0, 0.0],
        [1.0, 1.0, 1.0],
    );
    let free = slide(&model, DVec3::X, 4.0);
    assert!((free - 2.0).abs() < 0.06, "two to go, found {free}");
    assert!((slide(&model, DVec3::Y, 4.0) - 4.0).abs() < 1e-9);
}

#[test]
fn a_block_slides_over_the_floor_it_lies_on() {
    let model = Model::default().block(0, [-4.0, -4.0, -0.2], [4.0, 4.0, 0.0]).block(
        1,
        [0.0, 0.0, 0.0],
        [1.0, 1.0, 1.0],
    );
    assert!((slide(&model, DVec3::X, 2.0) - 2.0).abs() < 1e-9);
    assert!((slide(&model, DVec3::Z, 2.0) - 2.0).abs() < 1e-9);
    assert!(slide(&model, DVec3::NEG_Z, 2.0) < 0.1, "it does not sink in");
}

#[test]
fn a_sheet_of_paper_is_a_wall_too() {
    let model = Model::default().block(0, [2.0, -2.0, -2.0], [2.001, 2.0, 2.0]).block(
        1,
        [0.0, 0.0, 0.0],
        [1.0, 1.0, 1.0],
    );
    let free = slide(&model, DVec3::X, 4.0);
    assert!((free - 1.0).abs() < 0.1, "one to go, found {free}");
}

#[test]
fn a_drawer_slides_out_along_its_normal() {
    let m = only(&cabinet_with_drawer().joints(&[("drawer", JointKind::Prismatic)]));
    assert!(m.axis.dot(DVec3::NEG_Y) > 0.999, "{m:?}");
    let (lower, upper) = limits(&m);
    assert!(lower <= 0.0 && upper > 0.25 && upper < 0.5, "it stays in its guide: {m:?}");
}

#[test]
fn a_shut_drawer_is_seen_from_its_front_alone() {
    let model = cabinet_with_drawer();
    let (mesh, tree) = (model.mesh(), tree(&[("drawer", JointKind::Prismatic)]));
    let part_of_face = &model.labels;
    let weld = Weld::new(&mesh);
    let from =
        Labelled { mesh: &mesh, weld: &weld, tree: &tree, part_of_face, category: "", given: &[] };
    let scene = Scene::new(&from, 0);
    let context = JointContext::new(&scene, &from, 1, None, 0).unwrap();
    let place = |name: &str| NAMES.iter().position(|n| *n == name).unwrap();
    let seen = |d: DVec3| {
        let axis = Axis { direction: d, pivot: DVec3::ZERO, turns: false };
        let features = context.features(&axis, &[DVec3::X, DVec3::Y, DVec3::Z], [0.0; 2]);
        ["seen_less", "seen_more"].map(|name| 10f64.powf(features[place(name)]) - 0.03)
    };
    let ([back, front], [side, other]) = (seen(DVec3::Y), seen(DVec3::X));
    assert!(front > 0.5 && back < 0.1, "{front} {back}");
    assert!(side < 0.2 && other < 0.2, "{side} {other}");
}

#[test]
fn a_door_swings_about_the_pin_away_from_its_handle() {
    let m = only(&cabinet_with_door().joints(&[("door", JointKind::Revolute)]));
    assert!(m.axis.z.abs() > 0.999, "{m:?}");
    let pin = DVec3::new(-0.26, -0.015, 0.0);
    assert!((m.pivot - pin).with_z(0.0).length() < 0.02, "{m:?}");
    let (lower, upper) = limits(&m);
    assert!(lower > -0.1 && upper > 1.2, "{m:?}");
    let handle = DVec3::new(0.2, -0.06, 0.2);
    let way = m.axis.cross(handle - m.pivot);
    assert!(way.y < 0.0, "positive opens: {m:?}");
}

#[test]
fn a_knob_turns_about_its_own_axis_without_end() {
    let (a, b) = (DVec3::new(0.1, -0.06, 0.3), DVec3::new(0.1, -0.001, 0.3));
    let model = Model::default().block(0, [-0.3, 0.0, 0.0], [0.3, 0.4, 0.4]).bar(1, a, b, 0.04);
    let m = only(&model.joints(&[("knob", JointKind::Continuous)]));
    assert!(m.axis.y.abs() > 0.999 && m.range == Range::Continuous, "{m:?}");
    assert!((m.pivot - a).with_y(0.0).length() < 0.003, "{m:?}");
}

#[test]
fn an_axis_without_an_opening_side_points_the_positive_way() {
    let faced = |direction, range| {
        let axis = Axis { direction, pivot: DVec3::ZERO, turns: true };
        let Travel { axis, range, .. } =
            Travel { axis, range, stuck: false, rough: false, said: None }.facing();
        (axis.direction, range)
    };
    let limits = |lower, upper| Range::Limits { lower, upper };
    let oblique = DVec3::new(0.6, 0.0, -0.8);
    for (direction, range, wanted) in [
        (DVec3::NEG_Z, limits(-1.0, 1.2), (DVec3::Z, limits(-1.2, 1.0))),
        (oblique, limits(-0.3, 0.3), (-oblique, limits(-0.3, 0.3))),
        (DVec3::NEG_X, Range::Continuous, (DVec3::X, Range::Continuous)),
        (DVec3::Y, limits(-1.0, 1.2), (DVec3::Y, limits(-1.0, 1.2))),
        // what opens one way says so by its axis
        (DVec3::NEG_Z, limits(-0.1, 1.2), (DVec3::NEG_Z, limits(-0.1, 1.2))),
        (DVec3::NEG_Y, limits(0.0, 0.4), (DVec3::NEG_Y, limits(0.0, 0.4))),
    ] {
        assert_eq!(faced(direction, range), wanted);
    }
}

#[test]
fn a_button_goes_in_however_tall_that_is_what_it_sits_on() {
    let model = Model::default()
        .block(0, [-0.3, -0.4, 0.0], [0.3, 0.0, 0.3])
        .block(0, [-0.3, 0.0, 0.0], [0.3, 0.3, 1.6])
        .block(1, [-0.03, -0.25, 0.3], [0.03, -0.2, 0.32]);
    let m = only(&model.joints(&[("button", JointKind::Prismatic)]));
    assert!(m.axis.dot(DVec3::NEG_Z) > 0.999, "{m:?}");
    let (lower, upper) = limits(&m);
    assert!(lower == 0.0 && upper > 0.0 && upper < 0.02, "{m:?}");
}

#[test]
fn a_hinge_shows_by_its_knuckles_in_one_line() {
    let at = |z| DVec3::new(-0.25, -0.04, z);
    let door = cabinet()
        .block(1, [-0.25, -0.025, 0.0], [0.25, -0.005, 0.4])
        .bar(1, at(0.05), at(0.14), 0.015)
        .bar(0, at(0.145), at(0.255), 0.015)
        .bar(1, at(0.26), at(0.35), 0.015)
        .block(1, [0.2, -0.06, 0.1], [0.22, -0.04, 0.3]);
    let (mesh, tree) = (door.mesh(), tree(&[("door", JointKind::Revolute)]));
    let (weld, part_of_face) = (Weld::new(&mesh), &door.labels);
    let from =
        Labelled { mesh: &mesh, weld: &weld, tree: &tree, part_of_face, category: "", given: &[] };
    let scene = Scene::new(&from, 0);
    let context = JointContext::new(&scene, &from, 1, None, 0).unwrap();
    let seen = |x: DVec3| (x - scene.origin) / scene.unit;
    let round = |x: DVec3| rings(&scene, seen(x), DVec3::Z).first().map(|ring| ring.part);
    assert_eq!([0.1, 0.2, 0.3].map(|z| round(at(z))), [Some(1), Some(0), Some(1)]);
    assert_eq!(round(at(0.38)), None, "above the hinge");
    assert_eq!(round(DVec3::new(0.21, -0.05, 0.2)), None, "a square handle");
    assert_eq!(round(DVec3::new(0.0, -0.015, 0.2)), None, "a slab");
    let found = pins(&scene, context.contact.all(), DVec3::Z);
    let off = |x: &DVec3| (*x - seen(at(0.2))).with_z(0.0).length();
    assert!(found.iter().any(|x| off(x) < 1e-4), "{found:?}");
    let aside = rings(&scene, seen(at(0.2) + DVec3::new(0.002, -0.001, 0.0)), DVec3::Z)[0];
    assert!(
        off(&aside.middle) < 1e-3 && (aside.radius * scene.unit - 0.015).abs() < 3e-4,
        "{aside:?}"
    );

    let told = |pivot: DVec3| {
        let axis = Axis { direction: DVec3::Z, pivot: seen(pivot), turns: true };
        let features = context.features(&axis, &[DVec3::X, DVec3::Y, DVec3::Z], [0.0; 2]);
        ["pin_own", "pin_other", "pin_both", "pin_any", "beyond", "overhang"]
            .map(|name| features[NAMES.iter().position(|n| *n == name).unwrap()])
    };
    let [own, other, both, any, beyond, overhang] = told(at(0.2));
    assert!((own - 0.375).abs() < 0.05 && (other - 0.23).abs() < 0.05, "{own} {other}");
    assert!((any - own - other).abs() < 0.05, "{any}");
    assert!(both > 0.6 && beyond.abs() < 0.1 && overhang > -0.05, "{both} {beyond} {overhang}");
    assert_eq!(told(DVec3::new(0.25, -0.015, 0.2))[..4], [0.0; 4], "the other edge");
}

#[test]
fn knuckles_that_are_all_taken_for_the_parts_show_beside_the_contact() {
    let at = |z| DVec3::new(-0.25, -0.04, z);
    let door = cabinet()
        .block(1, [-0.25, -0.025, 0.0], [0.25, -0.005, 0.4])
        .bar(1, at(0.05), at(0.35), 0.015)
        .bar(1, DVec3::new(0.21, -0.08, 0.1), DVec3::new(0.21, -0.08, 0.3), 0.01);
    let (mesh, tree) = (door.mesh(), tree(&[("door", JointKind::Revolute)]));
    let (weld, part_of_face) = (Weld::new(&mesh), &door.labels);
    let from =
        Labelled { mesh: &mesh, weld: &weld, tree: &tree, part_of_face, category: "", given: &[] };
    let scene = Scene::new(&from, 0);
    let context = JointContext::new(&scene, &from, 1, None, 0).unwrap();
    let touched = pins(&scene, context.contact.all(), DVec3::Z);
    let axes: Vec<Axis> = crate::classic::joints::candidates::turns(
        &context.sources(),
        &[DVec3::X, DVec3::Y, DVec3::Z],
    );
    let seen = |x: DVec3| (x - scene.origin) / scene.unit;
    let shows = |x: DVec3| {
        axes.iter().any(|a| a.direction == DVec3::Z && a.radius(seen(x)) * scene.unit < 0.001)
    };
    assert!(touched.is_empty(), "{touched:?}");
    assert!(shows(at(0.2)), "the knuckles' line");
    assert!(!shows(DVec3::new(0.21, -0.08, 0.2)), "a handle's bar stands off");
}

#[test]
fn about_a_pin_is_the_knuckle() {
    let at = |z| DVec3::new(-0.26, -0.015, z);
    let door = cabinet_with_door();
    let (mesh, tree) = (door.mesh(), tree(&[("door", JointKind::Revolute)]));
    let (weld, part_of_face) = (Weld::new(&mesh), &door.labels);
    let from =
        Labelled { mesh: &mesh, weld: &weld, tree: &tree, part_of_face, category: "", given: &[] };
    let scene = Scene::new(&from, 0);
    let about = |z| {
        let rings = rings(&scene, (at(z) - scene.origin) / scene.unit, DVec3::Z);
        rings.iter().map(|ring| ring.part).collect::<Vec<_>>()
    };
    assert_eq!([0.1, 0.2, 0.3].map(about), [vec![0, 1], vec![0], vec![0, 1]]);
}

#[test]
fn what_a_hand_finds_is_no_hinge() {
    let found = |model: &Model| {
        let (mesh, tree) = (model.mesh(), tree(&[("door", JointKind::Revolute)]));
        let part_of_face = &model.labels;
        let weld = Weld::new(&mesh);
        let from = Labelled {
            mesh: &mesh,
            weld: &weld,
            tree: &tree,
            part_of_face,
            category: "",
            given: &[],
        };
        let scene = Scene::new(&from, 0);
        let context = JointContext::new(&scene, &from, 1, None, 0).unwrap();
        [context.grip, context.knuckle].map(|at| at.map(|x| (x * scene.unit + scene.origin).x))
    };
    let [grip, knuckle] = found(&cabinet_with_door());
    assert!(grip.is_some_and(|x| (x - 0.2).abs() < 0.02) && knuckle.is_none());
    // A handle beside a wall that it stands out from: its foot is near what stays, as a hinge is.
    let slab = cabinet().block(1, [-0.25, -0.025, 0.0], [0.25, -0.005, 0.4]);
    let walled = slab.block(0, [0.25, -0.1, 0.0], [0.27, 0.6, 0.4]);
    let [grip, knuckle] = found(&walled.block(1, [0.22, -0.13, 0.15], [0.24, -0.025, 0.25]));
    assert!(grip.is_some_and(|x| x > 0.2) && knuckle.is_none(), "{grip:?} {knuckle:?}");
    // Thick knuckles on a pin, and no handle.
    let at = |z| DVec3::new(-0.24, -0.04, z);
    let bare = cabinet()
        .block(1, [-0.25, -0.025, 0.0], [0.25, -0.005, 0.4])
        .bar(1, at(0.05), at(0.12), 0.012)
        .bar(1, at(0.28), at(0.35), 0.012)
        .bar(0, at(0.03), at(0.37), 0.004);
    let [grip, knuckle] = found(&bare);
    assert!(grip.is_none() && knuckle.is_some_and(|x| (x + 0.24).abs() < 0.02));
}

#[test]
fn knobs_and_wheels_say_how_a_cart_stands() {
    let wheel = |model: Model, part, x| {
        let at = |y| DVec3::new(x, y, -0.05);
        model.bar(part, at(-0.21), at(-0.24), 0.05).bar(part, at(0.21), at(0.24), 0.05)
    };
    let knob = [DVec3::new(0.31, 0.0, 0.2), DVec3::new(0.35, 0.0, 0.2)];
    let cart = Model::default()
        .block(0, [-0.3, -0.2, 0.0], [0.3, 0.2, 0.3])
        .block(1, [-0.3, -0.2, 0.31], [0.3, 0.2, 0.33])
        .bar(2, knob[0], knob[1], 0.03);
    let cart = wheel(wheel(cart, 3, -0.2), 4, 0.2);
    let kinds = [
        ("lid", JointKind::Revolute),
        ("knob", JointKind::Continuous),
        ("wheel 1", JointKind::Continuous),
        ("wheel 2", JointKind::Continuous),
    ];
    let (mesh, tree) = (cart.mesh(), tree(&kinds));
    let weld = Weld::new(&mesh);
    let part_of_face = &cart.labels;
    let from =
        Labelled { mesh: &mesh, weld: &weld, tree: &tree, part_of_face, category: "", given: &[] };
    let scene = Scene::new(&from, 0);
    let context = |part| JointContext::new(&scene, &from, part, None, 0).unwrap();
    let lid = context(1);
    assert!(lid.reached.is_some_and(|way| way.dot(DVec3::X) > 0.999), "{:?}", lid.reached);
    assert_eq!(lid.rolling, Some(DVec3::Y));
    assert_eq!(lid.wheeled, None, "wheels on both sides tell no side");
    assert_eq!(context(2).reached, None, "a knob does not tell itself where the front is");

    let told = |direction: DVec3, pivot: [f64; 3]| {
        let pivot = (DVec3::from_array(pivot) - scene.origin) / scene.unit;
        let axis = Axis { direction, pivot, turns: true };
        let features = lid.features(&axis, &[DVec3::X, DVec3::Y, DVec3::Z], [0.0; 2]);
        ["front", "front_along", "rolls", "along_x", "right", "back"]
            .map(|name| features[NAMES.iter().position(|n| *n == name).unwrap()])
    };
    let [front, along, rolls, along_x, right, back] = told(DVec3::Y, [-0.3, 0.0, 0.32]);
    assert!(front < -0.5 && right < -0.5 && back.abs() < 0.05, "{front} {right} {back}");
    assert!(along < 0.01 && rolls > 0.99 && along_x < 0.01, "{along} {rolls} {along_x}");
    let [front, along, rolls, along_x, right, back] = told(DVec3::X, [0.0, 0.2, 0.32]);
    assert!(front.abs() < 0.05 && right.abs() < 0.05 && back > 0.4, "{front} {right} {back}");
    assert!(along > 0.99 && rolls < 0.01 && along_x > 0.99, "{along} {rolls} {along_x}");
}

#[test]
fn the_pivot_of_a_hinge_is_near_both_parts() {
    let model = cabinet_with_door();
    let m = only(&model.joints(&[("door", JointKind::Revolute)]));
    let mesh = model.mesh();
    let near = |part: u16| {
        let own = (0..mesh.faces().len()).filter(|&f| model.labels[f] == part);
        object::weld::nearest_face(&mesh.submesh(own).unwrap(), m.pivot).1
    };
    assert!(near(0).max(near(1)) < 0.05 * mesh.bounds().diagonal(), "{m:?}");
}

#[test]
fn an_object_in_millimetres_gets_the_same_joints() {
    let small = cabinet_with_drawer();
    let mut large = small.clone();
    large.vertices.iter_mut().for_each(|v| *v = *v * 1000.0 + DVec3::new(7.0, -30.0, 11.0));
    let parts = [("drawer", JointKind::Prismatic)];
    let (a, b) = (only(&small.joints(&parts)), only(&large.joints(&parts)));
    assert!((a.axis - b.axis).length() < 1e-6, "{a:?} {b:?}");
    assert!((limits(&a).1 * 1000.0 - limits(&b).1).abs() < 1.0, "{a:?} {b:?}");
}

#[test]
fn any_number_of_threads_gives_the_same_joints() {
    let model = cabinet_with_door();
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| model.joints(&[("door", JointKind::Revolute)]))
    };
    assert_eq!(run(1), run(5));
}

#[test]
fn a_part_walled_in_gets_a_small_range_and_a_note() {
    let model = Model::default()
        .block(0, [-0.11, -0.11, -0.11], [0.11, 0.11, -0.1])
        .block(0, [-0.11, -0.11, 0.1], [0.11, 0.11, 0.11])
        .block(0, [-0.11, -0.11, -0.11], [-0.1, 0.11, 0.11])
        .block(0, [0.1, -0.11, -0.11], [0.11, 0.11, 0.11])
        .block(0, [-0.11, -0.11, -0.11], [0.11, -0.1, 0.11])
        .block(0, [-0.11, 0.1, -0.11], [0.11, 0.11, 0.11])
        .block(1, [-0.1, -0.1, -0.1], [0.1, 0.1, 0.1]);
    let joints = model.joints(&[("slider", JointKind::Prismatic)]);
    let (lower, upper) = limits(&only(&joints));
    assert!(lower <= 0.0 && upper > 0.0 && upper - lower < 0.05, "{joints:?}");
    assert_eq!(joints.notes.len(), 1);
    assert!(!joints.notes[0].loss);
}

/// A slab whose top has a raised button, one fused mesh of few triangles: 18 of the slab, 10 of the button.
fn slab_with_button() -> Model {
    let square = |half: f64, z: f64| {
        [[-half, -half], [half, -half], [half, half], [-half, half]]
            .map(|[x, y]| DVec3::new(x, y, z))
    };
    let rings = [square(1.0, 0.0), square(1.0, 0.5), square(0.2, 0.5), square(0.2, 0.56)];
    let wall = |ring: u32| {
        let side = move |i: u32| {
            let (a, b) = (4 * ring + i, 4 * ring + (i + 1) % 4);
            [[a, b, b + 4], [a, b + 4, a + 4]]
        };
        (0..4).flat_map(side).collect::<Vec<_>>()
    };
    let mut slab = Model::default();
    let slab_faces = [vec![[0, 2, 1], [0, 3, 2]], wall(0), wall(1)].concat();
    slab.add(0, &rings.concat(), &slab_faces);
    let button = [wall(2), vec![[12, 13, 14], [12, 14, 15]]].concat();
    slab.faces.extend(&button);
    slab.labels.extend(button.iter().map(|_| 1));
    slab
}

#[test]
fn however_faces_are_drawn_the_same_is_found() {
    let once = slab_with_button();
    let turned = |[a, b, c]: [u32; 3]| [b, a, c];
    let mut both = once.clone();
    both.faces = once.faces.iter().flat_map(|&face| [turned(face), face]).collect();
    both.labels = once.labels.iter().flat_map(|&part| [part; 2]).collect();
    let mut within = once.clone();
    within.faces = once.faces.iter().map(|&face| turned(face)).collect();
    let mut mixed = once.clone();
    mixed.faces.iter_mut().step_by(3).for_each(|face| *face = turned(*face));
    let parts = r#"{"name": "body", "point": [0.9, 0.8, 0.5]},
        {"name": "button", "parent": "body", "joint": "prismatic", "point": [0.05, 0.1, 0.56]}"#;
    let text = format!(r#"{{"schema": "kinfold-condition/1", "up": "z", "parts": [{parts}]}}"#);
    let condition = Condition::from_json(&text).unwrap();
    for articulator in [&Geometric as &dyn Articulate, &Hybrid] {
        for drawn in [&once, &both, &within, &mixed] {
            let made = articulator.articulate(&drawn.mesh(), &condition, 1).unwrap().object;
            assert_eq!(made.part_of_face(), drawn.labels);
            assert_eq!(made.mesh(), &drawn.mesh());
            let axis = made.joints(1)[0].axis;
            assert!(axis.z.abs() > 0.999, "{axis}");
        }
    }
}
