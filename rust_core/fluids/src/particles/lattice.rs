//! Sums of a kernel over the square or cubic lattice of a fluid at rest.

use super::kernel::KernelShape;

/// Moment −Σ Δ^D F x² over a lattice of spacing Δ, for unit smoothing length.
pub fn moment(shape: impl KernelShape, spacing: f64, dimension: usize) -> f64 {
    sum(spacing, dimension, |x, r| -shape.height(dimension) * shape.factor() * shape.slope(0.5 * r) * x * x)
}

/// Lattice sum S = Σ Δ^D W over the neighbors on a lattice of spacing Δ, and the factor κ of differences from S. The factor makes
/// a small compression of the lattice exact. Both are for unit smoothing length.
#[inline]
pub fn density(shape: impl KernelShape, spacing: f64, dimension: usize) -> (f64, f64) {
    let density = sum(spacing, dimension, |_, r| shape.height(dimension) * shape.value(0.5 * r));
    (density, 1.0 / moment(shape, spacing, dimension))
}

/// Sum Σ Δ^D |∇W| over the neighbors of a particle on a lattice of spacing Δ, for unit smoothing length.
#[inline]
pub fn gradient(shape: impl KernelShape, spacing: f64, dimension: usize) -> f64 {
    sum(spacing, dimension, |_, r| -shape.height(dimension) * shape.factor() * shape.slope(0.5 * r) * r)
        / moment(shape, spacing, dimension)
}

/// Sum Σ Δ^D f(x, r) over the neighbors on a lattice of spacing Δ within two units.
pub fn sum(spacing: f64, dimension: usize, of: impl Fn(f64, f64) -> f64) -> f64 {
    let most = (2.0 / spacing).floor() as i32;
    let across = if dimension == 2 { 0..=0 } else { -most..=most };
    let mut total = 0.0;
    for z in across {
        for (y, x) in (-most..=most).flat_map(|y| (-most..=most).map(move |x| (y, x))) {
            let square = f64::from(x * x + y * y + z * z) * spacing * spacing;
            if square > 0.0 && square < 4.0 {
                total += of(f64::from(x) * spacing, square.sqrt());
            }
        }
    }
    total * if dimension == 2 { spacing * spacing } else { spacing * spacing * spacing }
}
