//! Where a pack comes from: the commit whose sources the program was built from, if that can be told.

use std::path::Path;
use std::process::Command;

use super::sources;

/// The digest of the sources that this program was built from.
pub(crate) const BUILT_FROM: &str = env!("KINFOLD_CODE_FIT");
/// The commit, where it cannot be told.
pub(crate) const UNKNOWN: &str = "unknown";

/// The commit of the program: of the checkout that holds `near`, if its sources are those that the program
/// was built from and none of them was changed since the commit; otherwise [`UNKNOWN`].
pub(crate) fn commit(near: &Path) -> String {
    found(near).unwrap_or_else(|| UNKNOWN.into())
}

fn found(near: &Path) -> Option<String> {
    let folder = near.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let root = git(folder, &["rev-parse", "--show-toplevel"])?;
    let root = Path::new(&root);
    if sources::digest(root).ok()? != BUILT_FROM {
        return None;
    }
    let changed = [&["status", "--porcelain", "--"][..], &sources::PLACES].concat();
    let is_committed = git(root, &changed)?.is_empty();
    is_committed.then(|| git(root, &["rev-parse", "HEAD"]))?
}

/// What git says, without the line's end.
fn git(folder: &Path, words: &[&str]) -> Option<String> {
    let said = Command::new("git").arg("-C").arg(folder).args(words).output().ok()?;
    let told = String::from_utf8(said.stdout).ok()?;
    said.status.success().then(|| told.trim_end().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outside_a_checkout_of_its_sources_a_program_names_no_commit() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(commit(&folder.path().join("recipe.toml")), UNKNOWN);
    }

    #[test]
    fn a_commit_is_forty_digits_or_unknown() {
        let here = Path::new(env!("CARGO_MANIFEST_DIR")).join("recipes/ranges.toml");
        let told = commit(&here);
        let is_commit = told.len() == 40 && told.bytes().all(|b| b.is_ascii_hexdigit());
        assert!(is_commit || told == UNKNOWN, "{told}");
        assert_eq!(BUILT_FROM.len(), 64);
    }
}
