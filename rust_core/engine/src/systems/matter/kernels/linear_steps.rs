//! Whole steps under the linear force alone, in registers.

use std::marker::PhantomData;

use super::axis_force::{AxisForce, UniformForce};
use super::components::{Axes, Axis, split};
use super::power::{add_power, integrate, reuses_one_of_many};
use crate::catalog::Space;
use crate::forces::linear::AxisLaw;
use crate::integrators::{Component, Integrator, for_each_stage};
use crate::math::Real;
use crate::matter::{Blocks, EnergySink, EnergyTally, REGISTERS};
use crate::simd::{Isa, Kernel, LANES, Lanes, Pack, dispatch_wide};
use crate::systems::matter::dynamics::Dynamics;

/// Whole steps of a block whose forces are all fused.
struct LinearSteps<'a, T, I> {
    axes: Axes<'a, T>,
    tally: &'a mut EnergyTally,
    dissipates: bool,
    h: f64,
    number: u64,
    integrator: PhantomData<I>,
}

/// Advances one block by whole steps under the linear force alone.
pub fn steps<V: Space, I: Integrator>(dynamics: &Dynamics<V>, blocks: &mut Blocks<'_, V>, h: f64, steps: u64) {
    let (axes, tally) = split(dynamics, blocks);
    dispatch_wide(LinearSteps::<V::Scalar, I> {
        axes,
        tally,
        dissipates: dynamics.linear.dissipates,
        h,
        number: steps,
        integrator: PhantomData,
    });
}

/// Sinks of a linear force.
const OF_DRAG: [EnergySink; 2] = [EnergySink::Drag, EnergySink::Work];

/// Powers through [`OF_DRAG`] [W], by lane: weighted over the stages of a step, and at its last stage.
#[derive(Default)]
struct Powers {
    step: [Lanes<f64>; 2],
    last: [Lanes<f64>; 2],
}

impl<T: Real, I: Integrator> Kernel for LinearSteps<'_, T, I> {
    type Output = ();

    #[inline(always)]
    fn run<S: Isa>(mut self, _isa: S) {
        for _ in 0..self.number {
            self.step::<S::Pack<T>>();
        }
    }
}

impl<T: Real, I: Integrator> LinearSteps<'_, T, I> {
    /// Takes one step: a pass over a block in the first-level cache. Two steps in a pass would need more registers than there
    /// are.
    #[inline(always)]
    fn step<P: Pack<Scalar = T>>(&mut self) {
        let (mut powers, mut sinks) = (Powers::default(), 1);
        for (axis, law) in self.axes.iter_mut().flatten() {
            match *law {
                AxisLaw::Uniform(same) if self.dissipates => {
                    whole_step::<P, I, _>(UniformForce::<_, true>(same), axis, self.h, &mut powers);
                }
                AxisLaw::Uniform(same) => whole_step::<P, I, _>(UniformForce::<_, false>(same), axis, self.h, &mut powers),
                AxisLaw::Varying(varying) => {
                    whole_step::<P, I, _>(varying, axis, self.h, &mut powers);
                    sinks = OF_DRAG.len();
                }
            }
        }
        if self.dissipates {
            let weight = if I::NODES.len() == 1 { I::WEIGHTS[0] } else { 1.0 };
            let of_sinks = OF_DRAG.into_iter().zip(&powers.step).take(sinks);
            integrate(self.tally, of_sinks, self.h * weight, self.h * I::LAST_WEIGHT, true);
            if reuses_one_of_many::<I>() {
                OF_DRAG.into_iter().zip(powers.last).for_each(|(sink, last)| self.tally.last[sink as usize] = last);
            }
        }
    }
}

/// Takes one step of every lane along one axis, with its powers. Reads only persistent registers, and writes only readable
/// ones.
#[inline(always)]
fn whole_step<P: Pack<Scalar: Real>, I: Integrator, L: AxisForce<P::Scalar>>(
    law: L,
    axis: &mut Axis<'_, P::Scalar>,
    h: f64,
    powers: &mut Powers,
) {
    let (step, zero) = (P::constant(h), P::constant(0.0));
    let Axis { x, v, registers, .. } = axis;
    // A copy: writes to columns might change the value behind a reference.
    let registers = registers.each_mut().map(|column| &mut **column);
    let (mut of_step, mut of_last) = ([[P::Scalar::ZERO; LANES]; 2], [[P::Scalar::ZERO; LANES]; 2]);
    // The lanes of one register in all groups, then those of the next register.
    for first in (0..LANES).step_by(P::WIDTH) {
        let (mut sums, mut lasts) = ([zero; 2], [zero; 2]);
        for (group, (x, v)) in x.iter_mut().zip(v.iter_mut()).enumerate() {
            let coefficients = law.coefficients(|column| P::load(&column[group][first..]));
            let mut component = Component { x: P::load(&x[first..]), v: P::load(&v[first..]), registers: [zero; REGISTERS] };
            for register in 0..I::PERSISTENT {
                component.registers[register] = P::load(&registers[register][group][first..]);
            }
            let [powers, last] = one_step::<P, I, L>(&law, &coefficients, &mut component, step);
            for sink in 0..OF_DRAG.len() {
                sums[sink] += powers[sink];
                if reuses_one_of_many::<I>() {
                    lasts[sink] += last[sink];
                }
            }
            component.x.store(&mut x[first..]);
            component.v.store(&mut v[first..]);
            for register in 0..I::READABLE {
                component.registers[register].store(&mut registers[register][group][first..]);
            }
        }
        for sink in 0..OF_DRAG.len() {
            sums[sink].store(&mut of_step[sink][first..]);
            lasts[sink].store(&mut of_last[sink][first..]);
        }
    }
    let sinks = if L::SUPPLIES { 2 } else { 1 };
    for sink in 0..sinks {
        add_power(&mut powers.step[sink], &of_step[sink], law.unit());
        if reuses_one_of_many::<I>() {
            add_power(&mut powers.last[sink], &of_last[sink], law.unit());
        }
    }
}

/// Takes one step along one axis. Returns the dissipated and the supplied power, weighted over the stages, and at the last
/// stage.
#[inline(always)]
fn one_step<P: Pack<Scalar: Real>, I: Integrator, L: AxisForce<P::Scalar>>(
    law: &L,
    coefficients: &L::Coefficients<P>,
    component: &mut Component<P>,
    h: P,
) -> [[P; 2]; 2] {
    let mut sums = [P::constant(0.0); 2];
    let mut last = sums;
    for_each_stage!(I, stage => {
        I::stage_state(stage, component, h);
        last = law.power(coefficients, component.v);
        for sink in 0..OF_DRAG.len() {
            // A single stage's weight is left to `integrate`; here it would cost a multiplication per lane.
            let weighted = if I::NODES.len() == 1 { last[sink] } else { P::constant(I::WEIGHTS[stage]) * last[sink] };
            sums[sink] = if stage == 0 { weighted } else { sums[sink] + weighted };
        }
        let a = law.acceleration(coefficients, component.x, component.v);
        I::stage_update(stage, component, a, h);
    });
    [sums, last]
}
