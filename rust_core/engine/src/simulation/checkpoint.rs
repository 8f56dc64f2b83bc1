//! Checkpoints: all data that the bits of later steps depend on, besides the scene and the numerics.

use super::{Adaptation, Segment, Simulation};
use crate::error::Result;
use crate::history::Archive;

/// A checkpoint.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Checkpoint {
    /// The clock's present segment.
    pub segment: Segment,
    /// Number of steps taken so far.
    pub steps: u64,
    /// The state and the history of the system.
    pub system: Vec<f64>,
    /// The energy tallies, part by part.
    pub tallies: Vec<f64>,
    /// The state of the divergence monitor.
    pub monitor: [f64; 6],
    /// The state of the step-size control.
    pub adaptation: Adaptation,
}

impl Simulation {
    /// Captures the present state.
    pub fn capture(&self) -> Checkpoint {
        Checkpoint {
            segment: self.segment,
            steps: self.steps,
            system: self.archive().into_numbers(),
            tallies: self.system.tallies(),
            monitor: self.monitor.capture(),
            adaptation: self.adaptation,
        }
    }

    /// Restores a checkpoint.
    ///
    /// # Errors
    /// If it belongs to another scene or to other numerics.
    pub fn restore(&mut self, checkpoint: &Checkpoint) -> Result<()> {
        let mut archive = Archive::new(checkpoint.system.clone());
        self.system.restore(&mut archive)?;
        archive.finish()?;
        self.system.restore_tallies(&checkpoint.tallies)?;
        (self.segment, self.steps) = (checkpoint.segment, checkpoint.steps);
        self.monitor.restore(checkpoint.monitor);
        self.adaptation = checkpoint.adaptation;
        Ok(())
    }

    /// A hash of the state, the history of the system, and the clock.
    pub fn state_hash(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        let numbers = self.archive().into_numbers();
        for number in numbers.iter().chain([&self.segment.start, &self.segment.dt]).chain(&self.adaptation.control) {
            hasher.update(&number.to_le_bytes());
        }
        hasher.update(&self.segment.steps.to_le_bytes());
        hasher.update(&self.steps.to_le_bytes());
        hasher.finalize().to_hex()[..32].to_owned()
    }

    fn archive(&self) -> Archive {
        let mut archive = Archive::default();
        self.system.capture(&mut archive);
        archive
    }
}
