//! Moduli of surface tension that hold a lattice together, and the stiffness of its repulsion.

use std::f64::consts::FRAC_2_PI;

use super::SHORT_RANGE;
use crate::particles::kernel::{KernelShape, SmoothingKernel};
use crate::particles::lattice;

/// Local density s up to which the time-step bound holds. In settled drops it is 1.2 at most.
const DENSEST: f64 = 1.5;

/// Ratio A/B in 2D and 3D, in units of the ratio with which the outermost layer of a flat lattice is in equilibrium. With these
/// values the equation of state bears Laplace's pressure. They were measured with Wendland's C2 and h = 1.5 Δ, in drops of 12 to
/// 30 spacings in 2D and of 8 to 12 in 3D.
const COHESION: [f64; 2] = [1.8, 1.65];

/// Ratio of the energy of a relaxed surface to that of a flat lattice surface, in 2D and 3D, measured on the drops of
/// [`COHESION`].
pub const SETTLED: [f64; 2] = [0.75, 0.80];

/// Sum S₀ in close packing, and the largest stiffness of the repulsion at the local density [`DENSEST`], for unit C and spacing.
///
/// Let φ = (1 − r/r₀)² be the weight, and P = Σ |dφ/dr| / S₀. A wave of displacements changes s by P ⟨|cos|⟩ at most, and P² is
/// proportional to s for a constant number of neighbors. The curvature of φ, 2/r₀², adds (s − 1) 4 Σ 2 cos²/(r₀² S₀) = (s − 1) 2
/// P²/D.
pub fn close_packing(dimension: usize) -> [f64; 2] {
    // Hexagonal and face-centered cubic lattice, whose second neighbors are farther than r₀.
    let [count, distance, cosine] =
        [[6.0, libm::pow(4.0 / 3.0, 0.25), FRAC_2_PI], [12.0, libm::pow(2.0, 1.0 / 6.0), 0.5]][dimension - 2];
    let closeness = 1.0 - distance / SHORT_RANGE;
    let slope = 2.0 / (SHORT_RANGE * closeness);
    let stiffness = slope * slope * (DENSEST * cosine * cosine + 2.0 * (DENSEST - 1.0) / dimension as f64);
    [count * closeness * closeness, stiffness]
}

/// Moduli A and B for unit smoothing length and this spacing. Their ratio is [`COHESION`] times that with which the outermost
/// layer of a flat lattice is in equilibrium. The layers together have unit energy.
pub fn moduli<K: KernelShape>(shape: K, spacing: f64, dimension: usize) -> [f64; 2] {
    let (rest, scale) = lattice::density(shape, spacing, dimension);
    let kernel = SmoothingKernel::<f64, K>::new(shape, 1.0, spacing, dimension);
    // Layers count from the surface. A neighbor at x outward exists if its layer does.
    let layer = |x: f64| (x / spacing).round();
    let layers = || (0..).map(f64::from).take_while(|row| row * spacing < 2.0);
    let over = |row: f64, of: &dyn Fn(f64, f64) -> f64| {
        lattice::sum(spacing, dimension, |x, r| if layer(x) <= row { of(x, r) } else { 0.0 })
    };
    let missing = |row: f64| 1.0 - over(row, &|_, r| kernel.value(r)) / rest;
    let gradient = |row: f64| over(row, &|x, r| kernel.slope(1.0, r) * x);
    let energies = [
        spacing * layers().map(|row| 0.5 * missing(row).powi(2)).sum::<f64>(),
        spacing * layers().map(|row| 0.5 * gradient(row).powi(2)).sum::<f64>(),
    ];
    let forces = [
        over(0.0, &|x, r| (missing(0.0) + missing(-layer(x))) / (scale * rest) * kernel.slope(1.0, r) * x),
        over(0.0, &|x, r| (kernel.slope(1.0, r) + kernel.bend(1.0, r) * x * x) * (gradient(-layer(x)) - gradient(0.0))),
    ];
    let [area, gradient] = [COHESION[dimension - 2] * forces[1], -forces[0]];
    let energy = area * energies[0] + gradient * energies[1];
    [area / energy, gradient / energy]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particles::kernel::{OtherShape, WendlandC2};

    #[test]
    fn both_parts_hold_a_surface_together() {
        fn check(shape: impl KernelShape + std::fmt::Debug) {
            for (dimension, smoothing) in [(2, 1.5), (3, 1.25), (3, 1.5)] {
                let [area, gradient] = moduli(shape, 1.0 / smoothing, dimension);
                assert!(area > 0.0 && gradient > 0.0, "{shape:?} in {dimension}D: {area} {gradient}");
            }
        }
        check(WendlandC2);
        check(OtherShape::WendlandC4);
        check(OtherShape::CubicSpline);
    }
}
