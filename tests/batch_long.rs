//! The long forms: thousands of items, fifty kills. `cargo test --release --workspace --test tests
//! -- --ignored long_ --nocapture` runs them; what they measure stands on stderr.
#![cfg(unix)]

use std::path::PathBuf;
use std::time::{Duration, Instant};

use crate::batch::{Batch, killed};
use crate::cases;
use crate::kinfold::CLOCK;

fn count(name: &str, usual: usize) -> usize {
    std::env::var(name).ok().and_then(|v| v.parse().ok()).unwrap_or(usual)
}

#[test]
#[ignore = "minutes: fifty kills over one batch"]
fn long_fifty_kills_lose_nothing_and_repeat_nothing() {
    let items = count("KINFOLD_ITEMS", 40);
    let undisturbed = Batch::of(items);
    let began = Instant::now();
    let (said, _) = undisturbed.ran(&[]);
    assert_eq!(said.code, Some(0), "{said:?}");
    let whole = began.elapsed();
    eprintln!("{items} items undisturbed in {whole:.1?}");
    let kills = count("KINFOLD_KILLS", 50) as u32;
    // The kills together leave about as much time as the batch needs.
    let began = Instant::now();
    let batch = Batch::of(items);
    killed(&batch, whole.mul_f64(4.0 / f64::from(kills)), kills, &undisturbed.assets());
    eprintln!("with {kills} kills in {:.1?}", began.elapsed());
}

#[test]
#[ignore = "a minute: a hundred thousand lines"]
fn long_a_hundred_thousand_items_are_planned_and_resumed_in_seconds() {
    use workflow::batch::plan::{Share, plan};
    use workflow::batch::record::Ended;
    use workflow::batch::{Ledger, Record, ledger::Settled};

    let items = count("KINFOLD_ITEMS", 100_000);
    let batch = Batch::of(items);
    let settings = trace::Digest::of(b"settings");
    let manifest = batch.path("items.jsonl");
    let path = batch.path("ledger.sqlite");
    let began = Instant::now();
    let ledger = Ledger::open(&path).unwrap();
    let number = plan(&manifest, Share::ALL, &ledger).unwrap().number;
    eprintln!("{items} items planned in {:.2?}", began.elapsed());
    let settled = Settled { plan: number, settings: Some(&settings), again: &[], run: 1 };
    let (mut after, mut seen) = (0, 0);
    loop {
        let page = ledger.pending(&settled, after, 1000).unwrap();
        let Some(last) = page.last() else { break };
        after = last.n;
        seen += page.len();
        let done: Vec<_> = page
            .iter()
            .map(|p| (p.question.clone(), Record::new(&p.item.id, Ended::Accepted)))
            .collect();
        // All but the very last item are done.
        let most = if seen == items { done.len() - 1 } else { done.len() };
        ledger.add(1, &settings, &done[..most]).unwrap();
    }
    eprintln!("and done in {:.2?}", began.elapsed());
    drop(ledger);
    let began = Instant::now();
    let ledger = Ledger::open(&path).unwrap();
    let plan = plan(&manifest, Share::ALL, &ledger).unwrap();
    assert!(plan.known);
    let standing = ledger.standing(plan.number, &settings).unwrap();
    let left = ledger.pending(&settled, 0, 10).unwrap();
    eprintln!("resumed in {:.2?}", began.elapsed());
    assert_eq!((standing.accepted, left.len()), (items as u64 - 1, 1));
    let began = Instant::now();
    let said =
        batch.say(&["audit", "query", ".", "SELECT outcome, count(*) FROM items GROUP BY 1"]);
    eprintln!("asked in {:.2?}", began.elapsed());
    assert!(said.out.ends_with(&format!("accepted\t{}\n", items - 1)), "{said:?}");
}

/// Dev objects of few faces, so many of them; what a batch of them repeats are their meshes and
/// photos, never a seed.
const OBJECTS: usize = 40;

/// Items over real objects: their meshes come from a program, by the seed, their conditions from files.
fn of_real_objects(items: usize) -> Option<Batch> {
    let mut cases = cases::dev_cases()?;
    let weight = |case: &PathBuf| case.join("mesh.glb").metadata().map_or(u64::MAX, |m| m.len());
    cases.retain(|c| !c.to_string_lossy().ends_with("-fused"));
    cases.sort_by_key(weight);
    cases.truncate(OBJECTS);
    let batch = Batch::of(0);
    for (n, case) in cases.iter().enumerate() {
        std::fs::copy(case.join("mesh.glb"), batch.path(&format!("{n}.glb"))).unwrap();
    }
    let line = |n: usize| {
        let case = &cases[n % cases.len()];
        let mut line = Batch::given(&format!("k{n:04}"), n);
        line.as_object_mut().unwrap().remove("mesh");
        line["photo"] = cases::photo(case).unwrap().to_str().unwrap().into();
        line["condition"] = case.join("condition.json").to_str().unwrap().into();
        line["category"] = case.file_name().unwrap().to_str().unwrap().into();
        format!("{line}\n")
    };
    batch.write("items.jsonl", (0..items).map(line).collect::<String>());
    let folder = batch.path("").display().to_string();
    let body = format!("cp {folder}/$(($2 % {})).glb \"$1\"", cases.len());
    batch.with_generator(&body);
    Some(batch)
}

#[test]
#[ignore = "an hour on two cores: two thousand items over forty real objects"]
fn long_two_thousand_items_in_flat_memory() {
    let items = count("KINFOLD_ITEMS", 2000);
    let Some(batch) = of_real_objects(items) else { return };
    let began = Instant::now();
    let mut child = batch.batch(&["--quiet"]).spawn().unwrap();
    let (mut memory, mut spent) = (Vec::new(), 0.0);
    let done = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if let Some(bytes) = resident(child.id()) {
            let ended = ["out/assets", "out/quarantine"]
                .map(|f| std::fs::read_dir(batch.path(f)).map_or(0, Iterator::count));
            memory.push((ended.iter().sum::<usize>(), bytes));
        }
        spent = processor(child.id()).unwrap_or(spent);
        std::thread::sleep(Duration::from_millis(500));
    };
    let wall = began.elapsed().as_secs_f64();
    assert!([Some(0), Some(3)].contains(&done.code()), "{done:?}");
    let mean = |from: usize, to: usize| {
        let some: Vec<_> =
            memory.iter().filter(|(n, _)| (from..to).contains(n)).map(|(_, b)| *b as f64).collect();
        some.iter().sum::<f64>() / some.len().max(1) as f64 / 1e6
    };
    let (tenth, last) = (items / 10, items - items / 10);
    eprintln!("{items} items in {wall:.1} s: {}", batch.ask(BY_OUTCOME));
    eprintln!("{spent:.1} s of processor time, {:.1} % of two cores", 50.0 * spent / wall);
    eprintln!(
        "resident around item {tenth}: {:.1} MB, at the end {:.1} MB",
        mean(tenth / 2, tenth * 3 / 2),
        mean(last, items + 1)
    );
    let began = Instant::now();
    assert_eq!(batch.say(&["audit", "out"]).code, Some(0));
    eprintln!("audited in {:.1?}", began.elapsed());
    found_again(&batch, items / 5);
}

/// What the runner itself costs: the first items once more into another folder, every stage's result
/// in the store, so that nothing is left but planning, looking up, traces, assets' files and ledger.
fn found_again(batch: &Batch, items: usize) {
    let lines = std::fs::read_to_string(batch.path("items.jsonl")).unwrap();
    batch.write("again.jsonl", lines.split_inclusive('\n').take(items).collect::<String>());
    let args = ["batch", "again.jsonl", "--out", "again", "--state", "out/state", "--clock", CLOCK];
    let mut walls = Vec::new();
    for _ in 0..3 {
        let began = Instant::now();
        let said = batch.say(&[&args[..], &["--quiet"]].concat());
        let wall = began.elapsed().as_secs_f64();
        assert!([Some(0), Some(3)].contains(&said.code), "{said:?}");
        let sums = "SELECT sum(stages_run) || ' ' || sum(stages_recalled) FROM items";
        let said = batch.say(&["audit", "query", "again", sums]);
        let found = said.out.lines().nth(1).and_then(|line| line.strip_prefix("0 "));
        let found: f64 = found.and_then(|n| n.parse().ok()).unwrap_or_else(|| panic!("{said:?}"));
        walls.push(wall * 1000.0 / found);
        std::fs::remove_dir_all(batch.path("again")).unwrap();
    }
    eprintln!("{items} items found again: {walls:.2?} ms a stage");
}

const BY_OUTCOME: &str = "SELECT group_concat(t, ', ') FROM (SELECT outcome || ' ' || count(*) AS t FROM items GROUP BY outcome)";

/// Processor time of a process and those it waited for so far, seconds, in the hundredths that Linux
/// counts in.
fn processor(pid: u32) -> Option<f64> {
    let text = std::fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    let after = text.rsplit_once(") ")?.1;
    let ticks = |n: usize| after.split(' ').nth(n)?.parse::<f64>().ok();
    Some((11..=14).map(ticks).sum::<Option<f64>>()? / 100.0)
}

/// Resident memory of a process, bytes.
fn resident(pid: u32) -> Option<u64> {
    let text = std::fs::read_to_string(format!("/proc/{pid}/statm")).ok()?;
    let pages: u64 = text.split(' ').nth(1)?.parse().ok()?;
    Some(pages * 4096)
}
