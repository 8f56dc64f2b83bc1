//! The limit of the time step: the largest frequency of the discrete operator.
//!
//! With uniform speed along an axis of n cells, −Lₐ has the largest eigenvalue 4w sin²(θ/2): θ = π with two fixed ends (the
//! checkerboard), π (n − 1)/n with two free ones, π (n − ½)/n with one of each, and the multiple of 2π/n next below π where it
//! is periodic. Elsewhere rows bound it (Gershgorin): Σ w + |Σ w + κ|. With differences of order 4, λₐ becomes λₐ + λₐ²/(12 w).

use super::medium::Medium;
use super::sweep::Dynamics;
use crate::grid::{Edge, RowTable};
use crate::integrators::Integrator;
use crate::math::Real;
use crate::stability::{Horizon, Limit, SpectralBound};

/// The limit for an integrator.
pub fn limit<T: Real, I: Integrator>(dynamics: &Dynamics<T>) -> Limit {
    let medium = &dynamics.medium;
    let square = medium.uniform.map_or_else(|| bound(medium), |weight| exact(medium, weight.to_f64()));
    let rates = dynamics.damping.different().iter().map(|rate| rate.to_f64());
    let (least, most) = rates.fold((f64::INFINITY, 0.0_f64), |(least, most), rate| (least.min(rate), most.max(rate)));
    // In a layer u = exp((iω − ζ) t): a Runge–Kutta method, a function of the Jacobian, meets an oscillator of ω² + ζ² and 2ζ. Drifts
    // and kicks are bound by ω alone.
    let steepest = dynamics.layers.as_ref().map_or(0.0, |layers| if I::DRIFT_KICK.is_none() { layers.steepest } else { 0.0 });
    let (square, most) = (square + steepest * steepest, most.max(2.0 * steepest));
    let least: f64 = if steepest > 0.0 { 0.0 } else { least };
    let mut spectrum = SpectralBound::new(&[1.0], &[0], Horizon::Certified);
    spectrum.point(0, "wave", square, most);
    spectrum.steady(0, 0.0, least);
    let limit = spectrum.limit::<I>();
    let known = medium.uniform.is_some() && most == 0.0 && dynamics.layers.is_none();
    Limit { endured: if known { limit.stability } else { f64::INFINITY }, ..limit }
}

/// The largest ω² where w is the same everywhere [1/s²].
fn exact<T: Real>(medium: &Medium<T>, weight: f64) -> f64 {
    let of = |axis: usize| {
        let (count, edges) = (medium.grid.cells[axis] as f64, medium.edges.0[axis]);
        let halves = match edges.iter().filter(|&&edge| edge == Edge::Fixed).count() {
            2 => count,
            1 => count - 0.5,
            _ if medium.grid.periodic[axis] => 2.0 * (0.5 * count).floor(),
            _ => count - 1.0,
        };
        let square = libm::sin(0.5 * std::f64::consts::PI * halves / count).powi(2);
        let eigenvalue = 4.0 * weight * square;
        if medium.fourth.is_some() { eigenvalue * (1.0 + square / 3.0) } else { eigenvalue }
    };
    medium.grid.axes().map(of).sum()
}

/// An upper bound of ω² from the rows of the matrix [1/s²].
fn bound<T: Real>(medium: &Medium<T>) -> f64 {
    let Some(fourth) = &medium.fourth else {
        return largest_row(medium, medium.grid.axes(), &medium.anchor, None);
    };
    let of = |axis: usize| {
        let rows = |slowness| largest_row(medium, axis..axis + 1, &fourth.anchors[axis], slowness);
        // Lₐ h²/(12c²) Lₐ has at most the product of the largest eigenvalues of Lₐ and of h²/(12c²) Lₐ.
        rows(None) * (1.0 + rows(Some(&fourth.slowness)))
    };
    medium.grid.axes().map(of).sum()
}

/// The largest of 2 Σ w + κ over all cells, where κ is that along these axes; times the slowness where one is given.
fn largest_row<T: Real>(
    medium: &Medium<T>,
    axes: std::ops::Range<usize>,
    anchor: &RowTable<T>,
    slowness: Option<&RowTable<T>>,
) -> f64 {
    let grid = &medium.grid;
    let length = grid.row_length();
    let mut most = 0.0_f64;
    for row in 0..grid.rows() {
        for cell in 0..length {
            let mut faces = 0.0;
            for axis in axes.clone() {
                let table = &medium.faces[axis];
                let (lower, at) = if axis < 2 {
                    (grid.beside(row, axis, false).unwrap_or(row), cell)
                } else {
                    (row, if cell == 0 { length - 1 } else { cell - 1 })
                };
                let below = if axis < 2 && grid.beside(row, axis, false).is_none() { 0.0 } else { table.row(lower)[at].to_f64() };
                faces += table.row(row)[cell].to_f64() + below;
            }
            let sum = 2.0 * faces + anchor.row(row)[cell].to_f64();
            most = most.max(slowness.map_or(sum, |slowness| slowness.row(row)[cell].to_f64() * sum));
        }
    }
    most
}
