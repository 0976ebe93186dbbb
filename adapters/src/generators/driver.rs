//! The one driver of all jobs: submit once, come back after a crash, never wait forever.

use std::sync::Arc;
use std::time::Duration;

use object::mesh::UpAxis;
use object::meshfile::{self, Taken};
use trace::Digest;

use super::ledger::{Entry, Ledger};
use super::{Ask, Charges, FileAddress, Generator, JobHandle, JobState, Submitted};
use crate::files::MAX_MESH_BYTES;
use crate::net::address::same_origin;
use crate::net::hidden::HIDDEN;
use crate::net::pace::{Pace, back_off};
use crate::sent::sent;
use crate::transport::{Method, Reach, Request};
use crate::{AdapterError, GeneratedMesh, ImageTo3d, Photo, Transport};

/// How long to look after a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Patience {
    /// First pause between two looks; doubled each time.
    pub first_pause: Duration,
    /// Longest pause.
    pub longest_pause: Duration,
    /// After this the job is left alone; its number is kept.
    pub deadline: Duration,
}

impl Default for Patience {
    /// Pauses of 2 to 30 seconds, a quarter of an hour in all.
    fn default() -> Self {
        let [first_pause, longest_pause, deadline] = [2, 30, 900].map(Duration::from_secs);
        Self { first_pause, longest_pause, deadline }
    }
}

/// Makes meshes through a generator.
pub struct Generated<G> {
    /// Whose protocol is spoken.
    pub generator: G,
    /// What everything passes through.
    pub transport: Arc<dyn Transport>,
    /// Answers what was answered already and refuses everything else.
    pub on_record: Arc<dyn Transport>,
    /// Who waits.
    pub pace: Arc<dyn Pace>,
    /// What is known of jobs.
    pub ledger: Arc<dyn Ledger>,
    /// How long to look after a job.
    pub patience: Patience,
}

impl<G: Generator> ImageTo3d for Generated<G> {
    fn identity(&self) -> Result<String, AdapterError> {
        Ok(self.generator.identity())
    }

    fn generate(&self, photo: &Photo, seed: u64) -> Result<GeneratedMesh, AdapterError> {
        let identity = self.generator.identity();
        let words = serde_json::json!([identity, Digest::of(&photo.bytes), seed]);
        let job = Digest::of(words.to_string().as_bytes());
        let file = self.file(&job, &Ask { photo: &sent(photo)?, seed })?;
        let alone = &mut |_: &str| Err("is not part of the answer".to_owned());
        let taken = meshfile::take_in(file, (false, UpAxis::Y), alone);
        let Taken { mesh, file, media_type } =
            taken.map_err(|e| AdapterError::of_mesh(identity, e))?;
        Ok(GeneratedMesh { mesh, file, media_type: media_type.into() })
    }
}

impl<G: Generator> Generated<G> {
    fn file(&self, job: &Digest, ask: &Ask<'_>) -> Result<Vec<u8>, AdapterError> {
        match self.begun(job, ask)? {
            Submitted::File(file) => {
                self.ledger.forget(job)?;
                Ok(file)
            }
            Submitted::Job(handle) => self.looked_after(job, &handle),
        }
    }

    /// The job as it is known, or a new one.
    fn begun(&self, job: &Digest, ask: &Ask<'_>) -> Result<Submitted, AdapterError> {
        match self.ledger.entry(job)? {
            Some(Entry::Running(handle)) => return Ok(Submitted::Job(handle)),
            Some(Entry::Asked) => {
                // An answer may have come just before the end of the program that asked.
                if let Ok(submitted) = self.generator.submit(&*self.on_record, ask) {
                    return self.known(job, submitted);
                }
                if self.generator.charges() == Charges::Money {
                    return Err(self.perhaps_asked(job));
                }
                self.ledger.forget(job)?;
            }
            None => {}
        }
        if !self.ledger.begin(job)? {
            return Err(self.perhaps_asked(job));
        }
        self.submitted(job, ask)
    }

    fn submitted(&self, job: &Digest, ask: &Ask<'_>) -> Result<Submitted, AdapterError> {
        match self.generator.submit(&*self.transport, ask) {
            Ok(submitted) => self.known(job, submitted),
            Err(error) => {
                if !may_have_started(&error) {
                    self.ledger.forget(job)?;
                }
                Err(error)
            }
        }
    }

    fn known(&self, job: &Digest, submitted: Submitted) -> Result<Submitted, AdapterError> {
        if let Submitted::Job(handle) = &submitted {
            self.ledger.running(job, handle)?;
        }
        Ok(submitted)
    }

    /// The file of a job that was seen done by an earlier run, which ended before it had it. An
    /// address of which a part was left out is no address.
    fn file_of_done(&self, handle: &JobHandle) -> Option<Vec<u8>> {
        match self.generator.poll(&*self.on_record, handle).ok()? {
            JobState::Inline(file) => Some(file),
            JobState::At(address) => {
                let kept = self.fetched(&*self.on_record, &address);
                let is_whole = !address.0.contains(HIDDEN);
                kept.ok().or_else(|| {
                    is_whole.then(|| self.fetched(&*self.transport, &address).ok()).flatten()
                })
            }
            _ => None,
        }
    }

    fn perhaps_asked(&self, job: &Digest) -> AdapterError {
        AdapterError::Job {
            provider: self.generator.identity(),
            job: job.short().into(),
            found: "an earlier run asked for it and ended before the answer came, so it may have been charged".into(),
            hint: "look at the service's own list of jobs; another --seed asks for a new one",
        }
    }

    fn looked_after(&self, job: &Digest, handle: &JobHandle) -> Result<Vec<u8>, AdapterError> {
        let (start, mut handle) = (self.pace.elapsed(), handle.clone());
        if let Some(file) = self.file_of_done(&handle) {
            return Ok(file);
        }
        for look in 0.. {
            match self.state(&handle)? {
                JobState::Running => {}
                JobState::Next(next) => {
                    self.ledger.running(job, &next)?;
                    handle = next;
                    continue;
                }
                JobState::Inline(file) => return Ok(file),
                JobState::At(address) => return self.fetched(&*self.transport, &address),
                JobState::Failed(words) => {
                    self.ledger.forget(job)?;
                    let hint = "the same command asks for a new job";
                    let found = format!("the service gave it up: {words}");
                    return Err(self.ended(&handle, found, hint));
                }
                JobState::Gone => {
                    self.ledger.forget(job)?;
                    let hint = "the same command asks for a new job";
                    return Err(self.ended(&handle, "the service no longer knows it".into(), hint));
                }
            }
            let Patience { first_pause, longest_pause, deadline } = self.patience;
            let pause = back_off(first_pause, longest_pause, look, &handle.id);
            if self.pace.elapsed().saturating_sub(start) + pause > deadline {
                break;
            }
            self.pace.wait(pause);
        }
        let found = format!("still not done after {:?}", self.patience.deadline);
        let hint = "its number is kept: the same command goes on looking after it";
        Err(self.ended(&handle, found, hint))
    }

    /// How the job is doing. One look that got no answer is no reason to leave a paid job: it counts
    /// as "still running", and the deadline ends it.
    fn state(&self, handle: &JobHandle) -> Result<JobState, AdapterError> {
        match self.generator.poll(&*self.transport, handle) {
            Err(error) if error.is_transient() => Ok(JobState::Running),
            state => state,
        }
    }

    fn ended(&self, handle: &JobHandle, found: String, hint: &'static str) -> AdapterError {
        let provider = self.generator.identity();
        AdapterError::Job { provider, job: handle.id.clone(), found, hint }
    }

    fn fetched(
        &self,
        transport: &dyn Transport,
        address: &FileAddress,
    ) -> Result<Vec<u8>, AdapterError> {
        let provider = self.generator.identity();
        let mut request = Request::new("download", Method::Get, &address.0);
        request = request.within(Duration::from_secs(120), MAX_MESH_BYTES);
        let own = self.generator.own_server().is_some_and(|base| same_origin(base, &address.0));
        request.limits.reach = if own { Reach::Configured } else { Reach::Public };
        let response = transport.send(&request)?;
        let asked = super::answer::Asked { provider: &provider, step: "download" };
        if !response.is_success() {
            return Err(asked.refused(&response));
        }
        glb_bytes(asked, response)
    }
}

/// The body of an answer that is a GLB by its first bytes, whatever it calls itself.
pub(super) fn glb_bytes(
    asked: super::answer::Asked<'_>,
    response: crate::Response,
) -> Result<Vec<u8>, AdapterError> {
    if response.body.starts_with(b"glTF") {
        return Ok(response.body);
    }
    Err(asked.broke("the answer must be a GLB file", super::answer::words(&response)))
}

/// Whether a failed submit may have started (and charged) something all the same: unless it was
/// never sent, never arrived, or the service said no to it.
fn may_have_started(error: &AdapterError) -> bool {
    match error {
        AdapterError::Transport(e) => e.may_have_arrived,
        AdapterError::Service { status, .. } => !matches!(status, Some(400..500)),
        AdapterError::Photo { .. } => false,
        _ => true,
    }
}

#[cfg(test)]
#[path = "driver_tests.rs"]
mod tests;
