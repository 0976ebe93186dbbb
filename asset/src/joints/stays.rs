//! Stops a hinge before it would carry its part away from the parent.

use glamx::DVec3;
use object::condition::GivenJoints;
use object::pose::joint_pose;
use object::sample::sample_surface;
use object::{ArticulatedObject, JointKind, JointMotion, Mesh, Range};
use parry3d_f64::query::PointQueryWithLocation;
use parry3d_f64::shape::TriMesh;
use rayon::prelude::*;

use crate::change::Change;

/// How far what is seen of two parts may come apart along a hinge's range: share of the asset's
/// diagonal, and at least metres; nine tenths of what a checker of `simready-urdf 1.0` allows.
const GAP: (f64, f64) = (0.0027, 0.0027);
/// Poses looked at on each side of rest.
const POSES: usize = 16;
/// Least range left on a side that is cut, radians: 2 degrees.
const LEAST: f64 = 0.035;
/// Points looked at on each surface: samples, and at most so many corners.
const SAMPLES: usize = 1500;
const CORNERS: usize = 3000;

/// The motions with ranges along which each part stays at its parent, and what was cut. `seen` is
/// what is to be seen of every part, metres, asset frame.
pub(crate) fn stop(
    object: &ArticulatedObject,
    seen: &[Mesh],
    given: &GivenJoints,
    seed: u64,
) -> (Vec<Vec<JointMotion>>, Vec<Change>) {
    let diagonal = object.mesh().bounds().diagonal();
    let allowed = (GAP.0 * diagonal).max(GAP.1);
    let tree = object.tree();
    let fit = |part: usize| {
        let mut motions = object.joints(part).to_vec();
        let mut changes = Vec::new();
        let hinges = motions.iter_mut().enumerate();
        for (index, motion) in hinges.filter(|(_, m)| m.kind == JointKind::Revolute) {
            let Some(parent) = tree.parent(part) else { continue };
            let pair = [&seen[part], &seen[parent]].map(|mesh| Side::new(mesh, seed));
            let [Some(child), Some(parent)] = pair else { continue };
            let Range::Limits { lower, upper } = motion.range else { continue };
            let [keeps_lower, keeps_upper] = given.ends(part, index);
            let until = |end: f64, is_given: bool| match is_given {
                true => end,
                false => farthest(motion, [&child, &parent], end, allowed),
            };
            let (low, high) = (until(lower, keeps_lower), until(upper, keeps_upper));
            if (low, high) != (lower, upper) {
                motion.range = Range::Limits { lower: low, upper: high };
                let text = |low: f64, high: f64| format!("{low:.4} to {high:.4} rad");
                let why = "beyond, what is seen of the part would leave its parent";
                let name = &tree.parts()[part].name;
                changes.push(Change::new(name, "range", text(lower, upper), text(low, high), why));
            }
        }
        (motions, changes)
    };
    let fitted: Vec<_> = (0..tree.len()).into_par_iter().map(fit).collect();
    let (motions, changes): (Vec<_>, Vec<_>) = fitted.into_iter().unzip();
    (motions, changes.concat())
}

/// The value nearest `end` up to which the gap grows by no more than `allowed` metres.
fn farthest(motion: &JointMotion, pair: [&Side; 2], end: f64, allowed: f64) -> f64 {
    if end.abs() <= LEAST {
        return end;
    }
    let bound = gap(motion, pair, 0.0, f64::INFINITY) + allowed;
    let at = |k: usize| end * k as f64 / POSES as f64;
    let stays = |k: &usize| gap(motion, pair, at(*k), bound) < bound;
    let last = (1..=POSES).take_while(stays).last().unwrap_or(0);
    if last == POSES { end } else { at(last).abs().max(LEAST).copysign(end) }
}

/// Distance between what is seen of the parts at a joint value, metres; `bound` if not below it.
fn gap(motion: &JointMotion, [child, parent]: [&Side; 2], q: f64, bound: f64) -> f64 {
    let pose = joint_pose(motion, q);
    let there = child.points.iter().map(|&p| pose * p);
    let near = there.fold(bound, |least, p| parent.distance(p, least));
    let back = pose.inverse();
    parent.points.iter().fold(near, |least, &p| child.distance(back * p, least))
}

/// A surface one can ask how far away it is, and points on it.
struct Side {
    surface: TriMesh,
    bounds: object::mesh::Bounds,
    points: Vec<DVec3>,
}

impl Side {
    fn new(mesh: &Mesh, seed: u64) -> Option<Self> {
        let surface = TriMesh::new(mesh.vertices().to_vec(), mesh.faces().to_vec()).ok()?;
        let stride = mesh.vertices().len() / CORNERS + 1;
        let mut points: Vec<DVec3> = mesh.vertices().iter().copied().step_by(stride).collect();
        points.extend(sample_surface(mesh, SAMPLES, seed).iter().map(|s| s.position));
        Some(Self { surface, bounds: mesh.bounds(), points })
    }

    fn distance(&self, p: DVec3, least: f64) -> f64 {
        let outside = p.distance(p.clamp(self.bounds.min, self.bounds.max));
        if outside >= least {
            return least;
        }
        let found =
            self.surface.project_local_point_and_get_location_with_max_dist(p, false, least);
        found.map_or(least, |(found, _)| found.point.distance(p).min(least))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::hulls::tests::add_box;
    use object::{KinematicTree, Part};

    /// A door of 0.4 m hung on a post, its axis `aside` metres off the post.
    fn door(aside: f64) -> ArticulatedObject {
        let mut soup = (Vec::new(), Vec::new());
        add_box(&mut soup, [-0.1, -0.05, 0.0], [0.0, 0.05, 1.0]);
        add_box(&mut soup, [0.001, -0.01, 0.0], [0.4, 0.01, 1.0]);
        let mesh = Mesh::new(soup.0, soup.1).unwrap();
        let part = |name: &str, parent, joints| Part {
            name: String::from(name),
            text: name.into(),
            parent,
            joints,
        };
        let parts =
            vec![part("post", None, vec![]), part("door", Some(0), vec![JointKind::Revolute])];
        let motion = JointMotion {
            kind: JointKind::Revolute,
            axis: DVec3::Z,
            pivot: DVec3::new(aside, 0.0, 0.5),
            range: Range::Limits { lower: 0.0, upper: 1.5 },
        };
        let labels = (0..24).map(|f| u16::from(f >= 12)).collect();
        let tree = KinematicTree::new(parts).unwrap();
        ArticulatedObject::new(mesh, tree, labels, vec![vec![], vec![motion]]).unwrap()
    }

    fn stopped(object: &ArticulatedObject) -> (f64, usize) {
        let seen: Vec<Mesh> =
            (0..2).map(|p| object.mesh().submesh(object.faces_of(p)).unwrap()).collect();
        let (motions, changes) = stop(object, &seen, &GivenJoints::default(), 1);
        (motions[1][0].range.ends().1, changes.len())
    }

    #[test]
    fn a_door_hung_at_its_edge_keeps_its_range() {
        assert_eq!(stopped(&door(0.0)), (1.5, 0));
    }

    #[test]
    fn a_door_hung_too_far_out_stops_where_it_would_leave_the_post() {
        let (upper, changes) = stopped(&door(0.1));
        assert!(upper > 0.1 && upper < 0.8 && changes == 1, "{upper}");
    }
}
