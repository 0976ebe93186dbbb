//! An articulated object as a page shows it: a link for every part, in a colour of its own.

use object::articulated::{ArticulatedObject, JointMotion, Range};
use object::{DPose3, DVec3, JointKind, Mesh};
use page::{Joint, Kind, Link, Scene};

/// Colours of parts, RGBA, in turn: a guess at ten that are told apart side by side.
const COLOURS: [[u8; 4]; 10] = [
    [158, 165, 176, 255],
    [222, 132, 82, 255],
    [92, 153, 204, 255],
    [124, 176, 104, 255],
    [204, 102, 119, 255],
    [221, 190, 92, 255],
    [136, 118, 190, 255],
    [85, 178, 170, 255],
    [201, 137, 181, 255],
    [145, 125, 96, 255],
];

/// What a page shows of an object. Each part hangs on its parent by its joints, one behind the other; links
/// of no surface stand between two.
pub(crate) fn scene(object: &ArticulatedObject, title: String) -> Scene {
    let tree = object.tree();
    let notes = vec!["Lengths are in the mesh's own unit; nothing was checked.".to_owned()];
    let mut scene = Scene { title, notes, ..Scene::default() };
    // Where each part's link stands, and which it is.
    let mut placed = vec![(0, DVec3::ZERO); tree.len()];
    for &part in tree.root_first() {
        let name = &tree.parts()[part].name;
        let (mut parent, mut at) = tree.parent(part).map_or((None, DVec3::ZERO), |p| {
            let (link, at) = placed[p];
            (Some(link), at)
        });
        let joints = object.joints(part);
        for (index, motion) in joints.iter().enumerate().take(joints.len().saturating_sub(1)) {
            let between = Link { name: format!("{name}_{index}"), ..Link::default() };
            parent = Some(hang(&mut scene, (parent, at), between, Some(motion)));
            at = motion.pivot;
        }
        let to = joints.last().map_or(at, |motion| motion.pivot);
        let link = Link { name: name.clone(), visual: visual(object, part, to), ..Link::default() };
        placed[part] = (hang(&mut scene, (parent, at), link, joints.last()), to);
    }
    scene
}

/// Adds a link below another that stands at a point of the object, and returns its place.
fn hang(
    scene: &mut Scene,
    (parent, at): (Option<usize>, DVec3),
    link: Link,
    motion: Option<&JointMotion>,
) -> usize {
    let child = scene.links.len();
    let name = link.name.clone();
    scene.links.push(link);
    let Some(parent) = parent else { return child };
    let kind = match motion.map(|m| m.kind) {
        None => Kind::Fixed,
        Some(JointKind::Revolute) => Kind::Revolute,
        Some(JointKind::Continuous) => Kind::Continuous,
        Some(JointKind::Prismatic) => Kind::Prismatic,
    };
    let range = motion.and_then(|m| match m.range {
        Range::Limits { lower, upper } => Some([lower, upper]),
        Range::Continuous => None,
    });
    let to = motion.map_or(at, |m| m.pivot);
    scene.joints.push(Joint {
        name,
        kind,
        parent,
        child,
        origin: DPose3::from_translation(to - at),
        axis: motion.map_or(DVec3::X, |m| m.axis),
        range,
        mimic: None,
        facts: vec![],
    });
    child
}

/// The surface of a part from a point; nothing where it cannot be drawn.
fn visual(object: &ArticulatedObject, part: usize, from: DVec3) -> Option<Mesh> {
    let mesh = object.mesh().submesh(object.faces_of(part)).ok()?;
    let mesh = mesh.map_vertices(|v| v - from).ok()?;
    let colour = COLOURS[part % COLOURS.len()];
    let count = mesh.vertices().len();
    mesh.with_colours(Some(vec![colour; count])).ok()
}
