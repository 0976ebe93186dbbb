//! An object in another pose: the mesh as it then looks, with axes and ranges carried along.

use std::collections::BTreeMap;

use object::articulated::ObjectError;
use object::mesh::MeshError;
use object::pose::{joint_pose, part_poses};
use object::{ArticulatedObject, Configuration, DPose3, JointMotion, Mesh, Range};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

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

/// A configuration drawn evenly from the range of every joint.
pub fn random_configuration(object: &ArticulatedObject, rng: &mut Pcg64Mcg) -> Configuration {
    let mut value = |motion: &JointMotion| {
        let (lower, upper) = motion.range.ends();
        lower + (upper - lower) * rng.random::<f64>()
    };
    let parts = 0..object.tree().len();
    Configuration(parts.map(|p| object.joints(p).iter().map(&mut value).collect()).collect())
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

#[cfg(test)]
mod tests {
    use rand::SeedableRng;

    use super::*;
    use crate::procedural::FAMILIES;

    /// The fan: a head that tilts, and blades that turn on it.
    fn fan() -> ArticulatedObject {
        FAMILIES.iter().find(|f| f.name == "fan").unwrap().make().unwrap().object
    }

    #[test]
    fn an_object_at_rest_stays_as_it_is() {
        let fan = fan();
        let same = posed(&fan, &Configuration::rest(fan.tree())).unwrap();
        for face in 0..fan.mesh().faces().len() {
            assert_eq!(same.mesh().corners(face), fan.mesh().corners(face));
        }
        assert_eq!(same.joints(2), fan.joints(2));
    }

    #[test]
    fn moving_on_from_a_pose_ends_where_moving_at_once_does() {
        let fan = fan();
        let first = Configuration(vec![vec![], vec![0.25], vec![1.1]]);
        let then = Configuration(vec![vec![], vec![-0.5], vec![0.7]]);
        let sum = Configuration(vec![vec![], vec![-0.25], vec![1.8]]);
        let twice = posed(&posed(&fan, &first).unwrap(), &then).unwrap();
        let once = posed(&fan, &sum).unwrap();
        for face in (0..fan.mesh().faces().len()).step_by(97) {
            let [a, b] = [&twice, &once].map(|o| o.mesh().corners(face)[1]);
            assert!((a - b).length() < 1e-12);
        }
        let Range::Limits { lower, upper } = twice.joints(1)[0].range else { panic!() };
        assert!((lower + 0.15).abs() < 1e-12 && (upper - 0.65).abs() < 1e-12);
    }

    #[test]
    fn a_random_configuration_lies_in_every_range_and_repeats() {
        let fan = fan();
        let draw = |seed| random_configuration(&fan, &mut Pcg64Mcg::seed_from_u64(seed));
        assert_eq!(draw(3), draw(3));
        assert_ne!(draw(3), draw(4));
        assert!(draw(3).0[1][0].abs() <= 0.4);
    }
}
