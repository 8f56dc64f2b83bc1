//! The accelerations of a block: accumulated forces plus the linear force.

use super::activity::kinetic;
use super::axis_force::{AxisForce, Uniform};
use super::power::add_power;
use crate::forces::linear::AxisLaw;
use crate::math::{AXES, Real, Vector};
use crate::matter::{EnergySink, Power, Span, View};
use crate::simd::{Kernel, LANES, Lanes, dispatch};
use crate::systems::matter::dynamics::Dynamics;

/// One axis of a block.
struct Axis<'a, T> {
    x: &'a [Lanes<T>],
    v: &'a [Lanes<T>],
    force: &'a mut [Lanes<T>],
    law: AxisLaw<'a, T>,
}

struct Accelerations<'a, T> {
    axes: [Option<Axis<'a, T>>; AXES],
    inverse_mass: &'a [Lanes<T>],
    inertia: &'a [Lanes<T>],
    power: &'a mut Power,
    dissipates: bool,
}

/// Replaces the forces on the particles of a block from `start` on [N] by their accelerations [m/s²], adds the power of the
/// linear force, and returns the activity.
pub fn accelerations<V: Vector>(
    dynamics: &Dynamics<V>,
    start: usize,
    (position, velocity): (View<'_, V>, View<'_, V>),
    force: &mut Span<'_, V>,
    power: &mut Power,
) -> f64 {
    let length = force.len();
    let range = start..start + length;
    let mut forces = force.axes.iter_mut();
    let axes = std::array::from_fn(|axis| {
        let force = forces.next().filter(|_| axis < V::DIMENSION)?;
        let [x, v] = [position, velocity].map(|columns| columns.slice(axis, range.clone()).as_chunks().0);
        Some(Axis { x, v, force: force.as_chunks_mut().0, law: dynamics.linear.axis(axis, start, length) })
    });
    let inverse_mass = dynamics.properties.inverse_mass[range.clone()].as_chunks().0;
    let inertia = dynamics.properties.inertia[range].as_chunks().0;
    dispatch(Accelerations { axes, inverse_mass, inertia, power, dissipates: dynamics.linear.dissipates })
}

impl<T: Real> Kernel for Accelerations<'_, T> {
    type Output = f64;

    #[inline(always)]
    fn run(self) -> f64 {
        let Self { axes, inverse_mass, inertia, power, dissipates } = self;
        let mut squares = [T::ZERO; LANES];
        for axis in axes.into_iter().flatten() {
            let weights = (inverse_mass, inertia);
            match axis.law {
                AxisLaw::Uniform(same) if dissipates => along(Uniform::<_, true>(same), axis, weights, power, &mut squares),
                AxisLaw::Uniform(same) => along(Uniform::<_, false>(same), axis, weights, power, &mut squares),
                AxisLaw::Varying(varying) => along(varying, axis, weights, power, &mut squares),
            }
        }
        kinetic(&squares)
    }
}

/// The accelerations along one axis. Adds to the powers, and Σ m v² to `squares`.
#[inline(always)]
fn along<T: Real, L: AxisForce<T>>(
    law: L,
    Axis { x, v, force, .. }: Axis<'_, T>,
    (inverse_mass, inertia): (&[Lanes<T>], &[Lanes<T>]),
    power: &mut Power,
    squares: &mut Lanes<T>,
) {
    let (mut drag, mut work, mut moved) = ([T::ZERO; LANES], [T::ZERO; LANES], *squares);
    for (group, force) in force.iter_mut().enumerate() {
        let coefficients = law.coefficients(|column| column[group]);
        let (x, v, inverse_mass, inertia, mut a) = (x[group], v[group], inverse_mass[group], inertia[group], *force);
        for lane in 0..LANES {
            let own = law.of_lane(&coefficients, lane);
            let [dissipated, supplied] = law.power(&own, v[lane]);
            drag[lane] += dissipated;
            work[lane] += supplied;
            moved[lane] += inertia[lane] * (v[lane] * v[lane]);
            a[lane] = a[lane] * inverse_mass[lane] + law.acceleration(&own, x[lane], v[lane]);
        }
        *force = a;
    }
    *squares = moved;
    add_power(&mut power[EnergySink::Drag as usize], &drag, law.unit());
    if L::SUPPLIES {
        add_power(&mut power[EnergySink::Work as usize], &work, law.unit());
    }
}
