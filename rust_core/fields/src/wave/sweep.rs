//! Sweeps: one stage of a step over all rows. A sweep reads the displacement of the previous stage from one column and writes
//! that of the next to another, so no block waits for another.

use std::ops::Range;

use super::absorbing::Layers;
use super::fourth;
use super::medium::Medium;
use super::source::Sources;
use super::stage::{Input, Kernels, WaveStageAction, WaveSums};
use super::state::{DAMPING, EDGES, HELD, SINKS, SOURCE, WaveCells, WaveState, WaveTally};
use crate::grid::{Block, EdgeFace, EdgeValues, Padding, RowTable, Sweep, Window};
use crate::integrators::Facts;
use crate::integrators::REGISTERS;
use crate::math::Real;

/// Memory of the accelerations computed at a time, which stay in the first-level cache [bytes].
const SEGMENT: usize = 1 << 13;

/// Equation of motion: u'' = L u / r − γ u' + s.
pub struct WaveLaw<T> {
    pub medium: Medium<T>,
    /// Damping γ [1/s].
    pub damping: RowTable<T>,
    /// Whether each row is damped, contains a source, has values at edges or borders a layer, so its stages need the rate.
    pub exchanges: Vec<bool>,
    pub sources: Sources,
    pub edges: EdgeValues,
    /// Values at the edges at the time 0.
    pub levels: Vec<f64>,
    pub layers: Option<Layers<T>>,
    /// Position of the user's grid within all cells; energies are sums over this grid alone.
    pub padding: Padding,
    /// Mass of a cell ρ h^D at the largest density [kg].
    pub mass: f64,
}

/// Stage of a sweep.
#[derive(Debug, Clone, Copy)]
pub struct WavePass<'a> {
    pub action: WaveStageAction,
    /// Step size [s].
    pub h: f64,
    /// Amplitudes of the sources.
    pub amplitudes: &'a [f64],
    /// Values at the edges.
    pub edges: &'a [f64],
}

impl WavePass<'_> {
    /// Whether the stage is the first of a batch, which evaluates nothing.
    pub fn starts(&self) -> bool {
        matches!(self.action, WaveStageAction::Start)
    }
}

/// Stages of an integrator, as many as one pass over memory takes. The first stage of a batch reads all its input from `saved`.
pub struct Passes<'a, T> {
    pub dynamics: &'a WaveLaw<T>,
    pub method: &'a Facts,
    pub kernels: &'a Kernels<T>,
    pub stages: &'a [WavePass<'a>],
    pub saved: Option<&'a WaveState<T>>,
}

impl<T: Real> Sweep<T, WaveTally> for Passes<'_, T> {
    fn scratch(&self) -> usize {
        let WaveLaw { medium, .. } = self.dynamics;
        let length = medium.laplacian.grid.row_length();
        if medium.fourth.is_some() { (1 + fourth::SCRATCH) * length } else { (SEGMENT / size_of::<T>()).min(length) }
    }

    fn row(&self, stage: usize, block: &mut Block<'_, T, WaveTally>, index: usize, before: Window<'_, T>, scratch: &mut [T]) {
        self.stage_of_row(self.stages[stage], block, (index, stage), before, scratch);
    }
}

impl<T: Real> Passes<'_, T> {
    /// Runs a stage of a pass for a row, given by its index in the block.
    fn stage_of_row(
        &self,
        pass: WavePass<'_>,
        block: &mut Block<'_, T, WaveTally>,
        (index, stage): (usize, usize),
        rows: Window<'_, T>,
        scratch: &mut [T],
    ) {
        let Self { dynamics, method, kernels, saved, .. } = *self;
        let (row, length) = (block.first + index, block.length);
        let evaluates = !pass.starts();
        let damping = dynamics.exchanges[row].then(|| dynamics.damping.row(row));
        let inside = if dynamics.padding.crosses(row) { dynamics.padding.inside(2) } else { 0..0 };
        let (mut squares, mut power) = (0.0, [0.0; SINKS]);
        let mut start = 0;
        while start < length {
            let range = dynamics.segment(start, &inside);
            start = range.end;
            let own = row * length + range.start..row * length + range.end;
            let cells = WaveCells::of(block, index, range.clone());
            let mut input = Input {
                displacement: &rows.row(row)[range.clone()],
                rate: &[],
                persistent: [&[]; REGISTERS],
                acceleration: (),
                damping: damping.map(|damping| &damping[range.clone()]),
            };
            if let Some(saved) = saved.filter(|_| !evaluates) {
                input.displacement = &saved.displacement[own.clone()];
                input.rate = &saved.rate[own.clone()];
                for (register, column) in input.persistent.iter_mut().zip(&saved.persistent) {
                    *register = &column[own.clone()];
                }
            }
            // No buffer of accelerations: with it, steps in double precision would be a tenth slower, and in single precision a
            // fifth faster.
            let medium = &dynamics.medium;
            let plain = evaluates && !dynamics.exchanges[row] && dynamics.layers.is_none() && medium.fourth.is_none();
            let plane = || medium.laplacian.plane_row(rows, row, range.start);
            let fused = kernels.fused.filter(|_| plain).and_then(|fused| Some((fused, plane()?)));
            let sums = if let Some((fused, laplacian)) = fused {
                fused(method, cells, input.with(laplacian), pass.h, pass.action)
            } else {
                let (acceleration, scratch) = scratch.split_at_mut(range.len());
                let mut damped = None;
                if evaluates {
                    dynamics.accelerate(rows, row, range.clone(), acceleration, scratch);
                    dynamics.drive(row, range.clone(), pass, acceleration);
                    if let Some(layers) = &dynamics.layers {
                        layers.push(row, own.start, medium, acceleration);
                    }
                    if let Some(damping) = damping {
                        let velocity =
                            |cell: usize| mean_velocity(method, pass, &cells, acceleration, &damping[range.clone()], cell);
                        let [source, held] = dynamics.supplied(row, range.clone(), pass, velocity);
                        power[SOURCE] += source;
                        if inside.contains(&range.start) {
                            power[HELD] += held;
                        }
                        damped = dynamics.damped(row, range.clone(), cells.rate);
                        if let Some(layers) = &dynamics.layers {
                            let u = |cell: usize| rows.row(cell / length)[cell % length];
                            power[EDGES] += layers.power(row, own, velocity, u);
                        }
                    }
                }
                let sums = (kernels.buffered)(method, cells, input.with(&*acceleration), pass.h, pass.action);
                WaveSums { damping: damped.unwrap_or(sums.damping), ..sums }
            };
            if inside.contains(&range.start) {
                squares += sums.squares;
                power[DAMPING] += dynamics.mass * sums.damping;
            } else if !sums.squares.is_finite() {
                squares = f64::NAN;
            }
        }
        if damping.is_some() {
            integrate(method, &mut block.tallies[index], power, pass);
        }
        block.activity[index * block.stages + stage] = 0.5 * dynamics.mass * squares;
    }
}

impl<T: Real> WaveLaw<T> {
    /// Cells from `start` on that are computed at once: all inside, or all in layers.
    fn segment(&self, start: usize, inside: &Range<usize>) -> Range<usize> {
        let length = self.medium.laplacian.grid.row_length();
        if self.medium.fourth.is_some() {
            return 0..length;
        }
        let next = [inside.start, inside.end, length].into_iter().find(|&end| end > start).unwrap_or(length);
        start..(start + SEGMENT / size_of::<T>()).min(next)
    }

    /// Computes L u / r of some cells of a row.
    pub fn accelerate(&self, rows: Window<'_, T>, row: usize, range: Range<usize>, out: &mut [T], scratch: &mut [T]) {
        match &self.medium.fourth {
            Some(fourth) => fourth::accelerate((&self.medium, fourth), rows, row, out, scratch),
            None => self.medium.laplacian.apply(rows, row, range.clone(), out),
        }
        self.medium.divide(row, range, out);
    }

    /// Adds the accelerations by sources and by values at edges to those of some cells of a row.
    fn drive(&self, row: usize, range: Range<usize>, pass: WavePass<'_>, out: &mut [T]) {
        self.edges.add(row, range.clone(), pass.edges, out);
        self.sources.for_each(row, range, pass.amplitudes, |cell, driven| out[cell] += T::from_f64(driven));
    }

    /// Power of the sources, and of the values at edges that drive the wave, in some cells of a row [W].
    fn supplied(&self, row: usize, range: Range<usize>, pass: WavePass<'_>, velocity: impl Fn(usize) -> f64) -> [f64; 2] {
        let density = |cell: usize| self.medium.relative_density(row, range.start + cell);
        let (mut source, mut held) = (0.0, 0.0);
        self.sources
            .for_each(row, range.clone(), pass.amplitudes, |cell, driven| source += driven * velocity(cell) * density(cell));
        for face in self.edges.in_row(row).iter().filter(|face| range.contains(&face.column)) {
            let cell = face.column - range.start;
            held += face.weight * (pass.edges[face.slot] - self.level(face)) * velocity(cell) * density(cell);
        }
        [source, held].map(|power| self.mass * power)
    }

    /// Value at a face whose force is a part of the potential and does no work: g at the time 0, or 0 for a derivative.
    pub fn level(&self, face: &EdgeFace) -> f64 {
        if face.held { self.levels[face.slot] } else { 0.0 }
    }

    /// Sum Σ r γ v² over some cells of a row, if the density varies.
    fn damped(&self, row: usize, range: Range<usize>, rate: &[T]) -> Option<f64> {
        let density = &self.medium.density.as_ref()?.relative.row(row)[range.clone()];
        let factors = density.iter().zip(&self.damping.row(row)[range]);
        let powers = factors.zip(rate).map(|((r, gamma), v)| r.to_f64() * gamma.to_f64() * v.to_f64().powi(2));
        Some(powers.sum())
    }
}

/// Rate of a cell with which forces do work at a stage. At a kick it is the mean of the rates before and after, so the work
/// equals the change of energy by the kick. Otherwise it is the rate at the stage.
#[inline(always)]
fn mean_velocity<T: Real>(
    method: &Facts,
    pass: WavePass<'_>,
    cells: &WaveCells<'_, T>,
    acceleration: &[T],
    damping: &[T],
    cell: usize,
) -> f64 {
    let rate = cells.rate[cell].to_f64();
    match (pass.action, method.drifts_by_register()) {
        (WaveStageAction::Update { stage, .. }, Some(velocity)) => {
            // The kick that ends a step and the one that begins the next form a single kick.
            let next = if stage + 1 == method.stages() { method.last_weight } else { 0.0 };
            let half = 0.5 * (method.weights[stage] + next) * pass.h;
            cells.registers[velocity][cell].to_f64() + half * (acceleration[cell].to_f64() - damping[cell].to_f64() * rate)
        }
        _ => rate,
    }
}

/// Adds the energy through the sinks of a row during a stage.
fn integrate(method: &Facts, tally: &mut WaveTally, power: [f64; SINKS], pass: WavePass<'_>) {
    match pass.action {
        WaveStageAction::Begin => tally.last = power,
        WaveStageAction::Start => {}
        WaveStageAction::Update { stage, .. } => {
            let [weight, last] = method.weights_at(stage).map(|weight| pass.h * weight);
            for (sink, power) in power.into_iter().enumerate() {
                tally.energy[sink] += last * tally.last[sink] + weight * power;
                if stage + 1 == method.stages() {
                    tally.last[sink] = power;
                }
            }
        }
    }
}
