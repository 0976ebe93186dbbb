//! Results that several groups of checks need of one robot, each computed once, when first asked
//! for.

use std::sync::{Arc, OnceLock};

use crate::checks::sweep::Scene;
use crate::checks::sweep::overlap::overlaps;
use crate::checks::sweep::scene::SceneFault;
use crate::geometry::near::BoxTree;
use crate::geometry::tessellate::tessellated;
use crate::profile::subject::{Base, Subject};
use crate::robot::{Geometry, Link, Robot};

/// A robot under examination.
pub(crate) struct Study<'a> {
    pub robot: &'a Robot,
    /// What it is judged as.
    pub subject: Subject,
    /// Whether its base stands fast, where that was said.
    pub base: Option<Base>,
    /// Whether somebody answers for what overlaps at rest.
    pub is_rest_waived: bool,
    scene: OnceLock<Result<Scene<'a>, SceneFault>>,
    seen: Vec<OnceLock<Arc<BoxTree>>>,
}

impl<'a> Study<'a> {
    /// Nothing made yet of an asset.
    pub(crate) fn new(robot: &'a Robot) -> Self {
        Self::of(robot, Subject::Object, None)
    }

    /// Nothing made yet.
    pub(crate) fn of(robot: &'a Robot, subject: Subject, base: Option<Base>) -> Self {
        let seen = robot.links.iter().map(|_| OnceLock::new()).collect();
        Self { robot, subject, base, is_rest_waived: false, scene: OnceLock::new(), seen }
    }

    /// The robot made ready for contact questions, or why it cannot be.
    pub(crate) fn scene(&self) -> &Result<Scene<'a>, SceneFault> {
        self.scene.get_or_init(|| {
            let mut scene = Scene::of(self.robot, self.subject)?;
            scene.base = self.base;
            if self.leaves_rest() {
                let found = overlaps(&scene, &scene.rest(), |_, _| true);
                scene.leave(found.into_iter().map(|o| (o.pieces, o.depth)).collect());
            }
            Ok(scene)
        })
    }

    /// Whether what overlaps at rest is left alone from there on: of a robot, and where somebody answers for it.
    pub(crate) fn leaves_rest(&self) -> bool {
        self.subject == Subject::Robot || self.is_rest_waived
    }

    /// All visuals of a link that can be read, link frame; no triangles if there are none.
    pub(crate) fn seen(&self, link: usize) -> Arc<BoxTree> {
        let made = || Arc::new(BoxTree::new(self.robot.links.get(link).map_or(vec![], triangles)));
        self.seen.get(link).map_or_else(made, |tree| tree.get_or_init(made).clone())
    }
}

/// What a link shows, link frame: the visuals in order, each face by face; none of what cannot be read.
pub(crate) fn triangles(link: &Link) -> Vec<[glamx::DVec3; 3]> {
    let mut triangles = Vec::new();
    for shape in &link.visuals {
        let mut add = |mesh: &object::Mesh| {
            let corners = |f| mesh.corners(f).map(|p| shape.origin.transform_point(p));
            triangles.extend((0..mesh.faces().len()).map(corners));
        };
        match &shape.geometry {
            Geometry::Mesh(mesh) => add(mesh),
            other => tessellated(other).iter().for_each(add),
        }
    }
    triangles
}

/// Whether everything a link shows can be read.
pub(crate) fn is_readable(link: &Link) -> bool {
    let can = |g: &Geometry| matches!(g, Geometry::Mesh(_)) || tessellated(g).is_ok();
    link.visuals.iter().all(|shape| can(&shape.geometry))
}
