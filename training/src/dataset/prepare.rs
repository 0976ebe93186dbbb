//! Measures objects once: in the pose they come in, in random poses, and as one closed skin.

use std::path::{Path, PathBuf};

use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

use super::pose::{posed, random_configuration};
use super::sample::{Counts, Sample};
use super::{DataError, Specimen, cache};
use crate::fuse::{Recipe, fused};

/// Changes whenever samples may come out differently.
const VERSION: u32 = 1;
/// Grid cells along the longest side of a fused object: coarsest and finest.
const CELLS: [u64; 2] = [64, 112];

/// One way to look at an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variant {
    /// As it comes.
    Rest,
    /// In its n-th random pose.
    State(usize),
    /// As one closed skin, the n-th time: first as it comes, then in random poses.
    Fused(usize),
}

impl Variant {
    /// Every variant, with this many random poses and skins.
    pub fn all(states: usize, fused: usize) -> Vec<Self> {
        let states = (1..=states).map(Self::State);
        std::iter::once(Self::Rest).chain(states).chain((0..fused).map(Self::Fused)).collect()
    }

    fn name(self) -> String {
        match self {
            Self::Rest => "rest".into(),
            Self::State(n) => format!("state-{n}"),
            Self::Fused(n) => format!("fused-{n}"),
        }
    }
}

/// Where samples are kept and how they are measured.
#[derive(Clone, Debug)]
pub struct Shelf {
    folder: PathBuf,
    counts: Counts,
    seed: u64,
}

impl Shelf {
    /// A folder below `cache` for a source of this name; another one for other settings.
    ///
    /// # Errors
    /// [`DataError`] when it cannot be created.
    pub fn open(cache: &Path, name: &str, counts: Counts, seed: u64) -> Result<Self, DataError> {
        use model::features::PointFeatures;
        let encoder = model::features::GeometricFeatures.identity();
        let settings = format!("{VERSION} {encoder} {counts:?} {seed}");
        let digest = blake3::hash(settings.as_bytes()).to_hex();
        let folder = cache.join(format!("{name}-{}", &digest[..12]));
        std::fs::create_dir_all(&folder).map_err(DataError::io(&folder))?;
        Ok(Self { folder, counts, seed })
    }

    /// Where a variant of an object is kept.
    pub fn place(&self, id: &str, variant: Variant) -> PathBuf {
        self.folder.join(format!("{id}.{}.safetensors", variant.name()))
    }

    /// Where it says why there is no such variant.
    fn excuse(&self, id: &str, variant: Variant) -> PathBuf {
        self.folder.join(format!("{id}.{}.left-out", variant.name()))
    }

    /// Whether everything that can be known about a variant is on disk.
    pub fn is_settled(&self, id: &str, variant: Variant) -> bool {
        self.place(id, variant).exists() || self.excuse(id, variant).exists()
    }

    /// Measures the variants of an object that are not on disk. A variant that cannot be made is
    /// left out, and a file says why.
    ///
    /// # Errors
    /// [`DataError`] of the disk alone.
    pub fn fill(
        &self,
        id: &str,
        specimen: Result<&Specimen, &str>,
        variants: &[Variant],
    ) -> Result<(), DataError> {
        for &variant in variants.iter().filter(|&&v| !self.is_settled(id, v)) {
            let sample = specimen.map_err(String::from).and_then(|s| self.measure(s, variant));
            match sample {
                Ok(sample) => cache::write(&sample, &self.place(id, variant))?,
                Err(why) => {
                    let path = self.excuse(id, variant);
                    cache::write_whole(&path, why.as_bytes()).map_err(DataError::io(&path))?;
                }
            }
        }
        Ok(())
    }

    fn measure(&self, specimen: &Specimen, variant: Variant) -> Result<Sample, String> {
        let seed = seed_of(self.seed, &specimen.id, variant);
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let stands = match variant {
            Variant::Rest | Variant::Fused(0) => specimen.object.clone(),
            Variant::State(_) | Variant::Fused(_) => {
                let q = random_configuration(&specimen.object, &mut rng);
                posed(&specimen.object, &q).map_err(|e| e.to_string())?
            }
        };
        let wordings = specimen.wordings.clone();
        let mut specimen = Specimen { id: specimen.id.clone(), object: stands, wordings };
        if let Variant::Fused(_) = variant {
            let cells = CELLS[0] + seed % (CELLS[1] - CELLS[0] + 1);
            let recipe = Recipe::plain(cells as usize);
            specimen = fused(&specimen, &recipe).map_err(|e| e.to_string())?;
        }
        Sample::of(&specimen, self.counts, seed).map_err(|e| e.to_string())
    }
}

/// A seed that depends on the object and the variant, not on the order they are measured in.
fn seed_of(seed: u64, id: &str, variant: Variant) -> u64 {
    let digest = blake3::hash(format!("{seed} {id} {}", variant.name()).as_bytes());
    let bytes = digest.as_bytes();
    u64::from_le_bytes(std::array::from_fn(|i| bytes[i]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::procedural::{Id, generate};

    #[test]
    fn every_variant_is_settled_and_is_not_measured_twice() {
        let folder = tempfile::tempdir().unwrap();
        let counts = Counts { even: 200, least: 20 };
        let shelf = Shelf::open(folder.path(), "test", counts, 1).unwrap();
        let specimen = generate(Id::new("cabinet", 0).unwrap(), 1).unwrap();
        let variants = Variant::all(1, 1);
        assert_eq!(variants, [Variant::Rest, Variant::State(1), Variant::Fused(0)]);
        shelf.fill("a", Ok(&specimen), &variants).unwrap();
        for &variant in &variants {
            let sample = cache::read(&shelf.place("a", variant)).unwrap();
            assert_eq!(sample.parts.len(), specimen.wordings.len(), "{variant:?}");
        }
        shelf.fill("a", Err("must not be asked"), &variants).unwrap();
        shelf.fill("b", Err("no mesh"), &variants).unwrap();
        assert!(shelf.is_settled("b", Variant::Rest) && !shelf.place("b", Variant::Rest).exists());
    }

    #[test]
    fn other_settings_have_a_shelf_of_their_own() {
        let folder = tempfile::tempdir().unwrap();
        let open = |even| {
            let counts = Counts { even, least: 5 };
            Shelf::open(folder.path(), "test", counts, 1).unwrap().place("a", Variant::Rest)
        };
        assert_eq!(open(100), open(100));
        assert_ne!(open(100), open(101));
    }
}
