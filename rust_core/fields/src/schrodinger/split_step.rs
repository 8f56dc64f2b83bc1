//! Split-step method: phases of the potential between phases of the modes.
//!
//! The kinetic energy is a sum over axes, so its phases are a product. Lines along each axis in turn are transformed, multiplied
//! and transformed back while they are in the cache.
//!
//! Sources: order 2, G. Strang, SIAM J. Numer. Anal. 5, 506 (1968); order 4, S. Blanes, P. C. Moan, J. Comput. Appl. Math. 142
//! (2002) 313.
//!
//! The splitting of order 4 holds here as it does for x'' = a(x), because [V, [V, [V, T]]] = 0.

use super::fourier::{Complex, FourierReal, norm, polar, product, square};
use super::hamiltonian::Hamiltonian;
use super::passes::Field;
use crate::integrators::{BlanesMoan4, Splitting};
use crate::math::AXES;
use crate::parallel::{BlockedSlice, Executor};

/// Drifts and kicks of a step, in units of h: a kick before each drift, and one after the last.
#[derive(Debug, Clone, Copy)]
pub struct SplittingCoefficients {
    drifts: &'static [f64],
    kicks: &'static [f64],
}

impl SplittingCoefficients {
    /// Coefficients of order 2 or 4.
    pub fn of(order: u32) -> Self {
        if order == 2 {
            Self { drifts: &[1.0], kicks: &[0.5, 0.5] }
        } else {
            Self { drifts: BlanesMoan4::DRIFTS, kicks: BlanesMoan4::KICKS }
        }
    }

    /// Number of drifts.
    pub fn evaluations(&self) -> usize {
        self.drifts.len()
    }
}

/// Phases of all substeps of a step of `h`.
#[derive(Debug)]
pub struct SplitStep<T> {
    coefficients: SplittingCoefficients,
    h: f64,
    /// Phases of the modes along each axis in each drift, including the factor of the transform.
    modes: Vec<[Vec<Complex<T>>; AXES]>,
    /// Phases of the cells in each kick; None without a potential.
    cells: Vec<Option<Vec<Complex<T>>>>,
}

impl<T: FourierReal> SplitStep<T> {
    /// Returns substeps with these coefficients.
    pub fn new(coefficients: SplittingCoefficients) -> Self {
        Self { coefficients, h: 0.0, modes: Vec::new(), cells: Vec::new() }
    }

    fn prepare(&mut self, hamiltonian: &Hamiltonian<T>, h: f64) {
        if self.h == h {
            return;
        }
        let rate = h / hamiltonian.hbar;
        let along = |axis: usize, part: f64| {
            let share = 1.0 / hamiltonian.spectra[axis].length as f64;
            hamiltonian.mode_energies(axis).iter().map(|energy| polar(share, -part * rate * energy)).collect()
        };
        self.modes = self.coefficients.drifts.iter().map(|&part| std::array::from_fn(|axis| along(axis, part))).collect();
        let free = hamiltonian.interaction != 0.0 || hamiltonian.potential.iter().all(|value| *value == T::ZERO);
        let phases = |part: f64| hamiltonian.potential.iter().map(|value| polar(1.0, -part * rate * value.to_f64())).collect();
        self.cells = self.coefficients.kicks.iter().map(|&part| (!free).then(|| phases(part))).collect();
        self.h = h;
    }

    /// Kick by the interaction, which depends on the density and leaves it unchanged.
    fn kick(hamiltonian: &Hamiltonian<T>, values: &mut [Complex<T>], time: f64, executor: &Executor) {
        if hamiltonian.interaction == 0.0 {
            return;
        }
        let (rate, interaction) = (-time / hamiltonian.hbar, hamiltonian.interaction);
        executor.for_each_block(BlockedSlice::new(values, 4096), &|block: BlockedSlice<'_, Complex<T>>| {
            for (value, potential) in block.items.iter_mut().zip(&hamiltonian.potential[block.start..]) {
                *value = product(*value, polar(1.0, rate * (potential.to_f64() + interaction * square(*value))));
            }
        });
    }

    /// Takes a step of `h`; returns Σ |ψ|² at its end.
    pub fn step(&mut self, hamiltonian: &Hamiltonian<T>, field: &mut Field<'_, T>, h: f64, executor: &Executor) -> f64 {
        self.prepare(hamiltonian, h);
        let SplittingCoefficients { drifts, kicks } = self.coefficients;
        let axes = hamiltonian.padding.outer.axes();
        let mut sum = 0.0;
        for drift in 0..drifts.len() {
            Self::kick(hamiltonian, field.values, kicks[drift] * h, executor);
            for axis in axes.clone() {
                let spectrum = &hamiltonian.spectra[axis];
                let factors = &self.modes[drift][axis];
                let before = if axis == axes.start { self.cells[drift].as_deref() } else { None };
                let last = axis + 1 == axes.end && drift + 1 == drifts.len();
                let after = if last { self.cells[drift + 1].as_deref() } else { None };
                sum = field.pass(axis, [before, after], spectrum.scratch(), executor, &|_, _, line, memory| {
                    spectrum.multiply(line, factors, memory);
                    if last { norm(line) } else { 0.0 }
                });
            }
        }
        Self::kick(hamiltonian, field.values, kicks[drifts.len()] * h, executor);
        sum
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        self.cells.iter().flatten().chain(self.modes.iter().flatten()).map(|column| size_of_val(column.as_slice())).sum()
    }
}
