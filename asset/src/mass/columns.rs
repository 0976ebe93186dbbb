//! The union of closed bodies that overlap, measured along a grid of upright columns.
//!
//! Summing bodies counts their overlap twice. The columns give both the sum and the union with the
//! same small error of sampling, so their difference corrects an exact sum well.

use glamx::{DMat3, DVec3};
use object::mesh::Bounds;

use crate::mass::moments::Moments;

/// Columns along each side of the base.
const COLUMNS: usize = 160;

/// Where a column crosses a surface: cell, height, and +1 on entering from below.
type Crossing = (u32, f64, i32);

/// Moments of the stuff counted twice: sum of the bodies less their union. `faces` are the corners
/// of closed, outward surfaces (cavities inward).
pub(crate) fn overlap(faces: &[[DVec3; 3]]) -> Moments {
    let bounds = Bounds::of(faces.iter().flatten().copied());
    let size = bounds.size();
    if !(size.min_element() > 0.0 && size.is_finite()) {
        return Moments::ZERO;
    }
    let grid = Grid { min: bounds.min, cell: size / COLUMNS as f64 };
    let mut crossings: Vec<Crossing> = Vec::new();
    faces.iter().for_each(|f| grid.cross(*f, &mut crossings));
    crossings.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(b.2.cmp(&a.2)));
    crossings.chunk_by(|a, b| a.0 == b.0).map(|column| grid.counted_twice(column)).sum()
}

struct Grid {
    min: DVec3,
    cell: DVec3,
}

impl Grid {
    /// Centre line of a column: a little off the middle, so that the diagonals and edges of boxes
    /// aligned with the grid are not hit.
    fn centre(&self, i: usize, j: usize) -> [f64; 2] {
        let x = self.min.x + (i as f64 + 0.5137) * self.cell.x;
        [x, self.min.y + (j as f64 + 0.4871) * self.cell.y]
    }

    fn cross(&self, [a, b, c]: [DVec3; 3], crossings: &mut Vec<Crossing>) {
        let normal = (b - a).cross(c - a);
        if normal.z == 0.0 {
            return;
        }
        let box_of = |k: fn(DVec3) -> f64, min: f64, cell: f64| {
            let (low, high) = (k(a).min(k(b)).min(k(c)), k(a).max(k(b)).max(k(c)));
            let first = ((low - min) / cell - 1.0).max(0.0) as usize;
            first..=(((high - min) / cell + 1.0) as usize).min(COLUMNS - 1)
        };
        for i in box_of(|p| p.x, self.min.x, self.cell.x) {
            for j in box_of(|p| p.y, self.min.y, self.cell.y) {
                let [x, y] = self.centre(i, j);
                if covers([a, b, c], x, y) {
                    let rise = (normal.x * (x - a.x) + normal.y * (y - a.y)) / normal.z;
                    let way = if normal.z < 0.0 { 1 } else { -1 };
                    crossings.push(((i * COLUMNS + j) as u32, a.z - rise, way));
                }
            }
        }
    }

    fn counted_twice(&self, column: &[Crossing]) -> Moments {
        let Some(&(cell, ..)) = column.first() else { return Moments::ZERO };
        let (i, j) = (cell as usize / COLUMNS, cell as usize % COLUMNS);
        let [x, y] = self.centre(i, j);
        let base = self.cell.x * self.cell.y;
        let (mut depth, mut twice) = (0, Moments::ZERO);
        for w in column.windows(2) {
            depth += w[0].2;
            let excess = depth - i32::from(depth > 0);
            if excess != 0 {
                twice = twice + rod(x, y, w[0].1, w[1].1) * (base * f64::from(excess));
            }
        }
        twice
    }
}

/// Moments per unit of cross-section of an upright rod.
fn rod(x: f64, y: f64, low: f64, high: f64) -> Moments {
    let (length, mid) = (high - low, (high + low) / 2.0);
    let centre = DVec3::new(x, y, mid);
    let along = DMat3::from_diagonal(DVec3::Z * (length.powi(3) / 12.0));
    let second = crate::mass::moments::outer(centre, centre) * length + along;
    Moments { measure: length, first: centre * length, second }
}

/// Whether the upright line through (x, y) passes the triangle; lines through an edge belong to
/// exactly one of the two triangles that share it.
fn covers([a, b, c]: [DVec3; 3], x: f64, y: f64) -> bool {
    let left = |p: DVec3, q: DVec3| {
        let swap = (p.x, p.y) > (q.x, q.y);
        let (p, q) = if swap { (q, p) } else { (p, q) };
        ((q.x - p.x) * (y - p.y) - (q.y - p.y) * (x - p.x) >= 0.0) != swap
    };
    let first = left(a, b);
    first == left(b, c) && first == left(c, a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::{block, cylinder, joined};
    use object::Mesh;

    fn corners(mesh: &Mesh) -> Vec<[DVec3; 3]> {
        (0..mesh.faces().len()).map(|f| mesh.corners(f)).collect()
    }

    #[test]
    fn bodies_apart_share_nothing() {
        let two = joined(&[block(DVec3::ONE, DVec3::ZERO), cylinder(0.2, 3.0, 31)]);
        let apart = joined(&[block(DVec3::ONE, DVec3::ZERO), block(DVec3::ONE, DVec3::X * 1.5)]);
        assert_eq!(overlap(&corners(&apart)).measure, 0.0);
        let shared = std::f64::consts::PI * 0.04;
        assert!((overlap(&corners(&two)).measure / shared - 1.0).abs() < 0.02);
    }

    #[test]
    fn two_blocks_that_share_a_corner_overlap_there() {
        let two = [block(DVec3::ONE, DVec3::ZERO), block(DVec3::ONE, DVec3::splat(0.7))];
        let o = overlap(&corners(&joined(&two)));
        assert!((o.measure / 0.027 - 1.0).abs() < 0.05, "{}", o.measure);
        assert!((o.centre() - DVec3::splat(0.35)).length() < 0.01, "{}", o.centre());
    }

    #[test]
    fn the_same_block_three_times_is_counted_twice_too_often() {
        let b = block(DVec3::new(0.2, 0.3, 0.4), DVec3::X);
        let o = overlap(&corners(&joined(&[b.clone(), b.clone(), b])));
        assert!((o.measure / 0.048 - 1.0).abs() < 1e-12, "{}", o.measure);
    }
}
