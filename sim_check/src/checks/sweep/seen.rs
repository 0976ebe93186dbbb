//! The gap between two bodies as it is seen: between their visual surfaces.
//!
//! Collision pieces may leave the surface by millimetres, so a bound of 3 mm on a gap can only be
//! held against what is seen.

use std::sync::{Arc, OnceLock};

use super::scene::Scene;
use super::stance::Stance;
use crate::checks::study::{Study, is_readable};
use crate::geometry::near::{BoxTree, nearest};
use crate::geometry::tessellate::tessellated;
use crate::robot::Shape;

/// What is seen of each body of a scene, made ready when first asked for.
pub struct Skins<'s, 'a> {
    scene: &'s Scene<'a>,
    study: &'s Study<'a>,
    trees: Vec<OnceLock<Option<Arc<BoxTree>>>>,
}

impl<'s, 'a> Skins<'s, 'a> {
    /// No skin made yet.
    pub(crate) fn new(scene: &'s Scene<'a>, study: &'s Study<'a>) -> Self {
        let trees = scene.bodies.iter().map(|_| OnceLock::new()).collect();
        Self { scene, study, trees }
    }

    /// All visuals of all links of a body, in the frame of its first link; `None` if it shows
    /// nothing, or something that could not be read.
    pub fn of(&self, body: usize) -> Option<&BoxTree> {
        self.trees.get(body)?.get_or_init(|| skin(self.scene, self.study, body)).as_deref()
    }
}

fn skin(scene: &Scene, study: &Study, body: usize) -> Option<Arc<BoxTree>> {
    let rest = &scene.at_rest.links;
    let of = scene.bodies.get(body)?;
    let (first, links) = (of.link, &of.links);
    if !links.iter().all(|&l| is_readable(&scene.robot.links[l])) {
        return None;
    }
    if let [only] = links[..] {
        return Some(study.seen(only)).filter(|tree| !tree.is_empty());
    }
    let mut triangles = Vec::new();
    for &link in links {
        let frame = rest[first].inv_mul(&rest[link]);
        for Shape { geometry, origin, .. } in &scene.robot.links[link].visuals {
            let (mesh, pose) = (tessellated(geometry).ok()?, frame * *origin);
            let corners = |f| mesh.corners(f).map(|p| pose.transform_point(p));
            triangles.extend((0..mesh.faces().len()).map(corners));
        }
    }
    (!triangles.is_empty()).then(|| Arc::new(BoxTree::new(triangles)))
}

/// The gap between what is seen of a guide and of the bodies in it, followed through a motion.
pub struct SeenGap<'a> {
    guide: Seen<'a>,
    carried: Vec<Seen<'a>>,
    /// Where the two last came nearest: for each body a triangle of the guide and one of its own.
    last: Vec<[u32; 2]>,
}

#[derive(Clone, Copy)]
struct Seen<'a> {
    link: usize,
    tree: &'a BoxTree,
}

impl<'a> SeenGap<'a> {
    /// `None` if one of the bodies has no skin.
    pub fn new(
        scene: &'a Scene<'a>,
        skins: &'a Skins,
        guide: usize,
        carried: &[usize],
    ) -> Option<Self> {
        let seen = |&body: &usize| {
            Some(Seen { link: scene.bodies.get(body)?.link, tree: skins.of(body)? })
        };
        let last = vec![[0, 0]; carried.len()];
        let carried = carried.iter().map(seen).collect::<Option<_>>()?;
        Some(Self { guide: seen(&guide)?, carried, last })
    }

    /// The gap in some configuration, metres; anything up to `enough` counts as `enough`.
    pub fn at(&mut self, stance: &mut Stance, enough: f64) -> f64 {
        let to_guide = stance.link(self.guide.link).inverse();
        let mut least = f64::INFINITY;
        for (body, last) in self.carried.iter().zip(&mut self.last) {
            let there = to_guide * stance.link(body.link);
            let found = nearest(self.guide.tree, body.tree, &there, *last, enough);
            *last = found.triangles;
            least = least.min(found.distance);
            if least <= enough {
                return enough;
            }
        }
        least
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use crate::checks::kinematic;
    use crate::checks::sweep::tests::{joint, robot};
    use crate::options::CheckOptions;
    use crate::verdict::{Check, Status};

    type Block = ([f64; 3], [f64; 3]);

    /// A link that is seen as some boxes (middle and size) and touched as another.
    fn part(name: &str, seen: &[Block], touched: Block) -> String {
        let geometry = |(at, size): &Block| {
            let [at, size] = [at, size].map(|v| v.map(|c| c.to_string()).join(" "));
            format!("<origin xyz=\"{at}\"/><geometry><box size=\"{size}\"/></geometry>")
        };
        let seen = seen.iter().map(|b| format!("<visual>{}</visual>", geometry(b)));
        let seen = seen.collect::<String>();
        format!("<link name=\"{name}\">{seen}<collision>{}</collision></link>", geometry(&touched))
    }

    fn c4(body: &str) -> Check {
        let checks = kinematic::checks(&robot(body), &CheckOptions::default());
        checks.into_iter().find(|c| c.id == "C4").unwrap()
    }

    /// A post with its right side at x = 0, from y = −50 to 50 mm.
    fn post() -> String {
        let block = ([-0.05, 0.0, 0.0], [0.1, 0.1, 0.6]);
        part("post", &[block], block)
    }

    /// A door right of it, 20 mm thick, hinged about z at the height `y` of the page.
    fn door(y: f64) -> String {
        let block = ([0.25, -y, 0.0], [0.5, 0.02, 0.6]);
        let hinge = ("revolute", "post", "door");
        part("door", &[block], block)
            + &joint(hinge, [0.0, y, 0.0], [0.0, 0.0, 1.0], [0.0, FRAC_PI_2])
    }

    #[test]
    fn knuckles_that_meet_have_no_gap_though_collision_pieces_are_carved_short() {
        let pin = ([0.0; 3], [0.02, 0.02, 0.6]);
        let frame = part("frame", &[pin], ([0.0; 3], [0.012, 0.012, 0.6]));
        let leaf = part(
            "leaf",
            &[([0.25, 0.0, 0.0], [0.49, 0.02, 0.6])],
            ([0.3, 0.0, 0.0], [0.4, 0.01, 0.6]),
        );
        let hinge = joint(("revolute", "frame", "leaf"), [0.0; 3], [0.0, 0.0, 1.0], [0.0, 2.0]);
        let found = c4(&(frame + &leaf + &hinge));
        assert_eq!((found.status, found.value), (Status::Pass, Some(0.0)), "{found:?}");
    }

    #[test]
    fn a_door_hung_ten_millimetres_off_leaves_a_gap_of_ten() {
        let found = c4(&(post() + &door(0.02)));
        assert_eq!(found.status, Status::Fail, "{found:?}");
        assert!(found.evidence[0].contains("grows by 10.00 mm at 90.0 deg"), "{found:?}");
    }

    #[test]
    fn a_knuckle_of_its_own_link_holds_the_door_it_is_fixed_to() {
        let knuckle = ([0.0; 3], [0.01; 3]);
        let fixed = joint(("fixed", "door", "knuckle"), [0.0; 3], [1.0, 0.0, 0.0], [0.0; 2]);
        let found = c4(&(post() + &door(0.02) + &part("knuckle", &[knuckle], knuckle) + &fixed));
        assert_eq!((found.status, found.value), (Status::Pass, Some(0.0)), "{found:?}");
    }
}
