//! How a sample may be changed before it is shown: the settings of augmentation.

use serde::{Deserialize, Serialize};

/// How likely each change is, and how large. Defaults are the paper's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Augment {
    /// Whether objects without spatial words are turned about z by quarters.
    pub turn: bool,
    /// Largest relative change of size.
    pub scale: f64,
    /// Standard deviation of the shift along each axis.
    pub shift: f64,
    /// How likely no normals are shown.
    pub no_normals: f64,
    /// How likely each part is merged into its parent.
    pub merge: f64,
    /// How likely a part's text is dropped.
    pub no_text: f64,
    /// How likely a part's point is dropped; never both, and never the point of a part whose text
    /// another part shares.
    pub no_point: f64,
}

impl Default for Augment {
    fn default() -> Self {
        Self {
            turn: true,
            scale: 0.05,
            shift: 0.05,
            no_normals: 0.3,
            merge: 0.15,
            no_text: 0.2,
            no_point: 0.25,
        }
    }
}

impl Augment {
    /// Nothing is changed and everything is shown, as in validation.
    pub fn none() -> Self {
        let (scale, shift, no_normals) = (0.0, 0.0, 0.0);
        Self { turn: false, scale, shift, no_normals, merge: 0.0, no_text: 0.0, no_point: 0.0 }
    }
}
