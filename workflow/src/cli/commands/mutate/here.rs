//! The part of `kinfold mutate` that reads what strangers wrote, in a process of its own.

use std::collections::BTreeMap;
use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde::{Deserialize, Serialize};

use super::asked::options;
use crate::cli::args::MutateArgs;
use crate::cli::isolated::answer_once;
use crate::cli::speech::{Answer, Complaint};
use crate::mutate::kinds::KINDS;
use crate::mutate::manifest::NotApplicable;
use crate::mutate::plant::plant;
use crate::mutate::read::read;

/// What the process apart says.
#[derive(Debug, Serialize, Deserialize)]
pub(super) enum Line {
    Made(Box<Made>),
    Complaint(String),
}

/// A model and its defects, on their way to the other process.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Made {
    pub(super) format: String,
    pub(super) renamed: usize,
    /// The text of the copy without a defect.
    pub(super) text: String,
    /// The files it needs.
    pub(super) files: BTreeMap<String, Bytes>,
    pub(super) mutants: Vec<Defect>,
    pub(super) not_applicable: Vec<NotApplicable>,
}

/// One defect.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Defect {
    pub(super) kind: String,
    pub(super) subject: String,
    pub(super) line: u32,
    pub(super) change: String,
    pub(super) text: String,
    pub(super) files: BTreeMap<String, Bytes>,
}

/// What stands in a file, in base64.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Bytes(String);

impl Bytes {
    fn of(bytes: &[u8]) -> Self {
        Self(STANDARD.encode(bytes))
    }

    /// The bytes; none where the other process wrote no base64.
    pub(super) fn bytes(&self) -> Option<Vec<u8>> {
        STANDARD.decode(&self.0).ok()
    }
}

/// One line for the process that asked: the defects, or why none can be planted.
///
/// # Errors
/// [`Complaint`] when this process cannot be bounded.
pub(super) fn answer(file: &Path, args: &MutateArgs) -> Result<Answer, Complaint> {
    answer_once().map_err(|e| Complaint::failed(format!("this process cannot be bounded: {e}")))?;
    let line = match made(file, args) {
        Ok(made) => Line::Made(Box::new(made)),
        Err(why) => Line::Complaint(format!("{}: {why}", file.display())),
    };
    let line = serde_json::to_string(&line).map_err(|e| Complaint::from_error(&e))?;
    Ok(Answer::done(line + "\n"))
}

fn made(file: &Path, args: &MutateArgs) -> Result<Made, String> {
    let read = read(file, &options(args), args.seed)?;
    let model = &read.model;
    let wanted = |id: &str| args.kinds.is_empty() || args.kinds.iter().any(|k| k == id);
    let (mut mutants, mut not_applicable) = (Vec::new(), Vec::new());
    for kind in KINDS.iter().filter(|k| wanted(k.id)) {
        match plant(kind, model) {
            Ok((planted, text)) => mutants.push(Defect {
                kind: kind.id.into(),
                subject: planted.subject,
                line: planted.line,
                change: planted.words,
                text,
                files: planted.files.into_iter().map(|(to, b)| (to, Bytes::of(&b))).collect(),
            }),
            Err(why) => not_applicable.push(NotApplicable { kind: kind.id.into(), why }),
        }
    }
    let files = model.needed.iter().map(|n| (n.to.clone(), Bytes::of(&n.bytes)));
    Ok(Made {
        format: model.language.name().into(),
        renamed: read.renamed,
        text: model.source.whole().to_owned(),
        files: files.collect(),
        mutants,
        not_applicable,
    })
}
