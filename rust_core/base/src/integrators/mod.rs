//! Integrators, one file each.
//!
//! To add an integrator, write its file and add its line to [`with_integrator`]. Methods of alternating drifts and kicks
//! implement [`Splitting`]; explicit Runge–Kutta methods implement [`Tableau`]. Both consist of coefficients only.
//!
//! An integrator treats every component of every particle alike, so it is written for one number x with its velocity v. A step is
//! a sequence of stages. The function [`Integrator::stage_state`] moves x and v to the point at which the forces are evaluated.
//! The function [`Integrator::stage_update`] applies the acceleration found there. The drivers in the engine's systems decide how
//! stages are executed: a stage for all particles at a time, or many steps for a block of independent particles.

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

/// Component of a particle during a step.
#[derive(Debug, Clone, Copy)]
pub struct Component<T> {
    /// Position: at a step's end the state, at a stage the point at which the forces are evaluated.
    pub x: T,
    /// Velocity, at the same point.
    pub v: T,
    /// Registers, kept between stages. The first [`Integrator::PERSISTENT`] of them persist from step to step.
    pub registers: [T; REGISTERS],
}

impl<T: Real> Component<T> {
    /// Returns the component at a step's start, with its first register if it persists.
    pub fn new(x: T, v: T, persistent: T) -> Self {
        let mut registers = [T::ZERO; REGISTERS];
        registers[0] = persistent;
        Self { x, v, registers }
    }
}

/// Drifts and kicks of a step that consists of both. A field that changes with the motion is advanced over each drift, like
/// position.
#[derive(Debug, Clone, Copy)]
pub struct DriftKick {
    /// Drifts in units of h: one before each stage, 0 if there is none. An optional further drift follows the last stage, with
    /// the velocity of the step's end.
    pub drifts: &'static [f64],
    /// Register that holds the velocity of the preceding drift when a stage asks for the forces.
    pub velocity: usize,
}

/// Method that advances x'' = a(x, v, t) by steps of h.
pub trait Integrator: Sized + Send + Sync + 'static {
    /// Stages for kernels that sweep over columns.
    type Swept: Swept;
    /// Name of the class in Python.
    const NAME: &'static str;
    /// Order of convergence without velocity-dependent forces.
    const ORDER: u32;
    /// Order of convergence with dissipation.
    const ORDER_DISSIPATIVE: u32;
    /// Nodes cᵢ: times of the evaluations in the step, one per stage, in units of h.
    const NODES: &'static [f64];
    /// Weights bᵢ with which the powers at the stages are integrated over the step.
    const WEIGHTS: &'static [f64];
    /// Weight of the power at the last stage of the previous step, if the method reuses this evaluation.
    const LAST_WEIGHT: f64 = 0.0;
    /// Weight of the corrected velocity in the power of damping at a stage, which is the velocity after the stage's update. The
    /// remaining weight applies to the velocity at which the forces were evaluated.
    const CORRECTED_WEIGHT: f64 = 0.0;
    /// Number of registers in use.
    const REGISTERS: usize = 0;
    /// Number of registers that persist from one step to the next.
    const PERSISTENT: usize = 0;
    /// Index of the register that holds a position, if any.
    const POSITION_REGISTER: Option<usize> = None;
    /// Whether the last evaluation is that of the step's end, with which the next step begins.
    const ENDS_WITH_FORCES: bool = Self::LAST_WEIGHT != 0.0;
    /// Drifts of a step that consists of drifts and kicks.
    const DRIFT_KICK: Option<DriftKick> = None;
    /// Whether magnetic fields rotate the velocity in the middle of the only kick.
    const GYRATES: bool = false;
    /// Number of registers that can be read after a step: first the persistent ones, then the estimates.
    const READABLE: usize = Self::PERSISTENT;
    /// Registers that hold the estimated errors of x and v, if a method of lower order is embedded.
    const ERROR: Option<[usize; 2]> = None;
    /// Ratio of the limit with modes coupled by stiffness and damping to the limit of one mode; see [`crate::stability`].
    const COUPLED: f64 = 1.0;

    /// Largest stable ω·h on x'' = −ω²x − 2ξωx' for the damping ratio ξ; 0 if no step is stable.
    fn limit(damping_ratio: f64) -> f64;

    /// Largest stable ω·h on the same equation, beyond which no step is stable. It exceeds the limit where unstable resonances
    /// have stable steps on either side.
    fn last(damping_ratio: f64) -> f64 {
        amplification::last::<Self>(damping_ratio)
    }

    /// Oscillator, as its frequency and damping [1/s], whose longest stable step is at most that of a wave. The wave is given by
    /// its frequency, the damping of its velocity, and the decay of its field. The field takes the place of position and is
    /// advanced over the drifts.
    fn oscillator(frequency: f64, damping: f64, _decay: f64) -> [f64; 2] {
        [frequency, damping]
    }

    /// Whether loops that keep a particle in registers for many steps are compiled for the method. Other methods take their
    /// stages in turn.
    const IN_REGISTERS: bool = false;

    /// Whether positions are final when the only evaluation is due, on the parabola of the persistent acceleration. Contacts are
    /// then resolved on this parabola, before the evaluation.
    const DRIFTS_FIRST: bool = false;

    /// Continues from a velocity at the end of the parabola, which a contact may have changed.
    fn correct_velocity<T: Real>(_component: &mut Component<T>, _h: T) {}

    /// Sets the persistent register from the acceleration `a` at the initial state.
    fn begin<T: Number>(_component: &mut Component<T>, _a: T) {}

    /// Moves the component to the point at which stage `stage` evaluates the forces.
    fn stage_state<T: Number>(stage: usize, component: &mut Component<T>, h: T);

    /// Applies the acceleration of a stage. After the last stage, x and v are the state at the step's end.
    fn stage_update<T: Number>(stage: usize, component: &mut Component<T>, a: T, h: T);
}

/// Reason why a diffusing field cannot be advanced over the drifts of an integrator, if any.
pub fn refuses_fields<I: Integrator>() -> Option<&'static str> {
    match I::DRIFT_KICK {
        None => Some("density is advanced over the drifts between kicks, and its steps are not made of these"),
        Some(drift_kick) if drift_kick.drifts.iter().chain(I::WEIGHTS).any(|&part| part < 0.0) => {
            Some("some of its substeps run backwards, where diffusion and viscosity would roughen what they have to even out")
        }
        Some(_) => None,
    }
}

/// Evaluates `$body` for each stage of `$I`, with its index as a constant. The stages are written out: loops that the compiler
/// does not unroll are not vectorized, and loops over many stages are not unrolled.
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

/// Registry of integrators. Binds `$I` to the integrator called `$name` and evaluates `$body`, or `$otherwise` if there is none;
/// or evaluates `$body` for each.
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
