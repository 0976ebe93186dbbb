//! An articulated object to pictures: at rest and with every joint at its ends, from where its parts
//! are best seen to move.

use std::f64::consts::FRAC_PI_2;

use adapters::RenderedView;
use object::mesh::Bounds;
use object::posed::posed;
use object::{ArticulatedObject, Configuration, DVec3, Range};
use rayon::prelude::*;
use runner::StageError;
use view::{
    Camera, NO_FACE, Paint, Picture, Renderer, View, caption, draw_axis, eight_views, encode_png,
    mark, part_colour,
};

/// Width and height of each picture, pixels.
pub(super) const SIZE: u32 = 1024;
/// The same of the pictures that only tell which side is best.
const SMALL: u32 = 160;
/// The sides to choose from.
const SIDES: [&str; 3] = ["front_right", "front_left", "front"];
/// Those of them from which depth is seen, too.
pub(super) const CORNERS: [&str; 2] = ["front_right", "front_left"];
/// Length of an axis to either side of its pivot, as a share of the object's diagonal.
const REACH: f64 = 0.2;

/// Pictures of an object in motion, each part in its own colour, moving parts numbered, axes drawn.
/// Poses that are the same share a picture.
///
/// # Errors
/// [`StageError`] when the object cannot be posed or a picture cannot be encoded.
pub(super) fn motion_views(object: &ArticulatedObject) -> Result<Vec<RenderedView>, StageError> {
    let pose = |(name, q): (String, Configuration)| {
        let object = posed(object, &q).map_err(|e| StageError::from_error(&e))?;
        Ok(Pose { name, object })
    };
    let poses: Vec<_> = states(object).into_iter().map(pose).collect::<Result<_, StageError>>()?;
    let corners = poses.iter().flat_map(|p| p.object.mesh().vertices()).copied();
    let bounds = Bounds::of(corners);
    let paint = Paint::Parts(object.part_of_face());
    let renderers: Vec<_> = poses.iter().map(|p| Renderer::new(p.object.mesh(), &paint)).collect();
    let side = best_side(&renderers, &bounds, (object.part_of_face(), &SIDES));
    let views = eight_views(&bounds, SIZE);
    let Some(view) = views.iter().find(|v| v.name == side) else { return Ok(vec![]) };
    let both = poses.par_iter().zip(&renderers);
    both.map(|(pose, renderer)| pose.picture(view, renderer)).collect()
}

/// An object in one of its poses.
struct Pose {
    name: String,
    object: ArticulatedObject,
}

impl Pose {
    fn picture(&self, view: &View, renderer: &Renderer<'_>) -> Result<RenderedView, StageError> {
        let mut picture = renderer.render(&view.camera);
        let seen = picture.clone();
        for part in (0..self.object.tree().len()).filter(|&p| !self.object.joints(p).is_empty()) {
            self.draw_axes(&mut picture, &view.camera, part);
            if let Some(at) = middle(&seen, self.object.part_of_face(), part) {
                mark(&mut picture, at, &part.to_string());
            }
        }
        caption(&mut picture, &self.name);
        let png = encode_png(&picture).map_err(|e| StageError::from_error(&e))?;
        Ok(RenderedView { name: self.name.clone(), png })
    }

    fn draw_axes(&self, picture: &mut Picture, camera: &Camera, part: usize) {
        let reach = self.object.mesh().bounds().diagonal() * REACH;
        for motion in self.object.joints(part) {
            let along: DVec3 = motion.axis * reach;
            let (from, to) = (motion.pivot - along, motion.pivot + along);
            draw_axis(picture, camera, from, to, part_colour(part));
        }
    }
}

/// The poses to be seen, each with its name. What turns without end is turned a quarter each way.
fn states(object: &ArticulatedObject) -> Vec<(String, Configuration)> {
    let ends = |range: Range| match range {
        Range::Continuous => (-FRAC_PI_2, FRAC_PI_2),
        Range::Limits { lower, upper } => (lower, upper),
    };
    let at = |end: fn((f64, f64)) -> f64| {
        let values = |p| object.joints(p).iter().map(|m| end(ends(m.range))).collect();
        Configuration((0..object.tree().len()).map(values).collect())
    };
    let all = [
        ("at rest", Configuration::rest(object.tree())),
        ("at the lower limits", at(|(lower, _)| lower)),
        ("at the upper limits", at(|(_, upper)| upper)),
    ];
    let mut states: Vec<(String, Configuration)> = vec![];
    for (name, q) in all {
        match states.iter_mut().find(|(_, known)| *known == q) {
            Some((names, _)) => *names = format!("{names} and {name}"),
            None => states.push((name.to_owned(), q)),
        }
    }
    states
}

/// The side from which the poses differ most; the first of those that are alike.
pub(super) fn best_side(
    renderers: &[Renderer<'_>],
    bounds: &Bounds,
    (labels, sides): (&[u16], &[&'static str]),
) -> &'static str {
    let views = eight_views(bounds, SMALL);
    let shows = |side: &str| {
        let Some(view) = views.iter().find(|v| v.name == side) else { return 0 };
        let seen: Vec<_> =
            renderers.iter().map(|r| parts(&r.render(&view.camera), labels)).collect();
        let changed = |pair: &[Vec<Option<u16>>]| {
            pair[0].iter().zip(&pair[1]).filter(|(a, b)| a != b).count()
        };
        seen.windows(2).map(changed).sum::<usize>()
    };
    let mut best = (SIDES[0], 0);
    for &side in sides {
        let count = shows(side);
        if count > best.1 {
            best = (side, count);
        }
    }
    best.0
}

/// The part that each pixel sees.
fn parts(picture: &Picture, labels: &[u16]) -> Vec<Option<u16>> {
    let part = |&face: &u32| labels.get(face as usize).copied().filter(|_| face != NO_FACE);
    picture.face.iter().map(part).collect()
}

/// The pixel of a part that is nearest to the middle of all that see it; none where it is hidden.
fn middle(picture: &Picture, labels: &[u16], part: usize) -> Option<[f64; 2]> {
    let width = picture.size[0].max(1) as usize;
    let seen = parts(picture, labels);
    let own = seen.iter().enumerate().filter(|(_, p)| p.is_some_and(|p| usize::from(p) == part));
    let own: Vec<[f64; 2]> =
        own.map(|(i, _)| [(i % width) as f64 + 0.5, (i / width) as f64 + 0.5]).collect();
    let mean = [0, 1].map(|c| own.iter().map(|p| p[c]).sum::<f64>() / own.len().max(1) as f64);
    let far = |p: &[f64; 2]| (p[0] - mean[0]).hypot(p[1] - mean[1]);
    own.iter().min_by(|a, b| far(a).total_cmp(&far(b))).copied()
}

#[cfg(test)]
mod tests {
    use object::{JointKind, JointMotion, KinematicTree, Mesh, Part};

    use super::*;

    /// A wall with a plate before it that slides to the right.
    fn plate(range: Range) -> ArticulatedObject {
        let upright = |x: [f64; 2], y: f64| {
            [(x[0], 0.0), (x[1], 0.0), (x[1], 1.0), (x[0], 1.0)].map(|(x, z)| DVec3::new(x, y, z))
        };
        let corners = [upright([-1.0, 1.0], 0.1), upright([-0.5, 0.0], -0.1)].concat();
        let mesh = Mesh::new(corners, vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]).unwrap();
        let part = |name: &str, parent, joints| {
            let (name, text) = (name.to_owned(), name.to_owned());
            Part { name, text, parent, joints }
        };
        let kind = JointKind::Prismatic;
        let parts = vec![part("wall", None, vec![]), part("plate", Some(0), vec![kind])];
        let (axis, pivot) = (DVec3::X, DVec3::new(-0.25, -0.1, 0.5));
        let slide = JointMotion { kind, axis, pivot, range };
        let tree = KinematicTree::new(parts).unwrap();
        ArticulatedObject::new(mesh, tree, vec![0, 0, 1, 1], vec![vec![], vec![slide]]).unwrap()
    }

    #[test]
    fn poses_that_are_the_same_share_a_picture() {
        let names = |lower| {
            let states = states(&plate(Range::Limits { lower, upper: 0.7 }));
            states.into_iter().map(|(name, _)| name).collect::<Vec<_>>()
        };
        let upper = "at the upper limits";
        let rest = "at rest and at the lower limits";
        assert_eq!(names(0.0), [rest, upper]);
        assert_eq!(names(-0.2), ["at rest", "at the lower limits", upper]);
    }

    #[test]
    fn what_moves_is_seen_to_move_and_the_pictures_are_the_same_each_time() {
        let plate = plate(Range::Limits { lower: 0.0, upper: 0.7 });
        let views = motion_views(&plate).unwrap();
        assert_eq!(views.len(), 2);
        assert_ne!(views[0].png, views[1].png);
        assert_eq!(motion_views(&plate).unwrap(), views);
    }

    #[test]
    fn a_mark_stands_on_the_part_it_names() {
        let plate = plate(Range::Limits { lower: 0.0, upper: 0.7 });
        let camera = eight_views(&plate.mesh().bounds(), 200)[0].camera;
        let paint = Paint::Parts(plate.part_of_face());
        let picture = Renderer::new(plate.mesh(), &paint).render(&camera);
        let at = middle(&picture, plate.part_of_face(), 1).unwrap();
        let pixel = camera.project(DVec3::new(-0.25, -0.1, 0.5)).unwrap().pixel;
        assert!((at[0] - pixel[0]).hypot(at[1] - pixel[1]) < 5.0, "{at:?} {pixel:?}");
        assert_eq!(middle(&picture, &[0; 4], 1), None, "a part that nobody sees");
    }
}
