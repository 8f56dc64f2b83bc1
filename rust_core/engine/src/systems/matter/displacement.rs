//! Displacements: what moves particles beside their velocity, between a drift and the forces at its end.
//!
//! Velocities stay as they are, so momentum and kinetic energy do too. What the particles gain in potential energy is counted
//! as work, from the potentials before and after. Nobody is moved through a wall.

use crate::error::Result;
use crate::math::Vector;
use crate::matter::{Blocks, Channel, Columns, Matter};
use crate::parallel::Crew;
use crate::systems::matter::coupled::Work;
use crate::systems::matter::law::Law;

/// Moves all particles that a force displaces, at a time; `ways` is memory.
pub fn displace<V: Vector>(law: &Law<V>, matter: &mut Matter<V>, ways: &mut Columns<V>, time: f64, crew: &Crew) -> Result<()> {
    let before = law.potential_of_callbacks(&law.moment_of(matter, time, crew))?;
    crew.sweep(Work { blocks: matter.blocks(), force: ways.span() }, &|work: Work<'_, V>| {
        let Work { mut blocks, force: mut ways } = work;
        let (start, count) = (blocks.start, blocks.count);
        law.displace(&blocks.range(), &mut ways);
        let potential = |blocks: &Blocks<'_, V>| {
            let at = law.moment(blocks.position.view(start), blocks.velocity.view(start), time);
            law.potential(&(start..start + count), &at)
        };
        let before = potential(&blocks);
        for lane in 0..count {
            let way = ways.get(lane);
            if way != V::default() {
                let place = blocks.place(lane) + way.widen();
                let held = law.contacts.as_ref().and_then(|walls| walls.hold(place, &law.properties, start + lane));
                blocks.set_place(lane, held.unwrap_or(place));
            }
        }
        let gain = potential(&blocks) - before;
        blocks.meters[0].add(Channel::Work, gain);
    });
    let gain = law.potential_of_callbacks(&law.moment_of(matter, time, crew))? - before;
    if let Some(meter) = matter.meters.first_mut() {
        meter.add(Channel::Work, gain);
    }
    Ok(())
}
