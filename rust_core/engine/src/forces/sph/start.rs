//! Fluid parameters that follow from the scene: gravity, the speed of sound, walls, and the initial density.

use std::collections::BTreeMap;

use glam::DVec3;

use super::laws::{KINDS, OBSTACLE};
use super::walls::Side;
use crate::boundaries::{self, Gap, Path, Wall};
use crate::error::{Error, Result};
use crate::forces::{gravity, is_between_pairs};
use crate::math::Real;
use crate::scene::{Item, Scene, Value};

/// The exponent γ of the equation of state.
const GAMMA: i32 = 7;

/// The speed of sound in units of the fastest flow: density then varies by some (1/10)² = 1 %.
const SOUND: f64 = 10.0;

/// The square of the speed of sound in units of σ/ρ₀Δ: above a hundred σ/ρ₀R for radii of three spacings and more.
const TENSION: f64 = 40.0;

/// The material of a fluid.
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
    /// Particle spacing at rest Δ [m].
    pub spacing: f64,
    /// Dynamic viscosity μ [Pa·s].
    pub viscosity: f64,
    /// The coefficient α of the artificial viscosity.
    pub artificial_viscosity: f64,
    /// The coefficient δ of the diffusion of density.
    pub density_diffusion: f64,
    /// Surface tension σ [N/m].
    pub surface_tension: f64,
    /// Gravitational acceleration g [m/s²], without its component along periodic axes, where it makes no pressure.
    pub gravity: DVec3,
}

impl Material {
    /// Pressure at a density [Pa]: p = c²ρ₀/γ ((ρ/ρ₀)^γ − 1), of R. H. Cole, Underwater Explosions (1948).
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

    /// Specific energy of compression [J/kg]: ∫ p/ρ² dρ from ρ₀, that is c²/γ [s^(γ−1)/(γ−1) + 1/s − γ/(γ−1)], s = ρ/ρ₀.
    pub fn energy(&self, density: f64) -> f64 {
        let ratio = density / self.density;
        let sixth = ratio.powi(GAMMA - 1);
        self.sound_speed.powi(2) / 7.0 * (sixth / 6.0 + 1.0 / ratio - 7.0 / 6.0)
    }

    /// Enthalpy in units of density [kg/m³]: ρ₀w/c² with w = ∫ dp/ρ = c²/(γ−1) (s^(γ−1) − 1), s = ρ/ρ₀.
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

    /// Diffusivity of density between two particles, 2δhc [m²/s].
    pub fn diffusion(&self) -> f64 {
        2.0 * self.density_diffusion * self.smoothing_length * self.sound_speed
    }

    /// Coefficient c²ρ₀/γ of the equation of state [Pa].
    #[inline(always)]
    fn stiffness(&self) -> f64 {
        self.sound_speed * self.sound_speed * self.density / f64::from(GAMMA)
    }
}

/// The kind of a body that is a fluid.
pub const KIND: &str = "Fluid";

/// What fluids of one scene may differ in.
const OWN: [&str; 3] = ["density", "viscosity", "surface_tension"];

/// The fluids of a scene: the index of each body that is one, and what it says.
pub fn fluids(scene: &Scene) -> impl Iterator<Item = (usize, &Item)> {
    scene.bodies.iter().map(|body| &body.item).enumerate().filter(|(_, item)| item.kind == KIND)
}

/// The walls of the fluid, relative to an origin.
pub fn walls(scene: &Scene, origin: DVec3) -> Result<Vec<Side>> {
    let mut walls = Vec::new();
    for item in scene.boundaries.iter().filter(|item| fluids(scene).any(|(body, _)| item.acts_on(body))) {
        let no_slip = if item.values.contains_key("no_slip") { item.flag("no_slip")? } else { false };
        let boundary = boundaries::build(item, scene.dimension, origin)?;
        if boundary.walls().iter().any(|wall| matches!(wall, Wall::Terrain(_))) {
            // Mirror images are behind one plane, not behind the faces on both sides of an edge.
            let path = format!("{}.on", item.path);
            return Err(Error::parameter(path, "bodies that are no fluids", "a fluid on a height field"));
        }
        walls.extend(boundary.walls().iter().map(|wall| Side { wall: wall.clone(), no_slip }));
    }
    Ok(walls)
}

/// The materials of a scene, and that of each body.
#[derive(Debug)]
pub struct Materials {
    pub fluids: Vec<Material>,
    /// The material of each body: a fluid, [`OBSTACLE`], or None without interaction.
    pub of_body: Vec<Option<u8>>,
    /// Whether density is summed over positions.
    pub summation: bool,
    /// The coefficient A of shifting.
    pub shifting: f64,
}

impl Materials {
    /// The materials of a scene.
    ///
    /// # Errors
    /// If they are too many or have different kernels, or the speed of sound can neither be found nor is given.
    pub fn of(scene: &Scene) -> Result<Self> {
        let mut materials = Self { fluids: Vec::new(), of_body: vec![None; scene.bodies.len()], summation: false, shifting: 0.0 };
        let mut shared: Option<(usize, &Item)> = None;
        for (body, fluid) in fluids(scene) {
            let (first, model) = *shared.get_or_insert((body, fluid));
            if !common(fluid).eq(common(model)) {
                return Err(Error::parameter(
                    format!("bodies[{body}]"),
                    format!("numerics as those of bodies[{first}]"),
                    "others",
                )
                .with_hint("fluids of one scene may differ in density, viscosity and surface tension alone"));
            }
            materials.summation = fluid.word("density_from", &["continuity", "summation"])? == "summation";
            materials.shifting = fluid.non_negative("shifting")?;
            if materials.shifting > 0.0 {
                materials.check_shifting(scene, body, fluid)?;
            }
            let material = Material::of(scene, fluid)?;
            let known = materials.fluids.iter().position(|other| *other == material);
            if known.is_none() && materials.fluids.len() == usize::from(OBSTACLE) {
                return Err(Error::parameter(format!("bodies[{body}]"), "at most three kinds of fluid", "a fourth"));
            }
            materials.of_body[body] = Some(known.unwrap_or(materials.fluids.len()) as u8);
            materials.fluids.extend(known.is_none().then_some(material));
            if fluid.flag("obstacles")? {
                let solids = materials.of_body.iter_mut().zip(&scene.bodies).filter(|(_, body)| body.item.kind != KIND);
                solids.for_each(|(kind, _)| *kind = Some(OBSTACLE));
            }
        }
        Ok(materials)
    }

    /// Looks whether a fluid that is to be shifted may be.
    fn check_shifting(&self, scene: &Scene, body: usize, fluid: &Item) -> Result<()> {
        let refused = |expected: &str| fluid.wrong("shifting", expected, Some(&Value::Number(self.shifting)));
        if self.summation {
            return Err(refused("0 where density is counted by summation")
                .with_hint("the energy of such a fluid is that of its particles' positions, and keeps them apart"));
        }
        if fluid.number("surface_tension")? > 0.0 {
            return Err(refused("0 where there is surface tension")
                .with_hint("what a shift changes in the energy of surfaces is not counted"));
        }
        match scene.forces.iter().find(|item| is_between_pairs(item) && item.acts_on(body)) {
            Some(item) => Err(Error::parameter(format!("{}.on", item.path), "no fluid that is shifted", &fluid.path)
                .with_hint("what a shift changes in the energy of pairs is not counted")),
            None => Ok(()),
        }
    }

    /// Whether there is more than one material.
    pub fn are_mixed(&self) -> bool {
        self.fluids.len() > 1 || self.of_body.contains(&Some(OBSTACLE))
    }

    /// The first fluid, with the parameters that all fluids share.
    pub fn first(&self) -> &Material {
        &self.fluids[0]
    }

    /// The fluid of a material number; None for obstacles.
    #[inline(always)]
    pub fn fluid(&self, kind: u8) -> Option<&Material> {
        self.fluids.get(usize::from(kind))
    }

    /// Rest density of a material [kg/m³]; for obstacles that of the first fluid.
    pub fn rest_density(&self, kind: u8) -> f64 {
        self.fluid(kind).unwrap_or(self.first()).density
    }

    /// A coefficient of each fluid, 0 for obstacles.
    pub fn each<T: Real>(&self, of: impl Fn(&Material) -> f64) -> [T; KINDS] {
        std::array::from_fn(|kind| T::from_f64(self.fluids.get(kind).map_or(0.0, &of)))
    }

    /// A coefficient of each pair of materials. An obstacle takes that of its partner; between obstacles it is 0.
    pub fn pairs<T: Real>(&self, of: impl Fn(&Material, &Material) -> f64) -> [[T; KINDS]; KINDS] {
        let pair = |one: Option<&Material>, other: Option<&Material>| match (one, other) {
            (Some(one), Some(other)) => of(one, other),
            (Some(fluid), None) | (None, Some(fluid)) => of(fluid, fluid),
            (None, None) => 0.0,
        };
        std::array::from_fn(|one| std::array::from_fn(|other| T::from_f64(pair(self.fluids.get(one), self.fluids.get(other)))))
    }
}

/// What fluids of one scene have in common.
fn common(fluid: &Item) -> impl Iterator<Item = (&String, &Value)> {
    fluid.values.iter().filter(|(name, _)| !OWN.contains(&name.as_str()))
}

impl Material {
    /// The material of a fluid of the scene.
    fn of(scene: &Scene, fluid: &Item) -> Result<Self> {
        let first = fluids(scene).next().map_or(0, |(body, _)| body);
        let mut gravity = gravity::on_body(scene, first)?;
        // Along a periodic axis there is no hydrostatic pressure.
        if let Some([lower, upper]) = scene.periodic {
            (0..scene.dimension).filter(|&axis| (upper[axis] - lower[axis]).is_finite()).for_each(|axis| gravity[axis] = 0.0);
        }
        let sound_speed = match fluid.values.get("sound_speed") {
            Some(Value::Text(word)) if word == "auto" => enough_sound(scene, first, gravity)?,
            _ => fluid.number("sound_speed")?,
        };
        let (density, spacing) = (fluid.number("density")?, fluid.number("spacing")?);
        Ok(Self {
            mass: density * if scene.dimension == 2 { spacing.powi(2) } else { spacing.powi(3) },
            density,
            sound_speed,
            smoothing_length: fluid.record("kernel")?.number("smoothing")? * spacing,
            spacing,
            viscosity: fluid.number("viscosity")?,
            artificial_viscosity: fluid.number("artificial_viscosity")?,
            density_diffusion: fluid.number("density_diffusion")?,
            surface_tension: fluid.number("surface_tension")?,
            gravity,
        })
    }
}

/// Estimate of the largest speed [m/s]: the initial one, or that of a fall from the highest fluid to the lowest wall below
/// any of it.
fn fastest(scene: &Scene, gravity: DVec3) -> Result<f64> {
    let bodies = || fluids(scene).map(|(body, _)| &scene.bodies[body]);
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

/// Squared speed of sound for surface tension [m²/s²]: capillary pressures, of order σ/Δ, then change the density by some
/// percent.
fn square_for_tension(scene: &Scene) -> Result<f64> {
    let (mut tension, mut lightest) = (0.0_f64, f64::INFINITY);
    for (_, fluid) in fluids(scene) {
        tension = tension.max(fluid.number("surface_tension")? / fluid.number("spacing")?);
        lightest = lightest.min(fluid.number("density")?);
    }
    Ok(TENSION * tension / lightest)
}

/// Speed of sound at which the fluid is practically incompressible [m/s].
fn enough_sound(scene: &Scene, first: usize, gravity: DVec3) -> Result<f64> {
    let sound = (SOUND * fastest(scene, gravity)?).max(square_for_tension(scene)?.sqrt());
    if sound > 0.0 {
        return Ok(sound);
    }
    Err(Error::parameter(format!("bodies[{first}].sound_speed"), "a speed [m/s]", "auto").with_hint(
        "it follows from the initial velocities, from gravity and a wall below, or from surface tension; here there are none",
    ))
}

/// Distance along a ray from `x` to a wall [m].
fn hit(wall: &Wall, x: DVec3, direction: DVec3) -> Option<f64> {
    let distance = match *wall {
        Wall::Plane { normal, offset } => (offset - normal.dot(x)) / normal.dot(direction),
        Wall::Sphere { center, radius, inside } => {
            let (away, square) = ((x - center).dot(direction), (x - center).length_squared() - radius * radius);
            let root = (away * away - square).sqrt();
            if inside { root - away } else { -root - away }
        }
        Wall::Solid(_) | Wall::Terrain(_) => {
            let ray = Path { position: x, velocity: direction, acceleration: DVec3::ZERO };
            Gap::new(wall, &ray, 0.0, false).first_contact(2.0 * (x.length() + wall.extent()))?
        }
    };
    (distance > 0.0 && distance.is_finite()).then_some(distance)
}

/// A layer of fluid particles one spacing high.
#[derive(Debug, Clone, Copy, Default)]
struct Layer {
    /// Their mean density [kg/m³].
    density: f64,
    number: f64,
    /// Mass per area of the layers above [kg/m²].
    above: f64,
}

/// Hydrostatic pressure of fluid particles [Pa]: the weight of the column above. Each head is a depth [m] with the density
/// there. Empty parts of the column have no weight, and take no memory, however high it is.
pub fn pressures(heads: &[(f64, f64)], spacing: f64, gravity: f64) -> Vec<f64> {
    let top = heads.iter().map(|&(head, _)| head).fold(f64::INFINITY, f64::min) - 0.5 * spacing;
    let layer = |head: f64| ((head - top) / spacing) as usize;
    let mut layers: BTreeMap<usize, Layer> = BTreeMap::new();
    for &(head, density) in heads {
        let layer = layers.entry(layer(head)).or_default();
        layer.density += density;
        layer.number += 1.0;
    }
    let mut above = 0.0;
    for layer in layers.values_mut() {
        layer.density /= layer.number;
        layer.above = above;
        above += layer.density * spacing;
    }
    let pressure = |head: f64| {
        let index = layer(head);
        let Layer { density, above, .. } = layers[&index];
        gravity * (above + density * (head - top - index as f64 * spacing))
    };
    heads.iter().map(|&(head, _)| pressure(head)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_weight_above_is_that_of_all_layers() {
        // Half a meter of oil on water: (800 · 0.5 + 1000 · x) g.
        let heads: Vec<(f64, f64)> =
            (0..20).map(|row| (0.05 + 0.1 * f64::from(row), if row < 5 { 800.0 } else { 1000.0 })).collect();
        let found = pressures(&heads, 0.1, 10.0);
        for (&(head, _), pressure) in heads.iter().zip(found) {
            let expected = 10.0 * if head < 0.5 { 800.0 * head } else { 400.0 + 1000.0 * (head - 0.5) };
            assert!((pressure - expected).abs() < 1e-9 * expected, "{head} {pressure} {expected}");
        }
    }

    #[test]
    fn a_column_with_a_gap_takes_memory_for_its_particles_alone() {
        // A layer of 1e-9 m, and 1e15 empty ones below it.
        let found = pressures(&[(0.0, 1000.0), (1e6, 1000.0)], 1e-9, 10.0);
        let expected = [10.0 * 1000.0 * 0.5e-9, 10.0 * 1000.0 * 1.5e-9];
        // Depths of 1e6 m have a rounding of 1e-10 m.
        assert!(found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e4 * 1e-9), "{found:?}");
    }
}
