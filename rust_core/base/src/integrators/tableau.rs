//! Explicit Runge–Kutta methods from their Butcher tableaus: kᵢ = f(t + cᵢ h, y + h Σ aᵢⱼ kⱼ), y ← y + h Σ bᵢ kᵢ.
//!
//! Here y = (x, v) and x' = v, so only the acceleration of a slope has to be stored. Eliminating the velocities of the stages
//! gives a Nyström method:
//!
//! ```text
//!     xᵢ = x + h (cᵢ v + Σ h āᵢⱼ aⱼ),   vᵢ = v + Σ h aᵢⱼ aⱼ,   ā = a·a
//! ```
//!
//! The step's end follows likewise, with b for a. If only the last slope has a weight, x uses its velocity directly, which is
//! shorter. A step keeps x, v and the accelerations until only one acceleration is missing from its end. Then the sums for x and
//! v take their registers, and the error estimates, if any, two more.
//!
//! If the last row of a is b, the last slope is the first one of the next step ("first same as last"). Its acceleration persists,
//! and its evaluation ends the step.
//!
//! Source: E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed. (1993), sec. II.1, II.4
//! and II.14.

use std::marker::PhantomData;

use super::{Compiled, Component, Integrator, REGISTERS, amplification};
use crate::simd::Number;

/// Coefficients of an explicit Runge–Kutta method.
pub trait Tableau: Send + Sync + Sized + 'static {
    /// Name of the class in Python.
    const NAME: &'static str;
    /// Order of convergence.
    const ORDER: u32;
    /// Coefficients aᵢⱼ, row by row, left of the diagonal. The sum of a row is cᵢ.
    const A: &'static [&'static [f64]];
    /// Weights bᵢ; the last is 0 if the last row of a equals the other weights.
    const B: &'static [f64];
    /// Nodes cᵢ.
    const C: &'static [f64];
    /// Weights bᵢ minus those of the embedded method, for the estimated error; empty if none is embedded.
    const ERRORS: &'static [f64] = &[];
    /// Length of the stable interval on the negative real axis, for critical damping or more.
    const REAL_AXIS: f64;
    /// [`Integrator::IN_REGISTERS`].
    const IN_REGISTERS: bool = false;

    /// Largest stable ω·h for a damping ratio ξ < 1.
    fn underdamped_limit(damping_ratio: f64) -> f64 {
        amplification::limit::<RungeKutta<Self>>(damping_ratio, 0.0)
    }
}

/// Integrator of a tableau.
#[derive(Debug)]
pub struct RungeKutta<S>(PhantomData<S>);

/// Register of the acceleration at the state between steps, if it persists.
const FIRST: usize = 0;
/// Register of the sum for v, once only one slope is missing from it.
const SUM_V: usize = 0;
/// Registers of the estimated errors of x and v, from then on until the next step begins.
const ERROR_X: usize = 1;
const ERROR_V: usize = 2;
/// Register of the velocity at the step's start, until only one slope is missing.
const V0: usize = 2;
/// Register of the position at the step's start, and later of the position at its end.
const X0: usize = 3;
const SUM_X: usize = 3;
/// Registers of the accelerations of the first slopes, until only one slope is missing.
const SLOPES: [usize; 4] = [FIRST, 1, 4, 5];
/// Maximum number of slopes of a tableau.
const MOST: usize = REGISTERS + 1;

/// Weights of the accelerations from weights of the slopes' velocities: Σᵢ wᵢ aᵢⱼ.
const fn of_accelerations(a: &[&[f64]], weights: &[f64]) -> [f64; MOST] {
    let mut found = [0.0; MOST];
    let mut slope = 0;
    while slope < weights.len() {
        let mut earlier = 0;
        while earlier < a[slope].len() {
            found[earlier] += weights[slope] * a[slope][earlier];
            earlier += 1;
        }
        slope += 1;
    }
    found
}

/// Pads weights with zeros.
const fn padded(weights: &[f64]) -> [f64; MOST] {
    let mut all = [0.0; MOST];
    let mut index = 0;
    while index < weights.len() {
        all[index] = weights[index];
        index += 1;
    }
    all
}

/// Whether weights add up to a number, up to rounding.
const fn add_up(weights: &[f64], number: f64) -> bool {
    let (mut sum, mut scale, mut index) = (-number, 1.0, 0);
    while index < weights.len() {
        sum += weights[index];
        scale += weights[index].abs();
        index += 1;
    }
    sum.abs() <= 4.0 * f64::EPSILON * scale
}

/// State within a step: that of a slope, or the step's end.
struct TableauRow {
    /// Node c, in units of h.
    node: f64,
    /// Weights of the accelerations for v, in units of h.
    velocity: [f64; MOST],
    /// Weights of the accelerations for x, in units of h².
    position: [f64; MOST],
    /// Whether only the last slope has a weight, so x uses its velocity.
    is_plain: bool,
}

impl TableauRow {
    const fn new(a: &[&[f64]], weights: &[f64], node: f64) -> Self {
        let (mut is_plain, mut slope) = (!weights.is_empty(), 1);
        while slope < weights.len() {
            is_plain &= weights[slope - 1] == 0.0;
            slope += 1;
        }
        Self { node, velocity: padded(weights), position: of_accelerations(a, weights), is_plain }
    }
}

/// Layout of a tableau in stages, each a state and the slope evaluated there.
trait TableauLayout: Tableau {
    /// Whether a step begins with the last slope of the previous step.
    const REUSES: bool = Self::B.len() > 1 && Self::B[Self::B.len() - 1] == 0.0;
    /// Index of the last slope on which the step's end depends.
    const LAST: usize = Self::B.len() - 1 - Self::REUSES as usize;
    /// States of the slopes, then the step's end.
    const ROWS: &'static [TableauRow; MOST] = &{
        let mut rows = [const { TableauRow::new(Self::A, Self::B, 1.0) }; MOST];
        let mut slope = 0;
        while slope <= Self::LAST {
            rows[slope] = TableauRow::new(Self::A, Self::A[slope], Self::C[slope]);
            slope += 1;
        }
        rows
    };
    /// Weights of the accelerations for the error of v, in units of h.
    const ERRORS_OF_V: &'static [f64; MOST] = &padded(Self::ERRORS);
    /// Weights of the accelerations for the error of x, in units of h².
    const ERRORS_OF_X: &'static [f64; MOST] = &of_accelerations(Self::A, Self::ERRORS);
    /// Compile-time check of the tableau.
    const CONSISTENT: () = {
        let (a, b, c) = (Self::A, Self::B, Self::C);
        assert!(a.len() == b.len() && c.len() == b.len(), "one row, one weight and one node per slope");
        assert!(Self::LAST < REGISTERS, "no more accelerations to keep than registers, and to sum up than are written out");
        assert!(add_up(b, 1.0) && add_up(Self::ERRORS, 0.0));
        let mut slope = 0;
        while slope < a.len() {
            assert!(a[slope].len() == slope && add_up(a[slope], c[slope]), "an explicit method, whose nodes are sums of rows");
            let mut earlier = 0;
            while Self::REUSES && slope > Self::LAST && earlier < slope {
                assert!(a[slope][earlier] == b[earlier], "a last row that is the step's end");
                earlier += 1;
            }
            slope += 1;
        }
    };
}

impl<S: Tableau> TableauLayout for S {}

/// Computes Σ (h wⱼ) aⱼ over the nonzero weights of the first `known` accelerations; None if all weights are 0. Accelerations of
/// equal weights in a row are added first. The sum is written out, like [`super::for_each_stage`].
#[inline(always)]
#[allow(unused_assignments, reason = "the last pass of a loop that is written out")]
fn sum<T: Number>(weights: &[f64; MOST], accelerations: &[T; MOST], known: usize, h: T) -> Option<T> {
    let (mut sum, mut equal) = (None, None);
    macro_rules! add {
        ($($slope:literal)*) => {
            $(if $slope < known && weights[$slope] != 0.0 {
                let a = accelerations[$slope];
                let equals = if let Some(equal) = equal { equal + a } else { a };
                equal = Some(equals);
                if $slope + 1 == known || weights[$slope + 1] != weights[$slope] {
                    let term = h * T::constant(weights[$slope]) * equals;
                    (sum, equal) = (Some(if let Some(sum) = sum { sum + term } else { term }), None);
                }
            })*
        };
    }
    add!(0 1 2 3 4);
    sum
}

/// Computes x and v in a state of the step, from the first `known` accelerations. The last known slope has the velocity `last`.
#[inline(always)]
fn state<T: Number>(row: &TableauRow, [x, v]: [T; 2], last: T, accelerations: &[T; MOST], known: usize, h: T) -> [T; 2] {
    let velocity = match sum(&row.velocity, accelerations, known, h) {
        Some(change) => v + change,
        None => v,
    };
    if row.is_plain {
        return [x + h * T::constant(row.velocity[known - 1]) * last, velocity];
    }
    let drift = T::constant(row.node) * v;
    let mean = match sum(&row.position, accelerations, known, h) {
        Some(change) => drift + change,
        None => drift,
    };
    [x + h * mean, velocity]
}

impl<S: Tableau> Integrator for RungeKutta<S> {
    type Swept = Compiled<Self>;
    const IN_REGISTERS: bool = S::IN_REGISTERS;
    const NAME: &'static str = S::NAME;
    const ORDER: u32 = S::ORDER;
    const ORDER_DISSIPATIVE: u32 = S::ORDER;
    const NODES: &'static [f64] = S::C.split_at(S::REUSES as usize).1;
    const WEIGHTS: &'static [f64] = S::B.split_at(S::REUSES as usize).1;
    const LAST_WEIGHT: f64 = if S::REUSES { S::B[0] } else { 0.0 };
    const REGISTERS: usize = match S::LAST {
        0 => 0,
        1..=3 => 4,
        last => last + 1,
    };
    const PERSISTENT: usize = S::REUSES as usize;
    const READABLE: usize = if S::ERRORS.is_empty() { Self::PERSISTENT } else { 3 };
    const ERROR: Option<[usize; 2]> = if S::ERRORS.is_empty() { None } else { Some([ERROR_X, ERROR_V]) };
    const POSITION_REGISTER: Option<usize> = if S::LAST == 0 { None } else { Some(X0) };

    /// Limit from the amplification factor R(z) at z = ωh(−ξ ± √(ξ² − 1)). For ξ ≥ 1 both z are real, and the larger governs.
    fn limit(damping_ratio: f64) -> f64 {
        if damping_ratio < 1.0 {
            S::underdamped_limit(damping_ratio)
        } else {
            S::REAL_AXIS / (damping_ratio + ((damping_ratio - 1.0) * (damping_ratio + 1.0)).sqrt())
        }
    }

    /// For ξ ≥ 1, equals the limit: on the real axis stable steps form one interval.
    fn last(damping_ratio: f64) -> f64 {
        if damping_ratio < 1.0 { amplification::last::<Self>(damping_ratio) } else { Self::limit(damping_ratio) }
    }

    #[inline(always)]
    fn begin<T: Number>(component: &mut Component<T>, a: T) {
        if S::REUSES {
            component.registers[FIRST] = a;
        }
    }

    #[inline(always)]
    fn stage_state<T: Number>(stage: usize, component: &mut Component<T>, h: T) {
        const { S::CONSISTENT };
        // Later stages already are at the state that `stage_update` computed.
        if stage == 0 && S::LAST > 0 {
            let start = [component.x, component.v];
            [component.registers[X0], component.registers[V0]] = start;
            if S::REUSES {
                let known = [component.registers[FIRST]; MOST];
                [component.x, component.v] = state(&S::ROWS[1], start, component.v, &known, 1, h);
            }
        }
    }

    #[inline(always)]
    fn stage_update<T: Number>(stage: usize, component: &mut Component<T>, a: T, h: T) {
        let registers = &mut component.registers;
        let slope = stage + usize::from(S::REUSES);
        if slope < S::LAST {
            let start = [registers[X0], registers[V0]];
            let mut slopes =
                [registers[0], registers[1], registers[4], registers[5], T::constant(0.0), T::constant(0.0), T::constant(0.0)];
            slopes[slope] = a;
            let (last, known) = (component.v, slope + 1);
            [component.x, component.v] = state(&S::ROWS[known], start, last, &slopes, known, h);
            if known < S::LAST {
                registers[SLOPES[slope]] = a;
                return;
            }
            [registers[SUM_X], registers[SUM_V]] = state(&S::ROWS[S::LAST + 1], start, last, &slopes, known, h);
            if !S::ERRORS.is_empty() {
                registers[ERROR_X] = h * sum(S::ERRORS_OF_X, &slopes, known, h).unwrap_or(T::constant(0.0));
                registers[ERROR_V] = sum(S::ERRORS_OF_V, &slopes, known, h).unwrap_or(T::constant(0.0));
            }
            return;
        }
        if slope > S::LAST {
            registers[FIRST] = a;
        } else if slope == 0 {
            component.x += h * component.v;
            component.v += h * a;
        } else {
            component.x = registers[SUM_X];
            component.v = registers[SUM_V] + h * T::constant(S::B[S::LAST]) * a;
        }
        if !S::ERRORS.is_empty() {
            if S::ERRORS_OF_X[slope] != 0.0 {
                registers[ERROR_X] += h * (h * T::constant(S::ERRORS_OF_X[slope]) * a);
            }
            registers[ERROR_V] += h * T::constant(S::ERRORS_OF_V[slope]) * a;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::bogacki_shampine_3::BogackiShampine;
    use super::super::dormand_prince_5::DormandPrince;
    use super::super::explicit_euler::Euler;
    use super::super::runge_kutta_4::Kutta;
    use super::{Component, Integrator, RungeKutta, Tableau};

    fn acceleration(x: f64, v: f64) -> f64 {
        -2.0 * x.sin() - 0.3 * v * v.abs()
    }

    /// Computes the step's end and the estimated errors of x and v from the definition.
    fn textbook<S: Tableau>(y: [f64; 2], h: f64) -> [[f64; 2]; 2] {
        let mut slopes: Vec<[f64; 2]> = Vec::new();
        let sum = |weights: &[f64], slopes: &[[f64; 2]]| {
            let of =
                |component: usize| weights.iter().zip(slopes).map(|(weight, slope)| h * weight * slope[component]).sum::<f64>();
            [of(0), of(1)]
        };
        for row in S::A {
            let change = sum(row, &slopes);
            let (x, v) = (y[0] + change[0], y[1] + change[1]);
            slopes.push([v, acceleration(x, v)]);
        }
        let change = sum(S::B, &slopes);
        [[y[0] + change[0], y[1] + change[1]], sum(S::ERRORS, &slopes)]
    }

    /// Tolerance: the numbers are of the order of 1, and at most about fifty roundings enter, each of at most 1.1e-16.
    fn assert_steps<S: Tableau>() {
        let (mut component, h) = (Component::new(1.2, -0.4, 0.0), 0.3);
        RungeKutta::<S>::begin(&mut component, acceleration(1.2, -0.4));
        for step in 0..3 {
            let [end, errors] = textbook::<S>([component.x, component.v], h);
            for stage in 0..RungeKutta::<S>::NODES.len() {
                RungeKutta::<S>::stage_state(stage, &mut component, h);
                let a = acceleration(component.x, component.v);
                RungeKutta::<S>::stage_update(stage, &mut component, a, h);
            }
            let mut pairs = vec![(component.x, end[0]), (component.v, end[1])];
            if let Some(registers) = RungeKutta::<S>::ERROR {
                pairs.extend(registers.map(|register| component.registers[register]).into_iter().zip(errors));
            }
            for (found, expected) in pairs {
                assert!((found - expected).abs() < 50.0 * f64::EPSILON, "{} in step {step}: {found}, not {expected}", S::NAME);
            }
        }
    }

    #[test]
    fn a_step_is_that_of_the_definition() {
        assert_steps::<Euler>();
        assert_steps::<Kutta>();
        assert_steps::<BogackiShampine>();
        assert_steps::<DormandPrince>();
    }
}
