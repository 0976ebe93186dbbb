//! The flow's trace: what each stage was given and made, with the pictures and motion to look at.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;

use adapters::net::calls::{Calls, Unkept};
use adapters::net::tape::Exchange;
use adapters::recorded::{condition_question, critique_question, mesh_question};
use adapters::{Config, Photo};
use runner::Artefact as _;
use runner::observe::{Artefact, Event, ObserveError, Observer, What};
use serde_json::json;
use trace::{
    ArtefactRef, Clock, Digest, Happening, Manifest, Recorder, SceneLink, Severity, StageEvent,
    Time, TraceError, Transform,
};

use crate::stages::bundle::{self, Files};
use crate::stages::{Checked, Export, Frame, Pictures, Tools};

/// Version of the program.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Largest artefact that is kept whole in a trace, bytes; larger ones stand there by digest.
const ATTACHED: usize = 1 << 20;
/// Pause between two frames of the motion, nanoseconds.
const FRAME: Time = 1_000_000_000 / 24;

/// What a trace says its run was asked to do; `asked` is who is asked, as it may be kept.
pub fn manifest(
    tools: &Tools,
    exports: &[Export],
    photo: Option<&Photo>,
    asked: &Config,
) -> Manifest {
    // An adapter that cannot say who it is fails its stage; here it is only not listed.
    let identities = [
        ("image_to_3d", tools.image_to_3d.identity().ok()),
        ("vlm", tools.vlm.identity().ok()),
        ("articulate", Some(tools.articulate.identity())),
        ("critic", tools.critic.as_ref().and_then(|c| c.identity().ok())),
    ];
    let mut parameters: BTreeMap<_, _> = identities
        .into_iter()
        .filter_map(|(name, identity)| Some((name.to_string(), json!(identity?))))
        .collect();
    let exports: Vec<_> = exports.iter().map(|e| e.name()).collect();
    parameters.insert("export".into(), json!(exports));
    parameters.insert("providers".into(), json!(asked));
    let inputs: BTreeMap<_, _> =
        photo.map(|p| ("photo".to_string(), Digest::of(&p.bytes))).into_iter().collect();
    let (flow, version, seed) = ("image-to-urdf".to_string(), VERSION.to_string(), tools.seed);
    let question = json!([flow, version, seed, inputs, parameters]).to_string();
    let run_id = Digest::of(question.as_bytes()).to_string();
    Manifest { run_id, flow, version, seed, inputs, parameters }
}

/// Writes a run's trace as events come in, in the order of the graph.
///
/// What it writes depends on the clock and on what the stages made, not on whether they ran or
/// were recalled: a run that was killed and resumed leaves the trace of one that was not.
///
/// Calls to the world outside stand before the event of the stage they were made for.
pub struct Recording {
    recorder: Recorder,
    clock: Arc<dyn Clock>,
    last: Time,
    calls: Arc<dyn Calls>,
    seed: u64,
    photo: Option<Digest>,
    views: Vec<(String, Digest)>,
    bodies: BTreeSet<Digest>,
}

impl Recording {
    /// Creates the file, manifest first.
    ///
    /// # Errors
    /// [`TraceError`] when the disk refuses.
    pub fn create(
        path: &Path,
        manifest: &Manifest,
        clock: Arc<dyn Clock>,
    ) -> Result<Self, TraceError> {
        let last = clock.now();
        let recorder = Recorder::create(path, manifest, last)?;
        let (calls, seed) = (Arc::new(Unkept), manifest.seed);
        let (photo, views, bodies) = (None, Vec::new(), BTreeSet::new());
        Ok(Self { recorder, clock, last, calls, seed, photo, views, bodies })
    }

    /// The same with the calls that are kept there.
    #[must_use]
    pub fn with_calls(self, calls: Arc<dyn Calls>) -> Self {
        Self { calls, ..self }
    }

    /// Writes the summary and closes the file.
    ///
    /// # Errors
    /// [`TraceError`] when the disk refuses.
    pub fn finish(self) -> Result<(), TraceError> {
        self.recorder.finish()
    }

    /// Records that the run broke off before or beside its stages.
    ///
    /// # Errors
    /// [`TraceError`] when the disk refuses.
    pub fn broke_off(&mut self, stage: &str, why: &str) -> Result<(), TraceError> {
        let at = self.tick();
        self.recorder.log(Severity::Error, &format!("{stage}: {why}"), at)?;
        let event = StageEvent {
            stage: stage.into(),
            event: Happening::Failed,
            key: String::new(),
            identity: None,
            inputs: Vec::new(),
            outputs: Vec::new(),
            calls: Vec::new(),
            notes: vec![why.into()],
            previous: None,
        };
        let at = self.tick();
        self.recorder.stage(&event, at)?;
        self.recorder.sync()
    }

    /// The next moment: the clock's, but always later than the one before, so that a clock that
    /// stands still gives its time plus the ordinal of the event.
    fn tick(&mut self) -> Time {
        self.last = self.clock.now().max(self.last.saturating_add(1));
        self.last
    }

    fn record(&mut self, event: &Event) -> Result<(), ObserveError> {
        match &event.what {
            What::Started => Ok(self.event(event, Happening::Started, Told::default())?),
            What::Retry { .. } => Ok(()),
            What::Failed(error) => {
                let line = error.line();
                let at = self.tick();
                self.recorder.log(Severity::Error, &format!("{}: {line}", event.stage), at)?;
                let told = Told { calls: self.called(event)?, notes: vec![line], outputs: vec![] };
                Ok(self.event(event, Happening::Failed, told)?)
            }
            What::Finished { output, bytes, notes, .. } => {
                for note in notes {
                    let severity = if note.loss { Severity::Warning } else { Severity::Info };
                    let at = self.tick();
                    self.recorder.log(severity, &note.message, at)?;
                }
                let calls = self.called(event)?;
                self.show(output, bytes)?;
                let notes = notes.iter().map(|n| n.message.clone()).collect();
                let told = Told { outputs: outputs(output, bytes), notes, calls };
                Ok(self.event(event, Happening::Finished, told)?)
            }
        }
    }

    /// Writes down the calls that were made for a stage, in this run or an earlier one.
    fn called(&mut self, event: &Event) -> Result<Vec<Digest>, ObserveError> {
        let Some(question) = self.question(event) else { return Ok(Vec::new()) };
        let made = self.calls.made(&question);
        let (exchanges, bodies) = made.map_err(|e| ObserveError(e.to_string()))?;
        let schema = schemars::schema_for!(Exchange).to_value();
        let mut named = Vec::new();
        for exchange in &exchanges {
            let at = self.tick();
            named.push(self.recorder.call(exchange, &schema, at)?);
        }
        for (digest, bytes) in bodies {
            if self.bodies.insert(digest.clone()) {
                let at = self.tick();
                let name = format!("{}{digest}", trace::verify::CALL_BODY);
                self.recorder.attach(&name, "application/octet-stream", &bytes, at)?;
            }
        }
        Ok(named)
    }

    /// The question a stage puts to the world outside, where it does.
    fn question(&self, event: &Event) -> Option<Digest> {
        let (identity, photo) = event.identity.as_deref().zip(self.photo.as_ref())?;
        match event.stage {
            "generate-mesh" => Some(mesh_question(identity, photo, self.seed)),
            "propose-condition" => {
                let views = self.views.iter().map(|(name, digest)| (name.as_str(), digest.clone()));
                Some(condition_question(identity, photo, views))
            }
            "criticise" => {
                let object = event.inputs.iter().find(|i| i.kind.name == "object")?;
                Some(critique_question(identity, photo, &object.digest))
            }
            _ => None,
        }
    }

    fn event(&mut self, event: &Event, happening: Happening, told: Told) -> Result<(), TraceError> {
        let Told { outputs, notes, calls } = told;
        let event = StageEvent {
            stage: event.stage.into(),
            event: happening,
            key: event.key.as_ref().map(Digest::to_string).unwrap_or_default(),
            identity: event.identity.clone(),
            inputs: event.inputs.iter().map(reference).collect(),
            outputs,
            calls,
            notes,
            previous: None,
        };
        let at = self.tick();
        self.recorder.stage(&event, at)?;
        self.recorder.sync()
    }

    /// Puts into the trace what a person or a viewer wants to see of an artefact.
    fn show(&mut self, output: &Artefact, bytes: &[u8]) -> Result<(), TraceError> {
        match output.kind.name {
            "photo" => {
                self.photo = Some(output.digest.clone());
                self.picture("/input/photo", bytes)
            }
            "views" => self.views(bytes),
            // What a replay begins with is there whatever its size.
            "mesh" | "condition" => {
                self.attach_whole(output.kind.file_name, output.kind.media_type, bytes)
            }
            // Nobody looks at them, and the asset has what became of them: they stand there by digest.
            "shapes" | "appearance" => Ok(()),
            "urdf" => self.attach_texts(&unpacked(bytes)),
            "verdict" => self.checked(bytes),
            "pictures" => self.pictures(bytes),
            _ => self.attach(output.kind.file_name, output.kind.media_type, bytes),
        }
    }

    fn attach(&mut self, name: &str, media_type: &str, bytes: &[u8]) -> Result<(), TraceError> {
        if bytes.len() > ATTACHED {
            return Ok(());
        }
        self.attach_whole(name, media_type, bytes)
    }

    fn attach_whole(
        &mut self,
        name: &str,
        media_type: &str,
        bytes: &[u8],
    ) -> Result<(), TraceError> {
        let at = self.tick();
        self.recorder.attach(name, media_type, bytes, at)
    }

    fn picture(&mut self, topic: &str, bytes: &[u8]) -> Result<(), TraceError> {
        let at = self.tick();
        self.recorder.image(topic, picture_format(bytes), bytes, at)
    }

    fn views(&mut self, bytes: &[u8]) -> Result<(), TraceError> {
        for (name, png) in unpacked(bytes) {
            let name = name.trim_end_matches(".png");
            self.picture(&format!("/views/{name}"), &png)?;
            self.views.push((name.to_owned(), Digest::of(&png)));
        }
        Ok(())
    }

    /// The parts are a picture like the views; the motion, which viewers do not play, is a file.
    fn pictures(&mut self, bytes: &[u8]) -> Result<(), TraceError> {
        for (name, bytes) in unpacked(bytes) {
            match name.as_str() {
                Pictures::PARTS => self.picture("/asset/parts", &bytes)?,
                name => self.attach(name, "image/webp", &bytes)?,
            }
        }
        Ok(())
    }

    fn attach_texts(&mut self, files: &Files) -> Result<(), TraceError> {
        for (name, bytes) in files {
            match name.rsplit_once('.').map(|(_, extension)| extension) {
                Some("urdf") => self.attach(name, "application/xml", bytes)?,
                Some("json") => self.attach(name, "application/json", bytes)?,
                _ => {}
            }
        }
        Ok(())
    }

    fn checked(&mut self, bytes: &[u8]) -> Result<(), TraceError> {
        let Ok(checked) = Checked::decode(bytes) else { return Ok(()) };
        let json = checked.verdict.to_json();
        self.attach("verdict.json", "application/json", json.as_bytes())?;
        let at = self.tick();
        self.recorder.verdict(&serde_json::to_value(&checked.verdict).unwrap_or_default(), at)?;
        let model = |(name, glb): (&String, &Vec<u8>)| SceneLink {
            frame: name.trim_end_matches(".glb").into(),
            glb: glb.clone(),
        };
        let links: Vec<_> = checked.scene.iter().map(model).collect();
        if !links.is_empty() {
            let at = self.tick();
            self.recorder.scene(&links, at)?;
        }
        checked.motion.iter().try_for_each(|frame| self.frame(frame))
    }

    fn frame(&mut self, frame: &Frame) -> Result<(), TraceError> {
        // The motion is a film: its frames lie apart whatever the clock says.
        self.last = self.last.saturating_add(FRAME);
        let at = self.last;
        let place = |p: &crate::stages::LinkPose| Transform {
            parent: p.parent.clone(),
            child: p.link.clone(),
            translation: p.translation,
            rotation: p.rotation,
        };
        let places: Vec<_> = frame.links.iter().map(place).collect();
        self.recorder.transforms(&places, at)?;
        self.recorder.joints(&frame.joints, at)
    }
}

impl Observer for Recording {
    fn notice(&mut self, event: &Event) -> Result<(), ObserveError> {
        self.record(event)
    }
}

/// What an event tells besides what happened.
#[derive(Default)]
struct Told {
    outputs: Vec<ArtefactRef>,
    notes: Vec<String>,
    calls: Vec<Digest>,
}

fn reference(artefact: &Artefact) -> ArtefactRef {
    let (digest, bytes) = (artefact.digest.clone(), artefact.bytes);
    ArtefactRef { name: artefact.kind.file_name.into(), digest, bytes }
}

/// The artefact and, if it is several files, each of them.
fn outputs(artefact: &Artefact, bytes: &[u8]) -> Vec<ArtefactRef> {
    let mut all = vec![reference(artefact)];
    if artefact.kind.media_type == crate::stages::artefacts::BUNDLE {
        let one = |(name, bytes): (String, Vec<u8>)| ArtefactRef {
            name,
            digest: Digest::of(&bytes),
            bytes: bytes.len() as u64,
        };
        all.extend(unpacked(bytes).into_iter().map(one));
    }
    all
}

/// The files of a bundle this program wrote a moment ago.
fn unpacked(bytes: &[u8]) -> Files {
    bundle::unpack(bytes).unwrap_or_default()
}

fn picture_format(bytes: &[u8]) -> &'static str {
    match bytes {
        [0xff, 0xd8, ..] => "jpeg",
        [b'R', b'I', b'F', b'F', ..] => "webp",
        _ => "png",
    }
}
