//! No file imports in a circle: what a file names stands in files that do not name it back.
//!
//! Read from the sources, file by file: `use` lines and full paths in code, followed through
//! re-exports to the file that defines the thing. What only tests see does not count.

mod arrows;
mod module;
mod words;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use arrows::{circles, told};
use module::Crate;

const CRATES: [&str; 11] = [
    "guard",
    "object",
    "trace",
    "runner",
    "view",
    "model",
    "asset",
    "sim_check",
    "adapters",
    "training",
    "workflow",
];

/// Circles that are left, crate by crate: their files, the largest first. This list may only shrink.
const LEFT: [(&str, &[&str]); 1] = [(
    "model",
    &[
        "features/geometric.rs features/mod.rs features/regions.rs features/text.rs \
             net/batch.rs net/config.rs net/infer.rs net/network.rs",
        "net/kernel/activation.rs net/kernel/attention.rs net/kernel/gated.rs \
             net/kernel/linear.rs net/kernel/mod.rs net/kernel/norm.rs net/kernel/pair.rs",
        "net/partfield/planes.rs net/partfield/transformer.rs net/partfield/voxels.rs \
             net/partfield.rs",
        "weights/archive.rs weights/convert.rs weights/pickle.rs",
        "net/kernel/tiles/amx.rs net/kernel/tiles.rs",
    ],
)];

fn source(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(name).join("src")
}

/// Arrows between the topmost modules of a crate, most that there may be: rooms with few doors.
const DOORS: [(&str, usize); 2] = [("asset", 45), ("sim_check", 28)];

#[test]
fn rooms_have_few_doors() {
    for (name, most) in DOORS {
        let arrows = Crate::read(&source(name)).arrows();
        let topmost =
            |file: &Path| file.components().next().map(|c| Path::new(&c).with_extension(""));
        let doors: BTreeSet<_> = arrows
            .keys()
            .map(|(from, to)| [topmost(from), topmost(to)])
            .filter(|[from, to]| from != to)
            .collect();
        assert!(doors.len() <= most, "{name}: {} arrows: {doors:?}", doors.len());
    }
}

#[test]
fn no_file_imports_in_a_circle() {
    let mut wrong = String::new();
    for name in CRATES {
        let arrows = Crate::read(&source(name)).arrows();
        let found = circles(&arrows);
        let listed = LEFT.iter().find(|(n, _)| *n == name).map_or(&[][..], |(_, list)| list);
        let files = |c: &BTreeSet<PathBuf>| {
            c.iter().map(|f| f.display().to_string()).collect::<Vec<_>>().join(" ")
        };
        let now: BTreeSet<String> = found.iter().map(files).collect();
        let before: BTreeSet<String> = listed.iter().map(|c| (*c).to_string()).collect();
        for circle in found.iter().filter(|c| !before.contains(&files(c))) {
            wrong += &format!("\n{name}: a new circle of {}", told(circle, &arrows));
        }
        for gone in before.difference(&now) {
            wrong += &format!("\n{name}: no circle any more, strike it off the list: {gone}");
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}
