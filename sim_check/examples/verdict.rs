//! Prints the verdict on the URDFs named on the command line, and how long each took; the name of
//! a tier among them goes for those after it.
#![allow(clippy::print_stdout, reason = "an example talks to its reader")]

use std::path::Path;
use std::time::Instant;

use sim_check::{CheckOptions, Tier, check};

fn main() {
    let mut options = CheckOptions::default();
    for path in std::env::args().skip(1) {
        if let Some(tier) = Tier::ALL.into_iter().find(|t| t.name() == path) {
            options.up_to = tier;
            continue;
        }
        let start = Instant::now();
        let verdict = check(Path::new(&path), &options);
        println!("{path}\n{}\n{:?}", verdict.table(), start.elapsed());
    }
}
