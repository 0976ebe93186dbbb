//! Any bytes as a trace: an error or what was in it, never a crash, never much memory. What is sealed
//! and holds together can be read again to the same events.
#![no_main]

use std::panic;

use libfuzzer_sys::fuzz_target;
use trace::{seal, verify};

/// The reader makes an error of a panic in the MCAP library; the fuzzer must not end there.
fn forgive_the_library() {
    let ends = panic::take_hook();
    panic::set_hook(Box::new(move |told| {
        if !told.location().is_some_and(|at| at.file().contains("/mcap-")) {
            ends(told);
        }
    }));
}

fuzz_target!(init: forgive_the_library(), |bytes: &[u8]| {
    let sealed = seal::check(bytes);
    let Ok(reading) = trace::read_bytes(bytes, "trace.mcap") else { return };
    let holds = verify::holds_together(&reading);
    let _ = verify::made(&reading).count();
    if sealed.is_ok() && holds.is_ok() {
        let again = trace::read_bytes(bytes, "trace.mcap").map(|r| r.events);
        assert_eq!(again.ok(), Some(reading.events));
    }
});
