//! What can go wrong, typed: every variant carries what a user needs in order to mend it.

use std::sync::Arc;

/// The result of everything in this crate that can fail.
pub type Result<T> = std::result::Result<T, Error>;

/// An error of the engine.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// A parameter of the scene or of the numerics is not acceptable.
    #[error("{path}: expected {expected}, got {found}{}", hint_text(hint))]
    Parameter {
        /// Where the parameter stands, as in `forces[2].stiffness`.
        path: String,
        /// What is acceptable.
        expected: String,
        /// What was there.
        found: String,
        /// What to do about it; empty where that is plain.
        hint: String,
    },
    /// The run left what its numerics can follow; the simulation stands at the last good step.
    #[error(transparent)]
    Diverged(Box<Divergence>),
    /// The caller asked for the run to stop; the simulation stands at a whole step.
    #[error("interrupted")]
    Interrupted,
    /// A function that the user supplied failed; the simulation stands at a whole step.
    #[error("{path}: raised {cause}")]
    Callback {
        /// Which force called it, as in `forces[2].function`.
        path: String,
        /// What it raised.
        cause: Cause,
    },
    /// What was asked for does not fit into memory; the simulation stands at a whole step.
    #[error("{what}: needs {}, {} are available ({hint})", size_text(*needed), size_text(*available))]
    Memory {
        /// What does not fit.
        what: String,
        /// What it takes in all [bytes].
        needed: u64,
        /// What can be had for it [bytes].
        available: u64,
        /// What to do about it.
        hint: String,
    },
    /// A captured state does not belong to this simulation.
    #[error("state: {0}")]
    State(String),
}

/// What a function of the caller's raised, in the caller's own type: the engine passes it on and looks at it no further.
#[derive(Debug, Clone, thiserror::Error)]
#[error(transparent)]
pub struct Cause(pub Arc<dyn std::error::Error + Send + Sync>);

impl PartialEq for Cause {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

fn hint_text(hint: &str) -> String {
    if hint.is_empty() { String::new() } else { format!(" ({hint})") }
}

/// A number of bytes.
fn size_text(bytes: u64) -> String {
    if bytes < 100_000_000 { format!("{:.1} MB", bytes as f64 / 1e6) } else { format!("{:.1} GB", bytes as f64 / 1e9) }
}

impl Error {
    /// A parameter at `path` should have been `expected` but was `found`.
    // Callers write what they have found, often a temporary; a reference would only add noise.
    #[allow(clippy::needless_pass_by_value)]
    pub fn parameter(path: impl Into<String>, expected: impl Into<String>, found: impl std::fmt::Display) -> Self {
        Self::Parameter { path: path.into(), expected: expected.into(), found: found.to_string(), hint: String::new() }
    }

    /// The same error with advice added to it, where it is about a parameter.
    #[must_use]
    pub fn with_hint(mut self, advice: impl Into<String>) -> Self {
        if let Self::Parameter { hint, .. } = &mut self {
            *hint = advice.into();
        }
        self
    }
}

/// Where and how a run diverged.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("step {step} (t = {time:.6e} s): {quantity} of {element} {cause}; {hint}")]
pub struct Divergence {
    /// The step that failed, counted from 1.
    pub step: u64,
    /// The time at the end of that step [s].
    pub time: f64,
    /// The name of the element that shows it most: `particle 3`.
    pub element: String,
    /// Its index in the caller's order.
    pub index: usize,
    /// What is wrong: `position`, `velocity` or `energy`.
    pub quantity: &'static str,
    /// Why it counts as diverged.
    pub cause: String,
    /// What to do.
    pub hint: String,
}
