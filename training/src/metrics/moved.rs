//! Boxes around the points of parts, moved: what a person would see of two objects opened.

use object::DPose3;
use object::mesh::Bounds;

use super::body::{Body, Link, Motion};
use super::boxes::{giou, thickened};
use super::joints::{counterpart, ends};
use super::mean;

/// Where every joint of the truth is at its farther end from the pose shown.
pub fn opened(links: &[Link]) -> Vec<Vec<f64>> {
    let far = |m: &Motion| if m.upper.abs() >= m.lower.abs() { m.upper } else { m.lower };
    links.iter().map(|l| l.motions.iter().map(far).collect()).collect()
}

/// Where every joint of the prediction has gone the way of its true counterpart, as far as it goes: of
/// a joint without ends as far as the truth, of one without a counterpart to its farther end.
/// `pairs` holds predicted and true parts that go together.
pub fn opened_alike(predicted: &[Link], truth: &[Link], pairs: &[(u16, u16)]) -> Vec<Vec<f64>> {
    let mut values = opened(predicted);
    let far = opened(truth);
    for &(p, t) in pairs {
        let (Some(found), Some(wanted)) =
            (predicted.get(usize::from(p)), truth.get(usize::from(t)))
        else {
            continue;
        };
        for (place, motion) in found.motions.iter().enumerate() {
            if let Some(i) = counterpart(&found.motions, place, &wanted.motions) {
                let goes = far[usize::from(t)][i];
                values[usize::from(p)][place] = follow(motion, &wanted.motions[i], goes);
            }
        }
    }
    values
}

/// How far the prediction goes the way that the truth goes by `goes`.
fn follow(found: &Motion, wanted: &Motion, goes: f64) -> f64 {
    let side = if found.axis.dot(wanted.axis) < 0.0 { -1.0 } else { 1.0 };
    if found.kind == object::JointKind::Continuous {
        return side * goes;
    }
    let [lower, upper] = ends(found, wanted);
    side * if goes >= 0.0 { upper.max(0.0) } else { lower.min(0.0) }
}

/// Mean over the parts of both sides of the gIoU of axis-aligned boxes around their points, every
/// joint opened ([`opened`], [`opened_alike`]) and roots still; −1 to 1. A part without a counterpart
/// counts as −1.
pub fn moved_points_giou(predicted: &Body, truth: &Body, pairs: &[(u16, u16)]) -> f64 {
    let (found, wanted) = (still_root(predicted.links()), still_root(truth.links()));
    let (a, b) = (
        boxes(predicted, &found, &opened_alike(&found, &wanted, pairs)),
        boxes(truth, &wanted, &opened(&wanted)),
    );
    let both = |&(p, t): &(u16, u16)| {
        let [a, b] = [a.get(usize::from(p))?.as_ref()?, b.get(usize::from(t))?.as_ref()?];
        Some(giou(&thickened(a), &thickened(b)))
    };
    let values: Vec<f64> = pairs.iter().filter_map(both).collect();
    let side = |boxes: &[Option<Bounds>]| {
        let missing = boxes.iter().flatten().count().saturating_sub(values.len());
        mean(values.iter().copied().chain(std::iter::repeat_n(-1.0, missing))).unwrap_or(-1.0)
    };
    (side(&a) + side(&b)) / 2.0
}

fn still_root(links: &[Link]) -> Vec<Link> {
    let still = |l: &Link| match l.parent {
        None => Link::default(),
        Some(_) => l.clone(),
    };
    links.iter().map(still).collect()
}

/// The box around each part's points, its joints at `values`; none of a part without points.
fn boxes(body: &Body, links: &[Link], values: &[Vec<f64>]) -> Vec<Option<Bounds>> {
    let poses = poses(links, values);
    let mut of_part = vec![None; links.len()];
    for (&point, &part) in body.points().iter().zip(body.part_of_point()) {
        let moved = poses[usize::from(part)] * point;
        let slot = of_part[usize::from(part)].get_or_insert(Bounds { min: moved, max: moved });
        *slot = Bounds { min: slot.min.min(moved), max: slot.max.max(moved) };
    }
    of_part
}

/// The motion of every part from rest, its joints at `values`.
pub fn poses(links: &[Link], values: &[Vec<f64>]) -> Vec<DPose3> {
    let own = |part: usize| {
        let moved = links[part].motions.iter().zip(&values[part]);
        moved.fold(DPose3::identity(), |pose, (m, &q)| pose * m.pose(q))
    };
    let of = |part: usize| {
        let chain = std::iter::successors(Some(part), |&p| links[p].parent);
        chain.fold(DPose3::identity(), |below, p| own(p) * below)
    };
    (0..links.len()).map(of).collect()
}
