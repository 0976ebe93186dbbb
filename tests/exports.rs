//! The other formats: other people's loaders and validators accept them, and they say what the URDF
//! says.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use crate::kinfold::{Bench, say};
use crate::{cases, clients, examples};

/// Relative difference below which two simulators' figures are the same.
const SAME: f64 = 1e-4;

/// The folders of the examples, made with every format, and those of `KINFOLD_ASSETS`.
fn made(out: &Path) -> Vec<PathBuf> {
    let one = |name: &String| {
        let (case, target) = (examples::folder(name), out.join(name));
        let mut make = examples::make(&case, &case.join("photo.png"), &target, &out.join("state"));
        make.arg("--export").arg("urdf,mjcf,usd,glb,sdf,isaaclab").assert().success();
        target
    };
    examples::names().iter().map(one).chain(clients::more_assets()).collect()
}

fn numbers(of: &Value) -> Vec<f64> {
    of.as_array()
        .unwrap()
        .iter()
        .flat_map(|v| match v {
            Value::Array(_) => numbers(v),
            v => vec![v.as_f64().unwrap()],
        })
        .collect()
}

fn same(a: &Value, b: &Value) -> bool {
    let (a, b) = (numbers(a), numbers(b));
    let size = a.iter().chain(&b).fold(0.0_f64, |m, x| m.max(x.abs()));
    a.len() == b.len() && a.iter().zip(&b).all(|(a, b)| (a - b).abs() <= SAME * size)
}

/// Asks one client about one file.
fn ask(python: &Path, file: PathBuf, client: &str) -> Value {
    let json = clients::ask_one(python, client, &file).json;
    assert_eq!(json["error"], Value::Null, "{client}: {json}");
    json
}

#[test]
fn mujoco_reads_the_mjcf_as_it_reads_the_urdf() {
    let Some(python) = cases::python() else { return };
    let out = tempfile::tempdir().unwrap();
    for folder in made(out.path()) {
        let urdf = ask(&python, folder.join("asset.urdf"), "mujoco");
        let mjcf = ask(&python, folder.join("asset.xml"), "mujoco");
        for key in ["joints", "shapes", "joint_names", "body_names"] {
            assert_eq!(mjcf[key], urdf[key], "{}: {key}", folder.display());
        }
        for key in ["masses", "inertias", "ranges", "efforts", "damping", "friction_loss"] {
            let what = format!("{}: {key} {} {}", folder.display(), mjcf[key], urdf[key]);
            assert!(same(&mjcf[key], &urdf[key]), "{what}");
        }
        assert_eq!(mjcf["motors"], mjcf["joints"]);
        assert_eq!(mjcf["contacts_at_rest"], 0, "{}", folder.display());
        let crept = mjcf["crept_in_a_second"].as_f64().unwrap();
        assert!(crept < 1e-3, "{}: friction lets go, {crept} rad or m", folder.display());
    }
}

#[test]
fn drake_reads_the_sdf_as_it_reads_the_urdf_and_finds_an_actuator_for_each_joint() {
    let Some(python) = cases::python_with("pydrake") else { return };
    let out = tempfile::tempdir().unwrap();
    for folder in made(out.path()) {
        let urdf = ask(&python, folder.join("asset.urdf"), "drake");
        let sdf = ask(&python, folder.join("asset.sdf"), "drake");
        for key in ["joints", "shapes"] {
            assert_eq!(sdf[key], urdf[key], "{}: {key}", folder.display());
        }
        assert_eq!(urdf["actuators"], urdf["joints"], "{}", folder.display());
        let pairs = urdf["masses"].as_array().unwrap().len();
        assert!(pairs > 1 && same(&sdf["masses"], &urdf["masses"]), "{sdf} {urdf}");
    }
}

#[test]
fn python_reads_the_configurations_for_isaac_lab_and_finds_every_joint() {
    let Some(python) = cases::python_with("json") else { return };
    let out = tempfile::tempdir().unwrap();
    for folder in made(out.path()) {
        let said = ask(&python, folder.join("asset_isaaclab.py"), "python");
        let (_, joints) = links_and_joints(&folder.join("asset.urdf"));
        let configurations = said["groups"].as_object().unwrap();
        assert_eq!(configurations.len(), 2, "{said}");
        for named in configurations.values() {
            assert_eq!(*named, serde_json::json!(joints), "{}", folder.display());
        }
    }
}

#[test]
fn formats_of_several_files_stand_in_their_folders_and_the_trace_proves_them() {
    let bench = Bench::done();
    let said = bench.made(&["--export", "sdf,ros,isaaclab,simready"]);
    for file in ["out/asset.sdf\n", "out/ros\n", "out/asset_isaaclab.py\n", "out/simready\n"] {
        assert!(said.out.contains(file), "{said:?}");
    }
    let files = bench.out();
    let ends = |end: &str| files.keys().filter(|f| f.ends_with(end)).count();
    let due = [("model.config", 1), ("package.xml", 1), ("display.launch.py", 1), (".usda.png", 1)];
    for (end, count) in due {
        assert_eq!(ends(end), count, "{end} of {:?}", files.keys());
    }
    let [ros, simready] =
        ["ros/", "simready/"].map(|folder| files.keys().filter(|f| f.starts_with(folder)).count());
    assert!(ros > 5 && simready == 5, "{:?}", files.keys());
    let verified = say(&["trace", "verify", bench.path("out").to_str().unwrap()]);
    assert_eq!(verified.code, Some(0), "{verified:?}");
    bench.made(&[]);
    assert!(bench.out().keys().all(|f| !f.starts_with("ros/") && f != "asset.sdf"));
}

#[test]
fn usd_passes_its_own_validators_and_says_what_the_urdf_says() {
    let Some(python) = cases::python_with("pxr.UsdValidation") else { return };
    let out = tempfile::tempdir().unwrap();
    for folder in made(out.path()) {
        let usd = ask(&python, folder.join("asset.usda"), "usd");
        assert!(usd["validators"].as_u64().unwrap() >= 25, "{usd}");
        assert_eq!(usd["findings"], serde_json::json!([]), "{}", folder.display());
        assert_eq!(usd["up_axis"], "Z");
        assert_eq!(usd["metres_per_unit"], 1.0);
        let urdf = ask(&python, folder.join("asset.urdf"), "pinocchio");
        assert_eq!((&usd["joints"], &usd["shapes"]), (&urdf["joints"], &urdf["shapes"]));
        let urdf = ask(&python, folder.join("asset.urdf"), "mujoco");
        assert_eq!(usd["joint_names"], urdf["joint_names"]);
        for key in ["masses", "inertias", "ranges", "efforts"] {
            let what = format!("{}: {key} {} {}", folder.display(), usd[key], urdf[key]);
            assert!(same(&usd[key], &urdf[key]), "{what}");
        }
    }
}

/// NVIDIA's warning that stands: bodies of one part that touch keep points of their own, for with
/// one point the surface would not be manifold.
const TOUCHING: &str = "WARNING WeldChecker: Some points are co-located";

#[test]
fn nvidias_validator_finds_nothing_in_the_usd() {
    let Some(python) = cases::python_of_usd() else { return };
    let out = tempfile::tempdir().unwrap();
    let files: Vec<_> = made(out.path()).into_iter().map(|f| f.join("asset.usda")).collect();
    let answers = clients::ask_all(&python, &files);
    let answers: Vec<_> = answers.iter().filter(|a| a.client == "nvidia").collect();
    assert_eq!(answers.len(), files.len());
    let found: Vec<_> = answers
        .iter()
        .flat_map(|answer| {
            let file = answer.file.display();
            let findings = answer.json["findings"].as_array();
            let findings = findings.unwrap_or_else(|| panic!("{file}: {}", answer.json));
            let told = findings.iter().map(|f| f.as_str().unwrap());
            told.filter(|f| !f.starts_with(TOUCHING)).map(move |f| format!("{file}: {f}"))
        })
        .collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
}

/// The folder with Khronos' validator: `KINFOLD_GLTF_VALIDATOR`, or the repository's `node_modules`.
fn gltf_validator() -> Option<PathBuf> {
    let default = concat!(env!("CARGO_MANIFEST_DIR"), "/../.venv/node_modules/gltf-validator");
    let folder = std::env::var_os("KINFOLD_GLTF_VALIDATOR").map_or(default.into(), PathBuf::from);
    let has_node = Command::new("node").arg("--version").output().is_ok();
    if has_node && folder.is_dir() {
        return Some(folder);
    }
    eprintln!("SKIPPED: no node, or no gltf-validator at {}", folder.display());
    None
}

#[test]
fn glb_passes_khronos_validator_without_a_word() {
    const SCRIPT: &str = "const [folder, file] = process.argv.slice(1);
        const bytes = new Uint8Array(require('fs').readFileSync(file));
        require(folder).validateBytes(bytes).then(r => console.log(JSON.stringify(r)));";
    let Some(validator) = gltf_validator() else { return };
    let out = tempfile::tempdir().unwrap();
    for folder in made(out.path()) {
        let mut node = Command::new("node");
        node.args(["-e", SCRIPT]).arg(&validator).arg(folder.join("asset.glb"));
        let output = node.output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{said}");
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        let issues = &report["issues"];
        let counts = ["numErrors", "numWarnings"].map(|key| issues[key].as_u64());
        assert_eq!(counts, [Some(0); 2], "{issues:#}");
        let (links, joints) = links_and_joints(&folder.join("asset.urdf"));
        assert_eq!(report["info"]["animationCount"].as_u64(), Some(joints.len() as u64));
        let nodes = names(&folder.join("asset.glb"), "nodes");
        let (own, rests) = nodes.split_at(links.len());
        assert_eq!(own, links);
        assert!(rests.iter().all(|name| joints.contains(name)), "{rests:?}");
        assert_eq!(names(&folder.join("asset.glb"), "animations"), joints);
    }
}

/// Names of links and of moving joints, in the order of the URDF.
fn links_and_joints(urdf: &Path) -> (Vec<String>, Vec<String>) {
    let text = std::fs::read_to_string(urdf).unwrap();
    let name = |line: &str| line.split('"').nth(1).unwrap().to_owned();
    let links = text.lines().filter(|l| l.trim().starts_with("<link name")).map(name);
    // A transmission names joints, too, but gives them no type.
    let is_moving = |l: &&str| {
        l.trim().starts_with("<joint name") && l.contains(" type=") && !l.contains("\"fixed\"")
    };
    (links.collect(), text.lines().filter(is_moving).map(name).collect())
}

/// Names in a list of a GLB's JSON.
fn names(glb: &Path, list: &str) -> Vec<String> {
    let bytes = std::fs::read(glb).unwrap();
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let json: Value = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
    let name = |item: &Value| item["name"].as_str().unwrap().to_owned();
    json[list].as_array().map_or(vec![], |l| l.iter().map(name).collect())
}

#[test]
fn only_formats_asked_for_are_made_and_kept() {
    let bench = Bench::done();
    let plan = bench.made(&["--export", "glb,usd", "--dry-run"]);
    assert!(plan.out.ends_with("2 of 15 stages would run\n"), "{}", plan.out);
    let said = bench.made(&["--export", "glb,usd"]);
    let files = "out/asset.urdf\nout/asset.usda\nout/asset.glb\n";
    assert!(said.out.starts_with(files), "{said:?}");
    assert_eq!((bench.finished("write-usd"), bench.finished("write-mjcf")), (1, 0));
    let out = bench.out();
    let trace = bench.trace();
    for file in ["asset.usda", "asset.glb"] {
        let outputs = trace.events.iter().flat_map(|(_, e)| &e.outputs);
        let recorded = outputs.filter(|o| o.name == file).map(|o| o.digest.clone());
        assert_eq!(recorded.collect::<Vec<_>>(), [trace::Digest::of(&out[file])]);
    }
    bench.made(&[]);
    assert!(bench.out().keys().all(|name| !["asset.usda", "asset.glb"].contains(&name.as_str())));
}
