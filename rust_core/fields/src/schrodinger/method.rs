//! Time-stepping methods for wave functions, and their limits.

use super::fourier::{Complex, FourierReal, norm};
use super::hamiltonian::Hamiltonian;
use super::passes::Field;
use super::split_step::{SplitStep, SplittingCoefficients};
use super::{crank_nicolson, staggered};
use crate::error::{Error, Result};
use crate::parallel::{Executor, SERIAL};
use crate::scene::Item;
use crate::stability::{Limit, LimitKind};

/// Names of the methods, as of their classes in Python.
pub const NAMES: [&str; 3] = ["SplitStep", "CrankNicolson", "Staggered"];

/// Time-stepping method.
#[derive(Debug)]
pub enum SchrodingerMethod<T> {
    SplitStep { order: u32, steps: SplitStep<T> },
    CrankNicolson,
    Staggered,
}

impl<T: FourierReal> SchrodingerMethod<T> {
    /// Reads the method that an item declares.
    ///
    /// # Errors
    /// If the method is none for wave functions, or not applicable to this one.
    pub fn declared(item: &Item, hamiltonian: &Hamiltonian<T>) -> Result<Self> {
        let [split_step, crank_nicolson, staggered] = NAMES;
        match item.kind.as_str() {
            name if name == split_step => {
                let order = match item.number("order")? {
                    2.0 => 2,
                    4.0 => 4,
                    _ => return Err(item.wrong("order", "2 or 4", item.values.get("order"))),
                };
                Ok(Self::SplitStep { order, steps: SplitStep::new(SplittingCoefficients::of(order)) })
            }
            name if name == crank_nicolson => Ok(Self::CrankNicolson),
            name if name == staggered && hamiltonian.interaction != 0.0 => {
                Err(Error::parameter("integrator", "SplitStep or CrankNicolson beside an interaction", &item.kind))
            }
            name if name == staggered => Ok(Self::Staggered),
            other => Err(Error::parameter("integrator", "SplitStep, CrankNicolson or Staggered for a wave function", other)),
        }
    }

    /// Whether the kinetic energy is that of the modes, not of differences.
    pub fn is_spectral(&self) -> bool {
        matches!(self, Self::SplitStep { .. })
    }

    /// Name of the class in Python.
    pub fn name(&self) -> &'static str {
        NAMES[match self {
            Self::SplitStep { .. } => 0,
            Self::CrankNicolson => 1,
            Self::Staggered => 2,
        }]
    }

    /// Order of convergence.
    pub fn order(&self) -> u32 {
        if let Self::SplitStep { order, .. } = self { *order } else { 2 }
    }

    /// Number of evaluations of the kinetic energy per step.
    pub fn evaluations(&self, hamiltonian: &Hamiltonian<T>) -> usize {
        match self {
            Self::SplitStep { order, .. } => SplittingCoefficients::of(*order).evaluations(),
            Self::CrankNicolson => 1 + usize::from(hamiltonian.interaction != 0.0),
            Self::Staggered => 3,
        }
    }

    /// Takes a step of `h`; returns Σ |ψ|² at its end.
    pub fn step(&mut self, hamiltonian: &Hamiltonian<T>, field: &mut Field<'_, T>, h: f64, executor: &Executor) -> f64 {
        match self {
            Self::SplitStep { steps, .. } => return steps.step(hamiltonian, field, h, executor),
            Self::CrankNicolson => crank_nicolson::step(hamiltonian, field, h, executor),
            Self::Staggered => staggered::step(hamiltonian, field.values, h, executor),
        }
        norm(field.values)
    }

    /// Limit of the time step, from an initial state. Split steps resonate if the phase of a mode makes a full turn in a step.
    /// Crank–Nicolson steps have an accurate phase while that of H is small. Visscher's steps oscillate while |E| dt < 2ħ.
    pub fn limit(&self, hamiltonian: &Hamiltonian<T>, values: &[Complex<T>]) -> Limit {
        let potential = || hamiltonian.potential.iter().map(|value| value.to_f64());
        let (least, most) = potential().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        let accuracy = |accuracy: f64, term| Limit { accuracy, term, kind: LimitKind::Accuracy, ..Limit::NONE };
        match self {
            Self::SplitStep { .. } if least == most && hamiltonian.interaction == 0.0 => Limit::NONE,
            Self::SplitStep { .. } => {
                accuracy(2.0 * std::f64::consts::PI * hamiltonian.hbar / hamiltonian.largest_mode(), "resonance")
            }
            Self::CrankNicolson => {
                let size = mean_square(hamiltonian, values).sqrt();
                if size > 0.0 { accuracy(hamiltonian.hbar / size, "oscillation") } else { Limit::NONE }
            }
            Self::Staggered => {
                let largest = 4.0 * hamiltonian.hopping * hamiltonian.padding.outer.dimension as f64;
                let stability = 2.0 * hamiltonian.hbar / (largest + most.max(0.0)).max(-least);
                Limit { stability, certified: stability, term: "oscillation", kind: LimitKind::Stability, ..Limit::NONE }
            }
        }
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        if let Self::SplitStep { steps, .. } = self { steps.bytes() } else { 0 }
    }
}

/// Mean square ⟨H²⟩ without interaction [J²].
fn mean_square<T: FourierReal>(hamiltonian: &Hamiltonian<T>, values: &[Complex<T>]) -> f64 {
    let mut sum = 0.0;
    for part in [|value: &Complex<T>| value.re, |value: &Complex<T>| value.im] {
        let own: Vec<T> = values.iter().map(part).collect();
        let mut applied = vec![T::ZERO; own.len()];
        hamiltonian.apply(&own, &mut applied, 1.0, &SERIAL);
        sum += applied.iter().map(|value| value.to_f64().powi(2)).sum::<f64>();
    }
    sum / norm(values)
}
