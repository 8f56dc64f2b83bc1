//! Crank–Nicolson method: (1 + iτH/2ħ) ψ' = (1 − iτH/2ħ) ψ, with three-point differences.
//!
//! Along several axes H = Σ Hₐ, where V is shared equally. A step is a product of Cayley forms: half steps along all axes but the
//! first, around a whole step along the first. The method is unitary and of order 2. With an interaction, the step is repeated
//! with the mean density of its start and its predicted end.
//!
//! Source: J. Crank, P. Nicolson, Proc. Camb. Phil. Soc. 43, 50 (1947); A. Goldberg, H. M. Schey, J. L. Schwartz, Am. J. Phys.
//! 35, 177 (1967).

use super::fourier::{Complex, FourierReal, product, square};
use super::hamiltonian::Hamiltonian;
use super::passes::Field;
use crate::grid::Edge;
use crate::math::Real;
use crate::parallel::Executor;

/// Inverse 1/z.
#[inline(always)]
fn inverse<T: Real>(number: Complex<T>) -> Complex<T> {
    let size = number.re * number.re + number.im * number.im;
    Complex { re: number.re / size, im: -number.im / size }
}

#[inline(always)]
fn minus<T: Real>(one: Complex<T>, other: Complex<T>) -> Complex<T> {
    Complex { re: one.re - other.re, im: one.im - other.im }
}

/// Linear system of a line: tridiagonal, with a diagonal of 1 plus imaginary numbers, and a constant imaginary number beside it.
struct TridiagonalSystem<T> {
    /// Coefficient τ/2ħ times the hopping.
    hopping: T,
    /// Contributions of the boundary conditions at the ends of the line to the diagonal 2.
    ends: [T; 2],
    periodic: bool,
}

impl<T: Real> TridiagonalSystem<T> {
    fn new(cells: usize, ends: [Edge; 2], hopping: f64) -> Self {
        let own = |end: Edge| {
            T::from_f64(f64::from(match end {
                Edge::Fixed | Edge::Absorbing => 1,
                Edge::Free => -1,
                Edge::Periodic => 0_i8,
            }))
        };
        Self { hopping: T::from_f64(hopping), ends: ends.map(own), periodic: ends[0] == Edge::Periodic && cells > 2 }
    }

    /// Adds to ψ the solution of (1 + iA) δ = −2iAψ, where A has the diagonal `hopping` · 2 + `diagonal`. The increment is small,
    /// and so is its rounding error.
    fn advance(&self, line: &mut [Complex<T>], memory: &mut [Complex<T>], diagonal: impl Fn(usize) -> T) {
        let count = line.len();
        let (ratios, rest) = memory.split_at_mut(count);
        let (solution, around) = rest.split_at_mut(count);
        let two = T::ONE + T::ONE;
        let blank = Complex { re: T::ZERO, im: T::ZERO };
        // On a ring of two cells, each is the neighbor of the other on both sides; on a ring of one cell, nothing hops.
        let ring = self.ends == [T::ZERO; 2] && !self.periodic;
        let weight = if ring && count == 2 { two } else { T::ONE };
        let beside = Complex { re: T::ZERO, im: -(weight * self.hopping) };
        let links = |cell: usize| {
            let inner = if ring && count == 1 { T::ZERO } else { two };
            let lower = if cell == 0 { self.ends[0] } else { T::ZERO };
            inner + lower + if cell + 1 == count { self.ends[1] } else { T::ZERO }
        };
        let own = |cell: usize| Complex { re: T::ONE, im: self.hopping * links(cell) + diagonal(cell) };
        // Evaluates −2iAψ by differences, which lose no accuracy where ψ is smooth.
        let right = |cell: usize| {
            let (here, mut rest, mut bend) = (line[cell], links(cell), blank);
            let lower = if cell > 0 { Some(cell - 1) } else { self.periodic.then_some(count - 1) };
            let upper = if cell + 1 < count { Some(cell + 1) } else { self.periodic.then_some(0) };
            for neighbor in [lower, upper].into_iter().flatten() {
                let away = minus(here, line[neighbor]);
                (bend.re, bend.im, rest) = (bend.re + weight * away.re, bend.im + weight * away.im, rest - weight);
            }
            let (hopping, factor) = (two * self.hopping, two * (self.hopping * rest + diagonal(cell)));
            Complex { re: hopping * bend.im + factor * here.im, im: -(hopping * bend.re + factor * here.re) }
        };
        // The corners of a ring are removed: A = A' + u vᵀ with u = (γ, 0 …, b), v = (1, 0 …, b/γ) (Sherman–Morrison).
        let gamma = Complex { re: -own(0).re, im: -own(0).im };
        let corner = product(beside, product(beside, inverse(gamma)));
        let own = |cell: usize| match cell {
            0 if self.periodic => minus(own(0), gamma),
            cell if self.periodic && cell + 1 == count => minus(own(cell), corner),
            cell => own(cell),
        };
        let mut last = blank;
        for cell in 0..count {
            let pivot = inverse(minus(own(cell), product(beside, last)));
            last = product(beside, pivot);
            ratios[cell] = last;
            let before = if cell == 0 { blank } else { solution[cell - 1] };
            solution[cell] = product(pivot, minus(right(cell), product(beside, before)));
            if self.periodic {
                let unit = if cell == 0 {
                    gamma
                } else if cell + 1 == count {
                    beside
                } else {
                    blank
                };
                let before = if cell == 0 { blank } else { around[cell - 1] };
                around[cell] = product(pivot, minus(unit, product(beside, before)));
            }
        }
        for cell in (0..count - 1).rev() {
            solution[cell] = minus(solution[cell], product(ratios[cell], solution[cell + 1]));
            if self.periodic {
                around[cell] = minus(around[cell], product(ratios[cell], around[cell + 1]));
            }
        }
        let share = if self.periodic {
            let tip = product(beside, inverse(gamma));
            let along = |of: &[Complex<T>]| {
                let end = product(tip, of[count - 1]);
                Complex { re: of[0].re + end.re, im: of[0].im + end.im }
            };
            let (of_solution, of_around) = (along(solution), along(around));
            product(of_solution, inverse(Complex { re: T::ONE + of_around.re, im: of_around.im }))
        } else {
            blank
        };
        for cell in 0..count {
            let lost = if self.periodic { product(share, around[cell]) } else { blank };
            let value = minus(solution[cell], lost);
            line[cell] = Complex { re: line[cell].re + value.re, im: line[cell].im + value.im };
        }
    }
}

/// Takes a step with a given potential.
fn cayley<T: FourierReal>(hamiltonian: &Hamiltonian<T>, field: &mut Field<'_, T>, potential: &[T], h: f64, executor: &Executor) {
    let grid = &hamiltonian.padding.outer;
    let (first, last) = (grid.axes().start, grid.axes().end);
    let order = (first + 1..last).rev().chain([first]).chain(first + 1..last);
    for axis in order {
        let part = if axis == first { 0.5 } else { 0.25 } * h / hamiltonian.hbar;
        let line = TridiagonalSystem::new(grid.cells[axis], hamiltonian.ends(axis), part * hamiltonian.hopping);
        let share = T::from_f64(part / grid.dimension as f64);
        field.pass(axis, [None, None], 3 * grid.cells[axis], executor, &|place, index, values, memory| {
            let start = place.start(index);
            line.advance(values, memory, |cell| share * potential[start + cell * place.stride]);
            0.0
        });
    }
}

/// Takes a step of `h`.
pub fn step<T: FourierReal>(hamiltonian: &Hamiltonian<T>, field: &mut Field<'_, T>, h: f64, executor: &Executor) {
    if hamiltonian.interaction == 0.0 {
        return cayley(hamiltonian, field, &hamiltonian.potential, h, executor);
    }
    let with = |density: &dyn Fn(usize) -> f64| -> Vec<T> {
        let of = |(cell, potential): (usize, &T)| *potential + T::from_f64(hamiltonian.interaction * density(cell));
        hamiltonian.potential.iter().enumerate().map(of).collect()
    };
    let start = field.values.clone();
    cayley(hamiltonian, field, &with(&|cell| square(start[cell])), h, executor);
    let mean = with(&|cell| 0.5 * (square(start[cell]) + square(field.values[cell])));
    field.values.copy_from_slice(&start);
    cayley(hamiltonian, field, &mean, h, executor);
}
