//! Integrators, one file each. To add one: write its file, and add its line to [`with_integrator`]. Alternating
//! drifts and kicks are a [`Splitting`], explicit Runge–Kutta methods have a [`Tableau`]: either is nothing but coefficients.
//!
//! An integrator treats every component of every particle alike, so it is written for one number x with its velocity v.
//! A step is a sequence of stages: [`Integrator::stage_state`] moves x and v to where the forces are wanted, and
//! [`Integrator::stage_update`] takes in the acceleration found there. The drivers in [`crate::systems`] decide whether a stage
//! sweeps over all particles, or a block of independent particles runs through many steps.

use crate::math::Real;
use crate::simd::Number;

pub(crate) mod amplification;
mod blanes_moan_4;
mod blanes_moan_6;
mod bogacki_shampine_3;
mod boris;
mod dormand_prince_5;
pub mod explicit;
mod explicit_euler;
mod facts;
pub mod first_order;
pub mod gauss_radau_15;
mod group;
#[cfg(test)]
mod limits;
mod mclachlan_2;
mod pefrl;
mod runge_kutta_4;
pub mod runge_kutta_chebyshev;
mod semi_implicit_euler;
mod splitting;
mod swept;
mod tableau;
mod velocity_verlet;

pub use blanes_moan_4::BlanesMoan4;
pub use blanes_moan_6::BlanesMoan6;
pub use bogacki_shampine_3::BogackiShampine3;
pub use boris::Boris;
pub use dormand_prince_5::DormandPrince5;
pub use explicit_euler::ExplicitEuler;
pub use facts::Facts;
pub use first_order::FirstOrder;
pub use group::ComponentGroup;
pub use mclachlan_2::McLachlan2;
pub use pefrl::Pefrl;
pub use runge_kutta_4::RungeKutta4;
pub use semi_implicit_euler::SemiImplicitEuler;
pub use splitting::Splitting;
pub use swept::{Compiled, DriftsAndKicks, Swept};
pub use tableau::{RungeKutta, Tableau};
pub use velocity_verlet::VelocityVerlet;

/// Maximum number of registers (numbers per component) of an integrator.
pub const REGISTERS: usize = 6;

/// One component of one particle, on its way through a step.
#[derive(Debug, Clone, Copy)]
pub struct Component<T> {
    /// Position: at a step's end the state, at a stage the point where the forces are wanted.
    pub x: T,
    /// Velocity, likewise.
    pub v: T,
    /// Registers: kept between the stages and, the first [`Integrator::PERSISTENT`] of them, from step to step.
    pub registers: [T; REGISTERS],
}

impl<T: Real> Component<T> {
    /// The component at a step's start, with its first register, where that persists.
    pub fn new(x: T, v: T, persistent: T) -> Self {
        let mut registers = [T::ZERO; REGISTERS];
        registers[0] = persistent;
        Self { x, v, registers }
    }
}

/// The drifts and kicks of a step that consists of them. A field that changes with the motion is advanced over each drift, as
/// position is.
#[derive(Debug, Clone, Copy)]
pub struct DriftKick {
    /// The drifts, in units of h: the one that leads to each stage, 0 where there is none, and maybe one after the last stage,
    /// with the velocity of the step's end.
    pub drifts: &'static [f64],
    /// The register that holds, when a stage asks for the forces, the velocity of the drift that led there.
    pub velocity: usize,
}

/// A way to advance x'' = a(x, v, t) by steps of h.
pub trait Integrator: Sized + Send + Sync + 'static {
    /// Its stages in kernels that sweep over columns.
    type Swept: Swept;
    /// The class's name in Python.
    const NAME: &'static str;
    /// The order of convergence without velocity-dependent forces.
    const ORDER: u32;
    /// The order with dissipation.
    const ORDER_DISSIPATIVE: u32;
    /// The nodes cᵢ: the times in the step of the evaluations, one per stage, in units of h.
    const NODES: &'static [f64];
    /// The weights bᵢ with which the powers at the stages are integrated over the step.
    const WEIGHTS: &'static [f64];
    /// The weight of the power at the last stage of the step before, where the method reuses that evaluation.
    const LAST_WEIGHT: f64 = 0.0;
    /// The weight, in the power of damping at a stage, of the velocity that the stage's update ends with; the rest is of the one at
    /// which the forces were asked for.
    const CORRECTED_WEIGHT: f64 = 0.0;
    /// The number of registers in use.
    const REGISTERS: usize = 0;
    /// The number of those that persist from one step to the next.
    const PERSISTENT: usize = 0;
    /// The one of those that holds a position, if one does.
    const POSITION_REGISTER: Option<usize> = None;
    /// Whether its last evaluation is that of the step's end, with which the next step begins.
    const ENDS_WITH_FORCES: bool = Self::LAST_WEIGHT != 0.0;
    /// Its drifts, if a step consists of drifts and kicks.
    const DRIFT_KICK: Option<DriftKick> = None;
    /// Whether magnetic fields turn the velocity in the middle of its only kick.
    const GYRATES: bool = false;
    /// The number of those that can be read after a step: first the persistent ones, then the estimates.
    const READABLE: usize = Self::PERSISTENT;
    /// The ones of those that hold the estimated errors of x and v, where a method of the order below is embedded.
    const ERROR: Option<[usize; 2]> = None;
    /// The limit where stiffness and damping couple the modes, in units of the limit of one mode, as [`crate::stability`]
    /// explains.
    const COUPLED: f64 = 1.0;

    /// The largest stable ω·h on x'' = −ω²x − 2ξωx' for the damping ratio ξ; 0 where no step is stable.
    fn limit(damping_ratio: f64) -> f64;

    /// The largest stable ω·h there, beyond which no step is: not the same as the limit where resonances, at which a step is
    /// unstable, have stable steps on either side.
    fn last(damping_ratio: f64) -> f64 {
        amplification::last::<Self>(damping_ratio)
    }

    /// An oscillator, as its frequency and its damping [1/s], whose longest step is at most that of a wave: of a frequency, a
    /// damping of its velocity, and a decay of the field in its position's place, which is advanced over the drifts.
    fn oscillator(frequency: f64, damping: f64, _decay: f64) -> [f64; 2] {
        [frequency, damping]
    }

    /// Whether loops are compiled for it that keep a particle in registers for many steps. Others take their stages in turn.
    const IN_REGISTERS: bool = false;

    /// Whether the positions of the step's end stand when its only evaluation is asked for, on the parabola of the persistent
    /// acceleration. Contacts are then resolved on that parabola, before the evaluation.
    const DRIFTS_FIRST: bool = false;

    /// Goes on from a velocity, at the end of that parabola, that a contact may have changed.
    fn correct_velocity<T: Real>(_component: &mut Component<T>, _h: T) {}

    /// Sets the persistent register from the acceleration `a` at the initial state.
    fn begin<T: Number>(_component: &mut Component<T>, _a: T) {}

    /// Moves to where stage `stage` asks for the forces.
    fn stage_state<T: Number>(stage: usize, component: &mut Component<T>, h: T);

    /// Takes in the acceleration found there; after the last stage x and v are the state at the step's end.
    fn stage_update<T: Number>(stage: usize, component: &mut Component<T>, a: T, h: T);
}

/// Why a field that diffuses cannot be advanced over the drifts of an integrator, if it cannot.
pub fn refuses_fields<I: Integrator>() -> Option<&'static str> {
    match I::DRIFT_KICK {
        None => Some("density is advanced over the drifts between kicks, and its steps are not made of these"),
        Some(drift_kick) if drift_kick.drifts.iter().chain(I::WEIGHTS).any(|&part| part < 0.0) => {
            Some("some of its substeps run backwards, where diffusion and viscosity would roughen what they have to even out")
        }
        Some(_) => None,
    }
}

/// Evaluates `$body` for each stage of `$I`, with its index as a constant. It is written out, because a loop that the compiler
/// does not unroll is not vectorized, and that of a method of many stages is not unrolled.
#[doc(hidden)]
#[macro_export]
macro_rules! for_each_stage {
    ($I:ty, $stage:ident => $body:block) => {
        $crate::integrators::for_each_stage!(@ $I, $stage, $body; 0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15)
    };
    (@ $I:ty, $stage:ident, $body:block; $($index:literal)*) => {
        const { assert!(<$I as $crate::integrators::Integrator>::NODES.len() <= 16, "more stages than are written out") };
        $(if const { $index < <$I as $crate::integrators::Integrator>::NODES.len() } {
            let $stage: usize = $index;
            $body
        })*
    };
}
pub use for_each_stage;

/// The registry: binds `$I` to the integrator called `$name` and evaluates `$body`, or `$otherwise` if there is none; or
/// evaluates `$body` for each.
#[doc(hidden)]
#[macro_export]
macro_rules! with_integrator {
    (@registered $($then:tt)*) => {
        $crate::integrators::with_integrator!($($then)*;
            ExplicitEuler, SemiImplicitEuler, VelocityVerlet, McLachlan2, RungeKutta4, Pefrl, BlanesMoan4, BlanesMoan6,
            BogackiShampine3, DormandPrince5, Boris)
    };
    (@named $name:expr, $I:ident, $body:expr, $otherwise:expr; $($integrator:ident),+) => {
        match $name {
            $(name if name == <$crate::integrators::$integrator as $crate::integrators::Integrator>::NAME => {
                type $I = $crate::integrators::$integrator;
                $body
            })+
            _ => $otherwise,
        }
    };
    (@each $I:ident, $body:expr; $($integrator:ident),+) => {
        $({
            type $I = $crate::integrators::$integrator;
            $body
        })+
    };
    (each $I:ident => $body:expr) => {
        $crate::integrators::with_integrator!(@registered @each $I, $body)
    };
    ($name:expr, $I:ident => $body:expr, $otherwise:expr) => {
        $crate::integrators::with_integrator!(@registered @named $name, $I, $body, $otherwise)
    };
}
pub use with_integrator;
