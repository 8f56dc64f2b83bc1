//! Independent particles: a block runs through many steps while it stays in the cache.

use crate::catalog::Space;
use crate::contacts::Before;
use crate::forces::Rates;
use crate::integrators::Facts;
use crate::math::Real;
use crate::matter::{Blocks, Matter, SINKS, Span};
use crate::parallel::{BlockedSlice, Executor};
use crate::simd::LANES;
use crate::systems::matter::activity::Activity;
use crate::systems::matter::dynamics::Dynamics;
use crate::systems::matter::kernels::{self, Evaluation, StageAction, kicked};
use crate::systems::matter::methods::stepper::Stepper;
use crate::systems::{Interval, RecordedSteps};

/// Number of steps between activities if steps run in registers. The count follows the steps of the clock's segment, so that
/// it does not depend on batches.
const SAMPLING: u64 = 32;

/// Advances `matter` from the state `from`: block by block, each through all steps. The activity at the end is NaN if a
/// position is not finite.
pub fn advance<V: Space>(
    stepper: &Stepper<V>,
    dynamics: &Dynamics<V>,
    from: &Matter<V>,
    matter: &mut Matter<V>,
    interval: Interval,
    (activity, record): (&mut Activity, RecordedSteps),
    executor: &Executor,
) {
    // Only linear dynamics can omit intermediate activities.
    let fused = stepper.linear_steps.filter(|_| dynamics.is_fused() && dynamics.contacts.is_none());
    let point_force = || stepper.point_force_steps.zip(dynamics.lone_inverse_square());
    let recorded = if fused.is_some() && record == RecordedSteps::LastStep { 1 } else { interval.steps as usize };
    let work = (matter.blocks(), activity.record(from.tallies.len(), recorded));
    executor.for_each_block(work, &|(block, activity): (Blocks<'_, V>, BlockedSlice<'_, f64>)| {
        let activity = activity.items;
        with_buffers(from, block, &stepper.facts, &mut |buffers| {
            if let Some(steps) = fused {
                for activity in activity.iter_mut() {
                    steps(dynamics, &mut buffers.block, interval.h, interval.steps / recorded as u64);
                    *activity = kernels::activity(dynamics, &buffers.block);
                }
            } else if let (Some((advance, force)), None) = (point_force(), &dynamics.contacts) {
                sampled(dynamics, buffers, interval, record, activity, |block, steps| {
                    advance(dynamics, force, block, interval.h, steps);
                });
            } else if let (Some(fields), None) = (dynamics.lone_fields(), &dynamics.contacts) {
                sampled(dynamics, buffers, interval, record, activity, |block, steps| {
                    kernels::gyration_steps(dynamics, fields, block, interval.h, steps);
                });
            } else {
                one_by_one(stepper, dynamics, buffers, interval, activity, executor);
            }
            if let Some(last) = activity.last_mut() {
                *last += kernels::out_of_range(dynamics, &buffers.block);
            }
        });
    });
    activity.add_up(recorded);
}

/// Takes steps under one force alone, with the activity after sampled steps.
fn sampled<V: Space>(
    dynamics: &Dynamics<V>,
    buffers: &mut BlockBuffers<'_, V>,
    interval: Interval,
    record: RecordedSteps,
    mut rest: &mut [f64],
    advance: impl Fn(&mut Blocks<'_, V>, u64),
) {
    let every = if record == RecordedSteps::EveryStep { 1 } else { SAMPLING };
    while !rest.is_empty() {
        let step = interval.first + interval.steps - rest.len() as u64;
        let steps = (every - step % every).min(rest.len() as u64);
        advance(&mut buffers.block, steps);
        let (now, later) = rest.split_at_mut(steps as usize);
        if (step + steps).is_multiple_of(every) {
            now[now.len() - 1] = kernels::activity(dynamics, &buffers.block);
        }
        rest = later;
    }
}

/// Evaluates the dynamics at the state `from` and fills the persistent registers of `matter`.
pub fn begin<V: Space>(
    stepper: &Stepper<V>,
    dynamics: &Dynamics<V>,
    from: &Matter<V>,
    matter: &mut Matter<V>,
    interval: Interval,
) {
    Executor::serial().for_each_block(matter.blocks(), &|block: Blocks<'_, V>| {
        with_buffers(from, block, &stepper.facts, &mut |buffers| {
            run_stage(stepper, dynamics, buffers, interval, interval.start, StageAction::Begin);
        });
    });
}

/// Buffers of a block in the calling thread's scratch memory. Its columns are close together but at different offsets in
/// every page: at equal offsets they would evict each other from the first-level cache.
struct BlockBuffers<'a, V: Space> {
    block: Blocks<'a, V>,
    force: Span<'a, V>,
    before: [Span<'a, V>; 2],
}

/// Copies a block of `from` to buffers, applies `work`, and copies the result to `block`.
fn with_buffers<V: Space>(
    from: &Matter<V>,
    mut block: Blocks<'_, V>,
    method: &Facts,
    work: &mut dyn FnMut(&mut BlockBuffers<'_, V>),
) {
    let (start, length) = (block.start, block.position.len());
    block.tallies[0] = from.tallies[start / from.block];
    let stride = length + LANES;
    let vectors = 5 + method.registers;
    V::Scalar::with_scratch(vectors * V::DIMENSION * stride, |scratch| {
        let mut columns = scratch.chunks_exact_mut(stride).map(|column| &mut column[..length]);
        let mut span = || Span {
            axes: std::array::from_fn(|axis| if axis < V::DIMENSION { columns.next().unwrap_or_default() } else { &mut [] }),
        };
        let (position, velocity, force, before) = (span(), span(), span(), [span(), span()]);
        let registers = std::array::from_fn(|register| if register < method.registers { span() } else { Span::empty() });
        let mut buffers = BlockBuffers {
            block: Blocks::new(start, block.count, position, velocity, registers, &mut *block.tallies),
            force,
            before,
        };
        buffers.block.position.copy_from(&from.position.view(), start);
        buffers.block.velocity.copy_from(&from.velocity.view(), start);
        for (registers, from) in buffers.block.registers.iter_mut().zip(&from.registers).take(method.persistent) {
            registers.copy_from(&from.view(), start);
        }
        work(&mut buffers);
        let BlockBuffers { block: done, .. } = buffers;
        block.position.copy_from(&done.position.view(0), 0);
        block.velocity.copy_from(&done.velocity.view(0), 0);
        for (registers, done) in block.registers.iter_mut().zip(&done.registers).take(method.readable) {
            registers.copy_from(&done.view(0), 0);
        }
    });
}

/// Takes single steps, with a contact stage after each, or with forces that are not fused.
fn one_by_one<V: Space>(
    stepper: &Stepper<V>,
    dynamics: &Dynamics<V>,
    buffers: &mut BlockBuffers<'_, V>,
    interval: Interval,
    activity: &mut [f64],
    executor: &Executor,
) {
    for (step, activity) in (0..).zip(activity) {
        if executor.stopped() {
            return;
        }
        if dynamics.contacts.is_some() {
            buffers.before[0].copy_from(&buffers.block.position.view(0), 0);
            buffers.before[1].copy_from(&buffers.block.velocity.view(0), 0);
        }
        let alone = dynamics.is_fused() && (dynamics.contacts.is_none() || !stepper.facts.drifts_first);
        *activity = if let Some(steps) = stepper.linear_steps.filter(|_| alone) {
            steps(dynamics, &mut buffers.block, interval.h, 1);
            kernels::activity(dynamics, &buffers.block)
        } else {
            stages(stepper, dynamics, buffers, interval, step)
        };
        if let (Some(contacts), false) = (&dynamics.contacts, stepper.facts.drifts_first) {
            contacts.resolve(&Before::spans(&buffers.before), &mut buffers.block, &dynamics.properties, interval.h);
        }
    }
}

/// Takes one step, stage by stage; returns the activity at its last evaluation.
fn stages<V: Space>(
    stepper: &Stepper<V>,
    dynamics: &Dynamics<V>,
    buffers: &mut BlockBuffers<'_, V>,
    interval: Interval,
    step: u64,
) -> f64 {
    run_stage(stepper, dynamics, buffers, interval, 0.0, StageAction::StageState);
    if let (Some(contacts), Some(collide)) = (&dynamics.contacts, stepper.collide) {
        collide(dynamics, contacts, &mut buffers.block, &Before::spans(&buffers.before), interval.h);
    }
    let mut activity = 0.0;
    let nodes = stepper.facts.nodes;
    for (stage, &node) in nodes.iter().enumerate() {
        let next = (stage + 1 < nodes.len()).then_some(stage + 1);
        let time = interval.time(step, node);
        activity = run_stage(stepper, dynamics, buffers, interval, time, StageAction::StageUpdate(stage, next));
    }
    activity
}

fn run_stage<V: Space>(
    stepper: &Stepper<V>,
    dynamics: &Dynamics<V>,
    buffers: &mut BlockBuffers<'_, V>,
    interval: Interval,
    time: f64,
    action: StageAction,
) -> f64 {
    let BlockBuffers { block, force, .. } = buffers;
    let range = block.range();
    let mut power = [[0.0; LANES]; SINKS];
    if !matches!(action, StageAction::StageState) {
        let at = dynamics.state_view(block.position.view(range.start), block.velocity.view(range.start), time);
        dynamics.accumulate(&range, &at, &mut Rates::new(force.reborrow(), &mut power));
        if let (true, Some(before)) = (stepper.facts.gyrates && dynamics.magnetic, kicked(&stepper.facts, block, action)) {
            kernels::gyrate(dynamics, &range, &at, before, interval.h, force);
        }
    }
    stepper.stage(dynamics, None, block, &Evaluation { force: force.reborrow(), power, damping: None }, interval.h, action)
}
