//! Force law of a damped spring, defined here alone.

use std::ops::Range;

use super::Spring;
use crate::StateView;
use crate::math::{AXES, Real, Vector};

/// Parameters of a spring law, in the precision of the run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpringLaw<T> {
    /// Stiffness k [N/m].
    pub stiffness: T,
    /// Damping c along the spring [N·s/m].
    pub damping: T,
    /// Rest length L [m].
    pub rest_length: T,
}

impl<T: Real> SpringLaw<T> {
    /// Law of a spring without force.
    pub const NONE: Self = Self { stiffness: T::ZERO, damping: T::ZERO, rest_length: T::ZERO };

    /// Law of a spring of the scene.
    #[inline]
    pub fn of(spring: &Spring) -> Self {
        Self {
            stiffness: T::from_f64(spring.stiffness),
            damping: T::from_f64(spring.damping),
            rest_length: T::from_f64(spring.rest_length),
        }
    }

    /// Sort key, equal only for equal laws.
    #[inline]
    pub fn key(&self) -> [u64; 3] {
        [self.stiffness, self.damping, self.rest_length].map(|number| number.to_f64().to_bits())
    }

    /// Force on end i, opposite to that on end j. Without `DAMPED`, c counts as 0. With d = xⱼ − xᵢ, r = |d|, u = d/r:
    ///
    /// Fᵢ = [k (r − L) + c (vⱼ − vᵢ)·u] u = [k (r − L)/r + c ((vⱼ − vᵢ)·u)/r] d, P = c ((vⱼ − vᵢ)·u)²
    ///
    /// Exchange of i and j changes no bit. At rest length the force is exactly 0. For L = 0, (r − L)/r is 1 even at r = 0, so
    /// that such a spring is exactly linear. For L > 0, coincident ends have no direction, and the force is 0. Ends count as
    /// coincident if d·d underflows.
    #[inline(always)]
    pub fn force<V: Vector<Scalar = T>, const DAMPED: bool>(&self, i: EndState<T>, j: EndState<T>) -> Pull<T> {
        let SeparationFactors { tension, drag, power } = self.factors::<V, DAMPED>(i, j);
        let mut pull = Pull { force: [T::ZERO; AXES], damping: [T::ZERO; AXES], power };
        for axis in 0..V::DIMENSION {
            let along = j.position[axis] - i.position[axis];
            pull.force[axis] = tension * along;
            if DAMPED {
                pull.damping[axis] = drag * along;
            }
        }
        pull
    }

    /// Factors of d in the force, and the power.
    #[inline(always)]
    pub fn factors<V: Vector<Scalar = T>, const DAMPED: bool>(&self, i: EndState<T>, j: EndState<T>) -> SeparationFactors<T> {
        let (mut square, mut approach) = (T::ZERO, T::ZERO);
        for axis in 0..V::DIMENSION {
            let along = j.position[axis] - i.position[axis];
            square += along * along;
            if DAMPED {
                approach += (j.velocity[axis] - i.velocity[axis]) * along;
            }
        }
        let length = square.sqrt();
        let inverse = T::ONE / length;
        let inverse = if length > T::ZERO { inverse } else { T::ZERO };
        let strain = if self.rest_length == T::ZERO { T::ONE } else { (length - self.rest_length) * inverse };
        if !DAMPED {
            return SeparationFactors { tension: self.stiffness * strain, drag: T::ZERO, power: T::ZERO };
        }
        let rate = approach * inverse;
        let drag = self.damping * rate;
        SeparationFactors { tension: self.stiffness * strain + drag * inverse, drag: drag * inverse, power: drag * rate }
    }
}

/// Factors of the separation d = xⱼ − xᵢ in the force on end i.
#[derive(Debug, Clone, Copy)]
pub struct SeparationFactors<T> {
    /// Factor of the total force [N/m].
    pub tension: T,
    /// Factor of the damping force [N/m]; 0 without damping.
    pub drag: T,
    /// Dissipated power [W].
    pub power: T,
}

/// Force of a spring on one of its ends.
#[derive(Debug, Clone, Copy)]
pub struct Pull<T> {
    /// Total force [N].
    pub force: [T; AXES],
    /// Damping force [N]; 0 without damping.
    pub damping: [T; AXES],
    /// Dissipated power [W].
    pub power: T,
}

/// Position and velocity of one end.
#[derive(Debug, Clone, Copy)]
pub struct EndState<T> {
    /// Position [m].
    pub position: [T; AXES],
    /// Velocity [m/s]; unused without damping.
    pub velocity: [T; AXES],
}

impl<T: Real> EndState<T> {
    /// Squared distance to another end [m²].
    #[inline(always)]
    pub fn square_to<V: Vector<Scalar = T>>(self, other: Self) -> f64 {
        let mut square = 0.0;
        for axis in 0..V::DIMENSION {
            let along = other.position[axis].to_f64() - self.position[axis].to_f64();
            square += along * along;
        }
        square
    }
}

/// Positions and velocities of a range of particles.
#[derive(Debug, Clone, Copy)]
pub struct SpringRun<'a, T> {
    position: [&'a [T]; AXES],
    velocity: [&'a [T]; AXES],
}

impl<'a, T: Real> SpringRun<'a, T> {
    /// Columns of a range of particles.
    #[inline(always)]
    pub fn new<V: Vector<Scalar = T>>(at: &StateView<'a, V>, range: &Range<usize>) -> Self {
        Self {
            position: std::array::from_fn(|axis| at.position.slice(axis, range.clone())),
            velocity: std::array::from_fn(|axis| at.velocity.slice(axis, range.clone())),
        }
    }

    /// State of one particle.
    #[inline(always)]
    pub fn get<V: Vector<Scalar = T>, const DAMPED: bool>(&self, index: usize) -> EndState<T> {
        let mut state = EndState { position: [T::ZERO; AXES], velocity: [T::ZERO; AXES] };
        for axis in 0..V::DIMENSION {
            state.position[axis] = self.position[axis][index];
            if DAMPED {
                state.velocity[axis] = self.velocity[axis][index];
            }
        }
        state
    }
}
