//! How a job stands, by its outcome and by what it is at.

use std::collections::BTreeMap;
use std::path::Path;

use studio::{Job, JobState};

use crate::batch::record::{Ended, Record};
use crate::output::names::{REASON, STATEMENT, TRACE};

/// What a job is at.
#[derive(Clone, Debug, Default)]
pub(super) struct Running {
    pub stage: String,
    pub done: usize,
}

/// Digests and their characters.
const DIGEST: usize = 64;

/// A job of so many stages. Files are named as in the job's own words: those below `inputs` have no place
/// that a person elsewhere knows of.
pub(super) fn job(
    (id, of): (&str, usize),
    record: Option<&Record>,
    running: Option<Running>,
    inputs: &Path,
) -> Job {
    let over = record.filter(|record| record.is_final());
    let state = match (over.map(|record| record.outcome), &running) {
        (Some(Ended::Accepted), _) => JobState::Accepted,
        (Some(Ended::Rejected), _) => JobState::Rejected,
        (Some(Ended::Failed), _) => JobState::Failed,
        (Some(Ended::Reopened) | None, Some(_)) => JobState::Running,
        (Some(Ended::Reopened) | None, None) => JobState::Queued,
    };
    let said = |words: &Option<String>| words.as_deref().map(|words| unplaced(words, inputs));
    let running = running.filter(|_| over.is_none());
    let (stage, done) = match (running, over) {
        (Some(Running { stage, done }), _) => (Some(stage), done),
        (None, Some(record)) if record.outcome == Ended::Accepted => (None, of),
        (None, Some(record)) => (record.stage.clone(), 0),
        (None, None) => (None, 0),
    };
    let met = record.filter(|record| over.is_none() && record.outcome == Ended::Failed);
    let words = |text: &Option<String>| -> Vec<String> {
        text.iter().flat_map(|text| text.split_whitespace()).map(str::to_owned).collect()
    };
    Job {
        id: id.to_owned(),
        state,
        stage,
        done,
        of,
        tier: over.and_then(|record| record.verdict.clone()),
        class: over.or(met).and_then(|record| record.class.clone()),
        reason: over.and_then(|record| said(&record.reason)),
        trouble: met.and_then(|record| said(&record.reason)),
        confidence: over.and_then(|record| record.confidence),
        failed_checks: over.map(|record| words(&record.failed_checks)).unwrap_or_default(),
        calls: record.map_or(0, |record| record.calls),
        cost: record.map_or(0.0, |record| record.cost),
        files: over.map(files).unwrap_or_default(),
    }
}

/// The files that a job left: digests by path.
pub(super) fn files(record: &Record) -> BTreeMap<String, String> {
    let whole = record.files.iter().map(|(name, digest)| (name.clone(), digest.to_string()));
    let named = [("trace", TRACE), ("attestation", STATEMENT), ("reason", REASON)];
    let named = named
        .into_iter()
        .filter_map(|(what, name)| Some((name.to_owned(), record.digests.get(what)?.to_string())));
    whole.chain(named).collect()
}

/// Words without the folders that files which were sent lie in.
fn unplaced(words: &str, inputs: &Path) -> String {
    let place = format!("{}{}", inputs.display(), std::path::MAIN_SEPARATOR);
    let mut parts = words.split(&*place);
    let mut told = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let mut folders = part.splitn(3, std::path::MAIN_SEPARATOR);
        let (_, digest, rest) = (folders.next(), folders.next(), folders.next());
        match (digest, rest) {
            (Some(digest), Some(rest)) if digest.len() == DIGEST => told.push_str(rest),
            _ => told.push_str(part),
        }
    }
    told
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_folder_of_the_service_stands_in_what_it_says() {
        let digest = "a1".repeat(32);
        let said =
            format!("/srv/jobs/inputs/ann/{digest}/file: no photo, as is /srv/jobs/inputs/x");
        let inputs = Path::new("/srv/jobs/inputs");
        assert_eq!(unplaced(&said, inputs), "file: no photo, as is x");
    }

    #[test]
    fn a_job_that_met_a_passing_trouble_waits_and_says_which() {
        let mut record = Record::new("ann.1", Ended::Failed);
        (record.class, record.reason) = (Some("budget".into()), Some("spent".into()));
        let told = job(("1", 9), Some(&record), None, Path::new("/x"));
        assert_eq!((told.state, told.trouble.as_deref()), (JobState::Queued, Some("spent")));
        assert_eq!((told.reason, told.class.as_deref()), (None, Some("budget")));
        record.class = Some("geometry".into());
        let told = job(("1", 9), Some(&record), Some(Running::default()), Path::new("/x"));
        assert_eq!((told.state, told.reason.as_deref()), (JobState::Failed, Some("spent")));
    }
}
