//! Fusion of uniform gravity, linear drag, wind and harmonic wells into one linear force. The acceleration per particle is a =
//! a₀ + b v + c x, which the integrators' kernels evaluate in registers.

use glam::DVec3;

use crate::math::{AXES, Real, Vector};
use crate::matter::Properties;
use crate::simd::{Lanes, padded};

/// Sum of the linear forces, in double precision and absolute coordinates.
#[derive(Debug)]
pub struct Fusion {
    /// Constant acceleration a₀ [m/s²].
    pub acceleration: Vec<DVec3>,
    /// Velocity coefficient b [1/s].
    pub rate: Vec<f64>,
    /// Position coefficient c [1/s²].
    pub well: Vec<f64>,
    /// Linear drag coefficient γ [N·s/m].
    pub drag: Vec<f64>,
    /// Velocity of the wind [m/s]; None without drag.
    pub wind: Option<DVec3>,
}

impl Fusion {
    /// A sum of no forces, for `count` particles.
    #[inline]
    pub fn new(count: usize) -> Self {
        Self {
            acceleration: vec![DVec3::ZERO; count],
            rate: vec![0.0; count],
            well: vec![0.0; count],
            drag: vec![0.0; count],
            wind: None,
        }
    }
}

/// The coefficients of one particle along one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearCoefficients<T> {
    /// Constant acceleration a₀ [m/s²].
    pub a0: T,
    /// Velocity coefficient b [1/s].
    pub b: T,
    /// Position coefficient c [1/s²].
    pub c: T,
    /// Linear drag coefficient γ [N·s/m].
    pub drag: T,
}

/// Linear force in the precision of the state. Coefficients common to all particles are stored once. The last block stores them
/// per particle, because its padding must not move.
#[derive(Debug)]
pub struct LinearForce<V: Vector> {
    uniform: Option<[LinearCoefficients<V::Scalar>; AXES]>,
    /// First particle of the arrays.
    first: usize,
    a0: [Vec<V::Scalar>; AXES],
    b: Vec<V::Scalar>,
    c: Vec<V::Scalar>,
    drag: Vec<V::Scalar>,
    wind: [V::Scalar; AXES],
    /// Whether the force dissipates or supplies power.
    pub dissipates: bool,
}

/// The linear force along one axis of one block.
#[derive(Debug, Clone, Copy)]
pub enum AxisLaw<'a, T> {
    /// Common coefficients, without wind or well.
    Uniform(LinearCoefficients<T>),
    /// Coefficients per particle.
    Varying(VaryingCoefficients<'a, T>),
}

/// Coefficients per particle, for one axis of one block.
#[derive(Debug, Clone, Copy)]
pub struct VaryingCoefficients<'a, T> {
    /// Constant acceleration a₀ [m/s²].
    pub a0: &'a [Lanes<T>],
    /// Velocity coefficient b [1/s].
    pub b: &'a [Lanes<T>],
    /// Position coefficient c [1/s²].
    pub c: &'a [Lanes<T>],
    /// Linear drag coefficient γ [N·s/m].
    pub drag: &'a [Lanes<T>],
    /// The wind along this axis [m/s].
    pub wind: T,
}

impl<V: Vector> LinearForce<V> {
    /// The linear force of a fusion, for blocks of `block` particles.
    pub fn new(fusion: &Fusion, properties: &Properties<V>, block: usize) -> Self {
        let count = properties.count();
        let coefficients = |index: usize| {
            let a0 = (fusion.acceleration[index] + properties.origin * fusion.well[index]).to_array();
            let [b, c, drag] = [fusion.rate[index], fusion.well[index], fusion.drag[index]].map(V::Scalar::from_f64);
            a0.map(|a0| LinearCoefficients { a0: V::Scalar::from_f64(a0), b, c, drag })
        };
        let wind = fusion.wind.unwrap_or(DVec3::ZERO);
        let mut uniform = (count > 0).then(|| coefficients(0));
        if uniform.is_some_and(|same| same[0].c != V::Scalar::ZERO || (1..count).any(|index| coefficients(index) != same))
            || wind != DVec3::ZERO
        {
            uniform = None;
        }
        let first = if uniform.is_some() { count.saturating_sub(1) / block * block } else { 0 };
        let each = |value: &dyn Fn(usize) -> V::Scalar| {
            let mut values: Vec<V::Scalar> = (first..count).map(value).collect();
            values.resize(padded(count) - first, V::Scalar::ZERO);
            values
        };
        Self {
            uniform,
            first,
            a0: std::array::from_fn(|axis| each(&|index| coefficients(index)[axis].a0)),
            b: each(&|index| coefficients(index)[0].b),
            c: each(&|index| coefficients(index)[0].c),
            drag: each(&|index| coefficients(index)[0].drag),
            wind: wind.to_array().map(V::Scalar::from_f64),
            dissipates: fusion.drag.iter().any(|&drag| drag != 0.0),
        }
    }

    /// Linear force along an axis of the block of `length` particles from `start`, padding included.
    #[inline(always)]
    pub fn axis(&self, axis: usize, start: usize, length: usize) -> AxisLaw<'_, V::Scalar> {
        match self.uniform {
            Some(same) if start < self.first => AxisLaw::Uniform(same[axis]),
            _ => {
                let range = start - self.first..start - self.first + length;
                let [a0, b, c, drag] =
                    [&self.a0[axis], &self.b, &self.c, &self.drag].map(|values| values[range.clone()].as_chunks().0);
                AxisLaw::Varying(VaryingCoefficients { a0, b, c, drag, wind: self.wind[axis] })
            }
        }
    }

    /// Coefficients a₀ along one axis, b and c of one particle.
    #[inline]
    pub fn coefficients(&self, axis: usize, index: usize) -> [f64; 3] {
        match self.uniform {
            Some(same) if index < self.first => [same[axis].a0, same[axis].b, same[axis].c],
            _ => {
                let entry = index - self.first;
                [self.a0[axis][entry], self.b[entry], self.c[entry]]
            }
        }
        .map(Real::to_f64)
    }

    /// Acceleration of one particle along one axis [m/s²], at a position relative to the origin and a velocity.
    #[inline]
    pub fn acceleration(&self, axis: usize, index: usize, x: V::Scalar, v: V::Scalar) -> V::Scalar {
        match self.uniform {
            Some(same) if index < self.first => same[axis].a0 + same[axis].b * v,
            _ => {
                let entry = index - self.first;
                self.a0[axis][entry] + self.b[entry] * v + self.c[entry] * x
            }
        }
    }

    /// Memory [bytes].
    #[inline]
    pub fn bytes(&self) -> usize {
        (V::DIMENSION + 3) * std::mem::size_of_val(self.b.as_slice())
    }
}
