//! Stages for kernels that sweep over columns. They are compiled for an integrator, or use the coefficients of a splitting at run
//! time, by code that all splittings share.

use std::marker::PhantomData;

use super::splitting::{ACCELERATION, BEFORE};
use super::{Component, Facts, Integrator};
use crate::simd::Number;

/// Stages of an integrator, with its constants under their names in [`Integrator`].
pub trait Swept: Copy + Send + Sync {
    /// [`Integrator::REGISTERS`].
    const REGISTERS: usize;
    /// [`Integrator::PERSISTENT`].
    const PERSISTENT: usize;
    /// [`Integrator::READABLE`].
    const READABLE: usize;
    /// [`Integrator::POSITION_REGISTER`].
    const POSITION_REGISTER: Option<usize>;
    /// [`Integrator::CORRECTED_WEIGHT`].
    const CORRECTED_WEIGHT: f64;
    /// [`Facts::drifts_by_register`].
    const DRIFT_REGISTER: Option<usize>;
    /// Number of stages that are compiled separately; 1 if their coefficients are run-time values.
    const COMPILED: usize;

    /// Coefficients of one stage, which loops over particles keep in registers.
    type At: Copy + Send + Sync;

    /// Returns the stages of an integrator.
    fn of(facts: &Facts) -> Self;

    /// Returns the coefficients of a stage.
    fn at(&self, stage: usize) -> Self::At;

    /// [`Integrator::begin`].
    fn begin<T: Number>(component: &mut Component<T>, a: T);

    /// [`Integrator::stage_state`].
    fn state<T: Number>(at: Self::At, stage: usize, component: &mut Component<T>, h: T);

    /// [`Integrator::stage_update`].
    fn update<T: Number>(at: Self::At, stage: usize, component: &mut Component<T>, a: T, h: T);
}

/// Stages compiled for an integrator.
#[derive(Debug)]
pub struct Compiled<I>(PhantomData<fn() -> I>);

impl<I> Clone for Compiled<I> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<I> Copy for Compiled<I> {}

impl<I: Integrator> Swept for Compiled<I> {
    const REGISTERS: usize = I::REGISTERS;
    const PERSISTENT: usize = I::PERSISTENT;
    const READABLE: usize = I::READABLE;
    const POSITION_REGISTER: Option<usize> = I::POSITION_REGISTER;
    const CORRECTED_WEIGHT: f64 = I::CORRECTED_WEIGHT;
    const DRIFT_REGISTER: Option<usize> = match I::DRIFT_KICK {
        Some(drift_kick) if drift_kick.velocity < I::REGISTERS => Some(drift_kick.velocity),
        _ => None,
    };
    const COMPILED: usize = I::NODES.len();

    type At = ();

    fn of(_facts: &Facts) -> Self {
        Self(PhantomData)
    }

    #[inline(always)]
    fn at(&self, _stage: usize) {}

    #[inline(always)]
    fn begin<T: Number>(component: &mut Component<T>, a: T) {
        I::begin(component, a);
    }

    #[inline(always)]
    fn state<T: Number>((): (), stage: usize, component: &mut Component<T>, h: T) {
        I::stage_state(stage, component, h);
    }

    #[inline(always)]
    fn update<T: Number>((): (), stage: usize, component: &mut Component<T>, a: T, h: T) {
        I::stage_update(stage, component, a, h);
    }
}

/// Stages of a [`super::Splitting`], each a drift followed by a kick.
#[derive(Debug, Clone, Copy)]
pub struct DriftsAndKicks {
    /// Drifts, in units of h.
    drifts: &'static [f64],
    /// Kicks after drifts, in units of h.
    kicks: &'static [f64],
    /// Kick that begins a step, if any.
    first: Option<f64>,
}

/// Coefficients of a drift with the kick after it, in units of h.
#[derive(Debug, Clone, Copy)]
pub struct DriftKickStage {
    /// Kick that begins the step.
    first: Option<f64>,
    drift: f64,
    /// Part of the kick that predicts the velocity for forces that depend on it.
    half: f64,
    kick: f64,
    /// Drift that ends the step.
    last: Option<f64>,
}

impl DriftsAndKicks {
    /// Returns the stages of alternating drifts and kicks.
    pub const fn new(drifts: &'static [f64], kicks: &'static [f64]) -> Self {
        match kicks {
            [first, kicks @ ..] if kicks.len() == drifts.len() => Self { drifts, kicks, first: Some(*first) },
            _ => Self { drifts, kicks, first: None },
        }
    }
}

impl Swept for DriftsAndKicks {
    const REGISTERS: usize = 2;
    const PERSISTENT: usize = 1;
    const READABLE: usize = 1;
    const POSITION_REGISTER: Option<usize> = None;
    const CORRECTED_WEIGHT: f64 = 0.0;
    const DRIFT_REGISTER: Option<usize> = Some(BEFORE);
    const COMPILED: usize = 1;

    type At = DriftKickStage;

    fn of(facts: &Facts) -> Self {
        let drifts = facts.drift_kick.map_or(&[][..], |drift_kick| drift_kick.drifts);
        let first = (drifts.len() == facts.stages()).then_some(facts.last_weight);
        Self { drifts, kicks: facts.weights, first }
    }

    #[inline(always)]
    fn at(&self, stage: usize) -> DriftKickStage {
        let (kick, ends) = (self.kicks[stage], stage + 1 == self.kicks.len());
        DriftKickStage {
            first: self.first.filter(|_| stage == 0),
            drift: self.drifts[stage],
            half: if ends && self.first.is_some() { kick } else { 0.5 * kick },
            kick,
            last: if ends && self.first.is_none() { Some(self.drifts[stage + 1]) } else { None },
        }
    }

    #[inline(always)]
    fn begin<T: Number>(component: &mut Component<T>, a: T) {
        component.registers[ACCELERATION] = a;
    }

    #[inline(always)]
    fn state<T: Number>(at: DriftKickStage, _stage: usize, component: &mut Component<T>, h: T) {
        let a = component.registers[ACCELERATION];
        let before = match at.first {
            Some(kick) => component.v + T::constant(kick) * h * a,
            None => component.v,
        };
        component.x += T::constant(at.drift) * h * before;
        component.v = before + T::constant(at.half) * h * a;
        component.registers[BEFORE] = before;
    }

    #[inline(always)]
    fn update<T: Number>(at: DriftKickStage, _stage: usize, component: &mut Component<T>, a: T, h: T) {
        component.v = component.registers[BEFORE] + T::constant(at.kick) * h * a;
        component.registers[ACCELERATION] = a;
        if let Some(drift) = at.last {
            component.x += T::constant(drift) * h * component.v;
        }
    }
}
