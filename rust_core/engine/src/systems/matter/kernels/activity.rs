//! Activity of a block, and the test of its range.

use crate::catalog::Space;
use crate::math::Real;
use crate::matter::{Blocks, Span};
use crate::simd::{Isa, Kernel, LANES, dispatch};
use crate::systems::matter::dynamics::Dynamics;

/// Half of the sum over the lanes of m v² [J].
#[inline(always)]
pub(super) fn kinetic<T: Real, const W: usize>(squares: &[T; W]) -> f64 {
    0.5 * squares.iter().map(|square| square.to_f64()).sum::<f64>()
}

/// Activity of a block: the kinetic energy [J], ½ Σ m v², rough in single precision. The activity is not finite if a velocity
/// is not finite.
pub fn activity<V: Space>(dynamics: &Dynamics<V>, blocks: &Blocks<'_, V>) -> f64 {
    dispatch(ActivityKernel { columns: &blocks.velocity, weights: &dynamics.properties.inertia[blocks.range()] })
}

struct ActivityKernel<'a, 'b, V: Space> {
    columns: &'a Span<'b, V>,
    weights: &'a [V::Scalar],
}

impl<V: Space> Kernel for ActivityKernel<'_, '_, V> {
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

/// Returns 0 if all positions of a block and its kinetic energy are finite, else NaN (0·∞).
pub fn out_of_range<V: Space>(dynamics: &Dynamics<V>, blocks: &Blocks<'_, V>) -> f64 {
    dispatch(OutOfRange { blocks, weights: &dynamics.properties.inertia[blocks.range()] })
}

struct OutOfRange<'a, 'b, V: Space> {
    blocks: &'a Blocks<'b, V>,
    weights: &'a [V::Scalar],
}

impl<V: Space> Kernel for OutOfRange<'_, '_, V> {
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
