//! Drag: F = −(γ + q|u|) u, where u = v − w is the velocity relative to the wind w. The wind may depend on time and place.
//!
//! The power F·v splits into the dissipated power, (γ + q|u|)|u|² ≥ 0, and the power of the wind, −(γ + q|u|) u·w.

use std::ops::Range;

use super::derivatives::{Derivatives, Directed, MatrixBlock, Motion, Push};
use super::linear::Fusion;
use super::pointwise::{self, ForceField, PointRate};
use super::stream::Stream;
use super::{About, Declared, Force, ForceKind, Forces, Rates, Reach, StateView, Validity, VelocityDependence};
use crate::error::Result;
use crate::history::History;
use crate::math::{AXES, Real, Vector};
use crate::matter::{Columns, Properties};
use crate::parallel::Executor;
use crate::simd::Number;
use crate::stability::{Horizon, SpectralBound};

/// Linear or quadratic drag in a wind.
#[derive(Debug)]
pub struct Drag<V: Vector> {
    /// Linear drag coefficient γ [N·s/m].
    linear: f64,
    /// Quadratic drag coefficient q [N·s²/m²].
    quadratic: f64,
    /// Velocity of the wind w [m/s], at each particle of `named` if it depends on the place.
    wind: Stream,
    /// Engine indices of the affected particles, in the caller's order.
    named: Vec<usize>,
    /// Velocity of a wind that depends on the place, at every particle.
    local: Columns<V>,
    /// Weights of the particles: 1 if affected, else 0; padded.
    members: Vec<V::Scalar>,
}

/// Entry in the registry of forces.
pub fn kind<V: Vector>() -> ForceKind<V> {
    let build = |declared: &Declared<'_, V>| -> Result<Forces<V>> {
        Ok(Drag::<V>::parts(declared)?.into_iter().map(|part| Box::new(part) as _).collect())
    };
    ForceKind { name: "Drag", reach: Reach::Pointwise, charges: false, build }
}

impl<V: Vector> Drag<V> {
    /// Linear and quadratic part of an item's drag, each omitted if 0. They are separate because only the linear part can be
    /// fused. Drag in a wind that is a function is never fused, and has one part.
    fn parts(declared: &Declared<'_, V>) -> Result<Vec<Self>> {
        let (item, named) = (declared.item, declared.members());
        let wind = Stream::declared(item, "wind", V::DIMENSION, named.len())?;
        let (linear, quadratic) = (item.non_negative("linear")?, item.non_negative("quadratic")?);
        let parts = if wind.varies() { vec![(linear, quadratic)] } else { vec![(linear, 0.0), (0.0, quadratic)] };
        let placed = matches!(wind, Stream::Placed { .. });
        let part = |(linear, quadratic)| Self {
            linear,
            quadratic,
            wind: wind.clone(),
            named: if placed { named.clone() } else { Vec::new() },
            local: Columns::zeros(if placed { declared.chosen.len() } else { 0 }),
            members: declared.mask(),
        };
        Ok(parts.into_iter().filter(|&part| part != (0.0, 0.0)).map(part).collect())
    }

    /// Affected movable particles, each with its number among the named ones, if the wind depends on the place.
    fn affected(&self) -> impl Iterator<Item = (usize, usize)> {
        let everyone = if self.named.is_empty() { 0..self.members.len() } else { 0..0 };
        let named = self.named.iter().copied().enumerate();
        everyone.map(|index| (0, index)).chain(named).filter(|&(_, index)| self.acts_on(index))
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
            bytes: size_of_val(self.members.as_slice())
                + size_of_val(self.named.as_slice())
                + self.local.bytes()
                + self.wind.bytes(),
            ..About::new("drag", Reach::Pointwise)
        }
    }

    fn fuse(&self, properties: &Properties<V>, fusion: &mut Fusion) -> bool {
        if self.wind.varies() || self.quadratic != 0.0 {
            return false;
        }
        let wind = self.wind.value(0);
        if fusion.wind.is_some_and(|other| other != wind) {
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
        self.wind.update(at.time, || at.places(&self.named))?;
        for (point, &index) in self.named.iter().enumerate() {
            self.local.set(index, V::narrow(self.wind.value(point)));
        }
        Ok(())
    }

    fn accumulate(&self, block: Range<usize>, at: &StateView<'_, V>, rates: &mut Rates<'_, V>) {
        let [linear, quadratic] = [self.linear, self.quadratic].map(V::Scalar::from_f64);
        if matches!(self.wind, Stream::Placed { .. }) {
            let at = StateView { position: self.local.view(), ..*at };
            return pointwise::accumulate::<V>(LocalDragLaw { linear, quadratic }, &self.members, block, &at, rates);
        }
        let wind = self.wind.value(0).to_array().map(V::Scalar::from_f64);
        pointwise::accumulate::<V>(DragLaw { linear, quadratic, wind }, &self.members, block, at, rates);
    }

    /// The damping is the larger eigenvalue of −∂F/∂v, γ + 2q|u|. In a wind that depends on the place, the stiffness is at most
    /// the damping times the norm of the gradient of the wind.
    fn bound(&self, at: &StateView<'_, V>, bound: &mut SpectralBound) -> Result<()> {
        let wind = self.wind.with_gradients(at.time, || at.places(&self.named))?;
        for (point, index) in self.affected() {
            let (wind, gradient) = wind.at(point);
            let speed = (at.velocity.get(index).widen() - wind).length();
            let damping = self.linear + 2.0 * self.quadratic * speed;
            bound.point(index, "drag", damping * gradient, damping);
            bound.steady(index, 0.0, self.linear);
        }
        Ok(())
    }

    fn validity(&self, _at: &StateView<'_, V>, _horizon: Horizon) -> Validity {
        let steady = self.quadratic == 0.0 && matches!(self.wind, Stream::Uniform(_));
        if steady { Validity::Always } else { Validity::Now }
    }

    fn derivatives(&mut self) -> Option<&mut dyn Derivatives> {
        Some(self)
    }
}

/// Damping matrix C: γ + 2q|u| along u, and γ + q|u| across it. The derivative by position, C times the gradient of the wind, is
/// not symmetric, and is omitted.
impl<V: Vector> Derivatives for Drag<V> {
    fn arrange(&mut self, at: &Motion<'_>, _executor: &Executor) -> Result<()> {
        let Self { wind, named, .. } = self;
        wind.update(at.time, || named.iter().map(|&index| at.origin + at.position[index]).collect())
    }

    fn forces(&self, at: &Motion<'_>, push: &mut dyn FnMut(Push)) {
        for (point, particle) in self.affected() {
            let u = at.velocity[particle] - self.wind.value(point);
            push(Push { particle, force: -(self.linear + self.quadratic * u.length()) * u, stiffness: 0.0 });
        }
    }

    fn blocks(&self, at: &Motion<'_>, [_, rate]: [f64; 2], add: &mut dyn FnMut(MatrixBlock)) {
        for (point, particle) in self.affected() {
            let u = at.velocity[particle] - self.wind.value(point);
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

/// Drag in a wind that depends on the place. Velocities of the wind take the place of positions.
#[derive(Clone, Copy)]
struct LocalDragLaw<T> {
    linear: T,
    quadratic: T,
}

impl<V: Vector> ForceField<V> for LocalDragLaw<V::Scalar> {
    #[inline(always)]
    fn at(&self, member: V::Scalar, wind: [V::Scalar; AXES], v: [V::Scalar; AXES]) -> PointRate<V::Scalar> {
        let law = DragLaw { linear: self.linear, quadratic: self.quadratic, wind };
        ForceField::<V>::at(&law, member, wind, v)
    }
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
