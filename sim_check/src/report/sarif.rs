//! Verdicts as SARIF 2.1.0, which code hosts show beside the lines of a model.
//!
//! A finding is a result. What keeps a model below the tier that is asked of it is an error, unknown checks
//! with it; what fails beyond that a warning; what a person should look at a note. A waived finding is
//! suppressed and says why.
//!
//! ```
//! use sim_check::report::{Item, sarif};
//! use sim_check::{CheckOptions, Tier, undecided};
//! let verdict = undecided("stopped after 60 s", &CheckOptions::default());
//! let item = Item { name: "robots/door.urdf", verdict: &verdict, asked: Tier::Static, source: None };
//! let log: serde_json::Value = serde_json::from_str(&sarif::report(&[item])).unwrap();
//! assert_eq!(log["runs"][0]["results"][0]["level"], "error");
//! ```

use serde_json::{Value, json};

use super::answer::known;
use super::source::Place;
use super::{Item, expectation};
use crate::profile::explain::{Explanation, explain};
use crate::profile::{RULES, Severity};
use crate::verdict::{Check, Status};

const SCHEMA: &str = "https://json.schemastore.org/sarif-2.1.0.json";
/// Characters that stand in a path of a URI as they are (RFC 3986, 3.3), and the slash.
const PLAIN: &[u8] = b"-._~!$&'()*+,;=@/";

/// The report; the same verdicts give the same bytes. Ends with a newline.
pub fn report(items: &[Item<'_>]) -> String {
    let described = RULES.iter().filter_map(|rule| explain(rule.id));
    let rules: Vec<Value> = described.map(|told| rule(&told)).collect();
    let results: Vec<Value> = items.iter().flat_map(results).collect();
    let log = json!({
        "$schema": SCHEMA,
        "version": "2.1.0",
        "runs": [{
            "tool": {"driver": {
                "name": "kinfold",
                "semanticVersion": env!("CARGO_PKG_VERSION"),
                "rules": rules,
            }},
            "columnKind": "unicodeCodePoints",
            "results": results,
        }],
    });
    let text = serde_json::to_string_pretty(&log).unwrap_or_default();
    guard::text::json(&text).into_owned() + "\n"
}

fn rule(told: &Explanation) -> Value {
    let mend: Vec<&str> = told.mend.iter().map(|(_, remedy)| *remedy).collect();
    let level = if told.rule.severity == Severity::Error { "error" } else { "warning" };
    json!({
        "id": told.rule.id,
        "shortDescription": {"text": told.rule.words},
        "fullDescription": {"text": told.why},
        "help": {"text": format!("Measured: {}\nMend: {}", told.how, mend.join("; or "))},
        "defaultConfiguration": {"level": level},
        "properties": {"tier": told.rule.tier.name()},
    })
}

fn results(item: &Item<'_>) -> Vec<Value> {
    let mut all = Vec::new();
    for check in item.told() {
        let whole = [String::new()];
        let findings = if check.evidence.is_empty() { &whole[..] } else { &check.evidence };
        all.extend(findings.iter().map(|finding| result(item, check, finding)));
    }
    all
}

fn result(item: &Item<'_>, check: &Check, finding: &str) -> Value {
    let place = item.source.map_or(Place { line: 1, column: 1 }, |s| s.place_of(finding));
    let is_over = |c: &Check| c.waived.is_none() && item.is_blocking(c);
    let level = match check.status {
        Status::Warn | Status::Pass => "note",
        _ if is_over(check) => "error",
        _ => "warning",
    };
    let colon = if finding.is_empty() { "" } else { ": " };
    let judged = if check.status == Status::Unknown { "not judged, " } else { "" };
    let mend = match check.status {
        Status::Fail => explain(&check.id).map(|told| told.remedy(&check.evidence)),
        _ => None,
    };
    let mend = mend.filter(|m| !m.is_empty()).map(|m| format!(". Mend: {m}"));
    let text = format!(
        "{judged}{}{colon}{finding} ({}){}",
        check.rule,
        expectation(check),
        mend.unwrap_or_default()
    );
    let own = format!("{}\n{}\n{}", item.name, check.id, known(finding));
    let print = blake3::hash(own.as_bytes()).to_hex();
    let mut result = json!({
        "ruleId": check.id,
        "ruleIndex": RULES.iter().position(|r| r.id == check.id),
        "level": level,
        "message": {"text": text},
        "locations": [{"physicalLocation": {
            "artifactLocation": location(item.name),
            "region": {"startLine": place.line, "startColumn": place.column},
        }}],
        "partialFingerprints": {"kinfoldFinding/v1": &print[..32]},
    });
    if let Some(why) = &check.waived {
        result["suppressions"] = json!([{"kind": "external", "justification": why}]);
    }
    result
}

/// A path as SARIF names files: relative ones under the root of the sources.
fn location(name: &str) -> Value {
    let name = name.replace('\\', "/");
    let name = name.strip_prefix("./").unwrap_or(&name);
    let mut uri = String::new();
    for byte in name.bytes() {
        if byte.is_ascii_alphanumeric() || PLAIN.contains(&byte) {
            uri.push(char::from(byte));
        } else {
            uri.push_str(&format!("%{byte:02X}"));
        }
    }
    if name.starts_with('/') {
        return json!({"uri": format!("file://{uri}")});
    }
    json!({"uri": uri, "uriBaseId": "%SRCROOT%"})
}

#[cfg(test)]
mod tests {
    use super::super::source::Source;
    use super::*;
    use crate::{CheckOptions, Tier, Verdict, undecided};

    fn failing() -> Verdict {
        let mut verdict = undecided("not run", &CheckOptions::default());
        for check in &mut verdict.checks {
            *check = Check::pass(&check.id);
        }
        for (id, finding) in [("C1", "`door` and `body` overlap by 3 mm"), ("S1", "it flew off")] {
            let check = verdict.checks.iter_mut().find(|c| c.id == id).unwrap();
            *check = Check::fail(id).evidence(finding);
        }
        verdict
    }

    fn results(verdict: &Verdict, name: &str, source: Option<&Source>) -> Vec<Value> {
        let item = Item { name, verdict, asked: Tier::Kinematic, source };
        let log: Value = serde_json::from_str(&report(&[item])).unwrap();
        log["runs"][0]["results"].as_array().unwrap().clone()
    }

    #[test]
    fn a_finding_stands_at_its_link_and_only_what_is_asked_is_an_error() {
        let source = Source::read("<robot name=\"r\">\n  <link name=\"door\"/></robot>");
        let found = results(&failing(), "a b/dör.urdf", Some(&source));
        let place = &found[0]["locations"][0]["physicalLocation"];
        assert_eq!(place["artifactLocation"]["uri"], "a%20b/d%C3%B6r.urdf");
        assert_eq!(place["region"], json!({"startLine": 2, "startColumn": 3}));
        let levels: Vec<_> =
            found.iter().map(|r| (r["ruleId"].clone(), r["level"].clone())).collect();
        assert_eq!(levels, [("C1".into(), "error".into()), ("S1".into(), "warning".into())]);
    }

    #[test]
    fn a_finding_keeps_its_fingerprint_when_its_figures_change() {
        let print = |overlap: &str| {
            let mut verdict = failing();
            let c1 = verdict.checks.iter_mut().find(|c| c.id == "C1").unwrap();
            c1.evidence[0] = format!("`door` and `body` overlap by {overlap} mm");
            results(&verdict, "r.urdf", None)[0]["partialFingerprints"].clone()
        };
        assert_eq!(print("3"), print("4.5"));
    }

    #[test]
    fn a_waived_finding_is_suppressed_and_says_why() {
        let mut verdict = failing();
        let c1 = verdict.checks.iter_mut().find(|c| c.id == "C1").unwrap();
        c1.waived = Some("a pin in its hole".into());
        let found = results(&verdict, "/x/r.urdf", None);
        assert_eq!(found[0]["suppressions"][0]["justification"], "a pin in its hole");
        assert_eq!(
            found[0]["locations"][0]["physicalLocation"]["artifactLocation"]["uri"],
            "file:///x/r.urdf"
        );
    }
}
