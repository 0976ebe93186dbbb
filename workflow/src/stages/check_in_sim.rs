//! URDF package to verdict: written to disk and read back as a simulator would.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use object::{Condition, DVec3, Mesh, glb};
use runner::{Stage, StageError};
use sim_check::checks::sweep;
use sim_check::read::load;
use sim_check::robot::{Geometry, Link, Robot};
use sim_check::{CheckOptions, Expected, Tier};
use tempfile::TempDir;

use super::artefacts::{Checked, Frame, LinkPose, UrdfPackage};
use super::bundle::Files;
use super::code;
use super::tools::Tools;

/// Configurations per joint of the motion in the trace.
const STEPS: usize = 24;
/// Name of the URDF in its package.
pub(super) const URDF: &str = "asset.urdf";

/// URDF package to verdict.
pub struct CheckInSim;

impl Stage<Tools> for CheckInSim {
    type Input = (Arc<UrdfPackage>, Arc<Condition>);
    type Output = Checked;
    const NAME: &'static str = "check-in-sim";

    fn code(&self) -> String {
        code::version(&[code::SIM_CHECK])
    }

    fn params(&self, _tools: &Tools) -> serde_json::Value {
        serde_json::json!({ "up_to": Tier::Dynamic.name() })
    }

    fn seed(&self, tools: &Tools) -> Option<u64> {
        Some(tools.seed)
    }

    fn run(&self, (urdf, condition): Self::Input, tools: &Tools) -> Result<Checked, StageError> {
        let (links, joints) = (condition.tree.len(), condition.tree.degrees_of_freedom());
        let options = CheckOptions {
            seed: tools.seed,
            up_to: Tier::Dynamic,
            expected: Some(Expected { links, joints }),
            ..CheckOptions::default()
        };
        let folder = Passing::write(&urdf.0, &tools.scratch)?;
        let path = folder.path().join(URDF);
        let verdict = sim_check::check(&path, &options);
        let robot = load::read(&path, &options).robot;
        let motion = robot.as_ref().map(motion).unwrap_or_default();
        let scene = robot.as_ref().map(scene).unwrap_or_default();
        Ok(Checked { verdict, motion, scene })
    }
}

/// Files in a folder that is gone when it is let go. No two share one: items checked at the same
/// time may have the same files, and the first to end must not take them from the other.
pub(super) struct Passing(TempDir);

impl Passing {
    pub(super) fn path(&self) -> &Path {
        self.0.path()
    }

    pub(super) fn write(files: &Files, scratch: &Path) -> Result<Self, StageError> {
        let made = fs::create_dir_all(scratch)
            .and_then(|()| tempfile::Builder::new().prefix("check-").tempdir_in(scratch));
        let folder = Self(made.map_err(|e| StageError::from_io(&e).about(scratch.display()))?);
        for (name, bytes) in files {
            let path = folder.path().join(name);
            let parent = path.parent().unwrap_or(folder.path());
            let written = fs::create_dir_all(parent).and_then(|()| fs::write(&path, bytes));
            written.map_err(|e| StageError::from_io(&e).about(path.display()))?;
        }
        Ok(folder)
    }
}

/// Every joint through its range; nothing if a joint cannot be moved, which the verdict says.
fn motion(robot: &Robot) -> Vec<Frame> {
    let states = sweep::joint_sweep(robot, STEPS).unwrap_or_default();
    let rest = vec![0.0; robot.joints.len()];
    std::iter::once(&rest).chain(&states).map(|q| frame(robot, q)).collect()
}

fn frame(robot: &Robot, q: &[f64]) -> Frame {
    let moving = robot.joints.iter().zip(q).filter(|(j, _)| j.kind.moves());
    let joints = moving.map(|(j, &q)| (j.name.clone(), q)).collect();
    let poses = robot.link_poses(q);
    let pose = |(n, link): (usize, &Link)| {
        let parent = robot.parent(n).and_then(|p| Some((robot.links.get(p)?, poses.get(p)?)));
        let own = poses.get(n).copied()?;
        let (parent, pose) = match parent {
            Some((parent, above)) => (parent.name.clone(), above.inverse() * own),
            None => ("world".into(), own),
        };
        let (translation, rotation) = (pose.translation.to_array(), pose.rotation.to_array());
        Some(LinkPose { parent, link: link.name.clone(), translation, rotation })
    };
    Frame { joints, links: robot.links.iter().enumerate().filter_map(pose).collect() }
}

/// What nobody gave a colour.
const GREY: [u8; 4] = [200, 200, 200, 255];

/// Each link's visual meshes as one GLB in the link's frame.
fn scene(robot: &Robot) -> Files {
    let one = |link: &Link| Some((format!("{}.glb", link.name), glb::write(&surface(link)?)));
    robot.links.iter().filter_map(one).collect()
}

fn surface(link: &Link) -> Option<Mesh> {
    let (mut vertices, mut faces, mut colours) = (Vec::<DVec3>::new(), Vec::new(), Vec::new());
    for shape in &link.visuals {
        let Geometry::Mesh(mesh) = &shape.geometry else { continue };
        let first = u32::try_from(vertices.len()).ok()?;
        vertices.extend(mesh.vertices().iter().map(|&v| shape.origin * v));
        faces.extend(mesh.faces().iter().map(|f| f.map(|v| v + first)));
        let plain = || vec![shape.colour.unwrap_or(GREY); mesh.vertices().len()];
        colours.extend(mesh.colours().map_or_else(plain, <[_]>::to_vec));
    }
    Mesh::new(vertices, faces).ok()?.with_colours(Some(colours)).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_two_look_at_the_same_time_is_not_taken_from_either() {
        let scratch = tempfile::tempdir().unwrap();
        let below = scratch.path().join("not/yet");
        let files = Files::from([(URDF.to_owned(), b"<robot/>".to_vec())]);
        let write = || Passing::write(&files, &below).unwrap();
        let (one, other) = (write(), write());
        drop(one);
        assert_eq!(fs::read(other.path().join(URDF)).unwrap(), b"<robot/>");
        drop(other);
        assert_eq!(fs::read_dir(&below).unwrap().count(), 0);
    }
}
