//! Which checks depend on what could not be read.

/// Checks that need to know what a link weighs.
pub(crate) const WEIGHED: &[&str] =
    &["M1", "M2", "M3", "M4", "M5", "M6", "J7", "S1", "S2", "S3", "S4", "S5"];
/// Checks that need to know what a joint is.
pub(crate) const JOINTED: &[&str] = &["J1", "J2", "J3", "J4"];
/// Checks that need to know where a link stands.
pub(crate) const PLACED: &[&str] =
    &["U2", "U3", "G4", "J5", "J7", "C1", "C2", "C3", "C4", "C5", "S1", "S2", "S3", "S4", "S5"];
/// Checks that move joints.
pub(crate) const MOVED: &[&str] = &["C2", "C3", "C4", "C5", "S1", "S2", "S3", "S4", "S5"];
/// Checks that need to know all that stands around.
pub(crate) const AROUND: &[&str] = &["G4", "C1", "C2", "C3", "S1", "S2", "S3"];
