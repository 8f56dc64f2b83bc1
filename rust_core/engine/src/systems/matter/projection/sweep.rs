//! Extended position-based dynamics: sweeps over the springs, each of which takes the displacements that satisfy it alone.
//!
//! With the multiplier q = h² F of a spring, from 0 at the start of each part of a step,
//!
//!     Δq = (h² [k (r − L) + c n·Δu/h] − q) / (1 + (w₁ + w₂) (k h² + c h)),   u₁ ← u₁ + w₁ n Δq,  u₂ ← u₂ − w₂ n Δq
//!
//! which for c = 0 is Δλ = (−C − α̃ λ)/(w + α̃) with the compliance α̃ = 1/(k h²). Springs of a color have no common particles, and colors
//! follow each other: Gauss and Seidel's iteration, in one fixed order. Sources: M. Macklin, M. Müller, N. Chentanez, "XPBD", MIG 2016;
//! M. Macklin et al., "Small steps in physics simulation", SCA 2019.

use super::colors::Colors;
use super::{Projector, about};
use crate::error::{Error, Result};
use crate::math::{AXES, Real, Vector};
use crate::matter::{Columns, Span, View};
use crate::scene::Item;
use crate::simd::{Kernel, LANES, Lanes, dispatch};
use crate::systems::matter::dynamics::Dynamics;
use crate::systems::matter::method::About;

/// The class's name in Python.
pub const NAME: &str = "XPBD";

/// The projector.
#[derive(Debug)]
pub struct Sweeps<T> {
    substeps: usize,
    iterations: usize,
    /// The springs, for steps of this length [s].
    colors: Option<(f64, Colors<T>)>,
    /// Multipliers q by groups [kg·m].
    multipliers: Vec<Lanes<T>>,
}

impl<T> Sweeps<T> {
    /// The projector that an item declares.
    ///
    /// # Errors
    /// If a number is missing or below 1.
    pub fn declared(item: &Item) -> Result<Self> {
        let [substeps, iterations] = [count(item, "substeps")?, count(item, "iterations")?];
        Ok(Self { substeps, iterations, colors: None, multipliers: Vec::new() })
    }
}

/// A whole number of an item, at least 1.
pub fn count(item: &Item, name: &str) -> Result<usize> {
    match item.number(name)? {
        number if number >= 1.0 && number.fract() == 0.0 => Ok(number as usize),
        other => Err(Error::parameter(format!("{}.{name}", item.path), "a whole number ≥ 1", other)),
    }
}

impl<V: Vector> Projector<V> for Sweeps<V::Scalar> {
    fn about(&self) -> About {
        about(NAME, self.substeps)
    }

    fn substeps(&self) -> usize {
        self.substeps
    }

    fn begin(&mut self, _dynamics: &Dynamics<V>) {
        self.colors = None;
    }

    fn project(&mut self, dynamics: &Dynamics<V>, from: &Columns<V>, displacement: &mut Columns<V>, h: f64) {
        if self.colors.as_ref().is_none_or(|(known, _)| *known != h) {
            let properties = &dynamics.properties;
            self.colors = Some((h, Colors::new(&dynamics.springs, &properties.inverse_mass, properties.count(), h)));
        }
        let Some((_, colors)) = &self.colors else { return };
        self.multipliers.clear();
        self.multipliers.resize(colors.groups.len(), [V::Scalar::ZERO; LANES]);
        for _ in 0..self.iterations {
            dispatch(Sweep::<V> {
                colors,
                from: from.view(),
                displacement: displacement.span(),
                multipliers: &mut self.multipliers,
            });
        }
    }

    fn bytes(&self) -> usize {
        size_of_val(self.multipliers.as_slice()) + self.colors.as_ref().map_or(0, |(_, colors)| colors.bytes())
    }
}

struct Sweep<'a, V: Vector> {
    colors: &'a Colors<V::Scalar>,
    from: View<'a, V>,
    displacement: Span<'a, V>,
    multipliers: &'a mut [Lanes<V::Scalar>],
}

impl<V: Vector> Kernel for Sweep<'_, V> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { colors, from, mut displacement, multipliers } = self;
        let from: [&[V::Scalar]; AXES] = std::array::from_fn(|axis| from.axis(axis));
        for (index, multipliers) in multipliers.iter_mut().enumerate() {
            let group = &colors.groups[index];
            let mut moved = colors.read::<V>(index, displacement.axes.each_ref().map(|axis| &**axis));
            let state = colors.state::<V>(index, &colors.read::<V>(index, from), &moved);
            let mut change = [V::Scalar::ZERO; LANES];
            for lane in 0..LANES {
                let weight = group.inverse_mass[0][lane] + group.inverse_mass[1][lane];
                let total = V::Scalar::ONE + weight * (group.stiffness[lane] + group.damping[lane]);
                change[lane] = (state.pull[lane] - multipliers[lane]) / total;
                multipliers[lane] += change[lane];
            }
            for axis in 0..V::DIMENSION {
                for lane in 0..LANES {
                    let impulse = change[lane] * state.direction[axis][lane];
                    moved[0][axis][lane] += group.inverse_mass[0][lane] * impulse;
                    moved[1][axis][lane] -= group.inverse_mass[1][lane] * impulse;
                }
            }
            colors.write::<V>(index, &moved, &mut displacement);
        }
    }
}
