//! The sums of a weakly compressible fluid: what changes density, and what changes velocity.
//!
//! With d = xᵢ − xⱼ, v = vᵢ − vⱼ, the volume V = m/ρ and ∇W = F d, in the form of S. Marrone et al., Comput. Methods Appl. Mech.
//! Eng. 200 (2011) 1526 (δ-SPH), whose pressures take exactly as much energy from the motion as they give to compression:
//!
//! ```text
//! dρᵢ/dt = ρᵢ Σ Vⱼ v·∇W − 2δhc ρ₀/c² Σ Vⱼ [wⱼ − wᵢ − g·(xⱼ − xᵢ)] F
//!     Fᵢ = −Vᵢ Σ Vⱼ (pᵢ + pⱼ) ∇W + Vᵢ Σ Vⱼ αhcρ₀ v·d/(d² + 0.01h²) ∇W + Vᵢ Σ Vⱼ 2μ F v
//! ```
//!
//! Diffusion evens out the enthalpy w beyond what gravity makes of it at rest, as that of density does in G. Fourtakas et al.,
//! Comput. Fluids 190 (2019) 346, to first order in w/c²; in w it is exactly nothing in a fluid at rest. The artificial
//! viscosity is J. J. Monaghan and R. A. Gingold's, J. Comput. Phys. 52 (1983) 374; the laminar one that of J. P. Morris, P. J.
//! Fox and Y. Zhu, J. Comput. Phys. 136 (1997) 214, which is far more accurate in shear.
//!
//! Where several kinds of matter meet (`MIXED`), ρ₀, α and μ are those of the pair, nothing diffuses from kind to kind, and
//! obstacles do not push each other. The kind of a particle is the tag of its volume.

use super::images::Pressed;
use super::kernel::{Kernel, Shape};
use crate::math::{AXES, Real, Vector};
use crate::neighbors::sums::PairLaw;
use crate::simd::Record;

/// The number of kinds of matter: fluids, and obstacles.
pub const KINDS: usize = 4;
/// The tag of obstacles.
pub const OBSTACLE: u8 = 3;

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
pub fn approach<V: Vector>(own: &Record<V::Scalar>, other: &Record<V::Scalar>, apart: [V::Scalar; AXES]) -> V::Scalar {
    let mut sum = V::Scalar::ZERO;
    for axis in 0..V::DIMENSION {
        sum += (own[V::DIMENSION + axis] - other[V::DIMENSION + axis]) * apart[axis];
    }
    sum
}

/// What belongs to the kind of a tagged number.
#[inline(always)]
fn pick<T: Real, const MIXED: bool>(tagged: T, values: &[T; KINDS]) -> T {
    if !MIXED {
        return values[0];
    }
    let even = if tagged.has_tag_bit(1) { values[2] } else { values[0] };
    let odd = if tagged.has_tag_bit(1) { values[3] } else { values[1] };
    if tagged.has_tag_bit(0) { odd } else { even }
}

/// Continuity: Σ Vⱼ v·∇W, and what diffusion adds to the rate of density.
#[derive(Debug, Clone, Copy)]
pub struct Continuity<T, K, const MIXED: bool> {
    pub kernel: Kernel<T, K>,
    /// 2δhc [m²/s] of each pair of kinds, and those of the particle that is faced.
    pub diffusion: [[T; KINDS]; KINDS],
    pub faced: [T; KINDS],
    /// ρ₀ of each kind [kg/m³].
    pub density: [T; KINDS],
    /// g/c² [1/m], and times ρ₀ of the particle that is faced: the enthalpy that gravity makes per metre.
    pub gravity: [T; AXES],
    pub fall: [T; AXES],
}

impl<V: Vector, K: Shape<V::Scalar>, const MIXED: bool> PairLaw<V, 2> for Continuity<V::Scalar, K, MIXED> {
    #[inline(always)]
    fn facing(mut self, own: &Record<V::Scalar>) -> Self {
        if MIXED {
            let kind = usize::from(volume::<V>(own).tag());
            self.faced = self.diffusion[kind];
            for axis in 0..V::DIMENSION {
                self.fall[axis] = self.density[kind] * self.gravity[axis];
            }
        }
        self
    }

    #[inline(always)]
    fn terms(
        &self,
        own: &Record<V::Scalar>,
        other: &Record<V::Scalar>,
        apart: [V::Scalar; AXES],
        square: V::Scalar,
    ) -> [V::Scalar; 2] {
        let weight = self.kernel.slope(volume::<V>(other), square.sqrt());
        let diffusion = pick::<_, MIXED>(volume::<V>(other), &self.faced);
        let mut excess = content::<V>(other) - content::<V>(own);
        for axis in 0..V::DIMENSION {
            excess += self.fall[axis] * apart[axis];
        }
        [approach::<V>(own, other, apart) * weight, V::Scalar::ZERO - diffusion * excess * weight]
    }
}

/// Diffusion is not moved by what gravity makes of the density.
impl<V: Vector, K: Shape<V::Scalar>, const MIXED: bool> Pressed<V, 2> for Continuity<V::Scalar, K, MIXED> {
    #[inline(always)]
    fn density(&self, other: &Record<V::Scalar>) -> V::Scalar {
        pick::<_, MIXED>(volume::<V>(other), &self.density)
    }
}

/// What two kinds do to each other.
#[derive(Debug, Clone, Copy)]
pub struct Touch<T> {
    /// αhcρ₀ [Pa·s].
    pub artificial: [T; KINDS],
    /// 2μ [Pa·s].
    pub laminar: [T; KINDS],
    /// 1 for those who push each other, 0 for obstacles.
    pub contact: [T; KINDS],
    /// 1 where the other is an obstacle and this is none, and the other way round.
    pub met: [T; KINDS],
    pub meets: [T; KINDS],
}

/// Momentum: the force over Vᵢ along each axis [N/m^D], and powers, likewise.
#[derive(Debug, Clone, Copy)]
pub struct Momentum<T, K, const MIXED: bool> {
    pub kernel: Kernel<T, K>,
    /// What each kind does to each other, and what that of the particle that is faced does.
    pub touch: [Touch<T>; KINDS],
    pub faced: Touch<T>,
    /// ρ₀ of each kind [kg/m³].
    pub density: [T; KINDS],
    /// 0.01 h² [m²].
    pub softening: T,
}

impl<V: Vector, K: Shape<V::Scalar>, const MIXED: bool> PairLaw<V, FORCES> for Momentum<V::Scalar, K, MIXED> {
    #[inline(always)]
    fn facing(mut self, own: &Record<V::Scalar>) -> Self {
        if MIXED {
            self.faced = self.touch[usize::from(volume::<V>(own).tag())];
        }
        self
    }

    #[inline(always)]
    fn terms(
        &self,
        own: &Record<V::Scalar>,
        other: &Record<V::Scalar>,
        apart: [V::Scalar; AXES],
        square: V::Scalar,
    ) -> [V::Scalar; FORCES] {
        let zero = V::Scalar::ZERO;
        let weight = self.weight::<V>(other, square);
        let Viscous { squeeze, shear, approach } = self.viscous::<V>(own, other, apart, square, weight);
        let push = squeeze - (content::<V>(own) + content::<V>(other)) * weight;
        let mut terms = [zero; FORCES];
        let mut drag = zero;
        for axis in 0..V::DIMENSION {
            let velocity = own[V::DIMENSION + axis] - other[V::DIMENSION + axis];
            terms[axis] = push * apart[axis] + shear * velocity;
            drag += velocity * velocity;
        }
        terms[VISCOUS] = zero - (squeeze * approach + shear * drag);
        if MIXED {
            // What an obstacle's pressure takes is stored nowhere: no energy belongs to it.
            let theirs = pick::<_, MIXED>(volume::<V>(other), &self.faced.met) * content::<V>(other);
            let mine = pick::<_, MIXED>(volume::<V>(other), &self.faced.meets) * content::<V>(own);
            terms[VISCOUS] += (theirs + mine) * weight * approach;
        }
        terms
    }
}

/// What viscosity does between two particles.
struct Viscous<T> {
    /// The force along d, over d.
    squeeze: T,
    /// The force along v, over v.
    shear: T,
    /// v·d.
    approach: T,
}

impl<T: Real, K: Shape<T>, const MIXED: bool> Momentum<T, K, MIXED> {
    /// Vⱼ F, of those who push each other.
    #[inline(always)]
    fn weight<V: Vector<Scalar = T>>(&self, other: &Record<T>, square: T) -> T {
        let weight = self.kernel.slope(volume::<V>(other), square.sqrt());
        if MIXED { weight * pick::<_, MIXED>(volume::<V>(other), &self.faced.contact) } else { weight }
    }

    #[inline(always)]
    fn viscous<V: Vector<Scalar = T>>(
        &self,
        own: &Record<T>,
        other: &Record<T>,
        apart: [T; AXES],
        square: T,
        weight: T,
    ) -> Viscous<T> {
        let approach = approach::<V>(own, other, apart);
        let artificial = pick::<_, MIXED>(volume::<V>(other), &self.faced.artificial) * approach / (square + self.softening);
        let laminar = pick::<_, MIXED>(volume::<V>(other), &self.faced.laminar);
        Viscous { squeeze: artificial * weight, shear: laminar * weight, approach }
    }
}

impl<V: Vector, K: Shape<V::Scalar>, const MIXED: bool> Pressed<V, FORCES> for Momentum<V::Scalar, K, MIXED> {
    #[inline(always)]
    fn density(&self, other: &Record<V::Scalar>) -> V::Scalar {
        pick::<_, MIXED>(volume::<V>(other), &self.density)
    }

    /// A ceiling does not hold a drop by suction.
    #[inline(always)]
    fn raised(&self, content: V::Scalar, by: V::Scalar) -> V::Scalar {
        let least = if content < V::Scalar::ZERO { content } else { V::Scalar::ZERO };
        let raised = content + by;
        if raised > least || by > V::Scalar::ZERO { raised } else { least }
    }

    #[inline(always)]
    fn lift(
        &self,
        own: &Record<V::Scalar>,
        other: &Record<V::Scalar>,
        apart: [V::Scalar; AXES],
        square: V::Scalar,
        by: V::Scalar,
    ) -> [V::Scalar; FORCES] {
        let weight = self.weight::<V>(other, square);
        let Viscous { squeeze, shear, approach } = self.viscous::<V>(own, other, apart, square, weight);
        let two = V::Scalar::from_f64(2.0);
        let mut terms = [V::Scalar::ZERO; FORCES];
        // Of what a pair loses half is counted here: twice the particle's own loss instead of that of the pair.
        terms[VISCOUS] = squeeze * approach;
        for axis in 0..V::DIMENSION {
            let mine = own[V::DIMENSION + axis];
            let relative = mine - other[V::DIMENSION + axis];
            terms[LIFT] -= by * weight * apart[axis] * mine;
            terms[VISCOUS] += shear * relative * relative - two * (squeeze * apart[axis] + shear * relative) * mine;
        }
        terms
    }
}

/// Crowding: Σ Vⱼ W, by which density is counted.
#[derive(Debug, Clone, Copy)]
pub struct Crowding<T, K> {
    pub kernel: Kernel<T, K>,
}

impl<V: Vector, K: Shape<V::Scalar>> PairLaw<V, 1> for Crowding<V::Scalar, K> {
    #[inline(always)]
    fn terms(
        &self,
        _own: &Record<V::Scalar>,
        other: &Record<V::Scalar>,
        _apart: [V::Scalar; AXES],
        square: V::Scalar,
    ) -> [V::Scalar; 1] {
        [volume::<V>(other) * self.kernel.value(square.sqrt())]
    }
}

impl<V: Vector, K: Shape<V::Scalar>> Pressed<V, 1> for Crowding<V::Scalar, K> {}

/// The pressure of an obstacle: that of the fluid around it, and what gravity adds on the way: Σ [pⱼ + ρ₀ g·d] W and Σ W, of S.
/// Adami, X. Y. Hu and N. A. Adams, J. Comput. Phys. 231 (2012) 7057, for obstacles that are not themselves accelerated.
#[derive(Debug, Clone, Copy)]
pub struct Extrapolation<T, K> {
    pub kernel: Kernel<T, K>,
    /// ρ₀ of each kind [kg/m³], and 0 for obstacles.
    pub density: [T; KINDS],
    /// g [m/s²].
    pub gravity: [T; AXES],
}

impl<V: Vector, K: Shape<V::Scalar>> PairLaw<V, 2> for Extrapolation<V::Scalar, K> {
    #[inline(always)]
    fn terms(
        &self,
        _own: &Record<V::Scalar>,
        other: &Record<V::Scalar>,
        apart: [V::Scalar; AXES],
        square: V::Scalar,
    ) -> [V::Scalar; 2] {
        let fluid = volume::<V>(other).tag() != OBSTACLE;
        let weight = if fluid { self.kernel.value(square.sqrt()) } else { V::Scalar::ZERO };
        let mut rise = V::Scalar::ZERO;
        for axis in 0..V::DIMENSION {
            rise += self.gravity[axis] * apart[axis];
        }
        [(content::<V>(other) + pick::<_, true>(volume::<V>(other), &self.density) * rise) * weight, weight]
    }
}
