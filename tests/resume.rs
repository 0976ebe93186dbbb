//! Killed at any moment, the same command finishes, repeats nothing that was done, and gives the
//! bytes of an undisturbed run.
#![cfg(unix)]

use std::time::{Duration, Instant};

use crate::kinfold::{Bench, Said, files, names};

/// Moments of a kill, as shares of an undisturbed run: a fixed sequence that looks like chance.
fn moments(count: u64) -> impl Iterator<Item = f64> {
    let golden = 0.618_033_988_749_894_9;
    (1..=count).map(move |n| (n as f64 * golden).fract())
}

#[test]
fn a_run_killed_at_twenty_moments_gives_the_bytes_of_an_undisturbed_one() {
    let undisturbed = Bench::new();
    let began = Instant::now();
    assert_eq!(undisturbed.made(&[]).code, Some(0));
    let whole = began.elapsed();
    let expected = undisturbed.out();
    let moments: Vec<_> = moments(20).collect();
    for round in moments.chunks(5) {
        let bench = Bench::new();
        for moment in round {
            kill_after(&bench, whole.mul_f64(*moment * 0.9));
        }
        let said = bench.made(&[]);
        assert_eq!(said.code, Some(0), "{said:?}");
        assert!(bench.out() == expected, "after kills at {round:?}");
        for ((stage, did), times) in bench.counts() {
            assert!(did != "finished" || times == 1, "{stage} was committed {times} times");
        }
    }
}

fn kill_after(bench: &Bench, delay: Duration) {
    let mut child = bench.make(&[]).spawn().unwrap();
    std::thread::sleep(delay);
    // It may have ended by itself.
    let _ = child.kill();
    child.wait().unwrap();
    let out = bench.out();
    assert!(out.is_empty() || out.contains_key("verdict.json"), "half an asset: {:?}", names(&out));
    for (name, bytes) in files(&bench.path("out.failed")) {
        if name.ends_with("trace.mcap") && !bytes.is_empty() {
            let reading = trace::read_bytes(&bytes, &name).unwrap();
            assert!(reading.chain_holds, "what was synced is still read");
        }
    }
}

/// A shell that lets no file grow beyond some blocks of 512 bytes, as a full disk does.
fn made_with_room(bench: &Bench, blocks: u32) -> Said {
    let command = bench.make(&[]);
    let mut shell = std::process::Command::new("sh");
    let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" \"$@\"");
    shell.arg("-c").arg(script).arg(command.get_program()).args(command.get_args());
    shell.current_dir(command.get_current_dir().unwrap());
    shell.env("KINFOLD_STATE", bench.path("state"));
    shell.output().unwrap().into()
}

#[test]
fn a_full_disk_is_an_error_that_leaves_nothing_half_written_and_the_next_run_goes_on() {
    let undisturbed = Bench::done();
    let bench = Bench::new();
    for blocks in [1, 16, 64, 160, 300] {
        let said = made_with_room(&bench, blocks);
        if said.code == Some(0) {
            continue; // enough room for everything
        }
        assert_eq!(said.code, Some(1), "{blocks} blocks: {said:?}");
        assert!(said.err.contains("error: "), "{}", said.err);
        let whole = |name: &str| name.ends_with("trace.mcap") || name.ends_with(".kinfold");
        let left = [files(&bench.path("out")), files(&bench.path("out.failed"))];
        let left: Vec<_> = left.iter().flat_map(|f| f.keys()).filter(|n| !whole(n)).collect();
        assert!(left.is_empty(), "{blocks} blocks left {left:?}");
    }
    let said = bench.made(&[]);
    assert_eq!(said.code, Some(0), "{said:?}");
    assert!(bench.out() == undisturbed.out());
}
