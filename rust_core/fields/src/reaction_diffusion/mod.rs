//! Reaction–diffusion systems: u' = D ∇²u + R(u, v, …) for several species on a uniform grid. They are advanced by an explicit
//! method of first order in time derivatives.

mod cell_kinetics;
mod fields;
mod kinetics;
mod law;
mod limit;
mod stage;
mod steps;
mod system;

use std::collections::BTreeSet;
use std::sync::{Mutex, PoisonError};

use crate::error::{Error, Result};
use crate::grid::{CellCoefficients, Edge, EdgeCells, EdgeValues, Edges, Grid, Laplacian, Padding, depth};
use crate::integrators::first_order::{FirstOrder, NAMES};
use crate::math::{AXES, Real};
use crate::memory;
use crate::scene::{Item, Value};
use crate::systems::System;
use kinetics::Kinetics;
use law::{ReactionDiffusionLaw, SpeciesTally};
use stage::SpeciesStage;

/// Compiles a reaction–diffusion system for a method.
///
/// # Errors
/// If a parameter is missing or out of range, the method is not of first order, or memory does not suffice.
pub fn build(item: &Item, method: &Item, precision: &str) -> Result<Box<dyn System>> {
    let method =
        FirstOrder::named(&method.kind).ok_or_else(|| Error::parameter("integrator", NAMES.join(" or "), &method.kind))?;
    match precision {
        "f32" => Ok(Box::new(ReactionDiffusion::<f32>::new(item, method)?)),
        "f64" => Ok(Box::new(ReactionDiffusion::<f64>::new(item, method)?)),
        other => Err(Error::parameter("precision", "f32 or f64", other)),
    }
}

/// State: values of all species row by row (a row of the first species, the same row of the next, …), and tallies of gains and
/// losses.
#[derive(Debug, Clone)]
struct SpeciesState<T> {
    field: Vec<T>,
    tallies: Vec<SpeciesTally>,
}

/// Buffers of the stages.
struct SpeciesWorkspace<T> {
    /// Field at the previous stage, which neighbors still read.
    before: Vec<T>,
    /// Initial state y₀ and the stored slopes.
    columns: Vec<Vec<T>>,
    /// Reaction rates from a user-defined function.
    given: Vec<T>,
    /// Values at the edges: at all stages of a batch and at its end, or once if they are constant.
    edges: Vec<f64>,
    /// Largest |value| of each row at each stage of a pass.
    activity: Vec<f64>,
    /// Latest step size [s], with the stages of its steps.
    stages: (f64, Vec<SpeciesStage<T>>),
}

/// Reacting and diffusing species with their equation of motion.
struct ReactionDiffusion<T> {
    law: ReactionDiffusionLaw<T>,
    method: FirstOrder,
    /// Largest diffusion rate of any species [1/s], and the index of the species.
    fastest: (f64, usize),
    /// Name of the limit by this rate: `diffusion of u`.
    term: &'static str,
    state: SpeciesState<T>,
    /// State at the start of the last batch.
    saved: SpeciesState<T>,
    workspace: SpeciesWorkspace<T>,
    /// Number of stages in one pass over memory.
    depth: usize,
    /// Largest |value| after each step of the last batch.
    activity: Vec<f64>,
}

impl<T: Real> ReactionDiffusion<T> {
    fn new(item: &Item, method: FirstOrder) -> Result<Self> {
        let grid = Grid::declared(item)?;
        let (kinetics, names) = Kinetics::declared(item.record("reaction")?, &grid)?;
        let (species, rows, length) = (names.len(), grid.rows(), grid.row_length());
        let bytes = species * (2 + method.columns()) * size_of::<T>();
        let given = if kinetics.calls_back() { species } else { 0 };
        memory::check("the species", (bytes + (species + given) * size_of::<T>()) * grid.count(), 0, || {
            "a coarser grid, or precision=\"f32\"".to_owned()
        })?;
        let coefficients = item.record("diffusion")?;
        let padding = Padding::new(&grid, [[0; 2]; AXES]);
        let (mut diffusion, mut edges, mut listed) = (Vec::with_capacity(species), Vec::<EdgeValues>::new(), Vec::new());
        for name in &names {
            let weight = coefficients.non_negative(name)? / (grid.spacing * grid.spacing);
            if !T::from_f64(weight).is_finite() {
                let found = coefficients.values.get(name);
                return Err(coefficients.wrong(name, &format!("a number whose ratio to h² {} holds", T::NAME), found));
            }
            let (declaring, key) = match item.values.get("edges") {
                Some(Value::Record(of_species)) => (&**of_species, name.as_str()),
                _ => (item, "edges"),
            };
            let own = Edges::declared(declaring, key, &grid)?;
            if own.any(Edge::Absorbing) {
                return Err(declaring.wrong(key, "fixed, free or periodic", declaring.values.get(key)));
            }
            let of = |_: usize, _: usize| weight;
            let cells = CellCoefficients { grid: &grid, edges: own, walls: None, of: &of, same: true };
            diffusion.push(Laplacian::new(&cells));
            let cells = EdgeCells { padding: &padding, edges: own, of: &of, all: true, first: listed.len() };
            let values = EdgeValues::declared(declaring, key, &cells)?;
            values.list(0.0, &mut listed)?;
            EdgeValues::check_range::<T>(declaring, key, &listed)?;
            edges.push(values);
        }
        let mut field = vec![T::ZERO; species * grid.count()];
        let initial = item.record("initial")?;
        for (index, name) in names.iter().enumerate() {
            let table = grid.field(initial, name)?;
            for row in 0..rows {
                let slots = &mut field[(row * species + index) * length..][..length];
                slots.iter_mut().zip(table.row(row)).for_each(|(slot, &value)| *slot = T::from_f64(value));
                if let Some(cell) = slots.iter().position(|value| !value.is_finite()) {
                    let path = format!("{} at {}", initial.path_of(name), grid.name(row * length + cell));
                    return Err(Error::parameter(path, format!("a number that {} holds", T::NAME), table.row(row)[cell]));
                }
            }
        }
        let depth = if kinetics.calls_back() { 1 } else { depth(&grid, bytes) };
        let rates = diffusion.iter().map(Laplacian::largest).enumerate();
        let fastest = rates.fold((0.0, 0), |most, (index, rate)| if rate > most.0 { (rate, index) } else { most });
        let state = SpeciesState { field, tallies: vec![SpeciesTally::default(); rows * species] };
        let column = || vec![T::ZERO; species * grid.count()];
        let workspace = SpeciesWorkspace {
            before: column(),
            columns: (0..method.columns()).map(|_| column()).collect(),
            given: if given > 0 { column() } else { Vec::new() },
            edges: listed,
            activity: vec![0.0; rows * depth],
            stages: (0.0, Vec::new()),
        };
        let species: Vec<_> = names.into_iter().map(interned).collect();
        let term = interned(format!("diffusion of {}", species[fastest.1]));
        let law = ReactionDiffusionLaw { grid, kinetics, species, diffusion, edges };
        Ok(Self { law, method, fastest, term, saved: state.clone(), state, workspace, depth, activity: Vec::new() })
    }
}

/// Interns a name for the lifetime of the program. Only names of species are interned, and a program has few of these.
fn interned(name: String) -> &'static str {
    static NAMES: Mutex<BTreeSet<&'static str>> = Mutex::new(BTreeSet::new());
    let mut names = NAMES.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(known) = names.get(name.as_str()) {
        return known;
    }
    let lasting: &'static str = name.leak();
    names.insert(lasting);
    lasting
}

#[cfg(test)]
mod tests;
