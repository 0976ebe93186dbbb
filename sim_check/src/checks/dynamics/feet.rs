//! What a body stands on: the few corners of its hull that carry it on level ground.

use glamx::{DPose3, DVec3};

use crate::checks::sweep::Scene;
use crate::checks::sweep::bodies::Body;
use crate::checks::sweep::hull::Hull;

/// Radius of the ball at a corner, as a share of the scene's diagonal.
pub const FOOT: f64 = 0.001;
/// Least distance of two corners above the lowest layer, as a share of the diagonal.
const SPACING: f64 = 0.015;
/// Thickness of the lowest layer, as a share of the diagonal.
const LAYER: f64 = 0.002;
/// What the outline of the lowest layer may lose, as a share of the diagonal: contacts beyond the
/// dozen that carry a round foot add nothing but rounds for the solver, and let it tremble for ever.
const LOSS: f64 = 0.004;

/// Corners of a body's hull in the root frame: the outline of its lowest layer, and above it the
/// lowest first, none nearer to another than 1.5 % of the diagonal.
pub fn feet(scene: &Scene, body: &Body, poses: &[DPose3]) -> Vec<DVec3> {
    let mut corners = corners(scene, body, poses);
    corners.sort_by(|a, b| a.z.total_cmp(&b.z).then(a.x.total_cmp(&b.x)).then(a.y.total_cmp(&b.y)));
    let lowest = corners.first().map_or(0.0, |c| c.z);
    let top = lowest + LAYER * scene.diagonal;
    let layer = corners.iter().take_while(|c| c.z <= top).count();
    let above = corners.split_off(layer);
    let mut kept = outline(corners);
    thin(&mut kept, LOSS * scene.diagonal);
    for corner in above {
        if kept.iter().all(|k| k.distance(corner) >= SPACING * scene.diagonal) {
            kept.push(corner);
        }
    }
    kept
}

/// All corners of a body's hull in the root frame.
fn corners(scene: &Scene, body: &Body, poses: &[DPose3]) -> Vec<DVec3> {
    let placed = |&p: &usize| {
        let piece = &scene.pieces[p];
        let at = poses[piece.link] * piece.origin;
        piece.hull.points().iter().map(move |v| at.transform_point(*v))
    };
    let points: Vec<DVec3> = body.pieces.iter().flat_map(placed).collect();
    let hull = Hull::of_points(points.clone());
    hull.map_or(points, |h| h.points().to_vec())
}

/// The points that span the others seen from above, counter-clockwise (Andrew's monotone chain).
fn outline(mut points: Vec<DVec3>) -> Vec<DVec3> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z)));
    points.dedup_by(|a, b| a.x == b.x && a.y == b.y);
    if points.len() < 3 {
        return points;
    }
    let mut around = chain(points.iter().copied());
    let back = chain(points.iter().rev().copied());
    around.pop();
    around.extend(&back[..back.len() - 1]);
    around
}

/// One side of the outline, from the first point to the last.
fn chain(points: impl Iterator<Item = DVec3>) -> Vec<DVec3> {
    let mut side: Vec<DVec3> = Vec::new();
    for p in points {
        while let [.., a, b] = side[..]
            && (b - a).truncate().perp_dot((p - b).truncate()) <= 0.0
        {
            side.pop();
        }
        side.push(p);
    }
    side
}

/// Takes corners out of an outline, the flattest first, as long as each stands out from the line
/// between its neighbours by no more than `loss`; three stay.
fn thin(outline: &mut Vec<DVec3>, loss: f64) {
    while outline.len() > 3 {
        let flattest = (0..outline.len()).map(|k| (stands_out(outline, k), k));
        let Some((height, k)) = flattest.min_by(|a, b| a.0.total_cmp(&b.0)) else { return };
        if height > loss {
            return;
        }
        outline.remove(k);
    }
}

/// How far a corner stands out from the line between its neighbours, metres, seen from above.
fn stands_out(outline: &[DVec3], k: usize) -> f64 {
    let n = outline.len();
    let [before, at, after] = [k + n - 1, k, k + 1].map(|i| outline[i % n].truncate());
    let chord = after - before;
    chord.perp_dot(at - before).abs() / chord.length().max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_round_foot_stands_on_a_dozen_corners_and_keeps_its_reach() {
        let ring = |k: usize| {
            let turn = k as f64 / 96.0 * std::f64::consts::TAU;
            DVec3::new(turn.cos(), turn.sin(), 0.0)
        };
        let mut around = outline((0..96).map(ring).collect());
        assert_eq!(around.len(), 96);
        thin(&mut around, 0.02);
        assert!((8..=24).contains(&around.len()), "{}", around.len());
        let least = (0..around.len()).map(|k| {
            let [a, b] = [k, k + 1].map(|i| around[i % around.len()].truncate());
            a.perp_dot(b) / (b - a).length()
        });
        assert!(least.fold(1.0, f64::min) > 0.93);
    }

    #[test]
    fn the_corners_of_a_square_stay_and_what_lies_between_goes() {
        let at = |x: f64, y: f64| DVec3::new(x, y, 0.0);
        let mut around = outline(vec![
            at(0.0, 0.0),
            at(0.5, 0.001),
            at(1.0, 0.0),
            at(1.0, 1.0),
            at(0.5, 0.5),
            at(0.5, 1.001),
            at(0.0, 1.0),
        ]);
        thin(&mut around, 0.01);
        assert_eq!(around, [at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)]);
    }

    #[test]
    fn a_line_and_a_point_are_their_own_outline() {
        let at = |x: f64| DVec3::new(x, 0.0, 0.0);
        assert_eq!(outline(vec![at(1.0)]), [at(1.0)]);
        assert_eq!(outline(vec![at(1.0), at(0.0)]), [at(0.0), at(1.0)]);
        assert_eq!(outline(vec![at(1.0), at(0.0), at(2.0)]).len(), 2);
    }
}
