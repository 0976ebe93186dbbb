//! Where the network computes, by name; the CPU always, accelerators where the build has them.

use burn::tensor::Device;

/// A device this build does not have.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no device `{wanted}` in this build, which has {}; others are cargo features", NAMES.join(", "))]
pub struct UnknownDevice {
    /// What was asked for.
    pub wanted: String,
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

/// The device of this name, the first of its kind. Whether the machine has one shows only in use:
/// a driver that is missing ends the first operation in a panic of its library.
///
/// # Errors
/// [`UnknownDevice`] with the names there are.
pub fn device(name: &str) -> Result<Device, UnknownDevice> {
    match name {
        "cpu" => Ok(Device::flex()),
        #[cfg(feature = "vulkan")]
        "vulkan" => Ok(Device::vulkan(Default::default())),
        #[cfg(feature = "metal")]
        "metal" => Ok(Device::metal(Default::default())),
        #[cfg(feature = "cuda")]
        "cuda" => Ok(Device::cuda(0)),
        other => Err(UnknownDevice { wanted: other.into() }),
    }
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
