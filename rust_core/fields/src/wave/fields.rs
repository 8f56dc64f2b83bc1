//! Fields of a wave, in double precision.

use std::ops::Range;

use super::Wave;
use super::state::{HELD, SOURCE};
use crate::error::{Error, Result};
use crate::grid::Padding;
use crate::history::{Archive, History};
use crate::math::Real;
use crate::parallel::Executor;
use crate::systems::{FieldInfo, Location, System};

/// Names and units of the fields.
const FIELDS: [(&str, &str); 2] = [("displacement", "m"), ("rate", "m/s")];

/// Rows of the user's grid: their indices, and the ranges of their cells within all cells.
pub fn rows(padding: &Padding) -> impl Iterator<Item = (usize, Range<usize>)> {
    let length = padding.inner.row_length();
    (0..padding.inner.rows()).map(move |row| {
        let first = padding.outward(row * length);
        (row, first..first + length)
    })
}

/// Sets the values in walls to 0.
pub fn clear_walls<T: Real>(values: &mut [T], walls: Option<&[bool]>) {
    if let Some(walls) = walls {
        values.iter_mut().zip(walls).filter(|(_, wall)| **wall).for_each(|(value, _)| *value = T::ZERO);
    }
}

impl<T: Real> Wave<T> {
    /// Descriptions of the fields, with the shape of the grid.
    pub(super) fn field_infos(&self) -> Vec<FieldInfo> {
        let shape = self.dynamics.padding.inner.shape();
        let info = |&(name, unit): &(&str, &'static str)| FieldInfo {
            name: name.to_owned(),
            unit,
            location: Location::Cells,
            shape: shape.clone(),
            rate: (name == "displacement").then(|| "rate".to_owned()),
            state: true,
        };
        FIELDS.iter().map(info).collect()
    }

    /// Values of a field.
    pub(super) fn values(&self, field: usize) -> Vec<f64> {
        let column = if field == 0 { &self.state.displacement } else { &self.state.rate };
        rows(&self.dynamics.padding).flat_map(|(_, cells)| &column[cells]).map(|number| number.to_f64()).collect()
    }

    /// Replaces the displacement, the rate or both; in walls they remain 0.
    pub(super) fn replace(&mut self, fields: &[(&str, &[f64])], time: f64, executor: &Executor) -> Result<()> {
        let before = self.audit(time, executor)?.total();
        let mut edges = Vec::new();
        self.dynamics.edges.list(time, &mut edges)?;
        let imposed = self.dynamics.imposed(&self.state, &edges).driven;
        let mut previous = Archive::default();
        self.capture(&mut previous);
        let done = self.narrow(fields).and_then(|()| self.begin(time, executor)).and_then(|()| {
            let energy = self.finite_audit(time, executor)?.total();
            self.state.tallies[0].energy[SOURCE] += energy - before;
            self.state.tallies[0].energy[HELD] += self.dynamics.imposed(&self.state, &edges).driven - imposed;
            Ok(())
        });
        if done.is_err() {
            self.restore(&mut previous)?;
        }
        done
    }

    /// Writes fields into the state.
    fn narrow(&mut self, fields: &[(&str, &[f64])]) -> Result<()> {
        for &(name, values) in fields {
            let column = match name {
                "displacement" => &mut self.state.displacement,
                "rate" => &mut self.state.rate,
                _ => return Err(Error::parameter(format!("set.{name}"), "displacement or rate", name)),
            };
            let padding = &self.dynamics.padding;
            let (count, length) = (padding.inner.count(), padding.inner.row_length());
            if values.len() != count {
                return Err(Error::parameter(format!("set.{name}"), format!("{count} numbers"), values.len()));
            }
            for (row, cells) in rows(padding) {
                let slots = column[cells].iter_mut().zip(&values[row * length..]);
                slots.for_each(|(slot, &value)| *slot = T::from_f64(value));
            }
            clear_walls(column, self.walls.as_deref());
            if let Some(cell) = column.iter().position(|value| !value.is_finite()) {
                let nearest = padding.nearest(cell);
                let path = format!("set.{name} at {}", padding.inner.name(nearest));
                return Err(Error::parameter(path, format!("a finite number that {} holds", T::NAME), values[nearest]));
            }
        }
        Ok(())
    }
}
