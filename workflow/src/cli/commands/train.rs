//! `kinfold train`: a pack by its recipe, or weights for the articulation network, in runs that may be
//! interrupted.

use std::io::{self, IsTerminal, Write};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use serde_json::json;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use training::fit::{self, FitError};
use training::train::{Event, Outcome, TrainConfig, TrainError, Watcher, train};

use crate::cli::args::TrainArgs;
use crate::cli::speech::{Answer, Complaint, Exit};

/// Objects between two lines about measuring.
const MEASURED: u64 = 50;

/// Trains until the last step, until the time is up, or until Ctrl-C; the same command goes on.
///
/// # Errors
/// [`Complaint`] when the configuration, the data or the disk will not do.
pub fn run(args: &TrainArgs) -> Result<Answer, Complaint> {
    if fit::fit_of(&args.config).map_err(|e| refused(&e))?.is_some() {
        return run_fit(args);
    }
    let config = TrainConfig::read(&args.config).map_err(|e| complaint(&e))?;
    let mut teller = Teller::new(args, Some(config.steps))?;
    let ended = train(&config, &mut teller);
    teller.clear();
    let outcome = ended.map_err(|e| complaint(&e))?;
    Ok(answer(&outcome, config.steps, args.json, teller.stopped()))
}

/// Fits until the pack is there, until the time is up, or until Ctrl-C; the same command goes on.
fn run_fit(args: &TrainArgs) -> Result<Answer, Complaint> {
    let teller = Teller::new(args, None)?;
    let outcome = fit::fit(&args.config, &teller).map_err(|e| refused(&e))?;
    Ok(fit_answer(&outcome, args.json, teller.stopped()))
}

fn fit_answer(outcome: &fit::Outcome, as_json: bool, stopped: bool) -> Answer {
    let fit::Outcome { finished, pack, made, found, metrics } = outcome;
    let pack = pack.display().to_string();
    let result = if as_json {
        json!({
            "finished": finished, "pack": pack, "made": made, "found": found, "metrics": metrics
        })
        .to_string()
            + "\n"
    } else if *finished {
        format!("{pack}: {made} models fitted, {found} taken over\n")
    } else {
        format!("{pack} is not there yet: {made} models fitted, {found} taken over\n")
    };
    let exit = if stopped && !finished { Exit::Interrupted } else { Exit::Done };
    let hint = "hint: the same command goes on from there".to_owned();
    Answer { result, remarks: if *finished { vec![] } else { vec![hint] }, exit }
}

fn refused(error: &FitError) -> Complaint {
    let told = Complaint::from_error(error);
    match error {
        FitError::Busy(_) => told.hint("wait for the other run, or give this one another `out`"),
        FitError::Nothing(_) => told.hint("name more objects, or other families"),
        _ => told,
    }
}

fn answer(outcome: &Outcome, steps: u64, as_json: bool, stopped: bool) -> Answer {
    let Outcome { step, finished, weights } = outcome;
    let weights = weights.display().to_string();
    let result = if as_json {
        json!({ "step": step, "steps": steps, "finished": finished, "weights": weights })
            .to_string()
            + "\n"
    } else {
        format!("{weights} after {step} of {steps} steps\n")
    };
    let exit = if stopped && !finished { Exit::Interrupted } else { Exit::Done };
    let hint = "hint: the same command goes on from there".to_owned();
    Answer { result, remarks: if *finished { vec![] } else { vec![hint] }, exit }
}

fn complaint(error: &TrainError) -> Complaint {
    let told = Complaint::from_error(error);
    match error {
        TrainError::OtherRun(_) => {
            told.hint("give the run another `out`, and start it from the old weights with `from`")
        }
        TrainError::OtherSizes(_) => {
            told.hint("take the sizes the weights were trained with, or leave `from` away")
        }
        TrainError::Busy(_) => told.hint("wait for the other run, or give this one another `out`"),
        TrainError::Diverged { .. } => {
            told.hint("lower `schedule.rate` or lengthen `schedule.warmup`")
        }
        _ => told,
    }
}

/// Tells on stderr how the run goes, and ends it when the time is up or somebody wants to stop.
struct Teller {
    bar: Option<ProgressBar>,
    quiet: bool,
    until: Option<Instant>,
    began: Instant,
    wish: std::sync::Arc<std::sync::atomic::AtomicBool>,
    measured: AtomicU64,
    stderr: Mutex<()>,
}

impl Teller {
    /// With a bar where it is known how many steps there are.
    fn new(args: &TrainArgs, steps: Option<u64>) -> Result<Self, Complaint> {
        let lively = !args.quiet && io::stderr().is_terminal();
        let bar = steps.filter(|_| lively).map(|steps| {
            let bar = ProgressBar::new(steps);
            let style = ProgressStyle::with_template("{wide_bar} {pos}/{len} {msg} {eta}");
            bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
            bar
        });
        let wish = std::sync::Arc::new(std::sync::atomic::AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM] {
            let told = |e: io::Error| Complaint::failed(format!("cannot hear Ctrl-C: {e}"));
            // The second one ends the program at once; the last checkpoint stays.
            flag::register_conditional_shutdown(signal, Exit::Interrupted as i32, wish.clone())
                .map_err(told)?;
            flag::register(signal, wish.clone()).map_err(told)?;
        }
        let began = Instant::now();
        let limit = args.minutes.map(|m| Duration::try_from_secs_f64(m * 60.0)).transpose();
        let limit = limit.map_err(|e| Complaint::misused(format!("--minutes: {e}")))?;
        let until = limit.and_then(|limit| began.checked_add(limit));
        let (measured, stderr) = (AtomicU64::new(0), Mutex::new(()));
        Ok(Self { bar, quiet: args.quiet, until, began, wish, measured, stderr })
    }

    fn stopped(&self) -> bool {
        self.wish.load(Ordering::SeqCst)
    }

    fn clear(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }

    fn say(&self, line: &str) {
        let line = &*guard::text::shown(line);
        match &self.bar {
            Some(bar) => bar.println(line),
            None if self.quiet => {}
            None => {
                let _one_at_a_time = self.stderr.lock();
                // Nobody may be listening; that is no reason to stop.
                let _ = writeln!(io::stderr(), "{line}");
            }
        }
    }
}

impl fit::Watcher for Teller {
    fn say(&self, line: &str) {
        Self::say(self, &format!("{:>6.0} s  {line}", self.began.elapsed().as_secs_f64()));
    }

    fn go_on(&self, made: usize) -> bool {
        // A run that is short of time makes one model at least, or it would never end.
        let has_time = self.until.is_none_or(|until| Instant::now() < until);
        !self.stopped() && (made == 0 || has_time)
    }
}

impl Watcher for Teller {
    fn notice(&mut self, event: &Event) {
        let seconds = self.began.elapsed().as_secs_f64();
        match event {
            Event::Ready { objects, step } => {
                let objects: Vec<_> = objects.iter().map(usize::to_string).collect();
                self.say(&format!("{} objects, from step {step}", objects.join(" + ")));
            }
            Event::Stepped { step, loss } => {
                if let Some(bar) = &self.bar {
                    bar.set_position(*step);
                    bar.set_message(format!("loss {loss:.3}"));
                }
            }
            Event::Curve { step, losses: [loss, part, joint] } => self.say(&format!(
                "step {step:>7}  loss {loss:.4}  parts {part:.4}  joints {joint:.4}  {seconds:.0} s"
            )),
            Event::Saved(step) => self.say(&format!("step {step:>7}  saved")),
            Event::Validated { step, set, score } => self.say(&format!(
                "step {step:>7}  {set}: accuracy {:.3}  miou {:.3}  axes {:.1} deg  within 15 {:.3}",
                score.accuracy, score.miou, score.axis_error, score.within_15
            )),
        }
    }

    fn measured(&self, id: &str) {
        let count = self.measured.fetch_add(1, Ordering::SeqCst) + 1;
        if count.is_multiple_of(MEASURED) {
            self.say(&format!("measured {count} objects, the last {id}"));
        }
    }

    fn go_on(&mut self) -> bool {
        !self.stopped() && self.until.is_none_or(|until| Instant::now() < until)
    }
}
