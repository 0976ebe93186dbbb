//! A robot as the checker reads it, and its verdict, to what a page shows.

use std::collections::BTreeMap;

use object::{DVec3, Mesh};
use page::{Check, Inertial, Joint, Kind, Line, Link, Mimic, Scene, Status, Tier};
use serde_json::Value;
use sim_check::robot::{self, Motion, Robot, Shape};
use sim_check::verdict::Verdict;

use super::super::seen::surface;
use super::found::Finder;

/// The colour of a surface whose file gives none, beside one whose file does.
const PLAIN: [u8; 4] = [200, 200, 200, 255];

/// What a page is about.
pub struct Subject<'a> {
    /// What it is called.
    pub name: &'a str,
    /// Its links and joints; none if they could not be read.
    pub robot: Option<&'a Robot>,
    /// What was found about it; none if nobody checked it.
    pub verdict: Option<&'a Verdict>,
    /// The `asset.json` beside it, if there is one.
    pub sidecar: Option<&'a Value>,
    /// What else to say.
    pub notes: Vec<String>,
}

/// What a page shows of it.
pub fn scene(subject: &Subject) -> Scene {
    let facts = Facts::of(subject.sidecar);
    let mut notes = subject.notes.clone();
    let links =
        subject.robot.map(|r| r.links.iter().map(|l| link(l, &facts, &mut notes)).collect());
    let joints = subject.robot.map(|r| r.joints.iter().map(|j| joint(j, &facts)).collect());
    Scene {
        title: subject.name.to_owned(),
        tier: subject.verdict.map(tier),
        about: about(subject),
        notes,
        links: links.unwrap_or_default(),
        joints: joints.unwrap_or_default(),
        checks: subject.verdict.map(|v| checks(v, subject.robot)).unwrap_or_default(),
    }
}

/// What a sidecar says of links and joints, by name.
#[derive(Default)]
struct Facts(BTreeMap<(&'static str, String), Vec<Line>>);

impl Facts {
    fn of(sidecar: Option<&Value>) -> Self {
        let mut facts = BTreeMap::new();
        let wanted = [
            ("links", &["label", "material", "mass", "centre_of_mass"][..]),
            ("joints", &["axis", "lower", "upper", "limits", "effort", "damping", "friction"][..]),
        ];
        for (list, keys) in wanted {
            let all = sidecar.and_then(|s| s[list].as_array()).into_iter().flatten();
            for one in all {
                let Some(name) = one["name"].as_str() else { continue };
                let lines = keys.iter().filter_map(|key| fact(key, &one[*key])).collect();
                facts.insert((list, name.to_owned()), lines);
            }
        }
        Self(facts)
    }

    fn about(&self, list: &'static str, name: &str) -> Vec<Line> {
        self.0.get(&(list, name.to_owned())).cloned().unwrap_or_default()
    }
}

/// A number with where it comes from, or words.
fn fact(key: &str, value: &Value) -> Option<Line> {
    let label = key.replace('_', " ");
    if let Some(words) = value.as_str() {
        return Some(Line { label, text: words.to_owned() });
    }
    let (origin, how) = (value["origin"].as_str()?, value["how"].as_str().unwrap_or_default());
    let text = if how.is_empty() { origin.to_owned() } else { format!("{origin}: {how}") };
    Some(Line { label, text })
}

fn about(subject: &Subject) -> Vec<Line> {
    let line = |label: &str, text: String| Line { label: label.into(), text };
    let of_verdict = |v: &Verdict| {
        let mut lines = vec![line("Profile", v.profile.clone())];
        if !v.urdf_blake3.is_empty() {
            lines.push(line("File (BLAKE3)", v.urdf_blake3.clone()));
        }
        lines
    };
    let mut lines = subject.verdict.map(of_verdict).unwrap_or_default();
    if let Some(size) = subject.sidecar.map(|s| &s["size"]) {
        lines.extend(fact("Size from", size));
    }
    lines.push(line("Made by", format!("kinfold {}", env!("CARGO_PKG_VERSION"))));
    lines
}

fn tier(verdict: &Verdict) -> Tier {
    let place = |tier| sim_check::Tier::ALL.iter().position(|t| *t == tier).unwrap_or_default();
    Tier {
        name: verdict.tier.name().to_owned(),
        reached: [place(verdict.tier), place(verdict.asked)],
        profile: verdict.profile.clone(),
    }
}

fn checks(verdict: &Verdict, robot: Option<&Robot>) -> Vec<Check> {
    let finder = robot.map(Finder::new);
    let one = |check: &sim_check::Check| Check {
        id: check.id.clone(),
        rule: check.rule.clone(),
        status: status(check),
        figure: check.value.map(|v| figure(v, &check.unit)).unwrap_or_default(),
        bound: check.threshold.clone(),
        evidence: check.evidence.iter().map(|text| found(text, finder.as_ref())).collect(),
    };
    verdict.checks.iter().map(one).collect()
}

fn found(text: &str, finder: Option<&Finder>) -> page::Evidence {
    let plain = || page::Evidence { text: text.to_owned(), ..page::Evidence::default() };
    finder.map_or_else(plain, |f| f.find(text))
}

fn figure(value: f64, unit: &str) -> String {
    let text = if value == 0.0 || (1e-3..1e6).contains(&value.abs()) {
        let text = format!("{value:.3}");
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        format!("{value:.2e}")
    };
    format!("{text} {unit}").trim_end().to_owned()
}

fn status(check: &sim_check::Check) -> Status {
    match check.status {
        _ if check.waived.is_some() => Status::Waived,
        sim_check::Status::Pass => Status::Pass,
        sim_check::Status::Fail if check.counts_against() => Status::Fail,
        sim_check::Status::Unknown if check.counts_against() => Status::Unknown,
        _ => Status::Warn,
    }
}

fn link(link: &robot::Link, facts: &Facts, notes: &mut Vec<String>) -> Link {
    let mut surfaces = |shapes: &[Shape]| {
        shapes
            .iter()
            .filter_map(|s| match surface(s) {
                Ok(mesh) => Some(mesh),
                Err(why) => {
                    let note = format!("Not shown of `{}`: {why}.", link.name);
                    if !notes.contains(&note) {
                        notes.push(note);
                    }
                    None
                }
            })
            .collect::<Vec<_>>()
    };
    let seen = surfaces(&link.visuals);
    let collisions = surfaces(&link.collisions);
    let inertial =
        link.inertial.map(|i| Inertial { mass: i.mass, frame: i.origin, inertia: i.inertia });
    let facts = facts.about("links", &link.name);
    Link { name: link.name.clone(), facts, visual: together(&seen), collisions, inertial }
}

/// Several surfaces as one.
fn together(meshes: &[Mesh]) -> Option<Mesh> {
    let (mut vertices, mut faces, mut colours) = (Vec::<DVec3>::new(), Vec::new(), Vec::new());
    let coloured = meshes.iter().any(|m| m.colours().is_some());
    for mesh in meshes {
        let first = u32::try_from(vertices.len()).ok()?;
        vertices.extend_from_slice(mesh.vertices());
        faces.extend(mesh.faces().iter().map(|f| f.map(|v| v + first)));
        let plain = || vec![PLAIN; mesh.vertices().len()];
        colours.extend(mesh.colours().map_or_else(plain, <[_]>::to_vec));
    }
    let mesh = Mesh::new(vertices, faces).ok()?;
    mesh.with_colours(coloured.then_some(colours)).ok()
}

fn joint(joint: &robot::Joint, facts: &Facts) -> Joint {
    let kind = match joint.kind {
        Motion::Fixed => Kind::Fixed,
        Motion::Revolute => Kind::Revolute,
        Motion::Continuous => Kind::Continuous,
        Motion::Prismatic => Kind::Prismatic,
        Motion::Floating | Motion::Planar => Kind::Free,
    };
    let ends = joint.ends().map(|(low, high)| [low, high]);
    Joint {
        name: joint.name.clone(),
        kind,
        parent: joint.parent,
        child: joint.child,
        origin: joint.origin,
        axis: joint.axis,
        range: ends.filter(|_| joint.limit.is_some() || kind == Kind::Continuous),
        mimic: joint.mimic.map(|m| Mimic {
            joint: m.joint,
            factor: m.multiplier,
            offset: m.offset,
        }),
        facts: facts.about("joints", &joint.name),
    }
}
