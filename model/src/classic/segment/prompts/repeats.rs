//! Places parts without a point by repetition: the fourth wheel looks like the other three.

use std::collections::{BTreeMap, BTreeSet};

use object::Condition;

use crate::articulate::Note;
use crate::classic::lexicon::sizes::family;
use crate::classic::segment::oversegment::contact::Body;
use crate::classic::segment::prompts::seeds::Seed;

/// Copies differ in area and in box by less than this share.
const ALIKE: f64 = 0.01;

/// Seeds for parts without a point, and a note for each such part.
///
/// A part is placed only where there is no doubt. Other parts with the same words, numbers and
/// sides aside, have points. The unclaimed components that are copies of a prompted one are exactly
/// as many as the parts of these words without a point. Which copy is whose is then decided by
/// order along x, y, z, and the note says so.
pub(crate) fn place(
    condition: &Condition,
    component: &[u32],
    bodies: &[Body],
    seeds: &[Seed],
) -> (Vec<Seed>, Vec<Note>) {
    let claimed: BTreeSet<u32> = seeds.iter().map(|s| component[s.face as usize]).collect();
    let mut pointless: BTreeMap<String, Vec<usize>> = BTreeMap::new();
    for (part, prompt) in condition.prompts.iter().enumerate() {
        let is_placed = prompt.point.is_some() || seeds.iter().any(|s| usize::from(s.part) == part);
        if !is_placed && part != condition.tree.root() {
            pointless.entry(family(condition.text(part))).or_default().push(part);
        }
    }
    let (mut placed, mut notes) = (Vec::new(), Vec::new());
    for (words, parts) in pointless {
        let like = |s: &&Seed| family(condition.text(usize::from(s.part))) == words;
        let model = seeds.iter().find(like).map(|s| component[s.face as usize]);
        let copies = model.map_or(Vec::new(), |m| copies(bodies, m, &claimed));
        let certain = copies.len() == parts.len();
        for (i, &part) in parts.iter().enumerate() {
            let name = condition.tree.parts()[part].name.clone();
            notes.push(Note { part: name, message: message(certain).into(), loss: false });
            if let Some(copy) = copies.get(i).filter(|_| certain) {
                placed.push(Seed { face: bodies[*copy].faces[0], part: part as u16 });
            }
        }
    }
    (placed, notes)
}

fn message(placed: bool) -> &'static str {
    if placed {
        "has no point and was placed where the shape of a like part repeats"
    } else {
        "has no point, and no shape says where it is"
    }
}

/// Unclaimed components of the model's area and box, by position.
fn copies(bodies: &[Body], model: u32, claimed: &BTreeSet<u32>) -> Vec<usize> {
    let sides = |b: &Body| {
        let mut sides = b.bounds.size().to_array();
        sides.sort_by(f64::total_cmp);
        sides
    };
    let Some(original) = bodies.get(model as usize) else { return Vec::new() };
    let close = |a: f64, b: f64| (a - b).abs() <= ALIKE * a.abs().max(b.abs());
    let is_copy = |b: &Body| {
        close(b.area, original.area)
            && sides(b).iter().zip(sides(original)).all(|(&s, t)| close(s, t))
    };
    let free = |&i: &usize| !claimed.contains(&(i as u32)) && is_copy(&bodies[i]);
    let mut copies: Vec<usize> = (0..bodies.len()).filter(free).collect();
    let place = |i: usize| bodies[i].bounds.centre().to_array();
    let order = |a: &usize, b: &usize| {
        let (a, b) = (place(*a), place(*b));
        let by_axis = a.iter().zip(&b).map(|(x, y)| x.total_cmp(y));
        by_axis.fold(std::cmp::Ordering::Equal, std::cmp::Ordering::then)
    };
    copies.sort_by(order);
    copies
}
