//! The embedded point encoder: what the surface looks like around a point, at four scales, and the
//! component and smooth patch it belongs to. No weights, no download.

use object::sample::{SurfacePoint, sample_surface};
use object::weld::Weld;
use object::{DVec3, Mesh};
use rayon::prelude::*;

use super::moments::Moments;
use super::regions::{self, Regions};
use super::{FeatureError, PointFeatures, UnitCube};

/// Cells along the unit cube's side at each scale.
const CELLS: [usize; 4] = [32, 16, 8, 4];
/// Numbers at each scale.
const SCALE_WIDTH: usize = 8;
/// Numbers of a point: eight for each of four scales, then component, then patch.
pub const WIDTH: usize = CELLS.len() * SCALE_WIDTH + 2 * regions::WIDTH;
/// Points the surface is measured with, and the seed they are drawn with.
const SAMPLES: usize = 16_384;
const SEED: u64 = 0x5eed;

/// The embedded point encoder.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GeometricFeatures;

impl PointFeatures for GeometricFeatures {
    fn identity(&self) -> String {
        "geometric-features/1".into()
    }

    fn width(&self) -> usize {
        WIDTH
    }

    fn encode(
        &self,
        mesh: &Mesh,
        frame: UnitCube,
        points: &[SurfacePoint],
    ) -> Result<Vec<f32>, FeatureError> {
        let weld = Weld::new(mesh);
        Surroundings::new(mesh, &weld, frame)?.encode(points)
    }
}

/// One mesh, measured; describes any number of its points.
#[derive(Clone, Debug)]
pub struct Surroundings {
    frame: UnitCube,
    grids: Vec<Grid>,
    components: Regions,
    patches: Regions,
}

impl Surroundings {
    /// Measures a welded mesh.
    ///
    /// # Errors
    /// [`FeatureError::NoArea`].
    pub fn new(mesh: &Mesh, weld: &Weld, frame: UnitCube) -> Result<Self, FeatureError> {
        let samples = sample_surface(mesh, SAMPLES, SEED);
        if samples.is_empty() {
            return Err(FeatureError::NoArea);
        }
        let place = |s: &SurfacePoint| (frame.inside(s.position), s.normal);
        let samples: Vec<_> = samples.iter().map(place).collect();
        Ok(Self {
            frame,
            grids: CELLS.par_iter().map(|&cells| Grid::new(cells, &samples)).collect(),
            components: Regions::components(mesh, weld, frame),
            patches: Regions::patches(mesh, weld, frame),
        })
    }

    /// [`WIDTH`] numbers for each point.
    ///
    /// # Errors
    /// [`FeatureError::NotFinite`] for a point that is none.
    pub fn encode(&self, points: &[SurfacePoint]) -> Result<Vec<f32>, FeatureError> {
        let mut out = vec![0.0; points.len() * WIDTH];
        out.par_chunks_mut(WIDTH).zip(points).for_each(|(out, p)| self.describe(p, out));
        match out.iter().position(|v| !v.is_finite()) {
            Some(i) => Err(FeatureError::NotFinite { point: i / WIDTH, feature: i % WIDTH }),
            None => Ok(out),
        }
    }

    fn describe(&self, point: &SurfacePoint, out: &mut [f32]) {
        let p = self.frame.inside(point.position);
        let face = point.face as usize;
        let (around, regions) = out.split_at_mut(CELLS.len() * SCALE_WIDTH);
        for (out, grid) in around.chunks_exact_mut(SCALE_WIDTH).zip(&self.grids) {
            out.copy_from_slice(&grid.describe(p, point.normal));
        }
        let (component, patch) = regions.split_at_mut(regions::WIDTH);
        component.copy_from_slice(&self.components.describe(face, p));
        patch.copy_from_slice(&self.patches.describe(face, p));
    }
}

/// What the samples in one cell add up to.
#[derive(Clone, Copy, Debug, Default)]
struct Cell {
    moments: Moments,
    normal: DVec3,
}

/// A grid of cells over the unit cube, with one cell of margin.
#[derive(Clone, Debug)]
struct Grid {
    cells: usize,
    data: Vec<Cell>,
}

impl Grid {
    fn new(cells: usize, samples: &[(DVec3, DVec3)]) -> Self {
        let mut grid = Self { cells, data: vec![Cell::default(); (cells + 2).pow(3)] };
        for &(p, normal) in samples {
            let at = ((p + 0.5) * cells as f64).floor() + 1.0;
            let index =
                grid.index(at.to_array().map(|c| c.clamp(0.0, (cells + 1) as f64) as usize));
            let cell = &mut grid.data[index];
            cell.moments.add(&Moments::point(p, 1.0), 1.0);
            cell.normal += normal;
        }
        grid
    }

    fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        let side = self.cells + 2;
        (z * side + y) * side + x
    }

    /// The eight cells around a point, weighted by nearness, so that the sum changes smoothly.
    fn around(&self, p: DVec3) -> Cell {
        let at = ((p + 0.5) * self.cells as f64 + 0.5)
            .clamp(DVec3::ZERO, DVec3::splat(self.cells as f64 + 0.999));
        let (low, part) = (at.floor(), at - at.floor());
        let mut sum = Cell::default();
        for corner in 0..8usize {
            let up = [corner & 1, corner >> 1 & 1, corner >> 2];
            let share: f64 =
                (0..3).map(|i| if up[i] == 1 { part[i] } else { 1.0 - part[i] }).product();
            let index = self.index(std::array::from_fn(|i| low[i] as usize + up[i]));
            sum.moments.add(&self.data[index].moments, share);
            sum.normal += self.data[index].normal * share;
        }
        sum
    }

    /// Spread along three axes, offset of the mean along the normal (hollow or bulging) and across
    /// it (near a rim), how far the normals agree with the point's and with each other, and how
    /// much surface there is; lengths in cells.
    fn describe(&self, p: DVec3, normal: DVec3) -> [f32; SCALE_WIDTH] {
        let cell = self.around(p);
        let scale = self.cells as f64;
        let [a, b, c] = cell.moments.deviations().map(|d| d * scale);
        let empty = cell.moments.weight <= 0.0;
        let offset = if empty { DVec3::ZERO } else { (cell.moments.mean() - p) * scale };
        let mean_normal = if empty { DVec3::ZERO } else { cell.normal / cell.moments.weight };
        let along = offset.dot(normal);
        let across = (offset - normal * along).length();
        let area = cell.moments.weight / SAMPLES as f64 * scale * scale;
        let all =
            [a, b, c, along, across, mean_normal.dot(normal), mean_normal.length(), area.sqrt()];
        all.map(|v| v as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A flat square of side 1 and, apart from it, a small cube's top of side 0.1.
    fn two_squares() -> Mesh {
        let mut vertices = Vec::new();
        let mut faces = Vec::new();
        for (x, side) in [(0.0, 1.0), (1.5, 0.1)] {
            let start = vertices.len() as u32;
            for (dx, dy) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
                vertices.push(DVec3::new(x + dx * side, dy * side, 0.0));
            }
            faces.extend([[start, start + 1, start + 2], [start, start + 2, start + 3]]);
        }
        Mesh::new(vertices, faces).unwrap()
    }

    fn encode(mesh: &Mesh, points: &[SurfacePoint]) -> Vec<f32> {
        GeometricFeatures.encode(mesh, UnitCube::of(mesh), points).unwrap()
    }

    #[test]
    fn a_flat_place_is_flat_at_every_scale_and_knows_its_component() {
        let mesh = two_squares();
        let at = |x: f64, y: f64, face: u32| SurfacePoint {
            position: DVec3::new(x, y, 0.0),
            normal: DVec3::Z,
            face,
        };
        let found = encode(&mesh, &[at(0.5, 0.4, 0), at(1.55, 0.05, 2)]);
        assert_eq!(found.len(), 2 * WIDTH);
        for scale in found[..CELLS.len() * SCALE_WIDTH].chunks(SCALE_WIDTH) {
            assert!(scale[2] < 1e-4 && scale[3].abs() < 1e-4, "no thickness, no curvature");
            assert!((scale[5] - 1.0).abs() < 1e-4 && (scale[6] - 1.0).abs() < 1e-4);
        }
        let side = found[CELLS.len() * SCALE_WIDTH];
        assert!((side - 1.0 / 1.6).abs() < 1e-6, "the unit cube is 1.6 wide: {side}");
        let small = found[WIDTH + CELLS.len() * SCALE_WIDTH];
        assert!((small - 0.1 / 1.6).abs() < 1e-6);
    }

    #[test]
    fn a_point_is_described_alike_whichever_others_are_asked_about() {
        let mesh = two_squares();
        let points = sample_surface(&mesh, 101, 3);
        let all = encode(&mesh, &points);
        assert_eq!(all[50 * WIDTH..51 * WIDTH], encode(&mesh, &points[50..51])[..]);
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        assert_eq!(all, one.install(|| encode(&mesh, &points)));
    }
}
