//! `kinfold trace keygen`, `kinfold trace sign` and `kinfold audit sign`: keys and signatures on
//! disk.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use guard::text::shown;
use runner::ours::Turns;
use serde_json::json;
use trace::Time;
use trace::sign::{self, PublicKey, SecretKey, SignError};
use zeroize::Zeroizing;

use super::sealed;
use crate::batch::signed::placed;
use crate::batch::{audit, signed};
use crate::cli::speech::{Answer, Complaint};

/// Most bytes of a key's file: minisign's have fewer than 400, and a long comment.
const LONGEST_KEY: u64 = 4096;
/// Nanoseconds of a second.
const SECOND: Time = 1_000_000_000;

/// Draws a key: NAME.key, which its owner alone may read, and NAME.pub. Neither is ever written over.
///
/// # Errors
/// [`Complaint`] when one of them stands there, or the disk refuses.
pub fn keygen(name: &Path, as_json: bool) -> Result<Answer, Complaint> {
    let (secret, public) = (with(name, ".key"), with(name, ".pub"));
    for file in [&secret, &public] {
        if fs::symlink_metadata(file).is_ok() {
            let message = format!("{}: stands there already", told(file));
            return Err(
                Complaint::failed(message).hint("a key is never written over: name another")
            );
        }
    }
    let key = SecretKey::draw().map_err(|e| Complaint::from_error(&e))?;
    let failed = |file: &Path| {
        let file = told(file);
        move |e: io::Error| Complaint::failed(format!("{file}: cannot be written: {e}"))
    };
    written(&secret, true, key.to_text().as_bytes()).map_err(failed(&secret))?;
    if let Err(e) = written(&public, false, key.public().to_text().as_bytes()) {
        // Half a pair is of no use to anybody.
        let _ = fs::remove_file(&secret);
        return Err(failed(&public)(e));
    }
    let id = key.id().to_string();
    let result = if as_json {
        format!("{:#}\n", json!({ "key": id, "secret": secret, "public": public }))
    } else {
        format!("{}\n{}\n", told(&secret), told(&public))
    };
    Ok(Answer::done(result))
}

/// Signs a trace that is whole; the signature lies beside it.
///
/// # Errors
/// [`Complaint`] when trace or key is not fit for it, or the signature's place is taken.
pub fn sign_trace(
    file: &Path,
    key: &Path,
    clock: Option<Time>,
    as_json: bool,
) -> Result<Answer, Complaint> {
    let (key, remarks) = secret_key(key)?;
    let place = with(file, sign::SUFFIX);
    free_or_own(&place, &key)?;
    let (bytes, _) = sealed::sealed_bytes(file).map_err(|c| about(file, c))?;
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let time = clock.map(|at| format!("timestamp:{}\t", at / SECOND)).unwrap_or_default();
    let comment = format!("{time}file:{}\thashed", shown(&name));
    let text = sign::sign(&key, &bytes, &comment).map_err(|e| Complaint::from_error(&e))?;
    placed(&place, text.as_bytes())
        .map_err(|e| Complaint::failed(format!("{}: cannot be written: {e}", told(&place))))?;
    let result = if as_json {
        let id = key.id().to_string();
        format!("{:#}\n", json!({ "signature": place, "key": id, "comment": comment }))
    } else {
        format!("{}\n", told(&place))
    };
    Ok(Answer { remarks, ..Answer::done(result) })
}

/// Signs the statements of a batch of which everything holds.
///
/// # Errors
/// [`Complaint`] when something does not hold, the key is not fit for it, or the disk refuses.
pub fn sign_batch(folder: &Path, key: &Path, as_json: bool) -> Result<Answer, Complaint> {
    let (key, remarks) = secret_key(key)?;
    let looked = audit::audit(folder, None, None).map_err(|e| Complaint::from_error(&e))?;
    let found = looked.findings.first().map(|f| [f.id.as_str(), f.found.as_str()].join(" "));
    // What nobody knows is not vouched for either.
    if let Some(found) = found.or(looked.unknown.into_iter().next()) {
        let found = shown(found.trim()).into_owned();
        let message = format!("{}: does not hold, so nothing was signed: {found}", told(folder));
        return Err(Complaint::failed(message).hint("`kinfold audit DIR` says everything it found"));
    }
    let count = signed::sign(folder, &key, Turns { wait: true, tell: true })
        .map_err(|e| Complaint::from_error(&e))?;
    let id = key.id().to_string();
    let result = if as_json {
        format!("{:#}\n", json!({ "signed": count, "key": id }))
    } else {
        format!("{count} statements signed with key {id}\n")
    };
    Ok(Answer { remarks, ..Answer::done(result) })
}

/// A key that judges signatures.
///
/// # Errors
/// [`Complaint`] when the file cannot be read or holds something else.
pub(super) fn public_key(file: &Path) -> Result<PublicKey, Complaint> {
    let text = key_text(file)?;
    PublicKey::read(&text).map_err(|e| key_complaint(file, &e))
}

/// A key that signs, and what its owner should know about its file.
fn secret_key(file: &Path) -> Result<(SecretKey, Vec<String>), Complaint> {
    let text = key_text(file)?;
    let key = SecretKey::read(&text).map_err(|e| key_complaint(file, &e))?;
    let open = lies_open(file).then(|| {
        let file = told(file);
        format!("warning: {file}: others may read this secret key\nhint: chmod 600 {file}")
    });
    Ok((key, open.into_iter().collect()))
}

fn key_text(file: &Path) -> Result<Zeroizing<String>, Complaint> {
    let bytes = guard::files::read(file, LONGEST_KEY);
    let bytes = bytes.map_err(|e| Complaint::failed(format!("{}: {e}", told(file))))?;
    let text = String::from_utf8(bytes).map_err(|_| {
        Complaint::failed(format!("{}: expected a key of minisign, found no text", told(file)))
    });
    text.map(Zeroizing::new)
}

fn key_complaint(file: &Path, error: &SignError) -> Complaint {
    let complaint = Complaint::failed(format!("{}: {error}", told(file)));
    match error {
        SignError::Protected => complaint.hint(
            "`minisign -C -W -s KEY` takes the password off a copy; or sign with `minisign -S`, \
             whose signature `kinfold trace verify --key` judges as well",
        ),
        _ => complaint.hint("`kinfold trace keygen NAME` and `minisign -G` make such keys: a secret and a public one"),
    }
}

/// Whether the signature beside a file is a key's over these bytes of it; its trusted comment.
///
/// # Errors
/// [`Complaint`] when there is none, or it is not.
pub(super) fn judged(file: &Path, bytes: &[u8], key: &PublicKey) -> Result<String, Complaint> {
    let place = with(file, sign::SUFFIX);
    let name = place.file_name().unwrap_or_default().to_string_lossy();
    let name = shown(&name);
    let text = guard::files::read(&place, sign::MOST).map_err(|e| {
        Complaint::failed(format!("it is not signed: {name} {e}"))
            .hint("whoever made it signs it with `kinfold trace sign`")
    })?;
    let text = String::from_utf8_lossy(&text);
    let comment = sign::verify(key, bytes, &text);
    let comment = comment.map_err(|e| Complaint::failed(format!("{name}: {e}")))?;
    Ok(shown(&comment.replace('\t', " ")).into_owned())
}

/// A signature's place must be free, or hold one of the same key.
fn free_or_own(place: &Path, key: &SecretKey) -> Result<(), Complaint> {
    let Ok(there) = fs::symlink_metadata(place) else { return Ok(()) };
    let text = there.is_file().then(|| guard::files::read(place, sign::MOST).ok()).flatten();
    let text = text.and_then(|bytes| String::from_utf8(bytes).ok());
    match text.map(|text| sign::signer(&text)) {
        Some(Ok(id)) if id == key.id() => Ok(()),
        Some(Ok(id)) => {
            let message = format!("{}: stands there, by key {id}", told(place));
            Err(Complaint::failed(message)
                .hint("another's signature is never written over: move it"))
        }
        _ => {
            let message = format!("{}: stands there, and is no signature", told(place));
            Err(Complaint::failed(message).hint("nothing of others is written over: move it"))
        }
    }
}

/// A new file, for its owner's eyes alone where it is secret.
fn written(path: &Path, secret: bool, bytes: &[u8]) -> io::Result<()> {
    let mut options = File::options();
    options.write(true).create_new(true);
    #[cfg(unix)]
    if secret {
        use std::os::unix::fs::OpenOptionsExt as _;
        options.mode(0o600);
    }
    let mut file = options.open(path)?;
    file.write_all(bytes)?;
    file.sync_all()
}

#[cfg(unix)]
fn lies_open(file: &Path) -> bool {
    use std::os::unix::fs::PermissionsExt as _;
    fs::metadata(file).is_ok_and(|about| about.permissions().mode() & 0o077 != 0)
}

#[cfg(not(unix))]
fn lies_open(_file: &Path) -> bool {
    false
}

fn with(path: &Path, suffix: &str) -> PathBuf {
    let mut name = OsString::from(path);
    name.push(suffix);
    name.into()
}

fn told(path: &Path) -> String {
    shown(&path.display().to_string()).into_owned()
}

fn about(file: &Path, complaint: Complaint) -> Complaint {
    Complaint { message: format!("{}: {}", told(file), complaint.message), ..complaint }
}
