//! Laws that scenes can declare: forces and fluids. They are compiled in crates of their own, and the engine builds them by a
//! [`Catalog`]. An edit of one law thus compiles neither the engine nor the laws of the other crate.

use glam::{DVec2, DVec3, Vec2, Vec3};

use crate::error::Result;
use crate::forces::springs::Spring;
use crate::forces::{Force, Reach, fluid};
use crate::math::Vector;
use crate::matter::Properties;
use crate::parallel::Executor;
use crate::scene::{Item, Scene};

/// Forces that one item of a scene declares.
pub type Forces<V> = Vec<Box<dyn Force<V>>>;

/// Builds forces between particles with one kind of vectors.
pub trait BuildForces<V: Vector> {
    /// Builds the forces that an item of the scene declares.
    ///
    /// # Errors
    /// If there is no such force, or a parameter is out of range.
    fn build(&self, scene: &Scene, item: &Item, properties: &Properties<V>, executor: &Executor) -> Result<Forces<V>>;

    /// Builds the force of springs between `count` particles.
    fn springs(&self, springs: &[Spring], count: usize) -> Box<dyn Force<V>>;
}

/// All forces that scenes can declare.
pub trait ForceLaws: BuildForces<Vec2> + BuildForces<Vec3> + BuildForces<DVec2> + BuildForces<DVec3> + Sync {
    /// Range of the force of an item; None of other items.
    fn reach(&self, item: &Item) -> Option<Reach>;

    /// Whether the force of an item acts on charges.
    fn feels_charges(&self, item: &Item) -> bool;

    /// Order of particles in memory in which the partners of springs are near each other: index there → index of the caller. None
    /// if the given order is as good.
    fn order(&self, springs: &[Spring], count: usize) -> Option<Vec<u32>>;

    /// Acceleration of a body by all uniform gravity of a scene at the start [m/s²].
    ///
    /// # Errors
    /// If an acceleration is not finite.
    fn gravity(&self, scene: &Scene, body: usize) -> Result<DVec3>;

    /// Speed [m/s] of particles of this mass that fall to the center of a central force from the particle farthest from it. None
    /// of other forces.
    ///
    /// # Errors
    /// If a parameter is out of range.
    fn fall(&self, item: &Item, mass: f64, positions: &[DVec3]) -> Result<Option<f64>>;
}

impl dyn ForceLaws + '_ {
    /// Whether the force of an item acts between particles.
    #[inline]
    pub fn is_between_pairs(&self, item: &Item) -> bool {
        matches!(self.reach(item), Some(Reach::Network | Reach::Pairs | Reach::Far))
    }

    /// Whether any force or fluid of a scene acts between all near particles.
    #[inline]
    pub fn are_between_neighbors(&self, scene: &Scene) -> bool {
        fluid::is_in(scene) || scene.forces.iter().any(|item| self.reach(item) == Some(Reach::Pairs))
    }

    /// Whether forces of a scene act between all pairs of particles, at any distance.
    #[inline]
    pub fn are_at_a_distance(&self, scene: &Scene) -> bool {
        scene.forces.iter().any(|item| self.reach(item) == Some(Reach::Far))
    }
}

/// Builds fluids of particles with one kind of vectors.
pub trait BuildFluids<V: Vector> {
    /// Builds the fluids of a scene and their obstacles, if it has fluids. Their speed of sound depends on the forces.
    ///
    /// # Errors
    /// If their parameters are inconsistent.
    fn build(
        &self,
        scene: &Scene,
        laws: &dyn ForceLaws,
        properties: &Properties<V>,
        executor: &Executor,
    ) -> Result<Option<Box<dyn Force<V>>>>;
}

/// All particle methods for fluids that scenes can declare.
pub trait FluidLaws: BuildFluids<Vec2> + BuildFluids<Vec3> + BuildFluids<DVec2> + BuildFluids<DVec3> + Sync {}

/// All laws that scenes can declare.
#[derive(Clone, Copy)]
pub struct Catalog {
    /// Forces.
    pub forces: &'static dyn ForceLaws,
    /// Particle methods for fluids.
    pub fluids: &'static dyn FluidLaws,
}

impl std::fmt::Debug for Catalog {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str("Catalog")
    }
}

/// A kind of vectors that the engine computes with.
pub trait Space: Vector {
    /// Forces between particles with these vectors.
    fn forces(catalog: Catalog) -> &'static dyn BuildForces<Self>;

    /// Fluids of particles with these vectors.
    fn fluids(catalog: Catalog) -> &'static dyn BuildFluids<Self>;
}

macro_rules! spaces {
    ($($vector:ty),+) => {
        $(impl Space for $vector {
            fn forces(catalog: Catalog) -> &'static dyn BuildForces<Self> {
                catalog.forces
            }

            fn fluids(catalog: Catalog) -> &'static dyn BuildFluids<Self> {
                catalog.fluids
            }
        })+
    };
}

spaces!(Vec2, Vec3, DVec2, DVec3);
