//! Several systems in one scene, with one clock, one budget and one divergence monitor.
//!
//! Each system takes its own steps of one length, batch by batch. Systems are independent of each other. Fields of other
//! systems than the first are named after their items.

use glam::DVec3;

use super::{Element, Fault, FieldInfo, Interval, RecordedSteps, Sample, System};
use crate::error::{Error, Result};
use crate::history::{Archive, History};
use crate::ledger::Ledger;
use crate::parallel::Executor;
use crate::plan::Stages;
use crate::stability::{Horizon, Limit};
use crate::systems::Mach;

/// A system, and the name of its item in the scene; empty for matter, and for a system of several items.
pub struct SystemPart {
    /// Name of the item.
    pub name: String,
    /// The system.
    pub system: Box<dyn System>,
}

/// Systems of a scene, at least one.
pub struct Several {
    parts: Vec<SystemPart>,
    /// Sums of the systems' activities [J].
    activity: Vec<f64>,
}

impl Several {
    /// Combines several systems into one.
    pub fn new(parts: Vec<SystemPart>) -> Self {
        Self { parts, activity: Vec::new() }
    }

    fn systems(&self) -> impl Iterator<Item = &dyn System> {
        self.parts.iter().map(|part| &*part.system)
    }

    /// Adds the part's name to an element.
    fn named(part: &SystemPart, element: Element) -> Element {
        let name = if part.name.is_empty() { element.name } else { format!("{} of {}", element.name, part.name) };
        Element { name, ..element }
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

    /// Sums the activities over all systems, if each recorded the same number; otherwise those after the last step.
    fn add_up(&mut self) {
        let Self { parts, activity } = self;
        let recorded = |part: &SystemPart| part.system.activity().len();
        let steps = parts.iter().map(recorded).min().unwrap_or(0);
        let steps = if parts.iter().all(|part| recorded(part) == steps) { steps } else { steps.min(1) };
        activity.clear();
        activity.resize(steps, 0.0);
        for part in parts {
            let own = part.system.activity();
            activity.iter_mut().zip(&own[own.len() - steps..]).for_each(|(sum, activity)| *sum += activity);
        }
    }
}

impl History for Several {
    fn save(&mut self) {
        self.parts.iter_mut().for_each(|part| part.system.save());
    }

    fn rollback(&mut self) {
        self.parts.iter_mut().for_each(|part| part.system.rollback());
    }

    fn capture(&self, archive: &mut Archive) {
        self.systems().for_each(|system| system.capture(archive));
    }

    fn restore(&mut self, archive: &mut Archive) -> Result<()> {
        self.parts.iter_mut().try_for_each(|part| part.system.restore(archive))
    }
}

impl System for Several {
    fn stages(&self) -> Vec<Stages> {
        let named = |part: &SystemPart| {
            let name = part.name.clone();
            let item = move |own: String| if name.is_empty() { own } else { name.clone() };
            part.system.stages().into_iter().map(move |stages| Stages { item: item(stages.item.clone()), ..stages })
        };
        self.parts.iter().flat_map(named).collect()
    }

    fn bytes(&self) -> usize {
        self.systems().map(System::bytes).sum()
    }

    fn cost(&self) -> f64 {
        self.systems().map(System::cost).sum()
    }

    fn iterates(&self) -> bool {
        self.systems().any(System::iterates)
    }

    fn most_steps(&self) -> u64 {
        self.systems().map(System::most_steps).min().unwrap_or(1)
    }

    fn most_recorded(&self) -> u64 {
        self.systems().map(System::most_recorded).min().unwrap_or(1)
    }

    fn begin(&mut self, time: f64, executor: &Executor) -> Result<()> {
        self.parts.iter_mut().try_for_each(|part| part.system.begin(time, executor))
    }

    fn advance(&mut self, interval: Interval, record: RecordedSteps, executor: &Executor) -> Result<()> {
        for index in 0..self.parts.len() {
            let outcome = self.parts[index].system.advance(interval, record, executor);
            if outcome.is_err() {
                self.parts[..index].iter_mut().for_each(|part| part.system.rollback());
                return outcome;
            }
        }
        self.add_up();
        Ok(())
    }

    fn activity(&self) -> &[f64] {
        &self.activity
    }

    fn amplitude(&self) -> Option<f64> {
        self.systems().filter_map(System::amplitude).reduce(f64::max)
    }

    fn is_linear(&self) -> bool {
        self.systems().all(System::is_linear)
    }

    fn gains_energy(&self) -> bool {
        self.systems().any(System::gains_energy)
    }

    /// Smallest limit of each kind over all systems.
    fn limit(&self, horizon: Horizon, time: f64, executor: &Executor) -> Result<Limit> {
        let limits = self.systems().map(|system| system.limit(horizon, time, executor)).collect::<Result<Vec<_>>>()?;
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

    /// Largest error and lowest order over all systems; None if a system has no estimate.
    fn error(&self, h: f64) -> Option<(f64, u32)> {
        let errors: Option<Vec<_>> = self.systems().map(|system| system.error(h)).collect();
        errors?.into_iter().reduce(|(one, order), (other, lower)| (one.max(other), order.min(lower)))
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

    fn lowest_potential(&self) -> Option<f64> {
        self.systems().map(System::lowest_potential).sum()
    }

    fn momenta(&self) -> (DVec3, DVec3) {
        let add = |sum: (DVec3, DVec3), own: (DVec3, DVec3)| (sum.0 + own.0, sum.1 + own.1);
        self.systems().map(System::momenta).fold((DVec3::ZERO, DVec3::ZERO), add)
    }

    fn resolvable(&self, time: f64, h: f64) -> f64 {
        self.systems().map(|system| system.resolvable(time, h)).sum()
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

    fn mach(&self) -> Option<Mach> {
        self.systems().find_map(System::mach)
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

    fn read(&self, field: usize) -> Vec<f64> {
        self.locate(field).map_or_else(Vec::new, |(part, field)| part.system.read(field))
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
        let mut written: Vec<(usize, Archive, Vec<f64>)> = Vec::new();
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
            let tallies = part.system.tallies();
            let outcome = part.system.write(&own, time, executor);
            if outcome.is_err() {
                for (index, mut before, tallies) in written {
                    let system = &mut self.parts[index].system;
                    system.restore(&mut before)?;
                    system.restore_tallies(&tallies)?;
                }
                return outcome;
            }
            written.push((index, before, tallies));
        }
        Ok(())
    }

    fn tallies(&self) -> Vec<f64> {
        self.systems().flat_map(System::tallies).collect()
    }

    fn restore_tallies(&mut self, mut numbers: &[f64]) -> Result<()> {
        for part in &mut self.parts {
            let foreign = || Error::State("it does not belong to this scene and these numerics".to_owned());
            let (own, rest) = numbers.split_at_checked(part.system.tallies().len()).ok_or_else(foreign)?;
            part.system.restore_tallies(own)?;
            numbers = rest;
        }
        Ok(())
    }

    /// Samples the fields of matter, which is the first system.
    fn sample(&self, sample: &Sample<'_>, executor: &Executor) -> Result<Vec<f64>> {
        self.parts[0].system.sample(sample, executor)
    }
}

#[cfg(test)]
mod tests;
