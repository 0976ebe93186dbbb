//! Every question's calls, kept on disk as they happen: a run that was killed and goes on, and a
//! run that finds its result in the store, still know what was said.

use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use trace::Digest;

use super::tape::{Bodies, Exchange, Outcome, Tape};
use crate::AdapterError;

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
        let exchange = serde_json::from_slice(&bytes);
        exchange.map(Some).map_err(|e| damaged(&path, &e.to_string()))
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
        let (mut exchanges, mut bodies) = (vec![], Bodies::new());
        while let Some(exchange) = self.read(question, exchanges.len())? {
            for digest in exchange.bodies() {
                if !bodies.contains_key(digest) {
                    bodies.insert(digest.clone(), self.read_body(digest)?);
                }
            }
            exchanges.push(exchange);
        }
        Ok((exchanges, bodies))
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
            key: Digest::of(step.as_bytes()),
            outcome: Outcome::Answered { status: 200, headers: vec![], body: body.clone() },
            body: body.clone(),
        };
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
}
