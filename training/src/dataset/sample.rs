//! A sample: one pose of an object through points in the unit cube, and the truth about it.

use model::features::geometric::{Surroundings, WIDTH};
use model::features::{FeatureError, UnitCube};
use object::sample::{SurfacePoint, sample_surface};
use object::weld::Weld;
use object::{ArticulatedObject, DVec3, JointMotion, Mesh};
use serde::{Deserialize, Serialize};

use super::Specimen;

/// One pose of an object, measured. Lengths in the unit cube [−½, ½]³, z up; angles in radians.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sample {
    /// Where points of the surface lie: first `even` of them spread by area, then more on small
    /// parts.
    pub positions: Vec<[f32; 3]>,
    /// Their unit normals.
    pub normals: Vec<[f32; 3]>,
    /// [`WIDTH`] features of each, row-major.
    pub features: Vec<f32>,
    /// The part each lies on.
    pub labels: Vec<u16>,
    /// How many of the points are spread by area alone.
    pub even: usize,
    /// The parts, as the labels count them.
    pub parts: Vec<SamplePart>,
}

/// One part of a sample.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SamplePart {
    /// The part it hangs on; none for the root.
    pub parent: Option<usize>,
    /// One or more ways to say what it is.
    pub wordings: Vec<String>,
    /// How it moves, the joint nearest the parent first; none where it is fixed.
    pub joints: Vec<SampleJoint>,
}

/// One joint of a sample, in the pose the points show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SampleJoint {
    /// Whether it turns rather than slides.
    pub turns: bool,
    /// Unit direction.
    pub axis: [f64; 3],
    /// A point on the axis.
    pub pivot: [f64; 3],
    /// Smallest value, ≤ 0: radians, or lengths of the unit cube.
    pub lower: f64,
    /// Largest value, ≥ 0.
    pub upper: f64,
}

/// How many points a sample has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Counts {
    /// Points spread by area.
    pub even: usize,
    /// Points every part has at least.
    pub least: usize,
}

impl Default for Counts {
    fn default() -> Self {
        Self { even: 6_144, least: 64 }
    }
}

impl Sample {
    /// Measures an object in the pose it stands in.
    ///
    /// # Errors
    /// [`FeatureError`] when its surface cannot be described.
    pub fn measure(
        object: &ArticulatedObject,
        wordings: &[Vec<String>],
        counts: Counts,
        seed: u64,
    ) -> Result<Self, FeatureError> {
        let mesh = object.mesh();
        let frame = UnitCube::of(mesh);
        let points = points(object, counts, seed);
        let surroundings = Surroundings::new(mesh, &Weld::new(mesh), frame)?;
        let single = |v: DVec3| v.to_array().map(|x| x as f32);
        let joints = |p: usize| object.joints(p).iter().map(|m| inside(m, frame)).collect();
        let part = |(p, part): (usize, &object::Part)| SamplePart {
            parent: part.parent,
            wordings: wordings.get(p).cloned().unwrap_or_default(),
            joints: joints(p),
        };
        Ok(Self {
            positions: points.iter().map(|p| single(frame.inside(p.position))).collect(),
            normals: points.iter().map(|p| single(p.normal)).collect(),
            features: surroundings.encode(&points)?,
            labels: points.iter().map(|p| object.part_of_face()[p.face as usize]).collect(),
            even: counts.even.min(points.len()),
            parts: object.tree().parts().iter().enumerate().map(part).collect(),
        })
    }

    /// [`Sample::measure`] of a specimen as it stands.
    ///
    /// # Errors
    /// [`FeatureError`] when its surface cannot be described.
    pub fn of(specimen: &Specimen, counts: Counts, seed: u64) -> Result<Self, FeatureError> {
        Self::measure(&specimen.object, &specimen.wordings, counts, seed)
    }

    /// The features of one point.
    pub fn features_of(&self, point: usize) -> &[f32] {
        &self.features[point * WIDTH..(point + 1) * WIDTH]
    }
}

fn inside(motion: &JointMotion, frame: UnitCube) -> SampleJoint {
    let turns = motion.kind.turns();
    let (lower, upper) = motion.range.ends();
    let scale = if turns { 1.0 } else { frame.side.recip() };
    SampleJoint {
        turns,
        axis: motion.axis.to_array(),
        pivot: frame.inside(motion.pivot).to_array(),
        lower: lower * scale,
        upper: upper * scale,
    }
}

/// Points by area, then for every part that has too few of them as many as it lacks.
fn points(object: &ArticulatedObject, counts: Counts, seed: u64) -> Vec<SurfacePoint> {
    let mesh = object.mesh();
    let mut points = sample_surface(mesh, counts.even, seed);
    let mut found = vec![0; object.tree().len()];
    for point in &points {
        found[usize::from(object.part_of_face()[point.face as usize])] += 1;
    }
    for (part, &found) in found.iter().enumerate() {
        let missing = counts.least.saturating_sub(found);
        let faces: Vec<usize> = object.faces_of(part).collect();
        points.extend(points_on(mesh, &faces, missing, seed.wrapping_add(1 + part as u64)));
    }
    points
}

fn points_on(mesh: &Mesh, faces: &[usize], count: usize, seed: u64) -> Vec<SurfacePoint> {
    let Ok(part) = mesh.submesh(faces.iter().copied()) else { return vec![] };
    let mut points = sample_surface(&part, count, seed);
    points.iter_mut().for_each(|p| p.face = faces[p.face as usize] as u32);
    points
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::procedural::FAMILIES;

    fn bin() -> Sample {
        let made = FAMILIES.iter().find(|f| f.name == "pedal_bin").unwrap().make().unwrap();
        let wordings = vec![vec!["bin body".into()], vec!["lid".into()], vec!["pedal".into()]];
        let counts = Counts { even: 500, least: 40 };
        Sample::measure(&made.object, &wordings, counts, 3).unwrap()
    }

    #[test]
    fn a_sample_lies_in_the_unit_cube_and_knows_every_part() {
        let bin = bin();
        assert!(bin.positions.iter().flatten().all(|x| x.abs() <= 0.5 + 1e-6));
        assert_eq!(bin.features.len(), bin.positions.len() * WIDTH);
        for part in 0..3 {
            assert!(bin.labels.iter().filter(|&&l| l == part).count() >= 40);
        }
        assert!(bin.positions.len() > bin.even, "the pedal is small");
        assert_eq!(bin.parts[2].joints.len(), 1);
        assert_eq!(bin, self::bin(), "the same seed, the same sample");
    }

    #[test]
    fn points_that_fill_up_a_part_lie_on_it() {
        let made = FAMILIES.iter().find(|f| f.name == "pedal_bin").unwrap().make().unwrap();
        let all = points(&made.object, Counts { even: 10, least: 30 }, 5);
        for point in &all {
            let nearest = object::weld::nearest_face(made.object.mesh(), point.position);
            assert!(nearest.1 < 1e-9);
            let normal = made.object.mesh().normal(point.face as usize);
            assert!((normal - point.normal).length() < 1e-9);
        }
    }
}
