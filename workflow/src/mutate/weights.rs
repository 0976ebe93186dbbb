//! Mass, centre of mass and inertia: `mass-…`, `inertia-…`, `com-…`.

use glamx::{DMat3, DVec3};
use sim_check::read::source::{At, Edit};
use sim_check::robot::{Inertial, Link};

use super::language::Language;
use super::model::{Model, quoted, vector};
use super::planted::{Made, first, made};
use crate::fix::numbers::{short, triple};

const NONE: &str = "no moving part has an <inertial> in this file";
/// How many times the largest moment of a long part exceeds the smallest: a rod of ten times its
/// width has a hundred; a guess.
const LONG: f64 = 20.0;
/// Products below this share of the moments are rounding.
const DIAGONAL: f64 = 1e-3;
/// A largest moment above this is too near 1 for 1 to be a placeholder, kg·m²; a guess.
const NEAR_ONE: f64 = 0.02;

/// A moving part, what it weighs, and where that is told.
struct Weighed<'m> {
    link: &'m Link,
    inertial: Inertial,
    at: At,
}

fn weighed<'m>(model: &'m Model, word: &str) -> Vec<Weighed<'m>> {
    let all = model.parts(word).into_iter();
    let one = |(_, link, at): (usize, &'m Link, At)| {
        let inertial = link.inertial.filter(|i| i.mass > 0.0)?;
        Some(Weighed { link, inertial, at: model.source.child(at, "inertial")? })
    };
    all.filter_map(one).collect()
}

fn of_parts(model: &Model, word: &str, of: impl Fn(&Weighed) -> Result<Vec<Edit>, String>) -> Made {
    first(weighed(model, word), NONE, |part| {
        let edits = of(&part)?;
        let line = model.source.line(part.at);
        let words = format!("{}: {}", word.replace('-', " "), told(&edits));
        made(quoted("link", &part.link.name), line, words, edits)
    })
}

/// What stands there after a change.
fn told(edits: &[Edit]) -> String {
    let told: Vec<&str> = edits.iter().map(|e| e.text.trim()).filter(|t| !t.is_empty()).collect();
    if told.is_empty() { "left out".into() } else { told.join(", ") }
}

fn mass(model: &Model, word: &str, of: impl Fn(f64) -> f64) -> Made {
    let retold = |at: At, tag: &str, told: &str| match model.language {
        Language::Urdf => Ok(model.source.set(model.child_of(at, "mass")?, "value", told)),
        Language::Mjcf => Ok(model.source.set(at, "mass", told)),
        Language::Sdf => Ok::<Edit, String>(model.text(at, tag, told)),
    };
    let by_inertial = of_parts(model, word, |part| {
        Ok(vec![retold(part.at, "mass", &short(of(part.inertial.mass)))?])
    });
    if by_inertial.is_ok() || model.language != Language::Mjcf {
        return by_inertial;
    }
    // What a body of MJCF weighs is mostly told by its geoms.
    first(model.parts(word), NONE, |(_, link, at)| {
        let was = link.inertial.map(|i| i.mass).filter(|m| *m > 0.0).ok_or(NONE)?;
        let geoms = model.source.children(at, "geom");
        if geoms.is_empty() || model.source.child(at, "inertial").is_some() {
            return Err("its mass is not that of its geoms".into());
        }
        let told = short(of(was) / geoms.len() as f64);
        let edits: Vec<Edit> = geoms.iter().map(|g| model.source.set(*g, "mass", &told)).collect();
        made(quoted("link", &link.name), link.line, format!("mass {told} of each geom"), edits)
    })
}

pub(super) fn mass_zero(model: &Model, word: &str) -> Made {
    mass(model, word, |_| 0.0)
}

pub(super) fn mass_negative(model: &Model, word: &str) -> Made {
    mass(model, word, |m| -m)
}

pub(super) fn grams(model: &Model, word: &str) -> Made {
    mass(model, word, |m| 1000.0 * m)
}

pub(super) fn tonnes(model: &Model, word: &str) -> Made {
    mass(model, word, |m| m / 1000.0)
}

pub(super) fn missing(model: &Model, word: &str) -> Made {
    of_parts(model, word, |part| Ok(vec![model.source.remove(part.at)]))
}

/// The edits that tell six other entries, in the axes of the inertial.
fn entries(model: &Model, at: At, tensor: DMat3) -> Result<Vec<Edit>, String> {
    let (x, y, z) = (tensor.col(0), tensor.col(1), tensor.col(2));
    let all = [("ixx", x.x), ("iyy", y.y), ("izz", z.z), ("ixy", x.y), ("ixz", x.z), ("iyz", y.z)];
    let source = &model.source;
    if model.language == Language::Mjcf {
        let moments = all.map(|(_, v)| short(v));
        if source.get(at, "fullinertia").is_some() {
            return Ok(vec![source.set(at, "fullinertia", &moments.join(" "))]);
        }
        return match source.get(at, "diaginertia") {
            Some(_) => Ok(vec![source.set(at, "diaginertia", &moments[..3].join(" "))]),
            None => Err("its inertia is not told".into()),
        };
    }
    let inertia = model.child_of(at, "inertia")?;
    let mut edits = Vec::new();
    for (name, value) in all {
        let told = short(value);
        match model.language {
            Language::Sdf => match source.child(inertia, name) {
                Some(child) => {
                    edits.push(source.replace(child, format!("<{name}>{told}</{name}>")));
                }
                None if value != 0.0 => return Err(format!("its <{name}> is not told")),
                None => {}
            },
            _ => {
                let was = source.get(inertia, name).and_then(|t| t.trim().parse::<f64>().ok());
                let is_same = was.unwrap_or(0.0) == value;
                edits.extend((!is_same).then(|| source.set(inertia, name, &told)));
            }
        }
    }
    Ok(edits)
}

/// What is told, in the axes that it is told in: of MJCF that is a diagonal, where it is told so.
fn tensor(model: &Model, part: &Weighed) -> DMat3 {
    let told = part.inertial.inertia;
    if model.language != Language::Mjcf {
        return told;
    }
    let diagonal = model.source.get(part.at, "diaginertia").and_then(vector);
    diagonal.map_or(told, DMat3::from_diagonal)
}

fn inertia(model: &Model, word: &str, of: impl Fn(DMat3) -> Result<DMat3, String>) -> Made {
    of_parts(model, word, |part| entries(model, part.at, of(tensor(model, part))?))
}

fn moments(tensor: DMat3) -> DVec3 {
    DVec3::new(tensor.x_axis.x, tensor.y_axis.y, tensor.z_axis.z)
}

fn with_moments(mut tensor: DMat3, all: DVec3) -> DMat3 {
    (tensor.x_axis.x, tensor.y_axis.y, tensor.z_axis.z) = (all.x, all.y, all.z);
    tensor
}

pub(super) fn inertia_zero(model: &Model, word: &str) -> Made {
    inertia(model, word, |_| Ok(DMat3::ZERO))
}

pub(super) fn inertia_negative(model: &Model, word: &str) -> Made {
    inertia(model, word, |t| {
        let all = moments(t);
        Ok(with_moments(t, DVec3::new(-all.x.abs(), all.y, all.z)))
    })
}

pub(super) fn triangle(model: &Model, word: &str) -> Made {
    inertia(model, word, |t| {
        let all = moments(t);
        Ok(with_moments(t, DVec3::new(3.0 * (all.y + all.z), all.y, all.z)))
    })
}

pub(super) fn inertia_millimetres(model: &Model, word: &str) -> Made {
    inertia(model, word, |t| Ok(1e6 * t))
}

pub(super) fn placeholder(model: &Model, word: &str) -> Made {
    inertia(model, word, |t| match moments(t).max_element() < NEAR_ONE {
        true => Ok(DMat3::IDENTITY),
        false => Err("its moments are near 1 themselves".into()),
    })
}

pub(super) fn inertia_turned(model: &Model, word: &str) -> Made {
    inertia(model, word, |t| {
        let all = moments(t);
        let (least, most) = (all.min_element(), all.max_element());
        let products = [t.x_axis.y, t.x_axis.z, t.y_axis.z].map(f64::abs);
        let is_plain = products.into_iter().all(|p| p < DIAGONAL * least);
        if !(least > 0.0 && most > LONG * least && is_plain) {
            return Err("no part is so long that it would show".into());
        }
        let mut turned = all;
        let place = |value: f64| (0..3).find(|k| all[*k] == value).unwrap_or(0);
        let (a, b) = (place(least), place(most));
        (turned[a], turned[b]) = (most, least);
        Ok(with_moments(t, turned))
    })
}

fn centre(model: &Model, word: &str, of: impl Fn(&Weighed) -> Result<DVec3, String>) -> Made {
    of_parts(model, word, |part| {
        let by = of(part)?;
        Ok(vec![model.moved(part.at, part.inertial.origin.translation, by)?])
    })
}

pub(super) fn com_outside(model: &Model, word: &str) -> Made {
    let diagonal = model.diagonal()?;
    centre(model, word, |_| Ok(DVec3::splat(diagonal / 3f64.sqrt())))
}

pub(super) fn com_millimetres(model: &Model, word: &str) -> Made {
    let diagonal = model.diagonal()?;
    centre(model, word, |part| {
        let was = match model.language {
            Language::Mjcf => model.source.get(part.at, "pos").and_then(vector),
            _ => Some(part.inertial.origin.translation),
        };
        let by = was.ok_or("its place is not told")? * 999.0;
        match by.length() > diagonal {
            true => Ok(triple(by)).and_then(|t| vector(&t).ok_or_else(|| "no place".into())),
            false => Err("no centre of mass is far enough from its frame".into()),
        }
    })
}
