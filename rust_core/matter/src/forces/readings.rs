//! Readings of gauges, with their integrals over time.

use crate::error::Result;
use crate::history::Archive;
use crate::math::AXES;

/// Present values, and their time integrals.
#[derive(Debug, Clone, Default)]
pub struct Readings {
    /// Force on each boundary, and on each body [N], an array per item.
    pub forces: Vec<[f64; AXES]>,
    /// Pressure at each probe [Pa].
    pub pressures: Vec<f64>,
    /// Impulses ∫ force dt [N·s].
    pub impulses: Vec<[f64; AXES]>,
    /// Integrals ∫ pressure dt [Pa·s].
    pub pressure_integrals: Vec<f64>,
    /// Time of the present values [s]; None before the first evaluation.
    time: Option<f64>,
}

impl Readings {
    /// Readings of 0 for `rows` boundaries and bodies, and `probes` probes.
    pub fn new(rows: usize, probes: usize) -> Self {
        Self {
            forces: vec![[0.0; AXES]; rows],
            pressures: vec![0.0; probes],
            impulses: vec![[0.0; AXES]; rows],
            pressure_integrals: vec![0.0; probes],
            time: None,
        }
    }

    /// Adds the present values over the time until `time` [s] to the integrals.
    pub fn advance(&mut self, time: f64) {
        let passed = time - self.time.unwrap_or(time);
        self.time = Some(time);
        let forces = self.impulses.as_flattened_mut().iter_mut().zip(self.forces.as_flattened());
        let pressures = self.pressure_integrals.iter_mut().zip(&self.pressures);
        forces.chain(pressures).for_each(|(integral, present)| *integral += passed * present);
    }

    /// Arrays of an archive, with their names.
    fn arrays(&mut self) -> [(&'static str, &mut [f64]); 4] {
        let Self { forces, pressures, impulses, pressure_integrals, .. } = self;
        [
            ("forces", forces.as_flattened_mut()),
            ("pressures", pressures),
            ("impulses", impulses.as_flattened_mut()),
            ("pressure_integrals", pressure_integrals),
        ]
    }

    /// Copies the values of other readings of the same scene without allocation.
    pub fn copy_from(&mut self, other: &Self) {
        self.forces.copy_from_slice(&other.forces);
        self.pressures.copy_from_slice(&other.pressures);
        self.impulses.copy_from_slice(&other.impulses);
        self.pressure_integrals.copy_from_slice(&other.pressure_integrals);
        self.time = other.time;
    }

    /// Writes all numbers to an archive.
    pub fn capture(&self, archive: &mut Archive) {
        self.clone().arrays().into_iter().for_each(|(name, numbers)| archive.write(name, numbers.iter().copied()));
        archive.write("time", [self.time.unwrap_or(f64::NAN)]);
    }

    /// Reads all numbers from an archive.
    pub fn restore(&mut self, archive: &mut Archive) -> Result<()> {
        self.arrays().into_iter().try_for_each(|(name, numbers)| archive.read_into(name, numbers))?;
        self.time = Some(archive.read_number("time")?).filter(|time| !time.is_nan());
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integrals_are_those_of_what_held_until_then() {
        let mut readings = Readings::new(1, 1);
        for (time, pressure) in [(1.0, 4.0), (1.5, 6.0), (1.5, 8.0), (2.0, 0.0)] {
            readings.advance(time);
            readings.pressures[0] = pressure;
        }
        // The pressure is 4 Pa from 1 to 1.5 s, and then 8 Pa, the last value found at that time.
        assert_eq!(readings.pressure_integrals, [0.5 * 4.0 + 0.5 * 8.0]);
    }
}
