//! Laws: velocities that are known at every point and stage, with their kernels.

use super::points::{BLOCK, PointBlock, Points};
use crate::integrators::Tableau;
use crate::integrators::explicit::{self, Coefficients, CompiledTableau, Kutta, SLOPES, Slope, TableauRows};
use crate::math::Real;
use crate::parallel::{BlockedSlice, Executor};
use crate::simd::{Isa, Kernel, LANES, Number, Pack, dispatch_wide};

/// Velocity field v(x) [m/s], known at each stage of an interval, by the number of the stage. All of its code must be
/// `#[inline(always)]` to stay in registers.
pub trait VelocityLaw<T, const D: usize>: Copy + Send + Sync {
    /// Velocity v [m/s].
    fn velocity<N: Number<Scalar = T>>(&self, stage: usize, point: [N; D]) -> [N; D];

    /// Velocity gradient ∇v [1/s]: `gradient[i][j]` is ∂vᵢ/∂xⱼ.
    fn gradient<N: Number<Scalar = T>>(&self, stage: usize, point: [N; D]) -> [[N; D]; D];
}

/// State at the end of a batch: whether it is finite, and its error.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Outcome {
    /// 0, or NaN if a position is not finite.
    pub finite: f64,
    /// Largest estimated error of the only step [m], for a method with an estimate.
    pub error: f64,
}

impl Outcome {
    /// Combines two outcomes.
    pub fn and(self, other: Self) -> Self {
        Self { finite: self.finite + other.finite, error: self.error.max(other.error) }
    }
}

/// Takes steps of `h` seconds with all points, block by block, each block through all steps.
pub fn advance<T: Real, L: VelocityLaw<T, D>, const D: usize>(
    law: L,
    method: Coefficients,
    points: &mut Points<T, D>,
    h: f64,
    steps: u64,
    executor: &Executor,
) -> Outcome {
    if method.name == Kutta::NAME {
        return advance_by(law, CompiledTableau::<Kutta>::NEW, points, h, steps, executor);
    }
    advance_by(law, method, points, h, steps, executor)
}

fn advance_by<T: Real, L: VelocityLaw<T, D>, M: TableauRows, const D: usize>(
    law: L,
    method: M,
    points: &mut Points<T, D>,
    h: f64,
    steps: u64,
    executor: &Executor,
) -> Outcome {
    let mut outcomes = vec![Outcome::default(); points.block_count()];
    let work = (points.blocks(), BlockedSlice::new(&mut outcomes, 1));
    executor.for_each_block(work, &|(PointBlock { axes, .. }, outcomes): (PointBlock<'_, T, D>, BlockedSlice<'_, Outcome>)| {
        outcomes.items[0] = dispatch_wide(TracerSteps { law, axes, h, count: steps, method });
    });
    outcomes.into_iter().fold(Outcome::default(), Outcome::and)
}

/// Kernel of the steps of a block.
struct TracerSteps<'a, T, L, M, const D: usize> {
    law: L,
    axes: [&'a mut [T]; D],
    h: f64,
    count: u64,
    method: M,
}

/// Slopes of a step; `first` is the number of its first stage.
struct Slopes<'a, L> {
    law: &'a L,
    first: usize,
}

impl<N: Number, L: VelocityLaw<N::Scalar, D>, const D: usize> Slope<N, D> for Slopes<'_, L> {
    #[inline(always)]
    fn slope(&self, number: usize, state: [N; D]) -> [N; D] {
        self.law.velocity(self.first + number, state)
    }
}

impl<T: Real, L: VelocityLaw<T, D>, M: TableauRows, const D: usize> Kernel for TracerSteps<'_, T, L, M, D> {
    type Output = Outcome;

    #[inline(always)]
    fn run<I: Isa>(self, _isa: I) -> Outcome {
        let Self { law, axes, h, count, method } = self;
        let (length, width) = (axes[0].len(), <I::Pack<T> as Pack>::WIDTH);
        let zero = <I::Pack<T> as Number>::constant(0.0);
        let (mut finite, mut error) = (zero, zero);
        let estimates = count == 1 && !method.errors().is_empty();
        for step in 0..count as usize {
            let slopes = Slopes { law: &law, first: step * method.evaluations() };
            for at in (0..length).step_by(width) {
                let mut start = [zero; D];
                for axis in 0..D {
                    start[axis] = <I::Pack<T> as Pack>::load(&axes[axis][at..]);
                }
                let (end, mut known) = explicit::step(method, &slopes, &start, h);
                for axis in 0..D {
                    end[axis].store(&mut axes[axis][at..]);
                }
                if estimates {
                    known[method.evaluations().min(SLOPES - 1)] = law.velocity(method.evaluations(), end);
                    for estimate in explicit::estimate(method, &known, h) {
                        error = estimate.max(zero - estimate).max(error);
                    }
                }
            }
        }
        for at in (0..length).step_by(width) {
            for column in &axes {
                let value = <I::Pack<T> as Pack>::load(&column[at..]);
                finite += value * zero;
            }
        }
        let mut lanes = [[T::ZERO; LANES]; 2];
        finite.store(&mut lanes[0]);
        error.store(&mut lanes[1]);
        let [finite, error] = lanes.map(|lanes| lanes.map(Real::to_f64));
        Outcome { finite: finite.iter().sum(), error: error.into_iter().fold(0.0, f64::max) }
    }
}

/// Velocities of points.
pub fn velocities<T: Real, L: VelocityLaw<T, D>, const D: usize>(
    law: L,
    stage: usize,
    points: &Points<T, D>,
    out: &mut Points<T, D>,
    executor: &Executor,
) {
    executor.for_each_block(out.blocks(), &|PointBlock { start, axes }: PointBlock<'_, T, D>| {
        let points = points.axes.each_ref().map(|axis| &axis[start..start + axes[0].len()]);
        dispatch_wide(Velocities { law, stage, points, out: axes });
    });
}

struct Velocities<'a, T, L, const D: usize> {
    law: L,
    stage: usize,
    points: [&'a [T]; D],
    out: [&'a mut [T]; D],
}

impl<T: Real, L: VelocityLaw<T, D>, const D: usize> Kernel for Velocities<'_, T, L, D> {
    type Output = ();

    #[inline(always)]
    fn run<I: Isa>(self, _isa: I) {
        let width = <I::Pack<T> as Pack>::WIDTH;
        for at in (0..self.points[0].len()).step_by(width) {
            let mut point = [<I::Pack<T> as Number>::constant(0.0); D];
            for axis in 0..D {
                point[axis] = <I::Pack<T> as Pack>::load(&self.points[axis][at..]);
            }
            let velocity = self.law.velocity(self.stage, point);
            for axis in 0..D {
                velocity[axis].store(&mut self.out[axis][at..]);
            }
        }
    }
}

/// Largest |∇v| at points [1/s]: the root of the sum of the squares of all derivatives.
pub fn steepest<T: Real, L: VelocityLaw<T, D>, const D: usize>(
    law: L,
    stage: usize,
    points: &Points<T, D>,
    executor: &Executor,
) -> f64 {
    let mut squares = vec![0.0; points.block_count()];
    executor.for_each_block(BlockedSlice::new(&mut squares, 1), &|block: BlockedSlice<'_, f64>| {
        let range = block.start * BLOCK..((block.start + 1) * BLOCK).min(points.axes[0].len());
        let points = points.axes.each_ref().map(|axis| &axis[range.clone()]);
        block.items[0] = dispatch_wide(Steepest { law, stage, points });
    });
    squares.into_iter().fold(0.0, f64::max).sqrt()
}

struct Steepest<'a, T, L, const D: usize> {
    law: L,
    stage: usize,
    points: [&'a [T]; D],
}

impl<T: Real, L: VelocityLaw<T, D>, const D: usize> Kernel for Steepest<'_, T, L, D> {
    type Output = f64;

    #[inline(always)]
    fn run<I: Isa>(self, _isa: I) -> f64 {
        let zero = <I::Pack<T> as Number>::constant(0.0);
        let mut largest = zero;
        for at in (0..self.points[0].len()).step_by(<I::Pack<T> as Pack>::WIDTH) {
            let mut point = [zero; D];
            for axis in 0..D {
                point[axis] = <I::Pack<T> as Pack>::load(&self.points[axis][at..]);
            }
            let gradient = self.law.gradient(self.stage, point);
            let mut square = zero;
            for row in gradient {
                for derivative in row {
                    square += derivative * derivative;
                }
            }
            largest = square.max(largest);
        }
        let mut lanes = [T::ZERO; LANES];
        largest.store(&mut lanes);
        lanes.into_iter().fold(0.0, |most, lane| lane.to_f64().max(most))
    }
}
