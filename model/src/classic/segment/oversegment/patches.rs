//! Cuts a fused mesh into smooth patches, and says what the borders between patches look like.

use std::collections::BTreeMap;

use object::Mesh;
use object::weld::{Neighbour, Weld};

use crate::classic::segment::grow::merge::{Link, groups};

/// How a surface falls into patches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cutting {
    /// Patches merge while their common border turns by less than this on average, radians.
    smooth: f64,
    /// A convex turn counts this much of a concave one: parts meet in grooves, not on ridges.
    ridge: f64,
}

impl Cutting {
    /// How surfaces are cut where they are cut once.
    pub(crate) const USUAL: Self = Self { smooth: 0.2, ridge: 0.5 };
    /// How else fused meshes are cut: finer, coarser, with less and with more regard for ridges. Which patch a
    /// doubtful seam ends up in is a matter of chance, and of several cuts less so.
    pub(crate) const OTHERS: [Self; 4] = [
        Self { smooth: 0.14, ..Self::USUAL },
        Self { smooth: 0.28, ..Self::USUAL },
        Self { ridge: 0.25, ..Self::USUAL },
        Self { ridge: 1.0, ..Self::USUAL },
    ];

    /// All cuts for which patches merge in the same order, and so are found together: with the same regard
    /// for ridges.
    pub(crate) fn alike(self) -> Vec<Self> {
        let all = std::iter::once(Self::USUAL).chain(Self::OTHERS);
        all.filter(|other| other.ridge.to_bits() == self.ridge.to_bits()).collect()
    }
}

/// A turn of more than this, radians, is a clear groove or ridge.
const CLEAR: f64 = 0.35;

/// How the surface turns over an edge between two faces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Turn {
    /// Length of the edge, metres.
    pub length: f64,
    /// Angle between the faces' normals, radians; positive in a groove, negative on a ridge.
    pub angle: f64,
    /// What it costs to flood over the edge: the way from centroid to centroid as a share of the
    /// diagonal, and a hundred times (1 − cos) of the turn, a tenth of that on a ridge.
    pub effort: f64,
}

/// What the border between two patches looks like.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Seam {
    /// Its length, metres.
    pub length: f64,
    /// Mean turn over its length, ridges counting as none, radians.
    pub concave: f64,
    /// Mean turn over its length, grooves counting as none, radians.
    pub convex: f64,
    /// Share of its length that is a clear groove.
    pub sharp: f64,
    /// Share of its length that is a clear ridge.
    pub ridge: f64,
}

/// The turn over an edge.
pub(crate) fn turn(mesh: &Mesh, weld: &Weld, e: &Neighbour, diagonal: f64) -> Turn {
    let (f, g) = (e.first as usize, e.second as usize);
    let (nf, ng) = (mesh.normal(f), mesh.normal(g));
    let across = mesh.centroid(g) - mesh.centroid(f);
    let cos = nf.dot(ng).clamp(-1.0, 1.0);
    let groove = across.dot(nf) > across.dot(ng);
    let [p, q] = e.edge.map(|place| weld.places[place as usize]);
    let share = if groove { 1.0 } else { 0.1 };
    let flat = nf.length_squared() == 0.0 || ng.length_squared() == 0.0;
    let (angle, cos) = if flat { (0.0, 1.0) } else { (cos.acos(), cos) };
    Turn {
        length: p.distance(q),
        angle: if groove { angle } else { -angle },
        effort: across.length() / diagonal + 100.0 * (1.0 - cos) * share,
    }
}

/// For each of some ways to cut that are [`Cutting::alike`], the patch of each face, and how many patches
/// there are; faces without edges are their own.
pub(crate) fn patches(
    turns: &[Turn],
    edges: &[Neighbour],
    faces: usize,
    alike: &[Cutting],
) -> Vec<(Vec<u32>, usize)> {
    let ridge = alike.first().map_or(0.0, |cutting| cutting.ridge);
    let link = |(e, t): (&Neighbour, &Turn)| {
        let sharp = t.angle.max(-t.angle * ridge);
        Link { a: e.first, b: e.second, evidence: -sharp, weight: t.length, barrier: 0.0 }
    };
    let links: Vec<Link> = edges.iter().zip(turns).map(link).collect();
    let stops: Vec<f64> = alike.iter().map(|cutting| -cutting.smooth).collect();
    groups(faces, &links, &stops)
}

/// The borders between patches, by pair, the lower number first.
pub(crate) fn seams<'a>(
    edges: impl Iterator<Item = (&'a Neighbour, &'a Turn)>,
    patch: &[u32],
) -> BTreeMap<(u32, u32), Seam> {
    let mut seams: BTreeMap<(u32, u32), Seam> = BTreeMap::new();
    for (e, t) in edges {
        let (p, q) = (patch[e.first as usize], patch[e.second as usize]);
        if p != q {
            let seam = seams.entry((p.min(q), p.max(q))).or_default();
            seam.length += t.length;
            seam.concave += t.length * t.angle.max(0.0);
            seam.convex += t.length * (-t.angle).max(0.0);
            seam.sharp += if t.angle > CLEAR { t.length } else { 0.0 };
            seam.ridge += if t.angle < -CLEAR { t.length } else { 0.0 };
        }
    }
    for seam in seams.values_mut() {
        seam.concave /= seam.length.max(f64::MIN_POSITIVE);
        seam.convex /= seam.length.max(f64::MIN_POSITIVE);
        seam.sharp /= seam.length.max(f64::MIN_POSITIVE);
        seam.ridge /= seam.length.max(f64::MIN_POSITIVE);
    }
    seams
}
