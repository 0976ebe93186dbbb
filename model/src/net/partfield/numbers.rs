//! Numbers read back from the device.

use burn::tensor::Tensor;

use crate::weights::WeightsError;

/// The numbers of a tensor; `what` it is stands in errors.
///
/// # Errors
/// [`WeightsError::NotFinite`] if one is NaN or infinity, [`WeightsError::Format`] if they cannot be read.
pub(super) fn read<const D: usize>(what: &str, x: Tensor<D>) -> Result<Vec<f32>, WeightsError> {
    let values = x.into_data().try_into_vec::<f32>();
    let values = values.map_err(|e| WeightsError::Format(format!("{what}: {e:?}")))?;
    let sound = values.iter().all(|v| v.is_finite());
    sound.then_some(values).ok_or_else(|| WeightsError::NotFinite(what.into()))
}
