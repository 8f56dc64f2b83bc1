//! Visscher's staggered method, R' = H I/ħ, I' = −H R/ħ: the imaginary part is known at the middle of steps, the real part at
//! their ends.
//!
//! A state has both parts at its time, so a step begins and ends with half a step of the imaginary part.
//!
//! Source: P. B. Visscher, Computers in Physics 5, 596 (1991).

use super::fourier::{Complex, FourierReal};
use super::hamiltonian::Hamiltonian;
use crate::parallel::Executor;

/// Takes a step of `h`.
pub fn step<T: FourierReal>(hamiltonian: &Hamiltonian<T>, values: &mut [Complex<T>], h: f64, executor: &Executor) {
    let mut real: Vec<T> = values.iter().map(|value| value.re).collect();
    let mut imaginary: Vec<T> = values.iter().map(|value| value.im).collect();
    let rate = h / hamiltonian.hbar;
    hamiltonian.apply(&real, &mut imaginary, -0.5 * rate, executor);
    hamiltonian.apply(&imaginary, &mut real, rate, executor);
    hamiltonian.apply(&real, &mut imaginary, -0.5 * rate, executor);
    for ((value, re), im) in values.iter_mut().zip(real).zip(imaginary) {
        *value = Complex { re, im };
    }
}
