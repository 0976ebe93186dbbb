//! What a case to be measured does not give: asked of whom `kinfold.toml` names, by the first steps of
//! the flow, and kept like theirs, so that it is asked and paid for once.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use adapters::{AdapterError, GeneratedMesh, ImageTo3d, MeshFile, Photo, Vlm};
use model::Choice;
use object::Condition;
use runner::ours::Turns;
use runner::{AlwaysOpen, Cancel, Ending, Limits, Quiet, RunOptions, StateDir};
use trace::{Clock, SystemClock};
use training::evaluate::case::{MESH, PICTURES};
use training::evaluate::{Given, Mode, Supply, SupplyError, case};

use super::make::{state_complaint, state_dir};
use super::providers::{self, Chosen, Wanted};
use crate::cli::args::EvalArgs;
use crate::cli::speech::Complaint;
use crate::image_to_urdf::image_to_condition;
use crate::recording::VERSION;
use crate::stages::{Shared, Tools};

/// Whom the configuration names, and where their answers are kept.
pub(super) struct Hired {
    /// Who makes meshes, where cases do not give them.
    image_to_3d: Option<Arc<dyn ImageTo3d>>,
    vlm: Arc<dyn Vlm>,
    /// Both by name, model and version.
    identity: String,
    state: StateDir,
    seed: u64,
    clock: Arc<dyn Clock>,
}

/// Whoever is needed in a mode that does not give all.
pub(super) fn hired(args: &EvalArgs) -> Result<Hired, Complaint> {
    let mode = args.mode;
    let folder = state_dir(args.state.as_deref())?;
    let config = providers::configured(&Wanted {
        named: args.config.as_deref(),
        trusted: args.trust_config,
        mesh: !mode.has_surface(),
        condition: true,
    })?;
    config.permit(&args.policy).map_err(|e| providers::complaint(&e))?;
    let Chosen { image_to_3d, vlm, .. } = providers::hired(&config, &folder)?;
    let Some(vlm) = vlm else { return Err(nobody("a condition", mode)) };
    if image_to_3d.is_none() && !mode.has_surface() {
        return Err(nobody("a mesh", mode));
    }
    let named = |said: Result<String, AdapterError>| said.map_err(|e| providers::complaint(&e));
    let mut identity = format!("condition by {}", named(vlm.identity())?);
    if let Some(generator) = &image_to_3d {
        identity = format!("mesh by {}, {identity}", named(generator.identity())?);
    }
    let turns = Turns { wait: true, tell: true };
    let state = StateDir::open_in_turn(&folder, turns).map_err(|e| state_complaint(&e))?;
    let (image_to_3d, vlm) = (image_to_3d.map(Arc::from), Arc::from(vlm));
    let clock = Arc::new(SystemClock::default());
    Ok(Hired { image_to_3d, vlm, identity, state, seed: args.seed, clock })
}

fn nobody(what: &str, mode: Mode) -> Complaint {
    let told =
        format!("--mode {}: nobody to ask for {what}: no provider is configured", mode.name());
    Complaint::misused(told).hint("name who is to be asked in kinfold.toml, or in --config FILE")
}

impl Hired {
    fn tools(&self, folder: &Path) -> Tools {
        let image_to_3d: Box<dyn ImageTo3d> = match &self.image_to_3d {
            Some(generator) => Box::new(Shared(Arc::clone(generator))),
            None => Box::new(MeshFile { path: folder.join(MESH), ..Default::default() }),
        };
        let vlm = Box::new(Shared(Arc::clone(&self.vlm)));
        let (articulate, scratch) = (model::articulator(Choice::default()), self.state.scratch());
        Tools { image_to_3d, vlm, critic: None, articulate, seed: self.seed, scratch }
    }
}

impl Supply for Hired {
    fn mode(&self) -> Mode {
        if self.image_to_3d.is_some() { Mode::Image } else { Mode::Mesh }
    }

    fn identity(&self) -> String {
        self.identity.clone()
    }

    fn given(&self, folder: &Path) -> Result<Given, SupplyError> {
        let photo = Photo::open(&picture(folder)?).map_err(boxed)?;
        let (limits, cancel, clock) = (Limits::default(), Cancel::default(), self.clock.clone());
        let (version, gate) = (VERSION.into(), Arc::new(AlwaysOpen));
        let options = RunOptions { limits, cancel, clock, version, gate, workers: None };
        let (flow, tools) = (image_to_condition(photo), Arc::new(self.tools(folder)));
        let outcome =
            runner::run(&flow, &tools, &self.state, &options, &mut Quiet).map_err(boxed)?;
        match &outcome.ending {
            Ending::Done => {}
            Ending::Failed { stage, error } => {
                return Err(SupplyError(format!("{stage}: {}", error.line()).into()));
            }
            Ending::Interrupted(_) => return Err(SupplyError("interrupted".into())),
        }
        let mesh: GeneratedMesh = outcome.artefact("generate-mesh").map_err(boxed)?;
        let condition: Condition = outcome.artefact("propose-condition").map_err(boxed)?;
        Ok(Given { mesh: mesh.mesh, condition })
    }
}

fn boxed(error: impl std::error::Error + Send + Sync + 'static) -> SupplyError {
    SupplyError(Box::new(error))
}

/// The picture of a case.
fn picture(folder: &Path) -> Result<PathBuf, SupplyError> {
    case::picture(folder).ok_or_else(|| {
        let (folder, wanted) = (folder.display(), PICTURES.join(" or "));
        SupplyError(format!("{folder}: expected a picture, {wanted}, found none").into())
    })
}
