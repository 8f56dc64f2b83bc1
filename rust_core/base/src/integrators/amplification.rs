//! Stability limit of an integrator from its own code, for integrators whose limit has no closed form.
//!
//! On x'' = −ω²x − 2ξωx' a step maps (x, v, a) linearly, where a is the persistent acceleration. This map is a 3 × 3
//! amplification matrix, computed by running the step on the unit vectors. The step is stable if no eigenvalue lies outside the
//! unit circle. The eigenvalues themselves would be a poor test. Where two of them meet, as at ωh = 0 and at the limit of every
//! symplectic method, a rounding error ε moves them by √ε. Jury's conditions on the characteristic polynomial are smooth instead.
//!
//! Source: E. I. Jury, Theory and Application of the z-Transform Method (1964), ch. 3.

use std::marker::PhantomData;

use super::{Component, ComponentGroup, Integrator, for_each_stage};
use crate::simd::{Isa, Kernel, dispatch};

/// Largest ratio of a damping, or of a decay, to a frequency that is distinguished from an infinite ratio.
pub const STEEPEST: f64 = 1e6;

/// Number of steps computed side by side, in vector registers.
const ABREAST: usize = 8;

/// Amplification of steps over h = 1 with these ωh, as matrices that act on (x, v, a), and Jury's conditions on them. If x stands
/// for a field that is advanced over the drifts, it also decays: x ← x + h v − `decay` x over a whole h. The decay is in units of
/// ω.
struct Amplification<I, const W: usize> {
    steps: [f64; W],
    damping_ratio: f64,
    decay: f64,
    integrator: PhantomData<I>,
}

impl<I: Integrator, const W: usize> Kernel for Amplification<I, W> {
    type Output = [[f64; W]; 4];

    #[inline(always)]
    fn run<S: Isa>(self, _isa: S) -> [[f64; W]; 4] {
        const { assert!(I::PERSISTENT <= 1, "the matrix has one row for a register") };
        let drifts = const { if let Some(drift_kick) = I::DRIFT_KICK { drift_kick.drifts } else { &[] } };
        let part = |drift: usize| drifts.get(drift).copied().unwrap_or_default();
        // The loop over lanes is innermost, so everything stays in vector registers.
        let mut matrices = [[[0.0; W]; 3]; 3];
        for column in 0..2 + I::PERSISTENT {
            let mut group = ComponentGroup::<f64, W>::ZERO;
            for lane in 0..W {
                let unit = |row: usize| f64::from(u8::from(row == column));
                group.set(lane, &Component::new(unit(0), unit(1), unit(2)));
            }
            for_each_stage!(I, stage => {
                for lane in 0..W {
                    let (step, mut component) = (self.steps[lane], group.lane(lane));
                    let (stiffness, damping, decay) = (step * step, 2.0 * self.damping_ratio * step, self.decay * step);
                    let from = component.x;
                    I::stage_state(stage, &mut component, 1.0);
                    component.x -= decay * part(stage) * from;
                    let (x, a) = (component.x, -stiffness * component.x - damping * component.v);
                    I::stage_update(stage, &mut component, a, 1.0);
                    if stage + 1 == I::NODES.len() {
                        component.x -= decay * part(stage + 1) * x;
                    }
                    group.set(lane, &component);
                }
            });
            for lane in 0..W {
                let component = group.lane(lane);
                let image = [component.x, component.v, component.registers[0]];
                (0..2 + I::PERSISTENT).for_each(|row| matrices[row][column][lane] = image[row]);
            }
        }
        let mut found = [[0.0; W]; 4];
        for lane in 0..W {
            let row = |row: usize| [matrices[row][0][lane], matrices[row][1][lane], matrices[row][2][lane]];
            let [first, second, third, fourth] = conditions(&[row(0), row(1), row(2)]);
            found[0][lane] = first;
            found[1][lane] = second;
            found[2][lane] = third;
            found[3][lane] = fourth;
        }
        found
    }
}

/// Evaluates Jury's conditions on several steps.
fn several<I: Integrator, const W: usize>(steps: [f64; W], damping_ratio: f64, decay: f64) -> [[f64; W]; 4] {
    dispatch(Amplification::<I, W> { steps, damping_ratio, decay, integrator: PhantomData })
}

/// Evaluates Jury's conditions with an allowance for rounding: none is negative if the step is stable.
fn rounded<I: Integrator, const W: usize>(steps: [f64; W], damping_ratio: f64, decay: f64) -> [[f64; W]; 4] {
    several::<I, W>(steps, damping_ratio, decay).map(|lanes| lanes.map(|value| value + ROUNDING))
}

/// Margin of the eigenvalues of a step ωh inside the unit circle, by Jury's conditions; negative if one is outside.
#[cfg(test)]
pub fn margin<I: Integrator>(step: f64, damping_ratio: f64, decay: f64) -> f64 {
    least(&several::<I, 1>([step], damping_ratio, decay), 0)
}

/// Least of the conditions on one of several steps.
fn least<const W: usize>(conditions: &[[f64; W]; 4], lane: usize) -> f64 {
    conditions.iter().fold(f64::INFINITY, |least, lanes| least.min(lanes[lane]))
}

/// Jury's conditions on the characteristic polynomial g³ + pg² + qg + r of a matrix. None is negative if all eigenvalues are
/// inside the unit circle.
#[inline(always)]
fn conditions(m: &[[f64; 3]; 3]) -> [f64; 4] {
    let minor = |i: usize, j: usize| m[i][i] * m[j][j] - m[i][j] * m[j][i];
    let p = -(m[0][0] + m[1][1] + m[2][2]);
    let q = minor(0, 1) + minor(0, 2) + minor(1, 2);
    let r = -(m[0][0] * minor(1, 2) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
        + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]));
    [1.0 + p + q + r, 1.0 - p + q - r, 1.0 - r.abs(), 1.0 - r * r - (q - r * p).abs()]
}

/// Allowance for rounding in the margin, which is 0 along the whole stable interval of a symplectic method. The limit is too
/// large by this value over the slope of the margin, which is of the order of 1.
const ROUNDING: f64 = 1e-12;
/// Number of steps tried between 0 and the largest. A narrower region of instability shows as a dip of one of the conditions. It
/// may not show as a dip of the least condition. One condition is 0 for every step of a symplectic method, and hides how near to
/// 0 another comes. At its resonances (ωh near π, 2π …) a method of high order crosses −1 by 1e-7 over a thousandth of a step.
const TRIALS: usize = 200;

/// Computes the largest ωh such that all steps up to it are stable.
///
/// The search extends to 2 per evaluation, the maximum of undamped explicit methods, which as many Verlet steps reach. Where
/// damping dominates, it extends to a damping of 4 per evaluation: beyond that a limit would be of no use. The decay of a field
/// is given in units of ω.
pub fn limit<I: Integrator>(damping_ratio: f64, decay: f64) -> f64 {
    let reach = reach::<I>(damping_ratio, decay);
    let margin = |fraction: f64| least(&rounded::<I, 1>([fraction * reach], damping_ratio, decay), 0);
    let at = |trial: usize| trial as f64 / TRIALS as f64;
    let (mut before, mut here) =
        ([f64::INFINITY; 4], rounded::<I, 1>([at(1) * reach], damping_ratio, decay).map(|[value]| value));
    for first in (2..=TRIALS).step_by(ABREAST) {
        let steps: [f64; ABREAST] = std::array::from_fn(|lane| at((first + lane).min(TRIALS)) * reach);
        let later = rounded::<I, ABREAST>(steps, damping_ratio, decay);
        for (lane, trial) in (first - 1..TRIALS.min(first - 1 + ABREAST)).enumerate() {
            let after = later.map(|lanes| lanes[lane]);
            let unstable = if after.iter().any(|&value| value < 0.0) {
                Some(at(trial + 1))
            } else {
                (0..after.len())
                    .filter(|&which| before[which] > here[which] && here[which] < after[which])
                    .map(|which| {
                        lowest(
                            |fraction| rounded::<I, 1>([fraction * reach], damping_ratio, decay)[which][0],
                            at(trial - 1),
                            at(trial + 1),
                        )
                    })
                    .filter(|&dip| margin(dip) < 0.0)
                    .reduce(f64::min)
            };
            if let Some(unstable) = unstable {
                return reach * edge(margin, at(trial - 1), unstable);
            }
            (before, here) = (here, after);
        }
    }
    reach
}

fn reach<I: Integrator>(damping_ratio: f64, decay: f64) -> f64 {
    2.0 * I::NODES.len() as f64 / damping_ratio.max(decay).max(1.0)
}

/// Factor by which the search for the last stable step extends beyond that for the limit: damped steps may be stable beyond 2 per
/// evaluation.
const FARTHER: usize = 4;

/// Computes the largest of all stable ωh, which is not less than the limit. Stable islands narrower than a trial may be missed.
/// Infinite if the farthest trial is stable.
pub fn last<I: Integrator>(damping_ratio: f64) -> f64 {
    let reach = reach::<I>(damping_ratio, 0.0);
    let margin = |fraction: f64| least(&rounded::<I, 1>([fraction * reach], damping_ratio, 0.0), 0);
    let at = |trial: usize| trial as f64 / TRIALS as f64;
    let stable = (1..=FARTHER * TRIALS / ABREAST).rev().find_map(|block| {
        let trial = |lane: usize| (block - 1) * ABREAST + lane + 1;
        let found = rounded::<I, ABREAST>(std::array::from_fn(|lane| at(trial(lane)) * reach), damping_ratio, 0.0);
        (0..ABREAST).rev().find(|&lane| least(&found, lane) >= 0.0).map(trial)
    });
    let found = match stable {
        Some(trial) if trial == FARTHER * TRIALS => f64::INFINITY,
        Some(trial) => reach * edge(margin, at(trial), at(trial + 1)),
        None => 0.0,
    };
    found.max(I::limit(damping_ratio))
}

/// Finds by bisection where `margin` changes sign between a stable and an unstable point.
fn edge(margin: impl Fn(f64) -> f64, mut stable: f64, mut unstable: f64) -> f64 {
    for _ in 0..60 {
        let middle = 0.5 * (stable + unstable);
        if margin(middle) < 0.0 { unstable = middle } else { stable = middle }
    }
    stable
}

/// Finds the minimum of a function that is unimodal between `low` and `high`, by golden-section search.
pub fn lowest(function: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let (mut left, mut right) = (high - GOLDEN * (high - low), low + GOLDEN * (high - low));
    let (mut at_left, mut at_right) = (function(left), function(right));
    for _ in 0..40 {
        if at_left < at_right {
            (high, right, at_right) = (right, left, at_left);
            left = high - GOLDEN * (high - low);
            at_left = function(left);
        } else {
            (low, left, at_left) = (left, right, at_right);
            right = low + GOLDEN * (high - low);
            at_right = function(right);
        }
    }
    0.5 * (low + high)
}
