//! What a person sees while a run goes on: a line per stage, and a spinner on a terminal.

use std::io::{self, IsTerminal, Write};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use adapters::overheard::Onlooker;
use indicatif::{ProgressBar, ProgressStyle};
use runner::observe::What;
use runner::{Event, ObserveError, Observer};

/// The spinner of this terminal: whatever is written beside it goes through it.
static SPINNING: Mutex<Option<ProgressBar>> = Mutex::new(None);

/// Shows on stderr what a program says while it runs, each line with the program's name.
pub fn onlooker() -> Onlooker {
    Arc::new(|program: &str, line: &str| {
        let plain = anstream::adapter::strip_str(line).to_string();
        let line = format!("{}: {}", guard::text::shown(program), guard::text::shown(&plain));
        let spinner = SPINNING.lock().unwrap_or_else(|e| e.into_inner()).clone();
        match spinner {
            Some(spinner) => spinner.println(line),
            // Nobody may be listening; that is no reason to stop.
            None => drop(writeln!(io::stderr(), "{line}")),
        }
    })
}

/// Tells on stderr what happens.
pub struct Progress {
    spinner: Option<ProgressBar>,
    began: Option<Instant>,
    quiet: bool,
}

impl Progress {
    /// Lines, and a spinner if stderr is a terminal; nothing at all if `quiet`.
    pub fn new(quiet: bool) -> Self {
        let lively = !quiet && io::stderr().is_terminal();
        let spinner = lively.then(|| {
            let bar = ProgressBar::new_spinner();
            let style = ProgressStyle::with_template("{spinner} {msg} {elapsed}");
            bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()));
            bar.enable_steady_tick(Duration::from_millis(100));
            bar
        });
        *SPINNING.lock().unwrap_or_else(|e| e.into_inner()) = spinner.clone();
        Self { spinner, began: None, quiet }
    }

    /// Takes the spinner off the screen.
    pub fn clear(&self) {
        *SPINNING.lock().unwrap_or_else(|e| e.into_inner()) = None;
        if let Some(spinner) = &self.spinner {
            spinner.finish_and_clear();
        }
    }

    fn say(&self, line: &str) {
        let line = &*guard::text::shown(line);
        match &self.spinner {
            Some(spinner) => spinner.println(line),
            None if self.quiet => {}
            // Nobody may be listening; that is no reason to stop.
            None => drop(writeln!(io::stderr(), "{line}")),
        }
    }
}

impl Observer for Progress {
    fn notice(&mut self, event: &Event) -> Result<(), ObserveError> {
        let name = event.stage;
        match &event.what {
            What::Started => {
                self.began = Some(Instant::now());
                if let Some(spinner) = &self.spinner {
                    spinner.set_message(name);
                    spinner.reset_elapsed();
                }
            }
            What::Retry { error, pause } => {
                let pause = pause.as_secs_f64();
                self.say(&format!("{name:<18} again in {pause:.0} s: {}", error.line()));
            }
            What::Finished { .. } if event.identity.is_none() && event.inputs.is_empty() => {}
            What::Finished { recalled, notes, .. } => {
                let took = self.began.take().map_or(0.0, |b| b.elapsed().as_secs_f64());
                let word = if *recalled { "unchanged".into() } else { format!("{took:.1} s") };
                self.say(&format!("{name:<18} {word}"));
                for note in notes {
                    let word = if note.loss { "lost" } else { "note" };
                    self.say(&format!("{:<18} {word}: {}", "", note.message));
                }
            }
            What::Failed(_) => self.say(&format!("{name:<18} failed")),
        }
        Ok(())
    }
}
