//! One stage of a step, with accumulated forces plus the linear force.

use std::marker::PhantomData;

use super::activity::kinetic;
use super::axis_force::{AxisForce, Uniform};
use super::components::{Axes, Axis, split};
use super::power::{add_power, integrate, through_all};
use crate::forces::linear::AxisLaw;
use crate::integrators::{ComponentGroup, Integrator, for_each_stage};
use crate::math::{AXES, Real, Vector};
use crate::matter::{Blocks, EnergySink, EnergyTally, Power, Span};
use crate::simd::{Kernel, LANES, Lanes, dispatch};
use crate::systems::matter::dynamics::Dynamics;

/// The operation of a stage on the state.
#[derive(Debug, Clone, Copy)]
pub enum Action {
    /// Fills the persistent registers at the start of a run.
    Begin,
    /// Computes the state of the first stage.
    StageState,
    /// Updates the state by the acceleration of a stage, then computes the state of another stage.
    StageUpdate(usize, Option<usize>),
}

/// The velocities from which an evaluation of the forces kicks a block, if it does; at the start of a run the present ones.
pub fn kicked<'a, 'b, V: Vector, I: Integrator>(blocks: &'a Blocks<'b, V>, action: Action) -> Option<&'a Span<'b, V>> {
    match action {
        Action::Begin => Some(&blocks.velocity),
        Action::StageState => None,
        Action::StageUpdate(..) => I::DRIFT_KICK.map(|drift_kick| &blocks.registers[drift_kick.velocity]),
    }
}

/// The accumulated forces and powers of one block, without the linear force.
#[derive(Debug)]
pub struct Evaluation<'a, V: Vector> {
    /// The force on every particle [N].
    pub force: Span<'a, V>,
    /// The power through each sink [W].
    pub power: Power,
    /// The part of the force by the damping of springs [N].
    pub damping: Option<Span<'a, V>>,
}

struct Stage<'a, T, I> {
    axes: Axes<'a, T>,
    force: [&'a [Lanes<T>]; AXES],
    damping: [&'a [Lanes<T>]; AXES],
    inverse_mass: &'a [Lanes<T>],
    inertia: &'a [Lanes<T>],
    power: Power,
    tally: &'a mut EnergyTally,
    dissipates: bool,
    h: f64,
    action: Action,
    integrator: PhantomData<I>,
}

/// The columns of a span as groups of lanes.
fn lanes<'a, V: Vector>(span: &'a Span<'_, V>) -> [&'a [Lanes<V::Scalar>]; AXES] {
    span.axes.each_ref().map(|axis| axis.as_chunks().0)
}

/// Runs one stage of one block; returns the activity at the stage.
pub fn stage<V: Vector, I: Integrator>(
    dynamics: &Dynamics<V>,
    blocks: &mut Blocks<'_, V>,
    evaluation: &Evaluation<'_, V>,
    h: f64,
    action: Action,
) -> f64 {
    let inverse_mass = dynamics.properties.inverse_mass[blocks.range()].as_chunks().0;
    let inertia = dynamics.properties.inertia[blocks.range()].as_chunks().0;
    let force = lanes(&evaluation.force);
    let damping = evaluation.damping.as_ref().map_or([&[][..]; AXES], lanes);
    let (axes, tally) = split(dynamics, blocks);
    dispatch(Stage::<V::Scalar, I> {
        axes,
        force,
        damping,
        inverse_mass,
        inertia,
        power: evaluation.power,
        tally,
        dissipates: dynamics.linear.dissipates,
        h,
        action,
        integrator: PhantomData,
    })
}

impl<T: Real, I: Integrator> Kernel for Stage<'_, T, I> {
    type Output = f64;

    #[inline(always)]
    fn run(self) -> f64 {
        let Self { mut axes, force, damping, inverse_mass, inertia, mut power, tally, dissipates, h, action, .. } = self;
        let mut squares = [T::ZERO; LANES];
        for ((axis, law), (force, damping)) in axes.iter_mut().flatten().zip(force.into_iter().zip(damping)) {
            let input = AxisInput { force, damping, inverse_mass, inertia };
            let sums = (&mut power, &mut squares);
            match *law {
                AxisLaw::Uniform(same) if dissipates => {
                    one_stage::<_, I, _>(Uniform::<_, true>(same), input, axis, h, action, sums);
                }
                AxisLaw::Uniform(same) => one_stage::<_, I, _>(Uniform::<_, false>(same), input, axis, h, action, sums),
                AxisLaw::Varying(varying) => one_stage::<_, I, _>(varying, input, axis, h, action, sums),
            }
        }
        match action {
            Action::Begin => tally.last = power,
            Action::StageState => {}
            Action::StageUpdate(stage, _) => {
                let last = if stage == 0 { h * I::LAST_WEIGHT } else { 0.0 };
                integrate(tally, through_all(&power), h * I::WEIGHTS[stage], last, stage + 1 == I::NODES.len());
            }
        }
        kinetic(&squares)
    }
}

/// Forces along one axis [N], maybe with their part by damping, inverse masses [1/kg] and masses [kg].
#[derive(Clone, Copy)]
struct AxisInput<'a, T> {
    force: &'a [Lanes<T>],
    damping: &'a [Lanes<T>],
    inverse_mass: &'a [Lanes<T>],
    inertia: &'a [Lanes<T>],
}

/// One stage of every lane along one axis. Adds to the powers, and Σ m v² at the stage to `squares`.
#[inline(always)]
fn one_stage<T: Real, I: Integrator, L: AxisForce<T>>(
    law: L,
    input: AxisInput<'_, T>,
    axis: &mut Axis<'_, T>,
    h: f64,
    action: Action,
    (power, squares): (&mut Power, &mut Lanes<T>),
) {
    let step = T::from_f64(h);
    let Axis { x, v, registers, residual } = axis;
    let mut drag = [T::ZERO; LANES];
    let mut work = [T::ZERO; LANES];
    let mut corrected = [T::ZERO; LANES];
    let mut moved = *squares;
    for (group, (x, v)) in x.iter_mut().zip(v.iter_mut()).enumerate() {
        let coefficients = law.coefficients(|column| column[group]);
        let (force, inverse_mass, inertia) = (input.force[group], input.inverse_mass[group], input.inertia[group]);
        let mut components = ComponentGroup::<T>::load(x, v, registers, group, I::REGISTERS);
        let mut a = [T::ZERO; LANES];
        for lane in 0..LANES {
            let component = components.lane(lane);
            let own = law.of_lane(&coefficients, lane);
            let [dissipated, supplied] = law.power(&own, component.v);
            drag[lane] += dissipated;
            work[lane] += supplied;
            moved[lane] += inertia[lane] * (component.v * component.v);
            a[lane] = force[lane] * inverse_mass[lane] + law.acceleration(&own, component.x, component.v);
        }
        // Integrators only add increments to a position, so they can be added to the residual instead.
        if let Some(residual) = residual.get(group) {
            components.x = *residual;
        }
        match action {
            Action::Begin => begin::<T, I>(&mut components, &a),
            Action::StageState => stage_state::<T, I>(0, &mut components, step),
            Action::StageUpdate(stage, next) => {
                let predicted = components.v;
                stage_update::<T, I>(stage, &mut components, &a, step);
                if let (true, Some(damping)) = (I::CORRECTED_WEIGHT != 0.0, input.damping.get(group)) {
                    for lane in 0..LANES {
                        corrected[lane] += damping[lane] * (predicted[lane] - components.v[lane]);
                    }
                }
                if let Some(next) = next {
                    // The end of a step has the same bits, whether the next one follows in this sweep or in another batch.
                    if let (0, Some(residual)) = (next, residual.get_mut(group)) {
                        components.settle::<I>(x, residual);
                        (*x, components.x) = (components.x, *residual);
                    }
                    stage_state::<T, I>(next, &mut components, step);
                }
            }
        }
        if let Some(residual) = residual.get_mut(group) {
            components.settle::<I>(x, residual);
        }
        components.store(x, v, registers, group, I::REGISTERS);
    }
    *squares = moved;
    add_power(&mut power[EnergySink::Damping as usize], &corrected, I::CORRECTED_WEIGHT);
    add_power(&mut power[EnergySink::Drag as usize], &drag, law.unit());
    if L::SUPPLIES {
        add_power(&mut power[EnergySink::Work as usize], &work, law.unit());
    }
}

/// Sets the persistent register of a group.
#[inline(always)]
fn begin<T: Real, I: Integrator>(components: &mut ComponentGroup<T>, a: &Lanes<T>) {
    for lane in 0..LANES {
        let mut component = components.lane(lane);
        I::begin(&mut component, a[lane]);
        components.set(lane, &component);
    }
}

/// Computes the state of a stage of a group. The stage is a constant in each loop, and no loop calls a closure, which might
/// not be inlined: only then can it be vectorized.
#[inline(always)]
fn stage_state<T: Real, I: Integrator>(stage: usize, components: &mut ComponentGroup<T>, h: T) {
    for_each_stage!(I, constant => {
        if stage == constant {
            for lane in 0..LANES {
                let mut component = components.lane(lane);
                I::stage_state(constant, &mut component, h);
                components.set(lane, &component);
            }
        }
    });
}

/// Updates a group by the accelerations of a stage.
#[inline(always)]
fn stage_update<T: Real, I: Integrator>(stage: usize, components: &mut ComponentGroup<T>, a: &Lanes<T>, h: T) {
    for_each_stage!(I, constant => {
        if stage == constant {
            for lane in 0..LANES {
                let mut component = components.lane(lane);
                I::stage_update(constant, &mut component, a[lane], h);
                components.set(lane, &component);
            }
        }
    });
}
