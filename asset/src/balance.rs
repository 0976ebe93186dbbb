//! Keeps the masses of neighbouring links within the ratio that solvers bear.

use object::KinematicTree;

use crate::change::Change;
use crate::links::CARRIER_SHARE;
use crate::mass::{Body, DENSITY};

/// A parent may be this many times as heavy as its child; the profile allows 1000.
const RATIO: f64 = 900.0;
/// Densest a part may become where nothing gentler helps, kg/m³; the profile allows 20,000.
const DENSEST: f64 = 19_000.0;
const WHY: &str = "a parent may weigh at most 1000 times its child (M6)";

/// Raises light children, then lowers heavy parents, until neighbours are within the ratio; masses
/// marked as stated stay. Altered masses are returned as changes.
pub(crate) fn balance(tree: &KinematicTree, bodies: &mut [Body], stated: &[bool]) -> Vec<Change> {
    let before: Vec<f64> = bodies.iter().map(|b| b.mass.value).collect();
    for _ in 0..tree.len() + 2 {
        if !pass(tree, bodies, stated) {
            break;
        }
    }
    let mut changes = Vec::new();
    for (part, (body, &was)) in bodies.iter_mut().zip(&before).enumerate() {
        let now = body.mass.value;
        if now != was {
            let name = &tree.parts()[part].name;
            let (was, now) = (format!("{was:.6} kg"), format!("{now:.6} kg"));
            body.mass.how.push_str(&format!("; changed from {was}: {WHY}"));
            changes.push(Change::new(name, "mass", was, now, WHY));
        }
    }
    changes
}

/// One walk over all pairs; whether anything changed.
fn pass(tree: &KinematicTree, bodies: &mut [Body], stated: &[bool]) -> bool {
    let mut changed = false;
    for &child in tree.root_first() {
        let Some(parent) = tree.parent(child) else { continue };
        let lightest_share =
            if tree.parts()[child].joints.len() > 1 { CARRIER_SHARE } else { 1.0 };
        let allowed = RATIO * lightest_share;
        let violated = |b: &[Body]| b[parent].mass.value > allowed * b[child].mass.value * 1.0001;
        if !violated(bodies) {
            continue;
        }
        let [emptiest, dense] = DENSITY;
        let mut raise = |bodies: &mut [Body], densest: f64| {
            let cap = densest * bodies[child].volume.value;
            let wanted = (bodies[parent].mass.value / allowed).min(cap);
            if !stated[child] && wanted > bodies[child].mass.value {
                bodies[child].mass.value = wanted;
                changed = true;
            }
        };
        raise(bodies, dense);
        if violated(bodies) && !stated[parent] {
            let floor = emptiest * bodies[parent].volume.value;
            let wanted = (allowed * bodies[child].mass.value).max(floor);
            if wanted < bodies[parent].mass.value {
                bodies[parent].mass.value = wanted;
                raise(bodies, 0.0);
            }
        }
        if violated(bodies) {
            raise(bodies, DENSEST);
        }
    }
    changed
}
