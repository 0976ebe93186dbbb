//! A file and the clients asked for → what each will do.

use std::path::Path;

use serde::Serialize;

use crate::client::Client;
use crate::read::{Model, Outside, ReadError, read};
use crate::rule::{Find, Place, Rule, Severity, Source};
use crate::rules::RULES;

/// What one client will do with a file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Forecast {
    /// The client.
    pub client: Client,
    /// Rules about this client and the file's format that were asked. 0 means that nothing is known,
    /// not that nothing will happen.
    pub rules: usize,
    /// What the rules say, worst first.
    pub findings: Vec<Finding>,
}

/// A rule that applies.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// Its id.
    pub rule: &'static str,
    /// How much follows.
    pub severity: Severity,
    /// What will happen.
    pub sentence: &'static str,
    /// What to do about it.
    pub remedy: &'static str,
    /// With what it was measured, or what was read.
    pub version: &'static str,
    /// Where it is known from.
    pub source: Source,
    /// Where it applies, in the order of the file; the first [`MAX_PLACES`].
    pub places: Vec<Place>,
    /// In how many places it applies.
    pub count: usize,
}

/// Most places of a finding that are listed; a guess with room.
pub const MAX_PLACES: usize = 100;

/// Reads a URDF, MJCF or USDA file and asks every rule of these clients about it.
///
/// # Errors
/// [`ReadError`] when the file cannot be read, with what to do about it.
///
/// ```
/// let e = forecast::forecast("none.urdf".as_ref(), &forecast::Client::ALL, forecast::Outside::Refused);
/// assert!(e.unwrap_err().to_string().starts_with("none.urdf: cannot be opened"));
/// ```
pub fn forecast(
    path: &Path,
    clients: &[Client],
    outside: Outside,
) -> Result<Vec<Forecast>, ReadError> {
    let model = read(path, outside)?;
    Ok(clients.iter().map(|client| of_client(&model, *client)).collect())
}

fn of_client(model: &Model, client: Client) -> Forecast {
    let mut forecast = Forecast { client, rules: 0, findings: Vec::new() };
    for rule in RULES.iter().copied().flatten().filter(|r| r.client == client) {
        let places = match (rule.find, model) {
            (Find::Urdf(find), Model::Urdf(urdf)) => find(urdf),
            (Find::Mjcf(find), Model::Mjcf(mjcf)) => find(mjcf),
            (Find::Usd(find), Model::Usd(stage)) => find(stage),
            _ => continue,
        };
        forecast.rules += 1;
        if !places.is_empty() {
            forecast.findings.push(told(rule, places));
        }
    }
    forecast.findings.sort_by_key(|f| f.severity);
    forecast
}

fn told(rule: &Rule, mut places: Vec<Place>) -> Finding {
    places.sort_by_key(|p| p.line);
    let count = places.len();
    places.truncate(MAX_PLACES);
    Finding {
        rule: rule.id,
        severity: rule.severity,
        sentence: rule.sentence,
        remedy: rule.remedy,
        version: rule.version,
        source: rule.source,
        places,
        count,
    }
}
