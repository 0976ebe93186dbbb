//! The objects that packs are fitted on: those of shards, none of which may be held out, and our own.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::recipe::{DataRecipe, Families};
use super::{FitError, Watcher};
use crate::dataset::Specimen;
use crate::dataset::evalcase::specimen;
use crate::dataset::library::{check_held_out, held_out};
use crate::dataset::shards::{Bundle, read_shard, shards};
use crate::procedural::{Id, worded};
use crate::truth::TruthFile;

/// So many objects of our own families are made together.
const TOGETHER: usize = 45;

/// An object and what it is, in words.
#[derive(Clone, Debug)]
pub(super) struct Subject {
    pub specimen: Specimen,
    pub category: String,
}

/// Which objects of the shards are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Split {
    Train,
    Validation,
}

impl Split {
    /// What the split is called in truth files.
    fn name(self) -> &'static str {
        match self {
            Self::Train => "train",
            Self::Validation => "val",
        }
    }
}

/// What a recipe names, checked, and what it is made of.
pub(super) struct Data<'a> {
    recipe: &'a DataRecipe,
    held_out: BTreeSet<String>,
    /// Digests of every shard, by folder and name, and of every list, by name.
    pub digests: BTreeMap<String, String>,
    watcher: &'a dyn Watcher,
}

impl<'a> Data<'a> {
    pub(super) fn open(recipe: &'a DataRecipe, watcher: &'a dyn Watcher) -> Result<Self, FitError> {
        let mut held = BTreeSet::new();
        let mut digests = BTreeMap::new();
        let digest = |file: &Path| -> Result<String, FitError> {
            let bytes = std::fs::read(file).map_err(FitError::io(file))?;
            Ok(blake3::hash(&bytes).to_hex().to_string())
        };
        for list in &recipe.held_out {
            held.append(&mut held_out(list)?);
            let name = list.file_name().unwrap_or_default().to_string_lossy().into_owned();
            digests.insert(name, digest(list)?);
        }
        for folder in recipe.train.iter().chain(&recipe.validation) {
            for shard in shards(folder)? {
                digests.insert(called(&shard), digest(&shard)?);
            }
        }
        Ok(Self { recipe, held_out: held, digests, watcher })
    }

    /// What `one` makes of every object of a split, in order, of at most so many.
    ///
    /// # Errors
    /// [`FitError`] when a shard cannot be read or holds what must not be here.
    pub(super) fn of_shards<T: Send>(
        &self,
        split: Split,
        most: Option<usize>,
        one: impl Fn(&Subject) -> Vec<T> + Sync,
    ) -> Result<Vec<T>, FitError> {
        let (mut made, mut left) = (Vec::new(), most.unwrap_or(usize::MAX));
        for shard in self.shards(split)? {
            if left == 0 {
                break;
            }
            let (objects, some) = self.of_shard((&shard, split), left, &one)?;
            left -= objects;
            made.extend(some);
            self.watcher.say(&format!("{} is read: {} so far", called(&shard), made.len()));
        }
        Ok(made)
    }

    /// The shards of a split, in order.
    ///
    /// # Errors
    /// [`FitError`] when they cannot be listed.
    pub(super) fn shards(&self, split: Split) -> Result<Vec<PathBuf>, FitError> {
        let folder = match split {
            Split::Train => &self.recipe.train,
            Split::Validation => &self.recipe.validation,
        };
        Ok(folder.as_ref().map_or(Ok(Vec::new()), |folder| shards(folder))?)
    }

    /// What `one` makes of the objects of a shard, of at most so many, and how many those are.
    ///
    /// # Errors
    /// As [`Data::of_shards`].
    pub(super) fn of_shard<T: Send>(
        &self,
        (shard, split): (&Path, Split),
        most: usize,
        one: impl Fn(&Subject) -> Vec<T> + Sync,
    ) -> Result<(usize, Vec<T>), FitError> {
        let mut bundles = read_shard(shard)?;
        bundles.truncate(most);
        let from = (split.name(), &self.held_out);
        bundles.iter().try_for_each(|bundle| check_held_out(bundle, shard, from))?;
        let of = |bundle: &Bundle| match subject(bundle) {
            Ok(subject) => one(&subject),
            Err(why) => {
                self.watcher.say(&format!("{} is left out: {why}", bundle.id));
                Vec::new()
            }
        };
        Ok((bundles.len(), bundles.par_iter().flat_map_iter(of).collect()))
    }
}

/// The name of a file with that of its folder.
pub(super) fn called(file: &Path) -> String {
    let name = |path: Option<&Path>| {
        path.and_then(Path::file_name).unwrap_or_default().to_string_lossy().into_owned()
    };
    format!("{}/{}", name(file.parent()), name(Some(file)))
}

fn subject(bundle: &Bundle) -> Result<Subject, String> {
    let truth = TruthFile::from_json(&bundle.truth).map_err(|e| e.to_string())?;
    Ok(Subject { specimen: specimen(bundle)?, category: truth.category })
}

/// What `one` makes of objects of our own families, in order, each in one of its wordings.
///
/// # Errors
/// [`FitError`] when a family's own rules do not make a valid object.
pub(super) fn of_families<T: Send>(
    families: &Families,
    seed: u64,
    one: impl Fn(&Subject) -> Vec<T> + Sync,
) -> Result<Vec<T>, FitError> {
    let mut made = Vec::new();
    for ids in together(families) {
        made.extend(of_ids(&ids, seed, &one)?);
    }
    Ok(made)
}

/// Ids of our own families, as many at once as are made together.
pub(super) fn together(families: &Families) -> Vec<Vec<Id>> {
    families.ids().chunks(TOGETHER).map(<[Id]>::to_vec).collect()
}

/// What `one` makes of some objects of our own families, in order.
///
/// # Errors
/// As [`of_families`].
pub(super) fn of_ids<T: Send>(
    ids: &[Id],
    seed: u64,
    one: impl Fn(&Subject) -> Vec<T> + Sync,
) -> Result<Vec<T>, FitError> {
    let of = |id: &Id| {
        let specimen = worded(*id, seed)?;
        Ok::<_, FitError>(one(&Subject { specimen, category: id.category() }))
    };
    let made = ids.par_iter().map(of).collect::<Result<Vec<_>, _>>()?;
    Ok(made.into_iter().flatten().collect())
}
