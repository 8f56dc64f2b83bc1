//! Parameters of the scheme that a scene gives, or that follow from it.

use super::equation_of_state::CompressibleFluid;
use super::sound;
use crate::ForceLaws;
use crate::error::{Error, Result};
use crate::forces::fluid::fluids;
use crate::particles::start::method;
use crate::particles::{Material, Materials};
use crate::scene::{Item, Scene, Value};

/// Total viscosity that a fluid needs, as the coefficient α. The artificial viscosity adds what its own viscosity lacks.
const ARTIFICIAL: f64 = 0.02;

/// Coefficient A of shifting where it is safe.
pub const SHIFTING: f64 = 6.0;

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

/// Parameters of the fluids of a scene.
#[derive(Debug)]
pub struct FluidParameters {
    pub materials: Materials,
    /// Fluid of each material.
    pub fluids: Vec<CompressibleFluid>,
    /// Whether density is summed over positions.
    pub summation: bool,
    /// Coefficient A of shifting.
    pub shifting: Choice,
    /// Remarks in the plan.
    pub remarks: Vec<String>,
}

impl FluidParameters {
    /// Parameters of a scene whose first fluid is this one.
    ///
    /// # Errors
    /// If materials are inconsistent, or the speed of sound is neither given nor can be found.
    pub fn of(scene: &Scene, laws: &dyn ForceLaws, (first, item): (usize, &Item)) -> Result<Self> {
        let materials = Materials::of(scene, laws.gravity(scene, first)?)?;
        let method = method(item)?;
        let sound_speed = match Choice::of(method, "sound_speed")? {
            Choice::Auto => sound::enough(scene, laws, first, materials.first().gravity)?,
            Choice::Given(speed) => speed,
        };
        let compressible = |material: &Material| CompressibleFluid::new(material, method, sound_speed, scene.dimension);
        let mut parameters = Self {
            fluids: materials.fluids.iter().map(compressible).collect::<Result<_>>()?,
            materials,
            summation: method.word("density_from", &["continuity", "summation"])? == "summation",
            shifting: Choice::Given(0.0),
            remarks: Vec::new(),
        };
        for (body, item) in fluids(scene) {
            parameters.choose_shifting(scene, laws, (body, item))?;
            let of_body = parameters.materials.of_body[body].and_then(|kind| parameters.fluids.get(usize::from(kind)));
            let remark = of_body.and_then(|fluid| fluid.remark(scene, body));
            parameters.remarks.extend(remark);
        }
        Ok(parameters)
    }

    /// Sets the shifting that a fluid requests, if permitted. If the choice is automatic and shifting is not permitted, there is
    /// none.
    fn choose_shifting(&mut self, scene: &Scene, laws: &dyn ForceLaws, (body, fluid): (usize, &Item)) -> Result<()> {
        self.shifting = match Choice::of(method(fluid)?, "shifting")? {
            Choice::Given(coefficient) => {
                if coefficient > 0.0 {
                    self.check_shifting(scene, laws, (body, fluid), coefficient)?;
                }
                Choice::Given(coefficient)
            }
            // Adjacent fluids would mix.
            Choice::Auto if fluids(scene).nth(1).is_some() => Choice::Given(0.0),
            Choice::Auto if self.check_shifting(scene, laws, (body, fluid), SHIFTING).is_err() => Choice::Given(0.0),
            Choice::Auto => Choice::Auto,
        };
        Ok(())
    }

    /// Checks whether a fluid may be shifted.
    fn check_shifting(&self, scene: &Scene, laws: &dyn ForceLaws, (body, fluid): (usize, &Item), coefficient: f64) -> Result<()> {
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
        match scene.forces.iter().find(|item| laws.is_between_pairs(item) && item.acts_on(body)) {
            Some(item) => Err(Error::parameter(format!("{}.on", item.path), "no fluid that is shifted", &fluid.path)
                .with_hint("what a shift changes in the energy of pairs is not counted")),
            None => Ok(()),
        }
    }
}

impl CompressibleFluid {
    /// Fluid of a material with the parameters of a method, in a scene of `dimension` axes.
    fn new(material: &Material, method: &Item, sound_speed: f64, dimension: usize) -> Result<Self> {
        let Material { density, smoothing_length, viscosity, .. } = *material;
        let artificial_viscosity = match Choice::of(method, "artificial_viscosity")? {
            Choice::Auto => {
                let own = viscosity / (density * smoothing_length * sound_speed * share(dimension));
                (ARTIFICIAL - own).max(0.0)
            }
            Choice::Given(coefficient) => coefficient,
        };
        let density_diffusion = method.number("density_diffusion")?;
        Ok(Self { material: material.clone(), sound_speed, artificial_viscosity, density_diffusion })
    }

    /// Remark in the plan on the viscosity of a body of this material, if part of it is artificial.
    fn remark(&self, scene: &Scene, body: usize) -> Option<String> {
        let more = self.artificial() * share(scene.dimension);
        let (length, whole) = (sound::extent(scene), self.material.viscosity + more);
        let reynolds = self.material.density * self.sound_speed / sound::SOUND * length / whole;
        (more > 0.0).then(|| {
            format!(
                "bodies[{body}]: viscosity {whole:.1e} Pa·s, of which {more:.1e} are artificial (α = {:.2e}) and {:.1e} its own; at \
                 c/10 over {length:.3} m the Reynolds number is {reynolds:.0}, and grows with resolution",
                self.artificial_viscosity, self.material.viscosity,
            )
        })
    }
}

/// Ratio of the dynamic viscosity of an artificial viscosity to αhcρ₀, 1/2(D + 2): J. J. Monaghan, Rep. Prog. Phys. 68
/// (2005) 1703.
fn share(dimension: usize) -> f64 {
    1.0 / (2.0 * (dimension as f64 + 2.0))
}
