//! The articulation network to a file and back, its sizes and encoders beside it.

use std::collections::BTreeMap;
use std::io::{Read, Seek, Write};

use burn::module::{Module, ModuleVisitor, Param};
use burn::tensor::{Device, Tensor};
use half::f16;
use safetensors::Dtype;
use serde::{Deserialize, Serialize};

use super::file::{Extra, TensorFile, TensorWriter, WeightsError};
use super::source::FileSource;
use crate::net::source::id_of;
use crate::net::{Config, Network, Precision};

/// The key of the note beside the tensors, and the format it announces.
const KEY: &str = "kinfold";
const FORMAT: &str = "kinfold-network/1";

/// What stands beside the tensors of a network.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Header {
    /// Always `kinfold-network/1`.
    pub format: String,
    /// Every size.
    pub config: Config,
    /// Identity of the text encoder it was trained with.
    pub text: String,
    /// Identity of the point encoder it was trained with.
    pub points: String,
}

impl Header {
    /// The header of a network trained with these encoders.
    pub fn new(config: &Config, text: &str, points: &str) -> Self {
        let (text, points) = (text.into(), points.into());
        Self { format: FORMAT.into(), config: config.clone(), text, points }
    }
}

/// Values of every parameter by its name.
struct Collect<'a> {
    names: &'a BTreeMap<u64, &'a str>,
    values: BTreeMap<String, Vec<f32>>,
    failure: Option<String>,
}

impl ModuleVisitor for Collect<'_> {
    fn visit_float<const D: usize>(&mut self, param: &Param<Tensor<D>>) {
        let name = self.names.get(&param.id.val());
        match (name, param.val().into_data().try_to_vec::<f32>()) {
            (Some(name), Ok(values)) => {
                self.values.insert((*name).into(), values);
            }
            (None, _) => self.failure = Some(format!("parameter {:?} has no name", param.id)),
            (Some(name), Err(e)) => self.failure = Some(format!("parameter `{name}`: {e:?}")),
        }
    }
}

/// Writes a network: the same network gives the same bytes.
///
/// # Errors
/// [`WeightsError`] when the file cannot be written.
pub fn save_network(
    network: &Network,
    header: &Header,
    writer: impl Write,
) -> Result<(), WeightsError> {
    save(network, header, writer, Dtype::F32)
}

/// Writes a network in half precision, for weights that are shipped: half the bytes, and answers
/// that differ in the third digit.
///
/// # Errors
/// [`WeightsError`] when the file cannot be written, or a weight is too large for half precision.
pub fn save_network_half(
    network: &Network,
    header: &Header,
    writer: impl Write,
) -> Result<(), WeightsError> {
    save(network, header, writer, Dtype::F16)
}

fn save(
    network: &Network,
    header: &Header,
    writer: impl Write,
    dtype: Dtype,
) -> Result<(), WeightsError> {
    let parameters = Network::parameters(&header.config).map_err(sizes_error)?;
    let names = parameters.iter().map(|(n, _)| (id_of(n).val(), n.as_str())).collect();
    let mut found = Collect { names: &names, values: BTreeMap::new(), failure: None };
    network.visit(&mut found);
    if let Some(failure) = found.failure {
        return Err(WeightsError::Format(failure));
    }
    let note = serde_json::to_string(header).map_err(sizes_error)?;
    let tensors: Vec<_> = parameters.iter().map(|(n, s)| (n.clone(), dtype, s.clone())).collect();
    let mut file = TensorWriter::new(writer, &tensors, Some((KEY, &note)))?;
    for (name, _) in &parameters {
        let values = found.values.get(name).map_or(&[][..], Vec::as_slice);
        file.write(&bytes_of(name, values, dtype)?)?;
    }
    file.finish()
}

fn bytes_of(name: &str, values: &[f32], dtype: Dtype) -> Result<Vec<u8>, WeightsError> {
    if dtype == Dtype::F32 {
        return Ok(values.iter().flat_map(|v| v.to_le_bytes()).collect());
    }
    let halves: Vec<f16> = values.iter().map(|&v| f16::from_f32(v)).collect();
    if halves.iter().all(|v| v.is_finite()) {
        return Ok(halves.iter().flat_map(|v| v.to_le_bytes()).collect());
    }
    Err(WeightsError::NotFinite(name.into()))
}

/// Reads a network that answers in this precision. Sizes, keys and shapes are checked before a tensor is built.
///
/// # Errors
/// [`WeightsError`]; for tensors that do not fit, with all of them.
pub fn load_network(
    reader: impl Read + Seek,
    device: &Device,
    precision: Precision,
) -> Result<(Network, Header), WeightsError> {
    let mut file = TensorFile::open(reader)?;
    let note = file.note(KEY).ok_or_else(|| sizes_error(format!("no note called `{KEY}`")))?;
    let header: Header = serde_json::from_str(note).map_err(sizes_error)?;
    if header.format != FORMAT {
        return Err(sizes_error(format!("format `{}`, expected `{FORMAT}`", header.format)));
    }
    let needed = Network::parameters(&header.config).map_err(sizes_error)?;
    file.check(&needed, Extra::Refused)?;
    let mut source = FileSource { file: &mut file, failure: None };
    let network = Network::build(&header.config, &mut source, device, precision);
    let network = network.map_err(sizes_error)?;
    match source.failure {
        Some(failure) => Err(failure),
        None => Ok((network, header)),
    }
}

fn sizes_error(what: impl std::fmt::Display) -> WeightsError {
    WeightsError::Sizes(what.to_string())
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;
    use crate::net::Positions;

    fn sizes() -> Config {
        Config {
            width: 8,
            heads: 2,
            blocks: 1,
            points: 5,
            tokens: 3,
            chunk: 4,
            queries: 6,
            features: 3,
            text: 2,
            max_parts: 4,
            positions: Positions::Absolute,
        }
    }

    fn saved(seed: u64, header: &Header) -> Vec<u8> {
        let network = Network::new(&sizes(), seed, &Device::flex()).unwrap();
        let mut bytes = Vec::new();
        save_network(&network, header, &mut bytes).unwrap();
        bytes
    }

    #[test]
    fn a_network_comes_back_as_it_was_and_repeats_byte_for_byte() {
        let header = Header::new(&sizes(), "text/1", "points/1");
        let bytes = saved(3, &header);
        let (network, found) =
            load_network(Cursor::new(&bytes), &Device::flex(), Precision::Full).unwrap();
        assert_eq!(found, header);
        let mut again = Vec::new();
        save_network(&network, &header, &mut again).unwrap();
        assert_eq!(bytes, again);
        assert_eq!(bytes, saved(3, &header));
        assert_ne!(bytes, saved(4, &header));
    }

    #[test]
    fn half_precision_keeps_three_digits_in_half_the_bytes() {
        let header = Header::new(&sizes(), "text/1", "points/1");
        let network = Network::new(&sizes(), 3, &Device::flex()).unwrap();
        let mut bytes = Vec::new();
        save_network_half(&network, &header, &mut bytes).unwrap();
        assert!(bytes.len() < saved(3, &header).len() * 2 / 3);
        let (back, found) =
            load_network(Cursor::new(&bytes), &Device::flex(), Precision::Full).unwrap();
        assert_eq!(found, header);
        let [a, b] = [&network, &back].map(|n| {
            let mut file = Vec::new();
            save_network(n, &header, &mut file).unwrap();
            let mut file = TensorFile::open(Cursor::new(file)).unwrap();
            file.values("latents").unwrap()
        });
        let near = |(a, b): (&f32, &f32)| (a - b).abs() <= a.abs() * 1e-3 + 1e-7;
        assert!(a.iter().zip(&b).all(near));
    }

    #[test]
    fn weights_of_other_sizes_are_listed_with_both_shapes() {
        let wide = Config { text: 9, ..sizes() };
        let bytes = saved(3, &Header::new(&sizes(), "", ""));
        let text = String::from_utf8_lossy(&bytes).replace("\\\"text\\\":2", "\\\"text\\\":9");
        assert!(text.contains(":9"), "the note was changed");
        let at = bytes.windows(11).position(|w| w == b"\\\"text\\\":2,").unwrap();
        let mut changed = bytes.clone();
        changed[at + 9] = b'9';
        let told = load_network(Cursor::new(&changed), &Device::flex(), Precision::Full)
            .unwrap_err()
            .to_string();
        assert!(told.contains("`text_embed.0.weight` expected [8, 9], found [8, 2]"), "{told}");
        assert_eq!(wide.check(), Ok(()));
    }

    #[test]
    fn a_file_cut_short_or_padded_is_refused() {
        let bytes = saved(1, &Header::new(&sizes(), "", ""));
        for wrong in
            [&bytes[..7], &bytes[..100], &bytes[..bytes.len() - 1], &[&bytes[..], &[0]].concat()]
        {
            assert!(matches!(
                load_network(Cursor::new(wrong), &Device::flex(), Precision::Full),
                Err(WeightsError::Format(_))
            ));
        }
        let huge = u64::MAX.to_le_bytes();
        assert!(TensorFile::open(Cursor::new(&huge)).is_err());
    }
}
