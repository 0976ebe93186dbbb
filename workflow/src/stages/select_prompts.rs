//! Condition to what articulation depends on: another material or mass, or the size where no length is given
//! in metres, leaves parts and joints as they were found.

use std::sync::Arc;

use object::Condition;
use runner::{Stage, StageError};

use super::artefacts::Prompts;
use super::code;
use super::tools::Tools;

/// Condition to tree, texts, points and corrections.
pub struct SelectPrompts;

impl Stage<Tools> for SelectPrompts {
    type Input = Arc<Condition>;
    type Output = Prompts;
    const NAME: &'static str = "select-prompts";

    fn code(&self) -> String {
        code::version(&[])
    }

    fn run(&self, condition: Arc<Condition>, _tools: &Tools) -> Result<Prompts, StageError> {
        Ok(Prompts(condition.of_shape()))
    }
}
