//! Kinetics: reaction rates in a cell.

use std::sync::Arc;

use super::cell_kinetics::{CellKinetics, PARAMETERS};
use crate::error::{Error, Result};
use crate::grid::Grid;
use crate::math::Real;
use crate::scene::{self, Argument, Callback, Item, Value};

/// Reaction kinetics of two species in one cell.
pub trait RateLaw<T>: Copy + Send + Sync {
    /// Returns the kinetics with these parameters.
    fn new(parameters: [T; PARAMETERS]) -> Self;

    /// Reaction rates R(u, v).
    fn rates(self, values: [T; 2]) -> [T; 2];

    /// Derivatives of the rates, `∂R_u/∂u`, `∂R_u/∂v`, `∂R_v/∂u` and `∂R_v/∂v`.
    fn derivatives(self, values: [T; 2]) -> [T; 4];
}

/// Gray–Scott kinetics: `R_u` = −u v² + F (1 − u), `R_v` = u v² − (F + k) v.
#[derive(Debug, Clone, Copy)]
pub struct GrayScott<T> {
    feed: T,
    loss: T,
}

impl<T: Real> RateLaw<T> for GrayScott<T> {
    #[inline(always)]
    fn new([feed, loss, ..]: [T; PARAMETERS]) -> Self {
        Self { feed, loss }
    }

    #[inline(always)]
    fn rates(self, [u, v]: [T; 2]) -> [T; 2] {
        let converted = u * (v * v);
        [self.feed * (T::ONE - u) - converted, converted - self.loss * v]
    }

    #[inline(always)]
    fn derivatives(self, [u, v]: [T; 2]) -> [T; 4] {
        let (by_u, by_v) = (v * v, (u + u) * v);
        [-by_u - self.feed, -by_v, by_u, by_v - self.loss]
    }
}

/// `FitzHugh`–Nagumo kinetics: `R_u` = u − u³/3 − v + I, `R_v` = ε (u + β − γ v).
#[derive(Debug, Clone, Copy)]
pub struct FitzHughNagumo<T> {
    epsilon: T,
    beta: T,
    gamma: T,
    current: T,
}

impl<T: Real> RateLaw<T> for FitzHughNagumo<T> {
    #[inline(always)]
    fn new([epsilon, beta, gamma, current]: [T; PARAMETERS]) -> Self {
        Self { epsilon, beta, gamma, current }
    }

    #[inline(always)]
    fn rates(self, [u, v]: [T; 2]) -> [T; 2] {
        let cubic = u * (T::ONE - T::from_f64(1.0 / 3.0) * (u * u));
        [cubic - v + self.current, self.epsilon * (u + self.beta - self.gamma * v)]
    }

    #[inline(always)]
    fn derivatives(self, [u, _]: [T; 2]) -> [T; 4] {
        [T::ONE - u * u, -T::ONE, self.epsilon, -(self.epsilon * self.gamma)]
    }
}

/// Prigogine–Lefever kinetics (Brusselator): `R_u` = a − (b + 1) u + u² v, `R_v` = b u − u² v.
#[derive(Debug, Clone, Copy)]
pub struct Brusselator<T> {
    a: T,
    b: T,
}

impl<T: Real> RateLaw<T> for Brusselator<T> {
    #[inline(always)]
    fn new([a, b, ..]: [T; PARAMETERS]) -> Self {
        Self { a, b }
    }

    #[inline(always)]
    fn rates(self, [u, v]: [T; 2]) -> [T; 2] {
        let (formed, turned) = (u * u * v, self.b * u);
        [self.a - u + (formed - turned), turned - formed]
    }

    #[inline(always)]
    fn derivatives(self, [u, v]: [T; 2]) -> [T; 4] {
        let (by_u, by_v) = ((u + u) * v, u * u);
        [by_u - self.b - T::ONE, by_v, self.b - by_u, -by_v]
    }
}

/// Schnakenberg kinetics: `R_u` = a − u + u² v, `R_v` = b − u² v.
#[derive(Debug, Clone, Copy)]
pub struct Schnakenberg<T> {
    a: T,
    b: T,
}

impl<T: Real> RateLaw<T> for Schnakenberg<T> {
    #[inline(always)]
    fn new([a, b, ..]: [T; PARAMETERS]) -> Self {
        Self { a, b }
    }

    #[inline(always)]
    fn rates(self, [u, v]: [T; 2]) -> [T; 2] {
        let formed = u * u * v;
        [self.a - u + formed, self.b - formed]
    }

    #[inline(always)]
    fn derivatives(self, [u, v]: [T; 2]) -> [T; 4] {
        let (by_u, by_v) = ((u + u) * v, u * u);
        [by_u - T::ONE, by_v, -by_u, -by_v]
    }
}

/// User-defined function, with its path.
#[derive(Clone)]
pub struct ReactionFunction {
    function: Arc<dyn Callback>,
    path: String,
}

impl ReactionFunction {
    /// Evaluates the rates of all species from their values in all cells. Both are stored one field after the other.
    ///
    /// # Errors
    /// If the function fails, or returns a number that is not finite although the values are.
    pub fn rates(&self, values: &[f64], shape: &[usize]) -> Result<Vec<f64>> {
        let count = shape.iter().product::<usize>();
        let arguments: Vec<_> = values.chunks_exact(count).map(|numbers| Argument::Array { numbers, shape }).collect();
        let all: Vec<usize> = [arguments.len()].into_iter().chain(shape.iter().copied()).collect();
        let rates = self.function.call(&arguments, "the rates of all species", &all);
        let rates = rates.map_err(|failure| failure.at(self.path.clone()))?;
        match rates.iter().position(|rate| !rate.is_finite()) {
            Some(index) if values.iter().all(|value| value.is_finite()) => {
                let cell = index % count;
                let found = format!("{} for the species number {} in the cell number {cell}", rates[index], index / count);
                Err(Error::undefined(self.path.clone(), "rates that are finite", found))
            }
            _ => Ok(rates),
        }
    }
}

/// Registry of kinetics.
#[derive(Clone)]
pub enum Kinetics<T> {
    GrayScott(CellKinetics<T, GrayScott<T>>),
    FitzHughNagumo(CellKinetics<T, FitzHughNagumo<T>>),
    Brusselator(CellKinetics<T, Brusselator<T>>),
    Schnakenberg(CellKinetics<T, Schnakenberg<T>>),
    /// User-defined function of any number of species.
    Function(ReactionFunction),
}

/// Evaluates `$body` with built-in kinetics as `$law`, or `$otherwise` with the user-defined function.
macro_rules! with_law {
    ($kinetics:expr, $law:ident => $body:expr, $function:ident => $otherwise:expr) => {
        match $kinetics {
            $crate::reaction_diffusion::kinetics::Kinetics::GrayScott($law) => $body,
            $crate::reaction_diffusion::kinetics::Kinetics::FitzHughNagumo($law) => $body,
            $crate::reaction_diffusion::kinetics::Kinetics::Brusselator($law) => $body,
            $crate::reaction_diffusion::kinetics::Kinetics::Schnakenberg($law) => $body,
            $crate::reaction_diffusion::kinetics::Kinetics::Function($function) => $otherwise,
        }
    };
}
pub(super) use with_law;

impl<T: Real> Kinetics<T> {
    /// Reads the kinetics that an item declares, and the names of its species.
    ///
    /// # Errors
    /// If a value is missing or out of range.
    pub fn declared(item: &Item, grid: &Grid) -> Result<(Self, Vec<String>)> {
        let any: fn([f64; PARAMETERS]) -> [f64; PARAMETERS] = |given| given;
        let kinetics = match item.kind.as_str() {
            "GrayScott" => {
                let loss = |[feed, kill, ..]: [f64; PARAMETERS]| [feed, feed + kill, 0.0, 0.0];
                Self::GrayScott(CellKinetics::declared(item, grid, &["feed", "kill"], Grid::non_negative_field, loss)?)
            }
            "FitzHughNagumo" => {
                let names = ["epsilon", "beta", "gamma", "current"];
                Self::FitzHughNagumo(CellKinetics::declared(item, grid, &names, Grid::field, any)?)
            }
            "Brusselator" => Self::Brusselator(CellKinetics::declared(item, grid, &["a", "b"], Grid::field, any)?),
            "Schnakenberg" => Self::Schnakenberg(CellKinetics::declared(item, grid, &["a", "b"], Grid::field, any)?),
            "Reaction" => {
                let species = match item.values.get("species") {
                    Some(Value::Texts(names)) if !names.is_empty() => names.clone(),
                    other => return Err(item.wrong("species", "names", other)),
                };
                let function = ReactionFunction { function: item.callback("function")?, path: format!("{}.function", item.path) };
                return Ok((Self::Function(function), species));
            }
            _ => return Err(scene::unknown(item, "a kind of reaction")),
        };
        Ok((kinetics, vec!["u".to_owned(), "v".to_owned()]))
    }

    /// Whether parameters vary from cell to cell.
    pub fn varies(&self) -> bool {
        with_law!(self, kinetics => kinetics.uniform.is_none(), _function => false)
    }

    /// Memory of the parameters [bytes].
    pub fn bytes(&self) -> usize {
        with_law!(self, kinetics => kinetics.bytes(), _function => 0)
    }

    /// Whether the kinetics is a user-defined function.
    pub fn calls_back(&self) -> bool {
        matches!(self, Self::Function(_))
    }
}
