//! PartField, the point features Particulate and the paper use: a point cloud becomes three feature
//! planes, and a point's features are the sum of what the planes hold where it projects to.
//!
//! Layer names, shapes and quirks are those of its published checkpoint, so that one runs here.
//!
//! Letters: N points · C plane channels · R plane resolution · T channels out · W transformer width.

mod conv;
mod numbers;
mod planes;
mod sizes;
mod transformer;
mod unet;
mod voxels;

use std::io::{Read, Seek};

use burn::tensor::{Device, Tensor, TensorData};

use super::source::{Builder, Inventory, Source};
use crate::weights::{Extra, FileSource, TensorFile, WeightsError};
use numbers::read;
use planes::{sample, scatter};
pub use sizes::PartFieldSizes;
use transformer::PlaneTransformer;
use unet::PlaneUnet;
use voxels::PointVoxels;

/// Points reach this far from the origin once normalised.
const REACH: f32 = 0.9;

/// The feature extractor.
#[derive(Debug)]
pub struct PartField {
    voxels: PointVoxels,
    unet: PlaneUnet,
    transformer: PlaneTransformer,
    sizes: PartFieldSizes,
}

/// One object's feature planes.
#[derive(Clone, Debug)]
pub struct FeaturePlanes {
    centre: [f32; 3],
    scale: f32,
    values: Vec<f32>,
    sizes: PartFieldSizes,
}

impl PartField {
    /// Builds the extractor from a source of parameters.
    pub fn build(sizes: PartFieldSizes, source: &mut dyn Source, device: &Device) -> Self {
        let b = &mut Builder::new(source, device);
        Self {
            voxels: PointVoxels::new(b.at("pvcnn.pc_encoder.encoder.0"), sizes.channels),
            unet: PlaneUnet::new(b.at("pvcnn.unet_encoder"), sizes.channels, sizes.hidden),
            transformer: PlaneTransformer::new(b.at("triplane_transformer"), &sizes),
            sizes,
        }
    }

    /// Reads a checkpoint in safetensors form with its original keys. Tensors that only its training
    /// used are passed over.
    ///
    /// # Errors
    /// [`WeightsError`]; for tensors that do not fit, with all of them.
    pub fn load<R: Read + Seek>(
        file: &mut TensorFile<R>,
        untold: [usize; 2],
        device: &Device,
    ) -> Result<Self, WeightsError> {
        let sizes = PartFieldSizes::of(file, untold)?;
        let mut inventory = Inventory::default();
        Self::build(sizes, &mut inventory, device);
        file.check(&inventory.parameters, Extra::Ignored)?;
        let mut source = FileSource { file, failure: None };
        let network = Self::build(sizes, &mut source, device);
        source.failure.map_or(Ok(network), Err)
    }

    /// Its sizes.
    pub fn sizes(&self) -> PartFieldSizes {
        self.sizes
    }

    /// Feature planes of an object seen through `points` (any unit; at least one).
    ///
    /// # Errors
    /// [`WeightsError::NotFinite`] if they hold NaN or infinity.
    pub fn encode(
        &self,
        points: &[[f32; 3]],
        device: &Device,
    ) -> Result<FeaturePlanes, WeightsError> {
        let (centre, scale) = normaliser(points);
        let points: Vec<_> = points.iter().map(|p| normalised(*p, centre, scale)).collect();
        let (r, c) = (self.sizes.resolution, self.sizes.channels);
        let scattered = scatter(&points, &self.voxels.forward(&points, device)?, r);
        let rolled = Tensor::<4>::from_data(TensorData::new(scattered, [1, 3, c, r * r]), device);
        let rolled = rolled.swap_dims(1, 2).reshape([1, c, 3 * r, r]);
        let planes = self.transformer.forward(self.unet.forward(rolled));
        Ok(FeaturePlanes { centre, scale, values: read("the planes", planes)?, sizes: self.sizes })
    }
}

impl FeaturePlanes {
    /// The planes themselves [3, T, R, R]: xy, yz, xz; rows by the second coordinate.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// Features of points [N, T − distance], in the frame `encode` saw them in.
    pub fn features(&self, points: &[[f32; 3]]) -> Vec<f32> {
        let points: Vec<_> =
            points.iter().map(|p| normalised(*p, self.centre, self.scale)).collect();
        sample(&self.values, &points, &self.sizes)
    }
}

/// Centre of the box, and the factor that brings its longest side to ±0.9.
fn normaliser(points: &[[f32; 3]]) -> ([f32; 3], f32) {
    let end = |axis: usize, start: f32, pick: fn(f32, f32) -> f32| {
        points.iter().map(|p| p[axis]).fold(start, pick)
    };
    let low: [f32; 3] = std::array::from_fn(|i| end(i, f32::INFINITY, f32::min));
    let high: [f32; 3] = std::array::from_fn(|i| end(i, f32::NEG_INFINITY, f32::max));
    let side = (0..3).map(|i| high[i] - low[i]).fold(f32::MIN_POSITIVE, f32::max);
    (std::array::from_fn(|i| (low[i] + high[i]) * 0.5), 2.0 * REACH / side)
}

fn normalised(p: [f32; 3], centre: [f32; 3], scale: f32) -> [f32; 3] {
    std::array::from_fn(|i| (p[i] - centre[i]) * scale)
}
