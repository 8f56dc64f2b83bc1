//! What there is to simulate: plain numbers in double precision, in the caller's order, and nothing about how.

use std::collections::BTreeMap;
use std::fmt::{Debug, Formatter};
use std::sync::Arc;

use glam::DVec3;

use crate::error::{Cause, Error, Result};

/// Everything that a scene holds.
#[derive(Debug, Clone, Default)]
pub struct Scene {
    /// 2 or 3. In 2D the third component of every vector is 0.
    pub dimension: usize,
    /// The bodies, in the order in which results concatenate them.
    pub bodies: Vec<Body>,
    /// The forces beside springs.
    pub forces: Vec<Term>,
    /// The boundaries.
    pub boundaries: Vec<Term>,
    /// The periodic domain: its lower and its upper corner [m], infinite along an axis that is not periodic.
    pub periodic: Option<[DVec3; 2]>,
}

/// Particles, and the springs between them.
#[derive(Debug, Clone, Default)]
pub struct Body {
    /// Positions [m].
    pub positions: Vec<DVec3>,
    /// Velocities [m/s].
    pub velocities: Vec<DVec3>,
    /// Masses [kg].
    pub mass: Vec<f64>,
    /// Charges [C].
    pub charge: Vec<f64>,
    /// Radii [m].
    pub radius: Vec<f64>,
    /// Which particles keep their velocity whatever acts on them.
    pub fixed: Vec<bool>,
    /// The springs between them.
    pub springs: Vec<Spring>,
    /// What makes them a fluid, if they are one.
    pub fluid: Option<Fluid>,
}

/// A weakly compressible fluid, whose particles are lumps of matter.
#[derive(Debug, Clone, PartialEq)]
pub struct Fluid {
    /// The distance between neighboring particles at rest Δ [m].
    pub spacing: f64,
    /// The density at rest ρ₀ [kg/m³].
    pub density: f64,
    /// The dynamic viscosity μ [Pa·s].
    pub viscosity: f64,
    /// The speed of sound c [m/s]; None where it is to be found from the scene.
    pub sound_speed: Option<f64>,
    /// The coefficient α of the artificial viscosity.
    pub artificial_viscosity: f64,
    /// The coefficient δ of the diffusion of density.
    pub density_diffusion: f64,
    /// The surface tension σ [N/m].
    pub surface_tension: f64,
    /// The coefficient A by which particles are shifted to where there is room; 0 where they are not.
    pub shifting: f64,
    /// Whether density is counted from where the particles are, instead of carried along with them.
    pub summation: bool,
    /// The name of the smoothing kernel's class in Python.
    pub kernel: String,
    /// The smoothing length h over the spacing; the kernel reaches as far as 2h.
    pub smoothing: f64,
    /// Whether it meets the bodies that are no fluids as obstacles.
    pub obstacles: bool,
}

/// A damped spring between two particles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spring {
    /// The particles at its ends, as indices within the body.
    pub ends: [u32; 2],
    /// Stiffness k [N/m].
    pub stiffness: f64,
    /// Damping c along the spring [N·s/m].
    pub damping: f64,
    /// Rest length L [m].
    pub rest_length: f64,
}

impl Scene {
    /// The number of particles.
    pub fn count(&self) -> usize {
        self.bodies.iter().map(|body| body.positions.len()).sum()
    }

    /// The positions of all particles, body by body [m].
    pub fn positions(&self) -> Vec<DVec3> {
        self.bodies.iter().flat_map(|body| &body.positions).copied().collect()
    }

    /// The springs of all bodies, with indices into the whole scene.
    pub fn springs(&self) -> Vec<Spring> {
        let mut first = 0;
        let mut springs = Vec::with_capacity(self.bodies.iter().map(|body| body.springs.len()).sum());
        for body in &self.bodies {
            springs.extend(body.springs.iter().map(|spring| Spring { ends: spring.ends.map(|end| end + first), ..*spring }));
            first += body.positions.len() as u32;
        }
        springs
    }

    /// Whether a term acts on each particle.
    pub fn members(&self, term: &Term) -> Vec<bool> {
        let bodies = self.bodies.iter().enumerate();
        bodies.flat_map(|(index, body)| std::iter::repeat_n(term.acts_on(index), body.positions.len())).collect()
    }
}

/// A function of the user's: a force on every particle, and perhaps its potential energy.
pub trait Callback: Send + Sync {
    /// The forces [N] on the particles at these positions [m] and velocities [m/s], at this time [s]: as many as there are
    /// particles, and not necessarily finite.
    fn forces(&self, time: f64, positions: &[DVec3], velocities: &[DVec3]) -> std::result::Result<Vec<DVec3>, Failure>;
    /// Whether there is a potential.
    fn has_potential(&self) -> bool;
    /// The potential energy [J] at these positions, not necessarily finite.
    fn potential(&self, positions: &[DVec3]) -> std::result::Result<f64, Failure>;
}

/// How a function of the user's failed.
#[derive(Debug)]
pub enum Failure {
    /// It raised an error.
    Raised(Cause),
    /// It gave something else than was expected.
    Refused {
        /// What was expected.
        expected: String,
        /// What it gave.
        found: String,
    },
}

impl Failure {
    /// The error of the function at `path`.
    pub fn at(self, path: String) -> Error {
        match self {
            Self::Raised(cause) => Error::Callback { path, cause },
            Self::Refused { expected, found } => Error::parameter(path, expected, found),
        }
    }
}

/// A force or a boundary, as the user declared it.
#[derive(Debug, Clone, Default)]
pub struct Term {
    /// Where it stands in the scene, as in `forces[2]`.
    pub path: String,
    /// The name of its class in Python.
    pub kind: String,
    /// The bodies that it acts on; all of them if this is None.
    pub on: Option<Vec<usize>>,
    /// Its parameters by name.
    pub values: BTreeMap<String, Value>,
}

/// A parameter.
#[derive(Clone)]
pub enum Value {
    /// A number.
    Number(f64),
    /// A vector; in 2D its third component is 0.
    Vector(DVec3),
    /// Yes or no.
    Flag(bool),
    /// A function of the user's.
    Callback(Arc<dyn Callback>),
}

impl Debug for Value {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Number(number) => write!(formatter, "{number}"),
            Self::Vector(vector) => write!(formatter, "{vector}"),
            Self::Flag(flag) => write!(formatter, "{flag}"),
            Self::Callback(_) => write!(formatter, "a function"),
        }
    }
}

impl Term {
    /// Whether it acts on a body.
    pub fn acts_on(&self, body: usize) -> bool {
        self.on.as_ref().is_none_or(|bodies| bodies.contains(&body))
    }

    /// A number that must be there and finite.
    pub fn number(&self, name: &str) -> Result<f64> {
        match self.values.get(name) {
            Some(Value::Number(number)) if number.is_finite() => Ok(*number),
            other => Err(self.wrong(name, "a finite number", other)),
        }
    }

    /// A number that must be there, finite and at least 0.
    pub fn non_negative(&self, name: &str) -> Result<f64> {
        match self.number(name)? {
            number if number >= 0.0 => Ok(number),
            number => Err(self.wrong(name, "a number ≥ 0", Some(&Value::Number(number)))),
        }
    }

    /// A vector that must be there and finite.
    pub fn vector(&self, name: &str) -> Result<DVec3> {
        match self.values.get(name) {
            Some(Value::Vector(vector)) if vector.is_finite() => Ok(*vector),
            other => Err(self.wrong(name, "a finite vector", other)),
        }
    }

    /// A vector that may be left out.
    pub fn optional_vector(&self, name: &str) -> Result<Option<DVec3>> {
        if self.values.contains_key(name) { self.vector(name).map(Some) } else { Ok(None) }
    }

    /// Yes or no.
    pub fn flag(&self, name: &str) -> Result<bool> {
        match self.values.get(name) {
            Some(Value::Flag(flag)) => Ok(*flag),
            other => Err(self.wrong(name, "true or false", other)),
        }
    }

    /// A function of the user's.
    pub fn callback(&self, name: &str) -> Result<Arc<dyn Callback>> {
        match self.values.get(name) {
            Some(Value::Callback(callback)) => Ok(Arc::clone(callback)),
            other => Err(self.wrong(name, "a function", other)),
        }
    }

    /// The error that a parameter is not what it should be.
    pub fn wrong(&self, name: &str, expected: &str, found: Option<&Value>) -> Error {
        let found = found.map_or_else(|| "nothing".to_owned(), |value| format!("{value:?}"));
        Error::parameter(format!("{}.{name}", self.path), expected, found)
    }
}
