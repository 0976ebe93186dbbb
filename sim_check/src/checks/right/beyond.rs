//! R7: joints whose range leads away from where they would be shut, and slides that go in where they are free
//! to come out.

use glamx::DPose3;

use super::spread::{Spot, spread};
use crate::checks::study::{Study, triangles};
use crate::checks::sweep::Scene;
use crate::checks::sweep::advance::{TooMuchWork, sweep};
use crate::geometry::near::BoxTree;
use crate::profile::bounds::{AJAR, BACK, CLOSER, FARTHEST, INSIDE, LIES, OUT, STROKE};
use crate::verdict::Check;

/// How many points stand for what a joint moves.
const POINTS: usize = 300;
/// In how many poses beyond the range it is looked at.
const LOOKS: u32 = 16;

/// All joints with a range that begins where they are shown.
pub(super) fn beyond(study: &Study) -> Check {
    if !study.robot.joints.iter().any(|joint| joint.kind.moves()) {
        return Check::pass("R7").value(0.0);
    }
    let scene = match study.scene() {
        Ok(scene) => scene,
        Err(fault) => return Check::unknown("R7", fault.to_string()),
    };
    let (mut faults, mut most) = (Vec::new(), 0.0_f64);
    for drive in 0..scene.drives.len() {
        match Way::of(study, scene, drive).map(|way| way.finding()).transpose() {
            Ok(Some((gain, told))) => {
                most = most.max(gain);
                faults.extend(told);
            }
            Ok(None) => {}
            Err(much) => return Check::unknown("R7", much.to_string()),
        }
    }
    Check::from_faults("R7", faults).value(most)
}

/// A joint that is shown at one end of its range, and what it moves.
struct Way<'a> {
    scene: &'a Scene<'a>,
    drive: usize,
    /// The far end of its range, radians or metres from where it is shown.
    end: f64,
    /// Its frame at rest, root frame.
    frame: DPose3,
    /// Points of what it moves, root frame, at rest.
    points: Vec<Spot>,
    /// What it does not move: each surface with its frame at rest.
    still: Vec<(DPose3, std::sync::Arc<BoxTree>)>,
    /// How near is against it, metres.
    reach: f64,
}

impl<'a> Way<'a> {
    /// Nothing of a joint that goes both ways, or round, or takes others along.
    fn of(study: &Study, scene: &'a Scene<'a>, drive: usize) -> Option<Self> {
        let of = &scene.drives[drive];
        let span = of.upper - of.lower;
        if of.continuous || !of.followers.is_empty() || span <= 0.0 {
            return None;
        }
        let end = match [-of.lower, of.upper].map(|side| side < AJAR.0 * span) {
            [true, _] => of.upper,
            [_, true] => of.lower,
            _ => return None,
        };
        let rest = &scene.at_rest.links;
        let carried = scene.carried_bodies(drive).into_iter().flat_map(|b| &scene.bodies[b].links);
        let moved = carried.flat_map(|&link| {
            let of = triangles(&scene.robot.links[link]);
            of.into_iter().map(move |t| t.map(|p| rest[link].transform_point(p)))
        });
        let points = spread(&moved.collect::<Vec<_>>(), POINTS);
        let unmoved = scene.bodies.iter().filter(|body| !body.moved_by[drive]);
        let still = unmoved.flat_map(|b| &b.links).map(|&l| (rest[l], study.seen(l))).collect();
        let joint = &scene.robot.joints[of.joint];
        let frame = rest[joint.parent] * joint.origin;
        Some(Self { scene, drive, end, frame, points, still, reach: LIES * scene.diagonal })
    }

    /// The share of what moves that lies against what does not, where the joint stands at `q`.
    fn against(&self, q: f64) -> f64 {
        let joint = &self.scene.robot.joints[self.scene.drives[self.drive].joint];
        let moved = self.frame * joint.motion(q) * self.frame.inverse();
        let is_near = |spot: &&Spot| {
            let there = moved.transform_point(spot.at);
            self.still.iter().any(|(pose, surface)| {
                surface.distance(pose.inverse_transform_point(there), self.reach) < self.reach
            })
        };
        let count = self.points.iter().filter(is_near).count();
        count as f64 / self.points.len().max(1) as f64
    }

    /// How much more of a turning part lies against the rest beyond its range, or how much of a slide comes free
    /// there, and what is to be said of that.
    fn finding(&self) -> Result<(f64, Option<String>), TooMuchWork> {
        let least = BACK * self.end.abs();
        let turns = self.scene.turns(self.drive);
        let most = if turns { std::f64::consts::PI } else { f64::INFINITY };
        let look = (FARTHEST * self.end.abs()).min(most) * -self.end.signum();
        let shown = self.against(0.0);
        if !turns && (shown < INSIDE || self.end.abs() < STROKE * self.scene.diagonal) {
            return Ok((0.0, None));
        }
        let free = sweep(self.scene, self.drive, look)?.first_hit.unwrap_or(look);
        let name = self.scene.name(self.drive);
        if !turns {
            let is_out = free.abs() >= self.end.abs() && self.against(self.end) >= shown;
            let loss = if is_out { shown - self.against(-self.end) } else { 0.0 };
            let told = || format!("joint `{name}`: goes in, and is free to come out");
            return Ok((loss.max(0.0), (loss >= OUT).then(told)));
        }
        let places = (1..=LOOKS).map(|i| free * f64::from(i) / f64::from(LOOKS));
        let looks = places.filter(|q| q.abs() >= least).map(|q| (self.against(q), q));
        let Some((closest, q)) = looks.max_by(|a, b| a.0.total_cmp(&b.0)) else {
            return Ok((0.0, None));
        };
        let told = || {
            let way = self.scene.shown(self.drive, q);
            format!(
                "joint `{name}`: {:.0} % of what it turns lies against the rest at {way}, outside its range, and \
                 {:.0} % as shown",
                100.0 * closest,
                100.0 * shown
            )
        };
        Ok(((closest - shown).max(0.0), (closest - shown >= CLOSER).then(told)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CheckOptions;
    use crate::read::load::from_text;

    /// A case of 1 by 0.5 by 1 m and what a joint holds on it: its sizes, its middle in its own frame, and where
    /// that frame stands.
    fn told(joint: &str, [size, middle, stands]: [&str; 3], [lower, upper]: [f64; 2]) -> Check {
        let link = |name: &str, middle: &str, size: &str| {
            let shape =
                format!(r#"<origin xyz="{middle}"/><geometry><box size="{size}"/></geometry>"#);
            format!(
                r#"<link name="{name}"><visual>{shape}</visual><collision>{shape}</collision></link>"#
            )
        };
        let (case, part) = (link("case", "0 0 0", "1 0.5 1"), link("part", middle, size));
        let text = format!(
            r#"<robot name="r">{case}{part}<joint name="j" {joint}<parent link="case"/><child link="part"/>
            <origin xyz="{stands}"/><limit lower="{lower}" upper="{upper}" effort="1" velocity="1"/></joint>
            </robot>"#
        );
        let robot = from_text(&text, ".".as_ref(), &CheckOptions::default()).robot.unwrap();
        beyond(&Study::new(&robot))
    }

    const HINGE: &str = r#"type="revolute"><axis xyz="0 0 1"/>"#;
    /// A door that is shown open by a quarter turn.
    const OPEN: [&str; 3] = ["0.04 1 1", "0 -0.5 0", "-0.5 -0.28 0"];

    #[test]
    fn a_door_shown_open_that_only_opens_further_is_named() {
        let check = told(HINGE, OPEN, [-1.2, 0.0]);
        assert_eq!(check.evidence.len(), 1, "{check:?}");
        assert!(check.evidence[0].starts_with("joint `j`: "), "{check:?}");
    }

    #[test]
    fn a_door_that_shuts_or_is_shut_is_not_named() {
        assert!(told(HINGE, OPEN, [-0.3, 1.55]).holds());
        let shut = ["1 0.04 1", "0.5 0 0", "-0.5 -0.28 0"];
        assert!(told(HINGE, shut, [-1.5, 0.0]).holds());
    }

    #[test]
    fn a_leaf_that_goes_in_and_is_free_to_come_out_is_named() {
        let slide = r#"type="prismatic"><axis xyz="1 0 0"/>"#;
        // Half under the case.
        let leaf = ["0.6 0.4 0.004", "0 0 0", "0.3 0 -0.505"];
        assert_eq!(told(slide, leaf, [-0.25, 0.0]).evidence.len(), 1);
        assert!(told(slide, leaf, [0.0, 0.25]).holds());
    }
}
