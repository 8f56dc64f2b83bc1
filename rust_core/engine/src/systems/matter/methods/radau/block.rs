//! Series of one block during a step.

use crate::catalog::Space;
use crate::integrators::gauss_radau_15::{self, COEFFICIENTS, Node, STAGES, Series};
use crate::matter::{Span, View};
use crate::simd::{Isa, Kernel, LANES, Lanes, dispatch};

/// Persistent data of a group of lanes along one axis.
pub type LaneMemory = gauss_radau_15::Memory<LANES>;

/// Largest |values|, which measure the convergence of an iteration and the accuracy of a step.
#[derive(Debug, Clone, Copy, Default)]
pub struct Largest {
    /// Last change of b₆ [m/s²].
    pub change: f64,
    /// Acceleration at the last node [m/s²].
    pub acceleration: f64,
    /// Coefficient b₀ [m/s²].
    pub first: f64,
    /// Coefficient b₆ [m/s²].
    pub last: f64,
    /// Position [m] and velocity [m/s] at the start of the step.
    pub position: f64,
    pub velocity: f64,
}

impl Largest {
    /// Larger of each value.
    pub fn max(self, other: Self) -> Self {
        Self {
            change: self.change.max(other.change),
            acceleration: self.acceleration.max(other.acceleration),
            first: self.first.max(other.first),
            last: self.last.max(other.last),
            position: self.position.max(other.position),
            velocity: self.velocity.max(other.velocity),
        }
    }

    /// Error of a step of `h` seconds, |b₆| over |a|, and the largest contribution of rounding to it. Rounding errors are
    /// those of the accelerations, and those of the positions times the gradient. The gradient is b₀ over the path h v.
    pub fn error(&self, h: f64) -> [f64; 2] {
        if self.last == 0.0 {
            return [0.0; 2];
        }
        let ulps = if self.velocity > 0.0 { self.first / self.acceleration * self.position / (h * self.velocity) } else { 0.0 };
        [self.last / self.acceleration, 0.5 * f64::EPSILON * gauss_radau_15::CONDITION * (1.0 + ulps)]
    }
}

/// Use of the accelerations of a stage.
#[derive(Debug, Clone, Copy)]
pub enum Task {
    /// Begins a step with the acceleration at its start, and moves to its first node. The ratio is the size of the step over
    /// that of the step before.
    Open(Option<f64>),
    /// Corrects the series by the acceleration of a node, and moves to the next node, or from the last one to the first.
    Correct(usize),
    /// Ends the step.
    Close,
}

/// One block, as groups of lanes; in each group the axes one after the other.
pub struct RadauBlock<'a, 'b, V: Space> {
    /// First particle of the block.
    pub start: usize,
    /// Positions [m] and velocities [m/s], to be written.
    pub state: [&'a mut Span<'b, V>; 2],
    /// Positions [m] and velocities [m/s] at the start of the step.
    pub origin: [View<'a, V>; 2],
    /// Accelerations [m/s²].
    pub acceleration: View<'a, V>,
    pub series: &'a mut [Series<LANES>],
    pub memory: &'a mut [LaneMemory],
    pub largest: &'a mut Largest,
    /// Step size [s].
    pub h: f64,
    pub task: Task,
}

/// Performs the task of a stage, at the best SIMD level.
pub fn advance<V: Space<Scalar = f64>>(block: RadauBlock<'_, '_, V>) {
    dispatch(block);
}

impl<V: Space<Scalar = f64>> Kernel for RadauBlock<'_, '_, V> {
    type Output = ();

    #[inline(always)]
    fn run<S: Isa>(self, _isa: S) {
        let Self { start, state: [positions, velocities], origin: [x0, v0], acceleration, series, memory, largest, h, task } =
            self;
        let nodes: [Node; STAGES] = std::array::from_fn(|node| Node::new(node, h));
        let mut most = [[0.0; LANES]; 6];
        for axis in 0..V::DIMENSION {
            let range = start..start + positions.len();
            let [x0, v0, a] = [x0, v0, acceleration].map(|columns| columns.slice(axis, range.clone()).as_chunks::<LANES>().0);
            let [x, v] = [&mut *positions, &mut *velocities].map(|columns| columns.axes[axis].as_chunks_mut::<LANES>().0);
            for group in 0..a.len() {
                let entry = group * V::DIMENSION + axis;
                let (series, memory) = (&mut series[entry], &mut memory[entry]);
                let a = a[group];
                let (mut position, mut velocity) = (x0[group], v0[group]);
                let next = match task {
                    Task::Open(ratio) => {
                        *series = Series::new(a, memory.predict(ratio));
                        1
                    }
                    Task::Correct(node) => {
                        let changed = series.correct(node, &a);
                        if node + 1 == STAGES {
                            let values = [changed, a, series.b[0], series.b[COEFFICIENTS - 1], position, velocity];
                            for (most, values) in most.iter_mut().zip(&values) {
                                raise(most, values);
                            }
                            1
                        } else {
                            node + 1
                        }
                    }
                    Task::Close => 0,
                };
                if next == 0 {
                    series.end(h, memory, &mut position, &mut velocity);
                } else {
                    series.node_state(&nodes[next], memory, &mut position, &mut velocity);
                }
                (x[group], v[group]) = (position, velocity);
            }
        }
        let [change, acceleration, first, last, position, velocity] = most.map(|lanes| lanes.iter().copied().fold(0.0, f64::max));
        *largest = Largest { change, acceleration, first, last, position, velocity };
    }
}

/// Raises each lane to the absolute value of another, if that is larger.
#[inline(always)]
fn raise(largest: &mut Lanes<f64>, values: &Lanes<f64>) {
    for lane in 0..LANES {
        let value = values[lane].abs();
        largest[lane] = if value > largest[lane] { value } else { largest[lane] };
    }
}
