//! Projective dynamics: a quasi-Newton iteration for backward Euler's equation with one matrix for all steps.
//!
//! With r = x + u of a spring and its projection L n, the elastic energy is that of a linear spring between both. Therefore
//!
//!     (M + h² Σ (k + c/h) Dᵀ D) Δu = −M (u − y) + h² F(x + u, u/h)
//!
//! decreases the incremental energy in every iteration. D takes differences of positions, so that the matrix is the same for
//! all axes. It is factorized once for each step size. The matrix is stiff across springs too, where a swinging cloth is not.
//! Quasi-Newton updates from the iterations correct this ([`super::curvature`]). Iterations start from u = h v, which
//! conserves a state of rest, and motion too. Sources: S. Bouaziz et al., ACM Trans. Graph. 33, 154 (2014); T. Liu, S.
//! Bouaziz, L. Kavan, ACM Trans. Graph. 36, 23 (2017) for the quasi-Newton form.

use glam::{DVec3, DVec4};

use super::curvature::{Curvature, dot};
use super::links::{Point, ProjectionLink, gather, links, scatter};
use super::sweep::count;
use super::{Projector, about};
use crate::catalog::Space;
use crate::error::Result;
use crate::math::Real;
use crate::matter::{Columns, Matter};
use crate::parallel::Executor;
use crate::scene::Item;
use crate::simd::{Isa, Kernel, dispatch};
use crate::sparse::Factorization;
use crate::systems::matter::dynamics::Dynamics;
use crate::systems::matter::methods::MethodProperties;

/// Name of the class in Python.
pub const NAME: &str = "ProjectiveDynamics";

/// Maximum number of halvings of a step. Largest ascent of the energy at the end of a step, over its descent at the start. A
/// step that is too short is accepted: the energy falls along it, though hardly more slowly at its end.
const MOST_HALVINGS: usize = 6;
const DESCENT: f64 = 0.95;

/// Projector of projective dynamics.
pub struct Projective<V: Space> {
    iterations: usize,
    /// Data prepared for a step size [s].
    prepared: Option<(f64, Prepared<V::Scalar>)>,
    /// Positions, predicted displacements y and displacements u [m], and forces h² F [kg·m].
    from: Vec<Point<V::Scalar>>,
    predicted: Vec<Point<V::Scalar>>,
    displacements: Vec<Point<V::Scalar>>,
    forces: Vec<Point<V::Scalar>>,
    /// Residuals of the free particles, and their stored changes.
    residual: Vec<DVec3>,
    curvature: Curvature,
    buffer: Vec<DVec4>,
}

struct Prepared<T> {
    links: Vec<ProjectionLink<T>>,
    /// Particles that are not fixed.
    free: Vec<u32>,
    factorization: Factorization,
}

impl<V: Space> Projective<V> {
    /// Builds the projector that an item declares.
    ///
    /// # Errors
    /// If its iterations are missing or below 1.
    pub fn declared(item: &Item) -> Result<Self> {
        let empty = [const { Vec::new() }; 4];
        let [from, predicted, displacements, forces] = empty;
        let (iterations, residual, buffer) = (count(item, "iterations")?, Vec::new(), Vec::new());
        let curvature = Curvature::default();
        Ok(Self { iterations, prepared: None, from, predicted, displacements, forces, residual, curvature, buffer })
    }
}

/// Factorized matrix M + h² Σ (k + c/h) Dᵀ D of the free particles, and these particles.
///
/// # Errors
/// If it does not fit into memory, or on an interrupt.
fn prepare<V: Space>(dynamics: &Dynamics<V>, h: f64, executor: &Executor) -> Result<Prepared<V::Scalar>> {
    let mass = &dynamics.properties.mass;
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
    let links = links(&dynamics.springs, &dynamics.properties, h);
    let mut factorization = Factorization::new(free.len(), &pattern, executor)?;
    factorization.factorize(&diagonal, 0.0, &values, executor);
    executor.check()?;
    Ok(Prepared { links, free, factorization })
}

impl<V: Space> Projector<V> for Projective<V> {
    fn about(&self) -> MethodProperties {
        about(NAME, 1)
    }

    fn substeps(&self) -> usize {
        1
    }

    fn begin(&mut self, _dynamics: &Dynamics<V>) {
        self.prepared = None;
    }

    fn project(
        &mut self,
        dynamics: &Dynamics<V>,
        state: &Matter<V>,
        displacement: &mut Columns<V>,
        h: f64,
        executor: &Executor,
    ) -> Result<()> {
        if self.prepared.as_ref().is_none_or(|(known, _)| *known != h) {
            self.prepared = None;
            self.prepared = Some((h, prepare(dynamics, h, executor)?));
        }
        gather(&state.position, &mut self.from);
        gather(displacement, &mut self.predicted);
        gather(&state.velocity, &mut self.displacements);
        self.displacements.iter_mut().flatten().for_each(|component| *component = V::Scalar::from_f64(h) * *component);
        let Some((_, prepared)) = self.prepared.take() else { return Ok(()) };
        self.curvature.clear();
        self.balance(dynamics, &prepared);
        for iteration in 0..self.iterations {
            if executor.stopped() || !self.iterate(dynamics, &prepared, iteration == 0) {
                break;
            }
        }
        self.prepared = Some((h, prepared));
        scatter(&self.displacements, displacement);
        Ok(())
    }

    fn bytes(&self) -> usize {
        let points = [&self.from, &self.predicted, &self.displacements, &self.forces];
        let prepared = self.prepared.as_ref().map_or(0, |(_, prepared)| {
            size_of_val(prepared.links.as_slice()) + prepared.factorization.bytes() + size_of_val(prepared.free.as_slice())
        });
        prepared
            + points.iter().map(|points| size_of_val(points.as_slice())).sum::<usize>()
            + 2 * size_of_val(self.residual.as_slice())
            + self.curvature.bytes()
    }
}

impl<V: Space> Projective<V> {
    /// Sets the residual −M (u − y) + h² F of the free particles.
    fn balance(&mut self, dynamics: &Dynamics<V>, Prepared { links, free, .. }: &Prepared<V::Scalar>) {
        let Self { from, predicted, displacements, forces, residual, .. } = self;
        forces.clear();
        forces.resize(predicted.len(), Point::default());
        dispatch(Pulls { links, from, displacements, forces });
        let inertial =
            |index: usize| dynamics.properties.mass[index] * (vector(&predicted[index]) - vector(&displacements[index]));
        residual.clear();
        residual.extend(free.iter().map(|&index| inertial(index as usize) + vector(&forces[index as usize])));
    }

    /// Takes a step along the corrected direction, halved until the residual has fallen along it; false if there is none. The
    /// first step is whole. If nothing is held, it leaves a residual whose sum is 0, which conserves momentum. Later steps
    /// conserve momentum too, as long as the first is not stored.
    fn iterate(&mut self, dynamics: &Dynamics<V>, prepared: &Prepared<V::Scalar>, first: bool) -> bool {
        let before = self.residual.clone();
        let mut direction = before.clone();
        self.curvature.direct(&mut direction, |vector| prepared.factorization.solve(vector, &mut self.buffer));
        let slope = dot(&before, &direction);
        if slope <= 0.0 || slope.is_nan() {
            return false;
        }
        let start: Vec<Point<V::Scalar>> = prepared.free.iter().map(|&particle| self.displacements[particle as usize]).collect();
        let mut part = 1.0;
        let mut falls = false;
        for _ in 0..MOST_HALVINGS {
            for ((&particle, point), step) in prepared.free.iter().zip(&start).zip(&direction) {
                let step = (part * *step).to_array();
                let moved = &mut self.displacements[particle as usize];
                (0..3).for_each(|axis| moved[axis] = point[axis] + V::Scalar::from_f64(step[axis]));
            }
            self.balance(dynamics, prepared);
            let end = dot(&self.residual, &direction);
            falls = first || (-DESCENT * slope <= end && end < slope);
            if falls {
                break;
            }
            part *= 0.5;
        }
        if !falls {
            // The remainder is rounding, for which no direction is known.
            prepared.free.iter().zip(start).for_each(|(&particle, point)| self.displacements[particle as usize] = point);
            self.balance(dynamics, prepared);
            return false;
        }
        if first {
            return true;
        }
        direction.iter_mut().for_each(|step| *step *= part);
        let change = before.iter().zip(&self.residual).map(|(before, after)| *before - *after).collect();
        self.curvature.remember(direction, change);
        true
    }
}

/// Components of a point.
fn vector<T: Real>(point: &Point<T>) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|axis| point[axis].to_f64()))
}

/// Kernel that adds the forces of all springs, times h².
struct Pulls<'a, T> {
    links: &'a [ProjectionLink<T>],
    from: &'a [Point<T>],
    displacements: &'a [Point<T>],
    forces: &'a mut [Point<T>],
}

impl<T: Real> Kernel for Pulls<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<S: Isa>(self, _isa: S) {
        let Self { links, from, displacements, forces } = self;
        for link in links {
            let (direction, pull) = link.pull(from, displacements);
            let force = direction.map(|along| pull * along);
            let [one, other] = link.ends.map(|end| end as usize);
            let [a, b] = [forces[one], forces[other]];
            forces[one] = std::array::from_fn(|axis| a[axis] + force[axis]);
            forces[other] = std::array::from_fn(|axis| b[axis] - force[axis]);
        }
    }
}
