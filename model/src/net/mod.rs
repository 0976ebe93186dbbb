//! The articulation transformer: the paper's network, its predecessor, the encoders others
//! published, and their arithmetic.
//!
//! ```
//! use burn::tensor::Device;
//! use model::net::{Config, Network};
//!
//! let sizes = Config { width: 16, heads: 2, blocks: 1, tokens: 8, ..Config::small() };
//! let network = Network::new(&sizes, 7, &Device::flex().autodiff())?;
//! assert_eq!(network.config().width, 16);
//! # Ok::<(), model::net::ConfigError>(())
//! ```

pub mod batch;
mod block;
pub mod clip;
pub mod config;
pub mod device;
pub mod embed;
pub mod error;
pub mod heads;
pub mod infer;
pub(crate) mod kernel;
pub mod layers;
pub mod network;
pub(crate) mod op;
pub(crate) mod ops;
pub mod partfield;
pub mod particulate;
pub mod precision;
pub mod source;
mod watch;

#[cfg(test)]
mod tests;

pub use batch::{Example, JointQuestion, PartPrompt};
pub use config::{Config, ConfigError, Positions};
pub use device::{DeviceError, device};
pub use embed::{Cloud, Points};
pub use error::{BatchError, NetworkError};
pub use heads::{JointCase, JointRows, MotionType};
pub use infer::{Labels, Question, Vote};
pub use network::{Answer, Batch, Memory, Network, Prompts};
pub use precision::Precision;
