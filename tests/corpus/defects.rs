//! One defect each: the check that must catch it, the good asset, and the one change.

use super::good::{
    box_with_lid, button, cabinet, canister, cart, cat_flap, chest, corner_unit, drawer,
    folding_door, laptop, oven, sliding_door, stove_knob, tap, tray_drawer, two_flaps,
};
use super::model::{Geometry, Joint, Link, Model, Shape, block, obj, prism};

/// Name, check, good asset, change.
pub type Defect = (&'static str, &'static str, fn() -> Model, fn(&mut Model));

fn cabinet_meshes() -> Model {
    cabinet().in_meshes()
}

fn drawer_meshes() -> Model {
    drawer().in_meshes()
}

#[rustfmt::skip]
pub const DEFECTS: &[Defect] = &[
    // files and numbers
    ("mass_is_nan", "F1", drawer, |m| m.inertial("tray").mass = f64::NAN),
    ("limit_is_infinite", "F1", oven, |m| m.joint("hinge").limits = Some([0.0, f64::INFINITY])),
    ("comma_as_decimal_point", "F1", laptop, |m| m.edit("0 0.1 0.021", "0 0,1 0.021")),
    ("tag_left_open", "F1", tap, |m| m.edit("</link>", "")),
    ("entity_bomb", "F1", cart, |m| m.edit("<robot name=\"", "<!DOCTYPE r [<!ENTITY a \"b\">]>\n<robot name=\"&a;")),
    ("size_with_two_numbers", "F1", stove_knob, |m| m.edit("0.5 0.5 0.2", "0.5 0.5")),
    ("mesh_is_missing", "F2", drawer_meshes, |m| drop(m.files.remove("meshes/tray_c3.obj"))),
    ("mesh_is_no_mesh", "F2", drawer_meshes, |m| drop(m.files.insert("meshes/tray.obj".into(), "f 1 2 9\n".into()))),
    ("mesh_path_climbs_out", "F2", cabinet_meshes, |m| m.edit("meshes/door.obj", "../door.obj")),
    ("mesh_path_of_a_package", "F2", cabinet_meshes, |m| m.edit("meshes/door.obj", "package://cabinet/meshes/door.obj")),
    ("mesh_path_with_backslash", "F2", cabinet_meshes, |m| m.edit("meshes/door.obj", "meshes\\door.obj")),
    ("mesh_path_is_absolute", "F2", tray_drawer, |m| m.edit("meshes/tray.obj", "/meshes/tray.obj")),
    ("name_with_a_blank", "F3", chest, |m| m.joint("low_slide").name = "low slide".into()),
    ("name_twice", "F3", cart, |m| m.joints[1].name = m.joints[0].name.clone()),
    // tree
    ("link_nobody_attaches", "T1", tap, |m| m.links.push(Link::solid("spare", 600.0, &[Shape::block([0.1; 3], [1.0; 3])]))),
    ("child_does_not_exist", "T1", drawer, |m| m.joint("slide").child = "box".into()),
    ("parent_misspelt", "T1", folding_door, |m| m.joint("second").parent = "Leaf".into()),
    ("joints_in_a_circle", "T1", folding_door, |m| m.joint("first").parent = "end".into()),
    ("two_parents", "T1", chest, |m| m.joint("high_slide").child = "low".into()),
    ("joint_type_unknown", "T2", canister, |m| m.joint("turn").kind = "screw"),
    ("mimics_itself", "T2", two_flaps, |m| m.joint("left_hinge").mimic = Some("left_hinge".into())),
    ("mimics_nobody", "T2", two_flaps, |m| m.joint("left_hinge").mimic = Some("hinge".into())),
    ("moving_link_is_empty", "T3", canister, |m| m.link("carrier").inertial = None),
    // units
    ("mesh_in_millimetres_scaled", "U1", cabinet_meshes, |m| in_millimetres(m, "door", 1e-3)),
    ("all_in_millimetres", "U2", laptop, |m| grow(m, 1000.0)),
    ("smaller_than_a_grain", "U2", tap, |m| grow(m, 0.01)),
    // geometry
    ("faces_wound_against_each_other", "G1", cabinet_meshes, |m| flip(m, "meshes/door.obj", 2)),
    ("surface_inside_out", "G1", tray_drawer, |m| flip(m, "meshes/tray.obj", 1)),
    ("faces_without_area", "G1", tray_drawer, |m| append(m, "meshes/tray.obj", "f 1 1 2\nf 3 3 4\n")),
    ("too_many_faces", "G1", tray_drawer, |m| drop(m.files.insert("meshes/tray.obj".into(), fine_tray()))),
    ("collision_mesh_is_open", "G2", cabinet_meshes, |m| cut(m, "meshes/door_c0.obj", 3)),
    ("collision_mesh_inside_out", "G2", cabinet_meshes, |m| flip(m, "meshes/door_c0.obj", 1)),
    ("collision_mesh_is_hollow", "G2", tray_drawer, |m| m.link("tray").collisions = m.link("tray").visuals.clone()),
    ("collision_mesh_is_a_sheet", "G2", cabinet_meshes, |m| drop(m.files.insert("meshes/door_c0.obj".into(), sheet()))),
    ("collision_mesh_too_fine", "G2", || stove_knob().in_meshes(), |m| drop(m.files.insert("meshes/knob_c0.obj".into(), fine_knob()))),
    ("too_many_pieces", "G2", cabinet, |m| m.link("door").collisions = slats(40)),
    ("nothing_to_collide_with", "G3", sliding_door, |m| m.link("door").collisions.clear()),
    ("hollow_filled", "G3", tray_drawer, |m| m.link("tray").collisions = vec![Shape::block([0.35, 0.46, 0.2], [0.0, 0.0, 0.1])]),
    ("opening_walled_up", "G3", drawer, |m| m.link("body").collisions = vec![Shape::block([0.4, 0.5, 0.3], [0.0, 0.0, 0.15])]),
    ("collision_beside_the_door", "G3", cabinet, |m| m.link("door").collisions[0].centre[0] += 0.1),
    ("lever_does_not_collide", "G3", tap, |m| drop(m.link("lever").collisions.pop())),
    ("loose_chunk", "G4", oven, |m| both(m, "door", Shape::block([0.1, 0.02, 0.1], [0.0, -0.01, 0.7]))),
    ("loose_chunk_in_a_mesh", "G4", laptop, |m| { both(m, "body", Shape::block([0.05; 3], [0.5, 0.0, 0.1])); *m = std::mem::take(m).in_meshes(); }),
    // mass
    ("no_mass_given", "M1", chest, |m| m.link("high").inertial = None),
    ("mass_is_zero", "M1", stove_knob, |m| m.inertial("knob").mass = 0.0),
    ("mass_is_negative", "M1", drawer_meshes, |m| m.inertial("tray").mass *= -1.0),
    ("light_as_air", "M2", box_with_lid, |m| heavier(m, "lid", 0.002)),
    ("heavier_than_gold", "M2", cabinet_meshes, |m| heavier(m, "door", 60.0)),
    ("inertia_below_zero", "M3", laptop, |m| m.inertial("screen").tensor[0] *= -1.0),
    ("inertia_breaks_the_triangle", "M3", tap, |m| m.inertial("lever").tensor[2] *= 5.0),
    ("inertia_off_the_diagonal", "M3", drawer, |m| m.inertial("tray").tensor[3] = 1.0),
    ("inertia_is_one", "M4", cart, |m| m.inertial("rear_left").tensor = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0]),
    ("inertia_in_grams", "M4", folding_door, |m| m.inertial("leaf").tensor = m.inertial("leaf").tensor.map(|i| i * 1000.0)),
    ("inertia_of_a_speck", "M4", sliding_door, |m| m.inertial("door").tensor = m.inertial("door").tensor.map(|i| i * 0.01)),
    ("centre_of_mass_outside", "M5", oven, |m| m.inertial("door").centre[2] = 0.6),
    ("centre_of_mass_in_millimetres", "M5", button, |m| m.inertial("body").centre[2] = 50.0),
    ("feather_on_an_anvil", "M6", button, |m| heavier(m, "key", 0.02)),
    // joints
    ("axis_is_zero", "J1", stove_knob, |m| m.joint("spin").axis = [0.0; 3]),
    ("axis_is_long", "J1", cat_flap, |m| m.joint("swing").axis = [2.0, 0.0, 0.0]),
    ("limits_swapped", "J2", laptop, |m| m.joint("hinge").limits = Some([2.2, 0.0])),
    ("limits_missing", "J2", drawer, |m| m.joint("slide").limits = None),
    ("rest_outside_the_limits", "J2", sliding_door, |m| m.joint("slide").limits = Some([0.05, 0.29])),
    ("limits_equal", "J2", tap, |m| m.joint("turn").limits = Some([0.0, 0.0])),
    ("degrees_for_radians", "J3", tap, |m| m.joint("turn").limits = Some([-45.0, 45.0])),
    ("millimetres_for_metres", "J3", drawer_meshes, |m| m.joint("slide").limits = Some([0.0, 250.0])),
    ("effort_is_zero", "J4", box_with_lid, |m| m.joint("hinge").effort = 0.0),
    ("velocity_is_negative", "J4", chest, |m| m.joint("low_slide").velocity = -1.0),
    ("pivot_far_away", "J5", tap, |m| m.joint("turn").origin[0] = 0.4),
    ("part_left_floating", "J5", two_flaps, |m| m.joint("right_hinge").origin[1] = -1.2),
    ("falls_open", "J7", oven, |m| (m.joint("hinge").friction, m.inertial("door").centre[1]) = (0.0, -0.02)),
    ("slips_down", "J7", cat_flap, |m| m.joints[0] = sliding_flap()),
    // contact
    ("door_sunk_into_the_body", "C1", cabinet, |m| m.joint("hinge").origin[1] = -0.19),
    ("drawers_in_each_other", "C1", chest, |m| m.joint("high_slide").origin[2] = 0.2),
    ("wheel_in_the_platform", "C1", cart, |m| m.joint("front_left_spin").origin[1] = 0.14),
    ("drawer_through_the_bottom", "C1", drawer_meshes, |m| m.joint("slide").origin[2] = 0.01),
    ("lid_goes_into_the_box", "C2", box_with_lid, |m| m.joint("hinge").limits = Some([-0.5, 1.5])),
    ("button_pushed_too_deep", "C2", button, |m| m.joint("press").limits = Some([0.0, 0.03])),
    ("flap_hits_a_step", "C2", cat_flap, |m| both(m, "body", Shape::block([0.3, 0.04, 0.2], [0.0, -0.15, 0.1]))),
    ("pointer_hits_the_stove", "C2", stove_knob, |m| both(m, "body", Shape::block([0.02, 0.05, 0.02], [0.14, -0.275, 0.1]))),
    ("drawer_through_the_back", "C2", drawer_meshes, |m| m.joint("slide").limits = Some([-0.1, 0.2])),
    ("end_leaf_folds_through", "C2", folding_door, |m| m.joint("second").limits = Some([-1.5, 1.5])),
    ("drawers_meet_in_the_corner", "C3", corner_unit, |m| m.joint("side_slide").origin[1] += 0.12),
    ("drawer_falls_out", "C4", drawer, |m| m.joint("slide").limits = Some([0.0, 0.475])),
    ("hinge_lets_go", "C4", cabinet, |m| shift_pivot(m, -0.03)),
    ("door_opens_inwards", "C5", cabinet_meshes, |m| m.joint("hinge").axis[2] = 1.0),
    ("drawer_opens_backwards", "C5", drawer, |m| m.joint("slide").axis[1] = 1.0),
    ("lid_opens_downwards", "C5", box_with_lid, |m| m.joint("hinge").axis[0] = 1.0),
    // behaviour
    ("tips_over", "S2", two_flaps, |m| (m.inertial("body").mass, m.inertial("body").centre[1]) = (40.0, -0.149)),
    ("weaker_than_its_friction", "S3", sliding_door, |m| m.joint("slide").effort = 0.05),
    ("stuck_by_friction", "S3", chest, |m| m.joint("high_slide").friction = 500.0),
];

fn append(m: &mut Model, file: &str, text: &str) {
    m.files.get_mut(file).expect("a file of that name").push_str(text);
}

/// Every n-th face the other way round.
fn flip(m: &mut Model, file: &str, every: usize) {
    change_faces(m, file, |i, [a, b, c]| Some(if i % every == 0 { [a, c, b] } else { [a, b, c] }));
}

/// The surface without its first faces.
fn cut(m: &mut Model, file: &str, faces: usize) {
    change_faces(m, file, |i, face| (i >= faces).then_some(face));
}

fn change_faces<'a>(
    m: &mut Model,
    file: &str,
    change: impl Fn(usize, [String; 3]) -> Option<[String; 3]> + 'a,
) {
    let text = m.files.get_mut(file).expect("a file of that name");
    let (mut out, mut count) = (String::new(), 0);
    for line in text.lines() {
        let Some(rest) = line.strip_prefix("f ") else {
            out.push_str(&format!("{line}\n"));
            continue;
        };
        let corners: Vec<String> = rest.split(' ').map(String::from).collect();
        let face: [String; 3] = corners.try_into().expect("a triangle");
        if let Some([a, b, c]) = change(count, face) {
            out.push_str(&format!("f {a} {b} {c}\n"));
        }
        count += 1;
    }
    *text = out;
}

/// More of a link, seen and felt.
fn both(m: &mut Model, link: &str, shape: Shape) {
    let link = m.link(link);
    link.visuals.push(shape.clone());
    link.collisions.push(shape);
}

fn heavier(m: &mut Model, link: &str, factor: f64) {
    let inertial = m.inertial(link);
    inertial.mass *= factor;
    inertial.tensor = inertial.tensor.map(|i| i * factor);
}

/// The whole model larger, masses as they are for that size.
fn grow(m: &mut Model, factor: f64) {
    let longer = |t: &mut [f64; 3]| *t = t.map(|c| c * factor);
    for link in &mut m.links {
        if let Some(i) = &mut link.inertial {
            i.mass *= factor.powi(3);
            longer(&mut i.centre);
            i.tensor = i.tensor.map(|c| c * factor.powi(5));
        }
        for shape in link.visuals.iter_mut().chain(&mut link.collisions) {
            longer(&mut shape.centre);
            match &mut shape.geometry {
                Geometry::Block(size) => longer(size),
                Geometry::Cylinder { radius, length } => {
                    (*radius, *length) = (*radius * factor, *length * factor);
                }
                Geometry::Mesh { scale, .. } => *scale *= factor,
            }
        }
    }
    m.joints.iter_mut().for_each(|j| longer(&mut j.origin));
}

/// A link's surface in millimetres, scaled back in the URDF.
fn in_millimetres(m: &mut Model, link: &str, scale: f64) {
    let shapes = &mut m.link(link).visuals;
    let Geometry::Mesh { file, scale: given } = &mut shapes[0].geometry else { panic!("no mesh") };
    *given = scale;
    let file = file.clone();
    let text = m.files.get_mut(&file).expect("a file of that name");
    let larger = |line: &str| match line.strip_prefix("v ") {
        Some(rest) => {
            let numbers = rest.split(' ').map(|n| n.parse::<f64>().expect("a number") / scale);
            let numbers: Vec<_> = numbers.map(|n| n.to_string()).collect();
            format!("v {}\n", numbers.join(" "))
        }
        None => format!("{line}\n"),
    };
    *text = text.lines().map(larger).collect();
}

/// A tray's outside as one block, every side of it a fine grid.
fn fine_tray() -> String {
    const SIDE: usize = 120;
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for axis in 0..3 {
        for end in [0.0, 1.0] {
            let first = vertices.len();
            for i in 0..=SIDE {
                for j in 0..=SIDE {
                    let mut at = [0.0; 3];
                    at[axis] = end;
                    at[(axis + 1) % 3] = i as f64 / SIDE as f64;
                    at[(axis + 2) % 3] = j as f64 / SIDE as f64;
                    let size = [0.35, 0.46, 0.2];
                    vertices.push(std::array::from_fn(|k| (at[k] - 0.5) * size[k]));
                }
            }
            for i in 0..SIDE {
                for j in 0..SIDE {
                    let v = |i, j| first + i * (SIDE + 1) + j;
                    let quad = [v(i, j), v(i + 1, j), v(i + 1, j + 1), v(i, j + 1)];
                    let [a, b, c, d] = quad;
                    let out = [[a, b, c], [a, c, d]];
                    faces.extend(if end == 1.0 { out } else { out.map(|[a, b, c]| [a, c, b]) });
                }
            }
        }
    }
    obj(&vertices, &faces, 1)
}

/// The knob's cylinder with 100 sides, along y.
fn fine_knob() -> String {
    let (vertices, faces) = prism(0.025, 0.03, 100);
    let lying: Vec<_> = vertices.into_iter().map(|[x, y, z]| [x, -z - 0.015, y]).collect();
    obj(&lying, &faces, 1)
}

/// A door's front without any thickness, both sides.
fn sheet() -> String {
    let (vertices, faces) = block([0.5, 0.0, 0.6]);
    let placed: Vec<_> = vertices.into_iter().map(|[x, _, z]| [x + 0.25, -0.01, z + 0.3]).collect();
    obj(&placed, &faces, 1)
}

/// The door cut into upright slats.
fn slats(count: usize) -> Vec<Shape> {
    let width = 0.5 / count as f64;
    let slat = |i: usize| Shape::block([width, 0.02, 0.6], [width * (i as f64 + 0.5), -0.01, 0.3]);
    (0..count).map(slat).collect()
}

/// The flap as a sash that may slide down, with nothing to hold it.
fn sliding_flap() -> Joint {
    let place = [[0.0, 0.0, 0.354], [0.0, 0.0, -1.0]];
    Joint { friction: 0.0, ..Joint::slide("swing", ["body", "flap"], place, [0.0, 0.03]) }
}

/// The hinge moved along the front, the door staying where it is.
fn shift_pivot(m: &mut Model, by: f64) {
    m.joint("hinge").origin[1] += by;
    let door = m.link("door");
    door.inertial.as_mut().expect("a link with mass").centre[1] -= by;
    for shape in door.visuals.iter_mut().chain(&mut door.collisions) {
        shape.centre[1] -= by;
    }
}
