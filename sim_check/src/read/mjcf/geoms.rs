//! Geoms of an MJCF body: what is touched, what is only seen, and what each weighs.

use glamx::{DPose3, DQuat, DVec3};

use super::attributes::Element;
use super::model::Model;
use crate::mass::solid::{Weight, solid};
use crate::read::draft::MAX_LENGTH;
use crate::read::rgba::rgba;
use crate::robot::{Geometry, Shape};

/// Density of a geom that states none, kg/m³.
const DENSITY: f64 = 1000.0;
/// The first group that MuJoCo's viewer does not show, by its convention that of collision geometry.
const HIDDEN: f64 = 3.0;
/// The colour of a geom that states none; stated, it gives way to a material all the same.
const UNSAID: [u8; 4] = [128, 128, 128, 255];

/// The shapes of a body.
#[derive(Default)]
pub(super) struct Shapes {
    pub seen: Vec<Shape>,
    pub touched: Vec<Shape>,
    /// What planes may touch.
    pub planes: Vec<[u32; 2]>,
    /// Whether some of what is touched stands in a group that viewers show.
    pub shows: bool,
    /// Whether something that weighs could not be read.
    pub lacks: bool,
    /// What the geoms weigh, in the frame the shapes stand in.
    pub weights: Vec<Weight>,
}

impl Shapes {
    /// Visuals and collisions: what touches is seen, too, where there is nothing else to see.
    pub(super) fn split(self) -> (Vec<Shape>, Vec<Shape>) {
        let seen = if self.seen.is_empty() { self.touched.clone() } else { self.seen };
        (seen, self.touched)
    }
}

impl Model<'_, '_> {
    /// Adds a geom that stands in a frame at `own`.
    pub(super) fn geom(&mut self, element: &Element, own: DPose3, shapes: &mut Shapes) {
        let bits = ["contype", "conaffinity"].map(|bit| self.number(element, bit).unwrap_or(1.0));
        let mask = bits.map(|b| b as u32);
        let Some(shape) = self.shape(element, own) else {
            return shapes.planes.push(mask);
        };
        let shape = Shape { mask, ..shape };
        let group = self.number(element, "group").unwrap_or(0.0);
        let [first, last] = self.compiler.weighing;
        let weighs = (first..=last).contains(&group);
        let mass = self.number(element, "mass");
        let density = self.number(element, "density").unwrap_or(DENSITY);
        let solid = match (&shape.geometry, element.get("mesh")) {
            (Geometry::Mesh(mesh), Some(name)) => {
                let asset = self.meshes.get(name);
                asset.map(|asset| asset.weighing).unwrap_or_default().solid(mesh)
            }
            (geometry, _) => solid(geometry),
        };
        let solid = solid.filter(|_| weighs);
        shapes.weights.extend(solid.map(|of| of.weighing(mass, density, shape.origin)));
        shapes.lacks |= weighs && matches!(shape.geometry, Geometry::Unread { .. });
        shapes.shows |= mask != [0; 2] && group < HIDDEN;
        let list = if mask == [0; 2] { &mut shapes.seen } else { &mut shapes.touched };
        list.push(shape);
    }

    fn shape(&mut self, element: &Element, own: DPose3) -> Option<Shape> {
        let line = self.reader.line(element.node);
        let kind = element.get("type").unwrap_or("sphere").to_owned();
        let is_fitted = element.get("mesh").is_some() && element.get("size").is_none();
        let kind = match kind.as_str() {
            "plane" | "hfield" => return None,
            "sphere" if is_fitted && element.get("type").is_none() => "mesh",
            "sdf" => "mesh",
            kind => kind,
        };
        let (span, place) = match self.span(element) {
            Some((span, place)) => (Some(span), place),
            None => (None, self.place(element)),
        };
        let mut shape = Shape {
            origin: own * place,
            geometry: Geometry::Unread { reason: format!("line {line}: geom `{kind}`") },
            scale: DVec3::ONE,
            source: kind.into(),
            colour: self.colour(element),
            mask: [1, 1],
            line,
        };
        if kind == "mesh" {
            self.mesh_shape(element, &mut shape);
        } else if is_fitted {
            let reason = format!("line {line}: a {kind} that is fitted to a mesh is not read here");
            shape.geometry = Geometry::Unread { reason };
        } else {
            shape.geometry = self.primitive(element, kind, span);
        }
        Some(shape)
    }

    /// A geom's own colour, unless it is the one that stands for none; else that of its material.
    fn colour(&self, element: &Element) -> Option<[u8; 4]> {
        let own = element.get("rgba").and_then(rgba).filter(|colour| *colour != UNSAID);
        own.or_else(|| self.paints.get(element.get("material")?).copied())
    }

    fn mesh_shape(&mut self, element: &Element, shape: &mut Shape) {
        let name = element.get("mesh").unwrap_or_default();
        match self.meshes.get(name) {
            Some(asset) => {
                shape.source.clone_from(&asset.source);
                shape.scale = asset.scale;
                shape.geometry = asset.geometry.clone();
            }
            None => self.reader.fault(element.node, format!("there is no mesh `{name}`")),
        }
    }

    /// Length and frame of a geom that is told by its two ends.
    fn span(&mut self, element: &Element) -> Option<(f64, DPose3)> {
        let ends = self.numbers(element, "fromto", 6)?;
        let (from, to) = (DVec3::from_slice(&ends[..3]), DVec3::from_slice(&ends[3..]));
        let length = from.distance(to);
        if !(length > 0.0 && length <= MAX_LENGTH) {
            self.reader.fault(element.node, format!("fromto: spans {length} m"));
            return None;
        }
        // MuJoCo has the z axis run from the second end to the first.
        let turn = DQuat::from_rotation_arc(DVec3::Z, (from - to) / length);
        Some((length, DPose3::from_parts((from + to) / 2.0, turn)))
    }

    fn primitive(&mut self, element: &Element, kind: &str, span: Option<f64>) -> Geometry {
        let needed = match (kind, span) {
            ("box" | "ellipsoid", None) => 3,
            ("cylinder" | "capsule", None) => 2,
            _ => 1,
        };
        let Some(size) = self.numbers(element, "size", needed) else {
            self.reader.fault(element.node, format!("a {kind} needs {needed} numbers of size"));
            return Geometry::Unread { reason: format!("a {kind} without size") };
        };
        if size.iter().any(|s| s.abs() > MAX_LENGTH) {
            self.reader.fault(element.node, format!("size: {size:?} is beyond {MAX_LENGTH:e}"));
        }
        let second = size.get(1).copied().unwrap_or(size[0]);
        let length = span.unwrap_or(2.0 * second);
        let third = span.map_or_else(|| size.get(2).copied().unwrap_or(second), |l| l / 2.0);
        let half = DVec3::new(size[0], second, third);
        match kind {
            "sphere" => Geometry::Sphere { radius: size[0] },
            "box" => Geometry::Box { size: half * 2.0 },
            "cylinder" => Geometry::Cylinder { radius: size[0], length },
            "capsule" => Geometry::Capsule { radius: size[0], length },
            "ellipsoid" => Geometry::Ellipsoid { half },
            other => Geometry::Unread { reason: format!("geom type `{other}` is not read here") },
        }
    }
}
