//! Checkpoints written by hand, sound and hostile.

use std::io::Cursor;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::*;
use crate::weights::TensorFile;

/// A zip archive of stored entries.
fn zip(entries: &[(&str, &[u8])]) -> Vec<u8> {
    let (mut out, mut directory) = (Vec::new(), Vec::new());
    for (name, data) in entries {
        let at = out.len() as u32;
        let size = (data.len() as u32).to_le_bytes();
        let length = (name.len() as u16).to_le_bytes();
        out.extend(b"PK\x03\x04\0\0\0\0\0\0\0\0\0\0\0\0\0\0");
        out.extend([size, size].concat());
        out.extend([length, [0; 2]].concat());
        out.extend(name.bytes().chain(data.iter().copied()));
        directory.extend(b"PK\x01\x02\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0");
        directory.extend([size, size].concat());
        directory.extend([length, [0; 2], [0; 2], [0; 2], [0; 2], [0; 2], [0; 2]].concat());
        directory.extend(at.to_le_bytes());
        directory.extend(name.bytes());
    }
    let count = (entries.len() as u16).to_le_bytes();
    let (size, at) = (directory.len() as u32, out.len() as u32);
    out.extend(directory);
    out.extend(b"PK\x05\x06\0\0\0\0");
    out.extend([count, count].concat());
    out.extend([size.to_le_bytes(), at.to_le_bytes()].concat());
    out.extend([0, 0]);
    out
}

fn text(s: &str) -> Vec<u8> {
    [b"X".to_vec(), (s.len() as u32).to_le_bytes().to_vec(), s.as_bytes().to_vec()].concat()
}

/// A tensor of `count` floats in storage `key`, of this shape and these strides.
fn tensor(key: &str, count: u8, shape: &[u8], strides: &[u8]) -> Vec<u8> {
    let ints = |all: &[u8]| {
        let items: Vec<u8> = all.iter().flat_map(|n| [b'K', *n]).collect();
        [b"(".to_vec(), items, b"t".to_vec()].concat()
    };
    [
        b"ctorch._utils\n_rebuild_tensor_v2\n((".to_vec(),
        text("storage"),
        b"ctorch\nFloatStorage\n".to_vec(),
        text(key),
        text("cpu"),
        vec![b'K', count, b't', b'Q', b'K', 0],
        ints(shape),
        ints(strides),
        b"\x89ccollections\nOrderedDict\n)RtR".to_vec(),
    ]
    .concat()
}

/// An ordered dictionary of these items, with PyTorch's note on it.
fn dict(items: &[(&str, Vec<u8>)]) -> Vec<u8> {
    let items: Vec<u8> = items.iter().flat_map(|(k, v)| [text(k), v.clone()].concat()).collect();
    let note = [b"}".to_vec(), text("_metadata"), b"}sb".to_vec()].concat();
    [b"ccollections\nOrderedDict\n)R(".to_vec(), items, b"u".to_vec(), note].concat()
}

fn checkpoint(pickle: &[u8]) -> Vec<u8> {
    let floats: Vec<u8> = (0..6).flat_map(|i| (i as f32).to_le_bytes()).collect();
    let pickle = [b"\x80\x02", pickle, b"."].concat();
    zip(&[("m/data.pkl", &pickle), ("m/byteorder", b"little"), ("m/data/0", &floats)])
}

fn convert(pickle: &[u8], foreign: Foreign) -> Result<Vec<u8>, ConvertError> {
    let mut out = Vec::new();
    convert_checkpoint(Cursor::new(checkpoint(pickle)), &mut out, foreign).map(|_| out)
}

#[test]
fn tensors_keep_keys_shapes_and_values_and_transposed_ones_are_laid_out() {
    let pickle = dict(&[
        ("b.weight", tensor("0", 6, &[2, 3], &[3, 1])),
        ("a.weight", tensor("0", 6, &[3, 2], &[1, 3])),
    ]);
    let bytes = convert(&pickle, Foreign::Refused).unwrap();
    let mut file = TensorFile::open(Cursor::new(bytes)).unwrap();
    assert_eq!(file.names(), ["a.weight", "b.weight"]);
    assert_eq!(file.shape("a.weight"), Some(&[3, 2][..]));
    assert_eq!(file.values("b.weight").unwrap(), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
    assert_eq!(file.values("a.weight").unwrap(), [0.0, 3.0, 1.0, 4.0, 2.0, 5.0]);
}

#[test]
fn a_pickle_that_asks_for_anything_else_is_refused_by_name() {
    let evil = [b"cos\nsystem\n(".to_vec(), text("echo"), b"tR".to_vec()].concat();
    let told = convert(&dict(&[("a", evil)]), Foreign::Refused).unwrap_err().to_string();
    assert!(told.contains("asks for `os.system`"), "{told}");
}

#[test]
fn opaque_objects_may_stand_beside_the_tensors_but_not_among_them() {
    let object = b"cyacs.config\nCfgNode\n)\x81}b".to_vec();
    let state = dict(&[("w", tensor("0", 6, &[6], &[1]))]);
    let trainer = dict(&[("hyper_parameters", object.clone()), ("state_dict", state)]);
    assert!(matches!(convert(&trainer, Foreign::Refused), Err(ConvertError::Foreign(_))));
    let bytes = convert(&trainer, Foreign::Opaque).unwrap();
    assert_eq!(TensorFile::open(Cursor::new(bytes)).unwrap().names(), ["w"]);
    let among = dict(&[("w", object)]);
    let told = convert(&among, Foreign::Opaque).unwrap_err().to_string();
    assert!(told.contains("found an object of `yacs.config.CfgNode`"), "{told}");
}

#[test]
fn tensors_that_leave_their_storage_are_refused() {
    for (count, shape, strides) in [(6, [7], [1]), (6, [3], [3]), (200, [200], [1])] {
        let pickle = dict(&[("w", tensor("0", count, &shape, &strides))]);
        assert!(convert(&pickle, Foreign::Refused).is_err(), "{count} {shape:?} {strides:?}");
    }
    let missing = dict(&[("w", tensor("9", 6, &[6], &[1]))]);
    let told = convert(&missing, Foreign::Refused).unwrap_err().to_string();
    assert_eq!(told, "checkpoint entry `w`: expected 24 bytes of numbers, found no such entry");
}

#[test]
fn what_is_no_checkpoint_says_so() {
    for bytes in [&b""[..], b"PK\x05\x06", &[0; 1000]] {
        let mut out = Vec::new();
        let told = convert_checkpoint(Cursor::new(bytes), &mut out, Foreign::Refused);
        assert!(matches!(told, Err(ConvertError::Archive(_))), "{told:?}");
    }
}

/// Flips, cuts and doubles bytes of sound files; no reader may panic or take much memory.
/// `KINFOLD_FUZZ_ROUNDS` makes it longer.
#[test]
fn damaged_files_are_errors_not_crashes() {
    let pickle =
        dict(&[("a", tensor("0", 6, &[2, 3], &[3, 1])), ("b", tensor("0", 6, &[6], &[1]))]);
    let sound = [checkpoint(&pickle), convert(&pickle, Foreign::Refused).unwrap()];
    let rounds = std::env::var("KINFOLD_FUZZ_ROUNDS").ok().and_then(|r| r.parse().ok());
    let mut rng = Pcg64Mcg::seed_from_u64(11);
    for round in 0..rounds.unwrap_or(20_000u64) {
        let mut bytes = sound[(round % 2) as usize].clone();
        for _ in 0..rng.random_range(1..6) {
            let at = rng.random_range(0..bytes.len());
            match rng.random_range(0..4) {
                0 => bytes[at] = rng.random(),
                1 => bytes[at] ^= 1 << rng.random_range(0..8),
                2 => bytes.truncate(at.max(1)),
                _ => bytes.insert(at, b"(tRQsub}].hq\x81\xff"[rng.random_range(0..14)]),
            }
        }
        let mut out = Vec::new();
        let _ = convert_checkpoint(Cursor::new(&bytes), &mut out, Foreign::Opaque);
        if let Ok(mut file) = TensorFile::open(Cursor::new(&bytes)) {
            for name in file.names() {
                let _ = (file.values(&name).is_ok(), file.integers(&name).is_ok());
            }
        }
    }
}
