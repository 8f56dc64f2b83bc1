//! The activity of a block, and the test of its range.

use crate::math::{Real, Vector};
use crate::matter::{Blocks, Span};
use crate::simd::{Isa, Kernel, LANES, dispatch};
use crate::systems::matter::dynamics::Dynamics;

/// Half of the sum over the lanes of m v² [J].
#[inline(always)]
pub(super) fn kinetic<T: Real, const W: usize>(squares: &[T; W]) -> f64 {
    0.5 * squares.iter().map(|square| square.to_f64()).sum::<f64>()
}

/// The activity of a block: the kinetic energy [J], ½ Σ m v², rough in single precision, and not finite as soon as one
/// velocity is not.
pub fn activity<V: Vector>(dynamics: &Dynamics<V>, blocks: &Blocks<'_, V>) -> f64 {
    dispatch(Activity { columns: &blocks.velocity, weights: &dynamics.properties.inertia[blocks.range()] })
}

struct Activity<'a, 'b, V: Vector> {
    columns: &'a Span<'b, V>,
    weights: &'a [V::Scalar],
}

impl<V: Vector> Kernel for Activity<'_, '_, V> {
    type Output = f64;

    #[inline(always)]
    fn run<S: Isa>(self, _isa: S) -> f64 {
        let weights = self.weights.as_chunks::<LANES>().0;
        let mut squares = [V::Scalar::ZERO; LANES];
        for axis in 0..V::DIMENSION {
            for (group, weights) in self.columns.axes[axis].as_chunks::<LANES>().0.iter().zip(weights) {
                for lane in 0..LANES {
                    squares[lane] += weights[lane] * (group[lane] * group[lane]);
                }
            }
        }
        kinetic(&squares)
    }
}

/// 0 where all positions of a block and its kinetic energy are finite, else NaN, which is 0·∞.
pub fn out_of_range<V: Vector>(dynamics: &Dynamics<V>, blocks: &Blocks<'_, V>) -> f64 {
    dispatch(OutOfRange { blocks, weights: &dynamics.properties.inertia[blocks.range()] })
}

struct OutOfRange<'a, 'b, V: Vector> {
    blocks: &'a Blocks<'b, V>,
    weights: &'a [V::Scalar],
}

impl<V: Vector> Kernel for OutOfRange<'_, '_, V> {
    type Output = f64;

    #[inline(always)]
    fn run<S: Isa>(self, _isa: S) -> f64 {
        let weights = self.weights.as_chunks::<LANES>().0;
        let mut sums = [V::Scalar::ZERO; LANES];
        for axis in 0..V::DIMENSION {
            let [x, v] = [&self.blocks.position, &self.blocks.velocity].map(|columns| columns.axes[axis].as_chunks::<LANES>().0);
            for ((x, v), weights) in x.iter().zip(v).zip(weights) {
                for lane in 0..LANES {
                    sums[lane] += V::Scalar::ZERO * x[lane] + V::Scalar::ZERO * (weights[lane] * (v[lane] * v[lane]));
                }
            }
        }
        sums.iter().map(|sum| sum.to_f64()).sum()
    }
}
