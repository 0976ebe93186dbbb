//! Any bytes as a manifest, JSON Lines or CSV: items or reasons line by line, never a crash; an item's
//! id is always the name of a folder below the batch's.
#![no_main]

use std::path::{Component, Path, PathBuf};
use std::sync::OnceLock;

use kinfold_workflow_fuzz::manifest;
use libfuzzer_sys::fuzz_target;

/// A folder of this process's own; the end of the process is the end of it.
fn place(name: &str) -> Option<PathBuf> {
    static PLACE: OnceLock<Option<tempfile::TempDir>> = OnceLock::new();
    let folder = PLACE.get_or_init(|| tempfile::tempdir().ok());
    folder.as_ref().map(|folder| folder.path().join(name))
}

fuzz_target!(|bytes: &[u8]| {
    let [kind, rest @ ..] = bytes else { return };
    let name = if kind % 2 == 0 { "items.jsonl" } else { "items.csv" };
    let Some(path) = place(name) else { return };
    if std::fs::write(&path, rest).is_err() {
        return;
    }
    let Ok(lines) = manifest::open(&path) else { return };
    let mut last = 0;
    for line in lines.take(2000) {
        let Ok(line) = line else { break };
        // A table's rows may span lines, and its errors name none.
        assert!(line.number > last || kind % 2 == 1, "lines are counted");
        last = line.number;
        if let Ok(item) = line.item {
            let parts: Vec<_> = Path::new(&item.id).components().collect();
            assert!(matches!(parts[..], [Component::Normal(_)]), "{:?}", item.id);
        }
    }
});
