//! Particle methods for fluids, one folder each: a scheme is its state and its right-hand side. To add one: write its folder, and
//! add its line to [`methods`]. The engine builds them by [`FLUIDS`].
//!
//! A scheme is a [`Force`] between the particles of all fluids. A step of matter asks more of it than of other forces, by
//! [`FluidScheme`](forces::FluidScheme). [`particles`] has what schemes share.

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "references may be the C library's"))]

use glam::{DVec2, DVec3, Vec2, Vec3};

mod particles;
mod weakly_compressible;

use error::Result;
use forces::Force;
use forces::fluid::fluids;
use math::Vector;
use matter::Properties;
use parallel::Executor;
use particles::start::method;
use physcore_base::{error, history, ledger, math, parallel, scene, simd, stability};
use physcore_matter::catalog::{BuildFluids, FluidLaws, ForceLaws};
use physcore_matter::{boundaries, forces, matter, neighbors};
use scene::{Item, Scene};

/// Builds the force of a scheme, from the first fluid of a scene with the index of its body.
type BuildScheme<V> = fn(&Scene, (usize, &Item), &dyn ForceLaws, &Properties<V>, &Executor) -> Result<Box<dyn Force<V>>>;

/// The registry of methods: the name of each in the scene, and its scheme.
fn methods<V: Vector>() -> [(&'static str, BuildScheme<V>); 1] {
    [(weakly_compressible::NAME, weakly_compressible::build)]
}

/// Builds the fluids of a scene and their obstacles, if it has fluids, by the method in the record of the first. All fluids of a
/// scene have the same.
///
/// # Errors
/// If there is no such method, or a parameter is inconsistent.
fn build<V: Vector>(
    scene: &Scene,
    laws: &dyn ForceLaws,
    properties: &Properties<V>,
    executor: &Executor,
) -> Result<Option<Box<dyn Force<V>>>> {
    let Some(first) = fluids(scene).next() else { return Ok(None) };
    let method = method(first.1)?;
    let Some((_, scheme)) = methods().into_iter().find(|(name, _)| *name == method.kind) else {
        let known: Vec<_> = methods::<V>().iter().map(|(name, _)| *name).collect();
        return Err(scene::unknown(method, &known.join(", ")));
    };
    scheme(scene, first, laws, properties, executor).map(Some)
}

/// The fluids of this crate.
struct AllFluids;

/// All particle methods for fluids that scenes can declare.
pub const FLUIDS: &dyn FluidLaws = &AllFluids;

impl FluidLaws for AllFluids {}

macro_rules! compile_fluids {
    ($($vector:ty),+) => {
        $(impl BuildFluids<$vector> for AllFluids {
            fn build(
                &self,
                scene: &Scene,
                laws: &dyn ForceLaws,
                properties: &Properties<$vector>,
                executor: &Executor,
            ) -> Result<Option<Box<dyn Force<$vector>>>> {
                build(scene, laws, properties, executor)
            }
        })+
    };
}

compile_fluids!(Vec2, Vec3, DVec2, DVec3);

#[cfg(test)]
mod tests {
    use glam::DVec2;
    use physcore_forces::FORCES;

    use super::*;
    use crate::forces::fluid::KIND;
    use crate::parallel::SERIAL;
    use crate::scene::{Body, Value};

    #[test]
    fn an_unknown_method_is_refused_by_name_with_those_that_are_known() {
        let method = Item { path: "bodies[0].method".to_owned(), ..Item::new("Shallow", []) };
        let item = Item::new(KIND, [("method", Value::Record(Box::new(method)))]);
        let scene = Scene { dimension: 2, bodies: vec![Body { item, ..Body::default() }], ..Scene::default() };
        let properties = Properties::<DVec2>::new(Vec::new());
        let error = build(&scene, FORCES, &properties, &SERIAL).map(|_| ()).unwrap_err().to_string();
        assert_eq!(error, "bodies[0].method: expected WeaklyCompressible, got Shallow");
        assert!(build(&Scene::default(), FORCES, &properties, &SERIAL).unwrap().is_none());
    }
}
