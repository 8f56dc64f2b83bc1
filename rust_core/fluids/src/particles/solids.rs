//! Rigid bodies in a fluid, by samples of their volume near the surface.
//!
//! Samples are obstacles that move with their body. The volume of a sample is that of a cell of the body. Fluid then meets the
//! density at rest behind a flat wall, and a body displaces its volume. The force on each sample acts on the body at the
//! place of the sample. Fluid and samples push each other with opposite forces, so that momentum is kept.

use std::ops::Range;

use glam::{DMat3, DVec3};
use physcore_rigid::rotation::Orientation;
use physcore_rigid::shapes::{MassProperties, ShapeSamples, SolidShape, VolumeSample};

use super::material::Materials;
use crate::error::{Error, Result};
use crate::forces::fluid;
use crate::math::{Real, Vector};
use crate::matter::{Properties, View};
use crate::scene::{Item, RIGID_BODIES, Scene};

/// Number of powers of a load: viscous, and against the pressure of obstacles.
pub const POWERS: usize = 2;

/// Mean thickness of a body in units of the support radius of the kernel, below which fluid on its two sides meets through it.
const THIN: f64 = 0.5;

/// Force of the fluid on a sample or a body.
#[derive(Debug, Clone, Copy, Default)]
pub struct SolidLoad {
    /// Force [N].
    pub force: DVec3,
    /// Torque about the center of the body [N·m].
    pub torque: DVec3,
    /// Dissipated powers [W].
    pub powers: [f64; POWERS],
}

/// Rigid body with its samples.
#[derive(Debug)]
pub struct SampledBody {
    /// Index among the rigid bodies of the scene.
    pub solid: usize,
    /// Particle at the center of mass.
    pub particle: u32,
    samples: Range<usize>,
    /// Volume of the fluid that moves with the samples, as a bound for translation and rotation [m^D].
    pub moved: f64,
    /// Force of the fluid.
    pub load: SolidLoad,
}

/// Place and motion of the frame of a body. A point p of the body is at center + rotation p, with velocity + rate p.
#[derive(Debug, Clone, Copy)]
pub struct SolidFrame {
    /// Position of the center relative to the origin [m], and its velocity [m/s].
    pub center: DVec3,
    pub velocity: DVec3,
    /// Matrix from points of the body to vectors from its center, and its rate of change [1/s].
    pub rotation: DMat3,
    pub rate: DMat3,
}

impl SolidFrame {
    fn sample(&self, sample: &VolumeSample) -> SampleMotion {
        let arm = self.rotation * sample.point;
        SampleMotion { position: self.center + arm, arm, velocity: self.velocity + self.rate * sample.point }
    }
}

/// Place and motion of a sample.
#[derive(Debug, Clone, Copy, Default)]
struct SampleMotion {
    /// Position relative to the origin [m].
    position: DVec3,
    /// Vector from the center of the body [m].
    arm: DVec3,
    /// Velocity [m/s].
    velocity: DVec3,
}

/// Rigid bodies that meet the fluids of a scene.
#[derive(Debug, Default)]
pub struct Solids {
    /// Number of particles. The samples have the indices after them.
    particles: usize,
    /// Samples of all bodies, each in the frame of its body.
    samples: Vec<VolumeSample>,
    motions: Vec<SampleMotion>,
    bodies: Vec<SampledBody>,
    /// Remarks in the plan.
    pub remarks: Vec<String>,
}

/// Shape of a body with its samples.
struct SampledShape {
    shape: SolidShape,
    samples: Vec<VolumeSample>,
    moved: f64,
    thickness: f64,
}

impl SampledShape {
    fn new(item: &Item, scene: &Scene, materials: &Materials) -> Result<Self> {
        let (dimension, fluid) = (scene.dimension, materials.first());
        let (shape, mass) = SolidShape::declared(item.record("shape")?, dimension)?;
        let depth = 2.0 * fluid.smoothing_length + fluid.spacing;
        let Some(ShapeSamples { samples, surface }) = shape.samples(mass.size, fluid.spacing, depth, dimension) else {
            let found = format!("a reach of {:.3e} m in a fluid with a spacing of {:.3e} m", shape.reach(), fluid.spacing);
            return Err(Error::parameter(item.path_of("shape"), "a shape with fewer samples of its surface", found)
                .with_hint("take a coarser fluid, smaller bodies, or Fluid(…, obstacles=False)"));
        };
        Ok(Self { moved: moved(&samples, &mass, dimension), thickness: 2.0 * mass.size / surface, samples, shape })
    }
}

/// Largest ratio of the inertia of samples to that of their body at unit density, times its size [m^D]. The ratio of moments of
/// inertia is bounded by the row sums of I⁻¹ Σ V (r² − r rᵀ).
fn moved(samples: &[VolumeSample], mass: &MassProperties, dimension: usize) -> f64 {
    let (mut volume, mut moments) = (0.0, DMat3::ZERO);
    for VolumeSample { point, volume: of_sample } in samples {
        volume += of_sample;
        let outer = DMat3::from_cols(*point * point.x, *point * point.y, *point * point.z);
        moments += (DMat3::from_diagonal(DVec3::splat(point.length_squared())) - outer) * *of_sample;
    }
    let turned = if dimension == 2 {
        moments.z_axis.z / mass.inertia.z_axis.z
    } else {
        let ratio = mass.inertia.inverse() * moments;
        let row = |axis: usize| ratio.row(axis).abs().element_sum();
        row(0).max(row(1)).max(row(2))
    };
    volume.max(turned * mass.size)
}

/// Particles of the fluids that meet rigid bodies.
struct WetPoints<'a> {
    fluids: Vec<(&'a Item, &'a [DVec3])>,
}

impl<'a> WetPoints<'a> {
    fn of(scene: &'a Scene) -> Result<Self> {
        let mut fluids = Vec::new();
        for (body, item) in fluid::fluids(scene) {
            if item.flag("obstacles")? {
                fluids.push((item, &*scene.bodies[body].positions));
            }
        }
        Ok(Self { fluids })
    }

    /// Refuses fluid in bodies of a shape at these positions and orientations.
    fn refuse_inside<'b>(
        &self,
        item: &Item,
        shape: &SolidShape,
        bodies: &(impl Iterator<Item = (&'b DVec3, &'b Orientation)> + Clone),
    ) -> Result<()> {
        let places = bodies.clone().map(|(center, turn)| (*center, turn.quaternion));
        for (fluid, points) in &self.fluids {
            let inside = points.iter().filter(|point| shape.contains_at(places.clone(), **point)).count();
            if inside > 0 {
                let found = format!("{inside} of {} particles in {}", points.len(), item.path);
                return Err(Error::parameter(format!("{}.positions", fluid.path), "fluid outside of rigid bodies", found)
                    .with_hint("leave them out: positions[~body.contains(positions)]"));
            }
        }
        Ok(())
    }
}

impl Solids {
    /// Rigid bodies of a scene, if a fluid of these materials meets them.
    ///
    /// # Errors
    /// If fluid is within a body, or a shape has too many samples.
    pub fn declared<V: Vector>(scene: &Scene, properties: &Properties<V>, materials: &Materials) -> Result<Self> {
        let mut solids = Self { particles: properties.count(), ..Self::default() };
        if !materials.meet_solids {
            return Ok(solids);
        }
        let wet = WetPoints::of(scene)?;
        let (engine, mut solid) = (properties.engine(), 0);
        let rigid = scene.bodies.iter().enumerate().filter(|(_, body)| body.item.kind == RIGID_BODIES);
        for (index, body) in rigid {
            let count = body.positions.len();
            let shape = SampledShape::new(&body.item, scene, materials)?;
            let orientations = Orientation::declared(&body.item, count, scene.dimension)?;
            solids.remark(index, &shape, materials);
            wet.refuse_inside(&body.item, &shape.shape, &body.positions.iter().zip(&orientations))?;
            let first = scene.first(index);
            for (row, orientation) in orientations.iter().enumerate() {
                let start = solids.samples.len();
                let center = body.positions[row] - properties.origin;
                let motion = |sample: &VolumeSample| {
                    let arm = orientation.matrix() * sample.point;
                    SampleMotion { position: center + arm, arm, velocity: DVec3::ZERO }
                };
                solids.motions.extend(shape.samples.iter().map(motion));
                solids.samples.extend(&shape.samples);
                solids.bodies.push(SampledBody {
                    solid,
                    particle: engine[first + row],
                    samples: start..solids.samples.len(),
                    moved: shape.moved,
                    load: SolidLoad::default(),
                });
                solid += 1;
            }
        }
        Ok(solids)
    }

    /// Adds a remark on a body that is thin in units of the support radius.
    fn remark(&mut self, body: usize, shape: &SampledShape, materials: &Materials) {
        let fluid = materials.first();
        let least = THIN * 2.0 * fluid.smoothing_length;
        if shape.thickness < least {
            self.remarks.push(format!(
                "bodies[{body}]: {:.2e} m thick on average (2 volume/surface), and fluid on its two sides meets through less than \
                 {least:.2e} m; a spacing of {:.2e} m or a thicker body keeps it apart",
                shape.thickness,
                fluid.spacing * shape.thickness / least,
            ));
        }
    }

    /// Number of samples.
    #[inline]
    pub fn count(&self) -> usize {
        self.samples.len()
    }

    /// Bodies.
    #[inline]
    pub fn bodies(&self) -> &[SampledBody] {
        &self.bodies
    }

    /// Number of the sample with an index among particles and samples; None for a particle.
    #[inline(always)]
    pub fn sample(&self, index: usize) -> Option<usize> {
        index.checked_sub(self.particles)
    }

    /// Particle at the center of the body of a sample.
    pub fn owner(&self, sample: usize) -> u32 {
        let body = self.bodies.partition_point(|body| body.samples.end <= sample);
        self.bodies[body].particle
    }

    /// Volume of each sample [m^D].
    pub fn volumes(&self) -> impl Iterator<Item = f64> {
        self.samples.iter().map(|sample| sample.volume)
    }

    /// Position of a particle along an axis, by `particle`, or of a sample, relative to the origin [m].
    #[inline(always)]
    pub fn position(&self, axis: usize, index: usize, particle: impl Fn(usize, usize) -> f64) -> f64 {
        match self.sample(index) {
            Some(sample) => self.motions[sample].position[axis],
            None => particle(axis, index),
        }
    }

    /// Velocity of each particle, or of each sample, along an axis [m/s].
    pub fn velocities<'a, V: Vector>(&'a self, particles: &View<'a, V>) -> impl Fn(usize, usize) -> V::Scalar + Sync {
        let particles = *particles;
        move |axis, index| match self.sample(index) {
            Some(sample) => V::Scalar::from_f64(self.motions[sample].velocity[axis]),
            None => particles.axis(axis)[index],
        }
    }

    /// Moves the samples with their bodies, given the motion of each.
    pub fn place(&mut self, motion: impl Fn(&SampledBody) -> SolidFrame) {
        let Self { samples, motions, bodies, .. } = self;
        for body in bodies {
            let (frame, range) = (motion(body), body.samples.clone());
            motions[range.clone()].iter_mut().zip(&samples[range]).for_each(|(to, sample)| *to = frame.sample(sample));
        }
    }

    /// Sums the forces on the samples of each body. `load` returns the force and the powers of a sample.
    pub fn sum(&mut self, load: impl Fn(usize) -> (DVec3, [f64; POWERS])) {
        let Self { motions, bodies, .. } = self;
        for body in bodies {
            body.load = SolidLoad::default();
            for sample in body.samples.clone() {
                let (force, powers) = load(sample);
                body.load.force += force;
                body.load.torque += motions[sample].arm.cross(force);
                (0..POWERS).for_each(|kind| body.load.powers[kind] += powers[kind]);
            }
        }
    }

    /// Positions of the samples for a motion of each body, relative to the origin [m].
    pub fn positions(&self, motion: impl Fn(&SampledBody) -> SolidFrame) -> Vec<DVec3> {
        let place = |body: &SampledBody| {
            let frame = motion(body);
            self.samples[body.samples.clone()].iter().map(move |sample| frame.sample(sample).position)
        };
        self.bodies.iter().flat_map(place).collect()
    }

    /// Adds the torque on each body about its center [N·m].
    pub fn add_torques(&self, torques: &mut [DVec3]) {
        self.bodies.iter().for_each(|body| torques[body.solid] += body.load.torque);
    }

    /// Memory [bytes].
    #[inline]
    pub fn bytes(&self) -> usize {
        size_of_val(self.samples.as_slice()) + size_of_val(self.motions.as_slice()) + size_of_val(self.bodies.as_slice())
    }
}
