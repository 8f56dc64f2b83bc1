//! Halving of steps that diverge.

use super::Simulation;
use crate::error::{Error, Result};

/// The most successive halvings of a diverging step, after which it counts as divergence.
const MOST: u32 = 10;

/// The number of successive halvings of a diverging step.
#[derive(Debug, Default)]
pub(super) struct Halvings(u32);

impl Halvings {
    /// Counts a divergence.
    ///
    /// # Errors
    /// Its error, if the step cannot be halved once more.
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
    /// Takes a step of `h` seconds that diverged in two halves, and whenever one of its parts diverges what is left of it in
    /// parts of half that size. Each number of equal parts that were taken, with their size [s], goes to `parts`, also where
    /// this fails.
    ///
    /// # Errors
    /// As [`Simulation::step`]; if the smallest parts diverge.
    pub fn substep(&mut self, h: f64, parts: &mut Vec<(u64, f64)>, interrupted: &dyn Fn() -> bool) -> Result<()> {
        // The step itself was the first to diverge.
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
