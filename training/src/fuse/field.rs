//! The distance to a surface on a grid, negative where nothing from outside can reach.

use object::weld::nearest_on_triangle;
use object::{DVec3, Mesh};

use super::recipe::Recipe;

/// Cells around the object: more than any skin keeps clear by, so that all around it is outside.
const MARGIN: f64 = 3.0;
/// No face near a node.
const NONE: u32 = u32::MAX;

/// Distances at the nodes of a grid, lengths in metres.
#[derive(Clone, Debug)]
pub(super) struct Field {
    low: DVec3,
    cell: f64,
    /// How far from the surface the distance is known: a node inside the skin has neighbours no farther
    /// out than one cell more.
    band: f64,
    size: [usize; 3],
    /// Distance to the skin: positive outside.
    value: Vec<f64>,
    /// The nearest face, where there is one within the band.
    face: Vec<u32>,
}

/// The ball and the plane of a face, to pass over points that are surely farther than something.
struct Bound {
    centre: DVec3,
    radius: f64,
    normal: DVec3,
}

impl Bound {
    fn of([a, b, c]: [DVec3; 3]) -> Self {
        let centre = (a + b + c) / 3.0;
        let radius = [a, b, c].map(|p| (p - centre).length()).into_iter().fold(0.0, f64::max);
        Self { centre, radius, normal: (b - a).cross(c - a).normalize_or_zero() }
    }

    fn is_beyond(&self, p: DVec3, apart: f64) -> bool {
        let away = p - self.centre;
        let reach = self.radius + apart;
        self.normal.dot(away).abs() > apart || away.length_squared() > reach * reach
    }
}

impl Field {
    pub(super) fn of(mesh: &Mesh, recipe: &Recipe) -> Self {
        let bounds = mesh.bounds();
        let cell = bounds.size().max_element() / recipe.cells as f64;
        let band = (recipe.offset + 1.05).max(recipe.clearance + 1.0) * cell;
        let low = bounds.min - DVec3::splat(MARGIN * cell);
        let size = (bounds.size() / cell + 2.0 * MARGIN).to_array().map(|n| n.ceil() as usize + 1);
        let count = size.iter().product();
        let (value, face) = (vec![band; count], vec![NONE; count]);
        let mut field = Self { low, cell, band, size, value, face };
        (0..mesh.faces().len()).for_each(|face| field.splat(mesh, face));
        field.shut(recipe);
        field
    }

    pub(super) fn size(&self) -> [usize; 3] {
        self.size
    }

    pub(super) fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.size[1] + y) * self.size[0] + x
    }

    pub(super) fn value(&self, node: [usize; 3]) -> f64 {
        self.value[self.index(node)]
    }

    pub(super) fn position(&self, node: [usize; 3]) -> DVec3 {
        self.low + DVec3::from_array(node.map(|n| n as f64)) * self.cell
    }

    /// The faces nearest the nodes around a point, each once.
    pub(super) fn faces_near(&self, p: DVec3) -> Vec<u32> {
        let at = ((p - self.low) / self.cell).floor().to_array();
        let mut found = Vec::with_capacity(8);
        for corner in 0..8usize {
            let node = std::array::from_fn(|i| {
                (at[i].max(0.0) as usize + (corner >> i & 1)).min(self.size[i] - 1)
            });
            let face = self.face[self.index(node)];
            if face != NONE && !found.contains(&face) {
                found.push(face);
            }
        }
        found
    }

    /// Lowers the distance of the nodes around a face to the distance from it.
    fn splat(&mut self, mesh: &Mesh, face: usize) {
        let corners = mesh.corners(face);
        let reach = DVec3::splat(self.band);
        let low = corners[0].min(corners[1]).min(corners[2]) - reach;
        let high = corners[0].max(corners[1]).max(corners[2]) + reach;
        let node = |p: DVec3| ((p - self.low) / self.cell).to_array().map(|n| n.max(0.0) as usize);
        let (from, to) = (node(low), node(high));
        let to: [usize; 3] = std::array::from_fn(|i| to[i].min(self.size[i] - 1));
        let bound = Bound::of(corners);
        for z in from[2]..=to[2] {
            for y in from[1]..=to[1] {
                for x in from[0]..=to[0] {
                    let (index, p) = (self.index([x, y, z]), self.position([x, y, z]));
                    if bound.is_beyond(p, self.value[index]) {
                        continue;
                    }
                    let apart = (nearest_on_triangle(p, corners) - p).length();
                    if apart < self.value[index] {
                        self.value[index] = apart;
                        self.face[index] = face as u32;
                    }
                }
            }
        }
    }

    /// Turns distances from the surface into distances from the skin, and everything that cannot be
    /// reached from the corner of the grid into inside.
    fn shut(&mut self, recipe: &Recipe) {
        let skin = recipe.offset * self.cell;
        let clear = (recipe.clearance - recipe.offset).max(0.0) * self.cell;
        self.value.iter_mut().for_each(|v| *v -= skin);
        let mut outside = vec![false; self.value.len()];
        let mut open = vec![[0usize; 3]];
        outside[0] = true;
        while let Some(node) = open.pop() {
            for next in self.neighbours(node) {
                let index = self.index(next);
                if !outside[index] && self.value[index] > clear {
                    outside[index] = true;
                    open.push(next);
                }
            }
        }
        if clear > 0.0 {
            // What kept its distance comes as near as the skin again.
            (0..recipe.clearance.ceil() as usize).for_each(|_| self.widen(&mut outside));
        }
        let depth = self.cell;
        for (value, outside) in self.value.iter_mut().zip(outside) {
            if !outside && *value >= 0.0 {
                *value = -depth;
            }
        }
    }

    /// What is off the skin and beside what is outside is outside, too.
    fn widen(&self, outside: &mut [bool]) {
        let [across, deep, high] = self.size;
        let nodes = (0..high)
            .flat_map(|z| (0..deep).flat_map(move |y| (0..across).map(move |x| [x, y, z])));
        let is_met = |node: &[usize; 3]| {
            let index = self.index(*node);
            let met = || self.neighbours(*node).any(|next| outside[self.index(next)]);
            !outside[index] && self.value[index] > 0.0 && met()
        };
        let met: Vec<usize> = nodes.filter(is_met).map(|node| self.index(node)).collect();
        met.into_iter().for_each(|index| outside[index] = true);
    }

    fn neighbours(&self, node: [usize; 3]) -> impl Iterator<Item = [usize; 3]> + use<> {
        let size = self.size;
        (0..6).filter_map(move |i| {
            let (axis, up) = (i / 2, i % 2 == 1);
            let mut next = node;
            next[axis] = if up { node[axis] + 1 } else { node[axis].checked_sub(1)? };
            (next[axis] < size[axis]).then_some(next)
        })
    }
}
