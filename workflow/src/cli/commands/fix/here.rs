//! The part of `kinfold fix` that reads what strangers wrote, in a process of its own.

use std::path::Path;
use std::time::Instant;

use asset::collision::hulls::decompose;
use object::Mesh;

use super::asked::{options, wanted};
use super::told::{Line, Made};
use crate::cli::args::FixArgs;
use crate::cli::isolated::answer_once;
use crate::cli::speech::{Answer, Complaint};
use crate::fix::run::{Job, NoFix, fix};

/// Share of the time in which changes are tried; the rest is for the check that is under way.
const TRYING: f64 = 2.0 / 3.0;
/// Most faces of a mesh that is split: finding pieces takes a second for 40,000 (measured).
const MOST_FACES: usize = 400_000;

/// One line for the process that asked: a model before and after, or why there is none.
///
/// # Errors
/// [`Complaint`] when this process cannot be bounded.
pub(super) fn answer(file: &Path, args: &FixArgs) -> Result<Answer, Complaint> {
    answer_once().map_err(|e| Complaint::failed(format!("this process cannot be bounded: {e}")))?;
    let (options, wanted) = (options(args), wanted(args));
    let job = Job { file, options: &options, wanted: &wanted, split: &split };
    let until = Instant::now() + args.deadline.mul_f64(TRYING);
    let line = match fix(&job, until) {
        Ok(fixed) => Line::Made(Box::new(Made::of(fixed))),
        Err(NoFix::Unreadable(why)) => Line::Complaint {
            message: format!("{}: {why}", file.display()),
            hints: vec!["`kinfold check` says what is wrong with it".into()],
        },
        Err(why @ NoFix::Format(_)) => Line::Complaint {
            message: format!("{}: {why}", file.display()),
            hints: vec![
                "`kinfold check` says what is wrong with it, and how to mend it by hand".into(),
            ],
        },
    };
    let line = serde_json::to_string(&line).map_err(|e| Complaint::from_error(&e))?;
    Ok(Answer::done(line + "\n"))
}

/// A mesh as convex meshes, as `kinfold make` splits links.
fn split(mesh: &Mesh, tolerance: f64) -> Result<Vec<Mesh>, String> {
    let faces = mesh.faces().len();
    if faces > MOST_FACES {
        return Err(format!("it has {faces} faces, and meshes of at most {MOST_FACES} are split"));
    }
    let pieces = decompose(mesh, tolerance).map_err(|e| e.to_string())?;
    let made =
        pieces.into_iter().map(|p| Mesh::new(p.vertices, p.faces).map_err(|e| e.to_string()));
    made.collect()
}
