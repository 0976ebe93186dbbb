//! `kinfold trace extract`: any artefact out of a trace, whole in it or made again from it.

use std::collections::BTreeMap;
use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};

use trace::{Digest, Reading, verify};

use super::{sealed, trace_replay};
use crate::cli::speech::{Answer, Complaint};
use crate::stages::bundle;

/// Writes an artefact of a run to a file, or lists them all. Only with `force` is a file written over
/// that is there.
///
/// # Errors
/// [`Complaint`] when the trace has no such artefact or cannot be read, or the file is there.
pub fn extract(
    file: &Path,
    name: Option<&str>,
    out: Option<&Path>,
    force: bool,
) -> Result<Answer, Complaint> {
    let reading = sealed::sealed(file);
    let reading = reading
        .map_err(|c| Complaint { message: format!("{}: {}", file.display(), c.message), ..c })?;
    let Some(name) = name else { return Ok(Answer::done(list(&reading))) };
    let wanted = verify::made(&reading).filter(|(_, o)| o.name == name).last();
    let Some((_, wanted)) = wanted else {
        let complaint = Complaint::failed(format!("{}: no stage made `{name}`", file.display()));
        return Err(complaint.hint("`kinfold trace extract FILE` lists what there is"));
    };
    let out = out.map_or_else(|| beside(name), |out| Ok(out.to_path_buf()))?;
    // Before anything is computed; it is looked at again when it is written.
    if !force && std::fs::symlink_metadata(&out).is_ok() {
        return Err(is_there(&out));
    }
    let bytes = match in_trace(&reading, &wanted.digest) {
        Some(bytes) => bytes,
        None => made_again(&reading, &wanted.digest)?,
    };
    write(&out, &bytes, force)?;
    Ok(Answer::done(format!("{}\n", guard::text::shown(&out.to_string_lossy()))))
}

/// Where an artefact goes of itself: into the working folder, under the end of its name. The name is
/// the trace's, so it must be a plain one.
fn beside(name: &str) -> Result<PathBuf, Complaint> {
    let own = name.rsplit('/').next().unwrap_or_default();
    let plain = |c: char| c.is_alphanumeric() || "._- ".contains(c);
    if own.starts_with(char::is_alphanumeric) && own.chars().all(plain) && own.len() <= 255 {
        return Ok(PathBuf::from(own));
    }
    let complaint = Complaint::failed(format!(
        "`{}` is no plain name of a file, so it is not written into this folder",
        guard::text::shown(name)
    ));
    Err(complaint.hint("name a file with --out FILE"))
}

pub(super) fn is_there(out: &Path) -> Complaint {
    let complaint = Complaint::failed(format!("{} is there already", out.display()));
    complaint.hint("name another file with --out FILE, or write over it with --force")
}

/// Writes a file that is not there, or, if that is meant, instead of one that is. A link is replaced,
/// never followed.
pub(super) fn write(out: &Path, bytes: &[u8], force: bool) -> Result<(), Complaint> {
    let failed = |e: std::io::Error| Complaint::failed(format!("{}: {e}", out.display()));
    let folder = out.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut file = tempfile::NamedTempFile::new_in(folder).map_err(failed)?;
    file.write_all(bytes).and_then(|()| readable(file.as_file())).map_err(failed)?;
    let done = if force { file.persist(out) } else { file.persist_noclobber(out) };
    match done {
        Ok(_) => Ok(()),
        Err(e) if e.error.kind() == ErrorKind::AlreadyExists => Err(is_there(out)),
        Err(e) => Err(failed(e.error)),
    }
}

/// As files are that one makes oneself; a temporary one is for its maker alone.
fn readable(file: &std::fs::File) -> std::io::Result<()> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        file.set_permissions(std::fs::Permissions::from_mode(0o644))?;
    }
    file.sync_all()
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

pub(super) fn in_trace(reading: &Reading, digest: &Digest) -> Option<Vec<u8>> {
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
