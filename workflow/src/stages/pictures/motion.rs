//! The joints at work, one after the other, as a short animation.

use std::f64::consts::TAU;

use glamx::DPose3;
use object::Mesh;
use rayon::prelude::*;
use sim_check::robot::{Joint, Motion};
use view::{Camera, Film, Picture, Renderer, ViewError, caption, eight_views};

use super::super::motion_views::{CORNERS, best_side};
use super::solid::{Solid, around};

/// Widths and heights of the pictures, pixels, the first that fits into [`MOST`].
const SIZES: [u32; 3] = [288, 224, 160];
/// Most bytes of the animation.
const MOST: usize = 1 << 20;
/// Pictures that are drawn of all joints' ways together, and of one way at least and at most.
const PICTURES: usize = 20;
const OF_A_WAY: [usize; 2] = [2, 8];
/// Joints of a robot with many move in so many groups.
const GROUPS: usize = 8;
/// How long a picture stands, milliseconds: on the way, at an end, at rest.
const PASSING: u32 = 80;
const AT_END: u32 = 450;
const AT_REST: u32 = 300;
/// A way shorter than this is none, radians or metres.
const NONE: f64 = 1e-6;

/// Animated WebP of the joints at work, at most [`MOST`] bytes.
///
/// # Errors
/// [`ViewError`] when the pictures cannot be encoded.
pub(super) fn film(solid: &Solid<'_>) -> Result<Vec<u8>, ViewError> {
    let ways = ways(solid);
    let rest = Renderer::new(&solid.mesh, &solid.paint());
    let camera = camera(solid, &ways, &rest);
    let mut film = Vec::new();
    for size in SIZES {
        film = Shot { solid, rest: &rest, camera: Camera { size: [size; 2], ..camera } }
            .film(&ways)?;
        if film.len() <= MOST {
            break;
        }
    }
    Ok(film)
}

/// Joints on their way from rest to one of their ends.
struct Way<'a> {
    /// Each joint with its value at rest and at the end, radians or metres.
    joints: Vec<(usize, &'a Joint, [f64; 2])>,
    /// Whether its end is where it began.
    is_turn: bool,
}

/// The ways to go: of each joint towards the end that is farther, then towards the other.
fn ways<'a>(solid: &Solid<'a>) -> Vec<Way<'a>> {
    let drives: Vec<_> = solid.drives().collect();
    let group = drives.len().div_ceil(GROUPS).max(1);
    let mut ways = Vec::new();
    for joints in drives.chunks(group) {
        for far in [true, false] {
            let goes = |&(j, joint): &(usize, &'a Joint)| Some((j, joint, way(joint, far)?));
            let joints: Vec<_> = joints.iter().filter_map(goes).collect();
            let is_turn = joints.iter().all(|(_, joint, _)| joint.kind == Motion::Continuous);
            if !joints.is_empty() {
                ways.push(Way { joints, is_turn });
            }
        }
    }
    ways
}

/// From rest to the end of a joint that is farther from it, or to the nearer; none if that is no way.
fn way(joint: &Joint, far: bool) -> Option<[f64; 2]> {
    if joint.kind == Motion::Continuous {
        return far.then_some([0.0, TAU]);
    }
    let (low, high) = joint.ends()?;
    let rest = if low <= high { 0f64.clamp(low, high) } else { 0.0 };
    let ends = if rest - low > high - rest { [low, high] } else { [high, low] };
    let end = if far { ends[0] } else { ends[1] };
    (end.is_finite() && (end - rest).abs() > NONE).then_some([rest, end])
}

impl Way<'_> {
    /// Where its joints are when a share of it is gone, slowly at both ends.
    fn at(&self, share: f64) -> Vec<(usize, f64)> {
        let eased = share * share * (3.0 - 2.0 * share);
        self.joints.iter().map(|&(j, _, [rest, end])| (j, rest + (end - rest) * eased)).collect()
    }

    fn name(&self) -> String {
        let names: Vec<_> = self.joints.iter().map(|(_, joint, _)| joint.name.as_str()).collect();
        names.join(", ")
    }
}

/// The side that shows the ends best, with all of them in the picture.
fn camera(solid: &Solid<'_>, ways: &[Way<'_>], rest: &Renderer<'_>) -> Camera {
    let middle = |way: &Way<'_>| way.at(if way.is_turn { 0.25 } else { 1.0 });
    let moves: Vec<_> = ways.iter().map(|way| solid.moves(&middle(way))).collect();
    let meshes: Vec<_> = moves.iter().filter_map(|m| solid.moved(m)).collect();
    let bounds = around(std::iter::once(&solid.mesh).chain(&meshes));
    // What all joints together do is seen at once.
    let all: Vec<_> = ways.iter().flat_map(middle).collect();
    let open = solid.moves(&all);
    let mesh = solid.moved(&open);
    let moved = mesh.iter().map(|mesh| solid.renderer_of(rest, mesh, &open));
    let both: Vec<_> = std::iter::once(rest.clone()).chain(moved).collect();
    let side = best_side(&both, &bounds, (&solid.link_of_face, &CORNERS));
    let views = eight_views(&bounds, SIZES[0]);
    views.iter().find(|v| v.name == side).unwrap_or(&views[0]).camera
}

/// A robot before a camera.
struct Shot<'a> {
    solid: &'a Solid<'a>,
    rest: &'a Renderer<'a>,
    camera: Camera,
}

impl Shot<'_> {
    fn film(&self, ways: &[Way<'_>]) -> Result<Vec<u8>, ViewError> {
        let mut film = Film::new(self.camera.size)?;
        let mut still = self.rest.render(&self.camera);
        caption(&mut still, "at rest");
        film.push(&still, AT_REST)?;
        let [least, most] = OF_A_WAY;
        let steps = (PICTURES / ways.len().max(1)).clamp(least, most);
        for way in ways {
            let there: Vec<usize> = (1..=steps).collect();
            let pictures = there.par_iter().map(|&k| self.picture(way, k as f64 / steps as f64));
            let pictures: Vec<Picture> = pictures.collect();
            for (k, picture) in there.iter().zip(&pictures) {
                film.push(picture, if *k == steps { AT_END } else { PASSING })?;
            }
            // Back in half the time; what turned without end is back already.
            let back = pictures.iter().rev().skip(2).step_by(2);
            for picture in back.filter(|_| !way.is_turn) {
                film.push(picture, PASSING)?;
            }
            film.push(&still, AT_REST)?;
        }
        film.finish()
    }

    fn picture(&self, way: &Way<'_>, share: f64) -> Picture {
        let moves = self.solid.moves(&way.at(share));
        let mesh: Option<Mesh> = self.solid.moved(&moves);
        let mut picture = match &mesh {
            Some(mesh) => self.solid.renderer_of(self.rest, mesh, &moves).render(&self.camera),
            None => self.rest.render(&self.camera),
        };
        way.joints.iter().for_each(|(_, joint, _)| self.axis(&mut picture, joint, &moves));
        caption(&mut picture, &way.name());
        picture
    }

    fn axis(&self, picture: &mut Picture, joint: &Joint, moves: &[DPose3]) {
        self.solid.draw_axis(picture, &self.camera, joint, moves);
    }
}
