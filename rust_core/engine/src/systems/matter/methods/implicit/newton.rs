//! Newton's method with line search; preconditioned conjugate gradients solve its linear equations.
//!
//! Let the residual be R(u) = σ M (u − y) − h² F. For forces with a potential it is the gradient of a function of u. A search
//! along p ends where the derivative R·p has fallen to a half at most; it needs no potential. All sums are in one fixed
//! order. Source: J. Nocedal, S. J. Wright, "Numerical Optimization", 2nd ed., 2006, chapters 3, 5 and 7.

use glam::DVec3;

use super::stiffness::Stiffness;
use crate::catalog::Space;
use crate::error::{Error, Result};
use crate::forces::derivatives::{Motion, Push};
use crate::forces::springs::Spring;
use crate::parallel::Executor;
use crate::solvers::conjugate_gradient::{ConjugateGradient, DefiniteSystem, dot};
use crate::systems::matter::dynamics::Dynamics;
use crate::systems::matter::methods::projection::colored;

/// Maximum number of iterations of Newton's method, and of trials of a search along a direction.
const MOST_ITERATIONS: u64 = 200;
const MOST_TRIALS: u32 = 16;
/// Residual over the largest force below which all derivatives are used.
const NEAR: f64 = 0.01;
/// Derivative along a direction at the end of a search, over the derivative at its start.
const DESCENT: f64 = 0.5;
/// Rounding errors of the forces on a particle, in units of ε k times the coordinates of its springs.
const ROUNDINGS: f64 = 4.0;

/// Equation of a step: σ M (u − y) = h² F(x + α u, β u/h + w).
#[derive(Debug)]
pub struct Equation {
    /// Step size h [s].
    pub h: f64,
    /// Time of the forces [s].
    pub time: f64,
    /// Coefficients σ, α and β.
    pub inertia: f64,
    pub position: f64,
    pub rate: f64,
    /// Positions x at the start [m].
    pub from: Vec<DVec3>,
    /// Predicted displacements y [m].
    pub predicted: Vec<DVec3>,
    /// Offset w of the velocities [m/s].
    pub offset: Vec<DVec3>,
}

/// Solver with its buffers.
#[derive(Debug, Default)]
pub struct Newton {
    tolerance: f64,
    /// Springs, in an order in which neighbors have no common particles.
    springs: Vec<Spring>,
    /// Masses [kg], infinite where fixed.
    mass: Vec<f64>,
    matrix: Stiffness,
    places: Vec<DVec3>,
    velocities: Vec<DVec3>,
    residual: Vec<DVec3>,
    direction: Vec<DVec3>,
    gradients: ConjugateGradient<DVec3>,
}

/// Linear equations of an iteration. If `definite`, derivatives that may be negative are left out.
struct NewtonSystem<'a> {
    matrix: &'a Stiffness,
    definite: bool,
}

impl DefiniteSystem<DVec3> for NewtonSystem<'_> {
    fn multiply(&self, p: &[DVec3], product: &mut [DVec3]) {
        self.matrix.multiply(p, product, self.definite);
    }

    fn precondition(&self, r: &[DVec3], z: &mut [DVec3]) {
        self.matrix.precondition(r, z);
    }
}

impl Newton {
    /// Creates a solver for a tolerance, the largest residual over the largest force.
    pub fn new(tolerance: f64) -> Self {
        Self { tolerance, ..Self::default() }
    }

    /// Sets the springs of a scene.
    pub fn begin<V: Space>(&mut self, dynamics: &Dynamics<V>) {
        self.springs = colored(&dynamics.springs, dynamics.properties.count());
        self.mass.clone_from(&dynamics.properties.mass);
        let zeros = vec![DVec3::ZERO; self.mass.len()];
        for vector in [&mut self.places, &mut self.velocities, &mut self.residual, &mut self.direction] {
            vector.clone_from(&zeros);
        }
        self.gradients.resize(zeros.len());
    }

    /// Displacements that solve an equation, and the numbers of iterations and products.
    ///
    /// # Errors
    /// If the residual does not become small enough, or particles are too far away.
    pub fn solve<V: Space>(
        &mut self,
        dynamics: &mut Dynamics<V>,
        equation: &Equation,
        executor: &Executor,
    ) -> Result<(Vec<DVec3>, [u64; 2])> {
        let square = equation.h * equation.h;
        let mobile = |index: usize| {
            let [_, rate, well] = dynamics.linear.coefficients(0, index);
            self.mass[index] * (equation.inertia - square * (equation.position * well + equation.rate / equation.h * rate))
        };
        let diagonal = |index: usize| if self.mass[index].is_finite() { mobile(index) } else { 0.0 };
        self.matrix.diagonal = (0..self.mass.len()).map(diagonal).collect();
        // The start is the position: the prediction may have turned stiff springs over to another solution.
        let start = |index: usize| if self.mass[index].is_finite() { DVec3::ZERO } else { equation.predicted[index] };
        let mut u: Vec<DVec3> = (0..self.mass.len()).map(start).collect();
        let mut products = 0;
        let (mut worst, mut first) = (self.evaluate(dynamics, equation, &u, executor)?, None);
        for iteration in 0..MOST_ITERATIONS {
            executor.check()?;
            // The divergence monitor reports states that are not finite.
            if worst.1 <= self.tolerance || worst.1.is_nan() {
                return Ok((u, [iteration, products]));
            }
            let factors = [square * equation.position, square * equation.rate / equation.h];
            self.matrix.assemble(&self.springs, &self.places, &self.velocities, factors);
            let Self { places, velocities, matrix, .. } = self;
            let at = Motion { position: places, velocity: velocities, origin: dynamics.properties.origin, time: equation.time };
            for force in dynamics.derivatives() {
                force.blocks(&at, factors, &mut |block| matrix.add(block));
            }
            matrix.complete();
            // Superlinear convergence: the nearer the solution, the more accurately the linear equations are solved.
            let norm = dot(&self.residual, &self.residual).sqrt();
            let start = *first.get_or_insert(norm);
            let tolerance = (norm / start).sqrt().min(0.1);
            // Near the solution, with all derivatives, convergence is quadratic. Elsewhere compressed springs may make the
            // matrix indefinite; their stiffness across is then left out.
            let exact = (worst.1 < NEAR).then(|| self.descend(tolerance, false, executor));
            let count = exact.flatten().or_else(|| self.descend(tolerance, true, executor));
            products += count.unwrap_or_default();
            let slope = dot(&self.residual, &self.direction);
            worst = self.search(dynamics, equation, &mut u, slope, executor)?;
        }
        let cause = format!(
            "was not found in {MOST_ITERATIONS} iterations of Newton's method: {:.1e} of the forces is left unbalanced",
            worst.1
        );
        Err(Error::unsolved(dynamics.properties.caller[worst.0] as usize, cause))
    }

    /// Moves displacements along the direction, on which the derivative starts at `slope` < 0, until it has fallen to a half.
    /// A direction along which the derivative has hardly changed is followed further, as where springs buckle.
    fn search<V: Space>(
        &mut self,
        dynamics: &mut Dynamics<V>,
        equation: &Equation,
        u: &mut [DVec3],
        slope: f64,
        executor: &Executor,
    ) -> Result<(usize, f64)> {
        let before = u.to_vec();
        let mut bracket = [0.0, f64::INFINITY];
        let mut part = 1.0;
        let mut worst = (0, f64::INFINITY);
        for _ in 0..MOST_TRIALS {
            executor.check()?;
            u.iter_mut().zip(&before).zip(&self.direction).for_each(|((u, &before), &p)| *u = before + part * p);
            worst = self.evaluate(dynamics, equation, u, executor)?;
            let derivative = dot(&self.residual, &self.direction);
            if worst.1 <= self.tolerance || derivative.abs() <= DESCENT * slope.abs() {
                break;
            }
            bracket[usize::from(derivative > 0.0)] = part;
            part = if bracket[1].is_finite() { 0.5 * (bracket[0] + bracket[1]) } else { 2.0 * part };
        }
        Ok(worst)
    }

    /// Computes the residual at displacements. Returns the particle with the largest residual, and that residual over the
    /// largest force.
    fn evaluate<V: Space>(
        &mut self,
        dynamics: &mut Dynamics<V>,
        equation: &Equation,
        u: &[DVec3],
        executor: &Executor,
    ) -> Result<(usize, f64)> {
        let (h, square) = (equation.h, equation.h * equation.h);
        for index in 0..u.len() {
            self.places[index] = equation.from[index] + equation.position * u[index];
            self.velocities[index] = equation.rate / h * u[index] + equation.offset[index];
        }
        let (mut scale, mut rounding) = (0.0_f64, 0.0_f64);
        for index in 0..u.len() {
            let [force, terms] = linear(dynamics, index, self.places[index], self.velocities[index]);
            let mass = if self.mass[index].is_finite() { self.mass[index] } else { 0.0 };
            let inertia = equation.inertia * mass * (u[index] - equation.predicted[index]);
            self.residual[index] = inertia - square * mass * force;
            scale = scale.max(inertia.length()).max(square * mass * force.length());
            // Terms may balance each other, as gravity and drag do: what rounding leaves of them is no residual.
            rounding = rounding.max(equation.inertia * mass * equation.predicted[index].abs().max_element());
            rounding = rounding.max(square * mass * terms.max_element());
        }
        for spring in &self.springs {
            let [one, other] = spring.ends.map(|end| end as usize);
            let (offset, relative) = (self.places[other] - self.places[one], self.velocities[other] - self.velocities[one]);
            let length = offset.length();
            let direction = if length > 0.0 { offset / length } else { DVec3::ZERO };
            let pull = spring.stiffness * (length - spring.rest_length) + spring.damping * direction.dot(relative);
            let force = square * pull * direction;
            self.residual[one] -= force;
            self.residual[other] += force;
            scale = scale.max(force.length());
            let size = self.places[one].abs().max_element() + self.places[other].abs().max_element() + spring.rest_length;
            rounding = rounding.max(square * spring.stiffness * size);
        }
        let Self { places, velocities, residual, .. } = self;
        let at = Motion { position: places, velocity: velocities, origin: dynamics.properties.origin, time: equation.time };
        for force in dynamics.derivatives() {
            force.arrange(&at, executor)?;
            force.forces(&at, &mut |Push { particle, force, stiffness }| {
                residual[particle] -= square * force;
                scale = scale.max(square * force.length());
                rounding = rounding.max(2.0 * square * stiffness * places[particle].abs().max_element());
            });
        }
        let mut worst = (0, 0.0);
        let floor = ROUNDINGS * f64::EPSILON * rounding / self.tolerance;
        for (index, residual) in self.residual.iter_mut().enumerate() {
            if !self.mass[index].is_finite() {
                *residual = DVec3::ZERO;
            }
            let relative = residual.length() / scale.max(floor).max(f64::MIN_POSITIVE);
            if relative > worst.1 || relative.is_nan() {
                worst = (index, relative);
            }
        }
        Ok(worst)
    }

    /// Solves A p = −R for the direction p, to a relative residual. Returns the number of products, or None if A is not
    /// definite.
    fn descend(&mut self, tolerance: f64, definite: bool, executor: &Executor) -> Option<u64> {
        let Self { matrix, residual, direction, gradients, .. } = self;
        let system = NewtonSystem { matrix, definite };
        let downhill = residual.iter().map(|&residual| -residual);
        gradients.solve(&system, downhill, direction, tolerance, executor).map(|solved| solved.products)
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        let vectors = 5 * size_of_val(self.places.as_slice()) + self.gradients.bytes();
        size_of_val(self.springs.as_slice()) + self.matrix.bytes() + vectors + size_of_val(self.mass.as_slice())
    }
}

/// Acceleration by linear forces, and the sum of the sizes of its terms, along each axis [m/s²].
fn linear<V: Space>(dynamics: &Dynamics<V>, index: usize, place: DVec3, velocity: DVec3) -> [DVec3; 2] {
    let (place, velocity) = (place.to_array(), velocity.to_array());
    let (mut acceleration, mut sizes) = ([0.0; 3], [0.0; 3]);
    for axis in 0..V::DIMENSION {
        let [constant, rate, well] = dynamics.linear.coefficients(axis, index);
        let terms = [constant, rate * velocity[axis], well * place[axis]];
        acceleration[axis] = terms[0] + terms[1] + terms[2];
        sizes[axis] = terms[0].abs() + terms[1].abs() + terms[2].abs();
    }
    [acceleration, sizes].map(DVec3::from_array)
}
