//! Samples on disk: safetensors files that appear whole or not at all.

use std::fs::File;
use std::io::{BufReader, Write};
use std::path::{Path, PathBuf};

use half::f16;
use model::features::geometric::WIDTH;
use model::weights::{TensorFile, TensorWriter, WeightsError};
use safetensors::Dtype;
use serde::{Deserialize, Serialize};

use super::{DataError, Sample, SamplePart};

/// The key of the note beside the tensors.
const KEY: &str = "kinfold-sample";

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Note {
    even: usize,
    parts: Vec<SamplePart>,
}

/// Writes bytes beside a path, syncs them and moves them into place.
///
/// # Errors
/// [`std::io::Error`] of the disk; the old file, if any, is then still there.
pub fn write_whole(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let mut name = path.file_name().map(|n| n.to_os_string()).unwrap_or_default();
    name.push(".partial");
    let beside: PathBuf = path.with_file_name(name);
    let mut file = File::create(&beside)?;
    file.write_all(bytes)?;
    file.sync_all()?;
    std::fs::rename(&beside, path)
}

/// Writes a sample; features in half precision.
///
/// # Errors
/// [`DataError`] when the disk refuses.
pub fn write(sample: &Sample, path: &Path) -> Result<(), DataError> {
    let bytes = encode(sample).map_err(|e| DataError::broken(path, e))?;
    write_whole(path, &bytes).map_err(DataError::io(path))
}

fn encode(sample: &Sample) -> Result<Vec<u8>, WeightsError> {
    let count = sample.positions.len();
    let note = Note { even: sample.even, parts: sample.parts.clone() };
    let note = serde_json::to_string(&note).map_err(|e| WeightsError::Format(e.to_string()))?;
    let tensors = [
        ("positions".into(), Dtype::F32, vec![count, 3]),
        ("normals".into(), Dtype::F32, vec![count, 3]),
        ("labels".into(), Dtype::I32, vec![count]),
        ("features".into(), Dtype::F16, vec![count, WIDTH]),
    ];
    let mut bytes = Vec::new();
    let mut file = TensorWriter::new(&mut bytes, &tensors, Some((KEY, &note)))?;
    let single = |all: &[[f32; 3]]| -> Vec<u8> {
        all.iter().flatten().flat_map(|v| v.to_le_bytes()).collect()
    };
    file.write(&single(&sample.positions))?;
    file.write(&single(&sample.normals))?;
    let labels = sample.labels.iter().flat_map(|&l| i32::from(l).to_le_bytes());
    file.write(&labels.collect::<Vec<u8>>())?;
    let features = sample.features.iter().flat_map(|&v| f16::from_f32(v).to_le_bytes());
    file.write(&features.collect::<Vec<u8>>())?;
    file.finish()?;
    Ok(bytes)
}

/// Reads a sample.
///
/// # Errors
/// [`DataError`] when the file cannot be read or is none of ours.
pub fn read(path: &Path) -> Result<Sample, DataError> {
    let file = File::open(path).map_err(DataError::io(path))?;
    let sample = decode(BufReader::new(file)).map_err(|e| DataError::broken(path, e))?;
    check(&sample).map_err(|e| DataError::broken(path, e))?;
    Ok(sample)
}

fn decode(reader: BufReader<File>) -> Result<Sample, WeightsError> {
    let mut file = TensorFile::open(reader)?;
    let format = |e: String| WeightsError::Format(e);
    let note = file.note(KEY).ok_or_else(|| format(format!("no note called `{KEY}`")))?;
    let note: Note = serde_json::from_str(note).map_err(|e| format(e.to_string()))?;
    let labels = file.integers("labels")?;
    Ok(Sample {
        positions: triples(file.values("positions")?),
        normals: triples(file.values("normals")?),
        features: file.values("features")?,
        labels: labels.into_iter().map(|l| u16::try_from(l).unwrap_or(u16::MAX)).collect(),
        even: note.even,
        parts: note.parts,
    })
}

fn triples(values: Vec<f32>) -> Vec<[f32; 3]> {
    values.as_chunks::<3>().0.to_vec()
}

fn check(sample: &Sample) -> Result<(), String> {
    let (count, parts) = (sample.positions.len(), sample.parts.len());
    let rows = [sample.normals.len(), sample.labels.len(), sample.features.len() / WIDTH];
    if rows != [count; 3] || sample.even > count || count == 0 {
        return Err(format!("expected {count} rows in every tensor, found {rows:?}"));
    }
    if sample.labels.iter().any(|&l| usize::from(l) >= parts) {
        return Err(format!("a point is labelled with a part that is not one of {parts}"));
    }
    let outside = |p: &SamplePart| p.parent.is_some_and(|q| q >= parts) || p.wordings.is_empty();
    match sample.parts.iter().position(outside) {
        Some(part) => Err(format!("part {part} has no wording or an unknown parent")),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::SampleJoint;

    fn sample() -> Sample {
        let root = SamplePart { wordings: vec!["body".into()], ..SamplePart::default() };
        let joint = SampleJoint { turns: true, axis: [0.0, 0.0, 1.0], ..SampleJoint::default() };
        let door =
            SamplePart { parent: Some(0), wordings: vec!["door".into()], joints: vec![joint] };
        Sample {
            positions: vec![[0.1, 0.2, 0.3], [0.0, -0.5, 0.25], [0.5, 0.5, 0.5]],
            normals: vec![[0.0, 0.0, 1.0]; 3],
            features: (0..3 * WIDTH).map(|i| i as f32 / 8.0).collect(),
            labels: vec![0, 1, 0],
            even: 2,
            parts: vec![root, door],
        }
    }

    #[test]
    fn a_sample_comes_back_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.safetensors");
        write(&sample(), &path).unwrap();
        assert_eq!(read(&path).unwrap(), sample());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "nothing is left beside");
    }

    #[test]
    fn a_sample_that_contradicts_itself_is_refused_with_its_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.safetensors");
        let wrong = Sample { labels: vec![0, 2, 0], ..sample() };
        write(&wrong, &path).unwrap();
        let told = read(&path).unwrap_err().to_string();
        assert!(told.contains("a.safetensors: a point is labelled"), "{told}");
        std::fs::write(&path, b"nonsense").unwrap();
        assert!(read(&path).is_err());
    }
}
