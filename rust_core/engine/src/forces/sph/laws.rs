//! The two sums of a weakly compressible fluid: what changes density, and what changes velocity.
//!
//! With d = xᵢ − xⱼ, v = vᵢ − vⱼ, the volume V = m/ρ and ∇W = F d, in the form of S. Marrone et al., Comput. Methods Appl. Mech.
//! Eng. 200 (2011) 1526 (δ-SPH), whose two sums exchange exactly as much energy as they each take:
//!
//! ```text
//! dρᵢ/dt = ρᵢ Σ Vⱼ v·∇W − 2δhc Σ Vⱼ (ρⱼ − ρᵢ − ρᴴ) F
//!     Fᵢ = −Vᵢ Σ Vⱼ (pᵢ + pⱼ) ∇W + Vᵢ Σ Vⱼ [2(D+2) μ + αhcρ₀] v·d/(d² + 0.01 h²) ∇W
//! ```
//!
//! ρᴴ = ρ₀ g·(xⱼ − xᵢ)/c² is what gravity makes of the density between the two at rest, and is not diffused away (G. Fourtakas
//! et al., Comput. Fluids 190 (2019) 346). The viscous term conserves angular momentum (J. J. Monaghan, R. A. Gingold, J. Comput.
//! Phys. 52 (1983) 374; its coefficient for the dynamic viscosity μ: J. J. Monaghan, Rep. Prog. Phys. 68 (2005) 1703).

use super::images::Pressed;
use super::kernel::{Kernel, Shape};
use crate::math::{AXES, Real, Vector};
use crate::neighbors::sums::PairLaw;
use crate::simd::Record;

/// What is in a record behind the velocity.
#[inline(always)]
pub fn volume<V: Vector>(record: &Record<V::Scalar>) -> V::Scalar {
    record[2 * V::DIMENSION]
}

/// The second number there: pressure [Pa], or density [kg/m³] where density is what changes.
#[inline(always)]
pub fn content<V: Vector>(record: &Record<V::Scalar>) -> V::Scalar {
    record[2 * V::DIMENSION + 1]
}

/// v·d.
#[inline(always)]
fn approach<V: Vector>(own: &Record<V::Scalar>, other: &Record<V::Scalar>, apart: [V::Scalar; AXES]) -> V::Scalar {
    let mut sum = V::Scalar::ZERO;
    for axis in 0..V::DIMENSION {
        sum += (own[V::DIMENSION + axis] - other[V::DIMENSION + axis]) * apart[axis];
    }
    sum
}

/// Continuity: Σ Vⱼ v·∇W, and what diffusion adds to the rate of density.
#[derive(Debug, Clone, Copy)]
pub struct Continuity<T, K> {
    pub kernel: Kernel<T, K>,
    /// 2δhc [m²/s].
    pub diffusion: T,
    /// ρ₀ g/c² [kg/m⁴].
    pub stratification: [T; AXES],
    /// 1/c² [s²/m²].
    pub compliance: T,
}

/// Momentum: the force over Vᵢ along each axis [N/m^D], and the power that viscosity takes, likewise.
#[derive(Debug, Clone, Copy)]
pub struct Momentum<T, K> {
    pub kernel: Kernel<T, K>,
    /// 2(D+2) μ + αhcρ₀ [Pa·s].
    pub viscosity: T,
    /// 0.01 h² [m²].
    pub softening: T,
}

impl<V: Vector, K: Shape<V::Scalar>> PairLaw<V, 2> for Continuity<V::Scalar, K> {
    #[inline(always)]
    fn terms(
        &self,
        own: &Record<V::Scalar>,
        other: &Record<V::Scalar>,
        apart: [V::Scalar; AXES],
        square: V::Scalar,
    ) -> [V::Scalar; 2] {
        let weight = volume::<V>(other) * self.kernel.slope(square.sqrt());
        let mut excess = content::<V>(other) - content::<V>(own);
        for axis in 0..V::DIMENSION {
            excess += self.stratification[axis] * apart[axis];
        }
        [approach::<V>(own, other, apart) * weight, V::Scalar::ZERO - self.diffusion * excess * weight]
    }
}

impl<V: Vector, K: Shape<V::Scalar>> Pressed<V> for Continuity<V::Scalar, K> {
    #[inline(always)]
    fn press(&self, record: &mut Record<V::Scalar>, by: V::Scalar) {
        record[2 * V::DIMENSION + 1] += by * self.compliance;
    }
}

impl<V: Vector, K: Shape<V::Scalar>> PairLaw<V, { AXES + 1 }> for Momentum<V::Scalar, K> {
    #[inline(always)]
    fn terms(
        &self,
        own: &Record<V::Scalar>,
        other: &Record<V::Scalar>,
        apart: [V::Scalar; AXES],
        square: V::Scalar,
    ) -> [V::Scalar; AXES + 1] {
        let weight = volume::<V>(other) * self.kernel.slope(square.sqrt());
        let approach = approach::<V>(own, other, apart);
        let viscous = self.viscosity * approach / (square + self.softening);
        let push = (viscous - (content::<V>(own) + content::<V>(other))) * weight;
        let mut terms = [V::Scalar::ZERO; AXES + 1];
        for axis in 0..V::DIMENSION {
            terms[axis] = push * apart[axis];
        }
        terms[AXES] = V::Scalar::ZERO - viscous * weight * approach;
        terms
    }
}

impl<V: Vector, K: Shape<V::Scalar>> Pressed<V> for Momentum<V::Scalar, K> {
    #[inline(always)]
    fn press(&self, record: &mut Record<V::Scalar>, by: V::Scalar) {
        record[2 * V::DIMENSION + 1] += by;
    }
}
