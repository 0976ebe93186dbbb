//! Small articulated objects of any shape and motion, through every contact check.
//!
//! What breaks down inside the geometry library is caught and becomes `unknown`; only what breaks
//! down in this house counts as a crash.
#![no_main]

use std::sync::{Arc, Once};

use glamx::{DMat3, DPose3, DQuat, DVec3};
use libfuzzer_sys::fuzz_target;
use object::Mesh;
use sim_check::robot::{Geometry, Inertial, Joint, Limit, Link, Motion, Robot, Shape};
use sim_check::checks::kinematic;
use sim_check::{CheckOptions, Tier};

/// Bytes as small numbers.
struct Source<'a>(&'a [u8]);

impl Source<'_> {
    fn byte(&mut self) -> u8 {
        let Some((first, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        *first
    }

    /// From -2 to 2 in steps of 1/64; now and then any number at all.
    fn number(&mut self) -> f64 {
        match self.byte() {
            255 => {
                let bytes = [(); 8].map(|()| self.byte());
                f64::from_le_bytes(bytes)
            }
            byte => (f64::from(byte) - 128.0) / 64.0,
        }
    }

    fn vector(&mut self) -> DVec3 {
        DVec3::new(self.number(), self.number(), self.number())
    }

    fn pose(&mut self) -> DPose3 {
        let at = self.vector();
        let about = self.vector();
        let turn = if about.is_finite() { DQuat::from_scaled_axis(about) } else { DQuat::IDENTITY };
        DPose3::from_parts(at, turn)
    }

    fn geometry(&mut self) -> Geometry {
        match self.byte() % 6 {
            0 => Geometry::Box { size: self.vector().abs() },
            1 => Geometry::Cylinder { radius: self.number(), length: self.number() },
            2 => Geometry::Sphere { radius: self.number() },
            3 => Geometry::Capsule { radius: self.number(), length: self.number() },
            4 => Geometry::Ellipsoid { half: self.vector().abs() },
            _ => self.mesh(),
        }
    }

    fn mesh(&mut self) -> Geometry {
        let count = u32::from(self.byte() % 12) + 3;
        let points = (0..count).map(|_| self.vector()).collect();
        let faces = (0..count).map(|i| [i, (i + 1) % count, (i + 2) % count]).collect();
        match Mesh::new(points, faces) {
            Ok(mesh) => Geometry::Mesh(Arc::new(mesh)),
            Err(e) => Geometry::Unread { reason: e.to_string() },
        }
    }

    fn shape(&mut self) -> Shape {
        let (origin, geometry) = (self.pose(), self.geometry());
        Shape { origin, geometry, scale: DVec3::ONE, source: "shape".into(), colour: None, mask: [1, 1], line: 1 }
    }

    fn link(&mut self, name: usize) -> Link {
        let shapes: Vec<Shape> = (0..self.byte() % 3 + 1).map(|_| self.shape()).collect();
        let origin = DPose3::identity();
        let inertial = Inertial { origin, mass: 1.0, inertia: DMat3::IDENTITY, line: 1 };
        let (visuals, collisions) = (shapes.clone(), shapes);
        Link { name: format!("l{name}"), inertial: Some(inertial), visuals, collisions, between: false, line: 1 }
    }

    fn joint(&mut self, child: usize) -> Joint {
        let kinds = [Motion::Revolute, Motion::Continuous, Motion::Prismatic, Motion::Fixed];
        let axis_as_written = self.vector();
        let (lower, upper) = (-self.number().abs(), self.number().abs());
        Joint {
            name: format!("j{child}"),
            kind: kinds[usize::from(self.byte() % 4)],
            parent: usize::from(self.byte()) % child,
            child,
            origin: self.pose(),
            axis: axis_as_written.normalize_or_zero(),
            axis_as_written,
            limit: Some(Limit { lower, upper, effort: Some(1.0), velocity: Some(1.0) }),
            dynamics: None,
            mimic: None,
            rest: 0.0,
            spring: None,
            held: None,
            line: 1,
        }
    }
}

fn forgive_the_library() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let strict = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            let file = panic.location().map_or("", |l| l.file());
            if !file.contains("parry3d") {
                strict(panic);
            }
        }));
    });
}

fuzz_target!(|bytes: &[u8]| {
    forgive_the_library();
    let mut source = Source(bytes);
    let count = usize::from(source.byte() % 3) + 2;
    let links = (0..count).map(|l| source.link(l)).collect();
    let joints = (1..count).map(|c| source.joint(c)).collect();
    let Ok(robot) = Robot::new("r".into(), links, joints) else { return };
    let options = CheckOptions { up_to: Tier::Kinematic, ..CheckOptions::default() };
    assert!(!kinematic::checks(&robot, &options).is_empty());
});
