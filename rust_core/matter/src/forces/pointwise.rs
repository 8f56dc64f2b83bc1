//! Evaluation loop of all pointwise forces.

use std::ops::Range;

use super::{Rates, StateView};
use crate::math::{AXES, Real, Vector};
use crate::matter::{EnergySink, Power, Span};
use crate::simd::{Isa, Kernel, LANES, Lanes, dispatch};

/// A pointwise force: a function of a particle's position and velocity.
pub trait ForceField<V: Vector>: Copy {
    /// The force [N] on a particle, and the dissipated and supplied power [W], all times `weight`, which is 0 for an
    /// unaffected particle. Axes past the dimension are 0 and are ignored.
    fn at(&self, weight: V::Scalar, x: [V::Scalar; AXES], v: [V::Scalar; AXES]) -> PointRate<V::Scalar>;
}

/// Force and powers on one particle.
#[derive(Debug, Clone, Copy)]
pub struct PointRate<T> {
    /// The force [N].
    pub force: [T; AXES],
    /// Power dissipated by drag [W].
    pub dissipated: T,
    /// Power supplied from outside [W].
    pub work: T,
}

/// Adds the forces and powers of a force field for one block; `members` is 1 for affected particles, else 0.
pub fn accumulate<V: Vector>(
    law: impl ForceField<V>,
    members: &[V::Scalar],
    block: Range<usize>,
    at: &StateView<'_, V>,
    rates: &mut Rates<'_, V>,
) {
    dispatch(PointwiseLoop {
        law,
        members: &members[block.clone()],
        block,
        at,
        force: rates.force.reborrow(),
        power: rates.power,
    });
}

struct PointwiseLoop<'a, V: Vector, L> {
    law: L,
    members: &'a [V::Scalar],
    block: Range<usize>,
    at: &'a StateView<'a, V>,
    force: Span<'a, V>,
    power: &'a mut Power,
}

impl<V: Vector, L: ForceField<V>> Kernel for PointwiseLoop<'_, V, L> {
    type Output = ();

    #[inline(always)]
    fn run<S: Isa>(self, _isa: S) {
        let Self { law, members, block, at, mut force, power } = self;
        let x: [&[Lanes<V::Scalar>]; AXES] = std::array::from_fn(|axis| lanes(at.position.slice(axis, block.clone())));
        let v: [&[Lanes<V::Scalar>]; AXES] = std::array::from_fn(|axis| lanes(at.velocity.slice(axis, block.clone())));
        let f = force.axes.each_mut().map(|axis| axis.as_chunks_mut::<LANES>().0);
        let mut dissipated = [V::Scalar::ZERO; LANES];
        let mut work = [V::Scalar::ZERO; LANES];
        // All input is copied to local arrays first, so that the compiler can exclude aliasing.
        for (group, member) in lanes(members).iter().enumerate() {
            let read = |columns: &[&[Lanes<V::Scalar>]; AXES]| -> [Lanes<V::Scalar>; AXES] {
                std::array::from_fn(|axis| if axis < V::DIMENSION { columns[axis][group] } else { [V::Scalar::ZERO; LANES] })
            };
            let (member, x, v) = (*member, read(&x), read(&v));
            let mut sum = [[V::Scalar::ZERO; LANES]; AXES];
            for lane in 0..LANES {
                let rate = law.at(member[lane], pick(&x, lane), pick(&v, lane));
                for axis in 0..V::DIMENSION {
                    sum[axis][lane] = rate.force[axis];
                }
                dissipated[lane] += rate.dissipated;
                work[lane] += rate.work;
            }
            for axis in 0..V::DIMENSION {
                let mut column = f[axis][group];
                for lane in 0..LANES {
                    column[lane] += sum[axis][lane];
                }
                f[axis][group] = column;
            }
        }
        for lane in 0..LANES {
            power[EnergySink::Drag as usize][lane] += dissipated[lane].to_f64();
            power[EnergySink::Work as usize][lane] += work[lane].to_f64();
        }
    }
}

#[inline(always)]
fn lanes<T>(column: &[T]) -> &[Lanes<T>] {
    column.as_chunks::<LANES>().0
}

#[inline(always)]
fn pick<T: Copy>(columns: &[Lanes<T>; AXES], lane: usize) -> [T; AXES] {
    [columns[0][lane], columns[1][lane], columns[2][lane]]
}
