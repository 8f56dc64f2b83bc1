//! Power through the sinks of a block, integrated over the stages of its steps.

use crate::integrators::Integrator;
use crate::math::Real;
use crate::matter::{EnergySink, EnergyTally, Power};
use crate::simd::{LANES, Lanes, Pack};

/// Powers through all sinks.
pub fn through_all(power: &Power) -> impl Iterator<Item = (EnergySink, &Lanes<f64>)> {
    let sinks = [EnergySink::Drag, EnergySink::Damping, EnergySink::Contact, EnergySink::Viscosity, EnergySink::Work];
    sinks.into_iter().zip(power)
}

/// Adds the energy through some sinks of a tally during one stage. It is the power times `span`, plus the power at the last
/// stage of the previous step times `last_span`. The flag `keep` marks the last stage of a step.
#[inline(always)]
pub fn integrate<'a>(
    tally: &mut EnergyTally,
    powers: impl Iterator<Item = (EnergySink, &'a Lanes<f64>)>,
    span: f64,
    last_span: f64,
    keep: bool,
) {
    for (sink, now) in powers {
        let (sink, now) = (sink as usize, *now);
        let last = tally.last[sink];
        for lane in 0..LANES {
            tally.energy[sink][lane] += last_span * last[lane] + span * now[lane];
        }
        if keep {
            tally.last[sink] = now;
        }
    }
}

/// Whether a method of several stages reuses the last evaluation of the previous step (FSAL). The power of that evaluation is
/// then stored apart from the weighted sum: two steps in one pass would overwrite it there.
#[inline(always)]
pub(super) const fn reuses_one_of_many<I: Integrator>() -> bool {
    I::LAST_WEIGHT != 0.0 && I::NODES.len() > 1
}

/// Numbers of a group of lanes.
#[inline(always)]
pub(super) fn lanes<G: Pack<Scalar: Real>>(group: G) -> Lanes<G::Scalar> {
    let mut lanes = [G::Scalar::ZERO; LANES];
    group.store(&mut lanes);
    lanes
}

/// Adds the sums of a group of lanes, in the unit `unit` [W], to a power.
#[inline(always)]
pub(super) fn add_power<T: Real>(power: &mut Lanes<f64>, sums: &Lanes<T>, unit: f64) {
    for lane in 0..LANES {
        power[lane] += unit * sums[lane].to_f64();
    }
}
