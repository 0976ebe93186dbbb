//! Where two parts run through each other: what one hides of the other is cut out of what is seen.
//!
//! Two solids cannot share a place, so one of them gave way when their pieces were cleared of each
//! other. Where that left a part's surface without a piece behind it, inside the other part, the
//! surface goes as well: a socket, so that what is seen is what is touched.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};

use glamx::DVec3;
use object::mesh::{Bounds, Mesh, MeshError};
use object::weld::Weld;
use rayon::prelude::*;

use crate::change::Change;
use crate::collision::agreement::{FITS, gap};
use crate::collision::piece::ConvexPiece;
use crate::collision::solid::{MAX_CORNERS, Solid};
use crate::collision::whole::Whole;
use crate::surface::seal;

/// A hidden place farther than this share of the tolerance from every piece of its own is cut out.
const BARE: f64 = 0.85;
/// A socket is this much wider than what sits in it, in tolerances.
const ROOM: f64 = 0.25;
/// No part loses more than this share of its surface; if it would, it keeps all of it.
const MOST: f64 = 0.4;
/// Places of a triangle that are looked at.
const SPOTS: usize = 10;
/// What a cut leaves that is thinner than this share of the diagonal is not worth a triangle.
const SLIVER: f64 = 1e-4;
/// Corners this close to a cut lie on it, as a share of the diagonal.
const LEVEL: f64 = 5e-5;
/// A face that a cut left beside one it is wound against goes, too, if it is smaller than this share
/// of the surface.
const REMNANT: f64 = 1e-3;
/// Two faces on an edge that look the same way within this cosine lie on one another, as sheets do.
const SHEETS: f64 = 0.99;
/// Triangles cut in one go.
const AT_ONCE: usize = 200;

/// One way to cut: by what the others fill before they are cleared of each other or by what is left
/// of them, and how often a triangle is halved to tell bare from covered.
#[derive(Clone, Copy, Debug)]
struct Way {
    by_filled: bool,
    halvings: u32,
}

/// The ways tried, until a part fits.
const WAYS: [Way; 3] = [
    Way { by_filled: false, halvings: 0 },
    Way { by_filled: true, halvings: 7 },
    Way { by_filled: true, halvings: 0 },
];

/// What is seen of a part, and how far that and its pieces lie apart, in tolerances.
pub(crate) struct Seen {
    pub(crate) mesh: Mesh,
    pub(crate) gap: f64,
    pub(crate) change: Option<Change>,
}

/// The parts' whole surfaces without what others hide and no piece of their own stands behind. `filled`
/// are the pieces of each part before they were cleared of each other, `left` those after. Metres,
/// asset frame, rest pose; `tolerance` is how far surface and pieces may lie apart. What is cut open
/// is closed again where it fits no worse for it.
///
/// # Errors
/// [`MeshError`] if a cut surface is no mesh.
pub(crate) fn cut(
    wholes: &[Whole],
    [filled, left]: [&[Vec<ConvexPiece>]; 2],
    names: &[&str],
    tolerance: f64,
) -> Result<Vec<Seen>, MeshError> {
    let solid = |p: &ConvexPiece| Solid::of(&p.vertices, MAX_CORNERS, 0.0);
    let solids = |of: &[Vec<ConvexPiece>]| -> Vec<Vec<Solid>> {
        of.iter().map(|pieces| pieces.iter().filter_map(solid).collect()).collect()
    };
    let cutters = [solids(left), solids(filled)];
    let one = |part: usize| {
        let others = |way: &Way| -> Vec<&Solid> {
            let all = cutters[usize::from(way.by_filled)].iter().enumerate();
            all.filter(|(other, _)| *other != part).flat_map(|(_, of)| of).collect()
        };
        let (whole, own) = (&wholes[part], &cutters[0][part]);
        let seen = seen(whole, (&left[part], own), others, tolerance)?;
        Ok(seen.closed(whole.mesh, own, tolerance).of(names[part], whole.mesh))
    };
    (0..wholes.len()).into_par_iter().map(one).collect()
}

/// The surface as it is if it fits, else cut in the first way that makes it fit, else in the way
/// that comes nearest.
fn seen<'a>(
    whole: &Whole,
    (pieces, own): (&[ConvexPiece], &[Solid]),
    others: impl Fn(&Way) -> Vec<&'a Solid>,
    tolerance: f64,
) -> Result<Seen, MeshError> {
    let mesh = whole.mesh;
    let gap_whole = whole.gap(pieces, own, tolerance);
    let mut best = Seen { gap: gap_whole, mesh: mesh.clone(), change: None };
    for way in &WAYS {
        if best.gap <= FITS {
            break;
        }
        let mut skin = Skin::new(mesh);
        skin.cut_out(&others(way), own, way.halvings, tolerance);
        if skin.was_cut && skin.area() > (1.0 - MOST) * area_of(mesh) {
            let cut = without_remnants(skin.mesh(mesh)?)?;
            let gap = gap(&cut, own, tolerance);
            if gap < best.gap {
                best = Seen { mesh: cut, gap, change: None };
            }
        }
    }
    Ok(best)
}

impl Seen {
    /// With a floor in each socket of what was closed before it was cut.
    fn closed(self, whole: &Mesh, own: &[Solid], tolerance: f64) -> Self {
        if self.mesh == *whole || !seal::is_closed(whole) {
            return self;
        }
        let Some(mesh) = seal::sealed(&self.mesh) else { return self };
        let gap = gap(&mesh, own, tolerance);
        if gap <= self.gap.max(FITS) { Self { mesh, gap, ..self } } else { self }
    }

    /// With a word on what the part `name` lost of its whole surface.
    fn of(mut self, name: &str, whole: &Mesh) -> Self {
        let (before, after) = (area_of(whole), area_of(&self.mesh));
        if self.mesh != *whole {
            let text = |area: f64| format!("{area:.4e} m² of surface");
            let why = "what lies inside another part and has no piece of its own is not seen";
            self.change = Some(Change::new(name, "visual", text(before), text(after), why));
        }
        self
    }
}

fn area_of(mesh: &Mesh) -> f64 {
    (0..mesh.faces().len()).map(|f| mesh.area(f)).sum()
}

/// Without small faces that share an edge with one other face alone, wound against it: where bodies
/// meet along an edge, a cut may leave one face of each.
fn without_remnants(mut mesh: Mesh) -> Result<Mesh, MeshError> {
    let small = REMNANT * area_of(&mesh);
    loop {
        let weld = Weld::new(&mesh);
        let mut uses: BTreeMap<[u32; 2], Vec<(usize, bool)>> = BTreeMap::new();
        for (face, &[a, b, c]) in weld.faces.iter().enumerate() {
            for [p, q] in [[a, b], [b, c], [c, a]] {
                uses.entry([p.min(q), p.max(q)]).or_default().push((face, p < q));
            }
        }
        let clashing = uses.values().filter_map(|fan| match fan[..] {
            [(f, way), (g, other)] if way == other => {
                let lesser = if mesh.area(g) < mesh.area(f) { g } else { f };
                let is_sheet = mesh.normal(f).dot(mesh.normal(g)) > SHEETS;
                (!is_sheet && mesh.area(lesser) < small).then_some(lesser)
            }
            _ => None,
        });
        let remnants: BTreeSet<usize> = clashing.collect();
        if remnants.is_empty() {
            return Ok(mesh);
        }
        mesh = mesh.submesh((0..mesh.faces().len()).filter(|f| !remnants.contains(f)))?;
    }
}

/// A corner: where, and its colour as numbers so that it can be mixed.
#[derive(Clone, Copy, Debug)]
struct Corner {
    at: DVec3,
    colour: [f64; 4],
}

impl Corner {
    /// The place at a share of the way from a to b; the same, bit by bit, as from b to a.
    fn mix(a: &Self, b: &Self, share: f64) -> Self {
        let (a, b, share) = if b.is_before(a) { (b, a, 1.0 - share) } else { (a, b, share) };
        let mut colour = a.colour;
        colour.iter_mut().zip(b.colour).for_each(|(c, d)| *c += (d - *c) * share);
        Self { at: a.at.lerp(b.at, share), colour }
    }

    fn is_before(&self, other: &Self) -> bool {
        self.at.to_array().partial_cmp(&other.at.to_array()).is_some_and(Ordering::is_lt)
    }
}

type Triangle = [Corner; 3];

/// A surface as loose triangles, cut piece by piece.
struct Skin {
    triangles: Vec<Triangle>,
    diagonal: f64,
    was_cut: bool,
}

impl Skin {
    fn new(mesh: &Mesh) -> Self {
        let corner = |i: u32| {
            let colour = mesh.colours().map_or([0; 4], |c| c[i as usize]).map(f64::from);
            Corner { at: mesh.vertices()[i as usize], colour }
        };
        let triangles = mesh.faces().iter().map(|f| f.map(corner)).collect();
        Self { triangles, diagonal: mesh.bounds().diagonal(), was_cut: false }
    }

    /// Takes out what lies inside one of `others` and is bare of `own` pieces.
    fn cut_out(&mut self, others: &[&Solid], own: &[Solid], halvings: u32, tolerance: f64) {
        let (limit, room) = (BARE * tolerance, ROOM * tolerance);
        for other in others {
            let near: Vec<(Bounds, &Solid)> = own
                .iter()
                .map(|s| (s.bounds.grown(limit), s))
                .filter(|(around, _)| around.intersects(&other.bounds.grown(room)))
                .collect();
            let is_bare = |p: DVec3| {
                near.iter().all(|(around, s)| !around.holds(p) || s.distance(p, limit) >= limit)
            };
            let shape = Cutter { body: other, level: LEVEL * self.diagonal, room, halvings };
            let all = self.triangles.par_iter().with_min_len(AT_ONCE).enumerate();
            let rests = all.filter_map(|(at, t)| Some((at, shape.outside(t, is_bare)?)));
            let rests: Vec<(usize, Vec<Triangle>)> = rests.collect();
            if rests.is_empty() {
                continue;
            }
            self.was_cut = true;
            let mut left = Vec::with_capacity(self.triangles.len());
            let mut from = 0;
            for (at, rest) in rests {
                left.extend_from_slice(&self.triangles[from..at]);
                let thick = |t: &Triangle| breadth(t) > SLIVER * self.diagonal;
                left.extend(rest.into_iter().filter(thick));
                from = at + 1;
            }
            left.extend_from_slice(&self.triangles[from..]);
            self.triangles = left;
        }
    }

    fn area(&self) -> f64 {
        self.triangles.iter().map(area).sum()
    }

    /// The mesh of the triangles, in the frame of the one it was.
    fn mesh(&self, was: &Mesh) -> Result<Mesh, MeshError> {
        let (mut known, mut corners) = (BTreeMap::new(), Vec::new());
        let mut index = |c: &Corner| {
            let bits = c.at.to_array().map(f64::to_bits);
            *known.entry((bits, c.colour.map(f64::to_bits))).or_insert_with(|| {
                corners.push(*c);
                corners.len() as u32 - 1
            })
        };
        let faces: Vec<[u32; 3]> =
            self.triangles.iter().map(|t| [index(&t[0]), index(&t[1]), index(&t[2])]).collect();
        let byte = |c: f64| c.round().clamp(0.0, 255.0) as u8;
        let colours = corners.iter().map(|c: &Corner| c.colour.map(byte)).collect();
        let mesh = Mesh::new(corners.iter().map(|c| c.at).collect(), faces)?;
        let colours = was.colours().is_some().then_some(colours);
        mesh.with_frame(was.frame()).with_colours(colours)
    }
}

fn area(t: &Triangle) -> f64 {
    (t[1].at - t[0].at).cross(t[2].at - t[0].at).length() / 2.0
}

/// Smallest height of a triangle.
fn breadth(t: &Triangle) -> f64 {
    let longest =
        (0..3).map(|i| t[i].at.distance(t[(i + 1) % 3].at)).fold(f64::MIN_POSITIVE, f64::max);
    2.0 * area(t) / longest
}

/// A convex body that triangles are cut by.
struct Cutter<'a> {
    body: &'a Solid,
    /// Corners this close to one of its sides lie on it, metres.
    level: f64,
    /// It counts as this much larger, metres.
    room: f64,
    halvings: u32,
}

impl Cutter<'_> {
    /// What is left of a triangle outside the body; `None` if nothing bare lies inside.
    fn outside(
        &self,
        triangle: &Triangle,
        is_bare: impl Fn(DVec3) -> bool,
    ) -> Option<Vec<Triangle>> {
        let Self { body, level, room, halvings } = *self;
        let apart = |axis: DVec3, from: f64, to: f64| {
            triangle.iter().all(|c| axis.dot(c.at) < from)
                || triangle.iter().all(|c| axis.dot(c.at) > to)
        };
        let near = body.bounds.grown(room);
        let (min, max) = (near.min, near.max);
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        if axes.iter().any(|&a| apart(a, a.dot(min), a.dot(max))) {
            return None;
        }
        let (mut inside, mut left) = (triangle.to_vec(), Vec::new());
        for facet in &body.facets {
            let height = |c: &Corner| {
                let h = facet.normal.dot(c.at) - facet.offset - room;
                if h.abs() < level { 0.0 } else { h }
            };
            if inside.iter().any(|c| height(c) > 0.0) {
                left.extend(fan(&clipped(&inside, |c| -height(c))));
            }
            inside = clipped(&inside, height);
            if inside.len() < 3 {
                return None;
            }
        }
        let (hidden, before) = (fan(&inside), left.len());
        hidden.iter().for_each(|t| covered(*t, halvings, &is_bare, &mut left));
        let kept: f64 = left[before..].iter().map(area).sum();
        let all: f64 = hidden.iter().map(area).sum();
        (kept < (1.0 - 1e-9) * all).then_some(left)
    }
}

/// Adds the parts of a triangle where nothing is bare, found by halving it.
fn covered(t: Triangle, depth: u32, is_bare: &impl Fn(DVec3) -> bool, into: &mut Vec<Triangle>) {
    let bare = spots(&t).into_iter().filter(|&p| is_bare(p)).count();
    if bare == 0 {
        into.push(t);
    } else if bare < SPOTS && depth > 0 {
        let length = |i: usize| t[i].at.distance_squared(t[(i + 1) % 3].at);
        let opposite = |i: usize| t[(i + 2) % 3];
        let longest = (1..3).fold(0, |best, i| match length(i).total_cmp(&length(best)) {
            Ordering::Greater => i,
            Ordering::Equal if opposite(i).is_before(&opposite(best)) => i,
            _ => best,
        });
        let [a, b, c] = [longest, longest + 1, longest + 2].map(|i| t[i % 3]);
        let middle = Corner::mix(&a, &b, 0.5);
        covered([a, middle, c], depth - 1, is_bare, into);
        covered([middle, b, c], depth - 1, is_bare, into);
    }
}

/// Corners, middle and places between of a triangle.
fn spots(t: &Triangle) -> [DVec3; SPOTS] {
    let [a, b, c] = t.map(|c| c.at);
    let middle = (a + b + c) / 3.0;
    let half = |p: DVec3, q: DVec3| (p + q) / 2.0;
    let [ab, bc, ca] = [half(a, b), half(b, c), half(c, a)];
    [a, b, c, middle, ab, bc, ca, half(a, middle), half(b, middle), half(c, middle)]
}

/// The part of a convex polygon where `height` is at most 0.
fn clipped(polygon: &[Corner], height: impl Fn(&Corner) -> f64) -> Vec<Corner> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (i, a) in polygon.iter().enumerate() {
        let b = &polygon[(i + 1) % polygon.len()];
        let (ha, hb) = (height(a), height(b));
        if ha <= 0.0 {
            kept.push(*a);
        }
        if ha * hb < 0.0 {
            kept.push(crossing((a, ha), (b, hb)));
        }
    }
    kept
}

/// Where the height between two corners is 0; the same from either side.
fn crossing(a: (&Corner, f64), b: (&Corner, f64)) -> Corner {
    let ((a, ha), (b, hb)) = if b.0.is_before(a.0) { (b, a) } else { (a, b) };
    Corner::mix(a, b, ha / (ha - hb))
}

/// A convex polygon as triangles around its first corner in space, so that a sheet's two sides are
/// cut alike.
fn fan(polygon: &[Corner]) -> Vec<Triangle> {
    let n = polygon.len();
    let first = (1..n).fold(0, |f, k| if polygon[k].is_before(&polygon[f]) { k } else { f });
    let at = |k: usize| polygon[(first + k) % n];
    (2..n).map(|k| [at(0), at(k - 1), at(k)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::hulls::decompose;
    use crate::collision::hulls::tests::add_box;
    use crate::collision::piece::ConvexPiece;

    fn block(min: [f64; 3], max: [f64; 3]) -> Mesh {
        let mut soup = (Vec::new(), Vec::new());
        add_box(&mut soup, min, max);
        Mesh::new(soup.0, soup.1).unwrap()
    }

    fn pieces(mesh: &Mesh) -> Vec<ConvexPiece> {
        decompose(mesh, 0.01).unwrap()
    }

    #[test]
    fn a_panel_that_gave_way_to_a_knob_shows_a_hole_under_it() {
        lost_to_a_knob_from(-0.1);
    }

    #[test]
    fn a_side_level_with_the_sockets_floor_is_cut_once() {
        lost_to_a_knob_from(0.005);
    }

    fn lost_to_a_knob_from(bottom: f64) {
        let panel = block([0.0, 0.0, 0.0], [1.0, 1.0, 0.02]);
        let knob = block([0.4, 0.4, bottom], [0.6, 0.6, 0.1]);
        let frame = [([0.0, 0.0], [0.4, 1.0]), ([0.6, 0.0], [1.0, 1.0]), ([0.4, 0.0], [0.6, 0.4])];
        let frame = frame.into_iter().chain([([0.4, 0.6], [0.6, 1.0])]);
        let boxes = frame.map(|(a, b)| block([a[0], a[1], 0.0], [b[0], b[1], 0.02]));
        let ring: Vec<_> = boxes.flat_map(|b| pieces(&b)).collect();
        let (whole, both) = ([pieces(&panel), pieces(&knob)], [ring, pieces(&knob)]);
        let seen = cut(&[&panel, &knob].map(Whole::new), [&whole, &both], &["panel", "knob"], 0.02)
            .unwrap();
        let lost = area_of(&panel) - area_of(&seen[0].mesh);
        let bare = (0.2f64 - 2.0 * 0.85 * 0.02).powi(2);
        assert!(lost > 2.0 * bare && lost < 2.0 * 0.21f64.powi(2), "{lost}");
        assert_eq!(seen[1].mesh, knob);
        assert!(seen[0].change.as_ref().unwrap().part == "panel" && seen[1].change.is_none());
    }

    #[test]
    fn what_has_its_own_piece_behind_it_stays_though_hidden() {
        let panel = block([0.0, 0.0, 0.0], [1.0, 1.0, 0.02]);
        let knob = block([0.4, 0.4, -0.1], [0.6, 0.6, 0.1]);
        let both = [pieces(&panel), pieces(&knob)];
        let whole = both.clone();
        let seen = cut(&[&panel, &knob].map(Whole::new), [&whole, &both], &["panel", "knob"], 0.02)
            .unwrap();
        assert_eq!((&seen[0].mesh, &seen[1].mesh), (&panel, &knob));
        assert!(seen.iter().all(|s| s.change.is_none()));
    }

    #[test]
    fn of_two_faces_that_a_cut_leaves_wound_against_each_other_the_lesser_goes_if_it_is_small() {
        let (near, far) = (DVec3::new(0.001, 0.0, 0.0), DVec3::new(0.0, 0.0, 0.0005));
        let corners =
            vec![DVec3::ZERO, DVec3::Y * 0.001, near, far, DVec3::X, DVec3::new(1.0, 1.0, 0.0)];
        let wound = |more: &[[u32; 3]]| {
            let faces = [&[[0, 1, 2], [0, 1, 3]], more].concat();
            without_remnants(Mesh::new(corners.clone(), faces).unwrap()).unwrap()
        };
        assert_eq!(wound(&[[0, 4, 5]]).faces().len(), 2);
        assert_eq!(wound(&[[0, 4, 5]]).area(0), 5e-7, "the larger stays");
        assert_eq!(wound(&[]).faces().len(), 2, "what is no remnant stays");
    }
}
