//! What MJCF says and means.

use crate::find::place::at;
use crate::read::mjcf::Mjcf;
use crate::read::tree::Element;
use crate::rule::Place;

/// A range in radians is within a turn; degrees usually are not. The slack is for `6.2832`.
const TURN: f64 = std::f64::consts::TAU + 0.01;

fn pair(element: &Element, attribute: &str) -> Option<[f64; 2]> {
    let words = element.get(attribute)?.split_whitespace();
    let numbers: Vec<f64> = words.map_while(|w| w.parse().ok()).collect();
    <[f64; 2]>::try_from(numbers).ok()
}

/// Hinges with ranges that look like radians in a file that reads degrees.
pub(crate) fn degrees(mjcf: &Mjcf) -> Vec<Place> {
    let told = mjcf.compiler("angle").is_some() || mjcf.is_defaulted("joint", &["type"]);
    if told || mjcf.is_part() {
        return Vec::new();
    }
    let hinges = mjcf.placed("joint").filter(|j| j.get("type").is_none_or(|t| t == "hinge"));
    let small = hinges.filter_map(|j| {
        let [low, high] = pair(j, "range")?;
        let most = low.abs().max(high.abs());
        (most > 0.0 && most <= TURN).then(|| (j, format!("range {low} .. {high}")))
    });
    small.map(|(j, found)| at("joint", &j.name(), j.line, &found)).collect()
}

/// Ranges whose ends are equal, which nothing says to be limited.
pub(crate) fn range_empty(mjcf: &Mjcf) -> Vec<Place> {
    let joints = mjcf.placed("joint").filter(|j| j.get("limited").is_none_or(|l| l == "auto"));
    let empty = joints.filter(|j| pair(j, "range").is_some_and(|[a, b]| a == 0.0 && b == 0.0));
    empty.map(|j| at("joint", &j.name(), j.line, "range 0 0")).collect()
}

/// Geoms that touch nothing and weigh all the same.
pub(crate) fn visual_mass(mjcf: &Mjcf) -> Vec<Place> {
    let weights = ["mass", "density"];
    let told = mjcf.compiler("inertiagrouprange").is_some()
        || mjcf.compiler("inertiafromgeom") == Some("false")
        || mjcf.is_defaulted("geom", &weights);
    if told || mjcf.is_part() {
        return Vec::new();
    }
    let mut places = Vec::new();
    for body in mjcf.placed("body") {
        if mjcf.children(body).any(|e| e.tag == "inertial") {
            continue;
        }
        for geom in mjcf.children(body).filter(|e| e.tag == "geom") {
            let zero = |name| geom.get(name).is_some_and(|v| v.trim() == "0");
            let is_seen_only = zero("contype") && zero("conaffinity");
            if is_seen_only && weights.iter().all(|w| geom.get(w).is_none()) {
                places.push(at(
                    "geom",
                    &geom.name(),
                    geom.line,
                    &format!("in body {}", body.name()),
                ));
            }
        }
    }
    places
}

/// Ranges in a file that says that a range alone limits nothing.
pub(crate) fn autolimits_off(mjcf: &Mjcf) -> Vec<Place> {
    let off = mjcf.compiler("autolimits") == Some("false");
    if !off || mjcf.is_defaulted("joint", &["limited"]) || mjcf.is_part() {
        return Vec::new();
    }
    let bare =
        mjcf.placed("joint").filter(|j| j.get("range").is_some() && j.get("limited").is_none());
    bare.map(|j| at("joint", &j.name(), j.line, "range without limited")).collect()
}

/// Inertials that the compiler option passes over.
pub(crate) fn inertial_overruled(mjcf: &Mjcf) -> Vec<Place> {
    if mjcf.compiler("inertiafromgeom") != Some("true") {
        return Vec::new();
    }
    let mut places = Vec::new();
    for body in mjcf.placed("body") {
        let has_geom = mjcf.children(body).any(|e| e.tag == "geom");
        let inertial = mjcf.children(body).find(|e| e.tag == "inertial");
        if let (true, Some(inertial)) = (has_geom, inertial) {
            places.push(at("inertial", &body.name(), inertial.line, ""));
        }
    }
    places
}
