//! Servers that are not ours: a Gradio app, and a chat server that the official client speaks to.
#![cfg(unix)]

use std::io::BufRead as _;
use std::path::Path;
use std::process::{Child, Command, Stdio};

use object::Condition;
use serde_json::{Value, json};

use crate::cabinet::Cabinet;
use crate::cases;
use crate::kinfold::{CLOCK, Said, program_in, say};
use crate::services::Object;

const SCRIPT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/servers.py");

/// A server of `servers.py`, ended when it is let go.
struct Running {
    child: Child,
    port: u16,
}

impl Running {
    fn start(python: &Path, arguments: &[&str]) -> Self {
        let mut command = Command::new(python);
        command.arg(SCRIPT).args(arguments).stdout(Stdio::piped()).stderr(Stdio::inherit());
        command.env("GRADIO_ANALYTICS_ENABLED", "False").env("HF_HUB_OFFLINE", "1");
        let mut child = command.spawn().unwrap();
        let lines = std::io::BufReader::new(child.stdout.take().unwrap()).lines();
        let port = lines.map_while(Result::ok).find_map(|line| line.trim().parse().ok());
        Self { child, port: port.expect("the server says where it listens") }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Makes an asset with this configuration.
fn make(folder: &Path, config: &str) -> Said {
    std::fs::write(folder.join("kinfold.toml"), config).unwrap();
    let mut command = program_in(folder);
    command.env("KINFOLD_STATE", folder.join("state"));
    command.args(["make", "photo.png", "--out", "out", "--clock", CLOCK]);
    command.output().unwrap().into()
}

fn bodies_sent(trace: &Path, step: &str) -> Vec<Value> {
    let trace = trace::read(trace).unwrap();
    let calls = trace.calls.iter().map(|c| serde_json::from_slice::<Value>(c).unwrap());
    let asked = calls.filter(|c| c["step"].as_str().unwrap().starts_with(step));
    let body = |call: Value| {
        let name = format!("calls/{}", call["body"].as_str().unwrap());
        let kept = trace.attachments.iter().find(|a| a.name == name).unwrap();
        serde_json::from_slice(&kept.bytes).unwrap()
    };
    asked.map(body).collect()
}

#[test]
fn a_gradio_app_and_a_chat_server_make_an_asset_that_replays() {
    let Some(python) = cases::python_with("gradio, openai") else { return };
    let folder = tempfile::tempdir().unwrap();
    let cabinet = Cabinet::write(folder.path());
    let text = std::fs::read_to_string(&cabinet.condition).unwrap();
    let object = Object::of(&cabinet.mesh, &Condition::from_json(&text).unwrap());
    let answers = folder.path().join("answers.json");
    let known =
        json!({ "kinematics": object.parts, "points": object.points, "physical": object.physical });
    std::fs::write(&answers, known.to_string()).unwrap();
    let gradio = Running::start(&python, &["gradio", &cabinet.mesh.display().to_string()]);
    let chat = Running::start(&python, &["openai", &answers.display().to_string()]);
    let config = format!(
        "[image_to_3d]\nprovider = \"gradio\"\nbase = \"http://127.0.0.1:{}\"\napp = \"trellis\"\n\
         [vlm]\nprovider = \"openai\"\nbase = \"http://127.0.0.1:{}/v1\"\nmodel = \"some-vlm\"\n",
        gradio.port, chat.port
    );
    let said = make(folder.path(), &config);
    assert_eq!(said.code, Some(0), "{said:?}");
    let trace = folder.path().join("out/trace.mcap");
    let replayed = say(&["trace", "replay", &trace.display().to_string()]);
    assert_eq!(replayed.code, Some(0), "{replayed:?}");

    // The official client, given the very bodies that were sent, gets the same answers.
    let sent = folder.path().join("sent.json");
    std::fs::write(&sent, json!(bodies_sent(&trace, "vlm.")).to_string()).unwrap();
    let mut client = Command::new(&python);
    client.args([SCRIPT, "client", &chat.port.to_string(), &sent.display().to_string()]);
    let said: Said = client.output().unwrap().into();
    assert_eq!(said.code, Some(0), "{said:?}");
    let lines: Vec<Value> = said.out.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    let known = [object.parts, object.points, object.physical];
    assert_eq!(lines, known.map(|answer| json!(["stop", answer])));
}
