//! Fields of matter, in the caller's order and in double precision.

use glam::DVec3;

use super::compile::out_of_range;
use super::{MatterSystem, budget};
use crate::error::{Error, Result};
use crate::forces::Space;
use crate::forces::sph::Gauges;
use crate::forces::{DensityScheme, Fields};
use crate::math::AXES;
use crate::matter::{Columns, EnergySink};
use crate::parallel::{Executor, SERIAL};
use crate::systems::{FieldInfo, Location, System};

/// Names and units of the fields of all matter, and of fluids.
const MOTION: [(&str, &str); 2] = [("positions", "m"), ("velocities", "m/s")];
const FLUID: [(&str, &str); 2] = [("densities", "kg/m³"), ("pressures", "Pa")];
/// Names and units of the fields of boundaries and bodies, and of probes, with their integrals over time. Then those of
/// springs: with rods, and if springs can break.
const WALLS: [(&str, &str); 2] = [("wall_forces", "N"), ("wall_impulses", "N·s")];
const PROBES: [(&str, &str); 2] = [("probe_pressures", "Pa"), ("probe_impulses", "Pa·s")];
const TENSION: (&str, &str) = ("tensions", "N");
const BROKEN: (&str, &str) = ("broken", "1");
/// Names and units of the fields of matter as a whole: momentum, and angular momentum about the origin of coordinates.
const WHOLE: [(&str, &str); 2] = [("momentum", "kg·m/s"), ("angular_momentum", "kg·m²/s")];
/// Name and unit of the [Mach number](crate::forces::Mach) of a fluid: fraction of fast particles, and speed of sound [m/s].
const MACH: (&str, &str) = ("mach", "1");

/// Flattens vectors, component by component.
fn flat<V: Space>(vectors: &[[f64; AXES]]) -> Vec<f64> {
    vectors.iter().flat_map(|vector| vector[..V::DIMENSION].iter().copied()).collect()
}

impl<V: Space> MatterSystem<V> {
    /// Names and units of the fields of this matter.
    fn names(&self) -> impl Iterator<Item = (&'static str, &'static str)> {
        let fluid = self.dynamics.scheme.is_some().then_some(FLUID);
        let tension = self.dynamics.rods.is_some().then_some(TENSION);
        let broken = self.dynamics.tearing.is_some().then_some(BROKEN);
        let walls = self.gauges().map(|_| WALLS);
        let probes = self.gauges().filter(|gauges| !gauges.pressures().is_empty()).map(|_| PROBES);
        let fluid = fluid.into_iter().chain(walls).chain(probes).flatten();
        let mach = self.dynamics.scheme.is_some().then_some(MACH);
        MOTION.into_iter().chain(fluid).chain(tension).chain(broken).chain(WHOLE).chain(mach)
    }

    /// Gauges of the fluids.
    fn gauges(&self) -> Option<&Gauges> {
        self.dynamics.forces().iter().filter_map(|force| force.density()).find_map(|density| density.gauges())
    }

    /// Descriptions of the fields. Fields of a fluid exist only with a fluid, tensions with rods, broken springs if springs
    /// can break.
    pub(super) fn field_infos(&self) -> Vec<FieldInfo> {
        let info = |(name, unit): (&'static str, &'static str)| {
            let count = self.state.count();
            let moves = MOTION.contains(&(name, unit));
            let (location, shape) = match name {
                _ if moves => (Location::Points, vec![count, V::DIMENSION]),
                "tensions" | "broken" => (Location::Springs, vec![self.dynamics.springs.len()]),
                "wall_forces" | "wall_impulses" => {
                    (Location::Walls, vec![self.gauges().map_or(0, |gauges| gauges.forces().len()), V::DIMENSION])
                }
                "probe_pressures" | "probe_impulses" => {
                    (Location::Probes, vec![self.gauges().map_or(0, |gauges| gauges.pressures().len())])
                }
                "momentum" => (Location::Whole, vec![V::DIMENSION]),
                "angular_momentum" => (Location::Whole, vec![self.turns()]),
                "mach" => (Location::Whole, vec![2]),
                _ => (Location::Points, vec![count]),
            };
            let rate = (name == "positions").then(|| "velocities".to_owned());
            // Density by continuity is a part of the state; density by summation follows from the positions.
            let continuity = name == "densities" && self.dynamics.scheme == Some(DensityScheme::Continuity);
            FieldInfo { name: name.to_owned(), unit, location, shape, rate, state: moves || continuity }
        };
        self.names().map(info).collect()
    }

    /// Values of a field.
    pub(super) fn values(&self, field: usize) -> Vec<f64> {
        let (state, properties) = (&self.state, &self.dynamics.properties);
        match self.names().nth(field).map_or("", |(name, _)| name) {
            "positions" => self.vectors(|index| properties.origin + state.exact_position(index)),
            "velocities" => self.vectors(|index| state.velocity.get(index).widen()),
            "tensions" => self.dynamics.tensions_of_springs(&self.dynamics.view_of(state, 0.0, &SERIAL)),
            "broken" => {
                let broken = self.dynamics.tearing.as_ref().map_or(&[][..], |tearing| tearing.broken());
                broken.iter().map(|&torn| f64::from(u8::from(torn))).collect()
            }
            "wall_forces" => self.gauges().map_or_else(Vec::new, |gauges| flat::<V>(gauges.forces())),
            "wall_impulses" => self.gauges().map_or_else(Vec::new, |gauges| flat::<V>(gauges.impulses())),
            "probe_pressures" => self.gauges().map_or_else(Vec::new, |gauges| gauges.pressures().to_vec()),
            "probe_impulses" => self.gauges().map_or_else(Vec::new, |gauges| gauges.pressure_integrals().to_vec()),
            "momentum" => self.momenta().0.to_array()[..V::DIMENSION].to_vec(),
            "angular_momentum" => self.momenta().1.to_array()[AXES - self.turns()..].to_vec(),
            "mach" => {
                let fluid = self.dynamics.forces().iter().find_map(|force| force.density());
                let mach = fluid.map(|density| density.mach(state.velocity.view()));
                mach.map_or_else(Vec::new, |mach| vec![mach.fast, mach.sound])
            }
            name => {
                let nothing = || vec![f64::NAN; properties.count()];
                let mut fields = Fields { density: nothing(), pressure: nothing() };
                let densities = self.dynamics.forces().iter().filter_map(|force| force.density());
                densities.for_each(|density| density.export(&mut fields));
                let mut ordered = nothing();
                let values = if name == "densities" { fields.density } else { fields.pressure };
                properties.caller.iter().zip(values).for_each(|(&caller, value)| ordered[caller as usize] = value);
                ordered
            }
        }
    }

    /// Number of components of an angular momentum.
    fn turns(&self) -> usize {
        if V::DIMENSION == 2 { 1 } else { AXES }
    }

    fn momenta(&self) -> (DVec3, DVec3) {
        budget::momenta(&self.dynamics, &self.state)
    }

    fn vectors(&self, of: impl Fn(usize) -> DVec3) -> Vec<f64> {
        let mut values = vec![0.0; V::DIMENSION * self.state.count()];
        for (index, &caller) in self.dynamics.properties.caller.iter().enumerate() {
            let first = V::DIMENSION * caller as usize;
            values[first..first + V::DIMENSION].copy_from_slice(&of(index).to_array()[..V::DIMENSION]);
        }
        values
    }

    /// Replaces positions or velocities or both.
    pub(super) fn replace(&mut self, fields: &[(&str, &[f64])], time: f64, executor: &Executor) -> Result<()> {
        let before = self.audit(time, executor)?.total();
        let mut state = self.state.clone();
        for &(name, values) in fields {
            let properties = &self.dynamics.properties;
            let expected = V::DIMENSION * state.count();
            if values.len() != expected {
                return Err(Error::parameter(format!("set.{name}"), format!("{expected} numbers"), values.len()));
            }
            let of = |index: usize| {
                let first = V::DIMENSION * properties.caller[index] as usize;
                let mut vector = [0.0; 3];
                vector[..V::DIMENSION].copy_from_slice(&values[first..first + V::DIMENSION]);
                DVec3::from_array(vector)
            };
            let columns = match name {
                "positions" => {
                    (0..state.count()).for_each(|index| state.set_exact_position(index, of(index) - properties.origin));
                    &state.position
                }
                "velocities" => {
                    state.velocity = Columns::from_fn(state.count(), |index| V::narrow(of(index)));
                    &state.velocity
                }
                _ => return Err(Error::parameter(format!("set.{name}"), "positions or velocities", name)),
            };
            if let Some(index) = columns.out_of_range() {
                let path = format!("set.{name}[{}]", properties.caller[index]);
                return Err(out_of_range::<V>(&path, of(index)));
            }
            if let ("positions", Some(contacts)) = (name, &self.dynamics.contacts) {
                contacts.project_inside(&mut state.position, properties)?;
            }
        }
        let mut archive = crate::history::Archive::default();
        self.capture_histories(&mut archive);
        let previous = std::mem::replace(&mut self.state, state);
        // Forces first: the energy of some forces follows from their evaluation.
        let done = self.begin(time, executor).and_then(|()| self.finite_audit(time, executor)).map(|energy| {
            if let Some(tally) = self.state.tallies.first_mut() {
                tally.add(EnergySink::Work, energy.total() - before);
            }
        });
        if done.is_err() {
            self.state = previous;
            self.resume();
            self.restore_histories(&mut archive)?;
        }
        done
    }
}
