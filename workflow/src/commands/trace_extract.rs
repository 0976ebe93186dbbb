//! `kinfold trace extract`: any artefact out of a trace, whole in it or made again from it.

use std::collections::BTreeMap;
use std::path::Path;

use trace::{Digest, Reading, verify};

use super::{trace_replay, trace_verify};
use crate::speech::{Answer, Complaint};
use crate::stages::bundle;

/// Writes an artefact of a run to a file, or lists them all.
///
/// # Errors
/// [`Complaint`] when the trace has no such artefact or cannot be read.
pub fn extract(file: &Path, name: Option<&str>, out: Option<&Path>) -> Result<Answer, Complaint> {
    let reading = trace_verify::sealed(file);
    let reading = reading
        .map_err(|c| Complaint { message: format!("{}: {}", file.display(), c.message), ..c })?;
    let Some(name) = name else { return Ok(Answer::done(list(&reading))) };
    let wanted = verify::made(&reading).filter(|(_, o)| o.name == name).last();
    let Some((_, wanted)) = wanted else {
        let complaint = Complaint::failed(format!("{}: no stage made `{name}`", file.display()));
        return Err(complaint.hint("`kinfold trace extract FILE` lists what there is"));
    };
    let bytes = match in_trace(&reading, &wanted.digest) {
        Some(bytes) => bytes,
        None => made_again(&reading, &wanted.digest)?,
    };
    let beside = || Path::new(Path::new(name).file_name().unwrap_or_default()).to_path_buf();
    let out = out.map_or_else(beside, Path::to_path_buf);
    let written = std::fs::write(&out, &bytes);
    written.map_err(|e| Complaint::failed(format!("{}: {e}", out.display())))?;
    Ok(Answer::done(format!("{}\n", guard::text::shown(&out.to_string_lossy()))))
}

fn list(reading: &Reading) -> String {
    let mut seen = BTreeMap::new();
    for (event, made) in verify::made(reading) {
        let line = format!(
            "{:<14} {:>10} {} {}\n",
            made.digest.short(),
            made.bytes,
            guard::text::shown(&event.stage),
            guard::text::shown(&made.name)
        );
        seen.insert(made.name.clone(), line);
    }
    seen.into_values().collect()
}

fn in_trace(reading: &Reading, digest: &Digest) -> Option<Vec<u8>> {
    let files = reading.attachments.iter().map(|a| &a.bytes);
    let pictures = reading.pictures.iter().map(|p| &p.bytes);
    files.chain(pictures).find(|bytes| Digest::of(bytes) == *digest).cloned()
}

/// What stands in the trace by its digest alone comes out of running it again.
fn made_again(reading: &Reading, digest: &Digest) -> Result<Vec<u8>, Complaint> {
    let outcome = trace_replay::again(reading)?;
    for (made, bytes) in outcome.nodes.iter().filter_map(|n| n.output.as_ref()) {
        if made == digest {
            return Ok(bytes.to_vec());
        }
        let inside = bundle::unpack(bytes).unwrap_or_default();
        if let Some(bytes) = inside.into_values().find(|b| Digest::of(b) == *digest) {
            return Ok(bytes);
        }
    }
    let what = format!("running the trace again does not give {}", digest.short());
    Err(Complaint::failed(what).hint("`kinfold trace replay` says where it differs"))
}
