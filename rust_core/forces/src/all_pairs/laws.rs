//! Terms of a source in the sums of a target: the inverse-square force and its tide.

use super::sums::SourceLaw;
use crate::math::{AXES, Real};
use crate::simd::{Number, ParticleRecord, WORDS};

/// Number of sums of [`Attraction`]: the field along each axis, the potential, the power of one-sided sources, and the number of
/// sources at zero distance.
pub const SUMS: usize = AXES + 3;
/// Index of the potential in the sums.
pub const POTENTIAL: usize = AXES;
/// Index of the power in the sums.
pub const WORK: usize = AXES + 1;
/// Index of the number of sources at zero distance in the sums.
pub const COINCIDENT: usize = AXES + 2;

/// Field Σ cⱼ d/s³ toward the sources and potential Σ cⱼ/s. The parameter is the squared softening. Without softening, a source
/// at zero distance has no terms but is counted. `ONE_SIDED` adds the power Σ cⱼ d·vⱼ/s³.
#[derive(Debug, Clone, Copy)]
pub struct Attraction<T, const SOFTENED: bool, const ONE_SIDED: bool>(pub T);

impl<T: Real, const SOFTENED: bool, const ONE_SIDED: bool> SourceLaw<T, WORDS, SUMS> for Attraction<T, SOFTENED, ONE_SIDED> {
    const TERMS: usize = match (SOFTENED, ONE_SIDED) {
        (true, false) => POTENTIAL + 1,
        (true, true) => WORK + 1,
        (false, _) => COINCIDENT + 1,
    };

    #[inline(always)]
    fn terms<N: Number<Scalar = T>>(&self, offset: [N; AXES], square: N, source: &ParticleRecord<N>) -> [N; SUMS] {
        let (zero, one) = (N::constant(0.0), N::constant(1.0));
        let softened = if SOFTENED { square + N::of(self.0) } else { square };
        let mut inverse = one / softened.sqrt();
        let mut terms = [zero; SUMS];
        if !SOFTENED {
            let apart = zero.less(square);
            inverse = inverse.masked(apart);
            terms[COINCIDENT] = N::select(apart, zero, one);
        }
        terms[POTENTIAL] = source[AXES] * inverse;
        let strength = terms[POTENTIAL] * (inverse * inverse);
        for axis in 0..AXES {
            terms[axis] = strength * offset[axis];
            if ONE_SIDED {
                terms[WORK] += terms[axis] * source[AXES + 1 + axis];
            }
        }
        terms
    }
}

/// Sums Σ wⱼ/s³ of two words wⱼ of each source at nonzero distance. The parameter is the squared softening.
#[derive(Debug, Clone, Copy)]
pub struct Tide<T>(pub T);

impl<T: Real> SourceLaw<T, WORDS, 2> for Tide<T> {
    #[inline(always)]
    fn terms<N: Number<Scalar = T>>(&self, _offset: [N; AXES], square: N, source: &ParticleRecord<N>) -> [N; 2] {
        let zero = N::constant(0.0);
        let softened = square + N::of(self.0);
        let cube = (N::constant(1.0) / (softened * softened.sqrt())).masked(zero.less(square));
        [source[AXES] * cube, source[AXES + 1] * cube]
    }
}
