//! Forces as a step of matter sees them, and the laws of those that its kernels evaluate in registers. The crates of forces and
//! fluids implement [`Force`] and [`FluidScheme`].

use std::ops::Range;

use glam::DVec3;

use crate::error::Result;
use crate::history::History;
use crate::ledger::{Class, Ledger};
use crate::math::{Real, Vector};
use crate::matter::{Power, Properties, SolidMotion, Span, View};
use crate::parallel::Executor;
use crate::stability::{Horizon, SpectralBound};

pub mod derivatives;
mod electromagnetic;
pub mod fluid;
mod inverse_square;
pub mod linear;
pub mod pointwise;
mod readings;
pub mod springs;
mod strength;

use derivatives::Derivatives;
pub use electromagnetic::{Affine, ElectromagneticLaw, FieldLaw, ReadyField, Use, times};
pub use fluid::{DensityScheme, Drift, Fields, FluidScheme, Mach};
pub use inverse_square::{CentralLaw, InverseCube, InverseSquare, InverseSquareLaw, PowerLaw};
use linear::Fusion;
pub use pointwise::ForceField;
pub use readings::Readings;
pub use strength::{PART, Strength};

/// State of matter at an evaluation of the forces.
#[derive(Debug, Clone, Copy)]
pub struct StateView<'a, V: Vector> {
    /// Positions relative to the origin [m]; for pointwise forces those of the block, for others of all particles.
    pub position: View<'a, V>,
    /// Velocities [m/s].
    pub velocity: View<'a, V>,
    /// Rounding residuals of the positions [m]: exact position = position + residual. Empty where no force needs them.
    pub residual: View<'a, V>,
    /// Mass and all other constant properties.
    pub properties: &'a Properties<V>,
    /// Rotations of the rigid bodies, in the caller's order; empty for pointwise forces.
    pub solids: &'a [SolidMotion],
    /// The time [s].
    pub time: f64,
    /// Threads for long operations, and the stop request.
    pub executor: &'a Executor,
}

impl<V: Vector> StateView<'_, V> {
    /// The exact position of a particle relative to the origin along one axis [m].
    #[inline(always)]
    pub fn exact_position(&self, axis: usize, index: usize) -> f64 {
        let residual = self.residual.axis(axis).get(index).map_or(0.0, |residual| residual.to_f64());
        self.position.axis(axis)[index].to_f64() + residual
    }

    /// Positions of some particles in the scene [m].
    pub fn places(&self, particles: &[usize]) -> Vec<DVec3> {
        particles.iter().map(|&index| self.properties.origin + self.position.get(index).widen()).collect()
    }

    /// The exact position of a particle relative to the origin [m].
    #[inline]
    pub fn exact_point(&self, index: usize) -> DVec3 {
        let mut point = [0.0; 3];
        point[..V::DIMENSION].iter_mut().enumerate().for_each(|(axis, slot)| *slot = self.exact_position(axis, index));
        DVec3::from_array(point)
    }
}

/// Forces and powers on one block of particles.
#[derive(Debug)]
pub struct Rates<'a, V: Vector> {
    /// The force on every particle of the block [N], padding included. Each force adds to it.
    pub force: Span<'a, V>,
    /// The power that passes through each sink [W]. Each force adds to it.
    pub power: &'a mut Power,
    /// Force of the damping of springs alone [N], if an integrator asks for it.
    pub damping: Option<Span<'a, V>>,
}

impl<'a, V: Vector> Rates<'a, V> {
    /// Forces and powers, without separate damping.
    #[inline]
    pub fn new(force: Span<'a, V>, power: &'a mut Power) -> Self {
        Self { force, power, damping: None }
    }

    /// A reborrow of all fields.
    #[inline]
    pub fn reborrow(&mut self) -> Rates<'_, V> {
        Rates { force: self.force.reborrow(), power: &mut *self.power, damping: self.damping.as_mut().map(Span::reborrow) }
    }
}

/// Range of a force: the particles that the force on one particle depends on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Reach {
    /// The particle alone.
    Pointwise,
    /// Given partners of the particle.
    Network,
    /// Particles near it.
    Pairs,
    /// All other particles at any distance. Evaluated for all particles at once, in [`Force::prepare`].
    Far,
    /// The whole state. Evaluated for all particles at once, in [`Force::prepare`].
    Whole,
}

/// Dependence of a force on velocity.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum VelocityDependence {
    /// No dependence.
    None,
    /// Rotation of velocities, without work.
    Gyroscopic,
    /// Dissipation of energy.
    Dissipative,
}

/// States at which a force's term of the time-step bound stays valid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Validity {
    /// Always.
    Always,
    /// While `validity` says so.
    Here,
    /// At this state only.
    Now,
}

/// Metadata of a force, known before the first evaluation.
#[derive(Debug, Clone)]
pub struct About {
    /// Name in the plan and in the energy budget, such as `gravity`.
    pub name: &'static str,
    /// Range of the force.
    pub reach: Reach,
    /// Dependence on velocity.
    pub velocity: VelocityDependence,
    /// Largest order of convergence in time that the force permits.
    pub order: u32,
    /// Name of its potential energy in the energy budget, if it has one.
    pub potential: Option<&'static str>,
    /// Whether the force has kinks as a function of positions, such as where contact begins.
    pub kinks: bool,
    /// Whether a user-defined function is called, which requires calls in the order of time.
    pub callback: bool,
    /// Approximate number of springs or other pairs.
    pub pairs: usize,
    /// Relative rms error of the force in the initial state; 0 for an exact force.
    pub force_error: f64,
    /// Memory [bytes].
    pub bytes: usize,
    /// Layout in memory, for the plan; empty if none.
    pub layout: String,
    /// Further remarks in the plan.
    pub remarks: Vec<String>,
    /// Term of the last time-step bound, for the plan; empty if none.
    pub findings: String,
}

impl About {
    /// Metadata of a conservative force without pairs or memory.
    pub fn new(name: &'static str, reach: Reach) -> Self {
        Self {
            name,
            reach,
            velocity: VelocityDependence::None,
            order: u32::MAX,
            potential: Some(name),
            kinks: false,
            callback: false,
            pairs: 0,
            force_error: 0.0,
            bytes: 0,
            layout: String::new(),
            remarks: Vec::new(),
            findings: String::new(),
        }
    }
}

/// A law that accelerates matter, with its share of the energy budget.
pub trait Force<V: Vector>: History + Send + Sync {
    /// Metadata, known before the first evaluation.
    fn about(&self) -> About;

    /// Prepares the evaluation for all particles, before any block is accumulated.
    /// # Errors
    /// If the preparation fails.
    fn prepare(&mut self, _at: &StateView<'_, V>, _executor: &Executor) -> Result<()> {
        Ok(())
    }

    /// Adds the force on each particle of `block` and the power that it dissipates or supplies there.
    fn accumulate(&self, _block: Range<usize>, _at: &StateView<'_, V>, _rates: &mut Rates<'_, V>) {}

    /// Whether the force depends on the rotations of rigid bodies, or turns them.
    fn meets_solids(&self) -> bool {
        false
    }

    /// Adds the torques of the last [`Force::prepare`] on the rigid bodies, in the caller's order, about their centers of mass
    /// [N·m].
    fn torques(&self, _torques: &mut [DVec3]) {}

    /// Adds charge times magnetic field, q B, of the particles of `block` to `strength`, for a gyroscopic force F = v × q B.
    fn magnetic(&self, _block: Range<usize>, _at: &StateView<'_, V>, _strength: &mut Strength<V>) {}

    /// Potential energy of the particles of `block` [J]. The energy of a pair is split between its particles, or counts at one of
    /// them.
    fn potential(&self, _block: Range<usize>, _at: &StateView<'_, V>) -> f64 {
        0.0
    }

    /// Adds the potential energy of each particle in the force [J]. The energy of a pair counts in full for both particles.
    fn potentials(&self, at: &StateView<'_, V>, sums: &mut [f64]) {
        (0..at.properties.count()).for_each(|index| sums[index] += self.potential(index..index + 1, at));
    }

    /// Adds the energies of the force to the energy budget.
    ///
    /// # Errors
    /// If a user-defined function fails, or the executor was asked to stop.
    fn energy(&self, at: &StateView<'_, V>, ledger: &mut Ledger) -> Result<()> {
        if let Some(name) = self.about().potential {
            ledger.add_blocks(Class::Potential, name, |block| self.potential(block, at));
        }
        Ok(())
    }

    /// Removes the elements that depend on torn edges; returns their potential energy [J]. Edges are given by their ends in
    /// ascending order.
    fn tear(&mut self, _torn: &dyn Fn([u32; 2]) -> bool, _at: &StateView<'_, V>) -> f64 {
        0.0
    }

    /// Adds the stiffness and damping in this state to the time-step bound. A [certified](Horizon::Certified) bound includes
    /// those known to follow.
    ///
    /// # Errors
    /// If a user-defined function fails.
    fn bound(&self, at: &StateView<'_, V>, bound: &mut SpectralBound) -> Result<()>;

    /// States at which the force's term of the time-step bound equals that of this state.
    fn validity(&self, at: &StateView<'_, V>, horizon: Horizon) -> Validity;

    /// Adds the force to the linear force if possible; returns whether it did. A fused force is not accumulated.
    fn fuse(&self, _properties: &Properties<V>, _fusion: &mut Fusion) -> bool {
        false
    }

    /// The force as an inverse-square force, if it is one. Of the forces that cannot be fused, this one has a kernel of its own.
    /// In that kernel, independent particles run through whole steps.
    fn inverse_square(&self, _properties: &Properties<V>) -> Option<InverseSquare<'_, V::Scalar>> {
        None
    }

    /// The force as an electric or magnetic field, if the field is constant in time and computed by the engine.
    fn ready_field(&self) -> Option<ReadyField<'_, V::Scalar>> {
        None
    }

    /// Derivatives of the force, if implemented.
    fn derivatives(&mut self) -> Option<&mut dyn Derivatives> {
        None
    }

    /// The force as a scheme for fluids, if it is one.
    fn fluid(&self) -> Option<&dyn FluidScheme<V>> {
        None
    }

    /// Mutable access to the scheme for fluids.
    fn fluid_mut(&mut self) -> Option<&mut dyn FluidScheme<V>> {
        None
    }
}
