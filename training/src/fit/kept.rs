//! What a run has finished, in its folder: a run that was ended goes on, and nothing is taken over that was
//! made from anything else.

use std::cell::Cell;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use model::classic::learned::forest::Forest;

use super::{FitError, Watcher};
use crate::dataset::cache::write_whole;
use crate::forest::{Growth, Lessons};

/// How trees are grown: the same lessons give other trees where this changes.
const GROWER: &str = include_str!("../forest.rs");
/// How often the loss is told while a forest grows.
const TOLD: usize = 4;
/// Digits of a digest in a name.
const DIGITS: usize = 16;

/// The folder of a run.
pub(super) struct Kept<'a> {
    folder: PathBuf,
    watcher: &'a dyn Watcher,
    made: Cell<usize>,
    found: Cell<usize>,
}

impl<'a> Kept<'a> {
    pub(super) fn open(out: &Path, watcher: &'a dyn Watcher) -> Result<Self, FitError> {
        let folder = out.join("finished");
        std::fs::create_dir_all(&folder).map_err(FitError::io(&folder))?;
        Ok(Self { folder, watcher, made: Cell::new(0), found: Cell::new(0) })
    }

    /// How many models were made, and how many were taken over from before.
    pub(super) fn counts(&self) -> [usize; 2] {
        [self.made.get(), self.found.get()]
    }

    /// The forest of these lessons about the objects that it knows, grown or taken over. `name` says which
    /// it is, as far as files and reports go.
    ///
    /// # Errors
    /// [`FitError::Stopped`] when nobody wants another one, [`FitError`] of the disk.
    pub(super) fn forest<const N: usize>(
        &self,
        name: &str,
        (lessons, growth): (&Lessons<'_, N>, &Growth),
        knows: impl Fn(usize) -> bool,
    ) -> Result<Forest<N>, FitError> {
        let mut inputs = blake3::Hasher::new();
        inputs.update(GROWER.as_bytes()).update(format!("{growth:?}").as_bytes());
        lessons.hash_into(&mut inputs);
        (0..lessons.objects()).for_each(|object| {
            inputs.update(&[u8::from(knows(object))]);
        });
        let every = (growth.trees / TOLD).max(1);
        let grow = || {
            let forest = lessons.grow(growth, &knows, |trees, loss| {
                if trees.is_multiple_of(every) {
                    self.watcher.say(&format!("  {name}, {trees} trees: loss {loss:.4}"));
                }
            });
            let mut bytes = Vec::new();
            forest.write(&mut bytes);
            Ok(bytes)
        };
        let bytes = self.model(name, &inputs, grow)?;
        let whole = Forest::read(&mut &bytes[..]);
        whole.ok_or_else(|| FitError::Broken(format!("the forest `{name}` cannot be read back")))
    }

    /// A model as bytes, made or taken over.
    ///
    /// # Errors
    /// As [`Kept::forest`], or what making it says.
    pub(super) fn model(
        &self,
        name: &str,
        inputs: &blake3::Hasher,
        make: impl FnOnce() -> Result<Vec<u8>, FitError>,
    ) -> Result<Vec<u8>, FitError> {
        if let Some(bytes) = self.find(name, inputs) {
            self.found.set(self.found.get() + 1);
            return Ok(bytes);
        }
        if !self.watcher.go_on(self.made.get()) {
            return Err(FitError::Stopped);
        }
        let bytes = make()?;
        self.keep(name, inputs, &bytes)?;
        self.made.set(self.made.get() + 1);
        Ok(bytes)
    }

    /// What was kept under this name and made from these inputs, if it is whole.
    pub(super) fn find(&self, name: &str, inputs: &blake3::Hasher) -> Option<Vec<u8>> {
        let mut bytes = std::fs::read(self.place(name, inputs)).ok()?;
        let content = bytes.len().checked_sub(blake3::OUT_LEN)?;
        let is_whole = blake3::hash(&bytes[..content]).as_bytes() == &bytes[content..];
        bytes.truncate(content);
        is_whole.then_some(bytes)
    }

    /// Keeps something: it is there whole or not at all.
    pub(super) fn keep(
        &self,
        name: &str,
        inputs: &blake3::Hasher,
        bytes: &[u8],
    ) -> Result<(), FitError> {
        let path = self.place(name, inputs);
        let sealed = [bytes, blake3::hash(bytes).as_bytes()].concat();
        write_whole(&path, &sealed).map_err(FitError::io(&path))
    }

    fn place(&self, name: &str, inputs: &blake3::Hasher) -> PathBuf {
        let mut file = String::new();
        for letter in name.chars() {
            file.push(if letter.is_ascii_alphanumeric() { letter } else { '-' });
        }
        let digest = inputs.finalize().to_hex();
        // A string takes whatever is written.
        let _ = write!(file, ".{}", &digest[..DIGITS]);
        self.folder.join(file)
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::Quiet;
    use super::*;

    fn inputs(text: &str) -> blake3::Hasher {
        let mut inputs = blake3::Hasher::new();
        inputs.update(text.as_bytes());
        inputs
    }

    #[test]
    fn what_is_finished_is_taken_over_only_for_the_same_inputs_and_only_whole() {
        let folder = tempfile::tempdir().unwrap();
        let kept = Kept::open(folder.path(), &Quiet).unwrap();
        let make = |bytes: &'static [u8]| move || Ok(bytes.to_vec());
        assert_eq!(kept.model("a, fold 0", &inputs("x"), make(b"one")).unwrap(), b"one");
        assert_eq!(kept.model("a, fold 0", &inputs("x"), make(b"two")).unwrap(), b"one");
        assert_eq!(kept.model("a, fold 0", &inputs("y"), make(b"two")).unwrap(), b"two");
        assert_eq!(kept.counts(), [2, 1]);
        let path = kept.place("a, fold 0", &inputs("x"));
        let mut torn = std::fs::read(&path).unwrap();
        torn[0] ^= 1;
        std::fs::write(&path, torn).unwrap();
        assert_eq!(kept.find("a, fold 0", &inputs("x")), None);
    }
}
