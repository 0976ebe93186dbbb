//! Builds, checks and drafts for a studio, with what the command line has.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use guard::folder::{Caps, Folder, Kind};
use object::Condition;
use object::condition::plain;
use runner::observe::What;
use runner::{Artefact as _, Cancel, Event, ObserveError, Observer};
use serde_json::Value;
use studio::{Artefact, Built, Failure, House, Order, Outcome, StageState, Tell};

use super::opened::text_of;
use super::{ask, remedies};
use crate::cli::args::{Cli, Command, MakeArgs, StudioArgs};
use crate::cli::commands::{check, make};
use crate::cli::speech::{Answer, Complaint};
use crate::image_to_urdf::of_any_photo;
use crate::stages::{Export, Page};

/// How often somebody is asked whether a build is to stop.
const ASKED: Duration = Duration::from_millis(50);

/// The house of a studio.
pub(super) struct Bench {
    /// What `make` is asked with.
    pub make: MakeArgs,
    /// What a condition is asked for with; nothing where nobody can be asked.
    pub draft: Option<MakeArgs>,
    /// Whether there is a photo.
    pub has_photo: bool,
    /// Where the last asset stands: the output folder, or a folder of one that is not good enough for it.
    place: Mutex<PathBuf>,
}

impl Bench {
    pub(super) fn new(make: MakeArgs, args: &StudioArgs, out: &Path, has_photo: bool) -> Self {
        let draft = ask::without_condition(&make, args);
        let draft = Some(draft).filter(|draft| has_photo && ask::can_draft(draft));
        Self { make, draft, has_photo, place: Mutex::new(out.to_path_buf()) }
    }

    /// What `make` is asked with for an order.
    fn asked(&self, order: &Order) -> MakeArgs {
        let named = |e: &&Export| order.export.iter().any(|name| name == e.name());
        let export = Export::ALL.iter().filter(named).copied().collect();
        MakeArgs { export, ..self.make.clone() }
    }

    fn place(&self) -> PathBuf {
        self.place.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn folder(&self) -> Result<Option<Folder>, Failure> {
        let place = self.place();
        if !place.join("trace.mcap").is_file() {
            return Ok(None);
        }
        let opened = Folder::open(&place, Caps::default());
        opened.map(Some).map_err(|e| Failure::new(format!("{} {e}", place.display())))
    }

    fn read(&self, name: &str) -> Result<Option<Vec<u8>>, Failure> {
        let Some(folder) = self.folder()? else { return Ok(None) };
        let path = Path::new(name);
        match folder.kind(path) {
            Ok(Some(Kind::File)) => {}
            _ => return Ok(None),
        }
        folder.read(path).map(Some).map_err(|e| Failure::new(format!("{name} {e}")))
    }
}

impl House for Bench {
    fn why_not(&self) -> Option<String> {
        let why =
            "building needs a photo or a mesh: begin with `kinfold studio PHOTO` or `--mesh FILE`";
        (!self.has_photo && self.make.mesh.is_none()).then(|| why.to_owned())
    }

    fn stages(&self, order: &Order) -> usize {
        of_any_photo(&self.asked(order).exports()).stages()
    }

    fn build(
        &self,
        order: &Order,
        tell: Tell<'_>,
        stop: &dyn Fn() -> bool,
    ) -> Result<Outcome, Failure> {
        let mut args = self.asked(order);
        // What is built is what was asked for, whatever is written into the file meanwhile.
        let name = args.condition.as_deref().and_then(Path::file_name).unwrap_or_default();
        let scratch = runner::ours::scratch::folder().map_err(|e| Failure::new(e.to_string()))?;
        let copy = scratch.path().join(name);
        std::fs::write(&copy, &order.condition)
            .map_err(|e| Failure::new(format!("{}: {e}", copy.display())))?;
        args.condition = Some(copy);
        let cancel = Cancel::default();
        let mut telling = Telling { tell };
        let company = make::Company::Program(&mut telling, cancel.clone());
        let answer = until(
            || make::with(&args, company),
            || {
                if stop() {
                    // At once: what is finished is kept, and what runs is done again.
                    cancel.press();
                    cancel.press();
                }
            },
        );
        let Answer { result, remarks, exit } = answer.map_err(|c| failure(&c))?;
        let told: Value = serde_json::from_str(&result).unwrap_or_default();
        let urdf = told["urdf"].as_str().map(PathBuf::from);
        let place =
            urdf.as_deref().and_then(Path::parent).map_or_else(|| self.place(), Path::to_path_buf);
        let out = guard::text::shown(&place.to_string_lossy()).into_owned();
        *self.place.lock().unwrap_or_else(PoisonError::into_inner) = place;
        let tier = told["tier"].as_str().map(str::to_owned);
        Ok(Outcome { exit: exit as u8, tier, remarks, out })
    }

    fn built(&self) -> Result<Option<Built>, Failure> {
        let Some(html) = self.read(Page::FILE_NAME)? else { return Ok(None) };
        let html = String::from_utf8_lossy(&html);
        let Some((scene, geometry)) = page::held(&html) else {
            return Err(Failure::new(format!("{} is no page of this version", Page::FILE_NAME))
                .with_hint("build it again"));
        };
        let scene: Value = serde_json::from_str(scene)
            .map_err(|e| Failure::new(format!("{}: {e}", Page::FILE_NAME)))?;
        let text = self.make.condition.as_ref().and_then(|path| std::fs::read_to_string(path).ok());
        let up = self.make.up.unwrap_or_default();
        let file = text.as_deref().and_then(|text| plain(text).ok());
        let file = file.and_then(|plain| serde_json::from_value(plain.document).ok());
        let condition = text.and_then(|text| Condition::from_json_with(&text, up).ok());
        let both = condition.zip(file);
        let remedies = both.map(|(c, file)| remedies::of(&scene, &c, &file)).unwrap_or_default();
        Ok(Some(Built { scene, geometry: geometry.to_owned(), remedies }))
    }

    fn artefacts(&self) -> Result<Vec<Artefact>, Failure> {
        let Some(folder) = self.folder()? else { return Ok(vec![]) };
        let all = folder.walk(Path::new(".")).map_err(|e| Failure::new(e.to_string()))?;
        let mut files = Vec::new();
        for entry in all.into_iter().filter(|e| e.kind == Kind::File) {
            let Ok(file) = folder.file(&entry.path) else { continue };
            let name = entry.path.to_string_lossy().replace('\\', "/");
            let name = name.strip_prefix("./").unwrap_or(&name).to_owned();
            // Our own marker is nobody's artefact.
            if !name.starts_with('.') {
                files.push(Artefact { name, bytes: file.length() });
            }
        }
        files.sort_by(|a, b| a.name.cmp(&b.name));
        Ok(files)
    }

    fn artefact(&self, name: &str) -> Result<Option<Vec<u8>>, Failure> {
        self.read(name)
    }

    fn check(&self, path: &str) -> Result<Value, Failure> {
        let words = ["kinfold", "check", "--json", "--", path];
        let cli = <Cli as clap::Parser>::try_parse_from(words);
        let Ok(Cli { command: Command::Check(args) }) = cli else {
            return Err(Failure::new("the words for `check` are not understood"));
        };
        if Path::new(path).is_dir() {
            return Err(Failure::new(format!("{path}: expected a file, found a folder")));
        }
        let answer = check::check(&args).map_err(|c| failure(&c))?;
        serde_json::from_str(&answer.result).map_err(|e| Failure::new(format!("{path}: {e}")))
    }

    fn can_draft(&self) -> bool {
        self.draft.is_some()
    }

    fn draft(&self) -> Result<String, Failure> {
        let Some(draft) = &self.draft else {
            return Err(Failure::new("nobody is configured who could be asked for a condition"));
        };
        ask::condition(draft).map(|c| text_of(&c)).map_err(|c| failure(&c))
    }
}

fn failure(complaint: &Complaint) -> Failure {
    let failure = Failure::new(complaint.line());
    match complaint.hints.first() {
        Some(hint) => failure.with_hint(hint.clone()),
        None => failure,
    }
}

/// Does something on another thread, and looks around until it is done.
fn until<T: Send>(work: impl FnOnce() -> T + Send, look: impl Fn()) -> T {
    std::thread::scope(|scope| {
        let working = scope.spawn(work);
        while !working.is_finished() {
            std::thread::sleep(ASKED);
            look();
        }
        working.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })
}

/// Passes on what becomes of stages.
struct Telling<'a> {
    tell: Tell<'a>,
}

impl Observer for Telling<'_> {
    fn notice(&mut self, event: &Event) -> Result<(), ObserveError> {
        let is_input = event.identity.is_none() && event.inputs.is_empty();
        let state = match &event.what {
            What::Started => StageState::Running,
            What::Finished { recalled: true, .. } => StageState::Kept,
            What::Finished { .. } => StageState::Done,
            What::Failed(_) => StageState::Failed,
            What::Retry { .. } => return Ok(()),
        };
        if !is_input {
            (self.tell)(event.stage, state);
        }
        Ok(())
    }
}
