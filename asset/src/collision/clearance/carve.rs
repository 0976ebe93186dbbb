//! Taking the room another body needs out of a convex piece, with the fewest and best plane cuts.

use glamx::DVec3;

use super::meeting::Meeting;
use super::motion::Motion;
use crate::collision::cover::{Cover, Served};
use crate::collision::solid::Solid;

/// Samples looked at when planes are compared.
const LOOKED_AT: usize = 160;
/// A further piece must win back this much of the mean price per sample...
const WORTH: f64 = 0.003;
/// ...or hold this share of the host's volume.
const BULK: f64 = 0.08;
/// Directions of a host or an intruder that are tried.
const SIDES: usize = 14;

/// Bodies that a host must make room for: each with its motion relative to the host.
pub(crate) type Intruders<'a> = [(&'a Solid, Meeting)];

/// What limits a carving.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Room {
    /// Distance kept from the intruders, metres.
    pub(crate) gap: f64,
    /// Pieces thinner than this are dropped, metres.
    pub(crate) width: f64,
    /// Most pieces the host may become.
    pub(crate) pieces: usize,
    /// How much of the usual worth is enough for a further piece.
    pub(crate) share: f64,
}

/// What is left of `host` once every place the intruders reach is taken out: convex pieces, each
/// behind a plane `gap` away from all of the intruders' motion. Empty if nothing thick is left.
///
/// `served` are the samples the host covers, as [`Cover::served`] gives them.
pub(crate) fn carve(
    host: &Solid,
    intruders: &Intruders,
    served: &[Served],
    cover: &Cover,
    room: &Room,
) -> Vec<Solid> {
    let planes = planes(host, intruders, room.gap);
    let stride = served.len().div_ceil(LOOKED_AT).max(1);
    let thinned = served.iter().step_by(stride);
    let samples = thinned.map(|s| Served { weight: s.weight * stride as f64, ..*s }).collect();
    let mut left = Left { rest: host.clone(), samples, taken: Vec::new() };
    let bulk = host.volume();
    let mut pieces = Vec::new();
    while pieces.len() < room.pieces {
        let best = left.best_plane(&planes, cover, room.width);
        let Some((plane, won)) = best else { break };
        let (n, offset) = planes[plane];
        let piece = left.rest.below(-n, -offset).filter(|p| p.width() >= room.width);
        if let Some(piece) = piece {
            let worth = won > WORTH * room.share || piece.volume() > BULK * bulk * room.share;
            if !worth && !pieces.is_empty() {
                break;
            }
            left.cover(&piece);
            pieces.push(piece);
        }
        left.taken.push(plane);
        match left.rest.below(n, offset) {
            Some(rest) => left.rest = rest,
            None => break,
        }
    }
    pieces
}

/// What is still to be shared out of a host.
struct Left {
    rest: Solid,
    samples: Vec<Served>,
    taken: Vec<usize>,
}

impl Left {
    /// The plane above which most of the remainder's worth lies, and that worth in price.
    fn best_plane(
        &self,
        planes: &[(DVec3, f64)],
        cover: &Cover,
        width: f64,
    ) -> Option<(usize, f64)> {
        let mut best: Option<(usize, f64, f64)> = None;
        for (i, &(n, offset)) in planes.iter().enumerate() {
            let (top, bottom) = (self.rest.support(n), -self.rest.support(-n));
            if self.taken.contains(&i) || top - offset < width {
                continue;
            }
            let won = self.won(n, offset, cover);
            let share = ((top - offset) / (top - bottom)).min(1.0);
            let value = won + 0.002 * share;
            if best.is_none_or(|b| value > b.1) {
                best = Some((i, value, won));
            }
        }
        best.map(|(i, _, won)| (i, won))
    }

    /// Price saved, about, by keeping what lies above a plane.
    fn won(&self, n: DVec3, offset: f64, cover: &Cover) -> f64 {
        let saved = |s: &Served| {
            let distance = s.own.max(offset - n.dot(s.at));
            s.weight * (cover.price(s.kept) - cover.price(distance)).max(0.0)
        };
        self.samples.iter().map(saved).sum()
    }

    fn cover(&mut self, piece: &Solid) {
        for sample in &mut self.samples {
            sample.kept = sample.kept.min(piece.distance(sample.at, sample.kept));
        }
    }
}

/// Planes with the intruders' whole sweep below them: outward normal and offset, host's frame.
fn planes(host: &Solid, intruders: &Intruders, gap: f64) -> Vec<(DVec3, f64)> {
    let mut normals = Vec::new();
    for (solid, meeting) in intruders.iter().take(6) {
        axial(meeting, host, &mut normals);
        let (n, _) = meeting.separation(solid, host, f64::INFINITY);
        add(&mut normals, meeting.b.middle().inverse_transform_vector(n));
        let pose = meeting.middle();
        broadest(solid).for_each(|n| add(&mut normals, pose.transform_vector(n)));
    }
    broadest(host).for_each(|n| add(&mut normals, -n));
    let reach = |n: DVec3| {
        let each = intruders.iter().map(|(solid, meeting)| meeting.reach(&solid.vertices, n));
        each.fold(f64::NEG_INFINITY, f64::max)
    };
    normals.into_iter().map(|n| (n, reach(n) + gap)).collect()
}

/// Directions that suit a motion: along its axis, and around it.
fn axial(meeting: &Meeting, host: &Solid, normals: &mut Vec<DVec3>) {
    for motion in [&meeting.a, &meeting.b] {
        let Motion::Along(joint, ..) = motion else { continue };
        add(normals, joint.axis);
        add(normals, -joint.axis);
        let out = (host.centre() - joint.pivot).reject_from_normalized(joint.axis);
        let flat = |n: DVec3| n.reject_from_normalized(joint.axis).try_normalize();
        let start = flat(out).unwrap_or(joint.axis.any_orthonormal_vector());
        for k in 0..8 {
            let angle = f64::from(k) * std::f64::consts::FRAC_PI_4;
            let turn = object::pose::turn_about(joint.axis, DVec3::ZERO, angle);
            add(normals, turn.transform_vector(start));
        }
        broadest(host).filter_map(|n| flat(-n)).for_each(|n| add(normals, n));
    }
}

fn add(normals: &mut Vec<DVec3>, n: DVec3) {
    if n.is_normalized() && normals.iter().all(|m| m.dot(n) < 0.9995) {
        normals.push(n);
    }
}

/// Normals of a body's largest sides, largest first.
fn broadest(solid: &Solid) -> impl Iterator<Item = DVec3> {
    let mut sides: Vec<_> = solid.facets.iter().map(|f| (solid.area(f), f.normal)).collect();
    sides.sort_by(|a, b| b.0.total_cmp(&a.0));
    sides.into_iter().take(SIDES).map(|(_, n)| n)
}
