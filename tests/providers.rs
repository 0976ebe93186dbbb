//! From a photo alone to a verdict, with a program for the mesh and a chat server for the parts.
#![cfg(unix)]

use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::path::Path;

use object::{DVec3, glb};
use serde_json::{Value, json};
use view::{Unprojector, eight_views};

use crate::cabinet::Cabinet;
use crate::kinfold::{CLOCK, Said, program_in};

/// Pixels of a view.
const SIZE: u32 = 1024;
/// On the body's right side and on the door's front.
const PLACES: [(&str, DVec3); 2] =
    [("p0", DVec3::new(0.2, 0.17, 0.33)), ("p1", DVec3::new(0.05, -0.022, 0.31))];

pub fn parts() -> Value {
    let part = |id: &str, text: &str, parent: Option<&str>, joints: &[&str]| {
        json!({ "id": id, "name": text, "text": text, "parent": parent, "joint_types": joints,
            "motion": "it moves", "visible_views": [1], "confidence": "high" })
    };
    json!({ "verdict": "articulated", "category": "cabinet", "description": "a cabinet",
        "has_canonical_orientation": false, "front_view": 1,
        "parts": [part("p0", "cabinet body", None, &[]),
            part("p1", "cabinet door", Some("p0"), &["revolute"])] })
}

pub fn physical() -> Value {
    let part = |id: &str| {
        json!({ "part_id": id, "material": "engineered_wood", "density_kg_m3": 650,
            "construction": "panel", "wall_thickness_m": 0.02, "mass_kg_min": 2.0,
            "mass_kg_max": 5.0, "static_friction": 0.5, "dynamic_friction": 0.4 })
    };
    json!({ "scale": { "dimension": "height", "meters_min": 0.4, "meters_best": 0.6,
        "meters_max": 1.0, "basis": "such cabinets" }, "parts": [part("p0"), part("p1")] })
}

/// Where the places are seen: a pixel of the first view that shows each.
pub fn points(mesh: &Path) -> Value {
    let mesh = glb::read(&std::fs::read(mesh).unwrap()).unwrap();
    let (rays, views) = (Unprojector::new(&mesh), eight_views(&mesh.bounds(), SIZE));
    let seen = |(id, place): (&str, DVec3)| {
        let mut shown = views.iter().enumerate().filter_map(|(n, view)| {
            let [x, y] = view.camera.project(place)?.pixel.map(f64::round);
            let hit = rays.pixel(&view.camera, [x, y])?.position;
            (hit.distance(place) < 0.01).then(|| {
                json!({ "part_id": id, "view": n + 1,
                "point_2d": [x as i64, y as i64], "label": id })
            })
        });
        shown.next().unwrap()
    };
    json!({ "points": PLACES.map(seen), "not_visible": [] })
}

/// A chat server that answers each of the three questions; how often it was asked.
pub fn chat(points: Value) -> (u16, std::thread::JoinHandle<usize>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    let serve = move || {
        for question in ["kinematics", "points", "physical"] {
            let (mut stream, _) = listener.accept().unwrap();
            let asked = body(&stream);
            let schema = &asked["response_format"]["json_schema"];
            assert_eq!((&asked["model"], &schema["name"]), (&"some-vlm".into(), &question.into()));
            let content = match question {
                "kinematics" => parts().to_string(),
                "points" => points.to_string(),
                _ => physical().to_string(),
            };
            let answer = json!({ "choices": [{ "finish_reason": "stop",
                "message": { "role": "assistant", "content": content } }] });
            let answer = answer.to_string();
            let head = "HTTP/1.1 200 OK\r\ncontent-type: application/json\r\nconnection: close\r\n";
            write!(stream, "{head}content-length: {}\r\n\r\n{answer}", answer.len()).unwrap();
        }
        3
    };
    (port, std::thread::spawn(serve))
}

/// The JSON a client sends.
pub fn body(stream: &TcpStream) -> Value {
    let mut reader = BufReader::new(stream);
    let (mut length, mut line) = (0, String::new());
    while reader.read_line(&mut line).unwrap() > 2 {
        if let Some(value) = line.to_ascii_lowercase().strip_prefix("content-length:") {
            length = value.trim().parse().unwrap();
        }
        line.clear();
    }
    let mut bytes = vec![0; length];
    reader.read_exact(&mut bytes).unwrap();
    serde_json::from_slice(&bytes).unwrap()
}

#[test]
fn a_photo_becomes_a_checked_asset_through_a_program_and_a_chat_server() {
    let folder = tempfile::tempdir().unwrap();
    let cabinet = Cabinet::write(folder.path());
    let (port, server) = chat(points(&cabinet.mesh));
    let config = format!(
        "[image_to_3d]\nprovider = \"command\"\nprogram = \"cp\"\narguments = [{:?}, \"{{mesh}}\"]\n\
         [vlm]\nprovider = \"openai\"\nbase = \"http://127.0.0.1:{port}/v1\"\nmodel = \"some-vlm\"\n",
        cabinet.mesh.display().to_string(),
    );
    std::fs::write(folder.path().join("kinfold.toml"), config).unwrap();
    let make = || -> Said {
        let mut command = program_in(folder.path());
        command.env("KINFOLD_STATE", folder.path().join("state"));
        command.args(["make", "photo.png", "--out", "out", "--clock", CLOCK]);
        command.output().unwrap().into()
    };
    let said = make();
    assert_eq!(said.code, Some(0), "{said:?}");
    assert_eq!(server.join().unwrap(), 3, "each question is asked once");
    let urdf = std::fs::read_to_string(folder.path().join("out/asset.urdf")).unwrap();
    assert_eq!(urdf.matches("type=\"revolute\"").count(), 1, "{urdf}");
    // A view's number is the one in its picture: each point is where it was meant to be.
    let trace = trace::read(&folder.path().join("out/trace.mcap")).unwrap();
    let condition = trace.attachments.iter().find(|a| a.name == "condition.json").unwrap();
    let condition: object::Condition = serde_json::from_slice(&condition.bytes).unwrap();
    for (prompt, (_, place)) in condition.prompts.iter().zip(PLACES) {
        let found = prompt.point.unwrap();
        assert!(found.distance(place) < 0.01, "{found} is not {place}");
    }
    let again = make();
    assert_eq!((again.code, again.out), (Some(0), said.out), "nobody is asked a second time");
}
