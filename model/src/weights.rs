//! Weights on disk: safetensors files, read a tensor at a time and checked before anything runs.

mod archive;
mod checkpoint;
mod convert;
mod file;
mod network;
mod pickle;
mod source;

pub use checkpoint::{ConvertError, Foreign};
pub use convert::{Converted, convert_checkpoint};
pub use file::{Extra, TensorFile, TensorWriter, WeightsError, Wrong};
pub use network::{Header, load_network, save_network, save_network_half};
pub(crate) use source::FileSource;
