//! Folders as strangers could send them, made at random, and every reader that walks one: none
//! writes, none reads through a link that leads out, every call ends.
//!
//! `KINFOLD_FOLDERS` says how many folders are made in all [default: 400].
#![cfg(unix)]

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::os::unix::ffi::OsStrExt as _;
use std::os::unix::fs::{FileTypeExt as _, symlink};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::mpsc::channel;
use std::time::{Duration, Instant};

use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;
use runner::StateDir;
use serde_json::json;
use sim_check::{CheckOptions, Tier};
use trace::Digest;
use workflow::batch::ledger::{FILE as LEDGER, Ledger};
use workflow::batch::plan::Share;
use workflow::batch::record::{Ended, Record};
use workflow::batch::{audit, keep, plan};
use workflow::cli::commands::{trace as trace_show, trace_diff, trace_extract, trace_verify};

use crate::kinfold::{Bench, program};

/// After so long a call hangs; it ends the test and measures nothing.
const HANGS: Duration = Duration::from_secs(120);
/// What stands in the file that nobody may read.
const CANARY: &str = "canary: of nobody's business 7f3a9c";
/// Names that no sane person gives a file.
const ODD: [&[u8]; 12] = [
    b" ",
    b"a b",
    b"-rf",
    b"\n",
    b"\x1b[2J",
    b"\xe2\x80\xae",
    b"\xff\xfe",
    b"...",
    b"a\\b",
    b"%00",
    b"asset.json",
    b"CON",
];

/// How many folders one of six readers gets.
fn share() -> u64 {
    let all = std::env::var("KINFOLD_FOLDERS").ok().and_then(|n| n.parse().ok());
    all.unwrap_or(400_u64).div_ceil(6)
}

/// A place with what folders are made of: a canary, a pipe, a socket, and where it may be made a
/// device.
struct Place {
    folder: tempfile::TempDir,
}

impl Place {
    fn new() -> Self {
        let this = Self { folder: tempfile::tempdir().unwrap() };
        std::fs::create_dir_all(this.path("canary/deep")).unwrap();
        for name in ["canary/file", "canary/asset.urdf", "canary/deep/trace.mcap"] {
            std::fs::write(this.path(name), CANARY).unwrap();
        }
        std::fs::create_dir(this.path("pool")).unwrap();
        let made = Command::new("mkfifo").arg(this.path("pool/pipe")).status().unwrap();
        assert!(made.success());
        drop(std::os::unix::net::UnixListener::bind(this.path("pool/socket")).unwrap());
        let mut device = Command::new("mknod");
        device.arg(this.path("pool/zero")).args(["c", "1", "5"]).stderr(Stdio::null());
        if !device.status().is_ok_and(|s| s.success()) {
            eprintln!(
                "SKIPPED: no device can be made here; pipes, sockets and links to devices are"
            );
        }
        this
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Everything in a folder, by what can be known without opening anything but the canary.
    fn tree(&self, name: &str) -> BTreeMap<PathBuf, String> {
        let (mut found, mut folders) = (BTreeMap::new(), vec![self.path(name)]);
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(&folder).unwrap() {
                let path = entry.unwrap().path();
                let about = std::fs::symlink_metadata(&path).unwrap();
                let (kind, modified) = (about.file_type(), about.modified().unwrap());
                let mut told = format!("{kind:?} {} {modified:?}", about.len());
                if kind.is_dir() {
                    folders.push(path.clone());
                } else if path.starts_with(self.path("canary")) {
                    told.push_str(&std::fs::read_to_string(&path).unwrap());
                }
                assert!(!kind.is_block_device());
                found.insert(path, told);
            }
        }
        found
    }
}

/// One folder, made from others' files and a seed.
struct Maker<'a> {
    place: &'a Place,
    root: PathBuf,
    rng: Pcg64Mcg,
}

impl Maker<'_> {
    /// Copies a folder by links to its files, and spoils it in some places.
    fn spoil(&mut self, base: &Path) {
        copy(base, &self.root);
        for _ in 0..self.rng.random_range(1..6) {
            let at = self.target();
            self.put(&at);
        }
    }

    /// A path that is there, to be replaced, or a new one under an odd name.
    fn target(&mut self) -> PathBuf {
        let all = everything(&self.root);
        if self.rng.random_bool(0.6) && !all.is_empty() {
            return all[self.rng.random_range(0..all.len())].clone();
        }
        let folders: Vec<_> = all.into_iter().filter(|p| p.is_dir() && !p.is_symlink()).collect();
        let folder = match folders.len() {
            0 => self.root.clone(),
            n => folders[self.rng.random_range(0..n)].clone(),
        };
        folder.join(OsStr::from_bytes(ODD[self.rng.random_range(0..ODD.len())]))
    }

    fn put(&mut self, at: &Path) {
        remove(at);
        let up = at.strip_prefix(self.place.folder.path()).unwrap().components().count() - 1;
        let out = PathBuf::from("../".repeat(up));
        let link = |to: PathBuf| symlink(to, at);
        let pool = |name: &str| std::fs::hard_link(self.place.path("pool").join(name), at);
        let made = match self.rng.random_range(0..19) {
            0 => std::fs::write(at, self.rng.random::<[u8; 32]>()),
            1 => std::fs::File::create(at).and_then(|f| f.set_len(1 << 40)),
            2 => std::fs::File::create(at).and_then(|f| f.set_len((1 << 30) + 1)),
            3 | 4 => pool("pipe"),
            5 => pool("socket"),
            6 => pool("zero").or_else(|_| pool("pipe")),
            7 | 8 => link(self.place.path("canary/file")),
            9 => link(out.join("canary/file")),
            10 => link(out.join("canary")),
            11 => link(PathBuf::from(".")),
            12 => link(PathBuf::from("..")),
            13 => link(at.to_path_buf()),
            14 => link(PathBuf::from("/dev/zero")),
            15 => link(PathBuf::from("/proc/self/root")),
            16 => link(self.root.clone()),
            17 => std::fs::create_dir_all(at.join("d/".repeat(40))),
            _ => std::fs::create_dir(at)
                .and_then(|()| symlink(".", at.join("x")))
                .and_then(|()| symlink(".", at.join("y"))),
        };
        // Its folder may be a file by now, or a link to where nothing may be made.
        let _ = made;
    }
}

/// Every path below a folder that is reached without a link.
fn everything(root: &Path) -> Vec<PathBuf> {
    let (mut found, mut folders) = (Vec::new(), vec![root.to_path_buf()]);
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).into_iter().flatten().flatten() {
            let path = entry.path();
            if entry.file_type().unwrap().is_dir() {
                folders.push(path.clone());
            }
            found.push(path);
        }
    }
    found.sort();
    found
}

fn remove(path: &Path) {
    match std::fs::symlink_metadata(path) {
        Ok(about) if about.is_dir() => std::fs::remove_dir_all(path).unwrap(),
        Ok(_) => std::fs::remove_file(path).unwrap(),
        Err(_) => {}
    }
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for path in everything(from) {
        let copy = to.join(path.strip_prefix(from).unwrap());
        if path.is_dir() {
            std::fs::create_dir_all(copy).unwrap();
        } else {
            std::fs::hard_link(path, copy).unwrap();
        }
    }
}

/// Lets a reader look at a share of all folders, each made from `base` and a seed of its own. What it
/// says must not tell the canary, and nothing may be another afterwards.
fn look<F>(place: &Place, base: &str, first: u64, reader: F)
where
    F: Fn(&Path, u64) -> String + Send + Sync + Copy + 'static,
{
    let secrets = [CANARY.to_owned(), Digest::of(CANARY.as_bytes()).short().to_owned()];
    let canary = place.tree("canary");
    for n in 0..share() {
        let seed = first + n;
        let root = place.path(&format!("made-{n}"));
        let rng = Pcg64Mcg::seed_from_u64(seed);
        Maker { place, root: root.clone(), rng }.spoil(&place.path(base));
        let name = format!("made-{n}");
        let before = place.tree(&name);
        let (sender, answer) = channel();
        let at = root.clone();
        std::thread::spawn(move || sender.send(reader(&at, seed)));
        let said = answer.recv_timeout(HANGS);
        let said = said.unwrap_or_else(|e| panic!("seed {seed}: it broke down or hangs: {e}"));
        for secret in &secrets {
            assert!(!said.contains(secret), "seed {seed}: it read through a link: {said}");
        }
        assert_eq!(place.tree(&name), before, "seed {seed}: it wrote into the folder");
        assert_eq!(place.tree("canary"), canary, "seed {seed}: it wrote outside");
        remove(&root);
    }
}

/// What a command says, whichever way it ends.
fn told(answer: Result<workflow::cli::speech::Answer, workflow::cli::speech::Complaint>) -> String {
    match answer {
        Ok(answer) => format!("{} {:?}", answer.result, answer.remarks),
        Err(complaint) => format!("{} {complaint}", complaint.result),
    }
}

/// A place with a finished asset in `base`.
fn with_asset() -> Place {
    let (place, bench) = (Place::new(), Bench::done());
    for (name, bytes) in bench.out() {
        let path = place.path("base").join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
    place
}

#[test]
fn verifying_a_strangers_folder_is_safe() {
    let place = with_asset();
    std::fs::copy(place.path("base/trace.mcap"), place.path("whole.mcap")).unwrap();
    look(&place, "base", 1_000_000, |root, seed| {
        // Half of them with a trace that is whole, so that the files are looked at.
        let whole = root.parent().unwrap().join("whole.mcap");
        let trace = if seed % 2 == 0 { whole } else { root.join("trace.mcap") };
        told(trace_verify::verify(&trace, Some(root), None, (seed % 5 == 0, seed % 3 == 0)))
    });
}

#[test]
fn showing_comparing_and_extracting_what_a_stranger_sent_is_safe() {
    let place = with_asset();
    look(&place, "base", 2_000_000, |root, seed| {
        let all = everything(root);
        let trace = root.join("trace.mcap");
        let any = &all[seed as usize % all.len()];
        // A file that is named is read wherever its name leads; what is shown of it is no content.
        let shown = told(trace_show::show(any, seed % 2 == 0));
        let listed = told(trace_extract::extract(&trace, None, None, false));
        format!("{shown} {listed} {}", told(trace_diff::diff(&trace, any, true)))
    });
}

#[test]
fn checking_a_strangers_package_is_safe() {
    let place = Place::new();
    std::fs::create_dir_all(place.path("base/meshes")).unwrap();
    let mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    let own = ["meshes/a.obj", "meshes/b.obj", "c.obj", "d.bin"];
    for name in own {
        std::fs::write(place.path("base").join(name), mesh).unwrap();
    }
    // What is there, what odd things may be put there, and what lies behind links and outside.
    let odd = ODD.iter().filter_map(|name| std::str::from_utf8(name).ok());
    let odd = odd.filter(|name| !name.chars().any(guard::text::acts));
    let odd: Vec<_> = odd.flat_map(|n| [n.to_owned(), format!("meshes/{n}")]).collect();
    let behind = ["meshes", "-rf", "a b", "..."].map(|n| format!("{n}/file"));
    let outside = ["../canary/file", "meshes/../../canary/file", "/dev/zero", "x/x/y/x/c.obj"];
    let names: Vec<_> = own.iter().chain(&outside).map(|n| (*n).to_owned()).collect();
    let names: Vec<_> = names.into_iter().chain(odd).chain(behind).collect();
    let visual = |name| format!("<visual><geometry><mesh filename='{name}'/></geometry></visual>");
    let visuals: String = names.iter().map(visual).collect();
    let body = "<visual><geometry><box size='1 1 1'/></geometry></visual>";
    let urdf = format!("<robot name='r'><link name='a'>{body}{visuals}</link></robot>");
    std::fs::write(place.path("base/x.urdf"), urdf).unwrap();
    let files: BTreeMap<_, _> = names.iter().map(|n| (n, "blake3:00")).collect();
    let listed = json!({ "schema": "kinfold-asset/1", "files": files });
    std::fs::write(place.path("base/asset.json"), listed.to_string()).unwrap();
    look(&place, "base", 3_000_000, |root, seed| {
        let options = CheckOptions { up_to: Tier::Static, seed, ..CheckOptions::default() };
        sim_check::check(&root.join("x.urdf"), &options).to_json()
    });
}

/// A batch of two items, as their files and their ledger say.
fn with_batch() -> Place {
    let place = with_asset();
    let root = place.path("batch");
    std::fs::create_dir_all(root.join("quarantine")).unwrap();
    let ledger = Ledger::open(&root.join(LEDGER)).unwrap();
    let settings = Digest::of(b"settings");
    for id in ["one", "two"] {
        copy(&place.path("base"), &root.join("assets").join(id));
        let mut record = Record::new(id, Ended::Accepted);
        for path in everything(&root.join("assets").join(id)) {
            if path.is_file() {
                let name = path.strip_prefix(root.join("assets").join(id)).unwrap();
                let digest = Digest::of(&std::fs::read(&path).unwrap());
                record.files.insert(name.to_str().unwrap().to_owned(), digest);
            }
        }
        ledger.add(1, &settings, &[(Digest::of(id.as_bytes()), record)]).unwrap();
    }
    place
}

#[test]
fn auditing_a_strangers_batch_is_safe() {
    let place = with_batch();
    look(&place, "batch", 4_000_000, |root, _| {
        let audited = audit::audit(root, None, None);
        let ledger = Ledger::open_to_read(&root.join(LEDGER));
        let rows = match ledger {
            Ok(Some(ledger)) => format!("{:?}", ledger.ask("SELECT * FROM items", 9, HANGS / 2)),
            other => format!("{other:?}"),
        };
        format!("{audited:?} {rows}")
    });
}

#[test]
fn looking_through_a_strangers_store_is_safe() {
    let place = with_asset();
    let state = StateDir::open(&place.path("state")).unwrap();
    for n in 0..20_u8 {
        state.store.put(&[n; 100]).unwrap();
    }
    drop(state);
    look(&place, "state", 5_000_000, |root, _| {
        let verified = keep::verify(root, 0, keep::Access::Look);
        let kept = [root.parent().unwrap().join("base")];
        let tidied = keep::collect(root, &kept, u64::MAX, keep::Access::Look);
        let others = keep::collect(root, &[root.to_path_buf()], u64::MAX, keep::Access::Look);
        format!("{verified:?} {tidied:?} {others:?}")
    });
}

#[test]
fn planning_a_strangers_manifest_is_safe() {
    let place = Place::new();
    std::fs::create_dir_all(place.path("base/sub")).unwrap();
    let line = "{\"photo\":\"a.png\"}\n{\"photo\":\"../canary/file\"}\n{\"photo\":\"sub/b.png\"}\n";
    for (name, bytes) in
        [("a.png", "x"), ("sub/b.png", "y"), ("m.jsonl", line), ("m.csv", "photo\na.png\n")]
    {
        std::fs::write(place.path("base").join(name), bytes).unwrap();
    }
    look(&place, "base", 6_000_000, |root, seed| {
        let manifest =
            [root.to_path_buf(), root.join("m.jsonl"), root.join("m.csv"), root.join("sub")];
        let ledger = Ledger::passing().unwrap();
        let manifest = &manifest[seed as usize % 4];
        let planned = plan::plan(manifest, Share::ALL, &ledger);
        // A manifest that is named is read wherever its name leads.
        if manifest.is_symlink() { String::new() } else { format!("{planned:?}") }
    });
}

/// The same at the process boundary, with every verb that takes a folder.
#[test]
fn no_verb_that_looks_runs_writes_or_hangs() {
    let place = with_batch();
    copy(&place.path("base"), &place.path("batch/one"));
    let state = StateDir::open(&place.path("batch/state")).unwrap();
    state.store.put(b"blob").unwrap();
    drop(state);
    let secrets = [CANARY.to_owned(), Digest::of(CANARY.as_bytes()).short().to_owned()];
    for n in 0..share().div_ceil(8) {
        let name = format!("made-{n}");
        let rng = Pcg64Mcg::seed_from_u64(7_000_000 + n);
        let root = place.path(&name);
        Maker { place: &place, root: root.clone(), rng }.spoil(&place.path("batch"));
        let before = (place.tree(&name), place.tree("canary"));
        for args in [
            &["trace", "verify", "one/trace.mcap"][..],
            &["trace", "show", "one/trace.mcap"],
            &["trace", "diff", "one/trace.mcap", "assets/two/trace.mcap"],
            &["trace", "extract", "one/trace.mcap"],
            &["audit", "."],
            &["audit", "query", ".", "SELECT * FROM items"],
            &["check", ".", "--tier", "static", "--deadline", "30"],
            &["view", "one", "--out", "../page.html", "--deadline", "30"],
            &["store", "verify", "."],
            &["store", "gc", ".", "--dry-run", "--keep", "one"],
            &["batch", "one", "--out", "nowhere", "--dry-run"],
        ] {
            let mut command = program();
            command.current_dir(&root).args(args).env("HOME", place.path("home"));
            let output = place.path("said");
            let file = std::fs::File::create(&output).unwrap();
            command.stderr(file.try_clone().unwrap()).stdout(file);
            let mut child = command.spawn().unwrap();
            let begun = Instant::now();
            let code = loop {
                if let Some(status) = child.try_wait().unwrap() {
                    break status.code();
                }
                if begun.elapsed() > HANGS {
                    child.kill().unwrap();
                    panic!("seed {n}: {args:?} hangs");
                }
                std::thread::sleep(Duration::from_millis(2));
            };
            let said = String::from_utf8_lossy(&std::fs::read(&output).unwrap()).into_owned();
            assert!(matches!(code, Some(0 | 1 | 3)), "seed {n}: {args:?}: {code:?} {said}");
            for secret in &secrets {
                assert!(!said.contains(secret), "seed {n}: {args:?} read through a link: {said}");
            }
            let after = (place.tree(&name), place.tree("canary"));
            assert_eq!(after, before, "seed {n}: {args:?} wrote");
        }
        remove(&root);
    }
}
