//! Units: the smallest things a part without a point could be made of. They are components, and
//! smooth patches of a fused mesh that holds nearly everything.

use std::collections::BTreeMap;

use object::mesh::Bounds;
use object::weld::{Neighbour, Weld};
use object::{DMat3, DVec3, Mesh};

use crate::classic::segment::grow::evidence::{of_contacts, of_seams};
use crate::classic::segment::grow::merge::Link;
use crate::classic::segment::oversegment::contact::{Body, Touch, near, touches};
use crate::classic::segment::oversegment::patches::{Cutting, Turn, patches, seams, turn};
use crate::classic::segment::oversegment::segment::Segment;

/// A component with more than this share of the surface is a fused mesh over several parts.
const FUSED: f64 = 0.8;

/// The surface in units, and how they hang together.
#[derive(Debug)]
pub(crate) struct Units {
    /// The unit of each face; units are numbered in order of first face.
    pub of_face: Vec<u32>,
    /// What each is.
    pub list: Vec<Unit>,
    /// Contacts and seams between units.
    pub links: Vec<Link>,
    /// For pairs of units that touch, the lower number first: what area of both does, m².
    pub touching: BTreeMap<(u32, u32), f64>,
    /// Box of the whole surface, object frame, metres.
    pub bounds: Bounds,
}

/// One unit.
#[derive(Clone, Debug)]
pub(crate) struct Unit {
    /// Its largest face.
    pub face: u32,
    /// Area, centre and spread.
    pub mass: Mass,
}

/// A surface as its area is spread; those of several add up.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mass {
    /// Area, m².
    pub area: f64,
    /// Integral of the position over the area, m³.
    pub first: DVec3,
    /// Integral of the position's outer square over the area, m⁴.
    pub second: DMat3,
    /// Its box, object frame, metres.
    pub bounds: Bounds,
}

impl Mass {
    /// Nothing.
    pub(crate) fn nothing() -> Self {
        let bounds = Bounds::of([]);
        Self { area: 0.0, first: DVec3::ZERO, second: DMat3::ZERO, bounds }
    }

    /// How the area of a face is spread.
    pub(crate) fn of_face(mesh: &Mesh, face: usize) -> Self {
        let corners = mesh.corners(face);
        let (area, centre) = (mesh.area(face), mesh.centroid(face));
        let square = |p: DVec3| DMat3::from_cols(p * p.x, p * p.y, p * p.z);
        let sum = corners.iter().fold(square(centre) * 9.0, |sum, &p| sum + square(p));
        let second = sum * (area / 12.0);
        Self { area, first: centre * area, second, bounds: Bounds::of(corners) }
    }

    /// Both together.
    pub(crate) fn with(&self, other: &Self) -> Self {
        let (a, b) = (&self.bounds, &other.bounds);
        Self {
            area: self.area + other.area,
            first: self.first + other.first,
            second: self.second + other.second,
            bounds: Bounds { min: a.min.min(b.min), max: a.max.max(b.max) },
        }
    }

    /// Mean position over the area, object frame, metres.
    pub(crate) fn centre(&self) -> DVec3 {
        if self.area > 0.0 { self.first / self.area } else { self.bounds.centre() }
    }

    /// Covariance of the position over the area, m².
    pub(crate) fn spread(&self) -> DMat3 {
        let c = self.centre();
        let square = DMat3::from_cols(c * c.x, c * c.y, c * c.z);
        self.second * (1.0 / self.area.max(f64::MIN_POSITIVE)) - square
    }
}

impl Units {
    /// Cuts the surface: every component is a unit, but a fused mesh that holds nearly everything falls
    /// into its smooth patches.
    pub(crate) fn of(mesh: &Mesh, weld: &Weld, component: &[u32], bodies: &[Body]) -> Self {
        let total: f64 = bodies.iter().map(|b| b.area).sum();
        let fused_surface = |c: u32| bodies[c as usize].area > FUSED * total;
        let inside = |e: &Neighbour| fused_surface(component[e.first as usize]);
        let edges: Vec<Neighbour> = weld.neighbours().into_iter().filter(inside).collect();
        let diagonal = mesh.bounds().diagonal();
        let turns: Vec<Turn> = edges.iter().map(|e| turn(mesh, weld, e, diagonal)).collect();
        let found = patches(&turns, &edges, component.len(), &[Cutting::USUAL]);
        let (patch, _) = found.into_iter().next().unwrap_or_default();
        let key = |f: usize| {
            let c = component[f];
            if fused_surface(c) { (true, patch[f]) } else { (false, c) }
        };
        let mut number = BTreeMap::new();
        let of_face = (0..component.len()).map(|f| {
            let next = number.len() as u32;
            *number.entry(key(f)).or_insert(next)
        });
        let of_face: Vec<u32> = of_face.collect();
        let masses: Vec<Mass> = (0..of_face.len()).map(|face| Mass::of_face(mesh, face)).collect();
        let list = measure(&masses, &of_face);
        let segments: Vec<Segment> = list.iter().map(|u| segment(u, total)).collect();
        let contacts = touches((bodies, &near(bodies, diagonal)), &of_face, diagonal);
        let seams = seams(edges.iter().zip(&turns), &of_face);
        let mut links = of_contacts(&contacts, &segments, diagonal);
        links.extend(of_seams(&seams, &segments, diagonal));
        let mut touching = touching(&contacts);
        let strip = 0.01 * diagonal;
        touching.extend(seams.iter().map(|(&pair, s)| (pair, s.length * strip)));
        Self { of_face, list, links, touching, bounds: mesh.bounds() }
    }
}

/// The units of faces numbered in order of first face.
pub(crate) fn measure(masses: &[Mass], of_face: &[u32]) -> Vec<Unit> {
    let mut units: Vec<Unit> = Vec::new();
    let mut largest: Vec<f64> = Vec::new();
    for ((face, &u), mass) in of_face.iter().enumerate().zip(masses) {
        if u as usize == units.len() {
            units.push(Unit { face: face as u32, mass: Mass::nothing() });
            largest.push(0.0);
        }
        let unit = &mut units[u as usize];
        if mass.area > largest[u as usize] {
            (unit.face, largest[u as usize]) = (face as u32, mass.area);
        }
        unit.mass = unit.mass.with(mass);
    }
    units
}

fn segment(unit: &Unit, total: f64) -> Segment {
    let mass = &unit.mass;
    let share = mass.area / total.max(f64::MIN_POSITIVE);
    // Evidence of links asks for no normal.
    let (centre, normal) = (mass.centre(), DVec3::ZERO);
    Segment { seed: None, share, area: mass.area, centre, bounds: mass.bounds, normal }
}

fn touching(contacts: &BTreeMap<(u32, u32), Touch>) -> BTreeMap<(u32, u32), f64> {
    let mut sums = BTreeMap::new();
    for (&(a, b), touch) in contacts.iter().filter(|(_, t)| t.reaching > 0.0) {
        *sums.entry((a.min(b), a.max(b))).or_insert(0.0) += touch.reaching;
    }
    sums
}
