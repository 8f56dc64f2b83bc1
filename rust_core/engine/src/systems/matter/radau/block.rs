//! The series of one block on their way through a step.

use crate::integrators::gauss_radau_15::{self, COEFFICIENTS, Node, STAGES, Series};
use crate::math::Vector;
use crate::matter::{Span, View};
use crate::simd::{Isa, Kernel, LANES, Lanes, dispatch};

/// The data that persist, of a group of lanes along one axis.
pub type Memory = gauss_radau_15::Memory<LANES>;

/// The largest |values| that say how an iteration converges and how accurate a step is.
#[derive(Debug, Clone, Copy, Default)]
pub struct Largest {
    /// The last change of b₆ [m/s²].
    pub change: f64,
    /// The acceleration at the last node [m/s²].
    pub acceleration: f64,
    /// b₀ [m/s²].
    pub first: f64,
    /// b₆ [m/s²].
    pub last: f64,
    /// The position [m] and the velocity [m/s] at the step's start.
    pub position: f64,
    pub velocity: f64,
}

impl Largest {
    /// The larger of each.
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

    /// The error of a step of `h` seconds, |b₆| over |a|, and what rounding makes of it at most: that of the accelerations, and
    /// that of the positions times their gradient, which is b₀ over the way h v.
    pub fn error(&self, h: f64) -> [f64; 2] {
        if self.last == 0.0 {
            return [0.0; 2];
        }
        let ulps = if self.velocity > 0.0 { self.first / self.acceleration * self.position / (h * self.velocity) } else { 0.0 };
        [self.last / self.acceleration, 0.5 * f64::EPSILON * gauss_radau_15::CONDITION * (1.0 + ulps)]
    }
}

/// What is done with the accelerations of a stage.
#[derive(Debug, Clone, Copy)]
pub enum Task {
    /// Begins a step with that of its start, after one that it is this many times as long as, and moves to its first node.
    Open(Option<f64>),
    /// Takes in that of a node, and moves to the next one, or from the last one to the first.
    Correct(usize),
    /// Ends the step.
    Close,
}

/// One block; groups of lanes, of each the axes one after the other.
pub struct Block<'a, 'b, V: Vector> {
    /// Its first particle.
    pub start: usize,
    /// Positions [m] and velocities [m/s], to be written.
    pub state: [&'a mut Span<'b, V>; 2],
    /// The same at the step's start.
    pub origin: [View<'a, V>; 2],
    /// Accelerations [m/s²].
    pub acceleration: View<'a, V>,
    pub series: &'a mut [Series<LANES>],
    pub memory: &'a mut [Memory],
    pub largest: &'a mut Largest,
    /// Step size [s].
    pub h: f64,
    pub task: Task,
}

/// Does what a stage asks for, at the best level.
pub fn advance<V: Vector<Scalar = f64>>(block: Block<'_, '_, V>) {
    dispatch(block);
}

impl<V: Vector<Scalar = f64>> Kernel for Block<'_, '_, V> {
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
