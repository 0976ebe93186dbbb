//! What geoms weigh, where an MJCF body does not say what it weighs itself.

use std::f64::consts::PI;

use glamx::{DMat3, DPose3, DVec3};
use object::Mesh;
use roxmltree::Node;

use super::attributes::{Element, FromGeoms};
use super::meshes::hull;
use super::model::Model;
use crate::mass::inertia::{Moments, principal_axes};
use crate::mass::lump::Lump;
use crate::robot::{Geometry, Inertial};

/// A solid of density 1.
pub(super) struct Solid {
    volume: f64,
    centre: DVec3,
    /// Inertia about the centre per kilogram, m².
    inertia: DMat3,
}

/// A geom's mass where it stands.
pub(super) struct Weight(Lump);

impl Solid {
    /// Its mass, or else its volume times the density, at a place.
    pub(super) fn weighing(&self, mass: Option<f64>, density: f64, at: DPose3) -> Weight {
        let mass = mass.unwrap_or(density * self.volume);
        let turn = DMat3::from_quat(at.rotation);
        let inertia = turn * (self.inertia * mass) * turn.transpose();
        Weight(Lump { mass, com: at.transform_point(self.centre), inertia })
    }
}

/// How a mesh is weighed, in MuJoCo's words.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Weighing {
    /// Unless said otherwise: every face with the middle of all as a solid, whichever side of it
    /// the middle lies on. What bends inwards weighs too much.
    #[default]
    Legacy,
    /// As its convex hull.
    Convex,
    /// As the solid that it encloses.
    Exact,
    /// As its surface alone.
    Shell,
}

impl Weighing {
    /// The way a word of MJCF names, if it is one.
    pub(super) fn of(word: &str) -> Option<Self> {
        match word {
            "legacy" => Some(Self::Legacy),
            "convex" => Some(Self::Convex),
            "exact" => Some(Self::Exact),
            "shell" => Some(Self::Shell),
            _ => None,
        }
    }

    fn solid(self, mesh: &Mesh) -> Option<Solid> {
        let of = |moments: Moments| {
            let (centre, inertia) = moments.per_kilogram()?;
            Some(Solid { volume: moments.measure, centre, inertia })
        };
        match self {
            Self::Legacy => legacy(mesh),
            Self::Exact => of(Moments::solid(mesh)),
            Self::Shell => of(Moments::shell(mesh)),
            Self::Convex => {
                let (points, faces) = hull(mesh.vertices())?;
                of(Moments::solid(&Mesh::new(points, faces).ok()?))
            }
        }
    }
}

/// As MuJoCo 4.0.0 computes it: the centre by volumes seen from the middle of the surface; volume
/// and inertia by volumes seen from that centre. None of them is ever negative.
fn legacy(mesh: &Mesh) -> Option<Solid> {
    let (middle, _) = Moments::shell(mesh).per_kilogram()?;
    let (centre, _) = Moments::unsigned(mesh, middle).per_kilogram()?;
    let moments = Moments::unsigned(mesh, centre);
    let inertia = moments.per_kilogram_about(centre)?;
    Some(Solid { volume: moments.measure, centre, inertia })
}

/// The solid a geometry fills; `None` where it fills nothing that can be told.
pub(super) fn solid(geometry: &Geometry, way: Weighing) -> Option<Solid> {
    let about = |volume: f64, moments: DVec3| {
        let inertia = DMat3::from_diagonal(moments);
        (volume > 0.0).then_some(Solid { volume, centre: DVec3::ZERO, inertia })
    };
    let ellipsoid = |half: DVec3| {
        let s = half * half;
        let moments = DVec3::new(s.y + s.z, s.x + s.z, s.x + s.y) / 5.0;
        about(4.0 / 3.0 * PI * half.x * half.y * half.z, moments)
    };
    match geometry {
        Geometry::Box { size } => {
            let s = *size * *size;
            let moments = DVec3::new(s.y + s.z, s.x + s.z, s.x + s.y) / 12.0;
            about(size.x * size.y * size.z, moments)
        }
        Geometry::Cylinder { radius, length } => {
            let (volume, along, across) = cylinder(*radius, *length);
            about(volume, DVec3::new(across, across, along))
        }
        Geometry::Capsule { radius, length } => {
            let (volume, moments) = capsule(*radius, *length);
            about(volume, moments)
        }
        Geometry::Sphere { radius } => ellipsoid(DVec3::splat(*radius)),
        Geometry::Ellipsoid { half } => ellipsoid(*half),
        Geometry::Mesh(mesh) => way.solid(mesh),
        Geometry::Unread { .. } => None,
    }
}

/// Volume, and moments along and across the axis per kilogram.
fn cylinder(radius: f64, length: f64) -> (f64, f64, f64) {
    let square = radius * radius;
    (PI * square * length, square / 2.0, (3.0 * square + length * length) / 12.0)
}

/// Volume and moments per kilogram of a cylinder with half balls at its ends.
fn capsule(radius: f64, length: f64) -> (f64, DVec3) {
    let (tube, along, across) = cylinder(radius, length);
    let ball = 4.0 / 3.0 * PI * radius.powi(3);
    let (square, whole) = (radius * radius, tube + ball);
    let caps = 0.4 * square + length * length / 4.0 + 0.375 * length * radius;
    let across = (tube * across + ball * caps) / whole;
    let along = (tube * along + ball * 0.4 * square) / whole;
    (whole, DVec3::new(across, across, along))
}

/// The same inertia with no principal moment below the least; where they break the triangle
/// inequality and that is to be balanced, all three are their mean.
fn bounded(inertia: DMat3, least: f64, balances: bool) -> DMat3 {
    let Some((moments, axes)) = principal_axes(inertia) else { return inertia };
    let mut moments = moments.max(DVec3::splat(least));
    let breaks = 2.0 * moments.max_element() > moments.element_sum();
    if breaks && balances {
        moments = DVec3::splat(moments.element_sum() / 3.0);
    }
    axes * DMat3::from_diagonal(moments) * axes.transpose()
}

impl Model<'_, '_> {
    /// Mass and inertia of a body whose frame stands at `own` in its link's: as told, or from its
    /// geoms, whose weights stand in the link's frame already.
    pub(super) fn inertial(
        &mut self,
        told: Option<&Element>,
        own: DPose3,
        weights: &[Weight],
        line: u32,
    ) -> Option<Inertial> {
        let told = told.filter(|_| self.compiler.from_geoms != FromGeoms::Always);
        if let Some(element) = told {
            return Some(self.told_inertial(element, own));
        }
        if self.compiler.from_geoms == FromGeoms::Never {
            return None;
        }
        let all = weights.iter().fold(Lump::EMPTY, |sum, w| sum.with(w.0));
        let Lump { mass, com, inertia } = all;
        (mass > 0.0).then(|| Inertial {
            origin: DPose3::from_translation(com),
            mass,
            inertia,
            line,
        })
    }

    /// What the compiler's settings make of all masses once they are known.
    pub(super) fn bound_masses(&mut self, root: Node) {
        let [mass, moment] = self.compiler.least;
        let balances = self.compiler.balances;
        for inertial in self.draft.links.iter_mut().filter_map(|l| l.inertial.as_mut()) {
            if mass > 0.0 {
                inertial.mass = inertial.mass.max(mass);
            }
            if moment > 0.0 || balances {
                inertial.inertia = bounded(inertial.inertia, moment, balances);
            }
        }
        let Some(total) = self.compiler.total else { return };
        let inertials = self.draft.links.iter_mut().filter_map(|l| l.inertial.as_mut());
        let all: Vec<_> = inertials.collect();
        let sum: f64 = all.iter().map(|i| i.mass).sum();
        if !(sum > 0.0 && sum.is_finite()) {
            return self.reader.fault(root, "settotalmass: the bodies weigh nothing to scale");
        }
        for inertial in all {
            inertial.mass *= total / sum;
            inertial.inertia *= total / sum;
        }
    }

    fn told_inertial(&mut self, element: &Element, own: DPose3) -> Inertial {
        let line = self.reader.line(element.node);
        let mass = self.number(element, "mass").unwrap_or(0.0);
        let place = self.place(element);
        let full = self.numbers(element, "fullinertia", 6);
        let diagonal = self.vector(element, "diaginertia");
        let inertia = match (full, diagonal) {
            (Some(m), _) => {
                let column = DVec3::new;
                DMat3::from_cols(
                    column(m[0], m[3], m[4]),
                    column(m[3], m[1], m[5]),
                    column(m[4], m[5], m[2]),
                )
            }
            (None, Some(d)) => DMat3::from_diagonal(d),
            (None, None) => {
                self.reader.fault(element.node, "has neither `diaginertia` nor `fullinertia`");
                DMat3::ZERO
            }
        };
        Inertial { origin: own * place, mass, inertia, line }
    }
}
