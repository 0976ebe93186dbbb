//! What is kept for evaluation is never trained on: shown over the split files themselves.
#![allow(clippy::unwrap_used, clippy::print_stderr)]

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use training::dataset::evalcase::Truth;
use training::dataset::library::held_out;
use training::dataset::shards::{read_shard, shards};

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
            let truth = Truth::read(&bundle.truth).unwrap();
            assert_eq!((truth.source.as_str(), truth.split.as_str()), ("articraft", split));
            assert!(!bundle.id.starts_with("paper__"));
            records.insert(truth.record_id);
            ids.insert(bundle.id);
        }
    }
    (records, ids)
}

/// Record ids of the evaluation cases that have one.
fn cases(folder: &Path) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for case in std::fs::read_dir(folder).unwrap() {
        let truth = std::fs::read(case.unwrap().path().join("truth.json")).unwrap();
        let truth = Truth::read(&truth).unwrap();
        found.insert(truth.record_id);
    }
    found.remove("");
    found
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
    assert!(!excluded.is_empty() && cases.len() > 60);
    for (name, records) in [("train", &train), ("val", &val)] {
        let known: Vec<_> = records.intersection(&excluded).collect();
        assert!(known.is_empty(), "{name} holds excluded records: {known:?}");
        let known: Vec<_> = records.intersection(&cases).collect();
        assert!(known.is_empty(), "{name} holds records of cases: {known:?}");
    }
}
