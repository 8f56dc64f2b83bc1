//! Systems of a scene.
//!
//! To add a system, create its folder, here or in the crate of fields on grids, and its line in [`build`]. A
//! [simulation](crate::simulation) is a clock, a divergence monitor and a ledger over a system, independent of particles.

pub mod matter;
pub mod several;
pub mod tracers;

use std::collections::BTreeMap;

use crate::catalog::Catalog;
use crate::error::{Error, Result};
use crate::integrators::{first_order, with_integrator};
use crate::parallel::{Executor, SERIAL};
use crate::scene::{self, Item, Scene};
pub use physcore_base::systems::*;
use physcore_fields::{reaction_diffusion, schrodinger, wave};
use several::Several;
use tracers::coupling::VortexCoupling;

/// Builds the systems of a scene as one, in `f32` or `f64`. If there are bodies, they form a system of matter, advanced by
/// `method`. Further systems are those that items declare. The map `methods` gives their methods by name; the default is
/// `method`.
///
/// # Errors
/// If the scene or the numerics are invalid or do not fit into memory, or on an interrupt.
pub fn build(
    scene: &Scene,
    (method, methods): (&Item, &BTreeMap<String, Item>),
    precision: &str,
    catalog: Catalog,
    executor: &Executor,
) -> Result<Box<dyn System>> {
    let mut parts = Vec::new();
    if !scene.bodies.is_empty() || scene.systems.is_empty() {
        parts.push(SystemPart { name: String::new(), system: matter::build(scene, method, precision, catalog, executor)? });
    }
    let own = |item: &Item| methods.get(item.name.as_ref().unwrap_or(&item.path)).unwrap_or(method);
    let mut couplings: Vec<Box<dyn Coupling>> = Vec::new();
    for (index, item) in scene.systems.iter().enumerate().filter(|(_, item)| tracers::flow_of(item).is_none()) {
        let leader = parts.len();
        parts.push(declared(item, None, own(item), precision, executor)?);
        for tracers in scene.systems.iter().filter(|other| tracers::flow_of(other) == Some(index)) {
            if own(tracers) != own(item) {
                let (path, found) = (format!("integrator of {}", tracers.path), &own(tracers).kind);
                return Err(Error::parameter(path, format!("{}, that of {}", own(item).kind, item.path), found)
                    .with_hint("they are advanced in the same stages"));
            }
            couplings.push(match precision {
                "f32" => Box::new(VortexCoupling::<f32>::new(leader, parts.len())),
                _ => Box::new(VortexCoupling::<f64>::new(leader, parts.len())),
            });
            parts.push(declared(tracers, Some(item), own(item), precision, executor)?);
        }
    }
    Ok(match <[SystemPart; 1]>::try_from(parts) {
        Ok([SystemPart { name, system }]) if name.is_empty() => system,
        Ok([part]) => Box::new(Several::new(vec![part], couplings)),
        Err(parts) => Box::new(Several::new(parts, couplings)),
    })
}

/// Kind of all bodies together, for [`advances`].
pub const BODIES: &str = "bodies";

/// Whether a method can advance items of a kind: a kind of system, or [`BODIES`]. [`build`] refuses other methods; what else is
/// in a scene can exclude more.
pub fn advances(kind: &str, method: &Item, catalog: Catalog) -> bool {
    let name = method.kind.as_str();
    match kind {
        BODIES => matter::build(&Scene { dimension: 2, ..Scene::default() }, method, "f64", catalog, &SERIAL).is_ok(),
        "Wave" => wave::advances(name),
        "Schrodinger" => schrodinger::METHODS.contains(&name),
        "ReactionDiffusion" | "Tracers" | "PointVortices" => first_order::NAMES.contains(&name),
        _ => false,
    }
}

/// Builds the system that an item declares, by a method; tracers perhaps in the flow of another item. Registry of systems.
fn declared(item: &Item, flow: Option<&Item>, method: &Item, precision: &str, _executor: &Executor) -> Result<SystemPart> {
    let system = match item.kind.as_str() {
        "Wave" if !wave::advances(&method.kind) => Err(unknown_integrator(method)),
        "Wave" => with_integrator!(method.kind.as_str(), I => wave::build::<I>(item, precision), Err(unknown_integrator(method))),
        "ReactionDiffusion" => reaction_diffusion::build(item, method, precision),
        "Schrodinger" => schrodinger::build(item, method, precision),
        "Tracers" | "PointVortices" => tracers::build(item, flow, method, precision),
        _ => Err(scene::unknown(item, "a kind of system")),
    };
    Ok(SystemPart { name: item.name.clone().unwrap_or_else(|| item.path.clone()), system: system? })
}

/// Error for an unknown integrator.
fn unknown_integrator(method: &Item) -> Error {
    Error::parameter("integrator", "the name of an integrator", &method.kind)
}
