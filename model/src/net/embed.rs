//! Points to tokens: embed(x, n, f) = φ_x(x) + φ_n(n) + φ_f(f) (paper, section 4.1).
//!
//! Letters: B batch · N points · F point features · D width.

use burn::module::Module;
use burn::tensor::{Device, Tensor, TensorData};
use rayon::prelude::*;

use super::layers::{Linear, Mlp};
use super::source::Builder;

/// Frequencies per coordinate.
const WAVES: usize = 32;
/// Numbers per scalar: sines, then cosines.
pub(crate) const WAVE_WIDTH: usize = 2 * WAVES;
/// Numbers per vector: waves of x, y, z, then x, y, z themselves.
pub(crate) const CODE_WIDTH: usize = 3 * WAVE_WIDTH + 3;

/// sin a₀…a₃₁, cos a₀…a₃₁ with aᵢ = 1000 x 10000^(−i/32).
pub(crate) fn waves(x: f32) -> [f32; WAVE_WIDTH] {
    let mut out = [0.0; WAVE_WIDTH];
    for i in 0..WAVES {
        let frequency = (-(10_000f32.ln()) * i as f32 / WAVES as f32).exp();
        (out[i], out[WAVES + i]) = (1000.0 * x * frequency).sin_cos();
    }
    out
}

/// [`CODE_WIDTH`] numbers for each vector.
pub(crate) fn codes(vectors: &[[f32; 3]]) -> Vec<f32> {
    let mut out = vec![0.0; vectors.len() * CODE_WIDTH];
    out.par_chunks_mut(CODE_WIDTH).zip(vectors).for_each(|(code, v)| {
        for (to, &x) in code.chunks_exact_mut(WAVE_WIDTH).zip(v) {
            to.copy_from_slice(&waves(x));
        }
        code[3 * WAVE_WIDTH..].copy_from_slice(v);
    });
    out
}

/// Points of one object as plain numbers, in the model's unit cube.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Points {
    /// Positions, unit cube [−½, ½]³, z up.
    pub positions: Vec<[f32; 3]>,
    /// Unit normals; `None` where the network is not to see any.
    pub normals: Option<Vec<[f32; 3]>>,
    /// F numbers for each point, row-major.
    pub features: Vec<f32>,
}

impl Points {
    /// Points `range` of these, with `width` features each.
    pub fn slice(&self, range: std::ops::Range<usize>, width: usize) -> Self {
        Self {
            positions: self.positions[range.clone()].to_vec(),
            normals: self.normals.as_ref().map(|n| n[range.clone()].to_vec()),
            features: self.features[range.start * width..range.end * width].to_vec(),
        }
    }
}

/// Points of a batch of objects as tensors.
#[derive(Clone, Debug)]
pub struct Cloud {
    pub(crate) positions: Tensor<3>,      // [B, N, 3]
    pub(crate) position_codes: Tensor<3>, // [B, N, 195]
    pub(crate) normal_codes: Tensor<3>,   // [B, N, 195]
    pub(crate) has_normal: Tensor<3>,     // [B, N, 1]: 1 or 0
    pub(crate) features: Tensor<3>,       // [B, N, F]
}

impl Cloud {
    /// Stacks objects of equally many points (B objects of N points), with `width` features each.
    pub fn new(objects: &[&Points], width: usize, device: &Device) -> Self {
        let batch = objects.len();
        let n = objects.first().map_or(0, |o| o.positions.len());
        let stack = |values: Vec<f32>, width: usize| -> Tensor<3> {
            Tensor::from_data(TensorData::new(values, [batch, n, width]), device)
        };
        let positions: Vec<_> = objects.iter().flat_map(|o| o.positions.iter().copied()).collect();
        let normal = |o: &Points, i: usize| o.normals.as_ref().map_or([0.0; 3], |all| all[i]);
        let normals: Vec<_> = objects.iter().flat_map(|o| (0..n).map(|i| normal(o, i))).collect();
        let known = objects.iter().flat_map(|o| vec![f32::from(u8::from(o.normals.is_some())); n]);
        let features = objects.iter().flat_map(|o| o.features.iter().copied()).collect();
        Self {
            position_codes: stack(codes(&positions), CODE_WIDTH),
            normal_codes: stack(codes(&normals), CODE_WIDTH),
            positions: stack(positions.concat(), 3),
            has_normal: stack(known.collect(), 1),
            features: stack(features, width),
        }
    }
}

/// φ_x, φ_n and φ_f, shared by shape points, query points and point prompts.
#[derive(Module, Debug)]
pub struct Embedder {
    position: Mlp,
    normal: Mlp,
    feature: Linear,
}

impl Embedder {
    /// For `features` numbers a point, into tokens of this width. The names are Particulate's.
    pub fn new(b: &mut Builder, features: usize, width: usize) -> Self {
        Self {
            position: Mlp::new(b.at("pos_embed.mlp"), [CODE_WIDTH, width, width]),
            normal: Mlp::new(b.at("normal_embed.mlp"), [CODE_WIDTH, width, width]),
            feature: Linear::new(b.at("feat_proj"), features, width),
        }
    }

    /// [B, N, ..] → [B, N, D].
    pub fn forward(&self, cloud: &Cloud) -> Tensor<3> {
        let normal = self.normal.forward(cloud.normal_codes.clone()) * cloud.has_normal.clone();
        self.position.forward(cloud.position_codes.clone())
            + normal
            + self.feature.forward(cloud.features.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_code_is_waves_of_falling_frequency_and_the_vector_itself() {
        let code = codes(&[[0.25, -0.5, 0.0]]);
        assert_eq!(code.len(), CODE_WIDTH);
        assert!((code[0] - 250f32.sin()).abs() < 1e-6);
        assert!((code[WAVES] - 250f32.cos()).abs() < 1e-6);
        assert!((f64::from(code[16]) - (2.5f64).sin()).abs() < 1e-5, "1000 / 100 a quarter");
        assert!(code[2 * WAVE_WIDTH..][..WAVES].iter().all(|&s| s == 0.0));
        assert_eq!(code[3 * WAVE_WIDTH..], [0.25, -0.5, 0.0]);
    }
}
