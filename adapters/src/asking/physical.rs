//! How large an object is and what its parts are made of, and every rule about that answer.

use std::collections::BTreeSet;

use object::condition::{FilePart, FileSize};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::parts::PartAnswer;
use super::repair::Fault;

/// Sizes of objects, metres.
const SIZES: std::ops::RangeInclusive<f64> = 0.005..=20.0;
/// Most that the ends of a guess may lie apart.
const FACTOR: f64 = 5.0;
/// Coefficients of friction.
const FRICTIONS: std::ops::RangeInclusive<f64> = 0.02..=1.5;

/// The answer, as the schema has it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PhysicalAnswer {
    /// One true extent.
    pub scale: Scale,
    /// Each part's material and mass.
    pub parts: Vec<Matter>,
}

/// One true extent of the whole object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scale {
    /// Which.
    pub dimension: Dimension,
    /// Surely no less, metres.
    pub meters_min: f64,
    /// Most likely, metres.
    pub meters_best: f64,
    /// Surely no more, metres.
    pub meters_max: f64,
    /// What it is known from.
    pub basis: String,
}

/// An extent of an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Dimension {
    /// Along the up axis.
    Height,
    /// From side to side.
    Width,
    /// From front to back.
    Depth,
}

/// What a part is made of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Matter {
    /// Which part.
    pub part_id: String,
    /// Its material.
    pub material: Material,
    /// Of the solid material, kg/m³.
    pub density_kg_m3: f64,
    /// How it is built.
    pub construction: Construction,
    /// Of its skin or plate, metres.
    pub wall_thickness_m: Option<f64>,
    /// Surely no less, kg.
    pub mass_kg_min: f64,
    /// Surely no more, kg.
    pub mass_kg_max: f64,
    /// Coefficient of friction at rest.
    pub static_friction: f64,
    /// Coefficient of friction in motion.
    pub dynamic_friction: f64,
}

/// How a part is built.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Construction {
    /// Full of its material.
    Solid,
    /// A skin around nothing.
    HollowShell,
    /// A thin plate.
    Panel,
    /// Some of each.
    Mixed,
}

/// Materials with the densities they come in, kg/m³.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[allow(missing_docs, reason = "each is its own word")]
pub enum Material {
    Wood,
    EngineeredWood,
    Plastic,
    Steel,
    Aluminium,
    Brass,
    Glass,
    Ceramic,
    Stone,
    Rubber,
    Foam,
    Fabric,
    Leather,
    Cardboard,
    ElectronicsMixed,
    Other,
}

impl Material {
    /// The densities it comes in, kg/m³ (ranges of engineering handbooks).
    fn densities(self) -> (f64, f64) {
        match self {
            Self::Wood => (300.0, 1000.0),
            Self::EngineeredWood => (450.0, 900.0),
            Self::Plastic => (880.0, 1500.0),
            Self::Steel => (7600.0, 8100.0),
            Self::Aluminium => (2600.0, 2850.0),
            Self::Brass => (8300.0, 8800.0),
            Self::Glass => (2200.0, 2800.0),
            Self::Ceramic => (1900.0, 4000.0),
            Self::Stone => (2000.0, 3200.0),
            Self::Rubber => (850.0, 1700.0),
            Self::Foam => (10.0, 200.0),
            Self::Fabric | Self::Leather => (100.0, 1100.0),
            Self::Cardboard => (100.0, 800.0),
            Self::ElectronicsMixed => (500.0, 3000.0),
            Self::Other => (10.0, 20_000.0),
        }
    }

    /// Its name in a condition; none for what has none.
    fn name(self) -> Option<String> {
        let word = serde_json::to_value(self).ok()?;
        let known = !matches!(self, Self::Other);
        word.as_str().filter(|_| known).map(|w| w.replace('_', " "))
    }
}

/// Reads an answer and applies every rule; all faults at once.
///
/// # Errors
/// The rules it breaks.
pub fn judged(value: Value, parts: &[PartAnswer]) -> Result<PhysicalAnswer, Vec<Fault>> {
    let answer: PhysicalAnswer = serde_json::from_value(value)
        .map_err(|e| vec![Fault::new("J02", "/".into(), format!("must fit the schema: {e}"))])?;
    let mut faults = scale(&answer.scale);
    for (n, matter) in answer.parts.iter().enumerate() {
        faults.extend(one(matter, n, parts));
    }
    faults.extend(coverage(&answer.parts, parts));
    if faults.is_empty() { Ok(answer) } else { Err(faults) }
}

fn scale(scale: &Scale) -> Vec<Fault> {
    let Scale { meters_min: least, meters_best: best, meters_max: most, .. } = scale;
    let mut faults = guess("/scale", [*least, *best, *most]);
    if ![least, best, most].iter().all(|m| SIZES.contains(*m)) {
        let message = format!("sizes are 0.005 to 20 metres, found {least} to {most}");
        faults.push(Fault::new("Y03", "/scale".into(), message));
    }
    faults
}

/// The rules for a guess between two ends.
fn guess(path: &str, [least, best, most]: [f64; 3]) -> Vec<Fault> {
    let mut faults = vec![];
    if ![least, best, most].iter().all(|v| *v > 0.0) {
        let message = format!("all must be above 0, found {least}, {best}, {most}");
        faults.push(Fault::new("Y01", path.to_owned(), message));
    } else if !(least <= best && best <= most && most / least <= FACTOR) {
        let rule =
            "the least, the best and the most come in this order, at most a factor of 5 apart";
        faults.push(Fault::new(
            "Y02",
            path.into(),
            format!("{rule}, found {least}, {best}, {most}"),
        ));
    }
    faults
}

fn one(matter: &Matter, n: usize, parts: &[PartAnswer]) -> Vec<Fault> {
    let path = |key: &str| format!("/parts/{n}/{key}");
    let (least, most) = (matter.mass_kg_min, matter.mass_kg_max);
    let mut faults = guess(&path("mass_kg_min"), [least, (least + most) / 2.0, most]);
    if !parts.iter().any(|p| p.id == matter.part_id) {
        let message = format!("no part has the id {:?}", matter.part_id);
        faults.push(Fault::new("Y07", path("part_id"), message));
    }
    let (thin, dense) = matter.material.densities();
    let density = matter.density_kg_m3;
    if !(thin..=dense).contains(&density) {
        let message = format!("this material has {thin} to {dense} kg/m³, found {density}");
        faults.push(Fault::new("Y04", path("density_kg_m3"), message));
    }
    if matter.wall_thickness_m.is_some_and(|t| t.is_nan() || t <= 0.0) {
        faults.push(Fault::new("Y01", path("wall_thickness_m"), "must be above 0 or null"));
    }
    let (rest, motion) = (matter.static_friction, matter.dynamic_friction);
    if !(FRICTIONS.contains(&rest) && FRICTIONS.contains(&motion) && motion <= rest) {
        let rule = "frictions are 0.02 to 1.5, in motion no more than at rest";
        let message = format!("{rule}, found {rest} at rest and {motion} in motion");
        faults.push(Fault::new("Y06", path("static_friction"), message));
    }
    faults
}

fn coverage(matters: &[Matter], parts: &[PartAnswer]) -> Vec<Fault> {
    let told: BTreeSet<_> = matters.iter().map(|m| &m.part_id).collect();
    let mut faults = vec![];
    if told.len() != matters.len() {
        faults.push(Fault::new("Y07", "/parts".into(), "a part has one entry, found two"));
    }
    for part in parts.iter().filter(|p| !told.contains(&p.id)) {
        let message = format!("{} has no entry", part.id);
        faults.push(Fault::new("Y07", "/parts".into(), message));
    }
    faults
}

impl PhysicalAnswer {
    /// The true size, as a condition has it.
    pub fn size(&self) -> FileSize {
        let metres = self.scale.meters_best;
        match self.scale.dimension {
            Dimension::Height => FileSize::Height(metres),
            Dimension::Width => FileSize::Width(metres),
            Dimension::Depth => FileSize::Depth(metres),
        }
    }

    /// Writes what is known of a part into its entry. A part that is not solid gets the middle of
    /// its mass: how thick its walls are in the mesh says little of its weight.
    pub fn apply(&self, id: &str, part: &mut FilePart) {
        let Some(matter) = self.parts.iter().find(|m| m.part_id == id) else { return };
        part.material = matter.material.name();
        part.density = Some(matter.density_kg_m3);
        part.friction = Some(matter.dynamic_friction);
        let middle = (matter.mass_kg_min + matter.mass_kg_max) / 2.0;
        part.mass = (matter.construction != Construction::Solid).then_some(middle);
    }
}
