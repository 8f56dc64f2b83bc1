//! Forces, one file each. To add one: write its file, and add its line to [`build`].

use std::ops::Range;

use crate::error::{Error, Result};
use crate::math::{Real, Vector};
use crate::matter::{Power, Properties, Span, View};
use crate::parallel::Executor;
use crate::scene::{Scene, Term};
use crate::simd::padded;
use crate::stability::SpectralBound;

mod central;
mod custom;
mod drag;
mod gravity;
mod lennard_jones;
pub mod linear;
mod neighbor_list;
mod pairs;
mod pointwise;
mod repulsion;
pub mod sph;
pub mod springs;

pub use central::InverseSquare;
use linear::Fusion;
pub use pointwise::ForceField;

/// The matter at the moment when the forces are asked for.
#[derive(Debug, Clone, Copy)]
pub struct StateView<'a, V: Vector> {
    /// Positions relative to the origin [m]; for pointwise forces those of the block, for others of all particles.
    pub position: View<'a, V>,
    /// Velocities [m/s].
    pub velocity: View<'a, V>,
    /// What the positions are short of by rounding [m]; without particles where nobody needs it.
    pub residual: View<'a, V>,
    /// Mass and everything else that does not change.
    pub properties: &'a Properties<V>,
    /// The time [s].
    pub time: f64,
    /// Who may share what takes long, and says whether to stop it.
    pub executor: &'a Executor,
}

impl<V: Vector> StateView<'_, V> {
    /// The exact position of a particle relative to the origin along one axis [m].
    #[inline(always)]
    pub fn exact_position(&self, axis: usize, index: usize) -> f64 {
        let residual = self.residual.axis(axis).get(index).map_or(0.0, |residual| residual.to_f64());
        self.position.axis(axis)[index].to_f64() + residual
    }
}

/// The way of all particles through a drift: with constant velocity to where they are at its end.
#[derive(Debug, Clone, Copy)]
pub struct Drift<'a, V: Vector> {
    /// The matter at its end.
    pub end: StateView<'a, V>,
    /// The velocity of the way [m/s].
    pub velocity: View<'a, V>,
    /// Its duration [s].
    pub h: f64,
}

impl<V: Vector> Drift<'_, V> {
    /// The position of a particle relative to the origin along one axis, in the middle of the way [m].
    #[inline(always)]
    pub fn midpoint(&self, axis: usize, index: usize) -> f64 {
        self.end.exact_position(axis, index) - 0.5 * self.h * self.velocity.axis(axis)[index].to_f64()
    }
}

/// Density and pressure of the particles that are fluid, NaN for the others.
#[derive(Debug, Clone, Default)]
pub struct Fields {
    /// Density [kg/m³].
    pub density: Vec<f64>,
    /// Pressure [Pa].
    pub pressure: Vec<f64>,
}

/// How fast a fluid flows beside its sound.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct Flow {
    /// The share of its particles that are faster than [`Flow::FAST`].
    pub fast: f64,
    /// The speed of sound [m/s].
    pub sound: f64,
}

impl Flow {
    /// The Mach number from which on it is fast: density is then off by about the square of it, two percent.
    pub const FAST: f64 = 0.15;
}

/// What the forces do to one block.
#[derive(Debug)]
pub struct Rates<'a, V: Vector> {
    /// The force on every particle of the block [N], padding included. Each force adds to it.
    pub force: Span<'a, V>,
    /// The power that passes through each sink [W]. Each force adds to it.
    pub power: &'a mut Power,
}

/// How far a force reaches from the particle that it acts on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Reach {
    /// It depends on the particle alone.
    Pointwise,
    /// It depends on given partners.
    Network,
    /// It depends on whoever is near.
    Pairs,
    /// It depends on everything: asked for all at once, in [`Force::prepare`].
    Whole,
}

/// How a force depends on velocity.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum VelocityDependence {
    /// Not at all.
    None,
    /// It takes energy out.
    Dissipative,
}

/// How a force comes by a field of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Field {
    /// It has none.
    None,
    /// It is counted from where the particles are, whenever forces are asked for.
    Summation,
    /// It is carried along and changes with the motion.
    Continuity,
}

/// A law that accelerates matter, and its share of the energy budget.
pub trait Force<V: Vector>: Send + Sync {
    /// Its name in the plan and in the audit: `gravity`.
    fn name(&self) -> &'static str;

    /// How far it reaches.
    fn reach(&self) -> Reach;

    /// How it depends on velocity.
    fn velocity(&self) -> VelocityDependence;

    /// How it comes by its field, such as the density of a fluid.
    fn field(&self) -> Field {
        Field::None
    }

    /// The order in time to which it can be followed, at best.
    fn order(&self) -> u32 {
        u32::MAX
    }

    /// Counts its field at the end of a step where no force was asked for.
    fn count(&mut self, _at: &StateView<'_, V>, _crew: &Executor) -> Result<()> {
        Ok(())
    }

    /// Advances its field over a drift.
    fn drift(&mut self, _drift: &Drift<'_, V>, _crew: &Executor) -> Result<()> {
        Ok(())
    }

    /// Adds the energy that its field lost over the last drift to what passed through the sinks of a block [J].
    fn spend(&self, _block: Range<usize>, _energy: &mut Power) {}

    /// Whether it moves particles beside their velocity, after a drift.
    fn displaces(&self) -> bool {
        false
    }

    /// Adds where it moves the particles of `block` after the last drift [m] to `ways`. Their velocities stay, and what that
    /// changes in pointwise and user-given potentials counts as work.
    fn displace(&self, _block: Range<usize>, _ways: &mut Span<'_, V>) {}

    /// Work that must be done for all particles before any block is asked for.
    fn prepare(&mut self, _at: &StateView<'_, V>, _crew: &Executor) -> Result<()> {
        Ok(())
    }

    /// Remembers, at the start of a batch of steps, what it keeps from step to step.
    fn keep(&mut self) {}

    /// Goes back to what it last kept.
    fn undo(&mut self) -> Result<()> {
        Ok(())
    }

    /// What it keeps from step to step, as far as the bits of its forces depend on it.
    fn capture(&self) -> Vec<f64> {
        Vec::new()
    }

    /// Goes on from what it kept when it was captured; takes from the front of `numbers` as many as it gave.
    ///
    /// # Errors
    /// If they are not of its making.
    fn restore(&mut self, _numbers: &mut &[f64]) -> Result<()> {
        Ok(())
    }

    /// Adds itself to the fused law if it can. It is then not asked to accumulate.
    fn fold(&self, _properties: &Properties<V>, _fold: &mut Fusion) -> bool {
        false
    }

    /// Adds the force on each particle of `block` and the power that it dissipates or supplies there.
    fn accumulate(&self, _block: Range<usize>, _at: &StateView<'_, V>, _rates: &mut Rates<'_, V>) {}

    /// Itself as an inverse-square law, if it is one: of the forces that cannot be fused, this one is worth a kernel of its
    /// own, in which independent particles run through whole steps.
    fn inverse_square(&self, _properties: &Properties<V>) -> Option<InverseSquare<'_, V::Scalar>> {
        None
    }

    /// What the audit calls its potential energy.
    fn potential_name(&self) -> &'static str {
        self.name()
    }

    /// Whether it has a potential energy, which the audit then names.
    fn has_potential(&self) -> bool {
        true
    }

    /// The potential energy of the particles of `block` [J]; what two particles share is split between them.
    fn potential(&self, block: Range<usize>, at: &StateView<'_, V>) -> f64;

    /// The potential energy that belongs to no block [J].
    fn potential_of_all(&self, _at: &StateView<'_, V>) -> Result<f64> {
        Ok(0.0)
    }

    /// The internal energy of its field [J].
    fn internal(&self) -> f64 {
        0.0
    }

    /// Writes its field, by the index of the particle.
    fn show(&self, _fields: &mut Fields) {}

    /// How fast its fluid flows at these velocities, if it is one.
    fn flow(&self, _velocity: View<'_, V>) -> Option<Flow> {
        None
    }

    /// Adds its stiffness and damping, as they are at this moment, to the bound on the time step. Where it knows what is
    /// ahead it counts that too, but not if [`SpectralBound::is_present`].
    ///
    /// # Errors
    /// If a function of the user's fails.
    fn bound(&self, at: &StateView<'_, V>, bound: &mut SpectralBound) -> Result<()>;

    /// Whether its part of that bound changes as the matter moves.
    fn bound_varies(&self) -> bool {
        false
    }

    /// Whether its part of that bound is the one that it is at every moment at which this holds.
    fn bound_stands(&self, _at: &StateView<'_, V>) -> bool {
        !self.bound_varies()
    }

    /// Whether its part of the bound on one step, which does not look ahead, changes as the matter moves.
    fn present_bound_varies(&self) -> bool {
        self.bound_varies()
    }

    /// About how many springs or other pairs it consists of.
    fn pairs(&self) -> usize {
        0
    }

    /// How it is laid out, for the plan; empty if there is nothing to say.
    fn layout(&self) -> String {
        String::new()
    }

    /// What it found when it was last asked for its part of the bound, for the plan; empty if there is nothing to say.
    fn findings(&self) -> String {
        String::new()
    }

    /// The memory that it takes [bytes].
    fn bytes(&self) -> usize {
        0
    }
}

/// Whether any force of a scene passes between all particles that are near each other.
pub fn are_between_pairs(scene: &Scene) -> bool {
    let of_fluids = scene.bodies.iter().any(|body| body.fluid.is_some());
    of_fluids || scene.forces.iter().any(|term| ["Repulsion", "LennardJones"].contains(&term.kind.as_str()))
}

/// The registry: the forces that a term of the scene declares. Pointwise forces don't act on fixed
/// particles; forces between pairs count with them.
pub fn build<V: Vector>(scene: &Scene, term: &Term, properties: &Properties<V>) -> Result<Vec<Box<dyn Force<V>>>> {
    let in_scene = scene.members(term);
    let chosen: Vec<bool> = properties.caller.iter().map(|&caller| in_scene[caller as usize]).collect();
    let members: Vec<bool> = chosen.iter().enumerate().map(|(index, &chosen)| chosen && !properties.is_fixed(index)).collect();
    let mut mask: Vec<V::Scalar> = members.iter().map(|&member| if member { V::Scalar::ONE } else { V::Scalar::ZERO }).collect();
    mask.resize(padded(members.len()), V::Scalar::ZERO);
    Ok(match term.kind.as_str() {
        "Gravity" => vec![Box::new(gravity::Gravity::new(term, members)?)],
        "Drag" => drag::Drag::<V>::parts(term, &mask)?.into_iter().map(|part| Box::new(part) as _).collect(),
        "CentralForce" => vec![Box::new(central::Central::<V>::new(term, mask)?)],
        "CustomForce" => {
            let mut engine = vec![0; members.len()];
            properties.caller.iter().enumerate().for_each(|(index, &caller)| engine[caller as usize] = index);
            let all = (0..members.len()).filter(|&caller| in_scene[caller]).map(|caller| engine[caller]).collect();
            vec![Box::new(custom::Custom::<V>::new(term, all, members.len())?)]
        }
        "Repulsion" => vec![repulsion::force(scene, term, properties, &chosen)?],
        "LennardJones" => {
            let law = lennard_jones::LennardJones::<V::Scalar>::new(term)?;
            vec![Box::new(pairs::Pairs::<V, _>::new(scene, properties, &chosen, law)?)]
        }
        other => return Err(Error::parameter(&term.path, "a force", other)),
    })
}
