//! What clients will do with the checked files, beside their verdicts.

use std::fmt::Write as _;
use std::path::Path;

use forecast::{Client, Finding, Forecast, Outside, Place, Severity, Source};
use guard::text::shown;

/// Places of a finding that are told where nobody asks for all.
const SHOWN: usize = 3;

/// What is forecast of one file, or why nothing is.
pub(super) type Of = Result<Vec<Forecast>, String>;

/// Asks the rules about a file; nothing is started, and nothing outside its folder read unless
/// `outside` allows it.
pub(super) fn of(file: &Path, clients: &[Client], outside: bool) -> Of {
    let outside = if outside { Outside::Allowed } else { Outside::Refused };
    forecast::forecast(file, clients, outside).map_err(|e| e.to_string())
}

/// What keeps a file from meaning the same to all these clients, in a line; none where nothing is known to.
pub(super) fn obstacles(of: &Of) -> Option<String> {
    let forecasts = match of {
        Ok(forecasts) => forecasts,
        Err(why) => return Some(format!("no forecast: {why}")),
    };
    let told = |forecast: &Forecast| {
        let count = |s: Severity| forecast.findings.iter().filter(|f| f.severity == s).count();
        let words = match (forecast.rules, count(Severity::Refused), count(Severity::Behaves)) {
            (0, _, _) => "no rules for this format".to_owned(),
            (_, 0, 0) => return None,
            (_, 0, some) => format!("{some} rules say that it behaves otherwise"),
            (_, some, _) => format!("{some} rules say that it is refused"),
        };
        Some(format!("{}: {words}", forecast.client.label()))
    };
    let all: Vec<String> = forecasts.iter().filter_map(told).collect();
    (!all.is_empty()).then(|| all.join("; "))
}

/// A block for each client, worst first.
pub(super) fn told(forecasts: &[Forecast], verbose: bool) -> String {
    let mut out = String::new();
    for forecast in forecasts {
        let label = forecast.client.label();
        let _ = match (forecast.rules, forecast.findings.len()) {
            (0, _) => writeln!(out, "\n{label}: not known, there are no rules for this format"),
            (rules, 0) => writeln!(out, "\n{label}: none of {rules} rules applies"),
            (rules, some) => writeln!(out, "\n{label}: {some} of {rules} rules apply"),
        };
        forecast.findings.iter().for_each(|finding| block(&mut out, finding, verbose));
    }
    out
}

/// A finding: a line of a note, and for the rest where, what to do, and how it is known.
fn block(out: &mut String, finding: &Finding, verbose: bool) {
    let _ = writeln!(out, "{:<8} {}", finding.severity.name(), finding.sentence);
    if finding.severity == Severity::Note && !verbose {
        return;
    }
    let most = if verbose { finding.places.len() } else { SHOWN };
    for place in finding.places.iter().take(most) {
        let _ = writeln!(out, "{:9}{}", "", shown(&at(place)));
    }
    let left = finding.count.saturating_sub(most);
    if left > 0 {
        let _ = writeln!(out, "{:9}and {left} more", "");
    }
    let how = match finding.source {
        Source::Measured(_) => "measured with",
        Source::Read(_) => "read of",
    };
    let _ = writeln!(out, "{:9}mend: {}", "", finding.remedy);
    let _ = writeln!(out, "{:9}{}, {how} {}", "", finding.rule, finding.version);
}

fn at(place: &Place) -> String {
    let name = if place.name.is_empty() { String::new() } else { format!(" `{}`", place.name) };
    let found = if place.found.is_empty() { String::new() } else { format!(": {}", place.found) };
    format!("line {}, {}{name}{found}", place.line, place.element)
}
