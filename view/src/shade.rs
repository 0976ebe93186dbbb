//! Light on the surface: a soft key light over the viewer's left shoulder, a fill, and the sky.

use glamx::DVec3;
use object::Mesh;
use rayon::prelude::*;

use crate::camera::{Axes, Camera};
use crate::visibility::{NO_FACE, SAMPLES, Samples};

const SKY: f64 = 0.42;
const GROUND: f64 = 0.22;
const KEY: f64 = 0.66;
const FILL: f64 = 0.14;
const SHINE: f64 = 0.08;

/// Linear colours of a surface.
#[derive(Clone, Debug)]
pub(crate) enum Colours {
    One(DVec3),
    PerVertex(Vec<DVec3>),
    PerFace(Vec<DVec3>),
}

/// What shading finds for one pixel: light that reaches the camera, how much of the pixel the
/// surface covers, and the surface's direction at its centre.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Shaded {
    pub light: [f32; 3],
    pub cover: f32,
    pub normal: [f32; 3],
}

/// Directions towards the lights, unit, object frame; they turn with the camera, so that every
/// view is lit alike, and the sky stays above.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Light {
    key: DVec3,
    fill: DVec3,
    half: DVec3,
}

impl Light {
    pub(crate) fn for_camera(camera: &Camera) -> Self {
        let axes = camera.axes();
        let key = (axes.up * 0.85 - axes.right * 0.6 - axes.forward * 0.75).normalize();
        let fill = (axes.right * 0.9 + axes.up * 0.1 - axes.forward * 0.5).normalize();
        Self { key, fill, half: (key - axes.forward).normalize() }
    }

    /// Linear light a matt surface of the given colour sends to the viewer.
    fn on(&self, normal: DVec3, colour: DVec3) -> DVec3 {
        let sky = GROUND + (SKY - GROUND) * (0.5 + 0.5 * normal.z);
        let wrapped = |light: DVec3| ((normal.dot(light) + 0.25) / 1.25).max(0.0);
        let bright = sky + KEY * wrapped(self.key) + FILL * wrapped(self.fill);
        let shine = SHINE * to_the_24(normal.dot(self.half).max(0.0));
        colour * bright + DVec3::splat(shine)
    }
}

fn to_the_24(x: f64) -> f64 {
    let eighth = x * x * x * x * x * x * x * x;
    eighth * eighth * eighth
}

/// A face as one camera sees it: what each corner weighs along a ray, up to a common factor, and
/// whether its back is seen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Facing {
    weights: [DVec3; 3],
    is_back: bool,
}

impl Facing {
    /// All faces of a mesh as seen from a point.
    pub(crate) fn all(mesh: &Mesh, eye: DVec3) -> Vec<Self> {
        let corner = |v: u32| mesh.vertices()[v as usize] - eye;
        let of = |f: &[u32; 3]| Self::new(f.map(corner));
        mesh.faces().par_iter().with_min_len(1024).map(of).collect()
    }

    fn new([a, b, c]: [DVec3; 3]) -> Self {
        let weights = [b.cross(c), c.cross(a), a.cross(b)];
        Self { weights, is_back: (b - a).cross(c - a).dot(a + b + c) > 0.0 }
    }

    /// Where a ray from the eye meets the face's plane, as weights of its corners, kept inside.
    fn barycentric(&self, ray: DVec3) -> [f64; 3] {
        let [u, v, w] = self.weights;
        let [u, v, w] = [ray.dot(u), ray.dot(v), ray.dot(w)];
        let sum = u + v + w;
        if sum == 0.0 {
            return [1.0 / 3.0; 3];
        }
        let inside = |w: f64| (w / sum).clamp(0.0, 1.0);
        let [u, v, w] = [inside(u), inside(v), inside(w)];
        let total = u + v + w;
        [u / total, v / total, w / total]
    }
}

/// Everything needed to colour a pixel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shader<'a> {
    pub mesh: &'a Mesh,
    pub facing: &'a [Facing],
    pub normals: &'a [[DVec3; 3]],
    pub colours: &'a Colours,
    pub camera: Camera,
    pub axes: Axes,
    pub light: Light,
}

impl Shader<'_> {
    /// The light of a pixel: each face its samples see is lit once and counts by its samples.
    pub(crate) fn pixel(&self, [x, y]: [usize; 2], samples: &Samples) -> Shaded {
        if samples.face == [NO_FACE; SAMPLES.len()] {
            return Shaded::default();
        }
        let mut found = Shaded::default();
        let mut sum = DVec3::ZERO;
        for (s, &face) in samples.face.iter().enumerate() {
            if face == NO_FACE || samples.face[..s].contains(&face) {
                continue;
            }
            let count = samples.face[s..].iter().filter(|&&f| f == face).count();
            let share = count as f64 / SAMPLES.len() as f64;
            let at = [x as f64 + SAMPLES[s][0], y as f64 + SAMPLES[s][1]];
            let (normal, colour) = self.surface(face as usize, at);
            sum += self.light.on(normal, colour) * share;
            found.cover += share as f32;
            if s == 0 {
                found.normal = normal.to_array().map(|c| c as f32);
            }
            if count == SAMPLES.len() {
                break;
            }
        }
        found.light = sum.to_array().map(|c| c as f32);
        found
    }

    /// Smooth normal towards the viewer and linear colour where a pixel's ray meets a face.
    fn surface(&self, face: usize, pixel: [f64; 2]) -> (DVec3, DVec3) {
        let ray = self.axes.direction(self.camera.centre(), pixel);
        let facing = &self.facing[face];
        let weights = facing.barycentric(ray);
        let mix = |v: [DVec3; 3]| v[0] * weights[0] + v[1] * weights[1] + v[2] * weights[2];
        let normal = mix(self.normals[face]);
        let normal = if facing.is_back { -normal } else { normal };
        let colour = match self.colours {
            Colours::One(colour) => *colour,
            Colours::PerFace(colours) => colours[face],
            Colours::PerVertex(colours) => {
                mix(self.mesh.faces()[face].map(|v| colours[v as usize]))
            }
        };
        (normal.try_normalize().unwrap_or(-self.axes.forward), colour)
    }
}

/// Linear light (0–1) of an sRGB byte.
pub(crate) fn linear_of_byte(byte: u8) -> f64 {
    let c = f64::from(byte) / 255.0;
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

const STEPS: usize = 4096;

static BYTES: std::sync::LazyLock<Vec<u8>> = std::sync::LazyLock::new(|| {
    let srgb = |c: f64| {
        if c <= 0.003_130_8 { c * 12.92 } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 }
    };
    (0..=STEPS).map(|i| (srgb(i as f64 / STEPS as f64) * 255.0).round() as u8).collect()
});

/// Linear light to opaque sRGB pixels; bright light rolls off gently instead of clipping.
pub(crate) struct ToBytes(&'static [u8]);

impl ToBytes {
    /// Has its table ready.
    pub(crate) fn new() -> Self {
        Self(&BYTES)
    }

    /// The pixel of some light.
    pub(crate) fn of(&self, light: [f32; 3]) -> [u8; 4] {
        let [r, g, b] = light.map(|c| self.byte(c));
        [r, g, b, 255]
    }

    /// The pixel of light without colour.
    pub(crate) fn grey(&self, light: f32) -> [u8; 4] {
        let byte = self.byte(light);
        [byte, byte, byte, 255]
    }

    fn byte(&self, c: f32) -> u8 {
        let over = (c - KNEE) / (1.0 - KNEE);
        let soft = if over <= 0.0 { c } else { KNEE + (1.0 - KNEE) * (over / (1.0 + over)) };
        self.0[((soft.clamp(0.0, 1.0) * STEPS as f32) as usize).min(STEPS)]
    }
}

/// Light up to here is shown as it is.
const KNEE: f32 = 0.8;
