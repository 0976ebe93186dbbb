//! Condition to what the shapes of parts depend on: another mass or friction, or a material whose walls are
//! as thick, leaves surfaces and collision pieces as they were made.

use std::sync::Arc;

use asset::Measures;
use object::Condition;
use runner::{Stage, StageError};

use super::code;
use super::tools::Tools;

/// Condition to size, walls and what is given of joints.
pub struct SelectMeasures;

impl Stage<Tools> for SelectMeasures {
    type Input = Arc<Condition>;
    type Output = Measures;
    const NAME: &'static str = "select-measures";

    fn code(&self) -> String {
        code::version(&[code::ASSET])
    }

    fn run(&self, condition: Arc<Condition>, _tools: &Tools) -> Result<Measures, StageError> {
        Ok(Measures::of(&condition))
    }
}
