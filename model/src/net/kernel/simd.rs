//! Element-wise mathematics written so that the compiler turns it into vector instructions, and
//! the run-time choice of the widest ones the processor has.
//!
//! Fused multiply-adds stand where they are meant, and sums have 16 lanes everywhere: AVX-512, AVX2
//! and plain code give the same bits.

use pulp::{Arch, Simd, WithSimd};

/// Sums run in this many lanes, whatever the width of the processor's registers.
pub(crate) const LANES: usize = 16;

/// A loop over plain slices.
///
/// Every `run` is marked `#[inline(always)]`, and so is what it calls: what is not inlined into
/// [`vectorised`] is compiled once, for the plainest processor, as a closure would be.
pub(crate) trait Work {
    type Output;

    fn run(self) -> Self::Output;
}

/// Does work compiled for the widest vector instructions at hand (AVX-512, AVX2 or none).
pub(crate) fn vectorised<W: Work>(work: W) -> W::Output {
    Arch::new().dispatch(Wide(work))
}

struct Wide<W>(W);

impl<W: Work> WithSimd for Wide<W> {
    type Output = W::Output;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> W::Output {
        self.0.run()
    }
}

/// e^x for x ≤ 0, relative error below 3e-7; 1.2e-38 and less becomes about that.
///
/// 2^n · 2^f with n the nearest integer to x · log₂ e and a polynomial for 2^f, |f| ≤ ½.
#[inline(always)]
pub(crate) fn exp_negative(x: f32) -> f32 {
    /// Adding 1.5 · 2²³ leaves the nearest integer in the low bits.
    const ROUND: f32 = 12_582_912.0;
    let t = x * std::f32::consts::LOG2_E;
    let t = if t > -126.0 { t } else { -126.0 };
    let rounded = t + ROUND;
    let n = rounded.to_bits().wrapping_sub(ROUND.to_bits());
    let f = t - (rounded - ROUND);
    let p = f.mul_add(0.000_154_035_3, 0.001_333_355_8);
    let p = f.mul_add(f.mul_add(p, 0.009_618_129), 0.055_504_11);
    let p = f.mul_add(f.mul_add(p, 0.240_226_5), std::f32::consts::LN_2);
    let p = f.mul_add(p, 1.0);
    f32::from_bits(p.to_bits().wrapping_add(n << 23))
}

/// 1 / (1 + e^−x).
#[inline(always)]
pub(crate) fn sigmoid(x: f32) -> f32 {
    let e = exp_negative(-x.abs());
    let top = if x >= 0.0 { 1.0 } else { e };
    top / (1.0 + e)
}

/// The normal distribution function Φ and its density φ at x, absolute error below 2e-7.
///
/// Φ by the rational approximation of Abramowitz and Stegun, formula 7.1.26.
#[inline(always)]
pub(crate) fn normal(x: f32) -> (f32, f32) {
    let z = x.abs() * std::f32::consts::FRAC_1_SQRT_2;
    let e = exp_negative(-z * z);
    let t = 1.0 / (1.0 + 0.327_591_1 * z);
    let p = -1.453_152 + t * 1.061_405_4;
    let p = t * (0.254_829_6 + t * (-0.284_496_74 + t * (1.421_413_7 + t * p)));
    let tail = 0.5 * p * e;
    let below = if x >= 0.0 { 1.0 - tail } else { tail };
    (below, e * 0.398_942_3)
}

/// Sum of `f` over a row, in [`LANES`] lanes and a tail.
#[inline(always)]
pub(crate) fn sum_of(row: &[f32], f: impl Fn(f32) -> f32) -> f32 {
    let (chunks, tail) = row.as_chunks::<LANES>();
    let mut lanes = [0f32; LANES];
    for chunk in chunks {
        for (lane, &x) in lanes.iter_mut().zip(chunk) {
            *lane += f(x);
        }
    }
    fold_lanes(lanes) + tail.iter().map(|&x| f(x)).sum::<f32>()
}

/// Sum of products of two rows of equal length.
#[inline(always)]
pub(crate) fn dot(a: &[f32], b: &[f32]) -> f32 {
    let ((xs, tail_x), (ys, tail_y)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    let mut lanes = [0f32; LANES];
    for (x, y) in xs.iter().zip(ys) {
        for i in 0..LANES {
            lanes[i] += x[i] * y[i];
        }
    }
    fold_lanes(lanes) + tail_x.iter().zip(tail_y).map(|(x, y)| x * y).sum::<f32>()
}

/// Largest value of a row; −∞ for an empty one.
#[inline(always)]
pub(crate) fn largest(row: &[f32]) -> f32 {
    let (chunks, tail) = row.as_chunks::<LANES>();
    let mut lanes = [f32::NEG_INFINITY; LANES];
    for chunk in chunks {
        for (lane, &x) in lanes.iter_mut().zip(chunk) {
            *lane = if x > *lane { x } else { *lane };
        }
    }
    lanes.iter().chain(tail).fold(f32::NEG_INFINITY, |m, &x| if x > m { x } else { m })
}

/// Adds the lanes pairwise, so that the order is the same on every processor.
#[inline(always)]
fn fold_lanes(mut lanes: [f32; LANES]) -> f32 {
    let mut half = LANES / 2;
    while half > 0 {
        for i in 0..half {
            lanes[i] += lanes[i + half];
        }
        half /= 2;
    }
    lanes[0]
}

/// `a += b`, element by element.
#[inline(always)]
pub(crate) fn add_to(a: &mut [f32], b: &[f32]) {
    for (a, b) in a.iter_mut().zip(b) {
        *a += b;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn worst(f: impl Fn(f32) -> f32, truth: impl Fn(f64) -> f64, low: f32, high: f32) -> f64 {
        let step = (high - low) / 20_000.0;
        let at = |i: i32| low + step * i as f32;
        (0..=20_000)
            .map(|i| (f64::from(f(at(i))) - truth(f64::from(at(i)))).abs())
            .fold(0.0, f64::max)
    }

    #[test]
    fn the_exponential_is_right_to_seven_digits() {
        let relative = |x: f32| (f64::from(exp_negative(x)) / f64::from(x).exp() - 1.0).abs();
        let worst = (0..=80_000).map(|i| relative(-(i as f32) * 1e-3)).fold(0.0, f64::max);
        assert!(worst < 8e-6, "{worst:e}");
        let near = (0..=1_000).map(|i| relative(-(i as f32) * 1e-3)).fold(0.0, f64::max);
        assert!(near < 4e-7, "{near:e}");
        assert_eq!(exp_negative(0.0), 1.0);
        assert!(exp_negative(-1e9) < 2e-38);
    }

    #[test]
    fn sigmoid_and_normal_meet_their_closed_forms() {
        assert!(worst(sigmoid, |x| 1.0 / (1.0 + (-x).exp()), -30.0, 30.0) < 2e-7);
        assert_eq!(sigmoid(0.0), 0.5);
        let density = |x: f64| (-x * x / 2.0).exp() / (2.0 * std::f64::consts::PI).sqrt();
        assert!(worst(|x| normal(x).1, density, -9.0, 9.0) < 2e-7);
        // Φ(1) and Φ(−2) to ten digits.
        assert!((f64::from(normal(1.0).0) - 0.841_344_746_1).abs() < 2e-7);
        assert!((f64::from(normal(-2.0).0) - 0.022_750_131_9).abs() < 2e-7);
    }

    #[test]
    fn every_instruction_set_gives_the_same_bits() {
        let row: Vec<f32> = (0..1003).map(|i| ((i * 37 % 101) as f32 - 50.0) * 0.13).collect();
        let plain = Sums(&row).run();
        assert_eq!(vectorised(Sums(&row)), plain);
        #[cfg(target_arch = "x86_64")]
        if let Some(avx2) = pulp::x86::V3::try_new() {
            assert_eq!(Simd::vectorize(avx2, Wide(Sums(&row))), plain);
        }
    }

    struct Sums<'a>(&'a [f32]);

    impl Work for Sums<'_> {
        type Output = [u32; 3];

        #[inline(always)]
        fn run(self) -> [u32; 3] {
            let total = sum_of(self.0, |x| exp_negative(-x.abs()) + sigmoid(x) + normal(x).0);
            [total, dot(self.0, self.0), largest(self.0)].map(f32::to_bits)
        }
    }
}
