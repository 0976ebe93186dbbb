//! The numbers of `urdf-rs`'s model, put into the outline that our own pass drew.

use glamx::{DMat3, DPose3, DQuat, DVec3};
use urdf_rs::{JointType, Pose};

use crate::read::draft::{Draft, JointDraft};
use crate::robot::{Geometry, Inertial, Link, Motion, Shape};

/// Fills in every number of the outline.
///
/// # Errors
/// Where the model is not the one of the outline; then some of the numbers are still zero.
pub(super) fn fill(draft: &mut Draft, robot: &urdf_rs::Robot) -> Result<(), String> {
    same("links", draft.links.len(), robot.links.len())?;
    same("joints", draft.joints.len(), robot.joints.len())?;
    for (link, read) in draft.links.iter_mut().zip(&robot.links) {
        fill_link(link, read)?;
    }
    for (joint, read) in draft.joints.iter_mut().zip(&robot.joints) {
        fill_joint(joint, read)?;
    }
    Ok(())
}

fn same(what: &str, seen: usize, read: usize) -> Result<(), String> {
    if seen == read { Ok(()) } else { Err(format!("of {seen} {what} it reads {read}")) }
}

fn fill_link(link: &mut Link, read: &urdf_rs::Link) -> Result<(), String> {
    if let Some(inertial) = &mut link.inertial {
        fill_inertial(inertial, &read.inertial);
    }
    same("visuals", link.visuals.len(), read.visual.len())?;
    same("collisions", link.collisions.len(), read.collision.len())?;
    for (shape, read) in link.visuals.iter_mut().zip(&read.visual) {
        fill_shape(shape, &read.origin, &read.geometry)?;
    }
    for (shape, read) in link.collisions.iter_mut().zip(&read.collision) {
        fill_shape(shape, &read.origin, &read.geometry)?;
    }
    Ok(())
}

fn fill_inertial(inertial: &mut Inertial, read: &urdf_rs::Inertial) {
    let i = &read.inertia;
    let column = DVec3::new;
    inertial.origin = pose(&inertial.origin, &read.origin);
    inertial.mass = read.mass.value;
    inertial.inertia = DMat3::from_cols(
        column(i.ixx, i.ixy, i.ixz),
        column(i.ixy, i.iyy, i.iyz),
        column(i.ixz, i.iyz, i.izz),
    );
}

fn fill_shape(shape: &mut Shape, origin: &Pose, read: &urdf_rs::Geometry) -> Result<(), String> {
    use urdf_rs::Geometry as Read;
    shape.origin = pose(&shape.origin, origin);
    match (&mut shape.geometry, read) {
        (Geometry::Box { size }, Read::Box { size: read }) => *size = DVec3::from_array(read.0),
        (Geometry::Sphere { radius }, Read::Sphere { radius: read }) => *radius = *read,
        (Geometry::Cylinder { radius, length }, Read::Cylinder { radius: r, length: l })
        | (Geometry::Capsule { radius, length }, Read::Capsule { radius: r, length: l }) => {
            (*radius, *length) = (*r, *l);
        }
        (Geometry::Mesh(_) | Geometry::Unread { .. }, Read::Mesh { scale, .. }) => {
            shape.scale = scale.map_or(DVec3::ONE, |scale| DVec3::from_array(scale.0));
        }
        // Our own pass found that it cannot be had; what it reads instead stands for nothing.
        (Geometry::Unread { .. }, _) => {}
        _ => return Err(format!("line {}: it reads another shape", shape.line)),
    }
    Ok(())
}

fn fill_joint(draft: &mut JointDraft, read: &urdf_rs::Joint) -> Result<(), String> {
    let joint = &mut draft.joint;
    joint.kind = motion(&read.joint_type).ok_or("it reads a joint type that URDF does not have")?;
    joint.origin = pose(&joint.origin, &read.origin);
    joint.axis_as_written = DVec3::from_array(read.axis.xyz.0);
    joint.axis = joint.axis_as_written.normalize_or_zero();
    if let Some(limit) = &mut joint.limit {
        (limit.lower, limit.upper) = (read.limit.lower, read.limit.upper);
        limit.effort = limit.effort.map(|_| read.limit.effort);
        limit.velocity = limit.velocity.map(|_| read.limit.velocity);
    }
    if let (Some(dynamics), Some(read)) = (&mut joint.dynamics, &read.dynamics) {
        dynamics.damping = dynamics.damping.map(|_| read.damping);
        dynamics.friction = dynamics.friction.map(|_| read.friction);
    }
    if let (Some(mimic), Some(read)) = (&mut draft.mimic, &read.mimic) {
        mimic.multiplier = read.multiplier.unwrap_or(1.0);
        mimic.offset = read.offset.unwrap_or(0.0);
    }
    Ok(())
}

fn motion(read: &JointType) -> Option<Motion> {
    Some(match read {
        JointType::Fixed => Motion::Fixed,
        JointType::Revolute => Motion::Revolute,
        JointType::Continuous => Motion::Continuous,
        JointType::Prismatic => Motion::Prismatic,
        JointType::Floating => Motion::Floating,
        JointType::Planar => Motion::Planar,
        JointType::Spherical => return None,
    })
}

/// Translation, then yaw about z, pitch about y, roll about x, as URDF has it; or the quaternion of
/// the outline.
fn pose(drawn: &DPose3, read: &Pose) -> DPose3 {
    let [roll, pitch, yaw] = read.rpy.0;
    let turn =
        DQuat::from_rotation_z(yaw) * DQuat::from_rotation_y(pitch) * DQuat::from_rotation_x(roll);
    let turn = if drawn.rotation == DQuat::IDENTITY { turn } else { drawn.rotation };
    DPose3::from_parts(DVec3::from_array(read.xyz.0), turn)
}
