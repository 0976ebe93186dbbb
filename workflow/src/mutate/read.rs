//! A sound model from its file.

use std::path::Path;

use sim_check::checks::kind::found;
use sim_check::read::load;
use sim_check::read::source::Source;
use sim_check::{Asked, CheckOptions, Subject};

use super::language::Language;
use super::model::Model;
use super::needed::complete;

/// What a model was read as.
pub struct Read {
    /// The model.
    pub model: Model,
    /// The text of its file as it stands.
    pub as_it_stands: String,
    /// How many names of files are other ones in the copies.
    pub renamed: usize,
}

/// Reads a model with all the files that it needs.
///
/// # Errors
/// Why no defect can be planted in it.
pub fn read(file: &Path, options: &CheckOptions, seed: u64) -> Result<Read, String> {
    let bytes = load::read_bytes(file, options.outside)?;
    let as_it_stands =
        String::from_utf8(bytes).map_err(|e| format!("the file is not UTF-8: {e}"))?;
    let source = Source::of(&as_it_stands).ok_or("it is no XML that is read here")?;
    let root = source.tag(source.root()).to_owned();
    let language = Language::of(&source)
        .ok_or_else(|| format!("expected <robot>, <mujoco> or <sdf>, found <{root}>"))?;
    if source.is_put_together() {
        return Err("macros or included files make a part of it: expand it into one file".into());
    }
    let loaded = load::read(file, options);
    let faults = loaded.checks.iter().filter(|c| !c.holds()).flat_map(|c| c.evidence.first());
    let why = faults.map(String::as_str).next().unwrap_or("it is not read as one tree").to_owned();
    let robot = loaded.robot.ok_or(why)?;
    let complete = complete(file, &source, language, options)?;
    let source = Source::of(&complete.text).ok_or("its copy is no XML")?;
    let subject = match options.subject {
        Asked::As(subject) => subject,
        Asked::Asset => Subject::Object,
        Asked::Found => found(&robot).subject,
    };
    let model = Model { language, source, robot, subject, needed: complete.files, seed };
    Ok(Read { model, as_it_stands, renamed: complete.renamed })
}
