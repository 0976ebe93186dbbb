//! Mass, centre of mass and inertia from shapes: M1, M3, M4, M5.

use glamx::DMat3;
use sim_check::checks::lint::{Filled, filled};
use sim_check::profile::bounds::LIKELY;
use sim_check::read::source::{At, Edit};
use sim_check::robot::{Inertial, Link};
use sim_check::verdict::figure;

use super::numbers::{cleaned, digits, short, triple};
use super::offer::{Change, Offer, State, names};
use super::remedies::Way;

/// What is taken for a density where no link of the file tells a likely one, kg/m³: water's, which is
/// MuJoCo's default, too; a guess.
const DENSITY: f64 = 1000.0;
/// What a frame may be said to weigh, kg: files of CAD programs give frames a millionth of a gram; a guess.
const FRAME: f64 = 1e-6;
/// Tensors whose products are below this share of their moments are told as diagonals.
const DIAGONAL: f64 = 1e-9;

/// What a way offers for each link that is named in the findings.
pub(super) fn offers(state: &State, way: Way, findings: &[(&str, &str)]) -> Vec<Offer> {
    let named = names(findings, "link");
    if named.is_empty() {
        return Vec::new();
    }
    let shapes = filled(&state.robot);
    let density = density(&state.robot.links, &shapes);
    let links = state.robot.links.iter().zip(&shapes);
    let links = links.filter(|(link, _)| named.contains(&link.name.as_str()));
    let computed = |(link, shape): (&Link, &Option<Filled>)| {
        let unknown = || "its shape encloses no volume, so nothing can be computed from it";
        let shape = shape.as_ref().ok_or_else(unknown)?;
        match (way, link.inertial) {
            (Way::Centre, Some(inertial)) => centre(state, link, &inertial, shape),
            (Way::Inertia, Some(inertial)) => inertia(state, link, &inertial, shape),
            (Way::Weight, _) => weight(state, link, (shape, density)),
            _ => Err("it has no <inertial>".into()),
        }
    };
    let offer = |(link, shape): (&Link, &Option<Filled>)| {
        let bare = link.visuals.is_empty() && link.collisions.is_empty();
        let change =
            if way == Way::Weight && bare { frame(state, link) } else { computed((link, shape)) };
        let line = link.inertial.map_or(link.line, |i| i.line);
        let subject = format!("link `{}`", link.name);
        Offer { way, subject, line, changes: change.map(|change| vec![change]) }
    };
    links.map(offer).collect()
}

/// The middle one of the likely densities of links, and whether there is one.
fn density(links: &[Link], shapes: &[Option<Filled>]) -> (f64, bool) {
    let known = links.iter().zip(shapes).filter_map(|(link, shape)| {
        let density = link.inertial?.mass / shape.as_ref()?.volume;
        (LIKELY.0..=LIKELY.1).contains(&density).then_some(density)
    });
    let mut known: Vec<f64> = known.collect();
    known.sort_by(f64::total_cmp);
    known.get(known.len() / 2).map_or((DENSITY, false), |middle| (*middle, true))
}

type Made = Result<Change, String>;

/// The element of a body or link, and its inertial.
fn inertial_at(state: &State, link: &Link) -> Result<(At, Option<At>), String> {
    let tag = if state.is_urdf() { "link" } else { "body" };
    let at = state.element(tag, &link.name, link.line)?;
    match state.source.children(at, "inertial")[..] {
        [] => Ok((at, None)),
        [one] => Ok((at, Some(one))),
        _ => Err("it has several <inertial>".into()),
    }
}

fn made(words: String, edits: Vec<Edit>) -> Made {
    Ok(Change { words, edits, files: vec![] })
}

/// A link without shape that weighs nothing, or next to it: it is a frame, and needs no inertial.
fn frame(state: &State, link: &Link) -> Made {
    let weighs = link.inertial.is_some_and(|i| i.mass.abs() > FRAME);
    if weighs || link.inertial.is_none() {
        return Err("it has no shape to compute its mass from".into());
    }
    let (_, at) = inertial_at(state, link)?;
    let at = at.ok_or("its mass is that of its geoms")?;
    made(
        "an <inertial> of 0 kg taken from a frame without shape".into(),
        vec![state.source.remove(at)],
    )
}

fn centre(state: &State, link: &Link, inertial: &Inertial, shape: &Filled) -> Made {
    let (_, at) = inertial_at(state, link)?;
    let at = at.ok_or("its mass is that of its geoms")?;
    let source = &state.source;
    let told = triple(shape.centre);
    let words = format!("centre of mass {told}, the centre of its shape");
    if !state.is_urdf() {
        // A body's frame is that of its link, but for the place of its joint.
        let told_there = source.get(at, "pos").map(numbers_of).unwrap_or_default();
        let [x, y, z] = told_there[..] else { return Err("its inertial tells no place".into()) };
        let moved = shape.centre - inertial.origin.translation;
        if is_root(state, link) {
            return Err("its body stands in the frame of the world".into());
        }
        let told = triple(glamx::DVec3::new(x, y, z) + moved);
        return made(words, vec![source.set(at, "pos", &told)]);
    }
    let edit = match source.child(at, "origin") {
        Some(origin) => source.set(origin, "xyz", &told),
        None => source.insert_first(at, &format!("<origin xyz=\"{told}\"/>")),
    };
    made(words, vec![edit])
}

fn is_root(state: &State, link: &Link) -> bool {
    state.robot.links.get(state.robot.root()).is_some_and(|root| root.name == link.name)
}

fn numbers_of(text: &str) -> Vec<f64> {
    text.split_whitespace().map_while(|w| w.parse().ok()).collect()
}

/// The tensor of a shape with a mass, in the axes of an inertial.
fn tensor(mass: f64, shape: &Filled, inertial: Option<&Inertial>) -> DMat3 {
    let turn = inertial.map_or(DMat3::IDENTITY, |i| DMat3::from_quat(i.origin.rotation));
    turn.transpose() * (shape.per_kilogram * mass) * turn
}

/// The six numbers of a tensor by URDF's names.
fn entries(tensor: DMat3) -> [(&'static str, f64); 6] {
    let (x, y, z) = (tensor.col(0), tensor.col(1), tensor.col(2));
    let all = cleaned(&[x.x, y.y, z.z, x.y, x.z, y.z]);
    let names = ["ixx", "iyy", "izz", "ixy", "ixz", "iyz"];
    std::array::from_fn(|k| (names[k], all[k]))
}

/// Edits that make an inertial tell the tensor of a shape with a mass.
fn retold(
    (state, link): (&State, &Link),
    at: At,
    (mass, shape): (f64, &Filled),
) -> Result<Vec<Edit>, String> {
    let source = &state.source;
    let all = entries(tensor(mass, shape, link.inertial.as_ref()));
    if state.is_urdf() {
        let inertia = source.child(at, "inertia").ok_or("it has no <inertia> to mend")?;
        let same = |name: &str, value: f64| {
            source.get(inertia, name).and_then(|t| t.trim().parse::<f64>().ok()) == Some(value)
        };
        let other = all.iter().filter(|(name, value)| !same(name, *value));
        return Ok(other.map(|(name, value)| source.set(inertia, name, &short(*value))).collect());
    }
    let moments: Vec<String> = all.iter().map(|(_, v)| short(*v)).collect();
    let products = all[3..].iter().map(|(_, v)| v.abs()).fold(0.0, f64::max);
    let is_diagonal = products <= DIAGONAL * all[0].1.max(all[1].1).max(all[2].1);
    let turned = ["quat", "euler", "axisangle", "xyaxes", "zaxis"];
    if is_diagonal {
        let told = source.set(at, "diaginertia", &moments[..3].join(" "));
        return Ok([told].into_iter().chain(source.unset(at, "fullinertia")).collect());
    }
    // MuJoCo wants a full tensor in the axes of the body: those of its link, unless it is free.
    if is_root(state, link) {
        return Err("its body stands in the frame of the world".into());
    }
    let moments = entries(tensor(mass, shape, None)).map(|(_, v)| short(v));
    let told = source.set(at, "fullinertia", &moments.join(" "));
    let others = turned.iter().chain(&["diaginertia"]).filter_map(|name| source.unset(at, name));
    Ok([told].into_iter().chain(others).collect())
}

fn inertia(state: &State, link: &Link, inertial: &Inertial, shape: &Filled) -> Made {
    if !(inertial.mass > 0.0 && inertial.mass.is_finite()) {
        return Err("its mass is not above 0".into());
    }
    let (_, at) = inertial_at(state, link)?;
    let at = at.ok_or("its inertia is that of its geoms")?;
    let edits = retold((state, link), at, (inertial.mass, shape))?;
    made(format!("inertia of its shape with {} kg", figure(inertial.mass)), edits)
}

fn weight(
    state: &State,
    link: &Link,
    (shape, (density, is_known)): (&Filled, (f64, bool)),
) -> Made {
    let mass = density * shape.volume;
    let kilograms = digits(mass, 4);
    let mass: f64 = kilograms.parse().unwrap_or(mass);
    let whose = if is_known { "that of the other links" } else { "a guess: say what it weighs" };
    let words = format!(
        "mass {kilograms} kg, of {} kg/m³ ({whose}), with inertia of its shape",
        figure(density)
    );
    let (body, at) = inertial_at(state, link)?;
    let source = &state.source;
    if let Some(at) = at {
        let mut edits = retold((state, link), at, (mass, shape))?;
        edits.push(match (state.is_urdf(), source.child(at, "mass")) {
            (true, Some(at)) => source.set(at, "value", &kilograms),
            (true, None) => return Err("it has no <mass> to mend".into()),
            (false, _) => source.set(at, "mass", &kilograms),
        });
        return made(words, edits);
    }
    let (at, all) = (triple(shape.centre), entries(tensor(mass, shape, None)));
    let element = if state.is_urdf() {
        let told: Vec<String> = all.iter().map(|(n, v)| format!("{n}=\"{}\"", short(*v))).collect();
        format!(
            "<inertial>\n\t<origin xyz=\"{at}\"/>\n\t<mass value=\"{kilograms}\"/>\n\t<inertia {}/>\n</inertial>",
            told.join(" ")
        )
    } else {
        let stands = source.children(body, "joint").iter().all(|j| source.get(*j, "pos").is_none());
        if !stands || is_root(state, link) {
            return Err("its body's frame is not its link's".into());
        }
        let told: Vec<String> = all.iter().map(|(_, v)| short(*v)).collect();
        format!("<inertial pos=\"{at}\" mass=\"{kilograms}\" fullinertia=\"{}\"/>", told.join(" "))
    };
    made(words, vec![source.insert_first(body, &element)])
}
