//! What can go wrong outside, sorted by what to do about it.

use object::meshfile::MeshFileError;

use crate::net::redactor::Redactor;
use crate::transport::{CHARGED, TransportError};

/// Why an adapter has no answer.
#[derive(Debug, thiserror::Error)]
pub enum AdapterError {
    /// A file that cannot be read.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: String,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// A photo that is no photo.
    #[error("{path}: {rule}, found {found}")]
    Photo {
        /// The file.
        path: String,
        /// What a photo must be.
        rule: String,
        /// What this is.
        found: String,
    },
    /// A mesh file that cannot be used.
    #[error("{path}: {source}")]
    Glb {
        /// The file.
        path: String,
        /// Which rule it breaks.
        source: object::glb::GlbError,
    },
    /// An OBJ file that cannot be used.
    #[error("{path}: {source}")]
    Obj {
        /// The file.
        path: String,
        /// Which rule it breaks.
        source: object::obj::ObjError,
    },
    /// A mesh file of another format that cannot be used.
    #[error("{path}: {source}")]
    Mesh {
        /// The file.
        path: String,
        /// Which rule it breaks.
        source: object::meshfile::MeshFileError,
    },
    /// A condition that cannot be used.
    #[error("{path}: {source}")]
    Condition {
        /// The file.
        path: String,
        /// Which rule it breaks.
        source: object::condition::ConditionError,
    },
    /// A file of a kind nobody here reads.
    #[error("{path}: expected {expected}, found {found}")]
    Format {
        /// The file.
        path: String,
        /// What can be read.
        expected: &'static str,
        /// What it looks like.
        found: String,
    },
    /// A service that answered, but not with what it was asked for.
    #[error("{provider}: {step}: {rule}, found {found}")]
    Service {
        /// Whom we asked.
        provider: String,
        /// For what.
        step: String,
        /// What its answer should have been.
        rule: &'static str,
        /// What it was.
        found: String,
        /// Its HTTP status if that alone said no, or the one that says what its own code does.
        status: Option<u16>,
    },
    /// A job that gave no mesh.
    #[error("{provider}: job {job}: {found}")]
    Job {
        /// Whose job.
        provider: String,
        /// Its number there.
        job: String,
        /// What became of it.
        found: String,
        /// What to do about it.
        hint: &'static str,
    },
    /// A program of the user's that did not do its work.
    #[error("{program}: {found}")]
    Program {
        /// The program.
        program: String,
        /// What it did instead.
        found: String,
    },
    /// An answer that stayed wrong after it was sent back for repair.
    #[error("{who}: {question}: still wrong after {rounds} rounds of repair: {found}")]
    Unrepaired {
        /// Who answered.
        who: String,
        /// What was asked.
        question: &'static str,
        /// How often it was sent back.
        rounds: u32,
        /// Every broken rule, with what was found.
        found: String,
    },
    /// An object that cannot become an articulated asset, by the answer.
    #[error("{who}: the object cannot be articulated: {found}")]
    NotArticulated {
        /// Who said so.
        who: String,
        /// Why.
        found: String,
    },
    /// A critique that was lost when it was asked for, as a trace tells it.
    #[error("{0}")]
    NoCritique(String),
    /// A key that is needed and not set.
    #[error("no key: the variable {variable} is not set")]
    Key {
        /// The variable that should hold it.
        variable: String,
    },
    /// A key that stands in the configuration itself. It is not told.
    #[error("{path}: a key must not stand in the file, found one in line {line}, field `{field}`")]
    InlineKey {
        /// The file.
        path: String,
        /// The line, from one.
        line: usize,
        /// The field.
        field: String,
    },
    /// A key that would leave in plain.
    #[error("{host}: the key in {variable} would leave over plain http")]
    Plain {
        /// Where it would go.
        host: String,
        /// The variable that holds it, or what else is secret.
        variable: String,
    },
    /// A provider whose licence and a policy do not go together.
    #[error("{provider}: not with the policy `{policy}`: {found}")]
    Terms {
        /// The provider.
        provider: String,
        /// The policy.
        policy: String,
        /// What is forbidden, or not known.
        found: String,
    },
    /// The network, at the one seam it passes through.
    #[error(transparent)]
    Transport(#[from] TransportError),
}

impl AdapterError {
    /// A mesh file that cannot be used, told by its format.
    pub(crate) fn of_mesh(path: String, error: MeshFileError) -> Self {
        match error {
            MeshFileError::Glb(source) => Self::Glb { path, source },
            MeshFileError::Obj(source) => Self::Obj { path, source },
            MeshFileError::Foreign(found) => {
                Self::Format { path, expected: "a mesh as GLB, glTF, OBJ, STL, PLY or USD", found }
            }
            source => Self::Mesh { path, source },
        }
    }

    /// Whether asking again later may help.
    pub fn is_transient(&self) -> bool {
        match self {
            Self::Transport(e) => e.transient,
            Self::Service { status, .. } => matches!(status, Some(408 | 429 | 500..)),
            _ => false,
        }
    }

    /// Whether what may be spent is spent; nothing was asked.
    pub fn is_over_budget(&self) -> bool {
        matches!(self, Self::Transport(e) if e.over_budget)
    }

    /// The beginning of the steps whose answers came and were no good; everything's is empty, and
    /// none where no answer is to blame.
    pub(crate) fn spoiled_steps(&self) -> Option<String> {
        match self {
            Self::Unrepaired { question, .. } => Some(format!("vlm.{question}/")),
            Self::NotArticulated { .. } => Some("vlm.kinematics/".into()),
            // A model that was not reached, or said no, gave no answer that could be no good.
            Self::Service { step, status, .. } if step.starts_with("vlm.") => {
                let steps = step.split_inclusive('/').take(1).collect();
                status.is_none().then_some(steps)
            }
            Self::Service { .. }
            | Self::Condition { .. }
            | Self::Glb { .. }
            | Self::Obj { .. }
            | Self::Mesh { .. }
            | Self::Job { .. } => Some(String::new()),
            _ => None,
        }
    }

    /// The same without what must not be told, whoever put it there.
    #[must_use]
    pub fn without(self, redactor: &Redactor) -> Self {
        if redactor.is_idle() || !redactor.finds(&self.to_string()) {
            return self;
        }
        let text = |text: String| redactor.text(&text).into_owned();
        match self {
            Self::Photo { path, rule, found } => {
                Self::Photo { path: text(path), rule: text(rule), found: text(found) }
            }
            Self::Format { path, expected, found } => {
                Self::Format { path: text(path), expected, found: text(found) }
            }
            Self::Service { provider, step, rule, found, status } => {
                let (provider, step, found) = (text(provider), text(step), text(found));
                Self::Service { provider, step, rule, found, status }
            }
            Self::Job { provider, job, found, hint } => {
                Self::Job { provider: text(provider), job: text(job), found: text(found), hint }
            }
            Self::Program { program, found } => {
                Self::Program { program: text(program), found: text(found) }
            }
            Self::Unrepaired { who, question, rounds, found } => {
                Self::Unrepaired { who: text(who), question, rounds, found: text(found) }
            }
            Self::NotArticulated { who, found } => {
                Self::NotArticulated { who: text(who), found: text(found) }
            }
            Self::NoCritique(why) => Self::NoCritique(text(why)),
            Self::Transport(e) => {
                let (step, host, found) = (text(e.step), text(e.host), text(e.found));
                Self::Transport(TransportError { step, host, found, ..e })
            }
            other => Self::Format {
                path: "an answer".into(),
                expected: "one that can be used and repeats no key",
                found: text(other.to_string()),
            },
        }
    }

    /// What to do about it, where there is something to be done.
    pub fn hint(&self) -> Option<&'static str> {
        match self {
            Self::Job { hint, .. } => Some(hint),
            Self::Key { .. } => {
                Some("put the key into that variable, or name another with key_env")
            }
            Self::InlineKey { .. } => Some(
                "put the key into a variable of the environment and name that with key_env; change the key if anybody else saw the file",
            ),
            Self::Plain { .. } => Some("keys leave over https, or to this machine: correct `base`"),
            Self::Terms { .. } => Some(
                "ask another provider, or say what your own contract allows with `allowed` in [manners]",
            ),
            Self::NotArticulated { .. } => {
                Some("give the parts and joints yourself with --condition FILE.json")
            }
            Self::Transport(e) if e.found.ends_with(CHARGED) => Some(
                "look at the service's own list of calls; the same command (in a batch with --retry provider) asks once more and books it again",
            ),
            Self::Service { status: Some(402), .. } => Some("the account at the service is empty"),
            Self::Service { status: Some(401 | 403), .. } => {
                Some("the service does not accept the key: check the variable that holds it")
            }
            _ => None,
        }
    }
}
