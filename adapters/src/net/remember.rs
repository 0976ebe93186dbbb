//! Answers work that was done already from the record, so that no question is paid for twice.

use std::sync::Arc;

use trace::Digest;

use super::calls::Calls;
use crate::budget::Account;
use crate::transport::{Request, Response, Transport, TransportError};

/// Answers from the record of one question alone; what is not on record is refused.
#[derive(Clone)]
pub struct OnRecord {
    /// The record.
    pub calls: Arc<dyn Calls>,
    /// The question.
    pub question: Digest,
}

impl OnRecord {
    fn answer(&self, request: &Request) -> Result<Option<Response>, TransportError> {
        self.calls.answered(&self.question, request).map_err(|error| {
            let found = format!(
                "its answer on record cannot be used, and is not asked for again: {error}; move the folder of the question aside to ask anew"
            );
            TransportError::refused(request, found)
        })
    }
}

impl Transport for OnRecord {
    fn send(&self, request: &Request) -> Result<Response, TransportError> {
        let answer = self.answer(request)?;
        answer.ok_or_else(|| TransportError::refused(request, "it is not on record"))
    }
}

/// Answers a request for work from the record where its answer is there, and sends everything else.
/// Looks and uploads cost nothing and are always sent: what they say passes.
pub struct Remembering<T> {
    /// Who is asked what is not on record.
    pub inner: T,
    /// The record.
    pub record: OnRecord,
    /// Whose book says what was spent: an answer that was recorded just before the end of a program
    /// is settled there when it is used.
    pub account: Account,
}

impl<T: Transport> Transport for Remembering<T> {
    fn send(&self, request: &Request) -> Result<Response, TransportError> {
        if !request.is_work() {
            return self.inner.send(request);
        }
        let Some(answer) = self.record.answer(request)? else { return self.inner.send(request) };
        let made_up = self.account.make_up_for(&self.record.question, &request.step, &answer);
        made_up.map_err(|found| {
            let found = format!("what was used cannot be written down: {found}");
            TransportError::refused(request, found)
        })?;
        Ok(answer)
    }
}
