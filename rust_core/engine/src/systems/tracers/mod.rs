//! Tracers: massless points that move with a velocity field, x' = v(x, t). Point vortices are one such field.
//!
//! Tracers in the flow of vortices of the scene are [coupled](coupling) to these, and advanced in the same stages.

mod attractors;
pub mod coupling;
mod flow;
mod function;
mod law;
mod points;
mod sine;
mod staged;
mod system;
mod vortices;

use crate::error::{Error, Result};
use crate::integrators::FirstOrder;
use crate::integrators::explicit::Coefficients;
use crate::integrators::first_order::NAMES;
use crate::math::Real;
use crate::memory;
use crate::scene::{self, Array, Item, Value};
use crate::systems::System;
use flow::Flow;
use function::VelocityFunction;
use law::Outcome;
use points::Points;
use vortices::{InducedFlow, Vortices};

/// Kind of an item that declares vortices.
const VORTICES: &str = "PointVortices";

/// Index of the scene's system whose flow moves the tracers; None if the flow belongs to no system.
pub fn flow_of(item: &Item) -> Option<usize> {
    match item.values.get("flow") {
        Some(Value::Indices(Array { entries, .. })) => entries.first().map(|&index| index as usize),
        _ => None,
    }
}

/// Compiles tracers or vortices for a method. Tracers may move in the flow of the vortices that another item declares.
///
/// # Errors
/// If a parameter is missing or out of range, the method is not of first order, or memory does not suffice.
pub fn build(item: &Item, vortices: Option<&Item>, method: &Item, precision: &str) -> Result<Box<dyn System>> {
    let Some(Value::Numbers(Array { shape, .. })) = item.values.get(rows_of(item)) else {
        return Err(item.wrong(rows_of(item), "rows of coordinates", item.values.get(rows_of(item))));
    };
    match (precision, shape.last()) {
        ("f32", Some(2)) => Ok(Box::new(Tracers::<f32, 2>::new(item, vortices, method, plane)?)),
        ("f64", Some(2)) => Ok(Box::new(Tracers::<f64, 2>::new(item, vortices, method, plane)?)),
        ("f32", Some(3)) => Ok(Box::new(Tracers::<f32, 3>::new(item, None, method, space)?)),
        ("f64", Some(3)) => Ok(Box::new(Tracers::<f64, 3>::new(item, None, method, space)?)),
        ("f32" | "f64", _) => Err(Error::parameter(&item.path, "points in 2D or 3D", format!("the shape {shape:?}"))),
        (other, _) => Err(Error::parameter("precision", "f32 or f64", other)),
    }
}

/// Builds the flow in the plane that an item declares, or that of vortices.
fn plane<T: Real>(item: &Item, vortices: Option<&Item>, points: &Points<T, 2>) -> Result<Box<dyn Flow<T, 2>>> {
    if let Some(vortices) = vortices {
        return Ok(Box::new(InducedFlow::declared(vortices, points_of(vortices)?)?));
    }
    if item.kind == VORTICES {
        return Ok(Box::new(Vortices::declared(item, points)?));
    }
    match item.record("flow")? {
        flow if flow.kind == "Flow" => Ok(Box::new(VelocityFunction::declared(flow, points.count)?)),
        flow => Err(scene::unknown(flow, "a kind of flow in 2D")),
    }
}

/// Builds the flow in space that an item declares.
fn space<T: Real>(item: &Item, _vortices: Option<&Item>, points: &Points<T, 3>) -> Result<Box<dyn Flow<T, 3>>> {
    match item.record("flow")? {
        flow if flow.kind == "Flow" => Ok(Box::new(VelocityFunction::declared(flow, points.count)?)),
        flow => attractors::declared(flow),
    }
}

/// Name of the value that contains the positions of points.
fn rows_of(item: &Item) -> &'static str {
    if item.kind == VORTICES { "centers" } else { "positions" }
}

/// Function that builds the flow of an item with its points, from the item of vortices if there is one.
type FlowBuilder<T, const D: usize> = fn(&Item, Option<&Item>, &Points<T, D>) -> Result<Box<dyn Flow<T, D>>>;

/// Points in a flow.
struct Tracers<T, const D: usize> {
    flow: Box<dyn Flow<T, D>>,
    /// Word for one of the points.
    element: &'static str,
    /// Positions [m].
    points: Points<T, D>,
    /// Positions at the start of the last batch.
    saved: Points<T, D>,
    method: FirstOrder,
    coefficients: Coefficients,
    /// Change of the Hamiltonian by changes of the state between steps [m⁴/s²].
    supplied: f64,
    /// Outcome of the last batch.
    outcome: Outcome,
    /// 0 after each recorded step of the last batch, or NaN.
    activity: Vec<f64>,
    /// Present time, and time at the start of the last batch [s].
    time: f64,
    saved_time: f64,
}

impl<T: Real, const D: usize> Tracers<T, D> {
    fn new(item: &Item, vortices: Option<&Item>, method: &Item, declared: FlowBuilder<T, D>) -> Result<Self> {
        let refused = || Error::parameter("integrator", NAMES.join(" or "), &method.kind);
        let coefficients = Coefficients::named(&method.kind).ok_or_else(refused)?;
        let method = FirstOrder::named(&method.kind).ok_or_else(refused)?;
        let points = points_of(item)?;
        Ok(Self {
            flow: declared(item, vortices, &points)?,
            element: if item.kind == VORTICES { "vortex" } else { "tracer" },
            saved: points.clone(),
            points,
            method,
            coefficients,
            supplied: 0.0,
            outcome: Outcome::default(),
            activity: Vec::new(),
            time: 0.0,
            saved_time: 0.0,
        })
    }
}

/// Points that an item declares.
fn points_of<T: Real, const D: usize>(item: &Item) -> Result<Points<T, D>> {
    let name = rows_of(item);
    let rows = match item.values.get(name) {
        Some(Value::Numbers(Array { shape, entries })) if shape.len() == 2 && shape[1] == D => entries,
        other => return Err(item.wrong(name, &format!("rows of {D} coordinates"), other)),
    };
    memory::check("the tracers", 3 * size_of_val(rows.as_slice()), 0, || "fewer tracers, or precision=\"f32\"".to_owned())?;
    if let Some(index) = rows.iter().position(|&value| !T::from_f64(value).is_finite()) {
        let path = format!("{name}[{}, {}]", index / D, index % D);
        return Err(item.wrong(&path, &format!("a number that {} holds", T::NAME), Some(&Value::Number(rows[index]))));
    }
    Ok(Points::from_rows(rows))
}
