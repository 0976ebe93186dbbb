//! Where the network computes, by name; the CPU always, accelerators where the build has them.

use burn::tensor::Device;
#[cfg(any(feature = "vulkan", feature = "metal", feature = "cuda"))]
use burn::tensor::DeviceType;

/// A device that cannot be had.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DeviceError {
    /// This build knows none of that name.
    #[error("no device `{0}` in this build, which has {names}; others are cargo features", names = NAMES.join(", "))]
    Unknown(String),
    /// This build could use one, but this machine has none.
    #[error("no device `{0}` on this machine: its driver, or its driver's library, was not found")]
    Missing(&'static str),
}

/// Names of the devices of this build.
pub const NAMES: &[&str] = &[
    "cpu",
    #[cfg(feature = "vulkan")]
    "vulkan",
    #[cfg(feature = "metal")]
    "metal",
    #[cfg(feature = "cuda")]
    "cuda",
];

/// The device of this name, the best or the first of its kind.
///
/// # Errors
/// [`DeviceError`] when this build or this machine has none.
pub fn device(name: &str) -> Result<Device, DeviceError> {
    match name {
        "cpu" => Ok(Device::flex()),
        #[cfg(feature = "vulkan")]
        "vulkan" => found("vulkan", DeviceType::Vulkan, || Device::vulkan(Default::default())),
        #[cfg(feature = "metal")]
        "metal" => found("metal", DeviceType::Metal, || Device::metal(Default::default())),
        #[cfg(feature = "cuda")]
        "cuda" => found("cuda", DeviceType::Cuda, || Device::cuda(0)),
        other => Err(DeviceError::Unknown(other.into())),
    }
}

/// A device, if the machine has any of its kind: without this question, the first operation on one
/// that is missing would end in a panic of its library.
#[cfg(any(feature = "vulkan", feature = "metal", feature = "cuda"))]
fn found(
    name: &'static str,
    kind: DeviceType,
    device: impl FnOnce() -> Device,
) -> Result<Device, DeviceError> {
    if Device::enumerate(kind).is_empty() {
        return Err(DeviceError::Missing(name));
    }
    Ok(device())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cpu_is_always_there_and_others_are_named() {
        assert_eq!(device("cpu"), Ok(Device::flex()));
        let told = device("abacus").unwrap_err().to_string();
        assert!(told.starts_with("no device `abacus` in this build, which has cpu"), "{told}");
    }
}
