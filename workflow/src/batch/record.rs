//! What became of an item: a row of the ledger and of `index.parquet`, column by column.

use std::collections::BTreeMap;

use rusqlite::types::Value;
use serde::{Deserialize, Serialize};
use trace::{Digest, Time};

use super::class::Class;

/// What sort of value a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Text in UTF-8.
    Text,
    /// A whole number of 64 bits.
    Integer,
    /// A number in double precision.
    Real,
}

/// Columns of the ledger and of the index, in order; any but `id` and `outcome` may be empty.
pub const COLUMNS: [(&str, Kind); 35] = [
    ("id", Kind::Text),
    ("line", Kind::Integer),
    ("category", Kind::Text),
    ("license", Kind::Text),
    ("seed", Kind::Integer),
    ("outcome", Kind::Text),
    ("class", Kind::Text),
    ("stage", Kind::Text),
    ("reason", Kind::Text),
    ("verdict", Kind::Text),
    ("failed_checks", Kind::Text),
    ("provider", Kind::Text),
    ("condition_provider", Kind::Text),
    ("articulator", Kind::Text),
    ("calls", Kind::Integer),
    ("cost", Kind::Real),
    ("links", Kind::Integer),
    ("joints", Kind::Integer),
    ("bytes", Kind::Integer),
    ("seconds_generate_mesh", Kind::Real),
    ("seconds_render_views", Kind::Real),
    ("seconds_propose_condition", Kind::Real),
    ("seconds_articulate", Kind::Real),
    ("seconds_build_asset", Kind::Real),
    ("seconds_write", Kind::Real),
    ("seconds_check_in_sim", Kind::Real),
    ("stages_run", Kind::Integer),
    ("stages_recalled", Kind::Integer),
    ("photo", Kind::Text),
    ("mesh", Kind::Text),
    ("urdf", Kind::Text),
    ("trace", Kind::Text),
    ("attestation", Kind::Text),
    ("look", Kind::Text),
    ("at_ns", Kind::Integer),
];

/// The column of the index that is in none of the ledger's rows, but in their facts.
pub const CONFIDENCE: &str = "confidence";

/// How an item ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Ended {
    /// An asset of the tier asked for, whole.
    Accepted,
    /// An asset, but below the tier or with a loss: it lies in quarantine.
    Rejected,
    /// No asset.
    Failed,
    /// Its outcome no longer counts, because bytes it names were lost.
    Reopened,
}

impl Ended {
    /// Its name in lower case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Accepted => "accepted",
            Self::Rejected => "rejected",
            Self::Failed => "failed",
            Self::Reopened => "reopened",
        }
    }
}

/// What became of an item.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Record {
    /// The item.
    pub id: String,
    /// Its line in the manifest.
    pub line: u64,
    /// What it is, as the manifest says.
    pub category: Option<String>,
    /// Licence of the photo, as the manifest says.
    pub license: Option<String>,
    /// Seed of everything random.
    pub seed: u64,
    /// How it ended.
    pub outcome: Ended,
    /// What the failure is a failure of; none of an accepted asset.
    pub class: Option<String>,
    /// The stage that failed.
    pub stage: Option<String>,
    /// Why, in a line.
    pub reason: Option<String>,
    /// The tier reached, where there is an asset.
    pub verdict: Option<String>,
    /// Ids of the checks that count against it, with spaces between.
    pub failed_checks: Option<String>,
    /// Who made the mesh: the first word of its identity.
    pub provider: Option<String>,
    /// Who made the condition: the first word of its identity.
    pub condition_provider: Option<String>,
    /// Who fitted the joints.
    pub articulator: Option<String>,
    /// Requests that may cost and programs that were started, of every try.
    pub calls: u64,
    /// What they cost at the prices given.
    pub cost: f64,
    /// Links of the asset.
    pub links: Option<u64>,
    /// Moving joints of the asset.
    pub joints: Option<u64>,
    /// Size of its folder, bytes.
    pub bytes: Option<u64>,
    /// Seconds of each stage that ran this time; recalled ones are left out.
    pub seconds: BTreeMap<String, f64>,
    /// Stages that ran.
    pub stages_run: u64,
    /// Stages whose result was there.
    pub stages_recalled: u64,
    /// Digests by name: `photo`, `mesh`, `urdf`, `trace`, `attestation`.
    pub digests: BTreeMap<String, Digest>,
    /// How likely every part and joint is right, 0 to 1; none where the asset does not say.
    #[serde(default)]
    pub confidence: Option<f64>,
    /// How it looks: hashes of two pictures of it, for near-duplicates.
    pub look: Option<String>,
    /// When.
    pub at_ns: Time,
    /// Digest of every artefact it rests on, so that the store keeps them.
    pub artefacts: Vec<Digest>,
    /// Digest of every file of the asset, by path.
    pub files: BTreeMap<String, Digest>,
}

impl Record {
    /// A record that knows its item alone.
    pub fn new(id: impl Into<String>, outcome: Ended) -> Self {
        Self {
            id: id.into(),
            line: 0,
            category: None,
            license: None,
            seed: 0,
            outcome,
            class: None,
            stage: None,
            reason: None,
            verdict: None,
            failed_checks: None,
            provider: None,
            condition_provider: None,
            articulator: None,
            calls: 0,
            cost: 0.0,
            links: None,
            joints: None,
            bytes: None,
            seconds: BTreeMap::new(),
            stages_run: 0,
            stages_recalled: 0,
            digests: BTreeMap::new(),
            confidence: None,
            look: None,
            at_ns: 0,
            artefacts: Vec::new(),
            files: BTreeMap::new(),
        }
    }

    /// The class of its failure.
    pub fn class(&self) -> Option<Class> {
        Class::ALL.into_iter().find(|c| self.class.as_deref() == Some(c.name()))
    }

    /// Whether this outcome stands until somebody asks again.
    pub fn is_final(&self) -> bool {
        self.outcome != Ended::Reopened && !self.class().is_some_and(Class::passes)
    }

    /// The value of a column.
    pub fn value(&self, column: &str) -> Value {
        let text = |t: &Option<String>| t.clone().map_or(Value::Null, Value::Text);
        let number = |n: Option<u64>| n.map_or(Value::Null, |n| Value::Integer(signed(n)));
        match column {
            "id" => Value::Text(self.id.clone()),
            "line" => number(Some(self.line)),
            "category" => text(&self.category),
            "license" => text(&self.license),
            "seed" => number(Some(self.seed)),
            "outcome" => Value::Text(self.outcome.name().into()),
            "class" => text(&self.class),
            "stage" => text(&self.stage),
            "reason" => text(&self.reason),
            "verdict" => text(&self.verdict),
            "failed_checks" => text(&self.failed_checks),
            "provider" => text(&self.provider),
            "condition_provider" => text(&self.condition_provider),
            "articulator" => text(&self.articulator),
            "calls" => number(Some(self.calls)),
            "cost" => real(self.cost),
            "links" => number(self.links),
            "joints" => number(self.joints),
            "bytes" => number(self.bytes),
            "stages_run" => number(Some(self.stages_run)),
            "stages_recalled" => number(Some(self.stages_recalled)),
            "look" => text(&self.look),
            CONFIDENCE => self.confidence.map_or(Value::Null, real),
            "at_ns" => number(Some(self.at_ns)),
            name => self.found(name),
        }
    }

    /// The value of a column whose name says where it is found: seconds and digests.
    fn found(&self, column: &str) -> Value {
        if let Some(stage) = column.strip_prefix("seconds_") {
            return self.seconds_of(stage).map_or(Value::Null, real);
        }
        self.digests.get(column).map_or(Value::Null, |d| Value::Text(d.to_string()))
    }

    /// Seconds of a stage, those it is done in together: shapes count as the asset's, every format as
    /// writing.
    fn seconds_of(&self, stage: &str) -> Option<f64> {
        let stage = stage.replace('_', "-");
        let own = |name: &str| match stage.as_str() {
            "write" => name.starts_with("write-"),
            "build-asset" => name == stage || name == "shape-parts",
            _ => name == stage,
        };
        let times: Vec<_> = self.seconds.iter().filter(|(name, _)| own(name)).collect();
        (!times.is_empty()).then(|| times.into_iter().map(|(_, s)| s).sum())
    }
}

/// A number as it comes back from SQLite, which knows neither a negative nought nor no number.
fn real(number: f64) -> Value {
    if number.is_finite() { Value::Real(number + 0.0) } else { Value::Null }
}

/// SQLite and Parquet have no unsigned numbers; what does not fit is cut.
pub(super) fn signed(number: u64) -> i64 {
    i64::try_from(number).unwrap_or(i64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_column_finds_its_value() {
        let mut record = Record::new("kettle", Ended::Accepted);
        record.seconds = [("write-urdf".into(), 1.0), ("write-usd".into(), 0.5)].into();
        record.digests.insert("trace".into(), Digest::of(b"t"));
        assert_eq!(record.value("seconds_write"), Value::Real(1.5));
        record.seconds.extend([("shape-parts".into(), 2.0), ("build-asset".into(), 0.5)]);
        assert_eq!(record.value("seconds_build_asset"), Value::Real(2.5));
        assert_eq!(record.value("seconds_articulate"), Value::Null);
        record.cost = -0.0;
        let Value::Real(cost) = record.value("cost") else { panic!("no number") };
        assert!(cost.is_sign_positive(), "it would not come back as it went in");
        assert_eq!(record.value("trace"), Value::Text(Digest::of(b"t").to_string()));
        assert!(COLUMNS.iter().all(|(name, _)| record.value(name) != Value::Integer(-1)));
    }

    #[test]
    fn what_passes_is_not_final() {
        let mut record = Record::new("kettle", Ended::Failed);
        for (class, settled) in [("transient", false), ("budget", false), ("geometry", true)] {
            record.class = Some(class.into());
            assert_eq!(record.is_final(), settled, "{class}");
        }
        assert!(!Record::new("kettle", Ended::Reopened).is_final());
    }
}
