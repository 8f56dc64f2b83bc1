//! Coupled particles: every stage is a sweep over all blocks. A sweep reads the positions and velocities of all particles
//! from one copy. It writes those of each block to another, so that no block waits for another.

use crate::catalog::Space;
use crate::contacts::Before;
use crate::error::Result;
use crate::forces::{DensityScheme, Rates};
use crate::matter::{Blocks, Columns, SINKS, Span};
use crate::parallel::{BlockedSlice, Split};
use crate::simd::LANES;
use crate::systems::Interval;
use crate::systems::matter::activity::Activity;
use crate::systems::matter::kernels::{self, Evaluation, StageAction, kicked};
use crate::systems::matter::methods::displacement::displace;
use crate::systems::matter::methods::stepper::Stepper;
use crate::systems::matter::step::MatterStep;

/// Buffers of the sweeps.
#[derive(Debug)]
pub struct Workspace<V: Space> {
    pub position: Columns<V>,
    pub velocity: Columns<V>,
    pub force: Columns<V>,
    /// Part of the force by the damping of springs [N], if the integrator needs it.
    pub damping: Option<Columns<V>>,
    /// Positions and velocities at the start of the step, for contacts.
    pub before: Option<[Columns<V>; 2]>,
    /// Activity of each block at the end of the step [J].
    pub activity: Vec<f64>,
}

impl<V: Space> Workspace<V> {
    /// Buffers for `count` particles in `blocks` blocks, with or without contacts, and with or without the force of damping.
    pub fn new(count: usize, blocks: usize, contacts: bool, damping: bool) -> Self {
        let columns = || Columns::zeros(count);
        let before = contacts.then(|| [columns(), columns()]);
        let damping = damping.then(columns);
        Self { position: columns(), velocity: columns(), force: columns(), damping, before, activity: vec![0.0; blocks] }
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        let before = self.before.iter().flatten().chain(&self.damping).map(Columns::bytes).sum::<usize>();
        self.position.bytes() + self.velocity.bytes() + self.force.bytes() + before + size_of_val(self.activity.as_slice())
    }
}

/// Advances coupled matter in place. The activity at the end is NaN if a position is not finite.
pub fn advance<V: Space>(
    stepper: &Stepper<V>,
    step: &mut MatterStep<'_, V>,
    interval: Interval,
    activity: &mut Activity,
) -> Result<()> {
    for index in 0..interval.steps {
        take(stepper, step, interval, index)?;
        activity.push(step.workspace.activity.iter().sum());
        if step.executor.stopped() {
            break;
        }
    }
    Ok(())
}

/// Takes one step of an interval.
pub fn take<V: Space>(stepper: &Stepper<V>, step: &mut MatterStep<'_, V>, interval: Interval, index: u64) -> Result<()> {
    let (method, h) = (&stepper.facts, interval.h);
    let (stages, scheme) = (method.stages(), step.dynamics.scheme);
    // The last stage's sweep also computes the state of the next step's first stage, unless an operation intervenes at the
    // end of the step.
    let drifts = method.drift_kick.filter(|_| scheme.is_some_and(DensityScheme::is_carried));
    let sums = scheme == Some(DensityScheme::Summation) && !method.ends_with_forces;
    let intervenes = step.workspace.before.is_some() || step.constraints.act() || sums;
    let moves_on = !intervenes && drifts.is_none_or(|drift_kick| drift_kick.drifts.len() == stages);
    let drift = stepper.drift();
    step.begin(h, drift);
    if index == 0 || !moves_on {
        sweep(stepper, step, h, 0.0, StageAction::StageState)?;
    }
    if let Some(drift) = drift {
        step.drifted(h, drift, stepper.collide)?;
    }
    for stage in 0..stages {
        let time = interval.time(index, method.nodes[stage]);
        if let Some(drift_kick) = drifts {
            advance_density(step, Some(drift_kick.velocity), (time, drift_kick.drifts[stage] * h))?;
        }
        let next = if stage + 1 < stages { Some(stage + 1) } else { (index + 1 < interval.steps && moves_on).then_some(0) };
        sweep(stepper, step, h, time, StageAction::StageUpdate(stage, next))?;
    }
    if let Some(&last) = drifts.and_then(|drift_kick| drift_kick.drifts.get(stages)) {
        advance_density(step, None, (interval.time(index, 1.0), last * h))?;
    }
    if sums {
        step.dynamics.sum_density(step.matter, interval.time(index, 1.0), step.executor)?;
    }
    step.end(h, drift)
}

/// Evaluates the dynamics at the state and fills the persistent registers.
pub fn begin<V: Space>(stepper: &Stepper<V>, step: &mut MatterStep<'_, V>, interval: Interval) -> Result<()> {
    sweep(stepper, step, interval.h, interval.start, StageAction::Begin)?;
    step.start(stepper.drift());
    Ok(())
}

/// Advances density over the preceding drift of `h` seconds, which ends at `time`. The velocity of the drift is in a
/// register, or the present one. Tallies the dissipated energy, and shifts particles.
fn advance_density<V: Space>(step: &mut MatterStep<'_, V>, velocity: Option<usize>, (time, h): (f64, f64)) -> Result<()> {
    if h == 0.0 {
        return Ok(());
    }
    let MatterStep { dynamics, matter, workspace, executor, .. } = step;
    let velocity = velocity.map_or(&matter.velocity, |register| &matter.registers[register]);
    dynamics.drift_density(matter, velocity.view(), h, executor)?;
    let dynamics = &**dynamics;
    executor.for_each_block(matter.blocks(), &|blocks: Blocks<'_, V>| {
        dynamics.diffused(&blocks.range(), &mut blocks.tallies[0].energy);
    });
    let shifts = dynamics.scheme == Some(DensityScheme::Continuity { shifts: true });
    if shifts { displace(dynamics, matter, &mut workspace.force, time, executor) } else { Ok(()) }
}

/// Sets the forces of the workspace to the accelerations at its state, for which forces are prepared. Integrates the powers
/// there over the first share [s], and those of the last evaluation over the second; `keep` keeps the former.
pub fn accelerate<V: Space>(step: &mut MatterStep<'_, V>, time: f64, [share, last]: [f64; 2], keep: bool) {
    let MatterStep { dynamics, matter, workspace, executor, .. } = step;
    let dynamics = &**dynamics;
    let at = dynamics.state_view(workspace.position.view(), workspace.velocity.view(), time);
    let work = BlocksWithForces::new(matter.blocks(), workspace.force.span());
    executor.for_each_block(work, &|work: BlocksWithForces<'_, V>| {
        let BlocksWithForces { blocks, mut force, .. } = work;
        let mut power = [[0.0; LANES]; SINKS];
        dynamics.accumulate(&blocks.range(), &at, &mut Rates::new(force.reborrow(), &mut power));
        kernels::accelerations(dynamics, blocks.start, (at.position, at.velocity), &mut force, &mut power);
        kernels::integrate(&mut blocks.tallies[0], kernels::through_all(&power), share, last, keep);
    });
}

/// One pass over all blocks: evaluates the forces, if the action needs them, and acts on the state.
fn sweep<V: Space>(stepper: &Stepper<V>, step: &mut MatterStep<'_, V>, h: f64, time: f64, action: StageAction) -> Result<()> {
    let MatterStep { dynamics, matter, workspace, executor, .. } = step;
    let evaluates = !matches!(action, StageAction::StageState);
    if evaluates {
        dynamics.prepare(matter, time, executor)?;
    }
    std::mem::swap(&mut matter.position, &mut workspace.position);
    std::mem::swap(&mut matter.velocity, &mut workspace.velocity);
    let dynamics = &**dynamics;
    let ends_step = matches!(action, StageAction::StageUpdate(stage, _) if stage + 1 == stepper.facts.stages());
    let ends_run = ends_step && matches!(action, StageAction::StageUpdate(_, None));
    let at = dynamics.state_view(workspace.position.view(), workspace.velocity.view(), time);
    let before = workspace.before.as_ref().filter(|_| ends_step && !stepper.facts.drifts_first);
    let work = (
        BlocksWithForces {
            blocks: matter.blocks(),
            force: workspace.force.span(),
            damping: workspace.damping.as_mut().map(Columns::span),
        },
        BlockedSlice::new(&mut workspace.activity, 1),
    );
    executor.for_each_block(work, &|(work, activity): (BlocksWithForces<'_, V>, BlockedSlice<'_, f64>)| {
        let BlocksWithForces { mut blocks, mut force, mut damping } = work;
        let range = blocks.range();
        if matches!(action, StageAction::Begin) {
            // A rotation in a magnetic field kicks from this velocity at the start of a run.
            blocks.velocity.copy_from(&at.velocity, range.start);
        }
        let mut power = [[0.0; LANES]; SINKS];
        if evaluates {
            let damping = damping.as_mut().map(Span::reborrow);
            dynamics.accumulate(&range, &at, &mut Rates { force: force.reborrow(), power: &mut power, damping });
            if let (true, Some(before)) = (stepper.facts.gyrates && dynamics.magnetic, kicked(&stepper.facts, &blocks, action)) {
                kernels::gyrate(dynamics, &range, &at, before, h, &mut force);
            }
        }
        let evaluation = Evaluation { force, power, damping };
        activity.items[0] = stepper.stage(dynamics, Some(&at), &mut blocks, &evaluation, h, action);
        if let (Some(contacts), Some([position, velocity])) = (&dynamics.contacts, before) {
            contacts.resolve(&Before::part(position, velocity, &range), &mut blocks, &dynamics.properties, h);
        }
        if ends_run {
            activity.items[0] += kernels::out_of_range(dynamics, &blocks);
        }
    });
    Ok(())
}

/// Blocks with their forces.
pub struct BlocksWithForces<'a, V: Space> {
    pub blocks: Blocks<'a, V>,
    pub force: Span<'a, V>,
    pub damping: Option<Span<'a, V>>,
}

impl<'a, V: Space> BlocksWithForces<'a, V> {
    /// Creates blocks without a force of damping.
    pub fn new(blocks: Blocks<'a, V>, force: Span<'a, V>) -> Self {
        Self { blocks, force, damping: None }
    }
}

impl<V: Space> Split for BlocksWithForces<'_, V> {
    fn blocks(&self) -> usize {
        self.blocks.blocks()
    }

    fn split_at(self, blocks: usize) -> (Self, Self) {
        let (first, rest) = self.blocks.split_at(blocks);
        let length = first.position.len();
        let (force, other_force) = self.force.split_at(length);
        let (damping, other_damping) = self.damping.map(|damping| damping.split_at(length)).unzip();
        (Self { blocks: first, force, damping }, Self { blocks: rest, force: other_force, damping: other_damping })
    }
}
