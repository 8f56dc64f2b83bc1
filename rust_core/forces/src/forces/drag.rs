//! Drag: F = −(γ + q|u|) u with u = v − w, the velocity relative to the wind w.
//!
//! The power F·v splits into the dissipated power, (γ + q|u|)|u|² ≥ 0, and the power of the wind, −(γ + q|u|) u·w.

use std::ops::Range;

use super::derivatives::{Derivatives, Directed, MatrixBlock, Motion, Push};
use super::linear::Fusion;
use super::pointwise::{self, ForceField, PointRate};
use super::timed::TimedVector;
use super::{About, Declared, Force, ForceKind, Forces, Rates, Reach, StateView, Validity, VelocityDependence};
use crate::error::Result;
use crate::history::History;
use crate::math::{AXES, Real, Vector};
use crate::matter::Properties;
use crate::parallel::Executor;
use crate::scene::Item;
use crate::simd::Number;
use crate::stability::{Horizon, SpectralBound};

/// Linear or quadratic drag in a uniform wind.
#[derive(Debug)]
pub struct Drag<V: Vector> {
    /// Linear drag coefficient γ [N·s/m].
    linear: f64,
    /// Quadratic drag coefficient q [N·s²/m²].
    quadratic: f64,
    /// Velocity of the wind w [m/s].
    wind: TimedVector,
    /// Weights of the particles: 1 if affected, else 0; padded.
    members: Vec<V::Scalar>,
}

/// Entry in the registry of forces.
pub fn kind<V: Vector>() -> ForceKind<V> {
    let build = |declared: &Declared<'_, V>| -> Result<Forces<V>> {
        Ok(Drag::<V>::parts(declared.item, &declared.mask())?.into_iter().map(|part| Box::new(part) as _).collect())
    };
    ForceKind { name: "Drag", reach: Reach::Pointwise, charges: false, build }
}

impl<V: Vector> Drag<V> {
    /// Linear and quadratic part of an item's drag, each omitted if 0. They are separate because only the linear part can be
    /// fused.
    fn parts(item: &Item, members: &[V::Scalar]) -> Result<Vec<Self>> {
        let wind = TimedVector::declared(item, "wind", V::DIMENSION)?;
        let (linear, quadratic) = (item.non_negative("linear")?, item.non_negative("quadratic")?);
        let parts = [(linear, 0.0), (0.0, quadratic)].into_iter().filter(|&part| part != (0.0, 0.0));
        Ok(parts.map(|(linear, quadratic)| Self { linear, quadratic, wind: wind.clone(), members: members.to_vec() }).collect())
    }

    fn acts_on(&self, index: usize) -> bool {
        self.members[index] != V::Scalar::ZERO
    }
}

impl<V: Vector> History for Drag<V> {}

impl<V: Vector> Force<V> for Drag<V> {
    fn about(&self) -> About {
        About {
            velocity: VelocityDependence::Dissipative,
            potential: None,
            callback: self.wind.varies(),
            bytes: std::mem::size_of_val(self.members.as_slice()),
            ..About::new("drag", Reach::Pointwise)
        }
    }

    fn fuse(&self, properties: &Properties<V>, fusion: &mut Fusion) -> bool {
        let wind = self.wind.value;
        if self.wind.varies() || self.quadratic != 0.0 || fusion.wind.is_some_and(|other| other != wind) {
            return false;
        }
        fusion.wind = Some(wind);
        for index in (0..properties.count()).filter(|&index| self.acts_on(index)) {
            let rate = self.linear / properties.mass[index];
            fusion.drag[index] += self.linear;
            fusion.rate[index] -= rate;
            fusion.acceleration[index] += wind * rate;
        }
        true
    }

    fn prepare(&mut self, at: &StateView<'_, V>, _executor: &Executor) -> Result<()> {
        self.wind.update(at.time)
    }

    fn accumulate(&self, block: Range<usize>, at: &StateView<'_, V>, rates: &mut Rates<'_, V>) {
        let [linear, quadratic] = [self.linear, self.quadratic].map(V::Scalar::from_f64);
        let wind = self.wind.value.to_array().map(V::Scalar::from_f64);
        pointwise::accumulate::<V>(DragLaw { linear, quadratic, wind }, &self.members, block, at, rates);
    }

    /// The damping is the larger eigenvalue of −∂F/∂v, γ + 2q|u|.
    fn bound(&self, at: &StateView<'_, V>, bound: &mut SpectralBound) -> Result<()> {
        let wind = self.wind.at(at.time)?;
        for index in (0..at.properties.count()).filter(|&index| self.acts_on(index)) {
            let speed = (at.velocity.get(index).widen() - wind).length();
            bound.point(index, "drag", 0.0, self.linear + 2.0 * self.quadratic * speed);
            bound.steady(index, 0.0, self.linear);
        }
        Ok(())
    }

    fn validity(&self, _at: &StateView<'_, V>, _horizon: Horizon) -> Validity {
        if self.quadratic == 0.0 { Validity::Always } else { Validity::Now }
    }

    fn derivatives(&mut self) -> Option<&mut dyn Derivatives> {
        Some(self)
    }
}

/// Damping matrix C: γ + 2q|u| along u, and γ + q|u| across it.
impl<V: Vector> Derivatives for Drag<V> {
    fn arrange(&mut self, at: &Motion<'_>, _executor: &Executor) -> Result<()> {
        self.wind.update(at.time)
    }

    fn forces(&self, at: &Motion<'_>, push: &mut dyn FnMut(Push)) {
        for particle in (0..at.velocity.len()).filter(|&index| self.acts_on(index)) {
            let u = at.velocity[particle] - self.wind.value;
            push(Push { particle, force: -(self.linear + self.quadratic * u.length()) * u, stiffness: 0.0 });
        }
    }

    fn blocks(&self, at: &Motion<'_>, [_, rate]: [f64; 2], add: &mut dyn FnMut(MatrixBlock)) {
        for particle in (0..at.velocity.len()).filter(|&index| self.acts_on(index)) {
            let u = at.velocity[particle] - self.wind.value;
            let per_speed = self.quadratic * u.length();
            let damping = Directed { along: self.linear + 2.0 * per_speed, across: self.linear + per_speed };
            let matrix = rate * damping.matrix(u.normalize_or_zero());
            add(MatrixBlock::of(particle, matrix, matrix));
        }
    }
}

#[derive(Clone, Copy)]
struct DragLaw<T> {
    linear: T,
    quadratic: T,
    wind: [T; AXES],
}

impl<V: Vector> ForceField<V> for DragLaw<V::Scalar> {
    #[inline(always)]
    fn at(&self, member: V::Scalar, _x: [V::Scalar; AXES], v: [V::Scalar; AXES]) -> PointRate<V::Scalar> {
        let mut relative = [V::Scalar::ZERO; AXES];
        let (mut square, mut along) = (V::Scalar::ZERO, V::Scalar::ZERO);
        for axis in 0..V::DIMENSION {
            relative[axis] = v[axis] - self.wind[axis];
            square += relative[axis] * relative[axis];
            along += relative[axis] * self.wind[axis];
        }
        let strength = member * (self.linear + self.quadratic * square.sqrt());
        PointRate { force: relative.map(|u| -(strength * u)), dissipated: strength * square, work: -(strength * along) }
    }
}
