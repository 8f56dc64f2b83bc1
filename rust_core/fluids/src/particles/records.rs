//! Layout of the records of pair sums: position, velocity, and two words. The first is the volume, tagged with the material of
//! the particle. The second is the content, a quantity of the method, such as a pressure.

use super::material::KINDS;
use crate::math::{Real, Vector};
use crate::neighbors::NeighborList;
use crate::neighbors::sums::{Pair, Records};
use crate::parallel::Executor;
use crate::simd::{Number, ParticleRecord};

/// Writes the records of all members. The velocity is that of `velocity` for an axis and an index. `each` returns the volume and
/// content of a member.
pub fn fill<V: Vector>(
    records: &mut Records<V>,
    (neighbor_list, kind): (&NeighborList, &[u8]),
    velocity: &(impl Fn(usize, usize) -> V::Scalar + Sync),
    each: &(impl Fn(usize) -> [V::Scalar; 2] + Sync),
    executor: &Executor,
) {
    let members = neighbor_list.members();
    records.fill(neighbor_list.neighbors(), neighbor_list.positions(), executor, &|member, record| {
        let index = members[member] as usize;
        for axis in 0..V::DIMENSION {
            record[V::DIMENSION + axis] = velocity(axis, index);
        }
        let [volume, content] = each(member);
        record[2 * V::DIMENSION] = volume.tagged(kind[member]);
        record[2 * V::DIMENSION + 1] = content;
    });
}

/// Volume V [m^D]: the first word of a record after the velocity.
#[inline(always)]
pub fn volume<V: Vector, N: Copy>(record: &ParticleRecord<N>) -> N {
    record[2 * V::DIMENSION]
}

/// Second word of a record after the velocity: the pressure p [Pa], or another quantity of the method.
#[inline(always)]
pub fn content<V: Vector, N: Copy>(record: &ParticleRecord<N>) -> N {
    record[2 * V::DIMENSION + 1]
}

/// Relative velocity v along one axis [m/s].
#[inline(always)]
pub fn velocity<V: Vector, N: Number>(pair: &Pair<N>, axis: usize) -> N {
    pair.own[V::DIMENSION + axis] - pair.other[V::DIMENSION + axis]
}

/// Scalar product v·d [m²/s], negative in approach.
#[inline(always)]
pub fn approach<V: Vector, N: Number>(pair: &Pair<N>) -> N {
    let mut sum = velocity::<V, N>(pair, 0) * pair.separation[0];
    for axis in 1..V::DIMENSION {
        sum += velocity::<V, N>(pair, axis) * pair.separation[axis];
    }
    sum
}

/// Value for the material of a tagged number.
#[inline(always)]
pub fn pick<N: Number, const MIXED: bool>(tagged: N, values: &[N::Scalar; KINDS]) -> N
where
    N::Scalar: Copy,
{
    if !MIXED {
        return N::of(values[0]);
    }
    let (low, high) = (tagged.has_bit(0), tagged.has_bit(1));
    let even = N::select(high, N::of(values[2]), N::of(values[0]));
    let odd = N::select(high, N::of(values[3]), N::of(values[1]));
    N::select(low, odd, even)
}

/// Mask of numbers with the tag of obstacles, which has both bits.
#[inline(always)]
pub fn is_obstacle<N: Number>(tagged: N) -> N::Mask {
    N::both(tagged.has_bit(0), tagged.has_bit(1))
}
