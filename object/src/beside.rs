//! Files that lie beside a mesh file and that it names: who reads them decides what may be read.

/// A file that was found beside another.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Found {
    /// Where, below the folder of the file that names it.
    pub name: String,
    /// What is in it.
    pub bytes: Vec<u8>,
}

/// Gives a file by the path that a mesh file has for it, or why it cannot be had, as the rest of a sentence:
/// "is not there".
pub type Beside<'a> = &'a mut dyn FnMut(&str) -> Result<Found, String>;
