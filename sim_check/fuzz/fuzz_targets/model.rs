//! Any text as URDF, MJCF or SDFormat: findings or a robot that the checks of its numbers come through.
#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use sim_check::checks::lint;
use sim_check::read::load;
use sim_check::{CheckOptions, Status};

fuzz_target!(|text: &str| {
    let options = CheckOptions::default();
    let loaded = load::from_text(text, Path::new("/nowhere"), &options);
    match &loaded.robot {
        Some(robot) => drop(lint::checks(robot, &options)),
        None => assert!(loaded.checks.iter().any(|c| c.status != Status::Pass)),
    }
});
