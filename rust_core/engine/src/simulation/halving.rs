//! Halving of steps that diverge.

use super::Simulation;
use crate::error::{Error, Result};

/// Maximum number of successive halvings of a diverging step. A further divergence ends the run.
const MOST: u32 = 10;

/// The number of successive halvings of a diverging step.
#[derive(Debug, Default)]
pub(super) struct Halvings(u32);

impl Halvings {
    /// Counts a divergence.
    ///
    /// # Errors
    /// The error of the divergence, if the step cannot be halved once more.
    pub fn count(&mut self, error: Error) -> Result<()> {
        self.0 += 1;
        if self.0 > MOST { Err(error) } else { Ok(()) }
    }

    /// Whether this is the first divergence of a step.
    pub fn is_first(&self) -> bool {
        self.0 == 1
    }
}

impl Simulation {
    /// Repeats a step of `h` seconds that diverged, in two halves. If one of the parts diverges, takes the remainder in parts
    /// of half that size. Appends each number of equal parts taken, with their size [s], to `parts`, even on failure.
    ///
    /// # Errors
    /// As [`Simulation::step`]; if the smallest parts diverge.
    pub fn substep(&mut self, h: f64, parts: &mut Vec<(u64, f64)>, interrupted: &dyn Fn() -> bool) -> Result<()> {
        // The step itself was the first divergence.
        let (mut left, mut size, mut halvings) = (1, h, Halvings(1));
        loop {
            (left, size) = (2 * left, 0.5 * size);
            let before = self.steps;
            let outcome = self.step(left, size, interrupted);
            let taken = self.steps - before;
            parts.push((taken, size));
            left -= taken;
            match outcome {
                Err(error @ Error::Diverged(_)) => halvings.count(error)?,
                outcome => return outcome,
            }
        }
    }
}
