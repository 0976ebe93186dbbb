//! Sizes of a PartField checkpoint, read off its shapes.

use std::io::{Read, Seek};

use crate::weights::{TensorFile, WeightsError};

/// Sizes of a PartField checkpoint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PartFieldSizes {
    /// C, channels of the planes.
    pub channels: usize,
    /// R, pixels along a plane.
    pub resolution: usize,
    /// Channels of the UNet's first level.
    pub hidden: usize,
    /// W, width of the transformer.
    pub width: usize,
    /// Layers of the transformer.
    pub layers: usize,
    /// Attention heads; not to be seen from the weights.
    pub heads: usize,
    /// T, channels of the final planes.
    pub out: usize,
    /// How many of them come first and are a distance field, not features; not to be seen either.
    pub distance: usize,
}

impl PartFieldSizes {
    /// Heads and distance channels of the published checkpoint.
    pub const PUBLISHED: [usize; 2] = [8, 64];

    /// Reads the sizes off a checkpoint's shapes; heads and distance channels it does not tell.
    ///
    /// # Errors
    /// [`WeightsError::Sizes`] if a shape that tells a size is missing or odd.
    pub fn of<R: Read + Seek>(
        file: &TensorFile<R>,
        [heads, distance]: [usize; 2],
    ) -> Result<Self, WeightsError> {
        let odd = |what: String| WeightsError::Sizes(what);
        let shape = |name: &str, rank: usize| {
            let found = file.shape(name).filter(|s| s.len() == rank && s.iter().all(|&n| n > 0));
            found.ok_or_else(|| odd(format!("no tensor `{name}` of rank {rank}")))
        };
        let tokens = shape("triplane_transformer.pos_embed", 3)?;
        let low = (tokens[1] / 3).isqrt();
        let up = shape("triplane_transformer.upsampler.weight", 4)?;
        let layer = |i: &usize| {
            let name = format!("triplane_transformer.transformer.layers.{i}.norm1.weight");
            file.shape(&name).is_some()
        };
        let sizes = Self {
            channels: shape("pvcnn.unet_encoder.conv_final.weight", 4)?[0],
            resolution: 4 * low,
            hidden: shape("pvcnn.unet_encoder.down_convs.0.block.conv1.weight", 4)?[0],
            width: up[0],
            layers: (0..).take_while(layer).count(),
            heads,
            out: up[1],
            distance,
        };
        // Every width of the UNet falls into groups of channels, 32 of them where there are as many.
        let grouped = |times: usize| {
            let channels = times.saturating_mul(sizes.hidden);
            channels.is_multiple_of(channels.min(32))
        };
        let whole = [1, 2, 3, 4, 6].into_iter().all(grouped);
        let split = heads > 0 && sizes.width.is_multiple_of(heads);
        let sound = 3 * low * low == tokens[1] && split && whole;
        let small = sizes.resolution <= 1 << 10 && sizes.width <= 1 << 14 && distance < sizes.out;
        if sound && small { Ok(sizes) } else { Err(odd(format!("{sizes:?}"))) }
    }

    /// Features of a point.
    pub fn features(&self) -> usize {
        self.out - self.distance
    }
}
