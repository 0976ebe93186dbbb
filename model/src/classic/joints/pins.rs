//! Where a line runs in the middle of something thin and round, such as a hinge's knuckles, a pin
//! or an axle.

use nalgebra::{Cholesky, Matrix3, Vector3};
use object::DVec3;

use crate::classic::joints::contact::Touch;
use crate::classic::joints::scene::{Scene, Sight};

/// What is thin has its surface no farther from its middle than this, a share of the object's diagonal.
const THIN: f64 = 0.08;
/// In how many ways one looks across the line, and which of them are tried first: every fourth.
const LOOKS: usize = 24;
const FIRST: usize = 4;
/// Of those few, how many must meet what faces the line: of six looks a sixth of a turn apart at least three
/// fall within any [`ROUND`] of [`LOOKS`] that lie side by side.
const FIRST_FACING: usize = 3;
/// It is round if so many of them meet what faces the line, all about as far away: a knuckle has a leaf
/// on one side, and of a square bar ten do.
const ROUND: usize = 13;
/// A surface faces the line within 18°.
const FACING: f64 = 0.95;
/// How much nearer or farther than most it may be.
const UNEVEN: f64 = 0.25;
/// How many rings are told from one another about one place.
const RINGS: usize = 3;
/// A look goes on this far past what it met.
const AHEAD: f64 = 1e-4;
/// How many points of a contact are tried.
const TRIED: usize = 120;
/// How far from being across the line the way through a pin may be.
const ASKEW: f64 = 0.15;
/// Pins closer than this are one, a share of the object's diagonal.
const SAME_PIN: f64 = 0.006;
/// How many pins along one direction are kept.
const KEPT: usize = 2;

/// What is thin and round about a line along some direction, at one place of it.
#[derive(Clone, Copy, Debug)]
pub struct Ring {
    /// Its middle, across from that place.
    pub middle: DVec3,
    /// How far its surface is from there.
    pub radius: f64,
    /// The part that most of it is of.
    pub part: u16,
}

/// What is thin and round about the line through a point along `d`, there, from the innermost on: a pin,
/// the knuckle about it.
pub fn rings(scene: &Scene, at: DVec3, d: DVec3) -> Vec<Ring> {
    let ways = ways(d);
    rings_at(scene, at, &ways, RINGS)
}

/// The same for each of several points of one line.
pub fn rings_along(scene: &Scene, places: &[DVec3], d: DVec3) -> Vec<Vec<Ring>> {
    let ways = ways(d);
    places.iter().map(|&at| rings_at(scene, at, &ways, RINGS)).collect()
}

/// The innermost rings about a point, at most so many.
fn rings_at(scene: &Scene, at: DVec3, ways: &[DVec3; LOOKS], most: usize) -> Vec<Ring> {
    let mut found = Vec::new();
    let (mut met, mut count) = ([None; LOOKS], 0);
    for i in (0..LOOKS).step_by(FIRST) {
        let sight = scene.look(at, ways[i], THIN);
        count += usize::from(sight.is_some_and(|sight| is_facing(&sight, ways[i])));
        met[i] = Some(sight);
    }
    if count < FIRST_FACING {
        return found;
    }
    let mut begun = [0.0; LOOKS];
    while let Some(ring) = ring((scene, &met), at, ways, &mut begun) {
        found.push(ring);
        if found.len() == most {
            break;
        }
        met = [None; LOOKS];
    }
    found
}

/// Whether what one sees looks back along the way one looks.
fn is_facing(sight: &Sight, way: DVec3) -> bool {
    sight.normal.dot(way).abs() > FACING
}

/// Directions all around across `d`.
fn ways(d: DVec3) -> [DVec3; LOOKS] {
    let u = d.any_orthonormal_vector();
    let v = d.cross(u);
    std::array::from_fn(|i| {
        let (sin, cos) = (i as f64 / LOOKS as f64 * std::f64::consts::TAU).sin_cos();
        u * cos + v * sin
    })
}

/// The first ring that is met past where looks begin, which are then just past it. Some looks may have been
/// had; nothing more is looked at once so many have failed that it can be no ring.
fn ring(
    (scene, had): (&Scene, &[Option<Option<Sight>>; LOOKS]),
    at: DVec3,
    ways: &[DVec3; LOOKS],
    begun: &mut [f64; LOOKS],
) -> Option<Ring> {
    let fails = |(i, had): (usize, &Option<Option<Sight>>)| {
        had.is_some_and(|sight| !sight.is_some_and(|sight| is_facing(&sight, ways[i])))
    };
    let mut failed = had.iter().enumerate().filter(|&had| fails(had)).count();
    let mut met: Vec<(usize, Sight)> = Vec::with_capacity(LOOKS);
    for i in 0..LOOKS {
        let look = || scene.look(at + ways[i] * begun[i], ways[i], THIN - begun[i]);
        let sight = had[i].unwrap_or_else(look);
        met.extend(sight.map(|s| (i, Sight { distance: begun[i] + s.distance, ..s })));
        failed += usize::from(had[i].is_none() && fails((i, &Some(sight))));
        if failed > LOOKS - ROUND {
            return None;
        }
    }
    let mut facing: Vec<(usize, Sight)> =
        met.iter().filter(|(i, sight)| is_facing(sight, ways[*i])).copied().collect();
    facing.sort_by(|a, b| a.1.distance.total_cmp(&b.1.distance));
    let middle = facing.get(facing.len() / 2)?.1.distance;
    facing.retain(|(_, s)| (s.distance - middle).abs() < UNEVEN * middle);
    if facing.len() < ROUND {
        return None;
    }
    begun.fill(middle + AHEAD);
    met.iter().for_each(|(i, s)| begun[*i] = s.distance.max(begun[*i]) + AHEAD);
    let of = |part: u16| facing.iter().filter(|(_, s)| s.part == part).count();
    let most = facing.iter().map(|(_, s)| (of(s.part), std::cmp::Reverse(s.part))).max()?;
    let hits = facing.iter().map(|(i, s)| ways[*i] * s.distance);
    let (shift, radius) = circle(hits, [ways[0], ways[LOOKS / 4]])?;
    Some(Ring { middle: at + shift, radius, part: most.1.0 })
}

/// The middle and the radius of the circle that passes closest to points of the plane of `u` and `v`, by
/// the least sum of squares of its equation |p|² − 2 p·m = r² − |m|².
fn circle(points: impl Iterator<Item = DVec3>, [u, v]: [DVec3; 2]) -> Option<(DVec3, f64)> {
    let (mut matrix, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for p in points {
        let row = Vector3::new(2.0 * p.dot(u), 2.0 * p.dot(v), 1.0);
        matrix += row * row.transpose();
        right += row * p.length_squared();
    }
    let solved = Cholesky::new(matrix)?.solve(&right);
    let middle = u * solved.x + v * solved.y;
    let radius = (solved.z + middle.length_squared()).sqrt();
    (middle.is_finite() && radius > 0.0).then_some((middle, radius))
}

/// Points in the middle of the pins along `d` that a contact shows, those first that show most. The middle
/// of one way through is near it only; about that there is a ring, whose middle it is.
pub fn pins<'a>(scene: &Scene, contact: impl Iterator<Item = &'a Touch>, d: DVec3) -> Vec<DVec3> {
    let across: Vec<&Touch> = contact.filter(|t| t.normal.dot(d).abs() < ASKEW).collect();
    let few = across.iter().step_by(across.len() / TRIED + 1);
    let mut found: Vec<(usize, DVec3)> = Vec::new();
    for at in few.filter_map(|t| through(scene, t)) {
        let same = |(_, known): &&mut (usize, DVec3)| {
            (*known - at).reject_from_normalized(d).length() < SAME_PIN
        };
        if let Some((count, _)) = found.iter_mut().find(same) {
            *count += 1;
        } else if let Some(near) = middle(scene, at, d) {
            found.extend(middle(scene, near, d).map(|middle| (1, middle)));
        }
    }
    found.sort_by_key(|(count, _)| std::cmp::Reverse(*count));
    found.into_iter().take(KEPT).map(|(_, at)| at).collect()
}

fn middle(scene: &Scene, at: DVec3, d: DVec3) -> Option<DVec3> {
    rings_at(scene, at, &ways(d), 1).first().map(|ring| ring.middle)
}

/// The middle of what is thin under a point of a surface.
fn through(scene: &Scene, touch: &Touch) -> Option<DVec3> {
    let inward = -touch.normal;
    let far = scene.look(touch.position + inward * AHEAD, inward, 2.0 * THIN)?;
    let is_opposite = far.normal.dot(inward).abs() > FACING;
    is_opposite.then(|| touch.position + inward * ((far.distance + AHEAD) / 2.0))
}
