//! How deep parts stand in each other, for defects that are about that: measured here, by another
//! library's contact queries than those of the checks that are to find them.

use glamx::DPose3;
use parry3d_f64::query::contact;
use parry3d_f64::shape::ConvexPolyhedron;
use sim_check::Robot;
use sim_check::geometry::tessellate::tessellated;
use sim_check::robot::Joint;

/// How much larger than a mesh its hull may be for it to count as convex; a guess.
const CONVEX: f64 = 1.02;
/// Most corners of a shape whose hull is asked; a guess.
const MOST: usize = 20_000;

/// The convex shapes that links touch with, by link.
pub(super) struct Solids<'m> {
    robot: &'m Robot,
    of_link: Vec<Vec<(DPose3, ConvexPolyhedron)>>,
}

impl<'m> Solids<'m> {
    /// Those of a robot. What is not convex is left out: of it nobody could say so simply.
    pub(super) fn of(robot: &'m Robot) -> Self {
        let solid = |shape: &sim_check::robot::Shape| {
            let mesh = tessellated(&shape.geometry).ok()?;
            if mesh.vertices().len() > MOST || shape.mask == [0, 0] {
                return None;
            }
            let hull = crate::fix::lines::hull(&mesh).ok()?;
            if hull.signed_volume() > CONVEX * mesh.signed_volume() {
                return None;
            }
            let solid = ConvexPolyhedron::from_convex_hull(hull.vertices())?;
            Some((shape.origin, solid))
        };
        let of_link =
            robot.links.iter().map(|l| l.collisions.iter().filter_map(solid).collect()).collect();
        Self { robot, of_link }
    }

    /// How deep what hangs on a joint stands in the rest, where that joint is at `origin` in its
    /// parent's frame and has made this motion, metres.
    pub(super) fn depth(&self, joint: &Joint, origin: DPose3, motion: DPose3) -> f64 {
        let poses = self.robot.link_poses(&[]);
        let there = poses[joint.parent] * origin * motion;
        let moved = there * poses[joint.child].inverse();
        let (mut below, mut rest) = (Vec::new(), Vec::new());
        for (link, solids) in self.of_link.iter().enumerate() {
            let is_below = self.robot.is_under(link, joint.child);
            let to = if is_below { &mut below } else { &mut rest };
            let at = if is_below { moved * poses[link] } else { poses[link] };
            to.extend(solids.iter().map(|(own, solid)| (at * *own, solid)));
        }
        let deep = |a: &(DPose3, &ConvexPolyhedron), b: &(DPose3, &ConvexPolyhedron)| {
            // A query that breaks down says nothing.
            let asked = std::panic::catch_unwind(|| contact(&a.0, a.1, &b.0, b.1, 0.0));
            asked.ok().and_then(Result::ok).flatten().map_or(0.0, |c| -c.dist)
        };
        let pairs = below.iter().flat_map(|a| rest.iter().map(move |b| (a, b)));
        pairs.map(|(a, b)| deep(a, b)).fold(0.0, f64::max)
    }
}
