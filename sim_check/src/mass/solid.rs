//! What the shapes of a model weigh, where it does not say what its links weigh.

use std::f64::consts::PI;

use glamx::{DMat3, DPose3, DVec3};

use super::inertia::Moments;
use super::lump::Lump;
use crate::robot::{Geometry, Inertial};

/// A solid of density 1.
#[derive(Clone, Debug)]
pub(crate) struct Solid {
    pub volume: f64,
    centre: DVec3,
    /// Inertia about the centre per kilogram, m².
    inertia: DMat3,
}

/// A shape's mass where it stands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Weight(Lump);

impl Solid {
    /// A solid of a volume, m³, with its centre and its inertia about that per kilogram, m².
    pub(crate) fn new(volume: f64, centre: DVec3, inertia: DMat3) -> Self {
        Self { volume, centre, inertia }
    }

    /// What some moments are those of; `None` where they enclose nothing.
    pub(crate) fn of(moments: &Moments) -> Option<Self> {
        let (centre, inertia) = moments.per_kilogram()?;
        Some(Self { volume: moments.measure, centre, inertia })
    }

    /// Its mass, or else its volume times the density, at a place.
    pub(crate) fn weighing(&self, mass: Option<f64>, density: f64, at: DPose3) -> Weight {
        let mass = mass.unwrap_or(density * self.volume);
        let turn = DMat3::from_quat(at.rotation);
        let inertia = turn * (self.inertia * mass) * turn.transpose();
        Weight(Lump { mass, com: at.transform_point(self.centre), inertia })
    }

    /// A cone along z whose tip is up, centred halfway between tip and foot.
    pub(crate) fn cone(radius: f64, length: f64) -> Option<Self> {
        let across = 0.15 * radius * radius + 0.0375 * length * length;
        let inertia = DMat3::from_diagonal(DVec3::new(across, across, 0.3 * radius * radius));
        let volume = PI * radius * radius * length / 3.0;
        let centre = DVec3::new(0.0, 0.0, -length / 4.0);
        (volume > 0.0).then_some(Self { volume, centre, inertia })
    }
}

/// All of them as one body, in the frame they stand in.
pub(crate) fn together(weights: &[Weight], line: u32) -> Option<Inertial> {
    let all = weights.iter().fold(Lump::EMPTY, |sum, w| sum.with(w.0));
    let Lump { mass, com, inertia } = all;
    let origin = DPose3::from_translation(com);
    (mass > 0.0).then_some(Inertial { origin, mass, inertia, line })
}

/// The solid a geometry fills; `None` where it fills nothing that can be told.
pub(crate) fn solid(geometry: &Geometry) -> Option<Solid> {
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
        Geometry::Mesh(mesh) => Solid::of(&Moments::solid(mesh)),
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
