//! URDF package to verdict: written to disk and read back as a simulator would.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use object::{Condition, DVec3, Mesh, glb};
use sim_check::robot::{Geometry, Link, Robot};
use sim_check::{CheckOptions, Expected, Tier, load, sweep};
use trace::Digest;

use super::bundle::{self, Files};
use super::{Checked, Frame, LinkPose, Tools, UrdfPackage, code};
use crate::dag::{Stage, StageError};

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
        let path = folder.0.join(URDF);
        let verdict = sim_check::check(&path, &options);
        let robot = load::read(&path, &options).robot;
        let motion = robot.as_ref().map(motion).unwrap_or_default();
        let scene = robot.as_ref().map(scene).unwrap_or_default();
        Ok(Checked { verdict, motion, scene })
    }
}

/// A folder that is gone when it is let go.
pub(super) struct Passing(PathBuf);

impl Passing {
    pub(super) fn path(&self) -> &Path {
        &self.0
    }

    pub(super) fn write(files: &Files, scratch: &Path) -> Result<Self, StageError> {
        let name = format!("check-{}", Digest::of(&bundle::pack(files)).short());
        let folder = Self(scratch.join(name));
        for (name, bytes) in files {
            let path = folder.0.join(name);
            let parent = path.parent().unwrap_or(&folder.0);
            let written = fs::create_dir_all(parent).and_then(|()| fs::write(&path, bytes));
            written.map_err(|e| StageError::from_io(&e).about(path.display()))?;
        }
        Ok(folder)
    }
}

impl Drop for Passing {
    fn drop(&mut self) {
        // What stays behind is swept away by the next run.
        let _ = fs::remove_dir_all(&self.0);
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
        let plain = || vec![[200, 200, 200, 255]; mesh.vertices().len()];
        colours.extend(mesh.colours().map_or_else(plain, <[_]>::to_vec));
    }
    Mesh::new(vertices, faces).ok()?.with_colours(Some(colours)).ok()
}
