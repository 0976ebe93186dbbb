//! How exactly the network multiplies.

use std::str::FromStr;

use super::kernel::tiles;

/// The numbers the large products of inference are made of, on the CPU. Training, and what runs on
/// an accelerator, is always [`Precision::Full`].
///
/// Each is a promise about the result, not about the processor: half precision gives the same bits
/// everywhere, and is only slow where the processor has no tiles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// f32 throughout.
    #[default]
    Full,
    /// Factors rounded to bf16, three digits, and summed as f32, in dense layers of at least 32
    /// inputs and outputs; the rest is f32.
    Half,
}

/// A word that is no precision.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected best, full or half, found `{0}`")]
pub struct PrecisionError(String);

impl FromStr for Precision {
    type Err = PrecisionError;

    fn from_str(text: &str) -> Result<Self, PrecisionError> {
        match text {
            "best" => Ok(Self::best()),
            "full" => Ok(Self::Full),
            "half" => Ok(Self::Half),
            text => Err(PrecisionError(text.into())),
        }
    }
}

impl Precision {
    /// The fastest on this processor: half where it multiplies bf16 tiles (AMX), else full.
    pub fn best() -> Self {
        if tiles::at_hand() { Self::Half } else { Self::Full }
    }
}
