//! The simulation: a compiled scene with a clock. Everything that it gives and takes is in double precision and in the
//! caller's order; precision, dimension and integrator are erased here, once.

mod adaptive;
mod controlled;

pub use adaptive::{Adaptation, Rule};

use std::sync::OnceLock;

use glam::{DVec2, DVec3, Vec2, Vec3};

use crate::audit::{self, Energy};
use crate::error::{Divergence, Error, Result};
use crate::forces::{Fields, Flow};
use crate::integrators::{Integrator, with_integrator};
use crate::math::{Real, Vector};
use crate::matter::{CHANNELS, Channel, Columns, Meter};
use crate::parallel::{ALONE, Crew, Team};
use crate::plan::{self, Compiled, Plan};
use crate::scene::Scene;
use crate::simd::{LANES, Level};
use crate::stability::{Bound, Limit, Memo};
use crate::systems::matter::{Interval, MatterSystem};

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
    /// Whether a run may go on until the first number that is not finite.
    pub ignore_runaway: bool,
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
            None => Team::default_threads(),
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
    /// The meters, block by block.
    pub meters: Vec<f64>,
    /// What the watch over divergence remembers.
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
    fn set(&mut self, positions: Option<&[DVec3]>, velocities: Option<&[DVec3]>, crew: &Crew) -> Result<()>;
    /// Density and pressure of every particle, NaN where there is no fluid.
    fn fields(&self) -> Fields;
    /// The fastest flow of a fluid that was seen where the watch looked, if there is a fluid.
    fn flow(&self) -> Option<Flow>;
    /// Whether to find out its energy or its limits may take long.
    fn is_long(&self) -> bool;
    /// The energy now.
    fn energy(&self, crew: &Crew) -> Result<Energy>;
    /// The momentum [kg·m/s] and the angular momentum about the origin of coordinates [kg·m²/s].
    fn momenta(&self) -> (DVec3, DVec3);
    /// The largest time step as matters stand.
    fn limit(&self, crew: &Crew) -> Result<Limit>;
    /// The largest certified step [s], which is stable while no spring is shorter than half its rest length, wherever it
    /// turns.
    fn certified(&self, crew: &Crew) -> Result<f64>;
    /// The largest certified step from the present state, whatever is ahead.
    fn present_limit(&self, crew: &Crew) -> Result<Limit>;
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
/// If the scene or the numerics make no sense or do not fit into memory, or the crew was asked to stop.
pub fn build(scene: &Scene, numerics: &Numerics, crew: &Crew) -> Result<Box<dyn World>> {
    Level::check()?;
    match (scene.dimension, numerics.precision.as_str()) {
        (2, "f32") => build_for::<Vec2>(scene, numerics, crew),
        (3, "f32") => build_for::<Vec3>(scene, numerics, crew),
        (2, "f64") => build_for::<DVec2>(scene, numerics, crew),
        (3, "f64") => build_for::<DVec3>(scene, numerics, crew),
        (2 | 3, other) => Err(Error::parameter("precision", "f32 or f64", other)),
        (other, _) => Err(Error::parameter("scene.dimension", "2 or 3", other)),
    }
}

fn build_for<V: Vector>(scene: &Scene, numerics: &Numerics, crew: &Crew) -> Result<Box<dyn World>> {
    with_integrator!(
        numerics.integrator.as_str(),
        I => Ok(Box::new(Simulation::<V>::new::<I>(scene, numerics, crew)?)),
        Err(Error::parameter("integrator", "the name of an integrator", &numerics.integrator))
    )
}

struct Simulation<V: Vector> {
    system: MatterSystem<V>,
    plan: Plan,
    limit: fn(&Bound, &mut Memo) -> Limit,
    sharp_limit: fn(Bound) -> Limit,
    /// Makes a bound one for the integrator.
    bound_for: fn(Bound) -> Bound,
    memo: Memo,
    /// The certified limit while it stands [s], once it was asked for.
    certified: OnceLock<f64>,
    carried: usize,
    /// The integrator's order, and where it keeps the estimates of its errors, if it has any.
    order: u32,
    error: Option<[usize; 2]>,
    adaptation: Adaptation,
    segment: Segment,
    steps: u64,
    watch: Watch,
    flow: Option<Flow>,
}

/// What the watch over divergence remembers.
#[derive(Debug, Clone, Copy)]
struct Watch {
    /// How much the balance may rise, in units of the largest energy; infinite where nobody wants to know.
    runaway: f64,
    /// The largest energy that the motion has shown [J].
    scale: f64,
    /// The smallest potential energy so far [J].
    lowest: f64,
    /// The balance at the start [J].
    balance: f64,
    /// The kinetic energy up to which the balance need not be looked at [J].
    calm: f64,
}

impl Watch {
    /// Takes in the energy of a moment; says by how much the balance has risen if that is too much.
    fn check(&mut self, energy: &Energy, epsilon: f64) -> Option<f64> {
        let rise = (energy.balance() - self.balance).max(0.0);
        let potential = energy.total() - energy.kinetic;
        self.lowest = self.lowest.min(potential);
        // What has risen for no reason must not pass for energy of the motion. Rounding makes noise on the scale of the
        // numbers that the balance is the sum of; a few roundings per term, and a wide margin.
        let shown = energy.kinetic + (potential - self.lowest) + energy.dissipated() + energy.work.abs() - rise;
        self.scale = self.scale.max(shown).max(1e-3 * epsilon * energy.magnitude());
        let calm = if self.runaway.is_finite() { self.scale } else { self.scale.max(energy.kinetic) };
        self.calm = (2.0 * calm).min(f64::MAX);
        (rise > self.runaway * self.scale).then_some(rise)
    }
}

impl<V: Vector> Simulation<V> {
    fn new<I: Integrator>(scene: &Scene, numerics: &Numerics, crew: &Crew) -> Result<Self> {
        let Compiled { system, plan } = plan::compile::<V, I>(scene, numerics.threads()?, crew)?;
        let runaway = if numerics.ignore_runaway { f64::INFINITY } else { numerics.runaway };
        let watch = Watch { runaway, scale: 0.0, lowest: f64::INFINITY, balance: 0.0, calm: 0.0 };
        let mut simulation = Self {
            system,
            plan,
            limit: Bound::limit_after::<I>,
            sharp_limit: Bound::sharp_limit::<I>,
            bound_for: Bound::stepped_by::<I>,
            memo: Memo::default(),
            certified: OnceLock::new(),
            carried: I::CARRIED,
            order: I::ORDER,
            error: I::ERROR,
            adaptation: Adaptation::default(),
            segment: Segment::default(),
            steps: 0,
            watch,
            flow: None,
        };
        // An integrator that is stable on no oscillator may gain energy as it likes: that is what it is shown for.
        if I::limit(0.0) == 0.0 {
            simulation.watch.runaway = f64::INFINITY;
        }
        simulation.begin(crew)?;
        // Who is near whom is known only now.
        simulation.plan.pairs = simulation.system.law().pairs();
        let energy = simulation.energy(crew)?;
        simulation.watch.balance = energy.balance();
        simulation.watch.check(&energy, V::Scalar::EPSILON);
        Ok(simulation)
    }

    fn begin(&mut self, crew: &Crew) -> Result<()> {
        self.system.begin(self.segment.time(), crew)
    }

    /// Takes one chunk of steps. If something in it goes wrong, takes it again step by step to find where.
    fn chunk(&mut self, steps: u64, interrupted: &dyn Fn() -> bool) -> Result<()> {
        let before = self.watch;
        match self.advance(steps, interrupted) {
            Err(error) if !is_scattered(&error) && !matches!(error, Error::Memory { .. }) => return Err(error),
            Err(_) => {}
            Ok(()) if self.verdict(interrupted)?.is_none() => {
                let flow = self.fastest_flow();
                if flow > self.flow {
                    self.flow = flow;
                }
                return Ok(());
            }
            Ok(()) => self.take_back(steps)?,
        }
        for _ in 0..steps {
            match self.advance(1, interrupted) {
                Err(error) if is_scattered(&error) => {
                    let time = self.segment.time() + self.segment.dt;
                    return Err(Error::Diverged(Box::new(Divergence { step: self.steps + 1, time, ..self.scatter() })));
                }
                outcome => outcome?,
            }
            self.watch = before;
            self.watch.calm = -1.0;
            if let Some(mut divergence) = self.verdict(interrupted)? {
                divergence.step = self.steps;
                divergence.time = self.segment.time();
                self.take_back(1)?;
                return Err(Error::Diverged(Box::new(divergence)));
            }
        }
        Ok(())
    }

    /// Goes back to before the last [`Simulation::advance`].
    fn take_back(&mut self, steps: u64) -> Result<()> {
        self.system.undo()?;
        self.segment.steps -= steps;
        self.steps -= steps;
        Ok(())
    }

    fn advance(&mut self, steps: u64, interrupted: &dyn Fn() -> bool) -> Result<()> {
        let interval = Interval { start: self.segment.start, first: self.segment.steps, h: self.segment.dt, steps };
        self.system.advance(interval, interrupted)?;
        self.segment.steps += steps;
        self.steps += steps;
        Ok(())
    }

    /// What is wrong with the present state, if anything is.
    fn verdict(&mut self, interrupted: &dyn Fn() -> bool) -> Result<Option<Divergence>> {
        let agitation = self.system.agitation();
        if agitation <= self.watch.calm {
            return Ok(None);
        }
        let state = self.system.state();
        let stray = |columns: &Columns<V>| (0..state.count()).find(|&index| !columns.get(index).widen().is_finite());
        for (quantity, columns) in [("position", &state.position), ("velocity", &state.velocity)] {
            if let Some(index) = stray(columns) {
                return Ok(Some(self.divergence(index, quantity, "is not finite".to_owned())));
            }
        }
        let time = self.segment.time();
        let energy = match self.system.ask(interrupted, |law, state, crew| audit::energy(law, state, time, crew)) {
            Err(error) if is_scattered(&error) => return Ok(Some(self.scatter())),
            outcome => outcome?,
        };
        // Energies are squares: they leave the range of numbers long before the state does.
        if !energy.balance().is_finite() && self.watch.runaway.is_finite() {
            return Ok(Some(self.divergence(self.fastest(), "energy", "is not finite".to_owned())));
        }
        let rise = self.watch.check(&energy, V::Scalar::EPSILON);
        Ok(rise.map(|rise| {
            let scale = self.watch.scale;
            let cause = format!(
                "has run away: the energy balance rose by {rise:.3e} J, where the largest energy of the motion was {scale:.3e} J"
            );
            self.divergence(self.fastest(), "energy", cause)
        }))
    }

    /// Whether the certified limit is the one that it is whenever this holds.
    fn stands(&self) -> bool {
        let (law, state) = (self.system.law(), self.system.state());
        let at = law.moment_of(state, self.segment.time(), &ALONE);
        law.forces().iter().all(|force| force.bound_stands(&at))
    }

    /// What the terms contribute to a bound of some kind in the present state.
    fn bound(&self, empty: fn(&[f64], &[u32]) -> Bound) -> Bound {
        self.bound_by(empty, &ALONE)
    }

    /// The same, shared among a crew; when that was asked to stop, some part of it.
    fn bound_by(&self, empty: fn(&[f64], &[u32]) -> Bound, crew: &Crew) -> Bound {
        let (law, state) = (self.system.law(), self.system.state());
        let bound = (self.bound_for)(empty(&law.properties.mass, &law.properties.body));
        law.bound(&law.moment_of(state, self.segment.time(), crew), bound)
    }

    /// Takes in what a step of `dt` seconds cannot resolve, before the first one of them.
    fn expect(&mut self, dt: f64) {
        let kick = self.kick(dt);
        self.watch.scale = if kick.is_finite() { self.watch.scale.max(kick) } else { self.watch.scale };
    }

    /// The energy of the first kick from rest [J].
    fn kick(&self, dt: f64) -> f64 {
        let (law, state) = (self.system.law(), self.system.state());
        law.kick(&law.moment_of(state, self.segment.time(), &ALONE), dt)
    }

    fn fastest(&self) -> usize {
        let (law, state) = (self.system.law(), self.system.state());
        let kinetic = |index: usize| law.properties.mass[index] * state.velocity.get(index).widen().length_squared();
        let mobile = (0..state.count()).filter(|&index| !law.properties.is_fixed(index));
        mobile.max_by(|&one, &other| kinetic(one).total_cmp(&kinetic(other))).unwrap_or(0)
    }

    /// The fastest flow of the present state.
    fn fastest_flow(&self) -> Option<Flow> {
        let velocity = self.system.state().velocity.view();
        self.system.law().forces().iter().find_map(|force| force.flow(velocity))
    }

    /// What is wrong where neighbors can no longer be searched.
    fn scatter(&self) -> Divergence {
        self.divergence(self.fastest(), "position", "is so far away that it cannot be told who is near whom".to_owned())
    }

    fn divergence(&self, index: usize, quantity: &'static str, cause: String) -> Divergence {
        Divergence {
            step: 0,
            time: 0.0,
            particle: self.system.law().properties.caller[index] as usize,
            quantity,
            cause,
            hint: String::new(),
        }
    }

    /// Adds to a divergence what to do about it.
    fn with_hint(&self, error: Error) -> Error {
        match error {
            Error::Diverged(divergence) => Error::Diverged(Box::new(Divergence { hint: self.hint(), ..*divergence })),
            other => other,
        }
    }

    /// What to do about a divergence; asked for at the last good state.
    fn hint(&self) -> String {
        let (limit, dt) = ((self.sharp_limit)(self.bound(Bound::directed)), self.segment.dt);
        if limit.stability == 0.0 {
            return format!("no dt is stable with {} here: take another integrator", self.plan.integrator);
        }
        let (most, term) = (limit.dt(), limit.term);
        if dt > most {
            format!("dt = {dt:.3e} s is beyond the limit of {most:.3e} s set by {term}; dt = {:.3e} s would hold", 0.9 * most)
        } else if most.is_finite() {
            format!("dt = {dt:.3e} s is within the limit of {most:.3e} s at the last good state; try dt = {:.3e} s", 0.25 * dt)
        } else {
            format!("nothing bounds dt at the last good state; try dt = {:.3e} s", 0.25 * dt)
        }
    }

    /// The columns that make up the state, in a fixed order.
    fn columns(&self) -> impl Iterator<Item = &Columns<V>> {
        let state = self.system.state();
        [&state.position, &state.velocity, &state.residual].into_iter().chain(state.memory.iter().take(self.carried))
    }
}

/// Whether a step failed because particles are too far away to be searched: they diverge before their numbers do.
fn is_scattered(error: &Error) -> bool {
    matches!(error, Error::Parameter { path, .. } if path == "positions")
}

impl<V: Vector> World for Simulation<V> {
    fn plan(&self) -> &Plan {
        &self.plan
    }

    fn memory(&self) -> usize {
        self.system.bytes()
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
        if dt != self.segment.dt {
            self.segment = Segment { start: self.segment.time(), steps: 0, dt };
            self.expect(dt);
        }
        let mut left = steps;
        while left > 0 {
            let chunk = left.min(self.system.chunk());
            self.chunk(chunk, interrupted).map_err(|error| self.with_hint(error))?;
            left -= chunk;
            if left > 0 && interrupted() {
                return Err(Error::Interrupted);
            }
        }
        Ok(())
    }

    fn run(&mut self, interval: f64, rule: &Rule, interrupted: &dyn Fn() -> bool) -> Result<()> {
        self.advance_adaptively(interval, rule, interrupted)
    }

    fn adaptation(&self) -> Adaptation {
        self.adaptation
    }

    fn positions(&self) -> Vec<DVec3> {
        let properties = &self.system.law().properties;
        let mut positions = vec![DVec3::ZERO; properties.count()];
        for (index, &caller) in properties.caller.iter().enumerate() {
            positions[caller as usize] = properties.origin + self.system.state().place(index);
        }
        positions
    }

    fn velocities(&self) -> Vec<DVec3> {
        let mut velocities = vec![DVec3::ZERO; self.system.state().count()];
        for (index, &caller) in self.system.law().properties.caller.iter().enumerate() {
            velocities[caller as usize] = self.system.state().velocity.get(index).widen();
        }
        velocities
    }

    fn set(&mut self, positions: Option<&[DVec3]>, velocities: Option<&[DVec3]>, crew: &Crew) -> Result<()> {
        let before = self.energy(crew)?.total();
        let law = self.system.law();
        let (count, properties) = (law.properties.count(), &law.properties);
        let of = |index: usize, vectors: &[DVec3]| vectors[properties.caller[index] as usize];
        let mut moved = positions.map(|positions| {
            let mut moved = self.system.state().clone();
            (0..count).for_each(|index| moved.set_place(index, of(index, positions) - properties.origin));
            moved
        });
        let accelerated = velocities.map(|velocities| Columns::<V>::from_fn(count, |index| V::narrow(of(index, velocities))));
        if let (Some(moved), Some(contacts)) = (&mut moved, &law.contacts) {
            contacts.admit(&mut moved.position, properties)?;
        }
        let kept = self.system.state().clone();
        let state = self.system.state_mut();
        if let Some(moved) = moved {
            (state.position, state.residual) = (moved.position, moved.residual);
        }
        state.velocity = accelerated.unwrap_or_else(|| std::mem::take(&mut state.velocity));
        // First the forces, because what some of them keep for their energy follows the state.
        let done = self.begin(crew).and_then(|()| self.energy(crew)).map(|energy| {
            if let Some(meter) = self.system.state_mut().meters.first_mut() {
                meter.add(Channel::Work, energy.total() - before);
            }
        });
        if done.is_err() {
            *self.system.state_mut() = kept;
        }
        done
    }

    fn fields(&self) -> Fields {
        let law = self.system.law();
        let caller = &law.properties.caller;
        let nothing = || vec![f64::NAN; caller.len()];
        let mut fields = Fields { density: nothing(), pressure: nothing() };
        law.forces().iter().for_each(|force| force.show(&mut fields));
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

    fn energy(&self, crew: &Crew) -> Result<Energy> {
        audit::energy(self.system.law(), self.system.state(), self.segment.time(), crew)
    }

    fn momenta(&self) -> (DVec3, DVec3) {
        audit::momenta(self.system.law(), self.system.state())
    }

    fn limit(&self, crew: &Crew) -> Result<Limit> {
        let bound = self.bound_by(Bound::directed, crew);
        crew.check()?;
        Ok((self.sharp_limit)(bound))
    }

    fn certified(&self, crew: &Crew) -> Result<f64> {
        let stands = self.stands();
        if let (true, Some(&known)) = (stands, self.certified.get()) {
            return Ok(known);
        }
        let bound = self.bound_by(Bound::new, crew);
        crew.check()?;
        let found = (self.limit)(&bound, &mut Memo::default()).stability;
        if stands {
            self.certified.get_or_init(|| found);
        }
        Ok(found)
    }

    fn present_limit(&self, crew: &Crew) -> Result<Limit> {
        let bound = self.bound_by(Bound::at_present, crew);
        crew.check()?;
        Ok((self.limit)(&bound, &mut Memo::default()))
    }

    fn capture(&self) -> Capture {
        let columns =
            self.columns().flat_map(|columns| (0..V::DIMENSION).flat_map(|axis| &columns.axis(axis)[..columns.count()]));
        let meters = self.system.state().meters.iter().flat_map(|meter| meter.energy.iter().chain(&meter.last).flatten());
        Capture {
            segment: self.segment,
            steps: self.steps,
            columns: columns.map(|number| number.to_f64()).collect(),
            meters: meters.copied().collect(),
            watch: [self.watch.scale, self.watch.lowest, self.watch.balance, self.watch.calm],
            adaptation: self.adaptation,
            forces: self.system.recollection(),
        }
    }

    fn restore(&mut self, capture: &Capture) -> Result<()> {
        let state = self.system.state();
        let (count, blocks) = (state.count(), state.meters.len());
        let per_meter = 2 * CHANNELS * LANES;
        let numbers = ((2 + self.carried) * count + state.residual.count()) * V::DIMENSION;
        if capture.columns.len() != numbers || capture.meters.len() != blocks * per_meter {
            return Err(Error::State("it does not belong to this scene and these numerics".to_owned()));
        }
        let carried = self.carried;
        let state = self.system.state_mut();
        let mut numbers = capture.columns.iter();
        let columns = [&mut state.position, &mut state.velocity, &mut state.residual];
        for columns in columns.into_iter().chain(state.memory.iter_mut().take(carried)) {
            let count = columns.count();
            for axis in columns.span().axes.iter_mut().take(V::DIMENSION) {
                axis[..count].iter_mut().zip(&mut numbers).for_each(|(slot, &number)| *slot = V::Scalar::from_f64(number));
            }
        }
        for (meter, numbers) in state.meters.iter_mut().zip(capture.meters.chunks_exact(per_meter)) {
            *meter = Meter::ZERO;
            let slots = meter.energy.iter_mut().chain(&mut meter.last).flatten();
            slots.zip(numbers).for_each(|(slot, &number)| *slot = number);
        }
        self.segment = capture.segment;
        self.steps = capture.steps;
        [self.watch.scale, self.watch.lowest, self.watch.balance, self.watch.calm] = capture.watch;
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
