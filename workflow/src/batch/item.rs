//! One item of a batch, from its line to its outcome: the same flow, trace and folder as `make`'s.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use adapters::budget::Book;
use adapters::net::calls::Calls;
use adapters::{
    AdapterError, ConditionFile, Config, Critic, ImageTo3d, MeshFile, Photo, Vlm, World,
};
use model::Choice;
use runner::observe::Both;
use runner::{
    self, Blame, Cancel, Ending, Event, InGraphOrder, Limits, ObserveError, Observer, Outcome,
    RunOptions, StageError, StateDir, Workers,
};
use serde_json::json;
use sim_check::{Tier, Verdict};
use trace::{Clock, Digest};

use super::allowance::Allowance;
use super::class::Class;
use super::engine::{Feed as _, Work};
use super::error::BatchError;
use super::feed::{Back, Pending};
use super::folder::{BatchFolder, io_failed};
use super::gate::{ItemGate, Places};
use super::ledger::{Ledger, Planned};
use super::manifest::Item;
use super::progress::Board;
use super::purse::{ItemBook, Purse};
use super::record::{Ended, Record};
use super::{attest, look};
use crate::image_to_urdf::image_to_urdf;
use crate::output::names::{REASON, STATEMENT, TRACE};
use crate::output::{self, Making, sureness};
use crate::pictured;
use crate::recording::{self, Recording, VERSION};
use crate::stages::bundle::Files;
use crate::stages::{Checked, Export, Tools};

/// After so many items in a row that met a passing trouble, the batch stops.
const DOWN: u32 = 25;

/// What every item of a batch is made with.
pub struct Settings {
    /// Formats.
    pub exports: Vec<Export>,
    /// The tier an asset is accepted from.
    pub tier: Tier,
    /// How likely an asset must be right to be accepted, of items that do not say, 0 to 1.
    pub min_confidence: Option<f64>,
    /// Seed of items that name none.
    pub seed: u64,
    /// Who makes meshes, if anybody.
    pub image_to_3d: Option<Arc<dyn ImageTo3d>>,
    /// Who makes conditions, if anybody.
    pub vlm: Option<Arc<dyn Vlm>>,
    /// Who looks at items whose condition was made, if anybody.
    pub critic: Option<Arc<dyn Critic>>,
    /// Who is asked.
    pub config: Config,
    /// What they are reached through.
    pub world: World,
    /// Who is asked, as it may be kept.
    pub asked: Config,
    /// The calls they made.
    pub calls: Arc<dyn Calls>,
}

impl Settings {
    /// Everything in here that shapes an asset, in words.
    pub fn words(&self) -> String {
        let exports: Vec<_> = self.exports.iter().map(|e| e.name()).collect();
        let mesh = self.image_to_3d.as_ref().and_then(|a| a.identity().ok());
        let condition = self.vlm.as_ref().and_then(|a| a.identity().ok());
        let articulator = model::articulator(Choice::default()).identity();
        let mut words = json!({
            "exports": exports, "tier": self.tier.name(), "seed": self.seed,
            "mesh": mesh, "condition": condition, "articulator": articulator,
        });
        // Nobody's settings change by what they do not ask for.
        if let Some(critic) = &self.critic {
            words["critic"] = json!(critic.identity().ok());
        }
        if let Some(least) = self.min_confidence {
            words["min_confidence"] = json!(least);
        }
        words.to_string()
    }

    /// What an item is made with; what it asks for stands in its own book.
    fn tools(&self, item: &Item, scratch: &Path, book: Arc<dyn Book>) -> Result<Tools, StageError> {
        let nobody = |what: &str| StageError::new(format!("nobody to ask for a {what}"));
        let failed = |e: AdapterError| StageError::from_error(&e);
        let world = World { book, ..self.world.clone() };
        let condition = item.condition.as_ref();
        let condition =
            condition.map(|path| ConditionFile { path: path.clone(), ..Default::default() });
        let image_to_3d: Box<dyn ImageTo3d> = match mesh_of(item) {
            Some(file) => Box::new(file),
            None => {
                let made = self.config.image_to_3d(&world).map_err(failed)?;
                made.ok_or_else(|| nobody("mesh"))?
            }
        };
        let vlm: Box<dyn Vlm> = match condition {
            Some(file) => Box::new(file),
            None => {
                let made = self.config.vlm(&world).map_err(failed)?;
                made.ok_or_else(|| nobody("condition"))?
            }
        };
        let critic = match &item.condition {
            Some(_) => None,
            None => self.config.critic(&world).map_err(failed)?,
        };
        let seed = item.seed.unwrap_or(self.seed);
        let (articulate, scratch) = (model::articulator(Choice::default()), scratch.to_path_buf());
        Ok(Tools { image_to_3d, vlm, critic, articulate, seed, scratch })
    }
}

/// The photo of an item; without one, a view of its mesh.
fn photo_of(item: &Item) -> Result<Photo, AdapterError> {
    pictured::photo(item.given_photo(), mesh_of(item))
}

/// The mesh of an item that brings one.
fn mesh_of(item: &Item) -> Option<MeshFile> {
    let condition = item.condition.clone();
    let condition = condition.map(|path| ConditionFile { path, ..Default::default() });
    item.mesh.clone().map(|path| MeshFile::beside(path, condition.as_ref()))
}

/// Whoever is told how items go.
pub trait Onlooker: Sync {
    /// Something happened in an item's run.
    fn stage(&self, id: &str, event: &Event);

    /// An item came to an outcome.
    fn settled(&self, record: &Record);
}

/// Tells an onlooker of one item.
struct Telling<'a> {
    id: &'a str,
    onlooker: &'a dyn Onlooker,
}

impl Observer for Telling<'_> {
    fn notice(&mut self, event: &Event) -> Result<(), ObserveError> {
        self.onlooker.stage(self.id, event);
        Ok(())
    }
}

/// Where items are made: what all of them share.
pub struct Bench<'a> {
    /// Number of this run in the ledger.
    pub run: i64,
    /// What every item is made with.
    pub settings: &'a Settings,
    /// Digest of the settings' words.
    pub digest: Digest,
    /// Bytes by digest, results by key.
    pub state: &'a StateDir,
    /// Outcomes.
    pub ledger: Arc<Ledger>,
    /// Where items come from.
    pub feed: &'a Pending<'a>,
    /// Who does the stages that compute; this process, if nobody else.
    pub workers: Option<Arc<dyn Workers>>,
    /// Where assets go.
    pub folder: &'a BatchFolder,
    /// Places to work in.
    pub places: Arc<Places>,
    /// What calls are paid from.
    pub purse: Arc<Purse>,
    /// What calls cost.
    pub allowance: Allowance,
    /// The wish to stop.
    pub cancel: Cancel,
    /// Tells the time.
    pub clock: Arc<dyn Clock>,
    /// What a person sees.
    pub board: &'a Board,
    /// Who else is told of every stage, if anybody.
    pub onlooker: Option<&'a dyn Onlooker>,
    /// Items in a row that met a passing trouble.
    pub troubles: AtomicU32,
}

impl Work for Bench<'_> {
    fn perform(&self, planned: Planned) -> Result<(), BatchError> {
        let done = self.made(&planned);
        let back = match &done {
            Ok(Some(record)) if record.is_final() => Back::Settled,
            Ok(Some(_)) => Back::Troubled,
            Ok(None) | Err(_) => Back::Unfinished,
        };
        let noted = done.and_then(|record| record.map_or(Ok(()), |r| self.note(&planned, r)));
        self.feed.back(planned.n, back);
        noted
    }
}

impl Bench<'_> {
    /// Takes an item to its outcome; none if it was put down because everything is to stop.
    fn made(&self, planned: &Planned) -> Result<Option<Record>, BatchError> {
        let item = &planned.item;
        let mut record = self.record(planned);
        let asks_nobody = item.mesh.is_some() && item.condition.is_some();
        // Where everything is to stop, the gate of its stages says so.
        let _begun = (asks_nobody && self.settings.critic.is_none())
            .then(|| self.places.begin(planned.n, &self.cancel));
        let photo = match photo_of(item) {
            Ok(photo) => photo,
            Err(error) => {
                fail(&mut record, "photo", &StageError::from_error(&error), Class::Input);
                return self.quarantined(record).map(Some);
            }
        };
        let book = ItemBook::new(&self.settings.world.book, &self.purse, &item.id);
        let tools = match self.settings.tools(item, &self.state.scratch(), Arc::new(book)) {
            Ok(tools) => Arc::new(tools),
            Err(error) => {
                fail(&mut record, "generate-mesh", &error, Class::Input);
                return self.quarantined(record).map(Some);
            }
        };
        let out = self.folder.begin(&item.id)?;
        let outcome = self.run(planned, (&tools, photo), &out)?;
        self.tell_of(&outcome, &mut record)?;
        match &outcome.ending {
            Ending::Interrupted(_) => {
                self.folder.put_down(&item.id)?;
                Ok(None)
            }
            Ending::Failed { stage, error } if error.blame == Blame::House => {
                let (stage, found) = ((*stage).to_owned(), error.line());
                Err(BatchError::House { stage, found })
            }
            Ending::Failed { stage, error } => {
                fail(&mut record, stage, error, class_of(item, stage, error));
                self.failed(record, &out).map(Some)
            }
            Ending::Done => self.finished(item, &tools, (&outcome, &out), record).map(Some),
        }
    }

    fn run(
        &self,
        planned: &Planned,
        (tools, photo): (&Arc<Tools>, Photo),
        out: &Making,
    ) -> Result<Outcome, BatchError> {
        let Settings { exports, asked, calls, .. } = self.settings;
        let Planned { n, item, .. } = planned;
        let asked = asked.clone().without(item.mesh.is_some(), item.condition.is_some());
        let manifest = recording::manifest(tools, exports, Some(&photo), &asked);
        let path = out.trace();
        let recording = Recording::create(&path, &manifest, Arc::clone(&self.clock))?;
        let mut recording = recording.with_calls(Arc::clone(calls));
        let gate = Arc::new(ItemGate::new((*n, item), &self.places, &self.cancel));
        let (cancel, clock) = (self.cancel.clone(), Arc::clone(&self.clock));
        let limits = Limits { cpu: usize::MAX, network: usize::MAX };
        let workers = self.workers.clone();
        let options = RunOptions { limits, cancel, clock, version: VERSION.into(), gate, workers };
        let flow = image_to_urdf(photo, &self.settings.exports, tools.criticise());
        let mut ordered = InGraphOrder::new(&mut recording);
        let ran = match self.onlooker {
            None => runner::run(&flow, tools, self.state, &options, &mut ordered),
            Some(onlooker) => {
                let mut telling = Telling { id: &item.id, onlooker };
                let mut both = Both(&mut telling, &mut ordered);
                runner::run(&flow, tools, self.state, &options, &mut both)
            }
        };
        let released = ordered.release();
        let outcome = ran?;
        released.map_err(runner::RunError::from)?;
        recording.finish()?;
        Ok(outcome)
    }

    /// The record of an item of which nothing is known yet.
    fn record(&self, planned: &Planned) -> Record {
        let Planned { line, item, .. } = planned;
        let mut record = Record::new(&item.id, Ended::Failed);
        record.line = *line;
        record.category.clone_from(&item.category);
        record.license.clone_from(&item.license);
        record.seed = item.seed.unwrap_or(self.settings.seed);
        record
    }

    /// What the stages tell, however they ended.
    fn tell_of(&self, outcome: &Outcome, record: &mut Record) -> Result<(), BatchError> {
        let calls = self.ledger.calls(Some(&record.id))?;
        record.calls = calls.iter().map(|s| s.requests).sum();
        record.cost = self.allowance.cost(&calls);
        for node in &outcome.nodes {
            let Some((digest, _)) = &node.output else { continue };
            record.artefacts.push(digest.clone());
            match node.stage {
                "photo" => drop(record.digests.insert("photo".into(), digest.clone())),
                "generate-mesh" => drop(record.digests.insert("mesh".into(), digest.clone())),
                _ => {}
            }
            if node.recalled {
                record.stages_recalled += u64::from(node.key.is_some());
            } else {
                record.stages_run += 1;
                record.seconds.insert(node.stage.into(), node.took.as_secs_f64());
            }
        }
        record.provider = provider(outcome, "generate-mesh");
        record.condition_provider = provider(outcome, "propose-condition");
        record.articulator = provider(outcome, "articulate");
        Ok(())
    }

    fn finished(
        &self,
        item: &Item,
        tools: &Tools,
        (outcome, out): (&Outcome, &Making),
        mut record: Record,
    ) -> Result<Record, BatchError> {
        let unread = |e: StageError| BatchError::House { stage: item.id.clone(), found: e.line() };
        let mut files = output::files(outcome, &self.settings.exports).map_err(unread)?;
        let checked = outcome.artefact::<_, Checked>("check-in-sim").map_err(unread)?;
        record.confidence = sureness::confidence(&files);
        let least = item.min_confidence.or(self.settings.min_confidence);
        judge(&mut record, outcome, &checked.verdict, (self.settings.tier, least));
        record.look = look::look(&files);
        let statement = self.attest(item, tools, outcome, (&files, out), &mut record)?;
        files.insert(STATEMENT.into(), statement);
        let accepted = record.outcome == Ended::Accepted;
        if !accepted {
            let reason = reason(&record);
            record.digests.insert("reason".into(), Digest::of(&reason));
            files.insert(REASON.into(), reason);
        }
        out.fill(&files)?;
        self.place(&item.id, out, accepted)?;
        Ok(record)
    }

    /// Digests of everything in the folder, and the statement about it.
    fn attest(
        &self,
        item: &Item,
        tools: &Tools,
        outcome: &Outcome,
        (files, out): (&Files, &Making),
        record: &mut Record,
    ) -> Result<Vec<u8>, BatchError> {
        let path = out.trace();
        let trace = std::fs::read(&path).map_err(io_failed("read", &path))?;
        let mut digests: BTreeMap<_, _> =
            files.iter().map(|(name, bytes)| (name.clone(), Digest::of(bytes))).collect();
        digests.insert(TRACE.into(), Digest::of(&trace));
        let statement = attest::statement(item, tools, outcome, files, &digests);
        for (name, file) in [("urdf", "asset.urdf"), ("trace", TRACE)] {
            record.digests.extend(digests.get(file).map(|d| (name.to_owned(), d.clone())));
        }
        record.digests.insert("attestation".into(), Digest::of(&statement));
        let bytes: usize =
            files.values().map(Vec::len).sum::<usize>() + trace.len() + statement.len();
        (record.bytes, record.files) = (Some(bytes as u64), digests);
        Ok(statement)
    }

    /// A failed item: its trace goes into quarantine, unless it will be tried again by itself. An asset
    /// that was accepted before stays where it is.
    fn failed(&self, mut record: Record, out: &Making) -> Result<Record, BatchError> {
        if !record.is_final() {
            self.folder.put_down(&record.id)?;
            return Ok(record);
        }
        let path = out.trace();
        let trace = std::fs::read(&path).map_err(io_failed("read", &path))?;
        record.digests.insert("trace".into(), Digest::of(&trace));
        self.leave_reason(&mut record, out)?;
        Ok(record)
    }

    /// An item that failed before it had a trace.
    fn quarantined(&self, mut record: Record) -> Result<Record, BatchError> {
        let out = self.folder.begin(&record.id)?;
        self.leave_reason(&mut record, &out)?;
        Ok(record)
    }

    fn leave_reason(&self, record: &mut Record, out: &Making) -> Result<(), BatchError> {
        let reason = reason(record);
        record.digests.insert("reason".into(), Digest::of(&reason));
        out.fill(&[(REASON.to_owned(), reason)].into())?;
        self.place(&record.id, out, false)
    }

    /// Puts what was made in its place, and says which signatures went with what stood there.
    fn place(&self, id: &str, out: &Making, accepted: bool) -> Result<(), BatchError> {
        for signature in self.folder.place(id, out, accepted)?.1 {
            self.board
                .say(&format!("{id}: {signature} was of what stood there before, and is gone"));
        }
        Ok(())
    }

    /// Writes the outcome down; stops everything if nothing works any more.
    fn note(&self, planned: &Planned, mut record: Record) -> Result<(), BatchError> {
        record.at_ns = self.clock.now();
        let transient = record.class() == Some(Class::Transient);
        let row = [(planned.question.clone(), record)];
        self.ledger.add(self.run, &self.digest, &row)?;
        let [(_, record)] = row;
        self.board.note(&record, self.places.taken(), self.purse.spent());
        if let Some(onlooker) = self.onlooker {
            onlooker.settled(&record);
        }
        if self.feed.is_growing() {
            // What one owner's items meet is no reason to keep the others waiting.
            return Ok(());
        }
        if record.class() == Some(Class::Budget) {
            self.feed.stop();
        }
        if !transient {
            self.troubles.store(0, Ordering::SeqCst);
            return Ok(());
        }
        let items = self.troubles.fetch_add(1, Ordering::SeqCst) + 1;
        if items < DOWN {
            return Ok(());
        }
        Err(BatchError::Down { items, last: record.reason.unwrap_or_default() })
    }
}

/// Why an item was not accepted, as it stands beside what was made of it.
fn reason(record: &Record) -> Vec<u8> {
    let reason = json!({
        "id": record.id, "line": record.line, "outcome": record.outcome.name(),
        "class": record.class, "stage": record.stage, "reason": record.reason,
    });
    format!("{reason:#}\n").into_bytes()
}

fn fail(record: &mut Record, stage: &str, error: &StageError, class: Class) {
    record.outcome = Ended::Failed;
    record.class = Some(class.name().into());
    record.stage = Some(stage.into());
    record.reason = Some(error.line());
}

fn class_of(item: &Item, stage: &str, error: &StageError) -> Class {
    let given = match stage {
        "generate-mesh" => item.mesh.is_some(),
        "propose-condition" => item.condition.is_some(),
        _ => false,
    };
    Class::of(stage, error, given)
}

/// Whether an asset that was made is what was asked for.
fn judge(
    record: &mut Record,
    outcome: &Outcome,
    verdict: &Verdict,
    (least, min_confidence): (Tier, Option<f64>),
) {
    record.verdict = Some(verdict.tier.name().into());
    record.links = Some(verdict.links as u64);
    record.joints = Some(verdict.moving_joints as u64);
    let failures: Vec<_> = verdict.failures().map(|c| c.id.as_str()).collect();
    record.failed_checks = Some(failures.join(" "));
    let lost = outcome.nodes.iter().flat_map(|n| n.notes.iter().map(move |note| (n.stage, note)));
    let lost = lost.filter(|(_, note)| note.loss).map(|(stage, note)| (stage, &note.message));
    let mut lost = lost.peekable();
    record.outcome = Ended::Rejected;
    if let Some((stage, first)) = lost.peek() {
        (record.class, record.stage) = (Some(Class::Model.name().into()), Some((*stage).into()));
        record.reason = Some((*first).clone());
    } else if verdict.tier < least {
        record.class = Some(Class::Verdict.name().into());
        record.stage = Some("check-in-sim".into());
        let first = verdict.failures().next();
        let first = first.map_or(String::new(), |c| format!(": {} {}", c.id, c.rule));
        let (tier, least) = (verdict.tier.name(), least.name());
        record.reason = Some(format!("tier {tier}, below {least}{first}"));
    } else if let Some(reason) = sureness::too_unsure(record.confidence, min_confidence) {
        record.class = Some(Class::Model.name().into());
        record.stage = Some("articulate".into());
        let doubt = sureness::doubts(verdict).first().map_or(String::new(), |d| format!(": {d}"));
        record.reason = Some(reason + &doubt);
    } else {
        record.outcome = Ended::Accepted;
    }
}

/// Who did a stage's work: the first word of the identity.
fn provider(outcome: &Outcome, stage: &str) -> Option<String> {
    let node = outcome.nodes.iter().find(|n| n.stage == stage)?;
    node.identity.as_deref()?.split(' ').next().map(String::from)
}
