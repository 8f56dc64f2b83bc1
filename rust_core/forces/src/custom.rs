//! User-defined force: a function that is called for all particles at once.

mod gradient;

use std::f64::consts::TAU;
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use glam::DVec3;

use super::{About, Declared, Force, ForceKind, Forces, Rates, Reach, StateView, Validity, VelocityDependence};
use crate::error::{Error, Result};
use crate::history::History;
use crate::ledger::{Class, Ledger};
use crate::math::{Real, Vector};
use crate::matter::{Columns, EnergySink};
use crate::parallel::Executor;
use crate::scene::{Argument, Callback};
use crate::simd::LANES;
use crate::stability::{Horizon, SpectralBound};
use gradient::{Gradient, GradientInput};

/// Steps per rotation period of the velocities at an automatic time step. Integrators follow this rotation without damping it.
const STEPS_PER_TURN: f64 = 100.0;

/// Growth of the frequencies that a certified limit allows for. A time step counts as certified below the limit divided by this
/// factor. Without the factor, a step would be replaced only when it is already unstable.
const GROWTH: f64 = std::f64::consts::SQRT_2;

/// User-defined force on given particles. Without a potential, all its power counts as external work.
pub struct Custom<V: Vector> {
    /// Function that returns the forces [N] for the time [s], positions [m] and velocities [m/s].
    function: Arc<dyn Callback>,
    /// Function that returns the potential energy [J] for positions [m].
    potential: Option<Arc<dyn Callback>>,
    path: String,
    /// Engine indices of the affected particles, in the caller's order.
    members: Vec<usize>,
    /// Forces of the last evaluation [N].
    force: Columns<V>,
    /// Gradients by position and by velocity of the last estimate.
    found: Mutex<Option<[Gradient; 2]>>,
}

const FUNCTION: &str = "function";
const POTENTIAL: &str = "potential";

/// Entry in the registry of forces.
pub fn kind<V: Vector>() -> ForceKind<V> {
    let build = |declared: &Declared<'_, V>| -> Result<Forces<V>> { Ok(vec![Box::new(Custom::<V>::new(declared)?)]) };
    ForceKind { name: "CustomForce", reach: Reach::Whole, charges: false, build }
}

impl<V: Vector> Custom<V> {
    /// User-defined force of an item.
    fn new(declared: &Declared<'_, V>) -> Result<Self> {
        let (item, count) = (declared.item, declared.chosen.len());
        Ok(Self {
            function: item.callback(FUNCTION)?,
            potential: item.optional_callback(POTENTIAL)?,
            path: item.path.clone(),
            members: declared.members(),
            force: Columns::zeros(count),
            found: Mutex::new(None),
        })
    }

    fn velocities(&self, at: &StateView<'_, V>) -> Vec<DVec3> {
        self.members.iter().map(|&index| at.velocity.get(index).widen()).collect()
    }

    fn path(&self, function: &str) -> String {
        format!("{}.{function}", self.path)
    }

    /// Forces that the function returns [N], finite or not.
    fn given(&self, time: f64, positions: &[DVec3], velocities: &[DVec3]) -> Result<Vec<DVec3>> {
        let arguments = [Argument::Number(time), Argument::Vectors(positions), Argument::Vectors(velocities)];
        let numbers = self.function.call(&arguments, "forces", &[positions.len(), V::DIMENSION]);
        let numbers = numbers.map_err(|failure| failure.at(self.path(FUNCTION)))?;
        let row = |row: &[f64]| DVec3::from_array(std::array::from_fn(|axis| row.get(axis).copied().unwrap_or(0.0)));
        Ok(numbers.chunks_exact(V::DIMENSION).map(row).collect())
    }

    /// Forces at a state [N], finite in the precision of the run.
    fn forces(&self, time: f64, positions: &[DVec3], velocities: &[DVec3]) -> Result<Vec<DVec3>> {
        let forces = self.given(time, positions, velocities)?;
        let Some(row) = forces.iter().position(|&force| !V::narrow(force).widen().is_finite()) else { return Ok(forces) };
        let components = &forces[row].to_array()[..V::DIMENSION];
        let expected =
            if forces[row].is_finite() { format!("forces that {} can hold", V::Scalar::NAME) } else { "finite forces".into() };
        let found =
            format!("{components:?} N in row {row}, for the particle at {:?} m", &positions[row].to_array()[..V::DIMENSION]);
        Err(Error::undefined(self.path(FUNCTION), expected, found))
    }

    /// Gradients of the force on the movable particles, by position and by velocity.
    fn gradients(&self, at: &StateView<'_, V>) -> Result<[Gradient; 2]> {
        let (time, positions, velocities) = (at.time, at.places(&self.members), self.velocities(at));
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
        let by_position =
            GradientInput { given: &at_places, force: &force, root: &root, dimension: V::DIMENSION, step }.gradient()?;
        let step = gradient::velocity_increment(&velocities, length * by_position.norm.sqrt());
        let at_speeds = |way: &[DVec3], h: f64| self.given(time, &positions, &moved(&velocities, way, h));
        let by_velocity =
            GradientInput { given: &at_speeds, force: &force, root: &root, dimension: V::DIMENSION, step }.gradient()?;
        Ok([by_position, by_velocity])
    }

    /// Potential energy of the affected particles [J].
    fn potential_energy(&self, potential: &dyn Callback, at: &StateView<'_, V>) -> Result<f64> {
        if self.members.is_empty() {
            return Ok(0.0);
        }
        let path = || self.path(POTENTIAL);
        let energy = potential.call(&[Argument::Vectors(&at.places(&self.members))], "one energy", &[]);
        let energy = energy.map_err(|failure| failure.at(path()))?.first().copied().unwrap_or(f64::NAN);
        if energy.is_finite() { Ok(energy) } else { Err(Error::undefined(path(), "a finite energy", format!("{energy} J"))) }
    }

    /// Gradients of the last estimate, for the plan.
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
    /// The function receives velocities, so that a dependence on them is assumed.
    fn about(&self) -> About {
        let calls = gradient::MOST_CALLS;
        About {
            velocity: VelocityDependence::Dissipative,
            potential: self.potential.is_some().then_some("custom"),
            callback: true,
            bytes: self.force.bytes() + std::mem::size_of_val(self.members.as_slice()),
            layout: format!(
                "a function, called in every evaluation, and up to {calls} times whenever the limit of the time step is looked at"
            ),
            findings: self.findings(),
            ..About::new("custom", Reach::Whole)
        }
    }

    fn prepare(&mut self, at: &StateView<'_, V>, _executor: &Executor) -> Result<()> {
        if self.members.is_empty() {
            return Ok(());
        }
        let forces = self.forces(at.time, &at.places(&self.members), &self.velocities(at))?;
        for (&index, force) in self.members.iter().zip(forces) {
            self.force.set(index, V::narrow(force));
        }
        Ok(())
    }

    fn accumulate(&self, block: Range<usize>, at: &StateView<'_, V>, rates: &mut Rates<'_, V>) {
        let mine = self.force.view();
        let work = &mut rates.power[EnergySink::Work as usize];
        let conservative = self.potential.is_some();
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
        let Some(potential) = &self.potential else { return Ok(()) };
        ledger.add(Class::Potential, "custom", self.potential_energy(potential.as_ref(), at)?);
        Ok(())
    }

    /// The norms of the gradients count for every particle, because the force may couple any two particles.
    ///
    /// A rotation of velocities at the rate r is not a damped mode. With a stiffness ω² the frequencies reach r/2 + √(r²/4 + ω²),
    /// the larger root of μ² = rμ + ω². This root counts as the frequency. The splittings evaluate such a force at a predicted
    /// velocity, and gain a little energy per rotation. The rotation therefore limits the accuracy too.
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
