//! An object in another pose: the mesh as it then looks, with axes and ranges carried along.

use std::collections::BTreeMap;

use glamx::DPose3;

use crate::articulated::{ArticulatedObject, JointMotion, ObjectError, Range};
use crate::mesh::{Mesh, MeshError};
use crate::pose::{Configuration, joint_pose, part_poses};

/// Why an object cannot be posed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PoseError {
    /// Its surface.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// Its joints.
    #[error(transparent)]
    Object(#[from] ObjectError),
}

/// The object as it stands at `q`, which becomes its rest pose. Vertices that faces of several
/// parts use are split.
///
/// # Errors
/// [`PoseError`] when values outside the ranges leave the rest pose out of a range.
pub fn posed(
    object: &ArticulatedObject,
    q: &Configuration,
) -> Result<ArticulatedObject, PoseError> {
    let poses = part_poses(object, q);
    let tree = object.tree();
    let joints = |part: usize| {
        let parent = tree.parent(part).map_or(DPose3::identity(), |p| poses[p]);
        moved_joints(object.joints(part), &q.0[part], parent)
    };
    let joints = (0..tree.len()).map(joints).collect();
    let mesh = posed_mesh(object, &poses)?;
    let labels = object.part_of_face().to_vec();
    Ok(ArticulatedObject::new(mesh, tree.clone(), labels, joints)?)
}

fn posed_mesh(object: &ArticulatedObject, poses: &[DPose3]) -> Result<Mesh, MeshError> {
    let mesh = object.mesh();
    let mut number: BTreeMap<(u32, u16), u32> = BTreeMap::new();
    let mut vertices = Vec::new();
    let mut corner = |vertex: u32, part: u16| {
        *number.entry((vertex, part)).or_insert_with(|| {
            vertices.push(poses[usize::from(part)] * mesh.vertices()[vertex as usize]);
            vertices.len() as u32 - 1
        })
    };
    let pairs = mesh.faces().iter().zip(object.part_of_face());
    let faces = pairs.map(|(face, &part)| face.map(|v| corner(v, part))).collect();
    Ok(Mesh::new(vertices, faces)?.with_frame(mesh.frame()))
}

/// Joints of one part, each carried by those before it, with ranges counted from where it stands.
fn moved_joints(joints: &[JointMotion], q: &[f64], mut before: DPose3) -> Vec<JointMotion> {
    let mut out = Vec::with_capacity(joints.len());
    for (motion, &q) in joints.iter().zip(q) {
        let range = match motion.range {
            Range::Continuous => Range::Continuous,
            Range::Limits { lower, upper } => {
                Range::Limits { lower: (lower - q).min(0.0), upper: (upper - q).max(0.0) }
            }
        };
        let axis = (before.rotation * motion.axis).normalize();
        out.push(JointMotion { axis, pivot: before * motion.pivot, range, ..*motion });
        before *= joint_pose(motion, q);
    }
    out
}
