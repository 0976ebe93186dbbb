//! Articulated object and measures to the shapes of its parts, before anything is weighed.

use std::sync::Arc;
use std::time::Duration;

use asset::{Measures, Shapes};
use model::Articulation;
use runner::{Patience, Stage, StageError};

use super::code;
use super::tools::Tools;

/// Articulated object to repaired surfaces and collision pieces clear of each other.
pub struct ShapeParts;

impl Stage<Tools> for ShapeParts {
    type Input = (Arc<Articulation>, Arc<Measures>);
    type Output = Shapes;
    const NAME: &'static str = "shape-parts";

    fn code(&self) -> String {
        code::version(&[code::ASSET])
    }

    fn seed(&self, tools: &Tools) -> Option<u64> {
        Some(tools.seed)
    }

    fn patience(&self) -> Patience {
        Patience { timeout: Duration::from_secs(1800), ..Patience::default() }
    }

    fn run(&self, (made, measures): Self::Input, tools: &Tools) -> Result<Shapes, StageError> {
        let shapes = asset::shape(&made.object, &measures, &made.part_of_condition, tools.seed);
        let shapes = shapes.map_err(|e| StageError::from_error(&e))?;
        Ok(shapes.with_confidence(made.confidence.clone()))
    }
}
