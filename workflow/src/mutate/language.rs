//! The formats that defects can be planted in.

use sim_check::read::source::Source;

/// What a model is written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Language {
    /// URDF.
    Urdf,
    /// MuJoCo's own.
    Mjcf,
    /// SDFormat.
    Sdf,
}

impl Language {
    /// By the root element.
    pub fn of(source: &Source) -> Option<Self> {
        match source.tag(source.root()) {
            "robot" => Some(Self::Urdf),
            "mujoco" => Some(Self::Mjcf),
            "sdf" => Some(Self::Sdf),
            _ => None,
        }
    }

    /// Its name, as people write it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Urdf => "URDF",
            Self::Mjcf => "MJCF",
            Self::Sdf => "SDF",
        }
    }
}
