//! Whether what a condition points at lies on a mesh, and what it looks like where it does not.

use glamx::DVec3;

use super::fault::{ConditionError, Fault};
use super::types::{Condition, POINT_TOLERANCE, Prompt};
use crate::articulated::Range;
use crate::mesh::{FileFrame, Mesh};
use crate::weld::{nearest_face, nearest_point};

impl Condition {
    /// Checks that every point lies on the mesh, within [`POINT_TOLERANCE`], and that painted faces are
    /// faces of it.
    ///
    /// # Errors
    /// [`ConditionError`]: every point that does not, with the nearest one that does, and what they look
    /// like.
    pub fn check_points(&self, mesh: &Mesh) -> Result<(), ConditionError> {
        check(self, mesh)
    }

    /// The same with every point that lies off the mesh moved to the nearest one on it, and how many were.
    #[must_use]
    pub fn snapped(&self, mesh: &Mesh) -> (Self, usize) {
        snapped(self, mesh)
    }
}

/// A guess at coordinates: what is done to them, and what they look like if they then lie on the mesh.
type Guess = (fn(DVec3) -> DVec3, &'static str);

/// Coordinates of other programs, file frame.
const GUESSES: [Guess; 8] = [
    (
        |p| DVec3::new(p.x, p.z, -p.y),
        "(x, z, -y): these look like z-up coordinates, as Blender has them",
    ),
    (|p| DVec3::new(p.x, -p.z, p.y), "(x, -z, y): these look like y-up coordinates of a z-up mesh"),
    (|p| p / 1000.0, "a thousandth of it: 1000 times too large, millimetres for metres?"),
    (|p| p / 100.0, "a hundredth of it: 100 times too large, centimetres for metres?"),
    (|p| p * 1000.0, "1000 times it: metres for millimetres?"),
    (|p| p * 100.0, "100 times it: metres for centimetres?"),
    (
        |p| DVec3::new(p.x, p.z, -p.y) / 1000.0,
        "(x, z, -y) / 1000: these look like z-up millimetres",
    ),
    (|p| p * 0.0254, "0.0254 of it: inches for metres?"),
];

/// An axis lies no farther from the mesh, and a slide goes no farther, than this many of its diagonals: a guess,
/// well above any joint of an object that is one thing.
const FAR: f64 = 2.0;

/// A point of a condition: whose it is and where it stands there.
struct Spot {
    part: usize,
    field: &'static str,
    at: DVec3,
}

fn spots(condition: &Condition) -> Vec<Spot> {
    let of = |(part, prompt): (usize, &Prompt)| {
        let first = prompt.point.map(|at| Spot { part, field: "point", at });
        let also = prompt.also.iter().map(move |&at| Spot { part, field: "points", at });
        let not = prompt.not.iter().map(move |&at| Spot { part, field: "not", at });
        first.into_iter().chain(also).chain(not).collect::<Vec<_>>()
    };
    condition.prompts.iter().enumerate().flat_map(of).collect()
}

/// See [`Condition::check_points`].
fn check(condition: &Condition, mesh: &Mesh) -> Result<(), ConditionError> {
    let allowed = POINT_TOLERANCE * mesh.bounds().diagonal();
    let frame = condition.frame;
    let mut faults = painted(condition, mesh);
    if faults.is_empty() {
        faults = contradicted(condition, mesh);
    }
    let mut off: Vec<DVec3> = Vec::new();
    let spots = spots(condition);
    let count = spots.len();
    for Spot { part, field, at } in spots {
        let (nearest, distance) = nearest_point(mesh, at);
        if distance <= allowed {
            continue;
        }
        off.push(at);
        let [found, near] = [at, nearest].map(|p| written(frame, p));
        let name = &condition.tree.parts()[part].name;
        let what = if field == "not" { "`not` point" } else { "point" };
        let rule = format!("allowed is {allowed:.4} (1 % of its diagonal, same unit)");
        let message = format!(
            "part `{name}`: {what} {found} lies {distance:.4} off the mesh, {rule}; nearest on it is {near}"
        );
        faults.push(Fault::new(None, message));
    }
    // One point of several that is off is a slip; coordinates of another program are off in all of them.
    let told = (off.len() == count).then(|| looks_like((mesh, frame), &off, allowed)).flatten();
    if let Some(told) = told {
        let which = if off.len() == 1 { "it would lie" } else { "they would all lie" };
        let last = faults.pop().map(|fault| format!("{}; {which} on it as {told}", fault.message));
        faults.extend(last.map(|message| Fault::new(None, message)));
    }
    faults.extend(beyond(condition, mesh));
    ConditionError::of(faults)
}

/// Joints that have nothing to do with the mesh: axes far off it, and slides far longer than it.
fn beyond(condition: &Condition, mesh: &Mesh) -> Vec<Fault> {
    let (bounds, scale) = (mesh.bounds(), condition.size.map_or(1.0, |size| size.scale_for(mesh)));
    let diagonal = bounds.diagonal();
    let mut faults = Vec::new();
    for (part, prompt) in condition.tree.parts().iter().zip(&condition.prompts) {
        for (kind, given) in part.joints.iter().zip(&prompt.joints) {
            let off = given.pivot.map_or(0.0, |p| p.distance(p.clamp(bounds.min, bounds.max)));
            if off > FAR * diagonal {
                let rule = format!("at most {:.4}, {FAR} times its diagonal", FAR * diagonal);
                let message =
                    format!("part `{}`: pivot lies {off:.4} off the mesh, {rule}", part.name);
                faults.push(Fault::new(None, message));
            }
            let span = given.range.map(Range::span).into_iter().chain(given.open_by);
            let longest = span.fold(0.0, f64::max) / scale;
            if !kind.turns() && longest > FAR * diagonal {
                let most = FAR * diagonal * scale;
                let found = longest * scale;
                let message = format!(
                    "part `{}`: a slide goes at most {most:.4} m, {FAR} times the object's diagonal; found {found:.4} m",
                    part.name
                );
                faults.push(Fault::new(None, message));
            }
        }
    }
    faults
}

/// Faces of which two things are said: a point of one part on a face painted as another's, a point of a part
/// where another point is not of it.
fn contradicted(condition: &Condition, mesh: &Mesh) -> Vec<Fault> {
    let mut faults = Vec::new();
    let parts = condition.tree.parts();
    let has_painted = condition.prompts.iter().any(|p| !p.faces.is_empty());
    for (part, prompt) in condition.prompts.iter().enumerate() {
        if !has_painted && prompt.not.is_empty() {
            continue;
        }
        let name = &parts[part].name;
        let face_of = |p: DVec3| nearest_face(mesh, p).0 as u32;
        let own: Vec<u32> = prompt.points().map(face_of).collect();
        let others = condition.prompts.iter().zip(parts).enumerate().filter(|(p, _)| *p != part);
        for (_, (other, owner)) in others {
            let holds = |face: &&u32| other.faces.ranges().iter().any(|run| run.contains(*face));
            if let Some(face) = own.iter().find(holds) {
                let rule = format!("which is painted as `{}`'s", owner.name);
                let message = format!("part `{name}`: a point of it lies on face {face}, {rule}");
                faults.push(Fault::new(None, message));
            }
        }
        if let Some(face) = prompt.not.iter().map(|p| face_of(*p)).find(|face| own.contains(face)) {
            let message =
                format!("part `{name}`: a point of it and a `not` point lie on one face, {face}");
            faults.push(Fault::new(None, message));
        }
    }
    faults
}

fn painted(condition: &Condition, mesh: &Mesh) -> Vec<Fault> {
    let mut faults = Vec::new();
    let painted: Vec<(usize, u32)> = condition
        .prompts
        .iter()
        .enumerate()
        .filter_map(|(part, prompt)| Some((part, prompt.faces.last()?)))
        .collect();
    let Some(&(first, _)) = painted.first() else { return faults };
    let name = |part: usize| &condition.tree.parts()[part].name;
    if let Some(on) = condition.painted_on.as_ref().filter(|on| **on != mesh.digest()) {
        let message = format!(
            "part `{}`: its faces were painted on the mesh {on}, but this one is {}",
            name(first),
            mesh.digest()
        );
        faults.push(Fault::new(None, message));
        return faults;
    }
    let count = mesh.faces().len();
    for (part, last) in painted.into_iter().filter(|(_, last)| *last as usize >= count) {
        let message = format!(
            "part `{}`: face {last} is painted, but the mesh has {count} faces, counted from 0",
            name(part)
        );
        faults.push(Fault::new(None, message));
    }
    faults
}

/// What coordinates that lie off the mesh look like, if one guess puts all of them on it.
fn looks_like(
    (mesh, frame): (&Mesh, FileFrame),
    off: &[DVec3],
    allowed: f64,
) -> Option<&'static str> {
    if off.is_empty() {
        return None;
    }
    // As they stand in the file: a guess is about what was written.
    let fits = |(guess, _): &&Guess| {
        off.iter().all(|&p| {
            let guessed = frame.point_to_object(guess(frame.point_to_file(p)));
            nearest_point(mesh, guessed).1 <= allowed
        })
    };
    GUESSES.iter().find(fits).map(|(_, told)| *told)
}

fn written(frame: FileFrame, p: DVec3) -> String {
    let DVec3 { x, y, z } = frame.point_to_file(p);
    let number = |c: f64| {
        let rounded = (c * 1e5).round() / 1e5;
        if rounded == 0.0 { 0.0 } else { rounded }
    };
    format!("({}, {}, {})", number(x), number(y), number(z))
}

/// See [`Condition::snapped`].
fn snapped(condition: &Condition, mesh: &Mesh) -> (Condition, usize) {
    let allowed = POINT_TOLERANCE * mesh.bounds().diagonal();
    let mut snapped = condition.clone();
    let mut count = 0;
    for prompt in &mut snapped.prompts {
        for point in prompt.point.iter_mut().chain(&mut prompt.also).chain(&mut prompt.not) {
            let (nearest, distance) = nearest_point(mesh, *point);
            if distance > allowed {
                *point = nearest;
                count += 1;
            }
        }
    }
    (snapped, count)
}
