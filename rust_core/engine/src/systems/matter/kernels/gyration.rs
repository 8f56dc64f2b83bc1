//! Boris' kick: half of the kick by all other forces, a rotation of the velocity in the magnetic field, and the other half.
//!
//! With t = q B h/2m the rotation about −B by 2 atan |t| is v⁺ = v⁻ + (v⁻ + v⁻ × t) × 2t/(1 + t²), which conserves |v|. For
//! the exact angle |q B| h/m, t is lengthened to tan |t|.
//!
//! Sources: J. P. Boris, Proc. 4th Conf. Numerical Simulation of Plasmas (1970) 3; C. K. Birdsall, A. B. Langdon, Plasma
//! Physics via Computer Simulation (1985), § 4-3 and § 4-4.

use std::ops::Range;

use crate::catalog::Space;
use crate::forces::{PART, StateView, Strength};
use crate::math::{AXES, Real};
use crate::matter::Span;
use crate::simd::{Isa, Kernel, LANES, Lanes, dispatch};
use crate::systems::matter::dynamics::Dynamics;
use crate::systems::matter::methods::Angle;

/// Particles of a part of a block, with the accelerations by the linear force [m/s²].
struct Gyration<'a, V: Space> {
    range: Range<usize>,
    strength: &'a Strength<V>,
    linear: &'a [[V::Scalar; PART]; AXES],
    inverse_mass: &'a [V::Scalar],
    inertia: &'a [V::Scalar],
    before: &'a Span<'a, V>,
    force: Span<'a, V>,
    h: f64,
}

/// Replaces the forces on a block by the mean force of Boris' kick of `h` seconds. On entry the forces are the sum of all but
/// the magnetic ones. The kick starts from the velocities `before`.
pub fn gyrate<V: Space>(
    dynamics: &Dynamics<V>,
    block: &Range<usize>,
    at: &StateView<'_, V>,
    before: &Span<'_, V>,
    h: f64,
    force: &mut Span<'_, V>,
) {
    let mut strength = Strength::<V>::default();
    let mut linear = [[V::Scalar::ZERO; PART]; AXES];
    for start in (block.start..block.end).step_by(PART) {
        let some = start..(start + PART).min(block.end);
        strength.clear();
        dynamics.magnetic(some.clone(), at, &mut strength);
        if dynamics.angle == Some(Angle::Exact) {
            lengthen(&mut strength, dynamics, &some, h);
        }
        if dynamics.has_linear() {
            for axis in 0..V::DIMENSION {
                let (x, v) = (at.position.slice(axis, some.clone()), at.velocity.slice(axis, some.clone()));
                for (place, (&x, &v)) in x.iter().zip(v).enumerate() {
                    linear[axis][place] = dynamics.linear.acceleration(axis, start + place, x, v);
                }
            }
        }
        dispatch(Gyration {
            range: start - block.start..some.end - block.start,
            strength: &strength,
            linear: &linear,
            inverse_mass: &dynamics.properties.inverse_mass[some.clone()],
            inertia: &dynamics.properties.inertia[some],
            before,
            force: force.reborrow(),
            h,
        });
    }
}

/// Lengthens t to tan |t|, for the exact angle.
fn lengthen<V: Space>(strength: &mut Strength<V>, dynamics: &Dynamics<V>, some: &Range<usize>, h: f64) {
    for (place, index) in some.clone().enumerate() {
        let half = 0.5 * h * strength.get(place).length() * dynamics.properties.inverse_mass[index].to_f64();
        if half > 0.0 {
            let factor = V::Scalar::from_f64(libm::tan(half) / half);
            for axis in 0..AXES {
                strength.axes[axis][place] *= factor;
            }
        }
    }
}

impl<V: Space> Kernel for Gyration<'_, V> {
    type Output = ();

    #[inline(always)]
    fn run<S: Isa>(self, _isa: S) {
        let Self { range, strength, linear, inverse_mass, inertia, before, force, h } = self;
        let (half_step, step) = (V::Scalar::from_f64(0.5 * h), V::Scalar::from_f64(h));
        let zero = [V::Scalar::ZERO; LANES];
        let groups = range.len() / LANES;
        for group in 0..groups {
            let first = group * LANES;
            let at = range.start + first;
            let read = |column: &[V::Scalar], at: usize| -> Lanes<V::Scalar> {
                let mut lanes = zero;
                lanes.copy_from_slice(&column[at..at + LANES]);
                lanes
            };
            let (inverse_mass, inertia) = (read(inverse_mass, first), read(inertia, first));
            let mut columns = [[zero; AXES]; 4];
            for axis in 0..AXES {
                columns[0][axis] = read(&strength.axes[axis], first);
                if axis < V::DIMENSION {
                    columns[1][axis] = read(&linear[axis], first);
                    columns[2][axis] = read(before.axes[axis], at);
                    columns[3][axis] = read(force.axes[axis], at);
                }
            }
            let [strengths, accelerations, velocities, forces] = columns;
            let mut kicked = forces;
            for lane in 0..LANES {
                let of = |columns: &[Lanes<V::Scalar>; AXES]| [columns[0][lane], columns[1][lane], columns[2][lane]];
                let [f, a, v, s] = [of(&forces), of(&accelerations), of(&velocities), of(&strengths)];
                let by_mass = half_step * inverse_mass[lane];
                let turn = s.map(|s| s * by_mass);
                let turn = if V::DIMENSION == 2 { [V::Scalar::ZERO, V::Scalar::ZERO, turn[0]] } else { turn };
                let mut half = [V::Scalar::ZERO; AXES];
                for axis in 0..V::DIMENSION {
                    half[axis] = f[axis] * by_mass + a[axis] * half_step;
                }
                let increment = kick(v, half, turn);
                // A particle that does not turn keeps the exact bits of its force.
                let turns = turn != [V::Scalar::ZERO; AXES];
                for axis in 0..V::DIMENSION {
                    // Division: a rounded 1/h would lengthen or shorten the velocity by the same fraction in each step.
                    let mean = increment[axis] / step - a[axis];
                    kicked[axis][lane] = if turns { mean * inertia[lane] } else { f[axis] };
                }
            }
            for axis in 0..V::DIMENSION {
                force.axes[axis][at..at + LANES].copy_from_slice(&kicked[axis]);
            }
        }
    }
}

/// Increment of a velocity v in Boris' kick: twice the half kick by all other forces, and the rotation by t between them.
#[inline(always)]
pub fn kick<T: Real>(v: [T; AXES], half: [T; AXES], t: [T; AXES]) -> [T; AXES] {
    let minus = [v[0] + half[0], v[1] + half[1], v[2] + half[2]];
    let tilt = cross(minus, t);
    let middle = [minus[0] + tilt[0], minus[1] + tilt[1], minus[2] + tilt[2]];
    let square = t[0] * t[0] + t[1] * t[1] + t[2] * t[2];
    let scale = T::from_f64(2.0) / (T::ONE + square);
    let change = cross(middle, t).map(|change| change * scale);
    [half[0] + half[0] + change[0], half[1] + half[1] + change[1], half[2] + half[2] + change[2]]
}

#[inline(always)]
fn cross<T: Real>(a: [T; AXES], b: [T; AXES]) -> [T; AXES] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
