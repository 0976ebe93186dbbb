//! Keeps the masses of neighbouring links within the ratio that solvers bear.

use object::KinematicTree;

use crate::change::Change;
use crate::mass::weigh::{Body, DENSITY};

/// A parent may be this many times as heavy as its child; the profile allows 1000.
const RATIO: f64 = 900.0;
/// Densest a part may become where nothing gentler helps, kg/m³; the profile allows 20,000.
const DENSEST: f64 = 19_000.0;
/// Share of its least mass that a parent may fall to where nothing else helps: 24 kg/m³ of the space
/// it fills, where the profile allows 20.
const AIRIEST: f64 = 0.235;
/// Share of a part's mass that its carrier bears; the part keeps the rest.
pub(crate) const CARRIER_SHARE: f64 = 0.2;
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
        let lightest_share = if tree.parts()[child].joints.len() > 1 { CARRIER_SHARE } else { 1.0 };
        let allowed = RATIO * lightest_share;
        let violated = |b: &[Body]| b[parent].mass.value > allowed * b[child].mass.value * 1.0001;
        if !violated(bodies) {
            continue;
        }
        let [_, dense] = DENSITY;
        let raise = |bodies: &mut [Body], densest: f64| {
            let cap = densest * bodies[child].volume.value;
            let wanted = (bodies[parent].mass.value / allowed).min(cap);
            let raised = !stated[child] && wanted > bodies[child].mass.value;
            if raised {
                bodies[child].mass.value = wanted;
            }
            raised
        };
        let lower = |bodies: &mut [Body], lightest: f64| {
            let wanted = (allowed * bodies[child].mass.value).max(lightest);
            let lowered = !stated[parent] && wanted < bodies[parent].mass.value;
            if lowered {
                bodies[parent].mass.value = wanted;
            }
            lowered
        };
        let least = bodies[parent].least;
        changed |= violated(bodies) && raise(bodies, dense);
        changed |= violated(bodies) && lower(bodies, least);
        changed |= violated(bodies) && raise(bodies, DENSEST);
        changed |= violated(bodies) && lower(bodies, AIRIEST * least);
    }
    changed
}

#[cfg(test)]
mod tests {
    use super::*;
    use glamx::{DMat3, DVec3};
    use object::{JointKind, Origin, Part, Sourced};

    fn body(mass: f64, volume: f64) -> Body {
        let number = |v| Sourced::new(v, Origin::Default, "");
        Body {
            mass: number(mass),
            centre: DVec3::ZERO,
            covariance: DMat3::IDENTITY,
            volume: number(volume),
            least: 102.0 * volume,
        }
    }

    fn tree(joints: &[JointKind]) -> KinematicTree {
        let part = |name: &str, parent, joints: &[JointKind]| Part {
            name: name.into(),
            text: name.into(),
            parent,
            joints: joints.to_vec(),
        };
        KinematicTree::new(vec![part("body", None, &[]), part("knob", Some(0), joints)]).unwrap()
    }

    #[test]
    fn a_light_knob_is_made_heavier_first() {
        let mut bodies = [body(45.0, 0.2), body(0.007, 1e-5)];
        let changes = balance(&tree(&[JointKind::Revolute]), &mut bodies, &[false; 2]);
        assert!((bodies[1].mass.value - 0.05).abs() < 1e-12 && bodies[0].mass.value == 45.0);
        assert_eq!((changes.len(), changes[0].part.as_str()), (1, "knob"));
    }

    #[test]
    fn a_body_gives_way_when_the_knob_is_too_small_to_be_heavy() {
        let mut bodies = [body(450.0, 1.0), body(1e-4, 1e-6)];
        balance(&tree(&[JointKind::Revolute]), &mut bodies, &[false; 2]);
        assert!((bodies[0].mass.value - 102.0 * AIRIEST).abs() < 1e-9);
        assert!((bodies[1].mass.value - 1e-6 * DENSEST).abs() < 1e-12);
        let mut near = [body(20.0, 0.05), body(1e-4, 2e-6)];
        balance(&tree(&[JointKind::Revolute]), &mut near, &[false; 2]);
        assert!(near[0].mass.value <= 1000.0 * near[1].mass.value);
    }

    #[test]
    fn stated_masses_stay_and_a_carrier_counts_for_itself() {
        let mut bodies = [body(45.0, 0.2), body(0.007, 1e-5)];
        assert!(balance(&tree(&[JointKind::Revolute]), &mut bodies, &[true; 2]).is_empty());
        let both = [JointKind::Prismatic, JointKind::Continuous];
        let mut bodies = [body(9.0, 0.05), body(0.007, 1e-4)];
        balance(&tree(&both), &mut bodies, &[false; 2]);
        assert!((bodies[1].mass.value - 9.0 / 900.0 / CARRIER_SHARE).abs() < 1e-12);
    }
}
