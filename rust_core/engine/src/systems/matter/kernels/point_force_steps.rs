//! Whole steps under an inverse-square force alone, such as that of a star or a nucleus.

use std::marker::PhantomData;

use super::components::{Axis, columns};
use crate::catalog::Space;
use crate::forces::{InverseSquare, InverseSquareLaw};
use crate::integrators::{Component, Integrator, for_each_stage};
use crate::math::AXES;
use crate::matter::{Blocks, REGISTERS};
use crate::simd::{Isa, Kernel, LANES, Number, Pack, dispatch_wide};
use crate::systems::matter::dynamics::Dynamics;

/// Whole steps of a block.
struct PointForceSteps<'a, 'b, V: Space, I> {
    law: InverseSquareLaw<V::Scalar>,
    members: &'a [V::Scalar],
    inverse_mass: &'a [V::Scalar],
    block: &'a mut Blocks<'b, V>,
    h: f64,
    number: u64,
    integrator: PhantomData<I>,
}

/// Advances one block by whole steps under an inverse-square force alone.
pub fn point_force_steps<V: Space, I: Integrator>(
    dynamics: &Dynamics<V>,
    InverseSquare { law, members }: InverseSquare<'_, V::Scalar>,
    block: &mut Blocks<'_, V>,
    h: f64,
    steps: u64,
) {
    let members = &members[block.range()];
    let inverse_mass = &dynamics.properties.inverse_mass[block.range()];
    dispatch_wide(PointForceSteps::<V, I> { law, members, inverse_mass, block, h, number: steps, integrator: PhantomData });
}

impl<V: Space, I: Integrator> Kernel for PointForceSteps<'_, '_, V, I> {
    type Output = ();

    #[inline(always)]
    fn run<S: Isa>(self, _isa: S) {
        let Self { law, members, inverse_mass, block, h, number, .. } = self;
        let mut walk = Walk::<V, S::Pack<V::Scalar>, I> {
            law,
            members,
            inverse_mass,
            axes: columns(&mut block.position, &mut block.velocity, &mut block.registers, &mut block.residual),
            step: Number::constant(h),
            integrator: PhantomData,
        };
        // Several registers of particles in turn: some compute while one waits for its root and its division. Of wider
        // registers there are more.
        if const { S::Pack::<V::Scalar>::WIDTH == LANES } { walk.steps::<4>(number) } else { walk.steps::<3>(number) }
    }
}

/// Columns of a block, and the force that moves its particles.
struct Walk<'a, V: Space, P, I> {
    law: InverseSquareLaw<V::Scalar>,
    members: &'a [V::Scalar],
    inverse_mass: &'a [V::Scalar],
    axes: [Axis<'a, V::Scalar>; AXES],
    step: P,
    integrator: PhantomData<I>,
}

impl<V: Space, P: Pack<Scalar = V::Scalar>, I: Integrator> Walk<'_, V, P, I> {
    /// Takes all steps, with `TURNS` registers of particles in turn.
    #[inline(always)]
    fn steps<const TURNS: usize>(&mut self, number: u64) {
        for first in (0..self.members.len() / P::WIDTH).step_by(TURNS) {
            self.advance::<TURNS>(first, number);
        }
    }

    /// Takes all steps with `TURNS` registers of particles, from the register `first` on. Past the last register the last one
    /// is repeated; it reads and writes the same values.
    #[inline(always)]
    fn advance<const TURNS: usize>(&mut self, first: usize, number: u64) {
        let last = self.members.len() / P::WIDTH - 1;
        let at = |turn: usize| (first + turn).min(last) * P::WIDTH;
        let zero = P::constant(0.0);
        let mut components = [[Component { x: zero, v: zero, registers: [zero; REGISTERS] }; AXES]; TURNS];
        let mut weights = [zero; TURNS];
        for turn in 0..TURNS {
            // A force times an inverse mass is an acceleration.
            weights[turn] = P::load(&self.members[at(turn)..]) * P::load(&self.inverse_mass[at(turn)..]);
            for axis in 0..V::DIMENSION {
                let (from, component) = (&self.axes[axis], &mut components[turn][axis]);
                component.x = P::load(&from.x.as_flattened()[at(turn)..]);
                component.v = P::load(&from.v.as_flattened()[at(turn)..]);
                for register in 0..I::PERSISTENT {
                    component.registers[register] = P::load(&from.registers[register].as_flattened()[at(turn)..]);
                }
            }
        }
        for _ in 0..number {
            for_each_stage!(I, stage => {
                for turn in 0..TURNS {
                    for axis in 0..V::DIMENSION {
                        I::stage_state(stage, &mut components[turn][axis], self.step);
                    }
                }
                let mut accelerations = [[zero; AXES]; TURNS];
                for turn in 0..TURNS {
                    let place = components[turn].each_ref().map(|component| component.x);
                    accelerations[turn] = self.law.force::<V, P>(weights[turn], place);
                }
                for turn in 0..TURNS {
                    for axis in 0..V::DIMENSION {
                        I::stage_update(stage, &mut components[turn][axis], accelerations[turn][axis], self.step);
                    }
                }
            });
        }
        for turn in 0..TURNS {
            for axis in 0..V::DIMENSION {
                let (to, component) = (&mut self.axes[axis], &components[turn][axis]);
                component.x.store(&mut to.x.as_flattened_mut()[at(turn)..]);
                component.v.store(&mut to.v.as_flattened_mut()[at(turn)..]);
                for register in 0..I::READABLE {
                    component.registers[register].store(&mut to.registers[register].as_flattened_mut()[at(turn)..]);
                }
            }
        }
    }
}
