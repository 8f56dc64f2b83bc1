//! Energy and smallest extension of springs, in double precision.

use super::law::SpringLaw;
use crate::math::Real;
use crate::simd::{LANES, Lanes};

/// Statistics of all springs with a lower end in a block, lane by lane.
#[derive(Debug, Clone, Copy)]
pub struct SpringStatistics {
    /// Potential energy Σ ½ k (r − L)² [J].
    pub energy: Lanes<f64>,
    /// The smallest extension r/L of springs with L > 0.
    pub shortest: Lanes<f64>,
}

impl SpringStatistics {
    /// The statistics of no springs.
    pub const EMPTY: Self = Self { energy: [0.0; LANES], shortest: [f64::INFINITY; LANES] };

    /// Adds a spring of squared length `square` if it counts.
    #[inline(always)]
    pub fn add<T: Real>(&mut self, lane: usize, counts: bool, square: f64, law: SpringLaw<T>) {
        let (length, rest_length) = (square.sqrt(), law.rest_length.to_f64());
        let excess = length - rest_length;
        let energy = 0.5 * law.stiffness.to_f64() * (excess * excess);
        self.energy[lane] += if counts { energy } else { 0.0 };
        // The division does not depend on the spring's length, so that springs of one kind share it.
        let ratio = length * (1.0 / rest_length);
        let shorter = counts && rest_length > 0.0 && ratio < self.shortest[lane];
        self.shortest[lane] = if shorter { ratio } else { self.shortest[lane] };
    }
}
