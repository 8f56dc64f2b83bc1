//! Integrators as values: everything that code other than kernels needs, so only kernels are compiled for each integrator.

use super::{Component, DriftKick, Integrator, refuses_fields, with_integrator};

/// Constants and functions of an [`Integrator`], under their names there.
#[derive(Debug, Clone, Copy)]
pub struct Facts {
    /// [`Integrator::NAME`].
    pub name: &'static str,
    /// [`Integrator::ORDER`].
    pub order: u32,
    /// [`Integrator::ORDER_DISSIPATIVE`].
    pub order_dissipative: u32,
    /// [`Integrator::NODES`].
    pub nodes: &'static [f64],
    /// [`Integrator::WEIGHTS`].
    pub weights: &'static [f64],
    /// [`Integrator::LAST_WEIGHT`].
    pub last_weight: f64,
    /// [`Integrator::CORRECTED_WEIGHT`].
    pub corrected_weight: f64,
    /// [`Integrator::REGISTERS`].
    pub registers: usize,
    /// [`Integrator::PERSISTENT`].
    pub persistent: usize,
    /// [`Integrator::READABLE`].
    pub readable: usize,
    /// [`Integrator::ENDS_WITH_FORCES`].
    pub ends_with_forces: bool,
    /// [`Integrator::DRIFTS_FIRST`].
    pub drifts_first: bool,
    /// [`Integrator::DRIFT_KICK`].
    pub drift_kick: Option<DriftKick>,
    /// [`Integrator::GYRATES`].
    pub gyrates: bool,
    /// [`Integrator::ERROR`].
    pub error: Option<[usize; 2]>,
    /// [`Integrator::COUPLED`].
    pub coupled: f64,
    /// [`Integrator::limit`].
    pub limit: fn(f64) -> f64,
    /// [`Integrator::last`].
    pub last: fn(f64) -> f64,
    /// [`Integrator::oscillator`].
    pub oscillator: fn(f64, f64, f64) -> [f64; 2],
    /// [`Integrator::stage_state`] for f64.
    pub stage_state: fn(usize, &mut Component<f64>, f64),
    /// [`refuses_fields`].
    pub refuses_fields: Option<&'static str>,
}

impl Facts {
    /// Facts of an integrator.
    pub fn of<I: Integrator>() -> Self {
        Self {
            name: I::NAME,
            order: I::ORDER,
            order_dissipative: I::ORDER_DISSIPATIVE,
            nodes: I::NODES,
            weights: I::WEIGHTS,
            last_weight: I::LAST_WEIGHT,
            corrected_weight: I::CORRECTED_WEIGHT,
            registers: I::REGISTERS,
            persistent: I::PERSISTENT,
            readable: I::READABLE,
            ends_with_forces: I::ENDS_WITH_FORCES,
            drifts_first: I::DRIFTS_FIRST,
            drift_kick: I::DRIFT_KICK,
            gyrates: I::GYRATES,
            error: I::ERROR,
            coupled: I::COUPLED,
            limit: I::limit,
            last: I::last,
            oscillator: I::oscillator,
            stage_state: I::stage_state,
            refuses_fields: refuses_fields::<I>(),
        }
    }

    /// Facts of all registered integrators.
    pub fn all() -> Vec<Self> {
        let mut all = Vec::new();
        with_integrator!(each I => all.push(Self::of::<I>()));
        all
    }

    /// Number of stages of a step.
    pub fn stages(&self) -> usize {
        self.nodes.len()
    }

    /// Whether the method is unstable for an undamped oscillator at any step size.
    pub fn gains_energy(&self) -> bool {
        (self.limit)(0.0) == 0.0
    }

    /// Weights with which the power at a stage is integrated: of this evaluation, and of the last evaluation of the previous
    /// step.
    pub fn weights_at(&self, stage: usize) -> [f64; 2] {
        [self.weights[stage], if stage == 0 { self.last_weight } else { 0.0 }]
    }

    /// Register with the velocity of the drift that led to a stage. None unless everything that a stage keeps follows from this
    /// velocity and the acceleration.
    pub fn drifts_by_register(&self) -> Option<usize> {
        self.drift_kick.map(|drift_kick| drift_kick.velocity).filter(|&velocity| velocity < self.registers)
    }
}
