//! What is behind the object: a light grey studio, and a soft shadow on the floor it stands on.

use glamx::DVec3;
use object::Mesh;
use object::mesh::Bounds;

use crate::camera::{Axes, Camera};

/// Linear light of the backdrop at the top and at the bottom of the picture.
const TOP: f64 = 0.80;
const BOTTOM: f64 = 0.60;
/// How dark the shadow gets.
const SHADOW: f64 = 0.55;
/// Cells along the longer side of the shadow's map, object and surroundings together.
const CELLS: usize = 96;
/// How far the shadow's map reaches beyond the object, as a share of its width.
const AROUND: f64 = 0.35;

/// A floor with the object's shadow.
#[derive(Clone, Debug)]
pub(crate) struct Backdrop {
    corner: DVec3,
    cell: f64,
    size: [usize; 2],
    dark: Vec<f32>,
}

/// A backdrop as one camera sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Paper<'a> {
    backdrop: &'a Backdrop,
    camera: Camera,
    axes: Axes,
}

/// A row of it.
pub(crate) struct PaperRow<'a> {
    backdrop: &'a Backdrop,
    eye: DVec3,
    wall: f64,
    first: DVec3,
    step: DVec3,
    drop: f64,
}

impl Backdrop {
    /// Drops the surface onto the floor, the lower the darker, and softens the edge.
    pub(crate) fn new(mesh: &Mesh) -> Self {
        let bounds = mesh.bounds();
        let extent = bounds.size();
        let wide = extent.x.max(extent.y).max(0.2 * extent.z);
        let margin = AROUND * wide;
        let cell = (wide + 2.0 * margin) / CELLS as f64;
        let corner = bounds.min - DVec3::new(margin, margin, 0.0);
        let size = [extent.x, extent.y].map(|e| ((e + 2.0 * margin) / cell).ceil() as usize + 1);
        let mut floor = Self { corner, cell, size, dark: vec![0.0; size[0] * size[1]] };
        for face in 0..mesh.faces().len() {
            floor.drop_face(mesh.corners(face), &bounds);
        }
        floor.soften();
        floor
    }

    fn drop_face(&mut self, corners: [DVec3; 3], bounds: &Bounds) {
        let high = bounds.size().z.max(f64::MIN_POSITIVE);
        let longest = (0..3).map(|i| corners[i].distance(corners[(i + 1) % 3]));
        let longest = longest.fold(0.0, f64::max);
        let steps = ((longest / self.cell).ceil() as usize).clamp(1, 2 * CELLS);
        for i in 0..=steps {
            for j in 0..=steps - i {
                let (u, v) = (i as f64 / steps as f64, j as f64 / steps as f64);
                let p = corners[0] * (1.0 - u - v) + corners[1] * u + corners[2] * v;
                let low = 1.0 - (p.z - bounds.min.z) / high;
                let [x, y] = self.place(p);
                let index = y as usize * self.size[0] + x as usize;
                if let Some(dark) = self.dark.get_mut(index) {
                    *dark = dark.max((low * low * low) as f32);
                }
            }
        }
    }

    /// A point above the floor in cells of the map.
    fn place(&self, p: DVec3) -> [f64; 2] {
        [(p.x - self.corner.x) / self.cell, (p.y - self.corner.y) / self.cell]
    }

    /// Three box blurs each way are nearly a Gaussian.
    fn soften(&mut self) {
        let [width, height] = self.size;
        for _ in 0..3 {
            self.dark = blur(&self.dark, [width, height], [1, width]);
            self.dark = blur(&self.dark, [height, width], [width, 1]);
        }
    }

    pub(crate) fn seen_by(&self, camera: &Camera) -> Paper<'_> {
        Paper { backdrop: self, camera: *camera, axes: camera.axes() }
    }

    fn dark_at(&self, p: DVec3) -> f64 {
        let [x, y] = self.place(p).map(|v| v - 0.5);
        let [width, height] = self.size;
        let inside = x >= 0.0 && y >= 0.0 && x < (width - 1) as f64 && y < (height - 1) as f64;
        if !inside {
            return 0.0;
        }
        let (fx, fy) = (x.fract(), y.fract());
        let corner = y as usize * width + x as usize;
        let at = |i: usize| self.dark.get(i).copied().map_or(0.0, f64::from);
        let row = |i: usize| at(i) * (1.0 - fx) + at(i + 1) * fx;
        row(corner) * (1.0 - fy) + row(corner + width) * fy
    }
}

/// A box blur of the runs along `steps[0]`; `size` is the run's length and how many runs there are.
fn blur(from: &[f32], size: [usize; 2], steps: [usize; 2]) -> Vec<f32> {
    const REACH: usize = CELLS / 32;
    let mut to = vec![0.0; from.len()];
    for run in 0..size[1] {
        for k in 0..size[0] {
            let ends = [k.saturating_sub(REACH), (k + REACH).min(size[0] - 1)];
            let sum: f32 = (ends[0]..=ends[1]).map(|j| from[j * steps[0] + run * steps[1]]).sum();
            to[k * steps[0] + run * steps[1]] = sum / (2 * REACH + 1) as f32;
        }
    }
    to
}

impl<'a> Paper<'a> {
    /// The backdrop behind a row of pixels.
    pub(crate) fn row(&self, y: usize) -> PaperRow<'a> {
        let Self { backdrop, camera, axes } = *self;
        let down = y as f64 / f64::from(camera.size[1]);
        let pixel = [0.5, y as f64 + 0.5];
        PaperRow {
            backdrop,
            eye: camera.eye,
            wall: TOP + (BOTTOM - TOP) * down * down,
            first: axes.direction(camera.centre(), pixel),
            step: axes.right / axes.focal,
            drop: backdrop.corner.z - camera.eye.z,
        }
    }
}

impl PaperRow<'_> {
    /// Linear light of the backdrop behind a pixel of the row; it has no colour.
    pub(crate) fn light(&self, x: usize) -> f32 {
        let ray = self.first + self.step * x as f64;
        let dark = if self.drop < 0.0 && ray.z < 0.0 {
            self.backdrop.dark_at(self.eye + ray * (self.drop / ray.z))
        } else {
            0.0
        };
        (self.wall * (1.0 - SHADOW * dark)) as f32
    }
}
