use super::*;

const BINARY: &[u8] = include_bytes!("../../../fuzz/seeds/usd/boxes.usdc");

fn start_of(name: &str) -> usize {
    let sections = sections(BINARY).unwrap();
    sections.into_iter().find(|(called, _)| called.as_slice() == name.as_bytes()).unwrap().1
}

/// The layer with eight bytes altered.
fn altered(at: usize, number: u64) -> Vec<u8> {
    let mut layer = BINARY.to_vec();
    layer[at..at + 8].copy_from_slice(&number.to_le_bytes());
    layer
}

#[test]
fn a_sound_layer_is_within_its_bounds() {
    assert_eq!(bounded(BINARY), Ok(()));
}

#[test]
fn a_list_longer_than_its_bytes_is_refused_before_room_is_made_for_it() {
    for section in ["TOKENS", "STRINGS", "FIELDS", "FIELDSETS", "PATHS", "SPECS"] {
        for many in [1 << 20, 1 << 32, 1 << 56, u64::MAX] {
            let layer = altered(start_of(section), many);
            // How many tokens there are is only compared with what is found.
            let is_refused = bounded(&layer).is_err();
            assert!(is_refused || section == "TOKENS", "{section} {many}");
        }
    }
    assert!(bounded(&altered(start_of("TOKENS") + 8, 1 << 40)).is_err());
    assert!(bounded(&altered(start_of("TOKENS") + 16, 1 << 40)).is_err());
}

#[test]
fn an_array_longer_than_the_file_is_refused() {
    let mut is_refused = 0;
    for rep in fields(Bytes::at(BINARY, start_of("FIELDS"))).unwrap() {
        let place = (rep & ((1 << 48) - 1)) as usize;
        if rep >> 63 == 1 && place > 0 {
            let error = bounded(&altered(place, 1 << 40)).unwrap_err();
            assert!(error.contains("byte"), "{error}");
            is_refused += 1;
        }
    }
    assert!(is_refused > 5, "{is_refused}");
}

#[test]
fn a_dictionary_that_holds_itself_is_refused() {
    // One key whose value, by its offset, is the dictionary itself.
    let mut layer = vec![0; 64];
    let own: u64 = 31 << 48 | 64;
    layer.extend(1_u64.to_le_bytes());
    layer.extend(0_u32.to_le_bytes());
    layer.extend(8_i64.to_le_bytes());
    layer.extend(own.to_le_bytes());
    let mut values = Values::new(&layer, 8, [&[], &[], &[]]);
    assert!(values.weight(own).unwrap_err().contains("deep"));
}

#[test]
fn no_altered_byte_breaks_the_count() {
    for at in (0..BINARY.len()).step_by(3) {
        for bits in [0x01, 0x80, 0xff] {
            let mut layer = BINARY.to_vec();
            layer[at] ^= bits;
            let _ = bounded(&layer);
        }
    }
}
