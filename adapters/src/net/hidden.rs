//! What stands for something left out, and what of an address need not be left out.

/// What stands where something was left out.
pub const HIDDEN: &str = "<redacted>";

/// Query keys whose values say nothing but what is asked for.
pub(super) const QUERY_KEYS: [&str; 4] = ["filename", "logs", "subfolder", "type"];
