//! Plan of a simulation: stages of a step and their figures, for people to read.

/// Plan of a simulation.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Number of threads.
    pub threads: usize,
    /// Level of vector instructions.
    pub simd: &'static str,
    /// Memory in use [bytes].
    pub memory: usize,
    /// Stages of each system.
    pub stages: Vec<Stages>,
}

/// Stages of a system's step: exactly those that its scene requires.
#[derive(Debug, Clone)]
pub struct Stages {
    /// Name of the item to which the system belongs; empty for matter.
    pub item: String,
    /// Names of the stages, in order.
    pub names: Vec<String>,
    /// Number of dimensions of space.
    pub dimension: usize,
    /// `f32` or `f64`.
    pub precision: &'static str,
    /// Name of the integration method.
    pub method: &'static str,
    /// Order of convergence that holds in this scene.
    pub order: u32,
    /// Number of evaluations of the rates per step.
    pub evaluations: usize,
    /// Approximate number of springs and neighbor pairs per evaluation.
    pub pairs: usize,
    /// Relative rms error of long-range forces in the initial state; 0 if they are exact.
    pub force_error: f64,
    /// Whether the limit of the time step changes with the state and must be monitored.
    pub limit_varies: bool,
    /// Memory layout of the data.
    pub layout: String,
    /// Features that this scene does not need and that cost nothing.
    pub left_out: Vec<&'static str>,
    /// Notes for the user.
    pub notes: Vec<String>,
}
