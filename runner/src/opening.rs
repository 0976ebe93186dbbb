//! Opens the shared store at an address.

use std::sync::Arc;

use super::address::Address;
#[cfg(feature = "remote")]
use super::bucket::BucketDepot;
use super::depot::{Depot, DepotError, FolderDepot};

impl Address {
    /// Opens the store there. `name` tells this process's unfinished files from others'.
    ///
    /// # Errors
    /// [`DepotError`] for a bucket that is not there, may not be written or keeps no promise.
    pub fn open(&self, name: &str) -> Result<Arc<dyn Depot>, DepotError> {
        match self {
            Self::Folder(root) => Ok(Arc::new(FolderDepot::open(root, name)?)),
            Self::Bucket { .. } => self.open_bucket(),
        }
    }

    #[cfg(feature = "remote")]
    fn open_bucket(&self) -> Result<Arc<dyn Depot>, DepotError> {
        Ok(Arc::new(BucketDepot::open(self)?))
    }

    #[cfg(not(feature = "remote"))]
    fn open_bucket(&self) -> Result<Arc<dyn Depot>, DepotError> {
        Err(DepotError::NotBuilt(self.to_string()))
    }
}
