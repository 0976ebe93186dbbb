//! Joints as written and as they sit on their parts (J1–J6; J7 needs motion).

use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, TAU};

use glamx::{DMat3, DVec3};
use object::Mesh;
use object::mesh::Bounds;

use super::finding::{Finding, judged, mm, unread};
use super::part::{Part, Parts};
use crate::profile::bounds::{AXIS, PARALLEL, PIVOT, SLIDE, TURN};
use crate::profile::subject::Subject;
use crate::profile::words::percent;
use crate::read::rest::{REST, range_fault};
use crate::robot::{Format, Joint, Limit, Motion, Robot};
use crate::verdict::{Check, Status, figure};

/// A full turn, with what four decimals may add.
const TURNED: f64 = TURN + 1e-3;

/// How much of a whole turn limits may leave out that were rounded, radians.
const TURNED_NEARLY: f64 = 1e-2;

/// J1, J2 and J4: what the numbers alone tell.
pub(super) fn numbers(robot: &Robot, subject: Subject) -> Vec<Check> {
    vec![axes(robot), limits(robot, subject), drives(robot)]
}

/// How far a follower may be taken beyond its own range, as a share of that: rounded factors do.
const FOLLOWED: f64 = 0.01;

/// What goes round an axis leaves no wider gap, radians: three corners of a square's four do not.
const ROUND: f64 = 1.75;

/// J3, J5 and J6: what the numbers mean for the parts.
pub(super) fn geometry(parts: &Parts) -> Vec<Check> {
    vec![ranges(parts), pivots(parts), directions(parts)]
}

fn with_axis(robot: &Robot) -> impl Iterator<Item = &Joint> {
    robot.joints.iter().filter(|j| j.kind.has_axis())
}

fn told(joint: &Joint, words: String) -> String {
    format!("line {}: joint `{}`: {words}", joint.line, joint.name)
}

fn axes(robot: &Robot) -> Check {
    let needs = robot.joints.iter().filter(|j| j.kind.has_axis() || j.kind == Motion::Planar);
    let finding = |joint: &Joint| {
        let length = joint.axis_as_written.length();
        let off = (length - 1.0).abs();
        let words = format!("axis {} has length {}", joint.axis_as_written, figure(length));
        Finding { severity: off / AXIS, value: length, unit: "long", words: told(joint, words) }
    };
    judged("J1", needs.map(finding).collect(), vec![])
}

/// What is wrong with a joint's limits, if anything.
pub(crate) fn limit_fault(joint: &Joint) -> Option<String> {
    if !matches!(joint.kind, Motion::Revolute | Motion::Prismatic) {
        return None;
    }
    if let Some(fault) = range_fault(joint) {
        return Some(fault);
    }
    let (lower, upper) = joint.limits_as_written()?;
    let range = format!("{} to {}", figure(lower), figure(upper));
    let holds_rest = lower <= REST && upper >= -REST;
    (!holds_rest).then(|| format!("limits {range} leave out the rest pose 0"))
}

fn limits(robot: &Robot, subject: Subject) -> Check {
    let declared = robot.beside.declared.as_ref();
    let moved = |j: &Joint| declared.is_some() && range_fault(j).is_none();
    let fault = |j: &Joint| limit_fault(j).filter(|_| !moved(j));
    // A robot is judged at a pose within its limits: that 0 is none is for its owner to know.
    let is_flag = |j: &Joint| subject == Subject::Robot && range_fault(j).is_none();
    let (flags, faults): (Vec<&Joint>, Vec<&Joint>) =
        with_axis(robot).filter(|j| fault(j).is_some()).partition(|j| is_flag(j));
    let words = |all: Vec<&Joint>| {
        all.into_iter().filter_map(|j| fault(j).map(|f| told(j, f))).collect::<Vec<_>>()
    };
    let all: Vec<String> = words(faults).into_iter().chain(followed(robot)).collect();
    let count = all.len() as f64;
    let check = Check::from_faults("J2", all).value(count);
    let flags: Vec<String> = words(flags).into_iter().chain(stiff(robot)).collect();
    let check = match declared {
        Some(name) => check.evidence(format!("judged at the pose that keyframe `{name}` declares")),
        None => check,
    };
    if check.status == Status::Pass && !flags.is_empty() {
        return Check { status: Status::Warn, ..check }.evidences(flags);
    }
    check
}

/// Joints that cannot move, or never end, and have a range: whoever gave them one meant them to keep it.
fn stiff(robot: &Robot) -> Vec<String> {
    let words = |joint: &Joint| {
        let (lower, upper) = joint.limits_as_written().filter(|(lower, upper)| lower < upper)?;
        let range = format!("a range of {} to {}", figure(lower), figure(upper));
        let words = match joint.kind {
            Motion::Fixed => format!("is fixed and has {range}: is it meant to move?"),
            // Of a whole turn nothing is left out.
            Motion::Continuous if upper - lower < TURN - TURNED_NEARLY => {
                format!("never ends and has {range}: is it meant to be revolute?")
            }
            _ => return None,
        };
        Some(told(joint, words))
    };
    robot.joints.iter().filter_map(words).collect()
}

/// Followers that their leader's range takes beyond their own.
fn followed(robot: &Robot) -> Vec<String> {
    let limited = |j: &Joint| matches!(j.kind, Motion::Revolute | Motion::Prismatic);
    let within = |j: &&Joint| limited(j) && range_fault(j).is_none();
    let mut faults = Vec::new();
    for joint in robot.joints.iter().filter(within) {
        let Some((mimic, own)) = joint.mimic.zip(joint.limit) else { continue };
        let leader = &robot.joints[mimic.joint];
        let Some(leads) = leader.limit.filter(|_| within(&leader)) else { continue };
        let ends = [leads.lower, leads.upper].map(|q| mimic.multiplier * q + mimic.offset);
        let (least, most) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
        let spare = FOLLOWED * (own.upper - own.lower) + REST;
        if least < own.lower - spare || most > own.upper + spare {
            let [from, to] = [least, most].map(|q| figure(q + joint.rest));
            let [lower, upper] = [own.lower, own.upper].map(|q| figure(q + joint.rest));
            let words = format!(
                "follows `{}` from {from} to {to}, beyond its own limits {lower} to {upper}",
                leader.name
            );
            faults.push(told(joint, words));
        }
    }
    faults
}

fn drives(robot: &Robot) -> Check {
    let (mut faults, mut flags) = (Vec::new(), Vec::new());
    for joint in with_axis(robot) {
        let effort = joint.limit.and_then(|l| l.effort);
        let velocity = joint.limit.and_then(|l| l.velocity);
        for (what, value) in [("effort", effort), ("velocity", velocity)] {
            match value {
                None if what == "velocity" && robot.format == Format::Mjcf => {
                    flags.push(told(joint, "MJCF has no word for its velocity".into()));
                }
                None if what == "velocity" && robot.format.may_be_passive() => {
                    flags.push(told(joint, "has no largest velocity".into()));
                }
                None if robot.format.may_be_passive() => {
                    flags.push(told(joint, "is passive, or its drive has no largest force".into()));
                }
                None => faults.push(told(joint, format!("has no {what}"))),
                Some(v) if v <= 0.0 => {
                    faults.push(told(joint, format!("{what} {} must be above 0", figure(v))));
                }
                Some(_) => {}
            }
        }
        let damping = joint.dynamics.and_then(|d| d.damping);
        let friction = joint.dynamics.and_then(|d| d.friction);
        for (what, value) in [("damping", damping), ("friction", friction)] {
            match value {
                None => flags.push(told(joint, format!("has no {what}"))),
                Some(v) if v < 0.0 => {
                    faults.push(told(joint, format!("{what} {} is negative", figure(v))));
                }
                Some(_) => {}
            }
        }
    }
    let count = faults.len() as f64;
    let check = Check::from_faults("J4", faults).value(count);
    if check.status == Status::Pass && !flags.is_empty() {
        return Check { status: Status::Warn, ..check }.evidences(flags);
    }
    check
}

fn ranges(parts: &Parts) -> Check {
    let mut unknown = Vec::new();
    let mut findings = Vec::new();
    for joint in with_axis(parts.robot) {
        let finding = match (joint.kind, joint.limit) {
            (Motion::Revolute, Some(limit)) => Some(turn(joint, limit)),
            (Motion::Prismatic, Some(limit)) => slide(parts, joint, limit),
            (Motion::Continuous, _) => continue,
            _ => None,
        };
        match finding {
            Some(finding) => findings.push(finding),
            None => unknown.push(told(joint, "has no range or no part to measure it by".into())),
        }
    }
    judged("J3", findings, unknown)
}

fn turn(joint: &Joint, limit: Limit) -> Finding {
    let span = limit.upper - limit.lower;
    let hint = if span > TURNED { "; degrees written as radians?" } else { "" };
    let words = format!("turns {} rad, {:.0} deg{hint}", figure(span), span.to_degrees());
    Finding { severity: span / TURNED, value: span, unit: "rad", words: told(joint, words) }
}

/// `None` if the part has no geometry to measure the slide by.
fn slide(parts: &Parts, joint: &Joint, limit: Limit) -> Option<Finding> {
    let span = limit.upper - limit.lower;
    let part = parts.with_geometry_below(joint.child)?;
    let extent = extent_of_body(parts, part, axis_in_root(parts, joint))?;
    let words = format!("slides {}, its part is {} long along it", mm(span), mm(extent));
    let value = span / extent;
    let words = told(joint, words);
    Some(Finding { severity: value / SLIDE, value, unit: "of the part", words })
}

fn axis_in_root(parts: &Parts, joint: &Joint) -> DVec3 {
    parts.poses[joint.parent].rotation * (joint.origin.rotation * joint.axis)
}

/// Extent of the rigid body a link belongs to along a direction, root frame.
fn extent_of_body(parts: &Parts, link: usize, direction: DVec3) -> Option<f64> {
    let body_of = parts.robot.body_of_link();
    let mine = (0..parts.parts.len()).filter(|&l| body_of[l] == body_of[link]);
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for l in mine {
        let local = parts.poses[l].rotation.inverse() * direction;
        let shift = direction.dot(parts.poses[l].translation);
        for p in parts.parts[l].points() {
            let reach = local.dot(p) + shift;
            (low, high) = (low.min(reach), high.max(reach));
        }
    }
    (high > low).then_some(high - low)
}

/// J5. An axis of turning is a line, so its pivot counts wherever it comes nearest to both parts;
/// a slide has no pivot, so the gap between its parts counts.
fn pivots(parts: &Parts) -> Check {
    let bound = PIVOT * parts.diagonal;
    let (mut findings, mut unknown) = (Vec::new(), unread(parts));
    for joint in with_axis(parts.robot) {
        let above = parts.with_geometry_above(joint.parent);
        let below = parts.with_geometry_below(joint.child);
        let (Some(above), Some(below)) = (above, below) else {
            unknown.push(told(joint, "has no geometry on one side".into()));
            continue;
        };
        // What was not read may be where the pivot is.
        if parts.parts[above].unread().or(parts.parts[below].unread()).is_some() {
            continue;
        }
        let value = if joint.kind.turns() {
            pivot_distance(parts, joint, (above, below), bound)
        } else {
            gap_between(parts, above, below)
        };
        let what = if joint.kind.turns() { "its axis passes" } else { "its parts are" };
        let words = told(joint, format!("{what} {} apart from its parts at rest", mm(value)));
        findings.push(Finding { severity: value / bound, value, unit: "m", words });
    }
    judged("J5", findings, unknown).threshold(format!(
        "<= {} ({} of the diagonal)",
        mm(bound),
        percent(PIVOT)
    ))
}

/// The larger of the distances from the pivot to both links, taken where on the axis it is least;
/// the pivot as written counts if it is within the bound. A ring around a tube turns about its own
/// middle, where neither has anything: that counts as its place, and the tube's box as the tube.
fn pivot_distance(parts: &Parts, joint: &Joint, links: (usize, usize), bound: f64) -> f64 {
    let pivot = parts.poses[joint.parent].transform_point(joint.origin.translation);
    let at = |p: DVec3| {
        let from = |l: usize| parts.parts[l].distance(parts.poses[l].inverse_transform_point(p));
        from(links.0).max(from(links.1))
    };
    let written = at(pivot);
    if written <= bound {
        return written;
    }
    let axis = axis_in_root(parts, joint);
    let middle = pivot + axis * axis.dot(parts.bounds.centre() - pivot);
    let steps = (-40..=40).map(|i| middle + axis * (f64::from(i) / 40.0 * parts.diagonal));
    steps.map(at).fold(written, f64::min).min(ring_distance(parts, links, (pivot, axis)))
}

/// The larger of two distances, metres: from the axis to the middle of the link below, and from the
/// place where it passes there to the box of the link above. Infinite where the link below does not
/// go round the axis.
fn ring_distance(parts: &Parts, links: (usize, usize), (pivot, axis): (DVec3, DVec3)) -> f64 {
    let bounds = |l: usize| Bounds::of(parts.parts[l].points());
    let below = parts.poses[links.1];
    let middle = below.transform_point(bounds(links.1).centre());
    let place = pivot + axis * axis.dot(middle - pivot);
    let (u, v) = axis.any_orthonormal_pair();
    let spokes = parts.parts[links.1].points().map(|p| below.transform_point(p) - place);
    let mut angles: Vec<f64> = spokes.map(|s| s.dot(v).atan2(s.dot(u))).collect();
    angles.sort_by(f64::total_cmp);
    let next = angles.iter().skip(1).copied().chain(angles.first().map(|a| a + TAU));
    let open = angles.iter().zip(next).map(|(a, b)| b - a).fold(0.0, f64::max);
    if open > ROUND {
        return f64::INFINITY;
    }
    let (above, p) = (bounds(links.0), parts.poses[links.0].inverse_transform_point(place));
    place.distance(middle).max(p.distance(p.clamp(above.min, above.max)))
}

/// Smallest distance from points of one link to the surface of the other; 0 inside its pieces.
fn gap_between(parts: &Parts, above: usize, below: usize) -> f64 {
    let to_other = parts.poses[above].inverse() * parts.poses[below];
    let points: Vec<DVec3> = parts.parts[below].points().collect();
    let place = |p| to_other.transform_point(p);
    let one_way = nearest(&parts.parts[above], points, place, f64::INFINITY);
    let points: Vec<DVec3> = parts.parts[above].points().collect();
    nearest(&parts.parts[below], points, |p| to_other.inverse_transform_point(p), one_way)
}

fn nearest(part: &Part, points: Vec<DVec3>, place: impl Fn(DVec3) -> DVec3, at_most: f64) -> f64 {
    let every = points.len().div_ceil(500).max(1);
    let nearer = |least: f64, p: DVec3| match least > 0.0 {
        true => part.surface_distance(place(p), least),
        false => least,
    };
    points.into_iter().step_by(every).fold(at_most, nearer)
}

/// J6: edges and symmetry directions of either part.
fn directions(parts: &Parts) -> Check {
    let (mut findings, mut unknown) = (Vec::new(), Vec::new());
    let mut known: BTreeMap<usize, Option<Vec<DVec3>>> = BTreeMap::new();
    for joint in with_axis(parts.robot) {
        let sides =
            [parts.with_geometry_above(joint.parent), parts.with_geometry_below(joint.child)];
        let axis = axis_in_root(parts, joint);
        let of_side = |l: usize| {
            let local = parts.poses[l].rotation.inverse() * axis;
            let skin = parts.parts[l].skin.as_ref();
            let of_part = known.entry(l).or_insert_with(|| skin.map(|s| main_directions(&s.mesh)));
            of_part.as_ref().map(|of_part| smallest_angle(of_part, local))
        };
        let angle = sides.into_iter().flatten().filter_map(of_side).reduce(f64::min);
        let Some(angle) = angle else {
            unknown.push(told(joint, "has no visual geometry to compare with".into()));
            continue;
        };
        let value = angle.to_degrees();
        let words = format!("axis {axis:.3} is {value:.1} deg off every edge and symmetry");
        let words = told(joint, words);
        findings.push(Finding { severity: value / PARALLEL, value, unit: "deg", words });
    }
    judged("J6", findings, unknown)
}

/// Smallest angle between a direction and some lines, radians.
fn smallest_angle(lines: &[DVec3], direction: DVec3) -> f64 {
    let angle = |c: &DVec3| direction.dot(*c).abs().min(1.0).acos();
    lines.iter().map(angle).fold(FRAC_PI_2, f64::min)
}

/// The frame axes, the main normals, the edges where two of them meet, the principal directions.
fn main_directions(mesh: &Mesh) -> Vec<DVec3> {
    let mut directions = vec![DVec3::X, DVec3::Y, DVec3::Z];
    let normals = main_normals(mesh);
    for (i, a) in normals.iter().enumerate() {
        let edges = normals[..i].iter().filter_map(|b| a.cross(*b).try_normalize());
        directions.extend(edges);
    }
    directions.extend(normals);
    directions.extend(symmetry_axes(mesh));
    directions
}

/// Up to eight directions most of the area faces, either way round.
fn main_normals(mesh: &Mesh) -> Vec<DVec3> {
    let cell = |n: DVec3| {
        let n = if (n.z, n.y, n.x) < (0.0, 0.0, 0.0) { -n } else { n };
        // Rounded, half away from zero: `f64::round` is a call on processors without SSE4.1.
        (n * 16.0).to_array().map(|c| (c + 0.5f64.copysign(c)) as i32)
    };
    let mut cells: BTreeMap<[i32; 3], DVec3> = BTreeMap::new();
    for face in 0..mesh.faces().len() {
        let vector = mesh.area_vector(face);
        let key = cell(vector.normalize_or_zero());
        let sum = cells.entry(key).or_insert(DVec3::ZERO);
        *sum += if sum.dot(vector) < 0.0 { -vector } else { vector };
    }
    let mut sums: Vec<DVec3> = cells.into_values().collect();
    sums.sort_by(|a, b| b.length_squared().total_cmp(&a.length_squared()));
    sums.into_iter().take(8).filter_map(DVec3::try_normalize).collect()
}

/// Principal directions of the surface.
fn symmetry_axes(mesh: &Mesh) -> Vec<DVec3> {
    let (mut area, mut first) = (0.0, DVec3::ZERO);
    let faces = || (0..mesh.faces().len()).map(|f| (mesh.area(f), mesh.centroid(f)));
    for (a, c) in faces() {
        area += a;
        first += c * a;
    }
    let centre = first / f64::max(area, f64::MIN_POSITIVE);
    let mut spread = DMat3::ZERO;
    for (a, c) in faces() {
        let d = c - centre;
        spread += DMat3::from_cols(d * d.x, d * d.y, d * d.z) * a;
    }
    let eigen = glamx::DSymmetricEigen3::new(spread);
    let vectors = eigen.eigenvectors;
    [vectors.col(0), vectors.col(1), vectors.col(2)]
        .into_iter()
        .filter_map(DVec3::try_normalize)
        .collect()
}
