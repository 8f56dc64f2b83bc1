//! Springs in an order in which neighbors have no common particles: the processor computes several at once.

use crate::catalog::Space;
use crate::forces::springs::Spring;
use crate::math::{AXES, Real};
use crate::matter::{Columns, Properties};
use crate::solvers;
use crate::systems::matter::constraints::rods;

/// Vector of a particle; a fourth component 0 fills a register.
pub type Point<T> = [T; 4];

/// Spring, for steps of h seconds.
#[derive(Debug, Clone, Copy)]
pub struct ProjectionLink<T> {
    /// Ends, as indices of particles.
    pub ends: [u32; 2],
    /// Stiffness k h² and damping c h [kg]; 1 and 0 for a rod.
    stiffness: T,
    damping: T,
    rest_length: T,
    /// Inverse masses 1/m of both ends [1/kg].
    pub inverse_mass: [T; 2],
    /// Factor 1/(1 + (1/m₁ + 1/m₂) (k h² + c h)); 1/(1/m₁ + 1/m₂) for a rod, and 0 between fixed particles.
    pub share: T,
    /// 1 for a spring, 0 for a rod.
    pub compliant: T,
}

impl<T: Real> ProjectionLink<T> {
    fn new(spring: &Spring, inverse_mass: &[T], h: f64) -> Self {
        let inverse_mass = spring.ends.map(|end| inverse_mass[end as usize]);
        let is_rod = rods::is_rod(spring);
        let (stiffness, damping) = if is_rod { (1.0, 0.0) } else { (spring.stiffness * h * h, spring.damping * h) };
        let weight: f64 = inverse_mass.iter().map(|inverse| inverse.to_f64()).sum();
        let compliant = if is_rod { 0.0 } else { 1.0 };
        let share = if is_rod && weight == 0.0 { 0.0 } else { 1.0 / (compliant + weight * (stiffness + damping)) };
        Self {
            ends: spring.ends,
            stiffness: T::from_f64(stiffness),
            damping: T::from_f64(damping),
            rest_length: T::from_f64(spring.rest_length),
            inverse_mass,
            share: T::from_f64(share),
            compliant: T::from_f64(compliant),
        }
    }

    /// Unit vector n from the first end to the second, 0 if these coincide, and h² times the force of the displacements u, h²
    /// [k (r − L) + c n·Δu/h] [kg·m].
    #[inline(always)]
    pub fn pull(&self, from: &[Point<T>], moved: &[Point<T>]) -> (Point<T>, T) {
        let [one, other] = self.ends.map(|end| end as usize);
        let ([a, b], [u, v]) = ([from[one], from[other]], [moved[one], moved[other]]);
        let apart: Point<T> = std::array::from_fn(|axis| v[axis] - u[axis]);
        let separation: Point<T> = std::array::from_fn(|axis| (b[axis] - a[axis]) + apart[axis]);
        let dot = |one: &Point<T>, other: &Point<T>| one[0] * other[0] + one[1] * other[1] + one[2] * other[2];
        let length = dot(&separation, &separation).sqrt();
        let inverse = if length > T::ZERO { T::ONE / length } else { T::ZERO };
        let rate = dot(&separation, &apart) * inverse;
        (separation.map(|along| along * inverse), self.stiffness * (length - self.rest_length) + self.damping * rate)
    }
}

/// Springs between different ones of `count` particles, color by color. No two springs of a color share a particle.
pub fn colored(springs: &[Spring], count: usize) -> Vec<Spring> {
    let springs: Vec<Spring> = springs.iter().filter(|spring| spring.ends[0] != spring.ends[1]).copied().collect();
    solvers::colored(&springs, |spring| spring.ends, count).concat()
}

/// Links of all springs, for steps of `h` seconds.
pub fn links<V: Space>(springs: &[Spring], properties: &Properties<V>, h: f64) -> Vec<ProjectionLink<V::Scalar>> {
    colored(springs, properties.count()).iter().map(|spring| ProjectionLink::new(spring, &properties.inverse_mass, h)).collect()
}

/// Copies columns into points.
pub fn gather<V: Space>(columns: &Columns<V>, points: &mut Vec<Point<V::Scalar>>) {
    points.resize(columns.count(), Point::default());
    for axis in 0..V::DIMENSION.min(AXES) {
        points.iter_mut().zip(columns.axis(axis)).for_each(|(point, &value)| point[axis] = value);
    }
}

/// Copies points into columns.
pub fn scatter<V: Space>(points: &[Point<V::Scalar>], columns: &mut Columns<V>) {
    let span = columns.span();
    for axis in 0..V::DIMENSION {
        span.axes[axis].iter_mut().zip(points).for_each(|(value, point)| *value = point[axis]);
    }
}
