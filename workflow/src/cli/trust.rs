//! Which configurations a person approved: each by its place and the digest of its bytes, in the
//! user's own configuration folder.

use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};

use adapters::config::Draft;
use serde::{Deserialize, Serialize};
use trace::Digest;

/// Largest list that is read, bytes; a line has a few hundred.
const MAX_BYTES: u64 = 4 << 20;

/// An approval: a changed file, or the same one elsewhere, is another.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Approval {
    /// The file's bytes.
    pub digest: Digest,
    /// Where the file lies, links resolved.
    pub path: String,
}

/// The list of approvals.
#[derive(Clone, Debug)]
pub struct Approvals {
    /// The file they stand in.
    pub file: PathBuf,
}

/// Why approvals cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub enum TrustError {
    /// Nobody knows where the user's configuration lies.
    #[error("no folder for the user's configuration: neither XDG_CONFIG_HOME nor HOME is set")]
    Nowhere,
    /// The disk.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: String,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// The list is no regular file, or too large.
    #[error("{path}: {source}")]
    Refused {
        /// The file.
        path: String,
        /// Why.
        source: guard::files::Refused,
    },
    /// A line of the list that we did not write.
    #[error("{path}: expected an approval in line {line}, found something else")]
    Line {
        /// The file.
        path: String,
        /// The line, from one.
        line: usize,
    },
}

impl Approvals {
    /// Those of the user: `kinfold/trusted` in `XDG_CONFIG_HOME`, else in `~/.config`.
    ///
    /// # Errors
    /// [`TrustError::Nowhere`].
    pub fn of_user() -> Result<Self, TrustError> {
        let folder = |name| std::env::var_os(name).map(PathBuf::from).filter(|p| p.is_absolute());
        let config = folder("XDG_CONFIG_HOME").or_else(|| Some(folder("HOME")?.join(".config")));
        let config = config.ok_or(TrustError::Nowhere)?;
        Ok(Self { file: config.join("kinfold").join("trusted") })
    }

    /// All of them, oldest first; none where there is no list.
    ///
    /// # Errors
    /// [`TrustError`].
    pub fn all(&self) -> Result<Vec<Approval>, TrustError> {
        let path = self.file.display().to_string();
        let bytes = match guard::files::read(&self.file, MAX_BYTES) {
            Err(guard::files::Refused::Open(e)) if e.kind() == ErrorKind::NotFound => {
                return Ok(vec![]);
            }
            read => read.map_err(|source| TrustError::Refused { path: path.clone(), source })?,
        };
        let lines = bytes.split(|b| *b == b'\n').enumerate().filter(|(_, line)| !line.is_empty());
        let approval = |(n, line): (usize, &[u8])| {
            let wrong = |_| TrustError::Line { path: path.clone(), line: n + 1 };
            serde_json::from_slice(line).map_err(wrong)
        };
        lines.map(approval).collect()
    }

    /// Whether a configuration was approved as it stands.
    ///
    /// # Errors
    /// [`TrustError`].
    pub fn know(&self, draft: &Draft) -> Result<bool, TrustError> {
        let wanted = approval(draft)?;
        Ok(self.all()?.contains(&wanted))
    }

    /// Approves a configuration as it stands.
    ///
    /// # Errors
    /// [`TrustError`].
    pub fn add(&self, draft: &Draft) -> Result<Approval, TrustError> {
        let approval = approval(draft)?;
        if !self.all()?.contains(&approval) {
            let line = serde_json::json!(approval).to_string() + "\n";
            self.append(&line).map_err(|e| io(&self.file, e))?;
        }
        Ok(approval)
    }

    fn append(&self, line: &str) -> std::io::Result<()> {
        std::fs::create_dir_all(self.file.parent().unwrap_or(Path::new(".")))?;
        let mut file = std::fs::File::options().append(true).create(true).open(&self.file)?;
        file.write_all(line.as_bytes())?;
        file.sync_all()
    }

    /// Takes back every approval of the file at a path, which need not be there any more; says how
    /// many there were.
    ///
    /// # Errors
    /// [`TrustError`].
    pub fn remove(&self, path: &Path) -> Result<usize, TrustError> {
        let absolute = path.canonicalize().or_else(|_| std::path::absolute(path));
        let path = absolute.map_err(|e| io(path, e))?.display().to_string();
        let all = self.all()?;
        let kept: Vec<_> = all.iter().filter(|a| a.path != path).collect();
        let removed = all.len() - kept.len();
        if removed > 0 {
            let lines: String =
                kept.iter().map(|a| serde_json::json!(a).to_string() + "\n").collect();
            self.replace(&lines).map_err(|e| io(&self.file, e))?;
        }
        Ok(removed)
    }

    fn replace(&self, lines: &str) -> std::io::Result<()> {
        let folder = self.file.parent().unwrap_or(Path::new("."));
        let mut file = tempfile::NamedTempFile::new_in(folder)?;
        file.write_all(lines.as_bytes())?;
        file.as_file().sync_all()?;
        file.persist(&self.file).map_err(|e| e.error)?;
        Ok(())
    }
}

fn approval(draft: &Draft) -> Result<Approval, TrustError> {
    let path = draft.path.canonicalize().map_err(|e| io(&draft.path, e))?;
    Ok(Approval { digest: draft.digest.clone(), path: path.display().to_string() })
}

fn io(path: &Path, source: std::io::Error) -> TrustError {
    TrustError::Io { path: path.display().to_string(), source }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_approval_holds_for_these_bytes_in_this_place_until_it_is_taken_back() {
        let dir = tempfile::tempdir().unwrap();
        let approvals = Approvals { file: dir.path().join("config/kinfold/trusted") };
        let write = |name: &str, text: &str| {
            let path = dir.path().join(name);
            std::fs::write(&path, text).unwrap();
            Draft::read(&path).unwrap()
        };
        let draft = write("a.toml", "[budget]\ncalls = 1\n");
        assert!(!approvals.know(&draft).unwrap());
        approvals.add(&draft).unwrap();
        approvals.add(&draft).unwrap();
        assert!(approvals.know(&draft).unwrap());
        assert_eq!(approvals.all().unwrap().len(), 1);
        assert!(!approvals.know(&write("b.toml", "[budget]\ncalls = 1\n")).unwrap(), "elsewhere");
        assert!(!approvals.know(&write("a.toml", "[budget]\ncalls = 2\n")).unwrap(), "changed");
        assert_eq!(approvals.remove(&draft.path).unwrap(), 1);
        assert_eq!(approvals.all().unwrap(), vec![]);
        std::fs::write(&approvals.file, "no approval\n").unwrap();
        assert!(approvals.all().unwrap_err().to_string().contains("in line 1"));
    }
}
