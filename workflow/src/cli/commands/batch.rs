//! `kinfold batch`: many photos to many assets.

use std::path::Path;
use std::sync::Arc;

use adapters::Config;
use runner::Cancel;
use runner::ours::Turns;
use serde_json::{Value, json};
use sim_check::Tier;
use trace::{Clock, FixedClock, SystemClock};

use super::providers::{Chosen, Wanted};
use super::{engines, make, providers};
use crate::batch::allowance::{Allowance, Prices};
use crate::batch::estimate::{Estimate, estimate};
use crate::batch::folder::BatchFolder;
use crate::batch::gate::AtOnce;
use crate::batch::index::{self, IndexError};
use crate::batch::item::{Onlooker, Settings};
use crate::batch::manifest::settled;
use crate::batch::plan::Share;
use crate::batch::run::{Opened, Order, Summary, run};
use crate::batch::{BatchError, report};
use crate::cli::args::{BatchArgs, BatchCommand};
use crate::cli::speech::{Answer, Complaint, Exit};
use crate::stages::Export;

/// Runs a batch, or says what it would do.
///
/// # Errors
/// [`Complaint`] when it cannot go on; what has an outcome keeps it.
pub fn batch(args: &BatchArgs) -> Result<Answer, Complaint> {
    if let Some(BatchCommand::Report { folder, json }) = &args.command {
        return report(folder, *json);
    }
    with(args, Company::Person)
}

/// Who is there while a batch runs.
pub(in crate::cli) enum Company {
    /// A person at the command line, who has Ctrl-C.
    Person,
    /// A program, which is told of every item and stops it by itself.
    Program(Arc<dyn Onlooker + Send + Sync>, Cancel),
}

/// Runs a batch in this company.
pub(in crate::cli) fn with(args: &BatchArgs, company: Company) -> Result<Answer, Complaint> {
    let answered = answered(args, company);
    answered.map_err(|complaint| super::summary::with_result(complaint, args.json))
}

/// Writes index and report of a batch.
fn report(folder: &Path, json: bool) -> Result<Answer, Complaint> {
    let (page, figures) = report::write(folder).map_err(|e| index_complaint(&e))?;
    let index = folder.join(index::FILE);
    if !json {
        let names = [&page, &index].map(|path| path.to_string_lossy().into_owned());
        let lines = names.iter().map(|name| format!("{}\n", guard::text::shown(name)));
        return Ok(Answer::done(lines.collect::<String>()));
    }
    let total = figures.total;
    let value = json!({
        "report": page.display().to_string(),
        "index": index.display().to_string(),
        "items": total.all(),
        "accepted": total.accepted,
        "rejected": total.rejected,
        "failed": total.failed,
        "calls": figures.calls,
        "cost": figures.cost,
        "cost_per_accepted": figures.cost_per_accepted(),
        "near_duplicates": figures.twin_count,
    });
    Ok(Answer::done(format!("{value:#}\n")))
}

fn index_complaint(error: &IndexError) -> Complaint {
    match error {
        IndexError::Folder(e) => complaint(e),
        _ => Complaint::from_error(error),
    }
}

fn answered(args: &BatchArgs, company: Company) -> Result<Answer, Complaint> {
    let mut order = order(args)?;
    order.look().map_err(|e| complaint(&e))?;
    if args.dry_run {
        return estimated(&order, args);
    }
    let shared = |address| engines::shared(address, args.shard);
    order.depot = args.store.as_ref().map(shared).transpose()?;
    let engine = engines::chosen(args, order.at_once, order.depot.as_ref())?;
    // Whoever waits for his turn is ended by the first Ctrl-C.
    let turns = Turns { wait: !args.no_wait, tell: !args.quiet };
    let opened = opened(&order, args.shard.and(args.out.as_deref()), turns);
    let opened = opened.map_err(|e| complaint(&e))?;
    let (cancel, signals) = match company {
        Company::Person => {
            let cancel = Cancel::default();
            let signals = make::listen(&cancel, args.quiet)?;
            (cancel, Some(signals))
        }
        Company::Program(onlooker, cancel) => {
            order.onlooker = Some(onlooker);
            (cancel, None)
        }
    };
    let clock: Arc<dyn Clock> = match args.clock {
        Some(time) => Arc::new(FixedClock(time)),
        None => Arc::new(SystemClock::default()),
    };
    let ran = run(&order, &opened, &*engine, &cancel, clock);
    if let Some(signals) = signals {
        signals.close();
    }
    let summary = ran.map_err(|e| complaint(&e))?;
    index::write(&order.out).map_err(|e| index_complaint(&e))?;
    // Until here nobody else writes in it.
    drop(opened);
    Ok(answer(&summary, args))
}

/// The batch's folders, and the marker of the folder around its shards.
fn opened(order: &Order, around: Option<&Path>, turns: Turns) -> Result<Opened, BatchError> {
    around.map_or(Ok(()), BatchFolder::claim)?;
    Opened::of(order, turns)
}

/// What a batch would do, as far as that is known before.
fn estimated(order: &Order, args: &BatchArgs) -> Result<Answer, Complaint> {
    let estimate = estimate(order, args.shard.unwrap_or(Share::ALL)).map_err(|e| complaint(&e))?;
    let Estimate { items, bad_lines, settled, todo, cost, seconds, .. } = estimate;
    let Estimate { meshes, conditions, critiques, requests, .. } = estimate;
    let exit = if bad_lines > 0 { Exit::Losses } else { Exit::Done };
    let remarks = estimate_remarks(&estimate);
    if args.json {
        let mut value = json!({
            "items": items, "bad_lines": bad_lines, "settled": settled, "todo": todo,
            "calls": { "mesh": meshes, "condition": conditions }, "requests": requests,
            "cost": cost, "cpu_seconds": seconds,
        });
        if critiques > 0 {
            value["calls"]["critique"] = critiques.into();
        }
        return Ok(Answer { result: format!("{value:#}\n"), remarks, exit });
    }
    let looks = if critiques > 0 { format!(", {critiques} for critiques") } else { String::new() };
    let time = seconds
        .map_or("unknown: no item was made yet".into(), |s| format!("{s:.0} s of computing"));
    let result = format!(
        "items      {items}\nbad lines  {bad_lines}\nsettled    {settled}\nto do      {todo}\n\
         calls      at most {meshes} for meshes, {conditions} for conditions{looks}\nrequests   {requests} for all of them, repairs and repeats not counted\ncost       at most {cost:.2}, repairs and repeats not counted\ntime       {time}\n"
    );
    Ok(Answer { result, remarks, exit })
}

fn estimate_remarks(estimate: &Estimate) -> Vec<String> {
    let bad =
        (estimate.bad_lines > 0).then(|| format!("{} lines are no items", estimate.bad_lines));
    let told = estimate.told.iter().map(|(line, why)| format!("line {line}: {why}"));
    bad.into_iter().chain(told).collect()
}

fn order(args: &BatchArgs) -> Result<Order, Complaint> {
    // The command line demands both where nothing else is asked for.
    let manifest = settled(args.manifest.as_deref().unwrap_or(Path::new("")));
    let root = args.out.clone().unwrap_or_default();
    let out = match args.shard {
        Some(Share { k, of }) => root.join(format!("shard-{k}-of-{of}")),
        None => root,
    };
    let state = args.state.clone().unwrap_or_else(|| out.join("state"));
    let (named, trusted) = (args.config.as_deref(), args.trust_config);
    let wanted = Wanted { named, trusted, mesh: true, condition: true };
    let config = providers::configured(&wanted)?;
    let to_look_at = Export::ALL.into_iter().filter(|e| args.pages && e.is_for_looking());
    let exports = args.export.iter().copied().chain([Export::Urdf]).chain(to_look_at);
    let exports: std::collections::BTreeSet<_> = exports.collect();
    let exports = exports.into_iter().collect();
    let (tier, seed, min_confidence) = (args.tier, args.seed, args.min_confidence);
    let settings = settings(config, &state, Made { exports, tier, seed, min_confidence })?;
    let prices = Prices { mesh: args.mesh_price, condition: args.condition_price };
    Ok(Order {
        manifest,
        out,
        state,
        depot: None,
        settings,
        at_once: AtOnce {
            cpu: engines::jobs(args),
            mesh: args.mesh_calls,
            condition: args.condition_calls,
        },
        allowance: Allowance::new(args.max_calls, args.max_cost, prices),
        retry: args.retry.clone(),
        onlooker: None,
        quiet: args.quiet,
    })
}

/// What every item is to be like.
pub(super) struct Made {
    pub exports: Vec<Export>,
    pub tier: Tier,
    pub seed: u64,
    pub min_confidence: Option<f64>,
}

/// What items are made with, by whom a configuration names.
pub(super) fn settings(config: Config, state: &Path, made: Made) -> Result<Settings, Complaint> {
    let Chosen { image_to_3d, vlm, critic } = providers::hired(&config, state)?;
    let Made { exports, tier, seed, min_confidence } = made;
    Ok(Settings {
        exports,
        tier,
        seed,
        min_confidence,
        image_to_3d: image_to_3d.map(Arc::from),
        vlm: vlm.map(Arc::from),
        critic: critic.map(Arc::from),
        asked: config.redacted(),
        calls: Arc::new(providers::calls(state)),
        world: providers::world(state),
        config,
    })
}

fn answer(summary: &Summary, args: &BatchArgs) -> Answer {
    let all = summary.standing.accepted == summary.standing.planned && summary.standing.bad == 0;
    let exit = match (summary.interrupted, all) {
        (true, _) => Exit::Interrupted,
        (false, true) => Exit::Done,
        (false, false) => Exit::Losses,
    };
    let result = if args.json { in_json(summary, exit) } else { in_words(summary) };
    Answer { result, remarks: remarks(summary), exit }
}

fn in_words(summary: &Summary) -> String {
    let standing = &summary.standing;
    let rows = [
        ("accepted", standing.accepted),
        ("rejected", standing.rejected),
        ("failed", standing.failed),
        ("left", summary.left()),
        ("bad lines", standing.bad),
    ];
    let shown = rows.iter().filter(|(name, n)| *n > 0 || *name == "accepted");
    shown.map(|(name, n)| format!("{name:<10} {n}\n")).collect()
}

fn in_json(summary: &Summary, exit: Exit) -> String {
    let Summary { tally, standing, spent, .. } = summary;
    let outcome = match exit {
        Exit::Done => "done",
        Exit::Interrupted => "interrupted",
        _ => "done with losses",
    };
    let bad: Vec<Value> =
        summary.bad_lines.iter().map(|(line, why)| json!({ "line": line, "why": why })).collect();
    let value = json!({
        "outcome": outcome,
        "planned": standing.planned,
        "accepted": standing.accepted,
        "rejected": standing.rejected,
        "failed": standing.failed,
        "left": summary.left(),
        "bad_lines": standing.bad,
        "first_bad_lines": bad,
        "calls": spent.calls,
        "cost": spent.cost,
        "this_run": {
            "resumed": summary.resumed,
            "items": tally.done,
            "accepted": tally.accepted,
            "rejected": tally.rejected,
            "failed": tally.failed,
            "classes": tally.classes,
            "stages_run": tally.stages_run,
            "stages_recalled": tally.stages_recalled,
        },
    });
    format!("{value:#}\n")
}

fn remarks(summary: &Summary) -> Vec<String> {
    let mut remarks = Vec::new();
    let classes = &summary.tally.classes;
    if !classes.is_empty() {
        let words: Vec<_> = classes.iter().map(|(class, n)| format!("{class} {n}")).collect();
        remarks.push(format!("not accepted in this run: {}", words.join(", ")));
    }
    if classes.contains_key("budget") {
        remarks
            .push("hint: the same command with a larger --max-calls or --max-cost goes on".into());
    } else if summary.left() > 0 && !summary.interrupted {
        remarks.push("hint: the same command tries what is left again".into());
    }
    if summary.interrupted {
        remarks.push("interrupted; the same command goes on from there".into());
    }
    remarks
}

pub(super) fn complaint(error: &BatchError) -> Complaint {
    let complaint = Complaint::from_error(error);
    let kept = "what has an outcome keeps it: the same command goes on from there";
    match error {
        BatchError::State(e) => make::state_complaint(e),
        BatchError::Run(e) => make::run_complaint(e).hint(kept),
        BatchError::Out(e) => make::out_complaint(e).hint(kept),
        BatchError::Spending { .. } => complaint.hint(
            "`kinfold audit DIR` says more; without --max-calls and --max-cost the batch goes on",
        ),
        BatchError::Nobody { .. } => Complaint { exit: Exit::Misused, ..complaint }
            .hint("name who is to be asked in kinfold.toml, or give the file in the manifest"),
        BatchError::Lock { .. } => complaint
            .hint("without --no-wait this one waits, or choose another folder with --out DIR"),
        BatchError::NotOurs { .. } => {
            complaint.hint("choose a new or an empty folder with --out DIR")
        }
        BatchError::Folder { .. } => complaint,
        BatchError::Manifest(_) => complaint,
        _ => complaint.hint(kept),
    }
}
