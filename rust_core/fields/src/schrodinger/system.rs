//! Wave function as a system: steps, history, plan, budgets and fields.

use super::absorbing::Layer;
use super::fourier::{FourierReal, norm, square};
use super::passes::Field;
use super::{Schrodinger, state};
use crate::error::{Error, Result};
use crate::history::{Archive, History, TALLIES};
use crate::ledger::{Budget, Class, Ledger};
use crate::parallel::Executor;
use crate::plan::Stages;
use crate::stability::{Horizon, Limit};
use crate::systems::{Element, Fault, FieldInfo, Hints, Interval, Location, RecordedSteps, System};

/// Maximum number of steps of a batch.
const STEPS: u64 = 1023;
/// Estimated duration of an evaluation of a cell [s].
const COST: f64 = 2e-8;

impl<T: FourierReal> Schrodinger<T> {
    fn element(&self, index: usize) -> Element {
        let padding = &self.hamiltonian.padding;
        let nearest = padding.nearest(index);
        let name = padding.inner.name(nearest);
        Element {
            name: if padding.outward(nearest) == index { name } else { format!("the layer beyond {name}") },
            index: nearest,
        }
    }

    /// Takes a step. The probability and the energy that layers absorb are measured at its end.
    fn step(&mut self, h: f64, executor: &Executor) {
        let Self { hamiltonian, method, absorption, state, other, scratch, .. } = self;
        let content = hamiltonian.padding.outer.content();
        let before = absorption.as_ref().map_or(0.0, |absorption| absorption.outside(&state.values));
        let mut field = Field::new(hamiltonian.padding.outer.cells, &mut state.values, other, scratch);
        let mut norm = method.step(hamiltonian, &mut field, h, executor);
        if let Some(absorption) = absorption {
            let outside = absorption.outside(field.values);
            state.removed += content * (outside - before);
            let energy = hamiltonian.energies(&mut field, method.is_spectral(), executor).total();
            absorption.fade(field.values, h);
            norm += absorption.outside(field.values) - outside;
            state.dissipated += energy - hamiltonian.energies(&mut field, method.is_spectral(), executor).total();
        }
        self.activity.push(self.reference * content * norm);
    }
}

impl<T: FourierReal> History for Schrodinger<T> {
    fn save(&mut self) {
        self.saved.clone_from(&self.state);
    }

    fn rollback(&mut self) {
        std::mem::swap(&mut self.saved, &mut self.state);
    }

    fn capture(&self, archive: &mut Archive) {
        archive.write("wave_function", self.state.values.iter().flat_map(|value| [value.re.to_f64(), value.im.to_f64()]));
        archive.write(TALLIES, self.state.tallies());
    }

    fn restore(&mut self, archive: &mut Archive) -> Result<()> {
        let numbers = archive.read_exactly("wave_function", 2 * self.state.values.len())?.as_chunks::<2>().0;
        for (value, pair) in self.state.values.iter_mut().zip(numbers) {
            (value.re, value.im) = (T::from_f64(pair[0]), T::from_f64(pair[1]));
        }
        let slots = self.state.tallies_mut();
        let tallies = archive.read_exactly(TALLIES, slots.len())?;
        slots.into_iter().zip(tallies).for_each(|(slot, &tally)| *slot = tally);
        Ok(())
    }
}

impl<T: FourierReal> System for Schrodinger<T> {
    fn stages(&self) -> Vec<Stages> {
        let hamiltonian = &self.hamiltonian;
        let potential = hamiltonian.potential.iter().any(|value| *value != T::ZERO);
        let (interacts, open) = (hamiltonian.interaction != 0.0, self.layer.is_some());
        let kinetic = if self.method.is_spectral() { "kinetic energy of the modes" } else { "kinetic energy by differences" };
        let mut names = vec![kinetic.to_owned()];
        let absent = [(potential, "potential"), (interacts, "interaction"), (open, "absorbing edges")];
        names.extend(absent.iter().filter(|(present, _)| *present).map(|&(_, name)| name.to_owned()));
        let note = |Layer { width, reflection, .. }| {
            let wavelength = "wavelengths near that of the mean kinetic energy at the start";
            format!("absorbing edges: layers of {width} cells, of which {reflection:.1e} comes back at {wavelength}")
        };
        let product = (self.method.name() == "CrankNicolson" && hamiltonian.padding.outer.dimension > 1)
            .then(|| "a product of Cayley forms along the axes: unitary, and ⟨H⟩ to the order dt²".to_owned());
        vec![Stages {
            item: String::new(),
            names,
            dimension: hamiltonian.padding.outer.dimension,
            precision: T::NAME,
            method: self.method.name(),
            // Absorption is a factor at the end of each step: order 1.
            order: if open { 1 } else { self.method.order() },
            evaluations: self.method.evaluations(hamiltonian),
            pairs: 0,
            force_error: 0.0,
            limit_varies: false,
            layout: "lines of cells along one axis after the other".to_owned(),
            left_out: absent.into_iter().filter(|(present, _)| !present).map(|(_, name)| name).collect(),
            notes: self.layer.map(note).into_iter().chain(product).collect(),
        }]
    }

    fn bytes(&self) -> usize {
        let memory = size_of_val(self.other.as_slice()) + size_of_val(self.scratch.as_slice());
        let potential = size_of_val(self.hamiltonian.potential.as_slice());
        let layers = self.absorption.as_ref().map_or(0, super::Absorption::bytes);
        self.state.bytes() + self.saved.bytes() + memory + potential + layers + self.method.bytes()
    }

    fn cost(&self) -> f64 {
        let grid = &self.hamiltonian.padding.outer;
        let passes = grid.dimension * (self.method.evaluations(&self.hamiltonian) + 2 * usize::from(self.layer.is_some()));
        1e-7 + COST * (passes * grid.count()) as f64
    }

    fn hints(&self) -> Hints {
        Hints::new(self.cost(), 1..=STEPS)
    }

    fn begin(&mut self, _time: f64, executor: &Executor) -> Result<()> {
        let energies = self.energies(executor);
        executor.check()?;
        self.reference = energies.magnitude() / (norm(&self.state.values) * self.hamiltonian.padding.outer.content());
        Ok(())
    }

    fn advance(&mut self, interval: Interval, _record: RecordedSteps, executor: &Executor) -> Result<()> {
        self.save();
        self.activity.clear();
        for _ in 0..interval.steps {
            self.step(interval.h, executor);
            if let Err(error) = executor.check() {
                self.rollback();
                return Err(error);
            }
        }
        Ok(())
    }

    fn activity(&self) -> &[f64] {
        &self.activity
    }

    fn limit(&self, _horizon: Horizon, _time: f64, _executor: &Executor) -> Result<Limit> {
        Ok(self.limit)
    }

    fn audit(&self, _time: f64, executor: &Executor) -> Result<Ledger> {
        let energies = self.energies(executor);
        executor.check()?;
        let mut ledger = Ledger::new(1, 1);
        ledger.add(Class::Kinetic, "kinetic", energies.kinetic);
        ledger.add(Class::Potential, "potential", energies.potential);
        ledger.add(Class::Potential, "interaction", energies.interaction);
        ledger.add(Class::Dissipated, "edges", self.state.dissipated);
        ledger.add(Class::Work, "source", self.state.work);
        ledger.add_budget(Budget {
            name: "probability".to_owned(),
            unit: "1",
            stored: self.probability(),
            removed: vec![("edges", self.state.removed)],
            supplied: vec![("source", self.state.supplied)],
        });
        Ok(ledger)
    }

    fn finite_audit(&self, time: f64, executor: &Executor) -> Result<Ledger> {
        let hint = || format!("a smaller wave function, potential or interaction; this is {}", T::NAME);
        self.audit(time, executor)?.finite().map_err(|error| error.with_hint(hint()))
    }

    fn fault(&self) -> Option<Fault> {
        let index = self.state.values.iter().position(|value| !(value.re.is_finite() && value.im.is_finite()))?;
        Some(Fault { element: self.element(index), quantity: "wave function" })
    }

    fn fastest(&self) -> Element {
        let density = |index: &usize| square(self.state.values[*index]);
        let densest = (0..self.state.values.len()).max_by(|one, other| density(one).total_cmp(&density(other)));
        self.element(densest.unwrap_or(0))
    }

    /// Descriptions of the density, and of the wave function with real and imaginary parts along a last axis.
    fn fields(&self) -> Vec<FieldInfo> {
        let shape = self.hamiltonian.padding.inner.shape();
        let pairs = shape.iter().copied().chain([2]).collect();
        let info = |name: &str, unit, shape, state| FieldInfo {
            name: name.to_owned(),
            unit,
            location: Location::Cells,
            shape,
            rate: None,
            state,
        };
        vec![info("density", "m^-D", shape, false), info("wave_function", "m^(-D/2)", pairs, true)]
    }

    fn read(&self, field: usize, _time: f64) -> Vec<f64> {
        let cells = state::rows(&self.hamiltonian.padding).flat_map(|cells| &self.state.values[cells]);
        if field == 0 {
            return cells.map(|&value| square(value)).collect();
        }
        cells.flat_map(|value| [value.re.to_f64(), value.im.to_f64()]).collect()
    }

    /// Replaces the wave function, except in layers.
    fn write(&mut self, fields: &[(&str, &[f64])], time: f64, executor: &Executor) -> Result<()> {
        let before = (self.audit(time, executor)?.total(), self.probability());
        let previous = self.state.clone();
        let done = fields.iter().try_for_each(|&(name, pairs)| {
            let grid = &self.hamiltonian.padding.inner;
            if name != "wave_function" || pairs.len() != 2 * grid.count() {
                let expected = format!("wave_function with {} numbers", 2 * grid.count());
                return Err(Error::parameter(format!("set.{name}"), expected, pairs.len()));
            }
            let values = state::narrow(pairs, grid, "set.wave_function")?;
            let padding = &self.hamiltonian.padding;
            values.into_iter().enumerate().for_each(|(cell, value)| self.state.values[padding.outward(cell)] = value);
            Ok(())
        });
        let done = done.and_then(|()| self.begin(time, executor)).and_then(|()| {
            self.state.work += self.finite_audit(time, executor)?.total() - before.0;
            self.state.supplied += self.probability() - before.1;
            Ok(())
        });
        if done.is_err() {
            self.state = previous;
            self.begin(time, executor)?;
        }
        done
    }
}
