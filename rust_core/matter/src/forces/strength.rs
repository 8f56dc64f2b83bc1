//! Gyroscopic strengths: charge times magnetic field, q B, which rotates velocities by m v̇ = v × q B.

use glam::DVec3;

use crate::math::{AXES, Real, Vector};
use crate::matter::Span;

/// Maximum number of particles in a [`Strength`].
pub const PART: usize = 64;

/// Strength q B of consecutive particles [C·T], along each axis. In 2D, the z component is stored in place of x.
#[derive(Debug)]
pub struct Strength<V: Vector> {
    /// The components; 0 along missing axes.
    pub axes: [[V::Scalar; PART]; AXES],
}

impl<V: Vector> Default for Strength<V> {
    fn default() -> Self {
        Self { axes: [[V::Scalar::ZERO; PART]; AXES] }
    }
}

impl<V: Vector> Strength<V> {
    /// Sets all components to zero.
    #[inline]
    pub fn clear(&mut self) {
        self.axes = [[V::Scalar::ZERO; PART]; AXES];
    }

    /// Mutable components of the first `length` particles.
    #[inline]
    pub fn span(&mut self, length: usize) -> Span<'_, V> {
        let mut axes = self.axes.iter_mut();
        Span {
            axes: std::array::from_fn(|axis| {
                let column = axes.next().map_or(&mut [][..], |column| &mut column[..length]);
                if axis < V::DIMENSION { column } else { &mut [] }
            }),
        }
    }

    /// Strength of one particle.
    #[inline]
    pub fn get(&self, place: usize) -> DVec3 {
        let [x, y, z] = std::array::from_fn(|axis| self.axes[axis][place].to_f64());
        if V::DIMENSION == 2 { DVec3::new(0.0, 0.0, x) } else { DVec3::new(x, y, z) }
    }

    /// Adds to the strength of one particle.
    #[inline]
    pub fn add(&mut self, place: usize, strength: DVec3) {
        let [x, y, z] = strength.to_array().map(V::Scalar::from_f64);
        let components = if V::DIMENSION == 2 { [z, V::Scalar::ZERO, V::Scalar::ZERO] } else { [x, y, z] };
        for axis in 0..AXES {
            self.axes[axis][place] += components[axis];
        }
    }
}
