//! The scene as the page's script reads it.

use glamx::{DMat3, DPose3, DVec3};
use guard::text::shown;
use nalgebra::{Matrix3, SymmetricEigen};
use serde::Serialize;
use view::palette::part_colour;

use crate::lean;
use crate::pack::{Packed, pack};
use crate::scene::{Check, Evidence, Inertial, Joint, Kind, Line, Link, Mimic, Scene, Status};

/// Most steps of a decomposition; ten suffice, and what is not finite never ends.
const MAX_STEPS: usize = 200;
/// The colour of what has none (sRGB).
const PLAIN: [u8; 3] = [200, 200, 200];

#[derive(Serialize)]
pub(crate) struct Wire {
    schema: &'static str,
    title: String,
    tier: Option<WireTier>,
    about: Vec<Line>,
    notes: Vec<String>,
    links: Vec<WireLink>,
    joints: Vec<WireJoint>,
    checks: Vec<WireCheck>,
}

#[derive(Serialize)]
struct WireTier {
    name: String,
    reached: [usize; 2],
    profile: String,
}

#[derive(Serialize)]
struct WireLink {
    name: String,
    facts: Vec<Line>,
    colour: [u8; 3],
    visual: Option<Packed>,
    collisions: Vec<Packed>,
    inertial: Option<WireInertial>,
}

#[derive(Serialize)]
struct WireInertial {
    mass: f64,
    /// In the link's frame.
    centre: [f64; 3],
    /// The box of even density with that mass and inertia: its axes as a quaternion, its half sides.
    turn: [f64; 4],
    half: [f64; 3],
    /// Principal moments, kg·m².
    moments: [f64; 3],
}

#[derive(Serialize)]
struct WireJoint {
    name: String,
    kind: Kind,
    parent: usize,
    child: usize,
    at: [f64; 3],
    turn: [f64; 4],
    axis: [f64; 3],
    range: Option<[f64; 2]>,
    mimic: Option<Mimic>,
    facts: Vec<Line>,
}

#[derive(Serialize)]
struct WireCheck {
    id: String,
    rule: String,
    status: Status,
    figure: String,
    bound: String,
    evidence: Vec<WireEvidence>,
}

#[derive(Serialize)]
struct WireEvidence {
    text: String,
    pose: Vec<(usize, f64)>,
    place: Option<(usize, [f64; 3])>,
    links: Vec<usize>,
}

/// The scene for the script, and the bytes of its surfaces.
pub(crate) fn wire(scene: &Scene) -> (Wire, Vec<u8>) {
    let mut bytes = Vec::new();
    let mut notes: Vec<String> = scene.notes.iter().map(|n| shown(n).into_owned()).collect();
    let seen = lean::seen(scene.links.iter().map(|l| l.visual.as_ref()));
    let pieces = || scene.links.iter().flat_map(|l| &l.collisions);
    let touched = lean::touched(pieces().map(Some));
    notes.extend(seen.fewer.map(|f| thinned("What is seen", f)));
    notes.extend(touched.fewer.map(|f| thinned("Collision pieces", f)));
    let mut visuals = seen.meshes.into_iter();
    let mut hulls = touched.meshes.into_iter();
    let links = scene.links.iter().enumerate().map(|(i, l)| {
        let colour = part_colour(i);
        let visual = visuals.next().flatten().map(|m| pack(&mut bytes, &m, PLAIN));
        let own = hulls.by_ref().take(l.collisions.len()).flatten();
        let collisions = own.map(|m| pack(&mut bytes, &m, colour)).collect();
        link(l, colour, visual, collisions)
    });
    let links = links.collect();
    let is_link = |l: usize| l < scene.links.len();
    let sound = |j: &&Joint| is_link(j.parent) && is_link(j.child);
    let tier = scene.tier.as_ref().map(|t| WireTier {
        name: shown(&t.name).into_owned(),
        reached: t.reached,
        profile: shown(&t.profile).into_owned(),
    });
    let wire = Wire {
        schema: "kinfold-page/1",
        title: shown(&scene.title).into_owned(),
        tier,
        about: lines(&scene.about),
        notes,
        links,
        // Poses and mimics name joints by index: either all stand or none.
        joints: if scene.joints.iter().filter(sound).count() == scene.joints.len() {
            scene.joints.iter().map(|j| joint(j, scene.joints.len())).collect()
        } else {
            vec![]
        },
        checks: scene.checks.iter().map(|c| check(c, scene)).collect(),
    };
    (wire, bytes)
}

fn thinned(what: &str, [had, has]: [usize; 2]) -> String {
    format!("{what} was thinned out for the screen: {had} faces in the files, {has} here.")
}

fn lines(lines: &[Line]) -> Vec<Line> {
    let word = |text: &str| shown(text).into_owned();
    lines.iter().map(|l| Line { label: word(&l.label), text: word(&l.text) }).collect()
}

fn finite(v: DVec3) -> [f64; 3] {
    v.to_array().map(|x| if x.is_finite() { x } else { 0.0 })
}

fn turn(pose: &DPose3) -> [f64; 4] {
    let q = pose.rotation.to_array();
    if q.iter().all(|x| x.is_finite()) { q } else { [0.0, 0.0, 0.0, 1.0] }
}

fn link(link: &Link, colour: [u8; 3], visual: Option<Packed>, collisions: Vec<Packed>) -> WireLink {
    WireLink {
        name: shown(&link.name).into_owned(),
        facts: lines(&link.facts),
        colour,
        visual,
        collisions,
        inertial: link.inertial.as_ref().filter(|i| i.mass.is_finite()).map(inertial),
    }
}

/// Principal moments and their axes; nothing of what is not finite.
fn principal(inertia: DMat3) -> (DVec3, DMat3) {
    let symmetric = Matrix3::from(inertia.to_cols_array_2d());
    let found = SymmetricEigen::try_new(symmetric, f64::EPSILON, MAX_STEPS);
    let Some(found) = found.filter(|_| inertia.is_finite()) else {
        return (DVec3::ZERO, DMat3::IDENTITY);
    };
    let axes = DMat3::from_cols_array_2d(&found.eigenvectors.into());
    (DVec3::from_array(found.eigenvalues.into()), axes)
}

fn inertial(inertial: &Inertial) -> WireInertial {
    let (moments, mut axes) = principal(inertial.inertia);
    let moments = finite(moments);
    if axes.determinant() < 0.0 {
        axes.x_axis = -axes.x_axis;
    }
    let turn_of_box = inertial.frame.rotation * glamx::DQuat::from_mat3(&axes);
    let sum: f64 = moments.iter().sum();
    // A box with sides 2h has moments m/3 · (hy² + hz²) and so on.
    let half = moments.map(|i| {
        let squared = 1.5 * (sum - 2.0 * i) / inertial.mass;
        if squared.is_finite() && squared > 0.0 { squared.sqrt() } else { 0.0 }
    });
    WireInertial {
        mass: inertial.mass,
        centre: finite(inertial.frame.translation),
        turn: turn(&DPose3::from_parts(DVec3::ZERO, turn_of_box)),
        half,
        moments,
    }
}

fn joint(joint: &Joint, joints: usize) -> WireJoint {
    let is_sound = |[a, b]: &[f64; 2]| a.is_finite() && b.is_finite();
    WireJoint {
        name: shown(&joint.name).into_owned(),
        kind: joint.kind,
        parent: joint.parent,
        child: joint.child,
        at: finite(joint.origin.translation),
        turn: turn(&joint.origin),
        axis: finite(joint.axis),
        range: joint.range.filter(is_sound),
        mimic: joint.mimic.filter(|m| m.joint < joints),
        facts: lines(&joint.facts),
    }
}

fn check(check: &Check, scene: &Scene) -> WireCheck {
    WireCheck {
        id: shown(&check.id).into_owned(),
        rule: shown(&check.rule).into_owned(),
        status: check.status,
        figure: shown(&check.figure).into_owned(),
        bound: shown(&check.bound).into_owned(),
        evidence: check.evidence.iter().map(|e| evidence(e, scene)).collect(),
    }
}

fn evidence(evidence: &Evidence, scene: &Scene) -> WireEvidence {
    let is_link = |l: usize| l < scene.links.len();
    let moved = |&&(j, q): &&(usize, f64)| j < scene.joints.len() && q.is_finite();
    WireEvidence {
        text: shown(&evidence.text).into_owned(),
        pose: evidence.pose.iter().filter(moved).copied().collect(),
        place: evidence.place.filter(|p| is_link(p.link)).map(|p| (p.link, finite(p.at))),
        links: evidence.links.iter().copied().filter(|&l| is_link(l)).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_even_box_is_its_own_box_of_inertia() {
        let (mass, half) = (3.0, DVec3::new(0.1, 0.2, 0.5));
        let square = half * half;
        let moments = DVec3::new(square.y + square.z, square.x + square.z, square.x + square.y);
        let inertia = DMat3::from_diagonal(moments * (mass / 3.0));
        let shown = inertial(&Inertial { mass, frame: DPose3::identity(), inertia });
        let mut sides = shown.half;
        sides.sort_by(f64::total_cmp);
        for (found, side) in sides.iter().zip(half.to_array()) {
            assert!((found - side).abs() < 1e-12, "{sides:?}");
        }
    }

    #[test]
    fn what_leads_nowhere_is_left_out() {
        let lost = Evidence {
            pose: vec![(9, 1.0)],
            place: Some(crate::Place { link: 4, at: DVec3::ZERO }),
            links: vec![2],
            ..Evidence::default()
        };
        let found = evidence(&lost, &Scene::default());
        assert!(found.pose.is_empty() && found.place.is_none() && found.links.is_empty());
    }
}
