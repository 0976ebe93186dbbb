//! One way to look at a sample: how it is turned, scaled and shifted, and which parts are merged.

use model::features::{geometric, regions};
use model::net::Points;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use super::settings::Augment;
use crate::dataset::{Sample, SampleJoint, SamplePart};

/// Words that mean a side of the object, so that it may not be turned.
const SPATIAL: [&str; 9] =
    ["left", "right", "front", "rear", "back", "port", "starboard", "near", "far"];

/// How a sample is looked at.
#[derive(Clone, Debug)]
pub(crate) struct View {
    /// Quarter turns about z.
    quarters: u32,
    scale: f64,
    shift: [f64; 3],
    normals: bool,
    /// For each part of the sample, the part shown.
    part_of: Vec<u16>,
    /// The parts shown; their joints lie as shown, too.
    pub(crate) parts: Vec<SamplePart>,
}

impl View {
    pub(crate) fn draw(sample: &Sample, augment: &Augment, rng: &mut Pcg64Mcg) -> Self {
        let quarters = rng.random_range(0..4);
        let turns = augment.turn && !has_front(sample);
        let scale = 1.0 + augment.scale * (2.0 * rng.random::<f64>() - 1.0);
        let shift = std::array::from_fn(|_| augment.shift * normal(rng));
        let normals = augment.no_normals <= rng.random::<f64>();
        let merged: Vec<bool> = sample.parts.iter().map(|_| augment.merge > rng.random()).collect();
        let quarters = if turns { quarters } else { 0 };
        let part_of = merge(&sample.parts, &merged);
        let mut view = Self { quarters, scale, shift, normals, part_of, parts: vec![] };
        view.parts = view.shown_parts(sample);
        view
    }

    /// The part shown that a point lies on.
    pub(crate) fn label(&self, sample: &Sample, point: usize) -> u16 {
        self.part_of[usize::from(sample.labels[point])]
    }

    /// The points of each part shown.
    pub(crate) fn points_of_parts(&self, sample: &Sample) -> Vec<Vec<usize>> {
        let mut of_part = vec![Vec::new(); self.parts.len()];
        for point in 0..sample.positions.len() {
            of_part[usize::from(self.label(sample, point))].push(point);
        }
        of_part
    }

    /// Where a point is shown.
    pub(crate) fn position(&self, sample: &Sample, point: usize) -> [f64; 3] {
        self.place(sample.positions[point].map(f64::from))
    }

    /// Some points as the network sees them.
    pub(crate) fn points(&self, sample: &Sample, of: &[usize]) -> Points {
        let single = |v: [f64; 3]| v.map(|x| x as f32);
        let normal = |&p: &usize| single(self.turn(sample.normals[p].map(f64::from)));
        Points {
            positions: of.iter().map(|&p| single(self.position(sample, p))).collect(),
            normals: self.normals.then(|| of.iter().map(normal).collect()),
            features: of.iter().flat_map(|&p| self.features(sample.features_of(p))).collect(),
        }
    }

    fn turn(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        match self.quarters {
            0 => [x, y, z],
            1 => [-y, x, z],
            2 => [-x, -y, z],
            _ => [y, -x, z],
        }
    }

    fn place(&self, p: [f64; 3]) -> [f64; 3] {
        let turned = self.turn(p);
        std::array::from_fn(|i| turned[i] * self.scale + self.shift[i])
    }

    /// Features turned along: size and place of component and patch are all that has a direction.
    fn features(&self, features: &[f32]) -> Vec<f32> {
        let mut out = features.to_vec();
        let first = geometric::WIDTH - 2 * regions::WIDTH;
        for at in [first, first + regions::WIDTH] {
            let three = |at: usize| [out[at], out[at + 1], out[at + 2]].map(f64::from);
            let size = self.turn(three(at)).map(f64::abs);
            let place = self.turn(three(at + 3));
            for i in 0..3 {
                (out[at + i], out[at + 3 + i]) = (size[i] as f32, place[i] as f32);
            }
        }
        out
    }

    fn joint(&self, joint: &SampleJoint) -> SampleJoint {
        let scale = if joint.turns { 1.0 } else { self.scale };
        SampleJoint {
            turns: joint.turns,
            axis: self.turn(joint.axis),
            pivot: self.place(joint.pivot),
            lower: joint.lower * scale,
            upper: joint.upper * scale,
        }
    }

    fn shown_parts(&self, sample: &Sample) -> Vec<SamplePart> {
        let shown = self.part_of.iter().max().map_or(0, |&m| usize::from(m) + 1);
        let mut parts = vec![SamplePart::default(); shown];
        for (old, part) in sample.parts.iter().enumerate() {
            let new = self.part_of[old];
            let above = part.parent.map(|p| self.part_of[p]);
            if above == Some(new) {
                continue;
            }
            parts[usize::from(new)] = SamplePart {
                parent: above.map(usize::from),
                wordings: part.wordings.clone(),
                joints: part.joints.iter().map(|j| self.joint(j)).collect(),
            };
        }
        parts
    }
}

/// For each part the new number of the part it ends up in: its own, or that of the nearest
/// ancestor that is not merged.
fn merge(parts: &[SamplePart], merged: &[bool]) -> Vec<u16> {
    let stays = |p: usize| !merged[p] || parts[p].parent.is_none();
    let before = |p: usize| (0..p).filter(|&q| stays(q)).count() as u16;
    let number: Vec<u16> = (0..parts.len()).map(before).collect();
    let survivor = |mut p: usize| {
        // A tree is never deeper than it has parts.
        for _ in 0..parts.len() {
            match parts[p].parent {
                Some(parent) if merged[p] => p = parent,
                _ => break,
            }
        }
        number[p]
    };
    (0..parts.len()).map(survivor).collect()
}

/// Whether a text says where a part is.
fn has_front(sample: &Sample) -> bool {
    let words = sample.parts.iter().flat_map(|p| &p.wordings);
    let says = |text: &String| {
        text.split(|c: char| !c.is_alphanumeric()).any(|w| SPATIAL.contains(&&*w.to_lowercase()))
    };
    words.into_iter().any(says)
}

fn normal(rng: &mut Pcg64Mcg) -> f64 {
    let (u, v): (f64, f64) = (1.0 - rng.random::<f64>(), rng.random());
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}
