//! What a USD stage says of physics.

use std::collections::BTreeSet;

use crate::find::place::at;
use crate::read::usda::{Prim, Stage};
use crate::rule::Place;

fn at_prim(prim: &Prim, found: &str) -> Place {
    at("prim", &prim.name, prim.line, found)
}

fn which(stage: &Stage, is: impl Fn(&Prim) -> bool, found: &str) -> Vec<Place> {
    stage.prims.iter().filter(|p| is(p)).map(|p| at_prim(p, found)).collect()
}

fn is_off(prim: &Prim, flag: &str) -> bool {
    prim.attributes.get(flag).is_some_and(|v| matches!(v.as_str(), "0" | "false"))
}

fn is_on(prim: &Prim, flag: &str) -> bool {
    prim.attributes.get(flag).is_some_and(|v| matches!(v.as_str(), "1" | "true"))
}

/// Joints whose friction or speed only PhysX's attributes give.
pub(crate) fn physx_alone(stage: &Stage) -> Vec<Place> {
    let mut places = Vec::new();
    for prim in &stage.prims {
        let says = |word: &str, newton: &str| {
            !prim.attributes.contains_key(newton)
                && prim.attributes.keys().any(|k| {
                    let k = k.to_lowercase();
                    k.starts_with("physxjoint") && k.contains(word)
                })
        };
        let (rubs, speeds) =
            (says("friction", "newton:friction"), says("maxjointvelocity", "newton:velocityLimit"));
        match (rubs, speeds) {
            (true, true) => places.push(at_prim(prim, "friction and speed")),
            (true, false) => places.push(at_prim(prim, "friction")),
            (false, true) => places.push(at_prim(prim, "speed")),
            _ => {}
        }
    }
    places
}

/// Bodies that are switched off.
pub(crate) fn disabled_bodies(stage: &Stage) -> Vec<Place> {
    let off = |p: &Prim| p.has("PhysicsRigidBodyAPI") && is_off(p, "physics:rigidBodyEnabled");
    which(stage, off, "rigidBodyEnabled = 0")
}

/// Joints that are taken out of their articulation.
pub(crate) fn excluded_joints(stage: &Stage) -> Vec<Place> {
    let out = |p: &Prim| {
        p.kind.starts_with("Physics")
            && p.kind.ends_with("Joint")
            && is_on(p, "physics:excludeFromArticulation")
    };
    which(stage, out, "excludeFromArticulation = 1")
}

/// Joints of six axes of which some are limited and some are not mentioned.
pub(crate) fn free_axes(stage: &Stage) -> Vec<Place> {
    let axes = ["transX", "transY", "transZ", "rotX", "rotY", "rotZ"];
    let mut places = Vec::new();
    for prim in stage.prims.iter().filter(|p| p.kind == "PhysicsJoint") {
        let is_told = |axis: &&&str| prim.has(&format!("PhysicsLimitAPI:{axis}"));
        let told = axes.iter().filter(is_told).count();
        if told > 0 && told < axes.len() {
            let free = axes.iter().filter(|a| !is_told(a)).copied().collect::<Vec<_>>().join(", ");
            places.push(at_prim(prim, &format!("no limit for {free}")));
        }
    }
    places
}

/// Bodies with a centre of mass and without moments.
pub(crate) fn centre_alone(stage: &Stage) -> Vec<Place> {
    let is = |p: &Prim| {
        p.attributes.contains_key("physics:centerOfMass")
            && !p.attributes.contains_key("physics:diagonalInertia")
    };
    which(stage, is, "centerOfMass without diagonalInertia")
}

/// Prims that mirror a mesh which is seen only.
pub(crate) fn mirrored(stage: &Stage) -> Vec<Place> {
    let mirrors = |p: &Prim| {
        let scales = p.attributes.iter().filter(|(k, _)| k.starts_with("xformOp:scale"));
        let mut signs = scales
            .map(|(_, v)| v.split_whitespace().filter(|w| w.starts_with('-')).count() % 2 == 1);
        signs.any(|odd| odd)
    };
    let seen_only = |p: &&Prim| p.kind == "Mesh" && !p.has("PhysicsCollisionAPI");
    let mut mirrors_it = BTreeSet::new();
    for mesh in stage.prims.iter().filter(seen_only) {
        let mut here = Some(mesh);
        while let Some(prim) = here {
            if mirrors(prim) {
                mirrors_it.insert((prim.line, prim.name.as_str()));
            }
            here = prim.parent.and_then(|p| stage.prims.get(p));
        }
    }
    let told = mirrors_it.into_iter();
    told.map(|(line, name)| at("prim", name, line, "mirrors a visual")).collect()
}

/// Hinges and slides of which one end is written.
pub(crate) fn one_sided(stage: &Stage) -> Vec<Place> {
    let is = |p: &Prim| {
        let has = |name: &str| p.attributes.contains_key(name);
        matches!(p.kind.as_str(), "PhysicsRevoluteJoint" | "PhysicsPrismaticJoint")
            && has("physics:lowerLimit") != has("physics:upperLimit")
    };
    which(stage, is, "one limit alone")
}

/// Colliders that are switched off on a body whose mass is not written.
pub(crate) fn disabled_colliders(stage: &Stage) -> Vec<Place> {
    let mut places = Vec::new();
    for (i, prim) in stage.prims.iter().enumerate() {
        if !prim.has("PhysicsCollisionAPI") || !is_off(prim, "physics:collisionEnabled") {
            continue;
        }
        let (mut here, mut body) = (Some(i), None);
        while let Some(at) = here {
            let Some(above) = stage.prims.get(at) else { break };
            if above.has("PhysicsRigidBodyAPI") {
                body = Some(above);
                break;
            }
            here = above.parent;
        }
        if body.is_some_and(|b| !b.attributes.contains_key("physics:mass")) {
            places.push(at_prim(prim, "collisionEnabled = 0"));
        }
    }
    places
}
