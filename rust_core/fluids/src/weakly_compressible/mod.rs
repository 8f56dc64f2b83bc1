//! Weakly compressible fluids: smoothed particle hydrodynamics (SPH) with an equation of state.
//!
//! Density is a state variable. A step of drifts and kicks has a pair sum for each. The continuity equation advances density in
//! the middle of a drift ([`density`]). Pressure forces act at each kick ([`momentum`]). Density and velocity alternate like
//! position and velocity. A kick–drift–kick step may therefore be as long as that of a leapfrog: 2/ω for the fastest sound wave,
//! twice the limit for simultaneous rates.
//!
//! For density by summation ([`summation`]) both sums are evaluated at the kick, with any integrator.
//!
//! The pair laws of both sums are in [`laws`]. Free surfaces raise the frequency of sound and let go of walls ([`surface`]).
//! Particle shifting ([`shifting`]) restores even particle distributions. The parameters of the scene are completed in
//! [`parameters`], with the speed of sound ([`sound`]) and the equation of state ([`equation_of_state`]). The force is constructed
//! in [`assembly`], and [`limits`] bound its time step. All else is shared with other methods: see [`crate::particles`].

use crate::ForceLaws;
use crate::error::Result;
use crate::forces::Force;
use crate::history::{Archive, History};
use crate::math::Vector;
use crate::matter::Properties;
use crate::neighbors::NeighborList;
use crate::neighbors::sums::Records;
use crate::parallel::Executor;
use crate::particles::kernel::{KernelShape, OtherShape, WendlandC2};
use crate::particles::obstacles::Obstacles;
use crate::particles::solids::Solids;
use crate::particles::start::method;
use crate::particles::tension::Tension;
use crate::particles::walls::FluidWalls;
use crate::particles::waves::FluidWave;
use crate::particles::{Gauges, Materials};
use crate::scene::{self, Item, Scene};
use equation_of_state::CompressibleFluid;
use laws::{Continuity, FORCES, Momentum, RATES};
use parameters::FluidParameters;
use shifting::Shifting;
use summation::Summation;
use surface::SurfaceEffects;

mod assembly;
mod density;
mod equation_of_state;
mod laws;
mod limits;
mod momentum;
mod parameters;
mod shifting;
mod solids;
mod sound;
mod summation;
mod surface;

/// Name of the method in the scene.
pub const NAME: &str = "WeaklyCompressible";

/// Force of the fluids of a scene and their obstacles. The first fluid is given with the index of its body.
///
/// # Errors
/// If their parameters are inconsistent, or there is no kernel of that name.
pub fn build<V: Vector>(
    scene: &Scene,
    first: (usize, &Item),
    laws: &dyn ForceLaws,
    properties: &Properties<V>,
    executor: &Executor,
) -> Result<Box<dyn Force<V>>> {
    let parameters = FluidParameters::of(scene, laws, first)?;
    let kernel = method(first.1)?.record("kernel")?;
    match kernel.kind.as_str() {
        "WendlandC2" if !parameters.materials.are_mixed() => {
            with::<V, _, false>(WendlandC2, scene, properties, parameters, executor)
        }
        "WendlandC2" => with::<V, _, true>(WendlandC2, scene, properties, parameters, executor),
        "WendlandC4" => with::<V, _, true>(OtherShape::WendlandC4, scene, properties, parameters, executor),
        "CubicSpline" => with::<V, _, true>(OtherShape::CubicSpline, scene, properties, parameters, executor),
        _ => Err(scene::unknown(kernel, "WendlandC2, WendlandC4 or CubicSpline")),
    }
}

fn with<V: Vector, K: KernelShape, const MIXED: bool>(
    shape: K,
    scene: &Scene,
    properties: &Properties<V>,
    parameters: FluidParameters,
    executor: &Executor,
) -> Result<Box<dyn Force<V>>> {
    Ok(Box::new(WeaklyCompressible::<V, K, MIXED>::new(shape, scene, properties, parameters, executor)?))
}

/// Force on the particles of all fluids and obstacles.
struct WeaklyCompressible<V: Vector, K, const MIXED: bool> {
    materials: Materials,
    /// Fluid of each material.
    fluids: Vec<CompressibleFluid>,
    /// Remarks in the plan.
    remarks: Vec<String>,
    /// Material of each member.
    kind: Vec<u8>,
    /// Mass m of each member [kg]; for an obstacle, the mass of the fluid in its volume.
    mass: Vec<f64>,
    /// Density ρ of each member [kg/m³].
    density: Vec<f64>,
    /// Energy dissipated by diffusion in the last drift, of each member [J].
    diffused: Vec<f64>,
    /// Density at the start of the batch [kg/m³].
    saved_density: Vec<f64>,
    obstacles: Obstacles<V, K>,
    solids: Solids,
    neighbor_list: NeighborList,
    records: Records<V>,
    continuity: Continuity<V::Scalar, K, MIXED>,
    momentum: Momentum<V::Scalar, K, MIXED>,
    /// Density by summation, if that is the scheme.
    summation: Option<Summation<V, K>>,
    /// Surface tension, if a fluid has it.
    tension: Option<Tension<V, K, MIXED>>,
    /// Particle shifting, if enabled.
    shifting: Option<Shifting<V, K>>,
    /// Sums of [`Continuity`] by slot: over particles, and over their images if there are walls.
    rates: Vec<[V::Scalar; RATES]>,
    mirrored: Vec<[V::Scalar; RATES]>,
    /// Sums of [`Momentum`] by slot: force and power densities.
    forces: Vec<[V::Scalar; FORCES]>,
    walls: FluidWalls,
    /// Gauges, if there are any.
    gauges: Option<Gauges>,
    surface: SurfaceEffects<V, K>,
    /// Waves resolved by the kernel, for unit smoothing length.
    waves: &'static [FluidWave],
    /// Largest force density [N/m^D] if the present sums are not those of the state, and its value at the start of the batch.
    strongest: Option<f64>,
    saved_strongest: f64,
}

impl<V: Vector, K: KernelShape, const MIXED: bool> WeaklyCompressible<V, K, MIXED> {
    /// Fluid of a material number; None for obstacles.
    #[inline(always)]
    fn fluid(&self, kind: u8) -> Option<&CompressibleFluid> {
        self.fluids.get(usize::from(kind))
    }

    /// Volume V of a member [m^D]; for density by summation, its rest volume.
    fn volume(&self, member: usize) -> f64 {
        let summed = self.summation.is_some();
        self.mass[member] / if summed { self.materials.rest_density(self.kind[member]) } else { self.density[member] }
    }

    /// Rest volume V₀ of a member [m^D].
    fn rest_volume(&self, member: usize) -> f64 {
        self.mass[member] / self.materials.rest_density(self.kind[member])
    }

    /// Updates the neighbor lists and the lists of images. `position` returns the position of a particle along an axis [m];
    /// samples have theirs.
    fn search(&mut self, position: &(impl Fn(usize, usize) -> f64 + Sync), executor: &Executor) -> Result<()> {
        let solids = &self.solids;
        let position = |axis: usize, index: usize| solids.position(axis, index, position);
        let renewed = self.walls.search(&mut self.neighbor_list, &position, executor)?;
        self.surface.is_stale |= renewed;
        Ok(())
    }

    /// Memory [bytes].
    fn bytes(&self) -> usize {
        let rates = std::mem::size_of_val(self.rates.as_slice()) + std::mem::size_of_val(self.mirrored.as_slice());
        let own = rates + std::mem::size_of_val(self.forces.as_slice());
        let numbers = 4 * size_of::<f64>() * self.density.len();
        let indices = self.obstacles.bytes() + self.solids.bytes() + self.kind.len();
        let counts = self.summation.as_ref().map_or(0, Summation::bytes);
        let pulls = self.tension.as_ref().map_or(0, Tension::bytes) + self.shifting.as_ref().map_or(0, Shifting::bytes);
        let parts = self.neighbor_list.bytes() + self.records.bytes() + self.walls.bytes() + self.surface.bytes();
        counts + pulls + parts + own + numbers + indices + self.gauges.as_ref().map_or(0, Gauges::bytes)
    }
}

impl<V: Vector, K: KernelShape, const MIXED: bool> History for WeaklyCompressible<V, K, MIXED> {
    fn save(&mut self) {
        self.neighbor_list.save();
        self.saved_density.copy_from_slice(&self.density);
        self.surface.save();
        self.gauges.iter_mut().for_each(History::save);
        self.saved_strongest = self.strongest();
    }

    fn rollback(&mut self) {
        self.density.copy_from_slice(&self.saved_density);
        self.surface.rollback();
        self.gauges.iter_mut().for_each(History::rollback);
        self.strongest = Some(self.saved_strongest);
        self.neighbor_list.rollback();
    }

    fn capture(&self, archive: &mut Archive) {
        archive.write("densities", self.density.iter().copied());
        archive.write("strongest", [self.strongest()]);
        archive.within("surface", |archive| self.surface.capture(archive));
        self.gauges.iter().for_each(|gauges| archive.within("gauges", |archive| gauges.capture(archive)));
        self.neighbor_list.capture(archive);
    }

    fn restore(&mut self, archive: &mut Archive) -> Result<()> {
        archive.read_into("densities", &mut self.density)?;
        self.strongest = Some(archive.read_number("strongest")?);
        archive.within("surface", |archive| self.surface.restore(archive))?;
        self.gauges.iter_mut().try_for_each(|gauges| archive.within("gauges", |archive| gauges.restore(archive)))?;
        self.neighbor_list.restore(archive)
    }
}
