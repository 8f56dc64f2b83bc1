//! Contacts within the drift, for integrators with one evaluation of forces per step, at the final positions.
//!
//! Velocity Verlet moves its positions along the parabola of the acceleration at the start of the step. Contacts are resolved
//! on that parabola, before the evaluation of forces at its end. The second kick therefore uses the actual position. Contacts
//! after the step would combine the state with forces at a position that the particle never reaches: stiff bodies then gain
//! energy at every bounce.

use crate::catalog::Space;
use crate::contacts::{Before, Contacts};
use crate::integrators::{Component, Integrator};
use crate::math::Real;
use crate::matter::{Blocks, Span};
use crate::systems::matter::dynamics::Dynamics;

/// Resolves the contacts of a block at its stage, from the state `before` on.
pub fn collide<V: Space, I: Integrator>(
    dynamics: &Dynamics<V>,
    contacts: &Contacts<V>,
    block: &mut Blocks<'_, V>,
    before: &Before<'_, V>,
    h: f64,
) {
    contacts.resolve(before, block, &dynamics.properties, h);
    for axis in 0..V::DIMENSION {
        for index in 0..block.position.len() {
            let mut component = read(block, axis, index);
            I::correct_velocity(&mut component, V::Scalar::from_f64(h));
            for (span, value) in block.registers.iter_mut().zip(component.registers).take(I::REGISTERS) {
                if let Some(slot) = span.axes[axis].get_mut(index) {
                    *slot = value;
                }
            }
        }
    }
}

#[inline(always)]
fn read<V: Space>(block: &Blocks<'_, V>, axis: usize, index: usize) -> Component<V::Scalar> {
    let number = |span: &Span<'_, V>| span.axes[axis].get(index).copied().unwrap_or_default();
    Component { x: number(&block.position), v: number(&block.velocity), registers: block.registers.each_ref().map(number) }
}
