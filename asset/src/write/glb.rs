//! The asset as GLB: one named node per link, its surface in its own frame, and an animation per
//! joint that takes it through its range.
//!
//! glTF is y up, so everything is turned on the way out; a viewer shows what the URDF shows. Each
//! animation starts and ends at rest, so that any of them can be played over and over.
//!
//! A link that slides hangs under a node of its joint's name, which stands where the link rests. So
//! its key frames are the way it goes alone: added to a place, a short way would lose digits, and
//! with them its direction, in single precision.

use std::f64::consts::{FRAC_PI_2, TAU};

use glamx::{DQuat, DVec3};
use object::glb::{BinaryChunk, Faces, Textures, linear_of_srgb};
use object::mesh::{FileFrame, UpAxis};
use object::normals::{CREASE_ANGLE, corner_normals};
use serde_json::{Value, json};

use crate::asset::{Asset, Joint, JointType, Link, LinkBody, Motion};
use crate::write::appearance::look::{AssetAppearance, Group};

/// Length of one animation, seconds.
const CYCLE: f64 = 4.0;
/// Largest turn between two key frames: half of what could go either way round.
const STEP: f64 = FRAC_PI_2;

impl Asset {
    /// The asset as one GLB file; node n is link n, those after them are where sliding links rest.
    /// The same asset gives the same bytes.
    pub fn to_glb(&self) -> Vec<u8> {
        self.to_glb_with(&AssetAppearance::default())
    }

    /// The same with materials and textures, metallic and rough as they came.
    pub fn to_glb_with(&self, appearance: &AssetAppearance) -> Vec<u8> {
        let mut chunk = BinaryChunk::default();
        let mut textures = Textures::default();
        let (mut meshes, mut materials) = (Vec::new(), Vec::new());
        let mut nodes: Vec<Value> = Vec::new();
        let slides = Slides::of(self);
        for (index, link) in self.links.iter().enumerate() {
            let mut node = node(self, &slides, index);
            if let Some(body) = &link.body {
                node["mesh"] = meshes.len().into();
                let groups = appearance.materials(index);
                let mut primitives = Vec::new();
                if groups.is_empty() {
                    primitives.push(chunk.surface(&body.visual));
                    primitives[0]["material"] = materials.len().into();
                    materials.push(material(link, body));
                }
                let normals = if groups.is_empty() {
                    vec![]
                } else {
                    corner_normals(&body.visual, CREASE_ANGLE)
                };
                for Group { name, material, faces, corners, .. } in groups {
                    let of = Faces { normals: &normals, faces, corners, painted: false };
                    let mut primitive = chunk.faces(&body.visual, of);
                    primitive["material"] = materials.len().into();
                    primitives.push(primitive);
                    materials.push(textures.material(name, material));
                }
                meshes.push(json!({"name": link.name, "primitives": primitives}));
            }
            nodes.push(node);
        }
        nodes.extend(slides.rests(self));
        let mut document = json!({
            "asset": {"version": "2.0", "generator": "kinfold"},
            "scene": 0,
            "scenes": [{"name": self.name, "nodes": [0]}],
            "nodes": nodes,
            "meshes": meshes,
            "materials": materials,
        });
        textures.finish(&mut document, &mut chunk, |index| picture(appearance, index));
        let moving = self.joints.iter().filter_map(|j| Some((j, j.motion.as_ref()?)));
        let animations: Vec<_> = moving.map(|(j, m)| animation(&mut chunk, j, m)).collect();
        if !animations.is_empty() {
            document["animations"] = animations.into();
        }
        chunk.into_glb(document)
    }
}

fn to_file(p: DVec3) -> DVec3 {
    FileFrame { up: UpAxis::Y }.point_to_file(p)
}

fn single(v: DVec3) -> [f32; 3] {
    v.to_array().map(|c| c as f32)
}

/// Links that slide, each with the node where it rests: these follow the nodes of all links.
struct Slides(Vec<usize>);

impl Slides {
    fn of(asset: &Asset) -> Self {
        let slides = |j: &&Joint| j.kind == JointType::Prismatic && j.motion.is_some();
        Self(asset.joints.iter().filter(slides).map(|j| j.child).collect())
    }

    fn has(&self, link: usize) -> bool {
        self.0.contains(&link)
    }

    /// The node that carries a link: its own, or that where it rests.
    fn top(&self, asset: &Asset, link: usize) -> usize {
        let rest = self.0.iter().position(|&l| l == link);
        rest.map_or(link, |n| asset.links.len() + n)
    }

    fn rests(&self, asset: &Asset) -> impl Iterator<Item = Value> {
        self.0.iter().filter_map(|&link| {
            let joint = asset.joint_of(link)?;
            Some(json!({
                "name": joint.name,
                "translation": single(to_file(joint.origin.value)),
                "children": [link],
            }))
        })
    }
}

fn node(asset: &Asset, slides: &Slides, index: usize) -> Value {
    let link = &asset.links[index];
    let mut node = json!({"name": link.name, "extras": {"label": link.label}});
    if !slides.has(index) {
        let place = asset.joint_of(index).map_or(link.frame, |j| j.origin.value);
        node["translation"] = json!(single(to_file(place)));
    }
    let below = asset.joints.iter().filter(|j| j.parent == index);
    let children: Vec<usize> = below.map(|j| slides.top(asset, j.child)).collect();
    if !children.is_empty() {
        node["children"] = children.into();
    }
    node
}

/// A picture of the asset, as it came where that is a JPEG.
fn picture(appearance: &AssetAppearance, index: usize) -> Option<(Vec<u8>, &'static str)> {
    let file = appearance.textures.get(index)?;
    let (picture, media_type) = match &file.original {
        Some(jpeg) => (jpeg, "image/jpeg"),
        None => (&file.picture, "image/png"),
    };
    Some((picture.bytes().to_vec(), media_type))
}

/// The link's mean colour, or white where its surface has colours of its own.
fn material(link: &Link, body: &LinkBody) -> Value {
    let [r, g, b, alpha] = body.colour.value;
    let plain = [linear_of_srgb(r), linear_of_srgb(g), linear_of_srgb(b), alpha];
    let painted = body.visual.colours();
    let colour = if painted.is_some() { [1.0; 4] } else { plain };
    let is_clear = painted.map_or(alpha < 1.0, |c| c.iter().any(|c| c[3] < 255));
    json!({
        "name": link.name,
        "pbrMetallicRoughness":
            {"baseColorFactor": colour, "metallicFactor": 0.0, "roughnessFactor": 0.8},
        "doubleSided": true,
        "alphaMode": if is_clear { "BLEND" } else { "OPAQUE" },
    })
}

/// A joint from rest to its upper end, to its lower end and back to rest; once round if it has none.
fn animation(chunk: &mut BinaryChunk, joint: &Joint, motion: &Motion) -> Value {
    let frames = key_frames(joint.kind, motion);
    let times: Vec<f32> = frames.iter().map(|&(time, _)| time as f32).collect();
    let axis = to_file(motion.axis.value);
    let (path, output) = if joint.kind == JointType::Prismatic {
        let place = |&(_, q): &(f64, f64)| single(axis * q);
        ("translation", chunk.translations(&frames.iter().map(place).collect::<Vec<_>>()))
    } else {
        let turn =
            |&(_, q): &(f64, f64)| DQuat::from_axis_angle(axis, q).to_array().map(|c| c as f32);
        ("rotation", chunk.rotations(&frames.iter().map(turn).collect::<Vec<_>>()))
    };
    json!({
        "name": joint.name,
        "channels": [{"sampler": 0, "target": {"node": joint.child, "path": path}}],
        "samplers": [{"input": chunk.times(&times), "output": output, "interpolation": "LINEAR"}],
    })
}

/// Moments (seconds) and positions (radians or metres) at constant speed; at least two.
fn key_frames(kind: JointType, motion: &Motion) -> Vec<(f64, f64)> {
    let stops = match &motion.limits {
        Some([lower, upper]) => vec![upper.value, lower.value, 0.0],
        None => vec![TAU],
    };
    let step = if kind == JointType::Prismatic { f64::INFINITY } else { STEP };
    let mut places = vec![0.0];
    for stop in stops {
        let from = places.last().copied().unwrap_or_default();
        let steps = ((stop - from).abs() / step).ceil().max(1.0);
        let share = (1..=steps as usize).map(|i| i as f64 / steps);
        let between = share.map(|s| from * (1.0 - s) + stop * s);
        places.extend(between.filter(|&q| q != from));
    }
    let total: f64 = places.windows(2).map(|w| (w[1] - w[0]).abs()).sum();
    if total <= 0.0 {
        return vec![(0.0, 0.0), (CYCLE, 0.0)];
    }
    let mut way = 0.0;
    let mut frames = vec![(0.0, 0.0)];
    for w in places.windows(2) {
        way += (w[1] - w[0]).abs();
        frames.push((CYCLE * way / total, w[1]));
    }
    frames
}

#[cfg(test)]
mod tests {
    use super::*;
    use object::{Origin, Sourced};

    fn motion(limits: Option<[f64; 2]>) -> Motion {
        let number = |v| Sourced::new(v, Origin::User, "test");
        Motion {
            axis: Sourced::new(DVec3::Z, Origin::User, "test"),
            limits: limits.map(|l| l.map(number)),
            effort: number(1.0),
            velocity: number(1.0),
            damping: number(0.1),
            friction: number(0.1),
        }
    }

    #[test]
    fn a_joint_goes_to_both_ends_and_comes_back_to_rest() {
        let frames = key_frames(JointType::Prismatic, &motion(Some([-0.1, 0.3])));
        assert_eq!(frames.iter().map(|f| f.1).collect::<Vec<_>>(), [0.0, 0.3, -0.1, 0.0]);
        assert_eq!(frames.iter().map(|f| f.0).collect::<Vec<_>>(), [0.0, 1.5, 3.5, 4.0]);
        let frames = key_frames(JointType::Prismatic, &motion(Some([0.0, 0.3])));
        assert_eq!(frames, [(0.0, 0.0), (2.0, 0.3), (4.0, 0.0)]);
    }

    #[test]
    fn no_step_of_a_turn_could_go_the_other_way_round() {
        for limits in [None, Some([-3.0, 3.0])] {
            let frames = key_frames(JointType::Revolute, &motion(limits));
            assert!(frames.windows(2).all(|w| (w[1].1 - w[0].1).abs() <= STEP + 1e-12));
            assert!(frames.windows(2).all(|w| w[1].0 > w[0].0), "{frames:?}");
            assert_eq!(frames.last().unwrap().0, CYCLE);
        }
    }

    #[test]
    fn a_joint_that_goes_nowhere_still_has_an_animation() {
        let frames = key_frames(JointType::Revolute, &motion(Some([0.0, 0.0])));
        assert_eq!(frames, [(0.0, 0.0), (4.0, 0.0)]);
    }
}
