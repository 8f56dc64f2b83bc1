//! Stiffness and damping of a user-defined force: the norms of its gradients, estimated from calls of the force.
//!
//! The estimate of ∂F/∂x takes products of G = M^-½ ∂F/∂x M^-½ with vectors, which are differences of forces. The estimate of
//! ∂F/∂v is analogous. The products span a subspace with the orthonormal basis Q, in which G Q = Q' H with a small Hessenberg
//! matrix H. The norm of H is the largest |G u| of all unit vectors u in the subspace, and approaches |G| from below. For a
//! symmetric G, as of a conservative force, |G| equals the largest |eigenvalue|; otherwise it is not below it. If the subspace is
//! exhausted, as for a few particles, the norm is exact up to the error of the differences. Otherwise a margin is added.
//!
//! Sources: W. E. Arnoldi, Q. Appl. Math. 9 (1951) 17; L. N. Trefethen, D. Bau, Numerical Linear Algebra (1997), lectures 33–34;
//! for products by differences P. N. Brown, Y. Saad, SIAM J. Sci. Stat. Comput. 11 (1990) 450.
//!
//! **Displacements.** A difference over h has a truncation error of (h/l)², where l is the length over which the force varies.
//! Its rounding error is ε|F|/h, so that the best h is ε^⅓ l. For several particles l is a distance between neighbors.
//! Coordinates of size X are rounded to εX as well, so that h is at least ε^⅔ X. For a single particle l is a thousandth of X, or
//! a millimeter for X = 0. Velocities change by ε^⅓ of the largest speed, or of the speed that the stiffness gives over l.
//!
//! **Jumps and kinks.** Each product takes h in one direction and h/4 in the other. Where the two slopes of a particle differ,
//! the two remaining ones are evaluated as well. On each side, a slope counts if it is the same over h and over h/4. At a kink,
//! the steeper side counts. At a jump, the slope has no meaning, and none counts. Non-finite forces next to the state count as
//! small.

use glam::DVec3;

use crate::error::Result;
use crate::math::noise;

/// Maximum number of matrix–vector products for each gradient.
const PRODUCTS: usize = 16;
/// Minimum number of products before convergence, and relative growth of the norm per product at convergence.
const LEAST_PRODUCTS: usize = 6;
const CONVERGED: f64 = 1.01;
/// Factor on a converged norm, which is estimated from below.
const MARGIN: f64 = 1.1;
/// Relative residual of an exhausted subspace: the error of the differences.
const NOTHING: f64 = 1e-4;
/// Relative norm of the antisymmetric part below which it counts as an error of the differences.
const NO_TURN: f64 = 1e-2;
/// Relative difference between the slopes of a smooth force.
const SMOOTH: f64 = 0.1;
/// Rounding error of a user-defined force, relative to the largest force.
const ROUNDING: f64 = 8.0 * f64::EPSILON;
/// Ratio of the smaller to the larger displacement of a product: a power of two.
const NEAR: f64 = 0.25;
/// Substitute for a norm whose square overflows [1/s²].
const STEEPEST: f64 = 1e150;
/// Number of squarings of the Gram matrix. The trace then is the largest eigenvalue to the power 2¹⁴, times a factor of at most
/// the matrix size.
const SQUARINGS: usize = 14;

/// Maximum number of calls of the function: two at the state, and four for each product of both gradients.
pub const MOST_CALLS: usize = 2 + 2 * 4 * PRODUCTS;

/// Estimate of a mass-weighted gradient.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gradient {
    /// Spectral norm [1/s²] or [1/s].
    pub norm: f64,
    /// Spectral norm of the antisymmetric part, 0 if that is an error of the differences.
    pub rotation: f64,
}

impl Gradient {
    /// The gradient of a constant force.
    pub const NONE: Self = Self { norm: 0.0, rotation: 0.0 };
}

/// Forces [N] with every particle displaced by a multiple of its own displacement vector.
pub type Displaced<'a> = dyn Fn(&[DVec3], f64) -> Result<Vec<DVec3>> + 'a;

/// Input of a gradient estimate.
pub struct GradientInput<'a> {
    /// Forces of the function at displaced states.
    pub given: &'a Displaced<'a>,
    /// Forces [N] at the state itself.
    pub force: &'a [DVec3],
    /// Inverse root mass 1/√m of each particle [kg^-½], 0 for fixed particles; not all 0.
    pub root: &'a [f64],
    pub dimension: usize,
    /// Largest displacement of a particle.
    pub step: f64,
}

impl GradientInput<'_> {
    /// Estimates the gradient of the force.
    pub fn gradient(&self) -> Result<Gradient> {
        let mask = DVec3::new(1.0, 1.0, if self.dimension == 2 { 0.0 } else { 1.0 });
        let free = |index: usize| if self.root[index] > 0.0 { mask } else { DVec3::ZERO };
        let start: Vec<DVec3> = (0..self.root.len()).map(|index| free(index) * noise(index as u64)).collect();
        let length = norm(&start);
        let mut basis = vec![scaled(&start, length.recip())];
        let mut hessenberg: Vec<Vec<f64>> = Vec::new();
        let size = self.dimension * self.root.iter().filter(|&&root| root > 0.0).count();
        let mut before = 0.0;
        loop {
            let mut image = self.product(&basis[basis.len() - 1])?;
            let mut column = Vec::with_capacity(basis.len() + 1);
            for vector in &basis {
                let part = dot(vector, &image);
                image.iter_mut().zip(vector).for_each(|(image, vector)| *image -= part * *vector);
                column.push(part);
            }
            let rest = norm(&image);
            column.push(rest);
            hessenberg.push(column);
            let found = largest(&hessenberg);
            let products = hessenberg.len();
            if !found.is_finite() {
                return Ok(Gradient { norm: STEEPEST, rotation: 0.0 });
            }
            let whole = rest <= NOTHING * found || products == size;
            if whole || products == PRODUCTS || (products >= LEAST_PRODUCTS && found <= CONVERGED * before) {
                let rotation = largest(&turning(&hessenberg));
                let rotation = if rotation > NO_TURN * found { rotation } else { 0.0 };
                let margin = if whole { 1.0 } else { MARGIN };
                return Ok(Gradient { norm: margin * found, rotation: margin * rotation });
            }
            before = found;
            basis.push(scaled(&image, rest.recip()));
        }
    }

    /// Product of M^-½ ∂F/∂x M^-½ with a vector.
    fn product(&self, vector: &[DVec3]) -> Result<Vec<DVec3>> {
        let way: Vec<DVec3> = vector.iter().zip(self.root).map(|(entry, &root)| root * *entry).collect();
        let h = self.step / way.iter().fold(0.0, |longest: f64, way| longest.max(way.length()));
        let rounding = ROUNDING * self.force.iter().fold(0.0, |largest: f64, force| largest.max(force.abs().max_element()));
        let alike = |one: DVec3, other: DVec3, h: f64| {
            let separation = (one - other).length();
            separation.is_finite() && separation <= SMOOTH * one.length().max(other.length()) + rounding / (NEAR * h)
        };
        let (ahead, behind) = (self.slopes(&way, h)?, self.slopes(&way, -NEAR * h)?);
        let mut slopes: Vec<DVec3> = ahead
            .iter()
            .zip(&behind)
            // Both errors are h times the second derivative, and cancel in this mean.
            .map(|(&ahead, &behind)| (NEAR * ahead + behind) / (1.0 + NEAR))
            .collect();
        let free = |index: usize| self.root[index] > 0.0;
        if (0..way.len()).any(|index| free(index) && !alike(ahead[index], behind[index], h)) {
            let (close, far) = (self.slopes(&way, NEAR * h)?, self.slopes(&way, -h)?);
            for index in (0..way.len()).filter(|&index| !alike(ahead[index], behind[index], h)) {
                let sides = [(ahead[index], close[index]), (far[index], behind[index])];
                let steady = sides.into_iter().filter(|&(wide, near)| alike(wide, near, h)).map(|(_, near)| near);
                slopes[index] =
                    steady.fold(DVec3::ZERO, |steepest, side| if side.length() > steepest.length() { side } else { steepest });
            }
        }
        let worth = |slope: DVec3| if slope.length() > rounding / (NEAR * h) { slope } else { DVec3::ZERO };
        Ok(slopes.into_iter().zip(self.root).map(|(slope, &root)| root * worth(slope)).collect())
    }

    /// Directional derivatives of the forces.
    fn slopes(&self, way: &[DVec3], h: f64) -> Result<Vec<DVec3>> {
        let given = (self.given)(way, h)?;
        Ok(given.iter().zip(self.force).map(|(given, force)| (*given - *force) / h).collect())
    }
}

/// Largest displacement of a particle [m], and the length over which the force is assumed to vary [m].
pub fn displacement(positions: &[DVec3]) -> (f64, f64) {
    let size = positions.iter().fold(0.0, |size: f64, position| size.max(position.abs().max_element()));
    let size = if size > 0.0 { size } else { 1.0 };
    let mut sorted = positions.to_vec();
    sorted.sort_by(|one, other| one.x.total_cmp(&other.x).then(one.y.total_cmp(&other.y)).then(one.z.total_cmp(&other.z)));
    let separation = sorted.windows(2).map(|pair| pair[0].distance(pair[1])).filter(|&separation| separation > 0.0);
    let nearest = separation.fold(f64::INFINITY, f64::min);
    let length = if nearest.is_finite() { nearest } else { 1e-3 * size };
    let third = libm::cbrt(f64::EPSILON);
    ((third * length).max(third * third * size), length)
}

/// Largest change of a velocity [m/s], where `swing` is the speed that follows from the stiffness [m/s].
#[inline]
pub fn velocity_increment(velocities: &[DVec3], swing: f64) -> f64 {
    let fastest = velocities.iter().fold(swing, |fastest, velocity| fastest.max(velocity.length()));
    libm::cbrt(f64::EPSILON) * if fastest > 0.0 { fastest } else { 1.0 }
}

/// Antisymmetric part of a Hessenberg matrix without its last row, given by its columns.
fn turning(hessenberg: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let size = hessenberg.len();
    let entry = |row: usize, column: usize| hessenberg[column].get(row).copied().unwrap_or(0.0);
    (0..size).map(|column| (0..size).map(|row| 0.5 * (entry(row, column) - entry(column, row))).collect()).collect()
}

/// Spectral norm of a small matrix, given by its columns, with a relative error of up to +1e-4. Computed as λ = (trace of
/// (AᵀA)^p)^(1/p) with p = 2¹⁴.
fn largest(columns: &[Vec<f64>]) -> f64 {
    let size = columns.len();
    let product = |one: &[f64], other: &[f64]| one.iter().zip(other).map(|(one, other)| one * other).sum::<f64>();
    let mut gram: Vec<Vec<f64>> = columns.iter().map(|one| columns.iter().map(|other| product(one, other)).collect()).collect();
    let mut traces = Vec::with_capacity(SQUARINGS + 1);
    for _ in 0..=SQUARINGS {
        let trace: f64 = (0..size).map(|index| gram[index][index]).sum();
        if trace == 0.0 {
            return 0.0;
        }
        traces.push(trace);
        gram.iter_mut().flatten().for_each(|entry| *entry /= trace);
        gram = gram.iter().map(|one| gram.iter().map(|other| product(one, other)).collect()).collect();
    }
    traces.iter().rev().fold(1.0, |root: f64, trace| (trace * root).sqrt())
}

fn dot(one: &[DVec3], other: &[DVec3]) -> f64 {
    one.iter().zip(other).map(|(one, other)| one.dot(*other)).sum()
}

fn norm(vector: &[DVec3]) -> f64 {
    dot(vector, vector).sqrt()
}

fn scaled(vector: &[DVec3], factor: f64) -> Vec<DVec3> {
    vector.iter().map(|entry| factor * *entry).collect()
}
