//! One stage of a step, with accumulated forces plus the linear force.

use super::activity::kinetic;
use super::axis_force::{AxisForce, UniformForce};
use super::components::{Axes, Axis, split};
use super::power::{add_power, integrate, lanes, through_all};
use crate::catalog::Space;
use crate::forces::StateView;
use crate::forces::linear::AxisLaw;
use crate::integrators::{Component, Facts, Swept};
use crate::math::{AXES, Real};
use crate::matter::{Blocks, EnergySink, EnergyTally, Power, REGISTERS, Span};
use crate::simd::{Isa, Kernel, LANES, Lanes, Pack, dispatch};
use crate::systems::matter::dynamics::Dynamics;

/// Operation of a stage on the state.
#[derive(Debug, Clone, Copy)]
pub enum StageAction {
    /// Fills the persistent registers at the start of a run.
    Begin,
    /// Computes the state of the first stage.
    StageState,
    /// Updates the state by the acceleration of a stage, then computes the state of another stage.
    StageUpdate(usize, Option<usize>),
}

/// Velocities from which an evaluation of the forces kicks a block; None if it does not. At the start of a run: the present
/// ones.
pub fn kicked<'a, 'b, V: Space>(method: &Facts, blocks: &'a Blocks<'b, V>, action: StageAction) -> Option<&'a Span<'b, V>> {
    match action {
        StageAction::Begin => Some(&blocks.velocity),
        StageAction::StageState => None,
        StageAction::StageUpdate(..) => method.drift_kick.map(|drift_kick| &blocks.registers[drift_kick.velocity]),
    }
}

/// Accumulated forces and powers of one block, without the linear force.
#[derive(Debug)]
pub struct Evaluation<'a, V: Space> {
    /// Force on every particle [N].
    pub force: Span<'a, V>,
    /// Power through each sink [W].
    pub power: Power,
    /// Part of the force by the damping of springs [N].
    pub damping: Option<Span<'a, V>>,
}

struct Stage<'a, T, S> {
    axes: Axes<'a, T>,
    state: Option<[[&'a [Lanes<T>]; AXES]; 2]>,
    force: [&'a [Lanes<T>]; AXES],
    damping: [&'a [Lanes<T>]; AXES],
    inverse_mass: &'a [Lanes<T>],
    inertia: &'a [Lanes<T>],
    power: Power,
    tally: &'a mut EnergyTally,
    dissipates: bool,
    h: f64,
    action: StageAction,
    method: &'a Facts,
    swept: S,
}

/// Columns of a span as groups of lanes.
fn groups<'a, V: Space>(span: &'a Span<'_, V>) -> [&'a [Lanes<V::Scalar>]; AXES] {
    span.axes.each_ref().map(|axis| axis.as_chunks().0)
}

/// Runs one stage of one block, from the state `at`, or from the block's own state if None; returns the activity at the
/// stage.
pub fn stage<V: Space, S: Swept>(
    dynamics: &Dynamics<V>,
    method: &Facts,
    at: Option<&StateView<'_, V>>,
    blocks: &mut Blocks<'_, V>,
    evaluation: &Evaluation<'_, V>,
    h: f64,
    action: StageAction,
) -> f64 {
    let range = blocks.range();
    let inverse_mass = dynamics.properties.inverse_mass[range.clone()].as_chunks().0;
    let inertia = dynamics.properties.inertia[range.clone()].as_chunks().0;
    let state = at.map(|at| {
        [at.position, at.velocity].map(|columns| {
            std::array::from_fn(
                |axis| if axis < V::DIMENSION { columns.slice(axis, range.clone()).as_chunks().0 } else { &[][..] },
            )
        })
    });
    let force = groups(&evaluation.force);
    let damping = evaluation.damping.as_ref().map_or([&[][..]; AXES], groups);
    let (axes, tally) = split(dynamics, blocks);
    dispatch(Stage::<V::Scalar, S> {
        axes,
        state,
        force,
        damping,
        inverse_mass,
        inertia,
        power: evaluation.power,
        tally,
        dissipates: dynamics.linear.dissipates,
        h,
        action,
        method,
        swept: S::of(method),
    })
}

impl<T: Real, S: Swept> Kernel for Stage<'_, T, S> {
    type Output = f64;

    #[inline(always)]
    fn run<L: Isa>(self, _isa: L) -> f64 {
        let Self {
            mut axes,
            state,
            force,
            damping,
            inverse_mass,
            inertia,
            mut power,
            tally,
            dissipates,
            h,
            action,
            method,
            swept,
        } = self;
        let mut squares = [T::ZERO; LANES];
        for (axis, (columns, law)) in axes.iter_mut().flatten().enumerate() {
            let state = state.map(|columns| columns.map(|columns| columns[axis]));
            let input = AxisInput { state, force: force[axis], damping: damping[axis], inverse_mass, inertia };
            let sums = (&mut power, &mut squares);
            match *law {
                AxisLaw::Uniform(same) if dissipates => {
                    one_stage::<L::Group<T>, S, _>(swept, UniformForce::<_, true>(same), input, columns, h, action, sums);
                }
                AxisLaw::Uniform(same) => {
                    one_stage::<L::Group<T>, S, _>(swept, UniformForce::<_, false>(same), input, columns, h, action, sums);
                }
                AxisLaw::Varying(varying) => one_stage::<L::Group<T>, S, _>(swept, varying, input, columns, h, action, sums),
            }
        }
        match action {
            StageAction::Begin => tally.last = power,
            StageAction::StageState => {}
            StageAction::StageUpdate(stage, _) => {
                let [weight, last] = method.weights_at(stage).map(|weight| h * weight);
                integrate(tally, through_all(&power), weight, last, stage + 1 == method.stages());
            }
        }
        kinetic(&squares)
    }
}

/// Input along one axis. Positions [m] and velocities [m/s], unless they are in the block. Forces [N], with their part by
/// damping if needed. Inverse masses [1/kg] and masses [kg].
#[derive(Clone, Copy)]
struct AxisInput<'a, T> {
    state: Option<[&'a [Lanes<T>]; 2]>,
    force: &'a [Lanes<T>],
    damping: &'a [Lanes<T>],
    inverse_mass: &'a [Lanes<T>],
    inertia: &'a [Lanes<T>],
}

/// Runs one stage of every particle along one axis. Adds to the powers, and Σ m v² at the stage to `squares`.
#[inline(always)]
fn one_stage<G: Pack<Scalar: Real>, S: Swept, L: AxisForce<G::Scalar>>(
    swept: S,
    law: L,
    input: AxisInput<'_, G::Scalar>,
    axis: &mut Axis<'_, G::Scalar>,
    h: f64,
    action: StageAction,
    (power, squares): (&mut Power, &mut Lanes<G::Scalar>),
) {
    let [now, after] = match action {
        StageAction::StageUpdate(stage, next) => [swept.at(stage), swept.at(next.unwrap_or(0))],
        StageAction::Begin | StageAction::StageState => [swept.at(0); 2],
    };
    let (step, zero) = (G::constant(h), G::constant(0.0));
    let Axis { x, v, registers, residual } = axis;
    // A copy: writes to columns might change the value behind a reference.
    let registers = registers.each_mut().map(|column| &mut **column);
    let (mut drag, mut work, mut corrected, mut moved) = (zero, zero, zero, G::load(&*squares));
    for (group, (x, v)) in x.iter_mut().zip(v.iter_mut()).enumerate() {
        let coefficients = law.coefficients(|column| G::load(&column[group]));
        let (own_x, own_v) = if let Some([x, v]) = input.state { (&x[group], &v[group]) } else { (&*x, &*v) };
        let mut component = Component { x: G::load(own_x), v: G::load(own_v), registers: [zero; REGISTERS] };
        for register in 0..S::REGISTERS {
            component.registers[register] = G::load(&registers[register][group]);
        }
        let [dissipated, supplied] = law.power(&coefficients, component.v);
        drag += dissipated;
        work += supplied;
        moved += G::load(&input.inertia[group]) * (component.v * component.v);
        let linear = law.acceleration(&coefficients, component.x, component.v);
        let a = G::load(&input.force[group]) * G::load(&input.inverse_mass[group]) + linear;
        // Integrators only add increments to a position; these can be added to the residual instead.
        let mut from = component.x;
        if let Some(residual) = residual.get(group) {
            component.x = G::load(residual);
        }
        match action {
            StageAction::Begin => S::begin(&mut component, a),
            StageAction::StageState => stage_state::<G, S>(now, 0, &mut component, step),
            StageAction::StageUpdate(stage, next) => {
                let predicted = component.v;
                stage_update::<G, S>(now, stage, &mut component, a, step);
                if let (true, Some(damping)) = (S::CORRECTED_WEIGHT != 0.0, input.damping.get(group)) {
                    corrected += G::load(damping) * (predicted - component.v);
                }
                if let Some(next) = next {
                    // The end of a step has the same bits, whether the next step follows in this sweep or in another batch.
                    if next == 0 && group < residual.len() {
                        let rest = settle::<G, S>(&mut component, from);
                        (from, component.x) = (component.x, rest);
                    }
                    stage_state::<G, S>(after, next, &mut component, step);
                }
            }
        }
        if let Some(residual) = residual.get_mut(group) {
            settle::<G, S>(&mut component, from).store(residual);
        }
        component.x.store(x);
        component.v.store(v);
        for register in 0..S::REGISTERS {
            component.registers[register].store(&mut registers[register][group]);
        }
    }
    moved.store(squares);
    add_power(&mut power[EnergySink::Damping as usize], &lanes(corrected), S::CORRECTED_WEIGHT);
    add_power(&mut power[EnergySink::Drag as usize], &lanes(drag), law.unit());
    if L::SUPPLIES {
        add_power(&mut power[EnergySink::Work as usize], &lanes(work), law.unit());
    }
}

/// Converts a position relative to `from` to a rounded position, and returns the residual (two-sum). Their sum is exact (D.
/// E. Knuth, The Art of Computer Programming 2, 4.2.2, theorem B).
#[inline(always)]
fn settle<G: Pack, S: Swept>(component: &mut Component<G>, from: G) -> G {
    let by = component.x;
    let sum = from + by;
    let moved = sum - from;
    let residual = (from - (sum - moved)) + (by - moved);
    component.x = sum;
    if let Some(register) = S::POSITION_REGISTER {
        component.registers[register] = component.registers[register] - (by - residual);
    }
    residual
}

/// Evaluates `$body` for a stage: with a constant, if each stage is compiled separately. The cases are written out, because a
/// loop that the compiler does not unroll is not vectorized.
macro_rules! at_stage {
    ($S:ty, $number:ident, $stage:ident => $body:expr) => {
        at_stage!(@ $S, $number, $stage, $body; 0 1 2 3 4 5)
    };
    (@ $S:ty, $number:ident, $stage:ident, $body:expr; $($index:literal)*) => {
        const { assert!(<$S>::COMPILED <= 6, "more stages than are written out") };
        if const { <$S>::COMPILED == 1 } {
            let $stage: usize = $number;
            $body;
        } else {
            $(if const { $index < <$S>::COMPILED } {
                if $number == $index {
                    let $stage: usize = $index;
                    $body;
                }
            })*
        }
    };
}

/// Computes the state of a stage.
#[inline(always)]
fn stage_state<G: Pack, S: Swept>(at: S::At, number: usize, component: &mut Component<G>, h: G) {
    at_stage!(S, number, stage => S::state(at, stage, component, h));
}

/// Updates the state by the acceleration of a stage.
#[inline(always)]
fn stage_update<G: Pack, S: Swept>(at: S::At, number: usize, component: &mut Component<G>, a: G, h: G) {
    at_stage!(S, number, stage => S::update(at, stage, component, a, h));
}
