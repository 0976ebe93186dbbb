//! How cases are asked about and measured.

use object::condition::Prompt;
use object::{Condition, KinematicTree, Part};
use serde::Serialize;

use crate::metrics::Rules;

/// How cases are asked about and measured.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct How {
    /// Whose reading of the measures.
    pub rules: Rules,
    /// What the condition leaves out.
    pub without: Without,
    /// Where a part's point prompt lies.
    pub prompts: Prompts,
    /// Points drawn on each side's surface.
    pub points: usize,
    /// Seed of the articulator; of the true points and of prompts anywhere; the next one draws the predicted points.
    pub seed: u64,
}

impl Default for How {
    fn default() -> Self {
        Self {
            rules: Rules::Paper,
            without: Without::default(),
            prompts: Prompts::AsGiven,
            points: 100_000,
            seed: 0,
        }
    }
}

/// Where a part's point prompt lies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub enum Prompts {
    /// Where the case has it.
    #[default]
    AsGiven,
    /// Anywhere on the true part, inner faces included, larger faces oftener: people click anywhere.
    Anywhere,
}

/// What is kept from the solver.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Without {
    /// Every word: parts' texts and names, and the category.
    pub text: bool,
    /// Every point.
    pub points: bool,
}

impl Without {
    /// The condition with nothing in it that is left out.
    ///
    /// # Errors
    /// [`object::kinematics::TreeError`] never for a valid condition: only names change.
    pub(super) fn strip(
        self,
        condition: &Condition,
    ) -> Result<Condition, object::kinematics::TreeError> {
        let mut asked = condition.clone();
        if self.points {
            asked.prompts.iter_mut().for_each(Prompt::forget_places);
        }
        if self.text {
            let nameless = |(i, part): (usize, &Part)| Part {
                name: format!("part_{i}"),
                text: String::new(),
                ..part.clone()
            };
            let parts = condition.tree.parts().iter().enumerate().map(nameless);
            asked.tree = KinematicTree::new(parts.collect())?;
            asked.category.clear();
        }
        Ok(asked)
    }
}
