//! Any bytes as a binary USD layer whose counts are looked at, and as what the process that reads layers
//! answers: an error or a mesh, never a crash.
#![no_main]

use libfuzzer_sys::fuzz_target;
use object::beside::Found;
use object::mesh::UpAxis;
use object::usd;

fuzz_target!(|bytes: &[u8]| {
    let _ = usd::counted(bytes);
    let half = bytes.split_at(bytes.len() / 2).1.to_vec();
    let mut beside = |name: &str| Ok(Found { name: name.into(), bytes: half.clone() });
    let _ = usd::of_answer(bytes, UpAxis::Z, &mut beside);
});
