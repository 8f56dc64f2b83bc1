//! Pair laws of a weakly compressible fluid: continuity and momentum.
//!
//! With d = xᵢ − xⱼ, v = vᵢ − vⱼ, the volume V = m/ρ and ∇W = F d, the equations are those of δ-SPH. Its pressure forces conserve
//! kinetic plus compression energy exactly:
//!
//! ```text
//! dρᵢ/dt = ρᵢ Σ Vⱼ v·∇W − 2δhc ρ₀/c² Σ Vⱼ [wⱼ − wᵢ − g·(xⱼ − xᵢ)] F
//!     Fᵢ = −Vᵢ Σ Vⱼ (pᵢ + pⱼ) ∇W + Vᵢ Σ Vⱼ [αhcρ₀/(d² + 0.01h²) + 2μ/σ²] v·d ∇W
//! ```
//!
//! Diffusion acts on the enthalpy w minus its hydrostatic part, and vanishes exactly in a fluid at rest. To first order in w/c²,
//! this is the diffusion of density minus its hydrostatic part.
//!
//! **Viscosity.** Both viscous forces act along d and are proportional to v·d. Angular momentum is therefore conserved pair by
//! pair, and a rigid rotation feels none of them, even at a free surface. For any such force A(d) v·d d, the quadratic terms of a
//! flow give ∇²v + 2∇∇·v times ½∫A x²y² dV, which is free of traction at a free surface.
//!
//! Here A ∝ F instead of the usual A ∝ F/d². The integral is then −σ², the variance of W along an axis, and the sum over a
//! lattice is closer to it. With the default kernel, shear along an axis of a square lattice feels 0.999 of μ, and along its
//! diagonals 1.047. With A ∝ F/d² these factors are 0.89 and 1.11.
//!
//! A single fluid without a free surface and obstacles has the force Vᵢ Σ Vⱼ 2μ F v instead, which gives ∇²v. Where ∇·v = 0 this
//! is the same, except at surfaces. It is more isotropic on a lattice, and permits steps up to 1.6 times as long. However, it
//! would slow down a drop in rigid rotation.
//!
//! With several materials (`MIXED`), ρ₀, α and μ are those of the pair. There is no diffusion between materials, and obstacles do
//! not interact with each other. The material of a particle is the tag of its volume. Where a particle separates from an obstacle
//! at a free surface, the tag of its pressure gives the fraction that acts on obstacles ([`super::surface`]).
//!
//! Sources: for δ-SPH S. Marrone et al., Comput. Methods Appl. Mech. Eng. 200 (2011) 1526; for diffusion of density minus its
//! hydrostatic part G. Fourtakas et al., Comput. Fluids 190 (2019) 346; for the artificial viscosity J. J. Monaghan and R. A.
//! Gingold, J. Comput. Phys. 52 (1983) 374; for viscous forces at a free surface A. Colagrossi, M. Antuono, A. Souto-Iglesias, D.
//! Le Touzé, Phys. Rev. E 84 (2011) 026705; for A ∝ F/d² J. J. Monaghan, Rep. Prog. Phys. 68 (2005) 1703; for the force along v
//! J. P. Morris, P. J. Fox and Y. Zhu, J. Comput. Phys. 136 (1997) 214.

use crate::math::{AXES, Real, Vector};
use crate::neighbors::sums::{Pair, PairLaw};
use crate::particles::images::ImagePressure;
use crate::particles::kernel::{KernelShape, SmoothingKernel};
use crate::particles::records::{approach, content, is_obstacle, pick, velocity, volume};
use crate::particles::{KINDS, OBSTACLE};
use crate::simd::{Number, ParticleRecord};

/// Number of sums of [`Momentum`]: the force along each axis, the power of viscous forces, and the power dissipated by obstacle
/// pressures. The viscous power counts twice, and is negative where it is dissipated.
pub const FORCES: usize = AXES + 2;
pub const VISCOUS: usize = AXES;
pub const SOLID: usize = AXES + 1;

/// Number of sums of [`Continuity`].
pub const RATES: usize = 3;

/// Continuity: Σ Vⱼ v·∇W over fluids [1/s], the diffusive rate of density [kg/(m³·s)], and Σ Vⱼ v·∇W over obstacles [1/s].
#[derive(Debug, Clone, Copy)]
pub struct Continuity<T, K, const MIXED: bool> {
    pub kernel: SmoothingKernel<T, K>,
    /// Diffusivity 2δhc [m²/s] of each pair of materials, and its row for the particle's material.
    pub diffusion: [[T; KINDS]; KINDS],
    pub for_particle: [T; KINDS],
    /// Rest density ρ₀ of each material [kg/m³].
    pub density: [T; KINDS],
    /// Ratio g/c² [1/m], and its product with ρ₀ of the particle: the hydrostatic gradient of enthalpy.
    pub gravity: [T; AXES],
    pub fall: [T; AXES],
}

impl<V: Vector, K: KernelShape, const MIXED: bool> PairLaw<V, RATES> for Continuity<V::Scalar, K, MIXED> {
    #[inline(always)]
    fn for_particle(mut self, own: &ParticleRecord<V::Scalar>) -> Self {
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
    fn terms<N: Number<Scalar = V::Scalar>>(&self, pair: &Pair<N>) -> [N; RATES] {
        let Pair { own, other, separation, distance, .. } = pair;
        let (volume, zero) = (volume::<V, N>(other), N::constant(0.0));
        let weight = self.kernel.slope(volume, *distance);
        let squeeze = approach::<V, N>(pair) * weight;
        if !MIXED && self.diffusion[0][0] == V::Scalar::ZERO {
            return [squeeze, zero, zero];
        }
        let diffusion = pick::<N, MIXED>(volume, &self.for_particle);
        let mut excess = content::<V, N>(other) - content::<V, N>(own);
        for axis in 0..V::DIMENSION {
            excess += N::of(self.fall[axis]) * separation[axis];
        }
        let evened = zero - diffusion * excess * weight;
        if !MIXED {
            return [squeeze, evened, zero];
        }
        let is_obstacle = is_obstacle(volume);
        [N::select(is_obstacle, zero, squeeze), evened, squeeze.masked(is_obstacle)]
    }
}

/// Diffusion does not act on the hydrostatic part of the density.
impl<V: Vector, K: KernelShape, const MIXED: bool> ImagePressure<V, RATES> for Continuity<V::Scalar, K, MIXED> {
    #[inline(always)]
    fn density<N: Number<Scalar = V::Scalar>>(&self, other: &ParticleRecord<N>) -> N {
        pick::<N, MIXED>(volume::<V, N>(other), &self.density)
    }
}

/// Interaction coefficients of one material with every material.
#[derive(Debug, Clone, Copy)]
pub struct PairCoefficients<T> {
    /// Artificial viscosity αhcρ₀ [Pa·s].
    pub artificial: [T; KINDS],
    /// Twice the dynamic viscosity over the variance of the kernel, 2μ/σ² [Pa·s/m²].
    pub laminar: [T; KINDS],
    /// Flag 1 for materials that interact, 0 between obstacles.
    pub interacts: [T; KINDS],
    /// Flag 1 if only the other particle is an obstacle, and flag 1 if only this one is.
    pub other_is_obstacle: [T; KINDS],
    pub own_is_obstacle: [T; KINDS],
    /// Fraction of the particle's own pressure that acts on each material, and, by tag, fraction of the other particle's pressure
    /// that acts on it.
    pub own_acts: [T; KINDS],
    pub other_acts: [T; KINDS],
}

/// Momentum: force density along each axis [N/m^D], and power densities [W/m^D].
#[derive(Debug, Clone, Copy)]
pub struct Momentum<T, K, const MIXED: bool> {
    pub kernel: SmoothingKernel<T, K>,
    /// Coefficients of each material, and those of the particle's material.
    pub coefficients: [PairCoefficients<T>; KINDS],
    pub for_particle: PairCoefficients<T>,
    /// Rest density ρ₀ of each material [kg/m³].
    pub density: [T; KINDS],
    /// Regularization 0.01 h² [m²].
    pub softening: T,
    /// Twice the dynamic viscosity, 2μ [Pa·s], of a single fluid whose viscous force acts along v.
    pub shear: T,
}

impl<V: Vector, K: KernelShape, const MIXED: bool> PairLaw<V, FORCES> for Momentum<V::Scalar, K, MIXED> {
    #[inline(always)]
    fn for_particle(mut self, own: &ParticleRecord<V::Scalar>) -> Self {
        if MIXED {
            let solid = usize::from(OBSTACLE);
            self.for_particle = self.coefficients[usize::from(volume::<V, _>(own).tag())];
            self.for_particle.own_acts[solid] = self.coefficients[solid].other_acts[usize::from(content::<V, _>(own).tag())];
        }
        self
    }

    #[inline(always)]
    fn terms<N: Number<Scalar = V::Scalar>>(&self, pair: &Pair<N>) -> [N; FORCES] {
        let Pair { own, other, separation, .. } = pair;
        let weight = self.weight::<V, N>(pair);
        let approach = approach::<V, N>(pair);
        let squeeze = self.squeeze::<V, N>(pair, weight, approach);
        let (mut own_pressure, mut other_pressure) = (content::<V, N>(own), content::<V, N>(other));
        if MIXED {
            own_pressure = own_pressure * pick::<N, MIXED>(volume::<V, N>(other), &self.for_particle.own_acts);
            other_pressure = other_pressure * pick::<N, MIXED>(other_pressure, &self.for_particle.other_acts);
        }
        let push = squeeze - (own_pressure + other_pressure) * weight;
        let mut terms = [N::constant(0.0); FORCES];
        for axis in 0..V::DIMENSION {
            terms[axis] = push * separation[axis];
        }
        terms[VISCOUS] = squeeze * approach;
        if self.shear != V::Scalar::ZERO {
            let (shear, mut drag) = (N::of(self.shear) * weight, N::constant(0.0));
            for axis in 0..V::DIMENSION {
                let velocity = velocity::<V, N>(pair, axis);
                terms[axis] += shear * velocity;
                drag += velocity * velocity;
            }
            terms[VISCOUS] += shear * drag;
        }
        if MIXED {
            // The work against an obstacle's pressure is dissipated, because obstacles store no energy. Each particle accounts
            // for half of the power of a pair.
            let other_pressure =
                pick::<N, MIXED>(volume::<V, N>(other), &self.for_particle.other_is_obstacle) * content::<V, N>(other);
            let own_pressure = pick::<N, MIXED>(volume::<V, N>(other), &self.for_particle.own_is_obstacle) * content::<V, N>(own);
            terms[SOLID] = N::constant(0.5) * (other_pressure + own_pressure) * weight * approach;
        }
        terms
    }
}

impl<T: Real, K: KernelShape, const MIXED: bool> Momentum<T, K, MIXED> {
    /// The law without pressure tags, for images, which have none: the full pressure acts on obstacles.
    #[inline]
    pub fn untagged(mut self) -> Self {
        self.coefficients[usize::from(OBSTACLE)].other_acts = [T::ONE; KINDS];
        self
    }

    /// Product Vⱼ F, 0 for materials that do not interact.
    #[inline(always)]
    fn weight<V: Vector<Scalar = T>, N: Number<Scalar = T>>(&self, pair: &Pair<N>) -> N {
        let volume = volume::<V, N>(&pair.other);
        let weight = self.kernel.slope(volume, pair.distance);
        if MIXED { weight * pick::<N, MIXED>(volume, &self.for_particle.interacts) } else { weight }
    }

    /// Coefficient of d in the viscous force density, with v·d in `approach`.
    #[inline(always)]
    fn squeeze<V: Vector<Scalar = T>, N: Number<Scalar = T>>(&self, pair: &Pair<N>, weight: N, approach: N) -> N {
        let volume = volume::<V, N>(&pair.other);
        let artificial =
            pick::<N, MIXED>(volume, &self.for_particle.artificial) * approach / (pair.square + N::of(self.softening));
        let laminar = pick::<N, MIXED>(volume, &self.for_particle.laminar) * approach;
        (artificial + laminar) * weight
    }
}

impl<V: Vector, K: KernelShape, const MIXED: bool> ImagePressure<V, FORCES> for Momentum<V::Scalar, K, MIXED> {
    #[inline(always)]
    fn density<N: Number<Scalar = V::Scalar>>(&self, other: &ParticleRecord<N>) -> N {
        pick::<N, MIXED>(volume::<V, N>(other), &self.density)
    }

    /// A hydrostatic difference at a ceiling causes no suction, which would hold a drop.
    #[inline(always)]
    fn image_pressure<N: Number<Scalar = V::Scalar>>(&self, content: N, by: N) -> N {
        let least = content.min(N::constant(0.0));
        let pressure = content + by;
        N::select(N::constant(0.0).less(by), pressure, pressure.max(least))
    }

    #[inline(always)]
    fn power_correction<N: Number<Scalar = V::Scalar>>(&self, pair: &Pair<N>, by: N) -> [N; FORCES] {
        let Pair { own, separation, .. } = pair;
        let weight = self.weight::<V, N>(pair);
        let approach = approach::<V, N>(pair);
        let squeeze = self.squeeze::<V, N>(pair, weight, approach);
        let (shear, mut terms) = (N::of(self.shear) * weight, [N::constant(0.0); FORCES]);
        // Each particle accounts for half of the loss of a pair. Its own loss counts twice here, because the wall takes none.
        let mut loss = squeeze * approach;
        for axis in 0..V::DIMENSION {
            let own_velocity = own[V::DIMENSION + axis];
            // The work of the hydrostatic difference is dissipated too.
            terms[SOLID] += by * weight * separation[axis] * own_velocity;
            let relative = velocity::<V, N>(pair, axis);
            loss +=
                shear * relative * relative - N::constant(2.0) * (squeeze * separation[axis] + shear * relative) * own_velocity;
        }
        terms[VISCOUS] = N::constant(0.0) - loss;
        terms
    }
}
