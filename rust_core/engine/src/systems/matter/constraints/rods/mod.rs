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

mod network;
mod supports;

use glam::DVec3;

use crate::contacts::Contacts;
use crate::error::Error;
use crate::forces::springs::Spring;
use crate::math::{Real, Vector};
use crate::matter::{EnergySink, Matter, Properties};
use crate::parallel::{Executor, SERIAL};
use crate::stability::SpectralBound;
use network::{Network, Rod};

use supports::{RodWalls, Supports};

pub use network::Unsolved;

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
    /// Index of each rod in the declared springs.
    springs: Vec<usize>,
    /// Particles at the ends of the rods.
    particles: Vec<u32>,
    /// Kinetic energy of velocities along rods in the given states [J].
    removed: f64,
}

/// Whether a spring is a rod.
pub fn is_rod(spring: &Spring) -> bool {
    spring.stiffness.is_infinite()
}

impl Rods {
    /// Selects the rods among springs; None if there are none. Ends of springs are indices in the engine's order. Rods
    /// between two fixed particles constrain nothing and are left out.
    ///
    /// # Errors
    /// If the equations do not fit into memory, or on an interrupt.
    pub fn new<V: Vector>(springs: &[Spring], properties: &Properties<V>, executor: &Executor) -> Result<Option<Self>, Error> {
        let free = |spring: &Spring| spring.ends.iter().any(|&end| !properties.is_fixed(end as usize));
        let chosen: Vec<usize> = (0..springs.len()).filter(|&index| is_rod(&springs[index]) && free(&springs[index])).collect();
        if chosen.is_empty() {
            return Ok(None);
        }
        let mut particles: Vec<u32> = chosen.iter().flat_map(|&index| springs[index].ends).collect();
        particles.sort_unstable();
        particles.dedup();
        let local = |particle: u32| particles.partition_point(|&other| other < particle) as u32;
        let links: Vec<Rod> = chosen
            .iter()
            .map(|&index| Rod { ends: springs[index].ends.map(local), length: springs[index].rest_length })
            .collect();
        let inverse_mass: Vec<f64> = particles.iter().map(|&particle| 1.0 / properties.mass[particle as usize]).collect();
        let network = Network::new(links, inverse_mass, executor)?;
        Ok(Some(Self { network, supports: None, springs: chosen, particles, removed: 0.0 }))
    }

    /// Enables contacts with walls, in a space of `axes` dimensions.
    ///
    /// # Errors
    /// If the equations do not fit into memory, or on an interrupt.
    pub fn meet_walls(&mut self, axes: usize, executor: &Executor) -> Result<(), Error> {
        self.supports = Some(Supports::new(&self.network, axes, executor)?);
        Ok(())
    }

    /// Particles at the ends of the rods, in the engine's order.
    pub fn particles(&self) -> &[u32] {
        &self.particles
    }

    /// Records the state at the start of a step.
    pub fn start<V: Vector>(&mut self, matter: &Matter<V>) {
        if let Some(supports) = &mut self.supports {
            supports.start(&self.particles, matter);
        }
    }

    /// Keeps particles outside walls; follows [`Rods::hold_positions`] for the same drift.
    ///
    /// # Errors
    /// If rods and walls contradict each other.
    pub fn hold_gaps<V: Vector>(
        &mut self,
        matter: &mut Matter<V>,
        (contacts, properties): (&Contacts<V>, &Properties<V>),
        drift: (f64, usize),
        executor: &Executor,
    ) -> Result<(), Unsolved> {
        let Some(supports) = &mut self.supports else { return Ok(()) };
        let walls = RodWalls { contacts, properties, particles: &self.particles };
        let held = supports.hold_positions(matter, &walls, &self.network.directions, drift, executor);
        held.map_err(|unsolved| self.located(unsolved))
    }

    /// Removes velocities along rods and into walls at the end of a step of `h` seconds; without walls, as
    /// [`Rods::hold_velocities`].
    ///
    /// # Errors
    /// If rods and walls contradict each other.
    pub fn hold_velocities_at_walls<V: Vector>(
        &mut self,
        matter: &mut Matter<V>,
        (contacts, properties): (&Contacts<V>, &Properties<V>),
        h: f64,
        executor: &Executor,
    ) -> Result<(), Unsolved> {
        let walls = RodWalls { contacts, properties, particles: &self.particles };
        let touches = match &mut self.supports {
            Some(supports) => supports.hold_velocities(matter, &walls, &self.network.directions, h, executor),
            None => Ok(false),
        };
        if touches.map_err(|unsolved| self.located(unsolved))? { Ok(()) } else { self.hold_velocities(matter) }
    }

    /// Moves the particles of an initial state onto the constraints, and removes its velocities along rods.
    ///
    /// # Errors
    /// If the length of a rod is wrong by more than rounding.
    pub fn begin<V: Vector>(&mut self, matter: &mut Matter<V>, executor: &Executor) -> Result<(), Error> {
        let kinetic = |rods: &Self, matter: &Matter<V>| -> f64 {
            let of =
                |(&particle, &inverse): (&u32, &f64)| matter.velocity.get(particle as usize).widen().length_squared() / inverse;
            rods.particles.iter().zip(&rods.network.inverse_mass).filter(|(_, inverse)| **inverse > 0.0).map(of).sum::<f64>()
                / 2.0
        };
        for (rod, &spring) in self.network.links.iter().zip(&self.springs) {
            let [one, other] = rod.ends.map(|end| matter.exact_position(self.particles[end as usize] as usize));
            let found = (other - one).length();
            if (found - rod.length).abs() > DEVIATION * rod.length {
                let expected = format!("ends of rod {spring} that are {} m apart", rod.length);
                return Err(Error::parameter("set.positions", expected, format!("{found} m")));
            }
        }
        self.turn(|index| matter.exact_position(index), executor);
        let unsolved = |unsolved: Unsolved| {
            Error::parameter(
                "set.positions",
                "ends of rods at their lengths",
                format!("rods at particle {} that contradict", unsolved.particle),
            )
        };
        self.hold_positions(matter, None).map_err(unsolved)?;
        let before = kinetic(self, matter);
        self.turn(|index| matter.exact_position(index), executor);
        self.hold_velocities(matter).map_err(unsolved)?;
        let removed = before - kinetic(self, matter);
        if removed > 1e-9 * before {
            self.removed += removed;
        }
        Ok(())
    }

    /// Sets the directions of the rods at these positions, and factorizes A for projections.
    pub fn turn(&mut self, position: impl Fn(usize) -> DVec3, executor: &Executor) {
        self.turn_with(SHIFT, position, executor);
    }

    fn turn_with(&mut self, shift: f64, position: impl Fn(usize) -> DVec3, executor: &Executor) {
        let Network { directions, links, .. } = &mut self.network;
        for (direction, rod) in directions.iter_mut().zip(links.iter()) {
            let [one, other] = rod.ends.map(|end| position(self.particles[end as usize] as usize));
            *direction = (other - one).normalize_or_zero();
        }
        self.network.factorize(shift, executor);
    }

    /// Moves particles along the directions until all rods have their lengths. `drift` is the duration [s] of the preceding
    /// drift, with the register of its velocity v½. This velocity changes by the displacement over the duration. The velocity
    /// that predicts the end of the step changes by two such half kicks.
    ///
    /// # Errors
    /// If the iterations do not converge.
    pub fn hold_positions<V: Vector>(&mut self, matter: &mut Matter<V>, drift: Option<(f64, usize)>) -> Result<(), Unsolved> {
        let epsilon = resolution::<V>();
        for (vector, &particle) in self.network.vectors.iter_mut().zip(&self.particles) {
            *vector = matter.exact_position(particle as usize);
        }
        let length = |_: usize, rod: &Rod, _: DVec3, ends: [DVec3; 2]| rod.excess(ends, epsilon);
        self.network.project(length).map_err(|unsolved| self.located(unsolved))?;
        for ((&vector, &change), &particle) in self.network.vectors.iter().zip(&self.network.changes).zip(&self.particles) {
            let index = particle as usize;
            if let Some((h, half)) = drift {
                // From the change: the rounding of positions would be divided by h.
                let kick = change / h;
                add(&mut matter.registers[half], index, kick);
                add(&mut matter.velocity, index, 2.0 * kick);
            }
            matter.set_exact_position(index, vector);
        }
        if let Some((h, _)) = drift {
            count_reactions(&self.network, self.springs.len(), &self.particles, matter, 1.0 / h);
        }
        Ok(())
    }

    /// Removes velocities along rods from a state. A is factorized at its positions.
    ///
    /// # Errors
    /// If the iterations do not converge.
    pub fn hold_velocities<V: Vector>(&mut self, matter: &mut Matter<V>) -> Result<(), Unsolved> {
        let epsilon = V::Scalar::EPSILON.to_f64();
        for (vector, &particle) in self.network.vectors.iter_mut().zip(&self.particles) {
            *vector = matter.velocity.get(particle as usize).widen();
        }
        let along = |_: usize, _: &Rod, direction: DVec3, ends: [DVec3; 2]| network::along(direction, ends, epsilon);
        self.network.project(along).map_err(|unsolved| self.located(unsolved))?;
        for (&vector, &particle) in self.network.vectors.iter().zip(&self.particles) {
            matter.velocity.set(particle as usize, V::narrow(vector));
        }
        count_reactions(&self.network, self.springs.len(), &self.particles, matter, 1.0);
        Ok(())
    }

    /// Tensions T [N] in the order of the rods: n·(a₂ − a₁) + |v₂ − v₁|²/L − (A T) = 0. The state has these positions,
    /// velocities, and accelerations by all other forces. Reactions of walls on particles that touch them are included.
    pub fn tensions<V: Vector>(
        mut self,
        position: impl Fn(usize) -> DVec3,
        velocity: impl Fn(usize) -> DVec3,
        acceleration: impl Fn(usize) -> DVec3,
        walls: Option<(&Contacts<V>, &Properties<V>)>,
    ) -> Vec<f64> {
        self.turn_with(SHIFT_OF_TENSIONS, &position, &SERIAL);
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
        if let (Some(supports), Some((contacts, properties))) = (&mut self.supports, walls) {
            let walls = RodWalls { contacts, properties, particles: &self.particles };
            let state = |index: usize| [position(index), velocity(index), acceleration(index)];
            if let Some(tensions) = supports.tensions(&walls, &self.network.directions, state, along) {
                return tensions;
            }
        }
        // If the iterations stop above rounding, the multipliers are those of the last one.
        let _ = self.network.project(along);
        self.network.multipliers
    }

    /// Indices of the rods in the declared springs.
    pub fn springs(&self) -> &[usize] {
        &self.springs
    }

    /// Converts the particle's index to the engine's order.
    fn located(&self, unsolved: Unsolved) -> Unsolved {
        Unsolved { particle: self.particles[unsolved.particle] as usize, ..unsolved }
    }

    /// Adds the rods to the bound on the time step. Transverse waves of tense chains have the stiffness T/L. A rod turns at
    /// the rate ω = |Δv|/L; a step of more than 1/ω may leave it without a solution. Before the rod turns, √(|Δa|/L) stands
    /// for ω.
    pub fn bound(
        &self,
        tensions: &[f64],
        velocity: impl Fn(usize) -> DVec3,
        acceleration: impl Fn(usize) -> DVec3,
        bound: &mut SpectralBound,
    ) {
        for (rod, tension) in self.network.links.iter().zip(tensions) {
            let [one, other] = rod.ends.map(|end| self.particles[end as usize] as usize);
            let weights = rod.ends.map(|end| self.network.inverse_mass[end as usize]);
            let rate = (velocity(other) - velocity(one)).length() / rod.length;
            let onset = (acceleration(other) - acceleration(one)).length() / rod.length;
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

    /// Notes for the plan.
    pub fn notes(&self) -> Vec<String> {
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

    /// Estimated duration of a step [ns]: a factorization and about six iterations.
    pub fn cost(&self) -> f64 {
        self.network.cost()
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        let supports = self.supports.as_ref().map_or(0, Supports::bytes);
        self.network.bytes() + supports + self.particles.len() * size_of::<u32>()
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

fn add<V: Vector>(columns: &mut crate::matter::Columns<V>, index: usize, change: DVec3) {
    columns.set(index, V::narrow(columns.get(index).widen() + change));
}
