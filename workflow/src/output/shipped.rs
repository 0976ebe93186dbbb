//! The files that a run puts into its output folder.

use std::collections::BTreeMap;

use runner::Stage as _;
use trace::{Digest, Reading, StageEvent, verify};

use crate::stages::{Export, Pictures, WritePictures};

/// The files a finished run ships, by path in its folder, as its trace names them; `None` if it came
/// to no verdict.
pub fn shipped(reading: &Reading) -> Option<BTreeMap<String, Digest>> {
    let exports: Vec<_> = Export::ALL.into_iter().filter_map(Export::stage_and_file).collect();
    let packages: Vec<_> = Export::ALL.into_iter().filter_map(Export::package).collect();
    let inside = |stage: &str, name: &str| {
        let package = packages.iter().find(|p| p.stage == stage && p.bundle != name)?;
        Some(format!("{}{name}", package.folder))
    };
    let place = |event: &StageEvent, name: &str| match event.stage.as_str() {
        "write-urdf" => (name != "urdf.bundle").then(|| name.to_owned()),
        WritePictures::NAME => {
            [Pictures::PARTS, Pictures::MOTION].contains(&name).then(|| name.to_owned())
        }
        "render-views" => (name != "views.bundle").then(|| format!("views/{name}")),
        "check-in-sim" => (name == "verdict.json").then(|| name.to_owned()),
        "criticise" => (name == "critic.json").then(|| name.to_owned()),
        stage => {
            let is_file = exports.iter().any(|(s, f)| *s == stage && *f == name);
            is_file.then(|| name.to_owned()).or_else(|| inside(stage, name))
        }
    };
    let made = verify::made(reading);
    let files: BTreeMap<_, _> =
        made.filter_map(|(e, o)| Some((place(e, &o.name)?, o.digest.clone()))).collect();
    files.contains_key("verdict.json").then_some(files)
}
