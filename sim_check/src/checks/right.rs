//! Whether an asset is right, by what its sidecar says of how sure it is (R1 to R4), by where joints are shown
//! (R5), and by what lies beside what (R6, R7). None of them lowers a tier: what nobody is sure of may be sound.

mod beyond;
mod pieces;
mod spread;

use serde_json::Value;

use super::description::{FILE_NAME, entries};
use crate::checks::study::Study;
use crate::profile::bounds::{AJAR, PIECE, STRAY, SURE, UNSURE};
use crate::robot::{Joint, Motion, Robot};
use crate::verdict::Check;

/// All of them, for an asset with a sidecar.
pub(super) fn checks(sidecar: &Value, study: &Study) -> Vec<Check> {
    let links: Vec<(&str, &Value)> = entries(sidecar, "links").into_iter().collect();
    let joints: Vec<(&str, &Value)> = entries(sidecar, "joints").into_iter().collect();
    let mut checks = if links.iter().any(|(_, entry)| entry.get("confidence").is_some()) {
        vec![
            sure("R1", ("link", &links), [Some("labels"), None]),
            sure("R2", ("joint", &joints), [Some("axis"), Some("line")]),
            sure("R3", ("joint", &joints), [None, Some("way")]),
            doubtful_pieces(&links),
        ]
    } else {
        let silent = || format!("{FILE_NAME} does not say how sure it is");
        ["R1", "R2", "R3", "R4"].map(|id| Check::unknown(id, silent())).to_vec()
    };
    checks.extend([shown(study.robot), pieces::pieces(study), beyond::beyond(study)]);
    checks
}

/// How sure the least sure is, and which are doubtful, by the least of two numbers of each: one that must be
/// there, and one that may. What is no probability leaves all unknown.
fn sure(id: &str, (what, all): (&str, &[(&str, &Value)]), [must, may]: [Option<&str>; 2]) -> Check {
    let mut said: Vec<(String, f64)> = Vec::new();
    for (name, entry) in all {
        let Some(told) = entry.get("confidence") else { continue };
        let mut least: Option<f64> = None;
        for key in must.iter().chain(&may) {
            match told.get(key).map(probability) {
                Some(Some(chance)) => least = Some(least.map_or(chance, |l| l.min(chance))),
                None if Some(*key) != must => {}
                _ => {
                    let why = format!("{FILE_NAME}: {what} `{name}` has no probability as `{key}`");
                    return Check::unknown(id, why);
                }
            }
        }
        said.extend(least.map(|least| (format!("{what} `{name}`"), least)));
    }
    let least = said.iter().map(|(_, chance)| *chance).reduce(f64::min);
    let doubtful = said.iter().filter(|(_, chance)| *chance < SURE);
    let told = doubtful.map(|(what, chance)| format!("{what}: right with probability {chance:.2}"));
    let check = Check::from_faults(id, told.collect::<Vec<_>>());
    match least {
        Some(least) => check.value(least),
        // Where nothing moves there is no joint to be sure of.
        None => check,
    }
}

/// A number of the sidecar that is a probability.
fn probability(number: &Value) -> Option<f64> {
    number.get("value")?.as_f64().filter(|p| (0.0..=1.0).contains(p))
}

/// R4: pieces that may be another link's.
fn doubtful_pieces(links: &[(&str, &Value)]) -> Check {
    let number = |doubt: &Value, key: &str| doubt.get(key)?.get("value")?.as_f64();
    let piece = |(name, entry): &(&str, &Value)| {
        let doubt = entry.get("confidence")?.get("doubt")?;
        let (chance, share) = (number(doubt, "chance")?, number(doubt, "share")?);
        let other = doubt.get("other").and_then(Value::as_str).unwrap_or_default();
        let at: Option<Vec<f64>> = doubt
            .get("at")
            .and_then(|at| at.get("value")?.as_array())
            .map(|at| at.iter().filter_map(Value::as_f64).collect());
        let at = match at.as_deref() {
            Some([x, y, z]) => format!(" near {x:.3} {y:.3} {z:.3} m"),
            _ => String::new(),
        };
        let share_told = 100.0 * share;
        let told = format!(
            "link `{name}`: {share_told:.0} % of it{at} is of `{other}` with probability {chance:.2}"
        );
        let labels = number(entry.get("confidence")?, "labels")?;
        (share >= PIECE && labels < UNSURE).then_some((chance, told))
    };
    let pieces: Vec<(f64, String)> = links.iter().filter_map(piece).collect();
    let most = pieces.iter().map(|(chance, _)| *chance).fold(0.0, f64::max);
    let faults = pieces.into_iter().filter(|(chance, _)| *chance >= STRAY).map(|p| p.1);
    Check::from_faults("R4", faults.collect::<Vec<_>>()).value(most)
}

/// R5: joints that are shown neither at an end of their range nor about its middle.
fn shown(robot: &Robot) -> Check {
    let place = |joint: &Joint| {
        let limit =
            joint.limit.filter(|_| joint.kind.moves() && joint.kind != Motion::Continuous)?;
        let span = limit.upper - limit.lower;
        let place = (-limit.lower).min(limit.upper) / span;
        (span > 0.0 && place.is_finite()).then_some((joint.name.clone(), place.max(0.0)))
    };
    let places: Vec<(String, f64)> = robot.joints.iter().filter_map(place).collect();
    if places.is_empty() {
        return Check::pass("R5").value(0.0);
    }
    let is_ajar = |place: f64| (AJAR.0..AJAR.1).contains(&place);
    let ajar = places.iter().filter(|(_, place)| is_ajar(*place));
    let most = ajar.clone().map(|(_, place)| *place).fold(0.0, f64::max);
    let told = ajar.map(|(name, place)| {
        format!("joint `{name}`: shown {:.0} % of its range from its nearer end", 100.0 * place)
    });
    Check::from_faults("R5", told.collect::<Vec<_>>()).value(most)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::CheckOptions;
    use crate::read::load::from_text;
    use crate::verdict::Status;

    fn robot(lower: f64) -> Robot {
        let link = |name: &str| {
            let shape = "<geometry><box size=\"1 1 1\"/></geometry>";
            format!(
                r#"<link name="{name}"><visual>{shape}</visual><collision>{shape}</collision></link>"#
            )
        };
        let text = format!(
            r#"<robot name="r">{}{}<joint name="hinge" type="revolute"><parent link="body"/>
            <child link="door"/><axis xyz="0 0 1"/>
            <limit lower="{lower}" upper="1" effort="1" velocity="1"/></joint></robot>"#,
            link("body"),
            link("door")
        );
        from_text(&text, ".".as_ref(), &CheckOptions::default()).robot.unwrap()
    }

    fn number(value: f64) -> Value {
        json!({"value": value, "origin": "model"})
    }

    fn told(sidecar: &Value, lower: f64) -> Vec<(String, Status, Option<f64>, Vec<String>)> {
        let robot = robot(lower);
        let all = checks(sidecar, &Study::new(&robot)).into_iter();
        all.map(|c| (c.id, c.status, c.value, c.evidence)).collect()
    }

    #[test]
    fn what_is_doubtful_is_named_with_its_probability_and_place() {
        let doubt = json!({"other": "body", "chance": number(0.45), "share": number(0.5),
            "at": {"value": [0.1, 0.2, 0.3], "origin": "model"}});
        let sidecar = json!({
            "links": [{"name": "body", "confidence": {"labels": number(0.9)}},
                {"name": "door", "confidence": {"labels": number(0.4), "doubt": doubt}}],
            "joints": [{"name": "hinge", "confidence": {"axis": number(0.8), "line": number(0.3),
                "way": number(0.2), "joint": number(0.2)}}],
        });
        let told = told(&sidecar, -0.2);
        let ids: Vec<&str> = told.iter().map(|t| t.0.as_str()).collect();
        assert_eq!(ids, ["R1", "R2", "R3", "R4", "R5", "R6", "R7"]);
        assert!(told[..5].iter().all(|t| t.1 == Status::Fail), "{told:?}");
        let values: Vec<f64> = told[..5].iter().map(|t| t.2.unwrap()).collect();
        assert_eq!(values[..4], [0.4, 0.3, 0.2, 0.45]);
        assert!((values[4] - 0.2 / 1.2).abs() < 1e-12);
        assert!(told[0].3[0].contains("`door`") && told[3].3[0].contains("0.100 0.200 0.300"));
    }

    #[test]
    fn what_is_no_probability_is_unknown_and_never_a_pass() {
        for wrong in [json!("sure"), json!(1.5), json!(null), json!(-0.1)] {
            let wrong = json!({"value": wrong, "origin": "model"});
            let sidecar = json!({
                "links": [{"name": "door", "confidence": {"labels": wrong}}],
                "joints": [{"name": "hinge", "confidence": {"axis": wrong, "way": wrong}}],
            });
            let told = told(&sidecar, 0.0);
            assert!(told[..3].iter().all(|t| t.1 == Status::Unknown), "{told:?}");
        }
        let empty = json!({"links": [{"name": "door", "confidence": {}}],
            "joints": [{"name": "hinge", "confidence": {}}]});
        let status: Vec<Status> = told(&empty, 0.0).iter().map(|t| t.1).collect();
        assert_eq!(status[..2], [Status::Unknown; 2]);
    }

    #[test]
    fn what_is_sure_passes_and_silence_is_unknown() {
        let sidecar = json!({
            "links": [{"name": "door", "confidence": {"labels": number(0.9)}}],
            "joints": [{"name": "hinge", "confidence": {"axis": number(1.0), "way": number(0.7)}}],
        });
        assert!(told(&sidecar, -1.0).iter().all(|t| t.1 == Status::Pass), "{sidecar}");
        let silent = json!({"links": [{"name": "door"}], "joints": [{"name": "hinge"}]});
        let status: Vec<Status> = told(&silent, 0.0).iter().map(|t| t.1).collect();
        assert_eq!(status[..4], [Status::Unknown; 4]);
        assert_eq!(status[4..], [Status::Pass; 3]);
    }
}
