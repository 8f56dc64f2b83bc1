//! Fluid parameters that follow from the scene: gravity, the speed of sound, walls, and the initial density.

use std::collections::BTreeMap;

use glam::DVec3;

use super::laws::{KINDS, OBSTACLE};
use super::tension::SHORT_RANGE;
use super::walls::FluidWall;
use crate::boundaries::{self, Gap, Path, Wall};
use crate::error::{Error, Result};
use crate::forces::{central, gravity, is_between_pairs};
use crate::math::Real;
use crate::scene::{Item, Scene, Value};

/// Exponent γ of the equation of state.
const GAMMA: i32 = 7;

/// Speed of sound in units of the fastest flow. Density then varies by about (1/10)² = 1 %.
const SOUND: f64 = 10.0;

/// Expected speed of a fluid that strikes a wall, in units of the speed of this impact. The jets of a block that falls onto a floor
/// are measured to be faster. Two percent of its particles exceed 2.0 to 2.5 times the impact, at any height and resolution. With
/// this value their Mach number is below 0.15.
const JETS: f64 = 1.75;

/// Velocity in the middle of a turbulent channel in units of √(τ/ρ), where τ is the stress at its walls.
///
/// Source: S. B. Pope, Turbulent Flows (2000), § 7.1.
const TURBULENT: f64 = 20.0;

/// Total viscosity that a fluid needs, as the coefficient α. The artificial viscosity adds what its own viscosity lacks.
const ARTIFICIAL: f64 = 0.02;

/// Coefficient A of shifting where it is safe.
pub const SHIFTING: f64 = 6.0;

/// Squared speed of sound in units of σ/ρ₀Δ. For radii R of at least three spacings, it exceeds a hundred σ/ρ₀R.
const TENSION: f64 = 40.0;

/// Material of a fluid.
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
    /// Coefficient α of the artificial viscosity.
    pub artificial_viscosity: f64,
    /// Coefficient δ of the diffusion of density.
    pub density_diffusion: f64,
    /// Surface tension σ [N/m].
    pub surface_tension: f64,
    /// Gravitational acceleration g [m/s²], without its component along periodic axes, where it causes no pressure.
    pub gravity: DVec3,
}

impl Material {
    /// Pressure at a density [Pa]: p = c²ρ₀/γ ((ρ/ρ₀)^γ − 1).
    ///
    /// Source: R. H. Cole, Underwater Explosions (1948).
    #[inline(always)]
    pub fn pressure(&self, density: f64) -> f64 {
        let ratio = density / self.density;
        let cube = ratio * ratio * ratio;
        self.stiffness() * (cube * cube * ratio - 1.0)
    }

    /// Density at a pressure [kg/m³].
    #[inline]
    pub fn density_under(&self, pressure: f64) -> f64 {
        self.density * libm::pow(1.0 + pressure / self.stiffness(), 1.0 / f64::from(GAMMA))
    }

    /// Specific energy of compression [J/kg]: ∫ p/ρ² dρ from ρ₀, which is c²/γ [s^(γ−1)/(γ−1) + 1/s − γ/(γ−1)] with s = ρ/ρ₀.
    #[inline]
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
        self.density * (1.0 / f64::from(GAMMA - 1)) * (cube * cube - 1.0)
    }

    /// Speed of sound at a density [m/s].
    #[inline]
    pub fn sound_at(&self, density: f64) -> f64 {
        self.sound_speed * (density / self.density).powi((GAMMA - 1) / 2)
    }

    /// Artificial viscosity αhcρ₀ of a pair [Pa·s].
    #[inline]
    pub fn artificial(&self) -> f64 {
        self.artificial_viscosity * self.smoothing_length * self.sound_speed * self.density
    }

    /// Diffusivity of density between two particles, 2δhc [m²/s].
    #[inline]
    pub fn diffusion(&self) -> f64 {
        2.0 * self.density_diffusion * self.smoothing_length * self.sound_speed
    }

    /// Coefficient c²ρ₀/γ of the equation of state [Pa].
    #[inline(always)]
    fn stiffness(&self) -> f64 {
        self.sound_speed * self.sound_speed * self.density * (1.0 / f64::from(GAMMA))
    }
}

/// A parameter that is given or chosen automatically.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Choice {
    Given(f64),
    Auto,
}

impl Choice {
    /// Choice of a parameter of an item.
    fn of(item: &Item, name: &str) -> Result<Self> {
        match item.values.get(name) {
            Some(Value::Text(word)) if word == "auto" => Ok(Self::Auto),
            _ => item.non_negative(name).map(Self::Given),
        }
    }
}

/// Numerical method of a fluid.
#[inline]
pub fn method(fluid: &Item) -> Result<&Item> {
    fluid.record("method")
}

/// Kind of a body that is a fluid.
pub const KIND: &str = "Fluid";

/// Parameters in which fluids of one scene may differ.
const OWN: [&str; 3] = ["density", "viscosity", "surface_tension"];

/// Fluids of a scene, each with the index of its body.
#[inline]
pub fn fluids(scene: &Scene) -> impl Iterator<Item = (usize, &Item)> {
    scene.bodies.iter().map(|body| &body.item).enumerate().filter(|(_, item)| item.kind == KIND)
}

/// Boundaries that act on fluids, each with its index.
fn met(scene: &Scene) -> impl Iterator<Item = (usize, &Item)> {
    let meets = |item: &Item| fluids(scene).any(|(body, _)| item.acts_on(body));
    scene.boundaries.iter().enumerate().filter(move |(_, item)| meets(item))
}

/// Index of the boundary of each wall.
#[inline]
pub fn boundaries_of_walls(scene: &Scene, origin: DVec3) -> Result<Vec<usize>> {
    let mut found = Vec::new();
    for (index, item) in met(scene) {
        let count = boundaries::build(item, scene.dimension, origin)?.walls().len();
        found.extend(std::iter::repeat_n(index, count));
    }
    Ok(found)
}

/// Walls of the fluids, relative to an origin.
pub fn walls(scene: &Scene, origin: DVec3) -> Result<Vec<FluidWall>> {
    let mut walls = Vec::new();
    for (_, item) in met(scene) {
        let no_slip = if item.values.contains_key("no_slip") { item.flag("no_slip")? } else { false };
        let boundary = boundaries::build(item, scene.dimension, origin)?;
        if boundary.walls().iter().any(|wall| matches!(wall, Wall::Terrain(_))) {
            // Mirror images are behind one plane, and not behind the faces on both sides of an edge.
            let path = format!("{}.on", item.path);
            return Err(Error::parameter(path, "bodies that are no fluids", "a fluid on a height field"));
        }
        walls.extend(boundary.walls().iter().map(|wall| FluidWall { wall: wall.clone(), no_slip }));
    }
    Ok(walls)
}

/// Materials of a scene, and the material of each body.
#[derive(Debug)]
pub struct Materials {
    pub fluids: Vec<Material>,
    /// Material of each body: a fluid, [`OBSTACLE`], or None without interaction.
    pub of_body: Vec<Option<u8>>,
    /// Whether density is summed over positions.
    pub summation: bool,
    /// Coefficient A of shifting.
    pub shifting: Choice,
    /// Remarks in the plan.
    pub remarks: Vec<String>,
}

impl Materials {
    /// Materials of a scene.
    ///
    /// # Errors
    /// If there are too many, they have different kernels, or the speed of sound is neither given nor can be found.
    pub fn of(scene: &Scene) -> Result<Self> {
        let mut materials = Self {
            fluids: Vec::new(),
            of_body: vec![None; scene.bodies.len()],
            summation: false,
            shifting: Choice::Given(0.0),
            remarks: Vec::new(),
        };
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
            materials.summation = method(fluid)?.word("density_from", &["continuity", "summation"])? == "summation";
            materials.choose_shifting(scene, body, fluid)?;
            let material = Material::of(scene, fluid)?;
            materials.remarks.extend(material.remark(scene, body));
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

    /// Sets the shifting that a fluid requests, if permitted. If the choice is automatic and shifting is not permitted, there is
    /// none.
    fn choose_shifting(&mut self, scene: &Scene, body: usize, fluid: &Item) -> Result<()> {
        self.shifting = match Choice::of(method(fluid)?, "shifting")? {
            Choice::Given(coefficient) => {
                if coefficient > 0.0 {
                    self.check_shifting(scene, body, fluid, coefficient)?;
                }
                Choice::Given(coefficient)
            }
            // Adjacent fluids would mix.
            Choice::Auto if fluids(scene).nth(1).is_some() => Choice::Given(0.0),
            Choice::Auto if self.check_shifting(scene, body, fluid, SHIFTING).is_err() => Choice::Given(0.0),
            Choice::Auto => Choice::Auto,
        };
        Ok(())
    }

    /// Checks whether a fluid may be shifted.
    fn check_shifting(&self, scene: &Scene, body: usize, fluid: &Item, coefficient: f64) -> Result<()> {
        let found = Value::Number(coefficient);
        let refused = |expected: &str| Ok(method(fluid)?.wrong("shifting", expected, Some(&found)));
        if self.summation {
            return Err(refused("0 where density is counted by summation")?
                .with_hint("the energy of such a fluid is that of its particles' positions, and keeps them apart"));
        }
        if fluid.number("surface_tension")? > 0.0 {
            return Err(refused("0 where there is surface tension")?
                .with_hint("what a shift changes in the energy of surfaces is not counted"));
        }
        match scene.forces.iter().find(|item| is_between_pairs(item) && item.acts_on(body)) {
            Some(item) => Err(Error::parameter(format!("{}.on", item.path), "no fluid that is shifted", &fluid.path)
                .with_hint("what a shift changes in the energy of pairs is not counted")),
            None => Ok(()),
        }
    }

    /// Whether there is more than one material.
    #[inline]
    pub fn are_mixed(&self) -> bool {
        self.fluids.len() > 1 || self.of_body.contains(&Some(OBSTACLE))
    }

    /// The first fluid, with the parameters that all fluids share.
    #[inline]
    pub fn first(&self) -> &Material {
        &self.fluids[0]
    }

    /// The fluid of a material number; None for obstacles.
    #[inline(always)]
    pub fn fluid(&self, kind: u8) -> Option<&Material> {
        self.fluids.get(usize::from(kind))
    }

    /// Rest density of a material [kg/m³]; for obstacles, that of the first fluid.
    #[inline]
    pub fn rest_density(&self, kind: u8) -> f64 {
        self.fluid(kind).unwrap_or(self.first()).density
    }

    /// Coefficient of each fluid, 0 for obstacles.
    pub fn each<T: Real>(&self, of: impl Fn(&Material) -> f64) -> [T; KINDS] {
        std::array::from_fn(|kind| T::from_f64(self.fluids.get(kind).map_or(0.0, &of)))
    }

    /// Coefficient of each pair of materials. An obstacle takes the coefficient of its partner; between obstacles it is 0.
    pub fn pairs<T: Real>(&self, of: impl Fn(&Material, &Material) -> f64) -> [[T; KINDS]; KINDS] {
        let pair = |one: Option<&Material>, other: Option<&Material>| match (one, other) {
            (Some(one), Some(other)) => of(one, other),
            (Some(fluid), None) | (None, Some(fluid)) => of(fluid, fluid),
            (None, None) => 0.0,
        };
        std::array::from_fn(|one| std::array::from_fn(|other| T::from_f64(pair(self.fluids.get(one), self.fluids.get(other)))))
    }
}

/// Parameters that fluids of one scene have in common.
fn common(fluid: &Item) -> impl Iterator<Item = (&String, &Value)> {
    fluid.values.iter().filter(|(name, _)| !OWN.contains(&name.as_str()))
}

impl Material {
    /// Material of a fluid of the scene.
    fn of(scene: &Scene, fluid: &Item) -> Result<Self> {
        let first = fluids(scene).next().map_or(0, |(body, _)| body);
        let mut gravity = gravity::on_body(scene, first)?;
        // Along a periodic axis there is no hydrostatic pressure.
        if let Some([lower, upper]) = scene.periodic {
            (0..scene.dimension).filter(|&axis| (upper[axis] - lower[axis]).is_finite()).for_each(|axis| gravity[axis] = 0.0);
        }
        let method = method(fluid)?;
        let (density, spacing, viscosity) = (fluid.number("density")?, fluid.number("spacing")?, fluid.number("viscosity")?);
        let sound_speed = match Choice::of(method, "sound_speed")? {
            Choice::Auto => enough_sound(scene, first, gravity)?,
            Choice::Given(speed) => speed,
        };
        let (kernel, surface_tension) = (method.record("kernel")?, fluid.number("surface_tension")?);
        let smoothing = kernel.number("smoothing")?;
        if surface_tension > 0.0 && 2.0 * smoothing < SHORT_RANGE {
            let expected = format!("at least {} where there is surface tension", 0.5 * SHORT_RANGE);
            let hint = format!("it keeps particles apart within {SHORT_RANGE} spacings, and the support is twice the smoothing");
            return Err(kernel.wrong("smoothing", &expected, Some(&Value::Number(smoothing))).with_hint(hint));
        }
        let smoothing_length = smoothing * spacing;
        let artificial_viscosity = match Choice::of(method, "artificial_viscosity")? {
            Choice::Auto => {
                let own = viscosity / (density * smoothing_length * sound_speed * share(scene.dimension));
                (ARTIFICIAL - own).max(0.0)
            }
            Choice::Given(coefficient) => coefficient,
        };
        Ok(Self {
            mass: density * if scene.dimension == 2 { spacing.powi(2) } else { spacing.powi(3) },
            density,
            sound_speed,
            smoothing_length,
            spacing,
            viscosity,
            artificial_viscosity,
            density_diffusion: method.number("density_diffusion")?,
            surface_tension,
            gravity,
        })
    }

    /// Remark in the plan on the viscosity of a body of this material, if part of it is artificial.
    fn remark(&self, scene: &Scene, body: usize) -> Option<String> {
        let more = self.artificial() * share(scene.dimension);
        let (length, whole) = (extent(scene), self.viscosity + more);
        let reynolds = self.density * self.sound_speed / SOUND * length / whole;
        (more > 0.0).then(|| {
            format!(
                "bodies[{body}]: viscosity {whole:.1e} Pa·s, of which {more:.1e} are artificial (α = {:.2e}) and {:.1e} its own; at \
                 c/10 over {length:.3} m the Reynolds number is {reynolds:.0}, and grows with resolution",
                self.artificial_viscosity, self.viscosity,
            )
        })
    }
}

/// Ratio of the dynamic viscosity of an artificial viscosity to αhcρ₀, 1/2(D + 2): J. J. Monaghan, Rep. Prog. Phys. 68
/// (2005) 1703.
fn share(dimension: usize) -> f64 {
    1.0 / (2.0 * (dimension as f64 + 2.0))
}

/// Smallest initial extent of the fluids [m], with half a spacing on both sides.
fn extent(scene: &Scene) -> f64 {
    let positions = || fluids(scene).flat_map(|(body, _)| &scene.bodies[body].positions);
    let least = positions().fold(DVec3::INFINITY, |least, x| least.min(*x));
    let most = positions().fold(DVec3::NEG_INFINITY, |most, x| most.max(*x));
    let spacing = fluids(scene).filter_map(|(_, fluid)| fluid.number("spacing").ok()).fold(f64::INFINITY, f64::min);
    (most - least).to_array()[..scene.dimension].iter().copied().fold(f64::INFINITY, f64::min).max(0.0) + spacing
}

/// Largest initial speed [m/s].
fn initial(scene: &Scene) -> f64 {
    let velocities = fluids(scene).flat_map(|(body, _)| &scene.bodies[body].velocities);
    velocities.map(|velocity| velocity.length()).fold(0.0, f64::max)
}

/// Smallest kinematic viscosity [m²/s].
fn thinnest(scene: &Scene) -> Result<f64> {
    let each = fluids(scene).map(|(_, fluid)| Ok(fluid.number("viscosity")? / fluid.number("density")?));
    each.collect::<Result<Vec<f64>>>().map(|all| all.into_iter().fold(f64::INFINITY, f64::min))
}

/// Speed [m/s] at which friction at walls or obstacles balances gravity along a periodic axis; 0 without them. In the middle of a
/// channel of width L it is gL²/8ν, or, if that is turbulent, twenty times √(gL/2).
fn driven(scene: &Scene, first: usize, gravity: DVec3) -> Result<f64> {
    let along = (gravity::on_body(scene, first)? - gravity).length();
    let rough = walls(scene, DVec3::ZERO)?.iter().any(|side| side.no_slip);
    let stands = fluids(scene).any(|(_, fluid)| fluid.flag("obstacles").unwrap_or(false));
    let solid = stands && scene.bodies.iter().any(|body| body.item.kind != KIND);
    if along == 0.0 || !(rough || solid) {
        return Ok(0.0);
    }
    let (length, viscosity) = (extent(scene), thinnest(scene)?);
    Ok((along * length * length / (8.0 * viscosity)).min(TURBULENT * (0.5 * along * length).sqrt()))
}

/// Speed [m/s] of the fastest fall in a central force.
fn falling(scene: &Scene) -> Result<f64> {
    let mut fastest = 0.0_f64;
    for item in &scene.forces {
        for (body, fluid) in fluids(scene).filter(|&(body, _)| item.acts_on(body)) {
            let spacing = fluid.number("spacing")?;
            let mass = fluid.number("density")? * if scene.dimension == 2 { spacing.powi(2) } else { spacing.powi(3) };
            fastest = fastest.max(central::fall(item, mass, &scene.bodies[body].positions)?.unwrap_or(0.0));
        }
    }
    Ok(fastest)
}

/// Estimate of the largest speed [m/s]: the maximum of several speeds. One is the initial speed. The second is that of a fall
/// to the lowest wall. The third is that of a fall in a central force. The last is the speed at which friction balances gravity
/// along a periodic axis.
fn fastest(scene: &Scene, first: usize, gravity: DVec3) -> Result<f64> {
    let fall = gravity.try_normalize().map_or(Ok(0.0), |down| plunge(scene, gravity.length(), down))?;
    Ok(initial(scene).max(fall).max(driven(scene, first, gravity)?).max(falling(scene)?))
}

/// Largest speed in a fall to the lowest wall below any fluid [m/s]: of the highest particle, or of the jets of an impact.
///
/// The energy of the impact is that of the fall of the lowest particle and of the initial motion. A fluid that is thrown strikes
/// some wall, whatever its direction. The energy is zero where a fluid stands at rest on the wall, as in a dam.
fn plunge(scene: &Scene, gravity: f64, down: DVec3) -> Result<f64> {
    let sides = walls(scene, DVec3::ZERO)?;
    let bodies = || fluids(scene).map(|(body, _)| &scene.bodies[body]);
    let positions = || bodies().flat_map(|body| &body.positions);
    let depths = || positions().map(|x| x.dot(down));
    let (highest, lowest) = (depths().fold(f64::INFINITY, f64::min), depths().fold(f64::NEG_INFINITY, f64::max));
    let below = |x: &DVec3| sides.iter().filter_map(|side| hit(&side.wall, *x, down)).fold(f64::INFINITY, f64::min);
    let floor = positions().map(|x| x.dot(down) + below(x)).filter(|depth| depth.is_finite()).fold(highest, f64::max);
    if floor <= highest {
        return Ok(0.0);
    }
    let squares = bodies().flat_map(|body| &body.velocities).map(|velocity| velocity.length_squared());
    let impact = (squares.sum::<f64>() / positions().count() as f64 + 2.0 * gravity * (floor - lowest).max(0.0)).sqrt();
    Ok((2.0 * gravity * (floor - highest)).sqrt().max(JETS * impact))
}

/// Squared speed of sound for surface tension [m²/s²]. Capillary pressures, of order σ/Δ, then change the density by some
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
    // At a Reynolds number UL/ν below 1 the pressures are those of friction, ρνU/L: J. P. Morris et al., J. Comput. Phys. 136
    // (1997) 214.
    let rubbing = SOUND * (initial(scene) * thinnest(scene)? / extent(scene)).sqrt();
    let sound = (SOUND * fastest(scene, first, gravity)?).max(square_for_tension(scene)?.sqrt()).max(rubbing);
    if sound > 0.0 {
        return Ok(sound);
    }
    Err(Error::parameter(format!("bodies[{first}].method.sound_speed"), "a speed [m/s]", "auto").with_hint(
        "it follows from the initial velocities, from gravity and a wall below, or no-slip walls and obstacles along a periodic \
         axis, from a central force, or from surface tension; here there are none",
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
struct FluidLayer {
    /// Mean density of the particles [kg/m³].
    density: f64,
    number: f64,
    /// Mass per area of the layers above [kg/m²].
    above: f64,
}

/// Hydrostatic pressure of fluid particles [Pa]: the weight of the column above. Each head is a depth [m] with the density there.
/// Empty parts of a column have no weight, and take no memory for any height.
pub fn pressures(heads: &[(f64, f64)], spacing: f64, gravity: f64) -> Vec<f64> {
    let top = heads.iter().map(|&(head, _)| head).fold(f64::INFINITY, f64::min) - 0.5 * spacing;
    let layer = |head: f64| ((head - top) / spacing) as usize;
    let mut layers: BTreeMap<usize, FluidLayer> = BTreeMap::new();
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
        let FluidLayer { density, above, .. } = layers[&index];
        gravity * (above + density * (head - top - index as f64 * spacing))
    };
    heads.iter().map(|&(head, _)| pressure(head)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_weight_above_is_that_of_all_layers() {
        // Half a meter of oil on water has the pressure (800 · 0.5 + 1000 · x) g.
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
        // A layer of 1e-9 m has 1e15 empty layers below it.
        let found = pressures(&[(0.0, 1000.0), (1e6, 1000.0)], 1e-9, 10.0);
        let expected = [10.0 * 1000.0 * 0.5e-9, 10.0 * 1000.0 * 1.5e-9];
        // Depths of 1e6 m have a rounding error of 1e-10 m.
        assert!(found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e4 * 1e-9), "{found:?}");
    }
}
