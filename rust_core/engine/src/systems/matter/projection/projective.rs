//! Projective dynamics: a quasi-Newton iteration for backward Euler's equation with one matrix for all steps.
//!
//! With r = x + u of a spring and its projection L n, the elastic energy is that of a linear spring between both, so that
//!
//!     (M + h² Σ (k + c/h) Dᵀ D) Δu = −M (u − y) + h² F(x + u, u/h)
//!
//! decreases the incremental energy in every iteration. D takes differences of positions, so that the matrix is the same for all axes;
//! it is factorized once for each step size. Iterations start from u = 0, where a state of rest remains. Sources: S. Bouaziz et al.,
//! ACM Trans. Graph. 33, 154 (2014); T. Liu, S. Bouaziz, L. Kavan, ACM Trans. Graph. 36, 23 (2017) for the quasi-Newton form.

use glam::DVec3;

use super::colors::Colors;
use super::sweep::count;
use super::{Projector, about};
use crate::error::Result;
use crate::math::{AXES, Real, Vector};
use crate::matter::{Columns, Properties, Span, View};
use crate::scene::Item;
use crate::simd::{Kernel, LANES, dispatch};
use crate::sparse::Factorization;
use crate::systems::matter::dynamics::Dynamics;
use crate::systems::matter::method::About;

/// The class's name in Python.
pub const NAME: &str = "ProjectiveDynamics";

/// The projector.
pub struct Projective<V: Vector> {
    iterations: usize,
    /// What belongs to a step size [s].
    prepared: Option<(f64, Prepared<V::Scalar>)>,
    /// Predicted displacements y, the forces h² F, and the changes of all free particles.
    predicted: Columns<V>,
    force: Columns<V>,
    changes: Vec<DVec3>,
    buffer: Vec<DVec3>,
}

struct Prepared<T> {
    colors: Colors<T>,
    /// The particles that are not fixed.
    free: Vec<u32>,
    factorization: Factorization,
}

impl<V: Vector> Projective<V> {
    /// The projector that an item declares.
    ///
    /// # Errors
    /// If its iterations are missing or below 1.
    pub fn declared(item: &Item) -> Result<Self> {
        let (predicted, force) = (Columns::zeros(0), Columns::zeros(0));
        let iterations = count(item, "iterations")?;
        Ok(Self { iterations, prepared: None, predicted, force, changes: Vec::new(), buffer: Vec::new() })
    }
}

/// The factorized matrix M + h² Σ (k + c/h) Dᵀ D of the free particles, and these.
fn prepare<V: Vector>(dynamics: &Dynamics<V>, h: f64) -> Prepared<V::Scalar> {
    let Properties { mass, inverse_mass, .. } = &dynamics.properties;
    let free: Vec<u32> = (0..mass.len() as u32).filter(|&index| mass[index as usize].is_finite()).collect();
    let row = |particle: u32| free.binary_search(&particle).ok().map(|row| row as u32);
    let mut diagonal: Vec<f64> = free.iter().map(|&particle| mass[particle as usize]).collect();
    let mut pairs = Vec::new();
    for spring in dynamics.springs.iter().filter(|spring| spring.ends[0] != spring.ends[1]) {
        let weight = spring.stiffness * h * h + spring.damping * h;
        let rows = spring.ends.map(row);
        rows.into_iter().flatten().for_each(|row| diagonal[row as usize] += weight);
        if let [Some(one), Some(other)] = rows {
            pairs.push(([one.max(other), one.min(other)], -weight));
        }
    }
    pairs.sort_by_key(|&(pair, _)| pair);
    let (mut pattern, mut values): (Vec<[u32; 2]>, Vec<f64>) = (Vec::new(), Vec::new());
    for (pair, value) in pairs {
        match (pattern.last(), values.last_mut()) {
            (Some(last), Some(sum)) if *last == pair => *sum += value,
            _ => {
                pattern.push(pair);
                values.push(value);
            }
        }
    }
    let mut factorization = Factorization::new(free.len(), &pattern);
    factorization.factorize(&diagonal, 0.0, &values);
    Prepared { colors: Colors::new(&dynamics.springs, inverse_mass, mass.len(), h), free, factorization }
}

impl<V: Vector> Projector<V> for Projective<V> {
    fn about(&self) -> About {
        about(NAME, 1)
    }

    fn substeps(&self) -> usize {
        1
    }

    fn begin(&mut self, dynamics: &Dynamics<V>) {
        let count = dynamics.properties.count();
        (self.predicted, self.force) = (Columns::zeros(count), Columns::zeros(count));
        self.prepared = None;
    }

    fn project(&mut self, dynamics: &Dynamics<V>, from: &Columns<V>, displacement: &mut Columns<V>, h: f64) {
        if self.prepared.as_ref().is_none_or(|(known, _)| *known != h) {
            self.prepared = Some((h, prepare(dynamics, h)));
        }
        let Some((_, Prepared { colors, free, factorization })) = &mut self.prepared else { return };
        self.predicted.copy_from(displacement);
        for &particle in free.iter() {
            displacement.set(particle as usize, V::default());
        }
        self.changes.resize(free.len(), DVec3::ZERO);
        for _ in 0..self.iterations {
            let mut force = self.force.span();
            (0..V::DIMENSION).for_each(|axis| force.axes[axis].fill(V::Scalar::ZERO));
            dispatch(Forces::<V> { colors, from: from.view(), displacement: displacement.view(), force });
            for (change, &particle) in self.changes.iter_mut().zip(free.iter()) {
                let index = particle as usize;
                let inertia = self.predicted.get(index).widen() - displacement.get(index).widen();
                *change = dynamics.properties.mass[index] * inertia + self.force.get(index).widen();
            }
            factorization.solve(&mut self.changes, &mut self.buffer);
            for (change, &particle) in self.changes.iter().zip(free.iter()) {
                let index = particle as usize;
                displacement.set(index, V::narrow(displacement.get(index).widen() + *change));
            }
        }
    }

    fn bytes(&self) -> usize {
        let prepared = self.prepared.as_ref().map_or(0, |(_, prepared)| {
            prepared.colors.bytes() + prepared.factorization.bytes() + size_of_val(prepared.free.as_slice())
        });
        prepared + self.predicted.bytes() + self.force.bytes() + size_of_val(self.changes.as_slice())
    }
}

/// Adds the forces of all springs, times h².
struct Forces<'a, V: Vector> {
    colors: &'a Colors<V::Scalar>,
    from: View<'a, V>,
    displacement: View<'a, V>,
    force: Span<'a, V>,
}

impl<V: Vector> Kernel for Forces<'_, V> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { colors, from, displacement, mut force } = self;
        let [from, displacement] =
            [from, displacement].map(|view| -> [&[V::Scalar]; AXES] { std::array::from_fn(|axis| view.axis(axis)) });
        for index in 0..colors.groups.len() {
            let state = colors.state::<V>(index, &colors.read::<V>(index, from), &colors.read::<V>(index, displacement));
            let mut sums = colors.read::<V>(index, force.axes.each_ref().map(|axis| &**axis));
            for axis in 0..V::DIMENSION {
                for lane in 0..LANES {
                    let pull = state.pull[lane] * state.direction[axis][lane];
                    sums[0][axis][lane] += pull;
                    sums[1][axis][lane] -= pull;
                }
            }
            colors.write::<V>(index, &sums, &mut force);
        }
    }
}
