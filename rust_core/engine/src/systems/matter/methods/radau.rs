//! Gauss–Radau collocation of order 15 (IAS15) as a method of matter.
//!
//! A step evaluates the forces at its start. The forces at the seven nodes are then evaluated repeatedly, until b₆ changes by
//! no more than rounding. The coefficients of a step predict those of the next, so that two or three passes are enough.
//! Positions and velocities are summed with their low-order parts. Power is integrated by the same quadrature, at the last
//! pass.
//!
//! The estimated error is the largest |b₆| over the largest |a| of all particles. Its rounding may exceed the tolerance, as
//! in an encounter far from the origin. The error is then in units of the rounding: shorter steps would not make it smaller.
//! Source and formulas: [`crate::integrators::gauss_radau_15`].

mod block;

use block::{LaneMemory, Largest, RadauBlock, Task};

use super::coupled::Workspace;
use super::{Job, Method, MethodMemory, MethodProperties, MethodRefusals, Treatment};
use crate::catalog::Space;
use crate::error::{Error, Result};
use crate::forces::Rates;
use crate::history::{Archive, History};
use crate::integrators::gauss_radau_15::{self as rule, STAGES, Series};
use crate::matter::{Blocks, Matter, Power, SINKS, Span};
use crate::parallel::{BlockedSlice, Executor, Split};
use crate::scene::Item;
use crate::simd::{LANES, padded};
use crate::stability::{Limit, LimitCache, SpectralBound};
use crate::systems::matter::activity::Activity;
use crate::systems::matter::dynamics::Dynamics;
use crate::systems::matter::kernels;
use crate::systems::{Control, Interval};

/// Maximum number of iterations of a step.
const MOST_ITERATIONS: usize = 12;
/// Change of b₆ relative to the acceleration at which an iteration has converged.
const CONVERGED: f64 = 1e-16;

/// Data that persists from step to step.
#[derive(Debug, Clone, Default)]
struct Kept {
    /// Size of the last step [s]; 0 before the first one.
    h: f64,
    groups: Vec<LaneMemory>,
}

/// Gauss–Radau method with its buffers.
#[derive(Debug)]
pub struct GaussRadau15 {
    /// Tolerance of the error estimate: the largest relative change of b₆ that a last iteration may leave.
    tolerance: f64,
    kept: Kept,
    /// Data at the start of the last batch.
    saved: Kept,
    series: Vec<Series<LANES>>,
    /// Power at each stage, by blocks [W].
    power: Vec<[Power; STAGES]>,
    largest: Vec<Largest>,
    /// Estimated error of the last step.
    error: f64,
    /// Number of steps, of their iterations, and of steps whose iterations did not converge. Steps that were rolled back
    /// count too.
    taken: [u64; 3],
}

impl GaussRadau15 {
    /// Builds the method that an item declares.
    ///
    /// # Errors
    /// If its tolerance is missing or not above 0.
    pub fn declared(item: &Item) -> Result<Self> {
        let tolerance = item.number("tolerance")?;
        if tolerance <= 0.0 {
            return Err(Error::parameter(format!("{}.tolerance", item.path), "a finite number > 0", tolerance));
        }
        Ok(Self {
            tolerance,
            kept: Kept::default(),
            saved: Kept::default(),
            series: Vec::new(),
            power: Vec::new(),
            largest: Vec::new(),
            error: 0.0,
            taken: [0; 3],
        })
    }

    /// Takes one step; returns the activity at its last evaluation.
    fn step<V: Space<Scalar = f64>>(
        &mut self,
        dynamics: &mut Dynamics<V>,
        matter: &mut Matter<V>,
        workspace: &mut Workspace<V>,
        (interval, step): (Interval, u64),
        executor: &Executor,
    ) -> Result<f64> {
        let h = interval.h;
        workspace.position.copy_from(&matter.position);
        workspace.velocity.copy_from(&matter.velocity);
        self.evaluate(dynamics, matter, workspace, (0, interval.time(step, 0.0)), executor)?;
        let ratio = Some(h / self.kept.h).filter(|ratio| *ratio <= rule::LARGEST_RATIO);
        self.update(matter, workspace, h, Task::Open(ratio), executor);
        let (mut before, mut iterations) = (f64::INFINITY, 0);
        let (largest, change) = loop {
            for node in 1..STAGES {
                self.evaluate(dynamics, matter, workspace, (node, interval.time(step, rule::NODES[node])), executor)?;
                self.update(matter, workspace, h, Task::Correct(node), executor);
            }
            iterations += 1;
            let largest = self.largest.iter().copied().fold(Largest::default(), Largest::max);
            // At rest, or in free motion, both are 0.
            let change = if largest.change > 0.0 { largest.change / largest.acceleration } else { 0.0 };
            let oscillates = iterations > 2 && change >= before;
            if change <= CONVERGED || oscillates || iterations == MOST_ITERATIONS || executor.stopped() {
                break (largest, change);
            }
            before = change;
        };
        self.update(matter, workspace, h, Task::Close, executor);
        self.kept.h = h;
        let [error, rounding] = largest.error(h);
        self.error = error * (self.tolerance / rounding.max(self.tolerance));
        for (tally, power) in matter.tallies.iter_mut().zip(&self.power) {
            for (power, weight) in power.iter().zip(rule::WEIGHTS) {
                kernels::integrate(tally, kernels::through_all(power), h * weight, 0.0, false);
            }
        }
        let counts = [1, iterations as u64, u64::from(change > self.tolerance)];
        self.taken.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
        Ok(workspace.activity.iter().sum())
    }

    /// Evaluates accelerations and powers at a stage, at the present state.
    fn evaluate<V: Space<Scalar = f64>>(
        &mut self,
        dynamics: &mut Dynamics<V>,
        matter: &Matter<V>,
        workspace: &mut Workspace<V>,
        (stage, time): (usize, f64),
        executor: &Executor,
    ) -> Result<()> {
        dynamics.prepare(matter, time, executor)?;
        let dynamics = &*dynamics;
        let at = dynamics.view_of(matter, time, executor);
        let forces = ForceBlocks { start: 0, size: matter.block, force: workspace.force.span() };
        let sums = (BlockedSlice::new(&mut self.power, 1), BlockedSlice::new(&mut workspace.activity, 1));
        executor.for_each_block((forces, sums), &|(ForceBlocks { start, mut force, .. }, (power, activity))| {
            let mut sum: Power = [[0.0; LANES]; SINKS];
            let range = start..start + force.len();
            dynamics.accumulate(&range, &at, &mut Rates::new(force.reborrow(), &mut sum));
            activity.items[0] = kernels::accelerations(dynamics, start, (at.position, at.velocity), &mut force, &mut sum);
            power.items[0][stage] = sum;
        });
        Ok(())
    }

    /// Applies a task with the accelerations of all particles.
    fn update<V: Space<Scalar = f64>>(
        &mut self,
        matter: &mut Matter<V>,
        workspace: &Workspace<V>,
        h: f64,
        task: Task,
        executor: &Executor,
    ) {
        let origin = [workspace.position.view(), workspace.velocity.view()];
        let acceleration = workspace.force.view();
        let entries = (matter.block / LANES * V::DIMENSION).max(1);
        let series = BlockedSlice::new(&mut self.series, entries);
        let kept = (BlockedSlice::new(&mut self.kept.groups, entries), BlockedSlice::new(&mut self.largest, 1));
        executor.for_each_block((matter.blocks(), (series, kept)), &|(mut blocks, (series, (memory, largest)))| {
            block::advance(RadauBlock {
                start: blocks.start,
                state: [&mut blocks.position, &mut blocks.velocity],
                origin,
                acceleration,
                series: series.items,
                memory: memory.items,
                largest: &mut largest.items[0],
                h,
                task,
            });
        });
    }
}

/// Blocks of forces.
struct ForceBlocks<'a, V: Space> {
    start: usize,
    size: usize,
    force: Span<'a, V>,
}

impl<V: Space> Split for ForceBlocks<'_, V> {
    fn blocks(&self) -> usize {
        self.force.len().div_ceil(self.size)
    }

    fn split_at(self, blocks: usize) -> (Self, Self) {
        let length = blocks * self.size;
        let (first, rest) = self.force.split_at(length);
        (Self { force: first, ..self }, Self { start: self.start + length, size: self.size, force: rest })
    }
}

/// History: the coefficients of the last step, its size, and the low-order parts of the state.
impl History for GaussRadau15 {
    fn save(&mut self) {
        self.saved.clone_from(&self.kept);
    }

    fn rollback(&mut self) {
        std::mem::swap(&mut self.saved, &mut self.kept);
    }

    fn capture(&self, archive: &mut Archive) {
        archive.write("step", [self.kept.h]);
        archive.write("series", self.kept.groups.iter().flat_map(LaneMemory::rows).flatten().copied());
    }

    fn restore(&mut self, archive: &mut Archive) -> Result<()> {
        self.kept.h = archive.read_number("step")?;
        let count = self.kept.groups.iter().flat_map(LaneMemory::rows).map(|row| row.len()).sum();
        let rows = self.kept.groups.iter_mut().flat_map(LaneMemory::rows_mut);
        rows.flatten().zip(archive.read_exactly("series", count)?).for_each(|(slot, &number)| *slot = number);
        Ok(())
    }
}

impl<V: Space<Scalar = f64>> Method<V> for GaussRadau15 {
    fn about(&self) -> MethodProperties {
        // Per particle: the series, and the persistent data with its copy.
        let vectors = 1 + 2 * rule::COEFFICIENTS + 2 * LaneMemory::ROWS;
        MethodProperties {
            name: rule::NAME,
            orders: [rule::ORDER, rule::ORDER],
            // For a step with two iterations, as most steps are at the default tolerance.
            evaluations: 1 + 2 * rule::COEFFICIENTS,
            memory: MethodMemory { own: vectors, ..MethodMemory::default() },
            sweeps: true,
            angle: None,
            limit: rule::limit,
            springs: Treatment::Forces,
            drift: None,
            refusals: MethodRefusals {
                fields: None,
                kinks: Some("its steps are polynomials of degree 9, which contacts, SoftSpheres and fluids would break"),
            },
        }
    }

    fn persistent(&self) -> usize {
        0
    }

    fn error(&self, _state: &Matter<V>, _h: f64) -> Option<f64> {
        Some(self.error)
    }

    fn control(&self) -> Control {
        Control::GAUSS_RADAU
    }

    fn gains_energy(&self) -> bool {
        false
    }

    fn note(&self) -> Option<String> {
        let [steps, iterations, unconverged] = self.taken;
        let mean = iterations as f64 / steps as f64;
        let passes = || format!("{}: {mean:.2} iterations per step of {} evaluations each", rule::NAME, rule::COEFFICIENTS);
        let failed = match unconverged {
            0 => String::new(),
            some => format!("; in {some} steps they did not converge: take a smaller dt, or \"auto\""),
        };
        (steps > 0).then(|| passes() + &failed)
    }

    fn bytes(&self) -> usize {
        (self.kept.groups.len() + self.saved.groups.len()) * size_of::<LaneMemory>()
            + size_of_val(self.series.as_slice())
            + size_of_val(self.power.as_slice())
    }

    fn bound(&self, bound: SpectralBound) -> SpectralBound {
        bound
    }

    fn limit(&self, bound: &SpectralBound, _cache: &mut LimitCache) -> Limit {
        bound.limit_of(rule::limit)
    }

    fn sharp_limit(&self, bound: SpectralBound) -> Limit {
        let certified = bound.limit_of(rule::limit).stability;
        Limit { certified, ..bound.sharpened().limit_of(rule::limit) }
    }

    fn begin(&mut self, Job { dynamics, state, workspace, interval, .. }: Job<'_, V>, executor: &Executor) -> Result<()> {
        let entries = padded(state.count()) / LANES * V::DIMENSION;
        let blocks = state.tallies.len();
        self.kept = Kept { h: 0.0, groups: vec![LaneMemory::ZERO; entries] };
        self.series = vec![Series::ZERO; entries];
        self.power = vec![[[[0.0; LANES]; SINKS]; STAGES]; blocks];
        self.largest = vec![Largest::default(); blocks];
        let Some(workspace) = workspace else { return Ok(()) };
        self.evaluate(dynamics, state, workspace, (0, interval.start), executor)
    }

    fn advance(
        &mut self,
        Job { dynamics, state, record, workspace, interval, .. }: Job<'_, V>,
        executor: &Executor,
    ) -> Result<()> {
        let (Some(workspace), activity): (_, &mut Activity) = (workspace, record.0) else { return Ok(()) };
        for step in 0..interval.steps {
            let mut kinetic = self.step(dynamics, state, workspace, (interval, step), executor)?;
            if step + 1 == interval.steps {
                let work = (state.blocks(), BlockedSlice::new(&mut workspace.activity, 1));
                executor.for_each_block(work, &|(blocks, sum): (Blocks<'_, V>, BlockedSlice<'_, f64>)| {
                    sum.items[0] = kernels::out_of_range(dynamics, &blocks);
                });
                kinetic += workspace.activity.iter().sum::<f64>();
            }
            activity.push(kinetic);
            if executor.stopped() {
                break;
            }
        }
        Ok(())
    }
}
