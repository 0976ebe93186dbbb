//! Any bytes as a pack of what was learned: an error or models, never a crash, never much memory. What
//! opens is written again to the same bytes.
//!
//! The digest at the end is made to hold, so that what is fuzzed lies behind it.
#![no_main]

use kinfold_model_fuzz::pack::{Form, Pack, write};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let _ = Pack::open("as it is", bytes).is_ok();
    let mut sealed = bytes.to_vec();
    sealed.extend(blake3::hash(bytes).as_bytes());
    let Ok(pack) = Pack::open("sealed", &sealed) else { return };
    let mut content = pack.content();
    let mut sections = Vec::new();
    for section in &pack.head.sections {
        let (own, rest) = content.split_at(section.bytes as usize);
        content = rest;
        sections.push((section.clone(), own.to_vec()));
        if section.form == Form::Forest {
            if let Ok(forest) = pack.forest::<2>(&section.name) {
                let mut again = Vec::new();
                forest.write(&mut again);
                assert_eq!(again, own);
                assert!(forest.score(&[0.5, -0.5]).is_finite() || forest.trees.len() > 1);
            }
        } else {
            let count = own.len() / if section.form == Form::Single { 4 } else { 8 };
            let _ = pack.numbers(&section.name, count).is_ok();
        }
    }
    let again = write(pack.head.clone(), sections).and_then(|again| {
        let name = "again";
        Pack::open(name, &again).map(|p| p.head).map_err(|e| e.fault)
    });
    assert_eq!(again.as_ref(), Ok(&pack.head));
});
