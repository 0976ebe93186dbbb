//! Where a line runs in the middle of something thin and round, as it does through the knuckles of a
//! hinge, a pin, an axle.

use object::DVec3;

use super::contact::Touch;
use super::scene::{Scene, Sight};

/// What is thin has its surface no farther from its middle than this, a share of the object's diagonal.
const THIN: f64 = 0.08;
/// In how many ways one looks across the line; a few of them first.
const LOOKS: usize = 24;
const FIRST: usize = 4;
/// Of those few, how many must meet a surface.
const FIRST_MET: usize = 3;
/// It is round if so many of them meet what faces the line, all about as far away: a knuckle has a leaf
/// on one side, and of a square bar ten do.
const ROUND: usize = 13;
/// A surface faces the line within 18°.
const FACING: f64 = 0.95;
/// How much nearer or farther than most it may be.
const UNEVEN: f64 = 0.25;
/// A surface point is this far off itself.
const AHEAD: f64 = 1e-4;
/// How many points of a contact are tried.
const TRIED: usize = 120;
/// How far from being across the line the way through a pin may be.
const ASKEW: f64 = 0.15;
/// Pins closer than this are one, a share of the object's diagonal.
const SAME_PIN: f64 = 0.006;
/// How many pins along one direction are kept.
const KEPT: usize = 2;

/// The part that is thin and round about the line through a point along `d`, there.
pub fn round_at(scene: &Scene, at: DVec3, d: DVec3) -> Option<u16> {
    let u = d.any_orthonormal_vector();
    let v = d.cross(u);
    let look = |i: usize| {
        let (sin, cos) = (i as f64 / LOOKS as f64 * std::f64::consts::TAU).sin_cos();
        let way = u * cos + v * sin;
        scene.look(at, way, THIN).map(|sight| (sight, way))
    };
    let first = (0..LOOKS).step_by(FIRST).filter(|&i| look(i).is_some()).count();
    if first < FIRST_MET {
        return None;
    }
    let met: Vec<(Sight, DVec3)> = (0..LOOKS).filter_map(look).collect();
    let facing = met.iter().filter(|(sight, way)| sight.normal.dot(*way).abs() > FACING);
    let mut facing: Vec<&Sight> = facing.map(|(sight, _)| sight).collect();
    facing.sort_by(|a, b| a.distance.total_cmp(&b.distance));
    let middle = facing.get(facing.len() / 2)?.distance;
    facing.retain(|s| (s.distance - middle).abs() < UNEVEN * middle);
    let of = |part: u16| facing.iter().filter(|s| s.part == part).count();
    let most = facing.iter().map(|s| (of(s.part), std::cmp::Reverse(s.part))).max()?;
    (facing.len() >= ROUND).then_some(most.1.0)
}

/// Points in the middle of the pins along `d` that a contact shows, those first that show most.
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
        } else if round_at(scene, at, d).is_some() {
            found.push((1, at));
        }
    }
    found.sort_by_key(|(count, _)| std::cmp::Reverse(*count));
    found.into_iter().take(KEPT).map(|(_, at)| at).collect()
}

/// The middle of what is thin under a point of a surface.
fn through(scene: &Scene, touch: &Touch) -> Option<DVec3> {
    let inward = -touch.normal;
    let far = scene.look(touch.position + inward * AHEAD, inward, 2.0 * THIN)?;
    let is_opposite = far.normal.dot(inward).abs() > FACING;
    is_opposite.then(|| touch.position + inward * ((far.distance + AHEAD) / 2.0))
}
