//! What became of the parts and joints of one object, face by face: what a fit and a question need to know,
//! without clouds of points.

use model::Articulation;
use model::features::UnitCube;
use object::{DVec3, Mesh};

use super::{links_in, solver};
use crate::metrics::scores::RIGHT_IOU;
use crate::metrics::{Body, JointComparison, Link, compare_joints};

/// What became of an object whose condition has the true parts in order.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// For each true part, the IoU of its surface by area, 0 to 1.
    pub ious: Vec<f64>,
    /// Every true joint.
    pub joints: Vec<JointComparison>,
}

impl Outcome {
    /// Of a mesh, the true part of each face, and its true joints.
    pub fn of((mesh, part_of_face, links): (&Mesh, &[u16], &[Link]), made: &Articulation) -> Self {
        let ious = ious((mesh, part_of_face, links.len()), made);
        Self { ious, joints: joints((mesh, links), made) }
    }

    /// Whether a part is right.
    pub fn is_part_right(&self, part: usize) -> bool {
        self.ious.get(part).is_some_and(|iou| *iou >= RIGHT_IOU)
    }

    /// Whether every part and every joint is.
    pub fn is_right(&self) -> bool {
        let parts = (0..self.ious.len()).all(|part| self.is_part_right(part));
        parts && self.joints.iter().all(JointComparison::is_right)
    }
}

fn ious((mesh, part_of_face, count): (&Mesh, &[u16], usize), made: &Articulation) -> Vec<f64> {
    let found = solver::labels_by_condition(made);
    let (mut both, mut either) = (vec![0.0; count], vec![f64::MIN_POSITIVE; count]);
    for (face, (&a, &b)) in part_of_face.iter().zip(&found).enumerate() {
        let area = mesh.area(face);
        let (a, b) = (usize::from(a), usize::from(b));
        either[a] += area;
        if a == b {
            both[a] += area;
        } else {
            either[b] += area;
        }
    }
    both.iter().zip(either).map(|(both, either)| both / either).collect()
}

fn joints((mesh, links): (&Mesh, &[Link]), made: &Articulation) -> Vec<JointComparison> {
    let cube = UnitCube::of(mesh);
    let body = |links: &[Link]| Body::new(vec![DVec3::ZERO], vec![0], links_in(links, cube)).ok();
    let (Some(found), Some(wanted)) = (body(&solver::links(made)), body(links)) else {
        return Vec::new();
    };
    let pairs = (0..links.len()).map(|part| {
        let is_there = made.part_of_condition.get(part).is_some_and(Option::is_some);
        (part as u16, is_there.then_some(part as u16))
    });
    compare_joints(&found, &wanted, pairs)
}
