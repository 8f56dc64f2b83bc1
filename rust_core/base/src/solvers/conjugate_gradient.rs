//! Preconditioned conjugate gradients for linear equations A x = b with a symmetric positive definite matrix A.
//!
//! The matrix is known by its products alone. The components of vectors are numbers or vectors of space. All
//! sums are in one fixed order, so that the bits are the same for any number of threads. In exact arithmetic, as many
//! products as there are numbers give the solution. Fewer do if eigenvalues of the preconditioned matrix are close together.
//!
//! Source: J. Nocedal, S. J. Wright, "Numerical Optimization", 2nd ed., 2006, algorithm 5.3.

use std::ops::{Add, AddAssign, Mul, Neg, SubAssign};

use glam::DVec3;

use crate::parallel::Executor;

/// Products per number after which a solution is given up, and products besides.
const MOST_PER_NUMBER: u64 = 3;
const MOST_BESIDES: u64 = 10;

/// Component of a vector: a number, or a vector of space.
pub trait VectorComponent:
    Copy + Add<Output = Self> + AddAssign + SubAssign + Neg<Output = Self> + Mul<f64, Output = Self> + PartialEq
{
    /// Zero.
    const ZERO: Self;

    /// Scalar product.
    fn product(self, other: Self) -> f64;
}

impl VectorComponent for f64 {
    const ZERO: Self = 0.0;

    #[inline]
    fn product(self, other: Self) -> f64 {
        self * other
    }
}

impl VectorComponent for DVec3 {
    const ZERO: Self = Self::ZERO;

    #[inline]
    fn product(self, other: Self) -> f64 {
        self.dot(other)
    }
}

/// Matrix with its preconditioner. Both are symmetric.
pub trait DefiniteSystem<E> {
    /// Writes A p into `product`.
    fn multiply(&self, p: &[E], product: &mut [E]);

    /// Writes an approximation of A⁻¹ r into `z`, by a positive definite preconditioner.
    fn precondition(&self, r: &[E], z: &mut [E]);
}

/// Solution of linear equations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Solved {
    /// Number of products A p.
    pub products: u64,
    /// Whether the tolerance is reached; not after an interrupt, or if rounding errors prevent it.
    pub is_accurate: bool,
}

/// Solver with its buffers.
#[derive(Debug, Clone)]
pub struct ConjugateGradient<E> {
    residual: Vec<E>,
    /// Residual multiplied by the preconditioner.
    preconditioned: Vec<E>,
    direction: Vec<E>,
    product: Vec<E>,
}

impl<E> Default for ConjugateGradient<E> {
    fn default() -> Self {
        Self { residual: Vec::new(), preconditioned: Vec::new(), direction: Vec::new(), product: Vec::new() }
    }
}

/// Scalar product of two vectors.
#[inline]
pub fn dot<E: VectorComponent>(one: &[E], other: &[E]) -> f64 {
    one.iter().zip(other).map(|(one, other)| one.product(*other)).sum()
}

impl<E: VectorComponent> ConjugateGradient<E> {
    /// Allocates buffers for vectors of `count` components.
    pub fn resize(&mut self, count: usize) {
        for vector in [&mut self.residual, &mut self.preconditioned, &mut self.direction, &mut self.product] {
            vector.resize(count, E::ZERO);
        }
    }

    /// Solves A x = b from x = 0 until |b − A x| is at most `tolerance` |b|. Returns None if A is not positive definite along a
    /// direction that was found; `x` is then the solution so far.
    #[inline]
    pub fn solve(
        &mut self,
        system: &impl DefiniteSystem<E>,
        b: impl ExactSizeIterator<Item = E>,
        x: &mut [E],
        tolerance: f64,
        executor: &Executor,
    ) -> Option<Solved> {
        self.resize(b.len());
        let Self { residual: r, preconditioned: z, direction: p, product } = self;
        x.fill(E::ZERO);
        r.iter_mut().zip(b).for_each(|(r, b)| *r = b);
        system.precondition(r, z);
        p.clone_from(z);
        let (mut now, target) = (dot(r, z), tolerance * tolerance * dot(r, r));
        let most = MOST_PER_NUMBER * r.len() as u64 + MOST_BESIDES;
        for products in 0..most {
            let is_accurate = dot(r, r) <= target;
            if is_accurate || now <= 0.0 || executor.stopped() {
                return Some(Solved { products, is_accurate });
            }
            system.multiply(p, product);
            let curvature = dot(p, product);
            if curvature <= 0.0 {
                return None;
            }
            let step = now / curvature;
            x.iter_mut().zip(p.iter()).for_each(|(x, &p)| *x += p * step);
            r.iter_mut().zip(product.iter()).for_each(|(r, &product)| *r -= product * step);
            system.precondition(r, z);
            let next = dot(r, z);
            p.iter_mut().zip(z.iter()).for_each(|(p, &z)| *p = z + *p * (next / now));
            now = next;
        }
        Some(Solved { products: most, is_accurate: dot(r, r) <= target })
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        4 * size_of_val(self.residual.as_slice())
    }
}

#[cfg(test)]
mod tests {
    use glam::DMat3;

    use super::*;
    use crate::parallel::SERIAL;

    /// Poisson's equation on a line: −u″ with u = 0 at both ends, on points at unit distance, scaled row by row.
    struct Line {
        scale: Vec<f64>,
        preconditions: bool,
    }

    impl Line {
        fn of(count: usize, preconditions: bool) -> Self {
            Self { scale: (0..count).map(|row| 1.0 + 10.0 * (row % 3) as f64).collect(), preconditions }
        }
    }

    impl DefiniteSystem<f64> for Line {
        fn multiply(&self, p: &[f64], product: &mut [f64]) {
            let at = |row: usize| p.get(row).map_or(0.0, |p| self.scale[row] * p);
            for row in 0..p.len() {
                let before = if row == 0 { 0.0 } else { at(row - 1) };
                product[row] = self.scale[row] * (2.0 * at(row) - before - at(row + 1));
            }
        }

        fn precondition(&self, r: &[f64], z: &mut [f64]) {
            for row in 0..r.len() {
                z[row] = if self.preconditions { r[row] / (2.0 * self.scale[row].powi(2)) } else { r[row] };
            }
        }
    }

    fn residual(line: &Line, x: &[f64], b: &[f64]) -> f64 {
        let mut product = vec![0.0; x.len()];
        line.multiply(x, &mut product);
        let square: f64 = product.iter().zip(b).map(|(product, b)| (product - b).powi(2)).sum();
        (square / b.iter().map(|b| b * b).sum::<f64>()).sqrt()
    }

    #[test]
    fn poissons_equation_is_solved_to_the_tolerance_and_sooner_with_a_preconditioner() {
        let b: Vec<f64> = (0..60).map(|row| (f64::from(row) * 0.7).sin()).collect();
        let solve = |preconditions: bool, tolerance: f64| {
            let (line, mut x) = (Line::of(b.len(), preconditions), vec![f64::NAN; b.len()]);
            let solved = ConjugateGradient::default().solve(&line, b.iter().copied(), &mut x, tolerance, &SERIAL).unwrap();
            (solved, residual(&line, &x, &b))
        };
        for tolerance in [1e-2, 1e-8] {
            for (solved, residual) in [solve(false, tolerance), solve(true, tolerance)] {
                assert!(solved.is_accurate && residual <= 1.01 * tolerance, "{solved:?} {residual}");
            }
        }
        let [plain, helped] = [false, true].map(|preconditions| solve(preconditions, 1e-8).0.products);
        assert!(helped < plain && helped <= b.len() as u64 + 1, "{helped} {plain}");
    }

    /// Blocks on the diagonal, whose inverses are exact preconditioners.
    struct Blocks(Vec<DMat3>);

    impl DefiniteSystem<DVec3> for Blocks {
        fn multiply(&self, p: &[DVec3], product: &mut [DVec3]) {
            product.iter_mut().zip(p).zip(&self.0).for_each(|((product, &p), block)| *product = *block * p);
        }

        fn precondition(&self, r: &[DVec3], z: &mut [DVec3]) {
            z.iter_mut().zip(r).zip(&self.0).for_each(|((z, &r), block)| *z = block.inverse() * r);
        }
    }

    #[test]
    fn an_exact_preconditioner_solves_at_the_first_product() {
        let blocks = Blocks((1..5).map(|row| DMat3::from_diagonal(DVec3::new(1.0, f64::from(row), 100.0))).collect());
        let b: Vec<DVec3> = (0..4).map(|row| DVec3::new(1.0, f64::from(row), -2.0)).collect();
        let mut x = vec![DVec3::NAN; b.len()];
        let solved = ConjugateGradient::default().solve(&blocks, b.iter().copied(), &mut x, 1e-12, &SERIAL);
        assert_eq!(solved, Some(Solved { products: 1, is_accurate: true }));
        assert!(x.iter().zip(&b).zip(&blocks.0).all(|((x, b), block)| (*block * *x - *b).length() < 1e-12), "{x:?}");
    }

    #[test]
    fn an_indefinite_matrix_is_reported_and_zero_needs_no_product() {
        let mut solver = ConjugateGradient::default();
        let mut x = [DVec3::NAN; 1];
        let indefinite = Indefinite;
        assert_eq!(solver.solve(&indefinite, [DVec3::Y].into_iter(), &mut x, 1e-6, &SERIAL), None);
        let solved = solver.solve(&indefinite, [DVec3::ZERO].into_iter(), &mut x, 1e-6, &SERIAL);
        assert_eq!((solved, x[0]), (Some(Solved { products: 0, is_accurate: true }), DVec3::ZERO));
    }

    /// Matrix diag(1, −1, 1) without a preconditioner.
    struct Indefinite;

    impl DefiniteSystem<DVec3> for Indefinite {
        fn multiply(&self, p: &[DVec3], product: &mut [DVec3]) {
            product[0] = DVec3::new(p[0].x, -p[0].y, p[0].z);
        }

        fn precondition(&self, r: &[DVec3], z: &mut [DVec3]) {
            z.copy_from_slice(r);
        }
    }
}
