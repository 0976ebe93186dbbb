//! Assets that are as they should be: drawers, doors, lids, knobs, chains, wheels.

use super::model::{Joint, Link, Model, Shape, Triple, obj, tray};

const X: Triple = [1.0, 0.0, 0.0];
const Y: Triple = [0.0, 1.0, 0.0];
const Z: Triple = [0.0, 0.0, 1.0];
const WOOD: f64 = 600.0;

fn negative(axis: Triple) -> Triple {
    axis.map(|c| -c)
}

fn block(size: Triple, centre: Triple) -> Shape {
    Shape::block(size, centre)
}

fn model(links: Vec<Link>, joints: Vec<Joint>) -> Model {
    Model { links, joints, ..Model::default() }
}

/// Every good asset by name.
pub fn all() -> Vec<(&'static str, Model)> {
    vec![
        ("cabinet", cabinet()),
        ("drawer", drawer()),
        ("chest", chest()),
        ("box_with_lid", box_with_lid()),
        ("sliding_door", sliding_door()),
        ("stove_knob", stove_knob()),
        ("folding_door", folding_door()),
        ("canister", canister()),
        ("cat_flap", cat_flap()),
        ("laptop", laptop()),
        ("button", button()),
        ("tap", tap()),
        ("cart", cart()),
        ("oven", oven()),
        ("two_flaps", two_flaps()),
        ("corner_unit", corner_unit()),
        ("cabinet_meshes", cabinet().in_meshes()),
        ("drawer_meshes", drawer().in_meshes()),
        ("lid_meshes", box_with_lid().in_meshes()),
        ("knob_meshes", stove_knob().in_meshes()),
        ("cart_meshes", cart().in_meshes()),
        ("tray_drawer", tray_drawer()),
    ]
}

/// A block with a door before it.
pub fn cabinet() -> Model {
    let body = Link::solid("body", 100.0, &[block([0.5, 0.4, 0.6], [0.0, 0.0, 0.3])]);
    let door = Link::solid("door", WOOD, &[block([0.5, 0.02, 0.6], [0.25, -0.01, 0.3])]);
    let place = [[-0.25, -0.203, 0.0], negative(Z)];
    let hinge = Joint::hinge("hinge", ["body", "door"], place, [0.0, 1.57]);
    model(vec![body, door], vec![hinge])
}

/// Five panels around an opening towards −y.
fn carcass(size: Triple, wall: f64) -> Vec<Shape> {
    let [x, y, z] = size;
    let inner = z - 2.0 * wall;
    let side = |at: f64| block([wall, y, inner], [at, 0.0, z / 2.0]);
    vec![
        block([x, y, wall], [0.0, 0.0, wall / 2.0]),
        block([x, y, wall], [0.0, 0.0, z - wall / 2.0]),
        side(-x / 2.0 + wall / 2.0),
        side(x / 2.0 - wall / 2.0),
        block([x - 2.0 * wall, wall, inner], [0.0, y / 2.0 - wall / 2.0, z / 2.0]),
    ]
}

/// Five panels open above, standing on z = 0.
fn open_box([x, y, z]: Triple, wall: f64) -> Vec<Shape> {
    let high = z - wall;
    let middle = wall + high / 2.0;
    let (across, along) = ((x - wall) / 2.0, (y - wall) / 2.0);
    vec![
        block([x, y, wall], [0.0, 0.0, wall / 2.0]),
        block([wall, y, high], [-across, 0.0, middle]),
        block([wall, y, high], [across, 0.0, middle]),
        block([x - 2.0 * wall, wall, high], [0.0, -along, middle]),
        block([x - 2.0 * wall, wall, high], [0.0, along, middle]),
    ]
}

/// A tray in a carcass.
pub fn drawer() -> Model {
    let body = Link::solid("body", WOOD, &carcass([0.4, 0.5, 0.3], 0.02));
    let tray = Link::solid("tray", WOOD, &open_box([0.35, 0.46, 0.2], 0.01));
    let place = [[0.0, -0.02, 0.023], negative(Y)];
    let slide = Joint::slide("slide", ["body", "tray"], place, [0.0, 0.25]);
    model(vec![body, tray], vec![slide])
}

/// The drawer, its tray seen as one hollow surface.
pub fn tray_drawer() -> Model {
    let mut drawer = drawer();
    let (vertices, faces) = tray([0.35, 0.46, 0.2], 0.01);
    drawer.files.insert("meshes/tray.obj".into(), obj(&vertices, &faces, 1));
    let seen = Shape { centre: [0.0, 0.0, 0.1], ..Shape::mesh("meshes/tray.obj") };
    drawer.link("tray").visuals = vec![seen];
    drawer
}

/// Two drawers, one above the other.
pub fn chest() -> Model {
    let mut panels = carcass([0.4, 0.5, 0.5], 0.02);
    panels.push(block([0.36, 0.48, 0.02], [0.0, -0.01, 0.25]));
    let body = Link::solid("body", WOOD, &panels);
    let tray = |name| Link::solid(name, WOOD, &open_box([0.35, 0.46, 0.2], 0.01));
    let slide = |name, tray, z| {
        Joint::slide(name, ["body", tray], [[0.0, -0.02, z], negative(Y)], [0.0, 0.25])
    };
    let joints = vec![slide("low_slide", "low", 0.023), slide("high_slide", "high", 0.263)];
    model(vec![body, tray("low"), tray("high")], joints)
}

/// A box with a lid that lies on it.
pub fn box_with_lid() -> Model {
    let body = Link::solid("body", WOOD, &open_box([0.6, 0.4, 0.3], 0.02));
    let lid = Link::solid("lid", WOOD, &[block([0.6, 0.4, 0.02], [0.0, -0.2, 0.01])]);
    let place = [[0.0, 0.2, 0.301], negative(X)];
    let hinge = Joint::hinge("hinge", ["body", "lid"], place, [0.0, 1.5]);
    model(vec![body, lid], vec![hinge])
}

/// A door that slides across the front of a cupboard.
pub fn sliding_door() -> Model {
    let body = Link::solid("body", 100.0, &[block([0.6, 0.3, 0.5], [0.0, 0.0, 0.25])]);
    let door = Link::solid("door", WOOD, &[block([0.3, 0.02, 0.46], [0.0, 0.0, 0.23])]);
    let place = [[-0.15, -0.162, 0.02], X];
    let slide = Joint::slide("slide", ["body", "door"], place, [0.0, 0.29]);
    model(vec![body, door], vec![slide])
}

/// A knob on the front of a stove, which turns without end.
pub fn stove_knob() -> Model {
    let body = Link::solid("body", 200.0, &[block([0.5, 0.5, 0.2], [0.0, 0.0, 0.1])]);
    let pointer = block([0.008, 0.01, 0.06], [0.0, -0.035, 0.02]);
    let knob =
        Link::solid("knob", 1000.0, &[Shape::roller(0.025, 0.03, [0.0, -0.015, 0.0]), pointer]);
    let spin = Joint::spin("spin", ["body", "knob"], [[0.1, -0.251, 0.1], Y]);
    model(vec![body, knob], vec![spin])
}

/// Two leaves in a chain on a post.
pub fn folding_door() -> Model {
    let foot = block([0.8, 0.8, 0.03], [0.0, 0.0, 0.015]);
    let post = block([0.05, 0.05, 0.77], [0.0, 0.0, 0.415]);
    let body = Link::solid("body", 2000.0, &[foot, post]);
    let leaf = Link::solid("leaf", WOOD, &[block([0.3, 0.02, 0.7], [0.15, 0.01, 0.35])]);
    let end = Link::solid("end", WOOD, &[block([0.28, 0.02, 0.7], [0.14, -0.01, 0.35])]);
    let first = [[0.027, -0.01, 0.04], negative(Z)];
    let second = [[0.302, 0.02, 0.0], Z];
    let joints = vec![
        Joint::hinge("first", ["body", "leaf"], first, [0.0, 1.5]),
        Joint::hinge("second", ["leaf", "end"], second, [0.0, 1.5]),
    ];
    model(vec![body, leaf, end], joints)
}

/// A cap that lifts off its neck and turns, with a carrier between.
pub fn canister() -> Model {
    let neck = Shape::post(0.015, 0.04, [0.0, 0.0, 0.22]);
    let body = Link::solid("body", 800.0, &[block([0.1, 0.1, 0.2], [0.0, 0.0, 0.1]), neck]);
    let wall = |x: f64, y: f64, cx: f64, cy: f64| block([x, y, 0.04], [cx, cy, 0.02]);
    let cap = Link::solid(
        "cap",
        1000.0,
        &[
            wall(0.004, 0.044, -0.02, 0.0),
            wall(0.004, 0.044, 0.02, 0.0),
            wall(0.036, 0.004, 0.0, -0.02),
            wall(0.036, 0.004, 0.0, 0.02),
            block([0.044, 0.044, 0.004], [0.0, 0.0, 0.042]),
        ],
    );
    let mut carrier =
        Link::solid("carrier", 1000.0, &[block([0.02, 0.02, 0.01], [0.0, 0.0, 0.02])]);
    (carrier.visuals, carrier.collisions) = (vec![], vec![]);
    let joints = vec![
        Joint::slide("lift", ["body", "carrier"], [[0.0, 0.0, 0.201], Z], [0.0, 0.02]),
        Joint::spin("turn", ["carrier", "cap"], [[0.0; 3], Z]),
    ];
    model(vec![body, carrier, cap], joints)
}

/// A flap that hangs in a frame and swings both ways.
pub fn cat_flap() -> Model {
    let upright = |x: f64| block([0.04, 0.04, 0.32], [x, 0.0, 0.2]);
    let frame = [
        block([0.4, 0.3, 0.04], [0.0, 0.0, 0.02]),
        upright(-0.18),
        upright(0.18),
        block([0.4, 0.04, 0.04], [0.0, 0.0, 0.38]),
    ];
    let body = Link::solid("body", WOOD, &frame);
    let flap = Link::solid("flap", 1000.0, &[block([0.31, 0.01, 0.28], [0.0, 0.0, -0.14])]);
    let swing = Joint::hinge("swing", ["body", "flap"], [[0.0, 0.0, 0.354], X], [-1.2, 1.2]);
    model(vec![body, flap], vec![swing])
}

/// Two slabs with a hinge at the back.
pub fn laptop() -> Model {
    let body = Link::solid("body", 1500.0, &[block([0.3, 0.2, 0.02], [0.0, 0.0, 0.01])]);
    let screen = Link::solid("screen", 1500.0, &[block([0.3, 0.2, 0.01], [0.0, -0.1, 0.005])]);
    let place = [[0.0, 0.1, 0.021], negative(X)];
    let hinge = Joint::hinge("hinge", ["body", "screen"], place, [0.0, 2.2]);
    model(vec![body, screen], vec![hinge])
}

/// A push button in a hole.
pub fn button() -> Model {
    let front = |x: f64, z: f64, cx: f64, cz: f64| block([x, 0.04, z], [cx, -0.03, cz]);
    let body = Link::solid(
        "body",
        WOOD,
        &[
            block([0.2, 0.06, 0.1], [0.0, 0.02, 0.05]),
            front(0.08, 0.1, -0.06, 0.05),
            front(0.08, 0.1, 0.06, 0.05),
            front(0.04, 0.03, 0.0, 0.015),
            front(0.04, 0.03, 0.0, 0.085),
        ],
    );
    let key = Link::solid("key", 1000.0, &[block([0.034, 0.03, 0.034], [0.0, 0.0, 0.0])]);
    let press = Joint::slide("press", ["body", "key"], [[0.0, -0.045, 0.05], Y], [0.0, 0.01]);
    model(vec![body, key], vec![press])
}

/// A lever on top of a block.
pub fn tap() -> Model {
    let body = Link::solid("body", 2000.0, &[block([0.1, 0.1, 0.1], [0.0, 0.0, 0.05])]);
    let lever =
        [block([0.03, 0.03, 0.02], [0.0, 0.0, 0.01]), block([0.1, 0.02, 0.01], [0.0, 0.0, 0.025])];
    let lever = Link::solid("lever", 2000.0, &lever);
    let turn = Joint::hinge("turn", ["body", "lever"], [[0.0, 0.0, 0.101], Z], [-0.8, 0.8]);
    model(vec![body, lever], vec![turn])
}

/// A platform on four wheels.
pub fn cart() -> Model {
    let body = Link::solid("body", WOOD, &[block([0.5, 0.3, 0.05], [0.0, 0.0, 0.085])]);
    let names = ["front_left", "front_right", "rear_left", "rear_right"];
    let mut cart = model(vec![body], vec![]);
    for (i, name) in names.into_iter().enumerate() {
        let x = if i < 2 { 0.18 } else { -0.18 };
        let y = if i % 2 == 0 { 0.17 } else { -0.17 };
        cart.links.push(Link::solid(name, 1000.0, &[Shape::roller(0.05, 0.03, [0.0; 3])]));
        let spin = Joint::spin(&format!("{name}_spin"), ["body", name], [[x, y, 0.05], Y]);
        cart.joints.push(spin);
    }
    cart
}

/// A door that opens downwards and is held by friction.
pub fn oven() -> Model {
    let body = Link::solid("body", 150.0, &[block([0.5, 0.5, 0.5], [0.0, 0.0, 0.25])]);
    let door = Link::solid("door", WOOD, &[block([0.48, 0.02, 0.4], [0.0, -0.01, 0.2])]);
    let place = [[0.0, -0.252, 0.05], X];
    let mut hinge = Joint::hinge("hinge", ["body", "door"], place, [0.0, 1.5]);
    hinge.friction = 0.5;
    model(vec![body, door], vec![hinge])
}

/// Two flaps on the front of a block whose hinges stand far apart.
pub fn two_flaps() -> Model {
    let body = Link::solid("body", 100.0, &[block([0.6, 0.3, 0.3], [0.0, 0.0, 0.15])]);
    let left = Link::solid("left", WOOD, &[block([0.2, 0.02, 0.26], [0.1, -0.01, 0.13])]);
    let right = Link::solid("right", WOOD, &[block([0.2, 0.02, 0.26], [-0.1, -0.01, 0.13])]);
    let place = |x: f64, axis: Triple| [[x, -0.152, 0.02], axis];
    let joints = vec![
        Joint::hinge("left_hinge", ["body", "left"], place(-0.28, negative(Z)), [0.0, 1.5]),
        Joint::hinge("right_hinge", ["body", "right"], place(0.28, Z), [0.0, 1.5]),
    ];
    model(vec![body, left, right], joints)
}

/// Two slabs that slide out of the arms of a corner, past each other.
pub fn corner_unit() -> Model {
    let plate = |x: f64, y: f64, at: [f64; 2], z: f64| block([x, y, 0.1], [at[0], at[1], z]);
    let arms =
        [0.05, 0.25].map(|z| [plate(1.0, 0.3, [0.0, 0.15], z), plate(0.3, 0.6, [0.35, -0.3], z)]);
    let mut shapes = arms.concat();
    shapes.push(block([1.0, 0.02, 0.1], [0.0, 0.29, 0.15]));
    let body = Link::solid("body", 300.0, &shapes);
    let back = Link::solid("back", WOOD, &[block([0.3, 0.26, 0.094], [0.0; 3])]);
    let side = Link::solid("side", WOOD, &[block([0.28, 0.3, 0.094], [0.0; 3])]);
    let joints = vec![
        Joint::slide("back_slide", ["body", "back"], [[0.0, 0.135, 0.15], negative(Y)], [0.0, 0.2]),
        Joint::slide("side_slide", ["body", "side"], [[0.35, -0.4, 0.15], negative(X)], [0.0, 0.2]),
    ];
    model(vec![body, back, side], joints)
}
