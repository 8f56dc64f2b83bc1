//! Tracers as a system: history, plan, budgets and fields.

use super::Tracers;
use super::law::Outcome;
use crate::error::{Error, Result};
use crate::history::{Archive, History, TALLIES};
use crate::ledger::{Budget, Ledger};
use crate::math::Real;
use crate::parallel::Executor;
use crate::plan::Stages;
use crate::stability::{Horizon, Limit, LimitKind};
use crate::systems::{Control, Element, Fault, FieldInfo, Hints, Interval, Location, RecordedSteps, System};

/// Maximum number of steps of a batch.
const STEPS: u64 = 4095;
/// Limit of accuracy in units of 1/|∇v|: neighbors separate by a tenth of their distance in a step.
const ACCURATE: f64 = 0.1;
/// Names of the fields.
const FIELDS: [&str; 2] = ["positions", "velocities"];

impl<T: Real, const D: usize> Tracers<T, D> {
    fn element(&self, index: usize) -> Element {
        Element { name: format!("{} {index}", self.element), index }
    }

    /// Replaces the positions.
    fn replace(&mut self, name: &str, rows: &[f64]) -> Result<()> {
        if name != FIELDS[0] {
            return Err(Error::parameter(format!("set.{name}"), FIELDS[0], name));
        }
        let points = &mut self.points;
        if rows.len() != points.count * D {
            return Err(Error::parameter(format!("set.{name}"), format!("{} rows", points.count), rows.len() / D));
        }
        if let Some(index) = rows.iter().position(|&value| !T::from_f64(value).is_finite()) {
            let place = format!("set.{name}[{}, {}]", index / D, index % D);
            return Err(Error::parameter(place, format!("a finite number that {} holds", T::NAME), rows[index]));
        }
        points.fill(rows);
        Ok(())
    }
}

/// History: the positions, the time at which velocities are read, and the tally. No slope is kept from one step to the next.
impl<T: Real, const D: usize> History for Tracers<T, D> {
    fn save(&mut self) {
        self.saved_time = self.time;
        self.saved.copy_from(&self.points);
    }

    fn rollback(&mut self) {
        self.time = self.saved_time;
        self.points.copy_from(&self.saved);
    }

    fn capture(&self, archive: &mut Archive) {
        archive.write("time", [self.time]);
        archive.write(FIELDS[0], self.points.rows());
        archive.write(TALLIES, [self.supplied]);
    }

    fn restore(&mut self, archive: &mut Archive) -> Result<()> {
        self.time = archive.read_number("time")?;
        self.points.fill(archive.read_exactly(FIELDS[0], D * self.points.count)?);
        self.supplied = archive.read_number(TALLIES)?;
        Ok(())
    }
}

impl<T: Real, const D: usize> System for Tracers<T, D> {
    fn stages(&self) -> Vec<Stages> {
        vec![Stages {
            item: String::new(),
            names: vec![format!("velocity of {}", self.flow.name()), "update of positions".to_owned()],
            dimension: D,
            precision: T::NAME,
            method: self.method.name,
            order: self.method.order,
            evaluations: self.coefficients.evaluations,
            pairs: 0,
            force_error: 0.0,
            limit_varies: false,
            layout: self.flow.layout().to_owned(),
            left_out: Vec::new(),
            notes: Vec::new(),
        }]
    }

    fn bytes(&self) -> usize {
        2 * self.points.bytes() + self.flow.bytes()
    }

    fn cost(&self) -> f64 {
        self.coefficients.evaluations as f64 * (1e-8 + self.flow.cost() * self.points.count as f64)
    }

    fn hints(&self) -> Hints {
        let hints = Hints::new(self.cost(), 1..=STEPS);
        Hints { most_steps: hints.most_steps.min(self.flow.most_steps(self.coefficients.evaluations)), ..hints }
    }

    fn begin(&mut self, time: f64, executor: &Executor) -> Result<()> {
        self.time = time;
        self.flow.begin(&self.points, time)?;
        executor.check()
    }

    fn advance(&mut self, interval: Interval, record: RecordedSteps, executor: &Executor) -> Result<()> {
        self.save();
        self.activity.clear();
        let outcome = self.flow.advance(self.coefficients, &mut self.points, interval, executor);
        match outcome {
            Ok(outcome) => self.outcome = outcome,
            Err(error) => {
                self.rollback();
                return Err(error);
            }
        }
        let recorded = if record == RecordedSteps::LastStep { 1 } else { interval.steps as usize };
        self.activity.resize(recorded, 0.0);
        self.activity[recorded - 1] = self.outcome.finite;
        self.time = interval.time(interval.steps, 0.0);
        Ok(())
    }

    fn activity(&self) -> &[f64] {
        &self.activity
    }

    fn limit(&self, _horizon: Horizon, time: f64, executor: &Executor) -> Result<Limit> {
        let steepest = self.flow.steepest(&self.points, time, executor)?;
        // Squares overflow before positions do; nothing is then known of a step.
        if steepest == 0.0 || !steepest.is_finite() {
            return Ok(Limit::NONE);
        }
        Ok(Limit { accuracy: ACCURATE / steepest, term: "flow", kind: LimitKind::Accuracy, ..Limit::NONE })
    }

    fn limit_varies(&self, horizon: Horizon, _time: f64) -> bool {
        matches!(horizon, Horizon::Present)
    }

    fn error(&self, _h: f64) -> Option<(f64, Control)> {
        self.method.estimate.as_ref().map(|estimate| (self.outcome.error, Control::pair(estimate.order)))
    }

    fn audit(&self, _time: f64, executor: &Executor) -> Result<Ledger> {
        let mut ledger = Ledger::new(0, 1);
        if let Some(stored) = self.flow.hamiltonian(&self.points) {
            let supplied = vec![("set", self.supplied)];
            ledger.add_budget(Budget { name: "hamiltonian".to_owned(), unit: "m⁴/s²", stored, removed: Vec::new(), supplied });
        }
        executor.check()?;
        Ok(ledger)
    }

    fn fault(&self) -> Option<Fault> {
        self.points.fault().map(|index| Fault { element: self.element(index), quantity: "position" })
    }

    /// Point farthest from the origin.
    fn fastest(&self) -> Element {
        let square = |row: &[f64]| row.iter().map(|value| value * value).sum::<f64>();
        let squares = self.points.rows().chunks_exact(D).map(square).zip(0..).collect::<Vec<_>>();
        let farthest = squares.into_iter().max_by(|one, other| one.0.total_cmp(&other.0));
        self.element(farthest.map_or(0, |(_, index)| index))
    }

    fn fields(&self) -> Vec<FieldInfo> {
        let info = |field: usize| FieldInfo {
            name: FIELDS[field].to_owned(),
            unit: ["m", "m/s"][field],
            location: Location::Points,
            shape: vec![self.points.count, D],
            rate: (field == 0).then(|| FIELDS[1].to_owned()),
            state: field == 0,
        };
        vec![info(0), info(1)]
    }

    /// Positions or velocities. Velocities that cannot be evaluated are NaN; the next step meets the same error, and reports it.
    fn read(&self, field: usize, _time: f64) -> Vec<f64> {
        if field == 0 {
            return self.points.rows();
        }
        let velocities = self.flow.velocities(&self.points, self.time);
        velocities.map_or_else(|_| vec![f64::NAN; self.points.count * D], |velocities| velocities.rows())
    }

    fn write(&mut self, fields: &[(&str, &[f64])], time: f64, executor: &Executor) -> Result<()> {
        let before = (self.points.clone(), self.supplied);
        let hamiltonian = self.flow.hamiltonian(&self.points);
        let replaced = fields.iter().try_for_each(|&(path, rows)| self.replace(path, rows));
        let done =
            replaced.and_then(|()| self.begin(time, executor)).and_then(|()| self.finite_audit(time, executor).map(|_| ()));
        if done.is_err() {
            (self.points, self.supplied) = before;
        } else if let (Some(after), Some(before)) = (self.flow.hamiltonian(&self.points), hamiltonian) {
            self.supplied += after - before;
        }
        self.outcome = Outcome::default();
        done
    }
}
