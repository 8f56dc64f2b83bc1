//! Wind on the surfaces of rigid bodies: half of the law of a face at each patch.
//!
//! The law of a face is that of both its sides. A closed surface has a face for each side, so that a thin plate feels the same
//! force as a face. The sum over the patches of a body is its force, and the sum of their moments its torque.

use std::ops::Range;

use glam::{DMat3, DVec3};
use physcore_rigid::rotation::Inertia;
use physcore_rigid::shapes::{SolidShape, SurfacePatch};

use super::Air;
use crate::error::Result;
use crate::history::History;
use crate::math::Vector;
use crate::matter::{EnergySink, SolidMotion};
use crate::parallel::{BlockedSlice, Executor};
use crate::scene::{RIGID_BODIES, Scene};
use crate::simd::LANES;
use crate::stability::{Horizon, SpectralBound};
use crate::{About, Declared, Force, Rates, Reach, StateView, Validity, VelocityDependence};

/// Largest side of the pieces of a surface, over the distance of its farthest point from the center of mass.
const PIECE: f64 = 0.6;

/// Rigid body in the wind.
#[derive(Debug, Clone)]
struct Sail {
    /// Index among the rigid bodies.
    solid: usize,
    particle: usize,
    /// Its patches among those of all bodies.
    patches: Range<usize>,
    /// Largest inverse moment of inertia [1/(kg·m²)].
    inverse_moment: f64,
}

/// Force and torque of the wind on a body, with their powers.
#[derive(Debug, Clone, Copy, Default)]
struct WindLoad {
    force: DVec3,
    torque: DVec3,
    /// Dissipated power [W].
    lost: f64,
    /// Power of the wind [W].
    supplied: f64,
}

/// Wind on rigid bodies.
#[derive(Debug)]
pub(super) struct SolidWind {
    air: Air,
    sails: Vec<Sail>,
    /// Patches of the sails in the frames of their bodies, with half of their areas.
    patches: Vec<SurfacePatch>,
    loads: Vec<WindLoad>,
}

/// Patch in the world: its arm from the center of mass [m], half its area times its normal [m²], and its velocity [m/s].
struct MovingPatch {
    arm: DVec3,
    area: DVec3,
    velocity: DVec3,
}

impl SolidWind {
    /// Wind on the movable rigid bodies that an item names; None if there are none.
    ///
    /// # Errors
    /// If a value is wrong.
    pub fn new<V: Vector>(declared: &Declared<'_, V>) -> Result<Option<Self>> {
        let Declared { scene, item, properties, chosen, .. } = declared;
        let engine = properties.engine();
        let (mut sails, mut patches) = (Vec::new(), Vec::new());
        let named = declared.bodies();
        let is_named = named.iter().any(|&body| scene.bodies[body].item.kind == RIGID_BODIES);
        for body in named.into_iter().filter(|&body| scene.bodies[body].item.kind == RIGID_BODIES) {
            let (shape, mass) = SolidShape::declared(scene.bodies[body].item.record("shape")?, V::DIMENSION)?;
            let own = shape.patches(PIECE * shape.reach(), V::DIMENSION == 2);
            let unit = if V::DIMENSION == 2 { Inertia::planar(mass.inertia.z_axis.z) } else { Inertia::spatial(mass.inertia) };
            for row in 0..scene.bodies[body].positions.len() {
                let particle = engine[scene.first(body) + row] as usize;
                if chosen[particle] && !properties.is_fixed(particle) {
                    let first = patches.len();
                    patches.extend(own.iter().map(|patch| SurfacePatch { area: 0.5 * patch.area, ..*patch }));
                    let inverse_moment = unit.largest_inverse() * mass.size / properties.mass[particle];
                    let solid = solids_before(scene, body) + row;
                    sails.push(Sail { solid, particle, patches: first..patches.len(), inverse_moment });
                }
            }
        }
        let air = Air::declared(item, V::DIMENSION, patches.len())?;
        let loads = vec![WindLoad::default(); sails.len()];
        Ok(is_named.then_some(Self { air, sails, patches, loads }))
    }

    /// Patches of a body in the present state.
    fn moving<'a, V: Vector>(&'a self, sail: &'a Sail, at: &StateView<'_, V>) -> impl Iterator<Item = MovingPatch> + use<'a, V> {
        let SolidMotion { orientation, angular_velocity, .. } = at.solids[sail.solid];
        let (rotation, velocity) = (DMat3::from_quat(orientation), at.velocity.get(sail.particle).widen());
        self.patches[sail.patches.clone()].iter().map(move |patch| {
            let arm = rotation * patch.point;
            MovingPatch { arm, area: patch.area * (rotation * patch.normal), velocity: velocity + angular_velocity.cross(arm) }
        })
    }

    /// Positions of all patches [m].
    fn places<V: Vector>(&self, at: &StateView<'_, V>) -> Vec<DVec3> {
        let center = |sail: &Sail| at.properties.origin + at.exact_point(sail.particle);
        let of = |sail| self.moving(sail, at).map(move |patch| center(sail) + patch.arm);
        self.sails.iter().flat_map(of).collect()
    }

    /// Load of the wind on a body.
    fn load<V: Vector>(&self, sail: &Sail, at: &StateView<'_, V>) -> WindLoad {
        let mut load = WindLoad::default();
        for (patch, MovingPatch { arm, area, velocity }) in sail.patches.clone().zip(self.moving(sail, at)) {
            let wind = self.air.velocity.value(patch);
            let force = self.air.force(area, wind - velocity);
            load.force += force;
            load.torque += arm.cross(force);
            load.lost += force.dot(wind - velocity);
            load.supplied += force.dot(wind);
        }
        load
    }
}

/// Number of rigid bodies in the items before one.
fn solids_before(scene: &Scene, body: usize) -> usize {
    let rigid = scene.bodies[..body].iter().filter(|body| body.item.kind == RIGID_BODIES);
    rigid.map(|body| body.positions.len()).sum()
}

impl History for SolidWind {}

impl<V: Vector> Force<V> for SolidWind {
    fn about(&self) -> About {
        About {
            velocity: VelocityDependence::Dissipative,
            potential: None,
            callback: self.air.velocity.varies(),
            pairs: self.patches.len(),
            bytes: size_of_val(self.patches.as_slice()) + size_of_val(self.sails.as_slice()) + self.air.velocity.bytes(),
            layout: format!("{} points on the surfaces of {} rigid bodies", self.patches.len(), self.sails.len()),
            ..About::new("wind", Reach::Network)
        }
    }

    fn prepare(&mut self, at: &StateView<'_, V>, executor: &Executor) -> Result<()> {
        let places = if self.air.velocity.varies() { self.places(at) } else { Vec::new() };
        self.air.velocity.update(at.time, || places)?;
        let mut loads = std::mem::take(&mut self.loads);
        executor.for_each_block(BlockedSlice::new(&mut loads, 1), &|block: BlockedSlice<'_, WindLoad>| {
            for (index, load) in (block.start..).zip(block.items) {
                *load = self.load(&self.sails[index], at);
            }
        });
        self.loads = loads;
        executor.check()
    }

    fn accumulate(&self, block: Range<usize>, _at: &StateView<'_, V>, rates: &mut Rates<'_, V>) {
        for (sail, load) in self.sails.iter().zip(&self.loads).filter(|(sail, _)| block.contains(&sail.particle)) {
            let lane = sail.particle - block.start;
            rates.force.set(lane, rates.force.get(lane) + V::narrow(load.force));
            rates.power[EnergySink::Drag as usize][sail.particle % LANES] += load.lost;
            rates.power[EnergySink::Work as usize][sail.particle % LANES] += load.supplied;
        }
    }

    fn meets_solids(&self) -> bool {
        true
    }

    fn torques(&self, torques: &mut [DVec3]) {
        self.sails.iter().zip(&self.loads).for_each(|(sail, load)| torques[sail.solid] += load.torque);
    }

    /// A patch of damping c moves with its body by v + ω × a. The decay rate of the body is at most Σ c (1/m + a²/I), with the
    /// least moment of inertia I. A turn by δ turns the normals by δ, and changes a force by at most ½ ρ A r² (2 `C_n` + 3 `C_t`) δ.
    /// The arm of the force turns too.
    fn bound(&self, at: &StateView<'_, V>, bound: &mut SpectralBound) -> Result<()> {
        let velocity = self.air.velocity.with_gradients(at.time, || self.places(at))?;
        for sail in &self.sails {
            let (mut stiffness, mut damping) = (0.0, 0.0);
            let mass = at.properties.mass[sail.particle];
            for (patch, MovingPatch { arm, area, velocity: own }) in sail.patches.clone().zip(self.moving(sail, at)) {
                let (wind, gradient) = velocity.at(patch);
                let rate = self.air.rate(area, wind - own);
                let share = 1.0 + mass * sail.inverse_moment * arm.length_squared();
                let pressure = 0.5 * self.air.density * area.length() * (wind - own).length_squared();
                let turning = pressure * (3.0 * self.air.normal + 4.0 * self.air.tangential) * arm.length();
                damping += rate * share;
                stiffness += gradient * rate * share + mass * sail.inverse_moment * turning;
            }
            bound.point(sail.particle, "wind", stiffness, damping);
        }
        Ok(())
    }

    fn validity(&self, _at: &StateView<'_, V>, _horizon: Horizon) -> Validity {
        if self.sails.is_empty() { Validity::Always } else { Validity::Now }
    }
}
