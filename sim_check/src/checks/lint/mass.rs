//! Mass and inertia against the shape they belong to (M1–M6).

use std::panic::AssertUnwindSafe;

use glamx::{DMat3, DPose3, DVec3};
use parry3d_f64::query::gjk::{
    ConstantOrigin, CsoPoint, GJKResult, VoronoiSimplex, closest_points,
};
use parry3d_f64::shape::SupportMap;

use super::finding::{Finding, judged, mm, unread};
use super::part::{Part, Parts};
use super::surface::{Component, Topology};
use crate::checks::study::Study;
use crate::mass::inertia::{Moments, principal, principal_axes};
use crate::profile::bounds::{DENSITY, LIKELY, MOMENTS, OUTSIDE, RATIO, TRIANGLE};
use crate::profile::subject::Subject;
use crate::robot::{Inertial, Link, Robot};
use crate::verdict::{Check, Status, figure};

/// M1 to M6.
pub(super) fn checks(parts: &Parts) -> Vec<Check> {
    let solids: Vec<_> = parts.parts.iter().map(Solid::of).collect();
    vec![
        presence(parts),
        density(parts, &solids),
        triangle(parts),
        shape(parts, &solids),
        centre(parts),
        ratios(parts),
    ]
}

/// M1, M3 and M6: what needs no geometry.
pub(super) fn numbers(parts: &Parts) -> Vec<Check> {
    vec![presence(parts), triangle(parts), ratios(parts)]
}

/// A link's volume and moments.
struct Solid {
    solid: Moments,
    shell: Moments,
    method: &'static str,
}

impl Solid {
    /// Closed visuals as they are, unless most of them are mere sheets; else the collision pieces.
    fn of(part: &Part) -> Option<Self> {
        // What is not all there has no volume that means anything.
        if part.unread().is_some() {
            return None;
        }
        let area = |t: &Topology, of: fn(&Component) -> bool| -> f64 {
            t.components.iter().filter(|c| of(c)).map(|c| c.area).sum()
        };
        let encloses = |t: &Topology| {
            let sheets = area(t, Component::is_sheet);
            t.is_closed() && t.volume() > 0.0 && 2.0 * sheets < area(t, |_| true)
        };
        let closed = part.visuals.iter().all(|v| v.body.as_ref().is_ok_and(|b| encloses(&b.1)));
        let sum = |of: fn(&object::Mesh) -> Moments| {
            part.hulls().fold(Moments::none(), |sum, h| sum.plus(&of(&h.mesh)))
        };
        let skin = part.skin.as_ref().map(|s| &s.mesh);
        let pieces = sum(Moments::solid);
        match skin {
            Some(mesh) if closed => {
                let (solid, shell) = (Moments::solid(mesh), Moments::shell(mesh));
                Some(Self { solid, shell, method: "its closed surface" })
            }
            _ if pieces.measure <= 0.0 => None,
            Some(mesh) => {
                let shell = Moments::shell(mesh);
                Some(Self { solid: pieces, shell, method: "its collision pieces" })
            }
            None => {
                let shell = sum(Moments::shell);
                Some(Self { solid: pieces, shell, method: "its collision pieces" })
            }
        }
    }
}

/// The body that a link's shape fills, as M2 and M4 take it, link frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Filled {
    /// m³.
    pub volume: f64,
    /// Its centre, metres.
    pub centre: DVec3,
    /// Inertia about the centre for a mass of 1 kg, m².
    pub per_kilogram: DMat3,
}

/// What the shape of each link fills; `None` where that cannot be told.
pub fn filled(robot: &Robot) -> Vec<Option<Filled>> {
    let study = Study::new(robot);
    let of = |part: &Part| {
        let solid = Solid::of(part)?.solid;
        let (centre, per_kilogram) = solid.per_kilogram()?;
        Some(Filled { volume: solid.measure, centre, per_kilogram })
    };
    let made = || Parts::new(&study).parts.iter().map(of).collect();
    // A panic in a geometry library leaves nothing known.
    std::panic::catch_unwind(AssertUnwindSafe(made))
        .unwrap_or_else(|_| vec![None; robot.links.len()])
}

fn told(link: &Link, line: u32, words: String) -> String {
    format!("line {line}: link `{}`: {words}", link.name)
}

/// Whether the link moves and must have mass of its own: it is seen, touched, or carried by a joint.
fn needs_mass(parts: &Parts, link: usize) -> bool {
    let robot = parts.robot;
    let body = robot.body_of_link()[link];
    let under_joint = robot.joint_above(link).is_some_and(|j| robot.joints[j].kind.moves());
    let is_due = under_joint || parts.parts[link].has_geometry();
    let bare = robot.links[link].between || weighs_with_others(parts, link);
    body != robot.root() && is_due && !bare
}

/// Whether a link of a robot need not weigh or turn by itself, and does not: it is part of a body
/// that has mass in another link, or that stands fast. Frames of sensors, tools and feet, covers and
/// pedestals are written so.
fn weighs_with_others(parts: &Parts, link: usize) -> bool {
    let robot = parts.robot;
    let body_of = robot.body_of_link();
    let of = |l: usize| robot.links[l].inertial;
    let weighs = |l: usize| l != link && of(l).is_some_and(|i| i.mass > 0.0);
    let turns = |i: Inertial| i.inertia.to_cols_array().iter().any(|m| *m != 0.0);
    let stands = robot.beside.floats == Some(false) && body_of[link] == body_of[robot.root()];
    // The link that a joint carries and that is seen is the body itself.
    let is_minor = body_of[link] != link || !parts.parts[link].has_geometry();
    parts.subject == Subject::Robot
        && of(link).is_none_or(|i| i.mass == 0.0 || !turns(i))
        && (stands
            || is_minor && (0..robot.links.len()).any(|l| body_of[l] == body_of[link] && weighs(l)))
}

fn presence(parts: &Parts) -> Check {
    let links = parts.robot.links.iter().enumerate();
    let finding = |(l, link): (usize, &Link)| {
        let bad = |line, words: String| {
            let words = told(link, line, words);
            Some(Finding { severity: f64::INFINITY, value: 0.0, unit: "kg", words })
        };
        match link.inertial {
            None if needs_mass(parts, l) => bad(link.line, "moves but has no <inertial>".into()),
            Some(i) if i.mass == 0.0 && weighs_with_others(parts, l) => None,
            Some(i) if i.mass <= 0.0 => bad(i.line, format!("mass {} kg", figure(i.mass))),
            Some(i) => {
                let words = String::new();
                Some(Finding { severity: 0.0, value: i.mass, unit: "kg", words })
            }
            None => None,
        }
    };
    judged("M1", links.filter_map(finding).collect(), vec![])
}

/// Links with mass and geometry, and their solids; and those whose solid is unknown.
fn massive<'a>(
    parts: &'a Parts,
    solids: &'a [Option<Solid>],
) -> (Vec<(&'a Link, Inertial, &'a Solid)>, Vec<String>) {
    let (mut known, mut unknown) = (Vec::new(), unread(parts));
    for (l, (part, solid)) in parts.parts.iter().zip(solids).enumerate() {
        if weighs_with_others(parts, l) {
            continue;
        }
        match (part.link.inertial, solid) {
            (Some(inertial), Some(solid)) => known.push((part.link, inertial, solid)),
            (Some(_), None) if part.has_geometry() && part.unread().is_none() => {
                let name = &part.link.name;
                unknown.push(format!("link `{name}`: open surface and no collision piece"));
            }
            _ => {}
        }
    }
    (known, unknown)
}

fn density(parts: &Parts, solids: &[Option<Solid>]) -> Check {
    let (known, mut unknown) = massive(parts, solids);
    unknown.extend(without_inertial(parts));
    let mut flags = Vec::new();
    let finding = |(link, inertial, solid): (&Link, Inertial, &Solid)| {
        let density = inertial.mass / solid.solid.measure;
        let words = format!("{} kg/m³ of {}", figure(density), solid.method);
        let words = told(link, inertial.line, words);
        if !(LIKELY.0..=LIKELY.1).contains(&density) {
            flags.push(words.clone());
        }
        let severity = (DENSITY.0 / density.max(0.0)).max(density / DENSITY.1);
        Finding { severity, value: density, unit: "kg/m³", words }
    };
    let check = judged("M2", known.into_iter().map(finding).collect(), unknown);
    if check.status == Status::Pass && !flags.is_empty() {
        return Check { status: Status::Warn, ..check }.evidences(flags);
    }
    check
}

/// Moving links that have geometry but no inertia to judge.
fn without_inertial(parts: &Parts) -> Vec<String> {
    let lacks = |l: &usize| needs_mass(parts, *l) && parts.robot.links[*l].inertial.is_none();
    let lacking = (0..parts.parts.len()).filter(lacks);
    lacking.map(|l| format!("link `{}` has no <inertial>", parts.robot.links[l].name)).collect()
}

fn triangle(parts: &Parts) -> Check {
    let links = parts.robot.links.iter().enumerate();
    let due = links.filter(|(l, _)| !weighs_with_others(parts, *l));
    let links = due.filter_map(|(_, link)| Some((link, link.inertial?)));
    let finding = |(link, inertial): (&Link, Inertial)| {
        let m = principal(inertial.inertia);
        let value = m.z / (m.x + m.y);
        let words =
            format!("principal moments {}, {}, {} kg·m²", figure(m.x), figure(m.y), figure(m.z));
        let severity = if m.x > 0.0 { value / (1.0 + TRIANGLE) } else { f64::INFINITY };
        Finding { severity, value, unit: "of the sum", words: told(link, inertial.line, words) }
    };
    judged("M3", links.map(finding).collect(), without_inertial(parts))
}

fn shape(parts: &Parts, solids: &[Option<Solid>]) -> Check {
    let (known, mut unknown) = massive(parts, solids);
    unknown.extend(without_inertial(parts));
    let finding = |(link, inertial, solid): (&Link, Inertial, &Solid)| {
        let bodies = [solid.solid, solid.shell].map(|b| b.principal_per_kilogram());
        let bodies: Vec<DVec3> = bodies.into_iter().flatten().map(|b| b * inertial.mass).collect();
        let found = principal(inertial.inertia);
        let (low, high) = bodies
            .iter()
            .fold((DVec3::INFINITY, DVec3::ZERO), |(low, high), b| (low.min(*b), high.max(*b)));
        let over = (found / high).max_element();
        let under = (low / found.max(DVec3::ZERO)).max_element();
        let words = format!(
            "principal moments {} kg·m², its shape has {} to {}",
            triple(found),
            triple(low),
            triple(high)
        );
        let value = over.max(under);
        if let Some(turned) = turned(&inertial, solid, value) {
            let words = format!(
                "principal moments fit its shape, but not its axes: about one it has {} times those \
                 of its shape",
                figure(turned)
            );
            let words = told(link, inertial.line, words);
            return Finding { severity: turned / TURNED, value: turned, unit: "times", words };
        }
        let words = told(link, inertial.line, words);
        Finding { severity: value / MOMENTS, value, unit: "times", words }
    };
    judged("M4", known.into_iter().map(finding).collect(), unknown)
}

/// How many times a moment about some axis leaves those of the shape, where the sorted moments fit it
/// and the tensor does not: it was told in another frame than the link's. `None` where it fits, or
/// where the sorted moments do not fit either.
fn turned(inertial: &Inertial, solid: &Solid, sorted: f64) -> Option<f64> {
    let axes = DMat3::from_quat(inertial.origin.rotation);
    let found = axes * inertial.inertia * axes.transpose();
    let bodies: Vec<DMat3> = [solid.solid, solid.shell]
        .iter()
        .filter_map(|b| Some(b.per_kilogram()?.1 * inertial.mass))
        .collect();
    let mut own: Vec<DVec3> = vec![DVec3::X, DVec3::Y, DVec3::Z];
    for tensor in bodies.iter().chain(std::iter::once(&found)) {
        let (_, turn) = principal_axes(*tensor)?;
        own.extend([turn.col(0), turn.col(1), turn.col(2)]);
    }
    let about = |tensor: &DMat3, axis: DVec3| axis.dot(*tensor * axis);
    let off = |axis: DVec3| {
        let (low, high) = bodies
            .iter()
            .map(|b| about(b, axis))
            .fold((f64::INFINITY, 0.0_f64), |(low, high), moment| {
                (low.min(moment), high.max(moment))
            });
        let moment = about(&found, axis);
        (moment / high).max(low / moment)
    };
    let worst = own.into_iter().map(off).fold(1.0, f64::max);
    (sorted <= FITS && worst > TURNED && worst.is_finite()).then_some(worst)
}

/// Sorted moments within this many times those of the shape are its own; measured: solid and shell of
/// a door agree within 1.1.
const FITS: f64 = 1.5;
/// A moment about an axis that leaves those of the shape by more than this, where the sorted ones fit,
/// is another axis'; a guess, well above [`FITS`].
const TURNED: f64 = 2.0;

fn triple(v: DVec3) -> String {
    format!("({}, {}, {})", figure(v.x), figure(v.y), figure(v.z))
}

fn centre(parts: &Parts) -> Check {
    let bound = OUTSIDE.of(parts.diagonal);
    let finding = |part: &Part| {
        let inertial = part.link.inertial.filter(|_| part.unread().is_none())?;
        let points: Vec<DVec3> = part.points().collect();
        let outside = distance_to_hull(&points, inertial.origin.translation)?;
        let words = told(
            part.link,
            inertial.line,
            format!("the centre of mass lies {} outside its hull", mm(outside)),
        );
        Some(Finding { severity: outside / bound, value: outside, unit: "m", words })
    };
    let mut unknown = unread(parts);
    unknown.extend(without_inertial(parts));
    let check = judged("M5", parts.parts.iter().filter_map(finding).collect(), unknown);
    check.threshold(format!("<= {} outside", mm(bound)))
}

/// Some points, asked only for the farthest in a direction: their convex hull, never built.
struct Cloud<'a>(&'a [DVec3]);

impl SupportMap for Cloud<'_> {
    fn local_support_point(&self, direction: DVec3) -> DVec3 {
        let by_reach = |a: &&DVec3, b: &&DVec3| direction.dot(**a).total_cmp(&direction.dot(**b));
        self.0.iter().max_by(by_reach).copied().unwrap_or_default()
    }
}

/// Distance from a point to the convex hull of others, 0 inside; `None` without any.
fn distance_to_hull(points: &[DVec3], p: DVec3) -> Option<f64> {
    let towards = p - *points.first()?;
    let to_point = DPose3::from_translation(p);
    let cloud = Cloud(points);
    let mut simplex = VoronoiSimplex::new();
    let start = towards.try_normalize().unwrap_or(DVec3::X);
    simplex.reset(CsoPoint::from_shapes(&to_point, &cloud, &ConstantOrigin, start));
    match closest_points(&to_point, &cloud, &ConstantOrigin, f64::MAX, true, &mut simplex) {
        GJKResult::ClosestPoints(a, b, _) => Some(a.distance(b)),
        GJKResult::Intersection => Some(0.0),
        GJKResult::NoIntersection(_) | GJKResult::Proximity(_) => Some(f64::INFINITY),
    }
}

fn ratios(parts: &Parts) -> Check {
    let robot = parts.robot;
    let body_of = robot.body_of_link();
    let mut mass = vec![0.0; robot.links.len()];
    for (l, link) in robot.links.iter().enumerate() {
        mass[body_of[l]] += link.inertial.map_or(0.0, |i| i.mass);
    }
    let moving = robot.joints.iter().filter(|j| j.kind.moves());
    let pairs = moving.map(|j| (j, mass[body_of[j.parent]], mass[body_of[j.child]]));
    let finding = |(joint, parent, child): (&crate::robot::Joint, f64, f64)| {
        let value = parent / child;
        let words = format!(
            "line {}: joint `{}`: {} kg above, {} kg below",
            joint.line,
            joint.name,
            figure(parent),
            figure(child)
        );
        Finding { severity: value / RATIO, value, unit: "times", words }
    };
    judged("M6", pairs.map(finding).collect(), without_inertial(parts))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_is_inside_a_hull_or_as_far_from_it_as_it_is() {
        let corner = |i: usize| {
            let bit = |k: usize| (i >> k & 1) as f64;
            DVec3::new(bit(0), bit(1), bit(2))
        };
        let cube: Vec<_> = (0..8).map(corner).collect();
        let from = |x, y, z| distance_to_hull(&cube, DVec3::new(x, y, z)).unwrap();
        assert_eq!(from(0.5, 0.5, 0.5), 0.0);
        assert_eq!(from(0.001, 0.999, 0.3), 0.0);
        assert!((from(2.0, 0.5, 0.5) - 1.0).abs() < 1e-9);
        assert!((from(2.0, 2.0, 2.0) - 3.0_f64.sqrt()).abs() < 1e-9);
        assert!((from(1.002, 0.37, 0.61) - 0.002).abs() < 1e-9);
        assert_eq!(distance_to_hull(&[], DVec3::ZERO), None);
    }
}
