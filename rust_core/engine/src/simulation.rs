//! The simulation: a compiled scene with a clock. Everything that it gives and takes is in double precision and in the
//! caller's order; precision, dimension and integrator are erased here, once.

mod adaptive;
mod controlled;
mod monitor;

pub use adaptive::{Adaptation, Rule};

use std::sync::OnceLock;
use std::time::{Duration, Instant};

use glam::{DVec2, DVec3, Vec2, Vec3};

use crate::audit::{self, Energy};
use crate::error::{Error, Result};
use crate::forces::{Fields, Flow};
use crate::integrators::{Integrator, with_integrator};
use crate::math::{Real, Vector};
use crate::matter::{Columns, EnergySink, EnergyTally, SINKS};
use crate::parallel::{Executor, SERIAL, ThreadPool};
use crate::plan::{self, Compiled, Plan};
use crate::scene::Scene;
use crate::simd::{LANES, Level};
use crate::stability::{Limit, LimitCache, SpectralBound};
use crate::systems::matter::MatterSystem;
use monitor::{Monitor, Steps};

/// How to compute.
#[derive(Debug, Clone)]
pub struct Numerics {
    /// The integrator's name.
    pub integrator: String,
    /// `f32` or `f64`.
    pub precision: String,
    /// The number of threads; None for all that the process may use.
    pub threads: Option<usize>,
    /// A run counts as diverged when the energy balance has risen by this many times the largest energy so far.
    pub runaway: f64,
    /// Which states the divergence monitor diagnoses.
    pub vigilance: Vigilance,
}

/// Which states the divergence monitor diagnoses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Vigilance {
    /// Those whose positions or velocities are not finite.
    OutOfRange,
    /// Those with more kinetic energy than the motion has shown so far.
    Agitated,
    /// Each one, at the cost of an evaluation of the energy per step.
    EveryStep,
}

impl Numerics {
    /// How many threads may be used.
    ///
    /// # Errors
    /// If none may, or the environment says no number.
    pub fn threads(&self) -> Result<usize> {
        match self.threads {
            Some(0) => Err(Error::parameter("threads", "a whole number ≥ 1", 0)),
            Some(threads) => Ok(threads),
            None => ThreadPool::default_threads(),
        }
    }
}

/// The clock: equal steps since a time.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Segment {
    /// When it began [s].
    pub start: f64,
    /// How many steps of `dt` it is since then.
    pub steps: u64,
    /// Their length [s].
    pub dt: f64,
}

impl Segment {
    /// The time now [s].
    pub fn time(&self) -> f64 {
        self.start + self.steps as f64 * self.dt
    }
}

/// Everything that the next step's bits depend on, beside the scene and the numerics.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Capture {
    /// The clock's present segment.
    pub segment: Segment,
    /// All steps taken so far.
    pub steps: u64,
    /// Positions, velocities and what the integrator carries, relative to the origin, in the engine's order, axis by axis.
    pub columns: Vec<f64>,
    /// The tallies, block by block.
    pub tallies: Vec<f64>,
    /// What the divergence monitor remembers.
    pub watch: [f64; 4],
    /// What adaptive steps remember.
    pub adaptation: Adaptation,
    /// What the forces keep from step to step.
    pub forces: Vec<f64>,
}

/// A running scene, whatever its precision, dimension and integrator.
pub trait World: Send + Sync {
    /// What it does.
    fn plan(&self) -> &Plan;
    /// The memory that it takes now [bytes].
    fn memory(&self) -> usize;
    /// What the forces found when they were last asked what limits the time step.
    fn findings(&self) -> Vec<String>;
    /// The time and how it was reached.
    fn segment(&self) -> Segment;
    /// All steps taken so far.
    fn steps(&self) -> u64;
    /// Takes `steps` steps of `dt` seconds, asking now and then whether it was interrupted.
    fn step(&mut self, steps: u64, dt: f64, interrupted: &dyn Fn() -> bool) -> Result<()>;
    /// Advances by `interval` seconds in steps that a rule chooses; the last one ends exactly there.
    fn run(&mut self, interval: f64, rule: &Rule, interrupted: &dyn Fn() -> bool) -> Result<()>;
    /// What adaptive steps remember.
    fn adaptation(&self) -> Adaptation;
    /// Positions [m].
    fn positions(&self) -> Vec<DVec3>;
    /// Velocities [m/s].
    fn velocities(&self) -> Vec<DVec3>;
    /// Moves or accelerates particles; the change of energy counts as work.
    fn set(&mut self, positions: Option<&[DVec3]>, velocities: Option<&[DVec3]>, executor: &Executor) -> Result<()>;
    /// Density and pressure of every particle, NaN where there is no fluid.
    fn fields(&self) -> Fields;
    /// The fastest flow of a fluid that was seen where the watch looked, if there is a fluid.
    fn flow(&self) -> Option<Flow>;
    /// Whether to find out its energy or its limits may take long.
    fn is_long(&self) -> bool;
    /// The energy now.
    fn energy(&self, executor: &Executor) -> Result<Energy>;
    /// The momentum [kg·m/s] and the angular momentum about the origin of coordinates [kg·m²/s].
    fn momenta(&self) -> (DVec3, DVec3);
    /// The largest time step as matters stand.
    fn limit(&self, executor: &Executor) -> Result<Limit>;
    /// The largest certified step [s], which is stable while no spring is shorter than half its rest length, wherever it
    /// turns.
    fn certified(&self, executor: &Executor) -> Result<f64>;
    /// The largest certified step from the present state, whatever is ahead.
    fn present_limit(&self, executor: &Executor) -> Result<Limit>;
    /// Everything that the next step's bits depend on.
    fn capture(&self) -> Capture;
    /// Goes on from a captured state.
    fn restore(&mut self, capture: &Capture) -> Result<()>;
    /// A hash of the positions, the velocities, what the integrator carries, and the clock.
    fn state_hash(&self) -> String;
}

/// Compiles a scene.
///
/// # Errors
/// If the scene or the numerics make no sense or do not fit into registers, or the executor was asked to stop.
pub fn build(scene: &Scene, numerics: &Numerics, executor: &Executor) -> Result<Box<dyn World>> {
    Level::check()?;
    match (scene.dimension, numerics.precision.as_str()) {
        (2, "f32") => build_for::<Vec2>(scene, numerics, executor),
        (3, "f32") => build_for::<Vec3>(scene, numerics, executor),
        (2, "f64") => build_for::<DVec2>(scene, numerics, executor),
        (3, "f64") => build_for::<DVec3>(scene, numerics, executor),
        (2 | 3, other) => Err(Error::parameter("precision", "f32 or f64", other)),
        (other, _) => Err(Error::parameter("scene.dimension", "2 or 3", other)),
    }
}

fn build_for<V: Vector>(scene: &Scene, numerics: &Numerics, executor: &Executor) -> Result<Box<dyn World>> {
    with_integrator!(
        numerics.integrator.as_str(),
        I => Ok(Box::new(Simulation::<V>::new::<I>(scene, numerics, executor)?)),
        Err(Error::parameter("integrator", "the name of an integrator", &numerics.integrator))
    )
}

struct Simulation<V: Vector> {
    system: MatterSystem<V>,
    plan: Plan,
    limit: fn(&SpectralBound, &mut LimitCache) -> Limit,
    sharpened: fn(SpectralBound) -> Limit,
    /// Makes a bound one for the integrator.
    bound_for: fn(SpectralBound) -> SpectralBound,
    cache: LimitCache,
    /// The certified limit while it stands [s], once it was asked for.
    certified: OnceLock<f64>,
    carried: usize,
    /// The integrator's order, and where it keeps the estimates of its errors, if it has any.
    order: u32,
    error: Option<[usize; 2]>,
    adaptation: Adaptation,
    segment: Segment,
    steps: u64,
    monitor: Monitor,
    flow: Option<Flow>,
}

/// How often a long call asks whether it was interrupted.
const POLL: Duration = Duration::from_millis(20);

impl<V: Vector> Simulation<V> {
    fn new<I: Integrator>(scene: &Scene, numerics: &Numerics, executor: &Executor) -> Result<Self> {
        let Compiled { system, plan } = plan::compile::<V, I>(scene, numerics.threads()?, executor)?;
        // An integrator that is stable on no oscillator may gain energy as it likes: that is what it is shown for.
        let spirals = I::limit(0.0) == 0.0;
        let runaway = if spirals { f64::INFINITY } else { numerics.runaway };
        let mut simulation = Self {
            system,
            plan,
            limit: SpectralBound::limit_after::<I>,
            sharpened: SpectralBound::sharp_limit::<I>,
            bound_for: SpectralBound::stepped_by::<I>,
            cache: LimitCache::default(),
            certified: OnceLock::new(),
            carried: I::PERSISTENT,
            order: I::ORDER,
            error: I::ERROR,
            adaptation: Adaptation::default(),
            segment: Segment::default(),
            steps: 0,
            monitor: Monitor::new(runaway, numerics.vigilance),
            flow: None,
        };
        simulation.begin(executor)?;
        // Who is near whom is known only now.
        simulation.plan.pairs = simulation.system.dynamics().pairs();
        let energy = simulation.finite_energy(executor)?;
        simulation.monitor.balance = energy.balance();
        simulation.monitor.observe(&energy, energy.kinetic, V::Scalar::EPSILON);
        Ok(simulation)
    }

    fn begin(&mut self, executor: &Executor) -> Result<()> {
        self.system.begin(self.segment.time(), executor)
    }

    /// The energy now, refused where it is out of the range of numbers.
    fn finite_energy(&self, executor: &Executor) -> Result<Energy> {
        let energy = self.energy(executor)?;
        if energy.balance().is_finite() {
            return Ok(energy);
        }
        let parts = [("kinetic", energy.kinetic), ("internal", energy.internal)].into_iter().chain(energy.potential);
        let found = parts.into_iter().find(|(_, energy)| !energy.is_finite());
        let found = found.map_or_else(|| "a sum that is not".to_owned(), |(name, energy)| format!("{name} energy of {energy} J"));
        let error = Error::parameter("scene", "an energy that is finite", found);
        Err(match self.coincident() {
            Some([one, other]) => error.with_hint(format!("particles {one} and {other} are at the same place")),
            None => error.with_hint("particles too fast, too heavy or too close to each other"),
        })
    }

    /// Two particles at the same place, in the caller's order, if there are any.
    fn coincident(&self) -> Option<[u32; 2]> {
        let (state, caller) = (self.system.state(), &self.system.dynamics().properties.caller);
        let mut places: Vec<_> =
            (0..state.count()).map(|index| (state.exact_position(index).to_array(), caller[index])).collect();
        places.sort_by(|(one, _), (other, _)| one.partial_cmp(other).unwrap_or(std::cmp::Ordering::Equal));
        let pairs = places.windows(2).filter(|pair| pair[0].0 == pair[1].0);
        pairs.map(|pair| [pair[0].1.min(pair[1].1), pair[0].1.max(pair[1].1)]).min()
    }

    fn advance_by(&mut self, steps: u64, interrupted: &dyn Fn() -> bool) -> Result<()> {
        let (mut left, mut polled) = (steps, Instant::now());
        while left > 0 {
            left -=
                self.batch(left.min(self.system.batch()), Steps::Equal, interrupted).map_err(|error| self.with_hint(error))?;
            if left > 0 && polled.elapsed() >= POLL {
                if interrupted() {
                    return Err(Error::Interrupted);
                }
                polled = Instant::now();
            }
        }
        Ok(())
    }

    /// Whether the certified limit is the one that it is whenever this holds.
    fn stands(&self) -> bool {
        let (dynamics, state) = (self.system.dynamics(), self.system.state());
        let at = dynamics.view_of(state, self.segment.time(), &SERIAL);
        dynamics.forces().iter().all(|force| force.bound_stands(&at))
    }

    /// What the terms contribute to a bound of some kind in the present state.
    fn bound(&self, empty: fn(&[f64], &[u32]) -> SpectralBound) -> Result<SpectralBound> {
        self.bound_by(empty, &SERIAL)
    }

    /// The same, shared among an executor; when that was asked to stop, some part of it.
    fn bound_by(&self, empty: fn(&[f64], &[u32]) -> SpectralBound, executor: &Executor) -> Result<SpectralBound> {
        let (dynamics, state) = (self.system.dynamics(), self.system.state());
        let bound = (self.bound_for)(empty(&dynamics.properties.mass, &dynamics.properties.body));
        dynamics.bound(&dynamics.view_of(state, self.segment.time(), executor), bound)
    }

    /// The fastest flow of the present state.
    fn fastest_flow(&self) -> Option<Flow> {
        let velocity = self.system.state().velocity.view();
        self.system.dynamics().forces().iter().find_map(|force| force.flow(velocity))
    }

    /// The columns that make up the state, in a fixed order.
    fn columns(&self) -> impl Iterator<Item = &Columns<V>> {
        let state = self.system.state();
        [&state.position, &state.velocity, &state.residual].into_iter().chain(state.registers.iter().take(self.carried))
    }
}

impl<V: Vector> World for Simulation<V> {
    fn plan(&self) -> &Plan {
        &self.plan
    }

    fn memory(&self) -> usize {
        self.system.bytes()
    }

    fn findings(&self) -> Vec<String> {
        let findings = self.system.dynamics().forces().iter().map(|force| (force.name(), force.findings()));
        findings.filter(|(_, found)| !found.is_empty()).map(|(name, found)| format!("{name}: {found}")).collect()
    }

    fn segment(&self) -> Segment {
        self.segment
    }

    fn steps(&self) -> u64 {
        self.steps
    }

    fn step(&mut self, steps: u64, dt: f64, interrupted: &dyn Fn() -> bool) -> Result<()> {
        if !(dt.is_finite() && dt > 0.0) {
            return Err(Error::parameter("dt", "a finite number > 0", dt));
        }
        let (before, first) = ((self.segment, self.monitor), self.steps);
        if dt != self.segment.dt {
            self.segment = Segment { start: self.segment.time(), steps: 0, dt };
        }
        self.expect(dt);
        if !(Segment { steps: self.segment.steps.saturating_add(steps), ..self.segment }).time().is_finite() {
            self.segment = before.0;
            return Err(Error::parameter("dt", "steps that end at a time that is finite", format!("{steps} of {dt:e} s")));
        }
        let outcome = self.advance_by(steps, interrupted);
        if outcome.is_err() && self.steps == first {
            (self.segment, self.monitor) = before;
        }
        outcome
    }

    fn run(&mut self, interval: f64, rule: &Rule, interrupted: &dyn Fn() -> bool) -> Result<()> {
        self.advance_adaptively(interval, rule, interrupted)
    }

    fn adaptation(&self) -> Adaptation {
        self.adaptation
    }

    fn positions(&self) -> Vec<DVec3> {
        let properties = &self.system.dynamics().properties;
        let mut positions = vec![DVec3::ZERO; properties.count()];
        for (index, &caller) in properties.caller.iter().enumerate() {
            positions[caller as usize] = properties.origin + self.system.state().exact_position(index);
        }
        positions
    }

    fn velocities(&self) -> Vec<DVec3> {
        let mut velocities = vec![DVec3::ZERO; self.system.state().count()];
        for (index, &caller) in self.system.dynamics().properties.caller.iter().enumerate() {
            velocities[caller as usize] = self.system.state().velocity.get(index).widen();
        }
        velocities
    }

    fn set(&mut self, positions: Option<&[DVec3]>, velocities: Option<&[DVec3]>, executor: &Executor) -> Result<()> {
        let before = self.energy(executor)?.total();
        let dynamics = self.system.dynamics();
        let (count, properties) = (dynamics.properties.count(), &dynamics.properties);
        let of = |index: usize, vectors: &[DVec3]| vectors[properties.caller[index] as usize];
        let mut moved = positions.map(|positions| {
            let mut moved = self.system.state().clone();
            (0..count).for_each(|index| moved.set_exact_position(index, of(index, positions) - properties.origin));
            moved
        });
        let accelerated = velocities.map(|velocities| Columns::<V>::from_fn(count, |index| V::narrow(of(index, velocities))));
        for (name, given, columns) in [
            ("positions", positions, moved.as_ref().map(|moved| &moved.position)),
            ("velocities", velocities, accelerated.as_ref()),
        ] {
            if let (Some(given), Some(index)) = (given, columns.and_then(Columns::out_of_range)) {
                let caller = properties.caller[index] as usize;
                return Err(plan::out_of_range::<V>(&format!("set.{name}[{caller}]"), given[caller]));
            }
        }
        if let (Some(moved), Some(contacts)) = (&mut moved, &dynamics.contacts) {
            contacts.project_inside(&mut moved.position, properties)?;
        }
        let (kept, histories) = (self.system.state().clone(), self.system.recollection());
        let state = self.system.state_mut();
        if let Some(moved) = moved {
            (state.position, state.residual) = (moved.position, moved.residual);
        }
        state.velocity = accelerated.unwrap_or_else(|| std::mem::take(&mut state.velocity));
        // First the forces, because what some of them keep for their energy follows the state.
        let done = self.begin(executor).and_then(|()| self.finite_energy(executor)).map(|energy| {
            if let Some(tally) = self.system.state_mut().tallies.first_mut() {
                tally.add(EnergySink::Work, energy.total() - before);
            }
        });
        if done.is_err() {
            *self.system.state_mut() = kept;
            self.system.resume();
            self.system.recollect(&histories)?;
        }
        done
    }

    fn fields(&self) -> Fields {
        let dynamics = self.system.dynamics();
        let caller = &dynamics.properties.caller;
        let nothing = || vec![f64::NAN; caller.len()];
        let mut fields = Fields { density: nothing(), pressure: nothing() };
        dynamics.forces().iter().for_each(|force| force.show(&mut fields));
        let ordered = |values: &[f64]| {
            let mut ordered = nothing();
            caller.iter().zip(values).for_each(|(&caller, &value)| ordered[caller as usize] = value);
            ordered
        };
        Fields { density: ordered(&fields.density), pressure: ordered(&fields.pressure) }
    }

    fn flow(&self) -> Option<Flow> {
        self.flow
    }

    fn is_long(&self) -> bool {
        self.system.is_long()
    }

    fn energy(&self, executor: &Executor) -> Result<Energy> {
        audit::energy(self.system.dynamics(), self.system.state(), self.segment.time(), executor)
    }

    fn momenta(&self) -> (DVec3, DVec3) {
        audit::momenta(self.system.dynamics(), self.system.state())
    }

    fn limit(&self, executor: &Executor) -> Result<Limit> {
        let bound = self.bound_by(SpectralBound::directed, executor)?;
        executor.check()?;
        Ok((self.sharpened)(bound))
    }

    fn certified(&self, executor: &Executor) -> Result<f64> {
        let stands = self.stands();
        if let (true, Some(&known)) = (stands, self.certified.get()) {
            return Ok(known);
        }
        let bound = self.bound_by(SpectralBound::new, executor)?;
        executor.check()?;
        let found = (self.limit)(&bound, &mut LimitCache::default()).stability;
        if stands {
            self.certified.get_or_init(|| found);
        }
        Ok(found)
    }

    fn present_limit(&self, executor: &Executor) -> Result<Limit> {
        let bound = self.bound_by(SpectralBound::at_present, executor)?;
        executor.check()?;
        Ok((self.limit)(&bound, &mut LimitCache::default()))
    }

    fn capture(&self) -> Capture {
        let columns =
            self.columns().flat_map(|columns| (0..V::DIMENSION).flat_map(|axis| &columns.axis(axis)[..columns.count()]));
        let tallies = self.system.state().tallies.iter().flat_map(|tally| tally.energy.iter().chain(&tally.last).flatten());
        Capture {
            segment: self.segment,
            steps: self.steps,
            columns: columns.map(|number| number.to_f64()).collect(),
            tallies: tallies.copied().collect(),
            watch: [self.monitor.scale, self.monitor.lowest, self.monitor.balance, self.monitor.threshold],
            adaptation: self.adaptation,
            forces: self.system.recollection(),
        }
    }

    fn restore(&mut self, capture: &Capture) -> Result<()> {
        let state = self.system.state();
        let (count, blocks) = (state.count(), state.tallies.len());
        let per_meter = 2 * SINKS * LANES;
        let numbers = ((2 + self.carried) * count + state.residual.count()) * V::DIMENSION;
        if capture.columns.len() != numbers || capture.tallies.len() != blocks * per_meter {
            return Err(Error::State("it does not belong to this scene and these numerics".to_owned()));
        }
        let carried = self.carried;
        let state = self.system.state_mut();
        let mut numbers = capture.columns.iter();
        let columns = [&mut state.position, &mut state.velocity, &mut state.residual];
        for columns in columns.into_iter().chain(state.registers.iter_mut().take(carried)) {
            let count = columns.count();
            for axis in columns.span().axes.iter_mut().take(V::DIMENSION) {
                axis[..count].iter_mut().zip(&mut numbers).for_each(|(slot, &number)| *slot = V::Scalar::from_f64(number));
            }
        }
        for (tally, numbers) in state.tallies.iter_mut().zip(capture.tallies.chunks_exact(per_meter)) {
            *tally = EnergyTally::ZERO;
            let slots = tally.energy.iter_mut().chain(&mut tally.last).flatten();
            slots.zip(numbers).for_each(|(slot, &number)| *slot = number);
        }
        self.segment = capture.segment;
        self.steps = capture.steps;
        let monitor = &mut self.monitor;
        [monitor.scale, monitor.lowest, monitor.balance, monitor.threshold] = capture.watch;
        self.adaptation = capture.adaptation;
        self.system.resume();
        self.system.recollect(&capture.forces)
    }

    fn state_hash(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        let capture = self.capture();
        for number in capture
            .columns
            .iter()
            .chain(&capture.forces)
            .chain([&capture.segment.start, &capture.segment.dt])
            .chain(&capture.adaptation.control)
        {
            hasher.update(&number.to_le_bytes());
        }
        hasher.update(&self.segment.steps.to_le_bytes());
        hasher.update(&self.steps.to_le_bytes());
        hasher.finalize().to_hex()[..32].to_owned()
    }
}
