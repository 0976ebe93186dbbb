//! The whole evaluation as one document: what was asked, every set's means, every case.

use serde::Serialize;

use super::{How, Mode, Row, Set, Solver, Summary};

/// The schema name a report carries.
pub const SCHEMA: &str = "kinfold-eval/1";

/// An evaluation in full; lengths in the unit cube, angles in degrees, shares from 0 to 1.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Always [`SCHEMA`].
    pub schema: &'static str,
    /// What was given.
    pub mode: Mode,
    /// Who answered, with version.
    pub articulator: String,
    /// How cases were asked about and measured.
    pub how: How,
    /// Each set's means, sets without cases left out.
    pub sets: Vec<(Set, Summary)>,
    /// Means over all objects.
    pub all: Option<Summary>,
    /// One row per case, by name.
    pub cases: Vec<Row>,
}

impl Report {
    /// Sums up rows.
    pub fn new(solver: &Solver, how: How, cases: Vec<Row>) -> Self {
        let of_set = |set: Set| Some((set, Summary::of_set(&cases, set)?));
        Self {
            schema: SCHEMA,
            mode: solver.mode(),
            articulator: solver.identity(),
            how,
            sets: Set::ALL.into_iter().filter_map(of_set).collect(),
            all: Summary::of_all(&cases),
            cases,
        }
    }

    /// Rows without a prediction.
    pub fn failed(&self) -> impl Iterator<Item = &Row> {
        self.cases.iter().filter(|row| row.error.is_some())
    }

    /// The report as JSON.
    ///
    /// # Errors
    /// [`serde_json::Error`] never in practice: everything in it has a JSON form.
    pub fn to_json(&self) -> Result<String, serde_json::Error> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }

    /// The rows from worst to best, those without a prediction first: by how much of the surface and
    /// how many of the joints are right.
    pub fn worst_first(&self) -> Vec<&Row> {
        let merit = |row: &Row| {
            let scores = row.scores();
            let points = scores.point_iou.unwrap_or(scores.box_iou);
            let joints = scores.joints.found.unwrap_or(1.0);
            if row.error.is_some() { -1.0 } else { points + joints }
        };
        let mut rows: Vec<_> = self.cases.iter().collect();
        rows.sort_by(|a, b| merit(a).total_cmp(&merit(b)).then_with(|| a.case.cmp(&b.case)));
        rows
    }
}
