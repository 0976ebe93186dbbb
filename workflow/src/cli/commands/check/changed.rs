//! `--changed-since REF`: the models that differ from a commit, or use a file that does.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

use guard::folder::{Caps, Folder, Kind};

use crate::cli::speech::Complaint;

/// Endings of files that name others: models and what they are written with.
const NAMING: [&str; 12] = [
    "urdf", "xacro", "xml", "mjcf", "sdf", "world", "config", "usda", "srdf", "yaml", "yml", "mtl",
];
/// Files of more bytes are counted as changed, unread; a guess well above what people write by hand.
const MOST: u64 = 16 << 20;

/// Of these files those that differ from what they were at `reference`, and those that name one that does,
/// themselves or through others. A name counts wherever it stands, so rather one model too many.
///
/// # Errors
/// Where Git cannot say it.
pub(super) fn changed(files: Vec<PathBuf>, reference: &str) -> Result<Vec<PathBuf>, Complaint> {
    let root = said(Path::new("."), &["rev-parse", "--show-toplevel"], reference)?;
    let root = PathBuf::from(String::from_utf8_lossy(&root).trim_end_matches('\n'));
    let diff = ["diff", "--name-only", "-z", "--no-ext-diff", "--no-textconv", "--end-of-options"];
    let mut diff: Vec<&str> = diff.to_vec();
    diff.extend([reference, "--"]);
    let new = ["ls-files", "--others", "--exclude-standard", "-z"];
    let mut names = BTreeSet::new();
    let mut paths = BTreeSet::new();
    for words in [&diff[..], &new[..]] {
        let listed = said(&root, words, reference)?;
        for name in listed.split(|b| *b == 0).filter(|name| !name.is_empty()) {
            let path = PathBuf::from(String::from_utf8_lossy(name).into_owned());
            names.extend(path.file_name().map(|n| n.to_string_lossy().into_owned()));
            paths.insert(real(&root.join(path)));
        }
    }
    if paths.is_empty() {
        return Ok(Vec::new());
    }
    let mut folders = BTreeSet::from([root.clone()]);
    let is_below = |file: &PathBuf| real(file).starts_with(real(&root));
    folders.extend(files.iter().filter(|f| !is_below(f)).filter_map(|f| Some(f.parent()?.into())));
    let mut others: Vec<(PathBuf, String)> = Vec::new();
    for folder in folders {
        others.extend(texts(&folder, &mut paths)?);
    }
    // What names a changed file is changed itself, until nothing more is.
    loop {
        let naming =
            |(_, text): &(PathBuf, String)| names.iter().any(|n| text.contains(n.as_str()));
        let (found, rest): (Vec<_>, Vec<_>) = others.into_iter().partition(naming);
        others = rest;
        if found.is_empty() {
            break;
        }
        for (path, _) in found {
            names.extend(path.file_name().map(|n| n.to_string_lossy().into_owned()));
            paths.insert(path);
        }
    }
    Ok(files.into_iter().filter(|file| paths.contains(&real(file))).collect())
}

fn real(path: &Path) -> PathBuf {
    std::fs::canonicalize(path).or_else(|_| std::path::absolute(path)).unwrap_or(path.into())
}

/// The texts below a folder that may name others; those that cannot be read are changed.
fn texts(
    folder: &Path,
    paths: &mut BTreeSet<PathBuf>,
) -> Result<Vec<(PathBuf, String)>, Complaint> {
    let failed = |e: guard::files::Refused| Complaint::failed(format!("{} {e}", folder.display()));
    let caps = Caps { entries: 100_000_000, file: MOST, ..Caps::default() };
    let opened = Folder::open(folder, caps).map_err(failed)?;
    let mut all = Vec::new();
    for entry in opened.walk(Path::new(".")).map_err(failed)? {
        let ending = entry.path.extension().map(|e| e.to_string_lossy().to_lowercase());
        let is_naming = ending.is_some_and(|e| NAMING.contains(&e.as_str()));
        if !is_naming || entry.kind != Kind::File || entry.path.starts_with("./.git") {
            continue;
        }
        let path = real(&folder.join(&entry.path));
        match opened.read(&entry.path) {
            Ok(bytes) => all.push((path, String::from_utf8_lossy(&bytes).into_owned())),
            Err(_) => {
                paths.insert(path);
            }
        }
    }
    Ok(all)
}

/// What Git says. Nothing that the repository's own settings name is started by it.
fn said(folder: &Path, words: &[&str], reference: &str) -> Result<Vec<u8>, Complaint> {
    let mut git = Command::new("git");
    git.args(["-c", "core.fsmonitor=false", "-C"]).arg(folder).args(words);
    git.env("GIT_OPTIONAL_LOCKS", "0").stdin(std::process::Stdio::null());
    let answer = git.output().map_err(|e| {
        Complaint::failed(format!("--changed-since {reference}: git cannot be started: {e}"))
            .hint("without --changed-since every model is checked")
    })?;
    if answer.status.success() {
        return Ok(answer.stdout);
    }
    let words = String::from_utf8_lossy(&answer.stderr);
    let first =
        guard::text::brief(words.lines().next().unwrap_or("it said nothing"), 300).into_owned();
    Err(Complaint::failed(format!("--changed-since {reference}: git: {first}"))
        .hint("name a commit, branch or tag of this repository, fetched here"))
}
