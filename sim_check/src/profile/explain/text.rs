//! What is said of one rule.

/// What is said of one rule, as it is written here.
pub(super) struct Text {
    /// The rule's id.
    pub id: &'static str,
    /// What goes wrong where it does not hold.
    pub why: &'static str,
    /// How it is measured, with the bounds of the profile.
    pub how: fn() -> String,
    /// What mends it, the usual remedy last; each with a word of a finding it is for, empty for any.
    pub mend: &'static [(&'static str, &'static str)],
}
