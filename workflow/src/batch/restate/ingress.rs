//! Restate's front door: a stage is asked for until there is an answer, whatever is killed meanwhile.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard};
use std::thread;
use std::time::{Duration, Instant};

use adapters::transport::{Request, Response, Transport, TransportError};
use runner::errand::Input;
use runner::journal::Committed;
use runner::restate::{HANDLER, service};
use runner::{Again, Answer, Blame, Depot, Done, Errand, Found, StageError, Workers};
use trace::Digest;

/// How long one question waits for its answer; then the same question joins the same call.
const WAIT: Duration = Duration::from_secs(60);
/// Longest answer, bytes: digests and notes.
const LONGEST: u64 = 16 << 20;
/// Pause before the same question again; doubles up to [`LONGEST_PAUSE`].
const PAUSE: Duration = Duration::from_millis(100);
const LONGEST_PAUSE: Duration = Duration::from_secs(5);
/// How often a result may turn out lost before the stage is given up.
const ROUNDS: u32 = 3;

/// Asks Restate for stages.
pub struct Ingress {
    /// Its address, such as `http://127.0.0.1:8080`.
    pub address: String,
    /// How requests get there.
    pub transport: Arc<dyn Transport>,
    /// Where inputs and results are.
    pub depot: Arc<dyn Depot>,
    /// How long nobody may answer there before a stage is put off.
    pub patience: Duration,
    /// Keys whose answer is of no use any more, with the number of the next question.
    rounds: Mutex<BTreeMap<Digest, u32>>,
}

impl Ingress {
    /// The front door at an address.
    pub fn new(address: &str, transport: Arc<dyn Transport>, depot: Arc<dyn Depot>) -> Self {
        let (address, patience) = (address.trim_end_matches('/').into(), Duration::from_secs(180));
        Self { address, transport, depot, patience, rounds: Mutex::default() }
    }

    fn rounds(&self) -> MutexGuard<'_, BTreeMap<Digest, u32>> {
        self.rounds.lock().unwrap_or_else(|e| e.into_inner())
    }

    /// The idempotency key: the result's own, with a number once its first answer was of no use.
    fn question(&self, key: &Digest) -> String {
        match self.rounds().get(key) {
            None => key.to_string(),
            Some(round) => format!("{key}.{round}"),
        }
    }

    /// The next question under this key is another one.
    fn forget(&self, key: &Digest) {
        *self.rounds().entry(key.clone()).or_insert(0) += 1;
    }

    /// Asks until there is an answer.
    fn ask(&self, errand: &Errand) -> Result<Answer, StageError> {
        let url = format!("{}/{}/{HANDLER}", self.address, service(&errand.stage));
        let body = serde_json::to_value(errand).map_err(|e| of_the_house(&e))?;
        // A look at what is under way: asked again, it does the work no second time.
        let mut request = Request::post_json("restate.status", url, &body).within(WAIT, LONGEST);
        request.headers.push(("idempotency-key".into(), self.question(&errand.key)));
        let (mut pause, mut silent): (_, Option<Instant>) = (PAUSE, None);
        loop {
            let began = Instant::now();
            let heard = match self.transport.send(&request) {
                Ok(response) => self.heard(errand, &response)?,
                Err(error) if !error.transient => return Err(misplaced(&error)),
                // The stage takes its time: the same question joins it.
                Err(_) if began.elapsed() > WAIT / 2 => Heard::Nothing,
                Err(error) => Heard::Silence(error.to_string()),
            };
            match heard {
                Heard::Answer(answer) => return Ok(answer),
                Heard::Nothing => (silent, pause) = (None, PAUSE),
                Heard::Silence(words) => {
                    let since = silent.get_or_insert_with(Instant::now);
                    if since.elapsed() > self.patience {
                        return Err(StageError::new(words).later(None));
                    }
                }
            }
            thread::sleep(pause);
            pause = (pause * 2).min(LONGEST_PAUSE);
        }
    }

    fn heard(&self, errand: &Errand, response: &Response) -> Result<Heard, StageError> {
        let said = || said(response);
        match response.status {
            200 => serde_json::from_slice(&response.body).map(Heard::Answer).map_err(|e| {
                let words = format!("restate: expected a worker's answer, found {e}");
                StageError::new(words).blamed_on(Blame::House)
            }),
            404 => Err(nobody(errand, &self.address)),
            408 | 425 | 429 | 502..=504 => Ok(Heard::Silence(format!(
                "restate at {}: expected an answer, found status {}: {}",
                self.address,
                response.status,
                said()
            ))),
            status => {
                self.forget(&errand.key);
                let words =
                    format!("restate gave {} up: status {status}: {}", errand.stage, said());
                Err(StageError::new(words).later(None))
            }
        }
    }

    fn bring(&self, inputs: &[Input]) -> Result<(), StageError> {
        let put = |(digest, bytes): &Input| self.depot.put_blob(digest, bytes);
        inputs.iter().try_for_each(put).map_err(|e| of_the_house(&e))
    }
}

enum Heard {
    Answer(Answer),
    /// No answer yet, but somebody is there.
    Nothing,
    /// Nobody is there, or nobody who can answer; the words for it.
    Silence(String),
}

impl Workers for Ingress {
    fn perform(&self, errand: &Errand, inputs: &[Input]) -> Result<Done, StageError> {
        for _ in 0..ROUNDS {
            match self.ask(errand)? {
                Answer::Made { output, notes, seconds } => {
                    let took = Duration::try_from_secs_f64(seconds).unwrap_or_default();
                    let found = self.depot.blob(&output).map_err(|e| of_the_house(&e))?;
                    if let Found::Whole(bytes) = found {
                        let result = Committed { output, notes };
                        return Ok(Done { result, bytes, took });
                    }
                }
                Answer::Missing(_) => self.bring(inputs)?,
                Answer::Strange(key) => return Err(strange(errand, &key)),
                Answer::Failed { message, causes, hint } => {
                    let (again, blame) = (Again::Never, Blame::Work);
                    return Err(StageError { message, causes, hint, again, blame });
                }
            }
            self.forget(&errand.key);
        }
        let words = format!(
            "expected what {} needs and makes in the shared store, found it missing {ROUNDS} times",
            errand.stage
        );
        Err(StageError::new(words).blamed_on(Blame::House))
    }
}

/// What Restate says of a failure.
pub(super) fn said(response: &Response) -> String {
    let value: serde_json::Value = serde_json::from_slice(&response.body).unwrap_or_default();
    let text = value.get("message").and_then(|m| m.as_str()).unwrap_or("no message");
    text.split_whitespace().collect::<Vec<_>>().join(" ").chars().take(400).collect()
}

fn of_the_house(error: &dyn std::error::Error) -> StageError {
    StageError::from_error(error).blamed_on(Blame::House)
}

fn misplaced(error: &TransportError) -> StageError {
    of_the_house(error).hint("--ingress URL names Restate's front door")
}

fn nobody(errand: &Errand, address: &str) -> StageError {
    let name = service(&errand.stage);
    StageError::new(format!(
        "restate at {address}: expected a worker that does {}, found no service {name}",
        errand.stage
    ))
    .hint("start `kinfold worker` and name its address with --workers URL")
    .blamed_on(Blame::House)
}

fn strange(errand: &Errand, found: &Digest) -> StageError {
    StageError::new(format!(
        "{}: expected a worker of this version, found one whose key is {}, not {}",
        errand.stage,
        found.short(),
        errand.key.short()
    ))
    .hint("let all workers be of the batch's own version")
    .blamed_on(Blame::House)
}

#[cfg(test)]
mod tests;
