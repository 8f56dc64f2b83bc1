//! Matter: particles with their forces and contacts, advanced by a method.

mod activity;
mod budget;
mod compile;
mod constraints;
mod dynamics;
mod fields;
mod kernels;
mod methods;
mod step;
mod test_particles;

use std::sync::{Mutex, OnceLock, PoisonError};

use glam::{DVec2, DVec3, Vec2, Vec3};

use activity::Activity;
use constraints::{ConstrainedStep, Constraint, Constraints, ForcedState};
pub use constraints::{RigidPose, overlaps};
use dynamics::Dynamics;
use methods::coupled::Workspace;
use methods::explicit::Explicit;
use methods::implicit::Implicit;
use methods::projection::{PROJECTIVE, ProjectionMethod, Projective, Sweeps, XPBD};
use methods::radau::GaussRadau15;
use methods::rattle::{self, Rattle};
use methods::{Job, Method, MethodProperties, Treatment};

use crate::catalog::{Catalog, Space};
use crate::error::{Error, Result};
use crate::forces::Validity;
use crate::history::{Archive, History};
use crate::integrators::{gauss_radau_15, with_integrator};
use crate::ledger::Ledger;
use crate::math::Vector;
use crate::matter::{Columns, Matter};
use crate::parallel::{Executor, SERIAL};
use crate::plan::Stages;
use crate::scene::{Body, Item, Scene};
use crate::stability::{Horizon, Limit, LimitCache, SpectralBound};
use crate::systems::{
    Control, Element, Fault, FieldInfo, Hints, Interval, Quantity, RecordedSteps, Sample, System, unknown_integrator,
};

/// Size of one column of a block that runs many steps [bytes]: position, velocity and registers in three dimensions fit into
/// the first-level cache.
const INDEPENDENT_COLUMN: usize = 2048;
/// Number of particles per block of coupled matter. Large against the rows of a grid that a block shares with other blocks,
/// small against the second-level cache.
const COUPLED_BLOCK: usize = 4096;

/// Runs code with the vectors of a dimension and a precision.
macro_rules! with_space {
    ($dimension:expr, $precision:expr, $V:ident => $run:expr) => {
        match ($dimension, $precision) {
            (2, "f32") => {
                type $V = Vec2;
                $run
            }
            (3, "f32") => {
                type $V = Vec3;
                $run
            }
            (2, _) => {
                type $V = DVec2;
                $run
            }
            (3, _) => {
                type $V = DVec3;
                $run
            }
            (other, _) => Err(Error::parameter("scene.dimension", "2 or 3", other)),
        }
    };
}

/// Compiles a scene for a method.
///
/// # Errors
/// As [`crate::systems::build`].
pub fn build(scene: &Scene, method: &Item, precision: &str, catalog: Catalog, executor: &Executor) -> Result<Box<dyn System>> {
    if !["f32", "f64"].contains(&precision) {
        return Err(Error::parameter("precision", "f32 or f64", precision));
    }
    if method.kind == gauss_radau_15::NAME {
        return match (scene.dimension, precision) {
            (2, "f64") => compiled::<DVec2>(scene, GaussRadau15::declared(method)?, catalog, executor),
            (3, "f64") => compiled::<DVec3>(scene, GaussRadau15::declared(method)?, catalog, executor),
            (2 | 3, _) => Err(Error::parameter("precision", "\"f64\" with GaussRadau15()", format!("{precision:?}"))
                .with_hint("its errors are the roundings of double precision")),
            (other, _) => Err(Error::parameter("scene.dimension", "2 or 3", other)),
        };
    }
    with_space!(scene.dimension, precision, V => method_of::<V>(scene, method, catalog, executor))
}

/// Compiles a scene for a method in one precision and dimension. Registry of methods.
fn method_of<V: Space>(scene: &Scene, method: &Item, catalog: Catalog, executor: &Executor) -> Result<Box<dyn System>> {
    match method.kind.as_str() {
        rattle::NAME => compiled::<V>(scene, Rattle::declared(method)?, catalog, executor),
        XPBD => compiled::<V>(scene, ProjectionMethod::new(Sweeps::declared(method)?), catalog, executor),
        PROJECTIVE => compiled::<V>(scene, ProjectionMethod::new(Projective::<V>::declared(method)?), catalog, executor),
        "BackwardEuler" | "ImplicitMidpoint" | "BDF2" => compiled::<V>(scene, Implicit::declared(method)?, catalog, executor),
        kind => with_integrator!(
            kind,
            I => compiled::<V>(scene, Explicit::<V>::declared::<I>(method)?, catalog, executor),
            Err(unknown_integrator(method))
        ),
    }
}

/// Compiles a scene in one precision and dimension.
fn compiled<V: Space>(
    scene: &Scene,
    method: impl Method<V> + 'static,
    catalog: Catalog,
    executor: &Executor,
) -> Result<Box<dyn System>> {
    Ok(Box::new(compile::compile::<V>(scene, Box::new(method), catalog, executor)?))
}

/// Particles with their dynamics.
struct MatterSystem<V: Space> {
    dynamics: Dynamics<V>,
    constraints: Constraints<V>,
    state: Matter<V>,
    /// State at the start of the last batch.
    saved: Matter<V>,
    activity: Activity,
    workspace: Option<Workspace<V>>,
    method: Box<dyn Method<V>>,
    stages: Stages,
    /// Forces that are fields in space, or sums of fields of charges, as declared.
    fields: Vec<Item>,
    cost: f64,
    cache: Mutex<LimitCache>,
    /// Certified limit, while it is valid.
    certified: OnceLock<Limit>,
}

impl<V: Space> MatterSystem<V> {
    /// Number of particles per block, for independent or coupled particles.
    fn block(about: &MethodProperties, independent: bool) -> usize {
        let column = INDEPENDENT_COLUMN / size_of::<V::Scalar>();
        match (independent, about.memory.registers) {
            (false, _) => COUPLED_BLOCK,
            (true, 0..=2) => column,
            // More registers per particle, fewer particles in the same cache.
            (true, _) => column / 2,
        }
    }

    /// Creates a system at a given state.
    fn new(
        (dynamics, constraints): (Dynamics<V>, Constraints<V>),
        mut state: Matter<V>,
        method: Box<dyn Method<V>>,
        stages: Stages,
        fields: Vec<Item>,
    ) -> Self {
        let about = method.about();
        let independent = dynamics.is_independent() && !about.sweeps && !constraints.act();
        // Registers that live only between the stages of a step need not outlive a block that runs through whole steps.
        let registers = if independent { about.memory.readable } else { about.memory.registers };
        state.registers = vec![Columns::zeros(state.count()); registers];
        let count = state.count() as f64;
        let per_particle = if dynamics.is_fused() && dynamics.contacts.is_none() { 1.0 } else { 8.0 };
        let per_stage = 500.0 + count * per_particle + 6.0 * dynamics.pairs() as f64;
        // Estimates in nanoseconds on a typical core.
        let constrained: f64 = constraints.abouts().map(|constraint| constraint.cost).sum();
        let cost = 1e-9 * about.evaluations as f64 * (per_stage + constrained);
        let blocks = state.tallies.len();
        // The correction of damping is for velocities that nothing changes after the last kick.
        let damped = about.memory.damping && dynamics.damps_springs() && !constraints.change_velocities();
        let workspace = (!independent).then(|| Workspace::new(state.count(), blocks, dynamics.contacts.is_some(), damped));
        let mut system = Self {
            saved: state.clone(),
            dynamics,
            constraints,
            state,
            activity: Activity::default(),
            workspace,
            method,
            stages,
            fields,
            cost,
            cache: Mutex::default(),
            certified: OnceLock::new(),
        };
        system.show_solids();
        let blocks = if system.workspace.is_none() { blocks } else { 0 };
        let hints = system.hints();
        system.activity = Activity::new(blocks, hints.most_steps.min(hints.most_recorded));
        system
    }

    /// Shows the rotations of rigid bodies to the forces, after the constraints have changed.
    fn show_solids(&mut self) {
        self.state.solids = self.constraints.solids();
    }

    /// Resumes from a state that is complete with the persistent registers.
    fn resume(&mut self) {
        self.dynamics.observe(&self.state.velocity);
    }

    /// Whether the certified limit stays valid at this state.
    fn limit_holds(&self, time: f64) -> bool {
        let at = self.dynamics.view_of(&self.state, time, &SERIAL);
        let forces = self.dynamics.forces();
        !self.constraints.abouts().any(|constraint| constraint.varies)
            && forces.iter().all(|force| force.validity(&at, Horizon::Certified) != Validity::Now)
    }

    /// Two coincident particles, in the caller's order; None if there are none.
    fn coincident(&self) -> Option<[u32; 2]> {
        let caller = &self.dynamics.properties.caller;
        let position = |index: usize| self.state.exact_position(index).to_array();
        let mut positions: Vec<_> = (0..self.state.count()).map(|index| (position(index), caller[index])).collect();
        positions.sort_by(|(one, _), (other, _)| one.partial_cmp(other).unwrap_or(std::cmp::Ordering::Equal));
        let pairs = positions.windows(2).filter(|pair| pair[0].0 == pair[1].0);
        pairs.map(|pair| [pair[0].1.min(pair[1].1), pair[0].1.max(pair[1].1)]).min()
    }

    fn element(&self, index: usize) -> Element {
        let index = self.dynamics.properties.caller.get(index).map_or(0, |&caller| caller as usize);
        Element { name: format!("particle {index}"), index }
    }

    /// Bodies with their present positions and charges.
    fn bodies(&self) -> Vec<Body> {
        let properties = &self.dynamics.properties;
        let count = properties.body.iter().max().map_or(0, |&last| last as usize + 1);
        let mut bodies = vec![Body::default(); count];
        let mut order: Vec<usize> = (0..properties.count()).collect();
        order.sort_unstable_by_key(|&index| properties.caller[index]);
        for index in order {
            let body = &mut bodies[properties.body[index] as usize];
            body.positions.push(properties.origin + self.state.exact_position(index));
            body.charge.push(properties.charge[index]);
        }
        bodies
    }

    /// Calls a function with the state and the accelerations by all forces but those of constraints.
    fn forced<T>(&self, time: f64, executor: &Executor, call: impl FnOnce(&ForcedState<'_, V>) -> T) -> T {
        let at = self.dynamics.view_of(&self.state, time, executor);
        let accelerations = || self.dynamics.all_accelerations(&at).map(Vector::widen).collect();
        call(&ForcedState { at: &at, walls: self.dynamics.contacts.as_ref(), accelerations: &accelerations })
    }

    /// Data of steps over an interval.
    fn job(&mut self, interval: Interval, record: RecordedSteps) -> (&mut dyn Method<V>, Job<'_, V>) {
        let Self { dynamics, constraints, state, saved, activity, workspace, method, .. } = self;
        let (record, workspace) = ((activity, record), workspace.as_mut());
        (&mut **method, Job { dynamics, constraints, from: saved, state, record, workspace, interval })
    }

    /// Evaluates the forces at the present state, and fills the persistent registers.
    fn evaluate(&mut self, time: f64, executor: &Executor) -> Result<()> {
        let (method, job) = self.job(Interval { start: time, first: 0, h: 0.0, steps: 0 }, RecordedSteps::LastStep);
        method.begin(job, executor)
    }

    /// Takes steps.
    fn take(&mut self, interval: Interval, record: RecordedSteps, executor: &Executor) -> Result<()> {
        let (method, job) = self.job(interval, record);
        method.advance(job, executor).and_then(|()| executor.check())
    }

    /// Takes steps; springs break between them.
    fn take_and_tear(&mut self, interval: Interval, record: RecordedSteps, executor: &Executor) -> Result<()> {
        for index in 0..interval.steps {
            self.take(Interval { first: interval.first + index, steps: 1, ..interval }, record, executor)?;
            if self.constraints.tear(&self.state) {
                let energy = self.leave_out_broken();
                self.constraints.iter_mut().for_each(|constraint| constraint.lose(energy));
                self.evaluate(interval.time(index, 1.0), executor)?;
            }
        }
        Ok(())
    }

    /// Changes the data of the constraints, and leaves out the springs that are broken then, if they differ.
    fn change_constraints(&mut self, change: impl FnOnce(&mut Constraints<V>)) {
        let before = self.constraints.breakage();
        change(&mut self.constraints);
        if self.constraints.breakage() != before {
            self.leave_out_broken();
        }
        self.show_solids();
    }

    /// Removes broken springs and all that depends on them; returns the energy of forces that depended on them [J].
    fn leave_out_broken(&mut self) -> f64 {
        let Some(breakage) = self.constraints.breakage() else { return 0.0 };
        let energy = self.dynamics.leave_out(&breakage, &self.state);
        self.constraints.iter_mut().for_each(|constraint| constraint.leave_out(&breakage));
        self.method.take_springs(&self.dynamics);
        self.certified = OnceLock::new();
        energy
    }

    /// Writes the histories of method, constraints and forces to an archive.
    fn capture_histories(&self, archive: &mut Archive) {
        archive.within("method", |archive| self.method.capture(archive));
        archive.within("constraints", |archive| self.constraints.capture(archive));
        for (force, name) in self.dynamics.forces().iter().zip(self.names_of_forces()) {
            archive.within(&name, |archive| force.capture(archive));
        }
    }

    fn restore_histories(&mut self, archive: &mut Archive) -> Result<()> {
        archive.within("method", |archive| self.method.restore(archive))?;
        archive.within("constraints", |archive| self.constraints.restore(archive))?;
        self.leave_out_broken();
        self.show_solids();
        let names = self.names_of_forces();
        let mut forces = self.dynamics.forces_mut().iter_mut().zip(names);
        forces.try_for_each(|(force, name)| archive.within(&name, |archive| force.restore(archive)))
    }

    /// Names of the forces in archives. Forces of one kind are counted, so that no name depends on forces of other kinds.
    fn names_of_forces(&self) -> Vec<String> {
        let kinds: Vec<_> = self.dynamics.forces().iter().map(|force| force.about().name).collect();
        let alike = |index: usize| kinds[..index].iter().filter(|kind| **kind == kinds[index]).count();
        kinds.iter().enumerate().map(|(index, kind)| format!("forces/{kind}[{}]", alike(index))).collect()
    }
}

/// History: positions, velocities, residuals, persistent registers of the method, tallies, and histories of method,
/// constraints and forces.
impl<V: Space> History for MatterSystem<V> {
    fn save(&mut self) {
        self.method.save();
        self.constraints.save();
        self.dynamics.forces_mut().iter_mut().for_each(|force| force.save());
        if self.workspace.is_some() {
            self.saved.copy_from(&self.state);
        } else {
            // Steps of independent particles read the saved state and write the other one.
            std::mem::swap(&mut self.saved, &mut self.state);
        }
    }

    fn rollback(&mut self) {
        std::mem::swap(&mut self.saved, &mut self.state);
        self.method.rollback();
        self.change_constraints(History::rollback);
        self.dynamics.forces_mut().iter_mut().for_each(|force| force.rollback());
    }

    fn capture(&self, archive: &mut Archive) {
        archive.within("matter", |archive| {
            self.state.capture(self.method.persistent(), archive);
            self.capture_histories(archive);
        });
    }

    fn restore(&mut self, archive: &mut Archive) -> Result<()> {
        archive.within("matter", |archive| {
            self.state.restore(self.method.persistent(), archive)?;
            self.resume();
            self.restore_histories(archive)
        })
    }
}

impl<V: Space> System for MatterSystem<V> {
    fn stages(&self) -> Vec<Stages> {
        let known = self.dynamics.forces().iter().map(|force| force.about()).filter(|about| !about.findings.is_empty());
        let findings = known.map(|about| format!("{}: {}", about.name, about.findings));
        let constraints = self.constraints.iter().flat_map(Constraint::notes);
        vec![Stages {
            pairs: self.dynamics.pairs(),
            limit_varies: self.limit_varies(Horizon::Certified, 0.0),
            notes: self.stages.notes.iter().cloned().chain(findings).chain(self.method.note()).chain(constraints).collect(),
            ..self.stages.clone()
        }]
    }

    fn bytes(&self) -> usize {
        let workspace = self.workspace.as_ref().map_or(0, Workspace::bytes);
        let properties = self.state.count() * (5 * size_of::<f64>() + 2 * size_of::<V::Scalar>());
        let own = self.method.bytes() + self.activity.bytes();
        let constraints: usize = self.constraints.iter().map(Constraint::bytes).sum();
        self.dynamics.bytes() + constraints + self.state.bytes() + self.saved.bytes() + own + workspace + properties
    }

    fn cost(&self) -> f64 {
        self.cost
    }

    /// Batches have enough steps that the copies of the state cost less than the steps. With a user-defined function they have
    /// one: it is called in the order of time, once per evaluation.
    fn hints(&self) -> Hints {
        let least = match &self.workspace {
            None if self.dynamics.is_fused() => 200,
            None => 25,
            Some(_) => 5,
        };
        let hints = Hints::new(self.cost, least..=1_000_000);
        let solves = matches!(self.method.about().springs, Treatment::Solved | Treatment::Projections);
        Hints {
            most_steps: if self.dynamics.callbacks > 0 { 1 } else { hints.most_steps },
            most_recorded: Activity::most_steps(self.state.tallies.len()),
            iterates: solves || self.constraints.abouts().any(|constraint| constraint.iterates),
            linear: self.workspace.is_none() && self.dynamics.is_fused() && self.dynamics.contacts.is_none(),
            gains_energy: self.method.gains_energy(),
            ..hints
        }
    }

    fn begin(&mut self, time: f64, executor: &Executor) -> Result<()> {
        self.resume();
        if let Some(drift) = self.method.about().drift {
            let mut initial = ConstrainedStep::new(&self.dynamics, &mut self.state, (0.0, drift), executor);
            self.constraints.iter_mut().try_for_each(|constraint| constraint.initialize(&mut initial))?;
        }
        self.show_solids();
        self.saved.copy_from(&self.state);
        self.evaluate(time, executor)?;
        executor.check()
    }

    fn advance(&mut self, interval: Interval, record: RecordedSteps, executor: &Executor) -> Result<()> {
        self.save();
        self.activity.clear();
        let outcome = if self.constraints.iter().any(Constraint::tears) {
            self.take_and_tear(interval, record, executor)
        } else {
            self.take(interval, record, executor)
        };
        if outcome.is_err() {
            self.rollback();
        }
        outcome
    }

    fn activity(&self) -> &[f64] {
        self.activity.steps()
    }

    fn limit(&self, horizon: Horizon, time: f64, executor: &Executor) -> Result<Limit> {
        let holds = horizon == Horizon::Certified && self.limit_holds(time);
        if let (true, Some(&known)) = (holds, self.certified.get()) {
            return Ok(known);
        }
        let properties = &self.dynamics.properties;
        let mut bound = self.method.bound(SpectralBound::new(&properties.mass, &properties.body, horizon));
        self.forced(time, executor, |state| {
            self.dynamics.bound(state.at, &mut bound)?;
            self.constraints.iter().for_each(|constraint| constraint.bound(state, &mut bound));
            Ok(())
        })?;
        executor.check()?;
        if horizon == Horizon::Sharp {
            return Ok(self.method.sharp_limit(bound));
        }
        let limit = self.method.limit(&bound, &mut self.cache.lock().unwrap_or_else(PoisonError::into_inner));
        Ok(if holds { *self.certified.get_or_init(|| limit) } else { limit })
    }

    fn limit_varies(&self, horizon: Horizon, time: f64) -> bool {
        let at = self.dynamics.view_of(&self.state, time, &SERIAL);
        let forces = self.dynamics.forces();
        self.constraints.abouts().any(|constraint| constraint.varies)
            || forces.iter().any(|force| force.validity(&at, horizon) != Validity::Always)
    }

    fn error(&self, h: f64) -> Option<(f64, Control)> {
        Some((self.method.error(&self.state, h)?, self.method.control()))
    }

    fn audit(&self, time: f64, executor: &Executor) -> Result<Ledger> {
        budget::energy(&self.dynamics, &self.constraints, &self.state, time, executor)
    }

    fn finite_audit(&self, time: f64, executor: &Executor) -> Result<Ledger> {
        self.audit(time, executor)?.finite().map_err(|error| match self.coincident() {
            Some([one, other]) => error.with_hint(format!("particles {one} and {other} coincide")),
            None => error.with_hint("particles too fast, too heavy or too close to each other"),
        })
    }

    fn resolvable(&self, time: f64, h: f64) -> f64 {
        self.dynamics.kick(&self.dynamics.view_of(&self.state, time, &SERIAL), h)
    }

    fn fault(&self) -> Option<Fault> {
        let columns = [("position", &self.state.position), ("velocity", &self.state.velocity)];
        let mut faults = columns.into_iter().filter_map(|(quantity, columns)| Some((quantity, columns.out_of_range()?)));
        faults.next().map(|(quantity, index)| Fault { element: self.element(index), quantity })
    }

    fn fastest(&self) -> Element {
        let kinetic = |index: usize| budget::kinetic(&self.dynamics, &self.state, index);
        let mobile = (0..self.state.count()).filter(|&index| !self.dynamics.properties.is_fixed(index));
        self.element(mobile.max_by(|&one, &other| kinetic(one).total_cmp(&kinetic(other))).unwrap_or(0))
    }

    fn fields(&self) -> Vec<FieldInfo> {
        self.field_infos()
    }

    fn read(&self, field: usize, time: f64) -> Vec<f64> {
        self.values(field, time)
    }

    fn read_into(&self, field: usize, time: f64, values: &mut [f64]) {
        self.write_values(field, time, values);
    }

    fn write(&mut self, fields: &[(&str, &[f64])], time: f64, executor: &Executor) -> Result<()> {
        self.replace(fields, time, executor)
    }

    fn sample(&self, sample: &Sample<'_>, executor: &Executor) -> Result<Vec<f64>> {
        let acts = |item: &&Item| sample.on.is_none_or(|body| item.acts_on(body));
        let catalog = self.dynamics.catalog;
        let feels = |item: &&Item| match sample.quantity {
            Quantity::Acceleration => !catalog.forces.is_between_pairs(item),
            _ => catalog.forces.feels_charges(item),
        };
        let forces = self.fields.iter().filter(acts).filter(feels).cloned().collect();
        let bodies = if sample.quantity == Quantity::Acceleration { Vec::new() } else { self.bodies() };
        test_particles::sample((V::DIMENSION, catalog), forces, bodies, sample, executor)
    }
}
