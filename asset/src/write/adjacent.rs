//! Links that need not collide: those welded together, and those that meet in one joint.

use crate::asset::{Asset, JointType};

/// Pairs of links with geometry, lower index first, sorted, that a simulator should not let collide:
/// links that are rigidly joined, and the bodies on both sides of a moving joint, whose limits keep
/// them apart. A carrier has no geometry, so the bodies on either side of it meet in one joint, too.
pub(crate) fn adjacent(asset: &Asset) -> Vec<[usize; 2]> {
    let bodies = Bodies::of(asset);
    let mut pairs: Vec<[usize; 2]> = Vec::new();
    for a in (0..asset.links.len()).filter(|&l| asset.links[l].body.is_some()) {
        for b in (a + 1..asset.links.len()).filter(|&l| asset.links[l].body.is_some()) {
            let (x, y) = (bodies.of_link[a], bodies.of_link[b]);
            if x == y || bodies.above(asset, x) == Some(y) || bodies.above(asset, y) == Some(x) {
                pairs.push([a, b]);
            }
        }
    }
    pairs
}

/// Which rigid body each link belongs to; a body is named by its first link.
struct Bodies {
    of_link: Vec<usize>,
    is_solid: Vec<bool>,
}

impl Bodies {
    fn of(asset: &Asset) -> Self {
        let mut of_link: Vec<usize> = (0..asset.links.len()).collect();
        for joint in asset.joints.iter().filter(|j| j.kind == JointType::Fixed) {
            of_link[joint.child] = of_link[joint.parent];
        }
        let mut is_solid = vec![false; asset.links.len()];
        for (link, &body) in asset.links.iter().zip(&of_link) {
            is_solid[body] |= link.body.is_some();
        }
        Self { of_link, is_solid }
    }

    /// The nearest body above that has geometry.
    fn above(&self, asset: &Asset, body: usize) -> Option<usize> {
        let parent = |body| Some(self.of_link[asset.joint_of(body)?.parent]);
        let mut next = parent(body)?;
        while !self.is_solid[next] {
            next = parent(next)?;
        }
        Some(next)
    }
}
