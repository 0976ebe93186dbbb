//! The condition file: read, watched and written whole, never over what somebody else wrote meanwhile.

use std::fs;
use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};

use object::Condition;
use object::condition::{ConditionError, Plain, plain};
use object::mesh::UpAxis;
use serde_json::{Value, json};
use tempfile::NamedTempFile;

/// Most bytes of a condition file, as of one that is given to `make`.
const MOST: u64 = 1 << 20;
/// Texts with comments that are kept beside a file: a guess, far above what one person writes.
const KEPT: usize = 99;

/// Why a condition file cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub enum PaperError {
    /// The file system says no.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: String,
        /// What it says.
        source: std::io::Error,
    },
    /// It is no file that could be a condition.
    #[error("{path}: expected {expected}, found {found}")]
    Kind {
        /// The file.
        path: String,
        /// The rule.
        expected: &'static str,
        /// What was found.
        found: String,
    },
    /// What is to be written is no JSON.
    #[error(transparent)]
    Text(#[from] ConditionError),
    /// It is not what the change was made to.
    #[error("{0} was changed by somebody else meanwhile")]
    Changed(String),
}

/// A condition file and what stood in it when it was looked at last. One that is not there yet is an
/// object without parts.
#[derive(Clone, Debug)]
pub struct Paper {
    path: PathBuf,
    text: String,
    revision: String,
    plain: Result<Plain, ConditionError>,
    up: UpAxis,
}

impl Paper {
    /// Looks at a file; `up` is the up axis of one that does not say.
    ///
    /// # Errors
    /// [`PaperError`] when something stands there that is no readable file of at most 1 MiB.
    pub fn open(path: &Path, up: UpAxis) -> Result<Self, PaperError> {
        // A link is written through to what it leads to, so that it stays one.
        let path = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
        let text = on_disk(&path)?;
        Ok(Self::of(path, text, up))
    }

    fn of(path: PathBuf, text: Option<String>, up: UpAxis) -> Self {
        let text = text.unwrap_or_default();
        let nothing = || Plain { document: empty(), has_comments: false };
        let plain = if text.trim().is_empty() { Ok(nothing()) } else { plain(&text) };
        Self { revision: revision(&text), path, text, plain, up }
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What stands in it; nothing where there is none yet.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Names what stands in it: the same text, the same revision.
    pub fn revision(&self) -> &str {
        &self.revision
    }

    /// What it says, whatever is wrong with it; an object without parts where it is no JSON at all.
    pub fn document(&self) -> Value {
        let mut document = self.plain.as_ref().map_or_else(|_| empty(), |p| p.document.clone());
        // An axis that was said on the command line is written down with the first change.
        if let Some(fields) = document.as_object_mut().filter(|_| self.up == UpAxis::Z) {
            fields.entry("up").or_insert_with(|| "z".into());
        }
        document
    }

    /// The up axis that the mesh was read with.
    pub fn up(&self) -> UpAxis {
        self.up
    }

    /// Whether it has comments, which are lost when it is written anew.
    pub fn has_comments(&self) -> bool {
        self.plain.as_ref().is_ok_and(|plain| plain.has_comments)
    }

    /// The condition.
    ///
    /// # Errors
    /// [`ConditionError`]: all that is wrong with it.
    pub fn condition(&self) -> Result<Condition, ConditionError> {
        let condition = Condition::from_json_with(&self.text, self.up)?;
        let name = |up| if up == UpAxis::Z { "z" } else { "y" };
        if condition.frame.up != self.up {
            let (said, begun) = (name(condition.frame.up), name(self.up));
            let told = format!(
                "`up` is {said}, but the mesh was read with {begun} up: end the studio and begin it again"
            );
            return Err(ConditionError::told(told));
        }
        Ok(condition)
    }

    /// Looks at the file again; whether somebody else changed it.
    ///
    /// # Errors
    /// [`PaperError`] when it cannot be read any more.
    pub fn look(&mut self) -> Result<bool, PaperError> {
        let text = on_disk(&self.path)?;
        let changed = text.as_deref().unwrap_or_default() != self.text;
        if changed {
            *self = Self::of(self.path.clone(), text, self.up);
        }
        Ok(changed)
    }

    /// Writes another text, in one step, if the file still is of the revision `base`. A text that is no
    /// condition yet is written, too; one that is no JSON is not. The first text with comments stays
    /// beside it, as `NAME.commented`.
    ///
    /// # Errors
    /// [`PaperError::Changed`] if it is not: this then is what stands there now. [`PaperError::Text`] if
    /// the text is no JSON.
    pub fn write(&mut self, text: &str, base: &str) -> Result<(), PaperError> {
        if text.len() as u64 > MOST {
            return Err(self.kind("at most 1 MiB", format!("{} bytes", text.len())));
        }
        plain(text)?;
        self.look()?;
        if self.revision != base {
            return Err(PaperError::Changed(self.shown()));
        }
        if text == self.text {
            return Ok(());
        }
        if self.has_comments() {
            self.keep_comments()?;
        }
        if fs::metadata(&self.path).is_ok_and(|about| about.permissions().readonly()) {
            return Err(self.io(ErrorKind::PermissionDenied.into()));
        }
        self.fresh(text)?.persist(&self.path).map_err(|e| self.io(e.error))?;
        *self = Self::of(self.path.clone(), Some(text.to_owned()), self.up);
        Ok(())
    }

    /// Puts the text beside the file, whole, under the first name that is free or has it already.
    fn keep_comments(&self) -> Result<(), PaperError> {
        for number in 1..=KEPT {
            let mut name = self.path.file_name().unwrap_or_default().to_owned();
            name.push(if number == 1 {
                ".commented".into()
            } else {
                format!(".commented.{number}")
            });
            let place = self.path.with_file_name(name);
            if guard::files::read(&place, MOST).is_ok_and(|there| there == self.text.as_bytes()) {
                return Ok(());
            }
            match self.fresh(&self.text)?.persist_noclobber(&place) {
                Ok(_) => return Ok(()),
                Err(e) if e.error.kind() == ErrorKind::AlreadyExists => {}
                Err(e) => return Err(self.io(e.error)),
            }
        }
        Err(self.kind("fewer kept texts with comments beside it", format!("{KEPT} of them")))
    }

    /// A text in a file of its own beside this one, on disk.
    fn fresh(&self, text: &str) -> Result<NamedTempFile, PaperError> {
        let folder = self.path.parent().filter(|p| !p.as_os_str().is_empty());
        let mut file = tempfile::Builder::new();
        file.prefix(".kinfold-condition-");
        #[cfg(unix)]
        file.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o644));
        let file = file.tempfile_in(folder.unwrap_or(Path::new(".")));
        let mut file = file.map_err(|e| self.io(e))?;
        // Who may read it stays as it was.
        if let Ok(about) = fs::metadata(&self.path) {
            file.as_file().set_permissions(about.permissions()).map_err(|e| self.io(e))?;
        }
        let written = file.write_all(text.as_bytes()).and_then(|()| file.as_file().sync_all());
        written.map_err(|e| self.io(e))?;
        Ok(file)
    }

    /// Its path as it may be printed.
    pub fn shown(&self) -> String {
        guard::text::shown(&self.path.to_string_lossy()).into_owned()
    }

    fn io(&self, source: std::io::Error) -> PaperError {
        PaperError::Io { path: self.shown(), source }
    }

    fn kind(&self, expected: &'static str, found: String) -> PaperError {
        PaperError::Kind { path: self.shown(), expected, found }
    }
}

/// The text of a file; nothing where there is none.
fn on_disk(path: &Path) -> Result<Option<String>, PaperError> {
    let shown = || guard::text::shown(&path.to_string_lossy()).into_owned();
    match fs::symlink_metadata(path) {
        Err(e) if e.kind() == ErrorKind::NotFound => return Ok(None),
        Err(source) => return Err(PaperError::Io { path: shown(), source }),
        Ok(_) => {}
    }
    let kind = |found: String| PaperError::Kind {
        path: shown(),
        expected: "a readable file of at most 1 MiB, UTF-8",
        found,
    };
    let bytes = guard::files::read(path, MOST).map_err(|e| kind(e.to_string()))?;
    String::from_utf8(bytes).map(Some).map_err(|e| kind(e.to_string()))
}

fn revision(text: &str) -> String {
    blake3::hash(text.as_bytes()).to_hex()[..16].to_owned()
}

/// An object of which nothing is said yet.
fn empty() -> Value {
    json!({ "schema": object::condition::SCHEMA, "category": "", "parts": [] })
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on stops")]
mod tests {
    use super::*;

    fn paper(text: Option<&str>) -> (tempfile::TempDir, Paper) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.json");
        text.iter().for_each(|text| fs::write(&path, text).unwrap());
        let paper = Paper::open(&path, UpAxis::Y).unwrap();
        (folder, paper)
    }

    #[test]
    fn what_somebody_else_wrote_is_never_written_over() {
        let (_folder, mut paper) = paper(Some("{ \"parts\": [] }"));
        let base = paper.revision().to_owned();
        fs::write(paper.path(), "{ \"parts\": [{}] }").unwrap();
        assert!(matches!(paper.write("{}", &base), Err(PaperError::Changed(_))));
        assert_eq!(paper.text(), "{ \"parts\": [{}] }", "what stands there now");
        let base = paper.revision().to_owned();
        paper.write("{}", &base).unwrap();
        assert_eq!(fs::read_to_string(paper.path()).unwrap(), "{}");
    }

    #[test]
    fn a_draft_with_faults_is_kept_and_no_json_is_not() {
        let (_folder, mut paper) = paper(None);
        assert_eq!((paper.text(), &paper.document()), ("", &empty()));
        let draft = "{ \"parts\": [{ \"name\": \"a\", \"parent\": \"b\" }] }";
        let base = paper.revision().to_owned();
        paper.write(draft, &base).unwrap();
        assert!(paper.condition().is_err());
        assert_eq!(fs::read_to_string(paper.path()).unwrap(), draft);
        let base = paper.revision().to_owned();
        assert!(matches!(paper.write("{ \"parts\": [", &base), Err(PaperError::Text(_))));
        assert_eq!(fs::read_to_string(paper.path()).unwrap(), draft);
    }

    #[test]
    fn comments_stay_beside_what_is_written_anew() {
        let (folder, mut paper) = paper(Some("// mine\n{ parts: [] }"));
        let path = paper.path().to_owned();
        for text in ["{}", "{ \"parts\": [] }"] {
            let base = paper.revision().to_owned();
            paper.write(text, &base).unwrap();
        }
        let kept = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
        assert_eq!(kept("a.json.commented"), "// mine\n{ parts: [] }");
        fs::write(&path, "// theirs\n{}").unwrap();
        paper.look().unwrap();
        let base = paper.revision().to_owned();
        paper.write("{}", &base).unwrap();
        assert_eq!(kept("a.json.commented"), "// mine\n{ parts: [] }");
        assert_eq!(kept("a.json.commented.2"), "// theirs\n{}");
    }

    #[test]
    fn an_up_axis_that_was_said_is_written_down_and_another_is_a_fault() {
        let folder = tempfile::tempdir().unwrap();
        let mut paper = Paper::open(&folder.path().join("a.json"), UpAxis::Z).unwrap();
        assert_eq!(paper.document()["up"], "z");
        let base = paper.revision().to_owned();
        paper.write("{ \"up\": \"y\", \"parts\": [{ \"name\": \"a\" }] }", &base).unwrap();
        let told = paper.condition().unwrap_err().to_string();
        assert!(told.starts_with("`up` is y, but the mesh was read with z up"), "{told}");
    }

    #[cfg(unix)]
    #[test]
    fn who_may_read_a_file_stays_as_it_was() {
        use std::os::unix::fs::PermissionsExt as _;
        let (_folder, mut paper) = paper(Some("{}"));
        fs::set_permissions(paper.path(), fs::Permissions::from_mode(0o600)).unwrap();
        let base = paper.revision().to_owned();
        paper.write("{ \"parts\": [] }", &base).unwrap();
        let mode = fs::metadata(paper.path()).unwrap().permissions().mode();
        assert_eq!(mode & 0o777, 0o600);
    }

    #[test]
    fn a_file_that_is_gone_or_grown_is_noticed() {
        let (_folder, mut paper) = paper(Some("{}"));
        assert!(!paper.look().unwrap());
        fs::remove_file(paper.path()).unwrap();
        assert!(paper.look().unwrap() && paper.text().is_empty());
        fs::write(paper.path(), vec![b' '; MOST as usize + 1]).unwrap();
        assert!(matches!(paper.look(), Err(PaperError::Kind { .. })));
    }
}
