//! What the sidecar `asset.json` says about the asset: hashes, sources, labels, licences
//! (F4, M7, L1, L2, P1–P3).

use std::collections::BTreeSet;
use std::path::Path;

use guard::files::Refused;
use guard::folder::Folder;
use serde_json::Value;

use super::description::{FILE_NAME, entries, read};
use super::right;
use super::study::Study;
use crate::options::Provenance;
use crate::read::meshes::{Outside, broken_path_rule, caps, in_words};
use crate::robot::{Geometry, Joint, Link, Motion, Robot, Shape};
use crate::verdict::Check;

/// Where a number may come from.
const ORIGINS: [&str; 5] = ["measured", "model", "vlm", "user", "default"];
/// Largest relative difference between a number in the sidecar and the same in the URDF.
const SAME: f64 = 1e-6;

/// All checks that need the sidecar.
pub(crate) fn checks(study: &Study, urdf: &Path, provenance: &Provenance) -> Vec<Check> {
    let robot = study.robot;
    let folder = urdf.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let folder = Folder::open(folder, caps()).map_err(|refused| in_words(&refused));
    let sidecar = folder.as_ref().map_err(String::clone).and_then(read);
    let with = |id: &str, check: &dyn Fn(&Value) -> Check| match &sidecar {
        Ok(sidecar) => check(sidecar),
        Err(reason) => Check::unknown(id, reason.clone()),
    };
    // Of who says nothing of himself nobody knows how sure he is.
    let right = sidecar.as_ref().map(|s| right::checks(s, study)).unwrap_or_default();
    let mut checks = vec![
        with("F4", &|s| match &folder {
            Ok(folder) => hashes(s, robot, urdf, folder),
            Err(reason) => Check::unknown("F4", reason.clone()),
        }),
        with("M7", &|s| mass_sources(s, robot)),
        with("L1", &|s| labels(s, robot)),
        with("L2", &|s| graspable(s, robot)),
        trace(provenance),
        with("P2", &|s| licences(s, provenance)),
        with("P3", &|s| sources(s, robot)),
    ];
    checks.extend(right);
    checks
}

/// F4: every listed file has its hash; the URDF and every mesh it names are listed.
fn hashes(sidecar: &Value, robot: &Robot, urdf: &Path, folder: &Folder) -> Check {
    let Some(files) = sidecar.get("files").and_then(Value::as_object) else {
        return Check::fail("F4").evidence(format!("{FILE_NAME} lists no files"));
    };
    let mut faults: Vec<String> = Vec::new();
    for (name, expected) in files {
        let expected = expected.as_str().unwrap_or_default().trim_start_matches("blake3:");
        let found = hash_of(folder, name);
        if found.as_deref() != Ok(expected) {
            let found = found.unwrap_or_else(|e| e);
            faults.push(format!("`{name}`: expected blake3 {expected}, found {found}"));
        }
    }
    let listed: BTreeSet<&str> = files.keys().map(|k| plain(k)).collect();
    let own = urdf.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let meshes = robot.links.iter().flat_map(|l| l.visuals.iter().chain(&l.collisions));
    let is_file = |s: &&Shape| matches!(s.geometry, Geometry::Mesh(_) | Geometry::Unread { .. });
    let mut needed: BTreeSet<String> = meshes.filter(is_file).map(|s| s.source.clone()).collect();
    needed.insert(own);
    let missing = needed.iter().filter(|n| !listed.contains(plain(n)));
    faults.extend(missing.map(|n| format!("`{n}` is not listed in {FILE_NAME}")));
    let count = faults.len() as f64;
    Check::from_faults("F4", faults).value(count)
}

fn plain(path: &str) -> &str {
    path.trim_start_matches("./")
}

/// The hash of a file of the package, under the rule and the bound of its meshes.
fn hash_of(folder: &Folder, name: &str) -> Result<String, String> {
    if let Some(rule) = broken_path_rule(name, Outside::Refused) {
        return Err(format!("a path that {rule}"));
    }
    let refused = |refused: Refused| match refused {
        refused if refused.is_absence() => "no such file".to_owned(),
        refused => format!("a file that {}", in_words(&refused)),
    };
    let file = folder.file(Path::new(name)).map_err(refused)?;
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(file).map_err(|e| refused(Refused::of(e)))?;
    Ok(hasher.finalize().to_hex().to_string())
}

/// The first entry of that key, at any depth, in key order.
fn find<'a>(value: &'a Value, key: &str) -> Option<&'a Value> {
    match value {
        Value::Object(map) => map.get(key).or_else(|| map.values().find_map(|v| find(v, key))),
        Value::Array(items) => items.iter().find_map(|v| find(v, key)),
        _ => None,
    }
}

/// What is wrong with a sourced number: absent, without a known origin, or not the URDF's.
fn source_fault(entry: Option<&Value>, key: &str, in_urdf: Option<f64>) -> Option<String> {
    let Some(number) = entry.and_then(|e| find(e, key)) else {
        return Some(format!("{key} is not listed"));
    };
    let origin = number.get("origin").and_then(Value::as_str);
    if !origin.is_some_and(|o| ORIGINS.contains(&o)) {
        return Some(format!("{key} has no origin (one of {})", ORIGINS.join(", ")));
    }
    let listed = number.get("value").and_then(Value::as_f64);
    match (listed, in_urdf) {
        (Some(a), Some(b)) if (a - b).abs() > SAME * a.abs().max(b.abs()) => {
            Some(format!("{key} is {a} in {FILE_NAME}, {b} in the URDF"))
        }
        _ => None,
    }
}

/// M7: every mass has a source, and is the URDF's.
fn mass_sources(sidecar: &Value, robot: &Robot) -> Check {
    let listed = entries(sidecar, "links");
    let with_mass = robot.links.iter().filter_map(|l| Some((l, l.inertial?)));
    let fault = |(link, inertial): (&Link, crate::robot::Inertial)| {
        let entry = listed.get(link.name.as_str()).copied();
        let fault = source_fault(entry, "mass", Some(inertial.mass))?;
        Some(format!("link `{}`: {fault}", link.name))
    };
    let faults: Vec<_> = with_mass.filter_map(fault).collect();
    let count = faults.len() as f64;
    Check::from_faults("M7", faults).value(count)
}

/// L1: every link with geometry has a text.
fn labels(sidecar: &Value, robot: &Robot) -> Check {
    let (listed, texts) = (entries(sidecar, "links"), entries(sidecar, "labels"));
    let text = |name: &str| {
        let own = listed.get(name).and_then(|e| e.get("label").or_else(|| e.get("text")));
        let text = own.or_else(|| texts.get(name).copied()).and_then(Value::as_str);
        text.is_some_and(|t| !t.trim().is_empty())
    };
    let bare = with_geometry(robot).filter(|l| !text(&l.name));
    let faults: Vec<_> = bare.map(|l| format!("link `{}` has no label", l.name)).collect();
    let count = faults.len() as f64;
    Check::from_faults("L1", faults).value(count)
}

fn with_geometry(robot: &Robot) -> impl Iterator<Item = &Link> {
    robot.links.iter().filter(|l| !l.visuals.is_empty() || !l.collisions.is_empty())
}

/// L2: optional, so a sidecar that says nothing leaves it open, and one that speaks passes.
fn graspable(sidecar: &Value, robot: &Robot) -> Check {
    let listed = entries(sidecar, "links");
    let flag = |l: &Link| find(listed.get(l.name.as_str())?, "graspable")?.as_bool();
    let flags: Vec<(&str, bool)> =
        with_geometry(robot).filter_map(|l| Some((l.name.as_str(), flag(l)?))).collect();
    if flags.is_empty() {
        return Check::unknown("L2", "no link says whether it is meant to be grasped");
    }
    let held: Vec<_> = flags.iter().filter(|f| f.1).map(|f| format!("`{}`", f.0)).collect();
    let told = if held.is_empty() { "none".to_owned() } else { held.join(", ") };
    Check::pass("L2").value(held.len() as f64).evidence(format!("to be grasped: {told}"))
}

/// P1: the caller has read the trace; here nobody can.
fn trace(provenance: &Provenance) -> Check {
    match &provenance.trace_faults {
        Some(faults) => Check::from_faults("P1", faults.clone()).value(faults.len() as f64),
        None => Check::unknown("P1", "no trace was given to be verified"),
    }
}

/// P2: every licence the sidecar lists is one the policy allows.
fn licences(sidecar: &Value, provenance: &Provenance) -> Check {
    let Some(allowed) = &provenance.allowed_licences else {
        return Check::unknown("P2", "no licence policy was given");
    };
    let mut found = Vec::new();
    for key in ["licences", "licenses"] {
        collect_texts(sidecar.get(key).unwrap_or(&Value::Null), &mut found);
    }
    if found.is_empty() {
        return Check::unknown("P2", format!("{FILE_NAME} lists no licences"));
    }
    let is_allowed = |l: &String| allowed.iter().any(|a| a.eq_ignore_ascii_case(l));
    let faults = found.iter().filter(|l| !is_allowed(l));
    let faults: Vec<_> = faults.map(|l| format!("licence `{l}` is not allowed")).collect();
    let count = faults.len() as f64;
    Check::from_faults("P2", faults).value(count)
}

/// Licence names: a text, a list of them, or objects with a `licence`.
fn collect_texts(value: &Value, found: &mut Vec<String>) {
    match value {
        Value::String(text) => found.push(text.clone()),
        Value::Array(items) => items.iter().for_each(|v| collect_texts(v, found)),
        Value::Object(map) => match map.get("licence").or_else(|| map.get("license")) {
            Some(own) => collect_texts(own, found),
            None => map.values().for_each(|v| collect_texts(v, found)),
        },
        _ => {}
    }
}

/// P3: every number of the URDF's physics stands in the sidecar with its origin, and every default
/// is named in the list of defaults.
fn sources(sidecar: &Value, robot: &Robot) -> Check {
    let mut faults = unsourced(sidecar, "");
    let links = entries(sidecar, "links");
    for link in robot.links.iter().filter(|l| l.inertial.is_some()) {
        let entry = links.get(link.name.as_str()).copied();
        let missing = ["mass", "inertia"].into_iter().filter_map(|k| source_fault(entry, k, None));
        faults.extend(missing.map(|f| format!("link `{}`: {f}", link.name)));
    }
    let joints = entries(sidecar, "joints");
    for joint in robot.joints.iter().filter(|j| j.kind.has_axis()) {
        let entry = joints.get(joint.name.as_str()).copied();
        let missing = numbers_of(joint).into_iter();
        let missing = missing.filter_map(|(key, value)| source_fault(entry, key, value));
        faults.extend(missing.map(|f| format!("joint `{}`: {f}", joint.name)));
    }
    let defaults = default_paths(sidecar, "");
    let list = sidecar.get("defaults").and_then(Value::as_array).into_iter().flatten();
    let listed: BTreeSet<&str> = list.filter_map(Value::as_str).collect();
    let unlisted = defaults.iter().filter(|d| !listed.contains(d.as_str()));
    faults.extend(unlisted.map(|d| format!("`{d}` is a default, but not in the list of defaults")));
    let count = faults.len() as f64;
    Check::from_faults("P3", faults)
        .value(count)
        .evidence(format!("{} numbers are defaults", defaults.len()))
}

fn numbers_of(joint: &Joint) -> Vec<(&'static str, Option<f64>)> {
    let limit = joint.limit;
    let dynamics = joint.dynamics;
    let bounded = limit.filter(|_| joint.kind != Motion::Continuous);
    let all = vec![
        ("axis", None),
        ("lower", bounded.map(|l| l.lower)),
        ("upper", bounded.map(|l| l.upper)),
        ("effort", limit.and_then(|l| l.effort)),
        ("velocity", limit.and_then(|l| l.velocity)),
        ("damping", dynamics.and_then(|d| d.damping)),
        ("friction", dynamics.and_then(|d| d.friction)),
    ];
    let endless = joint.kind == Motion::Continuous;
    all.into_iter().filter(|(key, _)| !(endless && ["lower", "upper"].contains(key))).collect()
}

/// Objects with a `value` but no known `origin`, by path.
fn unsourced(value: &Value, path: &str) -> Vec<String> {
    let origin = value.get("origin").and_then(Value::as_str);
    let bad = value.get("value").is_some() && !origin.is_some_and(|o| ORIGINS.contains(&o));
    let own = bad.then(|| format!("{path}: a value without origin"));
    own.into_iter().chain(below(path, value).flat_map(|(p, v)| unsourced(v, &p))).collect()
}

/// Paths like `links.door.density` of everything whose origin is `default`.
fn default_paths(value: &Value, path: &str) -> Vec<String> {
    let is_default = value.get("origin").and_then(Value::as_str) == Some("default");
    let own = is_default.then(|| path.to_owned());
    own.into_iter().chain(below(path, value).flat_map(|(p, v)| default_paths(v, &p))).collect()
}

/// What stands directly below a value, each with its path: a list's items go by their name, or by
/// their index.
fn below<'a>(
    path: &'a str,
    value: &'a Value,
) -> Box<dyn Iterator<Item = (String, &'a Value)> + 'a> {
    let at =
        move |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
    match value {
        Value::Object(map) => Box::new(map.iter().map(move |(k, v)| (at(k), v))),
        Value::Array(items) => Box::new(items.iter().enumerate().map(move |(i, v)| {
            let name = v.get("name").and_then(Value::as_str);
            (name.map_or_else(|| at(&i.to_string()), at), v)
        })),
        _ => Box::new(std::iter::empty()),
    }
}

#[cfg(test)]
mod tests {
    use super::super::description::SCHEMA;
    use super::*;
    use crate::options::CheckOptions;

    const URDF: &str = r#"<robot name="r"><link name="a"><inertial><mass value="2"/>
        <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
        <visual><geometry><box size="1 1 1"/></geometry></visual></link></robot>"#;

    fn sidecar() -> Value {
        serde_json::json!({
            "schema": SCHEMA,
            "defaults": ["links.a.mass"],
            "files": { "a.urdf": blake3::hash(URDF.as_bytes()).to_hex().to_string() },
            "licences": [{ "what": "mesh", "licence": "CC0-1.0" }],
            "links": [{ "name": "a", "label": "a box", "graspable": true,
                "confidence": { "labels": { "value": 0.9, "unit": "1", "origin": "model" } },
                "mass": { "value": 2.0, "unit": "kg", "origin": "default", "how": "table" },
                "inertia": { "value": 1.0, "unit": "kg m2", "origin": "measured" } }],
        })
    }

    /// The ids that do not hold when the sidecar is changed so.
    fn broken(test: &str, change: impl FnOnce(&mut Value)) -> Vec<String> {
        let folder =
            std::env::temp_dir().join(format!("kinfold-sidecar-{}-{test}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let urdf = folder.join("a.urdf");
        std::fs::write(&urdf, URDF).unwrap();
        let mut sidecar = sidecar();
        change(&mut sidecar);
        std::fs::write(folder.join(FILE_NAME), sidecar.to_string()).unwrap();
        let robot = crate::read::load::read(&urdf, &CheckOptions::default()).robot.unwrap();
        let allowed_licences = Some(vec!["cc0-1.0".into()]);
        let provenance = Provenance { trace_faults: Some(vec![]), allowed_licences };
        let checks = checks(&Study::new(&robot), &urdf, &provenance);
        std::fs::remove_dir_all(&folder).unwrap();
        checks.into_iter().filter(|c| !c.holds()).map(|c| c.id).collect()
    }

    #[test]
    fn a_whole_sidecar_satisfies_every_check() {
        assert_eq!(broken("whole", |_| {}), [""; 0]);
    }

    #[test]
    fn what_is_left_out_of_the_sidecar_is_missed() {
        let spoil = |name: &str, path: &str, value: Value| {
            broken(name, |s| *s.pointer_mut(path).unwrap() = value)
        };
        assert_eq!(spoil("hash", "/files/a.urdf", "00".into()), ["F4"]);
        assert_eq!(spoil("label", "/links/0/label", " ".into()), ["L1"]);
        assert_eq!(spoil("mass", "/links/0/mass/value", 3.into()), ["M7"]);
        assert_eq!(spoil("origin", "/links/0/mass/origin", "guess".into()), ["M7", "P3"]);
        assert_eq!(spoil("default", "/defaults", Value::Null), ["P3"]);
        assert_eq!(spoil("licence", "/licences/0/licence", "unknown".into()), ["P2"]);
        let all = ["F4", "M7", "L1", "L2", "P2", "P3"];
        assert_eq!(spoil("schema", "/schema", "other".into()), all);
    }
}
