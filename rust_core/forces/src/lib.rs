//! Forces on particles, one file each. To add one: write its file, and add its line to [`kinds`]. The engine builds them by
//! [`FORCES`].

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "references may be the C library's"))]

use glam::{DVec2, DVec3, Vec2, Vec3};

mod all_pairs;
mod central;
mod corners;
mod custom;
mod dihedral;
mod drag;
mod electromagnetic;
mod gravity;
mod lennard_jones;
mod pairs;
mod placed;
mod soft_spheres;
mod springs;
mod stream;
mod timed;
mod wind;

use error::Result;
use math::{Real, Vector};
use matter::Properties;
use parallel::Executor;
use physcore_base::{adjacency, error, history, ledger, math, parallel, scene, simd, stability};
use physcore_matter::catalog::{BuildForces, ForceLaws, Forces};
use physcore_matter::forces::springs::Spring;
use physcore_matter::forces::{
    About, Force, PART, Rates, Reach, StateView, Strength, Validity, VelocityDependence, derivatives, linear, pointwise,
};
use physcore_matter::{matter, neighbors};
use scene::{Item, Scene};
use simd::padded;

/// A force that a scene declares, and the particles that it acts on.
struct Declared<'a, V: Vector> {
    scene: &'a Scene,
    item: &'a Item,
    properties: &'a Properties<V>,
    /// Whether the force acts on each particle, in the engine's order.
    chosen: Vec<bool>,
    /// Threads for long operations, and the stop request.
    executor: &'a Executor,
}

impl<V: Vector> Declared<'_, V> {
    /// The particles that the force acts on, in the caller's order.
    fn members(&self) -> Vec<usize> {
        self.properties.engine().into_iter().map(|index| index as usize).filter(|&index| self.chosen[index]).collect()
    }

    /// Whether each of these particles is movable. Pointwise forces act on no others; pair forces count fixed particles too.
    fn mobile(&self) -> Vec<bool> {
        self.chosen.iter().enumerate().map(|(index, &chosen)| chosen && !self.properties.is_fixed(index)).collect()
    }

    /// [`Declared::mobile`] as 1 and 0, padded.
    fn mask(&self) -> Vec<V::Scalar> {
        let mut mask = vec![V::Scalar::ZERO; padded(self.chosen.len())];
        mask.iter_mut().zip(self.mobile()).filter(|(_, mobile)| *mobile).for_each(|(slot, _)| *slot = V::Scalar::ONE);
        mask
    }
}

/// A kind of force that a scene can declare.
struct ForceKind<V: Vector> {
    /// Name in the scene.
    name: &'static str,
    /// Range of the force.
    reach: Reach,
    /// Whether the force acts on charges.
    charges: bool,
    /// Builds the forces that an item of this kind declares.
    build: fn(&Declared<'_, V>) -> Result<Forces<V>>,
}

/// The registry of forces.
fn kinds<V: Vector>() -> [ForceKind<V>; 11] {
    [
        gravity::kind(),
        drag::kind(),
        central::kind(),
        custom::kind(),
        soft_spheres::kind(),
        lennard_jones::kind(),
        all_pairs::gravitation(),
        all_pairs::coulomb(),
        dihedral::kind(),
        electromagnetic::kind(),
        wind::kind(),
    ]
}

/// Builds the forces that an item of the scene declares.
fn build<V: Vector>(scene: &Scene, item: &Item, properties: &Properties<V>, executor: &Executor) -> Result<Forces<V>> {
    let Some(kind) = kinds().into_iter().find(|kind| kind.name == item.kind) else {
        return Err(scene::unknown(item, "a force"));
    };
    let in_scene = scene.members(item);
    if in_scene.len() != scene.count() {
        return Err(item.wrong("on", "a mask of all particles", None));
    }
    let chosen = properties.caller.iter().map(|&caller| in_scene[caller as usize]).collect();
    (kind.build)(&Declared { scene, item, properties, chosen, executor })
}

/// The forces of this crate.
struct AllForces;

/// All forces that scenes can declare.
pub const FORCES: &dyn ForceLaws = &AllForces;

impl ForceLaws for AllForces {
    fn reach(&self, item: &Item) -> Option<Reach> {
        kinds::<DVec2>().iter().find(|kind| kind.name == item.kind).map(|kind| kind.reach)
    }

    fn feels_charges(&self, item: &Item) -> bool {
        kinds::<DVec2>().iter().any(|kind| kind.name == item.kind && kind.charges)
    }

    fn order(&self, springs: &[Spring], count: usize) -> Option<Vec<u32>> {
        springs::ordering(springs, count)
    }

    fn gravity(&self, scene: &Scene, body: usize) -> Result<DVec3> {
        gravity::on_body(scene, body)
    }

    fn fall(&self, item: &Item, mass: f64, positions: &[DVec3]) -> Result<Option<f64>> {
        central::fall(item, mass, positions)
    }
}

macro_rules! compile_forces {
    ($($vector:ty),+) => {
        $(impl BuildForces<$vector> for AllForces {
            fn build(
                &self,
                scene: &Scene,
                item: &Item,
                properties: &Properties<$vector>,
                executor: &Executor,
            ) -> Result<Forces<$vector>> {
                build(scene, item, properties, executor)
            }

            fn springs(&self, springs: &[Spring], count: usize) -> Box<dyn Force<$vector>> {
                Box::new(springs::Springs::<$vector>::new(springs, count))
            }
        })+
    };
}

compile_forces!(Vec2, Vec3, DVec2, DVec3);
