//! `World`: the engine's simulation.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, MutexGuard, TryLockError};

use numpy::{PyArray1, PyArray2, PyReadonlyArray1, ToPyArray};
use physcore_engine::error::{Error, Result as EngineResult};
use physcore_engine::forces::Flow;
use physcore_engine::simulation::{self, Adaptation, Capture, Numerics, Rule, Segment};
use physcore_engine::stability::{Kind, Limit};
use pyo3::gc::{PyTraverseError, PyVisit};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::callback::Function;
use crate::errors::{FileError, InternalError, PhyscoreError, exception};
use crate::scene;

/// A running simulation.
#[pyclass(frozen, module = "physcore._core")]
pub struct World {
    inner: Mutex<Box<dyn simulation::World>>,
    /// The functions that the engine calls: here the garbage collector finds them without a lock.
    functions: Vec<Arc<Function>>,
    dimension: usize,
}

type Guard<'a> = MutexGuard<'a, Box<dyn simulation::World>>;

impl World {
    fn lock(&self) -> PyResult<Guard<'_>> {
        match self.inner.try_lock() {
            Ok(guard) => Ok(guard),
            Err(TryLockError::WouldBlock) => Err(PhyscoreError::new_err(
                "this simulation is running, in another thread or around this call: wait until that has ended",
            )),
            Err(TryLockError::Poisoned(_)) => {
                Err(InternalError::new_err("this simulation was left in the middle of a step by an earlier internal error"))
            }
        }
    }

    /// Lets the engine change the world without the interpreter's lock. A panic becomes an exception, and poisons the world.
    fn change<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut dyn simulation::World) -> EngineResult<T> + Send,
    ) -> PyResult<T> {
        drop(self.lock()?);
        without_gil(py, || match self.inner.lock() {
            Ok(mut guard) => work(guard.as_mut()),
            Err(_) => Err(Error::State("it was lost by an internal error".to_owned())),
        })
    }
}

/// Lets the engine work without the interpreter's lock; a panic becomes an exception.
fn without_gil<T: Send>(py: Python<'_>, work: impl FnOnce() -> EngineResult<T> + Send) -> PyResult<T> {
    match py.detach(|| catch_unwind(AssertUnwindSafe(work))) {
        Ok(result) => result.map_err(|error| exception(py, error)),
        Err(panic) => {
            let message =
                panic.downcast_ref::<String>().cloned().or_else(|| panic.downcast_ref::<&str>().map(|&text| text.to_owned()));
            Err(InternalError::new_err(format!("the engine panicked, please report it: {}", message.unwrap_or_default())))
        }
    }
}

/// Whether a signal is waiting whose handler raises, as that of Ctrl-C does. The exception is raised again later.
fn interrupted() -> bool {
    Python::attach(|py| py.check_signals().map_err(|error| error.restore(py)).is_err())
}

#[pymethods]
impl World {
    #[new]
    fn new(
        py: Python<'_>,
        scene: &Bound<'_, PyDict>,
        integrator: String,
        precision: String,
        threads: Option<usize>,
        runaway: f64,
        on_divergence: &str,
    ) -> PyResult<Self> {
        let (scene, functions) = scene::read(scene)?;
        let numerics = Numerics { integrator, precision, threads, runaway, ignore_runaway: on_divergence == "ignore" };
        let dimension = scene.dimension;
        let inner = without_gil(py, || simulation::build(&scene, &numerics))?;
        Ok(Self { inner: Mutex::new(inner), functions, dimension })
    }

    /// Shows the garbage collector what may refer back to this. Like a tuple this needs no `__clear__`: what it refers to is
    /// older than it is, so a cycle goes through something that was changed later, and is opened there.
    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        self.functions.iter().try_for_each(|function| function.traverse(&visit))
    }

    /// Takes n steps of dt seconds, and gives the Mach number from which on a flow is fast, the largest share of a fluid that
    /// was ever seen to be, and its speed of sound [m/s]; nothing without a fluid.
    fn step(&self, py: Python<'_>, n: u64, dt: f64) -> PyResult<Option<(f64, f64, f64)>> {
        let flow = self.change(py, |world| world.step(n, dt, &interrupted).map(|()| world.flow()))?;
        Ok(flow.map(|flow| (Flow::FAST, flow.fast, flow.sound)))
    }

    /// Advances by an interval [s] in adaptive steps, and gives the same as `step`.
    fn run(
        &self,
        py: Python<'_>,
        interval: f64,
        safety: f64,
        free: f64,
        tolerance: Option<f64>,
    ) -> PyResult<Option<(f64, f64, f64)>> {
        let rule = Rule { safety, free, tolerance };
        let flow = self.change(py, |world| world.run(interval, &rule, &interrupted).map(|()| world.flow()))?;
        Ok(flow.map(|flow| (Flow::FAST, flow.fast, flow.sound)))
    }

    /// Of the adaptive steps so far: how many were taken back, how many diverged, and the smallest and the largest [s].
    fn adaptation(&self) -> PyResult<(u64, u64, f64, f64)> {
        let Adaptation { rejected, failed, range: [smallest, largest], .. } = self.lock()?.adaptation();
        Ok((rejected, failed, smallest, largest))
    }

    #[getter]
    fn time(&self) -> PyResult<f64> {
        Ok(self.lock()?.segment().time())
    }

    #[getter]
    fn steps(&self) -> PyResult<u64> {
        Ok(self.lock()?.steps())
    }

    #[getter]
    fn dt(&self) -> PyResult<f64> {
        Ok(self.lock()?.segment().dt)
    }

    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        scene::array(py, &self.lock()?.positions(), self.dimension)
    }

    fn velocities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        scene::array(py, &self.lock()?.velocities(), self.dimension)
    }

    fn densities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(self.lock()?.fields().density.to_pyarray(py))
    }

    fn pressures<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(self.lock()?.fields().pressure.to_pyarray(py))
    }

    fn set(&self, py: Python<'_>, positions: Option<&Bound<'_, PyAny>>, velocities: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        let positions = positions.map(scene::vectors).transpose()?;
        let velocities = velocities.map(scene::vectors).transpose()?;
        self.change(py, |world| world.set(positions.as_deref(), velocities.as_deref()))
    }

    fn energy<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let guard = self.lock()?;
        let world = &*guard;
        let energy = without_gil(py, || world.energy())?;
        let (record, potential, dissipated) = (PyDict::new(py), PyDict::new(py), PyDict::new(py));
        for (name, value) in &energy.potential {
            potential.set_item(name, value)?;
        }
        for (name, value) in ["drag", "damping", "contacts", "viscosity"].iter().zip(energy.dissipated) {
            dissipated.set_item(name, value)?;
        }
        record.set_item("kinetic", energy.kinetic)?;
        record.set_item("potential", potential)?;
        record.set_item("internal", energy.internal)?;
        record.set_item("dissipated", energy.dissipated())?;
        record.set_item("dissipated_by", dissipated)?;
        record.set_item("work", energy.work)?;
        Ok(record)
    }

    fn momentum<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let (momentum, _) = self.lock()?.momenta();
        Ok(momentum.to_array()[..self.dimension].to_pyarray(py))
    }

    fn angular_momentum<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let (_, angular) = self.lock()?.momenta();
        let components = angular.to_array();
        Ok(if self.dimension == 2 { components[2..].to_pyarray(py) } else { components.to_pyarray(py) })
    }

    fn limit<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let guard = self.lock()?;
        let world = &*guard;
        limit_record(py, without_gil(py, || world.limit())?)
    }

    fn certified(&self, py: Python<'_>) -> PyResult<f64> {
        self.change(py, |world| world.certified())
    }

    fn present_limit<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let guard = self.lock()?;
        let world = &*guard;
        limit_record(py, without_gil(py, || world.present_limit())?)
    }

    fn plan<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let world = self.lock()?;
        let plan = world.plan();
        let record = PyDict::new(py);
        record.set_item("stages", &plan.stages)?;
        record.set_item("dimension", plan.dimension)?;
        record.set_item("precision", plan.precision)?;
        record.set_item("integrator", plan.integrator)?;
        record.set_item("order", plan.order)?;
        record.set_item("evaluations", plan.evaluations)?;
        record.set_item("pairs", plan.pairs)?;
        record.set_item("limit_varies", plan.limit_varies)?;
        record.set_item("memory", plan.memory)?;
        record.set_item("threads", plan.threads)?;
        record.set_item("simd", plan.simd)?;
        record.set_item("layout", &plan.layout)?;
        record.set_item("left_out", &plan.left_out)?;
        record.set_item("notes", [plan.notes.as_slice(), &world.findings()].concat())?;
        Ok(record)
    }

    fn capture<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let capture = self.lock()?.capture();
        let record = PyDict::new(py);
        record.set_item("clock", [capture.segment.start, capture.segment.dt].to_pyarray(py))?;
        record.set_item("steps", [capture.segment.steps, capture.steps].to_pyarray(py))?;
        record.set_item("columns", capture.columns.to_pyarray(py))?;
        record.set_item("meters", capture.meters.to_pyarray(py))?;
        record.set_item("watch", capture.watch.to_pyarray(py))?;
        record.set_item("forces", capture.forces.to_pyarray(py))?;
        let Adaptation { rejected, failed, range, control } = capture.adaptation;
        record.set_item("adaptation", [range, control].as_flattened().to_pyarray(py))?;
        record.set_item("taken_back", [rejected, failed].to_pyarray(py))?;
        Ok(record)
    }

    fn restore(&self, py: Python<'_>, state: &Bound<'_, PyDict>) -> PyResult<()> {
        let [start, dt] = numbers(state, "clock")?;
        let [segment, steps] = numbers(state, "steps")?;
        let [smallest, largest, wanted, last] = numbers(state, "adaptation")?;
        let [rejected, failed] = numbers(state, "taken_back")?;
        let capture = Capture {
            segment: Segment { start, steps: segment, dt },
            steps,
            columns: column(state, "columns")?,
            meters: column(state, "meters")?,
            watch: numbers(state, "watch")?,
            adaptation: Adaptation { rejected, failed, range: [smallest, largest], control: [wanted, last] },
            forces: column(state, "forces")?,
        };
        self.change(py, |world| world.restore(&capture))
    }

    fn state_hash(&self) -> PyResult<String> {
        Ok(self.lock()?.state_hash())
    }
}

fn limit_record(py: Python<'_>, limit: Limit) -> PyResult<Bound<'_, PyDict>> {
    let record = PyDict::new(py);
    let kind = match limit.kind {
        Kind::Stability => "stability",
        Kind::Accuracy => "accuracy",
        Kind::None => "none",
    };
    record.set_item("dt", limit.dt())?;
    record.set_item("kind", kind)?;
    record.set_item("term", limit.term)?;
    record.set_item("stability", limit.stability)?;
    record.set_item("accuracy", limit.accuracy)?;
    record.set_item("certified", limit.certified)?;
    Ok(record)
}

fn column<T: numpy::Element + Clone>(state: &Bound<'_, PyDict>, name: &str) -> PyResult<Vec<T>> {
    let missing = || FileError::new_err(format!("state: {name} is missing or of the wrong kind"));
    let value = state.get_item(name)?.ok_or_else(missing)?;
    Ok(value.extract::<PyReadonlyArray1<'_, T>>().map_err(|_| missing())?.as_array().to_vec())
}

fn numbers<T: numpy::Element + Clone, const N: usize>(state: &Bound<'_, PyDict>, name: &str) -> PyResult<[T; N]> {
    column(state, name)?.try_into().map_err(|_| FileError::new_err(format!("state: {name} must hold {N} numbers")))
}
