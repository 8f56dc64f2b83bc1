//! Methods for fluids, one folder each: a scheme is its state and its right-hand side. To add one: write its folder, and add its
//! line to [`methods`].
//!
//! A scheme is a [`Force`] between the particles of all fluids. A step of matter asks more of it than of other forces, by
//! [`crate::forces::FluidScheme`]. [`crate::particles`] has what schemes share.

use crate::error::Result;
use crate::forces::Force;
use crate::math::Vector;
use crate::matter::Properties;
use crate::parallel::Executor;
pub use crate::particles::start::{KIND, is_in};
use crate::particles::start::{fluids, method};
use crate::scene::{self, Item, Scene};

mod weakly_compressible;

/// Builds the force of a scheme, from the first fluid of a scene with the index of its body.
type BuildScheme<V> = fn(&Scene, (usize, &Item), &Properties<V>, &Executor) -> Result<Box<dyn Force<V>>>;

/// The registry of methods: the name of each in the scene, and its scheme.
fn methods<V: Vector>() -> [(&'static str, BuildScheme<V>); 1] {
    [(weakly_compressible::NAME, weakly_compressible::build)]
}

/// Builds the fluids of a scene and their obstacles, if it has fluids, by the method in the record of the first. All fluids of a
/// scene have the same.
///
/// # Errors
/// If there is no such method, or a parameter is inconsistent.
pub(crate) fn build<V: Vector>(
    scene: &Scene,
    properties: &Properties<V>,
    executor: &Executor,
) -> Result<Option<Box<dyn Force<V>>>> {
    let Some(first) = fluids(scene).next() else { return Ok(None) };
    let method = method(first.1)?;
    let Some((_, scheme)) = methods().into_iter().find(|(name, _)| *name == method.kind) else {
        let known: Vec<_> = methods::<V>().iter().map(|(name, _)| *name).collect();
        return Err(scene::unknown(method, &known.join(", ")));
    };
    scheme(scene, first, properties, executor).map(Some)
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;
    use crate::parallel::SERIAL;
    use crate::scene::{Body, Value};

    #[test]
    fn an_unknown_method_is_refused_by_name_with_those_that_are_known() {
        let method = Item { path: "bodies[0].method".to_owned(), ..Item::new("Shallow", []) };
        let item = Item::new(KIND, [("method", Value::Record(Box::new(method)))]);
        let scene = Scene { dimension: 2, bodies: vec![Body { item, ..Body::default() }], ..Scene::default() };
        let properties = Properties::<DVec2>::new(Vec::new());
        let error = build(&scene, &properties, &SERIAL).map(|_| ()).unwrap_err().to_string();
        assert_eq!(error, "bodies[0].method: expected WeaklyCompressible, got Shallow");
        assert!(build(&Scene::default(), &properties, &SERIAL).unwrap().is_none());
    }
}
