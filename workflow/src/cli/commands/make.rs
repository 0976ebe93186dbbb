//! `kinfold make`: one photo to one checked URDF.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use adapters::Photo;
use adapters::net::calls::Calls;
use model::Choice;
use runner::observe::Both;
use runner::ours::{LockError, Turns};
use runner::{
    self, AlwaysOpen, Cancel, Ending, InGraphOrder, Limits, Observer, Outcome, RunError,
    RunOptions, StateDir, StateError, Wish,
};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::iterator::Signals;
use sim_check::Tier;
use trace::{Clock, Digest, FixedClock, SystemClock};

use super::given;
use super::providers::Chosen;
use super::summary::{self, Shipped};
use super::{plan, providers};
use crate::cli::args::MakeArgs;
use crate::cli::progress::Progress;
use crate::cli::speech::{Answer, Complaint, Exit};
use crate::image_to_urdf::image_to_urdf;
use crate::output::{self, Attempt, OutError, OutFolder, Standing, sureness};
use crate::recording::{self, Recording, VERSION};
use crate::stages::{Checked, Tools};

/// Makes an asset, or says what it would do.
///
/// # Errors
/// [`Complaint`], naming the file, the rule and what was found. A trace in the output folder says
/// how far it went.
pub fn make(args: &MakeArgs) -> Result<Answer, Complaint> {
    with(args, Company::Person)
}

/// Who is there while an asset is made.
pub(in crate::cli) enum Company<'a> {
    /// A person at the command line, who is told on stderr and has Ctrl-C.
    Person,
    /// A program, which is told of everything and stops it by itself.
    Program(&'a mut (dyn Observer + Send), Cancel),
}

/// The same as [`make`] in this company.
pub(in crate::cli) fn with(args: &MakeArgs, company: Company<'_>) -> Result<Answer, Complaint> {
    answered(args, company).map_err(|complaint| summary::with_result(complaint, args.json))
}

fn answered(args: &MakeArgs, company: Company<'_>) -> Result<Answer, Complaint> {
    given::agree(args)?;
    let state = state_dir(args.state.as_deref())?;
    let tools = Arc::new(tools(args, &state)?);
    if args.graph {
        let photo = given::photo(args).map_err(|e| Complaint::from_error(&e))?;
        let flow = image_to_urdf(photo, &args.exports(), tools.criticise());
        return Ok(Answer::done(flow.graphviz()));
    }
    let root = args.out.clone().unwrap_or_else(|| default_out(args.named()));
    look(&root, &state)?;
    if args.dry_run {
        return dry_run(args, &tools, &state);
    }
    let calls = Arc::new(providers::calls(&state));
    // Whoever waits for his turn is ended by the first Ctrl-C.
    let turns = Turns { wait: !args.no_wait, tell: !args.quiet };
    let out = OutFolder::open(&root, turns).map_err(|e| out_complaint(&e))?;
    if args.out.is_none() {
        of_the_same_photo(args, &out)?;
    }
    let state = StateDir::open_in_turn(&state, turns).map_err(|e| state_complaint(&e))?;
    traced((args, company), &tools, (&state, calls), &out)
}

/// Refuses a folder that nobody named where an asset of another photo stands: photos of one name from
/// different folders must not replace each other's assets.
fn of_the_same_photo(args: &MakeArgs, out: &OutFolder) -> Result<(), Complaint> {
    match is_other(args, out) {
        false => Ok(()),
        true => {
            let found = format!(
                "expected nothing or an asset of this photo in {}, found one of another photo",
                runner::ours::name(out.shown())
            );
            Err(Complaint::misused(found).hint("name a folder with --out DIR"))
        }
    }
}

/// Whether the asset that stands there is of another photo.
fn is_other(args: &MakeArgs, out: &OutFolder) -> bool {
    let photo = given::photo(args).ok().map(|photo| Digest::of(&photo.bytes));
    matches!((out.photo(), photo), (Some(there), Some(own)) if there != own)
}

/// Refuses folders that cannot be used, before anything is created.
fn look(root: &Path, state: &Path) -> Result<(), Complaint> {
    OutFolder::look(root).map_err(|e| out_complaint(&e))?;
    StateDir::open_to_read(state).map_err(|e| state_complaint(&e))?;
    let whole = |path: &Path| {
        let whole = std::fs::canonicalize(path).or_else(|_| std::path::absolute(path));
        whole.unwrap_or_else(|_| path.to_path_buf())
    };
    let mut shelf = root.file_name().unwrap_or_default().to_owned();
    shelf.push(".failed");
    let inside = |folder: &Path| whole(state).starts_with(whole(folder));
    if inside(root) || inside(&root.with_file_name(shelf)) {
        let found = format!(
            "expected a state directory outside the output folder and that of its failed runs, \
             found {} for {}",
            runner::ours::name(state),
            runner::ours::name(root)
        );
        return Err(Complaint::misused(found).hint("name another folder with --state DIR"));
    }
    Ok(())
}

fn dry_run(args: &MakeArgs, tools: &Tools, state: &Path) -> Result<Answer, Complaint> {
    let photo = given::photo(args).map_err(|e| Complaint::from_error(&e))?;
    let state = StateDir::open_to_read(state).map_err(|e| state_complaint(&e))?;
    let flow = image_to_urdf(photo, &args.exports(), tools.criticise());
    let planned = runner::plan(&flow, tools, state.as_ref());
    plan::shown(&planned.map_err(|e| state_complaint(&e))?, args.json)
}

/// Runs under a trace. What stands in the output folder changes when all is done, by one step; the
/// trace of a run that fails stays beside it.
fn traced(
    (args, company): (&MakeArgs, Company<'_>),
    tools: &Arc<Tools>,
    (state, calls): (&StateDir, Arc<dyn Calls>),
    out: &OutFolder,
) -> Result<Answer, Complaint> {
    let attempt = out.begin().map_err(|e| out_complaint(&e))?;
    match recorded((args, company), tools, (state, calls), &attempt) {
        Ok((outcome, remarks)) => {
            let mut answer = shipped(args, &outcome, out, attempt)?;
            answer.remarks.extend(remarks);
            Ok(answer)
        }
        Err(complaint) => {
            let trace = attempt.fail();
            Err(complaint.hint(trace_of(&trace)))
        }
    }
}

fn trace_of(trace: &Path) -> String {
    format!("the trace of this run is {}", runner::ours::name(trace))
}

fn recorded(
    (args, company): (&MakeArgs, Company<'_>),
    tools: &Arc<Tools>,
    (state, calls): (&StateDir, Arc<dyn Calls>),
    attempt: &Attempt<'_>,
) -> Result<(Outcome, Vec<String>), Complaint> {
    let clock: Arc<dyn Clock> = match args.clock {
        Some(time) => Arc::new(FixedClock(time)),
        None => Arc::new(SystemClock::default()),
    };
    let photo = given::photo(args);
    let (exports, asked) = (args.exports(), providers::asked(args)?);
    let manifest = recording::manifest(tools, &exports, photo.as_ref().ok(), &asked);
    let trace_complaint = |e: trace::TraceError| Complaint::from_error(&e);
    let recording = Recording::create(&attempt.trace(), &manifest, Arc::clone(&clock));
    let mut recording = recording.map_err(trace_complaint)?.with_calls(calls);
    let looked = given::looked_at(args);
    let ran = match (photo, &looked) {
        (Ok(_), Err(error)) => {
            let complaint = Complaint::from_stage(error.clone());
            let told = recording.broke_off("propose-condition", &complaint.line());
            told.map_err(trace_complaint)?;
            Err(complaint)
        }
        (Ok(photo), Ok(_)) => run((args, company), (tools, photo), state, &mut recording, clock),
        (Err(error), _) => {
            let complaint = Complaint::from_error(&error);
            let stage = if args.photo.is_some() { "photo" } else { "generate-mesh" };
            recording.broke_off(stage, &complaint.line()).map_err(trace_complaint)?;
            Err(complaint)
        }
    };
    let finished = recording.finish().map_err(trace_complaint);
    let outcome = ran?;
    finished.map(|()| (outcome, looked.unwrap_or_default()))
}

/// Puts what was made where the asset stands, or beside it where that is better.
fn shipped(
    args: &MakeArgs,
    outcome: &Outcome,
    out: &OutFolder,
    attempt: Attempt<'_>,
) -> Result<Answer, Complaint> {
    let files = output::files(outcome, &args.exports()).map_err(Complaint::from_stage)?;
    let checked = outcome.artefact::<_, Checked>("check-in-sim").map_err(Complaint::from_stage)?;
    let verdict = &checked.verdict;
    let better = (verdict.tier < args.tier).then(|| better(out.standing(), verdict.tier)).flatten();
    let trace = attempt.folder().join("trace.mcap");
    let mut remarks = Vec::new();
    if better.is_none() && is_other(args, out) {
        remarks.push("an asset of another photo stood there, and was replaced".to_owned());
    }
    let place = match &better {
        None => attempt.publish(&files).map(|gone| {
            let told = |name| format!("{name} was of what stood there before, and is gone");
            remarks.extend(gone.into_iter().map(told));
            out.shown().to_path_buf()
        }),
        Some(_) => attempt.keep_apart(&files),
    };
    let place = place.map_err(|e| out_complaint(&e).hint(trace_of(&trace)))?;
    let said = sureness::confidence(&files);
    let shipped = Shipped { place, better };
    let mut answer = summary::answer(outcome, (&checked.verdict, said), &shipped, args);
    answer.remarks.extend(remarks);
    Ok(answer)
}

/// Why an asset below the tier asked for does not take the place of what stands; none if it may.
fn better(standing: Standing, tier: Tier) -> Option<String> {
    match standing {
        Standing::Asset(there) if there > tier => {
            Some(format!("an asset of tier {} stands there", there.name()))
        }
        Standing::Unknown(why) => {
            Some(format!("an asset stands there of which nobody can say how good it is: {why}"))
        }
        Standing::Asset(_) | Standing::Nothing => None,
    }
}

fn run(
    (args, company): (&MakeArgs, Company<'_>),
    (tools, photo): (&Arc<Tools>, Photo),
    state: &StateDir,
    recording: &mut Recording,
    clock: Arc<dyn Clock>,
) -> Result<Outcome, Complaint> {
    let flow = image_to_urdf(photo, &args.exports(), tools.criticise());
    let mut ordered = InGraphOrder::new(recording);
    let run = |observer: &mut dyn Observer, cancel: Cancel| {
        let (limits, version, gate) = (Limits::default(), VERSION.into(), Arc::new(AlwaysOpen));
        let options = RunOptions { limits, cancel, clock, version, gate, workers: None };
        runner::run(&flow, tools, state, &options, &mut Both(observer, &mut ordered))
    };
    let ran = match company {
        Company::Person => {
            let cancel = Cancel::default();
            let signals = listen(&cancel, args.quiet)?;
            let mut progress = Progress::new(args.quiet);
            let ran = run(&mut progress, cancel);
            signals.close();
            progress.clear();
            ran
        }
        Company::Program(observer, cancel) => run(observer, cancel),
    };
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

pub(super) fn tools(args: &MakeArgs, state: &Path) -> Result<Tools, Complaint> {
    let Chosen { image_to_3d, vlm, critic } = providers::chosen(args, state)?;
    let missing: Vec<_> = [("a mesh", image_to_3d.is_none()), ("a condition", vlm.is_none())]
        .into_iter()
        .filter_map(|(what, gone)| gone.then_some(what))
        .collect();
    let (Some(image_to_3d), Some(vlm)) = (image_to_3d, vlm) else {
        let complaint = nobody_to_ask(&missing);
        return Err(match missing.contains(&"a condition") {
            true => complaint.hint("or ask a server of your own with --vlm URL --model NAME"),
            false => complaint,
        });
    };
    let articulate = model::articulator(Choice::default());
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
pub(super) fn default_out(photo: &Path) -> PathBuf {
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
        StateError::Lock { source: LockError::InUse(_), .. } => complaint.hint(
            "without --no-wait this one waits, or give it a folder of its own with --state DIR",
        ),
        StateError::Lock { .. } | StateError::NotOurs { .. } => {
            complaint.hint("choose a new or an empty folder with --state DIR")
        }
        _ => complaint,
    }
}

pub(super) fn out_complaint(error: &OutError) -> Complaint {
    let complaint = Complaint::from_error(error);
    match error {
        OutError::NotOurs { .. } | OutError::Kind { .. } => {
            complaint.hint("choose a new or an empty folder with --out DIR")
        }
        OutError::Place { root, .. } => {
            let inner = runner::ours::name(&root.join("asset"));
            complaint.hint(format!("name a folder in it, such as --out {inner}"))
        }
        OutError::Lock { source: LockError::InUse(_), .. } => complaint
            .hint("without --no-wait this one waits, or choose another folder with --out DIR"),
        OutError::Lock { .. } => complaint.hint("choose another folder with --out DIR"),
        OutError::Stuck(_) => {
            complaint.hint("move it somewhere else, or choose another folder with --out DIR")
        }
        OutError::Io { .. } => complaint,
    }
}

pub(super) fn run_complaint(error: &RunError) -> Complaint {
    match error {
        RunError::State(e) => state_complaint(e),
        RunError::Observe(e) => Complaint::from_error(e),
    }
}
