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
//! Where several materials of matter meet (`MIXED`), ρ₀, α and μ are those of the pair, nothing diffuses from kind to kind, and
//! obstacles do not push each other. The kind of a particle is the tag of its volume.

use super::images::Pressed;
use super::kernel::{Kernel, Shape};
use crate::math::{AXES, Real, Vector};
use crate::neighbors::sums::{Pair, PairLaw};
use crate::simd::{Number, Record};

/// The number of materials of matter: fluids, and obstacles.
pub const KINDS: usize = 4;
/// The tag of obstacles.
pub const OBSTACLE: u8 = 3;

/// The sums of [`Momentum`]: the force along each axis, and the powers that viscosity and solid matter take.
pub const FORCES: usize = AXES + 2;
pub const VISCOUS: usize = AXES;
pub const SOLID: usize = AXES + 1;

/// What is in a record behind the velocity.
#[inline(always)]
pub fn volume<V: Vector, N: Copy>(record: &Record<N>) -> N {
    record[2 * V::DIMENSION]
}

/// The second number there: the pressure p [Pa], or what enthalpy is in terms of density, ρ₀w/c² [kg/m³].
#[inline(always)]
pub fn content<V: Vector, N: Copy>(record: &Record<N>) -> N {
    record[2 * V::DIMENSION + 1]
}

/// v along one axis.
#[inline(always)]
fn velocity<V: Vector, N: Number>(pair: &Pair<N>, axis: usize) -> N {
    pair.own[V::DIMENSION + axis] - pair.other[V::DIMENSION + axis]
}

/// v·d.
#[inline(always)]
pub fn approach<V: Vector, N: Number>(pair: &Pair<N>) -> N {
    let mut sum = velocity::<V, N>(pair, 0) * pair.separation[0];
    for axis in 1..V::DIMENSION {
        sum += velocity::<V, N>(pair, axis) * pair.separation[axis];
    }
    sum
}

/// What belongs to the kind of a tagged number.
#[inline(always)]
pub fn pick<N: Number, const MIXED: bool>(tagged: N, values: &[N::Scalar; KINDS]) -> N
where
    N::Scalar: Copy,
{
    if !MIXED {
        return N::of(values[0]);
    }
    let (low, high) = (tagged.has_bit(0), tagged.has_bit(1));
    let even = N::select(high, N::of(values[2]), N::of(values[0]));
    let odd = N::select(high, N::of(values[3]), N::of(values[1]));
    N::select(low, odd, even)
}

/// Continuity: Σ Vⱼ v·∇W, and what diffusion adds to the rate of density.
#[derive(Debug, Clone, Copy)]
pub struct Continuity<T, K, const MIXED: bool> {
    pub kernel: Kernel<T, K>,
    /// 2δhc [m²/s] of each pair of materials, and those of the particle that is faced.
    pub diffusion: [[T; KINDS]; KINDS],
    pub for_particle: [T; KINDS],
    /// ρ₀ of each kind [kg/m³].
    pub density: [T; KINDS],
    /// g/c² [1/m], and times ρ₀ of the particle that is faced: the enthalpy that gravity makes per metre.
    pub gravity: [T; AXES],
    pub fall: [T; AXES],
}

impl<V: Vector, K: Shape, const MIXED: bool> PairLaw<V, 2> for Continuity<V::Scalar, K, MIXED> {
    #[inline(always)]
    fn for_particle(mut self, own: &Record<V::Scalar>) -> Self {
        if MIXED {
            let kind = usize::from(volume::<V, _>(own).tag());
            self.for_particle = self.diffusion[kind];
            for axis in 0..V::DIMENSION {
                self.fall[axis] = self.density[kind] * self.gravity[axis];
            }
        }
        self
    }

    #[inline(always)]
    fn terms<N: Number<Scalar = V::Scalar>>(&self, pair: &Pair<N>) -> [N; 2] {
        let Pair { own, other, separation, square } = pair;
        let weight = self.kernel.slope(volume::<V, N>(other), square.sqrt());
        let diffusion = pick::<N, MIXED>(volume::<V, N>(other), &self.for_particle);
        let mut excess = content::<V, N>(other) - content::<V, N>(own);
        for axis in 0..V::DIMENSION {
            excess += N::of(self.fall[axis]) * separation[axis];
        }
        [approach::<V, N>(pair) * weight, N::constant(0.0) - diffusion * excess * weight]
    }
}

/// Diffusion is not moved by what gravity makes of the density.
impl<V: Vector, K: Shape, const MIXED: bool> Pressed<V, 2> for Continuity<V::Scalar, K, MIXED> {
    #[inline(always)]
    fn density<N: Number<Scalar = V::Scalar>>(&self, other: &Record<N>) -> N {
        pick::<N, MIXED>(volume::<V, N>(other), &self.density)
    }
}

/// What two materials do to each other.
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
    pub for_particle: Touch<T>,
    /// ρ₀ of each kind [kg/m³].
    pub density: [T; KINDS],
    /// 0.01 h² [m²].
    pub softening: T,
}

impl<V: Vector, K: Shape, const MIXED: bool> PairLaw<V, FORCES> for Momentum<V::Scalar, K, MIXED> {
    #[inline(always)]
    fn for_particle(mut self, own: &Record<V::Scalar>) -> Self {
        if MIXED {
            self.for_particle = self.touch[usize::from(volume::<V, _>(own).tag())];
        }
        self
    }

    #[inline(always)]
    fn terms<N: Number<Scalar = V::Scalar>>(&self, pair: &Pair<N>) -> [N; FORCES] {
        let Pair { own, other, separation, .. } = pair;
        let weight = self.weight::<V, N>(pair);
        let Viscous { squeeze, shear, approach } = self.viscous::<V, N>(pair, weight);
        let push = squeeze - (content::<V, N>(own) + content::<V, N>(other)) * weight;
        let mut terms = [N::constant(0.0); FORCES];
        let mut drag = N::constant(0.0);
        for axis in 0..V::DIMENSION {
            let velocity = velocity::<V, N>(pair, axis);
            terms[axis] = push * separation[axis] + shear * velocity;
            drag += velocity * velocity;
        }
        terms[VISCOUS] = N::constant(0.0) - (squeeze * approach + shear * drag);
        if MIXED {
            // What an obstacle's pressure takes is stored nowhere: no energy belongs to it. Of a pair's power each counts half.
            let theirs = pick::<N, MIXED>(volume::<V, N>(other), &self.for_particle.met) * content::<V, N>(other);
            let mine = pick::<N, MIXED>(volume::<V, N>(other), &self.for_particle.meets) * content::<V, N>(own);
            terms[SOLID] = N::constant(0.5) * (theirs + mine) * weight * approach;
        }
        terms
    }
}

/// What viscosity does between two particles.
struct Viscous<N> {
    /// The force along d, over d.
    squeeze: N,
    /// The force along v, over v.
    shear: N,
    /// v·d.
    approach: N,
}

impl<T: Real, K: Shape, const MIXED: bool> Momentum<T, K, MIXED> {
    /// Vⱼ F, of those who push each other.
    #[inline(always)]
    fn weight<V: Vector<Scalar = T>, N: Number<Scalar = T>>(&self, pair: &Pair<N>) -> N {
        let volume = volume::<V, N>(&pair.other);
        let weight = self.kernel.slope(volume, pair.square.sqrt());
        if MIXED { weight * pick::<N, MIXED>(volume, &self.for_particle.contact) } else { weight }
    }

    #[inline(always)]
    fn viscous<V: Vector<Scalar = T>, N: Number<Scalar = T>>(&self, pair: &Pair<N>, weight: N) -> Viscous<N> {
        let (volume, approach) = (volume::<V, N>(&pair.other), approach::<V, N>(pair));
        let artificial =
            pick::<N, MIXED>(volume, &self.for_particle.artificial) * approach / (pair.square + N::of(self.softening));
        let laminar = pick::<N, MIXED>(volume, &self.for_particle.laminar);
        Viscous { squeeze: artificial * weight, shear: laminar * weight, approach }
    }
}

impl<V: Vector, K: Shape, const MIXED: bool> Pressed<V, FORCES> for Momentum<V::Scalar, K, MIXED> {
    #[inline(always)]
    fn density<N: Number<Scalar = V::Scalar>>(&self, other: &Record<N>) -> N {
        pick::<N, MIXED>(volume::<V, N>(other), &self.density)
    }

    /// A ceiling does not hold a drop by suction.
    #[inline(always)]
    fn raised<N: Number<Scalar = V::Scalar>>(&self, content: N, by: N) -> N {
        let least = content.min(N::constant(0.0));
        let raised = content + by;
        N::select(N::constant(0.0).less(by), raised, raised.max(least))
    }

    #[inline(always)]
    fn lift<N: Number<Scalar = V::Scalar>>(&self, pair: &Pair<N>, by: N) -> [N; FORCES] {
        let Pair { own, separation, .. } = pair;
        let weight = self.weight::<V, N>(pair);
        let Viscous { squeeze, shear, approach } = self.viscous::<V, N>(pair, weight);
        let mut terms = [N::constant(0.0); FORCES];
        // Of what a pair loses half is counted here: twice the particle's own loss instead of that of the pair.
        terms[VISCOUS] = squeeze * approach;
        for axis in 0..V::DIMENSION {
            let mine = own[V::DIMENSION + axis];
            let relative = velocity::<V, N>(pair, axis);
            // What gravity adds to the pressure of an image is stored nowhere either.
            terms[SOLID] += by * weight * separation[axis] * mine;
            let loss = shear * relative * relative - N::constant(2.0) * (squeeze * separation[axis] + shear * relative) * mine;
            terms[VISCOUS] += loss;
        }
        terms
    }
}

/// Crowding: Σ Vⱼ W, by which density is counted.
#[derive(Debug, Clone, Copy)]
pub struct NumberDensity<T, K> {
    pub kernel: Kernel<T, K>,
}

impl<V: Vector, K: Shape> PairLaw<V, 1> for NumberDensity<V::Scalar, K> {
    #[inline(always)]
    fn terms<N: Number<Scalar = V::Scalar>>(&self, pair: &Pair<N>) -> [N; 1] {
        [volume::<V, N>(&pair.other) * self.kernel.value(pair.square.sqrt())]
    }
}

impl<V: Vector, K: Shape> Pressed<V, 1> for NumberDensity<V::Scalar, K> {}

/// Surroundings: Σ Vⱼ ∇W along each axis [1/m], nothing where others are all around and the more the barer a side is; and
/// Σ Vⱼ |∇W|, the more the closer they are.
#[derive(Debug, Clone, Copy)]
pub struct KernelGradientSum<T, K> {
    pub kernel: Kernel<T, K>,
}

/// The sums of [`KernelGradientSum`].
pub const SURROUNDINGS: usize = AXES + 1;

impl<V: Vector, K: Shape> PairLaw<V, SURROUNDINGS> for KernelGradientSum<V::Scalar, K> {
    #[inline(always)]
    fn terms<N: Number<Scalar = V::Scalar>>(&self, pair: &Pair<N>) -> [N; SURROUNDINGS] {
        let (distance, zero) = (pair.square.sqrt(), N::constant(0.0));
        let weight = self.kernel.slope(volume::<V, N>(&pair.other), distance);
        let mut terms = [zero; SURROUNDINGS];
        for axis in 0..V::DIMENSION {
            terms[axis] = weight * pair.separation[axis];
        }
        // Beyond the support the distance is infinite where there is nobody.
        terms[AXES] = N::select(weight.less(zero), zero - weight * distance, zero);
        terms
    }
}

impl<V: Vector, K: Shape> Pressed<V, SURROUNDINGS> for KernelGradientSum<V::Scalar, K> {}

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

impl<V: Vector, K: Shape> PairLaw<V, 2> for Extrapolation<V::Scalar, K> {
    #[inline(always)]
    fn terms<N: Number<Scalar = V::Scalar>>(&self, pair: &Pair<N>) -> [N; 2] {
        let Pair { other, separation, square, .. } = pair;
        let volume = volume::<V, N>(other);
        // The tag of obstacles has both bits.
        let obstacle = N::both(volume.has_bit(0), volume.has_bit(1));
        let weight = N::select(obstacle, N::constant(0.0), self.kernel.value(square.sqrt()));
        let mut rise = N::constant(0.0);
        for axis in 0..V::DIMENSION {
            rise += N::of(self.gravity[axis]) * separation[axis];
        }
        [(content::<V, N>(other) + pick::<N, true>(volume, &self.density) * rise) * weight, weight]
    }
}
