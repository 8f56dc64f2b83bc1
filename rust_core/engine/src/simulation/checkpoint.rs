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
    /// The state, the history and the tallies of the system.
    pub system: Archive,
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
            system: self.archive(),
            monitor: self.monitor.capture(),
            adaptation: self.adaptation,
        }
    }

    /// Restores a checkpoint.
    ///
    /// # Errors
    /// If it belongs to another scene or to other numerics.
    pub fn restore(&mut self, checkpoint: &Checkpoint) -> Result<()> {
        let mut archive = checkpoint.system.clone();
        self.system.restore(&mut archive)?;
        archive.finish()?;
        (self.segment, self.steps) = (checkpoint.segment, checkpoint.steps);
        self.monitor.restore(checkpoint.monitor);
        self.adaptation = checkpoint.adaptation;
        self.hints = self.system.hints();
        self.moved = true;
        Ok(())
    }

    /// A hash of the state, the history of the system, and the clock.
    pub fn state_hash(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        let archive = self.archive();
        for number in archive.state().chain([&self.segment.start, &self.segment.dt]).chain(&self.adaptation.control) {
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
