//! What a fit is told: the file behind `kinfold train RECIPE.toml`.

use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde::de::DeserializeOwned;

use super::FitError;
use crate::procedural;

/// Which pack is fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Fit {
    /// Which segments are of one part, and which part each is of.
    Segments,
    /// Where the axis of a joint lies.
    Axes,
    /// How far a joint goes.
    Ranges,
    /// What parts of a role look like.
    Roles,
    /// Which components that touch are of one part.
    Contacts,
    /// How large parts usually are.
    Sizes,
    /// Which part a segment of a fused mesh is of, before anything else is asked.
    FusedUnary,
    /// How likely parts and joints are right.
    Confidence,
}

/// Every fit and how a recipe names it.
pub const FITS: [(&str, Fit); 8] = [
    ("segments", Fit::Segments),
    ("axes", Fit::Axes),
    ("ranges", Fit::Ranges),
    ("roles", Fit::Roles),
    ("contacts", Fit::Contacts),
    ("sizes", Fit::Sizes),
    ("fused_unary", Fit::FusedUnary),
    ("confidence", Fit::Confidence),
];

/// A recipe. Paths are relative to the file it is read from.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Recipe<T> {
    /// Which pack is fitted.
    pub fit: Fit,
    /// The folder of the run: what is finished is kept there.
    pub out: PathBuf,
    /// Where the pack goes.
    pub pack: PathBuf,
    /// What it is fitted on.
    #[serde(default)]
    pub data: DataRecipe,
    /// How.
    pub model: T,
}

/// What packs are fitted on, beside our own families.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DataRecipe {
    /// A folder of shards to learn from.
    pub train: Option<PathBuf>,
    /// A folder of shards that what was learned is judged by, and never learned from.
    pub validation: Option<PathBuf>,
    /// Lists of record ids that must not be here; they end the run where they turn up.
    #[serde(default)]
    pub held_out: Vec<PathBuf>,
}

/// Objects of our own families.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Families {
    /// So many of each.
    pub each: usize,
    /// But none of these.
    #[serde(default)]
    pub without: Vec<String>,
}

impl Families {
    /// Their ids.
    pub fn ids(&self) -> Vec<procedural::Id> {
        let is_wanted = |id: &procedural::Id| self.without.iter().all(|name| name != id.family());
        procedural::each(self.each).filter(is_wanted).collect()
    }

    fn check(&self) -> Result<(), String> {
        let is_known = |name: &&String| procedural::names().any(|known| known == *name);
        match self.without.iter().find(|name| !is_known(name)) {
            Some(name) => Err(format!("`model.families.without`: there is no family `{name}`")),
            None => Ok(()),
        }
    }
}

/// How a pack is fitted.
pub trait Model: DeserializeOwned {
    /// The objects of our own families that are learned from, list by list.
    fn families(&self) -> Vec<&Families>;

    /// Whether objects of validation are learned from: by what says how sure other packs are.
    const LEARNS_FROM_VALIDATION: bool = false;

    /// Refuses what cannot be fitted: field, rule and what was found.
    ///
    /// # Errors
    /// The first broken rule.
    fn check(&self) -> Result<(), String>;
}

/// The field `fit` of a configuration; nothing where it has none, as a network's.
///
/// # Errors
/// [`FitError`] when the file cannot be read, is no TOML, or names a fit that is none.
pub fn fit_of(path: &Path) -> Result<Option<Fit>, FitError> {
    let text = std::fs::read_to_string(path).map_err(FitError::io(path))?;
    let table: toml::Table = toml::from_str(&text).map_err(|e| FitError::recipe(path, e))?;
    let Some(found) = table.get("fit") else { return Ok(None) };
    let known = FITS.iter().find(|(name, _)| found.as_str() == Some(name));
    match known {
        Some((_, fit)) => Ok(Some(*fit)),
        None => {
            let names = FITS.map(|(name, _)| name).join(", ");
            Err(FitError::recipe(path, format!("`fit` must be one of {names}, found {found}")))
        }
    }
}

impl<T: Model> Recipe<T> {
    /// Reads a recipe; paths become relative to the working directory. With it comes its text.
    ///
    /// # Errors
    /// [`FitError`] when it cannot be read, has a field that nobody knows or breaks a rule.
    pub fn read(path: &Path) -> Result<(Self, String), FitError> {
        let text = std::fs::read_to_string(path).map_err(FitError::io(path))?;
        let mut recipe: Self = toml::from_str(&text).map_err(|e| FitError::recipe(path, e))?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let data = &mut recipe.data;
        let paths = [&mut recipe.out, &mut recipe.pack].into_iter().chain(&mut data.train);
        for path in paths.chain(&mut data.validation).chain(&mut data.held_out) {
            *path = folder.join(&*path);
        }
        recipe.check().map_err(|what| FitError::recipe(path, what))?;
        Ok((recipe, text))
    }

    fn check(&self) -> Result<(), String> {
        let families = self.model.families();
        families.iter().try_for_each(|f| f.check())?;
        let has_shards = self.data.train.is_some() || T::LEARNS_FROM_VALIDATION;
        if !has_shards && families.iter().all(|f| f.ids().is_empty()) {
            return Err("there is nothing to learn from: neither `data.train` nor \
                        `model.families` gives any object"
                .into());
        }
        self.model.check()?;
        self.data.check()
    }
}

impl DataRecipe {
    fn check(&self) -> Result<(), String> {
        let Self { train, validation, held_out } = self;
        for (name, folder) in [("train", train), ("validation", validation)] {
            match folder {
                Some(folder) if !folder.is_dir() => {
                    return Err(format!(
                        "`data.{name}` must be a folder of shards, found none at {}",
                        folder.display()
                    ));
                }
                Some(_) if held_out.is_empty() => {
                    return Err(format!(
                        "`data.held_out` must name a list of records that are held out where \
                         `data.{name}` is given, found none"
                    ));
                }
                _ => {}
            }
        }
        Ok(())
    }
}

/// Refuses a count outside what makes sense.
pub(super) fn counted(name: &str, count: usize, range: [usize; 2]) -> Result<(), String> {
    let [least, most] = range;
    if (least..=most).contains(&count) {
        return Ok(());
    }
    Err(format!("`{name}` must be from {least} to {most}, found {count}"))
}
