//! How far an asset got, and whether a failed check counts.

use serde::{Deserialize, Serialize};

/// How far an asset got. Each tier asks for all below it.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize,
)]
#[serde(rename_all = "lowercase")]
pub enum Tier {
    /// Not even readable.
    #[default]
    None,
    /// Reads as one tree with all its files (F, T).
    Parse,
    /// Units, geometry, mass and joints are sound at rest (U, G, M, J, L).
    Static,
    /// Moves through its ranges without collision (C).
    Kinematic,
    /// Behaves in a simulator (S).
    Dynamic,
    /// Says where it comes from (P).
    Audited,
}

impl Tier {
    /// All tiers, lowest first.
    pub const ALL: [Self; 6] =
        [Self::None, Self::Parse, Self::Static, Self::Kinematic, Self::Dynamic, Self::Audited];

    /// Its name in lower case.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Parse => "parse",
            Self::Static => "static",
            Self::Kinematic => "kinematic",
            Self::Dynamic => "dynamic",
            Self::Audited => "audited",
        }
    }
}

/// Whether a failed check lowers the tier.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// It does.
    Error,
    /// It does not.
    Warning,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiers_stand_in_order_and_are_written_by_their_names() {
        assert!(Tier::ALL.is_sorted());
        for tier in Tier::ALL {
            assert_eq!(serde_json::to_value(tier).unwrap(), tier.name());
        }
    }
}
