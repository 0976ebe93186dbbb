//! Where a piece of evidence is about: its words name links, joints, their values and places.
//!
//! The checker writes names between backticks, values as `at 12.0 deg` or `at 3.0 mm` behind their
//! joint, pieces as `piece 2` and places as `near [x, y, z] (link frame)`. Names that hold backticks
//! themselves are not found; nothing else depends on them.

use std::collections::BTreeMap;

use glamx::{DPose3, DVec3};
use guard::text::shown;
use page::{Evidence, Place};
use parry3d_f64::query::contact;
use parry3d_f64::shape::ConvexPolyhedron;
use sim_check::checks::sweep::hull::Hull;
use sim_check::robot::{Robot, Shape};

use super::super::seen::values;

/// How near two pieces that overlap may come without touching, metres: what was rounded in the words.
const NEAR: f64 = 0.01;

/// Finds links, joints and places of a robot in words.
pub(super) struct Finder<'a> {
    robot: &'a Robot,
    links: BTreeMap<String, usize>,
    joints: BTreeMap<String, usize>,
}

/// A name between backticks and the words behind it, up to the next.
struct Named<'t> {
    name: &'t str,
    before: &'t str,
    after: &'t str,
}

impl<'a> Finder<'a> {
    pub(super) fn new(robot: &'a Robot) -> Self {
        let names = |all: &mut dyn Iterator<Item = &str>| {
            all.enumerate().map(|(i, name)| (shown(name).into_owned(), i)).collect()
        };
        let links = names(&mut robot.links.iter().map(|l| l.name.as_str()));
        let joints = names(&mut robot.joints.iter().map(|j| j.name.as_str()));
        Self { robot, links, joints }
    }

    /// The evidence with what its words lead to.
    pub(super) fn find(&self, text: &str) -> Evidence {
        let mut found = Evidence { text: text.to_owned(), ..Evidence::default() };
        let mut pieces = Vec::new();
        for named in names(text) {
            match (self.links.get(named.name), self.joints.get(named.name)) {
                (Some(&link), joint) if joint.is_none() || !named.is_joint() => {
                    found.links.push(link);
                    pieces.push((link, named.piece()));
                }
                (_, Some(&joint)) => self.add_joint(&mut found, joint, &named, text),
                _ => {}
            }
        }
        let link = pieces.first().map(|p| p.0);
        let said = place(text).zip(link).map(|(at, link)| Place { link, at });
        found.place = said.or_else(|| match pieces[..] {
            [a, b] if text.contains("overlap") => self.meeting(&found.pose, a, b),
            _ => None,
        });
        if found.place.is_none() && pieces.is_empty() {
            // A joint is where its child has its frame.
            found.place = found.links.first().map(|&link| Place { link, at: DVec3::ZERO });
        }
        found
    }

    fn add_joint(&self, found: &mut Evidence, joint: usize, named: &Named, text: &str) {
        let of = &self.robot.joints[joint];
        let value = value(named.after, " at ").or_else(|| {
            let main = of.ends().map_or(1.0, |(low, high)| if high >= -low { 1.0 } else { -1.0 });
            value(named.after, "collides after ").map(|v| v * main)
        });
        found.pose.extend(value.map(|v| (joint, v)));
        // Where parts overlap, the words name them, and the joint says only the pose.
        if value.is_none() || !text.contains("overlap") {
            found.links.push(of.child);
        }
    }

    /// Where two pieces meet in a pose.
    fn meeting(
        &self,
        pose: &[(usize, f64)],
        a: (usize, Option<usize>),
        b: (usize, Option<usize>),
    ) -> Option<Place> {
        let poses = self.robot.link_poses(&values(self.robot, pose));
        let (here, there) = (*poses.get(a.0)?, *poses.get(b.0)?);
        let (ours, theirs) = (self.hulls(a), self.hulls(b));
        let mut deepest: Option<(f64, DVec3)> = None;
        for (one, own) in &ours {
            for (other, its) in &theirs {
                let met = contact(&(here * *own), one, &(there * *its), other, NEAR);
                let Ok(Some(met)) = met else { continue };
                if deepest.is_none_or(|(depth, _)| met.dist < depth) {
                    deepest = Some((met.dist, (met.point1 + met.point2) / 2.0));
                }
            }
        }
        let (_, at) = deepest?;
        Some(Place { link: a.0, at: here.inverse() * at })
    }

    /// The pieces asked for, each in its own frame, with that frame in the link's.
    fn hulls(&self, (link, piece): (usize, Option<usize>)) -> Vec<(ConvexPolyhedron, DPose3)> {
        let all = self.robot.links[link].collisions.iter().enumerate();
        let asked = all.filter(|(i, _)| piece.is_none_or(|p| p == *i));
        let hull = |s: &Shape| Some((Hull::of(&s.geometry).ok()?.to_polyhedron()?, s.origin));
        asked.filter_map(|(_, shape)| hull(shape)).collect()
    }
}

impl Named<'_> {
    fn is_joint(&self) -> bool {
        self.before.ends_with("joint ") || value(self.after, " at ").is_some()
    }

    fn piece(&self) -> Option<usize> {
        let rest = self.after.strip_prefix(" piece ")?;
        rest.split(|c: char| !c.is_ascii_digit()).next()?.parse().ok()
    }
}

fn names(text: &str) -> Vec<Named<'_>> {
    let parts: Vec<_> = text.split('`').collect();
    let triples = parts.windows(3).step_by(2);
    triples.map(|p| Named { before: p[0], name: p[1], after: p[2] }).collect()
}

/// The number behind a word, in radians or metres: `at 12.0 deg`, `at -3.5 mm`.
fn value(text: &str, word: &str) -> Option<f64> {
    let (_, rest) = text.split_once(word)?;
    let mut words = rest.split([' ', ':', ',']);
    let number: f64 = words.next()?.parse().ok()?;
    match words.next()? {
        "deg" => Some(number.to_radians()),
        "mm" => Some(number / 1000.0),
        _ => None,
    }
}

/// The place in words such as `near [0.1, 0, -0.2] (link frame)`.
fn place(text: &str) -> Option<DVec3> {
    let (_, rest) = text.split_once("near [")?;
    let (numbers, rest) = rest.split_once(']')?;
    let numbers: Vec<f64> = numbers.split(',').filter_map(|n| n.trim().parse().ok()).collect();
    match numbers[..] {
        [x, y, z] if rest.starts_with(" (link frame)") => Some(DVec3::new(x, y, z)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sim_check::CheckOptions;
    use sim_check::read::load::from_text;

    /// A block of 0.2 m at x = 0 that slides along x, towards a wall at 0.4, and has a flap.
    fn robot() -> Robot {
        let block = |name: &str, x: f64| {
            let shape =
                format!(r#"<origin xyz="{x} 0 0"/><geometry><box size="0.2 0.2 0.2"/></geometry>"#);
            let twice = format!("<collision>{shape}</collision>").repeat(2);
            format!(r#"<link name="{name}"><visual>{shape}</visual>{twice}</link>"#)
        };
        let joint = |name: &str, kind: &str, child: &str| {
            format!(
                r#"<joint name="{name}" type="{kind}"><parent link="wall"/><child link="{child}"/>
                <axis xyz="1 0 0"/><limit lower="0" upper="0.5" effort="1" velocity="1"/></joint>"#
            )
        };
        let text = [
            block("wall", 0.4),
            block("block", 0.0),
            block("flap", 3.0),
            joint("slide", "prismatic", "block"),
            joint("flap", "revolute", "flap"),
        ];
        let text = format!("<robot name=\"r\">{}</robot>", text.concat());
        from_text(&text, ".".as_ref(), &CheckOptions::default()).robot.unwrap()
    }

    #[test]
    fn an_overlap_is_marked_where_the_pieces_meet_in_its_pose() {
        let robot = robot();
        let words =
            "joint `slide` at 250.0 mm: `wall` piece 0 and `block` piece 1 overlap by 50.00 mm";
        let found = Finder::new(&robot).find(words);
        assert_eq!((found.pose, found.links), (vec![(0, 0.25)], vec![0, 1]));
        let Place { link, at } = found.place.unwrap();
        assert!(link == 0 && (0.29..=0.36).contains(&at.x), "{at:?}");
    }

    #[test]
    fn several_joints_have_a_value_each_and_a_name_of_both_is_told_apart() {
        let robot = robot();
        let words =
            "`slide` at 100.0 mm, `flap` at -90.0 deg: `wall` and `flap` overlap by 2.00 mm";
        let found = Finder::new(&robot).find(words);
        assert_eq!(found.pose, [(0, 0.1), (1, -90f64.to_radians())]);
        assert_eq!((found.links, found.place), (vec![0, 2], None), "they do not meet");
    }

    #[test]
    fn places_are_read_in_the_frame_of_their_link() {
        let robot = robot();
        let words = "link `block`: a collision piece leaves the surface by 3 mm, near [0.128, -0.020, 0.083] (link frame)";
        let found = Finder::new(&robot).find(words);
        let expected = Place { link: 1, at: DVec3::new(0.128, -0.02, 0.083) };
        assert_eq!((found.place, found.links), (Some(expected), vec![1]));
    }

    #[test]
    fn a_joint_is_marked_where_it_stands() {
        let robot = robot();
        let finder = Finder::new(&robot);
        let found = finder.find("line 3: joint `flap` has no effort");
        assert_eq!(found.place, Some(Place { link: 2, at: DVec3::ZERO }));
        let found =
            finder.find("joint `slide` collides after 200.0 mm the way it opens, but is free");
        assert_eq!(found.pose, [(0, 0.2)]);
    }

    #[test]
    fn words_about_nothing_lead_nowhere() {
        let robot = robot();
        for words in
            ["", "`", "``", "`nobody` at 3 deg", "near [1, 2] (link frame)", "a ` b ` c ` d"]
        {
            let found = Finder::new(&robot).find(words);
            assert!(
                found.pose.is_empty() && found.place.is_none() && found.links.is_empty(),
                "{words}"
            );
        }
    }
}
