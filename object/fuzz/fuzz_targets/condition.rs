//! Any text as a condition: an error that names the part, or a tree whose parts all hang below one
//! root; never a crash.
#![no_main]

use libfuzzer_sys::fuzz_target;
use object::Condition;

fuzz_target!(|text: &str| {
    let Ok(condition) = Condition::from_json(text) else { return };
    let parts = condition.tree.parts();
    assert!(!parts.is_empty(), "a condition has parts");
    for part in 0..parts.len() {
        let _ = condition.text(part);
    }
});
