//! Steps of a batch: stages in passes over memory.

use super::law::{SpeciesPass, SpeciesTally};
use super::stage::SpeciesStage;
use super::{ReactionDiffusion, SpeciesState, SpeciesWorkspace};
use crate::error::Result;
use crate::grid::{Block, Sweep};
use crate::math::Real;
use crate::parallel::Executor;
use crate::systems::Interval;

/// Block of all rows of a state, for writing by stages.
fn block<'a, T>(
    state: &'a mut SpeciesState<T>,
    before: &'a mut Vec<T>,
    columns: &'a mut [Vec<T>],
    activity: &'a mut [f64],
    width: usize,
    stages: usize,
) -> Block<'a, T, SpeciesTally> {
    let mut columns = columns.iter_mut().map(Vec::as_mut_slice);
    Block {
        first: 0,
        rows: state.field.len() / width,
        field: &mut state.field,
        before,
        columns: std::array::from_fn(|_| columns.next().unwrap_or_default()),
        tallies: &mut state.tallies,
        activity,
        stages,
        length: width,
    }
}

impl<T: Real> ReactionDiffusion<T> {
    /// Takes the steps of a batch from the saved state.
    pub(super) fn steps(&mut self, interval: Interval, executor: &Executor) -> Result<()> {
        self.state.tallies.copy_from_slice(&self.saved.tallies);
        if self.workspace.stages.0 != interval.h {
            let stages = self.method.stages(interval.h, self.fastest.0);
            self.workspace.stages = (interval.h, stages.iter().map(|stage| SpeciesStage::new(stage, interval.h)).collect());
        }
        let each = self.workspace.stages.1.len();
        if self.law.edges_vary() {
            let nodes: Vec<f64> = self.workspace.stages.1.iter().map(|stage| stage.node).collect();
            let stages = (0..interval.steps).flat_map(|step| nodes.iter().map(move |&node| interval.time(step, node)));
            self.list_edges(stages.chain([interval.time(interval.steps, 0.0)]))?;
        }
        let last = interval.steps as usize * each - 1;
        // Passes have equal depth, and their number is minimal.
        let depth = (last + 1).div_ceil((last + 1).div_ceil(self.depth));
        for first in (0..=last).step_by(depth) {
            let count = depth.min(last + 1 - first);
            self.pass(first, count, last, executor)?;
            executor.check()?;
            for index in (first..first + count).filter(|index| (index + 1).is_multiple_of(each)) {
                let rows = self.workspace.activity.iter().skip(index - first).step_by(self.depth);
                self.activity.push(rows.fold(0.0, |most, &row| if row.is_nan() || row > most { row } else { most }));
            }
        }
        Ok(())
    }

    /// Lists the values at the edges at some times [s]. If a function fails, the list is the one before.
    pub(super) fn list_edges(&mut self, times: impl Iterator<Item = f64>) -> Result<()> {
        let Self { law, workspace, .. } = self;
        let before = workspace.edges.len();
        for time in times {
            if let Err(error) = law.edges.iter().try_for_each(|edges| edges.list(time, &mut workspace.edges)) {
                workspace.edges.truncate(before);
                return Err(error);
            }
        }
        workspace.edges.drain(..before);
        Ok(())
    }

    /// Runs some stages of all rows, as many as one pass over memory takes.
    fn pass(&mut self, first: usize, count: usize, last: usize, executor: &Executor) -> Result<()> {
        std::mem::swap(&mut self.state.field, &mut self.workspace.before);
        if self.law.kinetics.calls_back() {
            let latest = if first == 0 { &self.saved.field } else { &self.workspace.before };
            self.workspace.given = self.given(latest)?.unwrap_or_default();
        }
        let Self { law, state, saved, workspace, depth, .. } = self;
        let SpeciesWorkspace { before, columns, activity, given, stages, edges } = workspace;
        let pass = SpeciesPass { law, stages: &stages.1, first, last, start: &saved.field, edges, given };
        let block = block(state, before, columns, activity, law.width(), *depth);
        if *depth > 1 {
            pass.pass(&law.grid, count, block, executor);
        } else {
            pass.sweep(block, executor);
        }
        if count.is_multiple_of(2) {
            std::mem::swap(&mut self.state.field, &mut self.workspace.before);
        }
        Ok(())
    }
}
