//! What stands in an output folder: whose it is, which files in it are ours, how good it is.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use runner::ours::marker::{self, Whose};
use runner::ours::swap::Names;
use runner::ours::{Kind, Marker};
use serde_json::Value;
use sim_check::{Tier, Verdict};
use trace::{Digest, Reading};

use super::error::{OutError, io_failed};
use super::names::{REASON, STATEMENT, TRACE, VERDICT};
use super::shipped::shipped;

/// Most bytes of a trace or a file of an asset that are read here; a guess, some ten times the
/// largest that was seen.
const MOST: u64 = 1 << 30;
/// A trace that a run of 0.1.0 was killed over.
const TRACE_OF_OLD: &str = "trace.mcap.partial";

/// How good what stands is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Standing {
    /// There is no asset.
    Nothing,
    /// An asset of that tier.
    Asset(Tier),
    /// An asset of which nobody can say how good it is: why.
    Unknown(String),
}

/// Refuses a folder that is not ours, not empty and there. Changes nothing. `shown` is its path in the
/// words of whoever asks.
///
/// # Errors
/// [`OutError`] with what was found.
pub(super) fn check(place: &Path, shown: &Path) -> Result<(), OutError> {
    let whose = marker::whose(place).map_err(io_failed("look into", shown))?;
    let root = shown.to_path_buf();
    match whose {
        Whose::Nobodys => Ok(()),
        Whose::Ours(Marker { kind: Kind::Asset | Kind::Unfinished, .. }) => Ok(()),
        Whose::Ours(Marker { kind, .. }) => Err(OutError::Kind { root, kind }),
        Whose::Strange(_) if of_old(place).is_some() => Ok(()),
        Whose::Strange(found) => Err(OutError::NotOurs { root, found }),
    }
}

/// The files of ours in a folder: those its marker lists, or those that a trace in it names and that
/// are what it says.
pub(super) fn ours(place: &Path) -> Names {
    match Marker::read(place) {
        Some(marker) => marker.files.into(),
        None => of_old(place).unwrap_or_default().into(),
    }
}

/// The same in an item's folder of a batch, where 0.1.0 wrote no marker: besides what follows from a
/// trace of ours, the statement that names that trace, and the reason that names the item.
pub fn ours_of_item(place: &Path) -> Names {
    if let Some(marker) = Marker::read(place) {
        return marker.files.into();
    }
    let mut names = of_old(place).unwrap_or_default();
    let json = |name: &str| serde_json::from_slice::<Value>(&read(place, name)?).ok();
    let trace = read(place, TRACE).map(|bytes| Digest::of(&bytes).to_string());
    let of_trace = |subject: &Value| {
        subject["name"] == TRACE && subject["digest"]["blake3"].as_str() == trace.as_deref()
    };
    if names.contains(TRACE)
        && json(STATEMENT)
            .is_some_and(|s| s["subject"].as_array().is_some_and(|all| all.iter().any(of_trace)))
    {
        names.insert(STATEMENT.into());
    }
    let id = place.file_name().map(|name| name.to_string_lossy().into_owned());
    let of_item =
        |reason: &Value| reason["id"].as_str() == id.as_deref() && reason["outcome"].is_string();
    if json(REASON).as_ref().is_some_and(of_item) {
        names.insert(REASON.into());
    }
    names.into()
}

/// The files of a run of 0.1.0, which wrote no marker: a trace that it sealed and the files that
/// follow from it; or the trace that it was killed over.
fn of_old(place: &Path) -> Option<BTreeSet<String>> {
    let mut names = BTreeSet::new();
    for name in [TRACE, TRACE_OF_OLD] {
        let Some(bytes) = read(place, name) else { continue };
        let Some(files) = named(&bytes, name) else { continue };
        let stands = |(file, digest): &(String, Digest)| {
            read(place, file).is_some_and(|bytes| Digest::of(&bytes) == *digest)
        };
        names.extend(files.into_iter().filter(stands).map(|(file, _)| file));
        names.insert(name.to_owned());
    }
    Some(names).filter(|names| !names.is_empty())
}

/// The files that a trace of ours names; none if it is no trace of ours. One that is finished has a
/// seal, one that a run was killed over begins with a manifest.
fn named(bytes: &[u8], name: &str) -> Option<Vec<(String, Digest)>> {
    // A seal costs nothing to judge; what unpacks to much is not unpacked without one.
    let sealed = trace::seal::check(bytes).is_ok();
    if !sealed && name != TRACE_OF_OLD {
        return None;
    }
    let reading = trace::read_bytes(bytes, name).ok()?;
    let is_ours = reading.manifest.as_ref().is_some_and(|m| m.flow == crate::image_to_urdf::NAME);
    let whole = sealed && trace::verify::holds_together(&reading).is_ok();
    match (is_ours, whole) {
        (true, true) => Some(follow(&reading)),
        (true, false) if name == TRACE_OF_OLD && reading.chain_holds => Some(vec![]),
        _ => None,
    }
}

/// The files of a whole run; none of one that came to no verdict.
fn follow(reading: &Reading) -> Vec<(String, Digest)> {
    shipped(reading).unwrap_or_default().into_iter().collect()
}

/// A regular file in the folder; a link on the way to it is not followed.
fn read(place: &Path, name: &str) -> Option<Vec<u8>> {
    let mut path = place.to_path_buf();
    for part in Path::new(name).components() {
        path.push(part);
        if fs::symlink_metadata(&path).ok()?.is_symlink() {
            return None;
        }
    }
    guard::files::read(&path, MOST).ok()
}

/// The photo of the asset in a folder of ours, as the trace beside it has it.
pub(super) fn photo(place: &Path) -> Option<Digest> {
    if matches!(of(place), Standing::Nothing) {
        return None;
    }
    let reading = trace::read_bytes(&read(place, TRACE)?, TRACE).ok()?;
    reading.manifest?.inputs.get("photo").cloned()
}

/// How good the asset in a folder of ours is, by its own verdict.
pub(super) fn of(place: &Path) -> Standing {
    let is_there = |name: &str| fs::symlink_metadata(place.join(name)).is_ok();
    if !is_there("asset.urdf") && !is_there(VERDICT) {
        return Standing::Nothing;
    }
    let unknown = |why: &str| Standing::Unknown(format!("its {VERDICT} {why}"));
    let Some(bytes) = read(place, VERDICT) else { return unknown("cannot be read") };
    match serde_json::from_slice::<Verdict>(&bytes) {
        Ok(verdict) => Standing::Asset(verdict.tier),
        Err(_) => unknown("is no verdict of ours"),
    }
}
