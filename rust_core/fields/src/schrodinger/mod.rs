//! Wave functions: iħ ψ' = (−ħ²/2m ∇² + V + g |ψ|²) ψ on a uniform grid.

mod absorbing;
mod crank_nicolson;
mod fourier;
mod hamiltonian;
mod method;
mod passes;
mod split_step;
mod staggered;
mod state;
mod system;

use crate::error::{Error, Result};
use crate::grid::{Edges, Grid, Padding};
use crate::memory;
use crate::parallel::SERIAL;
use crate::scene::{Item, Value};
use crate::stability::Limit;
use crate::systems::System;
use absorbing::{Absorption, Layer};
use fourier::{Complex, FourierReal, Spectrum};
use hamiltonian::{Energies, Hamiltonian};
pub use method::NAMES as METHODS;
use method::SchrodingerMethod;
use passes::Field;
use state::QuantumState;

/// Compiles a wave function for an integrator.
///
/// # Errors
/// If a parameter is missing or out of range, or memory does not suffice.
pub fn build(item: &Item, method: &Item, precision: &str) -> Result<Box<dyn System>> {
    match precision {
        "f32" => Ok(Box::new(Schrodinger::<f32>::new(item, method)?)),
        "f64" => Ok(Box::new(Schrodinger::<f64>::new(item, method)?)),
        other => Err(Error::parameter("precision", "f32 or f64", other)),
    }
}

/// Wave function with its equation of motion.
struct Schrodinger<T> {
    hamiltonian: Hamiltonian<T>,
    method: SchrodingerMethod<T>,
    layer: Option<Layer>,
    absorption: Option<Absorption<T>>,
    state: QuantumState<T>,
    /// State at the start of the last batch.
    saved: QuantumState<T>,
    /// Second copy of ψ, and the memory of transforms.
    other: Vec<Complex<T>>,
    scratch: Vec<Complex<T>>,
    /// Energy of a unit probability in the measure of activity [J].
    reference: f64,
    /// Activity after each step of the last batch [J].
    activity: Vec<f64>,
    limit: Limit,
}

impl<T: FourierReal> Schrodinger<T> {
    fn new(item: &Item, method: &Item) -> Result<Self> {
        let grid = Grid::declared(item)?;
        let edges = Edges::declared(item, "edges", &grid)?;
        memory::check("the wave function", 8 * grid.count() * size_of::<T>(), 0, || {
            "a coarser grid, or precision=\"f32\"".to_owned()
        })?;
        let inside = initial::<T>(item, &grid)?;
        let bare = declared(item, Padding::new(&grid, [[0; 2]; 3]), edges)?;
        let layer = Layer::declared(item, &grid, edges, wave_number(&bare, &inside))?;
        let padding = Padding::new(&grid, Layer::widths(layer, edges));
        let hamiltonian = if layer.is_some() { declared(item, padding, edges)? } else { bare };
        let count = hamiltonian.padding.outer.count();
        memory::check("the wave function with its layers", 8 * count * size_of::<T>(), 0, || "narrower layers".to_owned())?;
        let mut values = vec![state::zero(); count];
        inside.iter().enumerate().for_each(|(cell, &value)| values[hamiltonian.padding.outward(cell)] = value);
        let rate = hamiltonian.hopping / hamiltonian.hbar;
        let absorption = layer.map(|layer| Absorption::new(&hamiltonian.padding, layer, rate));
        let method = SchrodingerMethod::declared(method, &hamiltonian)?;
        if layer.is_some() && method.order() > 2 {
            let expected = "SplitStep(order=2) or CrankNicolson() beside absorbing edges, without substeps backward in time";
            return Err(Error::parameter("integrator", expected, "SplitStep(order=4)"));
        }
        let limit = method.limit(&hamiltonian, &values);
        let state = QuantumState { values, ..QuantumState::default() };
        Ok(Self {
            saved: state.clone(),
            other: state.values.clone(),
            scratch: Vec::new(),
            state,
            method,
            layer,
            absorption,
            reference: 0.0,
            activity: Vec::new(),
            limit,
            hamiltonian,
        })
    }

    /// Energies of the present state.
    fn energies(&self, executor: &crate::parallel::Executor) -> Energies {
        let (mut values, mut other, mut scratch) = (self.state.values.clone(), self.state.values.clone(), Vec::new());
        let mut field = Field::new(self.hamiltonian.padding.outer.cells, &mut values, &mut other, &mut scratch);
        self.hamiltonian.energies(&mut field, self.method.is_spectral(), executor)
    }

    /// Probability within the user's grid.
    fn probability(&self) -> f64 {
        let padding = &self.hamiltonian.padding;
        let sum: f64 = state::rows(padding).map(|cells| fourier::norm(&self.state.values[cells])).sum();
        padding.inner.content() * sum
    }
}

/// Reads the initial ψ, with real and imaginary parts along a last axis.
fn initial<T: FourierReal>(item: &Item, grid: &Grid) -> Result<Vec<Complex<T>>> {
    let given = item.values.get("wave_function");
    let shape: Vec<usize> = grid.shape().into_iter().chain([2]).collect();
    let Some(Value::Numbers(array)) = given.filter(|value| matches!(value, Value::Numbers(array) if array.shape == shape)) else {
        return Err(item.wrong("wave_function", &format!("an array of shape {shape:?}"), given));
    };
    state::narrow(&array.entries, grid, &format!("{}.wave_function", item.path))
}

/// Reads the Hamiltonian that an item declares, on its grid with layers.
fn declared<T: FourierReal>(item: &Item, padding: Padding, edges: Edges) -> Result<Hamiltonian<T>> {
    let positive = |name: &str| match item.number(name)? {
        number if number > 0.0 => Ok(number),
        number => Err(item.wrong(name, "a number > 0", Some(&Value::Number(number)))),
    };
    let (mass, hbar) = (positive("mass")?, positive("hbar")?);
    let spacing = padding.inner.spacing;
    let table = padding.extend(&padding.inner.field(item, "potential")?);
    let rows = 0..padding.outer.rows();
    let hopping = hbar / spacing * (hbar / spacing) / (2.0 * mass);
    if !(T::from_f64(hopping).is_finite() && hopping > 0.0) {
        let expected = format!("an energy ħ²/2m h² that {} holds", T::NAME);
        return Err(item.wrong("hbar", &expected, Some(&Value::Number(hopping))));
    }
    let potential: Vec<T> = rows.flat_map(|row| table.row(row)).map(|&value| T::from_f64(value)).collect();
    if let Some(cell) = potential.iter().position(|value| !value.is_finite()) {
        let path = format!("potential at {}", padding.inner.name(padding.nearest(cell)));
        return Err(item.wrong(&path, &format!("a number that {} holds", T::NAME), None));
    }
    Ok(Hamiltonian {
        potential,
        interaction: item.number("interaction")?,
        spectra: std::array::from_fn(|axis| Spectrum::new(padding.outer.cells[axis], edges.0[axis])),
        hopping,
        hbar,
        edges,
        padding,
    })
}

/// Wave number of the mean kinetic energy, per spacing.
fn wave_number<T: FourierReal>(hamiltonian: &Hamiltonian<T>, values: &[Complex<T>]) -> f64 {
    let norm = fourier::norm(values);
    let kinetic = hamiltonian.difference_energy(values, &SERIAL);
    (kinetic / (norm * hamiltonian.hopping)).sqrt()
}
