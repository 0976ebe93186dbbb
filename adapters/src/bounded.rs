//! Files that are read whole, up to a number of bytes.

use std::path::Path;

use guard::files::Refused;

use crate::AdapterError;

/// Reads a regular file of at most `limit` bytes; a pipe or a device is not waited for.
pub(crate) fn read_limited(path: &Path, limit: u64) -> Result<Vec<u8>, AdapterError> {
    let io = |source| AdapterError::Io { path: path.display().to_string(), source };
    let other = |expected, found: String| {
        let path = path.display().to_string();
        AdapterError::Format { path, expected, found }
    };
    guard::files::read(path, limit).map_err(|refused| match refused {
        Refused::Open(source) | Refused::Read(source) => io(source),
        Refused::TooLarge { most } => other("a smaller file", format!("more than {most} bytes")),
        _ => other("a regular file", "a folder, a pipe or a device".into()),
    })
}
