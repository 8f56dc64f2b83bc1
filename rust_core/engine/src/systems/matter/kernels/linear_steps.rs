//! Whole steps under the linear force alone, in registers.

use std::marker::PhantomData;

use super::axis_force::{AxisForce, Uniform, supplies};
use super::components::{Axes, Axis, split};
use super::power::{add_power, integrate, reuses_one_of_many};
use crate::forces::linear::AxisLaw;
use crate::integrators::{Component, ComponentGroup, Integrator, for_each_stage};
use crate::math::{Real, Vector};
use crate::matter::{Blocks, EnergySink, EnergyTally, Power, SINKS};
use crate::simd::{Kernel, LANES, dispatch};
use crate::systems::matter::dynamics::Dynamics;

/// Whole steps of a block whose forces are all fused.
struct Steps<'a, T, I> {
    axes: Axes<'a, T>,
    tally: &'a mut EnergyTally,
    dissipates: bool,
    h: f64,
    number: u64,
    integrator: PhantomData<I>,
}

/// Advances one block by whole steps under the linear force alone.
pub fn steps<V: Vector, I: Integrator>(dynamics: &Dynamics<V>, blocks: &mut Blocks<'_, V>, h: f64, steps: u64) {
    let (axes, tally) = split(dynamics, blocks);
    dispatch(Steps::<V::Scalar, I> {
        axes,
        tally,
        dissipates: dynamics.linear.dissipates,
        h,
        number: steps,
        integrator: PhantomData,
    });
}

impl<T: Real, I: Integrator> Kernel for Steps<'_, T, I> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        let mut left = self.number;
        // The stages of a longer method keep the registers busy enough.
        if const { I::NODES.len() == 1 } {
            for _ in 0..left / 2 {
                self.pass::<true>();
            }
            left %= 2;
        }
        for _ in 0..left {
            self.pass::<false>();
        }
    }
}

impl<T: Real, I: Integrator> Steps<'_, T, I> {
    /// Takes one step, or two with the same bits in one pass over the columns.
    #[inline(always)]
    fn pass<const TWO: bool>(&mut self) {
        let mut power = [[[0.0; LANES]; SINKS]; 2];
        let mut sinks = &[EnergySink::Drag][..];
        for (axis, law) in self.axes.iter_mut().flatten() {
            match *law {
                AxisLaw::Uniform(same) if self.dissipates => {
                    whole_steps::<_, I, TWO>(Uniform::<_, true>(same), axis, self.h, &mut power);
                }
                AxisLaw::Uniform(same) => whole_steps::<_, I, TWO>(Uniform::<_, false>(same), axis, self.h, &mut power),
                AxisLaw::Varying(varying) => {
                    whole_steps::<_, I, TWO>(varying, axis, self.h, &mut power);
                    sinks = &[EnergySink::Drag, EnergySink::Work];
                }
            }
        }
        if self.dissipates {
            let weight = if I::NODES.len() == 1 { I::WEIGHTS[0] } else { 1.0 };
            for power in power.iter().take(1 + usize::from(TWO)) {
                integrate(self.tally, power, sinks, self.h * weight, self.h * I::LAST_WEIGHT, true);
            }
            if reuses_one_of_many::<I>() {
                self.tally.last = power[1];
            }
        }
    }
}

/// One step of every lane along one axis, or two in one pass over the columns, with the power of each. Only persistent
/// registers are read, and only readable ones are written.
#[inline(always)]
fn whole_steps<T: Real, I: Integrator, const TWO: bool>(
    law: impl AxisForce<T>,
    axis: &mut Axis<'_, T>,
    h: f64,
    power: &mut [Power; 2],
) {
    let step = T::from_f64(h);
    let Axis { x, v, registers, .. } = axis;
    let (mut drag, mut second_drag) = ([T::ZERO; LANES], [T::ZERO; LANES]);
    let (mut work, mut second_work) = ([T::ZERO; LANES], [T::ZERO; LANES]);
    for (group, (x, v)) in x.iter_mut().zip(v.iter_mut()).enumerate() {
        let coefficients = law.group(group);
        let mut components = ComponentGroup::<T>::load(x, v, registers, group, I::PERSISTENT);
        for lane in 0..LANES {
            let mut component = components.lane(lane);
            let (passed, last) = one_step::<T, I, _>(&law, &coefficients, lane, &mut component, step);
            drag[lane] += passed.0;
            work[lane] += passed.1;
            if TWO {
                let (passed, _) = one_step::<T, I, _>(&law, &coefficients, lane, &mut component, step);
                second_drag[lane] += passed.0;
                second_work[lane] += passed.1;
            } else if reuses_one_of_many::<I>() {
                second_drag[lane] += last.0;
                second_work[lane] += last.1;
            }
            components.set(lane, &component);
        }
        components.store(x, v, registers, group, I::READABLE);
    }
    for (power, [drag, work]) in power.iter_mut().zip([[&drag, &work], [&second_drag, &second_work]]) {
        add_power(&mut power[EnergySink::Drag as usize], drag, law.unit());
        if supplies(&law) {
            add_power(&mut power[EnergySink::Work as usize], work, law.unit());
        }
    }
}

/// One step of one lane; returns the dissipated and the supplied power, weighted over the stages, and those of the last
/// stage.
#[inline(always)]
fn one_step<T: Real, I: Integrator, L: AxisForce<T>>(
    law: &L,
    coefficients: &L::Group,
    lane: usize,
    component: &mut Component<T>,
    h: T,
) -> ((T, T), (T, T)) {
    let (mut drag, mut work) = (T::ZERO, T::ZERO);
    let mut last = (T::ZERO, T::ZERO);
    for_each_stage!(I, stage => {
        I::stage_state(stage, component, h);
        let (dissipated, supplied) = law.power(coefficients, lane, component.v);
        // A single stage's weight is left to `integrate`: it would cost a multiplication per lane.
        let weigh = |power: T| if I::NODES.len() == 1 { power } else { T::from_f64(I::WEIGHTS[stage]) * power };
        drag = if stage == 0 { weigh(dissipated) } else { drag + weigh(dissipated) };
        work = if stage == 0 { weigh(supplied) } else { work + weigh(supplied) };
        last = (dissipated, supplied);
        let a = law.acceleration(coefficients, lane, component.x, component.v);
        I::stage_update(stage, component, a, h);
    });
    ((drag, work), last)
}
