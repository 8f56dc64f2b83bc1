//! The class `World`: the engine's simulation.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, RwLock, RwLockReadGuard, RwLockWriteGuard, TryLockError};

use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, ToPyArray};
use physcore_engine::error::{Error, Result as EngineResult};
use physcore_engine::forces::Mach;
use physcore_engine::history::Archive;
use physcore_engine::ledger::{Budget, Class};
use physcore_engine::memory;
use physcore_engine::parallel::{Executor, SERIAL, attend};
use physcore_engine::plan::Stages;
use physcore_engine::simulation::{Adaptation, Checkpoint, Course, Numerics, Segment, Simulation, StepSizeRule, Vigilance};
use physcore_engine::stability::{Horizon, Limit, LimitKind};
use physcore_engine::systems::{FieldInfo, Quantity, Sample};
use pyo3::gc::{PyTraverseError, PyVisit};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::callback::PythonFunction;
use crate::errors::{FileError, InternalError, PhyscoreError, SceneError, exception};
use crate::laws::CATALOG;
use crate::record::Reader;
use crate::scene;

/// Running simulation.
///
/// Any number of threads may read it at once, and one may change it. The interpreter is free meanwhile. A writer waits for
/// readers. A reader is refused during a change, because a step can take a day.
#[pyclass(frozen, module = "physcore._core")]
pub struct World {
    inner: Shared,
    /// Whether a thread changes the simulation, or waits for readers.
    changing: Arc<AtomicBool>,
    /// User-defined functions that the engine calls, also for energies. The garbage collector finds them here without a lock.
    functions: Vec<Arc<PythonFunction>>,
    dimension: usize,
    threads: usize,
}

type Shared = Arc<RwLock<Simulation>>;
/// Numbers of equal steps, with their sizes [s].
type Parts = Vec<(u64, f64)>;
/// Class, name and energy [J].
type EnergyRow = (&'static str, &'static str, f64);
/// Name, unit, elements with a value each, shape, name of the rate of change, and whether the field is a part of the state.
type FieldRow = (String, &'static str, &'static str, Vec<usize>, Option<String>, bool);
/// Name, unit, stored amount, removed amounts and supplied amounts.
type BudgetRow = (String, &'static str, f64, Vec<(&'static str, f64)>, Vec<(&'static str, f64)>);

/// Reason for which a request failed.
enum RequestFailure {
    Busy,
    Lost,
    Engine(Error),
}

impl From<Error> for RequestFailure {
    fn from(error: Error) -> Self {
        Self::Engine(error)
    }
}

impl RequestFailure {
    fn raised(self, py: Python<'_>) -> PyErr {
        match self {
            Self::Busy => PhyscoreError::new_err(
                "this simulation is running, in another thread or around this call: wait until that has ended",
            ),
            Self::Lost => InternalError::new_err("this simulation was left in the middle of a step by an earlier internal error"),
            Self::Engine(error) => exception(py, error),
        }
    }
}

/// Right to change a world, until it is dropped.
struct Claim(Arc<AtomicBool>);

impl Drop for Claim {
    fn drop(&mut self) {
        self.0.store(false, Ordering::Release);
    }
}

/// Locks the world for reading.
fn looked_at(inner: &RwLock<Simulation>) -> Result<RwLockReadGuard<'_, Simulation>, RequestFailure> {
    inner.try_read().map_err(|error| match error {
        TryLockError::WouldBlock => RequestFailure::Busy,
        TryLockError::Poisoned(_) => RequestFailure::Lost,
    })
}

/// Locks the world for writing, as soon as no thread reads it.
fn changed<'a>(
    inner: &'a RwLock<Simulation>,
    interrupted: &dyn Fn() -> bool,
) -> Result<RwLockWriteGuard<'a, Simulation>, RequestFailure> {
    loop {
        match inner.try_write() {
            Ok(guard) => return Ok(guard),
            Err(TryLockError::Poisoned(_)) => return Err(RequestFailure::Lost),
            Err(TryLockError::WouldBlock) if interrupted() => return Err(Error::Interrupted.into()),
            Err(TryLockError::WouldBlock) => std::thread::sleep(std::time::Duration::from_millis(1)),
        }
    }
}

impl World {
    /// Memory in use [bytes].
    fn memory(&self, py: Python<'_>) -> PyResult<usize> {
        self.glance(py, physcore_engine::simulation::Simulation::memory)
    }

    fn claim(&self, py: Python<'_>) -> PyResult<Claim> {
        if self.changing.swap(true, Ordering::Acquire) {
            return Err(RequestFailure::Busy.raised(py));
        }
        Ok(Claim(Arc::clone(&self.changing)))
    }

    /// Reads data that are available without computation.
    fn glance<T>(&self, py: Python<'_>, look: impl FnOnce(&Simulation) -> T) -> PyResult<T> {
        looked_at(&self.inner).map(|world| look(&world)).map_err(|failure| failure.raised(py))
    }

    /// Copies data of `bytes` bytes from the engine.
    fn copy<T: Send>(&self, py: Python<'_>, bytes: usize, copy: impl FnOnce(&Simulation) -> T + Send) -> PyResult<T> {
        let hint = || "for a copy of what there is; record fewer channels, or free some arrays".to_owned();
        memory::check("state", bytes, 0, hint).map_err(|error| exception(py, error))?;
        self.look(py, copy)
    }

    /// Reads a vector of matter as a whole; 0 without matter.
    fn total<'py>(&self, py: Python<'py>, field: &'static str, components: usize) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let found = self.look(py, |world| world.read(field))?;
        Ok(PyArray1::from_vec(py, found.map_or_else(|| vec![0.0; components], |(_, values)| values)))
    }

    /// Reads the world in the engine.
    fn look<T: Send>(&self, py: Python<'_>, look: impl FnOnce(&Simulation) -> T + Send) -> PyResult<T> {
        if self.changing.load(Ordering::Acquire) {
            return Err(RequestFailure::Busy.raised(py));
        }
        without_gil(py, || Ok(look(&*looked_at(&self.inner)?)))
    }

    /// Evaluates a query in the engine that may take long.
    fn ask<T: Send + 'static>(
        &self,
        py: Python<'_>,
        question: impl FnOnce(&Simulation, &Executor) -> EngineResult<T> + Send + 'static,
    ) -> PyResult<T> {
        if !self.glance(py, physcore_engine::simulation::Simulation::is_long)? {
            return self.look(py, |world| question(world, &SERIAL))?.map_err(|error| exception(py, error));
        }
        let (inner, threads) = (Arc::clone(&self.inner), self.threads);
        let job = move |executor: &Executor| Ok(question(&*looked_at(&inner)?, executor)?);
        without_gil(py, || attend(threads, &interrupted, job)?)
    }

    /// Changes the world in the engine. A panic becomes an exception, and poisons the world.
    fn change<T: Send>(&self, py: Python<'_>, work: impl FnOnce(&mut Simulation) -> EngineResult<T> + Send) -> PyResult<T> {
        let _claim = self.claim(py)?;
        without_gil(py, || Ok(work(&mut *changed(&self.inner, &interrupted)?)?))
    }

    /// Changes the world in the engine, on other threads if this may take long before the first step. After an interrupt the
    /// caller does not wait for these, but the change is completed.
    fn change_at_length<T: Send + 'static>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut Simulation, &Executor) -> EngineResult<T> + Send + 'static,
    ) -> PyResult<T> {
        if !self.glance(py, physcore_engine::simulation::Simulation::is_long)? {
            return self.change(py, |world| work(world, &SERIAL));
        }
        let (claim, inner) = (self.claim(py)?, Arc::clone(&self.inner));
        let job = move |executor: &Executor| {
            let _claim = claim;
            Ok(work(&mut *changed(&inner, &|| executor.stopped())?, executor)?)
        };
        without_gil(py, || attend(self.threads, &interrupted, job)?)
    }
}

/// Runs the engine without the interpreter's lock. A panic becomes an exception.
fn without_gil<T: Send>(py: Python<'_>, work: impl FnOnce() -> Result<T, RequestFailure> + Send) -> PyResult<T> {
    match py.detach(|| catch_unwind(AssertUnwindSafe(work))) {
        Ok(result) => result.map_err(|failure| failure.raised(py)),
        Err(panic) => {
            let message =
                panic.downcast_ref::<String>().cloned().or_else(|| panic.downcast_ref::<&str>().map(|&text| text.to_owned()));
            Err(InternalError::new_err(format!("the engine panicked, please report it: {}", message.unwrap_or_default())))
        }
    }
}

/// Size of a number [bytes].
const NUMBER: usize = 8;

/// Number of particles, springs and cells below which a scene is built and queried faster than threads start.
const FEW: usize = 1000;

/// Available memory [bytes], if the system reports it.
#[pyfunction]
pub fn available_memory() -> Option<u64> {
    memory::available()
}

/// Whether a signal is pending whose handler raises, such as that of Ctrl-C. The exception is raised again later.
pub fn interrupted() -> bool {
    Python::attach(|py| py.check_signals().map_err(|error| error.restore(py)).is_err())
}

#[pymethods]
impl World {
    #[new]
    #[expect(clippy::too_many_arguments, reason = "the numerical choices, one by one")]
    fn new(
        py: Python<'_>,
        scene: &Bound<'_, PyDict>,
        integrator: &Bound<'_, PyAny>,
        integrators: &Bound<'_, PyDict>,
        precision: String,
        threads: Option<usize>,
        max_energy_growth: f64,
        on_divergence: &str,
    ) -> PyResult<Self> {
        let (scene, functions) = scene::read(scene)?;
        let mut reader = Reader { dimension: scene.dimension, functions };
        let integrator = reader.item(integrator, "integrator".to_owned())?;
        let named = integrators.iter().map(|(name, record)| {
            let name: String = name.extract()?;
            let item = reader.item(&record, format!("integrator[{name:?}]"))?;
            Ok((name, item))
        });
        let integrators = named.collect::<PyResult<_>>()?;
        let functions = reader.functions;
        let vigilance = match on_divergence {
            "ignore" => Vigilance::OutOfRange,
            "substep" => Vigilance::EveryStep,
            _ => Vigilance::Active,
        };
        let numerics = Numerics { integrator, integrators, precision, threads, max_energy_growth, vigilance };
        let (dimension, calls_back) = (scene.dimension, !functions.is_empty());
        let threads = numerics.threads().map_err(|error| exception(py, error))?;
        let things = scene.rows();
        let build = move |executor: &Executor| Simulation::new(&scene, &numerics, CATALOG, executor);
        let inner = without_gil(py, || {
            Ok(if things < FEW && !calls_back { build(&SERIAL) } else { attend(threads, &interrupted, build)? }?)
        })?;
        let inner = Arc::new(RwLock::new(inner));
        Ok(Self { inner, changing: Arc::default(), functions, dimension, threads })
    }

    /// Visits references for the garbage collector. Like a tuple, the class needs no `__clear__`. All its referents are older
    /// than itself, so a cycle passes through an object that was changed later, and is broken there.
    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        self.functions.iter().try_for_each(|function| function.traverse(&visit))
    }

    /// Take n steps of dt seconds. For a fluid, return the Mach number above which a flow is fast, the largest fast fraction so
    /// far, and the speed of sound [m/s].
    fn step(&self, py: Python<'_>, n: u64, dt: f64) -> PyResult<Option<(f64, f64, f64)>> {
        let mach = self.change(py, |world| world.step(n, dt, &interrupted).map(|()| world.mach()))?;
        Ok(mach.map(|mach| (Mach::FAST, mach.fast, mach.sound)))
    }

    /// Divide steps of dt seconds, and later ones of other sizes, into equal substeps of each of several systems whose own
    /// limit is smaller.
    fn divide(&self, py: Python<'_>, dt: f64) -> PyResult<()> {
        self.change(py, |world| world.divide(dt, &interrupted))
    }

    /// Repeat a diverged step of dt seconds in parts. Return the numbers of equal parts taken, with their sizes [s], and the
    /// exception if this fails as well.
    fn substep(&self, py: Python<'_>, dt: f64) -> (Parts, Option<PyErr>) {
        let mut parts = Vec::new();
        let outcome = self.change(py, |world| world.substep(dt, &mut parts, &interrupted));
        (parts, outcome.err())
    }

    /// Take up to `steps` adaptive steps of a course. It consists of the start [s], the interval [s], the position in it (0 at
    /// the start), and the largest admissible step there [s] or None. Return the course, or None at its end, and the values of `step`.
    #[allow(clippy::type_complexity)]
    fn run(
        &self,
        py: Python<'_>,
        course: (f64, f64, u64, Option<f64>),
        steps: u64,
        safety: f64,
        free: f64,
        tolerance: Option<f64>,
    ) -> PyResult<(Option<(f64, f64, u64, Option<f64>)>, Option<(f64, f64, f64)>)> {
        let rule = StepSizeRule { safety, free, tolerance };
        let (start, interval, position, allowed) = course;
        let mut course = Course { start, interval, position, allowed };
        let mach = self.change(py, |world| world.cross(&mut course, steps, &rule, &interrupted).map(|()| world.mach()))?;
        let left = (!course.is_complete()).then_some((start, interval, course.position, course.allowed));
        Ok((left, mach.map(|mach| (Mach::FAST, mach.fast, mach.sound))))
    }

    /// Statistics of the adaptive steps so far: numbers of rejected and of diverged steps; smallest and largest step [s].
    fn adaptation(&self, py: Python<'_>) -> PyResult<(u64, u64, f64, f64)> {
        let Adaptation { rejected, failed, range: [smallest, largest], .. } =
            self.glance(py, physcore_engine::simulation::Simulation::adaptation)?;
        Ok((rejected, failed, smallest, largest))
    }

    #[getter]
    fn time(&self, py: Python<'_>) -> PyResult<f64> {
        self.glance(py, |world| world.segment().time())
    }

    #[getter]
    fn steps(&self, py: Python<'_>) -> PyResult<u64> {
        self.glance(py, physcore_engine::simulation::Simulation::steps)
    }

    #[getter]
    fn dt(&self, py: Python<'_>) -> PyResult<f64> {
        self.glance(py, |world| world.segment().dt)
    }

    /// Descriptions of the fields. The rate of change is named if it is a field too.
    fn fields(&self, py: Python<'_>) -> PyResult<Vec<FieldRow>> {
        let fields = self.glance(py, Simulation::fields)?;
        let row = |field: FieldInfo| (field.name, field.unit, field.location.name(), field.shape, field.rate, field.state);
        Ok(fields.into_iter().map(row).collect())
    }

    /// Read a field: one row per element, or one number per element if the field has a single component.
    fn read<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let missing = || InternalError::new_err(format!("there is no field {name:?}"));
        let field = self.glance(py, Simulation::fields)?.into_iter().find(|field| field.name == name).ok_or_else(missing)?;
        // The engine's copy beside that of the caller.
        let bytes = 2 * NUMBER * field.shape.iter().product::<usize>();
        let (_, values) = self.copy(py, bytes, |world| world.read(name))?.ok_or_else(missing)?;
        Ok(PyArray1::from_vec(py, values).reshape(field.shape)?.into_any())
    }

    /// Replace fields by name.
    fn write(&self, py: Python<'_>, fields: &Bound<'_, PyDict>) -> PyResult<()> {
        let fields: Vec<(String, Vec<f64>)> = fields
            .iter()
            .map(|(name, values)| Ok((name.extract()?, scene::copied(&values.call_method0("ravel")?.extract()?)?)))
            .collect::<PyResult<_>>()?;
        self.change_at_length(py, move |world, executor| {
            let fields: Vec<(&str, &[f64])> = fields.iter().map(|(name, values)| (name.as_str(), values.as_slice())).collect();
            world.write(&fields, executor)
        })
    }

    /// Energy budget, as (class, name, energy) [J], and budgets of further conserved quantities, as (name, unit, stored, removed
    /// by sink, supplied by source).
    fn budgets(&self, py: Python<'_>) -> PyResult<(Vec<EnergyRow>, Vec<BudgetRow>)> {
        let ledger = if self.functions.is_empty() {
            self.ask(py, physcore_engine::simulation::Simulation::energy)?
        } else {
            // A user-defined function may try to change the world. This must be refused and cannot wait.
            self.change_at_length(py, |world, executor| world.energy(executor))?
        };
        let energies = ledger.rows().iter().map(|row| (class(row.class), row.name, row.energy)).collect();
        let of =
            |budget: &Budget| (budget.name.clone(), budget.unit, budget.stored, budget.removed.clone(), budget.supplied.clone());
        Ok((energies, ledger.budgets().iter().map(of).collect()))
    }

    fn momentum<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        self.total(py, "momentum", self.dimension)
    }

    fn angular_momentum<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        self.total(py, "angular_momentum", [0, 1, 3][self.dimension - 1])
    }

    fn limit<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        limit_record(py, self.ask(py, |world, executor| world.limit(Horizon::Sharp, executor))?)
    }

    /// Largest certified and accurate step [s]; NaN where a user-defined function is not finite nearby.
    fn certified(&self, py: Python<'_>) -> PyResult<f64> {
        self.ask(py, |world, executor| match world.limit(Horizon::Certified, executor) {
            Err(Error::Undefined { .. }) => Ok(f64::NAN),
            limit => Ok(limit?.dt()),
        })
    }

    fn present_limit<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        limit_record(py, self.ask(py, |world, executor| world.limit(Horizon::Present, executor))?)
    }

    /// Plan: memory, threads, vector instructions, and the stages of each system.
    fn plan<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let plan = self.look(py, Simulation::plan)?;
        let record = PyDict::new(py);
        record.set_item("systems", plan.stages.iter().map(|stages| stages_record(py, stages)).collect::<PyResult<Vec<_>>>()?)?;
        record.set_item("memory", plan.memory)?;
        record.set_item("threads", plan.threads)?;
        record.set_item("simd", plan.simd)?;
        Ok(record)
    }

    /// Arrays by name: those of the clock and of the control of steps, and those of the systems, whose names are paths.
    fn capture<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let checkpoint = self.copy(py, self.memory(py)?, physcore_engine::simulation::Simulation::capture)?;
        let record = PyDict::new(py);
        record.set_item("clock", [checkpoint.segment.start, checkpoint.segment.dt].to_pyarray(py))?;
        record.set_item("steps", [checkpoint.segment.steps, checkpoint.steps].to_pyarray(py))?;
        record.set_item("monitor", checkpoint.monitor.to_pyarray(py))?;
        let Adaptation { rejected, failed, range, control } = checkpoint.adaptation;
        record.set_item("adaptation", [range, control].as_flattened().to_pyarray(py))?;
        record.set_item("taken_back", [rejected, failed].to_pyarray(py))?;
        for (name, numbers) in checkpoint.system.into_arrays() {
            record.set_item(name, PyArray1::from_vec(py, numbers))?;
        }
        Ok(record)
    }

    fn restore(&self, py: Python<'_>, state: &Bound<'_, PyDict>) -> PyResult<()> {
        let [start, dt] = numbers(state, "clock")?;
        let [segment, steps] = numbers(state, "steps")?;
        let [smallest, largest, wanted, last] = numbers(state, "adaptation")?;
        let [rejected, failed] = numbers(state, "taken_back")?;
        let checkpoint = Checkpoint {
            segment: Segment { start, steps: segment, dt },
            steps,
            system: systems(state)?,
            monitor: numbers(state, "monitor")?,
            adaptation: Adaptation { rejected, failed, range: [smallest, largest], control: [wanted, last] },
        };
        self.change(py, |world| world.restore(&checkpoint))
    }

    fn state_hash(&self, py: Python<'_>) -> PyResult<String> {
        self.copy(py, self.memory(py)?, physcore_engine::simulation::Simulation::state_hash)
    }

    /// Sample a field in space at some points, row by row: of the forces on one body or on all, at a time or at present.
    #[pyo3(signature = (field, points, on, time=None))]
    fn sample<'py>(
        &self,
        py: Python<'py>,
        field: &str,
        points: &Bound<'py, PyAny>,
        on: Option<usize>,
        time: Option<f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let quantity = Quantity::named(field).ok_or_else(|| SceneError::new_err(format!("no field {field:?}")))?;
        let points = scene::copied(&points.call_method0("ravel")?.extract()?)?;
        let width = match quantity {
            Quantity::Acceleration | Quantity::ElectricField => self.dimension,
            Quantity::MagneticField => 3,
            Quantity::ElectricPotential => 1,
        };
        let ask = move |world: &Simulation, executor: &Executor| {
            world.sample(&Sample { quantity, time: time.unwrap_or_else(|| world.time()), points: &points, on }, executor)
        };
        let rows = if self.functions.is_empty() {
            self.ask(py, ask)?
        } else {
            // As for the energy, a user-defined function may try to change the world.
            self.change_at_length(py, move |world, executor| ask(world, executor))?
        };
        scene::rows(py, rows, width)
    }
}

fn class(class: Class) -> &'static str {
    match class {
        Class::Kinetic => "kinetic",
        Class::Potential => "potential",
        Class::Internal => "internal",
        Class::Dissipated => "dissipated",
        Class::Work => "work",
    }
}

fn stages_record<'py>(py: Python<'py>, stages: &Stages) -> PyResult<Bound<'py, PyDict>> {
    let record = PyDict::new(py);
    record.set_item("item", &stages.item)?;
    record.set_item("stages", &stages.names)?;
    record.set_item("dimension", stages.dimension)?;
    record.set_item("precision", stages.precision)?;
    record.set_item("integrator", stages.method)?;
    record.set_item("order", stages.order)?;
    record.set_item("evaluations", stages.evaluations)?;
    record.set_item("pairs", stages.pairs)?;
    record.set_item("force_error", stages.force_error)?;
    record.set_item("limit_varies", stages.limit_varies)?;
    record.set_item("layout", &stages.layout)?;
    record.set_item("left_out", &stages.left_out)?;
    record.set_item("notes", &stages.notes)?;
    Ok(record)
}

fn limit_record(py: Python<'_>, limit: Limit) -> PyResult<Bound<'_, PyDict>> {
    let record = PyDict::new(py);
    let kind = match limit.kind {
        LimitKind::Stability => "stability",
        LimitKind::Accuracy => "accuracy",
        LimitKind::None => "none",
    };
    record.set_item("dt", limit.dt())?;
    record.set_item("kind", kind)?;
    record.set_item("term", limit.term)?;
    record.set_item("stability", limit.stability)?;
    record.set_item("accuracy", limit.accuracy)?;
    record.set_item("certified", limit.certified)?;
    record.set_item("endured", limit.endured)?;
    Ok(record)
}

/// Arrays of the systems.
fn systems(state: &Bound<'_, PyDict>) -> PyResult<Archive> {
    let names = state.keys().iter().map(|name| name.extract()).collect::<PyResult<Vec<String>>>()?;
    let names = names.into_iter().filter(|name| !CLOCK.contains(&name.as_str()));
    names.map(|name| column(state, &name).map(|numbers| (name, numbers))).collect()
}

/// Names of the arrays of a captured state that belong to no system.
const CLOCK: [&str; 5] = ["clock", "steps", "monitor", "adaptation", "taken_back"];

fn column<T: numpy::Element + Clone + Sync>(state: &Bound<'_, PyDict>, name: &str) -> PyResult<Vec<T>> {
    let missing = || FileError::new_err(format!("state: {name} is missing or of the wrong kind"));
    let value = state.get_item(name)?.ok_or_else(missing)?;
    scene::copied(&value.extract::<PyReadonlyArray1<'_, T>>().map_err(|_| missing())?)
}

fn numbers<T: numpy::Element + Clone + Sync, const N: usize>(state: &Bound<'_, PyDict>, name: &str) -> PyResult<[T; N]> {
    column(state, name)?.try_into().map_err(|_| FileError::new_err(format!("state: {name} must hold {N} numbers")))
}
