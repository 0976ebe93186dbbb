//! Jobs of a service, as the batch behind it has them.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use guard::folder::{Caps, Folder};
use object::Condition;
use object::mesh::UpAxis;
use runner::Event;
use runner::observe::What;
use serde_json::Value;
use studio::service::Bell;
use studio::{About, Failure, Incoming, Job, JobOrder, MeshOrder, Refused, Submitted, Works};
use trace::Digest;

use super::inputs::{CONDITION, INPUTS, Inputs};
use super::told::{self, Running};
use crate::batch::LedgerError;
use crate::batch::folder::{ASSETS, QUARANTINE};
use crate::batch::item::Onlooker;
use crate::batch::manifest::Item;
use crate::batch::record::{Ended, Record};
use crate::batch::service::Service;

/// Characters of a job's id: half a digest, which nobody finds a second time.
const ID: usize = 32;
/// Most characters of what an order calls its object and its licence.
const MOST_WORDS: usize = 200;
/// Most bytes of a condition, as of a condition's file.
const MOST_CONDITION: usize = 1 << 20;

/// The jobs of a service.
pub(super) struct Desk {
    /// The batch's folder.
    pub root: PathBuf,
    pub service: Service,
    pub inputs: Inputs,
    pub bell: Bell,
    /// What is the same for whoever asks.
    pub about: About,
    /// How many stages a job goes through.
    pub stages: usize,
    /// How many jobs of each may wait, and how many do.
    pub waiting: Mutex<BTreeMap<String, Waiting>>,
    /// What the jobs are at that somebody works on.
    pub running: Mutex<BTreeMap<String, Running>>,
}

/// How many jobs of somebody wait, and how many may.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Waiting {
    pub most: u64,
    pub now: u64,
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// An item's id, and whose it is.
fn item_id(who: &str, id: &str) -> String {
    format!("{who}.{id}")
}

impl Onlooker for Desk {
    fn stage(&self, id: &str, event: &Event) {
        if event.identity.is_none() && event.inputs.is_empty() {
            return;
        }
        {
            let mut running = locked(&self.running);
            let now = running.entry(id.to_owned()).or_default();
            match &event.what {
                What::Started | What::Retry { .. } => now.stage = event.stage.to_owned(),
                What::Finished { .. } | What::Failed(_) => now.done += 1,
            }
        }
        self.ring(id);
    }

    fn settled(&self, record: &Record) {
        locked(&self.running).remove(&record.id);
        if let (true, Some((who, _))) = (record.is_final(), record.id.split_once('.')) {
            let mut waiting = locked(&self.waiting);
            if let Some(of) = waiting.get_mut(who) {
                of.now = of.now.saturating_sub(1);
            }
        }
        self.ring(&record.id);
    }
}

impl Desk {
    fn ring(&self, id: &str) {
        if let Some((who, id)) = id.split_once('.') {
            self.bell.ring(who, id);
        }
    }

    fn told(&self, who: &str, id: &str) -> Result<Option<Job>, LedgerError> {
        let own = item_id(who, id);
        if self.service.item(&own)?.is_none() {
            return Ok(None);
        }
        let record = self.service.outcome(&own)?;
        let running = locked(&self.running).get(&own).cloned();
        let place = self.root.join(INPUTS);
        Ok(Some(told::job((id, self.stages), record.as_ref(), running, &place)))
    }

    /// An order as an item, without its id; its condition was read and holds.
    fn item(&self, who: &str, order: &JobOrder) -> Result<Item, Refused> {
        let wrong = |found: String, hint: &str| Refused::Order(Failure::new(found).with_hint(hint));
        let given = order.mesh.is_some() && order.condition.is_some();
        if order.photo.is_none() && !given {
            let found = "a job needs a photo, or a mesh and a condition".to_owned();
            return Err(wrong(found, "send the photo to /v1/files and name its digest"));
        }
        for (what, missing) in [
            ("mesh", order.mesh.is_none() && !self.about.makes_meshes),
            ("condition", order.condition.is_none() && !self.about.makes_conditions),
        ] {
            if missing {
                let found =
                    format!("nobody makes a {what} here: the service asks no provider for one");
                return Err(wrong(found, &format!("send the {what} with the job")));
            }
        }
        if let Some(least) = order.min_confidence.filter(|p| !(0.0..=1.0).contains(p)) {
            let found = format!("min_confidence is a probability from 0 to 1, found {least}");
            return Err(wrong(found, "leave it out where none is asked for"));
        }
        for (name, words) in [("category", &order.category), ("license", &order.license)] {
            let count = words.as_ref().map_or(0, |words| words.chars().count());
            if count > MOST_WORDS {
                let found = format!("{name} has at most {MOST_WORDS} characters, found {count}");
                return Err(wrong(found, "make it shorter"));
            }
        }
        let file = |digest: &str, what: &str, is_obj: bool| {
            let found = self.inputs.find(who, digest, is_obj).map_err(kept)?;
            found.ok_or_else(|| {
                let found = format!("{what}: this token sent no file of the digest `{digest}`");
                wrong(found, "send it to /v1/files first, and name the digest of the answer")
            })
        };
        let photo = order.photo.as_ref().map(|digest| file(digest, "photo", false)).transpose()?;
        let mesh = order.mesh.as_ref();
        let mesh = mesh.map(|MeshOrder { digest, obj }| file(digest, "mesh", *obj)).transpose()?;
        let condition = order.condition.as_ref().map(|c| self.condition(who, c)).transpose()?;
        Ok(Item {
            id: String::new(),
            photo: photo.unwrap_or_default(),
            mesh,
            condition,
            seed: order.seed,
            category: order.category.clone(),
            license: order.license.clone(),
            min_confidence: order.min_confidence,
        })
    }

    /// The file of a condition that holds.
    fn condition(&self, who: &str, condition: &Value) -> Result<PathBuf, Refused> {
        let text = format!("{condition:#}\n");
        if text.len() > MOST_CONDITION {
            let found =
                format!("a condition has at most {MOST_CONDITION} bytes, found {}", text.len());
            return Err(Refused::Order(Failure::new(found)));
        }
        Condition::from_json_with(&text, UpAxis::default()).map_err(Refused::Condition)?;
        self.inputs.keep(who, text.as_bytes(), CONDITION).map_err(kept)
    }
}

fn kept(error: io::Error) -> Refused {
    Refused::House(Failure::new(format!("what came cannot be kept: {error}")))
}

fn failure(error: LedgerError) -> Failure {
    Failure::new(error.to_string())
}

/// The id of a job: the same for the same question of the same one.
fn id_of(item: &Item) -> Result<String, Refused> {
    let text = serde_json::to_string(item);
    let text = text.map_err(|e| Refused::House(Failure::new(e.to_string())))?;
    Ok(Digest::of(text.as_bytes()).as_str().chars().take(ID).collect())
}

impl Works for Desk {
    fn about(&self, who: &str) -> Result<About, Failure> {
        let Waiting { most, now } = locked(&self.waiting).get(who).copied().unwrap_or_default();
        let mut about = About { token: who.to_owned(), ..self.about.clone() };
        (about.most_waiting, about.waiting) = (most, now);
        (about.budget.calls, about.budget.cost) = self.service.spent_by(who);
        let share = self.service.share_of(who);
        (about.budget.most_calls, about.budget.most_cost) = (share.calls, share.money);
        Ok(about)
    }

    fn receive(&self, who: &str) -> Result<Box<dyn Incoming>, Failure> {
        self.inputs.receive(who)
    }

    fn submit(&self, who: &str, order: JobOrder) -> Result<Submitted, Refused> {
        let item = self.item(who, &order)?;
        let id = id_of(&item)?;
        let item = Item { id: item_id(who, &id), ..item };
        let house = |e: LedgerError| Refused::House(failure(e));
        let is_new = {
            let mut waiting = locked(&self.waiting);
            let of = waiting.entry(who.to_owned()).or_default();
            if of.now >= of.most && self.service.item(&item.id).map_err(house)?.is_none() {
                let found = format!("{} jobs of this token wait already, its most", of.now);
                let failure = Failure::new(found).with_hint("wait until some of them are over");
                return Err(Refused::Full(failure));
            }
            let is_new = self.service.add(&item).map_err(house)?;
            of.now += u64::from(is_new);
            is_new
        };
        let gone = || Refused::House(Failure::new("the job is not in the ledger"));
        let job = self.told(who, &id).map_err(house)?.ok_or_else(gone)?;
        Ok(Submitted { job, is_new })
    }

    fn job(&self, who: &str, id: &str) -> Result<Option<Job>, Failure> {
        self.told(who, id).map_err(failure)
    }

    fn jobs(&self, who: &str, before: Option<&str>, most: usize) -> Result<Vec<Job>, Failure> {
        let before = before.map(|id| item_id(who, id));
        let ids = self.service.items(who, before.as_deref(), most).map_err(failure)?;
        let mut jobs = Vec::new();
        for own in ids {
            let id = own.split_once('.').map_or("", |(_, id)| id);
            jobs.extend(self.told(who, id).map_err(failure)?);
        }
        Ok(jobs)
    }

    fn artefact(&self, who: &str, id: &str, digest: &str) -> Result<Option<Vec<u8>>, Failure> {
        let own = item_id(who, id);
        if self.service.item(&own).map_err(failure)?.is_none() {
            return Ok(None);
        }
        let Some(record) = self.service.outcome(&own).map_err(failure)? else { return Ok(None) };
        let files = told::files(&record);
        let Some((name, _)) = files.iter().find(|(_, of)| *of == digest) else { return Ok(None) };
        let place = if record.outcome == Ended::Accepted { ASSETS } else { QUARANTINE };
        let folder = self.root.join(place).join(&own);
        let read = Folder::open(&folder, Caps::default()).and_then(|f| f.read(Path::new(name)));
        let bytes = read.map_err(|e| Failure::new(format!("{name}: {e}")))?;
        if Digest::of(&bytes).as_str() != digest {
            let found = format!("{name}: its bytes on the service's disk are others by now");
            return Err(
                Failure::new(found).with_hint("`kinfold audit` on the service's folder says more")
            );
        }
        Ok(Some(bytes))
    }
}
