//! Equation of motion: u' = D ∇²u + R(u, v, …), stage by stage over rows of cells.

use std::ops::Range;

use super::kinetics::{Kinetics, with_law};
use super::stage::{self, ComputedRates, GivenRates, SpeciesCells, SpeciesStage, SpeciesSums};
use crate::grid::{Block, Edge, EdgeValues, Grid, Laplacian, Sweep, Window};
use crate::math::Real;

/// Memory of the diffusion rates computed at a time, which stay in the first-level cache [bytes].
const SEGMENT: usize = 1 << 13;

/// Time integrals of gains and losses of one species in one row, in units of a cell.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SpeciesTally {
    /// Gain by reactions.
    pub gain: f64,
    /// Loss by reactions.
    pub loss: f64,
    /// Loss through edges.
    pub edges: f64,
    /// Gain through edges with values.
    pub supply: f64,
    /// Gain by changes of the field between steps.
    pub set: f64,
}

/// Equation of motion, without the state.
pub struct ReactionDiffusionLaw<T> {
    pub grid: Grid,
    pub kinetics: Kinetics<T>,
    /// Names of the species.
    pub species: Vec<&'static str>,
    /// Operator D ∇² of each species.
    pub diffusion: Vec<Laplacian<T>>,
    /// Values at the edges, of each species.
    pub edges: Vec<EdgeValues>,
}

/// Stages of a batch, as many as one pass over memory takes.
pub struct SpeciesPass<'a, T> {
    pub law: &'a ReactionDiffusionLaw<T>,
    /// Stages of a step.
    pub stages: &'a [SpeciesStage<T>],
    /// Index in the batch of the first stage of the pass, and of the last stage of the batch.
    pub first: usize,
    pub last: usize,
    /// State at the start of the batch.
    pub start: &'a [T],
    /// Values at the edges: at all stages of the batch and at its end, or once if they are constant.
    pub edges: &'a [f64],
    /// Reaction rates, if they come from a user-defined function.
    pub given: &'a [T],
}

impl<T: Real> ReactionDiffusionLaw<T> {
    /// Number of values in a row of all species.
    pub fn width(&self) -> usize {
        self.species.len() * self.grid.row_length()
    }

    /// Number of values at the edges, of all species.
    pub fn edge_values(&self) -> usize {
        self.edges.iter().map(EdgeValues::count).sum()
    }

    /// Whether values at the edges are user-defined functions of the time.
    pub fn edges_vary(&self) -> bool {
        self.edges.iter().any(EdgeValues::vary)
    }

    /// Values at the edges from a list: those listed at an index, or the only ones if they are constant.
    pub fn edge_values_at<'a>(&self, list: &'a [f64], index: usize) -> &'a [f64] {
        let count = self.edge_values();
        &list[if self.edges_vary() { index * count } else { 0 }..][..count]
    }

    /// Loss and gain rates of a row of a species through the edges. Without declared values the loss is Σ κ u, else it is
    /// taken flux by flux.
    fn exchange(&self, species: usize, row: usize, values: &[T], edge_values: &[f64]) -> [f64; 2] {
        let (diffusion, edges) = (&self.diffusion[species], &self.edges[species]);
        if !edges.is_empty() {
            let mut rates = [0.0; 2];
            for face in edges.in_row(row) {
                let inflow = face.inflow(edge_values, values[face.column].to_f64());
                rates[usize::from(inflow > 0.0)] += inflow.abs();
            }
            return rates;
        }
        if !diffusion.edges.any(Edge::Fixed) {
            return [0.0; 2];
        }
        let anchor = diffusion.anchor.row(row);
        let of = |cell: usize| anchor[cell].to_f64() * values[cell].to_f64();
        let beside = self.grid.neighbors(row);
        let last = values.len() - 1;
        let loss = if self.grid.axes().any(|axis| axis < 2 && beside[axis].contains(&None)) {
            (0..=last).map(of).sum()
        } else {
            of(0) + if last > 0 { of(last) } else { 0.0 }
        };
        [loss, 0.0]
    }
}

/// Returns cells of `N` species in a row of a block, from species `first` on.
fn cells<'a, T: Copy, const N: usize>(
    block: &'a mut Block<'_, T, SpeciesTally>,
    index: usize,
    length: usize,
    first: usize,
    range: &Range<usize>,
    before: Window<'a, T>,
    diffusion: &'a [T],
) -> [SpeciesCells<'a, T>; N] {
    let row = block.first + index;
    let own = index * block.length + first * length..(index + 1) * block.length;
    let mut next = block.field[own.clone()].chunks_exact_mut(length);
    let mut columns = block
        .columns
        .each_mut()
        .map(|column| if column.is_empty() { &mut [] } else { &mut column[own.clone()] }.chunks_exact_mut(length));
    let mut diffusion = diffusion.chunks_exact(range.len());
    std::array::from_fn(|species| SpeciesCells {
        value: &Window { field: first + species, ..before }.row(row)[range.clone()],
        diffusion: diffusion.next().unwrap_or_default(),
        next: next.next().map_or(&mut [], |row| &mut row[range.clone()]),
        columns: columns.each_mut().map(|rows| rows.next().map_or(&mut [][..], |row| &mut row[range.clone()])),
    })
}

impl<T: Real> Sweep<T, SpeciesTally> for SpeciesPass<'_, T> {
    fn scratch(&self) -> usize {
        let arrays = if self.law.kinetics.varies() { 2 } else { 1 };
        arrays * self.law.species.len() * (SEGMENT / size_of::<T>()).min(self.law.grid.row_length())
    }

    fn row(&self, stage: usize, block: &mut Block<'_, T, SpeciesTally>, index: usize, before: Window<'_, T>, scratch: &mut [T]) {
        let Self { law, stages, .. } = self;
        let (row, length, count) = (block.first + index, law.grid.row_length(), law.species.len());
        let (number, of) = (self.first + stage, |values| Window { length, fields: count, ..Window::new(values, length) });
        let before = if number == 0 { of(self.start) } else { Window { length, fields: count, ..before } };
        let scaled = &stages[number % stages.len()];
        let edge_values = law.edge_values_at(self.edges, number);
        let mut largest = 0.0_f64;
        let mut tally = |tallies: &mut [SpeciesTally], species: usize, sums: SpeciesSums| {
            let tally = &mut tallies[index * count + species];
            tally.gain += scaled.weight * sums.gain;
            tally.loss += scaled.weight * (sums.gain - sums.net);
            largest = if sums.largest.is_nan() || sums.largest > largest { sums.largest } else { largest };
        };
        let mut start = 0;
        while start < length {
            let range = start..(start + SEGMENT / size_of::<T>()).min(length);
            start = range.end;
            let (diffused, reacted) = scratch.split_at_mut(count * range.len());
            for (species, diffusion) in law.diffusion.iter().enumerate() {
                let out = &mut diffused[species * range.len()..(species + 1) * range.len()];
                diffusion.apply(Window { field: species, ..before }, row, range.clone(), out);
                law.edges[species].add(row, range.clone(), edge_values, out);
            }
            with_law!(
                &law.kinetics,
                kinetics => if let Some(uniform) = kinetics.uniform {
                    let mut cells = cells::<T, 2>(block, index, length, 0, &range, before, diffused);
                    let sums = stage::run(scaled, ComputedRates(uniform), &mut cells);
                    (0..2).for_each(|species| tally(block.tallies, species, sums[species]));
                    continue;
                } else {
                    let values = [0, 1].map(|species| Window { field: species, ..before }.row(row));
                    kinetics.row(row).rates(range.clone(), values, reacted);
                },
                _function => {}
            );
            for species in 0..count {
                let given = if law.kinetics.calls_back() {
                    &Window { field: species, ..of(self.given) }.row(row)[range.clone()]
                } else {
                    &reacted[species * range.len()..(species + 1) * range.len()]
                };
                let mut cells = cells::<T, 1>(block, index, length, species, &range, before, &diffused[species * range.len()..]);
                let [sums] = stage::run(scaled, GivenRates(given), &mut cells);
                tally(block.tallies, species, sums);
            }
        }
        for species in 0..count {
            let values = Window { field: species, ..before }.row(row);
            let [loss, gain] = law.exchange(species, row, values, edge_values);
            let tally = &mut block.tallies[index * count + species];
            tally.edges += scaled.weight * loss;
            tally.supply += scaled.weight * gain;
        }
        let ends = number == self.last;
        if ends && block.field[index * block.length..(index + 1) * block.length].iter().any(|value| !value.is_finite()) {
            largest = f64::NAN;
        }
        block.activity[index * block.stages + stage] = largest;
    }
}
