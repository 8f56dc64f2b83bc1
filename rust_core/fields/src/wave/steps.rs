//! Steps of a batch: stages in passes over memory.

use super::Wave;
use super::absorbing::Layers;
use super::stage::WaveStageAction;
use super::state::block;
use super::sweep::{Passes, WaveLaw, WavePass};
use crate::error::Result;
use crate::grid::{DEEPEST, Sweep};
use crate::math::Real;
use crate::parallel::Executor;
use crate::systems::Interval;

impl<T: Real> Wave<T> {
    /// Runs stages of all rows, as many as one pass over memory takes. The first stage of a batch starts from the saved state.
    fn pass(&mut self, passes: &[WavePass<'_>], executor: &Executor) {
        let Self { dynamics, method, kernels, state, saved, workspace, depth, .. } = self;
        let length = dynamics.medium.laplacian.grid.row_length();
        std::mem::swap(&mut state.displacement, &mut workspace.before);
        if *depth > 1 {
            let sweep = Passes { dynamics, method, kernels, stages: passes, saved: Some(saved) };
            sweep.pass(&dynamics.medium.laplacian.grid, passes.len(), block(state, workspace, length, *depth), executor);
        } else {
            self.sweep(passes[0], executor);
        }
        if passes.len().is_multiple_of(2) {
            std::mem::swap(&mut self.state.displacement, &mut self.workspace.before);
        }
    }

    /// Runs a sweep over all rows.
    pub(super) fn sweep(&mut self, pass: WavePass<'_>, executor: &Executor) {
        let Self { dynamics, method, kernels, state, saved, workspace, .. } = self;
        let length = dynamics.medium.laplacian.grid.row_length();
        let layers = |dynamics: &mut WaveLaw<T>, work: &dyn Fn(&mut Layers<T>)| dynamics.layers.iter_mut().for_each(work);
        if !pass.starts() {
            layers(dynamics, &|layers| layers.evaluate(&workspace.before, pass.action, pass.h, method));
        }
        let sweep = Passes { dynamics, method, kernels, stages: &[pass], saved: Some(saved) };
        sweep.sweep(block(state, workspace, length, 1), executor);
        layers(dynamics, &|layers| layers.advance(pass.action, pass.h, method, kernels.buffered));
    }

    /// Lists the amplitudes of the sources and the values at the edges at all stages of a batch.
    fn list_amplitudes(&mut self, interval: Interval) -> Result<()> {
        let Self { dynamics, method, workspace, .. } = self;
        let (amplitudes, edges) = (&mut workspace.amplitudes, &mut workspace.edges);
        amplitudes.clear();
        if dynamics.edges.vary() {
            edges.clear();
        }
        for step in 0..interval.steps {
            for &node in method.nodes {
                let time = interval.time(step, node);
                dynamics.sources.amplitudes(time, amplitudes)?;
                if dynamics.edges.vary() {
                    dynamics.edges.list(time, edges)?;
                }
            }
        }
        Ok(())
    }

    /// Takes the steps of a batch from the saved state.
    pub(super) fn steps(&mut self, interval: Interval, executor: &Executor) -> Result<()> {
        self.state.tallies.copy_from_slice(&self.saved.tallies);
        self.list_amplitudes(interval)?;
        let amplitudes = std::mem::take(&mut self.workspace.amplitudes);
        let edges = std::mem::take(&mut self.workspace.edges);
        let outcome = self.passes(interval, &amplitudes, &edges, executor);
        (self.workspace.amplitudes, self.workspace.edges) = (amplitudes, edges);
        outcome
    }

    fn passes(&mut self, interval: Interval, amplitudes: &[f64], edges: &[f64], executor: &Executor) -> Result<()> {
        let (stages, sources) = (self.method.stages(), self.dynamics.sources.count());
        let (count, vary) = (self.dynamics.edges.count(), self.dynamics.edges.vary());
        let last = interval.steps as usize * stages;
        let action = |index: usize| match index {
            0 => WaveStageAction::Start,
            _ => WaveStageAction::Update { stage: (index - 1) % stages, ends: index == last },
        };
        let pass = |index: usize| {
            let first = index.saturating_sub(1) * sources;
            let edges = &edges[if vary { index.saturating_sub(1) * count } else { 0 }..][..count];
            WavePass { action: action(index), h: interval.h, amplitudes: &amplitudes[first..first + sources], edges }
        };
        // Passes have equal depth, and their number is minimal.
        let depth = (last + 1).div_ceil((last + 1).div_ceil(self.depth));
        for first in (0..=last).step_by(depth) {
            let count = depth.min(last + 1 - first);
            let passes: [WavePass<'_>; DEEPEST] = std::array::from_fn(|index| pass((first + index).min(last)));
            self.pass(&passes[..count], executor);
            executor.check()?;
            for index in (first..first + count).filter(|&index| index > 0 && index.is_multiple_of(stages)) {
                let rows = self.workspace.kinetic.iter().skip(index - first).step_by(self.depth);
                self.activity.push(rows.sum());
            }
        }
        Ok(())
    }
}
