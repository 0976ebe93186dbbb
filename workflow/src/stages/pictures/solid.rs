//! All that is seen of a robot as one surface, whose links can be put in any pose.

use glamx::{DPose3, DVec3};
use object::Mesh;
use object::mesh::Bounds;
use object::simplify::{Triangles, simpler};
use sim_check::robot::{Joint, Motion, Robot};
use view::{Camera, Paint, Picture, Renderer, draw_axis, part_colour};

use super::super::seen::{surface, values};

/// Length of an axis to either side of its pivot, as a share of the object's diagonal.
const REACH: f64 = 0.16;

/// A robot and all that is seen of it.
pub(super) struct Solid<'a> {
    pub robot: &'a Robot,
    /// All links at rest, in the root's frame.
    pub mesh: Mesh,
    /// The link of each face.
    pub link_of_face: Vec<u16>,
    /// The link of each vertex.
    link_of_vertex: Vec<u16>,
    /// Where each link stands at rest.
    rest: Vec<DPose3>,
}

impl<'a> Solid<'a> {
    /// None where nothing can be seen.
    pub(super) fn of(robot: &'a Robot) -> Option<Self> {
        Self::built(robot, &|mesh| mesh)
    }

    /// The same with about so many faces, where it has more.
    pub(super) fn thinned(&self, most: usize) -> Option<Self> {
        let share = most as f64 / self.mesh.faces().len() as f64;
        let thin = |mesh: Mesh| {
            let target = (mesh.faces().len() as f64 * share).ceil() as usize;
            simpler(&mesh, target, Triangles::Any).unwrap_or(mesh)
        };
        Self::built(self.robot, &|mesh| if share < 1.0 { thin(mesh) } else { mesh })
    }

    fn built(robot: &'a Robot, made: &dyn Fn(Mesh) -> Mesh) -> Option<Self> {
        let rest = robot.link_poses(&values(robot, &[]));
        let (mut vertices, mut faces) = (Vec::new(), Vec::new());
        let (mut link_of_vertex, mut link_of_face) = (Vec::new(), Vec::new());
        for (l, link) in robot.links.iter().enumerate() {
            let own = u16::try_from(l).ok()?;
            for mesh in link.visuals.iter().filter_map(|shape| surface(shape).ok()).map(made) {
                let first = u32::try_from(vertices.len()).ok()?;
                vertices.extend(mesh.vertices().iter().map(|v| rest[l] * *v));
                faces.extend(mesh.faces().iter().map(|f| f.map(|v| v + first)));
                link_of_vertex.resize(vertices.len(), own);
                link_of_face.resize(faces.len(), own);
            }
        }
        let mesh = Mesh::new(vertices, faces).ok()?;
        Some(Self { robot, mesh, link_of_face, link_of_vertex, rest })
    }

    /// How it is painted: each link in the colour it has on the page, too.
    pub(super) fn paint(&self) -> Paint<'_> {
        Paint::Parts(&self.link_of_face)
    }

    /// The joints that move of themselves along or about an axis.
    pub(super) fn drives(&self) -> impl Iterator<Item = (usize, &'a Joint)> {
        let moves = |j: &Joint| j.kind.has_axis() && j.mimic.is_none() && j.axis != DVec3::ZERO;
        self.robot.joints.iter().enumerate().filter(move |(_, j)| moves(j))
    }

    /// How each link moves from where it is at rest, with joints at the values given.
    pub(super) fn moves(&self, pose: &[(usize, f64)]) -> Vec<DPose3> {
        let poses = self.robot.link_poses(&values(self.robot, pose));
        poses.iter().zip(&self.rest).map(|(pose, rest)| *pose * rest.inverse()).collect()
    }

    /// The surface with its links moved.
    pub(super) fn moved(&self, moves: &[DPose3]) -> Option<Mesh> {
        let of = self.mesh.vertices().iter().zip(&self.link_of_vertex);
        let vertices = of.map(|(v, &link)| moves[usize::from(link)] * *v).collect();
        Mesh::new(vertices, self.mesh.faces().to_vec()).ok()
    }

    /// What draws it with its links moved.
    pub(super) fn renderer_of<'b>(
        &'b self,
        rest: &Renderer<'b>,
        mesh: &'b Mesh,
        moves: &[DPose3],
    ) -> Renderer<'b> {
        rest.moved(mesh, |face| moves[usize::from(self.link_of_face[face])].rotation)
    }

    /// Draws a joint's axis as it lies with the links moved: in the colour of what it moves, as an
    /// arrow the way values grow, from its pivot on where it slides.
    pub(super) fn draw_axis(
        &self,
        picture: &mut Picture,
        camera: &Camera,
        joint: &Joint,
        moves: &[DPose3],
    ) {
        let parent = moves[joint.parent] * self.rest[joint.parent];
        let frame = parent * joint.origin;
        let along = frame.rotation * joint.axis * (self.mesh.bounds().diagonal() * REACH);
        let pivot = frame.translation;
        let from = if joint.kind == Motion::Prismatic { pivot } else { pivot - along };
        draw_axis(picture, camera, from, pivot + along, part_colour(self.seen_below(joint.child)));
    }

    /// The link itself, or what hangs below it where nothing is seen of it: several joints of one
    /// part stand with bare links between them.
    pub(super) fn seen_below(&self, link: usize) -> usize {
        let mut at = link;
        // No chain is longer than all links.
        for _ in &self.robot.links {
            let mut below = self.robot.joints.iter().filter(|j| j.parent == at).map(|j| j.child);
            match (below.next(), below.next()) {
                (Some(next), None) if self.robot.links[at].visuals.is_empty() => at = next,
                _ => break,
            }
        }
        at
    }
}

/// The box around a surface in several poses.
pub(super) fn around<'m>(meshes: impl Iterator<Item = &'m Mesh>) -> Bounds {
    Bounds::of(meshes.flat_map(|m| [m.bounds().min, m.bounds().max]))
}
