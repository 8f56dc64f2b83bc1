//! Columns of a block as groups of lanes.

use crate::catalog::Space;
use crate::forces::linear::AxisLaw;
use crate::math::AXES;
use crate::matter::{Blocks, EnergyTally, REGISTERS, Span};
use crate::simd::LANES;
use crate::systems::matter::dynamics::Dynamics;

/// Columns of one axis of one block, as groups of `W` lanes.
pub(super) struct Axis<'a, T, const W: usize = LANES> {
    pub x: &'a mut [[T; W]],
    pub v: &'a mut [[T; W]],
    pub registers: [&'a mut [[T; W]]; REGISTERS],
    /// Low-order part of x [m]; empty if unused.
    pub residual: &'a mut [[T; W]],
}

/// Axes of a block with their linear forces, as many as there are dimensions. The loops use only these: one compiled kernel
/// serves two and three dimensions.
pub(super) type Axes<'a, T> = [Option<(Axis<'a, T>, AxisLaw<'a, T>)>; AXES];

/// Axes of a block with their linear forces, and tally of the block.
pub(super) fn split<'a, V: Space>(
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

/// Columns of every axis; those past the dimension are empty.
pub(super) fn columns<'a, V: Space, const W: usize>(
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
