//! How sure an asset is of itself: what its `asset.json` and its verdict say.

use serde_json::Value;
use sim_check::{Status, Verdict};

use crate::stages::bundle::Files;

/// The file that says it.
const FILE: &str = "asset.json";
/// The checks whose findings are doubts about what the asset is.
const DOUBTS: [&str; 7] = ["R1", "R2", "R3", "R4", "R5", "R6", "R7"];

/// How likely every part and joint of an asset is right, 0 to 1; none where it does not say.
pub fn confidence(files: &Files) -> Option<f64> {
    let described: Value = serde_json::from_slice(files.get(FILE)?).ok()?;
    described.get("confidence")?.get("value")?.as_f64()
}

/// What is doubtful about an asset, a finding each, in the order of the profile.
pub fn doubts(verdict: &Verdict) -> Vec<&str> {
    let checks = DOUBTS.iter().filter_map(|id| verdict.check(id));
    let found = checks.filter(|check| check.status == Status::Fail);
    found.flat_map(|check| check.evidence.iter().map(String::as_str)).collect()
}

/// Why an asset is not as sure as is asked for, in a line; none if it is, or nothing is asked for.
pub fn too_unsure(said: Option<f64>, asked: Option<f64>) -> Option<String> {
    let asked = asked?;
    match said {
        Some(said) if said >= asked => None,
        Some(said) => Some(format!("confidence {said:.2}, below {asked}")),
        None => Some(format!("the asset does not say how sure it is, asked for {asked}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_an_asset_says_of_itself_is_found_and_silence_is_never_enough() {
        let file = |text: &str| Files::from([(FILE.to_owned(), text.as_bytes().to_vec())]);
        let said = file(r#"{"confidence": {"value": 0.75, "origin": "model"}}"#);
        assert_eq!(confidence(&said), Some(0.75));
        assert_eq!(confidence(&file("{}")), None);
        assert_eq!(too_unsure(Some(0.75), Some(0.75)), None);
        assert_eq!(too_unsure(Some(0.75), Some(0.9)).unwrap(), "confidence 0.75, below 0.9");
        assert!(too_unsure(None, Some(0.1)).is_some() && too_unsure(None, None).is_none());
    }
}
