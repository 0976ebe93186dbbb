//! What one check found of each link or joint, and the check made of it.

use super::part::{Part, Parts};
use crate::verdict::{Check, figure};

/// A finding about one link or joint: how far it goes (1 is the bound), the figure, the words.
pub(super) struct Finding {
    pub(super) severity: f64,
    pub(super) value: f64,
    pub(super) unit: &'static str,
    pub(super) words: String,
}

/// The worst finding gives the value; those beyond the bound (severity > 1) are the evidence,
/// worst first. `unread` parts make the check unknown unless it fails anyway.
pub(super) fn judged(id: &str, mut findings: Vec<Finding>, unread: Vec<String>) -> Check {
    findings.sort_by(|a, b| b.severity.total_cmp(&a.severity));
    let worst = findings.first().map(|f| (f.value, f.unit));
    let broken: Vec<String> = findings
        .into_iter()
        .filter(|f| f.severity.is_nan() || f.severity > 1.0)
        .map(|f| f.words)
        .collect();
    let check = if broken.is_empty() && !unread.is_empty() {
        Check::unknown(id, "some geometry could not be read").evidences(unread)
    } else {
        Check::from_faults(id, broken)
    };
    match worst {
        Some((value, unit)) => check.value(value).unit(unit),
        None => check,
    }
}

/// Why a link's geometry is not all there, link by link.
pub(super) fn unread(parts: &Parts) -> Vec<String> {
    let told = |p: &Part| p.unread().map(|reason| format!("link `{}`: {reason}", p.link.name));
    parts.parts.iter().filter_map(told).collect()
}

/// Millimetres with four digits.
pub(super) fn mm(metres: f64) -> String {
    format!("{} mm", figure(metres * 1e3))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verdict::Status;

    fn finding(severity: f64, words: &str) -> Finding {
        Finding { severity, value: 10.0 * severity, unit: "m", words: words.into() }
    }

    #[test]
    fn the_worst_finding_gives_the_value_and_the_broken_ones_the_words() {
        let found = vec![finding(0.5, "fine"), finding(3.0, "worst"), finding(2.0, "bad")];
        let check = judged("G3", found, vec![]);
        assert_eq!((check.status, check.value), (Status::Fail, Some(30.0)));
        assert_eq!(check.evidence, ["worst", "bad"]);
    }

    #[test]
    fn what_is_no_number_breaks_the_rule_and_what_was_not_read_leaves_it_open() {
        assert_eq!(judged("G3", vec![finding(f64::NAN, "lost")], vec![]).status, Status::Fail);
        let unread = || vec!["link `a`: no file".to_owned()];
        assert_eq!(
            judged("G3", vec![finding(1.0, "at the bound")], unread()).status,
            Status::Unknown
        );
        assert_eq!(judged("G3", vec![finding(1.1, "beyond")], unread()).status, Status::Fail);
        assert_eq!(judged("G3", vec![], vec![]).status, Status::Pass);
    }

    #[test]
    fn lengths_are_said_in_millimetres() {
        assert_eq!([mm(0.0123456), mm(2.0), mm(0.0)], ["12.35 mm", "2000 mm", "0 mm"]);
    }
}
