//! Any bytes as a safetensors file: an error or tensors, never a crash, never much memory.
#![no_main]

use std::io::Cursor;

use libfuzzer_sys::fuzz_target;
use kinfold_model_fuzz::TensorFile;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(mut file) = TensorFile::open(Cursor::new(bytes)) {
        for name in file.names() {
            let _ = (file.values(&name).is_ok(), file.integers(&name).is_ok());
        }
    }
});
