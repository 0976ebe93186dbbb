//! Any bytes as a GLB file: an error or a mesh, never a crash, never much memory.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(mesh) = object::glb::read(bytes) {
        let again = object::glb::read(&object::glb::write(&mesh));
        assert!(again.is_ok(), "what was written can be read");
    }
});
