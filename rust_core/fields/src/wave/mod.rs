//! Waves: ρ u'' = ∇·(ρ c² ∇u) − ρ γ u' + ρ s for a displacement u on a uniform grid, advanced by an explicit integrator.

mod absorbing;
mod budget;
mod fields;
mod fourth;
mod limit;
mod medium;
mod parameters;
mod source;
mod stage;
mod state;
mod steps;
mod sweep;
mod system;

use std::sync::OnceLock;

use crate::error::{Error, Result};
use crate::grid::{EdgeValues, Grid, RowTable, depth};
use crate::integrators::{Boris, Facts, Integrator, with_integrator};
use crate::math::Real;
use crate::memory;
use crate::scene::{Item, Value};
use crate::stability::Limit;
use crate::systems::System;
use absorbing::{AbsorptionParameters, Layers};
use medium::{DensityField, Medium};
use parameters::Parameters;
use source::Sources;
use stage::Kernels;
use state::{HELD, WaveState, WaveTally, WaveWorkspace};
use sweep::WaveLaw;

/// Whether an integrator can advance waves: the explicit ones, but not Boris' kick, which turns velocities of particles.
pub fn advances(name: &str) -> bool {
    with_integrator!(name, I => I::NAME != Boris::NAME, false)
}

/// Compiles a wave for an integrator.
///
/// # Errors
/// If a parameter is missing or out of range, or memory does not suffice.
pub fn build<I: Integrator>(item: &Item, precision: &str) -> Result<Box<dyn System>> {
    match precision {
        "f32" => Ok(Box::new(Wave::<f32>::new::<I>(item)?)),
        "f64" => Ok(Box::new(Wave::<f64>::new::<I>(item)?)),
        other => Err(Error::parameter("precision", "f32 or f64", other)),
    }
}

/// Wave with its equation of motion.
struct Wave<T> {
    method: Facts,
    kernels: Kernels<T>,
    dynamics: WaveLaw<T>,
    /// Mask of wall cells, which are cut out.
    walls: Option<Vec<bool>>,
    absorption: Option<AbsorptionParameters>,
    state: WaveState<T>,
    /// State at the start of the last batch.
    saved: WaveState<T>,
    workspace: WaveWorkspace<T>,
    /// Number of stages in one pass over memory.
    depth: usize,
    /// Activity after each step of the last batch [J].
    activity: Vec<f64>,
    limit: OnceLock<Limit>,
}

/// Tables of a parameter that varies, in double precision: as read, with the layers, and of derived coefficients.
const TABLES: usize = 3;

impl<T: Real> Wave<T> {
    fn new<I: Integrator>(item: &Item) -> Result<Self> {
        Self::compiled(item, Facts::of::<I>(), Kernels::of::<I>())
    }

    fn compiled(item: &Item, method: Facts, kernels: Kernels<T>) -> Result<Self> {
        let columns = 2 * (2 + method.persistent) + 1 + (method.registers - method.persistent);
        let varies = |name: &&str| !matches!(item.values.get(*name), Some(Value::Number(_)));
        let tables = TABLES * ["speed", "density", "damping"].iter().filter(|name| varies(name)).count();
        let needed = (columns * size_of::<T>() + tables * size_of::<f64>()) * Grid::declared(item)?.count();
        memory::check("the wave", needed, 0, || "a coarser grid, or precision=\"f32\"".to_owned())?;
        let parameters = Parameters::declared(item, &method)?;
        let grid = &parameters.grid;
        let (count, rows) = (grid.count(), grid.rows());
        let padding = &parameters.padding;
        let narrow = |name: &str| -> Result<Vec<T>> {
            let table = padding.inner.field(item, name)?;
            let mut values = vec![T::ZERO; count];
            for (row, inside) in fields::rows(padding) {
                let slots = values[inside].iter_mut().zip(table.row(row));
                slots.for_each(|(slot, &value)| *slot = T::from_f64(value));
            }
            fields::clear_walls(&mut values, parameters.walls.as_deref());
            let odd = values.iter().position(|value| !value.is_finite());
            odd.map_or(Ok(values), |cell| {
                let path = format!("{}.{name} at {}", item.path, padding.inner.name(padding.nearest(cell)));
                Err(Error::parameter(path, format!("a number that {} holds", T::NAME), "a larger one"))
            })
        };
        let state = WaveState {
            displacement: narrow("displacement")?,
            rate: narrow("rate")?,
            persistent: vec![vec![T::ZERO; count]; method.persistent],
            tallies: vec![WaveTally::default(); rows],
        };
        let sources = Sources::declared(item, padding, parameters.walls.as_deref())?;
        let damping = RowTable::new(rows, grid.row_length(), T::ZERO, |row, values| {
            values.iter_mut().zip(parameters.damping.row(row)).for_each(|(value, &rate)| *value = T::from_f64(rate));
        });
        let medium = Medium::new(&parameters);
        if medium.density.as_ref().is_some_and(DensityField::overflows) {
            let expected = format!("densities whose ratios to the largest, {}, {} holds", parameters.density, T::NAME);
            return Err(Error::parameter(format!("{}.density", item.path), expected, "a smaller one"));
        }
        let mass = parameters.density * grid.content();
        let edges = parameters.edge_values(item)?;
        let layers = parameters.absorption.map(|absorption| {
            let speed = |cell: usize| parameters.speed.row(cell / grid.row_length())[cell % grid.row_length()];
            Layers::new(padding, &medium, absorption, speed, mass, &method)
        });
        let layers = layers.transpose()?;
        let exchanges = (0..rows).map(|row| {
            let meters = layers.as_ref().is_some_and(|layers| layers.meters(row));
            meters
                || !sources.in_row(row).is_empty()
                || !edges.in_row(row).is_empty()
                || damping.row(row).iter().any(|&rate| rate != T::ZERO)
        });
        let mut levels = Vec::new();
        edges.list(0.0, &mut levels)?;
        EdgeValues::check_range::<T>(item, "edges", &levels)?;
        let dynamics = WaveLaw {
            levels,
            exchanges: exchanges.collect(),
            padding: padding.clone(),
            medium,
            mass,
            damping,
            sources,
            edges,
            layers,
        };
        let sweeps = dynamics.medium.fourth.is_some() || dynamics.layers.is_some();
        let bytes = (2 + stage::columns(&method)) * size_of::<T>();
        let depth = if sweeps { 1 } else { depth(grid, bytes) };
        let mut wave = Self {
            saved: state.clone(),
            workspace: WaveWorkspace::new(&method, count, rows, depth),
            depth,
            state,
            activity: Vec::new(),
            limit: OnceLock::new(),
            absorption: parameters.absorption,
            walls: parameters.walls,
            dynamics,
            method,
            kernels,
        };
        wave.workspace.edges.clone_from(&wave.dynamics.levels);
        // Values at edges have done no work yet: that of a derivative is beyond the energy that it imposes.
        wave.state.tallies[0].energy[HELD] = wave.dynamics.imposed(&wave.state, &wave.workspace.edges).driven;
        Ok(wave)
    }

    /// Whether the wave is damped anywhere.
    fn is_damped(&self) -> bool {
        self.dynamics.damping.different().iter().any(|&rate| rate != T::ZERO)
    }
}

#[cfg(test)]
mod tests;
