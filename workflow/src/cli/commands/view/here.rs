//! The part of `kinfold view` that reads what strangers wrote, in a process of its own.

use sim_check::read::load;
use sim_check::{CheckOptions, Outside, Tier};

use super::model::{Model, found};
use super::shown::{Shown, Told};
use crate::cli::args::ViewArgs;
use crate::cli::isolated::answer_once;
use crate::cli::speech::{Answer, Complaint};
use crate::stages::page::{Subject, scene};

/// One line for the process that asked: a page, or why there is none.
///
/// # Errors
/// [`Complaint`] when this process cannot be bounded.
pub(super) fn answer(args: &ViewArgs) -> Result<Answer, Complaint> {
    answer_once().map_err(|e| Complaint::failed(format!("this process cannot be bounded: {e}")))?;
    let told = match found(&args.path) {
        Ok(model) => Told::Page(shown(&model, args)),
        Err(Complaint { message, hints, .. }) => Told::Complaint { message, hints },
    };
    let line = serde_json::to_string(&told).map_err(|e| Complaint::from_error(&e))?;
    Ok(Answer::done(line + "\n"))
}

fn shown(model: &Model, args: &ViewArgs) -> Shown {
    let options = CheckOptions {
        seed: args.seed,
        up_to: Tier::Dynamic,
        outside: if args.allow_outside { Outside::Allowed } else { Outside::Refused },
        ..CheckOptions::default()
    };
    let unchecked = args.unchecked.as_ref();
    let verdict = unchecked.is_none().then(|| sim_check::check(&model.file, &options));
    let loaded = load::read(&model.file, &options);
    let mut notes = model.notes.clone();
    notes.extend(unchecked.map(|why| format!("Not checked: {why}.")));
    if loaded.robot.is_none() {
        notes.push("It could not be read as one model.".into());
        // Without a verdict these are all that is known.
        let faults = loaded.checks.iter().filter(|c| verdict.is_none() && !c.holds());
        notes.extend(faults.flat_map(|c| c.evidence.iter().take(3).cloned()));
    }
    let name = if loaded.name.is_empty() { &model.name } else { &loaded.name };
    let sidecar = model.sidecar();
    let subject = Subject {
        name,
        robot: loaded.robot.as_ref(),
        verdict: verdict.as_ref(),
        sidecar: sidecar.as_ref(),
        notes,
    };
    let scene = scene(&subject);
    let failures = verdict.iter().flat_map(|v| v.failures().map(|c| c.id.clone()));
    Shown {
        html: page::write(&scene),
        name: name.clone(),
        links: scene.links.len(),
        moving_joints: loaded.moving_joints,
        tier: verdict.as_ref().map(|v| v.tier.name().to_owned()),
        failures: failures.collect(),
        notes: scene.notes,
    }
}
