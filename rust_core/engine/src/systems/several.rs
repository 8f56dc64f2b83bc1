//! Several systems in one scene, with one clock, one budget and one divergence monitor.
//!
//! Each system takes its own steps, batch by batch, in the order of the scene. In steps of a given size, a system whose own limit
//! is smaller takes equal substeps: see [`Division`]. Systems meet by [couplings](Coupling) alone:
//!
//! ```text
//!     batch:   system 0 ─ follow ─ system 1 ─ follow ─ …
//!     begin, rollback, restore, write:   all systems ─ update
//! ```
//!
//! Fields of other systems than matter are named after their items.

mod division;

use super::{Control, Coupling, Element, Fault, FieldInfo, Hints, Interval, RecordedSteps, Sample, System, SystemPart};
use crate::error::{Error, Result};
use crate::history::{Archive, History};
use crate::ledger::Ledger;
use crate::parallel::Executor;
use crate::plan::Stages;
use crate::stability::{Horizon, Limit};
pub use division::Division;

/// Name of the limits of divided steps in archives.
const DIVISION: &str = "division";
/// Name of matter in notes.
const MATTER: &str = "matter";

/// Writes or reads what belongs to a system, under the name of its item.
fn within<T>(item: &str, archive: &mut Archive, act: impl FnOnce(&mut Archive) -> T) -> T {
    if item.is_empty() { act(archive) } else { archive.within(&format!("systems/{item}"), act) }
}

/// Systems of a scene, at least one.
pub struct Several {
    parts: Vec<SystemPart>,
    couplings: Vec<Box<dyn Coupling>>,
    division: Division,
    /// Sums of the systems' activities [J].
    activity: Vec<f64>,
}

impl Several {
    /// Combines several systems into one.
    pub fn new(parts: Vec<SystemPart>, couplings: Vec<Box<dyn Coupling>>) -> Self {
        Self { parts, couplings, division: Division::default(), activity: Vec::new() }
    }

    /// Updates what the systems know of each other.
    fn update(&mut self) {
        self.couplings.iter().for_each(|coupling| coupling.update(&mut self.parts));
    }

    fn systems(&self) -> impl Iterator<Item = &dyn System> {
        self.parts.iter().map(|part| &*part.system)
    }

    /// Systems with the numbers of their substeps.
    fn divided_systems(&self) -> impl Iterator<Item = (&dyn System, u64)> {
        self.systems().enumerate().map(|(index, system)| (system, self.division.substeps(index)))
    }

    /// Adds the part's name to an element.
    fn named(part: &SystemPart, element: Element) -> Element {
        let name = if part.name.is_empty() { element.name } else { format!("{} of {}", element.name, part.name) };
        Element { name, ..element }
    }

    /// Restores systems that were written to, after an error.
    fn take_back(&mut self, written: Vec<(usize, Archive)>, error: Error) -> Result<()> {
        written.into_iter().try_for_each(|(index, mut before)| self.parts[index].system.restore(&mut before))?;
        Err(error)
    }

    fn path(part: &SystemPart, field: &str) -> String {
        if part.name.is_empty() { field.to_owned() } else { format!("{}.{field}", part.name) }
    }

    /// Part and field of an index into all fields.
    fn locate(&self, mut field: usize) -> Option<(&SystemPart, usize)> {
        for part in &self.parts {
            let count = part.system.fields().len();
            if field < count {
                return Some((part, field));
            }
            field -= count;
        }
        None
    }

    /// Sums the activities over all systems, if each recorded the same steps; otherwise those after the last step.
    fn add_up(&mut self) {
        let Self { parts, division, activity, .. } = self;
        let substeps = |index: usize| division.substeps(index) as usize;
        let recorded = |(index, part): (usize, &SystemPart)| part.system.activity().len().div_ceil(substeps(index));
        let steps = parts.iter().enumerate().map(recorded).min().unwrap_or(0);
        let steps = if parts.iter().enumerate().all(|part| recorded(part) == steps) { steps } else { steps.min(1) };
        activity.clear();
        activity.resize(steps, 0.0);
        for (index, part) in parts.iter().enumerate() {
            let own = part.system.activity().iter().rev().step_by(substeps(index));
            activity.iter_mut().rev().zip(own).for_each(|(sum, activity)| *sum += activity);
        }
    }
}

impl History for Several {
    fn save(&mut self) {
        self.parts.iter_mut().for_each(|part| part.system.save());
    }

    fn rollback(&mut self) {
        self.parts.iter_mut().for_each(|part| part.system.rollback());
        self.update();
    }

    fn capture(&self, archive: &mut Archive) {
        for SystemPart { name, system } in &self.parts {
            within(name, archive, |archive| system.capture(archive));
        }
        if self.division.h > 0.0 {
            let Division { h, limits, until } = &self.division;
            archive.write(DIVISION, [*h, *until as f64].into_iter().chain(limits.iter().copied()));
        }
    }

    fn restore(&mut self, archive: &mut Archive) -> Result<()> {
        let mut parts = self.parts.iter_mut();
        let restored = parts.try_for_each(|SystemPart { name, system }| within(name, archive, |archive| system.restore(archive)));
        self.update();
        self.division = Division::default();
        if archive.read(DIVISION).is_ok() {
            let numbers = archive.read_exactly(DIVISION, 2 + self.parts.len())?;
            self.division = Division { h: numbers[0], limits: numbers[2..].to_vec(), until: numbers[1] as u64 };
        }
        restored
    }
}

impl System for Several {
    fn stages(&self) -> Vec<Stages> {
        let named = |(index, part): (usize, &SystemPart)| {
            let name = if part.name.is_empty() { MATTER } else { &part.name };
            let (note, substeps) = (self.division.note(index, name), self.division.substeps(index) as usize);
            let item = |own: String| if part.name.is_empty() { own } else { part.name.clone() };
            let stages = part.system.stages().into_iter().map(|stages| Stages {
                item: item(stages.item),
                evaluations: stages.evaluations * substeps,
                notes: note.iter().cloned().chain(stages.notes).collect(),
                ..stages
            });
            stages.collect::<Vec<_>>()
        };
        self.parts.iter().enumerate().flat_map(named).collect()
    }

    fn bytes(&self) -> usize {
        self.systems().map(System::bytes).sum()
    }

    fn cost(&self) -> f64 {
        self.divided_systems().map(|(system, substeps)| system.cost() * substeps as f64).sum()
    }

    fn hints(&self) -> Hints {
        let hints = self.divided_systems().map(|(system, substeps)| system.hints().in_parts(substeps));
        hints.reduce(Hints::and).unwrap_or(Hints::new(0.0, 1..=1))
    }

    fn begin(&mut self, time: f64, executor: &Executor) -> Result<()> {
        self.parts.iter_mut().try_for_each(|part| part.system.begin(time, executor))?;
        self.update();
        Ok(())
    }

    fn advance(&mut self, interval: Interval, record: RecordedSteps, executor: &Executor) -> Result<()> {
        for index in 0..self.parts.len() {
            let own = interval.in_parts(self.division.substeps(index));
            let recorded = self.division.recorded(index, interval.steps, record);
            let outcome = self.parts[index].system.advance(own, recorded, executor);
            if outcome.is_err() {
                self.parts[..index].iter_mut().for_each(|part| part.system.rollback());
                self.update();
                return outcome;
            }
            self.couplings.iter().for_each(|coupling| coupling.follow(&mut self.parts, index));
        }
        self.add_up();
        Ok(())
    }

    fn activity(&self) -> &[f64] {
        &self.activity
    }

    fn resolvable(&self, time: f64, h: f64) -> f64 {
        self.divided_systems().map(|(system, substeps)| system.resolvable(time, h / substeps as f64)).sum()
    }

    /// Smallest limit of each kind over all systems, of steps that are divided as at present.
    fn limit(&self, horizon: Horizon, time: f64, executor: &Executor) -> Result<Limit> {
        let own = |(system, substeps): (&dyn System, u64)| {
            system.limit(horizon, time, executor).map(|limit| limit.in_parts(substeps as usize))
        };
        let limits = self.divided_systems().map(own).collect::<Result<Vec<_>>>()?;
        let binding = limits.iter().min_by(|one, other| one.dt().total_cmp(&other.dt())).copied().unwrap_or(Limit::NONE);
        let least = |of: fn(&Limit) -> f64| limits.iter().map(of).fold(f64::INFINITY, f64::min);
        Ok(Limit {
            stability: least(|limit| limit.stability),
            accuracy: least(|limit| limit.accuracy),
            certified: least(|limit| limit.certified),
            endured: least(|limit| limit.endured),
            ..binding
        })
    }

    fn limit_varies(&self, horizon: Horizon, time: f64) -> bool {
        self.systems().any(|system| system.limit_varies(horizon, time))
    }

    /// Largest error, and control of the lowest order, over all systems; None if a system has no estimate.
    fn error(&self, h: f64) -> Option<(f64, Control)> {
        let errors: Option<Vec<_>> = self.systems().map(|system| system.error(h)).collect();
        let lower = |one: Control, other: Control| if other.order < one.order { other } else { one };
        errors?.into_iter().reduce(|(error, one), (larger, other)| (error.max(larger), lower(one, other)))
    }

    fn audit(&self, time: f64, executor: &Executor) -> Result<Ledger> {
        let mut ledger = Ledger::new(0, 1);
        self.systems().try_for_each(|system| system.audit(time, executor).map(|own| ledger.merge(&own)))?;
        Ok(ledger)
    }

    fn finite_audit(&self, time: f64, executor: &Executor) -> Result<Ledger> {
        let mut ledger = Ledger::new(0, 1);
        self.systems().try_for_each(|system| system.finite_audit(time, executor).map(|own| ledger.merge(&own)))?;
        Ok(ledger)
    }

    fn fault(&self) -> Option<Fault> {
        self.parts
            .iter()
            .find_map(|part| part.system.fault().map(|fault| Fault { element: Self::named(part, fault.element), ..fault }))
    }

    /// Fastest element of the system with the most kinetic energy.
    fn fastest(&self) -> Element {
        let kinetic = |part: &&SystemPart| part.system.activity().last().copied().unwrap_or_default();
        let fastest = self.parts.iter().max_by(|one, other| kinetic(one).total_cmp(&kinetic(other)));
        let none = || Element { name: "nothing".to_owned(), index: 0 };
        fastest.map_or_else(none, |part| Self::named(part, part.system.fastest()))
    }

    fn fields(&self) -> Vec<FieldInfo> {
        let named = |part: &SystemPart| {
            let fields = part.system.fields().into_iter();
            let named = |field: FieldInfo| {
                let rate = field.rate.as_ref().map(|rate| Self::path(part, rate));
                FieldInfo { name: Self::path(part, &field.name), rate, ..field }
            };
            fields.map(named).collect::<Vec<_>>()
        };
        self.parts.iter().flat_map(named).collect()
    }

    fn read(&self, field: usize, time: f64) -> Vec<f64> {
        self.locate(field).map_or_else(Vec::new, |(part, field)| part.system.read(field, time))
    }

    fn read_into(&self, field: usize, time: f64, values: &mut [f64]) {
        if let Some((part, field)) = self.locate(field) {
            part.system.read_into(field, time, values);
        }
    }

    fn write(&mut self, fields: &[(&str, &[f64])], time: f64, executor: &Executor) -> Result<()> {
        let names: Vec<Vec<String>> =
            self.parts.iter().map(|part| part.system.fields().into_iter().map(|field| field.name).collect()).collect();
        let belongs = |part: &SystemPart, names: &[String], name: &str| names.iter().any(|own| Self::path(part, own) == name);
        for (name, _) in fields {
            if !self.parts.iter().zip(&names).any(|(part, names)| belongs(part, names, name)) {
                return Err(Error::parameter(format!("set.{name}"), "the name of a field", name));
            }
        }
        let mut written: Vec<(usize, Archive)> = Vec::new();
        for (index, names) in names.iter().enumerate() {
            let part = &mut self.parts[index];
            let prefix = if part.name.is_empty() { 0 } else { part.name.len() + 1 };
            let own: Vec<_> = fields.iter().filter(|(name, _)| belongs(part, names, name)).collect();
            if own.is_empty() {
                continue;
            }
            let own: Vec<(&str, &[f64])> = own.into_iter().map(|(name, values)| (&name[prefix..], *values)).collect();
            let mut before = Archive::default();
            part.system.capture(&mut before);
            if let Err(error) = part.system.write(&own, time, executor) {
                return self.take_back(written, error);
            }
            written.push((index, before));
        }
        if self.division.h > 0.0 {
            match self.divided(self.division.h, 0, time, executor) {
                Ok(division) => self.division = division,
                Err(error) => return self.take_back(written, error),
            }
        }
        self.update();
        Ok(())
    }

    /// Samples the fields of matter, which is the first system.
    fn sample(&self, sample: &Sample<'_>, executor: &Executor) -> Result<Vec<f64>> {
        self.parts[0].system.sample(sample, executor)
    }
}

#[cfg(test)]
mod tests;
