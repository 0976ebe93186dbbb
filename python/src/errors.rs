//! Errors of the house as exceptions of the package: what is wrong, why, and what to do about it.

use adapters::AdapterError;
use guard::text::{brief, shown};
use object::condition::ConditionError;
use pyo3::prelude::*;
use workflow::cli::speech::{Complaint, Exit};

/// Most characters of a message, a cause or a hint, as on the command line.
const LONGEST: usize = 4000;

/// An exception of the package before it is raised.
#[derive(Clone, Debug)]
pub(crate) struct Wrong {
    /// Its class in `kinfold`.
    pub(crate) class: &'static str,
    /// The rule and what was found.
    pub(crate) message: String,
    /// What lies behind it, outermost first.
    pub(crate) causes: Vec<String>,
    /// What a person can do about it.
    pub(crate) hints: Vec<String>,
}

impl Wrong {
    /// Something that was given and cannot be used.
    pub(crate) fn input(message: impl Into<String>) -> Self {
        Self { class: "InputError", message: message.into(), causes: vec![], hints: vec![] }
    }

    /// A fault of ours.
    pub(crate) fn fault(message: impl Into<String>) -> Self {
        let hint = "this is a fault of kinfold's: please report it with what you called";
        Self { class: "InternalError", ..Self::input(message) }.hint(hint)
    }

    /// The same as an exception of this class.
    #[must_use]
    pub(crate) fn of_class(self, class: &'static str) -> Self {
        Self { class, ..self }
    }

    /// The same with advice.
    #[must_use]
    pub(crate) fn hint(mut self, hint: impl Into<String>) -> Self {
        self.hints.push(hint.into());
        self
    }

    /// An error of any room, with its chain of causes.
    pub(crate) fn of(class: &'static str, error: &dyn std::error::Error) -> Self {
        let wrong = Self::input(error.to_string()).of_class(class);
        let behind = std::iter::successors(error.source(), |e| e.source());
        // Some errors say themselves what lies behind them.
        let new = |cause: &String| !wrong.message.contains(cause.as_str());
        Self { causes: behind.map(ToString::to_string).filter(new).collect(), ..wrong }
    }

    /// The exception. What it quotes may be of strangers: it is inert, and of bounded length.
    pub(crate) fn raised(self, py: Python<'_>) -> PyErr {
        let inert = |said: &String| shown(&brief(said, LONGEST)).into_owned();
        let (causes, hints): (Vec<_>, Vec<_>) =
            (self.causes.iter().map(inert).collect(), self.hints.iter().map(inert).collect());
        let made = py.import("kinfold._errors").and_then(|module| module.getattr(self.class));
        let made = made.and_then(|class| class.call1((inert(&self.message), causes, hints)));
        made.map_or_else(|broken| broken, PyErr::from_value)
    }
}

impl From<Complaint> for Wrong {
    fn from(complaint: Complaint) -> Self {
        let class = match complaint.exit {
            Exit::Misused => "InputError",
            Exit::Interrupted => "Interrupted",
            _ => "RunError",
        };
        let Complaint { message, mut causes, hints, .. } = complaint;
        // Words of a command line, which nobody here sees.
        causes.retain(|cause| !cause.starts_with("For more information"));
        Self { class, message, causes, hints }
    }
}

impl From<ConditionError> for Wrong {
    fn from(error: ConditionError) -> Self {
        let wrong = Self::of("ConditionError", &error);
        wrong.hint("`kinfold.condition_schema()` is the format")
    }
}

impl From<AdapterError> for Wrong {
    fn from(error: AdapterError) -> Self {
        let class = match error {
            AdapterError::Glb { .. } | AdapterError::Obj { .. } | AdapterError::Mesh { .. } => {
                "MeshError"
            }
            AdapterError::Condition { .. } => "ConditionError",
            _ => "InputError",
        };
        let wrong = Self::of(class, &error);
        match error.hint() {
            Some(hint) => wrong.hint(hint),
            None => wrong,
        }
    }
}
