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

const CRATES: [&str; 15] = [
    "guard",
    "object",
    "trace",
    "runner",
    "view",
    "model",
    "asset",
    "sim_check",
    "forecast",
    "adapters",
    "page",
    "studio",
    "training",
    "workflow",
    "python",
];

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
        for circle in circles(&arrows) {
            wrong += &format!("\n{name}: a circle of {}", told(&circle, &arrows));
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}
