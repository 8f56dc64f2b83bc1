//! Plane waves in a fluid that is discretized by a kernel: their frequencies and decay rates.

use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::OnceLock;

use super::kernel::{KernelShape, SHAPES};

/// Number of steps of Simpson's rule; the error for these polynomials is 1e-6.
const STEPS: usize = 200;

/// A plane wave in a fluid discretized by a kernel of unit smoothing length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FluidWave {
    /// Wave number k.
    pub number: f64,
    /// Frequency at unit speed of sound: ∫ F x sin(kx) dV.
    pub frequency: f64,
    /// Decay rate of a transverse field at unit diffusivity: ∫ |F| (1 − cos(kx)) dV.
    pub decay: f64,
    /// Decay rate under artificial viscosity: ∫ |F| (x/r)² (1 − cos(kx)) dV.
    pub squeeze: f64,
    /// Decay rate of a longitudinal wave at unit viscosity: ∫ |F| (x/σ)² (1 − cos(kx)) dV. The fastest wave is longitudinal.
    pub strain: f64,
}

/// Waves resolved by a kernel in 2D or 3D, from the longest to the shortest. They depend on nothing else, and are computed once in
/// a process: that takes longer than the rest of a small scene.
#[inline]
pub fn waves(shape: impl KernelShape, dimension: usize) -> &'static [FluidWave] {
    static KNOWN: [[OnceLock<Vec<FluidWave>>; 2]; SHAPES] = [const { [const { OnceLock::new() }; 2] }; SHAPES];
    let number = |wave: u32| LARGEST * f64::from(wave) / f64::from(WAVES);
    KNOWN[shape.number()][dimension - 2].get_or_init(|| (1..=WAVES).map(|wave| wave_of(shape, dimension, number(wave))).collect())
}

/// Number of wave numbers, and the largest of them times the smoothing length.
const WAVES: u32 = 48;
const LARGEST: f64 = 6.0;

/// Number of directions over a right angle, by the midpoint rule.
const DIRECTIONS: u32 = 24;

fn wave_of(shape: impl KernelShape, dimension: usize, k: f64) -> FluidWave {
    let slope = |r: f64| shape.height(dimension) * shape.factor() * shape.slope(0.5 * r);
    let mean = |of: &dyn Fn(f64) -> f64| {
        let angle = |index: u32| FRAC_PI_2 * (f64::from(index) + 0.5) / f64::from(DIRECTIONS);
        // In 3D the solid angle of a ring around the axis is proportional to the sine of its angle.
        let weight = |angle: f64| if dimension == 2 { 1.0 } else { FRAC_PI_2 * libm::sin(angle) };
        (0..DIRECTIONS).map(angle).map(|angle| weight(angle) * of(libm::cos(angle))).sum::<f64>() / f64::from(DIRECTIONS)
    };
    let squeezed = |r: f64| mean(&|cosine| cosine * cosine * (1.0 - libm::cos(k * r * cosine)));
    FluidWave {
        number: k,
        frequency: integral(dimension, |r| -slope(r) * r * mean(&|cosine| cosine * libm::sin(k * r * cosine))),
        decay: integral(dimension, |r| -slope(r) * mean(&|cosine| 1.0 - libm::cos(k * r * cosine))),
        squeeze: integral(dimension, |r| -slope(r) * squeezed(r)),
        strain: integral(dimension, |r| -slope(r) * r * r * squeezed(r)) / variance(shape, dimension),
    }
}

/// Variance σ² = ∫ W x² dV of a kernel along an axis, for unit smoothing length. By parts, σ² = −∫ F x²y² dV.
#[inline]
pub fn variance(shape: impl KernelShape, dimension: usize) -> f64 {
    integral(dimension, |r| shape.height(dimension) * shape.value(0.5 * r) * r * r) / dimension as f64
}

/// Volume integral of a function of the distance over the support of a kernel of unit smoothing length, by Simpson's rule.
pub(super) fn integral(dimension: usize, value: impl Fn(f64) -> f64) -> f64 {
    let shell = |r: f64| if dimension == 2 { 2.0 * PI * r } else { 4.0 * PI * r * r };
    let width = 2.0 / STEPS as f64;
    let weight = |step: usize| if step == 0 || step == STEPS { 1.0 } else { 2.0 + 2.0 * (step % 2) as f64 };
    let at = |step: usize| step as f64 * width;
    (0..=STEPS).map(|step| weight(step) * value(at(step)) * shell(at(step))).sum::<f64>() * width / 3.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particles::kernel::{OtherShape, WendlandC2};

    /// The inviscid limit 2/ω, in units of h/c, equals the measured value. It is also 3.3 standard deviations of the kernel, as
    /// for a Gaussian, whose ω is c k exp(−σ²k²/2), at most c/(σ√e).
    #[test]
    fn the_acoustic_limit_is_that_of_the_literature() {
        fn check(shape: impl KernelShape, dimension: usize, expected: f64) {
            let fastest = waves(shape, dimension).iter().map(|wave| wave.frequency).fold(0.0, f64::max);
            assert!((2.0 / fastest - expected).abs() < 5e-3 * expected, "{} {expected}", 2.0 / fastest);
            let deviation = variance(shape, dimension).sqrt();
            assert!((2.0 / fastest / deviation - 3.3).abs() < 0.05, "{}", 2.0 / fastest / deviation);
        }
        check(WendlandC2, 2, 1.756);
        check(WendlandC2, 3, 1.722);
        check(OtherShape::CubicSpline, 2, 1.878);
        check(OtherShape::CubicSpline, 3, 1.829);
        check(OtherShape::WendlandC4, 2, 1.531);
        check(OtherShape::WendlandC4, 3, 1.507);
    }
}
