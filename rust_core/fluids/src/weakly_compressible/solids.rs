//! Rigid bodies in the fluid: motions of their samples, and loads on the bodies.

use std::ops::Range;

use glam::{DMat3, DVec3};

use super::WeaklyCompressible;
use super::laws::{SOLID, VISCOUS};
use super::momentum::force_density;
use crate::forces::{Drift, Rates, StateView};
use crate::math::{Real, Vector};
use crate::matter::EnergySink;
use crate::particles::kernel::KernelShape;
use crate::particles::solids::{SampledBody, SolidFrame};
use crate::simd::LANES;

/// Frame of each body in a state.
pub fn frames<V: Vector>(at: &StateView<'_, V>) -> impl Fn(&SampledBody) -> SolidFrame {
    |body| {
        let solid = &at.solids[body.solid];
        let rotation = DMat3::from_quat(solid.orientation);
        let turn = |column: DVec3| solid.angular_velocity.cross(column);
        SolidFrame {
            center: at.exact_point(body.particle as usize),
            velocity: at.velocity.get(body.particle as usize).widen(),
            rotation,
            rate: DMat3::from_cols(turn(rotation.x_axis), turn(rotation.y_axis), turn(rotation.z_axis)),
        }
    }
}

/// Frame of each body in the middle of a drift, with its mean velocity. Points of the body move on straight lines in a drift.
pub fn frames_between<V: Vector>(drift: &Drift<'_, V>) -> impl Fn(&SampledBody) -> SolidFrame {
    |body| {
        let solid = &drift.end.solids[body.solid];
        let [before, after] = [solid.before, solid.orientation].map(DMat3::from_quat);
        SolidFrame {
            center: drift.end.exact_point(body.particle as usize) - 0.5 * solid.moved,
            velocity: solid.moved * drift.h.recip(),
            rotation: (before + after) * 0.5,
            rate: (after - before) * drift.h.recip(),
        }
    }
}

impl<V: Vector, K: KernelShape, const MIXED: bool> WeaklyCompressible<V, K, MIXED> {
    /// Sums the forces and powers of the samples of each body.
    pub(super) fn load_solids(&mut self) {
        let Self { solids, neighbor_list, forces, tension, mass, density, materials, .. } = self;
        let (tension, first, slots) = (tension.as_ref(), mass.len() - solids.count(), neighbor_list.neighbors().slots());
        solids.sum(|sample| {
            let (member, slot) = (first + sample, slots[first + sample] as usize);
            let (sums, volume) = (&forces[slot], mass[member] / density[member]);
            let mut force = volume * force_density::<V>(sums);
            if let Some(tension) = tension {
                let rest = mass[member] / materials.first().density;
                force += rest * V::from_axes(|axis| tension.force(slot)[axis]).widen();
            }
            // Each particle of a pair accounts for half of its power.
            (force, [-0.5 * volume * sums[VISCOUS].to_f64(), volume * sums[SOLID].to_f64()])
        });
    }

    /// Adds the forces on the bodies whose particles are in a block, and their powers.
    pub(super) fn accumulate_solids(&self, block: &Range<usize>, rates: &mut Rates<'_, V>) {
        for body in self.solids.bodies().iter().filter(|body| block.contains(&(body.particle as usize))) {
            let index = body.particle as usize - block.start;
            for axis in 0..V::DIMENSION {
                rates.force.axes[axis][index] += V::Scalar::from_f64(body.load.force[axis]);
            }
            for (sink, power) in [EnergySink::Viscosity, EnergySink::Contact].into_iter().zip(body.load.powers) {
                rates.power[sink as usize][index % LANES] += power;
            }
        }
    }
}
