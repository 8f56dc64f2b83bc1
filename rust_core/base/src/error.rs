//! Errors: every variant carries the facts that a user needs to correct it.

use std::sync::Arc;

/// The result of every fallible function of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// An error of the engine.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// A parameter of the scene or of the numerics is not acceptable.
    #[error("{path}: expected {expected}, got {found}{}", hint_text(hint))]
    Parameter {
        /// The path of the parameter: `forces[2].stiffness`.
        path: String,
        /// The accepted values.
        expected: String,
        /// The value found.
        found: String,
        /// A remedy; empty where it is plain.
        hint: String,
    },
    /// The trajectory diverged; the simulation stands at the last good step.
    #[error(transparent)]
    Diverged(Box<Divergence>),
    /// The run was interrupted; the simulation stands at a whole step.
    #[error("interrupted")]
    Interrupted,
    /// A function that the user supplied failed; the simulation stands at a whole step.
    #[error("{path}: raised {cause}")]
    Callback {
        /// The path of the function: `forces[2].function`.
        path: String,
        /// The error that it raised.
        cause: Cause,
    },
    /// An allocation does not fit into memory; the simulation stands at a whole step.
    #[error("{what}: needs {}, {} are available ({hint})", size_text(*needed), size_text(*available))]
    Memory {
        /// The name of the allocation.
        what: String,
        /// Its size [bytes].
        needed: u64,
        /// The available memory [bytes].
        available: u64,
        /// A remedy; empty where it is plain.
        hint: String,
    },
    /// A captured state does not belong to this simulation.
    #[error("state: {0}")]
    State(String),
}

/// The error of a user-defined function, in the caller's own type, passed on unchanged.
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

/// A size in bytes as text.
fn size_text(bytes: u64) -> String {
    if bytes < 100_000_000 { format!("{:.1} MB", bytes as f64 / 1e6) } else { format!("{:.1} GB", bytes as f64 / 1e9) }
}

impl Error {
    /// A parameter at `path` should have been `expected` but was `found`.
    // Callers pass the found value, often a temporary; a reference would only add noise.
    #[allow(clippy::needless_pass_by_value)]
    pub fn parameter(path: impl Into<String>, expected: impl Into<String>, found: impl std::fmt::Display) -> Self {
        Self::Parameter { path: path.into(), expected: expected.into(), found: found.to_string(), hint: String::new() }
    }

    /// A step has no solution for a particle, by its index in the caller's order; the monitor adds step, time and hint.
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

    /// The same error with a hint, where it is about a parameter.
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
    /// The name of the most affected element: `particle 3`.
    pub element: String,
    /// Its index in the caller's order.
    pub index: usize,
    /// The diverged quantity: `position`, `velocity` or `energy`.
    pub quantity: &'static str,
    /// The criterion that it violates.
    pub cause: String,
    /// A remedy.
    pub hint: String,
}
