//! The floors hold: who may import whom, and which room owns which heavy library.

use std::collections::{BTreeMap, BTreeSet};

use cargo_metadata::{DependencyKind, Metadata, MetadataCommand, Package};

/// What each room may import of the house. The roof may import everything: `workflow`, and beside it
/// `python`, which nobody imports.
const FLOORS: [(&str, &[&str]); 13] = [
    ("guard", &[]),
    ("object", &["guard"]),
    ("trace", &["guard"]),
    ("runner", &["guard", "trace"]),
    ("view", &["object"]),
    ("model", &["object"]),
    ("asset", &["guard", "object"]),
    ("sim-check", &["guard", "object"]),
    ("forecast", &["guard"]),
    ("adapters", &["guard", "object", "view", "trace"]),
    ("page", &["guard", "object", "view"]),
    ("studio", &["guard", "object", "model"]),
    ("training", &["object", "view", "model", "adapters"]),
];

/// Which rooms may name a heavy library; everything else reaches it through them.
const OWNERS: [(&str, &[&str]); 25] = [
    ("cap-std", &["guard"]),
    ("draco-gltf", &["object"]),
    ("meshopt", &["object"]),
    ("openusd", &["object"]),
    ("zip", &["object"]),
    ("miniz_oxide", &["page"]),
    ("mcap", &["trace"]),
    ("ed25519-dalek", &["trace"]),
    ("foxglove", &["trace"]),
    ("rapier3d", &["sim-check"]),
    ("rapier3d-f64", &["sim-check"]),
    ("ureq", &["adapters"]),
    ("burn", &["model", "training"]),
    ("rusqlite", &["runner", "workflow"]),
    ("parquet", &["workflow"]),
    ("clap", &["workflow"]),
    ("indicatif", &["workflow"]),
    ("roxmltree", &["sim-check", "forecast"]),
    ("urdf-rs", &["sim-check"]),
    ("object_store", &["runner"]),
    ("reqwest", &["runner"]),
    ("restate-sdk", &["runner"]),
    ("axum", &["studio"]),
    ("tokio", &["runner", "studio"]),
    ("pyo3", &["python"]),
];

fn metadata() -> Metadata {
    let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/../Cargo.toml");
    let mut command = MetadataCommand::new();
    command.manifest_path(manifest).no_deps().other_options(["--offline".to_string()]);
    command.exec().unwrap()
}

fn room(package: &str) -> Option<&str> {
    package.strip_prefix("kinfold-")
}

/// What a room needs to run; what only its tests need may come from anywhere.
fn needs(package: &Package) -> BTreeSet<&str> {
    let normal = package.dependencies.iter().filter(|d| d.kind == DependencyKind::Normal);
    normal.map(|d| d.name.as_str()).collect()
}

#[test]
fn no_import_climbs_a_floor() {
    let metadata = metadata();
    let floors: BTreeMap<_, _> = FLOORS.into_iter().collect();
    let mut rooms = 0;
    for package in &metadata.packages {
        let Some(name) = room(&package.name) else { panic!("`{}` has no room", package.name) };
        rooms += 1;
        let Some(allowed) = floors.get(name) else {
            assert!(["workflow", "python"].contains(&name), "`{name}`: a room nobody drew");
            assert!(!needs(package).contains("kinfold-python"), "`{name}` imports `python`");
            continue;
        };
        for import in needs(package).into_iter().filter_map(room) {
            assert!(allowed.contains(&import), "`{name}` imports `{import}`, allowed: {allowed:?}");
        }
    }
    assert_eq!(rooms, 15, "fifteen rooms");
}

#[test]
fn every_heavy_library_has_one_owner() {
    for package in &metadata().packages {
        let name = room(&package.name).unwrap_or(&package.name);
        for (library, owners) in OWNERS {
            let imports = needs(package).contains(library);
            assert!(!imports || owners.contains(&name), "`{name}` imports {library} of {owners:?}");
        }
    }
}
