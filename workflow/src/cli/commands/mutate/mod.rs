//! `kinfold mutate`: defects of known kinds, planted in copies of a sound model.

mod list;

use crate::cli::args::MutateArgs;
use crate::cli::speech::{Answer, Complaint};

/// Plants defects, or lists their kinds.
///
/// # Errors
/// [`Complaint`] when there is no such file, it is no sound model, or the folder cannot be written.
pub fn mutate(args: &MutateArgs) -> Result<Answer, Complaint> {
    if args.list {
        return Ok(Answer::done(list::list(args.json)));
    }
    Err(Complaint::failed("nothing is planted yet"))
}
