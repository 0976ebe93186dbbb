//! Pivots apart from their parts: J5. The pivot goes to an edge of the part that hangs on it; what
//! hangs there is told anew, so that nothing moves at rest.

use glamx::{DPose3, DVec3};
use object::mesh::Bounds;
use sim_check::geometry::tessellate::tessellated;
use sim_check::profile::bounds::PIVOT;
use sim_check::read::source::{At, Edit};
use sim_check::robot::{Joint, Link};

use super::numbers::triple;
use super::offer::{Change, Offer, State, names};
use super::remedies::Way;

/// An offer for each joint that is named in the findings.
pub(super) fn offers(state: &State, findings: &[(&str, &str)]) -> Vec<Offer> {
    let named = names(findings, "joint");
    let joints = state.robot.joints.iter().filter(|j| named.contains(&j.name.as_str()));
    let turning = joints.filter(|j| j.kind.turns());
    let offer = |joint: &Joint| Offer {
        way: Way::Pivot,
        subject: format!("joint `{}`", joint.name),
        line: joint.line,
        changes: changes(state, joint),
    };
    turning.map(offer).collect()
}

/// Points of everything that a link shows and touches, told in a frame.
fn points(link: &Link, at: DPose3) -> Vec<DVec3> {
    let shapes = link.visuals.iter().chain(&link.collisions);
    let of = |shape: &sim_check::robot::Shape| {
        let place = at * shape.origin;
        let mesh = tessellated(&shape.geometry).ok();
        mesh.map_or(vec![], |m| m.vertices().iter().map(|p| place.transform_point(*p)).collect())
    };
    shapes.flat_map(of).collect()
}

fn changes(state: &State, joint: &Joint) -> Result<Vec<Change>, String> {
    let robot = &state.robot;
    if joint.rest != 0.0 || joint.axis == DVec3::ZERO {
        return Err("it cannot be told from where it stands at rest".into());
    }
    // All in the joint's frame, which is the child's at rest.
    let below = points(&robot.links[joint.child], DPose3::identity());
    let above = points(&robot.links[joint.parent], joint.origin.inverse());
    if below.is_empty() || above.is_empty() {
        return Err("one of its links has no geometry of its own".into());
    }
    let (above, bound) = (Bounds::of(above), PIVOT * state.diagonal());
    let mut found: Vec<(f64, DVec3)> = lines(&below, joint.axis)
        .into_iter()
        .map(|place| {
            let flat = place - joint.axis * joint.axis.dot(place);
            (place.distance(place.clamp(above.min, above.max)), flat)
        })
        .filter(|(apart, _)| *apart <= bound)
        .collect();
    if found.is_empty() {
        return Err("its parts are apart themselves: one of them is in the wrong place".into());
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.length().total_cmp(&b.1.length())));
    let all = found.into_iter().map(|(_, by)| moved(state, joint, by));
    all.collect()
}

/// A point in the middle of each edge of a part's box that runs along an axis, and of the box.
fn lines(points: &[DVec3], axis: DVec3) -> Vec<DVec3> {
    let bounds = Bounds::of(points.iter().copied());
    let main = axis.abs();
    let along = (0..3).fold(0, |most, k| if main[k] > main[most] { k } else { most });
    // Boxes stand along the frame's axes; of an axis that does not, the nearest edges count.
    let [u, v] = [(along + 1) % 3, (along + 2) % 3];
    let mut all = Vec::new();
    for (a, b) in [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0), (0.5, 0.5)] {
        let mut place = bounds.centre();
        place[u] = bounds.min[u] + a * bounds.size()[u];
        place[v] = bounds.min[v] + b * bounds.size()[v];
        all.push(place);
    }
    all
}

/// A joint moved by so much in its own frame, and what hangs on it moved back.
fn moved(state: &State, joint: &Joint, by: DVec3) -> Result<Change, String> {
    let (robot, source) = (&state.robot, &state.source);
    let at = state.element("joint", &joint.name, joint.line)?;
    let words = format!("pivot moved by {} m, to an edge of its part", triple(by));
    if !state.is_urdf() {
        let old: Vec<f64> = source
            .get(at, "pos")
            .map_or(vec![0.0; 3], |t| t.split_whitespace().map_while(|w| w.parse().ok()).collect());
        let [x, y, z] = old[..] else { return Err("its place is not three numbers".into()) };
        let told = triple(DVec3::new(x, y, z) + by);
        return Ok(Change { words, edits: vec![source.set(at, "pos", &told)], files: vec![] });
    }
    let child = &robot.links[joint.child];
    let link = state.element("link", &child.name, child.line)?;
    let there = joint.origin.translation + joint.origin.rotation * by;
    let mut edits = vec![placed(state, at, there)];
    let inside = |tag: &str| source.children(link, tag);
    let shapes = [("visual", &child.visuals), ("collision", &child.collisions)];
    for (tag, shapes) in shapes {
        let elements = inside(tag);
        if elements.len() != shapes.len() {
            return Err(state.elsewhere("link", child.line));
        }
        let all = elements.iter().zip(shapes);
        edits.extend(all.map(|(e, s)| placed(state, *e, s.origin.translation - by)));
    }
    if let (Some(inertial), [element]) = (child.inertial, &inside("inertial")[..]) {
        edits.push(placed(state, *element, inertial.origin.translation - by));
    }
    for next in robot.joints.iter().filter(|j| j.parent == joint.child) {
        if next.rest != 0.0 {
            return Err("a joint below it is not told from where it stands at rest".into());
        }
        let element = state.element("joint", &next.name, next.line)?;
        edits.push(placed(state, element, next.origin.translation - by));
    }
    Ok(Change { words, edits, files: vec![] })
}

/// An element whose `<origin>` is told anew.
fn placed(state: &State, at: At, place: DVec3) -> Edit {
    let source = &state.source;
    match source.child(at, "origin") {
        Some(origin) => source.set(origin, "xyz", &triple(place)),
        None => source.insert_first(at, &format!("<origin xyz=\"{}\"/>", triple(place))),
    }
}
