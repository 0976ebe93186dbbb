//! Weights on disk: safetensors files, read a tensor at a time and checked before anything runs.

mod file;
mod network;

pub(crate) use file::FileSource;
pub use file::{Extra, TensorFile, TensorWriter, WeightsError, Wrong};
pub use network::{Header, load_network, save_network};
