//! Adapters whose every call is written down, by the question it was made for.

use std::sync::Arc;

use serde::Serialize;
use trace::Digest;

use crate::budget::{Account, Accounted, COMMAND};
use crate::config::VlmConfig;
use crate::critic::Remark;
use crate::net::discreet::Discreet;
use crate::net::gate::{Gated, Rate};
use crate::net::punctual::Punctual;
use crate::net::redactor::Redactor;
use crate::net::remember::{OnRecord, Remembering};
use crate::net::retry::Retrying;
use crate::net::tape::Recorded;
use crate::{
    AdapterError, Critic, CritiqueQuestion, GeneratedMesh, ImageTo3d, KinematicQuestion, Photo,
    RenderedView, Transport, Vlm, World,
};

/// Most times a request is sent.
const ATTEMPTS: u32 = 4;

/// Asks whom a section of the configuration names, and writes down every call under the question.
pub(crate) struct Written<C> {
    /// The section.
    pub config: C,
    /// What is reached for.
    pub world: World,
    /// How much the service is asked.
    pub rate: Rate,
    /// Who pays.
    pub account: Account,
    /// Takes our keys out of whatever comes back.
    pub redactor: Redactor,
}

/// A section that becomes whoever makes meshes.
pub(crate) trait Builds: Send + Sync {
    /// The adapter, which reaches the world through this one.
    fn adapter(&self, world: &World) -> Result<Box<dyn ImageTo3d>, AdapterError>;

    /// Whether it is a program on this machine, whose runs are booked as a whole.
    fn is_program(&self) -> bool {
        false
    }
}

/// The question a generator is asked: who, about which photo, with which seed.
pub fn mesh_question(identity: &str, photo: &Digest, seed: u64) -> Digest {
    let words = serde_json::json!(["image_to_3d", identity, photo, seed]);
    Digest::of(words.to_string().as_bytes())
}

/// The question a vision-language model is asked: who, about which photo and which views, in whatever
/// order they are given.
pub fn condition_question<'a>(
    identity: &str,
    photo: &Digest,
    views: impl Iterator<Item = (&'a str, Digest)>,
) -> Digest {
    let views: std::collections::BTreeMap<_, _> = views.collect();
    let words = serde_json::json!(["vlm", identity, photo, views]);
    Digest::of(words.to_string().as_bytes())
}

/// The question a critic is asked: who, about which photo and which articulated object. The pictures
/// follow from the object.
pub fn critique_question(identity: &str, photo: &Digest, object: &Digest) -> Digest {
    let words = serde_json::json!(["critic", identity, photo, object]);
    Digest::of(words.to_string().as_bytes())
}

impl<C> Written<C> {
    /// The world with manners: what was answered already is answered from the record; everything
    /// else is repeated where it may be, let through the service's gate, counted against the budget
    /// and written into its book before it is sent, and recorded before its answer is used.
    pub(crate) fn world_for(&self, question: &Digest) -> World {
        let World { transport, calls, gates, pace, clock, .. } = self.world.clone();
        let known = self.redactor.clone();
        let inner = Punctual { inner: Discreet { inner: transport, known }, clock };
        let inner = Recorded { inner, tape: calls.tape(question) };
        let (account, question) = (self.account.clone(), question.clone());
        let record = OnRecord { calls, question: question.clone() };
        let inner = Accounted { inner, account: account.clone(), question };
        let inner = Gated { inner, gates, rate: self.rate, pace: Arc::clone(&pace) };
        let inner = Retrying { inner, pace, attempts: ATTEMPTS };
        let on_record: Arc<dyn Transport> = Arc::new(record.clone());
        let transport: Arc<dyn Transport> = Arc::new(Remembering { inner, record, account });
        World { transport, on_record, ..self.world.clone() }
    }

    /// The same result, its error as it may be told; answers that came and were no good are set
    /// aside, so that whoever asks again on purpose gets other ones.
    fn judged<A>(
        &self,
        question: &Digest,
        result: Result<A, AdapterError>,
    ) -> Result<A, AdapterError> {
        if let Err(error) = &result
            && let Some(steps) = error.spoiled_steps()
        {
            self.world.calls.set_aside(question, &steps)?;
        }
        self.told(result)
    }

    /// What came of a question, its error as it may be told.
    fn told<A>(&self, answer: Result<A, AdapterError>) -> Result<A, AdapterError> {
        answer.map_err(|error| error.without(&self.redactor))
    }

    /// Refuses an answer that says a key of ours only once it is put together: every answer was
    /// searched before it was read.
    fn check_silent(&self, who: &str, answer: &impl Serialize) -> Result<(), AdapterError> {
        let written = serde_json::to_string(answer).unwrap_or_default();
        if !self.redactor.finds(&written) {
            return Ok(());
        }
        Err(AdapterError::Format {
            path: who.to_owned(),
            expected: "an answer that repeats no key",
            found: "one that does".into(),
        })
    }
}

impl<C: Builds> ImageTo3d for Written<C> {
    fn identity(&self) -> Result<String, AdapterError> {
        self.config.adapter(&self.world)?.identity()
    }

    fn generate(&self, photo: &Photo, seed: u64) -> Result<GeneratedMesh, AdapterError> {
        let question = mesh_question(&self.identity()?, &Digest::of(&photo.bytes), seed);
        let adapter = self.config.adapter(&self.world_for(&question))?;
        let made = if self.config.is_program() {
            let made = self.account.booked(&question, COMMAND, || adapter.generate(photo, seed));
            self.told(made)?
        } else {
            self.judged(&question, adapter.generate(photo, seed))?
        };
        made.without(&self.redactor)
    }
}

impl Vlm for Written<VlmConfig> {
    fn identity(&self) -> Result<String, AdapterError> {
        self.config.adapter(&self.world)?.identity()
    }

    fn propose(&self, asked: &KinematicQuestion<'_>) -> Result<object::Condition, AdapterError> {
        let view = |v: &RenderedView| Digest::of(&v.png);
        let views = asked.views.iter().map(|v| (v.name.as_str(), view(v)));
        let photo = Digest::of(&asked.photo.bytes);
        let question = condition_question(&Vlm::identity(self)?, &photo, views);
        let adapter = self.config.adapter(&self.world_for(&question))?;
        let condition = self.judged(&question, adapter.propose(asked))?;
        self.check_silent(&Vlm::identity(self)?, &condition)?;
        Ok(condition)
    }
}

impl Critic for Written<VlmConfig> {
    fn identity(&self) -> Result<String, AdapterError> {
        Critic::identity(&self.config.asking(&self.world)?)
    }

    fn criticise(&self, asked: &CritiqueQuestion<'_>) -> Result<Vec<Remark>, AdapterError> {
        let photo = Digest::of(&asked.photo.bytes);
        let question = critique_question(&Critic::identity(self)?, &photo, asked.digest);
        let asking = self.config.asking(&self.world_for(&question))?;
        let remarks = self.judged(&question, asking.criticise(asked))?;
        self.check_silent(&Critic::identity(self)?, &remarks)?;
        Ok(remarks)
    }
}
