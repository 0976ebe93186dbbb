//! Parts with the same words are copies of each other: a segment that only one of them has is not
//! its own.

use std::collections::{BTreeMap, BTreeSet};

use object::Condition;

use crate::classic::lexicon::sizes::family;
use crate::classic::segment::oversegment::contact::Body;
use crate::classic::segment::prompts::seeds::Seed;

/// Copies differ in area by less than this share.
const ALIKE: f64 = 0.006;
/// A component belongs to a part that holds this share of its area.
const WHOLE: f64 = 0.98;
/// A part this much larger than its twin holds more than its own.
const LARGER: f64 = 1.05;

/// Evens out the labels of parts with the same words (features and sides aside) and the same parent.
///
/// The middle one by area, of two the smaller, is the model. What a larger one has besides copies of the model's
/// components goes to their parent. Components with a seed stay.
pub(crate) fn even_out(
    part_of_face: &mut [u16],
    condition: &Condition,
    component: &[u32],
    bodies: &[Body],
    seeds: &[Seed],
) {
    let seeded: BTreeSet<u32> = seeds.iter().map(|s| component[s.face as usize]).collect();
    let mut owner = owners(part_of_face, bodies);
    let before = owner.clone();
    for twins in families(condition) {
        even_out_family(&mut owner, &twins, condition, bodies, &seeded);
    }
    for (c, (now, was)) in owner.iter().zip(&before).enumerate() {
        if let (Some(now), true) = (now, now != was) {
            bodies[c].faces.iter().for_each(|&f| part_of_face[f as usize] = *now);
        }
    }
}

/// The part that holds each component; `None` where several share it.
fn owners(part_of_face: &[u16], bodies: &[Body]) -> Vec<Option<u16>> {
    let owner = |body: &Body| {
        let mut counts: BTreeMap<u16, usize> = BTreeMap::new();
        for &f in &body.faces {
            *counts.entry(part_of_face[f as usize]).or_default() += 1;
        }
        let (part, count) = counts.into_iter().max_by_key(|(_, n)| *n)?;
        (count as f64 >= WHOLE * body.faces.len() as f64).then_some(part)
    };
    bodies.iter().map(owner).collect()
}

/// Groups of two and more parts with the same words and the same parent.
fn families(condition: &Condition) -> Vec<Vec<usize>> {
    let tree = &condition.tree;
    let mut groups: BTreeMap<(Option<usize>, String), Vec<usize>> = BTreeMap::new();
    for part in (0..tree.len()).filter(|&p| p != tree.root()) {
        let key = (tree.parent(part), family(condition.text(part)));
        groups.entry(key).or_default().push(part);
    }
    groups.into_values().filter(|g| g.len() > 1).collect()
}

fn even_out_family(
    owner: &mut [Option<u16>],
    twins: &[usize],
    condition: &Condition,
    bodies: &[Body],
    seeded: &BTreeSet<u32>,
) {
    let own = |owner: &[Option<u16>], part: usize| -> Vec<usize> {
        (0..bodies.len()).filter(|&c| owner[c] == Some(part as u16)).collect()
    };
    let area = |components: &[usize]| components.iter().map(|&c| bodies[c].area).sum::<f64>();
    let held: Vec<(usize, Vec<usize>)> = twins.iter().map(|&p| (p, own(owner, p))).collect();
    let mut present: Vec<_> = held.iter().filter(|(_, c)| !c.is_empty()).collect();
    present.sort_by(|a, b| area(&a.1).total_cmp(&area(&b.1)));
    let middle = present.len().saturating_sub(1) / 2;
    let Some((model, core)) = present.get(middle) else { return };
    for (twin, components) in &held {
        if twin == model || area(components) < LARGER * area(core) {
            continue;
        }
        let Some(copies) = copies(core, components, bodies) else { continue };
        let Some(parent) = condition.tree.parent(*twin) else { continue };
        for &extra in components.iter().filter(|c| !copies.contains(c)) {
            if !seeded.contains(&(extra as u32)) {
                owner[extra] = Some(parent as u16);
            }
        }
    }
}

/// A copy of each component of the model among some others; `None` if one has none.
fn copies(core: &[usize], among: &[usize], bodies: &[Body]) -> Option<Vec<usize>> {
    let mut found: Vec<usize> = Vec::new();
    for &c in core {
        let copy = |i: &&usize| !found.contains(i) && alike(&bodies[**i], &bodies[c]);
        found.push(*among.iter().find(copy)?);
    }
    Some(found)
}

fn alike(a: &Body, b: &Body) -> bool {
    let near = (a.area - b.area).abs() <= ALIKE * a.area.max(b.area);
    near && a.faces.len() == b.faces.len()
}
