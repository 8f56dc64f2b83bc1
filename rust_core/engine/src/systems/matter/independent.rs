//! Particles that do not feel each other: a block runs through many steps while it stays in the cache.

use crate::contacts::Before;
use crate::forces::Rates;
use crate::integrators::Integrator;
use crate::math::{AXES, Real, Vector};
use crate::matter::{Blocks, CHANNELS, Matter, Span};
use crate::parallel::Crew;
use crate::simd::LANES;
use crate::systems::matter::Interval;
use crate::systems::matter::collisions::collide;
use crate::systems::matter::kernels::{self, Action, Load};
use crate::systems::matter::law::Law;

/// Advances `matter` from the state `from`: block by block, each through all steps.
pub fn advance<V: Vector, I: Integrator>(
    law: &Law<V>,
    from: &Matter<V>,
    matter: &mut Matter<V>,
    interval: Interval,
    crew: &Crew,
) {
    crew.sweep(matter.blocks(), &|mut block: Blocks<'_, V>| {
        copy::<V, I>(from, &mut block);
        if law.is_folded() && law.contacts.is_none() {
            kernels::steps::<V, I>(law, &mut block, interval.h, interval.steps);
        } else {
            V::Scalar::with_scratch(3 * AXES * block.position.len(), |scratch| {
                one_by_one::<V, I>(law, &mut block, interval, scratch)
            });
        }
        block.meters[0].agitation = kernels::agitation(law, &block);
    });
}

fn copy<V: Vector, I: Integrator>(from: &Matter<V>, block: &mut Blocks<'_, V>) {
    let start = block.start;
    block.position.copy_from(&from.position.view(), start);
    block.velocity.copy_from(&from.velocity.view(), start);
    for (memory, from) in block.memory.iter_mut().zip(&from.memory).take(I::CARRIED) {
        memory.copy_from(&from.view(), start);
    }
    block.meters[0] = from.meters[start / from.block];
}

/// One step after the other, with a contact stage between them, or with forces that are not folded.
fn one_by_one<V: Vector, I: Integrator>(law: &Law<V>, block: &mut Blocks<'_, V>, interval: Interval, scratch: &mut [V::Scalar]) {
    let length = block.position.len();
    let (forces, before) = scratch.split_at_mut(AXES * length);
    let mut force = Span::over(forces, length);
    for step in 0..interval.steps {
        if law.contacts.is_some() {
            remember(block, before);
        }
        if law.is_folded() && (law.contacts.is_none() || !I::DRIFTS_FIRST) {
            kernels::steps::<V, I>(law, block, interval.h, 1);
        } else {
            stages::<V, I>(law, block, interval, step, &mut force, before);
        }
        if let (Some(contacts), false) = (&law.contacts, I::DRIFTS_FIRST) {
            contacts.resolve(&Before::of(before, length), block, &law.properties, interval.h);
        }
    }
}

/// One step, stage by stage.
fn stages<V: Vector, I: Integrator>(
    law: &Law<V>,
    block: &mut Blocks<'_, V>,
    interval: Interval,
    step: u64,
    force: &mut Span<'_, V>,
    before: &[V::Scalar],
) {
    let length = block.position.len();
    run_stage::<V, I>(law, block, force, interval, 0.0, Action::Point);
    if let (Some(contacts), true) = (&law.contacts, I::DRIFTS_FIRST) {
        collide::<V, I>(law, contacts, block, &Before::of(before, length), interval.h);
    }
    for stage in 0..I::NODES.len() {
        let next = (stage + 1 < I::NODES.len()).then_some(stage + 1);
        let time = interval.time + (step as f64 + I::NODES[stage]) * interval.h;
        run_stage::<V, I>(law, block, force, interval, time, Action::Absorb(stage, next));
    }
}

fn remember<V: Vector>(block: &Blocks<'_, V>, before: &mut [V::Scalar]) {
    let length = block.position.len();
    let columns = block.position.axes.iter().chain(&block.velocity.axes);
    for (kept, column) in before.chunks_exact_mut(length).zip(columns).filter(|(_, column)| !column.is_empty()) {
        kept.copy_from_slice(column);
    }
}

fn run_stage<V: Vector, I: Integrator>(
    law: &Law<V>,
    block: &mut Blocks<'_, V>,
    force: &mut Span<'_, V>,
    interval: Interval,
    time: f64,
    action: Action,
) {
    let range = block.range();
    let mut power = [[0.0; LANES]; CHANNELS];
    if !matches!(action, Action::Point) {
        let at = law.moment(block.position.view(range.start), block.velocity.view(range.start), time);
        law.accumulate(&range, &at, &mut Rates { force: force.reborrow(), power: &mut power });
    }
    kernels::stage::<V, I>(law, block, &Load { force: force.reborrow(), power }, interval.h, action);
}

/// Evaluates the law at the state and fills the carried memory.
pub fn begin<V: Vector, I: Integrator>(law: &Law<V>, matter: &mut Matter<V>, interval: Interval) {
    Crew::alone().sweep(matter.blocks(), &|mut block: Blocks<'_, V>| {
        let length = block.position.len();
        V::Scalar::with_scratch(AXES * length, |scratch| {
            run_stage::<V, I>(law, &mut block, &mut Span::over(scratch, length), interval, interval.time, Action::Begin);
        });
    });
}
