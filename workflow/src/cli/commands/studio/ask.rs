//! Asking others before there is anything to edit: for a mesh, and for a condition to begin with.

use std::sync::Arc;

use adapters::{GeneratedMesh, Photo};
use object::Condition;
use runner::ours::Turns;
use runner::{AlwaysOpen, Artefact, Cancel, Dag, Ending, Limits, RunOptions, StateDir};
use trace::SystemClock;

use crate::cli::args::{MakeArgs, StudioArgs};
use crate::cli::commands::{given, make};
use crate::cli::progress::Progress;
use crate::cli::speech::Complaint;
use crate::image_to_urdf::{image_to_condition, image_to_mesh};
use crate::recording::VERSION;
use crate::stages::Tools;

/// The mesh of a photo, from whom the configuration names.
///
/// # Errors
/// [`Complaint`] when nobody is named, or nobody answers.
pub(super) fn mesh(args: &MakeArgs) -> Result<GeneratedMesh, Complaint> {
    result(args, "generate-mesh", image_to_mesh)
}

/// A condition of a photo and its mesh, from whom the configuration or the command line names.
///
/// # Errors
/// [`Complaint`] when nobody is named, or nobody answers.
pub(super) fn condition(args: &MakeArgs) -> Result<Condition, Complaint> {
    result(args, "propose-condition", image_to_condition)
}

/// The words for a condition: the same without the one that is edited.
pub(super) fn without_condition(make: &MakeArgs, args: &StudioArgs) -> MakeArgs {
    let (vlm, model) = (args.vlm.clone(), args.model.clone());
    MakeArgs { condition: None, snap: false, vlm, model, ..make.clone() }
}

/// Whether somebody is named who can be asked for a condition.
pub(super) fn can_draft(args: &MakeArgs) -> bool {
    let state = make::state_dir(args.state.as_deref());
    state.and_then(|state| make::tools(args, &state)).is_ok()
}

fn result<K, T: Artefact<K>>(
    args: &MakeArgs,
    stage: &'static str,
    flow: impl FnOnce(Photo) -> Dag<Tools>,
) -> Result<T, Complaint> {
    let state = make::state_dir(args.state.as_deref())?;
    let tools = Arc::new(make::tools(args, &state)?);
    let photo = given::photo(args).map_err(|e| Complaint::from_error(&e))?;
    let turns = Turns { wait: !args.no_wait, tell: true };
    let state = StateDir::open_in_turn(&state, turns).map_err(|e| make::state_complaint(&e))?;
    let cancel = Cancel::default();
    let signals = make::listen(&cancel, false)?;
    let (limits, version, gate) = (Limits::default(), VERSION.into(), Arc::new(AlwaysOpen));
    let clock = Arc::new(SystemClock::default());
    let options = RunOptions { limits, cancel, clock, version, gate, workers: None };
    let mut progress = Progress::new(false);
    let ran = runner::run(&flow(photo), &tools, &state, &options, &mut progress);
    signals.close();
    progress.clear();
    let outcome = ran.map_err(|e| make::run_complaint(&e))?;
    match &outcome.ending {
        Ending::Done => outcome.artefact::<K, T>(stage).map_err(Complaint::from_stage),
        Ending::Failed { error, .. } => Err(Complaint::from_stage(error.clone())),
        Ending::Interrupted(_) => Err(make::interrupted()),
    }
}
