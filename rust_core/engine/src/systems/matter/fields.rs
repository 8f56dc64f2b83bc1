//! Fields of matter, in the caller's order and in double precision.

use glam::DVec3;

use super::compile::out_of_range;
use super::constraints::Constraint;
use super::{MatterSystem, budget};
use crate::catalog::Space;
use crate::error::{Error, Result};
use crate::forces::{DensityScheme, Fields, Readings};
use crate::math::AXES;
use crate::matter::{Columns, EnergySink, Matter};
use crate::parallel::{Executor, SERIAL};
use crate::systems::{FieldInfo, Location, System};

/// Names and units of the fields of all matter, and of fluids.
const MOTION: [(&str, &str); 2] = [("positions", "m"), ("velocities", "m/s")];
const FLUID: [(&str, &str); 2] = [("densities", "kg/m³"), ("pressures", "Pa")];
/// Names and units of the fields of boundaries and bodies, and of probes, with their integrals over time.
const WALLS: [(&str, &str); 2] = [("wall_forces", "N"), ("wall_impulses", "N·s")];
const PROBES: [(&str, &str); 2] = [("probe_pressures", "Pa"), ("probe_impulses", "Pa·s")];
/// Names and units of the fields of matter as a whole: momentum, and angular momentum about the origin of coordinates.
const WHOLE: [(&str, &str); 2] = [("momentum", "kg·m/s"), ("angular_momentum", "kg·m²/s")];
/// Name and unit of the [Mach number](crate::forces::Mach) of a fluid: fraction of fast particles, and speed of sound [m/s].
const MACH: (&str, &str) = ("mach", "1");

/// Flattens vectors, component by component.
fn flat<V: Space>(vectors: &[[f64; AXES]]) -> Vec<f64> {
    vectors.iter().flat_map(|vector| vector[..V::DIMENSION].iter().copied()).collect()
}

impl<V: Space> MatterSystem<V> {
    /// Names and units of the fields of this matter, without those of constraints.
    fn names(&self) -> impl Iterator<Item = (&'static str, &'static str)> {
        let fluid = self.dynamics.scheme.is_some().then_some(FLUID);
        let walls = self.gauges().map(|_| WALLS);
        let probes = self.gauges().filter(|gauges| !gauges.pressures.is_empty()).map(|_| PROBES);
        let fluid = fluid.into_iter().chain(walls).chain(probes).flatten();
        let mach = self.dynamics.scheme.is_some().then_some(MACH);
        MOTION.into_iter().chain(fluid).chain(WHOLE).chain(mach)
    }

    /// Readings of the gauges of the fluids.
    fn gauges(&self) -> Option<&Readings> {
        self.dynamics.forces().iter().filter_map(|force| force.fluid()).find_map(|fluid| fluid.gauges())
    }

    /// Descriptions of the fields, those of constraints last.
    pub(super) fn field_infos(&self) -> Vec<FieldInfo> {
        let info = |(name, unit): (&'static str, &'static str)| {
            let count = self.state.count();
            let moves = MOTION.contains(&(name, unit));
            let (location, shape) = match name {
                _ if moves => (Location::Points, vec![count, V::DIMENSION]),
                "wall_forces" | "wall_impulses" => {
                    (Location::Walls, vec![self.gauges().map_or(0, |gauges| gauges.forces.len()), V::DIMENSION])
                }
                "probe_pressures" | "probe_impulses" => {
                    (Location::Probes, vec![self.gauges().map_or(0, |gauges| gauges.pressures.len())])
                }
                "momentum" => (Location::Whole, vec![V::DIMENSION]),
                "angular_momentum" => (Location::Whole, vec![Self::turns()]),
                "mach" => (Location::Whole, vec![2]),
                _ => (Location::Points, vec![count]),
            };
            let rate = (name == "positions").then(|| "velocities".to_owned());
            // Density by continuity is a part of the state; density by summation follows from the positions.
            let continuity = name == "densities" && self.dynamics.scheme.is_some_and(DensityScheme::is_carried);
            FieldInfo { name: name.to_owned(), unit, location, shape, rate, state: moves || continuity }
        };
        self.names().map(info).chain(self.constraints.iter().flat_map(Constraint::fields)).collect()
    }

    /// Values of a field of constraints.
    fn values_of_constraints(&self, mut field: usize, time: f64) -> Vec<f64> {
        for constraint in self.constraints.iter() {
            let count = constraint.fields().len();
            if field < count {
                return self.forced(time, &SERIAL, |state| constraint.read(field, state));
            }
            field -= count;
        }
        Vec::new()
    }

    /// Values of a field.
    pub(super) fn values(&self, field: usize, time: f64) -> Vec<f64> {
        let (state, properties) = (&self.state, &self.dynamics.properties);
        let names = self.names().count();
        if field >= names {
            return self.values_of_constraints(field - names, time);
        }
        match self.names().nth(field).map_or("", |(name, _)| name) {
            "positions" => self.vectors(|index| properties.origin + state.exact_position(index)),
            "velocities" => self.vectors(|index| state.velocity.get(index).widen()),
            "wall_forces" => self.gauges().map_or_else(Vec::new, |gauges| flat::<V>(&gauges.forces)),
            "wall_impulses" => self.gauges().map_or_else(Vec::new, |gauges| flat::<V>(&gauges.impulses)),
            "probe_pressures" => self.gauges().map_or_else(Vec::new, |gauges| gauges.pressures.clone()),
            "probe_impulses" => self.gauges().map_or_else(Vec::new, |gauges| gauges.pressure_integrals.clone()),
            "momentum" => self.momenta().0.to_array()[..V::DIMENSION].to_vec(),
            "angular_momentum" => self.momenta().1.to_array()[AXES - Self::turns()..].to_vec(),
            "mach" => self.mach().to_vec(),
            name => {
                let nothing = || vec![f64::NAN; properties.count()];
                let mut fields = Fields { density: nothing(), pressure: nothing() };
                let fluids = self.dynamics.forces().iter().filter_map(|force| force.fluid());
                fluids.for_each(|fluid| fluid.export(&mut fields));
                let mut ordered = nothing();
                let values = if name == "densities" { fields.density } else { fields.pressure };
                properties.caller.iter().zip(values).for_each(|(&caller, value)| ordered[caller as usize] = value);
                ordered
            }
        }
    }

    /// Writes the values of a field to a slice; the Mach number, which is read after each batch, without allocation.
    pub(super) fn write_values(&self, field: usize, time: f64, values: &mut [f64]) {
        if self.names().nth(field) == Some(MACH) {
            values.copy_from_slice(&self.mach());
        } else {
            values.copy_from_slice(&self.values(field, time));
        }
    }

    /// Fraction of fast particles, and speed of sound [m/s]; 0 for a fluid without a speed of sound.
    fn mach(&self) -> [f64; 2] {
        let fluid = self.dynamics.forces().iter().find_map(|force| force.fluid());
        let mach = fluid.and_then(|fluid| fluid.mach(self.state.velocity.view()));
        mach.map_or([0.0; 2], |mach| [mach.fast, mach.sound])
    }

    /// Number of components of an angular momentum.
    fn turns() -> usize {
        if V::DIMENSION == 2 { 1 } else { AXES }
    }

    fn momenta(&self) -> (DVec3, DVec3) {
        let (momentum, turning) = budget::momenta(&self.dynamics, &self.state);
        (momentum, turning + self.constraints.iter().map(Constraint::spin).sum::<DVec3>())
    }

    fn vectors(&self, of: impl Fn(usize) -> DVec3) -> Vec<f64> {
        let mut values = vec![0.0; V::DIMENSION * self.state.count()];
        for (index, &caller) in self.dynamics.properties.caller.iter().enumerate() {
            let first = V::DIMENSION * caller as usize;
            values[first..first + V::DIMENSION].copy_from_slice(&of(index).to_array()[..V::DIMENSION]);
        }
        values
    }

    /// Replaces fields of the state.
    pub(super) fn replace(&mut self, fields: &[(&str, &[f64])], time: f64, executor: &Executor) -> Result<()> {
        let before = self.audit(time, executor)?.total();
        let (infos, mut state) = (self.field_infos(), self.state.clone());
        for &(name, values) in fields {
            let path = format!("set.{name}");
            let Some(info) = infos.iter().find(|info| info.state && info.name == name) else {
                return Err(Error::parameter(path, "positions or velocities", name));
            };
            let expected: usize = info.shape.iter().product();
            if values.len() != expected {
                return Err(Error::parameter(path, format!("{expected} numbers"), values.len()));
            }
            self.place(name, values, &mut state)?;
        }
        let mut archive = crate::history::Archive::default();
        self.capture_histories(&mut archive);
        let previous = std::mem::replace(&mut self.state, state);
        fields.iter().for_each(|(name, values)| self.adopt(name, values));
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

    /// Replaces positions or velocities in a copy of the state.
    fn place(&self, name: &str, values: &[f64], state: &mut Matter<V>) -> Result<()> {
        let properties = &self.dynamics.properties;
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
            _ => return Ok(()),
        };
        if let Some(index) = columns.out_of_range() {
            let path = format!("set.{name}[{}]", properties.caller[index]);
            return Err(out_of_range::<V>(&path, of(index)));
        }
        if let ("positions", Some(contacts)) = (name, &self.dynamics.contacts) {
            contacts.project_inside(&mut state.position, properties)?;
        }
        Ok(())
    }

    /// Replaces densities, or which springs are broken: state that forces and constraints hold.
    fn adopt(&mut self, name: &str, values: &[f64]) {
        if name == "densities" {
            let ordered: Vec<f64> = self.dynamics.properties.caller.iter().map(|&caller| values[caller as usize]).collect();
            let fluids = self.dynamics.forces_mut().iter_mut().filter_map(|force| force.fluid_mut());
            fluids.for_each(|fluid| fluid.import(&ordered));
        }
        self.change_constraints(|constraints| constraints.iter_mut().for_each(|constraint| constraint.adopt(name, values)));
    }
}
