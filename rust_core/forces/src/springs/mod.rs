//! Damped springs between given particles.
//!
//! Springs with the same law and index offset form stencils ([`stencil`]). All other springs are gathered in slices ([`slices`]),
//! for which [`ordering`] can bring partners near each other in memory. Both add to the same force, by the same law ([`law`]).

use std::ops::Range;

use super::{About, Force, Rates, Reach, StateView, Validity, VelocityDependence};
use crate::error::Result;
use crate::history::History;
use crate::math::{Real, Vector};
use crate::simd::{Isa, Kernel, LANES, dispatch, dispatch_wide, padded};
use crate::stability::{Horizon, Link, SpectralBound};

mod law;
mod ordering;
mod slices;
mod statistics;
mod stencil;
#[cfg(test)]
mod tests;

pub use ordering::ordering;
pub use physcore_matter::forces::springs::{NAME, Spring, declared};

use law::SpringLaw;
use slices::Slices;
use statistics::SpringStatistics;
use stencil::{BLOCK, SpringStencil, StencilSums, TILE};

/// Ratio r/L = ½ below which the transverse stiffness exceeds the longitudinal one, with a margin for the rounding of single
/// precision. Above it, the time-step bound has the same bits for any configuration.
const HALF: f64 = 0.501;

/// Springs of a scene.
#[derive(Debug)]
pub struct Springs<V: Vector> {
    stencils: Vec<SpringStencil<V::Scalar>>,
    slices: Option<Slices<V::Scalar>>,
    damped: bool,
    /// Number of particles.
    count: usize,
}

impl<V: Vector> Springs<V> {
    /// Springs between `count` particles, by their index in the engine's order. A spring from a particle to itself exerts no
    /// force and is omitted.
    pub fn new(springs: &[Spring], count: usize) -> Self {
        let springs: Vec<Spring> = springs.iter().filter(|spring| spring.ends[0] != spring.ends[1]).copied().collect();
        let (stencils, taken) = stencil::find::<V::Scalar>(&springs);
        let rest: Vec<Spring> = springs.iter().zip(taken).filter(|(_, taken)| !taken).map(|(spring, _)| *spring).collect();
        Self {
            damped: springs.iter().any(|spring| spring.damping != 0.0),
            slices: (!rest.is_empty()).then(|| Slices::new(&rest, count)),
            stencils,
            count,
        }
    }

    /// Smallest r/L among springs with L > 0 whose lower end is in a block; infinite if there are none. Below ½ the time-step
    /// bound must be recomputed.
    pub fn shortest(&self, block: Range<usize>, at: &StateView<'_, V>) -> f64 {
        self.measure(block, at).shortest.into_iter().fold(f64::INFINITY, f64::min)
    }

    /// Description in the plan: `6 stencils of 597241 springs`, `slices of 16 particles with 40 springs, 3 kinds`.
    fn layout(&self) -> String {
        let plural = |number: usize, noun: &str| if number == 1 { format!("1 {noun}") } else { format!("{number} {noun}s") };
        let stencils = (!self.stencils.is_empty()).then(|| {
            let springs: usize = self.stencils.iter().map(|stencil| stencil.count).sum();
            format!("{} of {}", plural(self.stencils.len(), "stencil"), plural(springs, "spring"))
        });
        let slices = self.slices.as_ref().map(|slices| {
            let kinds = slices.kinds().map_or_else(|| "each of its own kind".to_owned(), |kinds| plural(kinds, "kind"));
            format!("slices of {LANES} particles with {}, {kinds}", plural(slices.count, "spring"))
        });
        let parts: Vec<String> = stencils.into_iter().chain(slices).collect();
        if parts.is_empty() { "no springs".to_owned() } else { parts.join("; ") }
    }

    /// Number of factors that all stencils keep for a block, which is computed in parts.
    fn factors(&self, block: &Range<usize>) -> usize {
        self.stencils.iter().map(|stencil| stencil.factors(block.len().min(BLOCK))).sum()
    }

    fn measure(&self, block: Range<usize>, at: &StateView<'_, V>) -> SpringStatistics {
        dispatch(Surveying { springs: self, block, at })
    }
}

impl<V: Vector> History for Springs<V> {}

impl<V: Vector> Force<V> for Springs<V> {
    fn about(&self) -> About {
        let (stencils, slices) = (&self.stencils, self.slices.as_ref());
        About {
            velocity: if self.damped { VelocityDependence::Dissipative } else { VelocityDependence::None },
            pairs: stencils.iter().map(|stencil| stencil.count).sum::<usize>() + slices.map_or(0, |slices| slices.count),
            bytes: stencils.iter().map(SpringStencil::bytes).sum::<usize>() + slices.map_or(0, Slices::bytes),
            layout: self.layout(),
            ..About::new(NAME, Reach::Network)
        }
    }

    fn accumulate(&self, block: Range<usize>, at: &StateView<'_, V>, rates: &mut Rates<'_, V>) {
        V::Scalar::with_scratch(self.factors(&block), |factors| {
            dispatch_wide(Accumulation { springs: self, block, at, rates: rates.reborrow(), factors });
        });
    }

    /// The energy ½ k (r − L)² of a spring counts at its lower end.
    fn potential(&self, block: Range<usize>, at: &StateView<'_, V>) -> f64 {
        self.measure(block, at).energy.into_iter().sum()
    }

    /// The longitudinal stiffness is k. The transverse stiffness is k (1 − L/r), whose magnitude exceeds k for r < L/2. Springs
    /// with coincident ends exert no force and count with k.
    fn bound(&self, at: &StateView<'_, V>, bound: &mut SpectralBound) -> Result<()> {
        let mut add = |i: usize, j: usize, law: &SpringLaw<V::Scalar>| {
            let offset = at.position.get(j).widen() - at.position.get(i).widen();
            let [rest_length, stiffness, damping] = [law.rest_length, law.stiffness, law.damping].map(Real::to_f64);
            bound.spring(i, j, &Link { offset, rest_length, stiffness, damping });
        };
        self.stencils.iter().for_each(|stencil| stencil.for_each(0..self.count, &mut add));
        self.slices.iter().for_each(|slices| slices.for_each(0..self.count, &mut add));
        Ok(())
    }

    fn validity(&self, at: &StateView<'_, V>, _horizon: Horizon) -> Validity {
        if self.shortest(0..padded(self.count), at) > HALF { Validity::Here } else { Validity::Now }
    }
}

struct Accumulation<'a, V: Vector> {
    springs: &'a Springs<V>,
    block: Range<usize>,
    at: &'a StateView<'a, V>,
    rates: Rates<'a, V>,
    /// Memory for the factors of all stencils.
    factors: &'a mut [V::Scalar],
}

impl<V: Vector> Kernel for Accumulation<'_, V> {
    type Output = ();

    #[inline(always)]
    fn run<S: Isa>(self, _isa: S) {
        if self.springs.damped { self.add::<true>() } else { self.add::<false>() }
    }
}

impl<V: Vector> Accumulation<'_, V> {
    #[inline(always)]
    fn add<const DAMPED: bool>(self) {
        let Self { springs, block, at, mut rates, factors } = self;
        if !springs.stencils.is_empty() {
            let mut sums = StencilSums::ZERO;
            for start in block.clone().step_by(TILE) {
                let first = start - (start - block.start) % BLOCK;
                let (part, tile) = (first..block.end.min(first + BLOCK), start..block.end.min(start + TILE));
                sums.clear::<V, DAMPED>();
                let mut rest = &mut *factors;
                for stencil in &springs.stencils {
                    let (own, others) = rest.split_at_mut(stencil.factors(part.len()));
                    stencil.accumulate::<V, DAMPED>((&tile, &part), at, own, &mut sums);
                    rest = others;
                }
                sums.add_to::<V, DAMPED>(&mut rates, start - block.start, tile.len());
            }
        }
        if let Some(slices) = &springs.slices {
            slices.accumulate::<V, DAMPED>(&block, at, &mut rates);
        }
    }
}

struct Surveying<'a, V: Vector> {
    springs: &'a Springs<V>,
    block: Range<usize>,
    at: &'a StateView<'a, V>,
}

impl<V: Vector> Kernel for Surveying<'_, V> {
    type Output = SpringStatistics;

    #[inline(always)]
    fn run<S: Isa>(self, _isa: S) -> SpringStatistics {
        let mut statistics = SpringStatistics::EMPTY;
        for stencil in &self.springs.stencils {
            stencil.measure::<V>(&self.block, self.at, &mut statistics);
        }
        if let Some(slices) = &self.springs.slices {
            slices.measure::<V>(&self.block, self.at, &mut statistics);
        }
        statistics
    }
}
