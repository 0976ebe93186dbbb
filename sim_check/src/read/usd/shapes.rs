//! Shapes of USD prims, told in the frame of the body they belong to.

use std::sync::Arc;

use glamx::{DMat3, DPose3, DQuat, DVec3};
use object::Mesh;

use super::model::{Usd, is_length};
use crate::read::assembly::relative;
use crate::read::cone::cone;
use crate::robot::{Geometry, Shape};

/// How much the scales of a round shape may differ and still be one.
const EVEN: f64 = 1e-6;

/// A shape and what it is for.
pub(super) struct Part {
    pub shape: Shape,
    pub prim: usize,
    pub is_seen: bool,
    pub is_touched: bool,
}

impl Usd<'_> {
    /// The shapes among some prims, in a frame of the world.
    pub(super) fn shapes(&mut self, among: &[usize], frame: DPose3) -> Vec<Part> {
        let shapes = among.iter().copied().filter(|p| self.prims.is_shape(*p));
        shapes.collect::<Vec<_>>().into_iter().filter_map(|p| self.part(p, frame)).collect()
    }

    fn part(&mut self, prim: usize, frame: DPose3) -> Option<Part> {
        let of = self.prims.prim(prim);
        let is_touched = self.prims.collides(prim);
        let is_drawn = matches!(of.purpose.as_str(), "default" | "render") && !of.is_hidden;
        // A plane is the ground and no part of anything.
        if of.kind == "Plane" || !(is_touched || is_drawn) {
            return None;
        }
        let (origin, geometry) = match of.kind.as_str() {
            "Mesh" => self.mesh(prim, frame, is_touched),
            _ => self.primitive(prim, frame),
        };
        let size = match &geometry {
            Geometry::Box { size } => *size,
            Geometry::Ellipsoid { half } => *half,
            Geometry::Cylinder { radius, length } | Geometry::Capsule { radius, length } => {
                DVec3::new(*radius, *length, 0.0)
            }
            Geometry::Sphere { radius } => DVec3::splat(*radius),
            Geometry::Mesh(mesh) => mesh.bounds().min.abs().max(mesh.bounds().max.abs()),
            Geometry::Unread { .. } => DVec3::ZERO,
        };
        let geometry = match is_length(size) {
            true => geometry,
            false => {
                let reason = format!("{}: its size {size} is beyond all bounds", self.at(prim));
                self.draft.faults.numbers.push(reason.clone());
                Geometry::Unread { reason }
            }
        };
        let line = self.line(prim);
        let source = self.prims.path(prim).to_owned();
        let (scale, colour, mask) = (DVec3::ONE, self.colour(prim), [1, 1]);
        let shape = Shape { origin, geometry, scale, source, colour, mask, line };
        Some(Part { shape, prim, is_seen: is_drawn, is_touched })
    }

    /// What a material says of the colour, as far as it is plain; linear in USD, sRGB here.
    fn colour(&self, prim: usize) -> Option<[u8; 4]> {
        let material = self.prims.targets(prim, "material:binding").first()?;
        let material = self.prims.find(material)?;
        let is_shader = |p: &usize| {
            self.prims.kind(*p) == "Shader"
                && self.prims.word(*p, "info:id") == Some("UsdPreviewSurface")
        };
        let shader = self.prims.below(material).find(is_shader)?;
        let light = self.prims.numbers(shader, "inputs:diffuseColor").filter(|c| c.len() == 3)?;
        let byte = |c: f64| (object::glb::srgb_of_linear(c.clamp(0.0, 1.0)) * 255.0).round() as u8;
        Some([byte(light[0]), byte(light[1]), byte(light[2]), 255])
    }

    fn mesh(&mut self, prim: usize, frame: DPose3, is_touched: bool) -> (DPose3, Geometry) {
        let at = self.at(prim);
        let unread =
            |why: String| (DPose3::identity(), Geometry::Unread { reason: format!("{at}: {why}") });
        let told = self.prims.word(prim, "physics:approximation").unwrap_or("none");
        let approximation = if is_touched { told.to_owned() } else { "none".to_owned() };
        let Some(surface) = &self.prims.prim(prim).surface else {
            return unread("a mesh without points".into());
        };
        // The body's frame in the world is a turn and a shift.
        let into = relative(frame, DPose3::identity());
        let point = |p: &[f64; 3]| into * self.prims.point(prim, DVec3::from_array(*p));
        let points: Vec<DVec3> = surface.points.iter().map(point).collect();
        let is_mirrored = self.prims.linear(prim).determinant() < 0.0;
        let mut faces = Vec::new();
        for face in &surface.faces {
            let mut corners = face.iter().copied();
            let (Some(hub), Some(mut last)) = (corners.next(), corners.next()) else { continue };
            for next in corners {
                faces.push(if is_mirrored { [hub, next, last] } else { [hub, last, next] });
                last = next;
            }
        }
        let mesh = match Mesh::new(points, faces) {
            Ok(mesh) => mesh,
            Err(e) => {
                let reason = format!("{at}: mesh `{}` is unreadable: {e}", self.prims.name(prim));
                self.draft.faults.files.push(reason.clone());
                return (DPose3::identity(), Geometry::Unread { reason });
            }
        };
        match approximation.as_str() {
            "none" | "convexHull" | "meshSimplification" | "sdf" => {
                (DPose3::identity(), Geometry::Mesh(Arc::new(mesh)))
            }
            "boundingCube" => {
                let bounds = mesh.bounds();
                let size = bounds.max - bounds.min;
                (DPose3::from_translation(bounds.centre()), Geometry::Box { size })
            }
            other => unread(format!("its approximation `{other}` is made by the simulator")),
        }
    }

    fn primitive(&self, prim: usize, frame: DPose3) -> (DPose3, Geometry) {
        let said = |name: &str, unsaid: f64| self.prims.number(prim, name).unwrap_or(unsaid);
        let scale = self.prims.scale(prim);
        let axis = self.prims.word(prim, "axis").unwrap_or("Z");
        let (turn, along, across) = match axis {
            "X" => {
                (DQuat::from_rotation_y(std::f64::consts::FRAC_PI_2), scale.x, [scale.y, scale.z])
            }
            "Y" => {
                (DQuat::from_rotation_x(-std::f64::consts::FRAC_PI_2), scale.y, [scale.x, scale.z])
            }
            _ => (DQuat::IDENTITY, scale.z, [scale.x, scale.y]),
        };
        let is_even = |a: f64, b: f64| (a - b).abs() <= EVEN * a.max(b);
        let is_round = is_even(across[0], across[1]);
        let sheared = {
            let linear = self.prims.linear(prim);
            let straight = DMat3::from_quat(self.prims.turn(prim)) * DMat3::from_diagonal(scale);
            let off = [0, 1, 2].map(|c| (linear.col(c) - straight.col(c)).length());
            off.iter().any(|o| *o > EVEN * scale.max_element()) && linear.determinant() > 0.0
        };
        let unread = |why: &str| Geometry::Unread { reason: format!("{}: {why}", self.at(prim)) };
        let kind = self.prims.kind(prim);
        let geometry = match kind {
            _ if sheared => unread("a shape that is sheared is not read here"),
            "Cube" => Geometry::Box { size: scale * said("size", 2.0) },
            "Sphere" => {
                let radius = said("radius", 1.0);
                match is_round && is_even(along, across[0]) {
                    true => Geometry::Sphere { radius: radius * along },
                    false => Geometry::Ellipsoid { half: scale * radius },
                }
            }
            "Cylinder" | "Cone" if is_round => {
                let (radius, length) =
                    (said("radius", 1.0) * across[0], said("height", 2.0) * along);
                match kind {
                    "Cone" => cone(radius, length, self.line(prim)),
                    _ => Geometry::Cylinder { radius, length },
                }
            }
            "Capsule" if is_round && is_even(along, across[0]) => Geometry::Capsule {
                radius: said("radius", 0.5) * along,
                length: said("height", 1.0) * along,
            },
            _ => unread("a round shape that is scaled unevenly is not read here"),
        };
        let own = self.prims.pose(prim);
        let turn = if kind == "Cube" || kind == "Sphere" { DQuat::IDENTITY } else { turn };
        (relative(frame, own) * DPose3::from_parts(DVec3::ZERO, turn), geometry)
    }
}
