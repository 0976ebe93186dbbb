//! What is looked at while a model is mended, and what a way offers to change.

use std::path::{Path, PathBuf};

use sim_check::read::load::{self, Edition};
use sim_check::read::source::{At, Edit, Source};
use sim_check::robot::Format;
use sim_check::{CheckOptions, Robot, Verdict};

use super::remedies::{Wanted, Way};

/// A mesh as convex meshes, given how far pieces and surface may lie apart, metres.
pub type Split = dyn Fn(&object::Mesh, f64) -> Result<Vec<object::Mesh>, String> + Sync;

/// What is asked.
pub struct Job<'a> {
    /// The model's file.
    pub file: &'a Path,
    /// How it is checked.
    pub options: &'a CheckOptions,
    /// What is to be mended.
    pub wanted: &'a Wanted,
    /// How a mesh is split.
    pub split: &'a Split,
}

/// A model as it stands after the changes so far.
pub(super) struct State {
    pub edition: Edition,
    pub source: Source,
    pub robot: Robot,
    pub verdict: Verdict,
    /// Files that changes so far need.
    pub files: Vec<NewFile>,
}

/// A new file that a change needs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NewFile {
    /// As the model names it.
    pub name: String,
    /// Where it is to stand.
    pub path: PathBuf,
    /// What stands in it.
    pub bytes: Vec<u8>,
}

/// A change: edits of the text, and the files they need.
#[derive(Clone, Debug, Default)]
pub(super) struct Change {
    /// In words, without a full stop.
    pub words: String,
    pub edits: Vec<Edit>,
    pub files: Vec<NewFile>,
}

/// What a way says about one joint, link or mesh.
pub(super) struct Offer {
    pub way: Way,
    /// What it is about, such as "joint `hinge`".
    pub subject: String,
    pub line: u32,
    /// Changes to try, the best first, or why there is none.
    pub changes: Result<Vec<Change>, String>,
}

impl State {
    pub(super) fn is_urdf(&self) -> bool {
        self.robot.format == Format::Urdf
    }

    /// The only element of that name and `name`, else the only one on that line.
    pub(super) fn element(&self, tag: &str, name: &str, line: u32) -> Result<At, String> {
        let named = self.source.named(tag, name);
        let on_line = || self.source.on_line(tag, line).filter(|_| !self.is_urdf());
        let found = named.or_else(on_line).filter(|at| self.source.line(*at) == line);
        found.ok_or_else(|| self.elsewhere(tag, line))
    }

    /// Why an element cannot be mended here.
    pub(super) fn elsewhere(&self, tag: &str, line: u32) -> String {
        match self.source.is_put_together() {
            true => format!(
                "<{tag}> of line {line} comes from a macro or an included file: mend it there"
            ),
            false => format!("<{tag}> of line {line} is not the only one of its name there"),
        }
    }

    /// Where a mesh that the model names stands, or is to stand, and what is in it.
    pub(super) fn mesh_file(&self, job: &Job, name: &str) -> Result<(PathBuf, Vec<u8>), String> {
        match self.files.iter().find(|f| f.name == name) {
            Some(file) => Ok((file.path.clone(), file.bytes.clone())),
            None => load::mesh_file(job.file, name, job.options),
        }
    }

    /// The diagonal of the model at rest, metres.
    pub(super) fn diagonal(&self) -> f64 {
        self.verdict.check("U2").and_then(|c| c.value).filter(|d| *d > 0.0).unwrap_or(1.0)
    }
}

/// The word in back quotes after another, such as a joint's name.
pub(super) fn quoted<'t>(text: &'t str, after: &str) -> Option<&'t str> {
    let from = text.find(&format!("{after} `"))? + after.len() + 2;
    let rest = &text[from..];
    rest.find('`').map(|end| &rest[..end])
}

/// Names in back quotes after a word in these findings, each once, in order of first mention.
pub(super) fn names<'t>(findings: &[(&str, &'t str)], after: &str) -> Vec<&'t str> {
    let mut all: Vec<&str> = Vec::new();
    for name in findings.iter().filter_map(|(_, finding)| quoted(finding, after)) {
        if !all.contains(&name) {
            all.push(name);
        }
    }
    all
}
