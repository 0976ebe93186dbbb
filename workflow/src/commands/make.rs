//! `kinfold make`: one photo to one checked URDF.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use adapters::Photo;
use adapters::net::calls::Calls;
use model::Hybrid;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::iterator::Signals;
use trace::{Clock, FixedClock, SystemClock};

use super::providers::Chosen;
use super::{plan, providers, summary};
use crate::cli::MakeArgs;
use crate::dag::observe::Both;
use crate::dag::{
    self, AlwaysOpen, Cancel, Ending, InGraphOrder, Limits, Outcome, RunError, RunOptions,
    StateDir, StateError, Wish,
};
use crate::image_to_urdf::image_to_urdf;
use crate::output::{self, OutError, OutFolder};
use crate::progress::Progress;
use crate::recording::{self, Recording, VERSION};
use crate::speech::{Answer, Complaint, Exit};
use crate::stages::Tools;

/// Makes an asset, or says what it would do.
///
/// # Errors
/// [`Complaint`], naming the file, the rule and what was found. A trace in the output folder says
/// how far it went.
pub fn make(args: &MakeArgs) -> Result<Answer, Complaint> {
    answered(args).map_err(|complaint| summary::with_result(complaint, args.json))
}

fn answered(args: &MakeArgs) -> Result<Answer, Complaint> {
    let state = state_dir(args.state.as_deref())?;
    let tools = Arc::new(tools(args, &state)?);
    if args.graph {
        let photo = Photo::open(&args.photo).map_err(|e| Complaint::from_error(&e))?;
        let flow = image_to_urdf(photo, &args.exports(), tools.criticise());
        return Ok(Answer::done(flow.graphviz()));
    }
    if args.dry_run {
        return dry_run(args, &tools, &state);
    }
    let calls = Arc::new(providers::calls(&state));
    let state = StateDir::open(&state).map_err(|e| state_complaint(&e))?;
    let root = args.out.clone().unwrap_or_else(|| default_out(&args.photo));
    let out = OutFolder::prepare(&root).map_err(|e| out_complaint(&e))?;
    traced(args, &tools, (&state, calls), &out)
}

fn dry_run(args: &MakeArgs, tools: &Tools, state: &Path) -> Result<Answer, Complaint> {
    let photo = Photo::open(&args.photo).map_err(|e| Complaint::from_error(&e))?;
    let state = StateDir::open_to_read(state).map_err(|e| state_complaint(&e))?;
    let flow = image_to_urdf(photo, &args.exports(), tools.criticise());
    let planned = dag::plan(&flow, tools, state.as_ref());
    plan::shown(&planned.map_err(|e| state_complaint(&e))?, args.json)
}

/// Runs under a trace; whatever happens, the folder is left with a whole result or the trace alone.
fn traced(
    args: &MakeArgs,
    tools: &Arc<Tools>,
    (state, calls): (&StateDir, Arc<dyn Calls>),
    out: &OutFolder,
) -> Result<Answer, Complaint> {
    let clock: Arc<dyn Clock> = match args.clock {
        Some(time) => Arc::new(FixedClock(time)),
        None => Arc::new(SystemClock::default()),
    };
    let photo = Photo::open(&args.photo);
    let (exports, asked) = (args.exports(), providers::asked(args)?);
    let manifest = recording::manifest(tools, &exports, photo.as_ref().ok(), &asked);
    let path = out.trace_in_progress();
    let trace_complaint = |e: trace::TraceError| Complaint::from_error(&e);
    let recording = Recording::create(&path, &manifest, Arc::clone(&clock));
    let mut recording = recording.map_err(trace_complaint)?.with_calls(calls);
    let ran = match photo {
        Ok(photo) => run(args, (tools, photo), state, &mut recording, clock),
        Err(error) => {
            let complaint = Complaint::from_error(&error);
            recording.broke_off("photo", &complaint.line()).map_err(trace_complaint)?;
            Err(complaint)
        }
    };
    let finished = recording.finish().map_err(trace_complaint);
    let published = ran.and_then(|outcome| {
        finished?;
        let files = output::files(&outcome, &args.exports()).map_err(Complaint::from_stage)?;
        out.publish(&files).map_err(|e| out_complaint(&e))?;
        summary::answer(&outcome, out, args)
    });
    if published.is_err() {
        // The complaint at hand says more than one about tidying up.
        let _ = out.leave_only_trace();
    }
    published
}

fn run(
    args: &MakeArgs,
    (tools, photo): (&Arc<Tools>, Photo),
    state: &StateDir,
    recording: &mut Recording,
    clock: Arc<dyn Clock>,
) -> Result<Outcome, Complaint> {
    let cancel = Cancel::default();
    let signals = listen(&cancel, args.quiet)?;
    let (limits, version, gate) = (Limits::default(), VERSION.into(), Arc::new(AlwaysOpen));
    let options = RunOptions { limits, cancel, clock, version, gate, workers: None };
    let flow = image_to_urdf(photo, &args.exports(), tools.criticise());
    let mut progress = Progress::new(args.quiet);
    let mut ordered = InGraphOrder::new(recording);
    let mut observer = Both(&mut progress, &mut ordered);
    let ran = dag::run(&flow, tools, state, &options, &mut observer);
    signals.close();
    progress.clear();
    let released = ordered.release();
    let outcome = ran.map_err(|e| run_complaint(&e))?;
    released.map_err(|e| Complaint::from_error(&e))?;
    match &outcome.ending {
        Ending::Done => Ok(outcome),
        Ending::Failed { error, .. } => Err(Complaint::from_stage(error.clone())),
        Ending::Interrupted(_) => Err(interrupted()),
    }
}

pub(super) fn interrupted() -> Complaint {
    let complaint = Complaint::failed("interrupted");
    let complaint = complaint.hint("finished stages are kept: the same command goes on from there");
    Complaint { exit: Exit::Interrupted, ..complaint }
}

/// The first Ctrl-C lets running stages finish, the second ends the run at once.
pub(super) fn listen(
    cancel: &Cancel,
    quiet: bool,
) -> Result<signal_hook::iterator::Handle, Complaint> {
    let signals = Signals::new([SIGINT, SIGTERM]);
    let mut signals = signals.map_err(|e| Complaint::failed(format!("cannot hear Ctrl-C: {e}")))?;
    let handle = signals.handle();
    let cancel = cancel.clone();
    std::thread::spawn(move || {
        for _ in signals.forever() {
            let first = cancel.press() == Wish::Drain;
            if first && !quiet {
                let line = "stopping after the running stage, press Ctrl-C again to stop at once";
                // Nobody may be listening.
                let _ = std::io::Write::write_all(
                    &mut std::io::stderr(),
                    format!("{line}\n").as_bytes(),
                );
            }
        }
    });
    Ok(handle)
}

fn tools(args: &MakeArgs, state: &Path) -> Result<Tools, Complaint> {
    let Chosen { image_to_3d, vlm, critic } = providers::chosen(args, state)?;
    let missing: Vec<_> = [("a mesh", image_to_3d.is_none()), ("a condition", vlm.is_none())]
        .into_iter()
        .filter_map(|(what, gone)| gone.then_some(what))
        .collect();
    let (Some(image_to_3d), Some(vlm)) = (image_to_3d, vlm) else {
        return Err(nobody_to_ask(&missing));
    };
    let articulate = Box::new(Hybrid);
    let (seed, scratch) = (args.seed, state.join("tmp"));
    Ok(Tools { image_to_3d, vlm, critic, articulate, seed, scratch })
}

pub(super) fn nobody_to_ask(missing: &[&str]) -> Complaint {
    let message = format!("nobody to ask for {}: no provider is configured", missing.join(" and "));
    let mut complaint = Complaint::misused(message);
    if missing.contains(&"a mesh") {
        complaint = complaint.hint("give the object's surface with --mesh FILE.glb");
    }
    if missing.contains(&"a condition") {
        complaint = complaint.hint(
            "give its parts and joints with --condition FILE.json (`kinfold schema condition` prints the format)",
        );
    }
    complaint = complaint.hint("or name who is to be asked in kinfold.toml");
    complaint
}

/// `./<photo's name>.kinfold`
fn default_out(photo: &Path) -> PathBuf {
    let stem = photo.file_stem().unwrap_or(photo.as_os_str());
    let mut name = stem.to_os_string();
    name.push(".kinfold");
    PathBuf::from(name)
}

/// `--state` or its variable, else `kinfold` in the user's cache.
pub(super) fn state_dir(named: Option<&Path>) -> Result<PathBuf, Complaint> {
    let folder = |name: &str| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    let cache = || {
        let of_home = || Some(folder("HOME")?.join(".cache"));
        Some(folder("XDG_CACHE_HOME").or_else(of_home)?.join("kinfold"))
    };
    named.map(Path::to_path_buf).or_else(cache).ok_or_else(|| {
        let complaint = Complaint::misused("no place to keep finished stages: HOME is not set");
        complaint.hint("name a folder with --state DIR")
    })
}

pub(super) fn state_complaint(error: &StateError) -> Complaint {
    let complaint = Complaint::from_error(error);
    match error {
        StateError::InUse(_) => complaint.hint(
            "wait until the other run ends, or give this one a folder of its own with --state DIR",
        ),
        _ => complaint,
    }
}

pub(super) fn out_complaint(error: &OutError) -> Complaint {
    let complaint = Complaint::from_error(error);
    match error {
        OutError::NotOurs { .. } => complaint.hint("choose another folder with --out DIR"),
        OutError::Io { .. } => complaint,
    }
}

pub(super) fn run_complaint(error: &RunError) -> Complaint {
    match error {
        RunError::State(e) => state_complaint(e),
        RunError::Observe(e) => Complaint::from_error(e),
    }
}
