//! `kinfold weights`: checkpoints of others in the form the articulation model reads.

use std::fs::{self, File};
use std::io::BufWriter;
use std::path::Path;

use model::weights::{ConvertError, Foreign, convert_checkpoint};

use model::classic::learned::pack::Ensemble;
use model::classic::learned::pack::Origin;
use model::classic::learned::pack::Pack;
use model::classic::learned::pack::Table;

use crate::cli::speech::{Answer, Complaint};

/// Most bytes of a pack; a guess, some two hundred times the largest that ships.
const MOST: u64 = 1 << 30;

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

/// Tells what a pack holds, which features it asks about and where it came from.
///
/// # Errors
/// [`Complaint`] when the file cannot be read or is no pack.
pub fn show(file: &Path, json: bool) -> Result<Answer, Complaint> {
    let shown = file.display().to_string();
    let bytes =
        guard::files::read(file, MOST).map_err(|e| Complaint::failed(format!("{shown}: {e}")))?;
    let pack = Pack::open(&shown, &bytes).map_err(|e| {
        Complaint::from_error(&e).hint("packs that ship lie in model/weights and end in .pack")
    })?;
    let head = &pack.head;
    if json {
        let told = serde_json::to_string_pretty(head);
        let told = told.map_err(|e| Complaint::failed(format!("{shown}: {e}")))?;
        return Ok(Answer::done(told + "\n"));
    }
    let mut said =
        format!("{}: {} sections, {} bytes\n", head.kind, head.sections.len(), bytes.len());
    for Table { name, features } in &head.tables {
        said +=
            &format!("asks about {} features ({name}): {}\n", features.len(), features.join(", "));
    }
    for (place, Ensemble { folds, rounds }) in head.ensembles.iter().enumerate() {
        said += &format!("ensemble {place}: {folds} folds, {rounds} rounds\n");
    }
    for (name, value) in &head.settings {
        said += &format!("{name}: {value}\n");
    }
    let Origin { recipe, commit, data, metrics, remark } = &head.origin;
    said += &format!("fitted by commit: {}\n", commit.as_deref().unwrap_or("not recorded"));
    for (name, value) in metrics {
        said += &format!("at fit, {name}: {value}\n");
    }
    for (name, digest) in data {
        said += &format!("fitted on: {name} {digest}\n");
    }
    said.extend(remark.iter().map(|remark| format!("remark: {remark}\n")));
    said.extend(recipe.iter().map(|recipe| format!("recipe:\n{recipe}")));
    Ok(Answer::done(said))
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
