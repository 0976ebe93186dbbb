//! Fits: every pack that ships, from a recipe.
//!
//! A recipe ([`Recipe`]) names what is fitted, on what and how; [`fit`] makes the pack of it. The same
//! recipe, data and program give the same bytes. Every model that is finished is kept in the run's folder
//! with the digest of all that it was made from, so a run that was killed goes on and ends with the bytes
//! of one that was not.
//!
//! | Module | What it fits |
//! |---|---|
//! | [`segments`] | ensembles of forests that say which part a segment is of |
//! | [`axes`] | forests and a network that choose the axis of a joint |
//! | [`ranges`] | forests that say how far a joint goes |
//! | [`confidence`] | forests that say how likely parts and joints are right, and their calibration |
//! | [`priors`] | weights: what roles look like, which contacts hold, how large parts are, and what speaks for a part on fused meshes |

pub mod axes;
mod bench;
pub mod confidence;
mod data;
mod error;
mod kept;
mod origin;
pub mod priors;
pub mod ranges;
pub mod recipe;
pub mod segments;
mod sources;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use model::classic;
use model::classic::learned::pack;
use model::classic::learned::pack::{Head, Origin, Pack};

use crate::alone::Alone;
use crate::dataset::cache::write_whole;
use bench::{Bench, Fits, Fitted};
use data::Data;
pub use error::{FitError, Watcher};
use kept::Kept;
pub use recipe::{Fit, Model, Recipe, fit_of};

/// How a run ended.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// Whether the pack is there.
    pub finished: bool,
    /// Where it is, or will be.
    pub pack: PathBuf,
    /// How many models this run made.
    pub made: usize,
    /// How many it took over from earlier runs.
    pub found: usize,
    /// How well the pack did when it was fitted, by name.
    pub metrics: BTreeMap<String, f64>,
}

/// Makes the pack of a recipe, or goes on with it, until it is there or the watcher has enough.
///
/// # Errors
/// [`FitError`]; what is finished is safe.
pub fn fit(path: &Path, watcher: &dyn Watcher) -> Result<Outcome, FitError> {
    let found = fit_of(path)?;
    match found
        .ok_or_else(|| FitError::recipe(path, "`fit` must say what is fitted, found none"))?
    {
        Fit::Segments => run::<segments::Segments>(path, watcher),
        Fit::Axes => run::<axes::Axes>(path, watcher),
        Fit::Ranges => run::<ranges::Ranges>(path, watcher),
        Fit::Roles => run::<priors::roles::Roles>(path, watcher),
        Fit::Contacts => run::<priors::contacts::Contacts>(path, watcher),
        Fit::Sizes => run::<priors::sizes::Sizes>(path, watcher),
        Fit::FusedUnary => run::<priors::fused_unary::FusedUnary>(path, watcher),
        Fit::Confidence => run::<confidence::Confidence>(path, watcher),
    }
}

/// Reads a recipe of any fit, and leaves it at that.
///
/// # Errors
/// [`FitError`] when it breaks a rule.
pub fn check(path: &Path) -> Result<(), FitError> {
    let found = fit_of(path)?;
    match found
        .ok_or_else(|| FitError::recipe(path, "`fit` must say what is fitted, found none"))?
    {
        Fit::Segments => Recipe::<segments::Segments>::read(path).map(|_| ()),
        Fit::Axes => Recipe::<axes::Axes>::read(path).map(|_| ()),
        Fit::Ranges => Recipe::<ranges::Ranges>::read(path).map(|_| ()),
        Fit::Roles => Recipe::<priors::roles::Roles>::read(path).map(|_| ()),
        Fit::Contacts => Recipe::<priors::contacts::Contacts>::read(path).map(|_| ()),
        Fit::Sizes => Recipe::<priors::sizes::Sizes>::read(path).map(|_| ()),
        Fit::FusedUnary => Recipe::<priors::fused_unary::FusedUnary>::read(path).map(|_| ()),
        Fit::Confidence => Recipe::<confidence::Confidence>::read(path).map(|_| ()),
    }
}

fn run<T: Fits>(path: &Path, watcher: &dyn Watcher) -> Result<Outcome, FitError> {
    let (recipe, text) = Recipe::<T>::read(path)?;
    let out = &recipe.out;
    std::fs::create_dir_all(out).map_err(FitError::io(out))?;
    let _lock = alone(out)?;
    let mut packs = classic::digests();
    packs.retain(|name, _| T::READS.contains(name));
    let data = Data::open(&recipe.data, watcher)?;
    let bench = Bench { data, kept: Kept::open(out, watcher)?, watcher, packs };
    let origin = origin_of(path, text, &bench);
    let bytes = match whole(&recipe.model, origin, &bench) {
        Err(FitError::Stopped) => None,
        bytes => Some(bytes?),
    };
    let metrics = bytes.as_deref().and_then(|bytes| Pack::open("fitted", bytes).ok());
    let metrics = metrics.map(|pack| pack.head.origin.metrics).unwrap_or_default();
    if let Some(bytes) = &bytes {
        let folder = recipe.pack.parent().unwrap_or(Path::new(""));
        std::fs::create_dir_all(folder).map_err(FitError::io(folder))?;
        write_whole(&recipe.pack, bytes).map_err(FitError::io(&recipe.pack))?;
    }
    let ([made, found], pack) = (bench.kept.counts(), recipe.pack);
    Ok(Outcome { finished: bytes.is_some(), pack, made, found, metrics })
}

/// The pack, fitted or taken over whole.
fn whole(model: &impl Fits, origin: Origin, bench: &Bench<'_>) -> Result<Vec<u8>, FitError> {
    let inputs = bench.inputs(&format!("{:?} {:?}", origin.recipe, origin.commit));
    if let Some(bytes) = bench.kept.find("pack", &inputs) {
        bench.watcher.say("the pack is taken over whole");
        return Ok(bytes);
    }
    let bytes = packed(model.fitted(bench)?, origin)?;
    bench.kept.keep("pack", &inputs, &bytes)?;
    Ok(bytes)
}

/// Keeps other runs out of a folder until the result is dropped or the process ends.
fn alone(out: &Path) -> Result<Alone, FitError> {
    let taken = Alone::in_folder(out).map_err(FitError::io(out))?;
    taken.ok_or_else(|| FitError::Busy(out.into()))
}

fn origin_of(path: &Path, recipe: String, bench: &Bench<'_>) -> Origin {
    let packs = bench.packs.iter().map(|(name, digest)| (format!("{name}.pack"), digest.clone()));
    let data = bench.data.digests.clone().into_iter().chain(packs).collect();
    let commit = Some(origin::commit(path));
    Origin { recipe: Some(recipe), commit, data, ..Origin::default() }
}

fn packed(fitted: Fitted, origin: Origin) -> Result<Vec<u8>, FitError> {
    let Fitted { kind, tables, ensembles, settings, sections, metrics } = fitted;
    // JSON knows finite numbers alone.
    let metrics = metrics.into_iter().filter(|(_, value)| value.is_finite()).collect();
    let mut head = Head::new(kind, tables, Origin { metrics, ..origin });
    (head.ensembles, head.settings) = (ensembles, settings);
    Ok(pack::write(head, sections)?)
}

#[cfg(test)]
mod tests;
