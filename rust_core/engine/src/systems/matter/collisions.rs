//! Contacts within the drift, for integrators whose positions stand before the step's only evaluation.
//!
//! Such a step is kick, drift, kick. Let the drift be the flight under the steady part g of the acceleration (gravity,
//! the pull of a wind), which is a parabola that the contact stage resolves exactly, and let the kicks be all the rest:
//! the step is still the same without contacts, and with them it is a symmetric splitting of order 2 into flows that each
//! keep the energy that they should. Source: Y. A. Houndonougbo, B. B. Laird, B. J. Leimkuhler, Mol. Phys. 98 (2000) 309.
//! Contacts after the step would leave the second kick with forces from where the particle never was.

use crate::contacts::{Before, Contacts};
use crate::integrators::{Integrator, Register};
use crate::math::{AXES, Real, Vector};
use crate::matter::{Blocks, Span};
use crate::systems::matter::law::Law;

/// Resolves the contacts of a block that stands at its stage: `before` holds the positions at the step's start, and
/// `slope` is memory for velocities.
pub fn collide<V: Vector, I: Integrator>(
    law: &Law<V>,
    contacts: &Contacts<V>,
    block: &mut Blocks<'_, V>,
    before: [&[V::Scalar]; AXES],
    slope: &mut Span<'_, V>,
    h: f64,
) {
    let push = |axis: usize, index: usize| V::Scalar::from_f64(0.5 * h) * law.affine.steady(axis, index);
    let (start, length) = (block.start, block.position.len());
    for axis in 0..V::DIMENSION {
        for index in 0..length {
            let (drift, push) = (I::drift(&read(block, axis, index)), push(axis, start + index));
            slope.axes[axis][index] = drift - push;
            block.velocity.axes[axis][index] = drift + push;
        }
    }
    let before = Before { position: before, velocity: slope.axes.each_ref().map(|axis| &**axis) };
    contacts.resolve(&before, block, &law.properties, h);
    for axis in 0..V::DIMENSION {
        for index in 0..length {
            let mut register = read(block, axis, index);
            let (drift, push) = (I::drift(&register), push(axis, start + index));
            // One that touched nothing keeps its bits.
            let drift = if register.v == drift + push { drift } else { register.v - push };
            I::redirect(&mut register, drift, V::Scalar::from_f64(h));
            write(block, axis, index, &register);
        }
    }
}

#[inline(always)]
fn read<V: Vector>(block: &Blocks<'_, V>, axis: usize, index: usize) -> Register<V::Scalar> {
    let number = |span: &Span<'_, V>| span.axes[axis].get(index).copied().unwrap_or_default();
    Register { x: number(&block.position), v: number(&block.velocity), memory: block.memory.each_ref().map(number) }
}

#[inline(always)]
fn write<V: Vector>(block: &mut Blocks<'_, V>, axis: usize, index: usize, register: &Register<V::Scalar>) {
    block.velocity.axes[axis][index] = register.v;
    for (span, value) in block.memory.iter_mut().zip(register.memory) {
        if let Some(slot) = span.axes[axis].get_mut(index) {
            *slot = value;
        }
    }
}
