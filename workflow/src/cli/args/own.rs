//! Whom a program that uses this house brings itself.

use std::fmt;
use std::sync::Arc;

use adapters::{ImageTo3d, Vlm};

/// Who is asked in place of files and of whom `kinfold.toml` names; on a command line it is nobody.
#[derive(Clone, Default)]
pub struct Own {
    /// Makes the mesh.
    pub image_to_3d: Option<Arc<dyn ImageTo3d>>,
    /// Says what the parts are.
    pub vlm: Option<Arc<dyn Vlm>>,
}

impl fmt::Debug for Own {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let is_there = [self.image_to_3d.is_some(), self.vlm.is_some()];
        f.debug_tuple("Own").field(&is_there).finish()
    }
}
