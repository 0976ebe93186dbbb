//! Every question's calls, kept on disk as they happen: a run that was killed and goes on, and a
//! run that finds its result in the store, still know what was said.

use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use trace::Digest;

use super::hidden::HIDDEN;
use super::tape::{self, Bodies, Exchange, Outcome, Tape};
use crate::{AdapterError, Request, Response};

/// Keeps calls by the question they were made for.
///
/// Promise: what a tape kept is there after the end of the program at any later moment; calls come
/// back in the order in which they were kept.
pub trait Calls: Send + Sync {
    /// Where calls for a question are written down.
    fn tape(&self, question: &Digest) -> Arc<dyn Tape>;

    /// All calls that were ever made for a question, with their bodies.
    ///
    /// # Errors
    /// [`AdapterError`] when they cannot be read.
    fn made(&self, question: &Digest) -> Result<(Vec<Exchange>, Bodies), AdapterError>;

    /// The last answer that a request got for a question, if it was a success, nothing is left out
    /// of it, and it was not set aside.
    ///
    /// # Errors
    /// [`AdapterError`] when the record cannot be read or was changed.
    fn answered(
        &self,
        question: &Digest,
        request: &Request,
    ) -> Result<Option<Response>, AdapterError>;

    /// Sets aside the answers so far to the steps that begin so: they stay on record, and are not
    /// taken for answers any more. For answers that are no good.
    ///
    /// # Errors
    /// [`AdapterError`] when that cannot be written down.
    fn set_aside(&self, question: &Digest, steps: &str) -> Result<(), AdapterError>;
}

/// Keeps nothing: for replays, whose calls are on record already.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unkept;

impl Tape for Unkept {
    fn keep(&self, _: Exchange, _: Bodies) -> Result<(), String> {
        Ok(())
    }
}

impl Calls for Unkept {
    fn tape(&self, _: &Digest) -> Arc<dyn Tape> {
        Arc::new(Self)
    }

    fn made(&self, _: &Digest) -> Result<(Vec<Exchange>, Bodies), AdapterError> {
        Ok(Default::default())
    }

    fn answered(&self, _: &Digest, _: &Request) -> Result<Option<Response>, AdapterError> {
        Ok(None)
    }

    fn set_aside(&self, _: &Digest, _: &str) -> Result<(), AdapterError> {
        Ok(())
    }
}

/// Answers of a question that are no good: those before a number, of steps that begin so.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Aside {
    before: usize,
    steps: String,
}

/// Keeps calls in a folder: a folder for each question with a file for each call, and the bodies of
/// all by their digests.
#[derive(Clone, Debug)]
pub struct FolderCalls {
    /// The folder; made when it is first needed.
    pub folder: PathBuf,
}

impl FolderCalls {
    fn body(&self, digest: &Digest) -> PathBuf {
        self.folder.join("bodies").join(digest.as_str())
    }

    fn call(&self, question: &Digest, number: usize) -> PathBuf {
        self.folder.join(question.as_str()).join(format!("{number:06}.json"))
    }

    /// The call of that number; none if there are no more.
    fn read(&self, question: &Digest, number: usize) -> Result<Option<Exchange>, AdapterError> {
        let path = self.call(question, number);
        let bytes = match std::fs::read(&path) {
            Err(e) if e.kind() == ErrorKind::NotFound => return Ok(None),
            read => read.map_err(io(&path))?,
        };
        let exchange: Result<Exchange, _> = serde_json::from_slice(&bytes);
        let exchange = exchange.map_err(|e| damaged(&path, &e.to_string()))?;
        if exchange.key != exchange.own_key() {
            return Err(damaged(&path, "another request than its key says"));
        }
        Ok(Some(exchange))
    }

    /// All calls of a question, without their bodies.
    fn exchanges(&self, question: &Digest) -> Result<Vec<Exchange>, AdapterError> {
        let mut exchanges = vec![];
        while let Some(exchange) = self.read(question, exchanges.len())? {
            exchanges.push(exchange);
        }
        // A call beyond a gap would be passed over in silence.
        let folder = self.folder.join(question.as_str());
        let number = |name: &str| name.strip_suffix(".json")?.parse::<usize>().ok();
        for entry in std::fs::read_dir(&folder).into_iter().flatten() {
            let name = entry.map_err(io(&folder))?.file_name();
            if number(&name.to_string_lossy()).is_some_and(|n| n >= exchanges.len()) {
                let gap = self.call(question, exchanges.len());
                return Err(damaged(&gap, "nothing, though there are later calls"));
            }
        }
        Ok(exchanges)
    }

    fn aside(&self, question: &Digest) -> Result<Vec<Aside>, AdapterError> {
        let path = self.aside_path(question);
        match std::fs::read(&path) {
            Err(e) if e.kind() == ErrorKind::NotFound => Ok(vec![]),
            read => serde_json::from_slice(&read.map_err(io(&path))?)
                .map_err(|e| damaged(&path, &e.to_string())),
        }
    }

    fn aside_path(&self, question: &Digest) -> PathBuf {
        self.folder.join(question.as_str()).join("set-aside.json")
    }

    fn read_body(&self, digest: &Digest) -> Result<Vec<u8>, AdapterError> {
        let path = self.body(digest);
        let bytes = std::fs::read(&path).map_err(io(&path))?;
        if Digest::of(&bytes) == *digest { Ok(bytes) } else { Err(damaged(&path, "other bytes")) }
    }
}

impl Calls for FolderCalls {
    fn tape(&self, question: &Digest) -> Arc<dyn Tape> {
        Arc::new(FolderTape { calls: self.clone(), question: question.clone() })
    }

    fn made(&self, question: &Digest) -> Result<(Vec<Exchange>, Bodies), AdapterError> {
        let (exchanges, mut bodies) = (self.exchanges(question)?, Bodies::new());
        for digest in exchanges.iter().flat_map(Exchange::bodies) {
            if !bodies.contains_key(digest) {
                bodies.insert(digest.clone(), self.read_body(digest)?);
            }
        }
        Ok((exchanges, bodies))
    }

    fn answered(
        &self,
        question: &Digest,
        request: &Request,
    ) -> Result<Option<Response>, AdapterError> {
        let key = tape::key_of(request);
        let exchanges = self.exchanges(question)?;
        let Some(n) = exchanges.iter().rposition(|e| e.key == key) else { return Ok(None) };
        let aside = |a: &Aside| n < a.before && exchanges[n].step.starts_with(&a.steps);
        if self.aside(question)?.iter().any(aside) {
            return Ok(None);
        }
        let Outcome::Answered { status, headers, body } = &exchanges[n].outcome else {
            return Ok(None);
        };
        let (status, headers, body) = (*status, headers.clone(), self.read_body(body)?);
        let response = Response { status, headers, body };
        // What was left out of the answer to a submit may be needed; a look's is on record with it.
        let whole = || {
            let hidden = memchr::memmem::find(&response.body, HIDDEN.as_bytes());
            tape::is_used_as_kept(&request.step) || request.is_look() || hidden.is_none()
        };
        Ok((response.is_success() && whole()).then_some(response))
    }

    fn set_aside(&self, question: &Digest, steps: &str) -> Result<(), AdapterError> {
        let before = self.exchanges(question)?.len();
        if before == 0 {
            return Ok(());
        }
        let mut aside = self.aside(question)?;
        aside.retain(|a| a.steps != steps);
        aside.push(Aside { before, steps: steps.to_owned() });
        let path = self.aside_path(question);
        let folder = path.parent().unwrap_or(Path::new("."));
        let write = || {
            let mut file = tempfile::NamedTempFile::new_in(folder)?;
            serde_json::to_writer(&mut file, &aside)?;
            file.as_file().sync_all()?;
            file.persist(&path).map_err(|e| e.error)?;
            std::fs::File::open(folder)?.sync_all()
        };
        write().map_err(io(&path))
    }
}

/// The tape of one question.
struct FolderTape {
    calls: FolderCalls,
    question: Digest,
}

impl Tape for FolderTape {
    fn keep(&self, exchange: Exchange, bodies: Bodies) -> Result<(), String> {
        for (digest, bytes) in &bodies {
            let path = self.calls.body(digest);
            write_new(&path, bytes).map_err(|e| format!("{}: {e}", path.display()))?;
        }
        let bytes = serde_json::to_vec(&exchange).map_err(|e| e.to_string())?;
        for number in 0.. {
            let path = self.calls.call(&self.question, number);
            if !path.exists() {
                let written = write_new(&path, &bytes);
                if written.map_err(|e| format!("{}: {e}", path.display()))? {
                    break;
                }
            }
        }
        Ok(())
    }
}

/// Writes a whole file under a name that nobody has yet, and waits for the disk; false if somebody
/// had it.
fn write_new(path: &Path, bytes: &[u8]) -> std::io::Result<bool> {
    if path.exists() {
        return Ok(false);
    }
    let folder = path.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder)?;
    let mut file = tempfile::NamedTempFile::new_in(folder)?;
    file.write_all(bytes)?;
    file.as_file().sync_all()?;
    match file.persist_noclobber(path) {
        Err(e) if e.error.kind() == ErrorKind::AlreadyExists => return Ok(false),
        persisted => persisted.map_err(|e| e.error)?,
    };
    std::fs::File::open(folder)?.sync_all()?;
    Ok(true)
}

impl Exchange {
    /// The digests of its bodies.
    pub fn bodies(&self) -> impl Iterator<Item = &Digest> {
        let answered = match &self.outcome {
            Outcome::Answered { body, .. } => Some(body),
            Outcome::Unanswered(_) => None,
        };
        std::iter::once(&self.body).chain(answered)
    }
}

fn io(path: &Path) -> impl Fn(std::io::Error) -> AdapterError {
    move |source| AdapterError::Io { path: path.display().to_string(), source }
}

fn damaged(path: &Path, found: &str) -> AdapterError {
    AdapterError::Format {
        path: path.display().to_string(),
        expected: "a call written down by kinfold",
        found: found.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transport::Method;

    fn exchange(step: &str, words: &[u8]) -> (Exchange, Bodies) {
        let body = Digest::of(words);
        let exchange = Exchange {
            step: step.into(),
            method: Method::Post,
            url: "https://h.example/a".into(),
            headers: vec![],
            key: Digest::of(b""),
            outcome: Outcome::Answered { status: 200, headers: vec![], body: body.clone() },
            body: body.clone(),
        };
        let exchange = Exchange { key: exchange.own_key(), ..exchange };
        (exchange, Bodies::from([(body, words.to_vec())]))
    }

    #[test]
    fn calls_come_back_in_order_whoever_kept_them() {
        let dir = tempfile::tempdir().unwrap();
        let calls = FolderCalls { folder: dir.path().join("calls") };
        let question = Digest::of(b"a photo");
        for step in ["submit", "status", "status"] {
            let (exchange, bodies) = exchange(step, b"same words");
            calls.tape(&question).keep(exchange, bodies).unwrap();
        }
        let (made, bodies) = calls.made(&question).unwrap();
        let steps: Vec<_> = made.iter().map(|e| e.step.as_str()).collect();
        assert_eq!((steps, bodies.len()), (vec!["submit", "status", "status"], 1));
        assert!(calls.made(&Digest::of(b"another")).unwrap().0.is_empty());
    }

    #[test]
    fn damage_is_told_and_not_passed_over() {
        let dir = tempfile::tempdir().unwrap();
        let calls = FolderCalls { folder: dir.path().into() };
        let (exchange, bodies) = exchange("submit", b"words");
        let question = Digest::of(b"a photo");
        calls.tape(&question).keep(exchange, bodies).unwrap();
        std::fs::write(calls.body(&Digest::of(b"words")), b"other").unwrap();
        assert!(calls.made(&question).unwrap_err().to_string().contains("other bytes"));
        std::fs::write(calls.call(&question, 0), b"{").unwrap();
        assert!(calls.made(&question).unwrap_err().to_string().contains("a call written down"));
    }

    /// A question whose request was answered with these words, its calls and the request.
    fn asked(words: &str) -> (tempfile::TempDir, FolderCalls, Digest, Request) {
        let dir = tempfile::tempdir().unwrap();
        let calls = FolderCalls { folder: dir.path().into() };
        let question = Digest::of(b"a photo");
        let request = Request::new("vlm.points/0", Method::Post, "https://h.example/a");
        let answer = Response { status: 200, headers: vec![], body: words.as_bytes().to_vec() };
        let (exchange, bodies) = tape::written_down(&request, &Ok(answer));
        calls.tape(&question).keep(exchange, bodies).unwrap();
        (dir, calls, question, request)
    }

    #[test]
    fn an_answer_is_found_by_its_request_until_it_is_set_aside() {
        let (_dir, calls, question, request) = asked("here");
        let answer = || calls.answered(&question, &request).unwrap().map(|r| r.body);
        assert_eq!(answer(), Some(b"here".to_vec()));
        let other = Request { body: b"else".to_vec(), ..request.clone() };
        assert!(calls.answered(&question, &other).unwrap().is_none());
        assert!(calls.answered(&Digest::of(b"another"), &request).unwrap().is_none());
        calls.set_aside(&question, "vlm.physical/").unwrap();
        assert!(answer().is_some());
        calls.set_aside(&question, "vlm.points/").unwrap();
        assert!(answer().is_none());
        assert_eq!(calls.made(&question).unwrap().0.len(), 1, "it stays on record");
        let again = Response { status: 200, headers: vec![], body: b"there".to_vec() };
        let (exchange, bodies) = tape::written_down(&request, &Ok(again));
        calls.tape(&question).keep(exchange, bodies).unwrap();
        assert_eq!(answer(), Some(b"there".to_vec()));
    }

    #[test]
    fn a_damaged_answer_is_told_and_neither_used_nor_asked_for_again() {
        type Harm = fn(&FolderCalls, &Digest);
        let harms: [Harm; 5] = [
            |c, q| std::fs::write(c.call(q, 0), b"{\"step\": \"vlm").unwrap(),
            |c, _| std::fs::write(c.body(&Digest::of(b"here")), b"there").unwrap(),
            |c, _| std::fs::remove_file(c.body(&Digest::of(b"here"))).unwrap(),
            |c, q| {
                let text = std::fs::read_to_string(c.call(q, 0)).unwrap();
                std::fs::write(c.call(q, 0), text.replace("/a\"", "/b\"")).unwrap();
            },
            |c, q| std::fs::rename(c.call(q, 0), c.call(q, 1)).unwrap(),
        ];
        for (n, harm) in harms.iter().enumerate() {
            let (_dir, calls, question, request) = asked("here");
            harm(&calls, &question);
            assert!(calls.answered(&question, &request).is_err(), "harm {n}");
        }
    }

    #[test]
    fn an_answer_of_which_something_was_left_out_is_none() {
        let (_dir, calls, question, request) = asked("no");
        let request = Request { step: "meshy.submit".into(), ..request };
        let body = br#"{"file": "https://c.example/m.glb?Signature=abc"}"#.to_vec();
        let answer = Response { status: 200, headers: vec![], body };
        let (exchange, bodies) = tape::written_down(&request, &Ok(answer));
        calls.tape(&question).keep(exchange, bodies).unwrap();
        assert!(calls.answered(&question, &request).unwrap().is_none());
    }
}
