//! `kinfold trace verify`: do the files in a folder follow from the trace that lies there?

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde_json::json;
use trace::{Digest, Reading, StageEvent, verify};

use crate::speech::{Answer, Complaint};
use crate::stages::Export;

/// Files and folders that only runs of ours leave.
const OURS: [&str; 8] = [
    "asset.urdf",
    "asset.json",
    "asset.xml",
    "asset.usda",
    "asset.glb",
    "verdict.json",
    "critic.json",
    "meshes",
];

/// Proves that the files beside a trace (or in `files`) follow from it, digest by digest. Exit 1
/// with the first difference otherwise.
///
/// # Errors
/// [`Complaint`] when the file cannot be read or is no trace.
pub fn verify(file: &Path, files: Option<&Path>, json: bool) -> Result<Answer, Complaint> {
    let beside = || file.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let folder = files.unwrap_or_else(beside);
    let checked = sealed(file).and_then(|reading| {
        let expected = shipped(&reading)?;
        compare(folder, &expected)?;
        Ok((reading, expected))
    });
    let name = file.display();
    match checked {
        Ok((reading, expected)) => Ok(Answer::done(told(&reading, &expected, json))),
        Err(complaint) => {
            let message = format!("{name}: {}", complaint.message);
            let value = json!({ "holds": false, "difference": complaint.message });
            let result = if json { format!("{value:#}\n") } else { String::new() };
            Err(Complaint { message, result, ..complaint })
        }
    }
}

/// A trace of which every bit is as it was sealed, and in which everything belongs together.
pub(super) fn sealed(file: &Path) -> Result<Reading, Complaint> {
    let bytes = std::fs::read(file);
    let bytes = bytes.map_err(|e| Complaint::failed(format!("cannot be read: {e}")))?;
    trace::seal::check(&bytes).map_err(Complaint::failed)?;
    let reading = trace::read_bytes(&bytes, "the file").map_err(|e| Complaint::from_error(&e))?;
    verify::holds_together(&reading).map_err(Complaint::failed)?;
    Ok(reading)
}

/// The files a finished run ships, by path in its folder, as its trace names them.
pub(crate) fn shipped(reading: &Reading) -> Result<BTreeMap<String, Digest>, Complaint> {
    let exports: Vec<_> = Export::ALL.into_iter().filter_map(Export::stage_and_file).collect();
    let place = |event: &StageEvent, name: &str| match event.stage.as_str() {
        "write-urdf" => (name != "urdf.bundle").then(|| name.to_owned()),
        "render-views" => (name != "views.bundle").then(|| format!("views/{name}")),
        "check-in-sim" => (name == "verdict.json").then(|| name.to_owned()),
        "criticise" => (name == "critic.json").then(|| name.to_owned()),
        stage => exports.iter().find(|(s, f)| *s == stage && *f == name).map(|_| name.to_owned()),
    };
    let made = verify::made(reading);
    let files: BTreeMap<_, _> =
        made.filter_map(|(e, o)| Some((place(e, &o.name)?, o.digest.clone()))).collect();
    if files.contains_key("verdict.json") {
        return Ok(files);
    }
    Err(Complaint::failed("the run came to no verdict, so no file follows from it")
        .hint("`kinfold trace show` says how far it went"))
}

/// The first file that is missing, other than the trace says, or not of this run.
fn compare(folder: &Path, expected: &BTreeMap<String, Digest>) -> Result<(), Complaint> {
    for (name, digest) in expected {
        let bytes = std::fs::read(folder.join(name));
        let bytes = bytes.map_err(|e| Complaint::failed(format!("{name} cannot be read: {e}")))?;
        let found = Digest::of(&bytes);
        if found != *digest {
            let (digest, found) = (digest.short(), found.short());
            let message = format!("{name} does not follow: the trace says {digest}, found {found}");
            return Err(Complaint::failed(message));
        }
    }
    let found = OURS.iter().chain(&["views"]).flat_map(|name| below(folder, Path::new(name)));
    let strange = found.map(|f| f.to_string_lossy().replace('\\', "/"));
    match strange.into_iter().find(|f| !expected.contains_key(f)) {
        Some(name) => Err(Complaint::failed(format!("{name} is not a file of this run"))),
        None => Ok(()),
    }
}

/// The files at or below a path, relative to the folder.
fn below(folder: &Path, path: &Path) -> Vec<PathBuf> {
    let full = folder.join(path);
    if full.is_file() {
        return vec![path.to_path_buf()];
    }
    let entries = std::fs::read_dir(full).into_iter().flatten().flatten();
    let mut names: Vec<_> = entries.map(|e| path.join(e.file_name())).collect();
    names.sort();
    names.iter().flat_map(|name| below(folder, name)).collect()
}

fn told(reading: &Reading, files: &BTreeMap<String, Digest>, json: bool) -> String {
    let run = reading.manifest.as_ref().map(|m| m.run_id.clone()).unwrap_or_default();
    if json {
        return format!("{:#}\n", json!({ "holds": true, "run": run, "files": files }));
    }
    let line = |(name, digest): (&String, &Digest)| {
        format!("{} {}\n", digest.short(), guard::text::shown(name))
    };
    let lines = files.iter().map(line);
    let run = guard::text::shown(run.get(..12).unwrap_or(&run));
    let count = files.len();
    format!("{}{count} files follow from run {run}\n", lines.collect::<String>())
}
