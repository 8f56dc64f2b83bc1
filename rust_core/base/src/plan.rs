//! The plan: the stages of a step and their figures, for people to read.

/// The plan of a simulation.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The number of threads.
    pub threads: usize,
    /// The level of vector instructions.
    pub simd: &'static str,
    /// Present memory [bytes].
    pub memory: usize,
    /// One part for each system.
    pub stages: Vec<Stages>,
}

/// The stages of a system's step: exactly those that its scene requires.
#[derive(Debug, Clone)]
pub struct Stages {
    /// The name of the item that the system belongs to; empty for matter.
    pub item: String,
    /// The names of the stages, in order.
    pub names: Vec<String>,
    /// The number of dimensions of space.
    pub dimension: usize,
    /// `f32` or `f64`.
    pub precision: &'static str,
    /// The name of its method.
    pub method: &'static str,
    /// The order of convergence that holds in this scene.
    pub order: u32,
    /// Evaluations of the rates per step.
    pub evaluations: usize,
    /// Approximate number of springs and neighbor pairs per evaluation.
    pub pairs: usize,
    /// The relative rms error of forces at a distance in the state at the start; 0 where they are exact.
    pub force_error: f64,
    /// Whether the limit of the time step changes with the state, so that it has to be monitored.
    pub limit_varies: bool,
    /// The memory layout of its data.
    pub layout: String,
    /// Features that this scene does not need and that cost nothing.
    pub left_out: Vec<&'static str>,
    /// Notes for the user.
    pub notes: Vec<String>,
}
