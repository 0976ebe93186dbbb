//! The account book: every request that may cost, written down before it is sent, and what is known
//! of it afterwards. The book is only added to, and each line names the digest of the one before.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{Read as _, Seek as _, SeekFrom, Write as _};
use std::path::PathBuf;
use std::sync::{Condvar, Mutex, MutexGuard};

use serde::{Deserialize, Serialize};
use trace::Digest;

use crate::AdapterError;
use crate::usage::Usage;

/// What a program's work is called in the account book.
pub const COMMAND: &str = "command.run";
/// Largest account book, bytes: some millions of requests.
const MAX_BOOK: u64 = 1 << 30;
/// Largest file of the end of the chain, bytes: it holds a number and a digest.
const MAX_HEAD: u64 = 4096;
/// What stands at the end of a line before its digest.
const SEAL: &str = ",\"digest\":\"";
/// Letters of a digest.
const DIGEST_LETTERS: usize = 64;

/// What is known of a request that may cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Fate {
    /// It is about to be sent, or was when the program ended: it may have been charged.
    Asked,
    /// A whole answer came.
    #[default]
    Answered,
    /// No answer came, or one that does not say whether the work was done: it may have been charged.
    Lost,
    /// The service said no, so that nothing was done.
    Refused,
    /// It never left, or never arrived.
    Unsent,
}

/// One request in the account book, or a later word on what one used.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    /// The question it was for.
    pub question: Digest,
    /// What was asked.
    pub step: String,
    /// Whether it was a request for work, or only told what an earlier one used.
    pub work: bool,
    /// What is known of it.
    #[serde(default)]
    pub fate: Fate,
    /// What the service reports.
    pub usage: Usage,
    /// What that costs by the user's prices; none without prices or reports.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub money: Option<f64>,
}

/// What may be done with a request, by what stands in the book.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Leave {
    /// It may be sent.
    Go,
    /// Not before a request of this program that is under way has come back.
    Wait,
    /// It may not, and why.
    No(String),
}

/// Says whether a request may be sent: of all entries and the numbers of those under way.
pub type Judge<'a> = &'a dyn Fn(&[Entry], &BTreeSet<u64>) -> Leave;

/// Why a request does not stand in the book.
#[derive(Debug)]
pub enum Unbooked {
    /// It may not be sent.
    Refused(String),
    /// The book cannot be read or written, or was changed.
    Book(AdapterError),
}

impl From<AdapterError> for Unbooked {
    fn from(error: AdapterError) -> Self {
        Self::Book(error)
    }
}

/// Where it is written down what was spent.
///
/// Promise: what was written survives the end of the program at any later moment; between the look
/// at what was spent and the line that spends more nobody else writes.
pub trait Book: Send + Sync {
    /// Every request and every later word so far, with what is known of each.
    ///
    /// # Errors
    /// [`AdapterError`] when the book cannot be read, or was changed.
    fn entries(&self) -> Result<Vec<Entry>, AdapterError>;

    /// Writes down a request before it is sent, if it may be; its number.
    ///
    /// # Errors
    /// [`Unbooked`] when it may not be sent.
    fn ask(&self, entry: &Entry, judge: Judge<'_>) -> Result<u64, Unbooked>;

    /// Writes down what became of a request.
    ///
    /// # Errors
    /// [`AdapterError`] when it cannot be written.
    fn settle(&self, number: u64, entry: &Entry) -> Result<(), AdapterError>;

    /// Writes down what a finished job used; what was told already is told once.
    ///
    /// # Errors
    /// [`AdapterError`] when it cannot be written.
    fn tell(&self, entry: &Entry) -> Result<(), AdapterError>;
}

/// The entries of a book and the requests of this program that are under way.
#[derive(Debug, Default)]
struct Open {
    entries: Vec<Entry>,
    under_way: BTreeSet<u64>,
}

impl Open {
    fn takes(&mut self, line: &Line) -> Result<(), String> {
        let Some(number) = line.settles else {
            self.entries.push(line.entry.clone());
            return Ok(());
        };
        let place = usize::try_from(number).ok().and_then(|n| self.entries.get_mut(n));
        let place = place.filter(|e| e.question == line.entry.question && e.work);
        let Some(place) = place else { return Err("a line settles what was never asked".into()) };
        *place = line.entry.clone();
        Ok(())
    }
}

/// A book in memory: for replays, which spend nothing, and tests.
#[derive(Debug, Default)]
pub struct MemoryBook(Mutex<Open>, Condvar);

impl MemoryBook {
    fn open(&self) -> MutexGuard<'_, Open> {
        self.0.lock().unwrap_or_else(|e| e.into_inner())
    }
}

impl Book for MemoryBook {
    fn entries(&self) -> Result<Vec<Entry>, AdapterError> {
        Ok(self.open().entries.clone())
    }

    fn ask(&self, entry: &Entry, judge: Judge<'_>) -> Result<u64, Unbooked> {
        let mut open = self.open();
        loop {
            match judge(&open.entries, &open.under_way) {
                Leave::Go => break,
                Leave::No(why) => return Err(Unbooked::Refused(why)),
                Leave::Wait => open = self.1.wait(open).unwrap_or_else(|e| e.into_inner()),
            }
        }
        let number = open.entries.len() as u64;
        open.entries.push(entry.clone());
        open.under_way.insert(number);
        Ok(number)
    }

    fn settle(&self, number: u64, entry: &Entry) -> Result<(), AdapterError> {
        let mut open = self.open();
        open.under_way.remove(&number);
        let line = Line { settles: Some(number), entry: entry.clone(), previous: None };
        // It was asked in this very book.
        let _ = open.takes(&line);
        self.1.notify_all();
        Ok(())
    }

    fn tell(&self, entry: &Entry) -> Result<(), AdapterError> {
        let mut open = self.open();
        if !open.entries.contains(entry) {
            open.entries.push(entry.clone());
        }
        Ok(())
    }
}

/// A line of the file. Lines of 0.1.0 have neither a predecessor nor a digest.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Line {
    /// The number of the entry it says more of; a line that settles none is an entry of its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    settles: Option<u64>,
    #[serde(flatten)]
    entry: Entry,
    /// Digest of the line before; of the first, of everything that kinfold 0.1.0 wrote.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    previous: Option<Digest>,
}

/// The end of the chain, kept beside the book, so that lines missing at its end are found.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Head {
    lines: u64,
    digest: Digest,
}

/// A book in a file, a line of JSON each, with the end of its chain beside it.
#[derive(Debug)]
pub struct FileBook {
    path: PathBuf,
    known: Mutex<Known>,
    settled: Condvar,
}

/// What was read of the file so far.
#[derive(Debug, Default)]
struct Known {
    open: Open,
    /// Bytes up to the end of the last whole line.
    length: u64,
    /// Lines of 0.1.0, which no digest vouches for.
    unchained: u64,
    /// Lines that are chained.
    chained: u64,
    last: Option<Digest>,
    /// Whether the end of the chain was found where it should be.
    end_seen: bool,
}

impl FileBook {
    /// The book in a file, which is made when it is first needed.
    pub fn new(path: PathBuf) -> Self {
        Self { path, known: Mutex::default(), settled: Condvar::new() }
    }

    /// How many lines were written by kinfold 0.1.0, which chained none: nothing vouches for them.
    ///
    /// # Errors
    /// [`AdapterError`] when the book cannot be read, or was changed.
    pub fn unchained(&self) -> Result<u64, AdapterError> {
        let mut known = self.known();
        self.read(&mut known)?;
        Ok(known.unchained)
    }

    fn known(&self) -> MutexGuard<'_, Known> {
        self.known.lock().unwrap_or_else(|e| e.into_inner())
    }

    fn io(&self, source: std::io::Error) -> AdapterError {
        AdapterError::Io { path: self.path.display().to_string(), source }
    }

    fn changed(&self, found: String) -> AdapterError {
        let expected = "an account book as kinfold wrote it";
        AdapterError::Format { path: self.path.display().to_string(), expected, found }
    }

    fn head_path(&self) -> PathBuf {
        self.path.with_extension("head")
    }

    /// Opens the book alone: nobody else reads or writes until the file is let go.
    fn locked(&self) -> Result<File, AdapterError> {
        if let Some(folder) = self.path.parent() {
            std::fs::create_dir_all(folder).map_err(|e| self.io(e))?;
        }
        let file = File::options().create(true).read(true).append(true).open(&self.path);
        let file = file.map_err(|e| self.io(e))?;
        file.lock().map_err(|e| self.io(e))?;
        Ok(file)
    }

    /// Reads what was added since the last look; makes nothing.
    fn read(&self, known: &mut Known) -> Result<(), AdapterError> {
        let file = match std::fs::symlink_metadata(&self.path) {
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => None,
            Ok(found) if !found.is_file() => return Err(self.changed("no regular file".into())),
            _ => Some(File::open(&self.path).map_err(|e| self.io(e))?),
        };
        if let Some(file) = &file {
            file.lock_shared().map_err(|e| self.io(e))?;
        }
        self.catch_up(known, file.as_ref())
    }

    fn catch_up(&self, known: &mut Known, file: Option<&File>) -> Result<(), AdapterError> {
        let length = match file {
            Some(file) => file.metadata().map_err(|e| self.io(e))?.len(),
            None => 0,
        };
        // What was cut, or was not chained yet, is read from its beginning.
        if length < known.length || (known.last.is_none() && known.length > 0) {
            let under_way = std::mem::take(&mut known.open.under_way);
            *known = Known { open: Open { under_way, ..Open::default() }, ..Known::default() };
        }
        if let Some(mut file) = file {
            let mut bytes = Vec::new();
            file.seek(SeekFrom::Start(known.length)).map_err(|e| self.io(e))?;
            file.take(MAX_BOOK).read_to_end(&mut bytes).map_err(|e| self.io(e))?;
            if known.length + bytes.len() as u64 >= MAX_BOOK {
                return Err(self.changed(format!("more than {MAX_BOOK} bytes")));
            }
            self.take_in(known, &bytes)?;
        }
        self.look_for_the_end(known)
    }

    /// Takes in whole lines; one that was cut by a crash was never acted upon.
    fn take_in(&self, known: &mut Known, bytes: &[u8]) -> Result<(), AdapterError> {
        let (head, mut at) = (self.head()?, 0);
        while let Some(end) = bytes[at..].iter().position(|b| *b == b'\n').map(|n| at + n) {
            let number = known.unchained + known.chained + 1;
            let told = |found: &str| self.changed(format!("line {number}: {found}"));
            let (line, digest) = parsed(&bytes[at..end]).map_err(|found| told(&found))?;
            match digest {
                Some(digest) => {
                    let before = known.last.clone().unwrap_or_else(|| Digest::of(&bytes[..at]));
                    if line.previous.as_ref() != Some(&before) {
                        return Err(told("it does not follow the line before it"));
                    }
                    known.chained += 1;
                    let at_end = |h: &Head| h.lines == known.chained && h.digest == digest;
                    known.end_seen |= head.as_ref().is_some_and(at_end);
                    known.last = Some(digest);
                }
                None if known.last.is_some() => return Err(told("it is not chained")),
                None => known.unchained += 1,
            }
            known.open.takes(&line).map_err(|found| told(&found))?;
            known.length += (end + 1 - at) as u64;
            at = end + 1;
        }
        Ok(())
    }

    fn head(&self) -> Result<Option<Head>, AdapterError> {
        let path = self.head_path();
        match std::fs::symlink_metadata(&path) {
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Ok(found) if found.is_file() && found.len() < MAX_HEAD => {}
            Ok(_) => return Err(self.changed(format!("{}: another file", path.display()))),
            Err(e) => return Err(self.io(e)),
        }
        let text = std::fs::read(&path).map_err(|e| self.io(e))?;
        let head = serde_json::from_slice(&text);
        head.map(Some).map_err(|e| self.changed(format!("{}: {e}", path.display())))
    }

    /// The end of the chain that was written down must be in the book.
    fn look_for_the_end(&self, known: &Known) -> Result<(), AdapterError> {
        if known.end_seen {
            return Ok(());
        }
        match self.head()? {
            Some(_) => Err(self.changed("lines are missing at its end".into())),
            // The first line of all may stand there alone after a crash.
            None if known.chained > 1 => {
                let path = self.head_path();
                Err(self.changed(format!("{} is gone, so lines may be missing", path.display())))
            }
            None => Ok(()),
        }
    }

    /// Adds a line to the end, durably, and takes it in.
    fn add(&self, known: &mut Known, file: &mut File, mut line: Line) -> Result<(), AdapterError> {
        let before = match &known.last {
            Some(last) => last.clone(),
            None => {
                let mut old = Vec::new();
                file.seek(SeekFrom::Start(0)).map_err(|e| self.io(e))?;
                (&*file).take(known.length).read_to_end(&mut old).map_err(|e| self.io(e))?;
                Digest::of(&old)
            }
        };
        line.previous = Some(before);
        let mut text = serde_json::to_string(&line).map_err(|e| self.io(e.into()))?;
        let digest = Digest::of(text.as_bytes());
        text.pop();
        text.push_str(&format!("{SEAL}{digest}\"}}\n"));
        file.set_len(known.length).map_err(|e| self.io(e))?;
        file.write_all(text.as_bytes()).and_then(|()| file.sync_all()).map_err(|e| self.io(e))?;
        known.open.takes(&line).map_err(|found| self.changed(found))?;
        known.length += text.len() as u64;
        known.chained += 1;
        known.last = Some(digest.clone());
        self.write_head(&Head { lines: known.chained, digest })?;
        known.end_seen = true;
        Ok(())
    }

    fn write_head(&self, head: &Head) -> Result<(), AdapterError> {
        let folder = self.path.parent().unwrap_or(std::path::Path::new("."));
        let write = || {
            let mut file = tempfile::NamedTempFile::new_in(folder)?;
            serde_json::to_writer(&mut file, head)?;
            file.as_file().sync_all()?;
            file.persist(self.head_path()).map_err(|e| e.error)
        };
        write().map(drop).map_err(|e| self.io(e))
    }
}

/// A line and its digest, if it has one and that is right.
fn parsed(bytes: &[u8]) -> Result<(Line, Option<Digest>), String> {
    let text = std::str::from_utf8(bytes).map_err(|e| e.to_string())?;
    let sealed = text.strip_suffix("\"}").and_then(|rest| {
        let (body, digest) = rest.split_at_checked(rest.len().checked_sub(DIGEST_LETTERS)?)?;
        Some((body.strip_suffix(SEAL)?, Digest::parse(digest)?))
    });
    let Some((body, digest)) = sealed else {
        let line: Line = serde_json::from_str(text).map_err(|e| e.to_string())?;
        let old = line.previous.is_none() && line.settles.is_none();
        return if old { Ok((line, None)) } else { Err("its digest is missing".into()) };
    };
    let body = format!("{body}}}");
    if Digest::of(body.as_bytes()) != digest {
        return Err("it was changed".into());
    }
    Ok((serde_json::from_str(&body).map_err(|e| e.to_string())?, Some(digest)))
}

impl Book for FileBook {
    fn entries(&self) -> Result<Vec<Entry>, AdapterError> {
        let mut known = self.known();
        self.read(&mut known)?;
        Ok(known.open.entries.clone())
    }

    fn ask(&self, entry: &Entry, judge: Judge<'_>) -> Result<u64, Unbooked> {
        let mut known = self.known();
        loop {
            let mut file = self.locked()?;
            self.catch_up(&mut known, Some(&file))?;
            match judge(&known.open.entries, &known.open.under_way) {
                Leave::No(why) => return Err(Unbooked::Refused(why)),
                Leave::Go => {
                    let number = known.open.entries.len() as u64;
                    let line = Line { settles: None, entry: entry.clone(), previous: None };
                    self.add(&mut known, &mut file, line)?;
                    known.open.under_way.insert(number);
                    return Ok(number);
                }
                Leave::Wait => {}
            }
            drop(file);
            known = self.settled.wait(known).unwrap_or_else(|e| e.into_inner());
        }
    }

    fn settle(&self, number: u64, entry: &Entry) -> Result<(), AdapterError> {
        let mut known = self.known();
        let mut write = || {
            let mut file = self.locked()?;
            self.catch_up(&mut known, Some(&file))?;
            let line = Line { settles: Some(number), entry: entry.clone(), previous: None };
            self.add(&mut known, &mut file, line)
        };
        let written = write();
        // Whoever waits for it finds it as it stands.
        known.open.under_way.remove(&number);
        self.settled.notify_all();
        written
    }

    fn tell(&self, entry: &Entry) -> Result<(), AdapterError> {
        let mut known = self.known();
        let mut file = self.locked()?;
        self.catch_up(&mut known, Some(&file))?;
        if known.open.entries.contains(entry) {
            return Ok(());
        }
        let line = Line { settles: None, entry: entry.clone(), previous: None };
        self.add(&mut known, &mut file, line)
    }
}

#[cfg(test)]
#[path = "book_tests.rs"]
mod tests;
