//! How a skin is drawn, and how that is written.

use std::str::FromStr;

use object::simplify::Triangles;

use super::error::FuseError;

/// How a skin is drawn. Written `CELLS[:FACES[:OFFSET[:CLEARANCE[:even]]]]`, as in `160:35000:0.85:1.5`.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize)]
#[serde(try_from = "String")]
pub struct Recipe {
    /// Cells of the grid along the object's longest side, 8 to 256.
    pub cells: usize,
    /// How many faces there may be, about.
    pub faces: usize,
    /// How far the skin lies from the surface, in cells, up to 2: above one half, so that no path slips
    /// through a sheet between two nodes.
    pub offset: f64,
    /// Ways that are narrower than twice this many cells, up to 2.5, are shut to what is outside; none if
    /// it is no more than the offset.
    pub clearance: f64,
    /// What triangles decimation leaves.
    pub triangles: Triangles,
}

impl Recipe {
    /// A close skin of as many faces as the grid gives.
    #[must_use]
    pub fn plain(cells: usize) -> Self {
        Self { cells, faces: usize::MAX, offset: 0.55, clearance: 0.0, triangles: Triangles::Any }
    }

    /// Whether a skin can be drawn so.
    ///
    /// # Errors
    /// [`FuseError::Cells`] or [`FuseError::Distances`], with what was found.
    pub(super) fn check(&self) -> Result<(), FuseError> {
        if !(8..=256).contains(&self.cells) {
            return Err(FuseError::Cells(self.cells));
        }
        let is_sound =
            self.offset > 0.5 && self.offset <= 2.0 && (0.0..=2.5).contains(&self.clearance);
        if is_sound { Ok(()) } else { Err(FuseError::Distances(self.offset, self.clearance)) }
    }
}

impl TryFrom<String> for Recipe {
    type Error = FuseError;

    fn try_from(written: String) -> Result<Self, FuseError> {
        written.parse()
    }
}

impl FromStr for Recipe {
    type Err = FuseError;

    fn from_str(written: &str) -> Result<Self, FuseError> {
        let wrong = || FuseError::Recipe(written.to_owned());
        let mut words = written.split(':');
        let cells = words.next().and_then(|w| w.parse().ok()).ok_or_else(wrong)?;
        let mut recipe = Self::plain(cells);
        if let Some(word) = words.next() {
            recipe.faces = word.parse().map_err(|_| wrong())?;
        }
        for distance in [&mut recipe.offset, &mut recipe.clearance] {
            if let Some(word) = words.next() {
                *distance = word.parse().map_err(|_| wrong())?;
            }
        }
        recipe.triangles = match (words.next(), words.next()) {
            (None, _) => Triangles::Any,
            (Some("even"), None) => Triangles::Even,
            _ => return Err(wrong()),
        };
        recipe.check()?;
        Ok(recipe)
    }
}
