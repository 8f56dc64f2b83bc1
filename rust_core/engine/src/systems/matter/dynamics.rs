//! Forces and contacts of matter, sorted by their evaluation.

use std::ops::Range;

use glam::DVec3;

use crate::contacts::Contacts;
use crate::error::{Error, Result};
use crate::forces::Space;
use crate::forces::derivatives::Derivatives;
use crate::forces::linear::{Fusion, LinearForce};
use crate::forces::springs::{self, Spring};
use crate::forces::{
    DensityEvolution, DensityScheme, Drift, ElectromagneticLaw, Force, InverseSquare, Rates, Reach, ReadyField, StateView,
    Strength, VelocityDependence,
};
use crate::ledger::{Class, Ledger};
use crate::math::Real;
use crate::matter::{Columns, EnergySink, Matter, Power, Properties, SINKS, Span, View};
use crate::parallel::{Executor, SERIAL};
use crate::simd::{LANES, padded};
use crate::stability::SpectralBound;
use crate::systems::matter::constraints::rods::{self, Rods};
use crate::systems::matter::constraints::self_contact::{ContactStep, InsidePosition, SelfContacts};
use crate::systems::matter::constraints::tearing::Tearing;

fn is_magnetic<V: Space>(force: &dyn Force<V>) -> bool {
    force.about().velocity == VelocityDependence::Gyroscopic
}

fn state_view<'a, V: Space>(
    properties: &'a Properties<V>,
    matter: &'a Matter<V>,
    time: f64,
    executor: &'a Executor,
) -> StateView<'a, V> {
    let (position, velocity, residual) = (matter.position.view(), matter.velocity.view(), matter.residual.view());
    StateView { position, velocity, residual, properties, time, executor }
}

/// Angle by which a method turns velocities in a magnetic field in a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Angle {
    /// 2 atan(|q B| h/2m).
    Boris,
    /// |q B| h/m.
    Exact,
}

/// Treatment of springs by a method.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Treatment {
    /// Springs are forces.
    Forces,
    /// Springs are forces; springs of infinite stiffness are rods that the method keeps at their lengths.
    Rods,
    /// Springs are forces whose derivatives the method uses to solve its equations.
    Solved,
    /// Springs are projections: the method moves particles onto them, so that they add no force.
    Projections,
}

/// Electric and magnetic field of a scene without other forces.
#[derive(Debug, Clone, Copy)]
pub struct LoneFields<'a, T> {
    pub electric: ElectromagneticLaw,
    pub magnetic: ElectromagneticLaw,
    /// Charges [C]; 0 for particles outside the fields.
    pub charges: &'a [T],
}

/// Forces and contacts of a scene.
pub struct Dynamics<V: Space> {
    /// Mass and other constant properties.
    pub properties: Properties<V>,
    /// Sum of all fused (linear) forces.
    pub linear: LinearForce<V>,
    /// Contact stage, if there are boundaries.
    pub contacts: Option<Contacts<V>>,
    /// Scheme of density, if there is a fluid.
    pub scheme: Option<DensityScheme>,
    /// Whether a force shifts particles.
    pub shifts: bool,
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
    driven: bool,
    /// Treatment of springs by the method.
    pub treatment: Treatment,
    /// Rods, if there are any.
    pub rods: Option<Rods>,
    /// All springs, rods included, as declared. Only with rods, with springs that can break, or for a method that projects or
    /// solves.
    pub springs: Vec<Spring>,
    /// Springs that can break, if there are any.
    pub tearing: Option<Tearing>,
    /// Contacts between meshes, if there are any.
    pub self_contacts: Option<SelfContacts>,
}

/// Velocity that the impulses of contacts between meshes change.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Impulses {
    /// Velocity in a register, with which the step moves; the velocity at the end of the step follows from it.
    Register(usize),
    /// Velocity at the end of the step, with which it moves.
    End,
}

impl<V: Space> Dynamics<V> {
    /// Sorts the forces for blocks of `block` particles.
    pub fn new(properties: Properties<V>, forces: Vec<Box<dyn Force<V>>>, contacts: Option<Contacts<V>>, block: usize) -> Self {
        let mut fusion = Fusion::new(properties.count());
        let (fused, others): (Vec<_>, Vec<_>) = forces.into_iter().partition(|force| force.fuse(&properties, &mut fusion));
        let (pointwise, coupled): (Vec<_>, Vec<_>) =
            others.into_iter().partition(|force| force.about().reach == Reach::Pointwise);
        let (count, together) = (fused.len(), fused.len() + coupled.len());
        let forces: Vec<_> = fused.into_iter().chain(coupled).chain(pointwise).collect();
        let mut densities = forces.iter().filter_map(|force| force.density());
        Self {
            linear: LinearForce::new(&fusion, &properties, block),
            properties,
            contacts,
            scheme: densities.clone().next().map(DensityEvolution::scheme),
            shifts: densities.any(DensityEvolution::shifts),
            velocity: forces.iter().map(|force| force.about().velocity).max().unwrap_or(VelocityDependence::None),
            callbacks: forces.iter().filter(|force| force.about().callback).count(),
            angle: None,
            magnetic: forces.iter().any(|force| is_magnetic(force.as_ref())),
            fused: count,
            together,
            forces,
            driven: false,
            treatment: Treatment::Forces,
            rods: None,
            springs: Vec::new(),
            tearing: None,
            self_contacts: None,
        }
    }

    /// Breaks the springs that are stretched too far; returns whether there are any.
    pub fn tear(&mut self, matter: &Matter<V>) -> bool {
        let torn = self.tearing.as_mut().is_some_and(|tearing| tearing.tear(|index| matter.exact_position(index)));
        if torn {
            let energy = self.leave_out_broken(matter);
            self.tearing.iter_mut().for_each(|tearing| tearing.lose(energy));
        }
        torn
    }

    /// Removes broken springs and the forces that depend on them; returns the energy of these forces [J].
    pub fn leave_out_broken(&mut self, matter: &Matter<V>) -> f64 {
        let Some(tearing) = &self.tearing else { return 0.0 };
        self.springs = tearing.springs();
        let elastic: Vec<Spring> = self.springs.iter().filter(|spring| springs::is_elastic(spring)).copied().collect();
        if let Some(force) = self.forces.iter_mut().find(|force| force.about().name == springs::NAME) {
            *force = V::springs(&elastic, self.properties.count());
        }
        if let Some(contacts) = &mut self.self_contacts {
            contacts.leave_out(tearing.broken());
        }
        let sides = tearing.sides();
        let at = state_view(&self.properties, matter, 0.0, &SERIAL);
        self.forces.iter_mut().map(|force| force.tear(&|ends| sides.contains(&ends), &at)).sum()
    }

    /// Checks that meshes do not pass through each other before the first step.
    pub fn check_self_contacts(&mut self, matter: &Matter<V>, executor: &Executor) -> Result<()> {
        let Some(contacts) = &mut self.self_contacts else { return Ok(()) };
        contacts.check(|index| matter.exact_position(index), executor).map_err(|ends| {
            let [one, other] = ends.map(|end| self.properties.caller[end as usize]);
            let found = format!("the edge between the particles {one} and {other} in a triangle");
            Error::parameter("scene", "bodies with SelfContact that do not pass through each other", found)
        })
    }

    /// Records the state at the start of a step for the contacts between meshes.
    pub fn begin_self_contacts(&mut self, matter: &Matter<V>) {
        if let Some(contacts) = &mut self.self_contacts {
            contacts.begin(|index| [matter.exact_position(index), matter.velocity.get(index).widen()]);
        }
    }

    /// Resolves the contacts between meshes on the path of a step of `h` seconds, whose end positions are reached. Returns
    /// whether there were any.
    pub fn resolve_self_contacts(
        &mut self,
        matter: &mut Matter<V>,
        h: f64,
        impulses: Impulses,
        executor: &Executor,
    ) -> Result<bool> {
        let Some(meshes) = &mut self.self_contacts else { return Ok(false) };
        let (properties, walls) = (&self.properties, &self.contacts);
        let free: Vec<DVec3> =
            (0..matter.count()).map(|index| (matter.exact_position(index) - meshes.start()[index]) / h).collect();
        let mut velocities = free.clone();
        let inside = |index: usize, x: DVec3| {
            let walls = walls.as_ref()?;
            let position = walls.confine(x, properties, index)?;
            let [friction, restitution] = walls.coefficients(x, properties, index)?;
            Some(InsidePosition { position, friction, restitution })
        };
        let touched = meshes.resolve(&mut velocities, ContactStep { h, walls: &inside, executor }).map_err(|unresolved| {
            let index = properties.caller[unresolved.particle] as usize;
            Error::unsolved(
                index,
                "passes through others, whatever impulses act: fixed particles drive it there, or it is too fast",
            )
        })?;
        if !touched {
            return Ok(false);
        }
        let mut losses = Vec::new();
        for (index, (before, after)) in free.iter().zip(&velocities).enumerate() {
            if before == after || properties.is_fixed(index) {
                continue;
            }
            let change = *after - *before;
            let end = meshes.start()[index] + h * *after;
            matter.set_exact_position(index, inside(index, end).map_or(end, |inside| inside.position));
            let end_velocity = matter.velocity.get(index).widen();
            matter.velocity.set(index, V::narrow(end_velocity + change));
            // The impulse acts at the start of the step, on the velocity before half of its kick: particles that rest on
            // others then lose no energy.
            let old = match impulses {
                Impulses::Register(register) => {
                    let middle = &mut matter.registers[register];
                    let way = middle.get(index).widen();
                    middle.set(index, V::narrow(way + change));
                    2.0 * way - end_velocity
                }
                Impulses::End => 0.5 * (meshes.start_velocities()[index] + *before),
            };
            let lost = -properties.mass[index] * change.dot(old + 0.5 * change);
            losses.push((index, lost));
        }
        matter.lose_in_contacts(&losses, self.driven);
        Ok(true)
    }

    /// Updates whether a fixed particle has a velocity.
    pub fn observe(&mut self, velocity: &Columns<V>) {
        let mut fixed = (0..velocity.count()).filter(|&index| self.properties.is_fixed(index));
        self.driven = fixed.any(|index| velocity.get(index) != V::default());
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

    /// Inverse-square force, if it is the only force.
    pub fn lone_inverse_square(&self) -> Option<InverseSquare<'_, V::Scalar>> {
        match self.forces.as_slice() {
            [force] => force.inverse_square(&self.properties),
            _ => None,
        }
    }

    /// Fields E and B, if they are the only forces, and [`super::kernels::gyration_steps`] turns velocities in them. The
    /// engine computes the fields itself, and they do not change in time.
    pub fn lone_fields(&self) -> Option<LoneFields<'_, V::Scalar>> {
        if self.angle != Some(Angle::Boris) {
            return None;
        }
        let none = ElectromagneticLaw::Uniform(DVec3::ZERO);
        match self.forces.as_slice() {
            [magnetic] => {
                let ReadyField { law, charges, is_magnetic } = magnetic.ready_field()?;
                is_magnetic.then_some(LoneFields { electric: none, magnetic: law, charges })
            }
            [electric, magnetic] => {
                let (electric, magnetic) = (electric.ready_field()?, magnetic.ready_field()?);
                let together = std::ptr::eq(electric.charges, magnetic.charges);
                (together && !electric.is_magnetic && magnetic.is_magnetic).then_some(LoneFields {
                    electric: electric.law,
                    magnetic: magnetic.law,
                    charges: magnetic.charges,
                })
            }
            _ => None,
        }
    }

    /// State of a block, or of all matter, at a time.
    pub fn state_view<'a>(&'a self, position: View<'a, V>, velocity: View<'a, V>, time: f64) -> StateView<'a, V> {
        StateView { position, velocity, residual: View::default(), properties: &self.properties, time, executor: &SERIAL }
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
        let at = StateView { position, velocity, residual, properties, time, executor };
        forces[*fused..].iter_mut().try_for_each(|force| force.prepare(&at, executor))
    }

    /// Derivatives of the forces that are not fused, where they have derivatives.
    pub fn derivatives(&mut self) -> impl Iterator<Item = &mut dyn Derivatives> {
        let fused = self.fused;
        self.forces[fused..].iter_mut().filter_map(|force| force.derivatives())
    }

    /// Sums density over the positions at the end of a step without an evaluation of forces.
    pub fn sum_density(&mut self, matter: &Matter<V>, time: f64, executor: &Executor) -> Result<()> {
        let Self { properties, forces, .. } = self;
        let at = state_view(properties, matter, time, executor);
        forces.iter_mut().filter_map(|force| force.density_mut()).try_for_each(|density| density.sum(&at, executor))
    }

    /// Advances density over the drift that led to a state.
    pub fn drift_density(&mut self, matter: &Matter<V>, velocity: View<'_, V>, h: f64, executor: &Executor) -> Result<()> {
        let Self { properties, forces, .. } = self;
        let drift = Drift { end: state_view(properties, matter, 0.0, executor), velocity, h };
        forces.iter_mut().filter_map(|force| force.density_mut()).try_for_each(|density| density.drift(&drift, executor))
    }

    /// Adds the energy that diffusion of density dissipated in the last drift to the sinks of a block [J].
    pub fn diffused(&self, block: &Range<usize>, energy: &mut Power) {
        let densities = self.forces.iter().filter_map(|force| force.density());
        densities.for_each(|density| density.dissipated(block.clone(), energy));
    }

    /// Displacements of the particles of one block by shifting [m].
    pub fn shift(&self, block: &Range<usize>, displacements: &mut Span<'_, V>) {
        for axis in 0..V::DIMENSION {
            displacements.axes[axis].fill(V::Scalar::ZERO);
        }
        let densities = self.forces.iter().filter_map(|force| force.density());
        densities.for_each(|density| density.shift(block.clone(), displacements));
    }

    /// Potential energy of the particles of one block in pointwise forces [J].
    pub fn potential(&self, block: &Range<usize>, at: &StateView<'_, V>) -> f64 {
        let pointwise = self.forces[..self.fused].iter().chain(&self.forces[self.together..]);
        pointwise.map(|force| force.potential(block.clone(), at)).sum()
    }

    /// Potential energy of all particles in user-defined forces [J].
    pub fn potential_of_callbacks(&self, at: &StateView<'_, V>) -> Result<f64> {
        if self.callbacks == 0 {
            return Ok(0.0);
        }
        let mut ledger = Ledger::new(0, 1);
        let mut callbacks = self.forces.iter().filter(|force| force.about().callback);
        callbacks.try_for_each(|force| force.energy(at, &mut ledger))?;
        Ok(ledger.sum(Class::Potential))
    }

    /// Sets the forces and powers of one block to those of all terms that are not fused.
    #[inline]
    pub fn accumulate(&self, block: &Range<usize>, at: &StateView<'_, V>, rates: &mut Rates<'_, V>) {
        for axis in 0..V::DIMENSION {
            rates.force.axes[axis].fill(V::Scalar::ZERO);
            if let Some(damping) = &mut rates.damping {
                damping.axes[axis].fill(V::Scalar::ZERO);
            }
        }
        let turned = self.magnetic && self.angle.is_some();
        let acting =
            |forces: Range<usize>| self.forces[forces].iter().filter(move |force| !turned || !is_magnetic(force.as_ref()));
        // For a method that projects, springs are the only forces between particles.
        for force in acting(self.fused..if self.treatment == Treatment::Projections { self.fused } else { self.together }) {
            force.accumulate(block.clone(), at, rates);
        }
        if self.driven {
            self.count_reactions(block, at, rates);
        }
        for force in acting(self.together..self.forces.len()) {
            force.accumulate(block.clone(), at, rates);
        }
    }

    /// Adds the powers of springs that dissipate or do work on fixed particles, for a method that projects springs.
    pub fn spring_power(&self, block: &Range<usize>, at: &StateView<'_, V>, rates: &mut Rates<'_, V>) {
        if !self.driven && self.velocity == VelocityDependence::None {
            return;
        }
        (0..V::DIMENSION).for_each(|axis| rates.force.axes[axis].fill(V::Scalar::ZERO));
        self.forces[self.fused..self.together].iter().for_each(|force| force.accumulate(block.clone(), at, rates));
        if self.driven {
            self.count_reactions(block, at, rates);
        }
    }

    /// Adds q B of all magnetic fields at the particles of a range to `strength`.
    pub fn magnetic(&self, range: Range<usize>, at: &StateView<'_, V>, strength: &mut Strength<V>) {
        let fields = self.forces.iter().filter(|force| is_magnetic(force.as_ref()));
        fields.for_each(|force| force.magnetic(range.clone(), at, strength));
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

    /// Kinetic energy of a kick of `h` seconds from rest [J], Σ ½ m |a|² h²: the smallest energy that steps of `h` can
    /// resolve.
    pub fn kick(&self, at: &StateView<'_, V>, h: f64) -> f64 {
        let accelerations = self.accelerations(at).enumerate().filter(|&(index, _)| !self.properties.is_fixed(index));
        accelerations.map(|(index, a)| 0.5 * self.properties.mass[index] * a.widen().length_squared() * h * h).sum()
    }

    /// Acceleration of every particle at a state [m/s²].
    pub fn accelerations<'a>(&'a self, at: &'a StateView<'_, V>) -> impl Iterator<Item = V> + 'a {
        let count = self.properties.count();
        let mut force = Columns::<V>::zeros(count);
        let mut power = [[0.0; LANES]; SINKS];
        self.accumulate(&(0..padded(count)), at, &mut Rates::new(force.span(), &mut power));
        (0..count).map(move |index| {
            let inverse_mass = self.properties.inverse_mass[index];
            V::from_axes(|axis| {
                let (x, v) = (at.position.axis(axis)[index], at.velocity.axis(axis)[index]);
                force.axis(axis)[index] * inverse_mass + self.linear.acceleration(axis, index, x, v)
            })
        })
    }

    /// Adds the power −F·v of the constraint of every fixed particle with velocity v, against the forces F of its partners.
    fn count_reactions(&self, block: &Range<usize>, at: &StateView<'_, V>, rates: &mut Rates<'_, V>) {
        for index in block.start..block.end.min(self.properties.count()) {
            if self.properties.is_fixed(index) {
                let force = rates.force.get(index - block.start).widen();
                rates.power[EnergySink::Work as usize][index % LANES] -= force.dot(at.velocity.get(index).widen());
            }
        }
    }

    /// Tensions of all rods [N] at a state with these accelerations by all other forces.
    fn tensions(&self, at: &StateView<'_, V>, accelerations: &[DVec3]) -> Vec<f64> {
        let (position, velocity) = (|index| at.exact_point(index), |index: usize| at.velocity.get(index).widen());
        let walls = self.contacts.as_ref().map(|contacts| (contacts, &self.properties));
        self.rods.clone().map_or_else(Vec::new, |rods| rods.tensions(position, velocity, |index| accelerations[index], walls))
    }

    /// Tensions of all springs and rods [N], as declared, at a state at which the forces are prepared. The tension of a
    /// spring is k (l − l₀) + c l̇.
    pub fn tensions_of_springs(&self, at: &StateView<'_, V>) -> Vec<f64> {
        let accelerations: Vec<DVec3> = self.accelerations(at).map(V::widen).collect();
        let of = |spring: &Spring| -> f64 {
            let [one, other] = spring.ends.map(|end| end as usize);
            let offset = at.exact_point(other) - at.exact_point(one);
            let rate = offset.normalize_or_zero().dot(at.velocity.get(other).widen() - at.velocity.get(one).widen());
            spring.stiffness * (offset.length() - spring.rest_length) + spring.damping * rate
        };
        // A rod between two fixed particles bears no load.
        let mut tensions: Vec<f64> =
            self.springs.iter().map(|spring| if rods::is_rod(spring) { 0.0 } else { of(spring) }).collect();
        if let Some(rods) = &self.rods {
            rods.springs()
                .iter()
                .zip(self.tensions(at, &accelerations))
                .for_each(|(&spring, tension)| tensions[spring] = tension);
        }
        tensions
    }

    /// Adds the terms of these particles to a bound on the time step, at a state.
    pub fn bound(&self, at: &StateView<'_, V>, mut bound: SpectralBound) -> Result<SpectralBound> {
        let explicit = |index: usize| self.treatment != Treatment::Projections || !(self.fused..self.together).contains(&index);
        let mut forces = self.forces.iter().enumerate().filter(|&(index, _)| explicit(index));
        forces.try_for_each(|(_, force)| force.bound(at, &mut bound))?;
        if let Some(rods) = &self.rods {
            let accelerations: Vec<DVec3> = self.accelerations(at).map(V::widen).collect();
            let velocity = |index: usize| at.velocity.get(index).widen();
            rods.bound(&self.tensions(at, &accelerations), velocity, |index| accelerations[index], &mut bound);
        }
        Ok(bound)
    }

    /// Approximate number of springs and other pairs.
    pub fn pairs(&self) -> usize {
        self.forces.iter().map(|force| force.about().pairs).sum()
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        let contacts = self.contacts.as_ref().map_or(0, Contacts::bytes);
        let rods = self.rods.as_ref().map_or(0, Rods::bytes) + size_of_val(self.springs.as_slice());
        let tearing = self.tearing.as_ref().map_or(0, Tearing::bytes);
        let meshes = self.self_contacts.as_ref().map_or(0, SelfContacts::bytes);
        self.linear.bytes()
            + contacts
            + rods
            + tearing
            + meshes
            + self.forces.iter().map(|force| force.about().bytes).sum::<usize>()
    }
}
