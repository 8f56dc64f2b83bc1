//! Largest eigenvalue of M⁻¹K (and likewise of M⁻¹C) for the present directions of the springs, by a few steps of the Lanczos
//! method.
//!
//! The Gershgorin rows ([`super::rows`]) hold for all directions of the springs; this method uses the present ones. It takes
//! products of the matrix M⁻½ K M⁻½ with a vector. Its largest Ritz value θ approaches the largest eigenvalue from below. An
//! eigenvalue lies within the residual |β s| of θ. Probably it is the largest one, but this is not certain: hence a margin, and
//! the rows where certainty is required. The start vector has random signs, and is large where the rows are large, as the fastest
//! modes are.
//!
//! Source: C. Lanczos, J. Res. Natl. Bur. Stand. 45 (1950) 255; B. N. Parlett, The Symmetric Eigenvalue Problem (1980),
//! chapter 13. The vectors are not reorthogonalized: loss of orthogonality repeats converged eigenvalues, and adds none.

use glam::DVec3;

use crate::math::noise;

/// Spring between two particles: its matrix has the longitudinal value `along` and the transverse value `across`.
#[derive(Debug, Clone, Copy)]
pub struct SpringEdge {
    pub ends: [u32; 2],
    pub direction: DVec3,
    pub along: f64,
    pub across: f64,
}

/// Number of matrix–vector products. Sixteen sufficed for 1000 random networks of up to 1600 particles.
const PRODUCTS: usize = 16;
/// Safety factor of the sum of the Ritz value and its residual.
const MARGIN: f64 = 1.02;
/// Length of a new vector, relative to θ, below which it is rounding error: the Krylov space of the start vector is exhausted.
const NOTHING: f64 = 1e-9;

/// Range of rates whose squares neither overflow nor underflow; outside it the rows are used.
const SQUARABLE: std::ops::Range<f64> = 1e-140..1e140;

/// Estimates of the largest eigenvalue, from below and from above; the upper estimate is rarely too small.
///
/// The matrix consists of the springs `edges` and of terms `alone` on single particles [1/s²]. The slice `root` holds the square
/// roots of the inverse masses, and `rows` the bound by rows at each particle.
pub fn largest(edges: &[SpringEdge], alone: &[f64], root: &[f64], rows: &[f64]) -> [f64; 2] {
    let highest = rows.iter().fold(0.0, |highest: f64, &row| highest.max(row));
    if highest == 0.0 {
        return [0.0; 2];
    }
    if !SQUARABLE.contains(&highest) {
        return [0.0, f64::INFINITY];
    }
    let flat = edges.iter().all(|edge| edge.direction.z == 0.0);
    // In a plane configuration the fastest mode lies in the plane: a spring is stiffer longitudinally than transversely.
    let space = DVec3::new(1.0, 1.0, if flat { 0.0 } else { 1.0 });
    let start = rows.iter().enumerate().map(|(index, &row)| (row / highest).powi(2) * space * noise(index as u64));
    let mut vector: Vec<DVec3> = start.collect();
    let mut last = vec![DVec3::ZERO; vector.len()];
    let mut image = last.clone();
    let norm = dot(&vector, &vector).sqrt();
    vector.iter_mut().for_each(|entry| *entry /= norm);
    let (mut diagonal, mut beside) = (Vec::with_capacity(PRODUCTS), Vec::with_capacity(PRODUCTS));
    let mut before = 0.0;
    for _ in 0..PRODUCTS {
        multiply(edges, alone, root, &vector, &mut image);
        let alpha = dot(&vector, &image);
        for ((image, vector), last) in image.iter_mut().zip(&vector).zip(&last) {
            *image -= alpha * *vector + before * *last;
        }
        before = dot(&image, &image).sqrt();
        diagonal.push(alpha);
        beside.push(before);
        if before <= NOTHING * highest {
            break;
        }
        std::mem::swap(&mut last, &mut vector);
        vector.iter_mut().zip(&image).for_each(|(vector, image)| *vector = *image / before);
    }
    let (ritz, residual) = top(&diagonal, &beside, highest);
    [ritz, MARGIN * (ritz + residual)]
}

/// Multiplies a vector by M⁻½ K M⁻½.
fn multiply(edges: &[SpringEdge], alone: &[f64], root: &[f64], vector: &[DVec3], image: &mut [DVec3]) {
    image.fill(DVec3::ZERO);
    for edge in edges {
        let [i, j] = edge.ends.map(|end| end as usize);
        let stretch = root[j] * vector[j] - root[i] * vector[i];
        let pull = edge.across * stretch + (edge.along - edge.across) * edge.direction.dot(stretch) * edge.direction;
        image[i] -= root[i] * pull;
        image[j] += root[j] * pull;
    }
    for ((image, vector), alone) in image.iter_mut().zip(vector).zip(alone) {
        *image += *alone * *vector;
    }
}

/// Scalar product, summed in a fixed order.
fn dot(one: &[DVec3], other: &[DVec3]) -> f64 {
    one.iter().zip(other).map(|(one, other)| one.dot(*other)).sum()
}

/// Largest eigenvalue of a symmetric tridiagonal matrix, at most `highest` up to rounding, and its residual. The residual is the
/// last off-diagonal element times the last entry of the eigenvector.
fn top(diagonal: &[f64], beside: &[f64], highest: f64) -> (f64, f64) {
    // Sylvester's law of inertia: all pivots of T − λ are negative just above the largest eigenvalue.
    let above = |value: f64| {
        let mut pivot = diagonal[0] - value;
        (1..diagonal.len()).all(|index| {
            let negative = pivot < 0.0;
            pivot = diagonal[index] - value - beside[index - 1].powi(2) / pivot;
            negative
        }) && pivot < 0.0
    };
    let (mut low, mut high) = (0.0, 1.01 * highest);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if above(middle) { high = middle } else { low = middle }
    }
    // In backward recurrence the converged eigenvector grows, so that rounding errors decay.
    let last = diagonal.len() - 1;
    let (mut entry, mut after, mut square) = (1.0, 0.0, 1.0);
    for index in (1..=last).rev() {
        let next =
            ((high - diagonal[index]) * entry - if index == last { 0.0 } else { beside[index] * after }) / beside[index - 1];
        (entry, after) = (next, entry);
        square += entry * entry;
    }
    (high, beside[last] / square.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The matrix (2 1; 1 3) has the eigenvalue λ = (5 + √5)/2 with the vector (1, λ − 2).
    #[test]
    fn the_residual_is_the_last_number_times_the_last_entry_of_the_unit_vector() {
        let exact = 0.5 * (5.0 + 5.0_f64.sqrt());
        let (found, residual) = top(&[2.0, 3.0], &[1.0, 0.5], 4.0);
        assert!((found - exact).abs() < 1e-14);
        assert!((residual - 0.5 * (exact - 2.0) / 1.0_f64.hypot(exact - 2.0)).abs() < 1e-14);
        // With a single vector, the residual is the remainder of its image.
        assert_eq!(top(&[2.0], &[0.5], 4.0).1, 0.5);
    }
}
