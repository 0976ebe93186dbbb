//! A URDF package to pictures of it: its parts, each named, and its joints at work.

mod motion;
mod parts;
mod solid;

use std::sync::Arc;

use runner::{Stage, StageError};
use sim_check::CheckOptions;
use sim_check::read::load;
use sim_check::robot::Robot;

use super::artefacts::{Pictures, UrdfPackage};
use super::bundle::Files;
use super::check_in_sim::{Passing, URDF};
use super::code;
use super::seen::dress;
use super::tools::Tools;
use solid::Solid;

/// Most faces of what moves: more are not seen in pictures so small.
const FACES: usize = 6000;

/// A URDF package to pictures of its parts and its motion, as a simulator reads it.
pub struct WritePictures;

impl Stage<Tools> for WritePictures {
    type Input = Arc<UrdfPackage>;
    type Output = Pictures;
    const NAME: &'static str = "write-pictures";

    fn code(&self) -> String {
        code::version(&[code::SIM_CHECK, code::VIEW])
    }

    fn run(&self, urdf: Arc<UrdfPackage>, tools: &Tools) -> Result<Pictures, StageError> {
        let folder = Passing::write(&urdf.0, &tools.scratch)?;
        let mut robot = load::read(&folder.path().join(URDF), &CheckOptions::default()).robot;
        if let Some(robot) = &mut robot {
            dress(robot, &urdf.0);
        }
        Ok(Pictures(robot.as_ref().map(drawn).transpose()?.unwrap_or_default()))
    }
}

/// Both pictures by name; none of a robot of which nothing can be seen.
fn drawn(robot: &Robot) -> Result<Files, StageError> {
    let Some(solid) = Solid::of(robot) else { return Ok(Files::new()) };
    let parts = parts::picture(&solid).map_err(|e| StageError::from_error(&e))?;
    let small = solid.thinned(FACES);
    let motion = motion::film(small.as_ref().unwrap_or(&solid));
    let motion = motion.map_err(|e| StageError::from_error(&e))?;
    Ok(Files::from([(Pictures::PARTS.into(), parts), (Pictures::MOTION.into(), motion)]))
}

#[cfg(test)]
mod tests;
