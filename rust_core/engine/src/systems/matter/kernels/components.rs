//! The columns of a block as groups of lanes, and the components of one group in registers.

use crate::forces::linear::AxisLaw;
use crate::integrators::{Component, Integrator};
use crate::math::{AXES, Real, Vector};
use crate::matter::{Blocks, EnergyTally, REGISTERS, Span};
use crate::simd::{LANES, Lanes};
use crate::systems::matter::dynamics::Dynamics;

/// The columns of one axis of one block, as groups of `W` lanes.
pub(super) struct Axis<'a, T, const W: usize = LANES> {
    pub x: &'a mut [[T; W]],
    pub v: &'a mut [[T; W]],
    pub registers: [&'a mut [[T; W]]; REGISTERS],
    /// Low-order part of x [m]; empty if unused.
    pub residual: &'a mut [[T; W]],
}

/// The axes of a block with their linear forces, as many as there are dimensions. The loops use only these, so that one
/// compiled kernel serves two and three dimensions.
pub(super) type Axes<'a, T> = [Option<(Axis<'a, T>, AxisLaw<'a, T>)>; AXES];

/// The axes with their linear forces and the tally of a block.
pub(super) fn split<'a, V: Vector>(
    dynamics: &'a Dynamics<V>,
    blocks: &'a mut Blocks<'_, V>,
) -> (Axes<'a, V::Scalar>, &'a mut EnergyTally) {
    let (start, length) = (blocks.start, blocks.position.len());
    let mut columns =
        columns(&mut blocks.position, &mut blocks.velocity, &mut blocks.registers, &mut blocks.residual).into_iter();
    let axes = std::array::from_fn(|axis| {
        let columns = columns.next().filter(|_| axis < V::DIMENSION);
        columns.map(|columns| (columns, dynamics.linear.axis(axis, start, length)))
    });
    (axes, &mut blocks.tallies[0])
}

/// The columns of every axis; those past the dimension are empty.
pub(super) fn columns<'a, V: Vector, const W: usize>(
    position: &'a mut Span<'_, V>,
    velocity: &'a mut Span<'_, V>,
    registers: &'a mut [Span<'_, V>; REGISTERS],
    residual: &'a mut Span<'_, V>,
) -> [Axis<'a, V::Scalar, W>; AXES] {
    let mut x = position.axes.iter_mut().map(|axis| &mut **axis);
    let mut v = velocity.axes.iter_mut().map(|axis| &mut **axis);
    let mut registers = registers.each_mut().map(|span| span.axes.iter_mut().map(|axis| &mut **axis));
    let mut residual = residual.axes.iter_mut().map(|axis| &mut **axis);
    let lanes = |column: Option<&'a mut [V::Scalar]>| column.map_or(&mut [][..], |column| column.as_chunks_mut().0);
    std::array::from_fn(|_| Axis {
        x: lanes(x.next()),
        v: lanes(v.next()),
        registers: registers.each_mut().map(|axes| lanes(axes.next())),
        residual: lanes(residual.next()),
    })
}

/// The components of one group of lanes. Separate arrays, because an array of arrays would not stay in registers.
pub(super) struct ComponentGroup<T, const W: usize = LANES> {
    pub x: [T; W],
    pub v: [T; W],
    a: [T; W],
    b: [T; W],
    c: [T; W],
    d: [T; W],
    e: [T; W],
    f: [T; W],
}

impl<T: Real, const W: usize> ComponentGroup<T, W> {
    pub const ZERO: Self = {
        let zero = [T::ZERO; W];
        Self { x: zero, v: zero, a: zero, b: zero, c: zero, d: zero, e: zero, f: zero }
    };

    /// Reads positions, velocities and the first `used` registers.
    #[inline(always)]
    pub fn load(x: &[T; W], v: &[T; W], registers: &[&mut [[T; W]]; REGISTERS], group: usize, used: usize) -> Self {
        let kept = |index: usize| if index < used { registers[index][group] } else { [T::ZERO; W] };
        Self { x: *x, v: *v, a: kept(0), b: kept(1), c: kept(2), d: kept(3), e: kept(4), f: kept(5) }
    }

    /// Writes positions, velocities and the first `used` registers.
    #[inline(always)]
    pub fn store(&self, x: &mut [T; W], v: &mut [T; W], registers: &mut [&mut [[T; W]]; REGISTERS], group: usize, used: usize) {
        *x = self.x;
        *v = self.v;
        for (index, values) in [&self.a, &self.b, &self.c, &self.d, &self.e, &self.f].into_iter().enumerate().take(used) {
            registers[index][group] = *values;
        }
    }

    #[inline(always)]
    pub fn lane(&self, lane: usize) -> Component<T> {
        let registers = [self.a[lane], self.b[lane], self.c[lane], self.d[lane], self.e[lane], self.f[lane]];
        Component { x: self.x[lane], v: self.v[lane], registers }
    }

    #[inline(always)]
    pub fn set(&mut self, lane: usize, component: &Component<T>) {
        self.x[lane] = component.x;
        self.v[lane] = component.v;
        [self.a[lane], self.b[lane], self.c[lane], self.d[lane], self.e[lane], self.f[lane]] = component.registers;
    }

    /// Converts positions relative to `x` to rounded positions and residuals (two-sum). Their sum is exact (D. E. Knuth,
    /// The Art of Computer Programming 2, 4.2.2, theorem B).
    #[inline(always)]
    pub fn settle<I: Integrator>(&mut self, x: &Lanes<T>, residual: &mut Lanes<T>) {
        for lane in 0..LANES {
            let mut component = self.lane(lane);
            let (from, by) = (x[lane], component.x);
            let sum = from + by;
            let moved = sum - from;
            residual[lane] = (from - (sum - moved)) + (by - moved);
            component.x = sum;
            if let Some(register) = I::POSITION_REGISTER {
                component.registers[register] -= by - residual[lane];
            }
            self.set(lane, &component);
        }
    }
}
