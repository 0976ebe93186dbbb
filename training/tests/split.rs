//! What is kept for evaluation is never trained on: shown over the split files themselves.
#![allow(clippy::unwrap_used, clippy::print_stderr)]

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use training::dataset::library::held_out;
use training::dataset::shards::{read_shard, shards};
use training::truth::TruthFile;

fn shared() -> Option<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let shared = std::env::var("KINFOLD_SHARED").unwrap_or_else(|_| "../shared".into());
    let folder = root.join(shared).join("data");
    if folder.is_dir() {
        return Some(folder);
    }
    eprintln!("SKIPPED: {} is not there, set KINFOLD_SHARED", folder.display());
    None
}

/// Record ids and object ids of a folder of shards, all of one split and one source.
fn records(folder: &Path, split: &str) -> (BTreeSet<String>, BTreeSet<String>) {
    let (mut records, mut ids) = (BTreeSet::new(), BTreeSet::new());
    for shard in shards(folder).unwrap() {
        for bundle in read_shard(&shard).unwrap() {
            let truth = TruthFile::from_json(&bundle.truth).unwrap();
            assert_eq!((truth.source.as_str(), truth.split.as_str()), ("articraft", split));
            assert!(!bundle.id.starts_with("paper__"));
            records.insert(truth.record_id);
            ids.insert(bundle.id);
        }
    }
    (records, ids)
}

/// The evaluation cases that come from the same source: the start of a record's name, and its end.
fn cases(folder: &Path) -> BTreeSet<(String, String)> {
    let name = |e: std::io::Result<std::fs::DirEntry>| {
        let name = e.unwrap().file_name().into_string().unwrap();
        let stem = name.strip_suffix("-fused").unwrap_or(&name).strip_prefix("articraft__")?;
        let (slug, end) = stem.rsplit_once('_')?;
        Some((format!("rec_{slug}"), end.to_owned()))
    };
    std::fs::read_dir(folder).unwrap().filter_map(name).collect()
}

/// How many of the cases some record may be.
fn known(cases: &BTreeSet<(String, String)>, records: &BTreeSet<String>) -> usize {
    let is = |(start, end): &&(String, String)| {
        records.iter().any(|r| r.starts_with(start.as_str()) && r.ends_with(end.as_str()))
    };
    cases.iter().filter(is).count()
}

#[test]
fn nothing_of_the_cases_or_of_the_excluded_records_stands_in_the_training_shards() {
    let Some(data) = shared() else { return };
    let (train, train_ids) = records(&data.join("articraft-train"), "train");
    let (val, val_ids) = records(&data.join("articraft-val"), "val");
    assert_eq!((train.len(), val.len()), (1_040, 100));
    assert!(train.is_disjoint(&val) && train_ids.is_disjoint(&val_ids));
    let excluded = held_out(&data.join("articraft-excluded.csv")).unwrap();
    let cases = cases(&data.join("cases/dev"));
    assert!(cases.len() > 60 && known(&cases, &excluded) > 50, "the rule finds cases by name");
    for (name, records) in [("train", &train), ("val", &val)] {
        let both: Vec<_> = records.intersection(&excluded).collect();
        assert!(both.is_empty(), "{name} holds excluded records: {both:?}");
        assert_eq!(known(&cases, records), 0, "{name} holds records of cases");
    }
}
