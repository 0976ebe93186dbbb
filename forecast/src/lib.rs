//! What eight clients will do with a model file, said without running them.
//!
//! Every sentence comes from a written rule: [`RULES`] is the table of all of them, each with the
//! version it was measured with and its source. A file is read once ([`read::read`]) and every rule
//! of the clients asked for looks at it ([`forecast`]). A rule that is silent promises nothing: the
//! rules are what is known, not all there is.
//!
//! ```
//! use forecast::{Client, Outside, forecast};
//! let folder = tempfile::tempdir()?;
//! let path = folder.path().join("m.urdf");
//! std::fs::write(&path, "<robot name='m'><link name='a'><visual><geometry>\
//!     <sphere radius='1'/></geometry></visual></link></robot>")?;
//! let said = forecast(&path, &[Client::Mujoco], Outside::Refused)?;
//! assert!(said[0].findings.iter().any(|f| f.rule == "mujoco.visuals-dropped"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod client;
mod find;
mod foresee;
pub mod read;
pub mod rule;
mod rules;
pub mod table;

pub use client::{Client, UnknownClient};
pub use foresee::{Finding, Forecast, MAX_PLACES, forecast};
pub use read::{Outside, ReadError};
pub use rule::{Place, Rule, Severity, Source};
pub use rules::RULES;
