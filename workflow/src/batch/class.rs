//! Sorts failures by what they are failures of, and so by what helps.

use std::fmt;

use runner::{Again, Blame, Stage as _, StageError};

use crate::stages::{
    Articulate, BuildAsset, CheckInSim, Criticise, GenerateMesh, ProposeCondition, RenderViews,
    SelectMeasures, SelectPrompts, ShapeParts, WriteUrdf,
};

/// What a failure is a failure of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, clap::ValueEnum)]
pub enum Class {
    /// A file that was given: photo, mesh or condition
    Input,
    /// A trouble that passes; tried again by itself
    Transient,
    /// What may be spent was spent; tried again when there is more
    Budget,
    /// A generator's or a language model's answer
    Provider,
    /// The articulation model, or a part that got no faces
    Model,
    /// The shape: it could not be drawn, built or written
    Geometry,
    /// The verdict: made, and below the tier asked for
    Verdict,
}

impl Class {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Input,
        Self::Transient,
        Self::Budget,
        Self::Provider,
        Self::Model,
        Self::Geometry,
        Self::Verdict,
    ];

    /// Its name in lower case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Input => "input",
            Self::Transient => "transient",
            Self::Budget => "budget",
            Self::Provider => "provider",
            Self::Model => "model",
            Self::Geometry => "geometry",
            Self::Verdict => "verdict",
        }
    }

    /// Whether the same item may do better without anybody changing anything.
    pub fn passes(self) -> bool {
        matches!(self, Self::Transient | Self::Budget)
    }

    /// The class of a stage's failure. A mesh or condition that was given is the input's fault,
    /// one that somebody was asked for is that provider's.
    pub fn of(stage: &str, error: &StageError, given: bool) -> Self {
        match (error.blame, error.again) {
            (Blame::Budget, _) => return Self::Budget,
            (_, Again::Later(_)) => return Self::Transient,
            _ => {}
        }
        match stage {
            GenerateMesh::NAME | ProposeCondition::NAME if given => Self::Input,
            GenerateMesh::NAME | ProposeCondition::NAME | Criticise::NAME => Self::Provider,
            SelectPrompts::NAME | Articulate::NAME => Self::Model,
            CheckInSim::NAME => Self::Verdict,
            RenderViews::NAME | SelectMeasures::NAME | ShapeParts::NAME => Self::Geometry,
            BuildAsset::NAME | WriteUrdf::NAME => Self::Geometry,
            name if name.starts_with("write-") => Self::Geometry,
            _ => Self::Input,
        }
    }
}

impl fmt::Display for Class {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failure_is_sorted_by_what_helps() {
        let wrong = StageError::new("wrong");
        let busy = wrong.clone().later(None);
        let spent = wrong.clone().blamed_on(Blame::Budget);
        let class = |stage, error| Class::of(stage, error, false);
        assert_eq!(class("generate-mesh", &wrong), Class::Provider);
        assert_eq!(Class::of("generate-mesh", &wrong, true), Class::Input);
        assert_eq!(class("generate-mesh", &busy), Class::Transient);
        assert_eq!(class("propose-condition", &spent), Class::Budget);
        assert_eq!(class("articulate", &wrong), Class::Model);
        assert_eq!(class("shape-parts", &wrong), Class::Geometry);
        assert_eq!(class("write-usd", &wrong), Class::Geometry);
        assert_eq!(class("check-in-sim", &wrong), Class::Verdict);
        assert_eq!(class("photo", &wrong), Class::Input);
        assert!(Class::ALL.into_iter().filter(|c| c.passes()).count() == 2);
    }
}
