//! Weights of few features, by logistic regression or as means: what is known of parts and surfaces before
//! any forest is asked.

pub mod choice;
pub mod contacts;
pub mod fused_unary;
pub mod roles;
pub mod sizes;

use std::collections::BTreeMap;

use model::classic::learned::pack::{Form, Section};
use object::ArticulatedObject;

use super::data::{Split, Subject, of_families};
use super::recipe::Families;
use super::{Bench, FitError};

/// The seed of our own families; nothing else is made with it.
const FAMILY_SEED: u64 = 56;

/// What `one` makes of the objects that are learned from, and of those that are judged by.
fn read<T: Send>(
    (objects, families): (Option<usize>, &Families),
    bench: &Bench<'_>,
    one: impl Fn(&Subject) -> Vec<T> + Sync,
) -> Result<[Vec<T>; 2], FitError> {
    let mut train = bench.data.of_shards(Split::Train, objects, &one)?;
    train.extend(of_families(families, FAMILY_SEED, &one)?);
    Ok([train, bench.data.of_shards(Split::Validation, objects, &one)?])
}

/// Numbers as a section of a pack.
fn section(name: &str, table: &str, (form, numbers): (Form, &[f64])) -> (Section, Vec<u8>) {
    let bytes = match form {
        Form::Single => numbers.iter().flat_map(|n| (*n as f32).to_le_bytes()).collect(),
        Form::Double | Form::Forest => numbers.iter().flat_map(|n| n.to_le_bytes()).collect(),
    };
    (Section::new(name, table, form), bytes)
}

/// For each of so many segments of a surface, the area of each part in it, m².
fn areas(
    object: &ArticulatedObject,
    segment_of_face: &[u32],
    segments: usize,
) -> Vec<BTreeMap<usize, f64>> {
    let mut areas = vec![BTreeMap::new(); segments];
    for (face, (&segment, &part)) in segment_of_face.iter().zip(object.part_of_face()).enumerate() {
        let area: &mut f64 = areas[segment as usize].entry(usize::from(part)).or_default();
        *area += object.mesh().area(face);
    }
    areas
}

/// The part that most of a segment is of.
fn most(areas: &BTreeMap<usize, f64>) -> Option<usize> {
    areas.iter().max_by(|a, b| a.1.total_cmp(b.1)).map(|m| *m.0)
}
