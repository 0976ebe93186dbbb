//! NOTICE says whose work is linked into the program, and is as old as the lock.
#![cfg(all(feature = "remote", feature = "restate"))]

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::Path;

use cargo_metadata::{DependencyKind, Metadata, MetadataCommand, Package};

const NOTICE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../NOTICE");
const HEAD: &str = "\
kinfold, Apache-2.0

Linked into the program or the Python package, with every feature but the accelerator's, on Linux, are
the libraries below.
Each is named with its version, its licence and whose it is, as its own files say; notices that
licences want kept follow. The sources that crates.io keeps hold each licence's text.

Written anew by: KINFOLD_NOTICE=write cargo test --release -p kinfold-workflow --test tests \\
    --features remote,restate notice
";

fn metadata() -> Metadata {
    let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/../Cargo.toml");
    let features = "kinfold-workflow/remote,kinfold-workflow/restate";
    let mut command = MetadataCommand::new();
    // All of it is there: these tests were built of it.
    let words =
        ["--offline", "--filter-platform", "x86_64-unknown-linux-gnu", "--features", features];
    command.manifest_path(manifest).other_options(words.map(String::from));
    command.exec().unwrap()
}

/// What the program and the Python package need to run, but for the house's own rooms, by name and version.
fn linked(metadata: &Metadata) -> BTreeMap<(String, String), &Package> {
    let nodes = &metadata.resolve.as_ref().unwrap().nodes;
    let nodes: BTreeMap<_, _> = nodes.iter().map(|node| (&node.id, node)).collect();
    let is_roof = |p: &&Package| ["kinfold-workflow", "kinfold-python"].contains(&p.name.as_str());
    let roofs = metadata.packages.iter().filter(is_roof).map(|p| &p.id);
    let (mut seen, mut ahead) = (BTreeSet::new(), roofs.collect::<Vec<_>>());
    while let Some(id) = ahead.pop() {
        if seen.insert(id) {
            let normal = nodes[id]
                .deps
                .iter()
                .filter(|dep| dep.dep_kinds.iter().any(|kind| kind.kind == DependencyKind::Normal));
            ahead.extend(normal.map(|dep| &dep.pkg));
        }
    }
    let theirs = metadata.packages.iter().filter(|p| seen.contains(&p.id) && p.source.is_some());
    theirs.map(|p| ((p.name.to_string(), p.version.to_string()), p)).collect()
}

/// The files of a package that speak of rights, by name.
fn rights(package: &Package) -> BTreeMap<String, String> {
    let folder = Path::new(package.manifest_path.as_str()).parent().unwrap();
    let names = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let of_rights = |name: &str| {
        let name = name.to_uppercase();
        ["LICEN", "COPYING", "COPYRIGHT", "NOTICE"].iter().any(|word| name.starts_with(word))
    };
    let files = names.filter_map(|path| {
        let name = path.file_name()?.to_str()?.to_owned();
        (of_rights(&name) && path.is_file()).then(|| {
            Some((name, String::from_utf8_lossy(&std::fs::read(&path).ok()?).into_owned()))
        })?
    });
    files.collect()
}

/// Lines that say whose it is, each once.
fn owners(files: &BTreeMap<String, String>) -> BTreeSet<String> {
    let lines = files.values().flat_map(|text| text.lines()).map(str::trim);
    let says = |line: &&str| {
        let word = line.to_lowercase();
        word.starts_with("copyright")
            && line.chars().any(|c| c.is_ascii_digit())
            && line.len() < 200
    };
    lines.filter(says).map(str::to_owned).collect()
}

fn notice() -> String {
    let metadata = metadata();
    let mut text = HEAD.to_owned();
    let mut kept = String::new();
    for ((name, version), package) in linked(&metadata) {
        let licence = package.license.clone().unwrap_or_else(|| "see its file".into());
        let files = rights(package);
        let _ = writeln!(text, "\n{name} {version}: {licence}");
        for owner in owners(&files) {
            let _ = writeln!(text, "    {owner}");
        }
        let notices = files.iter().filter(|(name, _)| name.to_uppercase().starts_with("NOTICE"));
        for (_, words) in notices {
            let words = words.trim().replace('\r', "");
            let _ = writeln!(kept, "\n---- {name} {version} ----\n{words}");
        }
    }
    format!("{text}\nNotices\n{kept}")
}

#[test]
fn notice_names_everybody_whose_work_is_linked() {
    let expected = notice();
    if std::env::var_os("KINFOLD_NOTICE").is_some_and(|wish| wish == "write") {
        std::fs::write(NOTICE, &expected).unwrap();
    }
    let found = std::fs::read_to_string(NOTICE).unwrap_or_default();
    let lines = |text: &str| text.lines().map(str::to_owned).collect::<BTreeSet<_>>();
    let (is, should) = (lines(&found), lines(&expected));
    let missing: Vec<_> = should.difference(&is).collect();
    let stale: Vec<_> = is.difference(&should).collect();
    assert!(
        found == expected,
        "NOTICE lacks {missing:#?} and still has {stale:#?}; its head says how it is written anew"
    );
    assert!(should.len() > 300, "a tree as large as ours has more: {}", should.len());
}
