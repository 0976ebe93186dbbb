//! Writes the development cases in every format, with the true labels and joints, for the engines that
//! `asset/engines/behave.py` asks: `write_formats OUT [case...]`, cases under
//! `$KINFOLD_SHARED/data/cases/dev`.
#![allow(clippy::print_stdout, clippy::print_stderr)]

use std::path::{Path, PathBuf};

use asset::{AssetAppearance, BuildOptions, build};
use object::{ArticulatedObject, Condition, JointMotion};
use rayon::prelude::*;
use serde_json::Value;

use truth::motion;

#[path = "shared/truth.rs"]
mod truth;

type Failure = Box<dyn std::error::Error + Send + Sync>;

fn main() -> Result<(), Failure> {
    let shared = std::env::var("KINFOLD_SHARED").unwrap_or_else(|_| "../shared".into());
    let folder = Path::new(&shared).join("data/cases/dev");
    let mut arguments = std::env::args().skip(1);
    let out = PathBuf::from(arguments.next().ok_or("expected a folder to write to")?);
    let wanted: Vec<String> = arguments.collect();
    let mut cases: Vec<PathBuf> =
        std::fs::read_dir(folder)?.filter_map(|e| Some(e.ok()?.path())).collect();
    cases.sort();
    cases.retain(|case| {
        let name = name(case);
        let asked = wanted.is_empty() || wanted.iter().any(|w| name.contains(w));
        asked && !name.ends_with("-fused") && case.join("truth.json").is_file()
    });
    let failed: Vec<String> = cases
        .par_iter()
        .filter_map(|case| Some(format!("{}: {}", name(case), write(case, &out).err()?)))
        .collect();
    failed.iter().for_each(|line| eprintln!("{line}"));
    println!("{} cases, {} failed", cases.len(), failed.len());
    Ok(())
}

fn name(case: &Path) -> String {
    case.file_name().map_or_else(String::new, |n| n.to_string_lossy().into())
}

fn write(case: &Path, out: &Path) -> Result<(), Failure> {
    let condition = Condition::from_json(&std::fs::read_to_string(case.join("condition.json"))?)?;
    let object = read_case(case, &condition)?;
    let map: Vec<_> = (0..condition.tree.len()).map(Some).collect();
    let asset = build(&object, &condition, &map, &BuildOptions::default())?;
    let mut files = asset.to_urdf().files;
    files.insert("asset.xml".into(), asset.to_mjcf().into_bytes());
    files.insert("asset.usda".into(), asset.to_usd().into_bytes());
    files.extend(asset.to_sdf_with(&AssetAppearance::default()).files);
    files.insert("asset_isaaclab.py".into(), asset.to_isaaclab().into_bytes());
    let packed = [
        ("ros", asset.to_ros_with(&AssetAppearance::default())),
        ("simready", asset.to_simready_with(&AssetAppearance::default(), vec![])),
    ];
    for (folder, package) in packed {
        files.extend(package.files.into_iter().map(|(path, b)| (format!("{folder}/{path}"), b)));
    }
    for (path, bytes) in &files {
        let path = out.join(name(case)).join(path);
        path.parent().map_or(Ok(()), std::fs::create_dir_all)?;
        std::fs::write(path, bytes)?;
    }
    Ok(())
}

/// The case as an articulated object: the condition's tree, true labels and joints.
fn read_case(case: &Path, condition: &Condition) -> Result<ArticulatedObject, Failure> {
    let mesh = object::glb::read(&std::fs::read(case.join("mesh.glb"))?)?;
    let truth: Value = serde_json::from_slice(&std::fs::read(case.join("truth.json"))?)?;
    let labels = std::fs::read(case.join("face_labels.u16le"))?;
    let labels = labels.chunks_exact(2).map(|b| u16::from_le_bytes([b[0], b[1]])).collect();
    let joints = |part: &Value| {
        let joints = part["joints"].as_array().cloned().unwrap_or_default();
        joints.iter().filter_map(motion).collect::<Vec<JointMotion>>()
    };
    let motions = truth["parts"].as_array().ok_or("no parts")?.iter().map(joints).collect();
    Ok(ArticulatedObject::new(mesh, condition.tree.clone(), labels, motions)?)
}
