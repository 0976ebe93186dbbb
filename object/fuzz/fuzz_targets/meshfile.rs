//! Any bytes as a mesh file of whatever format they look like: an error or one file that can be read again,
//! never a crash. The name of a file beside it gives the second half of the bytes.
//!
//! USD is left to the target `usd`: what the library that reads layers does with broken ones is fenced by a
//! process (`tests/mesh_formats.rs`), not by its code.
#![no_main]

use std::sync::Once;

use libfuzzer_sys::fuzz_target;
use object::beside::Found;
use object::mesh::UpAxis;
use object::meshfile;

/// What breaks down inside a decoder of somebody else's is caught and becomes an error.
fn forgive_the_decoders() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let strict = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            let file = panic.location().map_or("", |l| l.file());
            if !["draco"].iter().any(|theirs| file.contains(theirs)) {
                strict(panic);
                std::process::abort();
            }
        }));
    });
}

fuzz_target!(|bytes: &[u8]| {
    if bytes.starts_with(b"#usda") || bytes.starts_with(b"PXR-USDC") || bytes.starts_with(b"PK") {
        return;
    }
    forgive_the_decoders();
    let half = bytes.split_at(bytes.len() / 2).1.to_vec();
    let mut beside = |name: &str| Ok(Found { name: name.into(), bytes: half.clone() });
    for (is_obj, up) in [(false, UpAxis::Y), (true, UpAxis::Z)] {
        if let Ok(taken) = meshfile::take_in(bytes.to_vec(), (is_obj, up), &mut beside) {
            let again = meshfile::read_noted(&taken.file);
            assert!(again.is_ok_and(|again| again.mesh == taken.mesh), "what is kept can be read");
        }
    }
});
