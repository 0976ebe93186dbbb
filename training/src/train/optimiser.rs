//! AdamW whose whole state has names, so that it can be stored beside the weights and come back bit
//! by bit.

use std::collections::BTreeMap;

use burn::module::{Module, ModuleMapper, Param};
use burn::tensor::{Gradients, Tensor};
use serde::{Deserialize, Serialize};

/// How the optimiser goes; defaults are the paper's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Schedule {
    /// Learning rate after the warm-up.
    pub rate: f64,
    /// Steps over which the rate climbs from nothing.
    pub warmup: u64,
    /// Step at which the rate begins to fall, and the step at which it is nothing again: half a
    /// cosine. Constant where it is not given.
    pub decay: Option<[u64; 2]>,
    /// Decoupled weight decay.
    pub weight_decay: f64,
}

impl Default for Schedule {
    fn default() -> Self {
        Self { rate: 6.4e-5, warmup: 1_000, decay: None, weight_decay: 0.01 }
    }
}

impl Schedule {
    /// The learning rate of a step, counted from 1.
    pub fn rate_at(&self, step: u64) -> f64 {
        let climb = (step as f64 / self.warmup.max(1) as f64).min(1.0);
        let Some([from, to]) = self.decay else { return self.rate * climb };
        let way = step.saturating_sub(from) as f64 / to.saturating_sub(from).max(1) as f64;
        self.rate * climb * (0.5 + 0.5 * (std::f64::consts::PI * way.min(1.0)).cos())
    }
}

const BETA: [f64; 2] = [0.9, 0.999];
const EPSILON: f32 = 1e-8;

/// First and second moment of one parameter, flat.
#[derive(Clone, Debug)]
pub(crate) struct Moments {
    pub(crate) first: Tensor<1>,
    pub(crate) second: Tensor<1>,
}

/// AdamW (Loshchilov and Hutter, 2019) with β 0.9 and 0.999, ε 1e-8.
#[derive(Clone, Debug, Default)]
pub struct AdamW {
    pub(crate) steps: u64,
    pub(crate) moments: BTreeMap<u64, Moments>,
}

/// One step on its way through a module.
struct Step<'a> {
    moments: &'a mut BTreeMap<u64, Moments>,
    gradients: &'a mut Gradients,
    rate: f64,
    decay: f64,
    /// 1 − βᵗ of both moments.
    correction: [f64; 2],
}

impl AdamW {
    /// Moves every parameter that has a gradient.
    pub fn step<M: Module>(
        &mut self,
        module: M,
        gradients: &mut Gradients,
        schedule: &Schedule,
    ) -> M {
        self.steps += 1;
        let correction = BETA.map(|beta| 1.0 - beta.powi(self.steps.min(1 << 30) as i32));
        let (rate, decay) = (schedule.rate_at(self.steps), schedule.weight_decay);
        let moments = &mut self.moments;
        module.map(&mut Step { moments, gradients, rate, decay, correction })
    }
}

impl ModuleMapper for Step<'_> {
    fn map_float<const D: usize>(&mut self, param: Param<Tensor<D>>) -> Param<Tensor<D>> {
        let (id, tensor, mapper) = param.consume();
        let tensor = match tensor.grad_remove(self.gradients) {
            Some(gradient) => {
                let moved = self.moved(id.val(), tensor.inner(), gradient);
                Tensor::from_inner(moved).require_grad()
            }
            None => tensor,
        };
        Param::from_mapped_value(id, tensor, mapper)
    }
}

impl Step<'_> {
    fn moved<const D: usize>(
        &mut self,
        id: u64,
        tensor: Tensor<D>,
        gradient: Tensor<D>,
    ) -> Tensor<D> {
        let shape = tensor.dims();
        let (tensor, gradient) = (tensor.flatten::<1>(0, D - 1), gradient.flatten::<1>(0, D - 1));
        let old = self.moments.remove(&id).unwrap_or_else(|| {
            let zeros = gradient.zeros_like();
            Moments { first: zeros.clone(), second: zeros }
        });
        let [a, b] = BETA.map(|beta| beta as f32);
        let first = old.first * a + gradient.clone() * (1.0 - a);
        let second = old.second * b + gradient.clone() * gradient * (1.0 - b);
        let [c, d] = self.correction.map(|c| c as f32);
        let size = (second.clone() / d).sqrt() + EPSILON;
        let moved = tensor * (1.0 - self.rate * self.decay) as f32
            - first.clone() / size * (self.rate / f64::from(c)) as f32;
        self.moments.insert(id, Moments { first, second });
        moved.reshape(shape)
    }
}

#[cfg(test)]
mod tests {
    use burn::module::ParamId;
    use burn::tensor::{Device, TensorData};

    use super::*;

    #[derive(Module, Debug)]
    struct Two {
        weight: Param<Tensor<2>>,
    }

    #[test]
    fn two_steps_are_the_formula_worked_by_hand() {
        let device = Device::flex().autodiff();
        let start = Tensor::from_data(TensorData::new(vec![1.0f32, -2.0], [1, 2]), &device);
        let weight = Param::initialized(ParamId::from(7), start).set_require_grad(true);
        let mut module = Two { weight };
        let mut optimiser = AdamW::default();
        let schedule = Schedule { rate: 0.1, warmup: 2, decay: None, weight_decay: 0.5 };
        let (mut w, mut m, mut v) = ([1.0f64, -2.0], [0.0; 2], [0.0; 2]);
        for step in 1..=2 {
            let loss = module.weight.val().powi_scalar(2).sum();
            module = optimiser.step(module.clone(), &mut loss.backward(), &schedule);
            let rate = 0.05 * f64::from(step);
            for i in 0..2 {
                let g = 2.0 * w[i];
                (m[i], v[i]) = (0.9 * m[i] + 0.1 * g, 0.999 * v[i] + 0.001 * g * g);
                let [m, v] = [m[i] / (1.0 - 0.9f64.powi(step)), v[i] / (1.0 - 0.999f64.powi(step))];
                w[i] = w[i] * (1.0 - rate * 0.5) - rate * m / (v.sqrt() + 1e-8);
            }
        }
        let found: Vec<f32> = module.weight.val().into_data().try_to_vec().unwrap();
        assert!((0..2).all(|i| (f64::from(found[i]) - w[i]).abs() < 1e-5), "{found:?} {w:?}");
    }

    #[test]
    fn the_rate_climbs_stays_and_falls() {
        let schedule =
            Schedule { rate: 1.0, warmup: 10, decay: Some([100, 200]), weight_decay: 0.0 };
        let rates = [1, 5, 10, 100, 150, 200, 300].map(|s| schedule.rate_at(s));
        let wanted = [0.1, 0.5, 1.0, 1.0, 0.5, 0.0, 0.0];
        assert!(rates.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-12), "{rates:?}");
    }
}
