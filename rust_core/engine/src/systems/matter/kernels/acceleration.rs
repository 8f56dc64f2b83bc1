//! Accelerations of a block: accumulated forces plus the linear force.

use super::activity::kinetic;
use super::axis_force::{AxisForce, UniformForce};
use super::power::{add_power, lanes};
use crate::catalog::Space;
use crate::forces::linear::AxisLaw;
use crate::math::{AXES, Real};
use crate::matter::{EnergySink, Power, Span, View};
use crate::simd::{Isa, Kernel, LANES, Lanes, Pack, dispatch};
use crate::systems::matter::dynamics::Dynamics;

/// One axis of a block.
struct AccelerationAxis<'a, T> {
    x: &'a [Lanes<T>],
    v: &'a [Lanes<T>],
    force: &'a mut [Lanes<T>],
    law: AxisLaw<'a, T>,
}

struct Accelerations<'a, T> {
    axes: [Option<AccelerationAxis<'a, T>>; AXES],
    inverse_mass: &'a [Lanes<T>],
    inertia: &'a [Lanes<T>],
    power: &'a mut Power,
    dissipates: bool,
}

/// Replaces the forces [N] on the particles of a block from `start` on by their accelerations [m/s²]. Adds the power of the
/// linear force, and returns the activity.
pub fn accelerations<V: Space>(
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
        Some(AccelerationAxis { x, v, force: force.as_chunks_mut().0, law: dynamics.linear.axis(axis, start, length) })
    });
    let inverse_mass = dynamics.properties.inverse_mass[range.clone()].as_chunks().0;
    let inertia = dynamics.properties.inertia[range].as_chunks().0;
    dispatch(Accelerations { axes, inverse_mass, inertia, power, dissipates: dynamics.linear.dissipates })
}

impl<T: Real> Kernel for Accelerations<'_, T> {
    type Output = f64;

    #[inline(always)]
    fn run<S: Isa>(self, _isa: S) -> f64 {
        let Self { axes, inverse_mass, inertia, power, dissipates } = self;
        let mut squares = [T::ZERO; LANES];
        for axis in axes.into_iter().flatten() {
            let weights = [inverse_mass, inertia];
            match axis.law {
                AxisLaw::Uniform(same) if dissipates => {
                    along::<S::Group<T>, _>(UniformForce::<_, true>(same), axis, weights, power, &mut squares);
                }
                AxisLaw::Uniform(same) => {
                    along::<S::Group<T>, _>(UniformForce::<_, false>(same), axis, weights, power, &mut squares);
                }
                AxisLaw::Varying(varying) => along::<S::Group<T>, _>(varying, axis, weights, power, &mut squares),
            }
        }
        kinetic(&squares)
    }
}

/// Accelerations along one axis. Adds to the powers, and Σ m v² to `squares`.
#[inline(always)]
fn along<G: Pack<Scalar: Real>, L: AxisForce<G::Scalar>>(
    law: L,
    AccelerationAxis { x, v, force, .. }: AccelerationAxis<'_, G::Scalar>,
    [inverse_mass, inertia]: [&[Lanes<G::Scalar>]; 2],
    power: &mut Power,
    squares: &mut Lanes<G::Scalar>,
) {
    let zero = G::constant(0.0);
    let (mut drag, mut work, mut moved) = (zero, zero, G::load(&*squares));
    for (group, force) in force.iter_mut().enumerate() {
        let coefficients = law.coefficients(|column| G::load(&column[group]));
        let (x, v) = (G::load(&x[group]), G::load(&v[group]));
        let [dissipated, supplied] = law.power(&coefficients, v);
        drag += dissipated;
        work += supplied;
        moved += G::load(&inertia[group]) * (v * v);
        let a = G::load(&*force) * G::load(&inverse_mass[group]) + law.acceleration(&coefficients, x, v);
        a.store(force);
    }
    moved.store(squares);
    add_power(&mut power[EnergySink::Drag as usize], &lanes(drag), law.unit());
    if L::SUPPLIES {
        add_power(&mut power[EnergySink::Work as usize], &lanes(work), law.unit());
    }
}
