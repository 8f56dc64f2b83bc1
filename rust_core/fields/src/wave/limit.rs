//! Limit of the time step: the largest frequency of the discrete operator.
//!
//! With differences of order 4 along each axis, an eigenvalue λₐ of that axis becomes λₐ + λₐ²/(12 w).

use super::medium::{Fourth, Medium};
use super::sweep::WaveLaw;
use crate::integrators::Facts;
use crate::math::Real;
use crate::stability::{Horizon, Limit, SpectralBound};

/// Limit for an integrator.
pub fn limit<T: Real>(dynamics: &WaveLaw<T>, method: &Facts) -> Limit {
    let medium = &dynamics.medium;
    let axes = medium.laplacian.grid.axes();
    let square = match &medium.fourth {
        None => match &medium.density {
            None => medium.laplacian.largest(),
            Some(density) => medium.laplacian.largest_row(axes, &medium.laplacian.anchor, Some(&density.inverse)),
        },
        Some(fourth) => of_fourth_order(medium, fourth),
    };
    let rates = dynamics.damping.different().iter().map(|rate| rate.to_f64());
    let (least, most) = rates.fold((f64::INFINITY, 0.0_f64), |(least, most), rate| (least.min(rate), most.max(rate)));
    // In a layer u = exp((iω − ζ) t). A Runge–Kutta method, a function of the Jacobian, encounters an oscillator of ω² + ζ² and
    // 2ζ. Drifts and kicks are limited by ω alone.
    let steepest = dynamics.layers.as_ref().map_or(0.0, |layers| if method.drift_kick.is_none() { layers.steepest } else { 0.0 });
    let (square, most) = (square + steepest * steepest, most.max(2.0 * steepest));
    let least: f64 = if steepest > 0.0 { 0.0 } else { least };
    let mut spectrum = SpectralBound::new(&[1.0], &[0], Horizon::Certified);
    spectrum.point(0, "wave", square, most);
    spectrum.steady(0, 0.0, least);
    let limit = spectrum.limit(method);
    let known = medium.laplacian.uniform.is_some() && most == 0.0 && dynamics.layers.is_none();
    Limit { endured: if known { limit.stability } else { f64::INFINITY }, ..limit }
}

/// Largest ω² of the operator of order 4 [1/s²]: exact if w is uniform, else an upper bound.
fn of_fourth_order<T: Real>(medium: &Medium<T>, fourth: &Fourth<T>) -> f64 {
    let laplacian = &medium.laplacian;
    let of = |axis: usize| {
        if let Some(weight) = laplacian.uniform {
            let square = laplacian.largest_sine_squared(axis);
            4.0 * weight.to_f64() * square * (1.0 + square / 3.0)
        } else {
            let rows = |slowness| laplacian.largest_row(axis..axis + 1, &fourth.anchors[axis], slowness);
            // The eigenvalues of Lₐ/r h²/(12 r c²) Lₐ are at most the product of the largest ones of Lₐ/r and of h²/(12 r c²) Lₐ.
            rows(medium.density.as_ref().map(|density| &density.inverse)) * (1.0 + rows(Some(&fourth.slowness)))
        }
    };
    laplacian.grid.axes().map(of).sum()
}
