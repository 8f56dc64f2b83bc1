//! Forces and contacts of matter, sorted by their evaluation.

mod fluid;
mod lone;
mod sums;

use crate::catalog::{Catalog, Space};
use crate::contacts::Contacts;
use crate::error::Result;
use crate::forces::derivatives::Derivatives;
use crate::forces::linear::{Fusion, LinearForce};
use crate::forces::springs::{self, Spring};
use crate::forces::{DensityScheme, FluidScheme, Force, Reach, StateView, VelocityDependence};
use crate::matter::{Columns, Matter, Properties, View};
use crate::parallel::{Executor, SERIAL};
use crate::stability::SpectralBound;
use crate::systems::matter::constraints::Breakage;
use crate::systems::matter::methods::{Angle, Treatment};

pub use lone::LoneFields;
use sums::is_magnetic;

fn state_view<'a, V: Space>(
    properties: &'a Properties<V>,
    matter: &'a Matter<V>,
    time: f64,
    executor: &'a Executor,
) -> StateView<'a, V> {
    let (position, velocity, residual) = (matter.position.view(), matter.velocity.view(), matter.residual.view());
    StateView { position, velocity, residual, properties, solids: &matter.solids, time, executor }
}

/// Forces and contacts of a scene.
pub struct Dynamics<V: Space> {
    /// Laws that scenes can declare.
    pub catalog: Catalog,
    /// Mass and other constant properties.
    pub properties: Properties<V>,
    /// Sum of all fused (linear) forces.
    pub linear: LinearForce<V>,
    /// Contact stage, if there are boundaries.
    pub contacts: Option<Contacts<V>>,
    /// Scheme of density, if there is a fluid.
    pub scheme: Option<DensityScheme>,
    /// Dependence of the forces on velocity.
    pub velocity: VelocityDependence,
    /// Number of user-defined forces.
    pub callbacks: usize,
    /// All forces, fused ones first, then in the order in which they accumulate.
    forces: Vec<Box<dyn Force<V>>>,
    /// Number of fused forces.
    fused: usize,
    /// Number of fused forces and forces between particles; the others are pointwise.
    together: usize,
    /// Angle by which the integrator turns velocities in magnetic fields; None if it does not. Fields that turn velocities
    /// add no force.
    pub angle: Option<Angle>,
    /// Whether there is a magnetic field.
    pub magnetic: bool,
    /// Whether a fixed particle has a velocity, so that its constraint force does work.
    pub driven: bool,
    /// Treatment of springs by the method.
    pub treatment: Treatment,
    /// All springs, rods included, as declared; broken ones have no stiffness. Only for a method that projects or solves.
    pub springs: Vec<Spring>,
}

impl<V: Space> Dynamics<V> {
    /// Sorts the forces for blocks of `block` particles.
    pub fn new(
        catalog: Catalog,
        properties: Properties<V>,
        forces: Vec<Box<dyn Force<V>>>,
        contacts: Option<Contacts<V>>,
        block: usize,
    ) -> Self {
        let mut fusion = Fusion::new(properties.count());
        let (fused, others): (Vec<_>, Vec<_>) = forces.into_iter().partition(|force| force.fuse(&properties, &mut fusion));
        let (pointwise, coupled): (Vec<_>, Vec<_>) =
            others.into_iter().partition(|force| force.about().reach == Reach::Pointwise);
        let (count, together) = (fused.len(), fused.len() + coupled.len());
        let forces: Vec<_> = fused.into_iter().chain(coupled).chain(pointwise).collect();
        Self {
            catalog,
            linear: LinearForce::new(&fusion, &properties, block),
            properties,
            contacts,
            scheme: forces.iter().find_map(|force| force.fluid()).map(FluidScheme::density),
            velocity: forces.iter().map(|force| force.about().velocity).max().unwrap_or(VelocityDependence::None),
            callbacks: forces.iter().filter(|force| force.about().callback).count(),
            angle: None,
            magnetic: forces.iter().any(|force| is_magnetic(force.as_ref())),
            fused: count,
            together,
            forces,
            driven: false,
            treatment: Treatment::Forces,
            springs: Vec::new(),
        }
    }

    /// Removes broken springs and the forces that depend on them; returns the energy of these forces [J].
    pub fn leave_out(&mut self, breakage: &Breakage, matter: &Matter<V>) -> f64 {
        if !self.springs.is_empty() {
            self.springs.clone_from(&breakage.springs);
        }
        let elastic: Vec<Spring> = breakage.springs.iter().filter(|spring| springs::is_elastic(spring)).copied().collect();
        if let Some(force) = self.forces.iter_mut().find(|force| force.about().name == springs::NAME) {
            *force = V::forces(self.catalog).springs(&elastic, self.properties.count());
        }
        let at = state_view(&self.properties, matter, 0.0, &SERIAL);
        self.forces.iter_mut().map(|force| force.tear(&|ends| breakage.sides.contains(&ends), &at)).sum()
    }

    /// Updates whether a fixed particle has a velocity.
    pub fn observe(&mut self, velocity: &Columns<V>) {
        let mut fixed = (0..velocity.count()).filter(|&index| self.properties.is_fixed(index));
        self.driven = fixed.any(|index| velocity.get(index) != V::default());
    }

    /// Whether forces depend on velocities, or their powers may.
    pub fn needs_velocities(&self) -> bool {
        self.velocity != VelocityDependence::None || self.callbacks > 0
    }

    /// All forces.
    pub fn forces(&self) -> &[Box<dyn Force<V>>] {
        &self.forces
    }

    /// All forces, mutable.
    pub fn forces_mut(&mut self) -> &mut [Box<dyn Force<V>>] {
        &mut self.forces
    }

    /// Whether the particles are independent: no force acts between them.
    pub fn is_independent(&self) -> bool {
        self.fused == self.together && self.callbacks == 0
    }

    /// Whether all forces are fused.
    pub fn is_fused(&self) -> bool {
        self.fused == self.forces.len()
    }

    /// State of a block, or of all matter, at a time.
    pub fn state_view<'a>(&'a self, position: View<'a, V>, velocity: View<'a, V>, time: f64) -> StateView<'a, V> {
        let (residual, properties) = (View::default(), &self.properties);
        StateView { position, velocity, residual, properties, solids: &[], time, executor: &SERIAL }
    }

    /// State of all matter at a time.
    pub fn view_of<'a>(&'a self, matter: &'a Matter<V>, time: f64, executor: &'a Executor) -> StateView<'a, V> {
        state_view(&self.properties, matter, time, executor)
    }

    /// Prepares every force for all particles.
    pub fn prepare(&mut self, matter: &Matter<V>, time: f64, executor: &Executor) -> Result<()> {
        let Self { properties, forces, fused, .. } = self;
        let at = state_view(properties, matter, time, executor);
        forces[*fused..].iter_mut().try_for_each(|force| force.prepare(&at, executor))
    }

    /// Prepares every force for all particles, at positions and velocities of a stage of a step.
    pub fn prepare_at(&mut self, [position, velocity]: [&Columns<V>; 2], time: f64, executor: &Executor) -> Result<()> {
        let Self { properties, forces, fused, .. } = self;
        let (position, velocity, residual) = (position.view(), velocity.view(), View::default());
        let at = StateView { position, velocity, residual, properties, solids: &[], time, executor };
        forces[*fused..].iter_mut().try_for_each(|force| force.prepare(&at, executor))
    }

    /// Derivatives of the forces that are not fused, where they have derivatives.
    pub fn derivatives(&mut self) -> impl Iterator<Item = &mut dyn Derivatives> {
        let fused = self.fused;
        self.forces[fused..].iter_mut().filter_map(|force| force.derivatives())
    }

    /// Whether springs are damped.
    pub fn damps_springs(&self) -> bool {
        let mut springs = self.forces.iter().map(|force| force.about()).filter(|about| about.name == springs::NAME);
        springs.any(|about| about.velocity == VelocityDependence::Dissipative)
    }

    /// Whether there are fused forces.
    pub fn has_linear(&self) -> bool {
        self.fused > 0
    }

    /// Adds the terms of the forces to a bound on the time step, at a state.
    pub fn bound(&self, at: &StateView<'_, V>, bound: &mut SpectralBound) -> Result<()> {
        let explicit = |index: usize| self.treatment != Treatment::Projections || !(self.fused..self.together).contains(&index);
        let mut forces = self.forces.iter().enumerate().filter(|&(index, _)| explicit(index));
        forces.try_for_each(|(_, force)| force.bound(at, bound))
    }

    /// Approximate number of springs and other pairs.
    pub fn pairs(&self) -> usize {
        self.forces.iter().map(|force| force.about().pairs).sum()
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        let contacts = self.contacts.as_ref().map_or(0, Contacts::bytes);
        let forces: usize = self.forces.iter().map(|force| force.about().bytes).sum();
        self.linear.bytes() + contacts + forces + size_of_val(self.springs.as_slice())
    }
}
