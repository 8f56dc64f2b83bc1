//! Materials of the fluids of a scene, whatever method computes their flow.

use glam::DVec3;

use super::start::method;
use super::tension::SHORT_RANGE;
use crate::error::{Error, Result};
use crate::forces::fluid::{KIND, fluids};
use crate::math::Real;
use crate::scene::{Item, RIGID_BODIES, Scene, Value};

/// Number of materials: fluids, and obstacles.
pub const KINDS: usize = 4;
/// Tag of obstacles.
pub const OBSTACLE: u8 = 3;

/// Parameters in which fluids of one scene may differ.
const OWN: [&str; 3] = ["density", "viscosity", "surface_tension"];

/// Material of a fluid.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Mass of a particle m = ρ₀ Δ^D [kg].
    pub mass: f64,
    /// Density at rest ρ₀ [kg/m³].
    pub density: f64,
    /// Smoothing length h [m].
    pub smoothing_length: f64,
    /// Particle spacing at rest Δ [m].
    pub spacing: f64,
    /// Dynamic viscosity μ [Pa·s].
    pub viscosity: f64,
    /// Surface tension σ [N/m].
    pub surface_tension: f64,
    /// Gravitational acceleration g [m/s²], without its component along periodic axes, where it causes no pressure.
    pub gravity: DVec3,
}

impl Material {
    /// Material of a fluid of the scene in this gravity [m/s²].
    fn of(scene: &Scene, fluid: &Item, mut gravity: DVec3) -> Result<Self> {
        // Along a periodic axis there is no hydrostatic pressure.
        if let Some([lower, upper]) = scene.periodic {
            (0..scene.dimension).filter(|&axis| (upper[axis] - lower[axis]).is_finite()).for_each(|axis| gravity[axis] = 0.0);
        }
        let (density, spacing, viscosity) = (fluid.number("density")?, fluid.number("spacing")?, fluid.number("viscosity")?);
        let (kernel, surface_tension) = (method(fluid)?.record("kernel")?, fluid.number("surface_tension")?);
        let smoothing = kernel.number("smoothing")?;
        if surface_tension > 0.0 && 2.0 * smoothing < SHORT_RANGE {
            let expected = format!("at least {} where there is surface tension", 0.5 * SHORT_RANGE);
            let hint = format!("it keeps particles apart within {SHORT_RANGE} spacings, and the support is twice the smoothing");
            return Err(kernel.wrong("smoothing", &expected, Some(&Value::Number(smoothing))).with_hint(hint));
        }
        Ok(Self {
            mass: density * if scene.dimension == 2 { spacing.powi(2) } else { spacing.powi(3) },
            density,
            smoothing_length: smoothing * spacing,
            spacing,
            viscosity,
            surface_tension,
            gravity,
        })
    }
}

/// Materials of a scene, and the material of each body.
#[derive(Debug)]
pub struct Materials {
    pub fluids: Vec<Material>,
    /// Material of each body: a fluid, [`OBSTACLE`], or None without interaction.
    pub of_body: Vec<Option<u8>>,
    /// Whether there are rigid bodies that meet a fluid.
    pub meet_solids: bool,
}

impl Materials {
    /// Materials of a scene, in this gravity [m/s²].
    ///
    /// # Errors
    /// If there are too many, or they have different methods.
    pub fn of(scene: &Scene, gravity: DVec3) -> Result<Self> {
        let mut materials = Self { fluids: Vec::new(), of_body: vec![None; scene.bodies.len()], meet_solids: false };
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
            let material = Material::of(scene, fluid, gravity)?;
            let known = materials.fluids.iter().position(|other| *other == material);
            if known.is_none() && materials.fluids.len() == usize::from(OBSTACLE) {
                return Err(Error::parameter(format!("bodies[{body}]"), "at most three kinds of fluid", "a fourth"));
            }
            materials.of_body[body] = Some(known.unwrap_or(materials.fluids.len()) as u8);
            materials.fluids.extend(known.is_none().then_some(material));
            if fluid.flag("obstacles")? {
                let others = materials.of_body.iter_mut().zip(&scene.bodies).filter(|(_, body)| body.item.kind != KIND);
                for (kind, body) in others {
                    let is_rigid = body.item.kind == RIGID_BODIES;
                    materials.meet_solids |= is_rigid;
                    *kind = (!is_rigid).then_some(OBSTACLE);
                }
            }
        }
        Ok(materials)
    }

    /// Whether there is more than one material.
    #[inline]
    pub fn are_mixed(&self) -> bool {
        self.fluids.len() > 1 || self.meet_solids || self.of_body.contains(&Some(OBSTACLE))
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

    /// Rest density of each fluid [kg/m³], 0 for obstacles.
    pub fn rest_densities<T: Real>(&self) -> [T; KINDS] {
        std::array::from_fn(|kind| T::from_f64(self.fluids.get(kind).map_or(0.0, |fluid| fluid.density)))
    }
}

/// Parameters that fluids of one scene have in common.
fn common(fluid: &Item) -> impl Iterator<Item = (&String, &Value)> {
    fluid.values.iter().filter(|(name, _)| !OWN.contains(&name.as_str()))
}

/// Coefficient of each pair of materials. An obstacle takes the coefficient of its partner; between obstacles it is 0.
pub fn pairs<M, T: Real>(fluids: &[M], of: impl Fn(&M, &M) -> f64) -> [[T; KINDS]; KINDS] {
    let pair = |one: Option<&M>, other: Option<&M>| match (one, other) {
        (Some(one), Some(other)) => of(one, other),
        (Some(fluid), None) | (None, Some(fluid)) => of(fluid, fluid),
        (None, None) => 0.0,
    };
    std::array::from_fn(|one| std::array::from_fn(|other| T::from_f64(pair(fluids.get(one), fluids.get(other)))))
}
