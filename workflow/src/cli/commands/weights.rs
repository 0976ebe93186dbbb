//! `kinfold weights`: checkpoints of others in the form the articulation model reads.

use std::fs::{self, File};
use std::io::BufWriter;
use std::path::Path;

use model::weights::{ConvertError, Foreign, convert_checkpoint};

use crate::cli::speech::{Answer, Complaint};

/// Converts a PyTorch checkpoint to safetensors. The result appears whole or not at all.
///
/// # Errors
/// [`Complaint`] when the checkpoint cannot be read, holds more than tensors, or the result cannot
/// be written.
pub fn convert(
    checkpoint: &Path,
    out: Option<&Path>,
    state_dict_only: bool,
) -> Result<Answer, Complaint> {
    let out = out.map_or_else(|| checkpoint.with_extension("safetensors"), Path::to_path_buf);
    let at = |path: &Path| {
        let name = path.display().to_string();
        move |e: std::io::Error| Complaint::failed(format!("{name}: {e}"))
    };
    let reader = File::open(checkpoint).map_err(at(checkpoint))?;
    let unfinished = out.with_extension("safetensors.part");
    let writer = BufWriter::new(File::create(&unfinished).map_err(at(&unfinished))?);
    let foreign = if state_dict_only { Foreign::Opaque } else { Foreign::Refused };
    match convert_checkpoint(reader, writer, foreign) {
        Ok(tensors) => {
            fs::rename(&unfinished, &out).map_err(at(&out))?;
            Ok(Answer::done(format!(
                "{} tensors in {}\n",
                tensors.len(),
                guard::text::shown(&out.to_string_lossy())
            )))
        }
        Err(error) => {
            // The half-written file is of no use to anybody; if it cannot go, the error still counts.
            let _ = fs::remove_file(&unfinished);
            Err(complaint(&error))
        }
    }
}

fn complaint(error: &ConvertError) -> Complaint {
    let told = Complaint::from_error(error);
    match error {
        ConvertError::Foreign(_) => told.hint(
            "a trainer's settings beside the tensors can be passed over with --state-dict-only",
        ),
        _ => told,
    }
}
