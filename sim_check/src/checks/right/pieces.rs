//! R6: pieces that touch nothing of their link and lie along another: a front that stays behind, a panel that
//! is given to the body. What only slides along the other link is beside it for good reason: a drawer in its case.

use std::collections::BTreeMap;

use glamx::{DPose3, DVec3};
use object::mesh::Bounds;
use object::weld::{DisjointSets, Weld};

use super::spread::{Spot, Triangle, area, spread};
use crate::checks::study::{Study, triangles};
use crate::geometry::near::BoxTree;
use crate::geometry::near::islands::Islands;
use crate::geometry::tessellate::tessellated;
use crate::profile::bounds::{ALONG, LOOSE_PIECE, PARTS, TOUCH, TWICE};
use crate::robot::{Geometry, Link, Robot};
use crate::verdict::Check;

/// How many points stand for a piece.
const POINTS: usize = 400;

/// All links; the largest piece of each is its own whatever lies beside it.
pub(super) fn pieces(study: &Study) -> Check {
    let robot = study.robot;
    let poses = robot.link_poses(&[]);
    let corners = |link: usize| {
        let of = robot.links.get(link).map(triangles).unwrap_or_default();
        of.into_iter().flatten().map(|p| poses[link].transform_point(p)).collect::<Vec<_>>()
    };
    let bounds = Bounds::of((0..robot.links.len()).flat_map(corners));
    let diagonal = bounds.diagonal();
    let seen = |link: &Link| triangles(link).iter().map(area).sum::<f64>();
    let all: f64 = robot.links.iter().map(seen).sum();
    let (mut faults, mut most) = (Vec::new(), 0.0_f64);
    let bodies = robot.body_of_link();
    for (link, of) in robot.links.iter().enumerate() {
        let clusters = clusters(study, link, TOUCH * diagonal);
        let whole: f64 = clusters.iter().flatten().map(area).sum();
        let share = |cluster: &[Triangle]| cluster.iter().map(area).sum::<f64>() / whole;
        let sizes: Vec<f64> = clusters.iter().map(|c| share(c)).collect();
        let largest = sizes.iter().copied().fold(0.0, f64::max);
        let least = LOOSE_PIECE.max(LOOSE_PIECE * all / whole);
        let of_note = |k: &usize| (least..largest).contains(&sizes[*k]);
        for k in (0..clusters.len()).filter(of_note) {
            let points = spread(&clusters[k], POINTS);
            let rest = clusters.iter().enumerate().filter(|(other, _)| *other != k);
            let own = BoxTree::new(rest.flat_map(|(_, c)| c.iter().copied()).collect());
            let reach = ALONG * diagonal;
            let count = points.len().max(1) as f64;
            let own = points.iter().filter(|spot| own.distance(spot.at, reach) < reach).count();
            let own = own as f64 / count;
            let along = |other: usize| {
                let there = poses[other].inverse() * poses[link];
                let parting = Parting::of(robot, [link, other], &poses);
                let surface = study.seen(other);
                let is_beside = |spot: &&Spot| {
                    surface.distance(there.transform_point(spot.at), reach) < reach
                        && parting.is_parted(poses[link], spot)
                };
                (points.iter().filter(is_beside).count() as f64 / count, other)
            };
            let others = (0..robot.links.len()).filter(|&l| bodies[l] != bodies[link]);
            let beside = others.map(along).max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
            let Some((beside, other)) = beside else { continue };
            most = most.max(beside - TWICE * own);
            if beside >= LOOSE_PIECE && beside > TWICE * own {
                let middle = points.iter().map(|spot| spot.at).sum::<DVec3>() / count;
                let [x, y, z] = poses[link].transform_point(middle).to_array();
                faults.push(format!(
                    "link `{}`: {:.0} % of it, about {x:.3} {y:.3} {z:.3} m, touches nothing of it and lies \
                     along `{}`",
                    of.name,
                    100.0 * sizes[k],
                    robot.links[other].name
                ));
            }
        }
    }
    Check::from_faults("R6", faults).value(most.max(0.0))
}

/// How one of two links moves against the other, root frame.
enum Parting {
    /// About or along an axis through a place.
    Joint { at: DVec3, axis: DVec3, turns: bool },
    /// Not by a joint between them.
    Unknown,
}

impl Parting {
    fn of(robot: &Robot, [one, two]: [usize; 2], poses: &[DPose3]) -> Self {
        let child = if robot.is_under(two, one) {
            two
        } else if robot.is_under(one, two) {
            one
        } else {
            return Self::Unknown;
        };
        let Some(joint) = robot.joint_above(child).and_then(|j| robot.joints.get(j)) else {
            return Self::Unknown;
        };
        let frame = poses[joint.parent] * joint.origin;
        let (at, axis) = (frame.translation, frame.rotation * joint.axis);
        Self::Joint { at, axis, turns: joint.kind.turns() }
    }

    /// Whether what lies against a point of a link parts from it rather than slides along it.
    fn is_parted(&self, pose: DPose3, spot: &Spot) -> bool {
        let (place, normal) = (pose.transform_point(spot.at), pose.rotation * spot.normal);
        match self {
            Self::Unknown => true,
            Self::Joint { at, axis, turns } => {
                let way = if *turns { axis.cross(place - *at) } else { *axis };
                way.normalize_or_zero().dot(normal).abs() >= PARTS
            }
        }
    }
}

/// The triangles of a link, link frame, by what hangs together or comes as near as `touch` metres.
fn clusters(study: &Study, link: usize, touch: f64) -> Vec<Vec<Triangle>> {
    let Some(of) = study.robot.links.get(link) else { return Vec::new() };
    let islands = islands(of);
    let count = islands.iter().max().map_or(0, |most| *most as usize + 1);
    let mut sets = DisjointSets::new(count);
    if count > 1 {
        Islands::new(study.seen(link), &islands).join_own(touch, &mut sets);
    }
    let mut found: BTreeMap<u32, Vec<Triangle>> = BTreeMap::new();
    for (triangle, island) in triangles(of).into_iter().zip(islands) {
        found.entry(sets.root(island)).or_default().push(triangle);
    }
    found.into_values().collect()
}

/// The connected surface that each triangle of a link is of, in the order of [`triangles`].
fn islands(link: &Link) -> Vec<u32> {
    let (mut all, mut first) = (Vec::new(), 0);
    let mut add = |mesh: &object::Mesh| {
        let (of_face, count) = Weld::new(mesh).components();
        all.extend(of_face.into_iter().map(|c| first + c));
        first += u32::try_from(count).unwrap_or(u32::MAX);
    };
    for shape in &link.visuals {
        match &shape.geometry {
            Geometry::Mesh(mesh) => add(mesh),
            other => tessellated(other).iter().for_each(&mut add),
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CheckOptions;
    use crate::read::load::from_text;

    /// A body with a slab before it that touches nothing, and a door before that, which slides along an axis.
    fn told(axis: &str) -> Check {
        let shape = |y: f64, size: &str| {
            format!(
                r#"<visual><origin xyz="0 {y} 0"/><geometry><box size="{size}"/></geometry></visual>"#
            )
        };
        let slab = "0.9 0.02 0.9";
        let (body, front) = (shape(0.0, "1 1 1"), [-0.6, -0.625].map(|y| shape(y, slab)));
        let [loose, door] = front;
        let text = format!(
            r#"<robot name="r"><link name="body">{body}{loose}</link><link name="door">{door}</link>
            <joint name="slide" type="prismatic"><parent link="body"/><child link="door"/>
            <axis xyz="{axis}"/><limit lower="0" upper="0.3" effort="1" velocity="1"/></joint></robot>"#
        );
        let robot = from_text(&text, ".".as_ref(), &CheckOptions::default()).robot.unwrap();
        pieces(&Study::new(&robot))
    }

    #[test]
    fn a_front_that_stays_behind_is_named_with_its_place() {
        let check = told("0 -1 0");
        assert_eq!(check.evidence.len(), 1, "{check:?}");
        let said = &check.evidence[0];
        assert!(said.contains("`body`: 22 %") && said.contains("-0.600"), "{said}");
        assert!(said.ends_with("lies along `door`"), "{said}");
    }

    #[test]
    fn what_merely_slides_along_another_link_is_not_named() {
        assert!(told("1 0 0").holds());
    }
}
