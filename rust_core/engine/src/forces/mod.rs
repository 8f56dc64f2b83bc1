//! Forces, one file each. To add one: write its file, and add its line to [`kinds`].

use std::ops::Range;

use glam::{DVec2, DVec3};

use crate::error::Result;
use crate::history::History;
use crate::ledger::{Class, Ledger};
use crate::math::{Real, Vector};
use crate::matter::{Power, Properties, Span, View};
use crate::parallel::Executor;
use crate::scene::{self, Item, Scene};
use crate::simd::padded;
use crate::stability::{Horizon, SpectralBound};

mod all_pairs;
mod central;
mod corners;
mod custom;
pub mod density;
pub mod derivatives;
mod dihedral;
mod drag;
mod electromagnetic;
mod gravity;
mod lennard_jones;
pub mod linear;
mod neighbor_list;
mod pairs;
mod pointwise;
mod soft_spheres;
pub mod sph;
pub mod springs;
mod strength;
mod wind;

pub use central::{InverseSquare, InverseSquareLaw};
pub use density::{DensityEvolution, Drift, Fields, Scheme};
use derivatives::Derivatives;
pub use electromagnetic::ReadyField;
pub(crate) use electromagnetic::{Affine, FieldLaw, Law, Use, times};
use linear::Fusion;
pub use pointwise::ForceField;
pub use strength::{PART, Strength};

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

    /// The position of a particle, not rounded [m].
    pub fn exact_point(&self, index: usize) -> DVec3 {
        let mut point = [0.0; 3];
        point[..V::DIMENSION].iter_mut().enumerate().for_each(|(axis, slot)| *slot = self.exact_position(axis, index));
        DVec3::from_array(point)
    }
}

/// What the forces do to one block.
#[derive(Debug)]
pub struct Rates<'a, V: Vector> {
    /// The force on every particle of the block [N], padding included. Each force adds to it.
    pub force: Span<'a, V>,
    /// The power that passes through each sink [W]. Each force adds to it.
    pub power: &'a mut Power,
    /// The part of the force by the damping of springs [N], where an integrator asks for it.
    pub damping: Option<Span<'a, V>>,
}

impl<'a, V: Vector> Rates<'a, V> {
    /// Forces and powers alone.
    pub fn new(force: Span<'a, V>, power: &'a mut Power) -> Self {
        Self { force, power, damping: None }
    }

    /// A reborrow of all of them.
    pub fn reborrow(&mut self) -> Rates<'_, V> {
        Rates { force: self.force.reborrow(), power: &mut *self.power, damping: self.damping.as_mut().map(Span::reborrow) }
    }
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
    /// It depends on all others at any distance: found for all at once, in [`Force::prepare`].
    Far,
    /// It depends on everything: found for all at once, in [`Force::prepare`].
    Whole,
}

/// How a force depends on velocity.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum VelocityDependence {
    /// Not at all.
    None,
    /// It turns velocities, and does no work.
    Gyroscopic,
    /// It takes energy out.
    Dissipative,
}

/// At which states a force's part of the bound on the time step is the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Validity {
    /// At all.
    Always,
    /// At every state of which it says so.
    Here,
    /// At none but this.
    Now,
}

/// What is known of a force before it acts.
#[derive(Debug, Clone)]
pub struct About {
    /// Its name in the plan and in the budget: `gravity`.
    pub name: &'static str,
    /// How far it reaches.
    pub reach: Reach,
    /// How it depends on velocity.
    pub velocity: VelocityDependence,
    /// The order in time to which it can be followed, at best.
    pub order: u32,
    /// The name of its potential energy in the budget, if it has one.
    pub potential: Option<&'static str>,
    /// Whether it is a function of the user's, which is called in the order of time.
    pub callback: bool,
    /// About how many springs or other pairs it consists of.
    pub pairs: usize,
    /// The relative rms error of the force in the state at the start; 0 where it is exact.
    pub force_error: f64,
    /// The memory that it takes [bytes].
    pub bytes: usize,
    /// Its layout, for the plan; empty if there is nothing to say.
    pub layout: String,
    /// What else the plan says of it.
    pub remarks: Vec<String>,
    /// What was found when it was last asked for its part of the bound on the time step, for the plan; empty likewise.
    pub findings: String,
}

impl About {
    /// A conservative force without pairs or memory.
    pub fn new(name: &'static str, reach: Reach) -> Self {
        Self {
            name,
            reach,
            velocity: VelocityDependence::None,
            order: u32::MAX,
            potential: Some(name),
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

/// A law that accelerates matter, and its share of the energy budget.
pub trait Force<V: Vector>: History + Send + Sync {
    /// What is known of it before it acts.
    fn about(&self) -> About;

    /// Does what must be done for all particles before any block is asked for.
    ///
    /// # Errors
    /// If that fails.
    fn prepare(&mut self, _at: &StateView<'_, V>, _executor: &Executor) -> Result<()> {
        Ok(())
    }

    /// Adds the force on each particle of `block` and the power that it dissipates or supplies there.
    fn accumulate(&self, _block: Range<usize>, _at: &StateView<'_, V>, _rates: &mut Rates<'_, V>) {}

    /// Adds the charges times the magnetic field, q B, of the particles of `block` to `strength`, for a gyroscopic force F = v × q B.
    fn magnetic(&self, _block: Range<usize>, _at: &StateView<'_, V>, _strength: &mut Strength<V>) {}

    /// The potential energy of the particles of `block` [J]; that of two particles is split between them, or counts at one.
    fn potential(&self, _block: Range<usize>, _at: &StateView<'_, V>) -> f64 {
        0.0
    }

    /// Adds the potential energy of each particle in it [J], counted whole where it is that of a pair.
    fn potentials(&self, at: &StateView<'_, V>, sums: &mut [f64]) {
        (0..at.properties.count()).for_each(|index| sums[index] += self.potential(index..index + 1, at));
    }

    /// Adds its energies to the budget.
    ///
    /// # Errors
    /// If a function of the user's fails, or the executor was asked to stop.
    fn energy(&self, at: &StateView<'_, V>, ledger: &mut Ledger) -> Result<()> {
        if let Some(name) = self.about().potential {
            ledger.add_blocks(Class::Potential, name, |block| self.potential(block, at));
        }
        Ok(())
    }

    /// Leaves out what hangs on edges that are torn, by their ends in ascending order; returns the potential energy that it had [J].
    fn tear(&mut self, _torn: &dyn Fn([u32; 2]) -> bool, _at: &StateView<'_, V>) -> f64 {
        0.0
    }

    /// Adds its stiffness and damping in this state to the bound on the time step. If that is [certified](Horizon::Certified),
    /// it counts what is known to be ahead too.
    ///
    /// # Errors
    /// If a function of the user's fails.
    fn bound(&self, at: &StateView<'_, V>, bound: &mut SpectralBound) -> Result<()>;

    /// At which states its part of that bound is the one of this state.
    fn validity(&self, at: &StateView<'_, V>, horizon: Horizon) -> Validity;

    /// Adds itself to the linear force if it can. It is then not asked to accumulate.
    fn fuse(&self, _properties: &Properties<V>, _fusion: &mut Fusion) -> bool {
        false
    }

    /// Itself as an inverse-square force, if it is one: of the forces that cannot be fused, this one is worth a kernel of its
    /// own, in which independent particles run through whole steps.
    fn inverse_square(&self, _properties: &Properties<V>) -> Option<InverseSquare<'_, V::Scalar>> {
        None
    }

    /// Itself as an electric or magnetic field, if that is one the engine computes and does not change in time.
    fn ready_field(&self) -> Option<ReadyField<'_, V::Scalar>> {
        None
    }

    /// Its derivatives, if it has some.
    fn derivatives(&mut self) -> Option<&mut dyn Derivatives> {
        None
    }

    /// The evolution of density that belongs to it, if there is one.
    fn density(&self) -> Option<&dyn DensityEvolution<V>> {
        None
    }

    /// The same, to advance it.
    fn density_mut(&mut self) -> Option<&mut dyn DensityEvolution<V>> {
        None
    }
}

/// A force that a scene declares, and what it acts on.
struct Declared<'a, V: Vector> {
    scene: &'a Scene,
    item: &'a Item,
    properties: &'a Properties<V>,
    /// Which particles it acts on, in the engine's order.
    chosen: Vec<bool>,
    /// Who may share what takes long.
    executor: &'a Executor,
}

impl<V: Vector> Declared<'_, V> {
    /// The particles that it acts on, in the caller's order.
    fn members(&self) -> Vec<usize> {
        self.properties.engine().into_iter().map(|index| index as usize).filter(|&index| self.chosen[index]).collect()
    }

    /// Which of these particles are not fixed: pointwise forces act on no others, those between pairs count with them.
    fn mobile(&self) -> Vec<bool> {
        self.chosen.iter().enumerate().map(|(index, &chosen)| chosen && !self.properties.is_fixed(index)).collect()
    }

    /// The same as 1 and 0, padded.
    fn mask(&self) -> Vec<V::Scalar> {
        let mut mask = vec![V::Scalar::ZERO; padded(self.chosen.len())];
        mask.iter_mut().zip(self.mobile()).filter(|(_, mobile)| *mobile).for_each(|(slot, _)| *slot = V::Scalar::ONE);
        mask
    }
}

/// The forces that one item declares.
type Forces<V> = Vec<Box<dyn Force<V>>>;

/// A kind of force that a scene can declare.
struct Kind<V: Vector> {
    /// Its name.
    name: &'static str,
    /// How far such a force reaches.
    reach: Reach,
    /// Whether it acts on charges.
    charges: bool,
    /// Builds what an item of this kind declares.
    build: fn(&Declared<'_, V>) -> Result<Forces<V>>,
}

/// The registry.
fn kinds<V: Vector>() -> [Kind<V>; 11] {
    [
        gravity::kind(),
        drag::kind(),
        central::kind(),
        custom::kind(),
        soft_spheres::kind(),
        lennard_jones::kind(),
        all_pairs::gravitation(),
        all_pairs::coulomb(),
        dihedral::kind(),
        electromagnetic::kind(),
        wind::kind(),
    ]
}

/// How far a force of the scene reaches.
fn reach(item: &Item) -> Option<Reach> {
    kinds::<DVec2>().iter().find(|kind| kind.name == item.kind).map(|kind| kind.reach)
}

/// Whether a force of the scene acts on charges.
pub fn feels_charges(item: &Item) -> bool {
    kinds::<DVec2>().iter().any(|kind| kind.name == item.kind && kind.charges)
}

/// Whether a force of the scene passes between particles.
pub fn is_between_pairs(item: &Item) -> bool {
    matches!(reach(item), Some(Reach::Network | Reach::Pairs | Reach::Far))
}

/// Whether any passes between all particles that are near each other.
pub fn are_between_neighbors(scene: &Scene) -> bool {
    sph::is_in(scene) || scene.forces.iter().any(|item| reach(item) == Some(Reach::Pairs))
}

/// The forces that an item of the scene declares.
pub fn build<V: Vector>(scene: &Scene, item: &Item, properties: &Properties<V>, executor: &Executor) -> Result<Forces<V>> {
    let Some(kind) = kinds().into_iter().find(|kind| kind.name == item.kind) else {
        return Err(scene::unknown(item, "a force"));
    };
    let in_scene = scene.members(item);
    let chosen = properties.caller.iter().map(|&caller| in_scene[caller as usize]).collect();
    (kind.build)(&Declared { scene, item, properties, chosen, executor })
}
