//! Uniform gravity: F = m g. Fused ([`super::linear`]) where it is constant. One that depends on time has no potential energy; its
//! power counts as work.

use std::ops::Range;

use glam::DVec3;

use super::derivatives::{Derivatives, MatrixBlock, Motion, Push};
use super::linear::Fusion;
use super::pointwise::{self, ForceField, PointRate};
use super::timed::TimedVector;
use super::{About, Declared, Force, ForceKind, Forces, Rates, Reach, StateView, Validity};
use crate::error::Result;
use crate::history::History;
use crate::math::{AXES, Real, Vector};
use crate::matter::Properties;
use crate::parallel::Executor;
use crate::scene::Scene;
use crate::stability::{Horizon, SpectralBound};

/// Uniform acceleration of the movable particles.
#[derive(Debug)]
pub struct Gravity<V: Vector> {
    /// Gravitational acceleration g [m/s²].
    acceleration: TimedVector,
    /// Masses of the particles, 0 if unaffected; padded [kg].
    weights: Vec<V::Scalar>,
}

const NAME: &str = "Gravity";
const ACCELERATION: &str = "acceleration";

/// Entry in the registry of forces.
pub fn kind<V: Vector>() -> ForceKind<V> {
    let build = |declared: &Declared<'_, V>| -> Result<Forces<V>> {
        let acceleration = TimedVector::declared(declared.item, ACCELERATION, V::DIMENSION)?;
        let mut weights = declared.mask();
        for (weight, &mass) in weights.iter_mut().zip(&declared.properties.mass).filter(|(weight, _)| **weight != V::Scalar::ZERO)
        {
            *weight = V::Scalar::from_f64(mass);
        }
        Ok(vec![Box::new(Gravity::<V> { acceleration, weights })])
    };
    ForceKind { name: NAME, reach: Reach::Pointwise, charges: false, build }
}

/// Acceleration of a body by all uniform gravity of a scene at the start [m/s²].
///
/// # Errors
/// If an acceleration is not finite.
#[inline]
pub fn on_body(scene: &Scene, body: usize) -> Result<DVec3> {
    let acting = scene.forces.iter().filter(|item| item.kind == NAME && item.acts_on(body));
    acting.map(|item| Ok(TimedVector::declared(item, ACCELERATION, scene.dimension)?.value)).sum()
}

impl<V: Vector> Gravity<V> {
    fn acts_on(&self, index: usize) -> bool {
        self.weights[index] != V::Scalar::ZERO
    }
}

impl<V: Vector> History for Gravity<V> {}

impl<V: Vector> Force<V> for Gravity<V> {
    fn about(&self) -> About {
        let varies = self.acceleration.varies();
        About {
            potential: (!varies).then_some("gravity"),
            callback: varies,
            bytes: size_of_val(self.weights.as_slice()),
            ..About::new("gravity", Reach::Pointwise)
        }
    }

    fn prepare(&mut self, at: &StateView<'_, V>, _executor: &Executor) -> Result<()> {
        self.acceleration.update(at.time)
    }

    fn fuse(&self, properties: &Properties<V>, fusion: &mut Fusion) -> bool {
        if self.acceleration.varies() {
            return false;
        }
        for index in (0..properties.count()).filter(|&index| self.acts_on(index)) {
            fusion.acceleration[index] += self.acceleration.value;
        }
        true
    }

    fn accumulate(&self, block: Range<usize>, at: &StateView<'_, V>, rates: &mut Rates<'_, V>) {
        let acceleration = self.acceleration.value.to_array().map(V::Scalar::from_f64);
        pointwise::accumulate::<V>(GravityLaw { acceleration }, &self.weights, block, at, rates);
    }

    /// Potential energy U = −m g·x [J].
    fn potential(&self, block: Range<usize>, at: &StateView<'_, V>) -> f64 {
        if self.acceleration.varies() {
            return 0.0;
        }
        let properties = at.properties;
        let members = block.filter(|&index| self.acts_on(index));
        members
            .map(|index| {
                let place = properties.origin + at.position.get(index).widen();
                -properties.mass[index] * self.acceleration.value.dot(place)
            })
            .sum()
    }

    fn bound(&self, _at: &StateView<'_, V>, _bound: &mut SpectralBound) -> Result<()> {
        Ok(())
    }

    fn validity(&self, _at: &StateView<'_, V>, _horizon: Horizon) -> Validity {
        Validity::Always
    }

    fn derivatives(&mut self) -> Option<&mut dyn Derivatives> {
        Some(self)
    }
}

impl<V: Vector> Derivatives for Gravity<V> {
    fn arrange(&mut self, at: &Motion<'_>, _executor: &Executor) -> Result<()> {
        self.acceleration.update(at.time)
    }

    fn forces(&self, at: &Motion<'_>, push: &mut dyn FnMut(Push)) {
        for particle in (0..at.position.len()).filter(|&index| self.acts_on(index)) {
            push(Push { particle, force: self.weights[particle].to_f64() * self.acceleration.value, stiffness: 0.0 });
        }
    }

    fn blocks(&self, _at: &Motion<'_>, _factors: [f64; 2], _add: &mut dyn FnMut(MatrixBlock)) {}
}

#[derive(Clone, Copy)]
struct GravityLaw<T> {
    acceleration: [T; AXES],
}

impl<V: Vector> ForceField<V> for GravityLaw<V::Scalar> {
    #[inline(always)]
    fn at(&self, mass: V::Scalar, _x: [V::Scalar; AXES], v: [V::Scalar; AXES]) -> PointRate<V::Scalar> {
        let force = self.acceleration.map(|g| mass * g);
        let mut work = V::Scalar::ZERO;
        for axis in 0..V::DIMENSION {
            work += force[axis] * v[axis];
        }
        PointRate { force, dissipated: V::Scalar::ZERO, work }
    }
}
