//! Draws every procedural family, its parts with their axes beside the joints at work.
//!
//! `cargo run --release -p kinfold-training --example draw_families -- families.png [SEED]`

use std::error::Error;

use object::pose::Configuration;
use object::{ArticulatedObject, DVec3, Range};
use training::dataset::pose::posed;
use training::procedural::{each, generate};
use view::camera::framed;
use view::{Paint, Picture, caption, contact_sheet, draw_axis, render};

const SIZE: [u32; 2] = [240, 240];

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("usage: draw_families FILE.png [SEED]")?;
    let seed = std::env::args().nth(2).map_or(Ok(1), |s| s.parse())?;
    let mut pictures = Vec::new();
    for id in each(1) {
        pictures.extend(pair(&id.category(), &generate(id, seed)?.object)?);
    }
    std::fs::write(path, view::encode_png(&contact_sheet(&pictures, 8)?)?)?;
    Ok(())
}

/// An object with its parts and axes, and with every joint near the farther end of its range.
fn pair(name: &str, object: &ArticulatedObject) -> Result<[Picture; 2], Box<dyn Error>> {
    let open = posed(object, &opened(object))?;
    let bounds = open.mesh().bounds();
    let camera = framed(&bounds, DVec3::new(0.6, -1.0, 0.5), SIZE);
    let mut parts = render(object.mesh(), &Paint::Parts(object.part_of_face()), &camera);
    for motion in (0..object.tree().len()).flat_map(|p| object.joints(p)) {
        let reach = motion.axis * bounds.diagonal() * 0.1;
        let from = if motion.kind.turns() { motion.pivot - reach } else { motion.pivot };
        draw_axis(&mut parts, &camera, from, motion.pivot + reach, [200, 40, 40]);
    }
    caption(&mut parts, name);
    let moved = render(open.mesh(), &Paint::Parts(open.part_of_face()), &camera);
    Ok([parts, moved])
}

fn opened(object: &ArticulatedObject) -> Configuration {
    let value = |motion: &object::JointMotion| match motion.range {
        Range::Continuous => std::f64::consts::FRAC_PI_4,
        Range::Limits { lower, upper } if upper < -lower => lower * 0.8,
        Range::Limits { upper, .. } => upper * 0.8,
    };
    let parts = 0..object.tree().len();
    Configuration(parts.map(|p| object.joints(p).iter().map(value).collect()).collect())
}
