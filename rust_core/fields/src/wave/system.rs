//! Wave as a system: history, plan, budget and fields.

use std::f64::consts::TAU;

use super::absorbing::{AbsorptionParameters, Layers};
use super::stage::WaveStageAction;
use super::state::{DAMPING, EDGES, HELD, SOURCE};
use super::sweep::WavePass;
use super::{Wave, budget, limit};
use crate::error::Result;
use crate::history::{Archive, History};
use crate::ledger::{Class, Ledger};
use crate::math::Real;
use crate::parallel::Executor;
use crate::plan::Stages;
use crate::stability::{Horizon, Limit};
use crate::systems::{Control, Element, Fault, FieldInfo, Hints, Interval, RecordedSteps, System};

/// Wavelength for which the plan states the reflection of layers [cells].
const SHORT_WAVE: f64 = 20.0;
/// Minimum and maximum number of steps of a batch: the state at its start costs a sweep, and its activities cost memory.
const STEPS: std::ops::RangeInclusive<u64> = 31..=4095;
/// Estimated duration of a stage of a cell [s].
const COST: f64 = 6e-10;

impl<T: Real> Wave<T> {
    fn element(&self, index: usize) -> Element {
        let padding = &self.dynamics.padding;
        let nearest = padding.nearest(index);
        let name = padding.inner.name(nearest);
        Element {
            name: if padding.outward(nearest) == index { name } else { format!("the layer beyond {name}") },
            index: nearest,
        }
    }
}

/// Saves displacement, rate, the persistent registers of the integrator, and the tallies.
impl<T: Real> History for Wave<T> {
    /// Swaps the states: steps read the saved state and write the other.
    fn save(&mut self) {
        std::mem::swap(&mut self.saved, &mut self.state);
        self.dynamics.layers.iter_mut().for_each(Layers::save);
    }

    fn rollback(&mut self) {
        std::mem::swap(&mut self.saved, &mut self.state);
        self.dynamics.layers.iter_mut().for_each(Layers::rollback);
    }

    fn capture(&self, archive: &mut Archive) {
        self.state.capture(archive);
        self.dynamics.layers.iter().for_each(|layers| archive.within("layers", |archive| layers.capture(archive)));
    }

    fn restore(&mut self, archive: &mut Archive) -> Result<()> {
        self.state.restore(archive)?;
        self.dynamics.layers.iter_mut().try_for_each(|layers| archive.within("layers", |archive| layers.restore(archive)))
    }
}

impl<T: Real> System for Wave<T> {
    fn stages(&self) -> Vec<Stages> {
        let medium = &self.dynamics.medium;
        let (damped, driven) = (self.is_damped(), self.dynamics.sources.count() > 0);
        let order = if medium.fourth.is_some() { 4 } else { 2 };
        let density = if medium.density.is_some() { " with varying density" } else { "" };
        let mut names = vec![format!("wave operator of order {order}{density}")];
        names.extend(damped.then(|| "damping".to_owned()));
        names.extend(driven.then(|| "sources".to_owned()));
        names.extend((!self.dynamics.edges.is_empty()).then(|| "values at the edges".to_owned()));
        names.extend(self.absorption.map(|_| "absorbing edges".to_owned()));
        names.push("update of displacement and rate".to_owned());
        let open = self.absorption.is_some();
        let absent = [(damped, "damping"), (driven, "sources"), (self.walls.is_some(), "walls"), (open, "absorbing edges")];
        let note = |absorption: AbsorptionParameters| {
            let (width, returned) = (absorption.width, absorption.returned(TAU / SHORT_WAVE));
            let wave = format!("of a wave of {SHORT_WAVE} cells at normal incidence");
            format!("absorbing edges: layers of {width} cells, which return {returned:.1e} of the amplitude {wave}")
        };
        let layout = match self.depth {
            1 => "a sweep over all cells per evaluation".to_owned(),
            depth => format!("{depth} evaluations in one pass over memory, row by row"),
        };
        vec![Stages {
            item: String::new(),
            names,
            dimension: medium.laplacian.grid.dimension,
            precision: T::NAME,
            method: self.method.name,
            order: if damped || open { self.method.order_dissipative } else { self.method.order },
            evaluations: self.method.stages(),
            pairs: 0,
            force_error: 0.0,
            limit_varies: false,
            layout,
            left_out: absent.into_iter().filter(|(present, _)| !present).map(|(_, name)| name).collect(),
            notes: self.absorption.map(note).into_iter().collect(),
        }]
    }

    fn bytes(&self) -> usize {
        let walls = self.walls.as_ref().map_or(0, Vec::len);
        let dynamics = &self.dynamics;
        let layers = dynamics.layers.as_ref().map_or(0, Layers::bytes);
        let coefficients =
            layers + dynamics.medium.bytes() + dynamics.damping.bytes() + dynamics.sources.bytes() + dynamics.edges.bytes();
        self.state.bytes() + self.saved.bytes() + self.workspace.bytes() + coefficients + walls
    }

    fn cost(&self) -> f64 {
        let stages = self.method.stages() as f64;
        stages * (1e-7 + COST * self.dynamics.medium.laplacian.grid.count() as f64)
    }

    /// Batches are of one step for user-defined functions, which are called at least once per evaluation, in the order of time.
    /// The potential energy is at least 0, because it is a sum of squares.
    fn hints(&self) -> Hints {
        let hints = Hints::new(self.cost(), STEPS);
        let calls_back = self.dynamics.sources.calls_back() || self.dynamics.edges.vary();
        Hints {
            most_steps: if calls_back { 1 } else { hints.most_steps },
            linear: self.dynamics.sources.count() == 0 && self.dynamics.edges.is_empty() && self.absorption.is_none(),
            gains_energy: self.method.gains_energy(),
            lowest_potential: Some(0.0),
            ..hints
        }
    }

    fn begin(&mut self, time: f64, executor: &Executor) -> Result<()> {
        self.workspace.amplitudes.clear();
        let Self { dynamics, workspace, .. } = self;
        dynamics.sources.amplitudes(time, &mut workspace.amplitudes)?;
        workspace.edges.clear();
        dynamics.edges.list(time, &mut workspace.edges)?;
        let (amplitudes, edges) = (std::mem::take(&mut workspace.amplitudes), std::mem::take(&mut workspace.edges));
        std::mem::swap(&mut self.state.displacement, &mut self.workspace.before);
        self.sweep(WavePass { action: WaveStageAction::Begin, h: 0.0, amplitudes: &amplitudes, edges: &edges }, executor);
        (self.workspace.amplitudes, self.workspace.edges) = (amplitudes, edges);
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

    fn limit(&self, _horizon: Horizon, _time: f64, _executor: &Executor) -> Result<Limit> {
        Ok(*self.limit.get_or_init(|| limit::limit(&self.dynamics, &self.method)))
    }

    fn error(&self, h: f64) -> Option<(f64, Control)> {
        let [x, v] = self.method.error?.map(|register| {
            let persistent = self.state.persistent.len();
            if register < persistent {
                &self.state.persistent[register]
            } else {
                &self.workspace.registers[register - persistent]
            }
        });
        let of = |(x, v): (&T, &T)| x.to_f64().abs().max(h * v.to_f64().abs());
        Some((x.iter().zip(v).map(of).fold(0.0, f64::max), Control::pair(self.method.order)))
    }

    fn audit(&self, time: f64, executor: &Executor) -> Result<Ledger> {
        let energies = self.dynamics.energies(&self.state, executor);
        executor.check()?;
        let mut ledger = Ledger::new(self.state.tallies.len(), 1);
        let sum = |of: fn(&budget::RowEnergy) -> f64| self.dynamics.mass * energies.iter().map(of).sum::<f64>();
        let tallied = |sink: usize| self.state.tallies.iter().map(|tally| tally.energy[sink]).sum();
        ledger.add(Class::Kinetic, "kinetic", sum(|row| row.kinetic));
        let mut edges = Vec::new();
        self.dynamics.edges.list(time, &mut edges)?;
        let imposed = self.dynamics.imposed(&self.state, &edges);
        ledger.add(Class::Potential, "wave", sum(|row| row.potential) - imposed.all);
        ledger.add(Class::Dissipated, "damping", tallied(DAMPING));
        ledger.add(Class::Dissipated, "edges", tallied(EDGES));
        ledger.add(Class::Work, "source", tallied(SOURCE));
        if !self.dynamics.edges.is_empty() {
            ledger.add(Class::Work, "edges", tallied(HELD) - imposed.driven);
        }
        Ok(ledger)
    }

    fn finite_audit(&self, time: f64, executor: &Executor) -> Result<Ledger> {
        let ledger = self.audit(time, executor)?.finite();
        ledger.map_err(|error| error.with_hint("smaller displacements, rates, speeds or densities"))
    }

    fn resolvable(&self, time: f64, h: f64) -> f64 {
        let mut edges = Vec::new();
        if self.dynamics.edges.list(time, &mut edges).is_err() {
            return 0.0;
        }
        0.5 * self.dynamics.mass * h * h * self.dynamics.squared_accelerations(&self.state, &edges)
    }

    fn fault(&self) -> Option<Fault> {
        let columns = [("displacement", &self.state.displacement), ("rate", &self.state.rate)];
        columns.into_iter().find_map(|(quantity, column)| {
            let index = column.iter().position(|value| !value.is_finite())?;
            Some(Fault { element: self.element(index), quantity })
        })
    }

    fn fastest(&self) -> Element {
        let rate = |index: &usize| self.state.rate[*index].to_f64().abs();
        let fastest = (0..self.state.rate.len()).max_by(|one, other| rate(one).total_cmp(&rate(other)));
        self.element(fastest.unwrap_or(0))
    }

    fn fields(&self) -> Vec<FieldInfo> {
        self.field_infos()
    }

    fn read(&self, field: usize, _time: f64) -> Vec<f64> {
        self.values(field)
    }

    fn write(&mut self, fields: &[(&str, &[f64])], time: f64, executor: &Executor) -> Result<()> {
        self.replace(fields, time, executor)
    }
}
