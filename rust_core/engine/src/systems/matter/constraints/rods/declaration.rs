//! Rods that a scene declares.

use super::super::{Declaration, RODS, refuse};
use super::network::{Network, Rod};
use super::supports::Supports;
use super::{Rods, is_rod};
use crate::catalog::Space;
use crate::contacts::Contacts;
use crate::error::{Error, Result};
use crate::forces::springs::Spring;
use crate::matter::Properties;
use crate::systems::matter::methods::Treatment;

impl Rods {
    /// Selects the rods among springs; None if there are none, or if the method projects them itself. Rods between two fixed
    /// particles constrain nothing and are left out.
    ///
    /// # Errors
    /// If the method does not hold rods, if they have to part, if the equations do not fit into memory, or on an interrupt.
    pub fn declared<V: Space>(declared: &mut Declaration<'_, V>) -> Result<Option<Self>> {
        let Declaration { springs, properties, method, executor, .. } = *declared;
        if !springs.iter().any(is_rod) {
            return Ok(None);
        }
        refuse(RODS, method)?;
        refuse_parting(declared)?;
        let free = |spring: &Spring| spring.ends.iter().any(|&end| !properties.is_fixed(end as usize));
        let chosen: Vec<usize> = (0..springs.len()).filter(|&index| is_rod(&springs[index]) && free(&springs[index])).collect();
        if chosen.is_empty() || method.springs == Treatment::Projections {
            return Ok(None);
        }
        let mut particles: Vec<u32> = chosen.iter().flat_map(|&index| springs[index].ends).collect();
        particles.sort_unstable();
        particles.dedup();
        let local = |particle: u32| particles.partition_point(|&other| other < particle) as u32;
        let links: Vec<Rod> = chosen
            .iter()
            .map(|&index| Rod { ends: springs[index].ends.map(local), length: springs[index].rest_length })
            .collect();
        let inverse_mass: Vec<f64> = particles.iter().map(|&particle| 1.0 / properties.mass[particle as usize]).collect();
        let network = Network::new(links, inverse_mass, executor)?;
        let supports = match &mut declared.walls {
            Some(walls) => {
                own_contacts(walls, properties, &particles)?;
                Some(Supports::new(&network, V::DIMENSION, executor)?)
            }
            None => None,
        };
        Ok(Some(Self { network, supports, all: springs.to_vec(), springs: chosen, particles, removed: 0.0, turned: false }))
    }
}

/// Takes the contacts of the particles of rods out of those of independent particles.
fn own_contacts<V: Space>(walls: &mut Contacts<V>, properties: &Properties<V>, particles: &[u32]) -> Result<()> {
    walls.leave_out(particles);
    let Some((path, friction)) = walls.friction(properties, particles) else { return Ok(()) };
    Err(Error::parameter(format!("{path}.friction"), "0 with rods", friction)
        .with_hint("the friction of what rods hold is not computed; name bodies without rods with on="))
}

/// Refuses rods between fixed particles that have to part.
fn refuse_parting<V: Space>(Declaration { scene, springs, properties, .. }: &Declaration<'_, V>) -> Result<()> {
    let velocity = |end: u32| {
        let caller = properties.caller[end as usize] as usize;
        scene.bodies.iter().flat_map(|body| &body.velocities).nth(caller).copied()
    };
    let parting = |spring: &&Spring| {
        let [one, other] = spring.ends;
        spring.ends.iter().all(|&end| properties.is_fixed(end as usize)) && velocity(one) != velocity(other)
    };
    let Some(rod) = springs.iter().filter(|spring| is_rod(spring)).find(parting) else { return Ok(()) };
    let ends = rod.ends.map(|end| properties.caller[end as usize]);
    let found = format!("a rod between the fixed particles {} and {}, whose velocities differ", ends[0], ends[1]);
    Err(Error::parameter("scene", "rods whose ends can keep their distance", found))
}
