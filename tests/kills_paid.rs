//! Killed at any moment while money is spent: no result is lost, no answered question is asked twice,
//! nothing is sent that is not booked, no process is left, and the bytes are those of an unkilled run.
//!
//! `KINFOLD_MAKE_KILLS`, `KINFOLD_BATCH_KILLS` and `KINFOLD_TERMS` say how often; the full counts are
//! 100, 50 and 20, and `--nocapture` shows what was found.
#![cfg(unix)]

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use adapters::net::tape::{Exchange, Outcome};
use adapters::transport::Method;
use trace::Digest;

use crate::batch::same;
use crate::kinfold::{Said, files};
use crate::paid::{Paid, Shop};
use crate::programs::{all_gone, signal};

/// How long the provider takes for an answer: long enough that kills meet it at work.
const PAUSE: Duration = Duration::from_millis(60);

fn count(name: &str, usual: usize) -> usize {
    std::env::var(name).ok().and_then(|v| v.parse().ok()).unwrap_or(usual)
}

/// Moments of a kill, as shares of an undisturbed run: a fixed sequence that looks like chance.
fn moment(n: usize) -> f64 {
    (n as f64 * 0.618_033_988_749_894_9).fract()
}

/// Bodies of the requests for work that were answered, as they stand on record, and how often.
fn answered(state: &Path) -> BTreeMap<Digest, usize> {
    let calls = files(&state.join("calls"));
    let calls = calls.iter().filter(|(name, _)| name.ends_with(".json"));
    let bodies = calls
        .filter_map(|(_, bytes)| serde_json::from_slice::<Exchange>(bytes).ok())
        .filter(|e| e.method == Method::Post)
        .filter(|e| matches!(e.outcome, Outcome::Answered { status: 200, .. }))
        .map(|e| e.body);
    let mut counts = BTreeMap::new();
    bodies.for_each(|body| *counts.entry(body).or_insert(0) += 1);
    counts
}

/// Everybody who works in a folder.
fn at_work_in(folder: &Path) -> Vec<u32> {
    let folder = folder.canonicalize().unwrap();
    let processes = std::fs::read_dir("/proc").into_iter().flatten().flatten();
    let number = |e: std::fs::DirEntry| e.file_name().to_str()?.parse::<u32>().ok();
    let is_here =
        |pid: &u32| std::fs::read_link(format!("/proc/{pid}/cwd")).is_ok_and(|cwd| cwd == folder);
    processes.filter_map(number).filter(is_here).collect()
}

/// How a run is disturbed.
#[derive(Clone, Copy)]
enum Disturb {
    Kill,
    TwiceTerm,
}

impl Disturb {
    fn strike(self, child: &mut Child) {
        match self {
            // It may have ended by itself.
            Self::Kill => drop(child.kill()),
            Self::TwiceTerm => {
                signal("TERM", child.id());
                std::thread::sleep(Duration::from_millis(20));
                signal("TERM", child.id());
            }
        }
        child.wait().unwrap();
    }
}

/// What a series of kills came to.
#[derive(Debug, Default)]
struct Toll {
    struck: usize,
    asked: usize,
    asked_twice: usize,
    unbooked: usize,
    lost: usize,
    stopped: usize,
}

/// A shop at work, and what must not happen to it.
struct Watch<'a> {
    shop: &'a Shop,
    state: &'a str,
    /// Questions so far; where the parts are is asked of the views alone, whatever the photo, so that
    /// it is the same request of so many questions.
    questions: usize,
    toll: Toll,
}

impl Watch<'_> {
    /// Looks at what a run did that is over.
    fn after(&mut self, before: &BTreeMap<Digest, usize>, since: usize) {
        all_gone(&at_work_in(&self.shop.path("")));
        let work = self.shop.paid.work();
        self.toll.asked += work.len() - since;
        let mut times = before.clone();
        for work in &work[since..] {
            let most = if work.what == "points" { self.questions } else { 1 };
            let times = times.entry(work.asked.clone()).or_insert(0);
            *times += 1;
            self.toll.asked_twice += usize::from(*times > most);
        }
        self.toll.unbooked = self.shop.paid.unbooked();
    }

    fn struck(&mut self, mut command: Command, delay: Duration, disturb: Disturb) {
        let (before, since) = (answered(&self.shop.path(self.state)), self.shop.paid.work().len());
        let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        std::thread::sleep(delay);
        disturb.strike(&mut child);
        self.toll.struck += 1;
        self.after(&before, since);
    }

    fn whole(&mut self, mut command: Command) -> Said {
        let (before, since) = (answered(&self.shop.path(self.state)), self.shop.paid.work().len());
        let said = command.output().unwrap().into();
        self.after(&before, since);
        said
    }
}

/// Makes of other photos over one good asset, each struck some times before it may finish.
fn makes(strikes: usize, disturb: Disturb) -> Toll {
    let paid = Paid::open(PAUSE);
    let (undisturbed, shop) = (Shop::open(paid.clone(), true, ""), Shop::open(paid, true, ""));
    let made = |shop: &Shop, n: usize| shop.make_of(&shop.photo(n), &["--quiet"]);
    undisturbed.looks_into("state/spent.jsonl");
    let began = Instant::now();
    let said: Said = made(&undisturbed, 0).output().unwrap().into();
    assert_eq!(said.code, Some(0), "{said:?}");
    let whole = began.elapsed();
    shop.looks_into("state/spent.jsonl");
    let said: Said = made(&shop, 0).output().unwrap().into();
    assert_eq!(said.code, Some(0), "{said:?}");
    let mut good = shop.out();
    let mut watch = Watch { shop: &shop, state: "state", questions: 1, toll: Toll::default() };
    for n in 1.. {
        watch.questions += 1;
        for _ in 0..5.min(strikes - watch.toll.struck) {
            let delay = whole.mul_f64(moment(watch.toll.struck + 1));
            watch.struck(made(&shop, n), delay, disturb);
            let now = without_failures(shop.out());
            // It may have been done before it was struck.
            if now != without_failures(good.clone()) && !is_whole(&now) {
                watch.toll.lost += 1;
            }
        }
        let said = watch.whole(made(&shop, n));
        if said.code == Some(1) && said.err.contains("may have been charged") {
            // A job that was struck while it was submitted: a person has to look, and says so.
            watch.toll.stopped += 1;
            assert!(without_failures(shop.out()) == without_failures(good.clone()));
        } else {
            assert_eq!(said.code, Some(0), "{said:?}");
            good = shop.out();
            undisturbed.looks_into("state/spent.jsonl");
            let theirs: Said = made(&undisturbed, n).output().unwrap().into();
            assert_eq!(theirs.code, Some(0), "{theirs:?}");
            same(&without_failures(undisturbed.out()), &without_failures(good.clone()));
            shop.looks_into("state/spent.jsonl");
        }
        if watch.toll.struck >= strikes {
            break;
        }
    }
    watch.toll
}

/// What is published, without the traces of runs that failed.
fn without_failures(mut files: BTreeMap<String, Vec<u8>>) -> BTreeMap<String, Vec<u8>> {
    files.retain(|name, _| !name.starts_with("failed/") && !name.ends_with(".partial"));
    files
}

/// Whether a folder holds a whole asset: everything follows from the trace.
fn is_whole(files: &BTreeMap<String, Vec<u8>>) -> bool {
    ["asset.urdf", "trace.mcap", "verdict.json"].iter().all(|name| files.contains_key(*name))
}

/// A batch that is struck again and again before it may finish.
fn batches(strikes: usize, items: usize) -> Toll {
    let paid = Paid::open(PAUSE);
    let (undisturbed, shop) = (Shop::open(paid.clone(), false, ""), Shop::open(paid, false, ""));
    undisturbed.with_items(items);
    let began = Instant::now();
    assert_eq!(undisturbed.ran(&[]).0.code, Some(0));
    let whole = began.elapsed();
    shop.with_items(items);
    let mut watch =
        Watch { shop: &shop, state: "assets/state", questions: items, toll: Toll::default() };
    for n in 1..=strikes {
        // The strikes together leave about as much time as the batch needs.
        let delay = whole.mul_f64(moment(n) * (6.0 / strikes as f64).min(0.7));
        watch.struck(shop.batch(&["--quiet"]), delay, Disturb::Kill);
    }
    let said = watch.whole(shop.batch(&["--quiet"]));
    assert_eq!(said.code, Some(0), "{said:?}");
    same(&files(&undisturbed.path("assets/assets")), &files(&shop.path("assets/assets")));
    let audit = shop.kinfold(&["audit", "assets"]).output().unwrap();
    assert_eq!(audit.status.code(), Some(0), "{audit:?}");
    watch.toll
}

fn nothing_was_lost(name: &str, toll: &Toll) {
    eprintln!("{name}: {toll:?}");
    let Toll { asked_twice, unbooked, lost, .. } = *toll;
    assert_eq!([asked_twice, unbooked, lost], [0; 3], "{name}: {toll:?}");
}

#[test]
fn kills_of_a_paid_make_over_a_good_asset_cost_nothing() {
    let toll = makes(count("KINFOLD_MAKE_KILLS", 5), Disturb::Kill);
    nothing_was_lost("kills of make", &toll);
}

#[test]
fn two_terms_to_a_paid_make_over_a_good_asset_cost_nothing() {
    let toll = makes(count("KINFOLD_TERMS", 3), Disturb::TwiceTerm);
    nothing_was_lost("double terms", &toll);
}

#[test]
fn kills_of_a_paid_batch_cost_nothing() {
    let strikes = count("KINFOLD_BATCH_KILLS", 4);
    let toll = batches(strikes, 3.max(strikes / 5));
    nothing_was_lost("kills of batch", &toll);
}
