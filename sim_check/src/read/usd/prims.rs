//! The prims of a stage in metres, kilograms and a frame with z up.

use std::collections::BTreeMap;

use glamx::{DMat3, DPose3, DQuat, DVec3};
use object::usd::prims::{Prim, Stage};

use crate::read::draft::MAX_LENGTH;

/// A stage's prims and what each belongs to.
pub(super) struct Prims {
    all: Vec<Prim>,
    /// Metres a unit.
    pub metres: f64,
    /// Kilograms a unit.
    pub kilograms: f64,
    /// From the stage's frame to one with z up.
    upright: DMat3,
    paths: BTreeMap<String, usize>,
    /// The nearest body of each, itself included.
    bodies: Vec<Option<usize>>,
}

/// Kinds of prims that are shapes.
const SHAPES: &[&str] = &["Mesh", "Cube", "Sphere", "Cylinder", "Capsule", "Cone", "Plane"];

impl Prims {
    /// Refuses units that are none.
    pub(super) fn of(stage: Stage) -> Result<Self, String> {
        let Stage { up, metres, kilograms, prims: all, .. } = stage;
        for (name, unit) in [("metersPerUnit", metres), ("kilogramsPerUnit", kilograms)] {
            if !(unit.is_finite() && unit > 0.0) {
                return Err(format!("{name} must be a number above 0, found {unit}"));
            }
        }
        let upright = match up.as_deref() {
            Some("Z") => DMat3::IDENTITY,
            // Y is up where nothing is said.
            _ => DMat3::from_cols(DVec3::X, DVec3::Z, -DVec3::Y),
        };
        let paths = all.iter().enumerate().map(|(i, p)| (p.path.clone(), i)).collect();
        let mut prims = Self { all, metres, kilograms, upright, paths, bodies: Vec::new() };
        for prim in 0..prims.all.len() {
            prims.judge_place(prim)?;
            let above = prims.all[prim].above.and_then(|above| prims.bodies[above]);
            let own = if prims.is_body(prim) { Some(prim) } else { above };
            prims.bodies.push(own);
        }
        Ok(prims)
    }

    /// Refuses a prim that stands nowhere: what is below it would, too.
    fn judge_place(&self, prim: usize) -> Result<(), String> {
        let (linear, at) = (self.linear(prim), self.point(prim, DVec3::ZERO));
        let all = [linear.col(0), linear.col(1), linear.col(2), at];
        let is_sound = |v: &DVec3| v.is_finite() && v.abs().max_element() <= MAX_LENGTH;
        match all.iter().all(is_sound) {
            true => Ok(()),
            false => {
                let path = self.path(prim);
                Err(format!("`{path}` must stand within {MAX_LENGTH:e} m, found {at}"))
            }
        }
    }

    pub(super) fn all(&self) -> impl Iterator<Item = usize> + use<> {
        0..self.all.len()
    }

    pub(super) fn prim(&self, prim: usize) -> &Prim {
        &self.all[prim]
    }

    pub(super) fn kind(&self, prim: usize) -> &str {
        &self.all[prim].kind
    }

    pub(super) fn path(&self, prim: usize) -> &str {
        &self.all[prim].path
    }

    pub(super) fn name(&self, prim: usize) -> &str {
        self.path(prim).rsplit('/').next().unwrap_or_default()
    }

    pub(super) fn find(&self, path: &str) -> Option<usize> {
        self.paths.get(path).copied()
    }

    pub(super) fn has(&self, prim: usize, schema: &str) -> bool {
        self.all[prim].schemas.iter().any(|s| s == schema)
    }

    pub(super) fn flag(&self, prim: usize, name: &str, unsaid: bool) -> bool {
        self.number(prim, name).map_or(unsaid, |n| n != 0.0)
    }

    pub(super) fn numbers(&self, prim: usize, name: &str) -> Option<&[f64]> {
        self.all[prim].numbers.get(name).map(Vec::as_slice)
    }

    pub(super) fn number(&self, prim: usize, name: &str) -> Option<f64> {
        self.numbers(prim, name).filter(|all| all.len() == 1).map(|all| all[0])
    }

    pub(super) fn word(&self, prim: usize, name: &str) -> Option<&str> {
        self.all[prim].words.get(name).map(String::as_str)
    }

    pub(super) fn targets(&self, prim: usize, name: &str) -> &[String] {
        self.all[prim].targets.get(name).map_or(&[], Vec::as_slice)
    }

    pub(super) fn is_body(&self, prim: usize) -> bool {
        self.has(prim, "PhysicsRigidBodyAPI") && self.flag(prim, "physics:rigidBodyEnabled", true)
    }

    pub(super) fn is_shape(&self, prim: usize) -> bool {
        SHAPES.contains(&self.kind(prim))
    }

    /// Whether it collides: itself, or as a part of something that does.
    pub(super) fn collides(&self, prim: usize) -> bool {
        let mut at = Some(prim);
        while let Some(p) = at {
            if self.has(p, "PhysicsCollisionAPI") {
                return self.flag(p, "physics:collisionEnabled", true);
            }
            // A shape answers for itself; what collides as a whole is no body.
            at = self.all[p].above.filter(|_| !self.is_body(p)).filter(|a| !self.is_body(*a));
        }
        false
    }

    /// The nearest body of a prim, itself included.
    pub(super) fn body_of(&self, prim: usize) -> Option<usize> {
        self.bodies[prim]
    }

    /// The prims that belong to a body.
    pub(super) fn inside(&self, body: usize) -> impl Iterator<Item = usize> + '_ {
        self.all().filter(move |p| self.bodies[*p] == Some(body))
    }

    /// What stands below a prim: each prim comes before those below it, and they before its neighbours.
    pub(super) fn below(&self, prim: usize) -> impl Iterator<Item = usize> + '_ {
        (prim + 1..self.all.len()).take_while(move |p| self.is_under(*p, prim))
    }

    pub(super) fn is_under(&self, prim: usize, above: usize) -> bool {
        let mut at = Some(prim);
        while let Some(p) = at {
            if p == above {
                return true;
            }
            at = self.all[p].above;
        }
        false
    }

    /// What turns, scales and shears a prim's own directions into metres of the world.
    pub(super) fn linear(&self, prim: usize) -> DMat3 {
        let [x, y, z, _] = self.all[prim].place.map(DVec3::from_array);
        self.upright * DMat3::from_cols(x, y, z) * self.metres
    }

    /// A point of a prim in the world, metres.
    pub(super) fn point(&self, prim: usize, p: DVec3) -> DVec3 {
        let shift = DVec3::from_array(self.all[prim].place[3]);
        self.linear(prim) * p + self.upright * shift * self.metres
    }

    /// A place told in the stage's own frame, and how that is turned.
    pub(super) fn world(&self, at: DVec3) -> (DVec3, DQuat) {
        let turn = match self.upright == DMat3::IDENTITY {
            true => DQuat::IDENTITY,
            false => DQuat::from_mat3(&self.upright),
        };
        (self.upright * at * self.metres, turn)
    }

    /// Where a prim stands in the world, without its scale.
    pub(super) fn pose(&self, prim: usize) -> DPose3 {
        DPose3::from_parts(self.point(prim, DVec3::ZERO), self.turn(prim))
    }

    /// How a prim is turned in the world.
    pub(super) fn turn(&self, prim: usize) -> DQuat {
        let linear = self.linear(prim);
        let x = linear.col(0).normalize_or(DVec3::X);
        let y = linear.col(1).reject_from_normalized(x).normalize_or(x.any_orthonormal_vector());
        let turn = DMat3::from_cols(x, y, x.cross(y));
        if turn == DMat3::IDENTITY { DQuat::IDENTITY } else { DQuat::from_mat3(&turn) }
    }

    /// How long a prim's own directions are in the world, metres.
    pub(super) fn scale(&self, prim: usize) -> DVec3 {
        let linear = self.linear(prim);
        DVec3::new(linear.col(0).length(), linear.col(1).length(), linear.col(2).length())
    }
}
