//! `kinfold trace verify`: do the files in a folder follow from the trace that lies there?

use std::collections::BTreeMap;
use std::path::Path;

use guard::files::Refused;
use guard::folder::{Caps, Folder, Kind};
use serde_json::json;
use trace::sign::PublicKey;
use trace::{Digest, Happening, Reading};

use super::sealed::{read, sealed_in};
use super::signing;
use crate::cli::speech::{Answer, Complaint};
use crate::output::shipped;

/// Files and folders that only runs of ours leave.
const OURS: [&str; 15] = [
    "asset.urdf",
    "asset.json",
    "asset.xml",
    "asset.usda",
    "asset.usdz",
    "asset.glb",
    "asset.sdf",
    "asset_isaaclab.py",
    "model.config",
    "verdict.json",
    "critic.json",
    "viewer.html",
    "parts.png",
    "motion.webp",
    "meshes",
];

/// Proves that the files beside a trace (or in `files`) follow from it, digest by digest, and with a
/// key that the trace is signed with it; `verbose` lists them. Exit 1 with the first difference
/// otherwise.
///
/// # Errors
/// [`Complaint`] when the file cannot be read or is no trace, or the key is none.
pub fn verify(
    file: &Path,
    files: Option<&Path>,
    key: Option<&Path>,
    (verbose, json): (bool, bool),
) -> Result<Answer, Complaint> {
    let key = key.map(signing::public_key).transpose()?;
    let beside = || file.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let folder = files.unwrap_or_else(beside);
    let checked = read(file).and_then(|bytes| {
        // Nothing is believed of a trace before its signature is.
        let signed = key.as_ref().map(|key| Signed::judged(file, &bytes, key)).transpose()?;
        let reading = sealed_in(&bytes)?;
        let expected = shipped(&reading).ok_or_else(no_verdict)?;
        compare(folder, &expected)?;
        Ok((reading, expected, signed))
    });
    let name = file.display();
    match checked {
        Ok((reading, expected, signed)) => {
            Ok(Answer::done(told(&reading, &expected, signed.as_ref(), (verbose, json))))
        }
        Err(complaint) => {
            let message = format!("{name}: {}", complaint.message);
            let value = json!({ "holds": false, "difference": complaint.message });
            let result = if json { format!("{value:#}\n") } else { String::new() };
            Err(Complaint { message, result, ..complaint })
        }
    }
}

/// A signature that holds: whose, and what stands beside it.
struct Signed {
    key: String,
    comment: String,
}

impl Signed {
    fn judged(file: &Path, bytes: &[u8], key: &PublicKey) -> Result<Self, Complaint> {
        let comment = signing::judged(file, bytes, key)?;
        Ok(Self { key: key.id().to_string(), comment })
    }
}

fn no_verdict() -> Complaint {
    Complaint::failed("the run came to no verdict, so no file follows from it")
        .hint("`kinfold trace show` says how far it went")
}

/// The first file that is missing, other than the trace says, or not of this run. Nothing outside of
/// the folder is read, whatever the trace calls its files.
fn compare(folder: &Path, expected: &BTreeMap<String, Digest>) -> Result<(), Complaint> {
    let refused = |name: &str, refused: &Refused| Complaint::failed(format!("{name} {refused}"));
    let shown = folder.display().to_string();
    let folder = Folder::open(folder, Caps::default()).map_err(|why| refused(&shown, &why))?;
    for (name, digest) in expected {
        let found = folder
            .file(Path::new(name))
            .and_then(|file| Digest::of_reader(file).map_err(Refused::of));
        let found = found.map_err(|why| match why {
            Refused::Open(e) => Complaint::failed(format!("{name} cannot be read: {e}")),
            why => refused(name, &why),
        })?;
        if found != *digest {
            let (digest, found) = (digest.short(), found.short());
            let message = format!("{name} does not follow: the trace says {digest}, found {found}");
            return Err(Complaint::failed(message));
        }
    }
    for name in OURS.iter().chain(&["views"]) {
        for entry in folder.walk(Path::new(name)).map_err(|why| refused(name, &why))? {
            let name = entry.path.to_string_lossy().replace('\\', "/");
            if entry.kind == Kind::File && expected.contains_key(&name) {
                continue;
            }
            let what = match entry.kind {
                Kind::Link => "is a link, which is not followed, and no file of this run",
                _ => "is not a file of this run",
            };
            return Err(Complaint::failed(format!("{name} {what}")));
        }
    }
    Ok(())
}

/// How many stages came to their end.
fn stages(reading: &Reading) -> usize {
    reading.events.iter().filter(|(_, e)| e.event == Happening::Finished).count()
}

fn told(
    reading: &Reading,
    files: &BTreeMap<String, Digest>,
    signed: Option<&Signed>,
    (verbose, json): (bool, bool),
) -> String {
    let run = reading.manifest.as_ref().map(|m| m.run_id.clone()).unwrap_or_default();
    if json {
        let signed = signed.map(|s| json!({ "key": s.key, "comment": s.comment }));
        let value = json!({ "holds": true, "run": run, "files": files, "signed": signed });
        return format!("{value:#}\n");
    }
    let line = |(name, digest): (&String, &Digest)| {
        format!("{} {}\n", digest.short(), guard::text::shown(name))
    };
    let lines: String = files.iter().filter(|_| verbose).map(line).collect();
    let run = guard::text::shown(run.get(..12).unwrap_or(&run));
    let (count, stages) = (files.len(), stages(reading));
    let signed = signed.map(|s| format!("signed with key {}: {}\n", s.key, s.comment));
    let signed = signed.unwrap_or_default();
    format!("{lines}holds: {count} files, {stages} stages, seal ok (run {run})\n{signed}")
}
