//! Whole steps under one force field alone, such as that of a star or a nucleus.

use std::marker::PhantomData;

use super::components::columns;
use crate::forces::{ForceField, InverseSquare};
use crate::integrators::{Component, ComponentGroup, Integrator, for_each_stage};
use crate::math::{Real, Vector};
use crate::matter::Blocks;
use crate::simd::{Kernel, dispatch};
use crate::systems::matter::dynamics::Dynamics;

/// Whole steps of a block under a single conservative force field.
struct PointForceSteps<'a, 'b, V: Vector, I, L> {
    law: L,
    members: &'a [V::Scalar],
    inverse_mass: &'a [V::Scalar],
    block: &'a mut Blocks<'b, V>,
    h: f64,
    number: u64,
    integrator: PhantomData<I>,
}

/// Advances one block by whole steps under an inverse-square force alone.
pub fn point_force_steps<V: Vector, I: Integrator>(
    dynamics: &Dynamics<V>,
    InverseSquare { law: force, members }: InverseSquare<'_, V::Scalar>,
    block: &mut Blocks<'_, V>,
    h: f64,
    steps: u64,
) {
    let members = &members[block.range()];
    let inverse_mass = &dynamics.properties.inverse_mass[block.range()];
    dispatch(PointForceSteps::<V, I, _> { law: force, members, inverse_mass, block, h, number: steps, integrator: PhantomData });
}

impl<V: Vector, I: Integrator, L: ForceField<V>> Kernel for PointForceSteps<'_, '_, V, I, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        // The widest vector: a step needs so many temporaries that two vectors would exceed the register file.
        if size_of::<V::Scalar>() == size_of::<f32>() { self.steps::<16>() } else { self.steps::<8>() }
    }
}

impl<V: Vector, I: Integrator, L: ForceField<V>> PointForceSteps<'_, '_, V, I, L> {
    /// Takes all steps, `W` particles at a time.
    #[inline(always)]
    fn steps<const W: usize>(self) {
        let Self { law, members, inverse_mass, block, h, number, .. } = self;
        let step = V::Scalar::from_f64(h);
        let (members, inverse_mass) = (members.as_chunks::<W>().0, inverse_mass.as_chunks::<W>().0);
        let [mut x, mut y, mut z] =
            columns::<V, W>(&mut block.position, &mut block.velocity, &mut block.registers, &mut block.residual);
        for _ in 0..number {
            for (group, (members, inverse_mass)) in members.iter().zip(inverse_mass).enumerate() {
                let (members, inverse_mass) = (*members, *inverse_mass);
                let mut first = ComponentGroup::load(&x.x[group], &x.v[group], &x.registers, group, I::PERSISTENT);
                let mut second = ComponentGroup::load(&y.x[group], &y.v[group], &y.registers, group, I::PERSISTENT);
                let mut third = ComponentGroup::ZERO;
                if V::DIMENSION > 2 {
                    third = ComponentGroup::load(&z.x[group], &z.v[group], &z.registers, group, I::PERSISTENT);
                }
                for lane in 0..W {
                    // A force times an inverse mass is an acceleration.
                    let weight = members[lane] * inverse_mass[lane];
                    let mut components = [first.lane(lane), second.lane(lane), third.lane(lane)];
                    for_each_stage!(I, stage => {
                        for axis in 0..V::DIMENSION {
                            I::stage_state(stage, &mut components[axis], step);
                        }
                        let at = |of: fn(&Component<V::Scalar>) -> V::Scalar| std::array::from_fn(|axis| of(&components[axis]));
                        let a = law.at(weight, at(|component| component.x), at(|component| component.v)).force;
                        for axis in 0..V::DIMENSION {
                            I::stage_update(stage, &mut components[axis], a[axis], step);
                        }
                    });
                    first.set(lane, &components[0]);
                    second.set(lane, &components[1]);
                    third.set(lane, &components[2]);
                }
                first.store(&mut x.x[group], &mut x.v[group], &mut x.registers, group, I::READABLE);
                second.store(&mut y.x[group], &mut y.v[group], &mut y.registers, group, I::READABLE);
                if V::DIMENSION > 2 {
                    third.store(&mut z.x[group], &mut z.v[group], &mut z.registers, group, I::READABLE);
                }
            }
        }
    }
}
