//! What is ours on disk: the marker by which a folder of ours is known, the lock that lets one
//! process at a time write into it, and the step by which a new folder takes an old one's place.

pub mod files;
pub mod lock;
pub mod looking;
pub mod marker;
pub mod scratch;
pub mod swap;

pub use files::{create, name, sync_folder, write_synced};
pub use lock::{Holder, Lock, LockError, Turns};
pub use marker::{Kind, Marker, Whose};
