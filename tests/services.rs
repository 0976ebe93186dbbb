//! A Hunyuan3D server and a chat server in one, whose answers are made from a mesh and a condition.
#![cfg(unix)]

use std::path::Path;

use base64::Engine as _;
use object::kinematics::JointKind;
use object::{Condition, DVec3, Mesh, glb};
use serde_json::{Value, json};
use view::{Camera, Unprojector, eight_views};

use crate::server::{Answer, Asked, Server};

/// Pixels of a view.
const SIZE: u32 = 1024;

/// Everything such a server knows of one object.
#[derive(Clone)]
pub struct Object {
    /// The mesh file.
    pub mesh: Vec<u8>,
    /// The answer to the question for parts.
    pub parts: Value,
    /// The answer to the question where they are.
    pub points: Value,
    /// The answer to the question how large it is and what it is made of.
    pub physical: Value,
    /// What is said when it is asked what looks wrong.
    pub flags: Said,
}

/// What a model says.
#[derive(Clone, Debug)]
pub enum Said {
    /// This.
    Answer(Value),
    /// That it will not.
    Refusal,
}

impl Object {
    /// What a model that knows the condition would answer.
    pub fn of(mesh: &Path, condition: &Condition) -> Self {
        let file = std::fs::read(mesh).unwrap();
        let surface = glb::read(&file).unwrap();
        let (parts, points) = (parts(condition), points(&surface, condition));
        let flags = Said::Answer(flags(condition));
        Self { parts, points, physical: physical(condition), flags, mesh: file }
    }

    /// Answers a request of either protocol.
    pub fn answer(&self, asked: &Asked) -> Answer {
        match (asked.method.as_str(), asked.path.as_str()) {
            ("POST", "/send") => Answer::json(200, &json!({ "uid": "job-1" })),
            ("GET", "/status/job-1") => {
                let mesh = base64::engine::general_purpose::STANDARD.encode(&self.mesh);
                Answer::json(200, &json!({ "status": "completed", "model_base64": mesh }))
            }
            ("POST", "/v1/chat/completions") => self.chat(&asked.json()),
            _ => Answer::json(404, &json!({ "error": "no such place" })),
        }
    }

    fn chat(&self, asked: &Value) -> Answer {
        let schema = asked.pointer("/response_format/json_schema/name").unwrap();
        let content = match schema.as_str().unwrap() {
            "kinematics" => &self.parts,
            "points" => &self.points,
            "physical" => &self.physical,
            _ => match &self.flags {
                Said::Answer(flags) => flags,
                Said::Refusal => return spoken(&json!({ "refusal": "I cannot judge that" })),
            },
        };
        spoken(&json!({ "role": "assistant", "content": content.to_string() }))
    }

    /// Starts a server that answers so.
    pub fn serve(self) -> Server {
        Server::start(move |asked| self.answer(asked))
    }
}

/// A whole answer with some message in it.
fn spoken(message: &Value) -> Answer {
    Answer::json(
        200,
        &json!({ "choices": [{ "finish_reason": "stop", "message": message }],
            "usage": { "prompt_tokens": 3000, "completion_tokens": 200 } }),
    )
}

/// A configuration that asks such a server for everything.
pub fn config(port: u16) -> String {
    format!(
        "[image_to_3d]\nprovider = \"hunyuan\"\nbase = \"http://127.0.0.1:{port}\"\nqueue = true\n\
         [vlm]\nprovider = \"openai\"\nbase = \"http://127.0.0.1:{port}/v1\"\nmodel = \"some-vlm\"\n"
    )
}

fn parts(condition: &Condition) -> Value {
    let part = |(n, part): (usize, &object::kinematics::Part)| {
        let joints: Vec<_> = part.joints.iter().map(word).collect();
        json!({ "id": format!("p{n}"), "name": part.name, "text": part.text,
            "parent": part.parent.map(|p| format!("p{p}")), "joint_types": joints,
            "motion": "it moves", "visible_views": [1], "confidence": "high" })
    };
    let parts: Vec<_> = condition.tree.parts().iter().enumerate().map(part).collect();
    json!({ "verdict": "articulated", "category": condition.category, "description": "an object",
        "has_canonical_orientation": true, "front_view": 1, "parts": parts })
}

fn physical(condition: &Condition) -> Value {
    let part = |n: usize| {
        json!({ "part_id": format!("p{n}"), "material": "plastic", "density_kg_m3": 1100,
            "construction": "solid", "wall_thickness_m": null, "mass_kg_min": 0.5,
            "mass_kg_max": 1.0, "static_friction": 0.5, "dynamic_friction": 0.4 })
    };
    let parts: Vec<_> = (0..condition.tree.len()).map(part).collect();
    json!({ "scale": { "dimension": "height", "meters_min": 0.3, "meters_best": 0.4,
        "meters_max": 0.5, "basis": "such objects" }, "parts": parts })
}

/// All is well with every part that moves but for the first.
fn flags(condition: &Condition) -> Value {
    let parts = condition.tree.parts().iter().enumerate();
    let moving = parts.filter(|(_, part)| !part.joints.is_empty());
    let flag = |(n, (id, _)): (usize, (usize, _))| {
        let (fault, reason) = if n == 0 { ("axis", "it turns sideways") } else { ("none", "") };
        json!({ "part_id": format!("p{id}"), "fault": fault, "reason": reason })
    };
    json!({ "flags": moving.enumerate().map(flag).collect::<Vec<_>>() })
}

fn word(kind: &JointKind) -> &'static str {
    match kind {
        JointKind::Prismatic => "prismatic",
        _ => "revolute",
    }
}

/// Where the prompt points are seen: a pixel of each view that shows one, up to three.
fn points(mesh: &Mesh, condition: &Condition) -> Value {
    let (rays, views) = (Unprojector::new(mesh), eight_views(&mesh.bounds(), SIZE));
    let (mut points, mut hidden) = (vec![], vec![]);
    for (n, prompt) in condition.prompts.iter().enumerate() {
        let id = format!("p{n}");
        let seen = |(v, camera): (usize, &Camera)| {
            let place = prompt.point?;
            let [x, y] = pixel(camera, place)?;
            let hit = rays.pixel(camera, [x, y])?.position;
            (hit.distance(place) < 0.01 * mesh.bounds().diagonal()).then(
                || json!({ "part_id": id, "view": v + 1, "point_2d": [x as i64, y as i64], "label": id }),
            )
        };
        let cameras = views.iter().map(|v| &v.camera).enumerate();
        let shown: Vec<_> = cameras.filter_map(seen).take(3).collect();
        if shown.is_empty() {
            hidden.push(id.clone());
        }
        points.extend(shown);
    }
    json!({ "points": points, "not_visible": hidden })
}

fn pixel(camera: &Camera, place: DVec3) -> Option<[f64; 2]> {
    Some(camera.project(place)?.pixel.map(f64::round))
}
