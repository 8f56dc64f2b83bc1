//! The plan: the stages of a step and their figures, for people to read.

/// What a simulation does in every step.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The number of threads that it uses.
    pub threads: usize,
    /// The level of vector instructions.
    pub simd: &'static str,
    /// The memory that it takes now [bytes].
    pub memory: usize,
    /// One part for each system.
    pub stages: Vec<Stages>,
}

/// What a system does in every step: exactly the stages that its scene requires.
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
    /// Evaluations of its rates per step.
    pub evaluations: usize,
    /// About how many springs and pairs of neighbors an evaluation goes through.
    pub pairs: usize,
    /// Whether the limit of the time step changes with the state, so that it has to be watched.
    pub limit_varies: bool,
    /// The layout of its work in memory.
    pub layout: String,
    /// What this scene does not need and does not pay for.
    pub left_out: Vec<&'static str>,
    /// What the user may want to know.
    pub notes: Vec<String>,
}
