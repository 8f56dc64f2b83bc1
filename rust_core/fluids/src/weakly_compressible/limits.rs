//! Bounds on the time step of a fluid, and its Mach number.

use std::f64::consts::TAU;

use super::WeaklyCompressible;
use super::laws::FORCES;
use crate::forces::{FluidScheme, Mach};
use crate::math::{Real, Vector};
use crate::matter::View;
use crate::particles::kernel::KernelShape;
use crate::particles::waves::FluidWave;
use crate::particles::{Material, OBSTACLE};
use crate::stability::SpectralBound;

impl<V: Vector, K: KernelShape, const MIXED: bool> WeaklyCompressible<V, K, MIXED> {
    /// The Mach number at these velocities.
    #[inline]
    pub fn speed(&self, velocity: View<'_, V>) -> Mach {
        let sound = self.fluids[0].sound_speed;
        let square = |index: u32| (0..V::DIMENSION).map(|axis| velocity.axis(axis)[index as usize].to_f64().powi(2)).sum::<f64>();
        let (mut fast, mut all) = (0.0, 0.0);
        for (&index, _) in self.neighbor_list.members().iter().zip(&self.kind).filter(|(_, kind)| **kind != OBSTACLE) {
            all += 1.0;
            fast += if square(index) > (Mach::FAST * sound).powi(2) { 1.0 } else { 0.0 };
        }
        Mach { fast: fast / all, sound }
    }

    /// The largest force density [N/m^D].
    #[inline]
    pub fn strongest(&self) -> f64 {
        let square = |(slot, force): (usize, &[V::Scalar; FORCES])| {
            let pull = self.tension.as_ref().map(|tension| tension.force(slot));
            let along = |axis: usize| force[axis].to_f64() + pull.map_or(0.0, |pull| pull[axis].to_f64());
            (0..V::DIMENSION).map(|axis| along(axis).powi(2)).sum::<f64>()
        };
        self.strongest.unwrap_or_else(|| self.forces.iter().enumerate().map(square).fold(0.0, f64::max).sqrt())
    }

    /// Adds the shortest limit of all waves resolved by the kernel. An obstacle takes the limit of the stiffest fluid. The limit
    /// of capillary waves is √(ρh³/2πσ).
    ///
    /// Source: J. U. Brackbill, D. B. Kothe, C. Zemach, J. Comput. Phys. 100 (1992) 335.
    pub fn limit(&self, bound: &mut SpectralBound) {
        let h = self.materials.first().smoothing_length;
        let diffuses = if self.density().is_carried() { 1.0 } else { 0.0 };
        let sheared = self.momentum.shear != V::Scalar::ZERO;
        let bounds: Vec<(f64, f64, f64)> = self
            .fluids
            .iter()
            .zip(0..)
            .map(|(fluid, kind)| {
                let densities = self.density.iter().zip(&self.kind).filter(|(_, other)| **other == kind);
                let densest = densities.map(|(density, _)| *density).fold(fluid.material.density, f64::max);
                let scaled = |wave: &FluidWave| {
                    let laminar = if sheared { wave.decay } else { wave.strain };
                    let viscous =
                        (fluid.artificial() * wave.squeeze + 2.0 * fluid.material.viscosity * laminar) / fluid.material.density;
                    let diffusion = diffuses * fluid.diffusion() * wave.decay;
                    [fluid.sound_at(densest) * wave.frequency / h, viscous / (h * h), diffusion / (h * h)]
                };
                // If the fluid is compressed or fragmented, all frequencies are scaled by the largest one found there.
                let fastest = self.waves.iter().map(|wave| scaled(wave)[0]).fold(0.0, f64::max);
                let faster = (self.surface.highest() / fastest).max(1.0);
                let waves = self.waves.iter().map(scaled).map(|[frequency, damping, decay]| [faster * frequency, damping, decay]);
                let [stiffness, damping] = bound.shortest(waves);
                (stiffness, damping, fluid.material.density)
            })
            .collect();
        let heaviest = |one: &&(f64, f64, f64), other: &&(f64, f64, f64)| (one.0 * one.2).total_cmp(&(other.0 * other.2));
        let pressing = bounds.iter().max_by(heaviest).copied().unwrap_or_default();
        for body in self.solids.bodies() {
            let mass = body.moved * pressing.2;
            bound.point(body.particle as usize, "sound", mass * pressing.0, 0.0);
            bound.point(body.particle as usize, "viscosity", 0.0, mass * pressing.1);
            if let Some(tension) = &self.tension {
                bound.point(body.particle as usize, "surface tension", body.moved * tension.stiffness(OBSTACLE), 0.0);
            }
        }
        let members = self.neighbor_list.members().iter().enumerate();
        for (member, &index) in members.filter(|(_, index)| self.solids.sample(**index as usize).is_none()) {
            let (stiffness, damping, density) = bounds.get(usize::from(self.kind[member])).copied().unwrap_or(pressing);
            let mass = self.mass[member] / self.density[member] * density;
            bound.point(index as usize, "sound", mass * stiffness, 0.0);
            bound.point(index as usize, "viscosity", 0.0, mass * damping);
            if let Some(tension) = &self.tension {
                let stiffness = tension.stiffness(self.kind[member]);
                bound.point(index as usize, "surface tension", self.rest_volume(member) * stiffness, 0.0);
            }
        }
        let strongest = self.strongest();
        let lightest = self.materials.fluids.iter().map(|fluid| fluid.density).fold(f64::INFINITY, f64::min);
        let ripple = |fluid: &Material| (fluid.density * h.powi(3) / (TAU * fluid.surface_tension)).sqrt();
        let ripples = self.materials.fluids.iter().filter(|fluid| fluid.surface_tension > 0.0).map(ripple);
        ripples.for_each(|dt| bound.accuracy("surface tension", dt));
        // A diverged state has no scale of acceleration.
        if strongest.is_finite() {
            bound.accuracy("acceleration", (h * lightest / strongest).sqrt());
        }
    }
}
