//! A checkpoint: weights, moments and step in one file that is written whole or not at all.
//!
//! There is no generator to store: every draw of a step comes from the seed and the step's number.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Read, Seek};
use std::path::Path;

use burn::module::{Module, ModuleVisitor, Param};
use burn::tensor::{Device, Tensor, TensorData};
use model::net::source::{Source, Start, id_of};
use model::net::{Network, Precision};
use model::weights::{Extra, Header, TensorFile, TensorWriter, WeightsError};
use safetensors::Dtype;
use serde::{Deserialize, Serialize};

use super::error::TrainError;
use super::optimiser::{AdamW, Moments};
use crate::dataset::cache::write_whole;

/// The key of the note beside the tensors, and the format it announces.
const KEY: &str = "kinfold-training";
const FORMAT: &str = "kinfold-training/1";
/// What is stored of each parameter: itself and its two moments.
const PREFIXES: [&str; 3] = ["", "first.", "second."];

/// What stands beside the tensors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Note {
    format: String,
    /// Steps done.
    pub step: u64,
    /// Digest of everything in the configuration that the weights depend on.
    pub identity: String,
    /// Sizes and encoders.
    pub header: Header,
    /// The bits of the losses since the last point of the curve.
    pub window: Vec<[u32; 3]>,
}

/// A training run at one moment.
#[derive(Debug)]
pub struct Checkpoint {
    /// What stands beside the tensors.
    pub note: Note,
    /// The network, on a device that records gradients.
    pub network: Network,
    /// The optimiser.
    pub optimiser: AdamW,
}

impl Note {
    /// The note of a run.
    pub fn new(step: u64, identity: &str, header: &Header) -> Self {
        let (format, identity) = (FORMAT.into(), identity.into());
        Self { format, step, identity, header: header.clone(), window: vec![] }
    }
}

/// Flat values of every parameter by its identifier.
#[derive(Default)]
struct Collect(BTreeMap<u64, Vec<f32>>);

impl ModuleVisitor for Collect {
    fn visit_float<const D: usize>(&mut self, param: &Param<Tensor<D>>) {
        if let Ok(values) = param.val().into_data().try_into_vec() {
            self.0.insert(param.id.val(), values);
        }
    }
}

impl Checkpoint {
    /// Writes the checkpoint in place of an older one.
    ///
    /// # Errors
    /// [`TrainError`] when the disk refuses.
    pub fn write(&self, path: &Path) -> Result<(), TrainError> {
        let bytes = self.encode().map_err(TrainError::weights(path))?;
        write_whole(path, &bytes).map_err(TrainError::io(path))
    }

    fn encode(&self) -> Result<Vec<u8>, WeightsError> {
        let note = serde_json::to_string(&self.note).map_err(format_error)?;
        let parameters = Network::parameters(&self.note.header.config).map_err(format_error)?;
        let all = PREFIXES.iter().flat_map(|prefix| {
            parameters.iter().map(move |(n, s)| (format!("{prefix}{n}"), Dtype::F32, s.clone()))
        });
        let tensors: Vec<_> = all.collect();
        let mut bytes = Vec::new();
        let mut file = TensorWriter::new(&mut bytes, &tensors, Some((KEY, &note)))?;
        for values in self.values()? {
            for (name, shape) in &parameters {
                let zeros = vec![0.0; shape.iter().product()];
                let values = values.get(&id_of(name).val()).unwrap_or(&zeros);
                file.write(&values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<_>>())?;
            }
        }
        file.finish()?;
        Ok(bytes)
    }

    /// Weights, first and second moments; a parameter that never had a gradient has no moments.
    fn values(&self) -> Result<[BTreeMap<u64, Vec<f32>>; 3], WeightsError> {
        let mut weights = Collect::default();
        self.network.visit(&mut weights);
        let flat = |t: &Tensor<1>| t.clone().into_data().try_into_vec().map_err(debug_error);
        let (mut first, mut second) = (BTreeMap::new(), BTreeMap::new());
        for (&id, moments) in &self.optimiser.moments {
            first.insert(id, flat(&moments.first)?);
            second.insert(id, flat(&moments.second)?);
        }
        Ok([weights.0, first, second])
    }

    /// Reads a checkpoint.
    ///
    /// # Errors
    /// [`TrainError`] when it cannot be read or is none of ours.
    pub fn read(path: &Path, device: &Device) -> Result<Self, TrainError> {
        let file = File::open(path).map_err(TrainError::io(path))?;
        Self::decode(BufReader::new(file), device).map_err(TrainError::weights(path))
    }

    fn decode(reader: impl Read + Seek, device: &Device) -> Result<Self, WeightsError> {
        let mut file = TensorFile::open(reader)?;
        let note = file.note(KEY).ok_or_else(|| format_error(format!("no note called `{KEY}`")))?;
        let note: Note = serde_json::from_str(note).map_err(format_error)?;
        if note.format != FORMAT {
            return Err(format_error(format!("format `{}`, expected `{FORMAT}`", note.format)));
        }
        let parameters = Network::parameters(&note.header.config).map_err(format_error)?;
        let all = PREFIXES.iter().flat_map(|prefix| {
            parameters.iter().map(move |(n, s)| (format!("{prefix}{n}"), s.clone()))
        });
        file.check(&all.collect::<Vec<_>>(), Extra::Refused)?;
        let mut stored = Stored { file: &mut file, failure: None };
        let network = Network::build(&note.header.config, &mut stored, device, Precision::Full);
        let network = network.map_err(format_error)?;
        let mut optimiser = AdamW { steps: note.step, moments: BTreeMap::new() };
        for (name, _) in &parameters {
            let [first, second] = [PREFIXES[1], PREFIXES[2]]
                .map(|prefix| stored.flat(&format!("{prefix}{name}"), device));
            optimiser.moments.insert(id_of(name).val(), Moments { first, second });
        }
        match stored.failure {
            Some(failure) => Err(failure),
            None => Ok(Self { note, network, optimiser }),
        }
    }
}

/// Gives tensors of a checkpoint; the first failure is kept.
struct Stored<'a, R> {
    file: &'a mut TensorFile<R>,
    failure: Option<WeightsError>,
}

impl<R: Read + Seek> Stored<'_, R> {
    fn flat(&mut self, name: &str, device: &Device) -> Tensor<1> {
        let values = self.file.values(name).unwrap_or_else(|e| {
            self.failure.get_or_insert(e);
            vec![]
        });
        let count = values.len();
        Tensor::<1>::from_data(TensorData::new(values, [count]), device).inner()
    }
}

impl<R: Read + Seek> Source for Stored<'_, R> {
    fn values(&mut self, name: &str, shape: &[usize], _: Start) -> Vec<f32> {
        self.file.values(name).unwrap_or_else(|e| {
            self.failure.get_or_insert(e);
            vec![0.0; shape.iter().product()]
        })
    }
}

fn format_error(what: impl std::fmt::Display) -> WeightsError {
    WeightsError::Format(what.to_string())
}

fn debug_error(what: impl std::fmt::Debug) -> WeightsError {
    WeightsError::Format(format!("{what:?}"))
}
