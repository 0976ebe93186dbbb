//! The mixture: sources of objects, each with its weight, on shelves of measured samples.

use std::collections::BTreeSet;
use std::fs::File;
use std::path::{Path, PathBuf};

use rand::RngExt;
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::evalcase::specimen;
use super::prepare::{Shelf, Variant};
use super::sample::Counts;
use super::shards::{Bundle, read_shard, shards};
use super::{DataError, Sample, cache};
use crate::procedural;
use crate::truth::TruthFile;

/// A source of objects, as the configuration names it: a folder of shards, or our own families.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SourceConfig {
    /// What it is called; also in the cache.
    pub name: String,
    /// How often it is drawn from, relative to the others.
    #[serde(default = "one")]
    pub weight: f64,
    /// A folder of shards.
    #[serde(default)]
    pub shards: Option<PathBuf>,
    /// How many objects our own families make, taking turns.
    #[serde(default)]
    pub procedural: Option<usize>,
    /// At most this many objects of the shards; all where it is not given.
    #[serde(default)]
    pub most: Option<usize>,
    /// Random poses of each object, beside the one it comes in.
    #[serde(default)]
    pub states: usize,
    /// Closed skins of each object.
    #[serde(default)]
    pub fused: usize,
    /// How often a closed skin is shown where there is one.
    #[serde(default = "half")]
    pub fused_share: f64,
}

fn one() -> f64 {
    1.0
}

fn half() -> f64 {
    0.5
}

/// What objects are prepared for.
#[derive(Clone, Debug)]
pub struct Plan<'a> {
    /// Where samples are kept.
    pub cache: &'a Path,
    /// How many points they have.
    pub counts: Counts,
    /// Seed of poses, skins and points.
    pub seed: u64,
    /// The split that objects of shards must belong to: `train` or `val`.
    pub split: &'a str,
    /// Record ids that must not be used.
    pub held_out: &'a BTreeSet<String>,
}

/// Everything that can be drawn.
#[derive(Clone, Debug, Default)]
pub struct Library {
    sources: Vec<Source>,
}

#[derive(Clone, Debug)]
struct Source {
    weight: f64,
    fused_share: f64,
    objects: Vec<Object>,
}

/// The samples of one object.
#[derive(Clone, Debug, Default, PartialEq)]
struct Object {
    plain: Vec<PathBuf>,
    fused: Vec<PathBuf>,
}

/// Is told about each object that is ready.
pub type Ready<'a> = &'a (dyn Fn(&str) + Sync);

impl Library {
    /// Measures what is not measured yet, and takes stock.
    ///
    /// # Errors
    /// [`DataError`] when a source cannot be read, gives nothing, or holds what is held out.
    pub fn open(
        sources: &[SourceConfig],
        plan: &Plan<'_>,
        ready: Ready<'_>,
    ) -> Result<Self, DataError> {
        let _one_at_a_time = wait_for(plan.cache)?;
        let open = |config: &SourceConfig| -> Result<Source, DataError> {
            let shelf = Shelf::open(plan.cache, &config.name, plan.counts, plan.seed)?;
            let ids = match (&config.shards, config.procedural) {
                (Some(folder), None) => from_shards(folder, config, plan, &shelf, ready)?,
                (None, Some(count)) => from_families(count, config, plan, &shelf, ready)?,
                _ => vec![],
            };
            let objects = take_stock(&ids, config, &shelf);
            if objects.is_empty() {
                return Err(DataError::Empty(config.name.clone()));
            }
            Ok(Source { weight: config.weight, fused_share: config.fused_share, objects })
        };
        Ok(Self { sources: sources.iter().map(open).collect::<Result<_, _>>()? })
    }

    /// How many objects each source has.
    pub fn counts(&self) -> Vec<usize> {
        self.sources.iter().map(|s| s.objects.len()).collect()
    }

    /// Draws a sample: a source by weight, an object of it, one of its variants.
    ///
    /// # Errors
    /// [`DataError`] when it cannot be read back.
    pub fn draw(&self, rng: &mut Pcg64Mcg) -> Result<Sample, DataError> {
        let total: f64 = self.sources.iter().map(|s| s.weight).sum();
        let mut left = rng.random::<f64>() * total;
        let mut chosen = self.sources.first();
        for source in &self.sources {
            chosen = Some(source);
            left -= source.weight;
            if left < 0.0 {
                break;
            }
        }
        let source = chosen.ok_or_else(|| DataError::Empty("all".into()))?;
        cache::read(source.draw(rng))
    }

    /// The samples of every object, `fused` or not, at most `most` objects spread over all.
    pub fn shown(&self, fused: bool, most: usize) -> Vec<PathBuf> {
        let objects: Vec<&Object> = self.sources.iter().flat_map(|s| &s.objects).collect();
        let step = objects.len().div_ceil(most.max(1)).max(1);
        let of = |o: &&Object| if fused { o.fused.first() } else { o.plain.first() }.cloned();
        objects.iter().step_by(step).filter_map(of).collect()
    }
}

/// Waits until no other run measures into this cache, and keeps others waiting until the result is
/// dropped.
fn wait_for(cache: &Path) -> Result<File, DataError> {
    std::fs::create_dir_all(cache).map_err(DataError::io(cache))?;
    let path = cache.join("lock");
    let file = File::create(&path).map_err(DataError::io(&path))?;
    file.lock().map_err(DataError::io(&path))?;
    Ok(file)
}

impl Source {
    fn draw(&self, rng: &mut Pcg64Mcg) -> &Path {
        let object = &self.objects[rng.random_range(0..self.objects.len())];
        let wants_fused = rng.random::<f64>() < self.fused_share;
        let from = match (object.plain.is_empty(), object.fused.is_empty()) {
            (false, false) if wants_fused => &object.fused,
            (false, _) => &object.plain,
            _ => &object.fused,
        };
        &from[rng.random_range(0..from.len())]
    }
}

fn from_families(
    count: usize,
    config: &SourceConfig,
    plan: &Plan<'_>,
    shelf: &Shelf,
    ready: Ready<'_>,
) -> Result<Vec<String>, DataError> {
    let variants = Variant::all(config.states, config.fused);
    let one = |own: procedural::Id| {
        let id = own.to_string();
        if variants.iter().any(|&v| !shelf.is_settled(&id, v)) {
            let made = procedural::generate(own, plan.seed).map_err(|e| e.to_string());
            shelf.fill(&id, made.as_ref().map_err(String::as_str), &variants)?;
            ready(&id);
        }
        Ok(id)
    };
    let all: Vec<procedural::Id> = procedural::first(count).collect();
    all.into_par_iter().map(one).collect()
}

fn from_shards(
    folder: &Path,
    config: &SourceConfig,
    plan: &Plan<'_>,
    shelf: &Shelf,
    ready: Ready<'_>,
) -> Result<Vec<String>, DataError> {
    let variants = Variant::all(config.states, config.fused);
    let most = config.most.unwrap_or(usize::MAX);
    let mut ids = Vec::new();
    for path in shards(folder)? {
        let mut bundles = read_shard(&path)?;
        bundles.truncate(most.saturating_sub(ids.len()));
        for bundle in &bundles {
            check_held_out(bundle, &path, (plan.split, plan.held_out))?;
        }
        bundles.par_iter().try_for_each(|bundle| {
            if variants.iter().all(|&v| shelf.is_settled(&bundle.id, v)) {
                return Ok(());
            }
            let made = specimen(bundle);
            shelf.fill(&bundle.id, made.as_ref().map_err(String::as_str), &variants)?;
            ready(&bundle.id);
            Ok(())
        })?;
        ids.extend(bundles.into_iter().map(|b| b.id));
    }
    Ok(ids)
}

/// An object of another split, or one that is kept back, ends everything: it must not even be here.
///
/// # Errors
/// [`DataError::HeldOut`], or [`DataError::Broken`] when the truth cannot be read.
pub fn check_held_out(
    bundle: &Bundle,
    path: &Path,
    (split, held_out): (&str, &BTreeSet<String>),
) -> Result<(), DataError> {
    let refuse = |why: String| DataError::HeldOut { path: path.into(), id: bundle.id.clone(), why };
    let truth = TruthFile::from_json(&bundle.truth).map_err(|e| DataError::broken(path, e))?;
    if truth.split != split {
        let why = format!("it belongs to split `{}`, expected `{split}`", truth.split);
        return Err(refuse(why));
    }
    if held_out.contains(&truth.record_id) {
        return Err(refuse(format!("record `{}` is held out", truth.record_id)));
    }
    Ok(())
}

fn take_stock(ids: &[String], config: &SourceConfig, shelf: &Shelf) -> Vec<Object> {
    let stock = |id: &String| {
        let mut object = Object::default();
        for variant in Variant::all(config.states, config.fused) {
            let place = shelf.place(id, variant);
            match variant {
                _ if !place.exists() => {}
                Variant::Fused(_) => object.fused.push(place),
                _ => object.plain.push(place),
            }
        }
        (object != Object::default()).then_some(object)
    };
    ids.iter().filter_map(stock).collect()
}

/// Record ids of a list with the column `record_id`.
///
/// # Errors
/// [`DataError`] when it cannot be read or has no such column.
pub fn held_out(path: &Path) -> Result<BTreeSet<String>, DataError> {
    let text = std::fs::read_to_string(path).map_err(DataError::io(path))?;
    let mut lines = text.lines();
    let heads = lines.next().unwrap_or_default();
    let column = heads.split(',').position(|h| h.trim() == "record_id");
    let rule = "expected a first line that names the column record_id";
    let column = column.ok_or_else(|| DataError::broken(path, rule))?;
    Ok(lines.filter_map(|l| l.split(',').nth(column)).map(|id| id.trim().to_owned()).collect())
}

#[cfg(test)]
impl SourceConfig {
    /// Objects of our own families at rest.
    pub(crate) fn of_families(name: &str, objects: usize) -> Self {
        Self {
            name: name.into(),
            weight: 1.0,
            shards: None,
            procedural: Some(objects),
            most: None,
            states: 1,
            fused: 0,
            fused_share: 0.5,
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;

    use super::*;

    fn library(cache: &Path, sources: &[SourceConfig]) -> Result<Library, DataError> {
        let counts = Counts { even: 150, least: 10 };
        let plan = Plan { cache, counts, seed: 4, split: "train", held_out: &BTreeSet::default() };
        Library::open(sources, &plan, &|_| {})
    }

    #[test]
    fn the_same_seed_draws_the_same_samples_in_proportion_to_the_weights() {
        let folder = tempfile::tempdir().unwrap();
        let rare = SourceConfig { weight: 0.25, ..SourceConfig::of_families("rare", 1) };
        let library =
            library(folder.path(), &[rare, SourceConfig::of_families("common", 3)]).unwrap();
        assert_eq!(library.counts(), [1, 3]);
        let draw = |seed| library.draw(&mut Pcg64Mcg::seed_from_u64(seed)).unwrap();
        assert_eq!(draw(3), draw(3));
        let first =
            procedural::generate(procedural::Id::new("cabinet", 0).unwrap(), 4).unwrap().wordings;
        let is_rare = |s: &Sample| s.parts.iter().map(|p| &p.wordings).eq(&first);
        let rare = (0..200).filter(|&seed| is_rare(&draw(seed))).count();
        assert!((60..200).contains(&rare), "a fifth, and a third of the rest: {rare}");
        assert_eq!(library.shown(false, 2).len(), 2);
    }

    #[test]
    fn a_source_without_objects_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let told = library(folder.path(), &[SourceConfig::of_families("mine", 0)])
            .unwrap_err()
            .to_string();
        assert_eq!(told, "source `mine` has no usable object");
    }

    #[test]
    fn a_record_that_is_held_out_or_of_another_split_ends_everything() {
        let folder = tempfile::tempdir().unwrap();
        let list = folder.path().join("held.csv");
        std::fs::write(&list, "class,record_id\nx,rec_1\ny,rec_2\n").unwrap();
        let held = held_out(&list).unwrap();
        assert_eq!(held.len(), 2);
        let told = |record: &str, split: &str| {
            let truth = format!(
                r#"{{"schema":"evalcase/1","source":"a","record_id":"{record}","split":"{split}",
                "parts":[]}}"#
            );
            let truth = truth.into_bytes();
            let bundle = Bundle { id: "o".into(), truth, ..Bundle::default() };
            check_held_out(&bundle, &list, ("train", &held)).map_err(|e| e.to_string())
        };
        assert_eq!(told("rec_3", "train"), Ok(()));
        assert!(told("rec_2", "train").unwrap_err().contains("`rec_2` is held out"));
        assert!(told("rec_3", "val").unwrap_err().contains("split `val`, expected `train`"));
    }
}
