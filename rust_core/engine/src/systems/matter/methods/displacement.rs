//! Displacements of particles that do not change their velocity, between a drift and the forces at its end.
//!
//! Momentum and kinetic energy are conserved. The change of potential energy counts as work, from the potentials before and
//! after. Displacements do not cross walls.

use crate::catalog::Space;
use crate::error::Result;
use crate::matter::{Blocks, Columns, EnergySink, Matter};
use crate::parallel::Executor;
use crate::systems::matter::dynamics::Dynamics;
use crate::systems::matter::methods::coupled::BlocksWithForces;

/// Displaces all particles by the shifts of the forces at `time`; `displacements` is a buffer.
pub fn displace<V: Space>(
    dynamics: &Dynamics<V>,
    matter: &mut Matter<V>,
    displacements: &mut Columns<V>,
    time: f64,
    executor: &Executor,
) -> Result<()> {
    let before = dynamics.potential_of_callbacks(&dynamics.view_of(matter, time, executor))?;
    executor.for_each_block(BlocksWithForces::new(matter.blocks(), displacements.span()), &|work: BlocksWithForces<'_, V>| {
        let BlocksWithForces { mut blocks, force: mut displacements, .. } = work;
        let (start, count) = (blocks.start, blocks.count);
        dynamics.shift(&blocks.range(), &mut displacements);
        let potential = |blocks: &Blocks<'_, V>| {
            let at = dynamics.state_view(blocks.position.view(start), blocks.velocity.view(start), time);
            dynamics.potential(&(start..start + count), &at)
        };
        let before = potential(&blocks);
        for lane in 0..count {
            let displacement = displacements.get(lane);
            if displacement != V::default() {
                let position = blocks.exact_position(lane) + displacement.widen();
                let held =
                    dynamics.contacts.as_ref().and_then(|walls| walls.confine(position, &dynamics.properties, start + lane));
                blocks.set_exact_position(lane, held.unwrap_or(position));
            }
        }
        let gain = potential(&blocks) - before;
        blocks.tallies[0].add(EnergySink::Work, gain);
    });
    let gain = dynamics.potential_of_callbacks(&dynamics.view_of(matter, time, executor))? - before;
    if let Some(tally) = matter.tallies.first_mut() {
        tally.add(EnergySink::Work, gain);
    }
    Ok(())
}
