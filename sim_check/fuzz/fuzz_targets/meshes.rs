//! Any bytes as OBJ and as STL: an error or a mesh, never a crash, never much memory.
#![no_main]

use libfuzzer_sys::fuzz_target;
use object::mesh::UpAxis;

fuzz_target!(|bytes: &[u8]| {
    let _ = object::stl::read(bytes).is_ok();
    if let Ok(text) = std::str::from_utf8(bytes) {
        let _ = object::obj::read(text, UpAxis::Z).is_ok();
    }
});
