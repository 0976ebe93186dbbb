//! Bad input gets an error that names the file, the rule and the finding, and leaves a trace alone,
//! beside the output folder.

use std::collections::BTreeMap;

use object::glb;
use serde_json::{Value, json};

use crate::cabinet::{condition, in_file, mesh, png};
use crate::kinfold::{Bench, files, names};

/// Runs a spoilt bench: exit 1, the words in the error, the stage in the trace, nothing else left.
fn refused(spoil: impl FnOnce(&Bench), stage: &str, words: &[&str]) {
    let bench = Bench::new();
    spoil(&bench);
    let said = bench.made(&[]);
    assert_eq!(said.code, Some(1), "{said:?}");
    assert!(said.out.is_empty(), "stdout is for results: {}", said.out);
    for word in words {
        assert!(said.err.contains(word), "{word:?} is missing from {}", said.err);
    }
    assert!(!bench.path("out").exists(), "nothing was published: {}", said.err);
    assert_eq!(names(&failed(&bench)), [".kinfold", "trace.mcap"], "{}", said.err);
    let (_, last) = bench.failed(1).events.last().unwrap().clone();
    assert_eq!(
        (last.stage.as_str(), last.event),
        (stage, trace::Happening::Failed),
        "{}",
        said.err
    );
    assert!(!last.notes.is_empty());
    let again = bench.made(&[]);
    assert_eq!((again.code, told(&again.err)), (Some(1), told(&said.err)));
}

/// What a run leaves that failed first.
fn failed(bench: &Bench) -> BTreeMap<String, Vec<u8>> {
    files(&bench.path("out.failed/1"))
}

/// The error, without where the trace is, which is another place each time.
fn told(text: &str) -> Vec<&str> {
    let lines = text.lines().skip_while(|line| !line.starts_with("error: "));
    lines.filter(|line| !line.starts_with("hint: the trace of this run is ")).collect()
}

fn photo(bytes: Vec<u8>, words: &[&str]) {
    refused(|b| std::fs::write(&b.cabinet.photo, bytes).unwrap(), "photo", words);
}

fn glb_bytes(bytes: Vec<u8>, words: &[&str]) {
    refused(|b| std::fs::write(&b.cabinet.mesh, bytes).unwrap(), "generate-mesh", words);
}

fn parts(edit: impl FnOnce(&mut Value), words: &[&str]) {
    let mut spoilt = condition();
    edit(&mut spoilt);
    let words = [&["error: cabinet.json: ", "hint: "], words].concat();
    refused(|b| b.cabinet.write_condition(&spoilt), "propose-condition", &words);
}

#[test]
fn a_photo_that_is_none() {
    photo(b"hello".to_vec(), &["error: photo.png: a photo must be a PNG, JPEG or WebP picture"]);
    photo(vec![], &["found an empty file"]);
    let mut torn = png(200, 200);
    torn.truncate(torn.len() / 2);
    photo(torn, &["photo.png", "decode to its last pixel"]);
}

#[test]
fn a_photo_that_is_not_there() {
    refused(|b| std::fs::remove_file(&b.cabinet.photo).unwrap(), "photo", &["error: photo.png: "]);
}

#[test]
fn a_mesh_file_that_is_none() {
    glb_bytes(vec![], &["error: cabinet.glb: "]);
    glb_bytes(b"a mesh, honestly".to_vec(), &["error: cabinet.glb: "]);
    let mut torn = glb::write(&mesh());
    torn.truncate(torn.len() * 2 / 3);
    glb_bytes(torn, &["error: cabinet.glb: "]);
    refused(
        |b| std::fs::remove_file(&b.cabinet.mesh).unwrap(),
        "generate-mesh",
        &["cabinet.glb: "],
    );
}

/// The cabinet's GLB with its JSON edited; the binary chunk stays.
fn edited_glb(edit: impl FnOnce(&mut Value)) -> Vec<u8> {
    let whole = glb::write(&mesh());
    let length = u32::from_le_bytes(whole[12..16].try_into().unwrap()) as usize;
    let mut json: Value = serde_json::from_slice(&whole[20..20 + length]).unwrap();
    edit(&mut json);
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let rest = &whole[20 + length..];
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend(((20 + text.len() + rest.len()) as u32).to_le_bytes());
    bytes.extend((text.len() as u32).to_le_bytes());
    bytes.extend(b"JSON");
    bytes.extend(text);
    bytes.extend(rest);
    bytes
}

#[test]
fn a_mesh_with_a_broken_promise() {
    glb_bytes(edited_glb(|j| j["meshes"] = json!([])), &["error: cabinet.glb: "]);
    glb_bytes(
        edited_glb(|j| j["buffers"][0]["uri"] = "file:///etc/passwd".into()),
        &["cabinet.glb: "],
    );
    glb_bytes(
        edited_glb(|j| j["accessors"][0]["count"] = 4_000_000_000_u32.into()),
        &["cabinet.glb: "],
    );
    let unknown = json!(["EXT_made_up"]);
    glb_bytes(
        edited_glb(|j| {
            j["extensionsRequired"] = unknown.clone();
            j["extensionsUsed"] = unknown;
        }),
        &["error: cabinet.glb: ", "EXT_made_up"],
    );
}

#[test]
fn a_mesh_with_nan_in_it() {
    let mut bytes = glb::write(&mesh());
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let json: Value = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
    let positions = json["meshes"][0]["primitives"][0]["attributes"]["POSITION"].as_u64().unwrap();
    let view = json["accessors"][positions as usize]["bufferView"].as_u64().unwrap();
    let offset = json["bufferViews"][view as usize]["byteOffset"].as_u64().unwrap_or(0) as usize;
    let start = 20 + length + 8 + offset;
    bytes[start..start + 4].copy_from_slice(&f32::NAN.to_le_bytes());
    glb_bytes(bytes, &["error: cabinet.glb: ", "finite"]);
}

#[test]
fn a_condition_that_is_none() {
    let write =
        |text: &'static str| move |b: &Bench| std::fs::write(&b.cabinet.condition, text).unwrap();
    let named = "error: cabinet.json: ";
    refused(write("{"), "propose-condition", &[named, "not a condition"]);
    refused(
        write("{\"schema\": \"other/9\", \"parts\": []}"),
        "propose-condition",
        &[named, "`other/9`"],
    );
    let gone = |b: &Bench| std::fs::remove_file(&b.cabinet.condition).unwrap();
    refused(gone, "propose-condition", &["error: cabinet.json: "]);
}

#[test]
fn a_condition_that_is_no_tree() {
    let push = |part: Value| move |c: &mut Value| c["parts"].as_array_mut().unwrap().push(part);
    parts(push(json!({ "name": "shelf", "parent": "nowhere" })), &["`shelf`", "`nowhere`"]);
    parts(
        push(json!({ "name": "door", "parent": "door" })),
        &["`door` has two parents, `body` and `door`"],
    );
    let cycle = |c: &mut Value| {
        let list = c["parts"].as_array_mut().unwrap();
        list.push(json!({ "name": "a", "parent": "b" }));
        list.push(json!({ "name": "b", "parent": "a" }));
    };
    parts(cycle, &["`a`, `b` form a cycle"]);
}

#[test]
fn a_condition_that_leaves_open_what_is_meant() {
    let twins = |c: &mut Value| {
        let twin = json!({ "name": "door_2", "text": "cabinet door", "parent": "body" });
        c["parts"].as_array_mut().unwrap().push(twin);
    };
    parts(twins, &["\"cabinet door\"", "`door_2` has no point"]);
    let off = |c: &mut Value| c["parts"][1]["point"] = json!(in_file([0.0, -0.5, 0.3]));
    parts(off, &["part `door`: point", "off the mesh"]);
}

#[test]
fn a_condition_that_changes_under_a_good_result_leaves_it_as_it_was() {
    let bench = Bench::done();
    let before = bench.out();
    bench.cabinet.write_condition(&json!({}));
    let said = bench.made(&[]);
    assert_eq!(said.code, Some(1));
    assert!(bench.out() == before, "the good asset changed");
    assert!(
        said.err.contains("hint: the trace of this run is out.failed/1/trace.mcap"),
        "{said:?}"
    );
    assert_eq!(names(&failed(&bench)), [".kinfold", "trace.mcap"]);
}

#[test]
fn an_error_in_json_where_json_was_asked_for() {
    let bench = Bench::new();
    std::fs::write(&bench.cabinet.photo, "no photo").unwrap();
    let said = bench.made(&["--json"]);
    let answer: Value = serde_json::from_str(&said.out).unwrap();
    assert_eq!((said.code, &answer["outcome"]), (Some(1), &json!("failed")));
    assert!(answer["error"].as_str().unwrap().starts_with("photo.png: "), "{answer}");
}

#[test]
fn a_part_without_a_face_is_reported_as_a_loss() {
    // Its prompt lies on the same component as the door's, and a box has nothing to tell it by.
    let bench = Bench::new();
    let mut crowded = condition();
    let ghost =
        json!({ "name": "ghost", "text": "invisible knob", "parent": "door", "joint": "revolute" });
    crowded["parts"].as_array_mut().unwrap().push(ghost);
    bench.cabinet.write_condition(&crowded);
    let said = bench.made(&[]);
    match said.code {
        Some(3) => assert!(said.err.contains("ghost"), "{}", said.err),
        Some(1) => assert_eq!(names(&failed(&bench)), [".kinfold", "trace.mcap"]),
        _ => panic!("a part nobody can see must not pass in silence: {said:?}"),
    }
}
