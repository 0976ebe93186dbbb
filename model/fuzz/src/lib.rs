//! The readers of foreign files, compiled from the model's own sources without the tensor library
//! beside them, so that the fuzz targets build in a minute.

#[path = "../../src/weights/archive.rs"]
mod archive;
#[path = "../../src/weights/checkpoint.rs"]
mod checkpoint;
#[path = "../../src/weights/convert.rs"]
mod convert;
#[path = "../../src/weights/file.rs"]
mod file;
#[path = "../../src/classic/learned/forest.rs"]
pub mod forest;
#[path = "../../src/classic/learned/pack.rs"]
pub mod pack;
#[path = "../../src/weights/pickle.rs"]
mod pickle;

pub use checkpoint::{ConvertError, Foreign};
pub use convert::convert_checkpoint;
pub use file::{Extra, TensorFile, TensorWriter, WeightsError, Wrong};
