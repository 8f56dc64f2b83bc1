//! What a scene leaves open about its fluid: gravity, the speed of sound, walls, and the density to start with.

use glam::DVec3;

use super::images::Mirror;
use crate::boundaries::{self, Wall};
use crate::error::{Error, Result};
use crate::math::{Real, Vector};
use crate::matter::Properties;
use crate::scene::Scene;

/// The exponent γ of the equation of state.
const GAMMA: i32 = 7;

/// The speed of sound in units of the fastest flow: density then varies by some (1/10)² = 1 %.
const SOUND: f64 = 10.0;

/// What the fluid is made of.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Mass of a particle m = ρ₀ Δ^D [kg].
    pub mass: f64,
    /// Density at rest ρ₀ [kg/m³].
    pub density: f64,
    /// Speed of sound c at rest [m/s].
    pub sound_speed: f64,
    /// Smoothing length h [m].
    pub smoothing_length: f64,
    /// Distance of particles at rest Δ [m].
    pub spacing: f64,
    /// Dynamic viscosity μ [Pa·s].
    pub viscosity: f64,
    /// The coefficient α of the artificial viscosity.
    pub artificial_viscosity: f64,
    /// The coefficient δ of the diffusion of density.
    pub density_diffusion: f64,
    /// Gravity g [m/s²].
    pub gravity: DVec3,
}

impl Material {
    /// The pressure at a density [Pa]: p = c²ρ₀/γ ((ρ/ρ₀)^γ − 1), of R. H. Cole, Underwater Explosions (1948).
    #[inline(always)]
    pub fn pressure(&self, density: f64) -> f64 {
        let ratio = density / self.density;
        let cube = ratio * ratio * ratio;
        self.stiffness() * (cube * cube * ratio - 1.0)
    }

    /// The density at a pressure [kg/m³].
    pub fn density_under(&self, pressure: f64) -> f64 {
        self.density * libm::pow(1.0 + pressure / self.stiffness(), 1.0 / f64::from(GAMMA))
    }

    /// The energy of compression per mass [J/kg]: ∫ p/ρ² dρ from ρ₀, that is c²/γ [s^(γ−1)/(γ−1) + 1/s − γ/(γ−1)], s = ρ/ρ₀.
    pub fn energy(&self, density: f64) -> f64 {
        let ratio = density / self.density;
        let sixth = ratio.powi(GAMMA - 1);
        self.sound_speed.powi(2) / 7.0 * (sixth / 6.0 + 1.0 / ratio - 7.0 / 6.0)
    }

    /// The speed of sound at a density [m/s].
    pub fn sound_at(&self, density: f64) -> f64 {
        self.sound_speed * (density / self.density).powi((GAMMA - 1) / 2)
    }

    /// What multiplies v·d/(d² + 0.01h²) ∇W in a pair: 2(D+2) μ + αhcρ₀ [Pa·s].
    pub fn viscosity_of_pairs(&self, dimension: usize) -> f64 {
        let artificial = self.artificial_viscosity * self.smoothing_length * self.sound_speed * self.density;
        2.0 * (dimension as f64 + 2.0) * self.viscosity + artificial
    }

    /// c²ρ₀/γ [Pa].
    #[inline(always)]
    fn stiffness(&self) -> f64 {
        self.sound_speed * self.sound_speed * self.density / f64::from(GAMMA)
    }
}

/// A wall, and whether the fluid sticks to it.
#[derive(Debug, Clone)]
pub struct Side {
    pub wall: Wall,
    pub sticks: bool,
}

impl Side {
    /// The wall as a particle at `x` sees it within `reach`, and its normal.
    pub fn mirror<V: Vector>(&self, x: DVec3, reach: f64, material: &Material) -> Option<(DVec3, Mirror<V::Scalar>)> {
        let (distance, normal) = self.wall.distance(x);
        let components = normal.to_array();
        (distance < reach).then(|| {
            let mirror = Mirror {
                normal: components.map(V::Scalar::from_f64),
                distance: V::Scalar::from_f64(distance),
                weight: V::Scalar::from_f64(-material.density * material.gravity.dot(normal)),
                sticks: if self.sticks { V::Scalar::ONE } else { V::Scalar::ZERO },
            };
            (normal, mirror)
        })
    }
}

/// Whether two walls with these normals meet in a corner, where images are mirrored again. Walls that face each other, or go
/// on as one, do not.
pub fn meet(one: DVec3, other: DVec3) -> bool {
    one.dot(other).abs() < 0.5
}

/// The walls that hold the fluid, relative to an origin.
pub fn walls(scene: &Scene, origin: DVec3) -> Result<Vec<Side>> {
    let mut walls = Vec::new();
    for term in scene.boundaries.iter().filter(|term| fluids(scene).any(|body| term.acts_on(body))) {
        let sticks = if term.values.contains_key("no_slip") { term.flag("no_slip")? } else { false };
        let boundary = boundaries::build(term, scene.dimension, origin)?;
        walls.extend(boundary.walls().iter().map(|&wall| Side { wall, sticks }));
    }
    Ok(walls)
}

/// The indices of the bodies that are fluids.
fn fluids(scene: &Scene) -> impl Iterator<Item = usize> {
    (0..scene.bodies.len()).filter(|&body| scene.bodies[body].fluid.is_some())
}

impl Material {
    /// That of the fluids of a scene, which are all of one kind.
    ///
    /// # Errors
    /// If they are not, or the speed of sound can neither be found nor is given.
    pub fn of(scene: &Scene) -> Result<Self> {
        let all: Vec<usize> = fluids(scene).collect();
        let of = |body: usize| scene.bodies[body].fluid.as_ref();
        let Some((&first, rest)) = all.split_first() else { return Err(Error::parameter("bodies", "a fluid", "none")) };
        let Some(fluid) = of(first) else { return Err(Error::parameter("bodies", "a fluid", "none")) };
        if let Some(&other) = rest.iter().find(|&&other| of(other) != Some(fluid)) {
            let expected = format!("the same material, kernel and spacing as bodies[{first}]");
            return Err(Error::parameter(format!("bodies[{other}]"), expected, "another")
                .with_hint("all fluids of a scene are one kind of fluid"));
        }
        let gravity = scene.forces.iter().filter(|term| term.kind == "Gravity" && term.acts_on(first));
        let gravity = gravity.map(|term| term.vector("acceleration")).sum::<Result<DVec3>>()?;
        let mut material = Self {
            mass: fluid.density * if scene.dimension == 2 { fluid.spacing.powi(2) } else { fluid.spacing.powi(3) },
            density: fluid.density,
            sound_speed: fluid.sound_speed.unwrap_or(0.0),
            smoothing_length: fluid.smoothing * fluid.spacing,
            spacing: fluid.spacing,
            viscosity: fluid.viscosity,
            artificial_viscosity: fluid.artificial_viscosity,
            density_diffusion: fluid.density_diffusion,
            gravity,
        };
        if fluid.sound_speed.is_none() {
            material.sound_speed = SOUND * fastest(scene, first, gravity)?;
        }
        Ok(material)
    }
}

/// The fastest flow that is to be expected [m/s]: that of the start, or of a fall from the highest fluid to the lowest wall
/// below any of it.
fn fastest(scene: &Scene, first: usize, gravity: DVec3) -> Result<f64> {
    let bodies = || fluids(scene).map(|body| &scene.bodies[body]);
    let start = bodies().flat_map(|body| &body.velocities).map(|velocity| velocity.length()).fold(0.0, f64::max);
    let fall = match gravity.try_normalize() {
        None => 0.0,
        Some(down) => {
            let sides = walls(scene, DVec3::ZERO)?;
            let positions = || bodies().flat_map(|body| &body.positions);
            let highest = positions().map(|x| x.dot(down)).fold(f64::INFINITY, f64::min);
            let below = |x: &DVec3| sides.iter().filter_map(|side| hit(&side.wall, *x, down)).fold(f64::INFINITY, f64::min);
            let lowest = positions().map(|x| x.dot(down) + below(x)).filter(|depth| depth.is_finite()).fold(highest, f64::max);
            (2.0 * gravity.length() * (lowest - highest)).sqrt()
        }
    };
    let fastest = start.max(fall);
    if fastest > 0.0 {
        return Ok(fastest);
    }
    Err(Error::parameter(format!("bodies[{first}].sound_speed"), "a speed [m/s]", "auto")
        .with_hint("it follows from the initial velocities, or from gravity and a wall below; here there are neither"))
}

/// How far a ray goes from `x` until it meets a wall [m].
fn hit(wall: &Wall, x: DVec3, direction: DVec3) -> Option<f64> {
    let distance = match *wall {
        Wall::Plane { normal, offset } => (offset - normal.dot(x)) / normal.dot(direction),
        Wall::Sphere { center, radius, inside } => {
            let (away, square) = ((x - center).dot(direction), (x - center).length_squared() - radius * radius);
            let root = (away * away - square).sqrt();
            if inside { root - away } else { -root - away }
        }
    };
    (distance > 0.0 && distance.is_finite()).then_some(distance)
}

/// The density that each member starts with: under the weight of what is above it.
pub fn densities<V: Vector>(scene: &Scene, properties: &Properties<V>, members: &[u32], material: &Material) -> Vec<f64> {
    let positions: Vec<DVec3> = scene.bodies.iter().flat_map(|body| &body.positions).copied().collect();
    let weight = material.density * material.gravity;
    let load = |&member: &u32| positions[properties.caller[member as usize] as usize].dot(weight);
    let top = members.iter().map(load).fold(f64::INFINITY, f64::min) - 0.5 * material.spacing * weight.length();
    members.iter().map(|member| material.density_under(load(member) - top)).collect()
}
