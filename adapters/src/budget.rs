//! What may be spent, what was spent, and the gate between: every request for work is looked at and
//! written down before it is sent, and one whose answer was lost counts as spent.

use std::collections::BTreeSet;
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use trace::Digest;

pub use crate::book::{Book, COMMAND, Entry, Fate, FileBook, Leave, MemoryBook, Unbooked};
use crate::generators::answer::words;
use crate::net::retry::asked_wait;
use crate::transport::{CHARGED, Request, Response, Transport, TransportError};
use crate::usage::Usage;

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
    /// What a request counts for whose answer was lost; a budget of a kind that is left out here
    /// cannot be kept after such a loss.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lost: Option<Lost>,
}

/// What a request whose answer was lost counts for, by the user's own word.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Lost {
    /// Tokens, of a request to a model.
    pub tokens: Option<u64>,
    /// Credits, of a request for a mesh.
    pub credits: Option<f64>,
    /// Money.
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

/// The account of one service: what may be spent by anybody, what it charges, and the book.
#[derive(Clone)]
pub struct Account {
    /// The most that may be spent in all.
    pub budget: Budget,
    /// What this service charges.
    pub price: Option<Price>,
    /// Where it is written down.
    pub book: Arc<dyn Book>,
    /// Whether it is a server of the user's own, where asking twice costs time alone.
    pub own_server: bool,
}

impl Account {
    /// An account without limit and without a memory.
    pub fn free() -> Self {
        let book = Arc::new(MemoryBook::default());
        Self { budget: Budget::default(), price: None, book, own_server: false }
    }

    /// Whether another request for work may be sent.
    ///
    /// # Errors
    /// Which budget is used up, or cannot be kept because something is not known.
    pub fn check(&self) -> Result<(), String> {
        let entries = self.book.entries().map_err(|e| e.to_string())?;
        match self.judge(&entries, &BTreeSet::new()) {
            Leave::Go | Leave::Wait => Ok(()),
            Leave::No(why) => Err(why),
        }
    }

    /// Whether another request for work may be sent, and whether that can be told now: what those
    /// under way use is known when they are back.
    fn judge(&self, entries: &[Entry], under_way: &BTreeSet<u64>) -> Leave {
        let Budget { calls, .. } = self.budget;
        let sent = |e: &&Entry| e.work && e.fate != Fate::Unsent;
        let made = entries.iter().filter(sent).count() as u64;
        if let Err(why) = used_up("calls", calls.map(|n| n as f64), Some(made as f64 + 1.0)) {
            return Leave::No(why);
        }
        // A program reports nothing, so there is nothing to wait for.
        let reports = |n: &u64| {
            let entry = usize::try_from(*n).ok().and_then(|n| entries.get(n));
            entry.is_some_and(|e| e.step != COMMAND)
        };
        if self.waits_for_usage() && under_way.iter().any(reports) {
            return Leave::Wait;
        }
        match self.check_usage(entries) {
            Ok(()) => Leave::Go,
            Err(why) => Leave::No(why),
        }
    }

    /// Whether what may be spent depends on what services report.
    fn waits_for_usage(&self) -> bool {
        let Budget { tokens, credits, money, .. } = self.budget;
        let by_usage = |p: Price| p.credit + p.million_input + p.million_output > 0.0;
        tokens.is_some()
            || credits.is_some()
            || (money.is_some() && self.price.is_some_and(by_usage))
    }

    fn check_usage(&self, entries: &[Entry]) -> Result<(), String> {
        let Budget { tokens, credits, money, lost, .. } = self.budget;
        let lost = lost.unwrap_or_default();
        let asked = || entries.iter().filter(|e| e.work);
        let talk = |e: &&Entry| e.step.starts_with("vlm.");
        let tokens_of = |e: &Entry| match e.fate {
            Fate::Unsent | Fate::Refused => Some(0.0),
            Fate::Asked | Fate::Lost => lost.tokens.map(|n| n as f64),
            Fate::Answered => Some(e.usage.input?.saturating_add(e.usage.output?) as f64),
        };
        let spoken = asked().filter(talk).map(tokens_of).sum();
        used_up("tokens", tokens.map(|n| n as f64), spoken)?;
        let unknown = |e: &&Entry| matches!(e.fate, Fate::Asked | Fate::Lost);
        let job = |e: &&Entry| !talk(e) && e.step != COMMAND;
        let gone = asked().filter(job).filter(unknown).map(|_| lost.credits);
        let told = entries.iter().filter_map(|e| e.usage.credits).map(Some);
        used_up("credits", credits, told.chain(gone).sum())?;
        let money_of = |e: &Entry| e.money.or(lost.money.filter(|_| unknown(&e)));
        let next = self.price.map(|p| p.call);
        let spent: Option<f64> = entries.iter().map(money_of).sum();
        used_up("money", money, spent.zip(next).map(|(spent, next)| spent + next))
    }

    /// What a request costs that ended so; none where that depends on something not reported.
    fn money(&self, entry: &Entry) -> Option<f64> {
        let price = self.price?;
        if matches!(entry.fate, Fate::Unsent | Fate::Refused) {
            return Some(0.0);
        }
        let price = if entry.work { price } else { Price { call: 0.0, ..price } };
        // What a job used is told when it is done, not when it is asked for.
        let answered = entry.fate == Fate::Answered;
        let later = answered && entry.usage.is_empty() && !entry.step.starts_with("vlm.");
        let later = later && entry.work;
        let price = if later { Price { call: price.call, ..Price::default() } } else { price };
        price.of(&entry.usage)
    }

    /// Writes a request down before it is sent.
    ///
    /// # Errors
    /// What is said to whoever wants to send it.
    fn ask(&self, question: &Digest, request: &Request) -> Result<Sent<'_>, TransportError> {
        let mut entry = Entry {
            question: question.clone(),
            step: request.step.clone(),
            work: true,
            fate: Fate::Asked,
            usage: Usage::default(),
            money: None,
        };
        entry.money = self.money(&entry);
        let judge = |entries: &[Entry], under_way: &BTreeSet<u64>| self.judge(entries, under_way);
        match self.book.ask(&entry, &judge) {
            Ok(number) => Ok(Sent { account: self, number, entry, settled: false }),
            Err(Unbooked::Refused(why)) => {
                Err(TransportError { over_budget: true, ..TransportError::refused(request, why) })
            }
            Err(Unbooked::Book(error)) => {
                let found = format!("nothing is sent that cannot be written down: {error}");
                Err(TransportError::refused(request, found))
            }
        }
    }

    /// Writes down what an answer found on record used, where the program ended before it could.
    ///
    /// # Errors
    /// Why it cannot be written down.
    pub fn make_up_for(
        &self,
        question: &Digest,
        step: &str,
        response: &Response,
    ) -> Result<(), String> {
        let entries = self.book.entries().map_err(|e| e.to_string())?;
        let same = |e: &Entry| e.question == *question && e.step == step && e.work;
        let Some(number) = entries.iter().rposition(|e| same(e) && e.fate == Fate::Asked) else {
            return Ok(());
        };
        let mut entry = entries[number].clone();
        (entry.fate, entry.usage) = (Fate::Answered, Usage::reported(response));
        entry.money = self.money(&entry);
        self.book.settle(number as u64, &entry).map_err(|e| e.to_string())
    }

    /// Writes down what a finished job reports; a fetch that reports nothing leaves no line.
    fn tell(
        &self,
        question: &Digest,
        request: &Request,
        response: &Response,
    ) -> Result<(), String> {
        let usage = Usage::reported(response);
        if usage.is_empty() {
            return Ok(());
        }
        let (question, step) = (question.clone(), request.step.clone());
        let fate = Fate::Answered;
        let mut entry = Entry { question, step, work: false, fate, usage, money: None };
        entry.money = self.money(&entry);
        self.book.tell(&entry).map_err(|e| e.to_string())
    }

    /// Books some work that is no request, such as a program, and does it.
    ///
    /// # Errors
    /// Those of the work, and a refusal where it may not be done.
    pub fn booked<A>(
        &self,
        question: &Digest,
        step: &str,
        work: impl FnOnce() -> Result<A, crate::AdapterError>,
    ) -> Result<A, crate::AdapterError> {
        let request = Request::new(step, crate::transport::Method::Post, "command://program");
        let sent = self.ask(question, &request)?;
        let done = work();
        let fate = if done.is_ok() { Fate::Answered } else { Fate::Lost };
        sent.settle(fate, Usage::default())?;
        done
    }
}

/// A request that stands in the book and has not come back. Whoever lets it go without a word lost
/// its answer.
struct Sent<'a> {
    account: &'a Account,
    number: u64,
    entry: Entry,
    settled: bool,
}

impl Sent<'_> {
    fn settle(mut self, fate: Fate, usage: Usage) -> Result<(), TransportError> {
        self.settled = true;
        self.write(fate, usage).map_err(|found| TransportError {
            step: self.entry.step.clone(),
            host: "the account book".into(),
            found: format!("what was used cannot be written down: {found}"),
            transient: false,
            may_have_arrived: true,
            over_budget: false,
        })
    }

    fn write(&self, fate: Fate, usage: Usage) -> Result<(), String> {
        let mut entry = Entry { fate, usage, ..self.entry.clone() };
        entry.money = self.account.money(&entry);
        self.account.book.settle(self.number, &entry).map_err(|e| e.to_string())
    }
}

impl Drop for Sent<'_> {
    fn drop(&mut self) {
        if !self.settled {
            // A line that cannot be written leaves the request as asked for, which counts the same.
            let _ = self.write(Fate::Lost, Usage::default());
        }
    }
}

fn used_up(what: &str, most: Option<f64>, spent: Option<f64>) -> Result<(), String> {
    let Some(most) = most else { return Ok(()) };
    let Some(spent) = spent else {
        return Err(format!(
            "the budget of {most} {what} cannot be kept: prices are missing, a service did not report what it used, or its answer was lost and `lost` in [budget] does not say what that counts for"
        ));
    };
    let over = if what == "calls" { spent > most } else { spent >= most };
    if over { Err(format!("the budget of {most} {what} is used up")) } else { Ok(()) }
}

/// What an outcome says about whether the work was done.
fn fate(outcome: &Result<Response, TransportError>) -> Fate {
    match outcome {
        Err(e) if e.may_have_arrived => Fate::Lost,
        Err(_) => Fate::Unsent,
        Ok(r) => match r.status {
            200..300 => Fate::Answered,
            // A time to wait is a no; without one, nobody knows how far it came.
            503 if asked_wait(r).is_some() => Fate::Refused,
            408 => Fate::Lost,
            300..500 => Fate::Refused,
            _ => Fate::Lost,
        },
    }
}

/// Looks at the budget before each request for work, writes it down before it is sent, and then what
/// became of it. One whose answer was lost comes back as an error that nobody repeats.
pub struct Accounted<T> {
    /// Who is asked.
    pub inner: T,
    /// Who pays.
    pub account: Account,
    /// What for.
    pub question: Digest,
}

impl<T: Transport> Accounted<T> {
    /// The outcome as it is told above: what may have been charged is never transient.
    fn told(
        &self,
        request: &Request,
        outcome: Result<Response, TransportError>,
    ) -> Result<Response, TransportError> {
        if self.account.own_server || fate(&outcome) != Fate::Lost {
            return outcome;
        }
        let error = match outcome {
            Err(error) => error,
            Ok(response) => {
                let found = format!("{} {}", response.status, words(&response));
                let found = format!("the answer must be a success, found {found}");
                TransportError::refused(request, found)
            }
        };
        let found = format!("{}; {CHARGED}", error.found);
        Err(TransportError { found, transient: false, may_have_arrived: true, ..error })
    }
}

impl<T: Transport> Transport for Accounted<T> {
    fn send(&self, request: &Request) -> Result<Response, TransportError> {
        if !request.is_work() {
            let response = self.inner.send(request)?;
            let told = self.account.tell(&self.question, request, &response);
            told.map_err(|found| {
                let found = format!("what was used cannot be written down: {found}");
                TransportError { may_have_arrived: true, ..TransportError::refused(request, found) }
            })?;
            return Ok(response);
        }
        let sent = self.account.ask(&self.question, request)?;
        let outcome = self.inner.send(request);
        let usage = outcome.as_ref().map(Usage::reported).unwrap_or_default();
        sent.settle(fate(&outcome), usage)?;
        self.told(request, outcome)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

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

    /// Comes to the same end every time, and says what stood in the book when it was asked.
    struct Ends(Account, Result<Response, TransportError>, Mutex<Vec<Vec<Fate>>>);

    impl Transport for Ends {
        fn send(&self, _: &Request) -> Result<Response, TransportError> {
            let fates = self.0.book.entries().unwrap().iter().map(|e| e.fate).collect();
            self.2.lock().unwrap().push(fates);
            self.1.clone()
        }
    }

    fn status(status: u16, headers: &[(&str, &str)]) -> Result<Response, TransportError> {
        let headers = headers.iter().map(|(n, v)| (n.to_string(), v.to_string())).collect();
        Ok(Response { status, headers, body: vec![] })
    }

    fn broken(may_have_arrived: bool) -> Result<Response, TransportError> {
        let error = TransportError::refused(&Request::new("s", Method::Post, "http://h"), "broke");
        Err(TransportError { transient: true, may_have_arrived, ..error })
    }

    /// What comes back of one request, and what the book says then.
    fn one(
        account: &Account,
        end: Result<Response, TransportError>,
    ) -> (Result<Response, TransportError>, Fate) {
        let inner = Ends(account.clone(), end, Mutex::default());
        let question = Digest::of(b"q");
        let accounted = Accounted { inner, account: account.clone(), question };
        let came = accounted.send(&Request::new("vlm.points/0", Method::Post, "http://h"));
        let seen = accounted.inner.2.lock().unwrap().clone();
        assert_eq!(
            seen.last().unwrap().last(),
            Some(&Fate::Asked),
            "written down before it is sent"
        );
        (came, account.book.entries().unwrap().last().unwrap().fate)
    }

    #[test]
    fn every_end_a_request_can_come_to_is_in_the_book_and_a_loss_is_never_repeated() {
        let account = account(Budget::default(), None);
        for lost in
            [broken(true), status(500, &[]), status(502, &[]), status(503, &[]), status(408, &[])]
        {
            let (came, fate) = one(&account, lost);
            let error = came.unwrap_err();
            assert!(!error.transient && error.may_have_arrived, "{error}");
            assert!(error.found.ends_with(CHARGED), "{error}");
            assert_eq!(fate, Fate::Lost);
        }
        assert_eq!(one(&account, broken(false)).1, Fate::Unsent);
        assert_eq!(one(&account, status(200, &[])).1, Fate::Answered);
        for refused in [status(429, &[]), status(401, &[]), status(503, &[("retry-after", "1")])] {
            let (came, fate) = one(&account, refused);
            assert_eq!((came.is_ok(), fate), (true, Fate::Refused));
        }
        let own = Account { own_server: true, ..account };
        let (came, fate) = one(&own, broken(true));
        assert!(came.unwrap_err().transient && fate == Fate::Lost, "asking twice costs time alone");
    }

    #[test]
    fn a_lost_answer_counts_as_spent_in_every_budget() {
        let calls = account(Budget { calls: Some(1), ..Budget::default() }, None);
        one(&calls, broken(true)).0.unwrap_err();
        assert_eq!(calls.check().unwrap_err(), "the budget of 1 calls is used up");
        let price = Some(Price { call: 0.4, ..Price::default() });
        let money = account(Budget { money: Some(0.7), ..Budget::default() }, price);
        one(&money, broken(true)).0.unwrap_err();
        assert_eq!(money.check().unwrap_err(), "the budget of 0.7 money is used up");
        let tokens = Budget { tokens: Some(5000), ..Budget::default() };
        let unknown = account(tokens, None);
        one(&unknown, status(500, &[])).0.unwrap_err();
        assert!(unknown.check().unwrap_err().contains("its answer was lost"));
        let lost = Some(Lost { tokens: Some(4000), ..Lost::default() });
        let told = account(Budget { lost, ..tokens }, None);
        one(&told, broken(true)).0.unwrap_err();
        told.check().unwrap();
        one(&told, broken(true)).0.unwrap_err();
        assert_eq!(told.check().unwrap_err(), "the budget of 5000 tokens is used up");
        let unsent = account(Budget { calls: Some(1), ..Budget::default() }, None);
        one(&unsent, broken(false)).0.unwrap_err();
        unsent.check().unwrap();
    }

    #[test]
    fn a_refusal_for_want_of_budget_says_so_and_sends_nothing() {
        let none = account(Budget { calls: Some(0), ..Budget::default() }, None);
        let inner = Same(Mutex::default(), json!({}));
        let accounted = Accounted { inner, account: none, question: Digest::of(b"q") };
        let error = accounted.send(&Request::new("s", Method::Post, "http://h")).unwrap_err();
        assert!(error.over_budget && !error.may_have_arrived, "{error}");
        assert_eq!(*accounted.inner.0.lock().unwrap(), 0);
    }

    #[test]
    fn a_panic_under_way_is_a_loss() {
        struct Panics;
        impl Transport for Panics {
            fn send(&self, _: &Request) -> Result<Response, TransportError> {
                panic!("in the middle")
            }
        }
        let account = account(Budget::default(), None);
        let accounted =
            Accounted { inner: Panics, account: account.clone(), question: Digest::of(b"q") };
        let send = || accounted.send(&Request::new("s", Method::Post, "http://h"));
        std::panic::catch_unwind(std::panic::AssertUnwindSafe(send)).unwrap_err();
        assert_eq!(account.book.entries().unwrap()[0].fate, Fate::Lost);
    }

    #[test]
    fn an_answer_on_record_that_was_not_settled_is_made_up_for() {
        let budget = Budget { tokens: Some(9000), ..Budget::default() };
        let account = account(budget, None);
        let request = Request::new("vlm.points/0", Method::Post, "http://h");
        let question = Digest::of(b"q");
        let killed = account.ask(&question, &request).unwrap();
        std::mem::forget(killed);
        account.check().unwrap_err();
        let body = tokens().to_string().into_bytes();
        let answer = Response { status: 200, headers: vec![], body };
        account.make_up_for(&question, "vlm.points/0", &answer).unwrap();
        account.check().unwrap();
        assert_eq!(account.book.entries().unwrap()[0].usage.input, Some(600));
    }
}
