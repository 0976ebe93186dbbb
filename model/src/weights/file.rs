//! Safetensors files: a header that is proved against the file's length, and values on demand.

use std::collections::HashMap;
use std::fmt;
use std::io::{Read, Seek, SeekFrom, Write};

use safetensors::Dtype;
use safetensors::tensor::{Metadata, TensorInfo};

/// Longest header that is read, bytes.
const MAX_HEADER: u64 = 16 << 20;

/// Why weights could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum WeightsError {
    /// The disk said no.
    #[error("weights: {0}")]
    Io(#[from] std::io::Error),
    /// Not a safetensors file, or one that contradicts itself.
    #[error("not a safetensors file: {0}")]
    Format(String),
    /// Tensors that are missing, of another shape, or too many.
    #[error("{} of the weights do not fit the network:{}", .0.len(), list(.0))]
    Mismatch(Vec<Wrong>),
    /// A tensor that holds NaN or infinity.
    #[error("tensor `{0}` holds a value that is not finite")]
    NotFinite(String),
    /// A number format nobody computes with here.
    #[error("tensor `{name}` has element type {found}, expected {expected}")]
    ElementType {
        /// The tensor.
        name: String,
        /// What was expected.
        expected: &'static str,
        /// What it is.
        found: String,
    },
    /// The sizes stored beside the weights are missing or not sound.
    #[error("the network's sizes beside the weights: {0}")]
    Sizes(String),
}

/// A tensor that does not fit; shapes are `None` where there is no such tensor.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Wrong {
    /// Its key.
    pub name: String,
    /// The shape the network needs.
    pub expected: Option<Vec<usize>>,
    /// The shape in the file.
    pub found: Option<Vec<usize>>,
}

impl fmt::Display for Wrong {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let shape = |s: &Option<Vec<usize>>| s.as_ref().map_or("none".into(), |s| format!("{s:?}"));
        write!(
            f,
            "`{}` expected {}, found {}",
            self.name,
            shape(&self.expected),
            shape(&self.found)
        )
    }
}

fn list(wrong: &[Wrong]) -> String {
    wrong.iter().map(|w| format!("\n  {w}")).collect()
}

/// What becomes of tensors the network does not need.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extra {
    /// They are an error.
    Refused,
    /// They are passed over.
    Ignored,
}

/// An open safetensors file.
#[derive(Debug)]
pub struct TensorFile<R> {
    reader: R,
    start: u64,
    metadata: Metadata,
}

impl<R: Read + Seek> TensorFile<R> {
    /// Reads the header and proves that every tensor lies inside the file.
    ///
    /// # Errors
    /// [`WeightsError::Format`] for anything that is not sound.
    pub fn open(mut reader: R) -> Result<Self, WeightsError> {
        let length = reader.seek(SeekFrom::End(0))?;
        reader.seek(SeekFrom::Start(0))?;
        let mut size = [0; 8];
        reader.read_exact(&mut size).map_err(|_| format_error("shorter than 8 bytes"))?;
        let size = u64::from_le_bytes(size);
        if size > MAX_HEADER.min(length.saturating_sub(8)) {
            let rule = format!("a header has at most {MAX_HEADER} bytes and ends inside the file");
            return Err(format_error(format!("{rule}, found {size} of {length}")));
        }
        let mut header = vec![0; size as usize];
        reader.read_exact(&mut header)?;
        let metadata: Metadata = serde_json::from_slice(&header).map_err(format_error)?;
        let start = 8 + size;
        if start.checked_add(metadata.data_len() as u64) != Some(length) {
            let found = format!("{} bytes of tensors after {start}", metadata.data_len());
            return Err(format_error(format!("{found}, but the file has {length}")));
        }
        Ok(Self { reader, start, metadata })
    }

    /// A text stored beside the tensors.
    pub fn note(&self, key: &str) -> Option<&str> {
        self.metadata.metadata().as_ref()?.get(key).map(String::as_str)
    }

    /// Keys, in the order of the data.
    pub fn names(&self) -> Vec<String> {
        self.metadata.offset_keys()
    }

    /// Shape of a tensor.
    pub fn shape(&self, name: &str) -> Option<&[usize]> {
        self.metadata.info(name).map(|info| info.shape.as_slice())
    }

    /// Compares keys and shapes with what a network needs.
    ///
    /// # Errors
    /// [`WeightsError::Mismatch`] with every tensor that does not fit.
    pub fn check(&self, needed: &[(String, Vec<usize>)], extra: Extra) -> Result<(), WeightsError> {
        let mut wrong: Vec<Wrong> = Vec::new();
        for (name, shape) in needed {
            let found = self.shape(name);
            if found != Some(shape) {
                let (expected, found) = (Some(shape.clone()), found.map(<[usize]>::to_vec));
                wrong.push(Wrong { name: name.clone(), expected, found });
            }
        }
        if extra == Extra::Refused {
            let known: std::collections::BTreeSet<_> = needed.iter().map(|(n, _)| n).collect();
            for name in self.names().into_iter().filter(|n| !known.contains(n)) {
                let found = self.shape(&name).map(<[usize]>::to_vec);
                wrong.push(Wrong { name, expected: None, found });
            }
        }
        if wrong.is_empty() { Ok(()) } else { Err(WeightsError::Mismatch(wrong)) }
    }

    fn bytes(&mut self, name: &str) -> Result<(Dtype, Vec<u8>), WeightsError> {
        let missing = || Wrong { name: name.into(), expected: None, found: None };
        let info = self.metadata.info(name);
        let info = info.ok_or_else(|| WeightsError::Mismatch(vec![missing()]))?;
        let (dtype, (from, to)) = (info.dtype, info.data_offsets);
        self.reader.seek(SeekFrom::Start(self.start + from as u64))?;
        let mut bytes = vec![0; to - from];
        self.reader.read_exact(&mut bytes)?;
        Ok((dtype, bytes))
    }

    /// The values of a floating-point tensor, as f32, row-major.
    ///
    /// # Errors
    /// [`WeightsError::ElementType`] for integers, [`WeightsError::Mismatch`] if there is none.
    pub fn values(&mut self, name: &str) -> Result<Vec<f32>, WeightsError> {
        let (dtype, bytes) = self.bytes(name)?;
        let half = |b: &[u8; 2]| u16::from_le_bytes(*b);
        match dtype {
            Dtype::F32 => Ok(bytes.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect()),
            Dtype::F64 => {
                Ok(bytes.as_chunks().0.iter().map(|b| f64::from_le_bytes(*b) as f32).collect())
            }
            Dtype::BF16 => {
                let wide = |b| f32::from_bits(u32::from(half(b)) << 16);
                Ok(bytes.as_chunks().0.iter().map(wide).collect())
            }
            Dtype::F16 => Ok(bytes.as_chunks().0.iter().map(|b| from_half(half(b))).collect()),
            other => Err(element_type(name, "a floating-point type", other)),
        }
    }

    /// The values of an integer tensor (I64, I32 or U8), row-major.
    ///
    /// # Errors
    /// [`WeightsError::ElementType`] for other types, [`WeightsError::Mismatch`] if there is none.
    pub fn integers(&mut self, name: &str) -> Result<Vec<i64>, WeightsError> {
        let (dtype, bytes) = self.bytes(name)?;
        match dtype {
            Dtype::I64 => Ok(bytes.as_chunks().0.iter().map(|b| i64::from_le_bytes(*b)).collect()),
            Dtype::I32 => {
                Ok(bytes.as_chunks().0.iter().map(|b| i32::from_le_bytes(*b).into()).collect())
            }
            Dtype::U8 => Ok(bytes.iter().map(|&b| b.into()).collect()),
            other => Err(element_type(name, "I64, I32 or U8", other)),
        }
    }
}

fn format_error(what: impl fmt::Display) -> WeightsError {
    WeightsError::Format(what.to_string())
}

fn element_type(name: &str, expected: &'static str, found: Dtype) -> WeightsError {
    WeightsError::ElementType { name: name.into(), expected, found: format!("{found:?}") }
}

/// IEEE half precision to single.
fn from_half(h: u16) -> f32 {
    let sign = if h & 0x8000 == 0 { 1.0 } else { -1.0 };
    let (exponent, fraction) = (i32::from(h >> 10 & 31), f32::from(h & 1023));
    match exponent {
        0 => sign * fraction * 2f32.powi(-24),
        31 if fraction == 0.0 => sign * f32::INFINITY,
        31 => f32::NAN,
        e => sign * (1024.0 + fraction) * 2f32.powi(e - 25),
    }
}

/// Writes tensors of known shapes, one after the other.
#[derive(Debug)]
pub struct TensorWriter<W> {
    writer: W,
    left: std::vec::IntoIter<(String, usize)>,
}

impl<W: Write> TensorWriter<W> {
    /// Writes the header: element type and shape of every tensor, and at most one note, so that the
    /// same tensors give the same bytes.
    ///
    /// # Errors
    /// [`WeightsError`] when the header cannot be written.
    pub fn new(
        mut writer: W,
        tensors: &[(String, Dtype, Vec<usize>)],
        note: Option<(&str, &str)>,
    ) -> Result<Self, WeightsError> {
        let mut end = 0;
        let mut place = |(name, dtype, shape): &(String, Dtype, Vec<usize>)| {
            let size = shape.iter().product::<usize>() * dtype.bitsize() / 8;
            let data_offsets = (end, end + size);
            end += size;
            (name.clone(), TensorInfo { dtype: *dtype, shape: shape.clone(), data_offsets })
        };
        let placed: Vec<_> = tensors.iter().map(&mut place).collect();
        let sizes =
            |(n, i): &(String, TensorInfo)| (n.clone(), i.data_offsets.1 - i.data_offsets.0);
        let left: Vec<_> = placed.iter().map(sizes).collect();
        let note = note.map(|(key, text)| HashMap::from([(key.to_owned(), text.to_owned())]));
        let metadata = Metadata::new(note, placed).map_err(format_error)?;
        let mut header = serde_json::to_vec(&metadata).map_err(format_error)?;
        header.resize(header.len().next_multiple_of(8), b' ');
        writer.write_all(&(header.len() as u64).to_le_bytes())?;
        writer.write_all(&header)?;
        Ok(Self { writer, left: left.into_iter() })
    }

    /// Writes the bytes of the next tensor.
    ///
    /// # Errors
    /// [`WeightsError::Format`] if they are not as many as the header says.
    pub fn write(&mut self, bytes: &[u8]) -> Result<(), WeightsError> {
        match self.left.next() {
            Some((_, size)) if size == bytes.len() => Ok(self.writer.write_all(bytes)?),
            Some((name, size)) => {
                Err(format_error(format!("tensor `{name}` has {size} bytes, got {}", bytes.len())))
            }
            None => Err(format_error("every tensor of the header is already written")),
        }
    }

    /// Ends the file.
    ///
    /// # Errors
    /// [`WeightsError::Format`] if tensors are missing.
    pub fn finish(mut self) -> Result<(), WeightsError> {
        match self.left.next() {
            Some((name, _)) => Err(format_error(format!("tensor `{name}` was never written"))),
            None => Ok(self.writer.flush()?),
        }
    }
}
