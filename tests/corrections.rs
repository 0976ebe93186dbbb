//! A person corrects what was found, in the condition: it stands in the asset as it was said, in every
//! format, and what cannot be is in the verdict.

use object::DVec3;
use roxmltree::Document;
use serde_json::{Value, json};

use crate::cabinet::{condition, in_file, mesh};
use crate::kinfold::{Bench, program, say};

/// The cabinet, its door corrected.
fn corrected(corrections: &Value) -> Bench {
    let bench = Bench::new();
    let mut condition = condition();
    condition["schema"] = json!("kinfold-condition/2");
    for (field, value) in corrections.as_object().unwrap() {
        condition["parts"][1][field] = value.clone();
    }
    bench.cabinet.write_condition(&condition);
    bench
}

fn numbers(text: &str) -> Vec<f64> {
    text.split_whitespace().map(|word| word.parse().unwrap()).collect()
}

/// The door's joint as `asset.json` has it.
fn joint(bench: &Bench) -> Value {
    let asset: Value = serde_json::from_slice(&bench.out()["asset.json"]).unwrap();
    let joints = asset["joints"].as_array().unwrap();
    joints.iter().find(|j| j["name"] == "door_turn").unwrap().clone()
}

#[test]
fn axis_pivot_range_and_drive_stand_in_every_format_as_they_were_given() {
    let axis = DVec3::new(0.0005, 0.0003, 1.0).normalize();
    let pivot = DVec3::new(0.2, -0.002, 0.25);
    let bench = corrected(&json!({
        "axis": in_file((axis * 3.0).to_array()), "pivot": in_file(pivot.to_array()),
        "range": [0, "80°"], "rest": 0, "effort": 6.5, "damping": 0.75,
    }));
    let said = bench.made(&["--export", "mjcf,usd,glb"]);
    assert_eq!(said.code, Some(0), "{said:?}");
    let near = |found: &[f64], wanted: &[f64], of: &str| {
        let off = found.iter().zip(wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(found.len() == wanted.len() && off < 1e-6, "{of}: {found:?}, not {wanted:?}");
    };
    let upper = 80f64.to_radians();
    let out = bench.out();
    let text = |name: &str| std::str::from_utf8(&out[name]).unwrap().to_owned();
    // The cabinet is its own size, and stands with the middle of its body at x = y = 0.
    let there = pivot - DVec3::new(0.0, 0.15, 0.0);
    let urdf = text("asset.urdf");
    let urdf = Document::parse(&urdf).unwrap();
    let door = urdf.descendants().find(|n| n.attribute("name") == Some("door_turn")).unwrap();
    let tag = |tag: &str| door.children().find(|n| n.has_tag_name(tag)).unwrap();
    near(&numbers(tag("axis").attribute("xyz").unwrap()), &axis.to_array(), "URDF axis");
    let limit = |name: &str| tag("limit").attribute(name).unwrap().parse::<f64>().unwrap();
    near(&[limit("lower"), limit("upper"), limit("effort")], &[0.0, upper, 6.5], "URDF limits");
    near(&numbers(tag("dynamics").attribute("damping").unwrap()), &[0.75], "URDF damping");
    near(&numbers(tag("origin").attribute("xyz").unwrap()), &there.to_array(), "URDF origin");
    let mjcf = text("asset.xml");
    let mjcf = Document::parse(&mjcf).unwrap();
    let door = mjcf
        .descendants()
        .find(|n| n.has_tag_name("joint") && n.attribute("name") == Some("door_turn"));
    let door = door.unwrap();
    near(&numbers(door.attribute("axis").unwrap()), &axis.to_array(), "MJCF axis");
    near(&numbers(door.attribute("range").unwrap()), &[0.0, upper], "MJCF range");
    near(&numbers(door.parent().unwrap().attribute("pos").unwrap()), &there.to_array(), "MJCF pos");
    let usd = text("asset.usda");
    let after = |word: &str| {
        let door = &usd[usd.find("\"door_turn\"").unwrap()..];
        let value = &door[door.find(word).unwrap() + word.len()..];
        let value: String = value.chars().take_while(|c| *c != '\n').collect();
        numbers(&value.replace(['(', ')', ',', '='], " "))
    };
    near(&after("physics:localPos0"), &there.to_array(), "USD position");
    near(
        &[after("physics:lowerLimit")[0], after("physics:upperLimit")[0]],
        &[0.0, 80.0],
        "USD limits",
    );
    let rotation = after("physics:localRot0");
    let turn = object::DQuat::from_xyzw(rotation[1], rotation[2], rotation[3], rotation[0]);
    near(&(turn * DVec3::X).to_array(), &axis.to_array(), "USD axis");
    let glb = &out["asset.glb"];
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let json: Value = serde_json::from_slice(&glb[20..20 + length]).unwrap();
    let node = json["nodes"].as_array().unwrap().iter().find(|n| n["name"] == "door").unwrap();
    let place: Vec<f64> =
        node["translation"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
    near(&place, &in_file(there.to_array()), "GLB translation");
    for (number, value) in [("axis", None), ("effort", Some(6.5)), ("damping", Some(0.75))] {
        let found = &joint(&bench)[number];
        assert_eq!(found["origin"], "user", "{number}: {found}");
        assert!(value.is_none_or(|value: f64| found["value"] == json!(value)), "{found}");
    }
}

#[test]
fn a_trace_tells_what_was_given_by_hand() {
    let off = in_file([0.2, 0.15, 0.3]);
    let bench = corrected(&json!({
        "axis": in_file([0.0, 0.0, 1.0]), "pivot": in_file([0.2, -0.002, 0.25]), "not": [off],
    }));
    assert_eq!(bench.made(&[]).code, Some(0));
    let out = bench.path("out").display().to_string();
    let shown = say(&["trace", "show", &out]);
    let line = shown.out.lines().find(|line| line.starts_with("by hand ")).unwrap();
    let expected = ["by", "hand", "door", "axis,", "pivot,", "1", "point", "that", "is", "not"];
    assert!(line.split_whitespace().take(10).eq(expected), "{line}");
    let json: Value = serde_json::from_str(&say(&["trace", "show", &out, "--json"]).out).unwrap();
    let given = json!(["axis", "pivot", "1 point that is not on it"]);
    assert_eq!(json["by_hand"], json!([{ "part": "door", "given": given }]));
    let untouched = Bench::done();
    let shown = say(&["trace", "show", untouched.path("out").to_str().unwrap()]);
    assert!(!shown.out.contains("by hand"), "{}", shown.out);
}

#[test]
fn a_range_that_is_blocked_is_kept_and_the_verdict_says_so() {
    let bench = corrected(&json!({ "range": ["-60°", "60°"] }));
    let said = bench.made(&[]);
    assert_eq!(said.code, Some(3), "{said:?}");
    assert!(said.err.contains("C2 no parts overlap along any joint's range"), "{said:?}");
    let third = std::f64::consts::FRAC_PI_3;
    for (end, value) in [("lower", -third), ("upper", third)] {
        let found = &joint(&bench)[end];
        assert_eq!(found["origin"], "user", "{found}");
        assert!((found["value"].as_f64().unwrap() - value).abs() < 1e-12, "{found}");
    }
    let asset: Value = serde_json::from_slice(&bench.out()["asset.json"]).unwrap();
    let changes = asset["changes"].as_array().unwrap();
    assert!(changes.iter().all(|c| c["what"] != "range" && c["what"] != "axis"), "{changes:?}");
}

/// The cabinet as an OBJ whose z is up.
fn z_up() -> String {
    let mesh = mesh();
    let vertex = |v: &DVec3| format!("v {} {} {}\n", v.x, v.y, v.z);
    let face = |f: &[u32; 3]| format!("f {} {} {}\n", f[0] + 1, f[1] + 1, f[2] + 1);
    mesh.vertices().iter().map(vertex).chain(mesh.faces().iter().map(face)).collect()
}

#[test]
fn a_mesh_with_z_up_is_read_with_the_axis_that_the_condition_or_the_command_says() {
    let size = |points: bool, say: &str, arguments: &[&str]| {
        let bench = Bench::new();
        std::fs::write(bench.path("cabinet.obj"), z_up()).unwrap();
        let mut condition = condition();
        if !say.is_empty() {
            condition["up"] = json!(say);
        }
        for part in condition["parts"].as_array_mut().unwrap() {
            let [x, y, z] = [0, 1, 2].map(|i| part["point"][i].as_f64().unwrap());
            part["point"] = json!([x, -z, y]);
            if !points {
                part.as_object_mut().unwrap().remove("point");
            }
        }
        bench.cabinet.write_condition(&condition);
        let mut make = program();
        make.current_dir(bench.path("")).env("KINFOLD_STATE", bench.path("state"));
        make.args(["make", "photo.png", "--mesh", "cabinet.obj", "--condition", "cabinet.json"]);
        let said = make.args(["--out", "out"]).args(arguments).output().unwrap();
        assert_eq!(said.status.code(), Some(0), "{}", String::from_utf8_lossy(&said.stderr));
        let asset: Value = serde_json::from_slice(&bench.out()["asset.json"]).unwrap();
        let found = |i: usize| asset["size"]["value"][i].as_f64().unwrap();
        [found(0), found(1), found(2)].map(|side| (side * 1e3).round() / 1e3)
    };
    let upright = [0.4, 0.322, 0.6];
    assert_eq!(size(true, "z", &[]), upright);
    assert_eq!(size(false, "z", &[]), upright);
    assert_eq!(size(true, "", &["--up", "z"]), upright);
}

#[test]
fn the_command_and_the_condition_do_not_contradict_each_other() {
    let bench = corrected(&json!({}));
    let mut condition = condition();
    condition["up"] = json!("y");
    bench.cabinet.write_condition(&condition);
    let said = bench.made(&["--up", "z"]);
    assert_eq!(said.code, Some(2), "{said:?}");
    assert!(said.err.contains("--up z, but the condition says `up` is y"), "{said:?}");
}
