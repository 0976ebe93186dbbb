//! Any bytes as a PyTorch checkpoint: an error or tensors, never a crash, never much memory.
#![no_main]

use std::io::Cursor;

use libfuzzer_sys::fuzz_target;
use kinfold_model_fuzz::{Foreign, TensorFile, convert_checkpoint};

fuzz_target!(|bytes: &[u8]| {
    let mut out = Vec::new();
    if convert_checkpoint(Cursor::new(bytes), &mut out, Foreign::Opaque).is_ok() {
        let file = TensorFile::open(Cursor::new(&out));
        assert!(file.is_ok(), "what was written can be read");
    }
});
