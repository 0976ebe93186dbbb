//! How likely each part is of each face, as the fitted models have it.

use crate::classic::segment::classify::Probabilities;

/// Class probabilities of a surface whose faces fall into regions.
#[derive(Clone, Debug, Default)]
pub(crate) struct Confidence {
    /// The region of each face; empty where nothing was asked.
    pub region_of_face: Vec<u32>,
    /// For each region, how likely each part is, cuts averaged.
    pub rows: Probabilities,
}

impl Confidence {
    /// How likely each face is of the part it was given, 0 to 1; 1 where nothing was asked.
    pub(super) fn of_all(&self, part_of_face: &[u16]) -> Vec<f32> {
        let one = |(face, &part): (usize, &u16)| {
            let row = self.region_of_face.get(face).and_then(|&r| self.rows.get(r as usize));
            let chance = row.map_or(1.0, |row| row.get(usize::from(part)).copied().unwrap_or(0.0));
            chance.clamp(0.0, 1.0)
        };
        part_of_face.iter().enumerate().map(one).collect()
    }
}
