//! Small robots, each sound but for one thing.

use std::path::{Path, PathBuf};

use object::Mesh;
use object::obj::ObjNormals;

use super::surface::merged;
use super::*;
use crate::geometry::tessellate::tessellated;
use crate::read::load;
use crate::robot::Geometry;
use crate::verdict::Status;
use glamx::{DPose3, DVec3};

/// A cabinet of five boards with a drawer of five boards that slides out 0.3 m towards −y.
/// Board: centre and size in centimetres.
const CABINET: [[f64; 6]; 5] = [
    [0.0, 0.0, 1.0, 50.0, 40.0, 2.0],
    [0.0, 0.0, 29.0, 50.0, 40.0, 2.0],
    [-24.0, 0.0, 15.0, 2.0, 40.0, 26.0],
    [24.0, 0.0, 15.0, 2.0, 40.0, 26.0],
    [0.0, 19.0, 15.0, 46.0, 2.0, 26.0],
];
const DRAWER: [[f64; 6]; 5] = [
    [0.0, -1.0, 3.5, 44.0, 36.0, 2.0],
    [-21.0, -1.0, 14.5, 2.0, 36.0, 20.0],
    [21.0, -1.0, 14.5, 2.0, 36.0, 20.0],
    [0.0, 16.0, 14.5, 40.0, 2.0, 20.0],
    [0.0, -18.0, 14.5, 40.0, 2.0, 20.0],
];

fn shapes(tag: &str, boards: &[[f64; 6]]) -> String {
    let one = |b: &[f64; 6]| {
        let [x, y, z, w, d, h] = b.map(|c| c / 100.0);
        format!(
            "<{tag}><origin xyz=\"{x} {y} {z}\"/><geometry><box size=\"{w} {d} {h}\"/></geometry></{tag}>\n"
        )
    };
    boards.iter().map(one).collect()
}

fn inertial(mass: f64, centre: &str, [x, y, z]: [f64; 3]) -> String {
    format!(
        "<inertial><origin xyz=\"{centre}\"/><mass value=\"{mass}\"/><inertia ixx=\"{x}\" iyy=\"{y}\" izz=\"{z}\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>\n"
    )
}

/// The sound cabinet.
fn cabinet() -> String {
    let link = |name: &str, inertial: String, boards: &[[f64; 6]]| {
        let (seen, touched) = (shapes("visual", boards), shapes("collision", boards));
        format!("<link name=\"{name}\">\n{inertial}{seen}{touched}</link>\n")
    };
    let body = inertial(10.0, "0 0 0.15", [0.3, 0.4, 0.5]);
    let tray = inertial(4.0, "0 -0.01 0.12", [0.08, 0.12, 0.16]);
    let joint = "<joint name=\"slide\" type=\"prismatic\"><parent link=\"body\"/><child link=\"tray\"/>\
        <axis xyz=\"0 -1 0\"/><limit lower=\"0\" upper=\"0.3\" effort=\"50\" velocity=\"1\"/>\
        <dynamics damping=\"1\" friction=\"5\"/></joint>\n";
    let links = link("body", body, &CABINET) + &link("tray", tray, &DRAWER);
    format!("<robot name=\"cabinet\">\n{links}{joint}</robot>\n")
}

fn all(text: &str, folder: &Path) -> Vec<Check> {
    let options = CheckOptions::default();
    let loaded = load::from_text(text, folder, &options);
    let robot = loaded.robot.unwrap_or_else(|| panic!("not a robot: {:?}", loaded.checks));
    checks(&robot, &options)
}

/// Ids that do not hold, warnings included.
fn broken(text: &str) -> Vec<String> {
    let found = all(text, Path::new(".")).into_iter().filter(|c| c.status != Status::Pass);
    found.map(|c| c.id).collect()
}

/// Ids that do not hold once a piece of the sound cabinet is written otherwise.
fn after(old: &str, new: &str) -> Vec<String> {
    let text = cabinet();
    assert!(text.contains(old), "nothing to replace: {old}");
    broken(&text.replacen(old, new, 1))
}

#[test]
fn the_sound_cabinet_passes_everything() {
    assert_eq!(broken(&cabinet()), [""; 0], "{:#?}", all(&cabinet(), Path::new(".")));
}

#[test]
fn one_hull_round_a_drawer_fills_its_cavity() {
    let solid = shapes("collision", &[[0.0, -1.0, 13.5, 44.0, 36.0, 22.0]]);
    assert_eq!(after(&shapes("collision", &DRAWER), &solid), ["G3"]);
}

#[test]
fn a_board_without_collider_is_not_covered() {
    assert_eq!(after(&shapes("collision", &DRAWER), &shapes("collision", &DRAWER[..4])), ["G3"]);
    assert_eq!(after(&shapes("collision", &DRAWER), ""), ["G3"]);
}

#[test]
fn a_knob_in_the_air_is_loose_and_one_on_the_front_is_not() {
    let knob = |y: f64| {
        let board = [0.0, y, 14.5, 14.0, 2.0, 20.0];
        let both = shapes("visual", &[board]) + &shapes("collision", &[board]);
        after("</link>\n<joint", &format!("{both}</link>\n<joint"))
    };
    assert_eq!(knob(-20.2), [""; 0]);
    assert_eq!(knob(-30.0), ["G4"]);
}

#[test]
fn mass_must_fit_the_shape() {
    let mass = "<mass value=\"4\"/>";
    assert_eq!(after(mass, "<mass value=\"0\"/>"), ["M1", "M2", "M4", "M6"]);
    assert_eq!(after(mass, "<mass value=\"0.05\"/>"), ["M2", "M4"]);
    let tray = inertial(4.0, "0 -0.01 0.12", [0.08, 0.12, 0.16]);
    let with = |centre: &str, moments| after(&tray, &inertial(4.0, centre, moments));
    assert_eq!(with("0 -0.01 0.12", [0.5, 0.5, 0.5]), [""; 0]);
    assert_eq!(with("0 -0.01 0.12", [2.0, 2.0, 2.0]), ["M4"]);
    assert_eq!(with("0 -0.01 0.12", [0.08, 0.12, 0.21]), ["M3"]);
    assert_eq!(with("0 -0.01 0.32", [0.08, 0.12, 0.16]), ["M5"]);
    assert_eq!(after(&tray, ""), ["M1", "M2", "M3", "M4", "M5", "M6"]);
}

#[test]
fn joints_must_fit_their_parts() {
    let limit = "upper=\"0.3\" effort=\"50\"";
    assert_eq!(after(limit, "upper=\"0.6\" effort=\"50\""), ["J3"]);
    assert_eq!(after(limit, "upper=\"0.3\" effort=\"0\""), ["J4"]);
    assert_eq!(after(limit, "upper=\"0.3\""), ["J4"]);
    assert_eq!(after("xyz=\"0 -1 0\"", "xyz=\"0 -2 0\""), ["J1"]);
    assert_eq!(after("xyz=\"0 -1 0\"", "xyz=\"0 -0.8 0.6\""), ["J6"]);
    assert_eq!(after("<dynamics damping=\"1\" friction=\"5\"/>", ""), ["J4"]);
    let away = "<child link=\"tray\"/><origin xyz=\"0 -3 0\"/>";
    assert_eq!(after("<child link=\"tray\"/>", away), ["G4", "J5"]);
}

#[test]
fn a_hinge_may_have_its_origin_anywhere_on_its_axis() {
    let hinge = |origin: &str| {
        let turn = format!("<child link=\"tray\"/><origin xyz=\"{origin}\"/>");
        let text = cabinet().replace("<child link=\"tray\"/>", &turn);
        let text = text.replace("prismatic", "revolute").replace("0 -1 0", "0 0 1");
        let is_joint = |id: &String| id == "J5";
        broken(&text).into_iter().filter(is_joint).count()
    };
    assert_eq!(hinge("0 0 0"), 0);
    let shifted = cabinet().replace("prismatic", "revolute").replace("0 -1 0", "0 0 1");
    assert_eq!(broken(&shifted), [""; 0]);
    assert_eq!(hinge("3 0 0"), 1);
}

/// A frame of four boards that turns about a duct of four, both hollow, about y.
#[test]
fn a_ring_turns_about_its_own_middle_where_there_is_nothing() {
    let boards = |r: f64, long: f64| {
        let side = |x: f64, z: f64, w: f64, h: f64| [x, 0.0, z, w, long, h];
        let ends = [-r, r].map(|z| side(0.0, z, 2.0 * r - 2.0, 2.0));
        [-r, r]
            .map(|x| side(x, 0.0, 2.0, 2.0 * r + 2.0))
            .into_iter()
            .chain(ends)
            .collect::<Vec<_>>()
    };
    let link = |name: &str, boards: &[[f64; 6]]| {
        let (seen, touched) = (shapes("visual", boards), shapes("collision", boards));
        format!("<link name=\"{name}\">\n{seen}{touched}</link>\n")
    };
    let (duct, frame) = (link("duct", &boards(20.0, 60.0)), link("frame", &boards(30.0, 5.0)));
    let bent = link("frame", &boards(30.0, 5.0).into_iter().skip(1).take(2).collect::<Vec<_>>());
    let turned_about = |frame: &str, x: f64| {
        let joint = format!(
            "<joint name=\"turn\" type=\"continuous\"><parent link=\"duct\"/>\
            <child link=\"frame\"/><origin xyz=\"{x} 0 0\"/><axis xyz=\"0 1 0\"/></joint>\n"
        );
        let found = broken(&format!("<robot name=\"r\">\n{duct}{frame}{joint}</robot>\n"));
        found.iter().any(|id| id == "J5")
    };
    assert!(!turned_about(&frame, 0.0));
    assert!(turned_about(&frame, 0.6), "the duct is elsewhere");
    assert!(turned_about(&bent, 0.0), "two boards do not go round");
}

#[test]
fn scale_size_and_place_are_told() {
    let lifted = cabinet()
        .replace("0.01\"/><geometry><box size=\"0.5 ", "0.01\"/><geometry><box size=\"50 ");
    assert!(broken(&lifted).contains(&"U2".to_owned()));
    let raised: String = shapes("visual", &CABINET[..1]);
    let below = shapes("visual", &[[0.0, 0.0, -1.0, 50.0, 40.0, 2.0]]);
    assert!(after(&raised, &below).contains(&"U3".to_owned()));
}

/// Writes meshes into a folder of this process and returns it.
fn folder(test: &str, meshes: &[(&str, &Mesh)]) -> PathBuf {
    let name = format!("kinfold-lint-{}-{test}", std::process::id());
    let folder = std::env::temp_dir().join(name);
    std::fs::create_dir_all(&folder).unwrap();
    for (name, mesh) in meshes {
        std::fs::write(folder.join(name), object::obj::write(mesh, ObjNormals::None)).unwrap();
    }
    folder
}

fn with_mesh(test: &str, seen: &Mesh, touched: &Mesh) -> Vec<String> {
    let folder = folder(test, &[("seen.obj", seen), ("touched.obj", touched)]);
    let mesh = |tag: &str, file: &str| {
        format!("<{tag}><geometry><mesh filename=\"{file}\"/></geometry></{tag}>")
    };
    let text = format!(
        "<robot name=\"r\"><link name=\"a\">{}{}</link></robot>",
        mesh("visual", "seen.obj"),
        mesh("collision", "touched.obj")
    );
    let found = all(&text, &folder);
    std::fs::remove_dir_all(&folder).unwrap();
    found.into_iter().filter(|c| !c.holds() && c.id.starts_with('G')).map(|c| c.id).collect()
}

fn cuboid(w: f64, d: f64, h: f64) -> Mesh {
    tessellated(&Geometry::Box { size: DVec3::new(w, d, h) }).unwrap()
}

fn inside_out(mesh: &Mesh) -> Mesh {
    let faces = mesh.faces().iter().map(|&[a, b, c]| [a, c, b]).collect();
    Mesh::new(mesh.vertices().to_vec(), faces).unwrap()
}

#[test]
fn a_cavity_may_face_inward_and_a_solid_may_not() {
    let (outer, inner) = (cuboid(1.0, 1.0, 1.0), inside_out(&cuboid(0.9, 0.9, 0.9)));
    let at = |m, x| (m, DPose3::translation(x, 0.0, 0.0));
    let hollow = merged([at(&outer, 0.0), at(&inner, 0.0)].into_iter()).unwrap();
    assert_eq!(with_mesh("hollow", &hollow, &outer), ["G3"], "the hull fills the hollow");
    let beside = merged([at(&outer, 0.0), at(&inner, 0.96)].into_iter()).unwrap();
    assert!(with_mesh("beside", &beside, &outer).contains(&"G1".to_owned()));
}

#[test]
fn a_collision_piece_is_convex_closed_thick_and_simple() {
    let whole = cuboid(1.0, 1.0, 1.0);
    assert_eq!(with_mesh("whole", &whole, &whole), [""; 0]);
    let at = |m, x, y| (m, DPose3::translation(x, y, 0.0));
    let arm = cuboid(0.5, 0.2, 0.2);
    let corner = merged([at(&arm, 0.0, 0.0), at(&arm, 0.35, 0.35)].into_iter()).unwrap();
    assert!(with_mesh("corner", &corner, &corner).contains(&"G2".to_owned()));
    let sheet = cuboid(1.0, 1.0, 0.0005);
    assert_eq!(with_mesh("sheet", &sheet, &sheet), ["G2"]);
    assert_eq!(with_mesh("turned", &whole, &inside_out(&whole)), ["G2"]);
    let ball = tessellated(&Geometry::Sphere { radius: 0.5 }).unwrap();
    assert_eq!(with_mesh("ball", &ball, &ball), ["G2"], "too many vertices");
}
