//! What adapters reach the world through: the network, the records, the clock, the environment.

use std::path::PathBuf;
use std::sync::Arc;

use secrecy::SecretString;
use trace::Clock;

use crate::book::Book;
use crate::generators::Ledger;
use crate::net::calls::Calls;
use crate::net::gate::Gates;
use crate::net::pace::Pace;
use crate::overheard::Onlooker;
use crate::{AdapterError, Transport};

/// What adapters reach the world through.
#[derive(Clone)]
pub struct World {
    /// What everything passes through, once it is written down.
    pub transport: Arc<dyn Transport>,
    /// Answers what was answered already and refuses everything else.
    pub on_record: Arc<dyn Transport>,
    /// Where every call is written down.
    pub calls: Arc<dyn Calls>,
    /// Who waits.
    pub pace: Arc<dyn Pace>,
    /// Tells the time of day, for signatures and dates.
    pub clock: Arc<dyn Clock>,
    /// What is known of jobs.
    pub ledger: Arc<dyn Ledger>,
    /// Where it is written down what was spent.
    pub book: Arc<dyn Book>,
    /// The gates of all services.
    pub gates: Arc<Gates>,
    /// A folder for files that live no longer than a call.
    pub scratch: PathBuf,
    /// This program, which looks after programs that it starts; see [`crate::keeper::Keeper`].
    pub keeper: Option<PathBuf>,
    /// Who sees what such programs say while they run; none is nobody.
    pub onlooker: Option<Onlooker>,
    /// The environment: a variable's value by its name.
    pub variable: fn(&str) -> Option<String>,
}

impl World {
    /// The key a variable holds, without blanks around it.
    ///
    /// # Errors
    /// [`AdapterError::Key`] where it is not set or blank.
    pub(crate) fn key(&self, variable: &str) -> Result<SecretString, AdapterError> {
        let value = (self.variable)(variable).filter(|v| !v.trim().is_empty());
        let value = value.ok_or_else(|| AdapterError::Key { variable: variable.into() })?;
        Ok(value.trim().to_owned().into())
    }
}
