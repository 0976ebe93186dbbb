//! Why a file is not forecast.

use std::path::PathBuf;

/// A file that was not read, and why.
#[derive(Debug, thiserror::Error)]
#[error("{}: {reason}", path.display())]
pub struct ReadError {
    /// The file.
    pub path: PathBuf,
    /// Why.
    #[source]
    pub reason: Reason,
}

/// Why a file was not read, and what to do about it.
#[derive(Debug, thiserror::Error)]
pub enum Reason {
    /// It is not there, no regular file, or too large.
    #[error("{0}")]
    File(#[from] guard::files::Refused),
    /// It is no text.
    #[error("is no UTF-8 text; save it as UTF-8")]
    Text,
    /// Binary USD.
    #[error("is binary USD, which is not read; `usdcat FILE -o model.usda` writes it as text")]
    Binary,
    /// Declares entities, which could unfold without end.
    #[error("line {line}: declares a document type, which is not read; take the DOCTYPE out")]
    Doctype {
        /// Line, from 1.
        line: u32,
    },
    /// A cap is broken.
    #[error("line {line}: {rule} {most}, found {found}; is it a model file?")]
    TooMuch {
        /// Line, from 1.
        line: u32,
        /// What is counted.
        rule: &'static str,
        /// How many there may be.
        most: usize,
        /// How many there are.
        found: usize,
    },
    /// Broken XML.
    #[error("is no XML: {0}; `kinfold check FILE` says more")]
    Xml(#[from] roxmltree::Error),
    /// XML of another kind.
    #[error("its root is `{found}`: expected `robot` (URDF), `mujoco` (MJCF) or USD text; {}",
            if found == "sdf" { "SDF is not read yet" } else { "is it a model file?" })]
    Root {
        /// The root element.
        found: String,
    },
    /// A number that is none.
    #[error("line {line}: {attribute}=\"{found}\": expected {expected} finite numbers")]
    Number {
        /// Line, from 1.
        line: u32,
        /// The attribute.
        attribute: &'static str,
        /// What stands there, its start.
        found: String,
        /// How many numbers there should be.
        expected: usize,
    },
    /// Broken USD text.
    #[error("line {line}: {what}; `usdchecker FILE` says more")]
    Usda {
        /// Line, from 1.
        line: u32,
        /// What is wrong.
        what: &'static str,
    },
}
