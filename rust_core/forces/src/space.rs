//! Compilation of all forces and fluids for each kind of vector.

use glam::{DVec2, DVec3, Vec2, Vec3};

use crate::error::Result;
use crate::fluids;
use crate::forces::springs::{Spring, Springs};
use crate::forces::{self, Force, Forces, Space};
use crate::matter::Properties;
use crate::parallel::Executor;
use crate::scene::{Item, Scene};

macro_rules! compile_forces {
    ($($vector:ty),+) => {
        $(impl Space for $vector {
            fn forces(scene: &Scene, item: &Item, properties: &Properties<Self>, executor: &Executor) -> Result<Forces<Self>> {
                forces::build(scene, item, properties, executor)
            }

            fn springs(springs: &[Spring], count: usize) -> Box<dyn Force<Self>> {
                Box::new(Springs::<Self>::new(springs, count))
            }

            fn fluid(
                scene: &Scene,
                properties: &Properties<Self>,
                executor: &Executor,
            ) -> Result<Option<Box<dyn Force<Self>>>> {
                fluids::build(scene, properties, executor)
            }
        })+
    };
}

compile_forces!(Vec2, Vec3, DVec2, DVec3);
