//! Where parts are seen, taken back to the surface, and every rule about that answer.

use std::collections::BTreeSet;

use object::DVec3;
use serde_json::Value;

use super::parts::{PartAnswer, PartsAnswer};
use super::pointing::Convention;
use super::repair::Fault;
use super::scene::Scene;
use super::settle::{Sighting, settled};

/// Points of two parts nearer to each other than this share of the diagonal mean one place.
const ONE_PLACE: f64 = 0.01;

/// A part and a point on it, object frame, metres of the mesh's own unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Located {
    /// Its id.
    pub part: String,
    /// On the surface.
    pub position: DVec3,
}

/// A point as it is written.
struct Written {
    part: String,
    view: i64,
    point: [i64; 2],
}

/// Reads an answer, takes its points to the surface and applies every rule; all faults at once.
/// Several views of one part are settled into one point.
///
/// # Errors
/// The rules it breaks.
pub fn judged(
    value: Value,
    parts: &PartsAnswer,
    scene: &Scene<'_>,
    convention: Convention,
) -> Result<Vec<Located>, Vec<Fault>> {
    let (written, hidden) = read(&value, convention)?;
    let mut faults = vec![];
    let mut hits: Vec<(usize, Sighting<'_>)> = vec![];
    for (n, w) in written.iter().enumerate() {
        match hit(w, n, &parts.parts, (scene, convention)) {
            Ok(found) => hits.push(found),
            Err(fault) => faults.push(fault),
        }
    }
    faults.extend(swapped(&written, scene, convention));
    faults.extend(uncovered(&parts.parts, &hits, &hidden));
    let located = one_each(&parts.parts, &hits, scene);
    faults.extend(crowded(&located, scene.diagonal));
    if faults.is_empty() { Ok(located) } else { Err(faults) }
}

fn read(value: &Value, convention: Convention) -> Result<(Vec<Written>, Vec<String>), Vec<Fault>> {
    let shape = |path: String, rule: &str| vec![Fault::new("J02", path, rule)];
    let list = |key: &str| {
        let found = value.get(key).and_then(Value::as_array);
        found.ok_or_else(|| shape(format!("/{key}"), "must be a list"))
    };
    let point = |(n, p): (usize, &Value)| {
        let part = p.get("part_id").and_then(Value::as_str);
        let view = p.get("view").and_then(Value::as_i64);
        let pair = p.get(convention.key()).and_then(Value::as_array);
        let numbers = pair.map(|p| p.iter().map(Value::as_i64).collect::<Option<Vec<_>>>());
        let pair = numbers.flatten().unwrap_or_default();
        match (part, view, &pair[..]) {
            (Some(part), Some(view), &[a, b]) => {
                Ok(Written { part: part.into(), view, point: [a, b] })
            }
            _ => {
                let rule =
                    format!("must have part_id, view and {}: two integers", convention.key());
                Err(shape(format!("/points/{n}"), &rule))
            }
        }
    };
    let written = list("points")?.iter().enumerate().map(point).collect::<Result<_, _>>()?;
    let hidden = list("not_visible")?.iter().filter_map(|v| v.as_str().map(String::from));
    Ok((written, hidden.collect()))
}

/// The part a point names and where it is seen; there is surface at that place.
fn hit<'a>(
    written: &Written,
    n: usize,
    parts: &[PartAnswer],
    (scene, convention): (&Scene<'a>, Convention),
) -> Result<(usize, Sighting<'a>), Fault> {
    let path = |key: &str| format!("/points/{n}/{key}");
    let part = parts.iter().position(|p| p.id == written.part);
    let unknown = || format!("no part has the id {:?}", written.part);
    let part = part.ok_or_else(|| Fault::new("P01", path("part_id"), unknown()))?;
    let camera =
        usize::try_from(written.view.saturating_sub(1)).ok().and_then(|v| scene.cameras.get(v));
    let no_view = || format!("views are 1 to {}, found {}", scene.cameras.len(), written.view);
    let camera = camera.ok_or_else(|| Fault::new("P02", path("view"), no_view()))?;
    let pixel = convention.pixel(written.point, camera.size);
    let outside = || format!("{} Found {:?}", convention.words(), written.point);
    let pixel = pixel.ok_or_else(|| Fault::new("P03", path(convention.key()), outside()))?;
    let background = || format!("{:?} is background in view {}", written.point, written.view);
    let surface = scene.surface(camera, pixel);
    surface.ok_or_else(|| Fault::new("P04", path(convention.key()), background()))?;
    Ok((part, Sighting { camera, pixel }))
}

/// Points that mean more surface with their numbers exchanged were written in the wrong order.
fn swapped(written: &[Written], scene: &Scene<'_>, convention: Convention) -> Option<Fault> {
    let hits = |exchange: bool| {
        let on_surface = |w: &&Written| {
            let [a, b] = w.point;
            let point = if exchange { [b, a] } else { [a, b] };
            let camera =
                usize::try_from(w.view.saturating_sub(1)).ok().and_then(|v| scene.cameras.get(v));
            let pixel = camera.and_then(|c| Some((c, convention.pixel(point, c.size)?)));
            pixel.is_some_and(|(camera, pixel)| scene.rays.pixel(camera, pixel).is_some())
        };
        written.iter().filter(on_surface).count()
    };
    let (as_written, exchanged) = (hits(false), hits(true));
    let wrong = as_written < written.len() && exchanged == written.len();
    wrong.then(|| {
        let message = format!("the two numbers look exchanged. {}", convention.words());
        Fault::new("P09", "/points".into(), message)
    })
}

/// Parts without a point: allowed for what no view shows, unless only points tell it from others.
fn uncovered(
    parts: &[PartAnswer],
    hits: &[(usize, Sighting<'_>)],
    hidden: &[String],
) -> Vec<Fault> {
    let pointed: BTreeSet<_> = hits.iter().map(|(part, _)| *part).collect();
    let text = |p: &PartAnswer| p.text.trim().to_lowercase();
    let twin = |n: usize| {
        let others = parts.iter().enumerate().filter(|(m, _)| *m != n);
        others.into_iter().any(|(_, p)| text(p) == text(&parts[n]))
    };
    let fault = |n: usize| {
        let id = &parts[n].id;
        if twin(n) {
            let message = format!("{id} has the text of another part, so it needs a point");
            return Some(Fault::new("K10", "/points".into(), message));
        }
        let message = format!("{id} has neither a point nor a place in not_visible");
        (!hidden.contains(id)).then(|| Fault::new("P06", "/points".into(), message))
    };
    (0..parts.len()).filter(|n| !pointed.contains(n)).filter_map(fault).collect()
}

/// Each part's sightings settled into one point.
fn one_each(
    parts: &[PartAnswer],
    hits: &[(usize, Sighting<'_>)],
    scene: &Scene<'_>,
) -> Vec<Located> {
    let of = |n: usize| -> Option<Located> {
        let own: Vec<_> = hits.iter().filter(|(p, _)| *p == n).map(|(_, s)| *s).collect();
        Some(Located { part: parts[n].id.clone(), position: settled(scene, &own)? })
    };
    (0..parts.len()).filter_map(of).collect()
}

fn crowded(located: &[Located], diagonal: f64) -> Vec<Fault> {
    let mut faults = vec![];
    for (n, a) in located.iter().enumerate() {
        for b in &located[n + 1..] {
            if a.position.distance(b.position) < ONE_PLACE * diagonal {
                let message = format!("{} and {} have points in one place", a.part, b.part);
                faults.push(Fault::new("P07", "/points".into(), message));
            }
        }
    }
    faults
}
