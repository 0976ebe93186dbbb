//! A dry run: which stages would run, and why.
//!
//! ```
//! use runner::{Reason, plan};
//! # use std::sync::Arc;
//! # use runner::{Dag, Stage, StageError, Text};
//! # struct Upper;
//! # impl Stage<()> for Upper {
//! #     type Input = Arc<Text>;
//! #     type Output = Text;
//! #     const NAME: &'static str = "upper";
//! #     fn code(&self) -> String {
//! #         "1".into()
//! #     }
//! #     fn run(&self, text: Arc<Text>, _: &()) -> Result<Text, StageError> {
//! #         Ok(Text(text.0.to_uppercase()))
//! #     }
//! # }
//! # let mut dag = Dag::new("shout");
//! # let text = dag.input(Text("a lid".into()));
//! # dag.stage(Upper, text);
//!
//! let planned = plan(&dag, &(), None)?;
//! assert_eq!(planned[0].stage, "upper");
//! assert_eq!(planned[0].reasons, [Reason::NoRecord]);
//! # Ok::<(), runner::StateError>(())
//! ```

use std::fmt;

use trace::Digest;

use super::failure::StageError;
use super::graph::{Dag, Work};
use super::key::{InputDigest, Material};
use super::state_dir::{Recall, StateDir, StateError};

/// What would become of a stage.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlannedStage {
    /// Its name.
    pub stage: &'static str,
    /// Why it would run; empty if its result is there.
    pub reasons: Vec<Reason>,
}

impl PlannedStage {
    /// Whether it would run, as far as is known before anything runs.
    pub fn would_run(&self) -> bool {
        self.reasons.iter().any(|reason| !reason.is_pending())
    }

    /// Whether it runs only if what it waits for comes out other than before.
    pub fn may_run(&self) -> bool {
        !self.reasons.is_empty() && !self.would_run()
    }
}

/// Why a stage would run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reason {
    /// It never ran on anything like this.
    NoRecord,
    /// Its result was committed, but the bytes are gone.
    Lost(&'static str),
    /// An input has other bytes.
    InputChanged(String),
    /// An input is to be made again first, by this stage.
    InputPending(String, &'static str),
    /// Its code is another.
    CodeChanged,
    /// A parameter is another.
    ParamsChanged,
    /// The seed is another.
    SeedChanged {
        /// Before.
        was: Option<u64>,
        /// Now.
        is: Option<u64>,
    },
    /// Somebody or something else does the work, or reads another file.
    IdentityChanged {
        /// Before.
        was: String,
        /// Now.
        is: String,
    },
    /// It would fail before it begins.
    WouldFail(String),
}

impl Reason {
    /// Whether it is about an input that is made first, and may turn out as it was.
    fn is_pending(&self) -> bool {
        matches!(self, Self::InputPending(..))
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoRecord => f.write_str("no record"),
            Self::Lost(why) => f.write_str(why),
            Self::InputChanged(name) => write!(f, "input `{name}` changed"),
            Self::InputPending(name, stage) => {
                write!(f, "input `{name}` comes from {stage}, which runs first")
            }
            Self::CodeChanged => f.write_str("code version changed"),
            Self::ParamsChanged => f.write_str("parameters changed"),
            Self::SeedChanged { was, is } => {
                let word = |s: &Option<u64>| s.map_or("none".into(), |s| s.to_string());
                write!(f, "seed changed from {} to {}", word(was), word(is))
            }
            Self::IdentityChanged { was, is } => {
                // The first word says who, the rest what of: such as a file's digest.
                let who = |id: &str| id.split(' ').next().unwrap_or_default().to_owned();
                match (who(was), who(is)) {
                    (before, now) if before == now => write!(f, "what `{now}` reads changed"),
                    (before, now) => write!(f, "done by `{now}`, before by `{before}`"),
                }
            }
            Self::WouldFail(why) => write!(f, "would fail: {why}"),
        }
    }
}

/// An input of a planned stage: its name, its maker and its digest, if that is known already.
struct Source {
    name: &'static str,
    stage: &'static str,
    digest: Option<Digest>,
}

/// Plans a flow against what `state` has on record (`None`: nothing). Changes nothing.
///
/// # Errors
/// [`StateError`] when the record cannot be read.
pub fn plan<T>(
    dag: &Dag<T>,
    tools: &T,
    state: Option<&StateDir>,
) -> Result<Vec<PlannedStage>, StateError> {
    let mut known: Vec<Option<Digest>> = Vec::new();
    let mut planned = Vec::new();
    for node in dag.nodes() {
        let source = |&i: &usize| {
            let (from, digest) = (dag.nodes().get(i)?, known.get(i)?.clone());
            Some(Source { name: from.artefact.name, stage: from.name, digest })
        };
        let sources: Vec<_> = node.inputs.iter().filter_map(source).collect();
        let Work::Stage(stage) = &node.work else {
            known.push(given_digest(&node.work));
            continue;
        };
        let (output, reasons) = match stage.profile(tools) {
            Err(error) => (None, vec![Reason::WouldFail(StageError::line(&error))]),
            Ok(profile) => look_up(&Material::of(node.name, profile, vec![]), &sources, state)?,
        };
        known.push(output);
        planned.push(PlannedStage { stage: node.name, reasons });
    }
    Ok(planned)
}

fn given_digest<T>(work: &Work<T>) -> Option<Digest> {
    match work {
        Work::Given(Ok(bytes)) => Some(Digest::of(bytes)),
        _ => None,
    }
}

/// The output on record for a stage with these sources, or the reasons why there is none.
fn look_up(
    stage: &Material,
    sources: &[Source],
    state: Option<&StateDir>,
) -> Result<(Option<Digest>, Vec<Reason>), StateError> {
    let Some(state) = state else { return Ok((None, vec![Reason::NoRecord])) };
    let digests = |s: &Source| Some(InputDigest { name: s.name.into(), digest: s.digest.clone()? });
    if let Some(inputs) = sources.iter().map(digests).collect::<Option<Vec<_>>>() {
        match state.recall(&Material { inputs, ..stage.clone() }.key())? {
            Recall::Known(committed, _) => return Ok((Some(committed.output), vec![])),
            Recall::Lost(why) => return Ok((None, vec![Reason::Lost(why)])),
            Recall::Unknown => {}
        }
    }
    let earlier = state.journal.materials(&stage.stage).map_err(state.journal_failed())?;
    let alike = earlier.iter().filter(|old| is_alike(old, sources));
    let nearest = alike.map(|old| differences(old, stage, sources)).min_by_key(Vec::len);
    Ok((None, nearest.unwrap_or_else(|| vec![Reason::NoRecord])))
}

/// Whether an earlier result is of the same object: one input is the same, or none is known yet.
fn is_alike(old: &Material, sources: &[Source]) -> bool {
    let mut known = old.inputs.iter().zip(sources).filter(|(_, s)| s.digest.is_some()).peekable();
    known.peek().is_none() || known.any(|(before, s)| s.digest.as_ref() == Some(&before.digest))
}

fn differences(old: &Material, now: &Material, sources: &[Source]) -> Vec<Reason> {
    let mut reasons = Vec::new();
    for (n, source) in sources.iter().enumerate() {
        let before = old.inputs.get(n).map(|i| &i.digest);
        match &source.digest {
            None => reasons.push(Reason::InputPending(source.name.into(), source.stage)),
            Some(_) if source.digest.as_ref() == before => {}
            Some(_) => reasons.push(Reason::InputChanged(source.name.into())),
        }
    }
    if old.code != now.code {
        reasons.push(Reason::CodeChanged);
    }
    if old.params != now.params {
        reasons.push(Reason::ParamsChanged);
    }
    if old.seed != now.seed {
        reasons.push(Reason::SeedChanged { was: old.seed, is: now.seed });
    }
    if old.identity != now.identity {
        let word = |id: &Option<String>| id.clone().unwrap_or_else(|| "nobody".into());
        reasons.push(Reason::IdentityChanged { was: word(&old.identity), is: word(&now.identity) });
    }
    reasons
}
