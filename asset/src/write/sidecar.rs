//! `asset.json`: where every number of the package comes from, what was changed, and digests of the
//! files.

use std::collections::BTreeMap;

use glamx::{DMat3, DQuat, DVec3};
use object::confidence::Doubt;
use object::{Origin, Sourced};
use serde::Serialize;

use crate::asset::{Asset, JointType, Link, LinkBody};
use crate::change::Change;
use crate::surface::repaired::Report;
use crate::write::appearance::look::AssetAppearance;
use crate::write::paths::MeshPaths;

/// Schema of `asset.json`.
pub(crate) const SCHEMA: &str = "kinfold-asset/1";

/// A value with its unit and origin.
#[derive(Serialize)]
struct Number<T> {
    value: T,
    unit: &'static str,
    origin: Origin,
    how: String,
}

#[derive(Serialize)]
struct Description<'a> {
    schema: &'static str,
    name: &'a str,
    category: &'a str,
    frame: &'static str,
    scale: Number<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    turn_xyzw: Option<[f64; 4]>,
    offset_m: DVec3,
    size: Number<DVec3>,
    mass_kg: f64,
    links: Vec<LinkEntry<'a>>,
    joints: Vec<JointEntry<'a>>,
    changes: &'a [Change],
    /// What of the mesh file and of how it looks did not come along.
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    left_out: &'a [String],
    /// How likely all of it is right.
    #[serde(skip_serializing_if = "Option::is_none")]
    confidence: Option<Number<f64>>,
    /// Paths of every number above that is a default.
    defaults: Vec<String>,
    files: BTreeMap<&'a str, String>,
}

#[derive(Serialize)]
struct LinkEntry<'a> {
    name: &'a str,
    label: &'a str,
    graspable: bool,
    mass: Number<f64>,
    centre_of_mass: Number<DVec3>,
    inertia: Number<Tensor>,
    #[serde(flatten)]
    body: Option<BodyEntry<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    confidence: Option<LinkSureness<'a>>,
}

/// How likely the surface of a link is right.
#[derive(Serialize)]
struct LinkSureness<'a> {
    labels: Number<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    doubt: Option<DoubtEntry<'a>>,
}

/// A piece of a link that may be another link's.
#[derive(Serialize)]
struct DoubtEntry<'a> {
    other: &'a str,
    chance: Number<f64>,
    share: Number<f64>,
    at: Number<DVec3>,
}

/// How likely a joint is right.
#[derive(Serialize)]
struct JointSureness {
    axis: Number<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    line: Option<Number<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    way: Option<Number<f64>>,
    joint: Number<f64>,
}

#[derive(Serialize)]
struct BodyEntry<'a> {
    material: Number<&'a str>,
    density: Number<f64>,
    wall: Number<f64>,
    volume: Number<f64>,
    friction: Number<f64>,
    colour: Number<[f64; 4]>,
    visual: &'a str,
    /// One for each material, where there are several.
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    visuals: &'a [String],
    visual_faces: usize,
    repaired: Report,
    collision: &'a [String],
}

/// An inertia tensor by its six products.
#[derive(Serialize)]
struct Tensor {
    ixx: f64,
    ixy: f64,
    ixz: f64,
    iyy: f64,
    iyz: f64,
    izz: f64,
}

#[derive(Serialize)]
struct JointEntry<'a> {
    name: &'a str,
    #[serde(rename = "type")]
    kind: JointType,
    parent: &'a str,
    child: &'a str,
    origin: Number<DVec3>,
    #[serde(flatten)]
    motion: Option<MotionEntry>,
    #[serde(skip_serializing_if = "Option::is_none")]
    confidence: Option<JointSureness>,
}

#[derive(Serialize)]
struct MotionEntry {
    axis: Number<DVec3>,
    #[serde(skip_serializing_if = "Option::is_none")]
    lower: Option<Number<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    upper: Option<Number<f64>>,
    effort: Number<f64>,
    velocity: Number<f64>,
    damping: Number<f64>,
    friction: Number<f64>,
}

/// The text of `asset.json` for an asset whose other files are given.
pub(crate) fn describe(
    asset: &Asset,
    appearance: &AssetAppearance,
    paths: &[MeshPaths],
    files: &BTreeMap<String, Vec<u8>>,
) -> Vec<u8> {
    let digest = |(path, bytes): (&'_ String, &Vec<u8>)| {
        (path.clone(), blake3::hash(bytes).to_hex().to_string())
    };
    let digests: BTreeMap<String, String> = files.iter().map(digest).collect();
    let mut description = Description {
        schema: SCHEMA,
        name: &asset.name,
        category: &asset.category,
        frame: "right-handed, z up, standing on z = 0, base centred at x = y = 0",
        scale: number(&asset.scale, "m per unit of the mesh"),
        turn_xyzw: (asset.turn != DQuat::IDENTITY).then(|| asset.turn.to_array()),
        offset_m: asset.offset,
        size: number(&asset.size, "m"),
        mass_kg: asset.mass(),
        links: asset.links.iter().zip(paths).map(|(l, p)| link_entry(asset, l, p)).collect(),
        joints: (0..asset.joints.len()).map(|j| joint_entry(asset, j)).collect(),
        changes: &asset.changes,
        left_out: appearance.notes(),
        confidence: asset.confidence.as_ref().map(|c| chance(c.object)),
        defaults: Vec::new(),
        files: digests.iter().map(|(p, d)| (p.as_str(), d.clone())).collect(),
    };
    description.defaults = defaults(&description);
    let mut text = serde_json::to_vec_pretty(&description).unwrap_or_default();
    text.push(b'\n');
    text
}

fn number<T: Clone>(of: &Sourced<T>, unit: &'static str) -> Number<T> {
    Number { value: of.value.clone(), unit, origin: of.origin, how: of.how.clone() }
}

fn link_entry<'a>(asset: &'a Asset, link: &'a Link, paths: &'a MeshPaths) -> LinkEntry<'a> {
    let i = &link.inertial;
    let tensor = Sourced::new(tensor(i.inertia.value), i.inertia.origin, i.inertia.how.clone());
    LinkEntry {
        name: &link.name,
        label: &link.label,
        graspable: link.body.as_ref().is_some_and(|b| b.graspable),
        mass: number(&i.mass, "kg"),
        centre_of_mass: number(&i.centre, "m"),
        inertia: Number {
            value: tensor.value,
            unit: "kg m2",
            origin: tensor.origin,
            how: tensor.how,
        },
        body: link.body.as_ref().map(|b| body_entry(b, paths)),
        confidence: asset.confidence_of_link(link).map(|sure| LinkSureness {
            labels: chance(sure.labels),
            doubt: sure.doubt.as_ref().and_then(|doubt| doubt_entry(asset, doubt)),
        }),
    }
}

/// A probability: what a person gave is certain, and nothing else is.
fn chance(value: f64) -> Number<f64> {
    let (origin, how) = if value == 1.0 {
        (Origin::User, "given")
    } else {
        (Origin::Model, "boosted trees, calibrated out of fold")
    };
    Number { value, unit: "1", origin, how: how.into() }
}

fn doubt_entry<'a>(asset: &'a Asset, doubt: &Doubt) -> Option<DoubtEntry<'a>> {
    let is_other = |link: &&Link| link.part == doubt.other && link.body.is_some();
    let of_model =
        |value: f64, how: &str| Number { value, unit: "1", origin: Origin::Model, how: how.into() };
    Some(DoubtEntry {
        other: &asset.links.iter().find(is_other)?.name,
        chance: of_model(doubt.chance, "class probability"),
        share: of_model(doubt.share, "of the link's surface"),
        at: Number { value: doubt.at, unit: "m", origin: Origin::Model, how: "asset frame".into() },
    })
}

fn tensor(m: DMat3) -> Tensor {
    Tensor {
        ixx: m.x_axis.x,
        ixy: m.x_axis.y,
        ixz: m.x_axis.z,
        iyy: m.y_axis.y,
        iyz: m.y_axis.z,
        izz: m.z_axis.z,
    }
}

fn body_entry<'a>(body: &'a LinkBody, paths: &'a MeshPaths) -> BodyEntry<'a> {
    let s = &body.substance;
    BodyEntry {
        material: Number {
            value: &s.material.value,
            unit: "",
            origin: s.material.origin,
            how: s.material.how.clone(),
        },
        density: number(&s.density, "kg/m3"),
        wall: number(&s.wall, "m"),
        volume: number(&body.volume, "m3"),
        friction: number(&s.friction, "1"),
        colour: number(&body.colour, "sRGB 0 to 1"),
        visual: paths.visual(),
        visuals: if paths.visuals.len() > 1 { &paths.visuals } else { &[] },
        visual_faces: body.visual.faces().len(),
        repaired: body.repaired,
        collision: &paths.collision,
    }
}

fn joint_entry(asset: &Asset, nth: usize) -> JointEntry<'_> {
    let joint = &asset.joints[nth];
    let name = |link: usize| asset.links.get(link).map_or("", |l| l.name.as_str());
    let turns = joint.kind != JointType::Prismatic;
    let [place, force, speed, drag] =
        if turns { ["rad", "N m", "rad/s", "N m s/rad"] } else { ["m", "N", "m/s", "N s/m"] };
    let motion = joint.motion.as_ref().map(|m| MotionEntry {
        axis: number(&m.axis, "1"),
        lower: m.limits.as_ref().map(|l| number(&l[0], place)),
        upper: m.limits.as_ref().map(|l| number(&l[1], place)),
        effort: number(&m.effort, force),
        velocity: number(&m.velocity, speed),
        damping: number(&m.damping, drag),
        friction: number(&m.friction, force),
    });
    JointEntry {
        name: &joint.name,
        kind: joint.kind,
        parent: name(joint.parent),
        child: name(joint.child),
        origin: number(&joint.origin, "m"),
        motion,
        confidence: asset.confidence_of_joint(nth).map(|sure| JointSureness {
            axis: chance(sure.axis),
            line: sure.line.map(chance),
            way: sure.way.map(chance),
            joint: chance(sure.joint),
        }),
    }
}

/// Paths like `links.door.density` of everything whose origin is `default`.
fn defaults(of: &Description<'_>) -> Vec<String> {
    let mut found = Vec::new();
    let value = serde_json::to_value(of).unwrap_or_default();
    collect(&value, "", &mut found);
    found.sort();
    found
}

fn collect(value: &serde_json::Value, path: &str, found: &mut Vec<String>) {
    let below = |key: &str| if path.is_empty() { key.into() } else { format!("{path}.{key}") };
    match value {
        serde_json::Value::Object(map) => {
            if map.get("origin").and_then(|o| o.as_str()) == Some("default") {
                found.push(path.into());
            }
            map.iter().for_each(|(key, v)| collect(v, &below(key), found));
        }
        serde_json::Value::Array(list) => {
            for (i, v) in list.iter().enumerate() {
                let name = v.get("name").and_then(|n| n.as_str()).map(str::to_string);
                collect(v, &below(&name.unwrap_or_else(|| i.to_string())), found);
            }
        }
        _ => {}
    }
}
