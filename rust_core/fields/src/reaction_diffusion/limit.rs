//! Rates from user-defined functions, and the limit of the time step.
//!
//! Diffusion limits the step by the largest eigenvalue λ of −D ∇², which is known exactly. The rates ρ of the reaction are added
//! to it. They bound the eigenvalues of the Jacobian J of R in the present state, over all cells. An explicit method is then
//! stable on the real axis up to the step h at which h (λ + ρ) is its stable interval. An accurate step resolves the reaction, whose
//! fast rates, unlike those of diffusion, carry the solution.

use super::ReactionDiffusion;
use super::cell_kinetics::RowKinetics;
use super::kinetics::{RateLaw, with_law};
use crate::error::Result;
use crate::math::Real;
use crate::parallel::{BlockedSlice, Executor};
use crate::simd::{Isa, Kernel, dispatch};
use crate::stability::{Limit, LimitKind};

/// Step times the largest rate of the reaction at the limit of accuracy. At half of that the error of a step of order 4 is
/// below 0.5⁵/5! = 3e-4 of the change.
const RESOLVED: f64 = 1.0;

/// Difference for numerical derivatives of a user-defined function, as a fraction of the largest value of a species.
const DIFFERENCE: f64 = 1e-6;

/// Largest ρ of the cells of a row. The norms ‖J‖₁ and ‖J‖∞ bound eigenvalues; the smaller one is used.
struct Fastest<'a, T, L> {
    kinetics: RowKinetics<'a, T, L>,
    values: [&'a [T]; 2],
}

impl<T: Real, L: RateLaw<T>> Kernel for Fastest<'_, T, L> {
    type Output = f64;

    #[inline(always)]
    fn run<S: Isa>(self, _isa: S) -> f64 {
        let size = |value: T| if value < T::ZERO { -value } else { value };
        let larger = |one: T, other: T| if other > one { other } else { one };
        let mut most = T::ZERO;
        for (cell, (&u, &v)) in self.values[0].iter().zip(self.values[1]).enumerate() {
            let [a, b, c, d] = self.kinetics.at(cell).derivatives([u, v]).map(size);
            let (rows, columns) = (larger(a + b, c + d), larger(a + c, b + d));
            most = larger(most, if columns < rows { columns } else { rows });
        }
        most.to_f64()
    }
}

impl<T: Real> ReactionDiffusion<T> {
    /// Evaluates a user-defined function: rates of all species, in the layout of the field; None for built-in kinetics.
    pub(super) fn given(&self, field: &[T]) -> Result<Option<Vec<T>>> {
        with_law!(&self.law.kinetics, _law => Ok(None), function => {
            let rates = function.rates(&self.apart(field), &self.law.grid.shape())?;
            let (rows, length, species) = (self.law.grid.rows(), self.law.grid.row_length(), self.law.species.len());
            let at = |index: usize| {
                let (row, rest) = (index / (species * length), index % (species * length));
                T::from_f64(rates[((rest / length) * rows + row) * length + rest % length])
            };
            Ok(Some((0..field.len()).map(at).collect()))
        })
    }

    /// Values of all species, the cells of one species after those of another.
    fn apart(&self, field: &[T]) -> Vec<f64> {
        (0..self.law.species.len()).flat_map(|species| self.species_rows(species, field)).map(|value| value.to_f64()).collect()
    }

    /// Limit of the time step.
    pub(super) fn bound(&self, executor: &Executor) -> Result<Limit> {
        let (reaction, (diffusion, _)) = (self.reaction(executor)?, self.fastest);
        let step = self.method.limit(diffusion, reaction);
        let accuracy = if reaction > 0.0 { RESOLVED / reaction } else { f64::INFINITY };
        if step.min(accuracy).is_infinite() {
            return Ok(Limit::NONE);
        }
        let kind = if accuracy < step { LimitKind::Accuracy } else { LimitKind::Stability };
        let diffuses = reaction == 0.0 || self.method.limit(diffusion, 0.0) < self.method.limit(0.0, reaction);
        let term = if kind == LimitKind::Stability && diffuses { self.term } else { "reaction" };
        // The fastest mode decays at least at the rate λ − ρ.
        let known = !self.method.is_stabilized() && diffusion > reaction;
        let endured = if known { self.method.limit(diffusion - reaction, 0.0) } else { f64::INFINITY };
        Ok(Limit { stability: step, accuracy, term, kind, certified: step, endured })
    }

    /// Largest rate ρ of the reaction in the present state [1/s].
    fn reaction(&self, executor: &Executor) -> Result<f64> {
        with_law!(
            &self.law.kinetics,
            law => {
                let mut rates = vec![0.0; self.law.grid.rows()];
                executor.for_each_block(BlockedSlice::new(&mut rates, 16), &|block: BlockedSlice<'_, f64>| {
                    for (index, rate) in block.items.iter_mut().enumerate() {
                        let row = block.start + index;
                        let values = [0, 1].map(|species| self.species_row(species, row, &self.state.field));
                        *rate = dispatch(Fastest { kinetics: law.row(row), values });
                    }
                });
                executor.check()?;
                Ok(rates.into_iter().fold(0.0, f64::max))
            },
            function => {
                let (values, shape, count) = (self.apart(&self.state.field), self.law.grid.shape(), self.law.grid.count());
                let here = function.rates(&values, &shape)?;
                let species = self.law.species.len();
                // Sums of columns and of rows of |J|, cell by cell.
                let (mut columns, mut rows) = (vec![0.0; values.len()], vec![0.0; values.len()]);
                for other in 0..species {
                    let own = other * count..(other + 1) * count;
                    let largest = values[own.clone()].iter().fold(0.0_f64, |most, value| most.max(value.abs()));
                    let step = DIFFERENCE * if largest > 0.0 { largest } else { 1.0 };
                    let mut moved = values.clone();
                    moved[own].iter_mut().for_each(|value| *value += step);
                    let there = function.rates(&moved, &shape)?;
                    for index in 0..values.len() {
                        let derivative = ((there[index] - here[index]) / step).abs();
                        rows[index] += derivative;
                        columns[other * count + index % count] += derivative;
                    }
                    executor.check()?;
                }
                let most = |sums: &[f64], cell: usize| (0..species).map(|s| sums[s * count + cell]).fold(0.0, f64::max);
                Ok((0..count).map(|cell| most(&rows, cell).min(most(&columns, cell))).fold(0.0, f64::max))
            }
        )
    }
}
