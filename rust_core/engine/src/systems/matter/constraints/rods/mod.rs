//! Rods: connections of constant length, the holonomic constraints g = |r| − L = 0 of a network.
//!
//! A rod acts by an impulse λ along its direction n = r/|r|, equal and opposite at both ends. The impulses that cancel a
//! residual of every rod solve A λ = residual with A = J M⁻¹ Jᵀ, where J has the rows (−n, n). A is a sparse matrix: it
//! couples two rods that meet in a particle. A is factorized, so that a network converges in as few iterations as a single
//! rod, whatever the order of the rods.
//!
//! With redundant rods A is singular. The iterations then use A + ε 1 and evaluate the residuals anew. Multipliers converge
//! to those of least norm (M. R. Hestenes, J. Optim. Theory Appl. 4, 303 (1969): proximal iterations from zero remain in the
//! range of A).

mod declaration;
mod network;
mod supports;

use glam::DVec3;

use super::{Breakage, ConstrainedStep, Constraint, ConstraintProperties, ConstraintStage, ForcedState};
use crate::catalog::Space;
use crate::error::{Error, Result};
use crate::forces::springs::Spring;
use crate::history::{Archive, History};
use crate::math::{Real, Vector};
use crate::matter::{EnergySink, Matter};
use crate::parallel::{Executor, SERIAL};
use crate::stability::SpectralBound;
use crate::systems::{FieldInfo, Location};
use network::{Network, Rod, Unsolved};
use supports::{RodWalls, Supports};

/// Shift ε of A relative to its largest entry, for projections.
const SHIFT: f64 = 1e-10;
/// Shift ε of A relative to its largest entry, for tensions; those of redundant rods have rounding errors over ε.
const SHIFT_OF_TENSIONS: f64 = 1e-7;
/// Largest accurate angle by which a rod turns in a step [rad]; an angle of 1 may have no solution.
const LARGEST_ANGLE: f64 = 0.5;
/// Relative deviation from the length L above which the ends of a rod are refused; coordinates may be in single precision.
const DEVIATION: f64 = 1e-4;

/// All rods of a scene, with the factorization of A at the positions of the last [`Rods::turn`].
#[derive(Debug, Clone)]
pub struct Rods {
    network: Network,
    /// Contacts of the rods with walls, if there are any.
    supports: Option<Supports>,
    /// All springs, rods included, as declared; broken ones have no stiffness.
    all: Vec<Spring>,
    /// Index of each rod in the declared springs.
    springs: Vec<usize>,
    /// Particles at the ends of the rods.
    particles: Vec<u32>,
    /// Kinetic energy of velocities along rods in the given states [J].
    removed: f64,
    /// Whether A is factorized at the present positions.
    turned: bool,
}

/// Whether a spring is a rod.
pub fn is_rod(spring: &Spring) -> bool {
    spring.stiffness.is_infinite()
}

impl Rods {
    /// Sets the directions of the rods at the present positions, and factorizes A for projections.
    fn turn_to<V: Vector>(&mut self, matter: &Matter<V>, executor: &Executor) {
        self.turn(SHIFT, |index| matter.exact_position(index), executor);
        self.turned = true;
    }

    fn turn(&mut self, shift: f64, position: impl Fn(usize) -> DVec3, executor: &Executor) {
        let Network { directions, links, .. } = &mut self.network;
        for (direction, rod) in directions.iter_mut().zip(links.iter()) {
            let [one, other] = rod.ends.map(|end| position(self.particles[end as usize] as usize));
            *direction = (other - one).normalize_or_zero();
        }
        self.network.factorize(shift, executor);
    }

    /// Moves particles along the directions until all rods have their lengths, after the drift of a step.
    ///
    /// # Errors
    /// If the iterations do not converge.
    fn hold_positions<V: Space>(&mut self, step: &mut ConstrainedStep<'_, V>) -> std::result::Result<(), Unsolved> {
        let epsilon = resolution::<V>();
        for (vector, &particle) in self.network.vectors.iter_mut().zip(&self.particles) {
            *vector = step.matter.exact_position(particle as usize);
        }
        let length = |_: usize, rod: &Rod, _: DVec3, ends: [DVec3; 2]| rod.excess(ends, epsilon);
        self.network.project(length, step.executor).map_err(|unsolved| self.located(unsolved))?;
        for ((&vector, &change), &particle) in self.network.vectors.iter().zip(&self.network.changes).zip(&self.particles) {
            // From the change: the rounding of positions would be divided by h.
            step.pull(particle as usize, change);
            step.matter.set_exact_position(particle as usize, vector);
        }
        if step.h > 0.0 {
            count_reactions(&self.network, self.springs.len(), &self.particles, step.matter, 1.0 / step.h);
        }
        Ok(())
    }

    /// Keeps particles outside walls; follows [`Rods::hold_positions`].
    ///
    /// # Errors
    /// If rods and walls contradict each other.
    fn hold_gaps<V: Space>(&mut self, step: &mut ConstrainedStep<'_, V>) -> std::result::Result<(), Unsolved> {
        let (Some(supports), Some(contacts)) = (&mut self.supports, step.walls) else { return Ok(()) };
        let walls = RodWalls { contacts, properties: step.properties, particles: &self.particles };
        let held = supports.hold_positions(step, &walls, &self.network.directions);
        held.map_err(|unsolved| self.located(unsolved))
    }

    /// Removes velocities along rods and into walls at the end of a step.
    ///
    /// # Errors
    /// If rods and walls contradict each other.
    fn hold_velocities_at_walls<V: Space>(&mut self, step: &mut ConstrainedStep<'_, V>) -> std::result::Result<(), Unsolved> {
        let touches = match (&mut self.supports, step.walls) {
            (Some(supports), Some(contacts)) => {
                let walls = RodWalls { contacts, properties: step.properties, particles: &self.particles };
                supports.hold_velocities(step, &walls, &self.network.directions)
            }
            _ => Ok(false),
        };
        if touches.map_err(|unsolved| self.located(unsolved))? {
            Ok(())
        } else {
            self.hold_velocities(step.matter, step.executor)
        }
    }

    /// Removes velocities along rods from a state. A is factorized at its positions.
    ///
    /// # Errors
    /// If the iterations do not converge.
    fn hold_velocities<V: Vector>(&mut self, matter: &mut Matter<V>, executor: &Executor) -> std::result::Result<(), Unsolved> {
        let epsilon = V::Scalar::EPSILON.to_f64();
        for (vector, &particle) in self.network.vectors.iter_mut().zip(&self.particles) {
            *vector = matter.velocity.get(particle as usize).widen();
        }
        let along = |_: usize, _: &Rod, direction: DVec3, ends: [DVec3; 2]| network::along(direction, ends, epsilon);
        self.network.project(along, executor).map_err(|unsolved| self.located(unsolved))?;
        for (&vector, &particle) in self.network.vectors.iter().zip(&self.particles) {
            matter.velocity.set(particle as usize, V::narrow(vector));
        }
        count_reactions(&self.network, self.springs.len(), &self.particles, matter, 1.0);
        Ok(())
    }

    /// Kinetic energy of the particles at the ends of rods [J].
    fn kinetic<V: Vector>(&self, matter: &Matter<V>) -> f64 {
        let of = |(&particle, &inverse): (&u32, &f64)| matter.velocity.get(particle as usize).widen().length_squared() / inverse;
        self.particles.iter().zip(&self.network.inverse_mass).filter(|(_, inverse)| **inverse > 0.0).map(of).sum::<f64>() / 2.0
    }

    /// Tensions T [N] in the order of the rods: n·(a₂ − a₁) + |v₂ − v₁|²/L − (A T) = 0, with the accelerations a by all other
    /// forces. Reactions of walls on particles that touch them are included.
    fn tensions<V: Space>(mut self, state: &ForcedState<'_, V>, accelerations: &[DVec3]) -> Vec<f64> {
        let position = |index: usize| state.at.exact_point(index);
        let velocity = |index: usize| state.at.velocity.get(index).widen();
        let acceleration = |index: usize| accelerations[index];
        self.turn(SHIFT_OF_TENSIONS, position, &SERIAL);
        for (vector, &particle) in self.network.vectors.iter_mut().zip(&self.particles) {
            *vector = acceleration(particle as usize);
        }
        let centripetal: Vec<f64> = self
            .network
            .links
            .iter()
            .map(|rod| {
                let [one, other] = rod.ends.map(|end| velocity(self.particles[end as usize] as usize));
                (other - one).length_squared() / rod.length
            })
            .collect();
        let along = |index: usize, _: &Rod, direction: DVec3, [one, other]: [DVec3; 2]| {
            let turning = centripetal[index];
            (direction.dot(other - one) + turning, 2.0 * f64::EPSILON * (one.length() + other.length() + turning))
        };
        if let (Some(supports), Some(contacts)) = (&mut self.supports, state.walls) {
            let walls = RodWalls { contacts, properties: state.at.properties, particles: &self.particles };
            let state = |index: usize| [position(index), velocity(index), acceleration(index)];
            if let Some(tensions) = supports.tensions(&walls, &self.network.directions, state, along) {
                return tensions;
            }
        }
        // If the iterations stop above rounding, the multipliers are those of the last one.
        let _ = self.network.project(along, &SERIAL);
        self.network.multipliers
    }

    /// Converts the particle's index to the engine's order.
    fn located(&self, unsolved: Unsolved) -> Unsolved {
        Unsolved { particle: self.particles[unsolved.particle] as usize, ..unsolved }
    }
}

/// Error of a step whose rods have no solution, or an interrupt, after which a projection has no meaning.
fn held<V: Space>(outcome: std::result::Result<(), Unsolved>, step: &ConstrainedStep<'_, V>) -> Result<()> {
    step.executor.check()?;
    let Err(Unsolved { particle, residual }) = outcome else { return Ok(()) };
    let index = step.properties.caller[particle] as usize;
    let cause = format!(
        "does not satisfy its rods: they turn too far within a step, or walls leave them no room, and a residual of {residual:.1e} rounding errors is left"
    );
    Err(Error::unsolved(index, cause))
}

/// History: none. After a rollback or a restoration, the directions belong to another state.
impl History for Rods {
    fn rollback(&mut self) {
        self.turned = false;
    }

    fn restore(&mut self, _archive: &mut Archive) -> Result<()> {
        self.turned = false;
        Ok(())
    }
}

impl<V: Space> Constraint<V> for Rods {
    fn about(&self) -> ConstraintProperties {
        ConstraintProperties {
            name: "rods",
            stages: vec![ConstraintStage { name: "rods", note: None, last: true }],
            // Contacts with walls within a step are resolved together, whenever they are.
            order: if self.supports.is_some() { 1 } else { u32::MAX },
            varies: true,
            exact: true,
            iterates: false,
            cost: self.network.cost(),
        }
    }

    fn bytes(&self) -> usize {
        let supports = self.supports.as_ref().map_or(0, Supports::bytes);
        self.network.bytes() + supports + size_of_val(self.particles.as_slice()) + size_of_val(self.all.as_slice())
    }

    fn notes(&self) -> Vec<String> {
        let (count, redundant) = (self.network.links.len(), self.network.redundant);
        let redundant = (redundant > 0).then(|| {
            format!("rods: {redundant} of {count} are redundant; redundant rods share the load so that the sum of squares of tensions is least")
        });
        let removed = (self.removed > 0.0).then(|| {
            format!(
                "rods: {:.3e} J of the kinetic energy that was given were velocities along rods, which they do not allow",
                self.removed
            )
        });
        redundant.into_iter().chain(removed).collect()
    }

    /// Moves the particles onto the constraints, and removes velocities along rods.
    fn initialize(&mut self, step: &mut ConstrainedStep<'_, V>) -> Result<()> {
        for (rod, &spring) in self.network.links.iter().zip(&self.springs) {
            let [one, other] = rod.ends.map(|end| step.matter.exact_position(self.particles[end as usize] as usize));
            let found = (other - one).length();
            if (found - rod.length).abs() > DEVIATION * rod.length {
                let expected = format!("ends of rod {spring} that are {} m apart", rod.length);
                return Err(Error::parameter("set.positions", expected, format!("{found} m")));
            }
        }
        let unsolved = |unsolved: Unsolved| {
            Error::parameter(
                "set.positions",
                "ends of rods at their lengths",
                format!("rods at particle {} that contradict", unsolved.particle),
            )
        };
        self.turn_to(step.matter, step.executor);
        self.hold_positions(step).map_err(unsolved)?;
        let before = self.kinetic(step.matter);
        self.turn_to(step.matter, step.executor);
        self.hold_velocities(step.matter, step.executor).map_err(unsolved)?;
        let removed = before - self.kinetic(step.matter);
        if removed > 1e-9 * before {
            self.removed += removed;
        }
        Ok(())
    }

    fn begin(&mut self, step: &ConstrainedStep<'_, V>) {
        if let Some(supports) = &mut self.supports {
            supports.start(&self.particles, step.matter);
        }
        if !self.turned {
            self.turn_to(step.matter, step.executor);
        }
    }

    fn positions(&mut self, step: &mut ConstrainedStep<'_, V>) -> Result<bool> {
        let outcome = self.hold_positions(step);
        held(outcome, step)?;
        let outcome = self.hold_gaps(step);
        held(outcome, step)?;
        Ok(true)
    }

    fn velocities(&mut self, step: &mut ConstrainedStep<'_, V>) -> Result<()> {
        self.turn_to(step.matter, step.executor);
        let outcome = self.hold_velocities_at_walls(step);
        held(outcome, step)
    }

    /// Adds the rods to the bound on the time step. Transverse waves of tense chains have the stiffness T/L. A rod turns at
    /// the rate ω = |Δv|/L; a step of more than 1/ω may leave it without a solution. Before the rod turns, √(|Δa|/L) stands
    /// for ω.
    fn bound(&self, state: &ForcedState<'_, V>, bound: &mut SpectralBound) {
        let accelerations = (state.accelerations)();
        let tensions = self.clone().tensions(state, &accelerations);
        let velocity = |index: usize| state.at.velocity.get(index).widen();
        for (rod, tension) in self.network.links.iter().zip(tensions) {
            let [one, other] = rod.ends.map(|end| self.particles[end as usize] as usize);
            let weights = rod.ends.map(|end| self.network.inverse_mass[end as usize]);
            let rate = (velocity(other) - velocity(one)).length() / rod.length;
            let onset = (accelerations[other] - accelerations[one]).length() / rod.length;
            let fastest = rate.max(onset.sqrt());
            if fastest > 0.0 {
                bound.accuracy("rods", LARGEST_ANGLE / fastest);
            }
            let stiffness = tension.abs() / rod.length;
            // By Gershgorin's theorem the bound has twice the stiffness, unless the other end is fixed.
            for (end, partner) in [(one, weights[1]), (other, weights[0])] {
                bound.point(end, "rods", if partner > 0.0 { 2.0 } else { 1.0 } * stiffness, 0.0);
            }
        }
    }

    fn fields(&self) -> Vec<FieldInfo> {
        vec![FieldInfo {
            name: "tensions".to_owned(),
            unit: "N",
            location: Location::Springs,
            shape: vec![self.all.len()],
            rate: None,
            state: false,
        }]
    }

    /// Tensions of all springs and rods [N], as declared. The tension of a spring is k (l − l₀) + c l̇. A rod between two
    /// fixed particles bears no load.
    fn read(&self, _field: usize, state: &ForcedState<'_, V>) -> Vec<f64> {
        let of = |spring: &Spring| -> f64 {
            let [one, other] = spring.ends.map(|end| end as usize);
            let offset = state.at.exact_point(other) - state.at.exact_point(one);
            let rate = offset.normalize_or_zero().dot(state.at.velocity.get(other).widen() - state.at.velocity.get(one).widen());
            spring.stiffness * (offset.length() - spring.rest_length) + spring.damping * rate
        };
        let mut tensions: Vec<f64> = self.all.iter().map(|spring| if is_rod(spring) { 0.0 } else { of(spring) }).collect();
        let held = self.clone().tensions(state, &(state.accelerations)());
        self.springs.iter().zip(held).for_each(|(&spring, tension)| tensions[spring] = tension);
        tensions
    }

    fn leave_out(&mut self, breakage: &Breakage) {
        self.all.clone_from(&breakage.springs);
    }
}

/// Tallies the work of moving fixed particles on the first `rods` of a network. The impulses are `scale` λ of the last
/// projection [N·s].
fn count_reactions<V: Vector>(network: &Network, rods: usize, particles: &[u32], matter: &mut Matter<V>, scale: f64) {
    for (index, rod) in network.links[..rods].iter().enumerate() {
        for (end, sign) in rod.ends.into_iter().zip([1.0, -1.0]) {
            if network.inverse_mass[end as usize] == 0.0 {
                let particle = particles[end as usize] as usize;
                let along = network.directions[index].dot(matter.velocity.get(particle).widen());
                let tally = &mut matter.tallies[particle / matter.block];
                tally.add(EnergySink::Work, -sign * scale * network.multipliers[index] * along);
            }
        }
    }
}

/// Relative rounding error of positions.
fn resolution<V: Vector>() -> f64 {
    let epsilon = V::Scalar::EPSILON.to_f64();
    // Single precision also keeps a low-order part.
    f64::EPSILON.max(epsilon * epsilon)
}
