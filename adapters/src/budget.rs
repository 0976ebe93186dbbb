//! What may be spent, what was spent, and the gate between: looked at before each paid call.

use std::path::PathBuf;
use std::sync::{Arc, Mutex};

use serde::{Deserialize, Serialize};
use trace::Digest;

use crate::AdapterError;
use crate::files::read_limited;
use crate::transport::{Request, Response, Transport, TransportError};
use crate::usage::Usage;

/// Largest account book, bytes.
const MAX_BOOK: u64 = 64 << 20;

/// The most that may be spent in all; left out is without limit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Budget {
    /// Paid calls.
    pub calls: Option<u64>,
    /// Tokens, read and written.
    pub tokens: Option<u64>,
    /// Credits of the services' own currencies.
    pub credits: Option<f64>,
    /// Money, in the currency of the prices given.
    pub money: Option<f64>,
}

/// What a service charges, by the user's own contract.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Price {
    /// Each call.
    pub call: f64,
    /// Each credit.
    pub credit: f64,
    /// A million tokens read.
    pub million_input: f64,
    /// A million tokens written.
    pub million_output: f64,
}

impl Price {
    /// What a call costs; none if it depends on something the service did not report.
    fn of(&self, usage: &Usage) -> Option<f64> {
        let part = |price: f64, count: Option<f64>| {
            if price == 0.0 { Some(0.0) } else { Some(price * count?) }
        };
        let tokens = |count: Option<u64>| count.map(|n| n as f64 / 1e6);
        let [input, output] = [tokens(usage.input), tokens(usage.output)];
        let spoken = part(self.million_input, input)? + part(self.million_output, output)?;
        Some(self.call + spoken + part(self.credit, usage.credits)?)
    }
}

/// One line of the account book.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    /// The question it was for.
    pub question: Digest,
    /// What was asked.
    pub step: String,
    /// Whether it was a call for work, or only told what an earlier one used.
    pub work: bool,
    /// What the service reports.
    pub usage: Usage,
    /// What that costs by the user's prices; none without prices or reports.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub money: Option<f64>,
}

/// Where it is written down what was spent.
///
/// Promise: what was written survives the end of the program at any later moment.
pub trait Book: Send + Sync {
    /// Everything written so far.
    ///
    /// # Errors
    /// [`AdapterError`] when it cannot be read.
    fn entries(&self) -> Result<Vec<Entry>, AdapterError>;

    /// Writes a line.
    ///
    /// # Errors
    /// [`AdapterError`] when it cannot be written.
    fn write(&self, entry: &Entry) -> Result<(), AdapterError>;
}

/// A book in memory: for replays, which spend nothing, and tests.
#[derive(Debug, Default)]
pub struct MemoryBook(Mutex<Vec<Entry>>);

impl Book for MemoryBook {
    fn entries(&self) -> Result<Vec<Entry>, AdapterError> {
        Ok(self.0.lock().unwrap_or_else(|e| e.into_inner()).clone())
    }

    fn write(&self, entry: &Entry) -> Result<(), AdapterError> {
        self.0.lock().unwrap_or_else(|e| e.into_inner()).push(entry.clone());
        Ok(())
    }
}

/// A book in a file, a line of JSON an entry.
#[derive(Clone, Debug)]
pub struct FileBook {
    /// The file; made when it is first needed.
    pub path: PathBuf,
}

impl FileBook {
    /// Length up to the end of the last whole line.
    fn whole(&self) -> std::io::Result<u64> {
        let bytes = std::fs::read(&self.path)?;
        Ok(bytes.iter().rposition(|b| *b == b'\n').map_or(0, |at| at as u64 + 1))
    }
}

impl Book for FileBook {
    fn entries(&self) -> Result<Vec<Entry>, AdapterError> {
        if !self.path.exists() {
            return Ok(vec![]);
        }
        let bytes = read_limited(&self.path, MAX_BOOK)?;
        // A line that was cut by a crash was never acted upon.
        let whole = bytes.rsplitn(2, |b| *b == b'\n').nth(1).unwrap_or_default();
        let lines = whole.split(|b| *b == b'\n').filter(|line| !line.is_empty());
        let entry = |line: &[u8]| {
            serde_json::from_slice(line).map_err(|e| AdapterError::Format {
                path: self.path.display().to_string(),
                expected: "an account book written by kinfold",
                found: e.to_string(),
            })
        };
        lines.map(entry).collect()
    }

    fn write(&self, entry: &Entry) -> Result<(), AdapterError> {
        use std::io::Write as _;
        let io = |source| AdapterError::Io { path: self.path.display().to_string(), source };
        if let Some(folder) = self.path.parent() {
            std::fs::create_dir_all(folder).map_err(io)?;
        }
        let mut line = serde_json::to_vec(entry).map_err(|e| io(e.into()))?;
        line.push(b'\n');
        let file = std::fs::File::options().create(true).append(true).open(&self.path);
        let mut file = file.map_err(io)?;
        file.set_len(self.whole().map_err(io)?).map_err(io)?;
        file.write_all(&line).and_then(|()| file.sync_all()).map_err(io)
    }
}

/// The account of one service: what may be spent by anybody, what it charges, and the book.
#[derive(Clone)]
pub struct Account {
    /// The most that may be spent in all.
    pub budget: Budget,
    /// What this service charges.
    pub price: Option<Price>,
    /// Where it is written down.
    pub book: Arc<dyn Book>,
}

impl Account {
    /// An account without limit and without a memory.
    pub fn free() -> Self {
        Self { budget: Budget::default(), price: None, book: Arc::new(MemoryBook::default()) }
    }

    /// Whether another call for work may be made.
    ///
    /// # Errors
    /// Which budget is used up, or cannot be kept because something is not known.
    pub fn check(&self) -> Result<(), String> {
        let entries = self.book.entries().map_err(|e| e.to_string())?;
        let Budget { calls, tokens, credits, money } = self.budget;
        let made = entries.iter().filter(|e| e.work).count() as u64;
        used_up("calls", calls.map(|n| n as f64), Some(made as f64 + 1.0))?;
        let tokens_of = |e: &Entry| Some(e.usage.input?.saturating_add(e.usage.output?) as f64);
        let spoken = entries.iter().filter(|e| e.work && e.step.starts_with("vlm."));
        used_up("tokens", tokens.map(|n| n as f64), spoken.map(tokens_of).sum())?;
        used_up(
            "credits",
            credits,
            entries.iter().filter_map(|e| e.usage.credits).map(Some).sum(),
        )?;
        let next = self.price.map(|p| p.call);
        let spent: Option<f64> = entries.iter().map(|e| e.money).sum();
        used_up("money", money, spent.zip(next).map(|(spent, next)| spent + next))
    }

    /// Writes down what an answer reports; a fetch that reports nothing leaves no line.
    fn note(
        &self,
        question: &Digest,
        request: &Request,
        response: &Response,
    ) -> Result<(), String> {
        let (work, usage) = (request.is_work(), Usage::reported(response));
        if !work && usage.is_empty() {
            return Ok(());
        }
        // What a job used is told when it is done, not when it is asked for.
        let later = work && usage.is_empty() && !request.step.starts_with("vlm.");
        let price = self.price.map(|p| if work { p } else { Price { call: 0.0, ..p } });
        let price =
            price.map(|p| if later { Price { call: p.call, ..Price::default() } } else { p });
        let money = price.and_then(|p| p.of(&usage));
        let step = request.step.clone();
        let entry = Entry { question: question.clone(), step, work, usage, money };
        let told = self.book.entries().map_err(|e| e.to_string())?;
        // A finished job may be looked at twice; it was paid for once.
        if !work && told.contains(&entry) {
            return Ok(());
        }
        self.book.write(&entry).map_err(|e| e.to_string())
    }
}

fn used_up(what: &str, most: Option<f64>, spent: Option<f64>) -> Result<(), String> {
    let Some(most) = most else { return Ok(()) };
    let Some(spent) = spent else {
        return Err(format!(
            "the budget of {most} {what} cannot be kept: prices are missing, or a service did not report what it used"
        ));
    };
    let over = if what == "calls" { spent > most } else { spent >= most };
    if over { Err(format!("the budget of {most} {what} is used up")) } else { Ok(()) }
}

/// Looks at the budget before each call for work, and writes down what was used.
pub struct Accounted<T> {
    /// Who is asked.
    pub inner: T,
    /// Who pays.
    pub account: Account,
    /// What for.
    pub question: Digest,
}

impl<T: Transport> Transport for Accounted<T> {
    fn send(&self, request: &Request) -> Result<Response, TransportError> {
        if request.is_work() {
            self.account.check().map_err(|found| TransportError::refused(request, found))?;
        }
        let response = self.inner.send(request)?;
        let noted = self.account.note(&self.question, request, &response);
        noted.map_err(|found| {
            let found = format!("what was used cannot be written down: {found}");
            TransportError { may_have_arrived: true, ..TransportError::refused(request, found) }
        })?;
        Ok(response)
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::transport::Method;

    /// Answers with the same body, and counts.
    struct Same(Mutex<u32>, serde_json::Value);

    impl Transport for Same {
        fn send(&self, _: &Request) -> Result<Response, TransportError> {
            *self.0.lock().unwrap() += 1;
            Ok(Response { status: 200, headers: vec![], body: self.1.to_string().into_bytes() })
        }
    }

    fn asked(account: &Account, step: &str, body: serde_json::Value, times: usize) -> Vec<bool> {
        let inner = Same(Mutex::default(), body);
        let question = Digest::of(step.as_bytes());
        let accounted = Accounted { inner, account: account.clone(), question };
        let request = Request::new(step, Method::Post, "http://h");
        (0..times).map(|_| accounted.send(&request).is_ok()).collect()
    }

    fn account(budget: Budget, price: Option<Price>) -> Account {
        Account { budget, price, ..Account::free() }
    }

    fn tokens() -> serde_json::Value {
        json!({ "usage": { "prompt_tokens": 600, "completion_tokens": 400 } })
    }

    #[test]
    fn no_call_is_made_beyond_the_budget() {
        let calls = account(Budget { calls: Some(2), ..Budget::default() }, None);
        assert_eq!(asked(&calls, "meshy.submit", json!({}), 3), [true, true, false]);
        let budget = account(Budget { tokens: Some(2000), ..Budget::default() }, None);
        assert_eq!(asked(&budget, "vlm.points/0", tokens(), 3), [true, true, false]);
        let price = Price { million_input: 1000.0, million_output: 1000.0, ..Price::default() };
        let money = account(Budget { money: Some(1.5), ..Budget::default() }, Some(price));
        assert_eq!(asked(&money, "vlm.points/0", tokens(), 3), [true, true, false]);
        let price = Price { call: 1.0, ..Price::default() };
        let money = account(Budget { money: Some(1.5), ..Budget::default() }, Some(price));
        assert_eq!(asked(&money, "meshy.submit", json!({}), 2), [true, false]);
    }

    #[test]
    fn a_budget_that_cannot_be_kept_lets_nothing_pass() {
        let money = account(Budget { money: Some(9.0), ..Budget::default() }, None);
        assert_eq!(asked(&money, "meshy.submit", json!({}), 1), [false], "no prices");
        let budget = account(Budget { tokens: Some(2000), ..Budget::default() }, None);
        assert_eq!(asked(&budget, "vlm.points/0", json!({}), 2), [true, false], "no reports");
    }

    #[test]
    fn a_finished_job_is_paid_for_once_however_often_it_is_looked_at() {
        let price = Price { credit: 0.5, ..Price::default() };
        let account = account(Budget { credits: Some(40.0), ..Budget::default() }, Some(price));
        asked(&account, "meshy.submit", json!({ "result": "1" }), 1);
        let inner = Same(Mutex::default(), json!({ "consumed_credits": 30 }));
        let question = Digest::of(b"q");
        let accounted = Accounted { inner, account: account.clone(), question };
        for _ in 0..3 {
            accounted.send(&Request::new("meshy.status", Method::Get, "http://h")).unwrap();
        }
        let entries = account.book.entries().unwrap();
        assert_eq!(entries.len(), 2);
        assert_eq!((entries[0].money, entries[1].money), (Some(0.0), Some(15.0)));
        account.check().unwrap();
    }

    #[test]
    fn a_book_in_a_file_survives_a_line_cut_short() {
        let dir = tempfile::tempdir().unwrap();
        let book = FileBook { path: dir.path().join("deep/spent.jsonl") };
        assert!(book.entries().unwrap().is_empty());
        let question = Digest::of(b"q");
        let usage = Usage { input: Some(3), ..Usage::default() };
        let entry = Entry { question, step: "s".into(), work: true, usage, money: None };
        book.write(&entry).unwrap();
        let mut bytes = std::fs::read(&book.path).unwrap();
        bytes.extend_from_slice(b"{\"question\": \"ab");
        std::fs::write(&book.path, bytes).unwrap();
        assert_eq!(book.entries().unwrap(), std::slice::from_ref(&entry));
        book.write(&entry).unwrap();
        assert_eq!(book.entries().unwrap(), [entry.clone(), entry]);
        std::fs::write(&book.path, b"nonsense\n").unwrap();
        book.entries().unwrap_err();
    }
}
