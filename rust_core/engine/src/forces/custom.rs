//! A force given by a function of the user's: slow, correct, and called for all particles at once.

mod gradient;

use std::f64::consts::TAU;
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use glam::DVec3;

use super::{About, Force, Rates, Reach, StateView, Validity, VelocityDependence};
use crate::error::{Error, Result};
use crate::history::History;
use crate::ledger::{Class, Ledger};
use crate::math::{Real, Vector};
use crate::matter::{Columns, EnergySink};
use crate::parallel::Executor;
use crate::scene::{Callback, Term};
use crate::simd::LANES;
use crate::stability::{Horizon, SpectralBound};
use gradient::{Gradient, Probe};

/// How many steps an automatic time step gives a turn of the velocities, which the integrators follow and do not damp.
const STEPS_PER_TURN: f64 = 100.0;

/// By how much the frequencies may grow until somebody looks again: a time step counts as certified while it is below the limit
/// by this. Without it a step is replaced only when it is unstable already.
const GROWTH: f64 = std::f64::consts::SQRT_2;

/// A user's force on given particles. Without a potential, all that it does counts as work from outside.
pub struct Custom<V: Vector> {
    callback: Arc<dyn Callback>,
    path: String,
    /// The engine's index of each particle that it acts on, in the caller's order.
    members: Vec<usize>,
    /// The forces that the function gave last [N].
    force: Columns<V>,
    /// Its gradients by position and by velocity where they were last looked for.
    found: Mutex<Option<[Gradient; 2]>>,
}

impl<V: Vector> Custom<V> {
    /// A custom force as declared, on `members` in the caller's order, among `count` particles.
    pub fn new(term: &Term, members: Vec<usize>, count: usize) -> Result<Self> {
        let (callback, path) = (term.callback("function")?, term.path.clone());
        Ok(Self { callback, path, members, force: Columns::zeros(count), found: Mutex::new(None) })
    }

    fn positions(&self, at: &StateView<'_, V>) -> Vec<DVec3> {
        self.members.iter().map(|&index| at.properties.origin + at.position.get(index).widen()).collect()
    }

    fn velocities(&self, at: &StateView<'_, V>) -> Vec<DVec3> {
        self.members.iter().map(|&index| at.velocity.get(index).widen()).collect()
    }

    fn path(&self, function: &str) -> String {
        format!("{}.{function}", self.path)
    }

    /// What the function gives, finite or not.
    fn given(&self, time: f64, positions: &[DVec3], velocities: &[DVec3]) -> Result<Vec<DVec3>> {
        self.callback.forces(time, positions, velocities).map_err(|failure| failure.at(self.path("function")))
    }

    /// The forces [N] at a state, in this precision.
    fn forces(&self, time: f64, positions: &[DVec3], velocities: &[DVec3]) -> Result<Vec<DVec3>> {
        let forces = self.given(time, positions, velocities)?;
        let Some(row) = forces.iter().position(|&force| !V::narrow(force).widen().is_finite()) else { return Ok(forces) };
        let components = &forces[row].to_array()[..V::DIMENSION];
        let expected =
            if forces[row].is_finite() { format!("forces that {} can hold", V::Scalar::NAME) } else { "finite forces".into() };
        let found =
            format!("{components:?} N in row {row}, for the particle at {:?} m", &positions[row].to_array()[..V::DIMENSION]);
        Err(Error::parameter(self.path("function"), expected, found))
    }

    /// The gradients of the force on the particles that are free to move.
    fn gradients(&self, at: &StateView<'_, V>) -> Result<[Gradient; 2]> {
        let (time, positions, velocities) = (at.time, self.positions(at), self.velocities(at));
        let root: Vec<f64> = self.members.iter().map(|&index| at.properties.mass[index].recip().sqrt()).collect();
        if root.iter().all(|&root| root == 0.0) {
            return Ok([Gradient::NONE; 2]);
        }
        let force = self.forces(time, &positions, &velocities)?;
        if self.given(time, &positions, &velocities)? != force {
            return Ok([Gradient::NONE; 2]);
        }
        let moved = |from: &[DVec3], way: &[DVec3], h: f64| {
            from.iter().zip(way).map(|(from, way)| *from + h * *way).collect::<Vec<DVec3>>()
        };
        let (step, length) = gradient::displacement(&positions);
        let at_places = |way: &[DVec3], h: f64| self.given(time, &moved(&positions, way, h), &velocities);
        let by_position = Probe { given: &at_places, force: &force, root: &root, dimension: V::DIMENSION, step }.gradient()?;
        let step = gradient::acceleration(&velocities, length * by_position.norm.sqrt());
        let at_speeds = |way: &[DVec3], h: f64| self.given(time, &positions, &moved(&velocities, way, h));
        let by_velocity = Probe { given: &at_speeds, force: &force, root: &root, dimension: V::DIMENSION, step }.gradient()?;
        Ok([by_position, by_velocity])
    }

    /// The potential energy of its particles [J].
    fn potential_energy(&self, at: &StateView<'_, V>) -> Result<f64> {
        if self.members.is_empty() {
            return Ok(0.0);
        }
        let path = || self.path("potential");
        let energy = self.callback.potential(&self.positions(at)).map_err(|failure| failure.at(path()))?;
        if energy.is_finite() { Ok(energy) } else { Err(Error::parameter(path(), "a finite energy", format!("{energy} J"))) }
    }

    /// The gradients that were found last, for the plan.
    fn findings(&self) -> String {
        match *self.found.lock().unwrap_or_else(PoisonError::into_inner) {
            Some([by_position, by_velocity]) => {
                let turn = by_velocity.rotation;
                let turns = if turn > 0.0 { format!(", velocities turn at {turn:.3e} 1/s") } else { String::new() };
                format!(
                    "stiffness per mass up to {:.3e} 1/s², damping per mass up to {:.3e} 1/s{turns}",
                    by_position.norm, by_velocity.norm
                )
            }
            None => String::new(),
        }
    }
}

impl<V: Vector> History for Custom<V> {}

impl<V: Vector> Force<V> for Custom<V> {
    /// The function is given velocities, so it has to be expected that it uses them.
    fn about(&self) -> About {
        let calls = gradient::MOST_CALLS;
        About {
            velocity: VelocityDependence::Dissipative,
            potential: self.callback.has_potential().then_some("custom"),
            callback: true,
            bytes: self.force.bytes() + std::mem::size_of_val(self.members.as_slice()),
            layout: format!(
                "a function, called in every evaluation, and up to {calls} times whenever the limit of the time step is looked at"
            ),
            findings: self.findings(),
            ..About::new("custom", Reach::Whole)
        }
    }

    fn prepare(&mut self, at: &StateView<'_, V>, _crew: &Executor) -> Result<()> {
        if self.members.is_empty() {
            return Ok(());
        }
        let forces = self.forces(at.time, &self.positions(at), &self.velocities(at))?;
        for (&index, force) in self.members.iter().zip(forces) {
            self.force.set(index, V::narrow(force));
        }
        Ok(())
    }

    fn accumulate(&self, block: Range<usize>, at: &StateView<'_, V>, rates: &mut Rates<'_, V>) {
        let mine = self.force.view();
        let work = &mut rates.power[EnergySink::Work as usize];
        let conservative = self.callback.has_potential();
        for axis in 0..V::DIMENSION {
            let velocity = at.velocity.slice(axis, block.clone());
            let forces = mine.slice(axis, block.clone());
            for (index, ((sum, &force), &velocity)) in rates.force.axes[axis].iter_mut().zip(forces).zip(velocity).enumerate() {
                *sum += force;
                if !conservative {
                    work[index % LANES] += force.to_f64() * velocity.to_f64();
                }
            }
        }
    }

    fn energy(&self, at: &StateView<'_, V>, ledger: &mut Ledger) -> Result<()> {
        if !self.callback.has_potential() {
            return Ok(());
        }
        ledger.add(Class::Potential, "custom", self.potential_energy(at)?);
        Ok(())
    }

    /// The norms of its gradients, for every particle: it may couple any of them with any other.
    ///
    /// Velocities that it turns, at the rate r, are no damped modes: with a stiffness ω² they swing at up to
    /// r/2 + √(r²/4 + ω²), the larger root of μ² = rμ + ω², which counts as the frequency; and the splittings, which take
    /// such a force at a predicted velocity, gain a little energy in every turn, so that it limits the accuracy too.
    fn bound(&self, at: &StateView<'_, V>, bound: &mut SpectralBound) -> Result<()> {
        let gradients = self.gradients(at)?;
        *self.found.lock().unwrap_or_else(PoisonError::into_inner) = Some(gradients);
        let [by_position, by_velocity] = gradients;
        let turn = by_velocity.rotation;
        let frequency = 0.5 * turn + (0.25 * turn * turn + by_position.norm).sqrt();
        let stiffness = if turn > 0.0 { frequency * frequency } else { by_position.norm };
        let growth = if bound.horizon() == Horizon::Certified { GROWTH } else { 1.0 };
        for &index in self.members.iter().filter(|&&index| !at.properties.is_fixed(index)) {
            let mass = at.properties.mass[index];
            bound.point(index, "custom", growth * growth * stiffness * mass, growth * by_velocity.norm * mass);
        }
        if turn > 0.0 {
            bound.accuracy("custom", TAU / turn / STEPS_PER_TURN);
        }
        Ok(())
    }

    fn validity(&self, _at: &StateView<'_, V>, _horizon: Horizon) -> Validity {
        Validity::Now
    }
}
