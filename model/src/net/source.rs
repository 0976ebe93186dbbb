//! Where parameters come from: a seed or a file. A layer states names and shapes once, here.

use burn::module::{Param, ParamId};
use burn::tensor::{Device, Tensor, TensorData};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::precision::Precision;

/// How a parameter begins when no file gives it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Start {
    /// Uniform in ±bound.
    Uniform(f32),
    /// Normal with this standard deviation.
    Normal(f32),
    /// One value everywhere.
    Constant(f32),
}

/// Something that can give every parameter of a network.
pub trait Source {
    /// The values of one parameter, row-major. A source that cannot give them notes it and returns
    /// values of the right number all the same.
    fn values(&mut self, name: &str, shape: &[usize], start: Start) -> Vec<f32>;
}

/// Random parameters: the same for the same seed, whatever the order of layers.
#[derive(Clone, Copy, Debug)]
pub struct Random {
    /// Seed of all of them.
    pub seed: u64,
}

impl Source for Random {
    fn values(&mut self, name: &str, shape: &[usize], start: Start) -> Vec<f32> {
        let mut rng = Pcg64Mcg::seed_from_u64(self.seed ^ id_of(name).val());
        let count = shape.iter().product();
        let mut uniform = || rng.random::<f32>();
        match start {
            Start::Constant(value) => vec![value; count],
            Start::Uniform(bound) => (0..count).map(|_| (2.0 * uniform() - 1.0) * bound).collect(),
            Start::Normal(deviation) => {
                let mut normal = || {
                    let (u, v) = (1.0 - uniform(), uniform());
                    (-2.0 * u.ln()).sqrt() * (std::f32::consts::TAU * v).cos()
                };
                (0..count).map(|_| normal() * deviation).collect()
            }
        }
    }
}

/// Name and shape of every parameter, in order, without any values.
#[derive(Clone, Debug, Default)]
pub struct Inventory {
    /// What was asked for.
    pub parameters: Vec<(String, Vec<usize>)>,
}

impl Source for Inventory {
    fn values(&mut self, name: &str, shape: &[usize], _: Start) -> Vec<f32> {
        self.parameters.push((name.into(), shape.to_vec()));
        vec![]
    }
}

/// A parameter is known by its name: the identifier is the FNV-1a hash of it.
pub fn id_of(name: &str) -> ParamId {
    let step = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    ParamId::from(name.bytes().fold(0xcbf2_9ce4_8422_2325, step))
}

/// Hands parameters to a layer under a common prefix.
pub struct Builder<'a> {
    source: &'a mut dyn Source,
    device: &'a Device,
    precision: Precision,
    prefix: String,
}

impl<'a> Builder<'a> {
    /// Parameters of a whole network, on a device.
    pub fn new(source: &'a mut dyn Source, device: &'a Device) -> Self {
        Self { source, device, precision: Precision::Full, prefix: String::new() }
    }

    /// The same for layers that multiply as precisely as this.
    pub fn at_precision(self, precision: Precision) -> Self {
        Self { precision, ..self }
    }

    /// How precisely the layers multiply.
    pub fn precision(&self) -> Precision {
        self.precision
    }

    /// The parameters below `name`.
    pub fn at(&mut self, name: impl std::fmt::Display) -> Builder<'_> {
        let prefix = format!("{}{name}.", self.prefix);
        Builder { source: &mut *self.source, prefix, ..*self }
    }

    /// One parameter, trainable.
    pub fn parameter<const D: usize>(
        &mut self,
        name: &str,
        shape: [usize; D],
        start: Start,
    ) -> Param<Tensor<D>> {
        let name = format!("{}{name}", self.prefix);
        let values = self.source.values(&name, &shape, start);
        let shape = if values.is_empty() { [0; D] } else { shape };
        let tensor = Tensor::<D>::from_data(TensorData::new(values, shape), self.device);
        Param::initialized(id_of(&name), tensor).set_require_grad(true)
    }
}
