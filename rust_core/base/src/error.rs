//! Errors. Every variant carries the facts that a user needs to correct it.

use std::sync::Arc;

/// Result of a fallible function of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// Error of the engine.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// Invalid parameter of the scene or of the numerics.
    #[error("{path}: expected {expected}, got {found}{}", hint_text(hint))]
    Parameter {
        /// Path of the parameter: `forces[2].stiffness`.
        path: String,
        /// Accepted values.
        expected: String,
        /// Value found.
        found: String,
        /// Remedy; empty if obvious.
        hint: String,
    },
    /// A user-defined function returned a number that is not finite. In a step this counts as a divergence.
    #[error("{path}: expected {expected}, got {found}")]
    Undefined {
        /// Path of the function: `forces[2].function`.
        path: String,
        /// Accepted values.
        expected: String,
        /// Value found.
        found: String,
    },
    /// The trajectory diverged. The simulation is restored to the last good step.
    #[error(transparent)]
    Diverged(Box<Divergence>),
    /// The run was interrupted. The simulation is left after a whole step.
    #[error("interrupted")]
    Interrupted,
    /// A user-defined function failed. The simulation is left after a whole step.
    #[error("{path}: raised {cause}")]
    Callback {
        /// Path of the function: `forces[2].function`.
        path: String,
        /// Error raised by the function.
        cause: Cause,
    },
    /// An allocation does not fit into memory. The simulation is left after a whole step.
    #[error("{what}: needs {}, {} are available ({hint})", size_text(*needed), size_text(*available))]
    Memory {
        /// Name of the allocation.
        what: String,
        /// Size of the allocation [bytes].
        needed: u64,
        /// Available memory [bytes].
        available: u64,
        /// Remedy; empty if obvious.
        hint: String,
    },
    /// A captured state does not belong to this simulation.
    #[error("state: {0}")]
    State(String),
}

/// Error of a user-defined function, in the caller's own type, passed on unchanged.
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

/// Formats a size in bytes.
fn size_text(bytes: u64) -> String {
    if bytes < 100_000_000 { format!("{:.1} MB", bytes as f64 / 1e6) } else { format!("{:.1} GB", bytes as f64 / 1e9) }
}

impl Error {
    /// Error for a parameter at `path` whose value `found` is not `expected`.
    // Callers pass the found value, often a temporary; a reference would only add noise.
    #[allow(clippy::needless_pass_by_value)]
    pub fn parameter(path: impl Into<String>, expected: impl Into<String>, found: impl std::fmt::Display) -> Self {
        Self::Parameter { path: path.into(), expected: expected.into(), found: found.to_string(), hint: String::new() }
    }

    /// Error for a user-defined function at `path` whose value `found` is not finite.
    pub fn undefined(path: impl Into<String>, expected: impl Into<String>, found: impl Into<String>) -> Self {
        Self::Undefined { path: path.into(), expected: expected.into(), found: found.into() }
    }

    /// Returns the error that a step has no solution for the particle `index`, in the caller's order. The monitor adds step, time
    /// and hint.
    pub fn unsolved(index: usize, cause: impl Into<String>) -> Self {
        Self::Diverged(Box::new(Divergence {
            step: 0,
            time: 0.0,
            element: format!("particle {index}"),
            index,
            quantity: "position",
            cause: cause.into(),
            hint: String::new(),
        }))
    }

    /// Adds a hint to an error about a parameter; other errors are unchanged.
    #[must_use]
    pub fn with_hint(mut self, advice: impl Into<String>) -> Self {
        if let Self::Parameter { hint, .. } = &mut self {
            *hint = advice.into();
        }
        self
    }
}

/// Location and cause of a divergence.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("step {step} (t = {time:.6e} s): {quantity} of {element} {cause}; {hint}")]
pub struct Divergence {
    /// Number of the failed step, counted from 1.
    pub step: u64,
    /// Time at the end of the failed step [s].
    pub time: f64,
    /// Name of the most affected element: `particle 3`.
    pub element: String,
    /// Index of the element in the caller's order.
    pub index: usize,
    /// Diverged quantity: `position`, `velocity` or `energy`.
    pub quantity: &'static str,
    /// Violated criterion.
    pub cause: String,
    /// Remedy.
    pub hint: String,
}
