//! What a scene leaves open about its fluid: gravity, the speed of sound, walls, and the density to start with.

use glam::DVec3;

use super::laws::{KINDS, OBSTACLE};
use super::walls::Side;
use crate::boundaries::{self, Wall};
use crate::error::{Error, Result};
use crate::math::Real;
use crate::scene::{Fluid, Scene, Term};

/// The exponent γ of the equation of state.
const GAMMA: i32 = 7;

/// The speed of sound in units of the fastest flow: density then varies by some (1/10)² = 1 %.
const SOUND: f64 = 10.0;

/// The square of the speed of sound in units of σ/ρ₀Δ: above a hundred σ/ρ₀R for radii of three spacings and more.
const TENSION: f64 = 40.0;

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
    /// Surface tension σ [N/m].
    pub surface_tension: f64,
    /// Gravity g [m/s²], as far as it presses: not along a periodic axis.
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

    /// The enthalpy at a density in terms of density [kg/m³]: ρ₀w/c² with w = ∫ dp/ρ = c²/(γ−1) (s^(γ−1) − 1), s = ρ/ρ₀.
    #[inline(always)]
    pub fn enthalpy(&self, density: f64) -> f64 {
        let ratio = density / self.density;
        let cube = ratio * ratio * ratio;
        self.density / f64::from(GAMMA - 1) * (cube * cube - 1.0)
    }

    /// The speed of sound at a density [m/s].
    pub fn sound_at(&self, density: f64) -> f64 {
        self.sound_speed * (density / self.density).powi((GAMMA - 1) / 2)
    }

    /// The artificial viscosity of a pair αhcρ₀ [Pa·s].
    pub fn artificial(&self) -> f64 {
        self.artificial_viscosity * self.smoothing_length * self.sound_speed * self.density
    }

    /// The rate at which differences of density between two particles even out, 2δhc [m²/s].
    pub fn diffusion(&self) -> f64 {
        2.0 * self.density_diffusion * self.smoothing_length * self.sound_speed
    }

    /// c²ρ₀/γ [Pa].
    #[inline(always)]
    fn stiffness(&self) -> f64 {
        self.sound_speed * self.sound_speed * self.density / f64::from(GAMMA)
    }
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

/// The materials of a scene, and which each body is.
#[derive(Debug)]
pub struct Materials {
    pub fluids: Vec<Material>,
    /// The kind of each body: a fluid, [`OBSTACLE`], or nothing that the fluid meets.
    pub of_body: Vec<Option<u8>>,
    /// Whether density is summed over positions.
    pub summation: bool,
    /// The coefficient A of shifting.
    pub shifting: f64,
}

impl Materials {
    /// Those of a scene.
    ///
    /// # Errors
    /// If they are too many or have different kernels, or the speed of sound can neither be found nor is given.
    pub fn of(scene: &Scene) -> Result<Self> {
        let mut materials = Self { fluids: Vec::new(), of_body: vec![None; scene.bodies.len()], summation: false, shifting: 0.0 };
        let mut shared: Option<(usize, &Fluid)> = None;
        for (body, fluid) in scene.bodies.iter().enumerate().filter_map(|(body, matter)| Some((body, matter.fluid.as_ref()?))) {
            let (first, model) = *shared.get_or_insert((body, fluid));
            let common = Fluid {
                density: model.density,
                viscosity: model.viscosity,
                surface_tension: model.surface_tension,
                ..fluid.clone()
            };
            if common != *model {
                return Err(Error::parameter(
                    format!("bodies[{body}]"),
                    format!("numerics as those of bodies[{first}]"),
                    "others",
                )
                .with_hint("fluids of one scene may differ in density, viscosity and surface tension alone"));
            }
            materials.summation = fluid.summation;
            materials.shifting = fluid.shifting;
            check_shifting(scene, body, fluid)?;
            let material = Material::of(scene, fluid)?;
            let known = materials.fluids.iter().position(|other| *other == material);
            if known.is_none() && materials.fluids.len() == usize::from(OBSTACLE) {
                return Err(Error::parameter(format!("bodies[{body}]"), "at most three kinds of fluid", "a fourth"));
            }
            materials.of_body[body] = Some(known.unwrap_or(materials.fluids.len()) as u8);
            materials.fluids.extend(known.is_none().then_some(material));
            if fluid.obstacles {
                let solids = materials.of_body.iter_mut().zip(&scene.bodies).filter(|(_, matter)| matter.fluid.is_none());
                solids.for_each(|(kind, _)| *kind = Some(OBSTACLE));
            }
        }
        Ok(materials)
    }

    /// Whether there is more than one kind of matter.
    pub fn are_mixed(&self) -> bool {
        self.fluids.len() > 1 || self.of_body.contains(&Some(OBSTACLE))
    }

    /// What the fluids have in common, and the first of them.
    pub fn first(&self) -> &Material {
        &self.fluids[0]
    }

    /// The fluid of a kind; none for obstacles.
    #[inline(always)]
    pub fn fluid(&self, kind: u8) -> Option<&Material> {
        self.fluids.get(usize::from(kind))
    }

    /// The density at rest of a kind [kg/m³]; for obstacles that of the first fluid.
    pub fn rest_density(&self, kind: u8) -> f64 {
        self.fluid(kind).unwrap_or(self.first()).density
    }

    /// A number of each kind of fluid, 0 for obstacles.
    pub fn each<T: Real>(&self, of: impl Fn(&Material) -> f64) -> [T; KINDS] {
        std::array::from_fn(|kind| T::from_f64(self.fluids.get(kind).map_or(0.0, &of)))
    }

    /// A number of each pair of materials. Obstacles are as what they touch; to each other they are nothing.
    pub fn pairs<T: Real>(&self, of: impl Fn(&Material, &Material) -> f64) -> [[T; KINDS]; KINDS] {
        let pair = |one: Option<&Material>, other: Option<&Material>| match (one, other) {
            (Some(one), Some(other)) => of(one, other),
            (Some(fluid), None) | (None, Some(fluid)) => of(fluid, fluid),
            (None, None) => 0.0,
        };
        std::array::from_fn(|one| std::array::from_fn(|other| T::from_f64(pair(self.fluids.get(one), self.fluids.get(other)))))
    }
}

impl Material {
    /// That of a fluid of the scene.
    fn of(scene: &Scene, fluid: &Fluid) -> Result<Self> {
        let first = fluids(scene).next().unwrap_or(0);
        let gravity = scene.forces.iter().filter(|term| term.kind == "Gravity" && term.acts_on(first));
        let mut gravity = gravity.map(|term| term.vector("acceleration")).sum::<Result<DVec3>>()?;
        // Along a periodic axis nothing is below anything.
        if let Some([lower, upper]) = scene.periodic {
            (0..scene.dimension).filter(|&axis| (upper[axis] - lower[axis]).is_finite()).for_each(|axis| gravity[axis] = 0.0);
        }
        let sound_speed = match fluid.sound_speed {
            Some(speed) => speed,
            None => enough_sound(scene, first, gravity)?,
        };
        Ok(Self {
            mass: fluid.density * if scene.dimension == 2 { fluid.spacing.powi(2) } else { fluid.spacing.powi(3) },
            density: fluid.density,
            sound_speed,
            smoothing_length: fluid.smoothing * fluid.spacing,
            spacing: fluid.spacing,
            viscosity: fluid.viscosity,
            artificial_viscosity: fluid.artificial_viscosity,
            density_diffusion: fluid.density_diffusion,
            surface_tension: fluid.surface_tension,
            gravity,
        })
    }
}

/// Looks whether a fluid may be shifted, if it is to be.
fn check_shifting(scene: &Scene, body: usize, fluid: &Fluid) -> Result<()> {
    let path = format!("bodies[{body}].shifting");
    if !(fluid.shifting.is_finite() && fluid.shifting >= 0.0) {
        return Err(Error::parameter(path, "a finite number ≥ 0", fluid.shifting));
    }
    if fluid.shifting > 0.0 && fluid.summation {
        return Err(Error::parameter(path, "0 where density is counted by summation", fluid.shifting)
            .with_hint("the energy of such a fluid is that of its particles' positions, and keeps them apart"));
    }
    if fluid.shifting > 0.0 && fluid.surface_tension > 0.0 {
        return Err(Error::parameter(path, "0 where there is surface tension", fluid.shifting)
            .with_hint("what a shift changes in the energy of surfaces is not counted"));
    }
    let pushes = |term: &&Term| ["Repulsion", "LennardJones"].contains(&term.kind.as_str()) && term.acts_on(body);
    match scene.forces.iter().find(pushes) {
        Some(term) if fluid.shifting > 0.0 => {
            Err(Error::parameter(format!("{}.on", term.path), "no fluid that is shifted", format!("bodies[{body}]"))
                .with_hint("what a shift changes in the energy of pairs is not counted"))
        }
        _ => Ok(()),
    }
}

/// The fastest flow that is to be expected [m/s]: that of the start, or of a fall from the highest fluid to the lowest wall
/// below any of it.
fn fastest(scene: &Scene, gravity: DVec3) -> Result<f64> {
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
    Ok(start.max(fall))
}

/// The square of the speed of sound that the tension of a surface asks for [m²/s²]: its pressures, which are of the order of
/// σ/Δ next to it, then change the density by some percent.
fn square_for_tension(scene: &Scene) -> f64 {
    let models = || scene.bodies.iter().filter_map(|body| body.fluid.as_ref());
    let tension = models().map(|fluid| fluid.surface_tension / fluid.spacing).fold(0.0, f64::max);
    let lightest = models().map(|fluid| fluid.density).fold(f64::INFINITY, f64::min);
    TENSION * tension / lightest
}

/// The speed of sound with which the fluid of a scene is as good as incompressible [m/s].
fn enough_sound(scene: &Scene, first: usize, gravity: DVec3) -> Result<f64> {
    let sound = (SOUND * fastest(scene, gravity)?).max(square_for_tension(scene).sqrt());
    if sound > 0.0 {
        return Ok(sound);
    }
    Err(Error::parameter(format!("bodies[{first}].sound_speed"), "a speed [m/s]", "auto").with_hint(
        "it follows from the initial velocities, from gravity and a wall below, or from surface tension; here there are none",
    ))
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

/// The pressure that each fluid particle at these heads starts with [Pa]: the weight of what is above it. A head is how far
/// down something is [m]; it comes with the density there. What is empty on the way weighs nothing.
pub fn pressures(heads: &[(f64, f64)], spacing: f64, gravity: f64) -> Vec<f64> {
    let top = heads.iter().map(|&(head, _)| head).fold(f64::INFINITY, f64::min) - 0.5 * spacing;
    let layer = |head: f64| ((head - top) / spacing) as usize;
    let layers = heads.iter().map(|&(head, _)| layer(head) + 1).max().unwrap_or(0);
    let mut sums = vec![(0.0, 0.0); layers];
    for &(head, density) in heads {
        let (sum, number) = &mut sums[layer(head)];
        *sum += density;
        *number += 1.0;
    }
    let mean = |layer: usize| if sums[layer].1 > 0.0 { sums[layer].0 / sums[layer].1 } else { 0.0 };
    let mut above = vec![0.0; layers];
    (1..layers).for_each(|layer| above[layer] = above[layer - 1] + mean(layer - 1) * spacing);
    let pressure = |head: f64| {
        let layer = layer(head);
        gravity * (above[layer] + mean(layer) * (head - top - layer as f64 * spacing))
    };
    heads.iter().map(|&(head, _)| pressure(head)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_weight_above_is_that_of_all_layers() {
        // Half a metre of oil on water: (800 · 0.5 + 1000 · x) g.
        let heads: Vec<(f64, f64)> =
            (0..20).map(|row| (0.05 + 0.1 * f64::from(row), if row < 5 { 800.0 } else { 1000.0 })).collect();
        let found = pressures(&heads, 0.1, 10.0);
        for (&(head, _), pressure) in heads.iter().zip(found) {
            let expected = 10.0 * if head < 0.5 { 800.0 * head } else { 400.0 + 1000.0 * (head - 0.5) };
            assert!((pressure - expected).abs() < 1e-9 * expected, "{head} {pressure} {expected}");
        }
    }
}
