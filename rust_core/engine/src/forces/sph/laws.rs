//! The two sums of a weakly compressible fluid: what changes density, and what changes velocity.
//!
//! With d = xᵢ − xⱼ, v = vᵢ − vⱼ, the volume V = m/ρ and ∇W = F d, in the form of S. Marrone et al., Comput. Methods Appl. Mech.
//! Eng. 200 (2011) 1526 (δ-SPH), whose pressures take exactly as much energy from the motion as they give to compression:
//!
//! ```text
//! dρᵢ/dt = ρᵢ Σ Vⱼ v·∇W − 2δhc ρ₀/c² Σ Vⱼ [wⱼ − wᵢ − g·(xⱼ − xᵢ)] F
//!     Fᵢ = −Vᵢ Σ Vⱼ (pᵢ + pⱼ) ∇W + Vᵢ Σ Vⱼ αhcρ₀ v·d/(d² + 0.01h²) ∇W + Vᵢ Σ Vⱼ 2μ d²/(d² + 0.01h²) F v
//! ```
//!
//! Diffusion evens out the enthalpy w beyond what gravity makes of it at rest, as that of density does in G. Fourtakas et al.,
//! Comput. Fluids 190 (2019) 346, to first order in w/c²; in w it is exactly nothing in a fluid at rest. The artificial
//! viscosity is J. J. Monaghan and R. A. Gingold's, J. Comput. Phys. 52 (1983) 374; the laminar one that of J. P. Morris, P. J.
//! Fox and Y. Zhu, J. Comput. Phys. 136 (1997) 214, which is far more accurate in shear.

use super::images::Pressed;
use super::kernel::{Kernel, Shape};
use crate::math::{AXES, Real, Vector};
use crate::neighbors::sums::PairLaw;
use crate::simd::Record;

/// The sums of [`Momentum`]: the force along each axis, the power that viscosity takes, and that of walls against gravity.
pub const FORCES: usize = AXES + 2;
pub const VISCOUS: usize = AXES;
pub const LIFT: usize = AXES + 1;

/// What is in a record behind the velocity.
#[inline(always)]
pub fn volume<V: Vector>(record: &Record<V::Scalar>) -> V::Scalar {
    record[2 * V::DIMENSION]
}

/// The second number there: the pressure p [Pa], or what enthalpy is in terms of density, ρ₀w/c² [kg/m³].
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
    /// ρ₀ g/c² [kg/m⁴], the enthalpy that gravity makes per metre, likewise.
    pub stratification: [T; AXES],
}

/// Momentum: the force over Vᵢ along each axis [N/m^D], and powers, likewise.
#[derive(Debug, Clone, Copy)]
pub struct Momentum<T, K> {
    pub kernel: Kernel<T, K>,
    /// αhcρ₀ [Pa·s].
    pub artificial: T,
    /// 2μ [Pa·s].
    pub laminar: T,
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

impl<V: Vector, K: Shape<V::Scalar>> Pressed<V, 2> for Continuity<V::Scalar, K> {
    /// Diffusion is not moved by what gravity makes of the density.
    #[inline(always)]
    fn lift(
        &self,
        _own: &Record<V::Scalar>,
        _other: &Record<V::Scalar>,
        _apart: [V::Scalar; AXES],
        _square: V::Scalar,
        _by: V::Scalar,
    ) -> [V::Scalar; 2] {
        [V::Scalar::ZERO; 2]
    }
}

impl<V: Vector, K: Shape<V::Scalar>> PairLaw<V, FORCES> for Momentum<V::Scalar, K> {
    #[inline(always)]
    fn terms(
        &self,
        own: &Record<V::Scalar>,
        other: &Record<V::Scalar>,
        apart: [V::Scalar; AXES],
        square: V::Scalar,
    ) -> [V::Scalar; FORCES] {
        let zero = V::Scalar::ZERO;
        let weight = volume::<V>(other) * self.kernel.slope(square.sqrt());
        let approach = approach::<V>(own, other, apart);
        let inverse = V::Scalar::ONE / (square + self.softening);
        let squeeze = self.artificial * approach * inverse;
        // Of those who are nowhere, the square is infinite.
        let near = if square < V::Scalar::INFINITY { square * inverse } else { zero };
        let shear = self.laminar * near * weight;
        let push = (squeeze - (content::<V>(own) + content::<V>(other))) * weight;
        let mut terms = [zero; FORCES];
        let mut drag = zero;
        for axis in 0..V::DIMENSION {
            let velocity = own[V::DIMENSION + axis] - other[V::DIMENSION + axis];
            terms[axis] = push * apart[axis] + shear * velocity;
            drag += velocity * velocity;
        }
        terms[VISCOUS] = zero - (squeeze * weight * approach + shear * drag);
        terms
    }
}

impl<V: Vector, K: Shape<V::Scalar>> Pressed<V, FORCES> for Momentum<V::Scalar, K> {
    #[inline(always)]
    fn lift(
        &self,
        own: &Record<V::Scalar>,
        other: &Record<V::Scalar>,
        apart: [V::Scalar; AXES],
        square: V::Scalar,
        by: V::Scalar,
    ) -> [V::Scalar; FORCES] {
        let push = by * volume::<V>(other) * self.kernel.slope(square.sqrt());
        let mut terms = [V::Scalar::ZERO; FORCES];
        for axis in 0..V::DIMENSION {
            terms[LIFT] = terms[LIFT] - push * apart[axis] * own[V::DIMENSION + axis];
        }
        terms
    }
}
