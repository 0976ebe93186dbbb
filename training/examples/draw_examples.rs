//! Draws what the geometric articulator makes of each example: photo, parts found, joints at work.
//!
//! `cargo run --release -p kinfold-training --example draw_examples -- docs/examples.png`

use std::error::Error;

use model::{Articulate, Geometric};
use object::pose::{Configuration, part_poses};
use object::{ArticulatedObject, DVec3, Mesh, Range};
use training::procedural::FAMILIES;
use view::camera::framed;
use view::{Paint, Picture, caption, contact_sheet, draw_axis, render};

const SIZE: [u32; 2] = [480, 480];

/// The families that stand in `examples/`.
const SHOWN: [&str; 3] = ["cabinet", "pedal_bin", "cart"];

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("usage: draw_examples FILE.png")?;
    let mut pictures = Vec::new();
    for family in FAMILIES.iter().filter(|f| SHOWN.contains(&f.name)) {
        let made = family.make()?;
        let condition = made.condition.resolve()?;
        let found = Geometric.articulate(made.object.mesh(), &condition, 0)?.object;
        pictures.extend(row(family.name, &found)?);
    }
    std::fs::write(path, view::encode_png(&contact_sheet(&pictures, 3)?)?)?;
    Ok(())
}

/// An object as it came, its parts with their axes, and every joint near its upper end.
fn row(name: &str, object: &ArticulatedObject) -> Result<[Picture; 3], Box<dyn Error>> {
    let open = opened(object, 0.8)?;
    let bounds = open.bounds();
    let camera = framed(&bounds, DVec3::new(0.6, -1.0, 0.5), SIZE);
    let mut plain = render(object.mesh(), &Paint::Surface, &camera);
    caption(&mut plain, &name.replace('_', " "));
    let mut parts = render(object.mesh(), &Paint::Parts(object.part_of_face()), &camera);
    for motion in (0..object.tree().len()).flat_map(|p| object.joints(p)) {
        let reach = motion.axis * bounds.diagonal() * 0.16;
        let from = if motion.kind.turns() { motion.pivot - reach } else { motion.pivot };
        draw_axis(&mut parts, &camera, from, motion.pivot + reach, [200, 40, 40]);
    }
    caption(&mut parts, "parts and axes found");
    let mut moved = render(&open, &Paint::Parts(object.part_of_face()), &camera);
    caption(&mut moved, "joints at work");
    Ok([plain, parts, moved])
}

/// The surface with every joint at a share of its upper end; endless ones an eighth of a turn on.
fn opened(object: &ArticulatedObject, share: f64) -> Result<Mesh, Box<dyn Error>> {
    let mut q = Configuration::rest(object.tree());
    for (part, values) in q.0.iter_mut().enumerate() {
        for (value, motion) in values.iter_mut().zip(object.joints(part)) {
            *value = match motion.range {
                Range::Continuous => std::f64::consts::FRAC_PI_4,
                Range::Limits { upper, .. } => upper * share,
            };
        }
    }
    let poses = part_poses(object, &q);
    let moved = |(face, &part): (usize, &u16)| {
        object.mesh().corners(face).map(|p| poses[usize::from(part)] * p)
    };
    let triangles: Vec<_> = object.part_of_face().iter().enumerate().map(moved).collect();
    Ok(Mesh::of_triangles(&triangles)?)
}
