//! Particles that feel each other: every stage sweeps over all blocks. It reads the positions and velocities of all from
//! one copy and writes those of its block to another, so that no block has to wait for its neighbours.

use crate::contacts::Before;
use crate::error::Result;
use crate::forces::{Field, Rates};
use crate::integrators::Integrator;
use crate::math::Vector;
use crate::matter::{Blocks, CHANNELS, Columns, Matter, Span};
use crate::parallel::{Chunks, Crew, Split};
use crate::simd::LANES;
use crate::systems::matter::Interval;
use crate::systems::matter::activity::Activity;
use crate::systems::matter::collisions::collide;
use crate::systems::matter::displacement::displace;
use crate::systems::matter::kernels::{self, Action, Load};
use crate::systems::matter::law::Law;

/// Memory for the sweeps.
#[derive(Debug)]
pub struct Desk<V: Vector> {
    position: Columns<V>,
    velocity: Columns<V>,
    force: Columns<V>,
    before: Option<[Columns<V>; 2]>,
    /// The activity of each block after the step that a sweep ended [J].
    activity: Vec<f64>,
}

impl<V: Vector> Desk<V> {
    /// Memory for `count` particles in `blocks` blocks, with contacts or without.
    pub fn new(count: usize, blocks: usize, contacts: bool) -> Self {
        let columns = || Columns::zeros(count);
        let before = contacts.then(|| [columns(), columns()]);
        Self { position: columns(), velocity: columns(), force: columns(), before, activity: vec![0.0; blocks] }
    }

    /// The memory that it takes [bytes].
    pub fn bytes(&self) -> usize {
        let before = self.before.iter().flatten().map(Columns::bytes).sum::<usize>();
        self.position.bytes() + self.velocity.bytes() + self.force.bytes() + before + size_of_val(self.activity.as_slice())
    }
}

/// Advances `matter` in place. The activity at the end is not a number where a position is not finite.
pub fn advance<V: Vector, I: Integrator>(
    law: &mut Law<V>,
    matter: &mut Matter<V>,
    desk: &mut Desk<V>,
    interval: Interval,
    activity: &mut Activity,
    crew: &Crew,
) -> Result<()> {
    let stages = I::NODES.len();
    // The last stage's sweep moves on to the first stage of the next step, unless something happens at the step's end.
    let field = law.field();
    let drifts = I::TURNS.filter(|_| field == Field::Carried);
    let counts = field == Field::Counted && !I::ENDS_WITH_FORCES;
    let moves_on = desk.before.is_none() && !counts && drifts.is_none_or(|turns| turns.drifts.len() == stages);
    for step in 0..interval.steps {
        if let Some([position, velocity]) = &mut desk.before {
            position.copy_from(&matter.position);
            velocity.copy_from(&matter.velocity);
        }
        if step == 0 || !moves_on {
            sweep::<V, I>(law, matter, desk, interval, 0.0, Action::Point, crew)?;
        }
        if I::DRIFTS_FIRST {
            collisions::<V, I>(law, matter, desk, interval.h, crew);
        }
        for stage in 0..stages {
            let time = interval.time(step, I::NODES[stage]);
            if let Some(turns) = drifts {
                drift(law, matter, desk, Some(turns.velocity), (time, turns.drifts[stage] * interval.h), crew)?;
            }
            let next = if stage + 1 < stages { Some(stage + 1) } else { (step + 1 < interval.steps && moves_on).then_some(0) };
            sweep::<V, I>(law, matter, desk, interval, time, Action::Absorb(stage, next), crew)?;
        }
        activity.push(desk.activity.iter().sum());
        if let Some(&last) = drifts.and_then(|turns| turns.drifts.get(stages)) {
            drift(law, matter, desk, None, (interval.time(step, 1.0), last * interval.h), crew)?;
        }
        if counts {
            law.count(matter, interval.time(step, 1.0), crew)?;
        }
        if crew.stopped() {
            break;
        }
    }
    Ok(())
}

/// Evaluates the law at the state and fills the carried memory.
pub fn begin<V: Vector, I: Integrator>(
    law: &mut Law<V>,
    matter: &mut Matter<V>,
    desk: &mut Desk<V>,
    interval: Interval,
    crew: &Crew,
) -> Result<()> {
    sweep::<V, I>(law, matter, desk, interval, interval.start, Action::Begin, crew)
}

/// Advances the fields over the drift of `h` seconds that led here, at a time, with the velocity that is remembered or the
/// present one; meters what they lose on the way, and displaces what they move beside it.
fn drift<V: Vector>(
    law: &mut Law<V>,
    matter: &mut Matter<V>,
    desk: &mut Desk<V>,
    velocity: Option<usize>,
    (time, h): (f64, f64),
    crew: &Crew,
) -> Result<()> {
    if h == 0.0 {
        return Ok(());
    }
    let way = velocity.map_or(&matter.velocity, |memory| &matter.memory[memory]);
    law.drift(matter, way.view(), h, crew)?;
    let law = &*law;
    crew.sweep(matter.blocks(), &|blocks: Blocks<'_, V>| law.spend(&blocks.range(), &mut blocks.meters[0].energy));
    if law.displaces() { displace(law, matter, &mut desk.force, time, crew) } else { Ok(()) }
}

fn sweep<V: Vector, I: Integrator>(
    law: &mut Law<V>,
    matter: &mut Matter<V>,
    desk: &mut Desk<V>,
    interval: Interval,
    time: f64,
    action: Action,
    crew: &Crew,
) -> Result<()> {
    let asks = !matches!(action, Action::Point);
    if asks {
        law.prepare(matter, time, crew)?;
    }
    std::mem::swap(&mut matter.position, &mut desk.position);
    std::mem::swap(&mut matter.velocity, &mut desk.velocity);
    let law = &*law;
    let ends_step = matches!(action, Action::Absorb(stage, _) if stage + 1 == I::NODES.len());
    let ends_run = ends_step && matches!(action, Action::Absorb(_, None));
    let at = law.moment(desk.position.view(), desk.velocity.view(), time);
    let before = desk.before.as_ref().filter(|_| ends_step && !I::DRIFTS_FIRST);
    let work = (Work { blocks: matter.blocks(), force: desk.force.span() }, Chunks::new(&mut desk.activity, 1));
    crew.sweep(work, &|(work, activity): (Work<'_, V>, Chunks<'_, f64>)| {
        let Work { mut blocks, mut force } = work;
        let range = blocks.range();
        blocks.position.copy_from(&at.position, range.start);
        blocks.velocity.copy_from(&at.velocity, range.start);
        let mut power = [[0.0; LANES]; CHANNELS];
        if asks {
            law.accumulate(&range, &at, &mut Rates { force: force.reborrow(), power: &mut power });
        }
        activity.items[0] = kernels::stage::<V, I>(law, &mut blocks, &Load { force, power }, interval.h, action);
        if let (Some(contacts), Some([position, velocity])) = (&law.contacts, before) {
            contacts.resolve(&Before::part(position, velocity, &range), &mut blocks, &law.properties, interval.h);
        }
        if ends_run {
            activity.items[0] += kernels::out_of_range(law, &blocks);
        }
    });
    Ok(())
}

/// Resolves all contacts within the drift.
fn collisions<V: Vector, I: Integrator>(law: &Law<V>, matter: &mut Matter<V>, desk: &Desk<V>, h: f64, crew: &Crew) {
    let (Some(contacts), Some([position, velocity])) = (&law.contacts, &desk.before) else { return };
    crew.sweep(matter.blocks(), &|mut block: Blocks<'_, V>| {
        let before = Before::part(position, velocity, &block.range());
        collide::<V, I>(law, contacts, &mut block, &before, h);
    });
}

/// Blocks with their forces.
pub struct Work<'a, V: Vector> {
    pub blocks: Blocks<'a, V>,
    pub force: Span<'a, V>,
}

impl<V: Vector> Split for Work<'_, V> {
    fn blocks(&self) -> usize {
        self.blocks.blocks()
    }

    fn split_at(self, blocks: usize) -> (Self, Self) {
        let (first, rest) = self.blocks.split_at(blocks);
        let (force, other_force) = self.force.split_at(first.position.len());
        (Self { blocks: first, force }, Self { blocks: rest, force: other_force })
    }
}
