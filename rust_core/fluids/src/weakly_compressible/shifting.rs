//! Particle shifting: a displacement of particles from dense to sparse regions.
//!
//! A stretching flow concentrates particles along streamlines, with voids in between, above all at negative pressure. Each
//! particle is therefore displaced in every step, after its drift and independently of its velocity, against the gradient of
//! concentration:
//!
//! ```text
//! δxᵢ = −A h U dt Σ Vⱼ [1 + (W/W(Δ))⁴/5] ∇W,   U = min(8 h ε, c/10),   ε² = −Σ Vⱼ F (v·d)²/(d² + 0.01h²)
//! ```
//!
//! This displacement diffuses particles (Lind et al.). The coefficient A is from 1 to 6 (Skillen et al.), and the weights are
//! those of P. N. Sun et al. (2017), where A is 2.
//!
//! The literature takes for U the fastest expected flow, usually c/10. With it, a fluid at rest would never come to rest, and
//! waves would gain potential energy. Particles concentrate by their relative motion, at the rate of strain ε. Therefore U is the
//! velocity difference over 8h, twice the diameter of the support, up to c/10. This U is invariant under translation and
//! rotation, and vanishes with h, as a shifting law must (Michel et al.).
//!
//! The product A h U dt is limited to h²/2 (Lind et al.), so that this diffusion is stable at any step. The displacement |δx| is
//! limited to c dt/20, half of the displacement by the fastest flow (P. N. Sun et al. 2019).
//!
//! At a free surface the gradient points outward for any distribution, and particles there are not shifted. A particle is at a
//! surface if ∇·x = −Σ Vⱼ F d² is less than [`SURFACE`] of its value inside, D (Lee et al.). Images in walls and obstacles count
//! as neighbors, so that particles are not shifted through them.
//!
//! Velocities and densities do not change. Momentum, kinetic energy and internal energy are therefore conserved exactly. Angular
//! momentum is not, and a change of potential energy counts as work.
//!
//! Sources: S. J. Lind, R. Xu, P. K. Stansby, B. D. Rogers, J. Comput. Phys. 231 (2012) 1499; A. Skillen, S. Lind, P. K. Stansby,
//! B. D. Rogers, Comput. Methods Appl. Mech. Eng. 265 (2013) 163; P. N. Sun, A. Colagrossi, S. Marrone, A. M. Zhang, ibid. 315
//! (2017) 25; P. N. Sun et al., ibid. 348 (2019) 912; J. Michel et al., J. Comput. Phys. 459 (2022) 110999; E.-S. Lee et al., J.
//! Comput. Phys. 227 (2008) 8417.

use glam::DVec3;

use super::equation_of_state::CompressibleFluid;
use crate::math::{AXES, Real, Vector};
use crate::neighbors::NeighborList;
use crate::neighbors::sums::{Pair, PairLaw, Records};
use crate::parallel::Executor;
use crate::particles::Material;
use crate::particles::images::{ImagePressure, WallCondition};
use crate::particles::kernel::{KernelShape, SmoothingKernel};
use crate::particles::records::{approach, volume};
use crate::particles::walls::FluidWalls;
use crate::simd::Number;

/// Mach number of the fastest flow.
const FASTEST: f64 = 0.1;

/// Length of the velocity difference U, in units of h.
const ACROSS: f64 = 8.0;

/// Ratio of ∇·x to its value inside, below which a particle is at a free surface. On a lattice at a flat surface the ratio is
/// 0.60 to 0.70 in the first row. In the second row it is 0.91 to 0.99, for kernels that reach two to three and a half spacings.
const SURFACE: f64 = 0.85;

/// Weight R of the tensile correction for particles closer than Δ.
const CLOSE: f64 = 0.2;

/// Number of sums of [`ShiftingSum`]: the gradient of concentration along each axis, ∇·x, and ε².
const SUMS: usize = AXES + 2;
const SPREAD: usize = AXES;
const STRAIN: usize = AXES + 1;

/// Gradient of concentration Σ Vⱼ [1 + R (W/W(Δ))⁴] ∇W [1/m], ∇·x, and the squared rate of strain ε² [1/s²].
#[derive(Debug, Clone, Copy)]
struct ShiftingSum<T, K> {
    kernel: SmoothingKernel<T, K>,
    /// Inverse kernel value 1/W(Δ) [m^D].
    scale: T,
    /// Regularization 0.01 h² [m²].
    softening: T,
}

impl<V: Vector, K: KernelShape> PairLaw<V, SUMS> for ShiftingSum<V::Scalar, K> {
    #[inline(always)]
    fn terms<N: Number<Scalar = V::Scalar>>(&self, pair: &Pair<N>) -> [N; SUMS] {
        let (distance, zero) = (pair.distance, N::constant(0.0));
        let slope = self.kernel.slope(volume::<V, N>(&pair.other), distance);
        let near = N::of(self.scale) * self.kernel.value(distance);
        let weight = slope * (N::constant(1.0) + N::constant(CLOSE) * (near * near) * (near * near));
        let (mut terms, mut across) = ([zero; SUMS], zero);
        for axis in 0..V::DIMENSION {
            terms[axis] = weight * pair.separation[axis];
            // The square of the pair cannot be used, because it is infinite for padding.
            across += pair.separation[axis] * pair.separation[axis];
        }
        terms[SPREAD] = zero - slope * across;
        let approach = approach::<V, N>(pair);
        terms[STRAIN] = (zero - slope) * (approach * approach) / (pair.square + N::of(self.softening));
        terms
    }
}

impl<V: Vector, K: KernelShape> ImagePressure<V, SUMS> for ShiftingSum<V::Scalar, K> {}

/// Shifting of the fluids of a scene.
pub struct Shifting<V: Vector, K> {
    law: ShiftingSum<V::Scalar, K>,
    /// Coefficient A.
    coefficient: f64,
    smoothing_length: f64,
    /// Largest speed, c/10 [m/s].
    fastest: f64,
    /// Sums of [`ShiftingSum`] by slot.
    sums: Vec<[V::Scalar; SUMS]>,
    /// Duration of the drift [s].
    dt: f64,
}

impl<V: Vector, K: KernelShape> Shifting<V, K> {
    /// Shifting of `count` particles with a common kernel.
    pub fn new(kernel: SmoothingKernel<V::Scalar, K>, common: &CompressibleFluid, coefficient: f64, count: usize) -> Self {
        let number = V::Scalar::from_f64;
        let Material { spacing, smoothing_length, .. } = common.material;
        let scale = V::Scalar::ONE / kernel.value(number(spacing));
        Self {
            law: ShiftingSum { kernel, scale, softening: number(0.01 * smoothing_length.powi(2)) },
            coefficient,
            smoothing_length,
            fastest: FASTEST * common.sound_speed,
            sums: vec![[V::Scalar::ZERO; SUMS]; count],
            dt: 0.0,
        }
    }

    /// Computes the sums at the midpoint of a drift of `dt` seconds, from records of volumes and midpoint velocities.
    #[inline]
    pub fn update(
        &mut self,
        (neighbor_list, records): (&NeighborList, &Records<V>),
        walls: &FluidWalls,
        dt: f64,
        executor: &Executor,
    ) {
        self.dt = dt;
        records.sum(neighbor_list.neighbors(), self.law, &mut self.sums, executor);
        let condition = WallCondition { weight: DVec3::ZERO, no_slip: false };
        walls.add(self.law, &condition, (neighbor_list, records), &mut self.sums, executor);
    }

    /// Displacement δx of the particle at a slot [m].
    pub fn displacement(&self, slot: usize) -> V {
        let sums = &self.sums[slot];
        if sums[SPREAD].to_f64() < SURFACE * V::DIMENSION as f64 {
            return V::default();
        }
        let gradient = V::from_axes(|axis| sums[axis]).widen();
        let h = self.smoothing_length;
        let speed = (ACROSS * h * sums[STRAIN].to_f64().sqrt()).min(self.fastest);
        let diffusion = (self.coefficient * h * speed * self.dt).min(0.5 * h * h);
        V::narrow((gradient * -diffusion).clamp_length_max(0.5 * self.fastest * self.dt))
    }

    /// Coefficient A.
    #[inline]
    pub fn coefficient(&self) -> f64 {
        self.coefficient
    }

    /// Memory [bytes].
    #[inline]
    pub fn bytes(&self) -> usize {
        std::mem::size_of_val(self.sums.as_slice())
    }
}
