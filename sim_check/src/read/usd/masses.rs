//! What a USD body weighs: as told, or by its colliders.

use glamx::{DMat3, DPose3, DQuat};

use super::model::{Usd, is_length, vector};
use super::shapes::Part;
use crate::mass::solid::{Weight, solid, together};
use crate::read::depends::WEIGHED;
use crate::robot::{Inertial, Shape, Unread};

/// Density of what states none, kg/m³: UsdPhysics' own.
const DENSITY: f64 = 1000.0;

impl Usd<'_> {
    /// Mass and inertia in the body's frame; of what is no number nothing is known.
    pub(super) fn inertial(&mut self, body: usize, parts: &[Part]) -> Option<Inertial> {
        let found = self.found_inertial(body, parts)?;
        let Inertial { origin, mass, inertia, .. } = &found;
        let moments = [inertia.col(0), inertia.col(1), inertia.col(2)];
        let is_sound = mass.is_finite()
            && moments.iter().all(|m| m.is_finite())
            && is_length(origin.translation)
            && origin.rotation.is_finite();
        if !is_sound {
            let what = format!("{}: its mass or inertia is beyond all bounds", self.at(body));
            self.draft.faults.numbers.push(what.clone());
            self.draft.beside.unread.push(Unread { what, checks: WEIGHED });
            return None;
        }
        Some(found)
    }

    fn found_inertial(&mut self, body: usize, parts: &[Part]) -> Option<Inertial> {
        let line = self.line(body);
        let (metres, kilograms) = (self.prims.metres, self.prims.kilograms);
        let above_zero = |n: Option<f64>| n.filter(|n| *n > 0.0);
        let told = above_zero(self.prims.number(body, "physics:mass")).map(|m| m * kilograms);
        let moments = self.prims.numbers(body, "physics:diagonalInertia").and_then(vector);
        let moments = moments.filter(|m| m.min_element() > 0.0);
        // Where nothing is said the centre is at minus infinity, as the schema has it.
        let centre = self.prims.numbers(body, "physics:centerOfMass").and_then(vector);
        let centre = centre.filter(|c| c.is_finite()).map(|c| c * self.prims.scale(body));
        if let (Some(mass), Some(moments), Some(centre)) = (told, moments, centre) {
            let inertia = DMat3::from_diagonal(moments * (kilograms * metres * metres));
            let origin = DPose3::from_parts(centre, self.axes(body));
            return Some(Inertial { origin, mass, inertia, line });
        }
        let own = above_zero(self.prims.number(body, "physics:density"));
        let mut weights: Vec<Weight> = Vec::new();
        for Part { shape, prim, is_touched, .. } in parts {
            if !is_touched {
                continue;
            }
            match self.weight(*prim, shape, own) {
                Some(weight) => weights.push(weight),
                None => {
                    self.unread(*prim, "what it weighs cannot be told", WEIGHED);
                    return None;
                }
            }
        }
        let by_shapes = together(&weights, line);
        match (by_shapes, told) {
            (Some(all), _) => {
                let mass = told.unwrap_or(all.mass);
                let mut inertial =
                    Inertial { mass, inertia: all.inertia * (mass / all.mass), ..all };
                if let Some(centre) = centre {
                    inertial.origin.translation = centre;
                }
                if let Some(moments) = moments {
                    inertial.origin.rotation = self.axes(body);
                    inertial.inertia =
                        DMat3::from_diagonal(moments * (kilograms * metres * metres));
                }
                Some(inertial)
            }
            (None, Some(_)) => {
                self.unread(body, "its inertia is left to the simulator", WEIGHED);
                None
            }
            (None, None) => None,
        }
    }

    /// The axes that a body's inertia is told in.
    fn axes(&self, body: usize) -> DQuat {
        let told = self.prims.numbers(body, "physics:principalAxes").unwrap_or_default();
        let &[x, y, z, w] = told else { return DQuat::IDENTITY };
        let told = DQuat::from_xyzw(x, y, z, w);
        let is_turn = told.is_finite() && told.length() > 1e-6;
        if is_turn { told.normalize() } else { DQuat::IDENTITY }
    }

    fn weight(&self, prim: usize, shape: &Shape, of_body: Option<f64>) -> Option<Weight> {
        let above_zero = |n: Option<f64>| n.filter(|n| *n > 0.0);
        let (metres, kilograms) = (self.prims.metres, self.prims.kilograms);
        let mass = above_zero(self.prims.number(prim, "physics:mass")).map(|m| m * kilograms);
        let material = ["material:binding:physics", "material:binding"];
        let material = material.iter().find_map(|n| self.prims.targets(prim, n).first());
        let material = material.and_then(|path| self.prims.find(path));
        let of_material =
            material.and_then(|m| above_zero(self.prims.number(m, "physics:density")));
        let told =
            above_zero(self.prims.number(prim, "physics:density")).or(of_body).or(of_material);
        let density = told.map_or(DENSITY, |d| d * kilograms / metres.powi(3));
        Some(solid(&shape.geometry)?.weighing(mass, density, shape.origin))
    }
}
