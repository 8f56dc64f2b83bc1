//! Equation of state of a weakly compressible fluid.

use crate::particles::Material;

/// Exponent γ of the equation of state.
const GAMMA: i32 = 7;

/// Fluid with its equation of state, and with the coefficients of its dissipation.
#[derive(Debug, Clone, PartialEq)]
pub struct CompressibleFluid {
    pub material: Material,
    /// Speed of sound c at rest [m/s].
    pub sound_speed: f64,
    /// Coefficient α of the artificial viscosity.
    pub artificial_viscosity: f64,
    /// Coefficient δ of the diffusion of density.
    pub density_diffusion: f64,
}

impl CompressibleFluid {
    /// Pressure at a density [Pa]: p = c²ρ₀/γ ((ρ/ρ₀)^γ − 1).
    ///
    /// Source: R. H. Cole, Underwater Explosions (1948).
    #[inline(always)]
    pub fn pressure(&self, density: f64) -> f64 {
        let ratio = density / self.material.density;
        let cube = ratio * ratio * ratio;
        self.stiffness() * (cube * cube * ratio - 1.0)
    }

    /// Density at a pressure [kg/m³].
    #[inline]
    pub fn density_under(&self, pressure: f64) -> f64 {
        self.material.density * libm::pow(1.0 + pressure / self.stiffness(), 1.0 / f64::from(GAMMA))
    }

    /// Specific energy of compression [J/kg]: ∫ p/ρ² dρ from ρ₀, which is c²/γ [s^(γ−1)/(γ−1) + 1/s − γ/(γ−1)] with s = ρ/ρ₀.
    #[inline]
    pub fn energy(&self, density: f64) -> f64 {
        let ratio = density / self.material.density;
        let sixth = ratio.powi(GAMMA - 1);
        self.sound_speed.powi(2) / 7.0 * (sixth / 6.0 + 1.0 / ratio - 7.0 / 6.0)
    }

    /// Enthalpy in units of density [kg/m³]: ρ₀w/c² with w = ∫ dp/ρ = c²/(γ−1) (s^(γ−1) − 1), s = ρ/ρ₀.
    #[inline(always)]
    pub fn enthalpy(&self, density: f64) -> f64 {
        let ratio = density / self.material.density;
        let cube = ratio * ratio * ratio;
        self.material.density * (1.0 / f64::from(GAMMA - 1)) * (cube * cube - 1.0)
    }

    /// Speed of sound at a density [m/s].
    #[inline]
    pub fn sound_at(&self, density: f64) -> f64 {
        self.sound_speed * (density / self.material.density).powi((GAMMA - 1) / 2)
    }

    /// Artificial viscosity αhcρ₀ of a pair [Pa·s].
    #[inline]
    pub fn artificial(&self) -> f64 {
        self.artificial_viscosity * self.material.smoothing_length * self.sound_speed * self.material.density
    }

    /// Diffusivity of density between two particles, 2δhc [m²/s].
    #[inline]
    pub fn diffusion(&self) -> f64 {
        2.0 * self.density_diffusion * self.material.smoothing_length * self.sound_speed
    }

    /// Coefficient c²ρ₀/γ of the equation of state [Pa].
    #[inline(always)]
    fn stiffness(&self) -> f64 {
        self.sound_speed * self.sound_speed * self.material.density * (1.0 / f64::from(GAMMA))
    }
}
