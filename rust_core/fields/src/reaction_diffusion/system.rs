//! Reaction–diffusion system: history, plan, budgets and fields.

use super::ReactionDiffusion;
use super::law::SpeciesTally;
use crate::error::Result;
use crate::grid::{Edge, EdgeValues, Laplacian};
use crate::history::{Archive, History, TALLIES};
use crate::integrators::runge_kutta_chebyshev as chebyshev;
use crate::ledger::{Budget, Ledger};
use crate::math::Real;
use crate::parallel::Executor;
use crate::plan::Stages;
use crate::stability::{Horizon, Limit};
use crate::systems::{Control, Element, Fault, FieldInfo, Hints, Interval, RecordedSteps, System};

/// Minimum and maximum number of steps of a batch: the state at its start costs a sweep, and its activities cost memory.
const STEPS: std::ops::RangeInclusive<u64> = 31..=4095;
/// Estimated duration of a stage of a species in a cell [s].
const COST: f64 = 6e-10;
/// Number of sums in a tally.
const SUMS: usize = 5;
/// Units of amounts in one, two and three dimensions.
const UNITS: [&str; 3] = ["m", "m²", "m³"];
/// Numbers of stages for which the plan reports the limit.
const EXAMPLES: [usize; 4] = [2, 5, 10, 20];

impl<T: Real> ReactionDiffusion<T> {
    fn element(&self, index: usize) -> Element {
        Element { name: self.law.grid.name(index), index }
    }

    /// Cell and species of a value of the field.
    fn place(&self, index: usize) -> (usize, usize) {
        let (length, width) = (self.law.grid.row_length(), self.law.width());
        ((index / width) * length + index % length, index % width / length)
    }

    fn notes(&self) -> Vec<String> {
        if !self.method.is_stabilized() || self.fastest.0 == 0.0 {
            return Vec::new();
        }
        let reach = |stages: usize| (chebyshev::interval(stages) - chebyshev::REACTION).max(0.0) / self.fastest.0;
        let list = EXAMPLES.iter().skip(1).map(|&stages| format!("{stages} up to dt = {:.3e} s", reach(stages)));
        let euler = 2.0 / self.fastest.0;
        vec![format!(
            "stages by the step: {}; this pays from some five times the limit of ExplicitEuler on, {euler:.3e} s",
            list.collect::<Vec<_>>().join(", ")
        )]
    }
}

/// Saves the field and the tallies; no slope is kept from step to step.
impl<T: Real> History for ReactionDiffusion<T> {
    /// Swaps the states: steps read the saved state and write the other.
    fn save(&mut self) {
        std::mem::swap(&mut self.saved, &mut self.state);
    }

    fn rollback(&mut self) {
        std::mem::swap(&mut self.saved, &mut self.state);
    }

    fn capture(&self, archive: &mut Archive) {
        archive.write("species", self.state.field.iter().map(|number| number.to_f64()));
        let numbers = |tally: &SpeciesTally| [tally.gain, tally.loss, tally.edges, tally.supply, tally.set];
        archive.write(TALLIES, self.state.tallies.iter().flat_map(numbers));
    }

    fn restore(&mut self, archive: &mut Archive) -> Result<()> {
        let numbers = archive.read_exactly("species", self.state.field.len())?;
        self.state.field.iter_mut().zip(numbers).for_each(|(slot, &number)| *slot = T::from_f64(number));
        let groups = archive.read_exactly(TALLIES, SUMS * self.state.tallies.len())?.as_chunks::<SUMS>().0;
        for (tally, &[gain, loss, edges, supply, set]) in self.state.tallies.iter_mut().zip(groups) {
            *tally = SpeciesTally { gain, loss, edges, supply, set };
        }
        Ok(())
    }
}

impl<T: Real> System for ReactionDiffusion<T> {
    fn stages(&self) -> Vec<Stages> {
        let valued = self.law.edges.iter().any(|edges| !edges.is_empty());
        let fixed = self.law.diffusion.iter().any(|diffusion| diffusion.edges.any(Edge::Fixed));
        let layout = match self.depth {
            1 => "a sweep over all cells per evaluation".to_owned(),
            depth => format!("{depth} evaluations in one pass over memory, row by row"),
        };
        let count = self.method.stages(0.0, 0.0).len();
        let diffusion = if valued { "diffusion with values at the edges" } else { "diffusion" };
        let reaction = if self.law.kinetics.varies() { "reaction with parameters of each cell" } else { "reaction" };
        vec![Stages {
            item: String::new(),
            names: vec![diffusion.to_owned(), reaction.to_owned(), format!("update of {}", self.law.species.join(", "))],
            dimension: self.law.grid.dimension,
            precision: T::NAME,
            method: self.method.name,
            order: self.method.order,
            evaluations: self.workspace.stages.1.len().max(count),
            pairs: 0,
            force_error: 0.0,
            limit_varies: true,
            layout,
            left_out: if fixed { Vec::new() } else { vec!["fixed edges"] },
            notes: self.notes(),
        }]
    }

    fn bytes(&self) -> usize {
        let workspace = &self.workspace;
        let columns = workspace.columns.iter().chain([&workspace.before, &workspace.given, &self.state.field, &self.saved.field]);
        let edges = self.law.edges.iter().map(EdgeValues::bytes).sum::<usize>() + size_of_val(workspace.edges.as_slice());
        let coefficients = self.law.diffusion.iter().map(Laplacian::bytes).sum::<usize>() + self.law.kinetics.bytes() + edges;
        columns.map(|column| size_of_val(column.as_slice())).sum::<usize>()
            + 2 * size_of_val(self.state.tallies.as_slice())
            + size_of_val(workspace.activity.as_slice())
            + coefficients
    }

    fn cost(&self) -> f64 {
        let stages = self.method.stages(0.0, 0.0).len() as f64;
        stages * (1e-7 + COST * self.state.field.len() as f64)
    }

    /// Batches are of one step for a user-defined function, which is called once per stage and may take long.
    fn hints(&self) -> Hints {
        let hints = Hints::new(self.cost(), STEPS);
        let calls_back = self.law.kinetics.calls_back() || self.law.edges_vary();
        let imposed = self.law.edges.iter().map(|edges| edges.largest(&self.workspace.edges)).fold(0.0, f64::max);
        let amplitude = self.state.field.iter().fold(imposed, |most, value| value.to_f64().abs().max(most));
        Hints { most_steps: if calls_back { 1 } else { hints.most_steps }, amplitude: Some(amplitude), ..hints }
    }

    fn begin(&mut self, time: f64, executor: &Executor) -> Result<()> {
        self.given(&self.state.field)?;
        self.list_edges(std::iter::once(time))?;
        executor.check()
    }

    fn advance(&mut self, interval: Interval, _record: RecordedSteps, executor: &Executor) -> Result<()> {
        self.save();
        self.activity.clear();
        let outcome = self.steps(interval, executor);
        if outcome.is_err() {
            self.rollback();
        }
        outcome
    }

    fn activity(&self) -> &[f64] {
        &self.activity
    }

    fn limit(&self, _horizon: Horizon, _time: f64, executor: &Executor) -> Result<Limit> {
        self.bound(executor)
    }

    fn limit_varies(&self, _horizon: Horizon, _time: f64) -> bool {
        true
    }

    fn error(&self, h: f64) -> Option<(f64, Control)> {
        self.estimate(h)
    }

    fn audit(&self, _time: f64, executor: &Executor) -> Result<Ledger> {
        let content = self.law.grid.content();
        let mut ledger = Ledger::new(0, 1);
        for (species, &name) in self.law.species.iter().enumerate() {
            let tallied = |of: fn(&SpeciesTally) -> f64| content * self.tallied(species, of);
            let mut supplied = vec![("reaction", tallied(|tally| tally.gain)), ("set", tallied(|tally| tally.set))];
            if !self.law.edges[species].is_empty() {
                supplied.push(("edges", tallied(|tally| tally.supply)));
            }
            ledger.add_budget(Budget {
                name: name.to_owned(),
                unit: UNITS[self.law.grid.dimension - 1],
                stored: content * self.amount(species),
                removed: vec![("reaction", tallied(|tally| tally.loss)), ("edges", tallied(|tally| tally.edges))],
                supplied,
            });
        }
        executor.check()?;
        Ok(ledger)
    }

    fn fault(&self) -> Option<Fault> {
        let index = self.state.field.iter().position(|value| !value.is_finite())?;
        let (cell, species) = self.place(index);
        Some(Fault { element: self.element(cell), quantity: self.law.species[species] })
    }

    /// Cell with the largest value.
    fn fastest(&self) -> Element {
        let size = |index: &usize| self.state.field[*index].to_f64().abs();
        let largest = (0..self.state.field.len()).max_by(|one, other| size(one).total_cmp(&size(other)));
        self.element(self.place(largest.unwrap_or(0)).0)
    }

    fn fields(&self) -> Vec<FieldInfo> {
        self.field_infos()
    }

    fn read(&self, field: usize, _time: f64) -> Vec<f64> {
        self.species_rows(field, &self.state.field).map(|value| value.to_f64()).collect()
    }

    fn write(&mut self, fields: &[(&str, &[f64])], time: f64, executor: &Executor) -> Result<()> {
        let before = self.state.clone();
        let replaced = fields.iter().try_for_each(|&(name, values)| self.replace(name, values));
        let done =
            replaced.and_then(|()| self.begin(time, executor)).and_then(|()| self.finite_audit(time, executor).map(|_| ()));
        if done.is_err() {
            self.state = before;
        }
        done
    }
}
