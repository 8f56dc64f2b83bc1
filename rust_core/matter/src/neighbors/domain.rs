//! Domain of particles, and the range of coordinates and cutoffs with an exact search.

use crate::error::{Error, Result};
use crate::math::AXES;

/// Largest spacing of f64 numbers at a position, in units of the cutoff.
const COARSEST: f64 = 1e-7;

/// Range of cutoffs [m] whose squares and inverses neither overflow nor underflow.
const CUTOFFS: std::ops::RangeInclusive<f64> = 1e-100..=1e100;

/// Domain of particles, periodic or unbounded along each axis.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Domain {
    /// Lower and upper end of each periodic axis [m]; None for an unbounded axis.
    pub period: [Option<(f64, f64)>; AXES],
}

impl Domain {
    /// Length of each periodic axis [m].
    #[inline]
    pub fn lengths(&self) -> [Option<f64>; AXES] {
        self.period.map(|period| period.map(|(lower, upper)| upper - lower))
    }

    /// Whether any axis is periodic.
    #[inline]
    pub fn is_periodic(&self) -> bool {
        self.period.iter().any(Option::is_some)
    }

    /// Rejects periodic axes that are invalid, or so short that a particle would interact with two images of another.
    pub(super) fn check(&self, cutoff: f64, support: f64) -> Result<()> {
        self.period.iter().flatten().try_for_each(|&ends| check_period(ends, cutoff, support))
    }
}

/// Rejects cutoffs and skins that are out of range.
#[inline]
pub fn check_lengths(cutoff: f64, skin: f64) -> Result<()> {
    if !CUTOFFS.contains(&cutoff) {
        return Err(Error::parameter("cutoff", "a length between 1e-100 and 1e100 m", cutoff));
    }
    if !(skin >= 0.0 && skin <= *CUTOFFS.end()) {
        return Err(Error::parameter("skin", "a length from 0 to 1e100 m", skin));
    }
    Ok(())
}

/// Rejects coordinates whose rounding error is not small compared with the cutoff.
#[inline]
pub fn check_spacing<'a>(coordinates: impl Iterator<Item = &'a f64>, cutoff: f64) -> Result<()> {
    let farthest = coordinates.filter(|end| end.is_finite()).fold(0.0_f64, |most, end| most.max(end.abs()));
    if is_coarse(farthest, cutoff) {
        let expected = format!("all within {:.3e} m of 0, for a cutoff of {cutoff} m", farthest_exact(cutoff));
        return Err(Error::parameter("positions", expected, format!("one at {farthest:e} m"))
            .with_hint("f64 numbers there are too far from each other to tell distances; has the run diverged?"));
    }
    Ok(())
}

/// Whether the spacing of f64 numbers at a coordinate is too large.
fn is_coarse(coordinate: f64, cutoff: f64) -> bool {
    coordinate > farthest_exact(cutoff)
}

/// Largest permitted |coordinate| [m].
fn farthest_exact(cutoff: f64) -> f64 {
    cutoff * COARSEST / f64::EPSILON
}

/// Rejects an axis that is invalid, or so short that a particle would interact with two images of another.
fn check_period((lower, upper): (f64, f64), cutoff: f64, support: f64) -> Result<()> {
    let found = format!("{lower} to {upper}");
    if !(lower.is_finite() && upper.is_finite() && lower < upper) {
        return Err(Error::parameter("periodic", "finite ends, the lower below the upper", found));
    }
    if is_coarse(lower.abs().max(upper.abs()), cutoff) {
        let expected = format!("ends within {:.3e} m of 0, for a cutoff of {cutoff} m", farthest_exact(cutoff));
        return Err(Error::parameter("periodic", expected, found));
    }
    if upper - lower < 2.0 * support {
        let expected = format!("a length of at least {} m, twice the reach of the pair forces", 2.0 * support);
        return Err(Error::parameter("periodic", expected, format!("{} m", upper - lower))
            .with_hint("a particle would meet two images of another; enlarge the domain or shorten the cutoff"));
    }
    Ok(())
}
