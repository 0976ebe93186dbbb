//! PyTorch checkpoints (zip and pickle) to safetensors, without running anything they say.

use std::collections::BTreeSet;
use std::io::{Read, Seek, Write};

use super::archive::Archive;
use super::checkpoint::{ConvertError, Foreign};
use super::file::TensorWriter;
use super::pickle::{self, Heap, TensorAt, Value};

/// Longest pickle, and largest tensor, that is read; bytes.
const MAX_PICKLE: u64 = 64 << 20;
const MAX_TENSOR: u64 = 1 << 30;

/// A tensor of the result.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Converted {
    /// Its key.
    pub name: String,
    /// Its shape.
    pub shape: Vec<usize>,
}

/// Writes the tensors of a checkpoint as safetensors: same keys, shapes and element types, in the
/// order of their keys. The dictionary of tensors is the checkpoint itself or its `state_dict`.
///
/// # Errors
/// [`ConvertError`]; nothing useful was written then.
pub fn convert_checkpoint(
    checkpoint: impl Read + Seek,
    out: impl Write,
    foreign: Foreign,
) -> Result<Vec<Converted>, ConvertError> {
    let mut archive = Archive::open(checkpoint)?;
    let root = root(&archive)?;
    let order = format!("{root}byteorder");
    if archive.size(&order).is_some() && archive.read(&order, 16)? != b"little" {
        return Err(ConvertError::Archive("its numbers must be little-endian".into()));
    }
    let heap = pickle::read(&archive.read(&format!("{root}data.pkl"), MAX_PICKLE)?, foreign)?;
    let tensors = tensors(&heap)?;
    for (name, tensor) in &tensors {
        check(&archive, &root, name, tensor)?;
    }
    let header: Vec<_> =
        tensors.iter().map(|(n, t)| (n.clone(), t.storage.dtype, t.shape.clone())).collect();
    let mut writer = TensorWriter::new(out, &header, None)?;
    for (_, tensor) in &tensors {
        let bytes = archive.read(&format!("{root}data/{}", tensor.storage.key), MAX_TENSOR)?;
        writer.write(&gather(tensor, &bytes))?;
    }
    writer.finish()?;
    let done = |(name, tensor): (String, TensorAt)| Converted { name, shape: tensor.shape };
    Ok(tensors.into_iter().map(done).collect())
}

/// The folder, with its slash, that holds the one `data.pkl`.
fn root<R: Read + Seek>(archive: &Archive<R>) -> Result<String, ConvertError> {
    let mut found = archive.names().filter_map(|n| n.strip_suffix("data.pkl"));
    match (found.next(), found.next()) {
        (Some(root), None) if root.ends_with('/') => Ok(root.into()),
        _ => Err(ConvertError::Archive("it must hold one folder with a `data.pkl`".into())),
    }
}

/// The dictionary of tensors, sorted by key.
fn tensors(heap: &Heap) -> Result<Vec<(String, TensorAt)>, ConvertError> {
    let dictionary = |id: usize| match heap.values.get(id) {
        Some(Value::Dict(items)) => Ok(items),
        other => Err(ConvertError::Pickle(format!("expected a dictionary, found {}", kind(other)))),
    };
    let text = |id: usize| match heap.values.get(id) {
        Some(Value::Text(text)) => Ok(text.clone()),
        other => Err(ConvertError::Pickle(format!("a key must be a text, found {}", kind(other)))),
    };
    let mut items = dictionary(heap.root)?;
    let inner = items.iter().find(|(key, _)| text(*key).is_ok_and(|k| k == "state_dict"));
    if let Some((_, inner)) = inner {
        items = dictionary(*inner)?;
    }
    let mut tensors = Vec::new();
    let mut names = BTreeSet::new();
    for &(key, value) in items {
        let name = text(key)?;
        let Some(Value::Tensor(tensor)) = heap.values.get(value) else {
            let rule = format!("expected a tensor, found {}", kind(heap.values.get(value)));
            return Err(ConvertError::Entry { name, rule });
        };
        if !names.insert(name.clone()) {
            return Err(ConvertError::Entry { name, rule: "it stands there twice".into() });
        }
        tensors.push((name, tensor.clone()));
    }
    tensors.sort_by(|a, b| a.0.cmp(&b.0));
    Ok(tensors)
}

fn kind(value: Option<&Value>) -> String {
    match value {
        Some(Value::Text(_)) => "a text".into(),
        Some(Value::Int(_) | Value::Plain) => "a plain value".into(),
        Some(Value::Sequence(_)) => "a list".into(),
        Some(Value::Dict(_)) => "a dictionary".into(),
        Some(Value::Tensor(_)) => "a tensor".into(),
        Some(Value::Storage(_) | Value::Name(_)) => "a name".into(),
        Some(Value::Foreign(name)) => format!("an object of `{name}`"),
        None => "nothing".into(),
    }
}

/// Proves that the archive holds the tensor's numbers, all of them.
fn check<R: Read + Seek>(
    archive: &Archive<R>,
    root: &str,
    name: &str,
    tensor: &TensorAt,
) -> Result<(), ConvertError> {
    let entry = |rule: String| ConvertError::Entry { name: name.into(), rule };
    let needed =
        (tensor.storage.count as u64).checked_mul(tensor.storage.dtype.bitsize() as u64 / 8);
    let needed = needed.filter(|&n| n <= MAX_TENSOR);
    let needed =
        needed.ok_or_else(|| entry(format!("a storage has at most {MAX_TENSOR} bytes")))?;
    match archive.size(&format!("{root}data/{}", tensor.storage.key)) {
        Some(found) if found >= needed => Ok(()),
        found => {
            let found = found.map_or("no such entry".into(), |f| format!("{f} bytes"));
            Err(entry(format!("expected {needed} bytes of numbers, found {found}")))
        }
    }
}

/// The tensor's numbers in row-major order.
fn gather(tensor: &TensorAt, bytes: &[u8]) -> Vec<u8> {
    let width = tensor.storage.dtype.bitsize() / 8;
    let size: usize = tensor.shape.iter().product();
    let mut out = Vec::with_capacity(size * width);
    let mut index = vec![0; tensor.shape.len()];
    for _ in 0..size {
        let steps = index.iter().zip(&tensor.strides).map(|(i, s)| i * s);
        let at = (tensor.offset + steps.sum::<usize>()) * width;
        out.extend_from_slice(bytes.get(at..at + width).unwrap_or(&[]));
        for (i, n) in index.iter_mut().zip(&tensor.shape).rev() {
            *i += 1;
            if *i < *n {
                break;
            }
            *i = 0;
        }
    }
    out
}

#[cfg(test)]
mod tests;
